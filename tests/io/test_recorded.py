"""Recordings: whatever a recorder's conventions, the same sea comes out; and one line for whatever is wrong."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.sparse
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT, wrap_degrees
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.errors import InputError
from seamap_rt.interferometry import retrieve
from seamap_rt.interferometry.recorded import echoes_from_recording, open_recording
from seamap_rt.io.recorded import read_matlab
from seamap_rt.radar.installation import Installation
from seamap_rt.settings import PlatformSettings, RadarSettings, RetrievalSettings

Array = NDArray[np.float64]
RPM, PRF, HEIGHT, BASELINE = 60.0, 1000.0, 5.0, 0.2
GATES = 30.0 + 1.5 * np.arange(24)
K = 2.0 * np.pi * 10e9 / SPEED_OF_LIGHT
HEADER = {
    "frequency_hz": 10e9,
    "pulse_width_s": 20e-9,
    "bandwidth_hz": 50e6,
    "height_m": HEIGHT,
    "baseline_m": BASELINE,
    "azimuth_beamwidth_deg": 1.8,
    "elevation_beamwidth_deg": 18.0,
    "first_gate_m": 30.0,
    "gate_m": 1.5,
    "noise_power_w": 0.0,
}
SLIM = RetrievalSettings(estimator="single_cell", cell_range_m=1.5, cell_azimuth_deg=3.6, ground_m=20.0)
# Phases of complex64 are good to 6e-8 rad, heights are 1.6 m/rad at most: λR/(2πB).
FLAT = 1e-6  # m
COUNTS_FULL = 1000  # of I or Q: rounding turns a phase by 0.5e-3 rad at most, the height by 2 mm with both receivers
COARSE = 2e-3


def clock(turns: float = 1.0, start: float = 0.0) -> tuple[Array, Array]:
    """Times [s] and azimuths [deg]."""
    time = np.arange(round(turns * PRF * 60.0 / RPM)) / PRF
    return time, (start + 6.0 * RPM * time) % 360.0


def flat_sea(pulses: int) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Voltages (pulse, gate) of the point of mean sea level in each gate, the lower antenna sending: half the mean
    path is the gate's range, R₀ + (R₁ − R₀)/4."""
    ground, lower, upper = GATES, GATES, GATES
    for _ in range(30):
        ground = ground + GATES - lower - 0.25 * (upper - lower)
        lower, upper = (np.hypot(ground, HEIGHT + side * BASELINE / 2.0) for side in (-1.0, 1.0))
    rows = np.exp(2j * np.random.default_rng(1).uniform(0.0, np.pi, (pulses, 1)))
    return rows * np.exp(-1j * K * 2.0 * lower), rows * np.exp(-1j * K * (lower + upper))


def echoes(
    lower: Any = None,
    upper: Any = None,
    *,
    turns: float = 1.0,
    start: float = 0.0,
    head: dict | None = None,
    **arrays: Any,
) -> xr.Dataset:
    """Of a flat sea unless something else is given; None takes a key out of the header."""
    time, azimuth = clock(turns, start)
    sea = flat_sea(time.size)
    header = {key: value for key, value in {**HEADER, **(head or {})}.items() if value is not None}
    given = {"time": time, "azimuth": azimuth, **arrays}
    return echoes_from_recording(
        sea[0] if lower is None else lower, sea[1] if upper is None else upper, header, **given
    )


def heights(found: xr.Dataset) -> Array:
    return np.asarray(retrieve(found, SLIM)["polar"].to_dataset()["height"].values[0])


# ------------------------------------------------------------------------------------------------- conventions


def recorded_as_it_is() -> xr.Dataset:
    return echoes()


def recorded_with_the_other_sign() -> xr.Dataset:
    lower, upper = flat_sea(1000)
    return echoes(lower.conj(), upper.conj(), head={"conjugate": True})


def recorded_with_a_longer_cable_to_the_lower_antenna() -> xr.Dataset:
    lower, upper = flat_sea(1000)
    return echoes(lower * np.exp(1j * np.radians(50.0)), upper, head={"phase_offset_deg": 50.0})


def recorded_by_an_encoder_from_the_bow() -> xr.Dataset:
    counts = np.rint((70.0 - clock()[1]) / 0.36) % 1000
    head = {"heading_deg": 100.0, "azimuth_from": "bow", "encoder_zero_deg": -30.0, "encoder_clockwise": False}
    return echoes(azimuth=counts.astype(np.uint16), head={**head, "encoder_counts": 1000})


