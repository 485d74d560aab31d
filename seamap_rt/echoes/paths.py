"""Each facet's paths to the antennas: their lengths, their differences, and the voltage that it returns.

The antennas are where they stand when the beam passes the facet's column, and move on from there at a constant
velocity while it does. What goes from one antenna to another goes back the same way: a path serves both. Phases of
the other paths are reckoned from the first by differences of ranges, formed from differences of squares, which keeps
every digit (3e-7 m even in float32; here float64).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled, compiled_step, compiled_step_fused
from ..radar.antenna import Cut
from ..radar.array import Array
from ..radar.installation import Installation
from ..radar.receiver import amplitude_constant
from ..tracing import Illumination

_FACETS = 64  # worked on at a time

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
    installation: Installation,
    columns: slice,
    paths: tuple[Path, ...] | None = None,
    chosen: Chosen | None = None,
) -> FacetPaths:
    """The facets of `columns` on paths between antennas; left out, on those that the radar's mode uses.

    rcs (column, facet) [m²] is that of all columns; a facet echoes on a path only if it is lit for both of its
    antennas. With a diffracted field it echoes as far as that reaches it, lit or not, out and back alike.
    chosen: numbers (n,) of columns and facets: these alone, and (n,) stands for (column, facet) in what is returned.
    """
    grid = facets.grid
    paths = installation.array.paths if paths is None else paths
    if chosen is None:
        number = np.arange(facets.height.shape[0])[columns]
        chosen = number[:, None], np.arange(facets.distance.size)[None, :]
    shape = np.broadcast_shapes(*(index.shape for index in chosen))
    # Kernels are compiled for each layout of memory that they meet.
    column, facet = (
        np.require(index if index.shape == shape else np.broadcast_to(index, shape), None, ["C", "W"]).reshape(-1)
        for index in chosen
    )
    flat = column, facet
    ranges, difference, coming = np.empty((3, grid.antenna_positions.shape[1], flat[0].size))
    sine = np.empty(flat[0].size)
    ahead, aside = (facets.distance * function(facets.angle) for function in (np.cos, np.sin))
    positions = (facets.distance, ahead, aside, facets.height, grid.column_height[:, 0])
    velocities = (facets.velocity_look, facets.velocity_up)
    _fill_antenna_paths(
        *flat,
        positions,
        velocities,
        _ArrayMotion(grid.antenna_positions, grid.drift, grid.array_up),
        ranges,
        difference,
        coming,
        sine,
    )
    amplitude = _amplitudes(facets, rcs, installation, flat, paths, ranges, sine)

    def shaped(values: NDArray) -> NDArray:
        return values.reshape(len(values), *shape)

    return FacetPaths(paths, *(shaped(each) for each in (ranges, difference, coming, amplitude)))


Row = NDArray[np.float64]  # (_FACETS,)


class _Facets(NamedTuple):
    """Some facets at work; the array stands at the origin of the frame, ahead along the look."""

    distance: Row  # m, horizontal
    ahead: Row  # m
    aside: Row  # m
    rise: Row  # m
    outward: Row  # m/s, the water's velocity
    upward: Row  # m/s
    square: Row  # m², of the distance from the origin
    flow: Row  # m²/s, velocity times position
    sine: Row  # direction cosine up the array


class _Sight(NamedTuple):
    """What an antenna has of them."""

    first_range: Row  # m, the first antenna's
    range: Row  # m
    difference: Row  # m, to the first antenna's
    coming: Row  # m/s, radial velocity


class _ArrayMotion(NamedTuple):
    antennas: NDArray[np.float64]  # (column, antenna, 3) m
    drift: NDArray[np.float64]  # (column, antenna, 3) m/s
    up: NDArray[np.float64]  # (column, 3)


@compiled
def _fill_antenna_paths(column, facet, positions, velocities, array, ranges, difference, coming, sine):
    """Fill ranges [m], their differences to the first antenna's and radial velocities [m/s], (antenna, n), and the
    direction cosines up the array (n,) of facets with these numbers (n,).

    positions: distance, ahead and aside (facet,), height (column, facet), the frame's height (column,). velocities:
    along the look and up (column, facet).
    """
    antennas, drift, up = array
    facets = _Facets(_row(), _row(), _row(), _row(), _row(), _row(), _row(), _row(), _row())
    sight, begin = _Sight(_row(), _row(), _row(), _row()), 0
    while begin < column.size:
        c, count = column[begin], _same_column_count(column, begin)
        _gather(c, facet, begin, count, positions, velocities, facets)
        _look_up(up[c, 0], up[c, 1], up[c, 2], facets)
        for n in range(count):
            sine[begin + n] = facets.sine[n]
        for antenna in range(ranges.shape[0]):
            _look_at(antennas[c, antenna], antennas[c, 0], drift[c, antenna], antenna == 0, facets, sight)
            for n in range(count):
                ranges[antenna, begin + n] = sight.range[n]
                difference[antenna, begin + n], coming[antenna, begin + n] = sight.difference[n], sight.coming[n]
        begin += count


@compiled_step
def _row():
    return np.zeros(_FACETS)


@compiled_step
def _same_column_count(column, begin):
    """How many facets from `begin` on, at most _FACETS, are of the same column: few numbers are then all lanes'."""
    count = 1
    while count < _FACETS and begin + count < column.size and column[begin + count] == column[begin]:
        count += 1
    return count


@compiled_step
def _gather(column, facet, begin, count, positions, velocities, facets):
    """Fill in where facets are and how they move."""
    distance, ahead, aside, height, origin = positions
    look, lift = velocities
    level = origin[column]
    for n in range(count):
        f = facet[begin + n]
        facets.distance[n], facets.ahead[n], facets.aside[n] = distance[f], ahead[f], aside[f]
        facets.rise[n] = height[column, f] - level
        facets.outward[n], facets.upward[n] = look[column, f], lift[column, f]


