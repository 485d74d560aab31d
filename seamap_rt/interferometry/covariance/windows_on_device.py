"""Sums over windows of neighbouring cells on the device: what `window_kernel` does, a lane a cell.

Phases are turned by sines and cosines of float32, to 1e-7 of a turn of a radian; the sums are of tens of cells.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compute.device import ONE_AT_A_TIME, Device, device


class CellsThere(NamedTuple):
    """Flat arrays (look, gate); 0 where a cell is not known."""

    real: Any  # of the covariance
    imag: Any
    lower: Any
    upper: Any
    known: Any
    shape: tuple[int, int]

    @classmethod
    def of(
        cls,
        cross: NDArray[np.complex128],
        lower: NDArray[np.float64],
        upper: NDArray[np.float64],
        known: NDArray[np.bool_],
    ) -> CellsThere:
        """Those of the host, placed there."""
        with ONE_AT_A_TIME:
            of = device()
            real, imag, first, second = (
                of.place_single(np.where(known, part, 0.0)) for part in (cross.real, cross.imag, lower, upper)
            )
            return cls(real, imag, first, second, of.place(known), (known.shape[0], known.shape[1]))


def windows_on_device(
    cells: CellsThere,
    range_weights: NDArray[np.float64],
    look_weights: NDArray[np.float64],
    phase_per_gate: NDArray[np.float64],
    phase_per_look: NDArray[np.float64],
    here: NDArray[np.complex128],
    there: NDArray[np.complex128],
) -> tuple[NDArray[np.complex128], NDArray[np.float64], NDArray[np.float64]]:
    """Covariance and both powers (look, gate) of windows; see `Covariance.windowed_along`.

    phase_per_gate, phase_per_look (look or 1, gate or 1) rad; here (offset, look, gate), there (look, gate): what turns
    by the level of the sea so many gates on as seen from the cell, and back by the neighbour's own.
    """
    looks, gates = cells.shape
    with ONE_AT_A_TIME:
        of = device()
        dr, lane = of.dr, of.dr.arange(of.UInt32, looks * gates)
        look, gate = lane // gates, lane % gates
        wide, half_range, half_look = range_weights.size, range_weights.size // 2, look_weights.size // 2
        along, aside = (_spread(of, each, look, gate) for each in (phase_per_gate, phase_per_look))
        on_range, on_look = of.place_single(range_weights), of.place_single(look_weights)
        level = None
        if here.size:
            level = [of.place_single(part) for each in (here, there) for part in (each.real, each.imag)]

        def add(k: Any, *sums: Any) -> tuple[Any, ...]:
            n, m = of.Int32(k // wide) - half_look, of.Int32(k % wide) - half_range
            beside, opposite = _inside(of, cells, look, gate, n, m), _inside(of, cells, look, gate, -n, -m)
            place = of.UInt32(of.Int32(lane) + n * gates + m)
            both = beside & opposite
            weight = dr.gather(of.Float, on_range, k % wide) * dr.gather(of.Float, on_look, k // wide)
            real, imag, lower, upper = (dr.gather(of.Float, each, place, both) for each in cells[:4])
            sine, cosine = dr.sincos(-(of.Float(m) * along + of.Float(n) * aside))
            real, imag = _product(real, imag, cosine, sine)
            if level is not None:
                own = (k % wide) * (looks * gates) + lane
                real, imag = _product(real, imag, *(dr.gather(of.Float, each, own) for each in level[:2]))
                real, imag = _product(real, imag, *(dr.gather(of.Float, each, place, both) for each in level[2:]))
            weight = dr.select(both, weight, 0.0)
            added = (weight * real, weight * imag, weight * lower, weight * upper, weight)
            return k + 1, *(s + each for s, each in zip(sums, added, strict=True))

        state = dr.zeros(of.UInt32, looks * gates), *(dr.zeros(of.Float, looks * gates) for _ in range(5))
        *sums, weights = dr.while_loop(state, lambda k, *_: k < wide * look_weights.size, add)[1:]
        known = dr.gather(of.Bool, cells.known, lane)
        means = [dr.select(known, each / weights, of.Float(np.nan)) for each in sums]
        dr.eval(means)
        real, imag, lower, upper = (of.fetch(each, cells.shape).astype(np.float64) for each in means)
    return real + 1j * imag, lower, upper


def _spread(of: Device, field: NDArray[np.float64], look: Any, gate: Any) -> Any:
    """A field (look or 1, gate or 1) at each cell."""
    rows, columns = field.shape
    place = (look if rows > 1 else of.UInt32(0)) * columns + (gate if columns > 1 else of.UInt32(0))
    return of.dr.gather(of.Float, of.place_single(field), place)


def _inside(of: Device, cells: CellsThere, look: Any, gate: Any, n: Any, m: Any) -> Any:
    """Whether the cell n looks and m gates on is there and known."""
    looks, gates = cells.shape
    row, column = of.Int32(look) + n, of.Int32(gate) + m
    there = (row >= 0) & (row < looks) & (column >= 0) & (column < gates)
    return of.dr.gather(of.Bool, cells.known, of.UInt32(row * gates + column), there)


def _product(a: Any, b: Any, c: Any, d: Any) -> tuple[Any, Any]:
    return a * c - b * d, a * d + b * c