def recorded_with_long_cables() -> xr.Dataset:
    ranges = np.round(GATES + 12.3456, 3)  # as a list that is written to the millimetre
    return echoes(ranges=ranges, head={"first_gate_m": None, "gate_m": None, "range_offset_m": 12.346})


def recorded_with_gates_before_the_antenna() -> xr.Dataset:
    lower, upper = (np.concatenate((np.ones((1000, 25)), each), axis=1) for each in flat_sea(1000))
    return echoes(lower, upper, head={"first_gate_m": -7.5})


def recorded_on_a_pedestal() -> xr.Dataset:
    generator = np.random.default_rng(3)
    lower, upper = (
        np.concatenate((each, np.zeros((1000, 8))), axis=1) + 1e-9 * generator.standard_normal((1000, 32))
        for each in flat_sea(1000)
    )
    return echoes(lower + 0.3 - 0.1j, upper - 0.2j, head={"dc_offset": "remove"})


@pytest.mark.parametrize(
    "recorded",
    [
        recorded_as_it_is,
        recorded_with_the_other_sign,
        recorded_with_a_longer_cable_to_the_lower_antenna,
        recorded_by_an_encoder_from_the_bow,
        recorded_with_long_cables,
        recorded_with_gates_before_the_antenna,
        recorded_on_a_pedestal,
    ],
)
def test_the_sea_is_flat_in_whatever_convention_it_was_recorded(recorded: Callable[[], xr.Dataset]) -> None:
    found = recorded()
    height = heights(found.sel(range=GATES, method="nearest"))
    assert np.isfinite(height).all()
    assert np.abs(height).max() < FLAT


def test_with_the_wrong_sign_it_is_not() -> None:
    lower, upper = flat_sea(1000)
    assert np.abs(heights(echoes(lower.conj(), upper.conj()))).min() > 0.05
    assert np.abs(heights(echoes(upper, lower))).min() > 0.05


@pytest.mark.parametrize("kind", ["pairs", "records", "float pairs"])
def test_pairs_of_whole_numbers_are_voltages_within_their_rounding(kind: str) -> None:
    def written(voltage: NDArray[np.complex128]) -> NDArray:
        pairs = np.stack((voltage.real, voltage.imag), axis=-1) * COUNTS_FULL
        if kind == "float pairs":
            return pairs.astype(np.float32)
        pairs = np.rint(pairs).astype(np.int16)
        return pairs.view([("I", "<i2"), ("Q", "<i2")])[..., 0] if kind == "records" else pairs

    found = echoes(*(written(each) for each in flat_sea(1000)), head={"voltage_scale": 1.0 / COUNTS_FULL})
    assert np.abs(found["voltage"].values).max() == pytest.approx(1.0, abs=1.0 / COUNTS_FULL)
    assert np.abs(heights(found)).max() < COARSE
    assert "saturated" not in found


def test_a_converter_at_its_limit_is_known() -> None:
    lower, upper = (np.zeros((1000, 24, 2), dtype=np.int16) for _ in range(2))
    lower[5, 3, 1], upper[7, 2, 0] = -32768, 32767
    saturated = echoes(lower, upper)["saturated"].values
    assert set(zip(*np.nonzero(saturated), strict=True)) == {(5, 3), (7, 2)}
    lower[9, 9, 0] = 8191  # of a converter of 14 bits in words of 16
    assert echoes(lower, upper, head={"full_scale": 8191.0})["saturated"].values[9, 9] == 1


def test_what_is_not_finite_is_unknown_and_flags_go_with_their_pulses() -> None:
    lower, upper = flat_sea(1000)
    lower[3, 4], upper[5, 6] = np.inf, 1e60
    flags = np.zeros(1000, dtype=int)
    flags[8] = QUALITY_FLAGS["submerged"]
    found = echoes(lower, upper, quality=flags)
    assert np.isnan(found["voltage"].values[3, 0, 4])
    assert np.isnan(found["voltage"].values[5, 1, 6])
    assert np.flatnonzero(found["flag"].values).tolist() == [8]


