"""Optimal interpolation of a sea's heights: the linear mean of a cell's neighbours whose expected error is least.

Gandin 1963, Bretherton, Davis & Fandry 1976. Of measured heights y with error covariance R and a sea of mean level 0
and covariance C the mean of a cell is kᵀ(C + R)⁻¹y, of variance k₀ − kᵀ(C + R)⁻¹k, k the sea's covariance between the
cell's mean and the points of y. The window thus adapts itself: it is short where the echo is strong and clear, long
where it is weak, and longer along the crests than across. A measured height is the mean over the pulse's and the beam's
footprint, so that its covariances are those of the sea blurred by it, once towards a point and twice between two of
them; what it flattens is restored as far as errors allow, and what they do not is part of the variance.

A cell's mean slope errs alike, by s₀ − cᵀ(C + R)⁻¹c: s₀ the sea's variance of it, c its covariance with the points
of y. Of this wᵀRw, w = (C + R)⁻¹c, is due to the errors of y. Where y differs from what its neighbours make it expected
to be by more than C + R say (innovations, Kalman 1960), they are as much larger.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...compute.machine import pool
from .error_covariance import ErrorCovariance
from .optimal_kernel import BLOCK, MOST_LOOKS, Cells, ErrorTables, HalfCell, SeaTables, interpolate
from .sea_covariance import SeaCovariance


ACROSS_M = 6.5  # neighbouring looks as far as this, one at least
_MOST_VARIANCE = 6.0  # error variance over the sea's: such a height has no weight
_GAUSS = 1.0 / np.sqrt(3.0)
_BLURS = 4  # tables of the covariance, of means over areas as large as the beam's footprint from near to far


@dataclass(frozen=True)
class MeasuredHeights:
    """Heights as measured, all (look, gate); NaN where there is none."""

    height: Map  # m
    errors: ErrorCovariance
    ground: tuple[Map, Map]  # m east and north, where they lie
    outward: tuple[Map, Map]  # east and north of the direction from the radar
    blur: Map  # (gate,) m², variance a side of the area that a height is the mean of


def optimal_heights(
    measured: MeasuredHeights,
    sea: SeaCovariance,
    wanted: NDArray[np.bool_],
    cell: tuple[float, float],
    ranges: Map,
    tasks: int = 32,
) -> tuple[Map, Map, Map]:
    """Mean heights [m] of wanted cells, their variances [m²], both (look, gate), and the variances of the cells' mean
    slopes outward and clockwise and their covariance (3, look, gate); NaN elsewhere.

    cell: its length along the look [m] and its width [rad]; ranges (gate,) [m]. tasks: blocks of gates that threads
    take; no bit depends on them.
    """
    shape = measured.height.shape
    (x, y), (east, north) = measured.ground, (np.broadcast_to(each, shape) for each in measured.outward)
    lying = np.isfinite(x) & np.isfinite(y) & np.isfinite(east) & np.isfinite(north)
    variance = measured.errors.variance
    usable = lying & np.isfinite(measured.height) & (variance < _MOST_VARIANCE * sea.variance)
    parts = np.where(usable, measured.errors.parts, np.nan)
    points = np.stack([np.where(lying, each, 0.0) for each in (x, y, east, north)])
    width = cell[1] * ranges
    looks = np.clip(np.round(ACROSS_M / np.maximum(width, 1e-9)), 1, MOST_LOOKS).astype(np.int64)
    half = HalfCell(0.5 * _GAUSS * cell[0], 0.5 * _GAUSS * width)
    blurs = np.linspace(measured.blur.min(), measured.blur.max(), _BLURS)
    level = np.abs(measured.blur[:, None] - blurs).argmin(axis=1)
    tables = np.stack([np.stack((sea.table, sea.blurred(blur), sea.blurred(2.0 * blur))) for blur in blurs])
    estimate = np.full((5, *shape), np.nan)

    given = (
        Cells(measured.height, parts, points, wanted & lying, looks),
        SeaTables(tables, level, sea.spacing),
        half,
        ErrorTables(np.ascontiguousarray(measured.errors.along), measured.errors.beside),
    )

    def blocks(first: int, last: int) -> None:
        interpolate(*given, first, last, estimate)

    edges = np.linspace(0, -(-shape[1] // BLOCK), tasks + 1).astype(int)
    with pool() as workers:
        list(workers.map(blocks, edges[:-1], edges[1:]))
    return estimate[0], estimate[1], estimate[2:]
