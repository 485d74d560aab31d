"""The mesh's spacings: the closed form behind them, what they must follow, and their errors measured on one sea."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from seamap_rt.echoes import expected_look_gates
from seamap_rt.mesh.grid import circle_grid
from seamap_rt.mesh.sizing import MOST_TRIANGLES, POWER_ERROR_DB, MeshDetail, chord_error, triangles
from seamap_rt.scene import Scene, load_scene
from seamap_rt.simulation import Simulator
from seamap_rt.truth import polar_truth


def scene(name: str = "choppy_sea", **keys: Any) -> Scene:
    return load_scene(name, {key.replace("__", "."): value for key, value in keys.items()})


def wind_sea(height: float, period: float) -> dict[str, float]:
    return {"sea__waves__0__significant_wave_height_m": height, "sea__waves__0__peak_period_s": period}


# ------------------------------------------------------------------------------------------------- chords


@given(st.floats(0.02, 40.0))
def test_chord_error_is_the_mean_square_of_what_a_chord_misses(kappa: float) -> None:
    """By Gauss–Legendre quadrature over the chord and the trapezoid rule over the phase, which is exact for sines.

    The tolerance is what κ⁴/120 leaves off, (11/252) κ² of itself: 4.4e-4 at 0.1, where the exact form takes over.
    """
    nodes, weights = np.polynomial.legendre.leggauss(64)
    u, phase = 0.5 * (1.0 + nodes), 2.0 * np.pi * np.arange(8)[:, None] / 8
    missed = np.cos(phase + kappa * u) - (1.0 - u) * np.cos(phase) - u * np.cos(phase + kappa)
    expected = np.mean(missed**2 @ (0.5 * weights)) / 0.5
    assert_allclose(chord_error(kappa), expected, rtol=4.5e-4, atol=0.0)


def test_chords_miss_nothing_of_a_level_and_all_of_what_is_far_too_short() -> None:
    """Corners that know nothing of what lies between: 1 of the wave and ⅔ of the chord's own, at κ = 2πn + π/2."""
    assert_allclose(chord_error(0.0), 0.0, atol=0.0)
    assert_allclose(chord_error(-0.3), chord_error(0.3), rtol=0.0)
    assert_allclose(chord_error(2e4 * np.pi + 0.5 * np.pi), 5.0 / 3.0, rtol=1e-8)


# ----------------------------------------------------------------------------------------- what is chosen


def test_defaults_meet_their_targets_with_fewer_facets_than_a_plain_mesh() -> None:
    detail = scene().detail
    assert detail.height_error_m <= 0.02
    assert detail.power_error_db <= POWER_ERROR_DB
    assert detail.facet_m == 0.8  # the grid of the sea's waves: what is shorter is in the scattering
    assert "sea.resolution_m" in detail.limited_by
    plain = scene(tracing__facet_m=0.5, tracing__columns_per_beam=4).detail
    assert detail.facets < 0.7 * plain.facets


@pytest.mark.parametrize("name", ["choppy_sea", "wind_and_swell", "long_crested_swell", "calm"])
def test_the_mesh_is_never_coarser_than_sea_beam_and_cell(name: str) -> None:
    made = scene(name, tracing__height_error_m=10.0)
    resolved = made.sea.resolution_m or np.inf
    assert made.detail.facet_m <= min(resolved, 1.0)
    assert made.detail.columns_per_beam >= 3


@pytest.mark.parametrize("target", ["height_error_m", "visible_error"])
def test_a_tighter_target_is_met_by_more_facets(target: str) -> None:
    found = [load_scene("choppy_sea", {f"tracing.{target}": value}).detail for value in (0.02, 0.01, 0.005, 0.0025)]
    facets = [each.facets for each in found]
    assert facets == sorted(facets)
    assert facets[-1] > 2 * facets[0]
    for value, each in zip((0.02, 0.01, 0.005), found, strict=False):
        assert (each.height_error_m if target == "height_error_m" else each.visible_error) <= value


def test_height_and_power_are_both_held_to() -> None:
    """HH fades with the slopes that facets average away: there the power asks for more than the heights do."""
    upright, lying = scene().detail, scene(scattering__polarization="HH").detail
    assert lying.facet_m < upright.facet_m
    assert "power" in lying.limited_by
    assert lying.power_error_db <= POWER_ERROR_DB


def test_a_sector_knows_its_look_against_the_waves() -> None:
    """Waves from the west: looking along their crests the rungs miss little, and the columns much."""
    facing, along = (
        scene(radar__sector_deg=[middle - 6.0, middle + 6.0], tracing__height_error_m=0.003).detail
        for middle in (270.0, 180.0)
    )
    assert along.facet_m > facing.facet_m
    assert along.columns_per_beam > facing.columns_per_beam


def test_a_flat_sea_costs_nothing_and_asks_for_little() -> None:
    flat = scene("flat").detail
    assert flat.visible_error == 0.0
    # What sums over facets leave, and no more: it is measured in tests/mesh/test_sampling.py.
    assert 0.0 < flat.height_error_m < 1e-4
    assert 0.0 < flat.power_error_db < 1e-3
    assert flat.columns_per_beam == 3
    assert_allclose(flat.facet_m, 1.0, atol=0.02)  # a third of the range cell of 3 m
    short = scene("flat", radar__pulse_width_s=1e-8, radar__bandwidth_hz=1e8, radar__range_sampling_m=0.75).detail
    assert_allclose(short.facet_m, 0.5, atol=0.01)


