"""A wrapped phase allows heights one ambiguity, λR/(pB), apart: which one a cell has, and where that is undecided.

Nothing but the mean level is known beforehand: the sea stays about it within its own size. Far out the ambiguity is
larger than any wave, and that alone decides; nearer in, the sea goes on from cell to cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from .unwrapping import unwrap

Field = NDArray[np.float64]

LEAST_ODDS = 20.0  # of the cycles taken over the next best ones, below which a cell is flagged
BEYOND = 5.0  # of the sea's rms heights; crests rise to a significant wave height and a quarter
_SLOPE = 0.14  # rms of the sea's slopes as cells of some metres show them, steep wind seas
_STRAY = 0.001  # m² per m² of distance, by which such seas are let stray from a plane
_RADIUS = 6.0  # m, of the neighbourhood: an eighth of the length of a wind sea's waves
_MOST_LOOKS = 6  # to either side
ASTRAY = (0.5 * _SLOPE * _RADIUS) ** 2  # m², of heights about their neighbourhood's mean
_CERTAIN_CYCLE = 8.0  # standard deviations to a cycle, four to half of one: then neighbours are not used
_FIXED_PRECISION = 1e9  # precision of what is settled, over that of a whole cycle
_UNIFORM_STD = np.pi / np.sqrt(3.0)  # rad, standard deviation of a phase that is uniform over the circle
_LEAST_RESULTANT = 0.3  # of a gate's phases, below which it counts as none
_FEW = 8  # cells, too few for a mean


@dataclass(frozen=True)
class Resolved:
    """Arrays (look, gate). `cycles` are to be added to the phase; 0 in unknown cells."""

    cycles: NDArray[np.int64]
    ambiguous: NDArray[np.bool_]  # another number of cycles is more likely than 1 in 20 of the one taken


@dataclass(frozen=True)
class HeightEstimate:
    """What else is known of the heights: of one way's interferogram, whose ambiguity is twice as large, or of the turn
    before. Arrays (look, gate); NaN where nothing is."""

    height: Field  # m
    std: Field  # m, how far the true height may be off


def sea_size(residual: Field, gain: Field, known: NDArray[np.bool_]) -> float:
    """Rms height [m] of the sea from wrapped phases, free of their ambiguity; arrays as those of `resolve`.

    A Gaussian phase of variance s² has ⟨cos φ⟩ = exp(−s²/2). Fitted to all gates (taken together, where looks are few)
    whose phases such a sea does not spread beyond a radian, those most whose phase is most sensitive to height. The
    farthest gates come first and say which these are: a swell of which few waves lie in the circle may leave a nearer
    gate's phases together though they are all turned. If all gates' are spread over the whole circle, what would spread
    them so in the farthest. The phases' noise is not taken off: what is compared with this size contains it too.
    """
    together = max(1, int(np.ceil(_FEW * known.shape[1] / max(1, np.count_nonzero(known)))))

    def total(field: Field) -> Field:
        return np.add.reduceat(np.where(known, field, 0.0).sum(axis=0), np.arange(0, known.shape[1], together))

    counts = total(np.ones(known.shape))
    usable = counts >= _FEW
    resultant = np.clip(total(np.cos(residual))[usable] / counts[usable], 1e-3, 1.0)
    gains = total(gain**2)[usable] / counts[usable]
    clear = resultant > _LEAST_RESULTANT
    if not clear.any():
        return float(np.sqrt(-2.0 * np.log(_LEAST_RESULTANT) * gains.max(initial=0.0)))
    variance, gains = -2.0 * np.log(resultant[clear]), gains[clear]

    def square(fitted: NDArray[np.bool_]) -> float:
        return float(np.sum((variance / gains)[fitted]) / np.sum(gains[fitted] ** -2.0))

    far = gains >= np.median(gains)
    near = gains > square(far)
    return float(np.sqrt(square(near if near.any() else far)))


def largest_size(residual: Field, gain: Field, known: NDArray[np.bool_]) -> float:
    """Rms height [m] of the largest sea that few wrapped phases allow; arrays as those of `resolve`.

    The mean cosine of n phases is known to 1/√(2n). Where thrice that less is none, no sea is too large.
    """
    gains = np.abs(gain[known])
    if not gains.size:
        return np.inf
    far = gains >= np.median(gains)
    resultant = np.mean(np.cos(residual[known][far])) - 3.0 / np.sqrt(2.0 * np.count_nonzero(far))
    if not resultant > 0.0:
        return np.inf
    return float(np.sqrt(-2.0 * np.log(min(resultant, 1.0)) * np.mean(gains[far] ** 2)))


def needed(gain: Field, known: NDArray[np.bool_], size: float) -> NDArray[np.bool_]:
    """Gates (gate,) in which a sea of that rms height [m] reaches beyond half an ambiguity, π |dz/dφ|."""
    with np.errstate(invalid="ignore"):
        return np.any(known & (np.pi * np.abs(gain) < BEYOND * size), axis=0)


def astray(off: Field, step: Field) -> NDArray[np.bool_]:
    """Cells whose height may well lie on another cycle than the one that is nearest to its neighbourhood's mean.

    Arrays (look, gate). off: cycles by which the phase differs from the mean's, whole ones do not matter; step: metres
    of a cycle. A steep wind sea strays from the mean over _RADIUS by its slope times half of that. True of NaN.
    """
    return ~_certain(off, step, ASTRAY)


def _certain(off: Field, step: Field, variance: Field | float) -> NDArray[np.bool_]:
    """Whether the nearest cycle is likelier by LEAST_ODDS than the next, where heights of that variance [m²] about
    what is expected are `off` cycles from it. False of NaN."""
    with np.errstate(invalid="ignore"):
        odds = 0.5 * step**2 * (1.0 - 2.0 * np.abs(off - np.round(off))) / variance
        return odds >= np.log(LEAST_ODDS)


def _islands(known: NDArray[np.bool_], spacing: float, across: Field) -> NDArray[np.bool_]:
    """Cells (look, gate) whose known neighbours, and theirs, make up less than a neighbourhood's area: alone with the
    mean level of the sea."""
    number: NDArray[np.intp] = np.empty(known.shape, np.intp)
    label(known, np.ones((3, 3)), number)
    area = np.bincount(number.ravel(), np.broadcast_to(spacing * across, known.shape).ravel())
    return known & (area < (2.0 * _RADIUS) ** 2)[number]


def resolve(
    residual: Field,
    phase_std: Field,
    gain: Field,
    known: NDArray[np.bool_],
    spacing: float,
    across: Field,
    *expected: HeightEstimate,
) -> Resolved:
    """The cycles of each cell of a polar map, and where they stay ambiguous.

    Arrays (look, gate). residual: phase less that of mean sea level [rad], its own cycles do not matter; phase_std: its
    standard error [rad]; gain: dz/dφ [m/rad], signed or not (then heights are too, as those of `expected` must be);
    known: cells with an echo. spacing: metres between gates; across (gate,): metres between looks. The first and the
    last look are no neighbours: of a circle they lie a turn apart in time. Where the ambiguity is far beyond the sea's
    size (`needed`) nothing is done, and it costs nothing.
    """
    known = known & np.isfinite(residual) & np.isfinite(phase_std) & np.isfinite(gain) & (gain != 0.0)
    resolved = Resolved(np.zeros(residual.shape, np.int64), np.zeros(residual.shape, np.bool_))
    phase = np.where(known, residual, 0.0)
    whole = np.round(phase / (2.0 * np.pi))
    gain = np.where(known, gain, 1.0)
    size = max([sea_size(phase, gain, known), *(_rms(each.height[known]) for each in expected)])
    most = max(size, largest_size(phase, gain, known))
    gates = np.flatnonzero(needed(gain, known, most))
    if not gates.size:
        resolved.cycles[:] = -whole
        return resolved
    reach = int(_RADIUS / spacing)
    part = np.s_[:, max(0, gates[0] - reach) : gates[-1] + reach + 1]
    wanted, gain = known[part], gain[part]
    folded = gain * (phase - 2.0 * np.pi * whole)[part]
    spread = np.where(known, phase_std, 0.0)[part]
    # The larger a phase's error, the less certain is the cycle that its neighbours gave it.
    share = np.maximum(1.0 - (spread / _UNIFORM_STD) ** 2, 1e-4)
    noise = np.maximum((gain * spread) ** 2 / share, 1e-6 * size**2)
    others = [HeightEstimate(e.height[part], e.std[part]) for e in expected]
    height, precision = _known_beforehand(size, others, gain.shape)
    step = 2.0 * np.pi * np.abs(gain)
    # A cell known well enough by itself does not follow its neighbours' plane, which may be wrong at a map's edge.
    sure = wanted & (noise + 1.0 / precision < (step / _CERTAIN_CYCLE) ** 2)
    first = np.where(sure, np.round((height - folded) / step), 0.0)
    folded = folded + first * step
    height, precision = np.where(sure, folded, height), np.where(sure, _FIXED_PRECISION / step**2, precision)
    layout = np.array([spacing, _RADIUS, _MOST_LOOKS, _STRAY, 1.0 / _SLOPE**2])
    beside = np.ascontiguousarray(across[part[1]])
    cycles, odds = unwrap(folded, step, noise, height, precision, np.ascontiguousarray(wanted), beside, layout)
    resolved.cycles[:] = -whole
    resolved.cycles[part] += np.where(wanted, np.sign(gain) * (first + cycles), 0.0).astype(np.int64)
    resolved.ambiguous[part] = wanted & ~sure & (odds < np.log(LEAST_ODDS))
    island = wanted & _islands(wanted, spacing, beside)
    if island.any():
        height, precision = _known_beforehand(most, others, gain.shape)
        off = (folded + cycles * step - height) / step
        resolved.ambiguous[part] |= island & ~_certain(off, step, 1.0 / np.maximum(precision, 1e-12) + noise)
    return resolved


def _rms(height: Field) -> float:
    some = height[np.isfinite(height)]
    return float(np.sqrt(np.mean(some**2))) if some.size else 0.0


def _known_beforehand(size: float, others: list[HeightEstimate], shape: tuple[int, ...]) -> tuple[Field, Field]:
    """Height [m] and one over its variance: mean sea level within the sea's size, and whatever else there is."""
    height, precision = np.zeros(shape), np.full(shape, max(size, 1e-9) ** -2.0)
    for other in others:
        with np.errstate(divide="ignore", invalid="ignore"):
            more = np.where(np.isfinite(other.height) & (other.std > 0.0), 1.0 / other.std**2, 0.0)
        height += more * np.where(more > 0.0, other.height, 0.0)
        precision += more
    return height / np.maximum(precision, 1e-12), precision
