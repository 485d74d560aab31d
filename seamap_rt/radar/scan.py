"""When and where the radar looks: pulses of a turn, and the looks into which they are gathered.

Pulse n is fired at n/prf. The turntable turns clockwise at a constant rate and points to sector_deg[0] at the start of
each turn; outside the sector nothing is sent. A staring one points to the sector's middle all the time, and a turn is a
stretch of `stare_s` seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..settings import RadarSettings
from .array import antenna_array
from .grid import look_sweeps
from .mast import ArrayPose, Mast, turn_duration

# Beam widths to either side that an antenna hears; so far beyond the sector the sea is meshed.
BEAMS_BEYOND = 3.0


@dataclass(frozen=True)
class Pulses:
    """The pulses of one turn; all arrays (pulse,)."""

    number: NDArray[np.int64]
    time: NDArray[np.float64]  # s
    sweep: NDArray[np.float64]  # deg, angle of the boresight since the start of the sector: never wraps
    azimuth: NDArray[np.float64]  # deg in [0, 360)
    transmitter: NDArray[np.int8]  # antenna
    slot: NDArray[np.int8]  # of the mode's cycle
    mast: Mast

    @cached_property
    def pose(self) -> ArrayPose:
        """How the array truly stands at each pulse."""
        return self.mast.pose(self.time)


def sector_width(radar: RadarSettings) -> float:
    """deg."""
    return radar.sector_deg[1] - radar.sector_deg[0]


def scanned_share(radar: RadarSettings) -> float:
    """Share of a turn's time in which pulses are sent."""
    return 1.0 if radar.scan == "staring" else sector_width(radar) / 360.0


def pulses(radar: RadarSettings, turn: int, mast: Mast | None = None) -> Pulses:
    """The pulses of turn `turn` (0, 1, …) that fall within the sector. mast: of the boat; left out, one at rest."""
    mast = mast or Mast(radar)
    period, share = turn_duration(radar), scanned_share(radar)
    first = int(np.ceil(turn * period * radar.prf_hz - 1e-9))
    last = int(np.ceil((turn + share) * period * radar.prf_hz - 1e-9))
    number = np.arange(first, last, dtype=np.int64)
    time = number / radar.prf_hz
    sweep = (time - turn * period) * mast.rate + mast.swing(time)
    if radar.scan == "staring":
        sweep = sweep + 0.5 * sector_width(radar)
    azimuth = (radar.sector_deg[0] + sweep) % 360.0
    # The mode's cycle follows the pulse number, so that it goes on across turns too.
    cycle = antenna_array(radar).cycle
    slot = number % len(cycle)
    transmitter = np.array([each.transmitter for each in cycle])[slot]
    return Pulses(number, time, sweep, azimuth, transmitter.astype(np.int8), slot.astype(np.int8), mast)


def phase_centres(radar: RadarSettings, azimuth_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """World positions (…, antenna, xyz) [m] of the phase centres when the boresight of a boat at rest points to an
    azimuth: the middle of the baseline above the origin, the upper antenna leaning towards the look by the tilt."""
    azimuth = np.asarray(azimuth_deg, dtype=np.float64)
    pose = Mast(radar).pose(np.zeros(azimuth.size), azimuth.ravel() - radar.sector_deg[0])
    return pose.positions.reshape(*azimuth.shape, -1, 3)


__all__ = [
    "BEAMS_BEYOND",
    "Pulses",
    "look_sweeps",
    "phase_centres",
    "pulses",
    "scanned_share",
    "sector_width",
    "turn_duration",
]
