"""When and where the radar looks: pulses of a turn, and the looks into which they are gathered.

Pulse n is fired at n/prf. The boresight turns clockwise at a constant rate and points to sector_deg[0] at the start of
each turn; outside the sector nothing is sent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..conventions import unit_from_azimuth
from ..settings import RadarSettings

# Beam widths to either side that an antenna hears; so far beyond the sector the sea is meshed.
BEAMS_BEYOND = 3.0


@dataclass(frozen=True)
class Pulses:
    """The pulses of one turn; all arrays (pulse,)."""

    number: NDArray[np.int64]
    time: NDArray[np.float64]  # s
    sweep: NDArray[np.float64]  # deg, angle turned since the start of the sector: never wraps
    azimuth: NDArray[np.float64]  # deg in [0, 360)
    transmitter: NDArray[np.int8]


def turn_duration(radar: RadarSettings) -> float:
    """Seconds that one turn of the antenna lasts."""
    return 60.0 / radar.rotation_rpm


def sector_width(radar: RadarSettings) -> float:
    """Width of the sector in degrees."""
    return radar.sector_deg[1] - radar.sector_deg[0]


def pulses(radar: RadarSettings, turn: int) -> Pulses:
    """The pulses of turn `turn` (0, 1, …) that fall within the sector."""
    period, share = turn_duration(radar), sector_width(radar) / 360.0
    first = int(np.ceil(turn * period * radar.prf_hz - 1e-9))
    last = int(np.ceil((turn + share) * period * radar.prf_hz - 1e-9))
    number = np.arange(first, last, dtype=np.int64)
    time = number / radar.prf_hz
    sweep = (time - turn * period) * 360.0 / period
    azimuth = (radar.sector_deg[0] + sweep) % 360.0
    # The transmitter follows the pulse number, so that it alternates across turns too.
    transmitter = (number % 2 if radar.transmit == "switched" else np.zeros_like(number)).astype(np.int8)
    return Pulses(number, time, sweep, azimuth, transmitter)


def look_sweeps(sector_deg: tuple[float, float], cell_azimuth_deg: float) -> NDArray[np.float64]:
    """Centres of the looks as angles from the start of the sector (deg): as many whole cells as the sector holds."""
    width = sector_deg[1] - sector_deg[0]
    if np.isclose(width, 360.0):
        count = max(1, round(360.0 / cell_azimuth_deg))
        return (np.arange(count) + 0.5) * 360.0 / count
    count = max(1, int(np.floor(width / cell_azimuth_deg + 1e-9)))
    return (np.arange(count, dtype=np.float64) + 0.5) * cell_azimuth_deg


def phase_centres(radar: RadarSettings, azimuth_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """World positions (…, antenna, xyz) [m] of the two phase centres when the boresight points to an azimuth.

    The middle of the baseline stays above the origin; the upper antenna leans towards the look by the tilt.
    """
    east, north = unit_from_azimuth(azimuth_deg)
    tilt = np.radians(radar.tilt_deg)
    half = 0.5 * radar.baseline_m
    centres = np.empty((*np.shape(azimuth_deg), 2, 3))
    for antenna, side in ((0, -1.0), (1, 1.0)):
        centres[..., antenna, 0] = side * half * np.sin(tilt) * east
        centres[..., antenna, 1] = side * half * np.sin(tilt) * north
        centres[..., antenna, 2] = radar.height_m + side * half * np.cos(tilt)
    return centres
