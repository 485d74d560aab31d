"""What light that bends over crests does to heights, and what error bars hold of it."""

from __future__ import annotations

import json

import numpy as np
import pytest

import seamap_rt as sr
from seamap_rt.physics.shadowing import arrival_error_mrad
from validation.light.height_bias import height_bias, over_edges
from validation.light.wave_shadows import WAVELENGTH_M

X = np.arange(60.0, 120.0, 0.02)


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


def test_height_bars_hold_the_error_of_the_angle_of_arrival_times_the_range_and_nothing_else_changes() -> None:
    scene = sr.load_scene("tiny", {"tracing.tracer": "horizon"})
    echoes = sr.simulate(scene).echoes
    straight, bent = (sr.retrieve(echoes, {"diffraction_mrad": error})["polar"].to_dataset() for error in (None, 2.0))
    expected = np.hypot(straight["height_std"].values, 2e-3 * straight["range"].values)
    np.testing.assert_allclose(bent["height_std"].values, expected, rtol=1e-5)
    others = [name for name in straight if name != "height_std" and not straight[name].equals(bent[name])]
    assert others == []
    assert "diffraction" in bent.attrs["height_std_holds"]
    assert "diffraction" not in straight.attrs["height_std_holds"]


def test_scenes_without_diffraction_state_none_of_its_error_others_and_recordings_do() -> None:
    """It grows as √λ, and is more in HH than in VV."""
    assert sr.load_scene("tiny").resolved_retrieval.diffraction_mrad is None
    edges = sr.load_scene("tiny", {"tracing.diffraction": "knife_edge", "scattering.polarization": "HH"})
    assert edges.resolved_retrieval.diffraction_mrad == pytest.approx(arrival_error_mrad("HH", edges.wavelength_m))
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
