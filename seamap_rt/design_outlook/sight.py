"""What of each strip's cells is seen from the lower antenna: by the horizon, a step of the surface at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..compute.compiled import compiled
from .strips import LOOKS, ROWS, Strips

Array = NDArray[np.float64]

STARTS = 3  # places of the mast on a strip
TABLE = 512  # entries by the local grazing angle's tangent t, even in t/(1 + t)


class Sight(NamedTuple):
    """Means over a gate's length of single rows, (look, row, gate)."""

    visible: NDArray[np.float32]  # share of the ground
    height: NDArray[np.float32]  # m, of all of it
    lit_height: NDArray[np.float32]  # m times the share that is seen
    echo: NDArray[np.float32]  # σ0 before calibration, per ground


def table_grazing() -> Array:
    """Local grazing angles [rad] (TABLE,) of echo tables, from 0 to π/2."""
    even = np.linspace(0.0, 1.0, TABLE)
    return np.arctan2(even, 1.0 - even)


def sight(strips: Strips, eye_m: ArrayLike, edges: tuple[Array, Array], echo: Array, in_sight: Array) -> Sight:
    """What a mast sees that stands at several places of each strip, one after the other along the first axis.

    eye_m: height of the lower antenna over mean sea level, of all places or (place,). edges: ground ranges [m] at which
    gates begin and end, (gate,). echo: σ0 (look, TABLE) per ground, at the grazing angles of `table_grazing`; in_sight:
    likewise, the share of what the strips light that shorter waves leave in sight. Strips repeat.
    """
    steps = strips.distance.size
    first, last = (np.clip(np.rint(each / strips.step), 0, steps - 1).astype(np.int64) for each in edges)
    last = np.maximum(last, first + 1)
    starts = np.arange(STARTS) * (steps // STARTS)
    shape = (STARTS * LOOKS, ROWS, first.size)
    eyes = np.broadcast_to(np.asarray(eye_m, dtype=np.float64), STARTS).copy()
    made = Sight(*(np.empty(shape, np.float32) for _ in Sight._fields))
    tables = np.stack((echo, in_sight), axis=-1).astype(np.float32)
    _look(strips.height, strips.step, eyes, starts, first, last, tables, *made)
    return made


@compiled
def _look(height, step, eyes, starts, first, last, table, visible, mean, lit_mean, echo):
    looks, rows, steps = height.shape
    entries = table.shape[1] - 1
    reach = last[-1]
    sums = np.zeros((4, reach + 1))
    for place in range(starts.size * looks):
        look, start, eye = place % looks, starts[place // looks], eyes[place // looks]
        for row in range(rows):
            z = height[look, row]
            horizon = -np.inf
            here = start
            for n in range(reach):
                near = step * (n + 0.5)
                there = here + 1 if here + 1 < steps else 0
                horizon = max(horizon, (z[here] - eye) / near)
                middle, rise = 0.5 * (z[here] + z[there]), (z[there] - z[here]) / step
                here = there
                view = (middle - eye) / (near + 0.5 * step)
                lit = 1.0 if view > horizon else 0.0
                strength = 0.0
                if lit > 0.0:
                    up = max(rise - view, 0.0)  # over 1 + rise · view, as tangents subtract
                    at = entries * up / (up + max(1.0 + rise * view, 1e-6))
                    entry = min(int(at), entries - 1)
                    part = at - entry
                    strength = table[look, entry, 0] * (1.0 - part) + table[look, entry + 1, 0] * part
                    lit = table[look, entry, 1] * (1.0 - part) + table[look, entry + 1, 1] * part
                sums[0, n + 1] = sums[0, n] + lit
                sums[1, n + 1] = sums[1, n] + middle
                sums[2, n + 1] = sums[2, n] + lit * middle
                sums[3, n + 1] = sums[3, n] + strength
            for gate in range(first.size):
                begin, end = first[gate], last[gate]
                share = 1.0 / (end - begin)
                visible[place, row, gate] = (sums[0, end] - sums[0, begin]) * share
                mean[place, row, gate] = (sums[1, end] - sums[1, begin]) * share
                lit_mean[place, row, gate] = (sums[2, end] - sums[2, begin]) * share
                echo[place, row, gate] = (sums[3, end] - sums[3, begin]) * share
