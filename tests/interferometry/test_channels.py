"""The channel between the receivers: as it is told, and as reciprocity tells it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import seamap_rt as sr
from seamap_rt.errors import SchemaError
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.dwell_sums import Channel, DwellSums, PulseComparison
from seamap_rt.interferometry.dwells import Dwells
from seamap_rt.interferometry.windows import Covariance
from seamap_rt.settings import RetrievalSettings

GAIN_DB, PHASE_DEG = 1.5, 25.0


def echoes(**overrides: Any) -> xr.Dataset:
    """Of a few reflectors at several ranges and bearings, that move, at an upper receiver with another channel."""
    scene = sr.load_scene("tiny", {"radar.noise": False, **{f"radar.{key}": value for key, value in overrides.items()}})
    rng = np.random.default_rng(1)
    azimuth, distance = np.radians(rng.uniform(242.0, 298.0, 40)), rng.uniform(20.0, 140.0, 40)
    points = np.stack((distance * np.sin(azimuth), distance * np.cos(azimuth), rng.uniform(-1.0, 1.0, 40)), axis=1)
    return sr.echoes.from_scatterers(scene, points, np.full(40, 10.0), rng.uniform(-2.0, 2.0, (40, 3)))


def sums(data: xr.Dataset, **chosen: Any) -> DwellSums:
    radar, settings = RadarDescription.of(data), RetrievalSettings.model_validate(chosen)
    voltage, transmitter, time = (data[name].values for name in ("voltage", "transmitter", "time"))
    dwells = Dwells(np.arange(time.size) // 50, -(-time.size // 50))
    paired = PulseComparison.of(voltage, transmitter, time, (0, 1), radar, settings)
    return DwellSums.of(voltage, transmitter, time, paired, dwells, (0, 1), radar, settings)


def strong(one: Covariance) -> Any:
    return one.lower > 1e-3 * np.nanmax(one.lower)


@pytest.mark.parametrize("channels", ["as_given", "from_cross_paths"])
def test_what_a_channel_does_is_undone(channels: str) -> None:
    plain = sums(echoes())
    skewed = echoes(channel_gain_db=GAIN_DB, channel_phase_deg=PHASE_DEG)
    found = sums(skewed, channels=channels, channel_gain_db=GAIN_DB, channel_phase_deg=PHASE_DEG)
    for name in ("one", "two"):
        mine, his = getattr(found, name), getattr(plain, name)
        heard = strong(his)
        # float32 when told. By the echoes themselves: neighbouring pulses, between which the beam turns by 0.036° and
        # the paths of reflectors differ that move, agree to some 1e-4, less where forward and backward cancel.
        tolerance = 1e-5 if channels == "as_given" else 2e-3
        np.testing.assert_allclose(mine.cross[heard], his.cross[heard], rtol=tolerance)
        np.testing.assert_allclose(mine.upper[heard], his.upper[heard], rtol=2.0 * tolerance)
        np.testing.assert_array_equal(mine.lower[heard], his.lower[heard])
    assert np.degrees(np.angle(found.channel.ratio)) == pytest.approx(PHASE_DEG, abs=0.01)


def test_left_alone_it_stays_in_the_phase() -> None:
    plain = sums(echoes())
    one = sums(echoes(channel_phase_deg=PHASE_DEG)).one
    assert one is not None
    assert plain.one is not None
    heard = strong(plain.one)
    turned = np.degrees(np.angle(one.cross[heard] / plain.one.cross[heard]))
    np.testing.assert_allclose(turned, -PHASE_DEG, atol=1e-3)


def test_noise_is_told_as_it_is_after_the_correction() -> None:
    # The recorded figure is the mean of both receivers' noise; the upper one's, amplified by g, is g times the
    # lower's. 2 million samples of noise have a mean power good to 0.1 %; 5 σ.
    rng, gain = np.random.default_rng(2), 4.0
    channel = Channel.from_gain(10.0 * np.log10(gain), 40.0)
    powers = rng.exponential(3.0, 2_000_000), gain * rng.exponential(3.0, 2_000_000)
    lower, upper = (np.array([[each.mean()]]) for each in powers)
    found = channel.corrected(Covariance(np.zeros((1, 1), dtype=complex), lower, upper))
    assert channel.noise_power(0.5 * (lower + upper).item()) == pytest.approx(3.0, rel=5e-3)
    assert found.upper.item() == pytest.approx(3.0, rel=5e-3)
    assert found.lower.item() == pytest.approx(3.0, rel=5e-3)


@pytest.mark.parametrize("radar", [{"transmit": "single"}, {"interferogram": "alternating_pulse"}])
def test_without_cross_paths_it_says_what_to_do(radar: dict[str, str]) -> None:
    with pytest.raises(SchemaError, match=r"from_cross_paths.*; record both receivers") as failure:
        sums(echoes(**radar), channels="from_cross_paths")
    assert "\n" not in str(failure.value)


def test_a_silent_receiver_has_no_channel() -> None:
    data = echoes()
    data["voltage"].values[:, 1] = 0.0
    with pytest.raises(SchemaError, match="heard nothing"):
        sums(data, channels="from_cross_paths")