def test_receivers_that_wait_write_zeros_and_each_antenna_hears_itself() -> None:
    waiting = np.arange(1000)[:, None] % 2
    head = {"transmit": "switched", "interferogram": "alternating_pulse"}
    found = echoes(*(each * (waiting == n) for n, each in enumerate(flat_sea(1000))), head=head)
    np.testing.assert_array_equal(found["transmitter"], waiting[:, 0])
    heard = np.isfinite(found["voltage"].values).all(axis=2)
    np.testing.assert_array_equal(heard, np.stack((waiting[:, 0] == 0, waiting[:, 0] == 1), axis=1))


# ------------------------------------------------------------------------------------------------------- noise


def test_the_noise_is_that_of_silent_pulses_or_of_the_darkest_far_cells() -> None:
    generator = np.random.default_rng(7)
    noise = (
        1e-3 * np.sqrt(0.5) * (generator.standard_normal((2, 1000, 24)) + 1j * generator.standard_normal((2, 1000, 24)))
    )
    silent = np.arange(1000) % 50 == 0
    sea = np.stack(flat_sea(1000)) * ~silent[:, None]
    sender = np.where(silent, -1, 0)
    unsaid = {"noise_power_w": None}
    found = echoes(*(sea + noise), transmitter=sender, head=unsaid)
    # 20 pulses of 24 gates and 2 receivers: 960 samples, 3.2 % rms; three times that.
    assert found.attrs["noise_power_w"] == pytest.approx(1e-6, rel=0.1)
    assert found.sizes["pulse"] == 980
    assert (found["transmitter"].values == 0).all()
    # Of 62 stretches of 6 far gates and 2 receivers the 2 % quantile is good to 4 %.
    assert echoes(*noise, head=unsaid).attrs["noise_power_w"] == pytest.approx(1e-6, rel=0.15)
    far = (
        np.concatenate((sea[:, :, :18], 0.1 * sea[:, :, 18:] * (np.arange(1000)[:, None] % 400 > 100)), axis=2) + noise
    )
    # A third of the stretches are dark, whose 6 % quantile is taken for the 2 % one of all: 15 % too much.
    assert echoes(*far, head=unsaid).attrs["noise_power_w"] == pytest.approx(1e-6, rel=0.4)
    assert echoes(*far, head={"noise_power_w": 2e-6}).attrs["noise_power_w"] == 2e-6


# ------------------------------------------------------------------------------------------------------- turns


def test_turns_are_found_from_where_the_recording_begins() -> None:
    found = echoes(turns=2.6, start=100.0, time=clock(2.6)[0] + 1.7e9)
    assert found.attrs["complete_turns"] == 2
    assert np.bincount(found["turn"].values).tolist() == [1000, 1000]
    assert found.attrs["sector_deg"] == [100.0, 460.0]
    # Times since 1970 are good to 2.4e-7 s.
    assert found["time"].values[0] == pytest.approx(0.0, abs=1e-6)
    assert found.attrs["time_zero_s"] == pytest.approx(1.7e9)
    assert found.attrs["rotation_rpm"] == pytest.approx(RPM, rel=1e-5)
    assert found.attrs["prf_hz"] == pytest.approx(PRF, rel=1e-3)
    np.testing.assert_array_equal(np.diff(found["pulse"]), 1)
    maps = retrieve(found, SLIM)["polar"].to_dataset()
    assert maps.sizes["turn"] == 2
    assert np.abs(maps["height"].values).max() < FLAT


def test_two_pulses_tell_how_fast_the_antenna_turns() -> None:
    time, azimuth = (each[:2] for each in clock())
    head = {"sector_deg": [0.0, 0.36], "partial_turns": "keep"}
    found = echoes(*flat_sea(2), time=time, azimuth=azimuth, head=head)
    assert found.attrs["rotation_rpm"] == pytest.approx(RPM, rel=1e-9)


def test_partial_turns_are_dropped_or_kept() -> None:
    dropped = echoes(turns=3.0, start=100.0, head={"sector_deg": [0.0, 360.0]})
    assert np.bincount(dropped["turn"].values).tolist() == [1000, 1000]
    assert dropped["azimuth"].values[0] == pytest.approx(0.0, abs=0.36)
    # Times count from where the first turn begins: 0.36° are a millisecond.
    assert dropped["time"].values[0] == pytest.approx(0.0, abs=1e-3)
    kept = echoes(turns=3.0, start=100.0, head={"sector_deg": [0.0, 360.0], "partial_turns": "keep"})
    assert kept.attrs["complete_turns"] == 4
    assert kept["time"].values[0] == pytest.approx(100.0 / 360.0, abs=1e-3)


