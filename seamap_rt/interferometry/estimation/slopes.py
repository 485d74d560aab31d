"""Slopes by weighted local planes: differencing neighbouring cells would amplify their noise.

A plane is as long as errors make it, and stands for the mean slope of its middle cell. How far off that is, by short
waves that it smooths as well, follows from the sea's covariance where the estimator knows it (`optimal`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import erfcx

from ...compute.compiled import compiled
from ...compute.machine import in_blocks
from .quality import gate_median

Map = NDArray[np.float64]
Pair = tuple[Map, Map]

_TOLERATED = 0.2, 0.27  # height error over half a plane's length and width, over the sea's rms slope
_USUAL_SLOPE = 0.075  # rms slope of a sea of which it is not known
_HALF_LENGTH = 3.0, 21.0  # m: at least, at most
_HALF_WIDTH = 2.0, 6.0  # looks
_SURELY_SEEN = 4.0  # standard errors above where a slope hides itself


@dataclass(frozen=True)
class Slopes:
    """Outward and clockwise slopes (look, gate), NaN where the neighbours span no plane."""

    outward: Map
    clockwise: Map


def local_planes(
    height: NDArray[np.float64],
    weight: NDArray[np.float64],
    ground: Pair,
    outward: Pair,
    reach: tuple[ArrayLike, ArrayLike],
    least: float = 1e-3,
) -> Slopes:
    """Slopes outward and clockwise of the plane fitted to each cell's neighbours, all of it (look, gate).

    height [m] and weight; cells that are not finite or weigh nothing count nothing, and have no slope. `ground`: x and
    y [m] of the cells. `outward`: east and north of each cell's own direction; they broadcast. `reach`: how many gates
    and looks away weights have fallen to zero, by 1 − (distance/reach)² in either, (gate,) or one number each; no more
    than 1 is the cell's own. The first and the last look of a circle are no neighbours: they lie a turn apart in time.
    `least`: of the points' spread across their line, over that along it, for them to span a plane.
    """
    pieces = np.broadcast_arrays(height, weight, *ground, *outward)
    known = np.all(np.isfinite(pieces), axis=0) & (pieces[1] > 0.0)
    z, w, *rest = (np.where(known, part, 0.0) for part in pieces)
    shape = z.shape
    limits = np.stack([np.broadcast_to(np.asarray(each, dtype=np.float64), shape[1]) for each in reach])
    slopes = np.full((2, *shape), np.nan)
    points, away = np.stack(rest[:2]), np.stack(rest[2:])
    in_blocks(lambda *looks: fit_planes(*looks, z, w, points, away, limits, least, slopes), shape[0])
    return Slopes(*slopes)


def plane_reach(
    height_std: NDArray[np.float64],
    ranges: NDArray[np.float64],
    spacing: float,
    width_deg: float,
    slope_rms: float | None = None,
) -> Pair:
    """Reach (gate,) in gates and looks of planes that are as small as the heights' errors (look, gate) [m] let them be.

    Small planes follow short waves, and noise: over half a plane the gate's median error makes a fifth of the sea's rms
    slope. ranges [m] (gate,) `spacing` apart, looks width_deg apart.
    """
    error = gate_median(height_std, np.isfinite(height_std))[0] / max(slope_rms or _USUAL_SLOPE, 1e-6)
    along = np.clip(error / _TOLERATED[0], *_HALF_LENGTH) / spacing
    across = np.clip(error / _TOLERATED[1] / (ranges * np.radians(width_deg)), *_HALF_WIDTH)
    return np.maximum(along, 2.0), across


def visible_slopes(slope: Map, std: Map, tangent: Map, share: Map) -> tuple[Map, Map]:
    """Outward slopes of cells of which a share is in sight, and their standard errors; arrays broadcast.

    What is in sight leans away by less than the ray, of grazing angle ψ (tangent: tan ψ). Of a Gaussian slope of mean
    m and deviation σ that is greater than −tan ψ the mean is m + σλ and the variance σ²(1 − λ(λ + a)),
    a = (m + tan ψ)/σ, λ = φ(a)/Φ(a); the hidden share is as it was, and a slope of unknown error.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        above = (slope + tangent) / std
    near = np.isfinite(above) & (above < _SURELY_SEEN)
    more = np.zeros(near.shape)
    more[near] = np.sqrt(2.0 / np.pi) / erfcx(-above[near] / np.sqrt(2.0))
    left = 1.0 - share * more * (more + np.where(near, above, 0.0))
    return slope + np.nan_to_num(share * std * more), std * np.sqrt(left)


@compiled
def fit_planes(begin, end, height, weight, points, outward, reach, least, slopes):
    """Write looks begin … end of slopes (2, look, gate), outward and clockwise.

    Points whose spread across their line is less than a part `least` of it span no plane.
    points (2, look, gate) x and y, outward (2, look, gate) east and north, reach (2, gate) in gates and looks. Cells of
    weight 0 count nothing, but need finite numbers all the same.
    """
    looks, gates = height.shape
    for i in range(begin, end):
        for j in range(gates):
            if weight[i, j] == 0.0:
                continue
            far_gate, far_look = math.ceil(reach[0, j]) - 1, math.ceil(reach[1, j]) - 1
            rows = max(0, i - far_look), min(looks, i + far_look + 1)
            span = rows[0], rows[1], max(0, j - far_gate), min(gates, j + far_gate + 1)
            uu, uv, vv, uz, vz, spans = _moments(height, weight, points, outward, reach, i, j, span)
            determinant = uu * vv - uv * uv
            if not (spans and determinant > least * uu * vv):
                continue
            slopes[0, i, j] = (uz * vv - vz * uv) / determinant
            slopes[1, i, j] = (vz * uu - uz * uv) / determinant


@compiled
def _moments(height, weight, points, outward, reach, i, j, span):
    """Second moments of points (u, v) and heights; and whether several looks and gates have a part in them: one gate's
    own points lie on an arc, whose bend alone would seem to span a plane."""
    x, y, east, north = points[0, i, j], points[1, i, j], outward[0, i, j], outward[1, i, j]
    s = su = sv = suu = suv = svv = sz = suz = svz = of_gate = of_look = 0.0
    for a in range(span[0], span[1]):
        taper = 1.0 - ((a - i) / reach[1, j]) ** 2
        before = s
        for b in range(span[2], span[3]):
            # Relative to the cell itself, which keeps the sums well conditioned.
            dx, dy, z = points[0, a, b] - x, points[1, a, b] - y, height[a, b] - height[i, j]
            u, v = dx * east + dy * north, dx * north - dy * east
            w = weight[a, b] * taper * (1.0 - ((b - j) / reach[0, j]) ** 2)
            wu, wv = w * u, w * v
            s += w
            su += wu
            sv += wv
            suu += wu * u
            suv += wu * v
            svv += wv * v
            sz += w * z
            suz += wu * z
            svz += wv * z
        of_gate += weight[a, j] * taper
        if a == i:
            of_look = s - before
    spans = s - of_gate > 1e-9 * s and s - of_look > 1e-9 * s
    u, v, z = su / s, sv / s, sz / s
    return suu / s - u * u, suv / s - u * v, svv / s - v * v, suz / s - u * z, svz / s - v * z, spans
