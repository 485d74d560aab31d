"""The picture of an ordinary marine radar: detector, filter, pulses, and a file that reads as it was written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import seamap_rt as sr
from seamap_rt.echoes.video import detected, polar_image, video
from seamap_rt.io.polar_images import write_polar_image
from seamap_rt.radar.receiver import noise_power
from seamap_rt.settings import RadarSettings
from seamap_rt.simulation import Simulator

RANGE = np.arange(100.0, 1600.0, 3.75)
KNEES = (-30.0, 0.0, 20.0, 60.0)


def radar(**keys: Any) -> RadarSettings:
    """A radar of that receiver."""
    return sr.load_scene("choppy_sea", {f"radar.receiver.{k}": v for k, v in keys.items()} | CHAIN | MARINE).radar


CHAIN: dict[str, Any] = {"radar.receiver.chain": "video"}
MARINE: dict[str, Any] = {
    "radar.range_sampling_m": 3.75,
    "radar.pulse_width_s": 70e-9,
    "radar.bandwidth_hz": 20e6,
    "retrieval.cell_range_m": 6.0,
}
SHOWN: dict[str, Any] = CHAIN | {
    "tracing.tracer": "horizon",
    "radar.range_m": [30.0, 150.0],
    "radar.sector_deg": [250.0, 290.0],
    "radar.transmit": "single",
    "sea.extent_m": 400.0,
    "sea.resolution_m": 1.25,
    "radar.receiver.video_pulses": 4,
}


def speckle(pulses: int, decibels: float = 40.0, seed: int = 1) -> np.ndarray:
    """(pulse, gate) of even mean power over the noise."""
    random = np.random.default_rng(seed)
    unit = random.standard_normal((pulses, RANGE.size, 2)) @ np.array([1.0, 1j]) * np.sqrt(0.5)
    return unit * np.sqrt(noise_power(radar()) * 10.0 ** (0.1 * decibels))


@pytest.mark.parametrize("knee", KNEES)
def test_the_detector_is_linear_below_its_knee_and_a_logarithm_above(knee: float) -> None:
    settings, noise = radar(knee_db=knee), noise_power(radar())
    below, above = (np.sqrt(noise * 10.0 ** (0.1 * (knee + over))) for over in (-7.0, np.array([20.0, 40.0])))
    assert detected(settings, 2.0 * below) == pytest.approx(2.0 * detected(settings, below))
    assert np.diff(detected(settings, above)) == pytest.approx(np.log(10.0))  # 20 dB are a factor of ten of voltage
    at = np.sqrt(noise * 10.0 ** (0.1 * knee))
    levels = detected(settings, at * (1.0 + 1e-4 * np.array([-1.0, 0.0, 1.0])))
    assert np.diff(levels) == pytest.approx(1e-4, rel=1e-3)  # no step in level or slope


@pytest.mark.parametrize("exponent", [2.0, 4.0])
def test_the_control_takes_off_the_fall_of_an_echo_before_the_detector(exponent: float) -> None:
    """In front of a logarithm an echo that falls as that power of range is even, up to where the control ends."""
    settings = radar(knee_db=-60.0, stc_exponent=exponent, stc_range_m=800.0, adc_bits=12)
    strong = np.sqrt(noise_power(settings) * 1e5 * (RANGE / 800.0) ** -exponent)[None] + 0j
    counts = video(settings, strong, RANGE)[0].astype(float)
    near = RANGE < 800.0
    assert np.ptp(counts[near]) <= 1.0
    assert counts[near].mean() - counts[~near].min() > 50.0


@pytest.mark.parametrize("pulses", [1, 3, 5])
def test_pulses_average_and_the_rest_of_a_radial_goes(pulses: int) -> None:
    settings = radar(knee_db=-60.0, video_pulses=pulses)
    one = video(radar(knee_db=-60.0), speckle(1000), RANGE).astype(float)
    mean = video(settings, speckle(1000), RANGE)
    assert mean.shape == (1000 // pulses, RANGE.size)
    # 400 000 cells: the ratio of variances is known to 1 %.
    assert mean.var() == pytest.approx(one.var() / pulses, rel=0.03)


@pytest.mark.parametrize("bandwidth", [4e6, 10e6])
def test_the_video_filter_passes_half_the_power_at_its_bandwidth(bandwidth: float) -> None:
    plain, filtered = (
        video(radar(knee_db=-60.0, video_bandwidth_hz=b), speckle(2000), RANGE).astype(float) for b in (None, bandwidth)
    )
    power = [np.mean(np.abs(np.fft.rfft(each - each.mean(), axis=1)) ** 2, axis=0) for each in (plain, filtered)]
    frequency = np.fft.rfftfreq(RANGE.size, 2.0 * 3.75 / 299_792_458.0)
    at = np.argmin(np.abs(frequency - bandwidth))
    around = slice(at - 5, at + 6)
    # 22 000 cells of an exponential: 1 %; the filter bends by 1 % over the band.
    assert power[1][around].sum() / power[0][around].sum() == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("bits", [4, 8, 12])
def test_counts_fill_the_converter_and_no_more(bits: int) -> None:
    settings = radar(adc_bits=bits)
    top = 2**bits - 1
    strongest = np.full((1, RANGE.size), np.sqrt(1e-3 * 10.0 ** (0.1 * (settings.receiver.full_scale_dbm + 20.0))))
    assert (video(settings, strongest + 0j, RANGE) == top).all()
    assert (video(settings, 0j * strongest, RANGE) == 0).all()
    assert (video(settings, np.nan * strongest + 0j, RANGE) == 0).all()


def test_a_picture_reads_as_it_was_written(tmp_path: Path) -> None:
    """Turns at their times, radials at their bearings, all counts: of two turns with the wind across north."""
    scene = sr.load_scene("choppy_sea", SHOWN | {"turns": 2, "radar.sector_deg": [340.0, 380.0]})
    sr.simulate(scene, out=tmp_path)
    files = sorted((tmp_path / "polar_images").iterdir())
    assert [file.name for file in files] == ["turn-0001.pol", "turn-0002.pol"]
    read = sr.read_polar_images(files)
    said = {"ship_speed_m_s": 0.0, "wind_speed_m_s": 8.0, "wind_from_deg": 270.0}
    simulator = Simulator(scene)
    made = [polar_image(simulator.turn(number).echoes, scene.radar, said) for number in range(2)]
    np.testing.assert_array_equal(read["video"], np.concatenate([each["video"] for each in made]))
    np.testing.assert_allclose(read["range"], made[0]["range"], rtol=1e-6)
    wanted = np.concatenate([each["azimuth"] for each in made])
    radial = 360.0 * scene.radar.rotation_rpm / 60.0 / scene.radar.prf_hz * 4
    off = (read["azimuth"].values - wanted + 180.0) % 360.0 - 180.0
    assert np.abs(off).max() < 2.0 * radial  # a counter of whole degrees places a radial to half of one
    time = np.concatenate([each["time"] for each in made])
    np.testing.assert_allclose(read["time"] - read["time"][0], time - time[0], atol=1e-3)
    assert read.attrs["wind_speed_m_s"] == 8.0


@pytest.mark.parametrize(
    ("keys", "named"),
    [
        ({"radar.receiver.adc_bits": 14}, "radar.receiver.adc_bits = 14"),
        ({"radar.sector_deg": [0.0, 2.0]}, "radar.sector_deg = "),
        ({"radar.range_m": [30.0, 40.0], "radar.range_sampling_m": 1.5}, "radar.range_sampling_m = 1.5"),
        ({"radar.scan": "staring"}, "radar.receiver.chain = 'video'"),
    ],
)
def test_a_picture_that_the_format_cannot_hold_is_refused(keys: dict[str, Any], named: str) -> None:
    with pytest.raises(sr.InputError, match=named):
        sr.load_scene("choppy_sea", SHOWN | keys)


def test_a_file_refuses_a_turn_that_it_cannot_hold(tmp_path: Path) -> None:
    scene = sr.load_scene("choppy_sea", SHOWN)
    said = {"ship_speed_m_s": 0.0, "wind_speed_m_s": 8.0, "wind_from_deg": 270.0}
    image = polar_image(Simulator(scene).turn(0).echoes, scene.radar, said)
    for part in (image.isel(pulse=slice(0, 3)), image.isel(range=slice(0, 20)), image.isel(pulse=slice(0, 0))):
        with pytest.raises(sr.InputError, match=r"a\.pol"):
            write_polar_image(tmp_path / "a.pol", part)
    assert not (tmp_path / "a.pol").exists()
