"""From the covariance of a turn's looks to heights: flattening, inversion, and the window that follows the waves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..conventions import wrap_phase
from ..settings import RetrievalSettings
from .covariance import Covariance, window_weights
from .description import LookGeometry, RadarDescription
from .inversion import difference_at_height, height_and_ground_range, height_per_phase, path_share
from .quality import gate_median
from .slopes import local_plane

Weights = tuple[NDArray[np.float64], NDArray[np.float64]]  # of a window: along range, across looks
PhaseSlopes = tuple[NDArray[np.float64], NDArray[np.float64]]  # rad per gate, rad per look; they broadcast to a map


@dataclass(frozen=True)
class Heights:
    """What the phase of each cell says; arrays (look, gate)."""

    cells: Covariance  # the averaged covariance that it was taken from
    window: Weights
    phase: NDArray[np.float64]  # rad, ambiguity resolved
    height: NDArray[np.float64]  # m
    ground_range: NDArray[np.float64]  # m, from the lower antenna
    gain: NDArray[np.float64]  # |dz/dφ| [m/rad]
    phase_slopes: PhaseSlopes  # along which cells were averaged, of the flat sea and of the waves as far as known


class PhaseModel:
    """What a phase means in each gate: the phase of mean sea level, and the height of any other."""

    def __init__(self, radar: RadarDescription, geometry: LookGeometry) -> None:
        self.radar, self.geometry = radar, geometry
        self._share = path_share(radar.transmit)
        self._wavenumber = 2.0 * np.pi / radar.wavelength
        self.flat = self._flat_phase(0.0)
        self.flat_per_gate = 0.5 * (self._flat_phase(radar.spacing) - self._flat_phase(-radar.spacing))

    def _flat_phase(self, offset: float) -> NDArray[np.float64]:
        """Phase (look, gate) of mean sea level `offset` beyond each gate."""
        geometry = self.geometry
        return self._wavenumber * difference_at_height(
            self.radar.ranges + offset, 0.0, geometry.baseline, geometry.lower_height, geometry.tilt, self._share
        )

    def heights(self, cells: Covariance, window: Weights, phase_slopes: PhaseSlopes) -> Heights:
        """Invert the phase of averaged cells. Departures from mean sea level beyond half an ambiguity are folded so
        far; the flag `ambiguous` says where the sea may be that high."""
        radar, geometry = self.radar, self.geometry
        phase = self.flat + wrap_phase(np.angle(cells.cross) - self.flat)
        difference = phase / self._wavenumber
        height, ground_range = height_and_ground_range(
            radar.ranges, difference, geometry.baseline, geometry.lower_height, geometry.tilt, self._share
        )
        gain = height_per_phase(radar.ranges, difference, geometry.baseline, geometry.tilt, radar.wavelength)
        return Heights(cells, window, phase, height, ground_range, gain, phase_slopes)


def single_cell_heights(dwell: Covariance, model: PhaseModel, settings: RetrievalSettings, width_deg: float) -> Heights:
    """Heights from the covariance of each cell alone; looks are width_deg apart."""
    window = (
        window_weights(settings.cell_range_m, model.radar.spacing),
        window_weights(settings.cell_azimuth_deg, width_deg),
    )
    along = (model.flat_per_gate, np.zeros(1))
    return model.heights(dwell.windowed_along(*window, *along), window, along)


def sliding_plane_heights(
    dwell: Covariance, model: PhaseModel, settings: RetrievalSettings, width_deg: float
) -> Heights:
    """Heights from a wider window that follows the slopes of the single cells' map."""
    first, radar = single_cell_heights(dwell, model, settings, width_deg), model.radar
    outward, clockwise = slopes(first.height, first.ground_range, first.cells.lower, radar, settings, width_deg)
    per_height = np.nan_to_num(1.0 / first.gain, posinf=0.0, neginf=0.0)
    step = _ground_step(radar, first.ground_range, model.geometry.lower_height - first.height, outward)
    window = (
        window_weights(settings.window_range_m, radar.spacing),
        window_weights(settings.window_azimuth_deg, width_deg),
    )
    along = (
        model.flat_per_gate + _phase_slope(outward * step, per_height),
        _phase_slope(clockwise * first.ground_range * np.radians(width_deg), per_height),
    )
    return model.heights(dwell.windowed_along(*window, *along), window, along)


ESTIMATORS = {"single_cell": single_cell_heights, "sliding_plane": sliding_plane_heights}


def slopes(
    height: NDArray[np.float64],
    ground_range: NDArray[np.float64],
    power: NDArray[np.float64],
    radar: RadarDescription,
    settings: RetrievalSettings,
    width_deg: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Slopes outward and clockwise by planes over three looks and a cell and a half to either side: 10.5 m by default.

    Shorter planes would follow steeper waves, and more noise. Strong echoes count for more, up to thrice the median.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = power / gate_median(power, np.isfinite(power))
    weight = np.where(np.isfinite(height), np.clip(np.nan_to_num(relative), 0.0, 3.0), 0.0)
    across = np.where(np.isfinite(ground_range), ground_range, radar.ranges) * np.radians(width_deg)
    reach = (1, max(1, round(1.5 * settings.cell_range_m / radar.spacing)))
    # Not closed: the first and the last look of a circle are neighbours in place, but lie a turn apart in time.
    return local_plane(height, weight, ground_range, across, reach, closed=False)


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
