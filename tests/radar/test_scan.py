"""Pulses of a turn: their times, bearings and places in the mode's cycle, over turns, sectors and a moving boat."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from seamap_rt.conventions import wrap_degrees
from seamap_rt.radar.array import antenna_array
from seamap_rt.radar.grid import look_sweeps
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses, scanned_share, sector_width
from seamap_rt.settings import PlatformSettings, RadarSettings

ROLLING = PlatformSettings(
    motion="sinusoidal", roll_deg=12.0, pitch_deg=5.0, yaw_deg=6.0, heave_m=0.5, speed_m_s=4.0, heading_deg=70.0
)
MODES = [(t, i) for t in ("single", "switched") for i in ("single_pulse", "alternating_pulse")]


def radar_of(**keys: Any) -> RadarSettings:
    return RadarSettings.model_validate(keys)


@pytest.mark.parametrize("platform", [PlatformSettings(), ROLLING])
@pytest.mark.parametrize(("rpm", "prf"), [(60.0, 1000.0), (47.0, 1234.5), (60.0, 999.7)])
def test_full_turns_hold_every_pulse_once(rpm: float, prf: float, platform: PlatformSettings) -> None:
    """Pulse n is fired at n/prf, whatever turn it falls into, and however the boat swings."""
    radar = radar_of(rotation_rpm=rpm, prf_hz=prf)
    mast = Installation(radar, platform)
    turns = [pulses(mast, turn) for turn in range(5)]
    number = np.concatenate([fired.number for fired in turns])
    assert_array_equal(number, np.arange(number.size))
    assert_array_equal(np.concatenate([fired.time for fired in turns]), number / prf)
    for turn, fired in enumerate(turns):
        # The ceiling that finds the first pulse forgives 1e-9 of a pulse.
        assert fired.time[0] >= turn * mast.period - 1e-9 / prf
        assert fired.time[-1] < (turn + 1) * mast.period


@pytest.mark.parametrize("turn", [0, 3])
def test_a_sectors_pulses_are_those_within_it(turn: int) -> None:
    radar = radar_of(sector_deg=[200.0, 260.0], prf_hz=2000.0, rotation_rpm=48.0)
    fired = pulses(Installation(radar), turn)
    assert sector_width(radar) == 60.0
    assert scanned_share(radar) == pytest.approx(1.0 / 6.0, rel=1e-15)
    step = 360.0 * 0.8 / 2000.0  # deg a pulse
    assert 0.0 <= fired.sweep[0] < step
    assert 60.0 - step <= fired.sweep[-1] < 60.0
    assert_allclose(np.diff(fired.sweep), step, rtol=1e-9)
    # Bit by bit the schedule of a boat at rest.
    assert_array_equal(fired.sweep, (fired.time - turn * 1.25) * Installation(radar).rate)
    assert_array_equal(fired.azimuth, (200.0 + fired.sweep) % 360.0)


def test_the_azimuth_is_where_the_boresight_of_a_moving_boat_bears() -> None:
    radar = radar_of(sector_deg=[-50.0, 300.0], prf_hz=1000.0, tilt_deg=8.0)
    mast = Installation(radar, ROLLING)
    for turn in (0, 4):
        fired = pulses(mast, turn)
        assert_allclose(wrap_degrees(fired.azimuth - fired.pose.bearing), 0.0, rtol=0.0, atol=1e-10)
        assert np.all((fired.azimuth >= 0.0) & (fired.azimuth < 360.0))
        assert_allclose(wrap_degrees(-50.0 + fired.sweep - fired.azimuth), 0.0, rtol=0.0, atol=1e-10)
        assert np.abs(fired.sweep - (fired.time - turn) * 360.0).max() > 1.0  # the boat does swing it
        assert np.ptp(fired.sweep) > 340.0  # and it never wraps
        assert_array_equal(fired.pose.time, fired.time)


@pytest.mark.parametrize(("transmit", "interferogram"), MODES)
@pytest.mark.parametrize("prf", [1001.0, 1000.0])
def test_the_cycle_goes_on_over_turns(transmit: str, interferogram: str, prf: float) -> None:
    """Also where a turn holds an odd number of pulses."""
    radar = radar_of(transmit=transmit, interferogram=interferogram, prf_hz=prf)
    cycle = antenna_array(radar).cycle
    turns = [pulses(Installation(radar), turn) for turn in range(3)]
    number, slot, transmitter = (
        np.concatenate([getattr(fired, name) for fired in turns]) for name in ("number", "slot", "transmitter")
    )
    assert_array_equal(slot, number % len(cycle))
    assert_array_equal(transmitter, [cycle[each].transmitter for each in slot])
    assert set(transmitter) == ({0, 1} if transmit == "switched" else {0})


def test_four_antennas_take_their_turns() -> None:
    antennas = [{"offset_m": [0.0, 0.0, 0.1 * n], "role": role} for n, role in enumerate(("tx", "both", "rx", "both"))]
    fired = pulses(Installation(radar_of(antennas=antennas, prf_hz=500.0)), 0)
    assert_array_equal(fired.transmitter[:7], (0, 1, 3, 0, 1, 3, 0))


def test_a_staring_antenna_fires_all_the_time_into_one_direction() -> None:
    radar = radar_of(scan="staring", stare_s=0.04, sector_deg=[40.0, 70.0], prf_hz=2500.0)
    assert scanned_share(radar) == 1.0
    turns = [pulses(Installation(radar), turn) for turn in range(3)]
    assert_array_equal(np.concatenate([fired.number for fired in turns]), np.arange(300))
    for fired in turns:
        assert_array_equal(fired.sweep, 15.0)
        assert_array_equal(fired.azimuth, 55.0)
    rolling = pulses(Installation(radar, ROLLING), 0)
    assert_allclose(rolling.azimuth, rolling.pose.bearing, rtol=0.0, atol=1e-10)


def test_looks_are_whole_cells_of_the_sector() -> None:
    assert_allclose(look_sweeps((200.0, 260.0), 1.8), 0.9 + 1.8 * np.arange(33), rtol=1e-14)
    assert_allclose(look_sweeps((10.0, 370.0), 1.8), 0.9 + 1.8 * np.arange(200), rtol=1e-14)
    assert look_sweeps((0.0, 360.0), 1.7).size == 212  # the circle closes: cells of 1.698°
    assert_allclose(look_sweeps((10.0, 50.0), 1.8, staring=True), [20.0], rtol=1e-15)
