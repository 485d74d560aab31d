"""What of each cell the radar sees, from the echo alone, and by how much what it sees stands above the cell's mean.

Two observations are combined by Bayes' rule. Without them, a place of outward slope m is in sight with Smith's share S
(1967), which needs the sea's rms slope and the grazing angle. Then the echo is held against that of a lit cell: power p
means "lit" with the odds p : c, c what shadow's edge and noise leave in the dark. A crest half in the dark turns its
steep side to the radar and echoes as a whole cell does, in HH more than that: what answers is not lit all over, but
hides a part of 1 − S. A sea too flat to cast shadows has none, however its echo fades.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf, erfcx

Field = NDArray[np.float64]

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
_DEPTH = 0.28  # of σ √(L ℓ), a wholly hidden cell's mean depth below what is seen of it: ray-traced wind seas


@dataclass(frozen=True)
class Shadow:
    """Of each cell (look, gate), from the echo alone; NaN where it is undefined."""

    visible_share: Field  # of its horizontal area, 0 to 1
    crest_bias: Field  # m, expected excess of the visible part's height over the whole cell's mean
    hidden_std: Field  # m, how far that excess may be off


def shadow(
    power: Field,
    lit: Field,
    slope_range: Field,
    slope_rms: float,
    grazing: Field,
    cell: tuple[float, Field | float],
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


def rms_slope(slope_range: Field, height_std: Field) -> float:
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


def visible_share(power: Field, lit: Field, slope: Field, slope_rms: float, grazing: Field, noise: float = 0) -> Field:
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


def smith_odds(slope: Field, slope_rms: float, grazing: Field) -> Field:
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


def crest_bias(share: Field, slope_rms: float, length: float, width: Field | float) -> tuple[Field, Field]:
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


def _smoothed(field: Field) -> Field:
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