def test_a_sector_is_a_turn_and_what_is_beside_it_belongs_to_the_nearer_one() -> None:
    time, azimuth = clock(2.5, start=200.0)
    inside = np.abs(wrap_degrees(azimuth - 270.0)) < 32.0
    sea = [each[inside] for each in flat_sea(time.size)]
    found = echoes(*sea, time=time[inside], azimuth=azimuth[inside], head={"sector_deg": [240.0, 300.0]})
    assert found.attrs["complete_turns"] == 3
    assert np.bincount(found["turn"].values).tolist() == [np.count_nonzero(inside) // 3] * 3
    assert np.abs(heights(found)).max() < FLAT


def test_missing_pulses_and_unknown_azimuths_break_no_turn() -> None:
    generator = np.random.default_rng(2)
    time, azimuth = clock(3.0)
    kept = generator.random(time.size) > 0.2
    kept[[0, -1]] = True
    kept[1300:1700] = False  # 144° of the second turn
    azimuth = np.where(generator.random(time.size) > 0.1, azimuth, np.nan)
    sea = [each[kept] for each in flat_sea(time.size)]
    found = echoes(*sea, time=time[kept], azimuth=azimuth[kept], head={"prf_hz": PRF})
    assert found.attrs["complete_turns"] == 3
    np.testing.assert_array_equal(found["turn"], found["pulse"].values // 1000)
    assert np.isfinite(found["azimuth"].values).all()


def test_turns_that_are_given_are_taken() -> None:
    found = echoes(turns=2.0, turn=np.repeat([7, 9], 1000))
    assert np.bincount(found["turn"].values).tolist() == [1000, 0, 1000]


# ----------------------------------------------------------------------------------------------------- attitude


def test_antennas_stand_where_the_mast_has_them() -> None:
    """Against the simulator's own mast: sensors of its motion, and an encoder that counts from the bow."""
    radar = RadarSettings(prf_hz=PRF, height_m=HEIGHT, baseline_m=BASELINE, tilt_deg=7.0)
    boat = {
        "motion": "sinusoidal",
        "roll_deg": 8.0,
        "pitch_deg": 5.0,
        "yaw_deg": 3.0,
        "heave_m": 0.4,
        "heading_deg": 350.0,
    }
    mast = Installation(
        radar, PlatformSettings.model_validate({**boat, "lever_arm_m": [0.7, -1.2, 3.5], "yaw_phase_deg": 0.0})
    )
    time, _ = clock(1.5)
    pose, motion = mast.pose(time), mast.motion(time)
    scan = mast.schedule(time) - mast.heading
    head = {"azimuth_from": "bow", "tilt_deg": 7.0, "lever_arm_m": [0.7, -1.2, 3.5], "sector_deg": [0.0, 360.0]}
    utm = np.add(motion.position, (350_000.0, 5_600_000.0, 0.0))
    found = echoes(
        turns=1.5, azimuth=scan, attitude=motion.attitude, position=utm, head=head | {"partial_turns": "keep"}
    )
    # Rounding of a northing of 5.6e6 m: 1e-9.
    np.testing.assert_allclose(found["position"], pose.positions, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(wrap_degrees(found["azimuth"] - pose.bearing), 0.0, atol=1e-9)
    given = echoes(turns=1.5, position=pose.positions, head={"partial_turns": "keep"})
    np.testing.assert_array_equal(given["position"], pose.positions)


def test_slower_sensors_are_drawn_straight_and_through_north() -> None:
    time, _ = clock()
    moments = np.arange(-0.05, 1.2, 0.1)
    attitude = np.stack((3.0 * moments, -2.0 * moments, (355.0 + 20.0 * moments) % 360.0), axis=1)
    way = np.stack((5.0 * moments, 2.0 * moments, 0.1 * moments), axis=1)
    found = echoes(attitude=(moments, attitude), position=(moments, way))
    expected = np.stack((3.0 * time, -2.0 * time, 355.0 + 20.0 * time), axis=1)
    np.testing.assert_allclose(wrap_degrees(found["attitude"] - expected), 0.0, atol=1e-9)
    moved = np.diff(found["position"].values.mean(axis=1)[:, :2], axis=0) * PRF
    # The mast leans with the boat: 5 m high, some 3°/s, which is 0.3 m/s.
    np.testing.assert_allclose(moved, np.broadcast_to((5.0, 2.0), moved.shape), atol=0.35)
    attitude[5] = np.nan  # read at 0.45 s: what lies between its neighbours is not known
    unknown = np.isnan(echoes(attitude=(moments, attitude))["attitude"].values).any(axis=1)
    np.testing.assert_array_equal(unknown, (time > 0.35) & (time < 0.55))


# ------------------------------------------------------------------------------------------------------ refusals


def refusal(call: Callable[[], object]) -> str:
    with pytest.raises(InputError) as caught:
        call()
    line = str(caught.value)
    assert "\n" not in line
    return line


def jumping(by: float) -> Array:
    azimuth = clock()[1].copy()
    azimuth[500:] += by
    return azimuth % 360.0


TIME, AZIMUTH = clock()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"upper": np.ones((999, 24), complex)}, "upper: has the shape (999, 24)"),
        ({"lower": np.ones((1000, 24)), "upper": np.ones((1000, 24))}, "lower: has the shape (1000, 24)"),
        ({"lower": np.ones((0, 24), complex), "upper": np.ones((0, 24), complex)}, "must hold a pulse"),
        ({"time": TIME[:-1]}, "time: has the shape (999,)"),
        ({"time": np.where(TIME == 0.5, 0.4, TIME)}, "time[500] = 0.4"),
        ({"time": np.where(TIME == 0.5, np.nan, TIME)}, "time[500] = nan"),
        ({"azimuth": jumping(-90.0)}, "azimuth: jumps by -89.64°"),
        ({"azimuth": jumping(90.0)}, "azimuth: jumps by 90.36°"),
        ({"azimuth": np.radians(AZIMUTH)}, "give degrees, if these are radians"),
        ({"azimuth": -AZIMUTH}, "azimuth: turns at -360 deg/s"),
        ({"azimuth": np.full(1000, np.nan)}, "azimuth: no pulse"),
        ({"azimuth": AZIMUTH / 6.0}, "sector_deg: is missing"),
        ({"azimuth": AZIMUTH / 6.0, "head": {"sector_deg": [0.0, 90.0]}}, "azimuth: no turn covers"),
        ({"head": {"rotation_rpm": 24.0}}, "rotation_rpm = 24"),
        ({"head": {"prf_hz": 1200.0}}, "prf_hz = 1200"),
        ({"head": {"first_gate_m": None}}, "first_gate_m"),
        ({"head": {"first_gate_m": None, "gate_m": None}}, "ranges: are missing"),
        ({"ranges": GATES**1.01}, "ranges["),
        ({"ranges": GATES[::-1]}, "ranges[1] = 63"),
        ({"head": {"range_offset_m": 900.0}}, "range_offset_m = 900"),
        ({"attitude": np.zeros((1000, 2))}, "attitude: has the shape (1000, 2)"),
        ({"attitude": (TIME + 5.0, np.zeros((1000, 3)))}, "attitude_time: runs from 5"),
        ({"attitude": (TIME[::-1], np.zeros((1000, 3)))}, "attitude_time[1] = 0.998"),
        ({"transmitter": np.full(1000, 2)}, "transmitter = 2"),
        ({"head": {"transmit": "switched"}}, "transmitter: is missing"),
        ({"turn": np.r_[np.ones(500), np.zeros(500)]}, "turn: must be"),
        ({"head": {"frequncy_hz": 1.0}}, "did you mean frequency_hz?"),
        ({"head": {"frequency_hz": None}}, "frequency_hz: is missing"),
        ({"head": {"height_m": float("nan")}}, "height_m = nan"),
        ({"head": {"sector_deg": [90.0, 0.0]}}, "sector_deg"),
        ({"head": {"azimuth_from": "stern"}}, "azimuth_from"),
        (
            {"head": {"frequency_hz": 9.41}},
            "frequency_hz = 9.41: must be at least 1e+08 (a carrier); did you mean 9.41e9 (Hz)?",
        ),
        ({"head": {"frequency_hz": 9410.0}}, "did you mean 9.41e9 (Hz)?"),
        ({"head": {"pulse_width_s": 20}}, "did you mean 2e-5 or 2e-8 (s)?"),
        ({"head": {"bandwidth_hz": 50.0}}, "5e7 or 50000 (Hz)?"),
        ({"head": {"chirp_bandwidth_hz": 50.0}}, "must be at least 10000 with waveform = 'chirp'"),
        (
            {"head": {"prf_hz": 1.0}},
            "prf_hz = 1.0: must be at least 5 (pulses per second); did you mean 1e6 or 1000 (Hz)?",
        ),
    ],
)
def test_one_line_says_what_is_wrong(given: dict[str, Any], said: str) -> None:
    assert said in refusal(lambda: echoes(**given))


