"""Each facet's paths to the antennas: their lengths, their differences, and the voltage that it returns.

The antennas are where they stand when the beam passes the facet's column, and move on from there at a constant
velocity while it does. What goes from one antenna to another goes back the same way: a path serves both. Phases of
the other paths are reckoned from the first by differences of ranges, formed from differences of squares, which keeps
every digit (3e-7 m even in float32; here float64).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled
from ..conventions import SPEED_OF_LIGHT
from ..radar.antenna import Cut
from ..radar.array import antenna_array
from ..radar.receiver import amplitude_constant
from ..settings import RadarSettings
from ..tracing import Illumination

Path = tuple[int, int]  # the two antennas
Chosen = tuple[NDArray[np.intp], NDArray[np.intp]]  # numbers of columns and of facets, which broadcast


@dataclass(frozen=True)
class FacetPaths:
    """Paths of the facets of some columns."""

    paths: tuple[Path, ...]
    range: NDArray[np.float64]  # (antenna, column, facet) m
    difference: NDArray[np.float64]  # (antenna, column, facet) R − R₀ [m]
    coming: NDArray[np.float64]  # (antenna, column, facet) m/s, radial velocity seen from each antenna, positive away
    # (path, column, facet) voltage at boresight azimuth, before the range response [√W]; complex where light bends
    amplitude: NDArray[np.float32] | NDArray[np.complex64]

    @property
    def length(self) -> NDArray[np.float64]:
        """(path, column, facet) half the path transmitter → facet → receiver [m]."""
        return np.stack([self.range[i] if i == j else 0.5 * (self.range[i] + self.range[j]) for i, j in self.paths])


def facet_paths(
    facets: Illumination,
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
    array, grid = antenna_array(radar), facets.grid
    paths = array.paths if paths is None else paths
    if chosen is None:
        number = np.arange(facets.height.shape[0])[columns]
        chosen = number[:, None], np.arange(facets.distance.size)[None, :]
    shape = np.broadcast_shapes(*(index.shape for index in chosen))
    # Kernels are compiled for each layout of memory that they meet.
    column, facet = (np.require(np.broadcast_to(index, shape).ravel(), None, "W") for index in chosen)
    flat = column, facet
    ranges, difference, coming = np.empty((3, grid.antenna_positions.shape[1], flat[0].size))
    sine = np.empty(flat[0].size)
    ahead, aside = (facets.distance * function(facets.angle) for function in (np.cos, np.sin))
    positions = (facets.distance, ahead, aside, facets.height, grid.column_height[:, 0])
    velocities = (facets.velocity_look, facets.velocity_up)
    _to_antennas(
        *flat,
        positions,
        velocities,
        grid.antenna_positions,
        grid.drift,
        grid.array_up,
        ranges,
        difference,
        coming,
        sine,
    )
    amplitude = _amplitudes(facets, rcs, radar, flat, paths, ranges, sine)

    def shaped(values: NDArray) -> NDArray:
        return values.reshape(len(values), *shape)

    return FacetPaths(paths, *(shaped(each) for each in (ranges, difference, coming, amplitude)))


@compiled
def _to_antennas(column, facet, positions, velocities, antennas, drift, up, ranges, difference, coming, sine):
    """Fill ranges [m], their differences to the first antenna's and radial velocities [m/s], (antenna, n), and the
    direction cosines up the array (n,) of facets with these numbers (n,).

    positions: distance, ahead and aside (facet,), height (column, facet), the frame's height (column,). velocities:
    along the look and up (column, facet). antennas (column, antenna, 3) m; drift (column, antenna, 3) m/s; up
    (column, 3).
    """
    distance, ahead, aside, height, origin = positions
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
            # (u − d)·(r − a), with the facet's velocity u and position r, and the antenna's d and a.
            u, v, w = drift[c, antenna, 0], drift[c, antenna, 1], drift[c, antenna, 2]
            product = flow - look[c, f] * x - lift[c, f] * z
            product -= u * ahead[f] + v * aside[f] + w * rise - (u * x + v * y + w * z)
            coming[antenna, n] = product / ranges[antenna, n]


def _amplitudes(
    facets: Illumination,
    rcs: NDArray[np.float32],
    radar: RadarSettings,
    chosen: Chosen,
    paths: tuple[Path, ...],
    ranges: NDArray[np.float64],
    sine: NDArray[np.float64],
) -> NDArray[np.float32] | NDArray[np.complex64]:
    """(path, n) √W of the chosen facets; sine: direction cosine of each facet up the array."""
    antennas = [element.antenna for element in antenna_array(radar).elements]
    tables, which = elevation_tables(radar)
    gains = [float(np.sqrt(antennas[i].gain * antennas[j].gain)) for i, j in paths]
    constants = np.array([amplitude_constant(radar, gain) for gain in gains])
    out = np.empty((len(paths), sine.size), dtype=np.float32)
    lit = facets.lit if facets.field is None else np.ones_like(facets.lit)
    _fill_amplitudes(*chosen, np.array(paths), constants, rcs, lit, ranges, sine, tables, which, out)
    if facets.field is None:
        return out
    return np.stack(
        [each * facets.field[i][chosen] * facets.field[j][chosen] for each, (i, j) in zip(out, paths, strict=True)]
    )


@compiled
def _fill_amplitudes(column, facet, paths, constants, rcs, lit, ranges, sine, tables, which, out):
    """Fill out (path, n): constant · root of rcs (column, facet) · cuts / ranges (antenna, n), where lit for both.

    tables (cut, entry): over direction cosines from −1 to 1; which (antenna,): its table.
    """
    steps = tables.shape[1] - 1
    for n in range(column.size):
        c, f = column[n], facet[n]
        root = np.sqrt(float(rcs[c, f]))
        entry_at = (sine[n] + 1.0) * (0.5 * steps)
        entry = min(max(int(entry_at), 0), steps - 1)
        beyond = entry_at - entry
        for path in range(paths.shape[0]):
            i, j = paths[path, 0], paths[path, 1]
            value = 0.0
            if lit[i, c, f] and lit[j, c, f]:
                value = constants[path] * root / (ranges[i, n] * ranges[j, n])
                value *= tables[which[i], entry] + beyond * (tables[which[i], entry + 1] - tables[which[i], entry])
                value *= tables[which[j], entry] + beyond * (tables[which[j], entry + 1] - tables[which[j], entry])
            out[path, n] = value


def elevation_tables(radar: RadarSettings) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """(cut, entry) over direction cosines from −1 to 1, for linear interpolation; and (antenna,) the cut of each."""
    antennas = [element.antenna for element in antenna_array(radar).elements]
    cuts = tuple(dict.fromkeys(antenna.elevation for antenna in antennas))
    return _tables(cuts), np.array([cuts.index(antenna.elevation) for antenna in antennas])


def wavenumber(radar: RadarSettings) -> float:
    """k = 2πf/c [rad/m]."""
    return 2.0 * np.pi * radar.frequency_hz / SPEED_OF_LIGHT


@lru_cache(maxsize=16)
def _tables(cuts: tuple[Cut, ...]) -> NDArray[np.float64]:
    """(cut, entry) of pattern cuts, for linear interpolation (1e-4 apart: 1e-6 of the peak for beams ≥ 1°)."""
    return np.array([cut(np.linspace(-1.0, 1.0, 20_001)) for cut in cuts])
