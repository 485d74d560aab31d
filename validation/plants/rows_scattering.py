"""Plants in the scattering."""

from __future__ import annotations

from .plant import Plant

_SCATTERING = "seamap_rt/scattering/"

PLANTS = (
    Plant(
        "Bragg VV",
        _SCATTERING + "bragg.py",
        "(eps * (1.0 + sine2) - sine2)",
        "(eps * (1.0 + sine2) + sine2)",
        "tests/scattering/test_bragg.py::test_coefficients_meet_the_check_values",
    ),
    Plant(
        "Bragg HH",
        _SCATTERING + "bragg.py",
        "g_hh = (eps - 1.0) / (cosine + below) ** 2",
        "g_hh = (eps - 1.0) / (cosine + eps * below) ** 2",
        "tests/scattering/test_bragg.py::test_coefficients_meet_the_check_values",
    ),
    Plant(
        "Bragg cosine",
        _SCATTERING + "bragg.py",
        "k**4 * cosine**4 *",
        "k**4 * cosine**2 *",
        "tests/scattering/test_bragg.py::test_first_order_formula_by_hand",
    ),
    Plant(
        "tilted Bragg contrast",
        _SCATTERING + "tilted_bragg.py",
        "weight = 8.0 * k**4",
        "weight = 16.0 * k**4",
        "tests/scattering/test_tilted_bragg.py::test_the_table_is_the_sum_over_tilts",
    ),
    Plant(
        "short waves' tilt",
        "seamap_rt/report/limits/case.py",
        "math.sqrt(0.5 * sum(short.tilt_variances",
        "math.sqrt(1.0 * sum(short.tilt_variances",
        "tests/report/test_limits.py::test_unresolved_waves_hide_by_half_of_their_tilts_along_the_look",
    ),
    Plant(
        "breakers' share",
        _SCATTERING + "breaking.py",
        "min(0.5 * COVERAGE",
        "min(COVERAGE",
        "tests/scattering/test_breaking.py::test_the_fraction_is_the_integral_of_the_fronts",
    ),
    Plant(
        "compiled terms: the wind's axis turns the wrong way on a leaning facet",
        _SCATTERING + "composite_kernel.py",
        "axis_cosine * turned_cosine + axis_sine * turned_sine",
        "axis_cosine * turned_cosine - axis_sine * turned_sine",
        "tests/echoes/test_radar_cross_section.py::test_compiled_terms_are_the_formulas_in_every_attitude",
    ),
    Plant(
        "compiled terms: breakers that crowd as Bragg waves do",
        _SCATTERING + "composite_kernel.py",
        "often = sea.breaking_level * (cube * cube)",
        "often = sea.breaking_level * cube",
        "tests/echoes/test_radar_cross_section.py::test_compiled_terms_are_the_formulas_in_every_attitude",
    ),
    Plant(
        "breakers' lean",
        _SCATTERING + "breaking.py",
        "(cos_local + lean",
        "(cos_local - lean",
        "tests/scattering/test_breaking.py::test_the_front_returns_more_than_the_back_as_the_paper_expands_it",
    ),
    Plant(
        "modulation by strain",
        _SCATTERING + "modulation.py",
        "ACTION_POWER = 4.5",
        "ACTION_POWER = 4.0",
        "tests/scattering/test_modulation.py::"
        "test_small_strain_gathers_action_as_alpers_and_hasselmann_and_large_strain_is_bounded",
    ),
    Plant(
        "permittivity Meissner–Wentz",
        _SCATTERING + "permittivity.py",
        "3.70886e4 - 82.168 * t",
        "3.70886e4 - 81.168 * t",
        "tests/scattering/test_permittivity.py::test_sea_water_at_10_ghz_meets_the_check_value",
    ),
    Plant(
        "permittivity Klein–Swift",
        _SCATTERING + "permittivity.py",
        "static = 87.134 ",
        "static = 88.134 ",
        "tests/scattering/test_permittivity.py::test_sea_water_at_10_ghz_meets_the_check_value",
    ),
    Plant(
        "Fresnel",
        _SCATTERING + "permittivity.py",
        "(eps * cosine - below) /",
        "(cosine - eps * below) /",
        "tests/scattering/test_permittivity.py::test_pseudo_brewster_angle",
    ),
    Plant("mean level HH", _SCATTERING + "gregers_hansen12.py", "20.781", "20.871", "case nrl_sea_clutter"),
    Plant(
        "clutter's shape",
        _SCATTERING + "watts_wicks90.py",
        "area_m2**0.625",
        "area_m2**0.5",
        "tests/scattering/test_watts_wicks90.py::test_clutter_is_spikier_in_hh_and_in_small_cells",
    ),
)