# --------------------------------------------------------------------------------------------------------- files


def arrays() -> dict[str, NDArray]:
    lower, upper = flat_sea(1000)
    moments = np.arange(0.0, 1.1, 0.1)
    slow = {"attitude": np.zeros((moments.size, 3)), "attitude_time": moments}
    return {
        "lower": lower.astype(np.complex64),
        "upper": upper.astype(np.complex64),
        "time": TIME,
        "azimuth": AZIMUTH,
    } | slow


def test_an_npz_with_its_header_within_or_beside_it(tmp_path: Path) -> None:
    np.savez(tmp_path / "within.npz", allow_pickle=False, header=np.array(json.dumps(HEADER)), **arrays())
    assert np.abs(heights(open_recording(tmp_path / "within.npz"))).max() < FLAT
    np.savez(tmp_path / "beside.npz", allow_pickle=False, **arrays())
    assert "has no header" in refusal(lambda: open_recording(tmp_path / "beside.npz"))
    (tmp_path / "beside.toml").write_text("".join(f"{key} = {value}\n" for key, value in HEADER.items()))
    found = open_recording(tmp_path / "beside.npz")
    xr.testing.assert_identical(found, open_recording(tmp_path / "within.npz"))
    (tmp_path / "other.json").write_text(json.dumps(HEADER | {"conjugate": True}))
    assert np.abs(heights(open_recording(tmp_path / "beside.npz", tmp_path / "other.json"))).min() > 0.05


