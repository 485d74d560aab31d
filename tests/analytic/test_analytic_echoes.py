"""Closed-form echoes: each law of the geometry and of the statistics they promise, by another way than their own."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.dataset import check
from seamap_rt.interferometry import retrieve
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.platform import boat_motion
from seamap_rt.radar.pose import antenna_axes
from seamap_rt.radar.scan import pulses
from seamap_rt.radar.waveform import gates
from seamap_rt.settings import PlacedAntenna, PlatformSettings, RadarSettings, RetrievalSettings
from validation import analytic
from validation.analytic.echoes import echoes, gate_weights
from validation.analytic.sight import Array

C = 299_792_458.0
K = 2.0 * np.pi * 10e9 / C
WAVE = analytic.SinusoidSea(0.6, 30.0, 240.0, 50.0)
MODES = [(t, i) for t in ("single", "switched") for i in ("single_pulse", "alternating_pulse")]


def radar_of(**asked: object) -> RadarSettings:
    return RadarSettings.model_validate(
        {"sector_deg": (30.0, 39.0), "range_m": (20.0, 80.0), "range_sampling_m": 5.0, **asked}
    )


def voltages(dataset: xr.Dataset) -> NDArray[np.complex128]:
    return dataset["voltage"].values.astype(np.complex128)


def turned(path: NDArray[np.float64]) -> NDArray[np.complex128]:
    return np.exp(-1j * np.remainder(K * path, 2.0 * np.pi))


# ------------------------------------------------------------------------------------------------------- the array


def test_axes_are_those_of_the_pose() -> None:
    # Two derivations of one convention: here turns of pairs of axes, there products of matrices.
    rng = np.random.default_rng(1)
    attitude, scan = rng.uniform((-30.0, -30.0, -180.0), (30.0, 30.0, 180.0), (50, 3)), rng.uniform(0.0, 360.0, 50)
    offsets = np.eye(3)
    array = Array.standing(attitude, scan, 13.0, np.zeros((50, 3)), offsets)
    axes = antenna_axes(attitude, scan, 13.0)
    np.testing.assert_allclose(np.stack((array.across, array.boresight, array.upright), axis=1), axes, atol=1e-15)
    np.testing.assert_allclose(array.antennas, axes, atol=1e-15)


@pytest.mark.parametrize("mode", MODES)
def test_pulses_and_places_are_the_radars(mode: tuple[str, str]) -> None:
    radar = radar_of(transmit=mode[0], interferogram=mode[1], tilt_deg=4.0, prf_hz=3001.0, baseline_error_m=0.01)
    platform = PlatformSettings(heading_deg=70.0, list_deg=6.0, trim_deg=-2.0, lever_arm_m=(0.0, 0.0, 5.0))
    made = echoes(
        analytic.FlatSea(), radar, attitude_deg=(6.0, -2.0, 70.0), turns=3, position_m=lambda t: np.outer(t, (1, 2, 0))
    )
    check("echoes", made)
    mast = Installation(radar, platform, sensors=boat_motion(platform)).sensed
    fired = [pulses(mast, turn) for turn in range(3)]
    np.testing.assert_array_equal(made["pulse"], np.concatenate([each.number for each in fired]))
    np.testing.assert_array_equal(made["transmitter"], np.concatenate([each.transmitter for each in fired]))
    np.testing.assert_array_equal(made["turn"], np.repeat(np.arange(3), [each.number.size for each in fired]))
    time = made["time"].values
    np.testing.assert_allclose(time, np.concatenate([each.time for each in fired]), atol=1e-15)
    poses = [each.installation.pose(each.time) for each in fired]
    np.testing.assert_allclose(made["azimuth"], np.concatenate([each.bearing for each in poses]), atol=1e-9)
    places = np.concatenate([each.offsets for each in poses])
    middle = np.stack((time, 2.0 * time, np.full(time.size, 5.0)), axis=1)
    np.testing.assert_allclose(made["position"], middle[:, None] + places, atol=1e-9)
    heard = np.isfinite(voltages(made)).all(axis=2)
    assert (np.isnan(voltages(made)).all(axis=2) == ~heard).all()
    slots = {"single_pulse": [(True, True)], "alternating_pulse": [(True, False), (False, True)]}[mode[1]]
    np.testing.assert_array_equal(heard, np.array(slots)[made["pulse"].values % len(slots)])


# ------------------------------------------------------------------------------------------------- the ideal sea


@pytest.mark.parametrize("sea", [analytic.FlatSea(), analytic.TiltedSea(0.05, -0.08, 0.3), WAVE])
@pytest.mark.parametrize("transmit", ["single", "switched"])
@pytest.mark.parametrize("tilt", [-20.0, 20.0])
def test_points_lie_on_the_sea_in_the_fan_at_the_gates_range(sea, transmit: str, tilt: float) -> None:
    rng, radar = np.random.default_rng(3), radar_of(transmit=transmit, tilt_deg=tilt, baseline_m=1.8)
    count, ranges = 40, gates(radar_of())
    attitude = rng.uniform((-15.0, -10.0, 0.0), (15.0, 10.0, 360.0), (count, 3))
    middle = rng.uniform((-50.0, -50.0, 4.0), (50.0, 50.0, 12.0), (count, 3))
    array = Array.standing(
        attitude, rng.uniform(0.0, 360.0, count), tilt, middle, np.array(((0, 0, -0.9), (0, 0, 0.9)))
    )
    points = array.fan_meets(sea, ranges, gate_weights(radar))
    assert np.isfinite(points).all()
    np.testing.assert_allclose(points[..., 2], sea.height(points[..., 0], points[..., 1]), atol=1e-11)
    away = points - middle[:, None]
    np.testing.assert_allclose(np.einsum("ngj,nj->ng", away, array.across), 0.0, atol=1e-11)
    assert (np.einsum("ngj,nj->ng", away, array.boresight) > 0.0).all()
    distance = np.linalg.norm(points[:, None] - array.antennas[:, :, None], axis=-1)
    sent = distance[:, 0] if transmit == "single" else distance.mean(axis=1)
    np.testing.assert_allclose(
        0.5 * sent + 0.5 * distance.mean(axis=1), np.broadcast_to(ranges, sent.shape), atol=1e-10
    )


@pytest.mark.parametrize("baseline", [0.05, 1.8])
def test_the_phase_of_a_flat_sea_is_the_triangles(baseline: float) -> None:
    radar = radar_of(baseline_m=baseline, range_m=(20.0, 3000.0), range_sampling_m=100.0)
    volts = voltages(echoes(analytic.FlatSea(), radar))
    # The gate's ground range from its mean half path r = R₁ + ΔR/2, then ΔR of that place.
    ranges, low = gates(radar), 5.0 - 0.5 * baseline
    ground = np.sqrt(ranges**2 - 25.0)
    for _ in range(30):
        difference = analytic.range_difference(ground, 0.0, baseline, low)
        ground = np.sqrt((ranges - 0.5 * difference) ** 2 - low**2)
    phase = np.angle(volts[:, 0] * volts[:, 1].conj() * turned(analytic.range_difference(ground, 0.0, baseline, low)))
    assert np.abs(phase).max() < 3e-7  # complex64, twice


@pytest.mark.parametrize("mode", MODES)
def test_voltages_turn_by_their_whole_path(mode: tuple[str, str]) -> None:
    radar = radar_of(transmit=mode[0], interferogram=mode[1], tilt_deg=-3.0)
    attitude = (8.0, 3.0, 20.0)
    made = echoes(WAVE, radar, attitude_deg=attitude, position_m=(3.0, -4.0, 0.5))
    scan = 30.0 + 360.0 * made["time"].values - 20.0
    offsets, count = np.array(((0.0, 0.0, -0.1), (0.0, 0.0, 0.1))), scan.size
    array = Array.standing(np.tile(attitude, (count, 1)), scan, -3.0, np.tile((3.0, -4.0, 5.5), (count, 1)), offsets)
    points = array.fan_meets(WAVE, gates(radar), gate_weights(radar))
    distance = np.linalg.norm(points[:, None] - made["position"].values[:, :, None], axis=-1)
    sent = distance[np.arange(count), made["transmitter"].values]
    error = voltages(made) - turned(sent[:, None] + distance)
    assert np.nanmax(np.abs(error)) < 2e-7  # complex64


def test_what_recedes_turns_back() -> None:
    radar = radar_of()
    still, away = (voltages(echoes(WAVE, radar, radial_velocity_m_s=v)) for v in (0.0, 2.0))
    time = np.arange(still.shape[0])[:, None, None] / radar.prf_hz
    np.testing.assert_allclose(away, still * turned(2.0 * 2.0 * time), atol=3e-7)


def test_above_the_water_nothing_is_heard() -> None:
    radar = radar_of(range_m=(4.0, 10.0), range_sampling_m=0.5)
    volts = voltages(echoes(analytic.FlatSea(), radar))
    assert (volts[:, :, gates(radar) < 5.0] == 0.0).all()
    np.testing.assert_allclose(np.abs(volts[:, :, gates(radar) > 5.0]), 1.0, atol=1e-6)


def test_channels_and_listed_antennas() -> None:
    listed = [
        PlacedAntenna(offset_m=(0.0, 0.0, -0.1)),
        PlacedAntenna(offset_m=(0.2, 0.0, 0.3), role="rx", channel_gain_db=6.0, channel_phase_deg=30.0),
        PlacedAntenna(offset_m=(0.0, 0.1, 0.9)),
    ]
    plain = echoes(WAVE, radar_of(antennas=[each.model_copy(update={"channel_gain_db": 0.0}) for each in listed]))
    uneven = echoes(WAVE, radar_of(antennas=listed))
    assert uneven.sizes["receiver"] == 3
    assert uneven.attrs["receiver_antennas"] == [0, 1, 2]
    np.testing.assert_allclose(voltages(uneven)[:, 1], 10.0**0.3 * voltages(plain)[:, 1], rtol=1e-6)


def test_slopes_are_the_heights_gradient_and_the_wave_comes_from_where_it_says() -> None:
    x, y = np.random.default_rng(4).uniform(-100.0, 100.0, (2, 100))
    step = 1e-4  # differences err by step²k³a/6 and by ulp/step: 1e-11 at either end
    for sea in (analytic.TiltedSea(0.1, 0.2, 1.0), WAVE):
        east = (sea.height(x + step, y) - sea.height(x - step, y)) / (2.0 * step)
        north = (sea.height(x, y + step) - sea.height(x, y - step)) / (2.0 * step)
        np.testing.assert_allclose(sea.slopes(x, y), (east, north), atol=1e-9)
    from_east = analytic.SinusoidSea(1.0, 20.0, 90.0, 30.0)
    np.testing.assert_allclose(from_east.height(x, y), from_east.height(x, 0.0 * y), atol=1e-12)
    # It runs west: a later phase, further on.
    assert from_east.height(np.array(-1.0), np.array(0.0)) < from_east.height(np.array(1.0), np.array(0.0))


# ---------------------------------------------------------------------------------------------- speckle and noise


def test_speckle_has_its_coherence_and_its_looks() -> None:
    radar = radar_of(sector_deg=(0.0, 180.0), range_sampling_m=0.5)
    asked = np.where(gates(radar) < 50.0, 0.6, 0.95)
    made = echoes(analytic.FlatSea(), radar, coherence=asked, looks=5.0)
    plain = voltages(echoes(analytic.FlatSea(), radar))
    speckle = voltages(made) / plain
    dwells = speckle.reshape(100, 5, 10, 2, -1)
    assert np.abs(dwells - dwells[:, :, :1]).max() < 1e-5  # as it is for a fifth of the beam
    new = dwells[:, :, 0].reshape(500, 2, -1)
    lower, upper = new[:, 0], new[:, 1]
    for near in (True, False):
        gate = (gates(radar) < 50.0) == near
        count, gamma = 500 * gate.sum(), 0.6 if near else 0.95
        cross = np.mean(lower[:, gate] * upper[:, gate].conj())
        assert abs(cross - gamma) < 4.0 / np.sqrt(count)
        for each in (lower, upper):
            assert abs(np.mean(np.abs(each[:, gate]) ** 2) - 1.0) < 4.0 / np.sqrt(count)
    # Independent from block to block, from gate to gate, and circular; 4 standard errors of a mean of unit numbers.
    for alien in (lower[1:] * lower[:-1].conj(), lower[:, 1:] * lower[:, :-1].conj(), lower * lower, lower * upper):
        assert abs(np.mean(alien)) < 4.0 * np.sqrt(2.0 / alien.size)


def test_noise_is_new_in_every_pulse_and_of_the_power_it_says() -> None:
    radar = radar_of(sector_deg=(0.0, 90.0))
    snr = np.linspace(-10.0, 20.0, gates(radar).size)
    noisy = echoes(analytic.FlatSea(), radar, snr_db=snr)
    echo = voltages(echoes(analytic.FlatSea(), radar)) * 10.0 ** (snr / 20.0)
    noise = voltages(noisy) - echo
    assert noisy.attrs["noise_power_w"] == 1.0
    assert abs(np.mean(np.abs(noise) ** 2) - 1.0) < 4.0 / np.sqrt(noise.size)
    for alien in (noise[1:] * noise[:-1].conj(), noise[:, 0] * noise[:, 1].conj(), noise * echo.conj() / np.abs(echo)):
        assert abs(np.mean(alien)) < 4.0 / np.sqrt(alien.size)
    assert echoes(analytic.FlatSea(), radar).attrs["noise_power_w"] == 0.0


def test_a_seed_is_kept() -> None:
    for sea, coherence in ((WAVE, 0.9), (analytic.PointSea(WAVE), None)):
        first, again, other = (
            voltages(echoes(sea, radar_of(), coherence=coherence, snr_db=10.0, seed=seed)) for seed in (7, 7, 8)
        )
        np.testing.assert_array_equal(first, again)
        assert np.abs(first - other).mean() > 1.0


def test_turns_have_speckle_of_their_own() -> None:
    made = echoes(analytic.FlatSea(), radar_of(), coherence=1.0, turns=2)
    one, two = (voltages(made)[made["turn"].values == turn] for turn in (0, 1))
    assert one.shape == two.shape
    assert np.abs(one - two).mean() > 0.5


# ------------------------------------------------------------------------------------------------- random points


def test_random_points_echo_through_beam_and_waveform() -> None:
    radar = radar_of(sector_deg=(0.0, 72.0), range_m=(30.0, 180.0), range_sampling_m=1.5, prf_hz=2500.0)
    made = echoes(analytic.PointSea(), radar)
    volts = voltages(made)[:, 0]
    power = np.abs(volts) ** 2
    # 100 gates of 3 m length by 40 looks: some 1500 independent powers, whose mean errs by 1/√1500 = 0.026.
    assert abs(power.mean() - 1.0) < 0.1
    # ⟨P²⟩ = 2 ⟨P⟩² of circular Gaussian numbers; their square scatters by √20 of itself.
    assert abs(np.mean(power**2) / power.mean() ** 2 - 2.0) < 4.0 * np.sqrt(20.0 / 1500.0)
    # Gates 6 m apart share no point but by the skirts of the pulse (±5.1 m); looks two beams apart none.
    apart = volts[:, 4:] * volts[:, :-4].conj()
    assert abs(np.mean(apart)) < 0.1
    assert np.abs(np.mean(volts[:, 1:] * volts[:, :-1].conj())) > 0.5  # 1.5 m apart they share most


def test_a_flat_sea_of_points_is_flat() -> None:
    radar = radar_of(sector_deg=(0.0, 90.0), range_m=(50.0, 140.0), range_sampling_m=1.5, prf_hz=2500.0)
    maps = retrieve(
        echoes(analytic.PointSea(analytic.TiltedSea(0.0, 0.0, 0.2)), radar),
        RetrievalSettings(estimator="single_cell", ground_m=100.0),
    )
    error = maps["polar"].to_dataset()["height"].values - 0.2
    # Cells scatter by some 0.05 m; a quarter of 3000 are independent.
    assert abs(np.median(error)) < 0.015
    assert 0.005 < 1.4826 * np.median(np.abs(error)) < 0.1


# ------------------------------------------------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"turns": 0}, "turns = 0: must be"),
        ({"coherence": 1.2}, r"coherence = 1\.2: must be"),
        ({"coherence": 0.9, "looks": 0.0}, r"looks = 0\.0: must be"),
        ({"radar": radar_of(scan="staring")}, r"radar\.scan = 'staring': must be"),
        ({"sea": analytic.PointSea(), "coherence": 0.9}, r"coherence = 0\.9: must be None"),
    ],
)
def test_what_cannot_be_made_is_refused(asked: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        echoes(**{"sea": analytic.FlatSea(), "radar": radar_of(), **asked})


def test_seas_refuse_what_they_cannot_be() -> None:
    with pytest.raises(ValueError, match="wavelength_m = 0"):
        analytic.SinusoidSea(1.0, 0.0)
    with pytest.raises(ValueError, match="per_cell = 0"):
        analytic.PointSea(per_cell=0.0)
