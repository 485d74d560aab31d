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

from ..compiled import compiled
from ..conventions import SPEED_OF_LIGHT
from ..mesh import Facets
from ..radar.antenna import Antenna, Cut
from ..radar.array import antenna_array
from ..radar.receiver import amplitude_constant
from ..settings import RadarSettings

Path = tuple[int, int]  # the two antennas
Chosen = tuple[NDArray[np.intp], NDArray[np.intp]]  # numbers of columns and of facets, which broadcast


@dataclass(frozen=True)
class FacetPaths:
    """Paths of the facets of some columns; arrays (column, facet) unless said otherwise."""

    paths: tuple[Path, ...]
    length: NDArray[np.float64]  # (path, column, facet) half the path transmitter → facet → receiver [m]
    range: NDArray[np.float64]  # (antenna, column, facet) m
    difference: NDArray[np.float64]  # (antenna, column, facet) R − R₀ [m]
    coming: NDArray[np.float64]  # (antenna, column, facet) m/s, radial velocity seen from each antenna, positive away
    # (path, column, facet) voltage at boresight azimuth, before the range response [√W]; complex where light bends
    amplitude: NDArray[np.float32] | NDArray[np.complex64]


def facet_paths(
    facets: Facets,
    rcs: NDArray[np.float32],
    radar: RadarSettings,
    columns: slice,
    paths: tuple[Path, ...] | None = None,
    chosen: Chosen | None = None,
) -> FacetPaths:
    """The facets of `columns` on paths between antennas; left out, on those that the radar's mode uses.

    rcs (column, facet) [m²] is that of all columns; a facet echoes on a path only if it is lit for both of its
    antennas. With a diffracted field it echoes as far as that reaches it, lit or not, out and back alike.
    chosen: numbers (n,) of columns and facets: these alone, and (n,) stands for (column, facet) in what is returned.
    """
    if facets.lit is None:
        raise ValueError("these facets have not been traced; call a tracer first")
    array, grid = antenna_array(radar), facets.grid
    paths = array.paths if paths is None else paths
    if chosen is None:
        number = np.arange(facets.height.shape[0])[columns]
        chosen = number[:, None], np.arange(facets.distance.size)[None, :]
    shape = np.broadcast_shapes(*(index.shape for index in chosen))
    flat = np.broadcast_to(chosen[0], shape).ravel(), np.broadcast_to(chosen[1], shape).ravel()
    ranges, difference, coming = np.empty((3, grid.places.shape[1], flat[0].size))
    sine = np.empty(flat[0].size)
    ahead, aside = (facets.distance * part(facets.angle) for part in (np.cos, np.sin))
    places = (facets.distance, ahead, aside, facets.height, grid.column_height[:, 0])
    velocities = (facets.velocity_look, facets.velocity_up)
    _to_antennas(*flat, places, velocities, grid.places, grid.drift, grid.array_up, ranges, difference, coming, sine)
    length = np.stack([ranges[i] if i == j else 0.5 * (ranges[i] + ranges[j]) for i, j in paths])
    amplitude = _amplitudes(facets, np.sqrt(rcs[flat]), radar, flat, paths, ranges, sine)

    def shaped(values: NDArray) -> NDArray:
        return values.reshape(len(values), *shape)

    return FacetPaths(paths, *(shaped(each) for each in (length, ranges, difference, coming, amplitude)))


@compiled
def _to_antennas(column, facet, places, velocities, antennas, drift, up, ranges, difference, coming, sine):
    """Fill ranges [m], their differences to the first antenna's and radial velocities [m/s], (antenna, n), and the
    direction cosines up the array (n,) of facets with these numbers (n,).

    places: distance, ahead and aside (facet,), height (column, facet), the frame's height (column,). velocities along
    the look and up (column, facet). antennas (column, antenna, 3) m, drift (column, antenna, 3) m/s, up (column, 3).
    """
    distance, ahead, aside, height, origin = places
    look, lift = velocities
    for n in range(column.size):
        c, f = column[n], facet[n]
        rise = height[c, f] - origin[c]
        square = distance[f] * distance[f] + rise * rise
        sine[n] = (up[c, 0] * ahead[f] + up[c, 1] * aside[f] + up[c, 2] * rise) / np.sqrt(square)
        flow = look[c, f] * distance[f] + lift[c, f] * rise
        first_square = first_along = 0.0
        for antenna in range(ranges.shape[0]):
            x, y, z = antennas[c, antenna, 0], antennas[c, antenna, 1], antennas[c, antenna, 2]
            along, its_square = x * ahead[f] + y * aside[f] + z * rise, x * x + y * y + z * z
            ranges[antenna, n] = np.sqrt(square - 2.0 * along + its_square)
            if antenna == 0:
                first_square, first_along = its_square, along
            squares = (its_square - first_square) - 2.0 * (along - first_along)
            difference[antenna, n] = squares / (ranges[antenna, n] + ranges[0, n])
            # (u − d)·(r − a), with the facet's velocity u and place r, and the antenna's d and a.
            u, v, w = drift[c, antenna, 0], drift[c, antenna, 1], drift[c, antenna, 2]
            product = flow - look[c, f] * x - lift[c, f] * z
            product -= u * ahead[f] + v * aside[f] + w * rise - (u * x + v * y + w * z)
            coming[antenna, n] = product / ranges[antenna, n]


def _amplitudes(
    facets: Facets,
    root: NDArray[np.float32],
    radar: RadarSettings,
    chosen: Chosen,
    paths: tuple[Path, ...],
    ranges: NDArray[np.float64],
    sine: NDArray[np.float64],
) -> NDArray[np.float32] | NDArray[np.complex64]:
    """(path, column, facet) √W; root: of the cross-sections; sine: direction cosine of each facet up the array."""
    elements = antenna_array(radar).elements
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
            seen = facets.lit[i][chosen] if i == j else facets.lit[i][chosen] & facets.lit[j][chosen]
            amplitudes.append(np.where(seen, voltage, 0.0).astype(np.float32))
        else:
            amplitudes.append((voltage * facets.field[i][chosen] * facets.field[j][chosen]).astype(np.complex64))
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
