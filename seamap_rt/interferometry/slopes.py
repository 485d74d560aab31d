"""Slopes by weighted local planes: differencing neighbouring cells would amplify their noise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Cells = tuple[NDArray[np.intp], ...]  # an index of a map
Offsets = Callable[[Cells, Cells], tuple[NDArray[np.float64], NDArray[np.float64]]]


def local_plane(
    height: NDArray[np.float64],
    weight: NDArray[np.float64],
    along: NDArray[np.float64],
    across_spacing: NDArray[np.float64],
    reach: tuple[int, int],
    closed: bool,
    offsets: Offsets | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Slopes along and across the look (look, gate) of the plane fitted to each cell's neighbours.

    height, weight, along (ground range) and across_spacing (metres between neighbouring looks) are (look, gate); NaN
    heights count nothing. `reach` is (looks, gates) to either side. NaN where the neighbours do not span a plane.
    `closed`: look 0 follows the last one. `offsets`: how far from cells others lie, outward and clockwise [m], where
    that is more than the differences in `along` and across_spacing.
    """
    good = np.isfinite(height) & np.isfinite(along) & (weight > 0.0)
    z, w = np.where(good, height, 0.0), np.where(good, weight, 0.0)
    x = np.where(good, along, 0.0)
    names = ("w", "x", "y", "xx", "xy", "yy", "z", "xz", "yz")
    sums = {name: np.zeros_like(z) for name in names}
    looks, gates = height.shape
    for look in range(-reach[0], reach[0] + 1):
        for gate in range(-reach[1], reach[1] + 1):
            rows, there = _shifted(looks, look, closed)
            low, high = max(0, -gate), gates - max(0, gate)
            target = np.ix_(rows, np.arange(low, high))
            source = np.ix_(there, np.arange(low + gate, high + gate))
            ww, zz = w[source], z[source]
            # Coordinates relative to the cell itself keep the sums well conditioned.
            if offsets is None:
                xx = x[source] - np.where(good[target], x[target], x[source])
                yy = look * across_spacing[target]
            else:
                both = good[target] & good[source]
                xx, yy = (np.where(both, each, 0.0) for each in offsets(target, source))
            for name, value in zip(names, (1.0, xx, yy, xx * xx, xx * yy, yy * yy, zz, xx * zz, yy * zz), strict=True):
                sums[name][target] += ww * value
    s = sums
    with np.errstate(invalid="ignore", divide="ignore"):
        mx, my, mz = s["x"] / s["w"], s["y"] / s["w"], s["z"] / s["w"]
        xx, yy = s["xx"] / s["w"] - mx * mx, s["yy"] / s["w"] - my * my
        xy = s["xy"] / s["w"] - mx * my
        xz, yz = s["xz"] / s["w"] - mx * mz, s["yz"] / s["w"] - my * mz
        determinant = xx * yy - xy * xy
        spans = good & (determinant > 1e-3 * np.maximum(xx, 1e-12) * np.maximum(yy, 1e-12))
        outward = np.where(spans, (xz * yy - yz * xy) / determinant, np.nan)
        clockwise = np.where(spans, (yz * xx - xz * xy) / determinant, np.nan)
    return outward, clockwise


def _shifted(count: int, shift: int, closed: bool) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows that have a neighbour `shift` rows on, and those neighbours."""
    rows = np.arange(count)
    if closed:
        return rows, (rows + shift) % count
    rows = rows[(rows + shift >= 0) & (rows + shift < count)]
    return rows, rows + shift