def in_matlab_73(path: Path, tree: dict[str, Any]) -> None:
    """As MATLAB writes version 7.3: dimensions from the other end, complex numbers as records, texts as their codes."""

    def put(group: h5py.Group, name: str, value: Any) -> None:
        if isinstance(value, dict):
            node = group.create_group(name)
            for field, part in value.items():
                put(node, field, part)
            kind = "struct"
        elif isinstance(value, str):
            node = group.create_dataset(name, data=np.array([[ord(each)] for each in value], dtype=np.uint16))
            kind = "char"
        else:
            array = np.atleast_2d(np.asarray(value))
            kind = {"b": "logical", "c": "double"}.get(array.dtype.kind, "double")
            if array.dtype.kind == "c":
                record = np.empty(array.shape, dtype=[("real", "f8"), ("imag", "f8")])
                record["real"], record["imag"] = np.real(array), np.imag(array)
                array = record
            node = group.create_dataset(name, data=array.astype(np.uint8).T if kind == "logical" else array.T)
        node.attrs["MATLAB_class"] = np.bytes_(kind)

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in tree.items():
            put(file, name, value)


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_matlab_files_of_both_kinds_hold_the_same(tmp_path: Path, version: str) -> None:
    path, (lower, upper) = tmp_path / "night.mat", flat_sea(1000)
    header = HEADER | {"conjugate": True, "encoder_counts": 1000.0, "polarization": "HH", "sector_deg": [0.0, 360.0]}
    counts = np.round(clock()[1] / 0.36)
    tree = {"rx": {"lower": lower.conj(), "upper": upper.conj()}, "time": TIME, "azimuth": counts, "header": header}
    if version == "5":
        scipy.io.savemat(path, tree)
    else:
        in_matlab_73(path, tree)
    assert "'upper'" in refusal(lambda: open_recording(path, names={"lower": "rx/lower"}))
    found = open_recording(path, names={"lower": "rx/lower", "upper": "rx/upper"})
    assert found.attrs["polarization"] == "HH"
    assert np.abs(heights(found)).max() < FLAT


def test_a_damaged_matlab_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "night.mat"
    path.write_bytes(b"MATLAB 5.0 MAT-file" + bytes(200))
    assert "cannot be read" in refusal(lambda: open_recording(path))


