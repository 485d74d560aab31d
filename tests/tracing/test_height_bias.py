"""What light that bends over crests does to heights, and what error bars hold of it."""

from __future__ import annotations

import json

import numpy as np
import pytest

import seamap_rt as sr
from seamap_rt.interferometry.slopes import diffraction_error
from seamap_rt.physics.shadowing import arrival_error_mrad
from validation.light.height_bias import height_bias, over_edges
from validation.light.wave_shadows import WAVELENGTH_M

X = np.arange(60.0, 120.0, 0.02)
GRID = 1.8, 3.0, False  # deg, m, no circle


@pytest.mark.parametrize("off_m", [-0.1, 0.05])
def test_fields_that_come_from_higher_up_are_found_higher(off_m: float) -> None:
    """Of water at mean level, a field as that of a point δ higher: the height is δ, to (h/R)² and half a cell, 3 %."""
    masts = np.array([4.9, 5.1])[:, None]
    longer = np.hypot(X, masts - off_m) - np.hypot(X, masts)
    lower, upper = np.exp(-2j * np.pi / WAVELENGTH_M * longer)
    bias = height_bias(lower, upper, X, 0.2)
    np.testing.assert_allclose(bias[np.isfinite(bias)], off_m, rtol=0.03)


def test_over_level_water_nothing_turns_the_phase() -> None:
    x = np.arange(0.0, 210.0, 0.02)
    lower, upper = (over_edges(X, x, np.zeros(x.size), mast) for mast in (4.9, 5.1))
    bias = height_bias(lower, upper, X, 0.2)
    assert np.abs(bias[np.isfinite(bias)]).max() < 1e-3


@pytest.mark.parametrize("share", [0.0, 0.36, 1.0])
def test_the_error_grows_with_range_and_hidden_share_up_to_the_seas_own_height(share: float) -> None:
    """Near by the angle times the range, far off the sea's rms, both times the root of what is hidden: none where all
    is in sight."""
    ranges = np.array([1e-3, 10.0, 1e6])
    height = np.tile([[2.5], [3.5]], (10, 3))  # ± 0.5 m about a level that does not matter
    error = diffraction_error(np.full(height.shape, share), height, np.full(height.shape, 0.1), ranges, GRID, 2e-3)
    root = np.sqrt(1.0 - share)
    exact = root * np.array([2e-6, 1.0 / np.hypot(1.0 / 2e-2, 1.0 / 0.5), 0.5])
    np.testing.assert_allclose(error, np.broadcast_to(exact, error.shape), rtol=1e-5, atol=1e-12)


def test_no_height_known_or_no_angle_is_no_error() -> None:
    height, ranges = np.full((4, 3), np.nan), np.array([10.0, 20.0, 30.0])
    for known, angle in ((height, 2e-3), (np.ones((4, 3)), 0.0)):
        np.testing.assert_array_equal(diffraction_error(height, known, known, ranges, GRID, angle), 0.0)


def test_the_error_goes_round_with_a_circle_and_not_by_how_finely_it_is_sampled() -> None:
    """A map turned by a quarter has the error turned; one of half as wide looks has the same at the same places, to
    the step of a look in a mean over fifteen; what does not echo counts as hidden."""
    random = np.random.default_rng(5)
    ranges, height = np.arange(20.0, 80.0, 1.5), random.normal(size=(200, 40))
    share = np.repeat(random.uniform(size=(40, 40)), 5, axis=0)
    spread, circle = np.full(share.shape, 0.1), (1.8, 1.5, True)
    error = diffraction_error(share, height, spread, ranges, circle, 2e-3)
    there, level, bars = (np.roll(each, 50, axis=0) for each in (share, height, spread))
    turned = diffraction_error(there, level, bars, ranges, circle, 2e-3)
    np.testing.assert_allclose(turned, np.roll(error, 50, axis=0), rtol=1e-9)
    there, level, bars = (np.repeat(each, 2, axis=0) for each in (share, height, spread))
    found = diffraction_error(there, level, bars, ranges, (0.9, 1.5, True), 2e-3)[::2]
    np.testing.assert_allclose(found, error, rtol=0.1)
    silent = diffraction_error(np.where(share < 0.3, np.nan, share), height, spread, ranges, circle, 2e-3)
    dark = diffraction_error(np.where(share < 0.3, 0.0, share), height, spread, ranges, circle, 2e-3)
    np.testing.assert_array_equal(silent, dark)


def test_height_bars_hold_it_and_nothing_else_changes() -> None:
    scene = sr.load_scene("tiny", {"tracing.tracer": "horizon"})
    echoes = sr.simulate(scene).echoes
    straight, bent = (sr.retrieve(echoes, {"diffraction_mrad": error})["polar"].to_dataset() for error in (0.0, 2.0))
    known = np.isfinite(straight["height_std"].values)
    more = bent["height_std"].values[known] ** 2 - straight["height_std"].values[known] ** 2
    assert more.min() >= -1e-9
    assert more.max() > 0.0
    ranges = np.broadcast_to(straight["range"].values, known.shape)[known]
    assert np.all(more <= (2e-3 * ranges) ** 2 * (1.0 + 1e-5) + 1e-9)
    assert np.all(bent["analysis_std"].values[known] <= straight["height_std"].values[known])
    others = [name for name in straight if name != "height_std" and not straight[name].equals(bent[name])]
    assert others == []
    assert "diffraction" in bent.attrs["height_std_holds"]
    assert "diffraction" not in straight.attrs["height_std_holds"]


def test_scenes_without_diffraction_state_none_of_its_error_others_and_recordings_do() -> None:
    """It grows as √λ, and is more in HH than in VV, but for knife edges, which know no polarization."""
    assert sr.load_scene("tiny", {"tracing.diffraction": "none"}).resolved_retrieval.diffraction_mrad is None
    edges = sr.load_scene("tiny", {"tracing.diffraction": "knife_edge", "scattering.polarization": "HH"})
    assert edges.resolved_retrieval.diffraction_mrad == pytest.approx(arrival_error_mrad("VV", edges.wavelength_m))
    assert arrival_error_mrad("HH", 0.03) > arrival_error_mrad("VV", 0.03)
    assert arrival_error_mrad("VV", 0.12) == pytest.approx(2.0 * arrival_error_mrad("VV", 0.03))
    own = edges.model_copy(update={"retrieval": edges.retrieval.model_copy(update={"diffraction_mrad": 0.1})})
    assert own.resolved_retrieval.diffraction_mrad == 0.1


def test_recordings_carry_the_error() -> None:
    pulses, gates = np.arange(8), 20.0 + 3.0 * np.arange(10)
    header = {
        "frequency_hz": 10e9, "pulse_width_s": 2e-8, "bandwidth_hz": 5e7, "height_m": 5.0, "baseline_m": 0.2,
        "azimuth_beamwidth_deg": 1.8, "elevation_beamwidth_deg": 18.0, "polarization": "HH", "rotation_rpm": 60.0,
        "prf_hz": 1000.0, "sector_deg": [0.0, 10.0], "partial_turns": "keep",
    }  # fmt: skip
    voltage = np.ones((8, 10), np.complex64)
    echoes = sr.echoes_from_recording(
        voltage, voltage, header, time=1e-3 * pulses, azimuth=2.0 + 0.36 * pulses, ranges=gates
    )
    carried = json.loads(echoes.attrs["retrieval"])
    assert carried == {"diffraction_mrad": pytest.approx(arrival_error_mrad("HH", 0.0299792458))}
