"""Slopes by weighted local planes: differencing neighbouring cells would amplify their noise.

A plane is as long as errors make it, and stands for the mean slope of its middle cell. How far off that is, by short
waves that it smooths as well, follows from the sea's covariance where the estimator knows it (`optimal`).

The share of each cell that the radar sees, from the echo alone, and by how much that stands above the cell's mean.

Two observations are combined by Bayes' rule. Without them, a place of outward slope m is in sight with Smith's share S
(1967), which needs the sea's rms slope and the grazing angle. Then the echo is held against that of a lit cell: power p
means "lit" with the odds p : c, c what shadow's edge and noise leave in the dark. A crest half in the dark turns its
steep side to the radar and echoes as a whole cell does, in HH more than that: what answers is not lit all over, but
hides a part of 1 − S. A sea too flat to cast shadows has none, however its echo fades.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import uniform_filter1d
from scipy.special import erf, erfcx

from ..compute.compiled import compiled
from ..compute.machine import run_blocks
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
    run_blocks(lambda *looks: fit_planes(*looks, z, w, points, away, limits, least, slopes), shape[0])
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


_STEEPER = 2.95  # rms slope of a wind sea down to decimetres over that of the planes (its spectrum is ∝ 1/k)
_STEEPEST = 0.5  # slope of a crest about to break: 120° between its sides would be 0.58 (Stokes 1880)
_EVEN_ODDS = 0.2  # of a lit cell's power: as likely the skirt of shadow's edge as a lit cell's faded speckle
_PLANES = 0.65  # weight of Smith's odds: the slope is that of a plane of 6 m and more, not of the cell
_STILL_HIDDEN = 0.15  # of what Smith hides, in cells that answer as lit ones do
_NEIGHBOUR_GATE, _NEIGHBOUR_LOOK = 0.6, 0.3  # weights: half a gate's response is its neighbour's, a look's a third
# Independent samples in a cell and its eight neighbours: their speckle differs, the shadow's edge does not.
_OBSERVATIONS = 2.0
_SURE = 1e-3  # a single cell's power counts for odds of a thousand at most
_CONFIDENCE = 3.0  # the share is known as from three draws, lit or dark: variance f(1 − f)/(3 + 1)
SHADOW_WINDOW = 27.0, 16.5  # deg and m, as wide as half a wave: what a crest hides and what it lights are in one mean
_DEPTH = 0.28  # of σ √(L ℓ), a wholly hidden cell's mean depth below what is seen of it: ray-traced wind seas


@dataclass(frozen=True)
class Shadow:
    """Of each cell (look, gate), from the echo alone; NaN where it is undefined."""

    visible_share: Map  # of its horizontal area, 0 to 1
    crest_bias: Map  # m, expected excess of the visible part's height over the whole cell's mean
    hidden_std: Map  # m, how far that excess may be off


def shadow(
    power: Map,
    lit: Map,
    slope_range: Map,
    slope_rms: float,
    grazing: Map,
    cell: tuple[float, Map | float],
    known: NDArray[np.bool_] | None = None,
    noise: float = 0.0,
) -> Shadow:
    """Visible share and crest bias of the cells of a turn.

    power (look, gate): a dwell's echo power without noise [W], not averaged over gates; lit: what a lit cell would have
    (`quality.lit_power`); slope_range: outward slopes found, NaN where unknown; slope_rms: as `rms_slope` gives it;
    grazing: tan ψ of mean sea level; cell: its length and its width [m]. Arrays broadcast to (look, gate). known: cells
    that count, by default all of finite power. noise: rms [W] of what noise leaves in a power.
    """
    share = visible_share(power, lit, slope_range, slope_rms, grazing, noise)
    share = np.where(np.isfinite(power) if known is None else known & np.isfinite(power), share, np.nan)
    bias, spread = crest_bias(share, slope_rms, *cell)
    return Shadow(share, bias, spread)


def rms_slope(slope_range: Map, height_std: Map) -> float:
    """Rms outward slope of the sea down to decimetres, from those of the planes that were fitted to the map.

    Weighted by the inverse variance of the heights [m], that is by the near cells, which see all of the sea and make
    little noise; the best tenth counts alike, and a plane steeper than any wave as one of these. 0 if none is known.
    """
    known = np.isfinite(slope_range) & (height_std > 0.0)
    if not known.any():
        return 0.0
    slope, spread = np.clip(slope_range[known], -_STEEPEST, _STEEPEST), height_std[known]
    weight = np.maximum(spread, np.quantile(spread, 0.1)) ** -2.0
    return _STEEPER * float(np.sqrt(np.sum(weight * slope**2) / weight.sum()))


def visible_share(power: Map, lit: Map, slope: Map, slope_rms: float, grazing: Map, noise: float = 0) -> Map:
    """Share (look, gate) of each cell in sight: the expectation, given slope and echo. Arguments as in `shadow`."""
    with np.errstate(invalid="ignore", divide="ignore"):
        answer = np.where(lit > 0.0, np.maximum(np.nan_to_num(power), 0.0), 1.0)
        answer = answer / (answer + np.where(lit > 0.0, _EVEN_ODDS * lit + noise, _EVEN_ODDS))
    answer = np.clip(_smoothed(answer), _SURE, 1.0 - _SURE)
    if not slope_rms > 0.0:
        return np.ones(answer.shape)
    before = smith_odds(np.nan_to_num(slope), slope_rms, grazing)
    odds = before**_PLANES * (answer / (1.0 - answer)) ** _OBSERVATIONS
    return odds / (1.0 + odds) * (1.0 - _STILL_HIDDEN / (1.0 + before))


def smith_odds(slope: Map, slope_rms: float, grazing: Map) -> Map:
    """Odds that a place of that outward slope is in sight, in sight : hidden. Arrays broadcast.

    S = Φ((tan ψ + m)/σ)/(1 + Λ), Λ as in Smith, IEEE Trans. Antennas Propag. 15(5), 668–671 (1967): the first factor
    is the share of a cell about the plane found that does not turn away from the radar (his step function, the waves
    shorter than the plane as steep as all), the second that no crest in front hides it.
    """
    v = np.maximum(grazing, 0.0) / (np.sqrt(2.0) * slope_rms)
    with np.errstate(divide="ignore", over="ignore"):
        blocking = 0.5 * np.exp(-np.square(v)) * np.maximum(1.0 / (v * np.sqrt(np.pi)) - erfcx(v), 0.0)
    share = 0.5 * (1.0 + erf((grazing + slope) / (np.sqrt(2.0) * slope_rms))) / (1.0 + blocking)
    share = np.clip(share, 1e-6, 1.0 - 1e-9)
    return share / (1.0 - share)


def crest_bias(share: Map, slope_rms: float, length: float, width: Map | float) -> tuple[Map, Map]:
    """Expected excess [m] of the visible part's mean height over the whole cell's, and its standard deviation.

    The hidden part, a share 1 − f, falls away from the visible part's edge: its depth grows as its length does, and the
    mean loses (1 − f)² A. A = 0.28 σ √(L ℓ) for cells of length L and diagonal ℓ [m]: heights of a wind sea drift apart
    as the root of the distance. Depths scatter as exponential ones, by as much as their mean. The share is itself
    uncertain: moments of 1 − f are those of a beta distribution.
    """
    depth = _DEPTH * slope_rms * np.sqrt(length * np.hypot(length, width))
    hidden = _CONFIDENCE * (1.0 - share)
    square = hidden * (hidden + 1.0) / (_CONFIDENCE * (_CONFIDENCE + 1.0))
    fourth = square * (hidden + 2.0) * (hidden + 3.0) / ((_CONFIDENCE + 2.0) * (_CONFIDENCE + 3.0))
    mean = depth * square
    return mean, np.sqrt(np.maximum(2.0 * depth**2 * fourth - mean**2, 0.0))


def diffraction_error(
    share: Map, height: Map, spread: Map, ranges: Map, grid: tuple[float, float, bool], angle: float
) -> Map:
    """Error [m] (look, gate) of heights by light that bends over the crests before them.

    The angle of arrival errs where crests are near the ray, so with the hidden share of the water around a cell; and
    no height errs by more than the sea's own rms. share, height, spread (look, gate): visible share, NaN where nothing
    echoes, which counts as hidden; height and its error [m], NaN where unknown; ranges (gate,) m, above 0; grid: width
    of a look [deg], spacing of gates [m], and whether the looks close a circle; angle: the error [rad] if all around
    were hidden.
    """
    known = np.isfinite(height) & (spread > 0.0) & np.isfinite(spread)
    if angle == 0.0 or not known.any():
        return np.zeros(height.shape)
    weight = np.where(known, np.maximum(spread, np.quantile(spread[known], 0.1)), np.inf) ** -2.0
    level = np.where(known, height, 0.0)
    mean = np.sum(weight * level) / weight.sum()
    sea = max(float(np.sqrt(np.sum(weight * (level - mean) ** 2) / weight.sum())), 1e-6)
    width, spacing, closed = grid
    size = [
        1 + 2 * round(0.5 * (each / step - 1.0)) for each, step in zip(SHADOW_WINDOW, (width, spacing), strict=True)
    ]
    seen = uniform_filter1d(np.nan_to_num(share), max(1, size[0]), axis=0, mode="wrap" if closed else "nearest")
    hidden = 1.0 - uniform_filter1d(seen, max(1, size[1]), axis=1, mode="nearest")
    return diffraction_height_error(hidden, ranges, sea, angle)


def diffraction_height_error(hidden: Map, ranges: Map, sea: float, angle: float) -> Map:
    """Error [m] (look, gate) of heights where a share `hidden` of the water around is hidden: the angle [rad] times the
    range [m] and the root of the share, at most the sea's rms height [m]. Angle and sea above 0."""
    return np.sqrt(np.clip(hidden, 0.0, 1.0)) / np.hypot(1.0 / (angle * ranges), 1.0 / sea)


def _smoothed(field: Map) -> Map:
    """Weighted mean over a cell and its eight neighbours; at the edges over those that there are."""
    for axis, weight in ((0, _NEIGHBOUR_LOOK), (1, _NEIGHBOUR_GATE)):
        moved = np.moveaxis(field, axis, 0)
        total, weights = moved.copy(), np.ones(moved.shape[0])
        total[1:] += weight * moved[:-1]
        total[:-1] += weight * moved[1:]
        weights[1:] += weight
        weights[:-1] += weight
        field = np.moveaxis(total / weights[:, None], 0, axis)
    return field