@pytest.mark.parametrize("wavelength", [1.0, 2.0, 5.0])
def test_a_regular_wave_has_eight_rungs(wavelength: float) -> None:
    keys = {"sea__waves__0__wavelength_m": wavelength, "sea__waves__0__height_m": wavelength / 30.0}
    detail = scene("sinusoid", **keys).detail
    assert wavelength / 9.0 < detail.facet_m <= wavelength / 8.0


def test_spacings_that_are_given_are_taken() -> None:
    assert scene(tracing__facet_m=0.37).detail.facet_m == 0.37
    assert scene(tracing__columns_per_beam=7).detail.columns_per_beam == 7
    both = scene(tracing__facet_m=0.5, tracing__columns_per_beam=4)
    assert (both.detail.facet_m, both.detail.columns_per_beam, both.detail.limited_by) == (0.5, 4, "as given")
    assert (both.meshing.facet_m, both.meshing.columns_per_beam) == (0.5, 4)
    coarse = scene(tracing__facet_m=5.0, tracing__columns_per_beam=3).detail
    assert "exceeded" in coarse.limited_by


def test_a_target_beyond_memory_is_said() -> None:
    made = scene(tracing__height_error_m=1e-4)
    assert triangles(made.radar, made.detail.facet_m, made.detail.columns_per_beam) <= MOST_TRIANGLES
    assert "memory" in made.detail.limited_by
    assert "tracing.height_error_m" in made.detail.limited_by


def test_detail_is_told_in_words_and_numbers() -> None:
    detail = scene().detail
    assert isinstance(detail, MeshDetail)
    assert detail == scene().detail
    assert f"rungs {detail.facet_m:g} m apart" in detail.words()
    ranges = [row["range_m"] for row in detail.facts()["by_range"]]  # type: ignore[attr-defined]
    assert ranges == sorted(ranges)
    errors = [row[1] for row in detail.by_range]
    assert errors == sorted(errors)  # the beam widens


def test_triangles_are_those_of_the_mesh() -> None:
    made = scene("tiny", radar__range_m=[15.0, 60.0])
    facets = Simulator(made).mesh(0).facets.height.size
    assert_allclose(made.detail.facets, facets, rtol=0.05)  # whole columns, and the innermost metre


# -------------------------------------------------------------------------------------- against measurement


def maps(made: Scene, surface: Any = None) -> tuple[Any, ...]:
    """Power, phase times range, visible share in the expectation, and the scattering surface."""
    simulator = Simulator(made)
    if surface is not None:
        simulator._surface = surface  # one calibration for all
    facets, returns, _ = simulator.light(0)
    found = expected_look_gates(facets, returns.rcs, simulator.installation, 1.8)
    truth = polar_truth(facets, returns.rcs, simulator.installation, made.retrieval, 0)
    return found, truth["visible_fraction"].values[0], simulator.surface


def test_predicted_errors_are_those_of_a_wind_sea() -> None:
    """Twelve degrees up the waves, against a mesh of a sixth of the rungs and four times the columns: within 1.5."""
    keys = {"radar__sector_deg": [264.0, 276.0], "radar__range_m": [15.0, 250.0], "tracing__tracer": "horizon"}
    keys |= {"scattering__sea_spikes": False, "tracing__diffraction": "none"}
    coarse = scene(**keys, tracing__facet_m=0.8, tracing__columns_per_beam=4)
    echoes, visible, surface = maps(coarse)
    finer, seen, _ = maps(scene(**keys, tracing__facet_m=0.13, tracing__columns_per_beam=16), surface)
    k = 2.0 * np.pi / coarse.wavelength_m
    kept = seen > 0.5
    turned = np.angle(echoes.covariance * finer.covariance.conj()) * finer.range / (k * coarse.radar.baseline_m)
    power = 10.0 * np.log10(np.where(kept, echoes.power[0, 0], 1.0) / np.where(kept, finer.power[0, 0], 1.0))
    for errors, predicted in (
        (turned, coarse.detail.height_error_m),
        (power, coarse.detail.power_error_db),
        (visible - seen, coarse.detail.visible_error),
    ):
        ratio = np.sqrt(np.mean(errors[kept] ** 2)) / predicted
        assert 1.0 / 1.5 < ratio < 1.5


def test_calibration_samples_the_same_places_whatever_the_mesh() -> None:
    """Another mesh's crests would set its scale apart by luck, 0.1 dB."""
    grids = [
        circle_grid(made.radar, made.meshing)[0]
        for made in (scene(tracing__facet_m=f, tracing__columns_per_beam=c) for f, c in ((0.5, 4), (0.8, 3), (0.25, 8)))
    ]
    for grid in grids[1:]:
        np.testing.assert_array_equal(grid.azimuth, grids[0].azimuth)


def test_a_circle_is_never_promised_more_than_its_worst_sector() -> None:
    """Maps hold every look: the errors that a circle is sized by are those of the look that errs most."""
    mesh = {"tracing__facet_m": 0.8, "tracing__columns_per_beam": 3}
    sectors = [scene(radar__sector_deg=[start, start + 30.0], **mesh).detail for start in (0.0, 45.0, 90.0, 150.0)]
    circle = scene(**mesh).detail
    for name in ("height_error_m", "power_error_db", "visible_error"):
        worst = max(getattr(each, name) for each in sectors)
        assert getattr(circle, name) > 0.97 * worst  # a sector's one look may lie between those of the circle
