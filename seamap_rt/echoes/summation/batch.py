"""What a kernel needs to sum the facets of some columns: plain arrays and numbers under names.

Named tuples, not dataclasses: compiled functions accept them and use the same names. Arrays are C-contiguous. Axes:
column; facet, of all columns one after the other, those that echo; node, a slow-time instant; gate, a sample in range;
antenna; path, from one antenna to another; mode, of the speckle; kind, of scatterer; leg, of a path: out, back, or both
in one where the antennas look along one line.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

ALIKE = 1e-3  # rad by which the phases of paths may drift apart while a facet is heard, and share a phasor


class Columns(NamedTuple):
    """The columns, each heard for the same number of nodes, its window."""

    number: NDArray[np.intp]  # (column,) key in the random source
    first_facet: NDArray[np.intp]  # (column + 1,) where each column's facets begin; last: the number of facets
    first_node: NDArray[np.intp]  # (column,) node of the sums at which the window begins, from 0
    begin_s: NDArray[np.float64]  # (column,) s, the window's first node after the beam's passing; usually negative


class ListedFacets(NamedTuple):
    """The facets that echo, when the beam passes them."""

    number: NDArray[np.intp]  # (facet,) in its column, key in the random source
    range_m: NDArray[np.float64]  # (facet,) m, slant range R₀ from the first antenna
    difference_m: NDArray[np.float64]  # (antenna, facet) m, R − R₀
    radial_velocity: NDArray[np.float64]  # (antenna, facet) m/s relative to each antenna, positive away
    amplitude: NDArray[np.complex64]  # (path, facet) √W at boresight azimuth, before the range response


class Speckle(NamedTuple):
    """Modes of the speckle in slow time: a facet's speckle is their sum, weighted by its own complex Gaussians."""

    streams: NDArray[np.uint64]  # (kind,) keys of the random source
    modes: NDArray[np.complex64]  # (column or 1, mode, node of the window), those of the first kind first
    first_kind_modes: int
    strength: NDArray[np.float32]  # (facet, kind) share of the facet's voltage


class Geometry(NamedTuple):
    """What turns ranges into phases."""

    antennas: NDArray[np.intp]  # (path, 2) those that send and hear
    wavenumber: float  # rad/m
    node_spacing_s: float  # s


class RangeTable(NamedTuple):
    """Response of the gates to a reflector by its distance from their middles."""

    table: NDArray[np.float32]  # (path or 1, entry), entry n at (n + ½)/entries_per_m; 0 from the last on
    entries_per_m: float  # 1/m
    first_gate_m: float  # m, slant range of the first gate
    gate_spacing_m: float  # m


class Beam(NamedTuple):
    """Voltage patterns in azimuth, and the direction cosine at which they hear the mean sea at each gate.

    Of an antenna `aside` off the array's axis it is level[gate] along[column, node] − drop[gate] up[column, node] −
    inverse_range[gate] (past[column, node] + aside).
    """

    table: NDArray[np.float32]  # (path or 1, leg, entry) voltage, cosine 0 lies half an entry beyond the middle
    entries_per_cosine: float
    aside_m: NDArray[np.float64]  # (path or 1, leg) m
    level: NDArray[np.float64]  # (gate,) cosine of the depression of the mean sea
    drop: NDArray[np.float64]  # (gate,) its sine
    inverse_range: NDArray[np.float64]  # (gate,) 1/m
    along: NDArray[np.float64]  # (column, node of the window) of the aperture's axis with the column's azimuth
    up: NDArray[np.float64]  # (column, node of the window) upward part of the axis, by the height over that at rest
    past_m: NDArray[np.float64]  # (column, node of the window) m that the array has moved along its axis


class ColumnBatch(NamedTuple):
    """Some columns, to be summed together."""

    window: int  # nodes at which a column is heard
    nodes: int  # of the sums; each column's window lies within them
    columns: Columns
    facets: ListedFacets
    speckle: Speckle
    geometry: Geometry
    response: RangeTable
    beam: Beam