@compiled_step_fused
def _look_up(x, y, z, facets):
    """Fill in what all antennas share; x, y, z: the array's direction up."""
    for n in range(_FACETS):  # of one column or not: whole groups of lanes
        distance, rise = facets.distance[n], facets.rise[n]
        square = distance * distance + rise * rise
        facets.square[n] = square
        facets.flow[n] = facets.outward[n] * distance + facets.upward[n] * rise
        facets.sine[n] = (x * facets.ahead[n] + y * facets.aside[n] + z * rise) / np.sqrt(square)


@compiled_step_fused
def _look_at(position, first, moves, is_first, facets, sight):
    """Fill in what an antenna has of the facets. Its own position and the first one's (3,) m, how it moves (3,) m/s."""
    x, y, z, u, v, w = position[0], position[1], position[2], moves[0], moves[1], moves[2]
    x_first, y_first, z_first = first[0], first[1], first[2]
    its_square, drifts = x * x + y * y + z * z, u * x + v * y + w * z
    first_square = x_first * x_first + y_first * y_first + z_first * z_first
    for n in range(_FACETS):
        ahead, aside, rise = facets.ahead[n], facets.aside[n], facets.rise[n]
        along, first_along = x * ahead + y * aside + z * rise, x_first * ahead + y_first * aside + z_first * rise
        range_m = np.sqrt(facets.square[n] - 2.0 * along + its_square)
        squares = (its_square - first_square) - 2.0 * (along - first_along)
        # (u − d)·(r − a), with the facet's velocity u and position r, and the antenna's d and a.
        product = facets.flow[n] - facets.outward[n] * x - facets.upward[n] * z
        product -= u * ahead + v * aside + w * rise - drifts
        sight.first_range[n] = range_m if is_first else sight.first_range[n]
        sight.difference[n] = squares / (range_m + sight.first_range[n])
        sight.range[n], sight.coming[n] = range_m, product / range_m


def _amplitudes(
    facets: Illumination,
    rcs: NDArray[np.float32],
    installation: Installation,
    chosen: Chosen,
    paths: tuple[Path, ...],
    ranges: NDArray[np.float64],
    sine: NDArray[np.float64],
) -> NDArray[np.float32] | NDArray[np.complex64]:
    """(path, n) √W of the chosen facets; sine: direction cosine of each facet up the array."""
    antennas = [element.antenna for element in installation.array.elements]
    tables, which = elevation_tables(installation.array)
    gains = [float(np.sqrt(antennas[i].gain * antennas[j].gain)) for i, j in paths]
    constants = np.array([amplitude_constant(installation.radar, gain) for gain in gains])
    out = np.empty((len(paths), sine.size), dtype=np.float32)
    lit = facets.lit if facets.field is None else np.ones_like(facets.lit)
    _fill_amplitudes(*chosen, np.array(paths), constants, rcs, lit, ranges, sine, (tables, which), out)
    if facets.field is None:
        return out
    return np.stack(
        [each * facets.field[i][chosen] * facets.field[j][chosen] for each, (i, j) in zip(out, paths, strict=True)]
    )


@compiled
def _fill_amplitudes(column, facet, paths, constants, rcs, lit, ranges, sine, cuts, out):
    """Fill out (path, n): constant · root of rcs (column, facet) · cuts / ranges (antenna, n), where lit for both.

    cuts: tables (cut, entry) over direction cosines from −1 to 1, and which of them (antenna,) is whose.
    """
    tables, which = cuts
    antennas, begin = ranges.shape[0], 0
    root, pattern = np.zeros(_FACETS), np.zeros((antennas, _FACETS))
    while begin < column.size:
        c, count = column[begin], _same_column_count(column, begin)
        for n in range(count):
            root[n] = np.sqrt(float(rcs[c, facet[begin + n]]))
        for antenna in range(antennas):
            _fill_elevation_cut(c, facet, begin, count, lit[antenna], sine, tables[which[antenna]], pattern[antenna])
        for path in range(paths.shape[0]):
            i, j, constant = paths[path, 0], paths[path, 1], constants[path]
            for n in range(count):
                value = constant * root[n] / (ranges[i, begin + n] * ranges[j, begin + n])
                out[path, begin + n] = value * pattern[i, n] * pattern[j, n]
        begin += count


@compiled_step
def _fill_elevation_cut(column, facet, begin, count, lit, sine, cut, gain):
    """Fill gain (n,): an antenna's cut in elevation towards facets, 0 where it does not light them."""
    steps = cut.size - 1
    for n in range(count):
        entry_at = (sine[begin + n] + 1.0) * (0.5 * steps)
        entry = min(max(int(entry_at), 0), steps - 1)
        value = cut[entry] + (entry_at - entry) * (cut[entry + 1] - cut[entry])
        gain[n] = value if lit[column, facet[begin + n]] else 0.0


def elevation_tables(array: Array) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """(cut, entry) over direction cosines from −1 to 1, for linear interpolation; and (antenna,) the cut of each."""
    antennas = [element.antenna for element in array.elements]
    cuts = tuple(dict.fromkeys(antenna.elevation for antenna in antennas))
    return _tables(cuts), np.array([cuts.index(antenna.elevation) for antenna in antennas])


@lru_cache(maxsize=16)
def _tables(cuts: tuple[Cut, ...]) -> NDArray[np.float64]:
    """(cut, entry) of pattern cuts, for linear interpolation (1e-4 apart: 1e-6 of the peak for beams ≥ 1°)."""
    return np.array([cut(np.linspace(-1.0, 1.0, 20_001)) for cut in cuts])