_READ_DAMAGED = """
import sys
from pathlib import Path
from seamap_rt.io.recorded import read_matlab
path = Path(sys.argv[1])
content, refused = path.read_bytes(), 0
for place in range(126, len(content)):
    for value in (0, 5, 9, 127):
        path.write_bytes(content[:place] + bytes([value]) + content[place + 1 :])
        try:
            read_matlab(path, ("lower", "rx", "text"), lambda *_: None)
        except Exception:
            refused += 1
print(refused)
"""


def test_no_damage_of_a_matlab_file_ends_the_process(tmp_path: Path) -> None:
    """Each byte behind the header, set to what is another type, class, flag or size."""
    path = tmp_path / "night.mat"
    lower, struct = np.ones((2, 3), np.complex64), {"gate": np.arange(3.0), "of": {"note": "x"}}
    scipy.io.savemat(path, {"lower": lower, "rx": struct, "text": "words", "few": np.arange(2, dtype=np.int16)})
    done = subprocess.run([sys.executable, "-c", _READ_DAMAGED, str(path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    assert int(done.stdout) > 500


@pytest.mark.parametrize("packed", [False, True])
def test_what_matlab_files_may_hold_is_read(packed: bool, tmp_path: Path) -> None:
    """All kinds of variables beside the arrays; numbers of any type, none, and one."""
    path = tmp_path / "night.mat"
    kept = {
        "one": np.uint8(3),
        "none": np.zeros((0, 3)),
        "short": np.arange(2, dtype=np.int16),
        "yes": np.array([True]),
    }
    kept |= {"lower": np.ones((200, 300), np.complex64), "text": "äöü"}
    others = {
        "cell": np.array([1, "a"], dtype=object),
        "sparse": scipy.sparse.csc_matrix(np.eye(3)),
        "rx": {"a": {"b": 1.0}},
    }
    scipy.io.savemat(path, kept | others, do_compression=packed)
    _, found = read_matlab(path, kept, lambda *_: np.zeros(0))
    assert found.pop("text") == kept.pop("text")
    for name, values in kept.items():
        np.testing.assert_array_equal(np.squeeze(found[name]), np.squeeze(values))


@pytest.mark.parametrize("layout", ["complex", "parts", "pairs"])
def test_an_hdf5_of_its_own_layout(tmp_path: Path, layout: str) -> None:
    path = tmp_path / "own.h5"
    with h5py.File(path, "w") as file:
        for name, values in arrays().items():
            if layout == "complex" or not np.iscomplexobj(values):
                file[f"raw/{name}"] = values
            elif layout == "parts":
                file[f"raw/{name}/Real"], file[f"raw/{name}/Imag"] = np.real(values), np.imag(values)
            else:
                file[f"raw/{name}"] = np.stack((np.real(values), np.imag(values)), axis=-1)
        file.create_group("header").attrs.update(HEADER)
    found = open_recording(path, names={name: f"raw/{name}" for name in arrays()})
    assert np.abs(heights(found)).max() < FLAT


def test_one_line_says_what_is_wrong_with_a_file(tmp_path: Path) -> None:
    path = tmp_path / "some.npz"
    assert "no such file" in refusal(lambda: open_recording(path))
    path.write_bytes(b"PK\x03\x04 not whole")
    assert "cannot be read" in refusal(lambda: open_recording(path, HEADER))
    assert "must be a file of the kinds" in refusal(lambda: open_recording(tmp_path / "some.dat"))
    given = arrays()
    np.savez(path, allow_pickle=False, **{name: given[name] for name in ("lower", "time", "azimuth")})
    assert "holds no 'upper'" in refusal(lambda: open_recording(path, HEADER))
    assert "'uper' is no array" in refusal(lambda: open_recording(path, HEADER, names={"uper": "x"}))
    np.savez(path, allow_pickle=False, transmiter=np.zeros(1000), **given)
    assert "did you mean transmitter?" in refusal(lambda: open_recording(path, HEADER))
    np.savez(path, allow_pickle=False, position_time=TIME, **given)
    assert "'position_time' stands alone" in refusal(lambda: open_recording(path, HEADER))
    (tmp_path / "some.json").write_text("[1, 2]")
    assert "is a list" in refusal(lambda: open_recording(path, tmp_path / "some.json"))
    (tmp_path / "text.h5").write_text("not HDF5")
    assert "cannot be read" in refusal(lambda: open_recording(tmp_path / "text.h5", HEADER))
