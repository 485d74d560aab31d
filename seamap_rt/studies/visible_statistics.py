"""Bands from independent realisations, the range at which half is shadowed, and quantiles of counted lengths.

Neighbouring azimuths and range bins share crests: they are not independent, and no band here counts them as if they
were. One seed is one draw, whatever it holds; bands are Student's, with one degree of freedom less than seeds.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from .paired import FEWEST_SEEDS

CONFIDENCE = 0.95
HALF = 0.5
_SMOOTHED = 0.25  # of the range, standard deviation
_NOTHING = 1e-9  # of the sea shadowed: rounding

Array = NDArray[np.float64]


def jackknife(
    statistic: Callable[[Array], Array], draws: Array, within: tuple[float, float] = (-np.inf, np.inf)
) -> tuple[Array, Array, Array]:
    """A statistic of the mean over draws (draw, …), and its 95 % band: estimate, low, high; within: what it can be.

    Quenouille's and Tukey's pseudo-values: for a statistic that is linear in the mean, the mean's own t band. NaN bands
    of fewer draws than FEWEST_SEEDS, and where the statistic is not defined without one of the draws.
    """
    number = len(draws)
    whole = statistic(draws.mean(axis=0))
    if number < FEWEST_SEEDS:
        unknown = np.full(np.shape(whole), np.nan)
        return whole, unknown, unknown
    total = draws.sum(axis=0)
    without = np.stack([statistic((total - draw) / (number - 1)) for draw in draws])
    spread = np.std((number - 1) * without, axis=0, ddof=1) / np.sqrt(number)
    reach = stdtrit(number - 1, 0.5 + 0.5 * CONFIDENCE) * spread
    low, high = (np.clip(each, *within) for each in (whole - reach, whole + reach))
    return whole, low, high


def half_range(middle: Array, share: Array) -> Array:
    """Range [m] (…) at which the visible share (…, bin) falls through one half; NaN where it does not.

    Of the curve smoothed over about a quarter of the range to either side: in any one sea crests stand where they
    stand, and the first of the many crossings of the ragged curve would lie too near. Linear between the bins' middles
    (bin,).
    """
    smooth = np.asarray(share, dtype=np.float64) @ _smoothing(middle).T
    falling = np.minimum.accumulate(smooth, axis=-1)
    after = np.argmax(falling < HALF, axis=-1)
    crosses = np.isfinite(falling[..., -1]) & (after > 0)  # 0: all above, or the first below
    after = np.maximum(after, 1)
    above, below = (np.take_along_axis(falling, (after - n)[..., None], -1)[..., 0] for n in (1, 0))
    part = (above - HALF) / np.where(crosses, above - below, 1.0)
    return np.where(crosses, middle[after - 1] + part * (middle[after] - middle[after - 1]), np.nan)


def why_no_half(middle: Array, share: Array) -> str:
    """Why a curve of shares (bin,) has no `half_range`; empty if it has one."""
    if np.isnan(share).any():
        return "not known"
    if share.min() > 1.0 - _NOTHING:
        return f"nothing is shadowed within {middle[-1]:.0f} m"
    if np.isfinite(half_range(middle, share)):
        return ""
    if float(_smoothing(middle)[0] @ share) < HALF:
        return f"less than half is visible from {middle[0]:.0f} m on"
    return f"half or more is visible to {middle[-1]:.0f} m"


def _smoothing(middle: Array) -> Array:
    """(bin, bin) weights of a straight line fitted about each bin in the logarithm of range, each bin by its area."""
    away = np.log(middle) - np.log(middle)[:, None]
    weight = np.exp(-0.5 * (away / _SMOOTHED) ** 2) * middle
    zeroth, first, second = ((weight * away**power).sum(axis=1, keepdims=True) for power in range(3))
    return weight * (second - first * away) / (zeroth * second - first**2)


def neighbour_correlation(draws: Array, axis: int) -> float:
    """Correlation of neighbours along an axis, of what draws (draw, …) differ by from their mean: 0 if independent.

    NaN for a single draw, or where draws do not differ."""
    moved = np.moveaxis(draws - draws.mean(axis=0), axis, 0)
    one, other = moved[:-1], moved[1:]
    square = np.sum(one**2) * np.sum(other**2)
    return float(np.sum(one * other) / np.sqrt(square)) if square > 1e-24 else np.nan


def count_quantile(counts: NDArray[np.int64], share: float, room: NDArray[np.int64]) -> Array:
    """Quantile (…, bin) in steps of how often each length (…, bin, length) was counted; NaN without any.

    The last length counts runs cut short at the end of the mesh, none of them shorter than `room` (bin,): quantiles up
    to there are right all the same, and those beyond are NaN.
    """
    reached = np.cumsum(counts, axis=-1)
    number = reached[..., -1]
    length = np.argmax(reached >= share * number[..., None], axis=-1)
    return np.where((number > 0) & (length <= room), length, np.nan)
