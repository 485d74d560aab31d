"""When and where the radar looks: pulses of a turn, and the looks into which they are gathered.

Pulse n is fired at n/prf. The turntable turns clockwise at a constant rate and points to sector_deg[0] at the start of
each turn; outside the sector nothing is sent. A staring one points to the sector's middle all the time, and a turn is a
stretch of `stare_s` seconds.

While a look is recorded the boresight turns by the width of a cell. A fan that leans is heard where it meets the sea,
and looks are made of pulses by where that is: offsets in azimuth are all that `dwell_power` and `DwellBeams` need, the
antennas' azimuth patterns towards a column of the sea, averaged over the look's dwell.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from ..settings import RadarSettings
from .antenna import Cut
from .array import Array
from .grid import look_sweeps
from .installation import ArrayPose, Installation, turn_duration

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
    installation: Installation

    @cached_property
    def pose(self) -> ArrayPose:
        """How the array truly stands at each pulse."""
        return self.installation.pose(self.time)


def sector_width(radar: RadarSettings) -> float:
    """deg."""
    return radar.sector_deg[1] - radar.sector_deg[0]


def scanned_share(radar: RadarSettings) -> float:
    """Share of a turn's time in which pulses are sent."""
    return 1.0 if radar.scan == "staring" else sector_width(radar) / 360.0


def pulses(installation: Installation, turn: int) -> Pulses:
    """The pulses of turn `turn` (0, 1, …) that fall within the sector."""
    radar, period = installation.radar, installation.period
    share = scanned_share(radar)
    first = int(np.ceil(turn * period * radar.prf_hz - 1e-9))
    last = int(np.ceil((turn + share) * period * radar.prf_hz - 1e-9))
    number = np.arange(first, last, dtype=np.int64)
    time = number / radar.prf_hz
    sweep = (time - turn * period) * installation.rate + installation.swing(time)
    if radar.scan == "staring":
        sweep = sweep + 0.5 * sector_width(radar)
    azimuth = (radar.sector_deg[0] + sweep) % 360.0
    # The mode's cycle follows the pulse number, so that it goes on across turns too.
    cycle = installation.array.cycle
    slot = number % len(cycle)
    transmitter = np.array([each.transmitter for each in cycle])[slot]
    return Pulses(number, time, sweep, azimuth, transmitter.astype(np.int8), slot.astype(np.int8), installation)


def phase_centres(radar: RadarSettings, azimuth_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """World positions (…, antenna, xyz) [m] of the phase centres when the boresight of a boat at rest points to an
    azimuth: the middle of the baseline above the origin, the upper antenna leaning towards the look by the tilt."""
    azimuth = np.asarray(azimuth_deg, dtype=np.float64)
    pose = Installation(radar).pose(np.zeros(azimuth.size), azimuth.ravel() - radar.sector_deg[0])
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


Path = tuple[int, int]  # the two antennas
_POINTS = 24  # of a dwell
_TABLE = 4001  # entries over all directions that are heard


def dwell_power(array: Array, offset_deg: NDArray[np.float64], cell_azimuth_deg: float) -> NDArray[np.float64]:
    """Two-way power pattern of the first two receivers' antennas, averaged over a dwell of cell_azimuth_deg, for a look
    whose middle lies offset_deg clockwise of the column (any shape). 0 beyond the beam's reach."""
    return np.interp(offset_deg, *_power_table(array, cell_azimuth_deg), left=0.0, right=0.0)


@lru_cache(maxsize=16)
def _power_table(array: Array, cell_azimuth_deg: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Offsets [deg] and `dwell_power` there: the same for every turn."""
    reach = BEAMS_BEYOND * array.beam_deg
    table = np.linspace(-reach - cell_azimuth_deg, reach + cell_azimuth_deg, _TABLE)
    pointing = np.clip(table[:, None] + _dwell(cell_azimuth_deg), -89.0, 89.0)
    first, second = (array.elements[n].antenna.azimuth for n in array.receivers[:2])
    cosine = -np.sin(np.radians(pointing))
    return table, _mean((first(cosine) * second(cosine)) ** 2, np.abs(pointing) <= reach)


class DwellBeams:
    """The dwell's mean product of two paths' voltage patterns towards one column, (look, gate)."""

    def __init__(
        self, array: Array, sweeps: NDArray[np.float64], cell_azimuth_deg: float, column_sweep: float, level: NDArray
    ) -> None:
        """sweeps (look,) deg: middles of the looks; cell_azimuth_deg: what they turn by, 0 for a staring antenna;
        column_sweep [deg]: where the column lies; level (gate,): cosine of the depression of the sea at each gate."""
        reach = BEAMS_BEYOND * array.beam_deg + 1e-9  # rounding must not separate looks that stand alike
        self.looks = np.flatnonzero(np.abs(sweeps - column_sweep) <= reach + 0.5 * cell_azimuth_deg)  # that hear it
        dwell = _dwell(cell_azimuth_deg) if cell_azimuth_deg > 0.0 else np.zeros(1)
        offset = sweeps[self.looks, None] + dwell - column_sweep
        self._array = array
        self._cosine = -np.sin(np.radians(offset))[..., None] * level
        self._within_reach = np.abs(offset)[..., None] <= reach
        # Beyond it no cosine lies; the same for all columns, so that looks are alike to the last digits.
        self._span = float(np.sin(np.radians(min(90.0, reach + cell_azimuth_deg))))
        self._cuts: dict[object, NDArray[np.float64]] = {}
        self._products: dict[object, NDArray[np.float64]] = {}

    def __call__(self, one: Path, other: Path) -> NDArray[np.float64]:
        """The product of two paths' patterns, for the looks that hear the column."""
        cuts = sorted((self._array.elements[n].antenna.azimuth for n in (*one, *other)), key=id)
        key = tuple(cuts)
        if key not in self._products:
            product = np.ones_like(self._cosine)
            for cut in cuts:
                product = product * self._voltage(cut)
            self._products[key] = _mean(product, self._within_reach)
        return self._products[key]

    def _voltage(self, cut: Cut) -> NDArray[np.float64]:
        if cut not in self._cuts:
            table = np.linspace(-self._span, self._span, _TABLE)
            self._cuts[cut] = np.interp(self._cosine, table, cut(table))
        return self._cuts[cut]


def _dwell(cell_azimuth_deg: float) -> NDArray[np.float64]:
    """(point,) deg off the dwell's middle."""
    return cell_azimuth_deg * ((np.arange(_POINTS) + 0.5) / _POINTS - 0.5)


def _mean(pattern: NDArray[np.float64], within_reach: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The mean over the points of a dwell, the second axis; points out of reach count as 0."""
    return np.where(within_reach, pattern, 0.0).mean(axis=1)
