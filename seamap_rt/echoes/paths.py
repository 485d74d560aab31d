"""Each facet's paths to the antennas: their lengths, their differences, and the voltage that it returns.

The antennas are where they stand when the beam passes the facet's column, and move on from there at a constant
velocity while it does. What goes from one antenna to another goes back the same way: a path serves both. Phases of
further paths are reckoned from the first by differences of ranges, formed from differences of squares, which keeps
every digit (3e-7 m even in float32; here float64).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..conventions import SPEED_OF_LIGHT
from ..mesh import Facets
from ..radar.antenna import Antenna, Cut
from ..radar.array import antenna_array
from ..radar.receiver import amplitude_constant
from ..settings import RadarSettings

Path = tuple[int, int]  # the two antennas
_STEADY = 1e-6  # m/s of the antennas against each other: at 100 Hz of bandwidth a phase of 1e-5 rad


@dataclass(frozen=True)
class FacetPaths:
    """Paths of the facets of some columns; arrays (column, facet) unless said otherwise."""

    paths: tuple[Path, ...]
    length: NDArray[np.float64]  # (path, column, facet) half the path transmitter → facet → receiver [m]
    range: NDArray[np.float64]  # (antenna, column, facet) m
    difference: NDArray[np.float64]  # (antenna, column, facet) R − R₀ [m]
    radial_velocity: NDArray[np.float64]  # m/s, positive away: the mean over the antennas
    apart_velocity: NDArray[np.float64] | None  # (antenna, column, facet) m/s over that mean; None if all the same
    # (path, column, facet) voltage at boresight azimuth, before the range response [√W]; complex where light bends
    amplitude: NDArray[np.float32] | NDArray[np.complex64]

    def coming(self, antenna: int) -> NDArray[np.float64]:
        """Radial velocity [m/s] against one antenna."""
        if self.apart_velocity is None:
            return self.radial_velocity
        return self.radial_velocity + self.apart_velocity[antenna]


def facet_paths(
    facets: Facets,
    rcs: NDArray[np.float32],
    radar: RadarSettings,
    columns: slice,
    paths: tuple[Path, ...] | None = None,
) -> FacetPaths:
    """The facets of `columns` on paths between antennas; left out, on those that the radar's mode uses.

    rcs (column, facet) [m²] is that of all columns; a facet echoes on a path only if it is lit for both of its
    antennas. With a diffracted field it echoes as far as that reaches it, lit or not, out and back alike.
    """
    if facets.lit is None:
        raise ValueError("these facets have not been traced; call a tracer first")
    array, grid = antenna_array(radar), facets.grid
    paths = array.paths if paths is None else paths
    rise = facets.height[columns] - grid.column_height[columns]
    ahead, aside = facets.distance * np.cos(facets.angle), facets.distance * np.sin(facets.angle)
    square = facets.distance**2 + rise**2
    middle = np.sqrt(square)
    places = grid.places[columns]

    def towards(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """(column, facet): products of the facets' places with a vector (column, 3) each."""
        product = vectors[:, 2:] * rise
        for part, along in ((vectors[:, :1], ahead), (vectors[:, 1:2], aside)):
            if part.any():  # an upright array stands on its own axis
                product += part * along
        return product

    ranges = np.empty((places.shape[1], *middle.shape))
    difference = np.zeros_like(ranges)
    for antenna in range(places.shape[1]):
        place = places[:, antenna]
        ranges[antenna] = np.sqrt(square - 2.0 * towards(place) + np.sum(place**2, axis=1)[:, None])
    for antenna in range(1, places.shape[1]):
        place, first = places[:, antenna], places[:, 0]
        squares = np.sum(place**2 - first**2, axis=1)[:, None] - 2.0 * towards(place - first)
        difference[antenna] = squares / (ranges[antenna] + ranges[0])

    drift = grid.drift[columns]
    common = drift.mean(axis=1)
    velocity = facets.velocity_look[columns] * facets.distance + facets.velocity_up[columns] * rise
    if common.any():
        velocity -= towards(common)
    velocity /= middle
    apart = drift - common[:, None]
    moving = np.abs(apart).max(initial=0.0) > _STEADY
    apart_velocity = np.stack([-towards(apart[:, n]) / middle for n in range(apart.shape[1])]) if moving else None

    sine = towards(grid.array_up[columns]) / middle
    return FacetPaths(
        paths=paths,
        length=np.stack([ranges[i] if i == j else 0.5 * (ranges[i] + ranges[j]) for i, j in paths]),
        range=ranges,
        difference=difference,
        radial_velocity=velocity,
        apart_velocity=apart_velocity,
        amplitude=_amplitudes(facets, rcs, radar, columns, paths, ranges, sine),
    )


def _amplitudes(
    facets: Facets,
    rcs: NDArray[np.float32],
    radar: RadarSettings,
    columns: slice,
    paths: tuple[Path, ...],
    ranges: NDArray[np.float64],
    sine: NDArray[np.float64],
) -> NDArray[np.float32] | NDArray[np.complex64]:
    """(path, column, facet) √W; sine: direction cosine of each facet up the array."""
    elements = antenna_array(radar).elements
    root = np.sqrt(rcs[columns])
    cuts: dict[Cut, NDArray[np.float64]] = {}

    def cut(antenna: Antenna) -> NDArray[np.float64]:
        if antenna.elevation not in cuts:
            cuts[antenna.elevation] = _tabulated(antenna.elevation, sine)
        return cuts[antenna.elevation]

    amplitudes = []
    for i, j in paths:
        one, other = elements[i].antenna, elements[j].antenna
        gain = float(np.sqrt(one.gain * other.gain))
        voltage = amplitude_constant(radar, gain) * cut(one) * cut(other) * root / (ranges[i] * ranges[j])
        if facets.field is None:
            assert facets.lit is not None
            seen = facets.lit[i, columns] if i == j else facets.lit[i, columns] & facets.lit[j, columns]
            amplitudes.append(np.where(seen, voltage, 0.0).astype(np.float32))
        else:
            amplitudes.append((voltage * facets.field[i, columns] * facets.field[j, columns]).astype(np.complex64))
    return np.stack(amplitudes)


def wavenumber(radar: RadarSettings) -> float:
    """k = 2πf/c [rad/m]."""
    return 2.0 * np.pi * radar.frequency_hz / SPEED_OF_LIGHT


_TABLE = np.linspace(-1.0, 1.0, 20_001)


def _tabulated(cut, sine: NDArray[np.float64]) -> NDArray[np.float64]:
    """A pattern cut by linear interpolation in its direction cosine (1e-4 apart: 1e-6 of the peak for beams ≥ 1°)."""
    return np.interp(sine, _TABLE, _table(cut))


@lru_cache(maxsize=16)
def _table(cut: Cut) -> NDArray[np.float64]:
    return cut(_TABLE)
