"""How much of a sea an antenna sees: random seas by their slopes, and a sinusoid exactly."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import erf, erfcx

_HALVINGS = 80  # of a bracket that is at most a wave long: down to float64's own spacing


def shadowing_smith67(v: ArrayLike) -> NDArray[np.float64]:
    """Visible share S = ½ (1 + erf v)/(1 + Λ) of a Gaussian sea; v = tan ψ/(√2 σ) ≥ 0.

    σ is the rms slope along the look. Smith, IEEE Trans. Antennas Propag. 15(5), 668–671 (1967). It
    overestimates what rays see by 3–16 %: heights and slopes are taken as uncorrelated along the ray. 0 at v
    = 0; ValueError for a negative v.
    """
    v = _not_negative("v", v)
    return 0.5 * (1.0 + erf(v)) / (1.0 + _lambda(v))


def shadowing_wagner67(v: ArrayLike) -> NDArray[np.float64]:
    """Visible share S = ½ (1 + erf v)(1 − e^−Λ)/Λ of a Gaussian sea; v as for `shadowing_smith67`.

    Wagner, J. Acoust. Soc. Am. 41(1), 138–147 (1967). It overestimates what rays see by 20–45 %.
    """
    v = _not_negative("v", v)
    blocking = _lambda(v)
    some = blocking > 0.0
    unblocked = np.where(some, -np.expm1(-blocking) / np.where(some, blocking, 1.0), 1.0)
    return 0.5 * (1.0 + erf(v)) * unblocked


def sinusoid_shadowed_fraction(m: ArrayLike) -> NDArray[np.float64]:
    """Shadowed share of z = a cos kx under parallel rays, exactly; m = tan ψ/(ak) ≥ 0.

    1 at m = 0, 0 from m = 1 on; ValueError for a negative m. The ray leaves the surface at the phase φt past
    the crest, sin φt = m, and meets it again at the root φe of cos φ + m φ = cos φt + m φt: the share is (φe
    − φt)/2π.
    """
    m = np.minimum(_not_negative("m", m), 1.0)
    leaves = np.arcsin(m)
    level = np.cos(leaves) + m * leaves
    meets = _bisect(lambda phi: np.cos(phi) + m * phi - level, np.pi - leaves, 2.0 * np.pi + leaves)
    return np.where(m < 1.0, (meets - leaves) / (2.0 * np.pi), 0.0)


def sinusoid_visible_intervals(
    height_m: float,
    wavelength_m: float,
    antenna_height_m: float,
    range_min: float,
    range_max: float,
    phase: float = 0.0,
    direction: Literal[1, -1] = 1,
) -> tuple[NDArray[np.float64], float]:
    """What an antenna over x = 0 sees of z = (height/2) cos(kx + phase), exactly: intervals and share.

    The intervals (n, 2) are ground ranges [m], in order, clipped to range_min–range_max, along +x or, with
    direction −1, along −x; the share is their length over the window's. height_m: crest to trough.
    antenna_height_m: above the mean level. ValueError for an antenna under water, a negative height, a
    wavelength that is not positive or an empty window.

    The ray's rise t(x) = (z − H)/x has at most one maximum per crest, where the tangent from the antenna
    touches it, H − z = −x z′; it lies between the crest's two inflections, and exists beyond the range
    H/(ak). A crest is seen only from where t passes the greatest t of all crests before it, to its own
    tangent point.
    """
    if not (height_m >= 0.0 and wavelength_m > 0.0):
        raise ValueError(
            f"height_m = {height_m}, wavelength_m = {wavelength_m}: need a height ≥ 0 and a wavelength > 0"
        )
    if not 0.0 <= range_min < range_max < np.inf:
        raise ValueError(f"range_min = {range_min}, range_max = {range_max}: need 0 ≤ range_min < range_max, finite")
    k = 2.0 * np.pi / wavelength_m
    a = 0.5 * height_m
    offset = float(np.remainder(direction * phase, 2.0 * np.pi))
    if not antenna_height_m > a * np.cos(offset):
        raise ValueError(f"antenna_height_m = {antenna_height_m}: is not above the water below it")

    def rise(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray((a * np.cos(k * x + offset) - antenna_height_m) / x, dtype=np.float64)

    def steepening(x: NDArray[np.float64]) -> NDArray[np.float64]:  # x² dt/dx
        angle = k * x + offset
        return antenna_height_m - a * np.cos(angle) - k * x * a * np.sin(angle)

    # crests by their number: the inflections before and after; kept where the far side falls below the ray
    crest = np.arange(0, int(np.ceil((k * range_max + offset) / (2.0 * np.pi))) + 1)
    before = (2.0 * np.pi * crest - 0.5 * np.pi - offset) / k
    after = before + 0.5 * wavelength_m
    reached = before - 0.5 * wavelength_m < range_max  # its face, if not its crest, lies before the end
    tangent_exists = (after > 0.0) & (after * a * k > antenna_height_m) & reached
    before, after = before[tangent_exists], after[tangent_exists]
    touches = _bisect(lambda x: -steepening(x), np.maximum(before, 0.0), after)
    horizon = np.maximum.accumulate(rise(touches))

    if touches.size == 0:
        starts, ends = np.array([0.0]), np.array([range_max])
    else:
        trough = _bisect(steepening, after[:-1], before[1:])  # where t is least, between two crests
        seen = rise(touches[1:]) > horizon[:-1]
        level = horizon[:-1][seen]
        emerges = _bisect(lambda x: rise(x) - level, trough[seen], touches[1:][seen])
        starts, ends = np.append(0.0, emerges), np.append(touches[0], touches[1:][seen])
    starts, ends = np.clip(starts, range_min, range_max), np.clip(ends, range_min, range_max)
    intervals = np.column_stack((starts, ends))[ends > starts]
    return intervals, float(np.sum(intervals[:, 1] - intervals[:, 0]) / (range_max - range_min))


def visible_share(intervals: NDArray[np.float64], edges: ArrayLike) -> NDArray[np.float64]:
    """Share of each range bin (edges (bins + 1,) [m], rising) that disjoint intervals (n, 2) cover."""
    edges = np.asarray(edges, dtype=np.float64)
    covered = np.clip(edges[:, None], intervals[:, 0], intervals[:, 1]) - intervals[:, 0]
    return np.diff(covered.sum(axis=1)) / np.diff(edges)


def _lambda(v: NDArray[np.float64]) -> NDArray[np.float64]:
    """Smith's Λ = ½ [exp(−v²)/(v√π) − erfc v], with the exponential in front so that large v lose nothing."""
    with np.errstate(divide="ignore", over="ignore"):
        return 0.5 * np.exp(-np.square(v)) * np.maximum(1.0 / (v * np.sqrt(np.pi)) - erfcx(v), 0.0)


def _not_negative(name: str, value: ArrayLike) -> NDArray[np.float64]:
    array = np.asarray(value, dtype=np.float64)
    if not np.all(array >= 0.0):
        raise ValueError(f"{name} must be 0 or more")
    return array


def _bisect(
    function: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    low: ArrayLike,
    high: ArrayLike,
) -> NDArray[np.float64]:
    """Root of a function that is negative at `low` and positive at `high`, each element apart."""
    low, high = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        above = function(middle) > 0.0
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return 0.5 * (low + high)
