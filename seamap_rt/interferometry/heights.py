"""From the covariance of a turn's looks to heights: flattening, inversion, and the window that follows the waves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..conventions import wrap_phase
from ..settings import RetrievalSettings
from .covariance import Covariance, Level, window_weights
from .description import RadarDescription
from .inversion import Places, difference_at_height, height_per_phase, place
from .quality import gate_median
from .slopes import Cells, Offsets, local_plane
from .stance import LookStances

Weights = tuple[NDArray[np.float64], NDArray[np.float64]]  # of a window: along range, across looks
# rad per gate, rad per look, which broadcast to a map, and the level of the sea as seen from a boat that moves
PhaseSlopes = tuple[NDArray[np.float64], NDArray[np.float64], Level | None]


@dataclass(frozen=True)
class Heights:
    """What the phase of each cell says; arrays (look, gate)."""

    cells: Covariance  # the averaged covariance that it was taken from
    window: Weights
    phase: NDArray[np.float64]  # rad, ambiguity resolved
    places: Places  # m, height above mean sea level, outward and clockwise of the lower antenna
    ground_range: NDArray[np.float64]  # m, from the middle of the receivers
    gain: NDArray[np.float64]  # |dz/dφ| [m/rad]
    phase_slopes: PhaseSlopes  # along which cells were averaged, of the flat sea and of the waves as far as known

    @property
    def height(self) -> NDArray[np.float64]:
        return self.places.height


class PhaseModel:
    """What a phase means in each gate: the phase of mean sea level, and the height of any other."""

    def __init__(self, radar: RadarDescription, stances: LookStances) -> None:
        self.radar, self.stances = radar, stances
        self._wavenumber = 2.0 * np.pi * radar.paths / radar.wavelength
        self.flat = self._flat_phase(0.0)
        self.flat_per_gate = 0.5 * (self._flat_phase(radar.spacing) - self._flat_phase(-radar.spacing))
        # The antennas of a boat that rolls or heaves are no more where they were at the look before.
        self.level = None if stances.at_rest else lru_cache(self._level)

    def _flat_phase(self, offset: float) -> NDArray[np.float64]:
        """Phase (look, gate) of mean sea level `offset` beyond each gate."""
        return self._wavenumber * difference_at_height(self.radar.ranges + offset, 0.0, self.stances.fan)

    def _level(self, gates: int) -> NDArray[np.float64]:
        return np.nan_to_num(self._flat_phase(gates * self.radar.spacing))

    def heights(self, cells: Covariance, window: Weights, phase_slopes: PhaseSlopes) -> Heights:
        """Invert the phase of averaged cells. Departures from mean sea level beyond half an ambiguity are folded so
        far; the flag `ambiguous` says where the sea may be that high."""
        radar, fan = self.radar, self.stances.fan
        phase = self.flat + wrap_phase(np.angle(cells.cross) - self.flat)
        difference = phase / self._wavenumber
        places = place(radar.ranges, difference, fan)
        gain = height_per_phase(radar.ranges, difference, fan, radar.wavelength, radar.paths)
        return Heights(cells, window, phase, places, self.stances.ground_range(places), gain, phase_slopes)

    def slopes(
        self, found: Heights, height: NDArray[np.float64], settings: RetrievalSettings, width_deg: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Slopes outward and clockwise by planes over three looks and a cell and a half to either side: 10.5 m by
        default. height: the found one, NaN where it is not to be believed.

        Shorter planes would follow steeper waves, and more noise. Strong echoes count for more, up to thrice
        the median.
        """
        power, radar = found.cells.lower, self.radar
        with np.errstate(invalid="ignore", divide="ignore"):
            relative = power / gate_median(power, np.isfinite(power))
        weight = np.where(np.isfinite(height), np.clip(np.nan_to_num(relative), 0.0, 3.0), 0.0)
        ground_range = np.where(np.isfinite(height), found.ground_range, np.nan)
        across = np.where(np.isfinite(ground_range), ground_range, radar.ranges) * np.radians(width_deg)
        reach = (1, max(1, round(1.5 * settings.cell_range_m / radar.spacing)))
        ground = None if self.stances.at_rest else self.stances.world(found.places)
        # Not closed: the first and the last look of a circle are neighbours in place, but lie a turn apart in time.
        return local_plane(height, weight, ground_range, across, reach, closed=False, offsets=self._offsets(ground))

    def _offsets(self, ground: tuple[NDArray[np.float64], NDArray[np.float64]] | None) -> Offsets | None:
        """Between cells at (east, north), as seen from the antennas at the first one's dwell; None if they all lie on
        straight lines from one point."""
        if ground is None:
            return None
        (x, y), (middle_x, middle_y) = ground, self.stances.middle
        distance = np.hypot(x - middle_x, y - middle_y)
        with np.errstate(invalid="ignore"):
            east, north = (x - middle_x) / distance, (y - middle_y) / distance

        def between(here: Cells, there: Cells) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
            dx, dy = x[there] - x[here], y[there] - y[here]
            return dx * east[here] + dy * north[here], dx * north[here] - dy * east[here]

        return between


def single_cell_heights(dwell: Covariance, model: PhaseModel, settings: RetrievalSettings, width_deg: float) -> Heights:
    """Heights from the covariance of each cell alone; looks are width_deg apart."""
    window = (
        window_weights(settings.cell_range_m, model.radar.spacing),
        window_weights(settings.cell_azimuth_deg, width_deg),
    )
    along = (model.flat_per_gate, np.zeros(1), model.level)
    return model.heights(dwell.windowed_along(*window, *along), window, along)


def sliding_plane_heights(
    dwell: Covariance, model: PhaseModel, settings: RetrievalSettings, width_deg: float
) -> Heights:
    """Heights from a wider window that follows the slopes of the single cells' map."""
    first, radar = single_cell_heights(dwell, model, settings, width_deg), model.radar
    outward, clockwise = model.slopes(first, first.height, settings, width_deg)
    # With the second receiver below the first a rise turns the phase on, not back.
    per_height = np.sign(model.stances.fan.upper.up) * np.nan_to_num(1.0 / first.gain, posinf=0.0, neginf=0.0)
    step = _ground_step(radar, first.ground_range, model.stances.fan.height - first.height, outward)
    window = (
        window_weights(settings.window_range_m, radar.spacing),
        window_weights(settings.window_azimuth_deg, width_deg),
    )
    along = (
        model.flat_per_gate + _phase_slope(outward * step, per_height),
        _phase_slope(clockwise * first.ground_range * np.radians(width_deg), per_height),
        model.level,
    )
    return model.heights(dwell.windowed_along(*window, *along), window, along)


ESTIMATORS = {"single_cell": single_cell_heights, "sliding_plane": sliding_plane_heights}


def _ground_step(
    radar: RadarDescription,
    ground_range: NDArray[np.float64],
    drop: NDArray[np.float64],
    slope: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Ground range from a gate to the next along a surface of that slope: r dr = (x − drop · slope) dx.

    Kept within three gates' spacing: where the surface faces the radar squarely, many places share a gate.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        step = radar.ranges / (ground_range - drop * np.nan_to_num(slope))
    return radar.spacing * np.clip(np.where(step > 0.0, step, 3.0), 0.0, 3.0)


def _phase_slope(rise: NDArray[np.float64], per_height: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height difference to the neighbour as phase; 0 where the slope is unknown. A rise turns the phase back."""
    return -np.nan_to_num(rise) * per_height
