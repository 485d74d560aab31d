"""Plants in the shadows of small waves, and in the wave optics that judges them."""

from __future__ import annotations

from .plant import Plant

_UNRESOLVED = "tests/tracing/test_unresolved_waves.py::"
_WAVES = "tests/tracing/test_wave_optics.py::"

PLANTS = (
    Plant(
        "small shadows: Fresnel's number",
        "seamap_rt/physics/shadowing.py",
        "fresnel(np.sqrt(2.0 * height_m",
        "fresnel(np.sqrt(1.0 * height_m",
        _UNRESOLVED + "test_what_bends_into_small_shadows_goes_from_all_to_none_with_their_fresnel_number",
    ),
    Plant(
        "small shadows: HH as VV",
        "seamap_rt/physics/shadowing.py",
        'one_way**2 if polarization == "VV" else one_way**4',
        "one_way**2",
        _UNRESOLVED + "test_a_radar_s_shadows_lie_between_none_and_light_s",
    ),
    Plant(
        "small shadows: what is kept on a back",
        "seamap_rt/tracing/unresolved_waves.py",
        "return shares + kept * (1.0 - shares)",
        "return shares + kept * (shares[1] - shares)",
        _UNRESOLVED + "test_of_hidden_water_the_share_kept_answers",
    ),
    Plant(
        "small shadows: what is left out of them",
        "seamap_rt/report/limits/leaving_out.py",
        "yield row(name, hidden * (1.0 - kept), error, BENT, says)",
        "yield row(name, hidden, error, BENT, says)",
        "tests/report/test_limits.py::test_unresolved_waves_hide_by_half_of_their_tilts_along_the_look",
    ),
    Plant(
        "wave optics: beyond the point",
        "validation/light/wave_optics.py",
        "+ 2.0 / np.pi\n",
        "\n",
        _WAVES + "test_level_water_is_lit_by_fresnel_s_coefficients",
    ),
    Plant(
        "wave optics: the normal of HH",
        "validation/light/wave_optics.py",
        "at_i = (dz - slant * dx) * over * arc[j]",
        "at_i = (dz - slope[j] * dx) * over * arc[j]",
        _WAVES + "test_a_wedge_s_shadow_holds_what_its_exact_field_does",
    ),
    Plant(
        "wave optics: near waves",
        "validation/light/wave_optics.py",
        "of_c += at_j * h1 *",
        "of_c += 0.5 * at_j * h1 *",
        _WAVES + "test_a_march_is_the_whole_equation_but_for_what_is_scattered_back",
    ),
    Plant(
        "a wedge's even field",
        "validation/analytic/diffraction.py",
        "np.where(order == 0.0, 1.0, 2.0)",
        "np.where(order == 0.0, 2.0, 2.0)",
        _WAVES + "test_a_wedge_seen_along_its_face_casts_a_knife_edge_s_shadow",
    ),
    Plant(
        "slope of hidden waves on both axes",
        "seamap_rt/tracing/unresolved_waves.py",
        "np.sqrt(0.5 * sum(variances))",
        "np.sqrt(sum(variances))",
        "tests/tracing/test_unresolved_waves.py::test_a_scene_s_hidden_water_keeps_what_its_own_small_waves_leave",
    ),
)
