"""The four modes hear the same sea: pulse by pulse, in the mean, and in the noise."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import mpmath
import numpy as np
import pytest
from exact_echoes import MODES, ROCKING, SEED, direct_sum, radar_of, relative_rms, sea_seen
from numpy.typing import NDArray

from seamap_rt.conventions import BOLTZMANN, SPEED_OF_LIGHT, from_db
from seamap_rt.echoes import expected_look_gates, from_scatterers, turn_voltages
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.waveform import gates
from seamap_rt.scene import Scene

RUNNING = {"speed_m_s": 5.0, "heading_deg": 60.0}
HEARD = {  # on even and on odd pulses: the transmitter, and the receivers that are sampled
    ("single", "single_pulse"): ((0, (0, 1)), (0, (0, 1))),
    ("switched", "single_pulse"): ((0, (0, 1)), (1, (0, 1))),
    ("single", "alternating_pulse"): ((0, (0,)), (0, (1,))),
    ("switched", "alternating_pulse"): ((0, (0,)), (1, (1,))),
}


def scene_of(transmit: str, interferogram: str, **radar) -> Scene:
    default = {
        "sector_deg": (20.0, 56.0),
        "range_m": (15.0, 90.0),
        "transmit": transmit,
        "interferogram": interferogram,
    }
    return Scene.model_validate({"name": "mode", "radar": {**default, **radar}})


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("noise", [False, True])
def test_who_sends_and_who_hears(mode: tuple[str, str], noise: bool) -> None:
    echoes = from_scatterers(scene_of(*mode, noise=noise), [[0.0, 30.0, 0.0]], [1.0])
    silent = np.isnan(echoes["voltage"].values)
    assert echoes.sizes["pulse"] == 1000
    assert (silent.all(axis=2) == silent.any(axis=2)).all()
    for parity, (sender, heard) in enumerate(HEARD[mode]):
        assert (echoes["transmitter"].values[parity::2] == sender).all()
        np.testing.assert_array_equal(silent[parity::2].all(axis=2), [[r not in heard for r in (0, 1)]] * 500)
    assert (echoes.attrs["transmit"], echoes.attrs["interferogram"]) == mode


@pytest.mark.parametrize("mode", MODES)
def test_modes_against_a_direct_sum(mode: tuple[str, str]) -> None:
    # As for any boat (test_moving_boat): 2.5e-3 … 2.9e-3, and 1.1e-3 beyond 35 m.
    radar = radar_of(transmit=mode[0], interferogram=mode[1])
    facets, rcs, fired = sea_seen(radar, RUNNING)
    found = turn_voltages(facets, rcs, Installation(radar), fired, SEED, np.inf)
    exact = direct_sum(facets, rcs, radar, fired)
    assert relative_rms(found, exact) < 4e-3
    assert relative_rms(found[..., 10:], exact[..., 10:]) < 2.5e-3


@cache
def _voltages(transmit: str, interferogram: str) -> NDArray[np.complex64]:
    radar = radar_of(transmit=transmit, interferogram=interferogram)
    facets, rcs, fired = sea_seen(radar, ROCKING)
    return turn_voltages(facets, rcs, Installation(radar), fired, SEED, np.inf)


@pytest.mark.parametrize("transmit", ["single", "switched"])
def test_what_is_heard_does_not_depend_on_what_else_is(transmit: str) -> None:
    # Sample by sample where both modes have it. Nodes may lie elsewhere: the windowed sinc's 1e-4 … 1e-3.
    whole, part = _voltages(transmit, "single_pulse"), _voltages(transmit, "alternating_pulse")
    both = ~np.isnan(part)
    np.testing.assert_allclose(both.mean(), 0.5)
    assert relative_rms(part[both], whole[both]) < 1e-3


def test_what_goes_one_way_comes_back_the_other() -> None:
    # Lower to upper is upper to lower, a pulse later: with one transmitter and two the upper receiver's even pulses
    # agree.
    single, switched = _voltages("single", "single_pulse"), _voltages("switched", "single_pulse")
    assert relative_rms(switched[::2], single[::2]) < 1e-3
    # And interpolated to the time of the odd ones, so do the lower's from the upper with the upper's from the lower.
    np.testing.assert_allclose(switched[1::2, 0], single[1::2, 1], atol=2e-3 * np.abs(single).max())


@pytest.mark.parametrize("mode", MODES)
def test_phase_of_the_expected_covariance(mode: tuple[str, str]) -> None:
    # One facet echoes: k ΔR, and twice that where each antenna hears itself. float64 throughout, weights in float32.
    radar = radar_of(transmit=mode[0], interferogram=mode[1], baseline_m=0.9, tilt_deg=5.0)
    facets, rcs, _ = sea_seen(radar)
    column, facet = facets.grid.columns // 2, 61
    assert facets.lit[:, column, facet].all()
    alone = np.zeros_like(rcs)
    alone[column, facet] = 1.0
    found = expected_look_gates(facets, alone, Installation(radar), 1.8).covariance
    angle = float(np.angle(found.flat[np.abs(found).argmax()]))
    twice = 2 if mode == ("switched", "alternating_pulse") else 1
    with mpmath.workdps(30):
        k = 2 * mpmath.pi * mpmath.mpf(10**10) / mpmath.mpf(SPEED_OF_LIGHT)
        lean, aside = mpmath.radians(5), mpmath.mpf(float(facets.angle[facet]))
        x, y = (mpmath.mpf(float(facets.distance[facet])) * f(aside) for f in (mpmath.cos, mpmath.sin))
        z = mpmath.mpf(float(facets.height[column, facet])) - mpmath.mpf(radar.height_m)
        half = mpmath.mpf(radar.baseline_m) / 2
        lower, upper = (
            mpmath.norm([x - s * half * mpmath.sin(lean), y, z - s * half * mpmath.cos(lean)]) for s in (-1, 1)
        )
        apart = float((angle - twice * k * (upper - lower) + mpmath.pi) % (2 * mpmath.pi) - mpmath.pi)
    # The chain's boresight passes the column's middle, 2e-6° of rounding off: the tilted baseline 0.08 m ahead does not
    # feel that.
    assert abs(apart) < 1e-6


@pytest.mark.parametrize("mode", [MODES[0], MODES[2]])
def test_the_expected_covariance_of_bent_light_is_that_of_the_voltages(mode: tuple[str, str]) -> None:
    # Fields of unlike phase at the two antennas: 0.3 − 1.1 rad between the receivers, whichever of them transmits.
    radar = radar_of(transmit=mode[0], interferogram=mode[1])
    facets, rcs, fired = sea_seen(radar)
    alone = np.zeros_like(rcs)
    alone[facets.grid.columns // 2, 61] = 1.0
    fields = np.exp(1j * np.array([0.3, 1.1]))[:, None, None] * np.ones(facets.lit.shape)
    angles = []
    for field in (None, fields.astype(np.complex64)):
        bent = replace(facets, field=field)
        covariance = expected_look_gates(bent, alone, Installation(radar), 1.8).covariance
        angles.append(np.angle(covariance.flat[np.abs(covariance).argmax()]))
        volts = turn_voltages(bent, alone, Installation(radar), fired, SEED, np.inf).astype(complex)
        assert abs(np.angle(np.sum(volts[:, 0] * volts[:, 1].conj()) * np.exp(-1j * angles[-1]))) < 1e-4
    assert abs((angles[1] - angles[0] + 0.8 + np.pi) % (2.0 * np.pi) - np.pi) < 1e-6


@pytest.mark.parametrize("mode", MODES)
def test_noise_is_kTBF_in_every_mode(mode: tuple[str, str]) -> None:
    # 1000 pulses × 51 gates, neighbours hardly correlated (1.5 m apart, 50 MHz): 1/√(500 × 51 / 1.0) = 0.6 % at least.
    echoes = from_scatterers(scene_of(*mode), [[0.0, 1e4, 0.0]], [0.0])
    power = np.nanmean(np.abs(echoes["voltage"].values.astype(complex)) ** 2, axis=(0, 2))
    thermal = BOLTZMANN * 290.0 * 50e6 * from_db(3.0)
    np.testing.assert_allclose(power, thermal, rtol=0.03)
    np.testing.assert_allclose(echoes.attrs["noise_power_w"], thermal, rtol=1e-12)
    assert echoes.sizes["range"] == gates(scene_of(*mode).radar).size
