"""A wrapped phase allows heights one ambiguity, λR/(pB), apart: which one a cell has, and where that is undecided.

Nothing but the mean level is known beforehand: the sea stays about it within its own size. Far out the ambiguity is
larger than any wave, and that alone decides; nearer in, the sea goes on from cell to cell.

They grow from cell to cell, the surest first, compiled.
A cell's cycles are those that bring it nearest to what its resolved neighbours let expect: a plane through them, by
least squares, held to a height known beforehand (of the sea: its mean level, within its own size). How much more likely
these cycles are than the next best ones decides which cell is next: the growth avoids what is noisy or in shadow
before it crosses it (quality-guided path following, Ghiglia & Pritt 1998), and comes to cells that are sure by
themselves, far out, first of all. Then each cell is tested again, now with neighbours on all sides, until none changes
(iterated conditional modes, Besag 1986).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from ..compute.compiled import compiled

_LEVELS = 128  # of the queue,
_PER_NAT = 8.0  # each an eighth of the odds' natural logarithm: above e^16 they are not ordered any more
_BESIDE = 2  # looks and gates within which a new neighbour changes a cell's place in the queue
_SWEEPS = 6  # of correction at most; most maps converge after two or three


class Neighbourhood(NamedTuple):
    """Which cells' heights let a cell's be expected, and how well."""

    spacing: float  # m, between gates
    radius: float  # m
    most_looks: int  # to either side
    stray: float  # m² per m² of distance, by which heights stray from a plane
    slope_precision: float  # one over the variance of slopes


@compiled
def unwrap(folded, step, noise, expected, precision, wanted, across, around):
    """Cycles (look, gate) to add, and the log odds of these over the next best ones.

    folded: heights [m], one cycle is `step` m; noise: their variance [m²]; expected, precision: the height known
    beforehand [m] and one over its variance; wanted: cells to resolve; across (gate,): metres between looks.
    """
    cycles = np.zeros(folded.shape)
    sums = _grow(folded, step, noise, expected, precision, wanted, across, around, cycles)
    odds = np.zeros(folded.shape)
    looks, gates = folded.shape
    for _ in range(_SWEEPS):
        converged = True
        for i in range(looks):
            for j in range(gates):
                if not wanted[i, j]:
                    continue
                mean, variance = _predict(sums[i, j], expected[i, j], precision[i, j], around.slope_precision)
                now = folded[i, j] + cycles[i, j] * step[i, j]
                more = np.round((mean - now) / step[i, j])
                odds[i, j] = _odds(now, step[i, j], mean, variance + noise[i, j])
                if more != 0.0:
                    converged = False
                    cycles[i, j] += more
                    _add_neighbour(sums, wanted, i, j, more * step[i, j], 0.0, noise[i, j], across[j], around)
        if converged:
            break
    return cycles, odds


@compiled
def _grow(folded, step, noise, expected, precision, wanted, across, around, cycles):
    """Fill cycles; return the sums (look, gate, 9) over each cell's neighbours that its plane is fitted from."""
    looks, gates = folded.shape
    sums = np.zeros((looks, gates, 9))
    # The queue: cells of one level are a chain.
    first = np.full(_LEVELS, -1, np.int64)
    after, before = np.full(looks * gates, -1, np.int64), np.full(looks * gates, -1, np.int64)
    level = np.full(looks * gates, -1, np.int64)
    top = -1
    for i in range(looks):
        for j in range(gates):
            if wanted[i, j]:
                sure = _odds(folded[i, j], step[i, j], expected[i, j], 1.0 / precision[i, j] + noise[i, j])
                top = max(top, _queue(first, after, before, level, i * gates + j, sure))
    while top >= 0:
        if first[top] < 0:
            top -= 1
            continue
        cell = first[top]
        _remove_cell(first, after, before, level, cell)
        level[cell] = -2  # resolved
        i, j = cell // gates, cell % gates
        mean, _ = _predict(sums[i, j], expected[i, j], precision[i, j], around.slope_precision)
        cycles[i, j] = np.round((mean - folded[i, j]) / step[i, j])
        height = folded[i, j] + cycles[i, j] * step[i, j]
        _add_neighbour(sums, wanted, i, j, height, 1.0, noise[i, j], across[j], around)
        for ii in range(max(0, i - _BESIDE), min(looks, i + _BESIDE + 1)):
            for jj in range(max(0, j - _BESIDE), min(gates, j + _BESIDE + 1)):
                beside = ii * gates + jj
                if level[beside] >= 0:
                    mean, variance = _predict(sums[ii, jj], expected[ii, jj], precision[ii, jj], around.slope_precision)
                    sure = _odds(folded[ii, jj], step[ii, jj], mean, variance + noise[ii, jj])
                    top = max(top, _queue(first, after, before, level, beside, sure))
    return sums


@compiled
def _predict(sums, expected, precision, slope_precision):
    """Mean and variance of a height, from its neighbours and from what was known beforehand."""
    a, b, c = sums[0] + precision, sums[1], sums[2]
    d, e, f = sums[3] + slope_precision, sums[4], sums[5] + slope_precision
    aa, bb, cc = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * aa + b * bb + c * cc
    mean = (aa * (sums[6] + precision * expected) + bb * sums[7] + cc * sums[8]) / determinant
    return mean, aa / determinant


@compiled
def _odds(height, step, mean, variance):
    """Log odds of the cycle that comes nearest to the mean over the second nearest."""
    off = (height - mean) / step
    off = abs(off - np.round(off))
    return 0.5 * step * step * (1.0 - 2.0 * off) / variance


@compiled
def _add_neighbour(sums, wanted, i, j, height, count, noise, across, around):
    """Add a cell's height to its neighbours' sums; count = 0: a change of a height that they have already."""
    spacing, radius, most, stray = around.spacing, around.radius, around.most_looks, around.stray
    looks, gates = wanted.shape
    aside, out = min(most, int(radius / across + 0.5)), int(radius / spacing)
    for ii in range(max(0, i - aside), min(looks, i + aside + 1)):
        for jj in range(max(0, j - out), min(gates, j + out + 1)):
            x, y = (j - jj) * spacing, (i - ii) * across
            square = x * x + y * y
            if not wanted[ii, jj] or square > radius * radius or (ii == i and jj == j):
                continue
            weight = 1.0 / (noise + stray * square)
            there, counted = sums[ii, jj], count * weight
            there[0] += counted
            there[1] += counted * x
            there[2] += counted * y
            there[3] += counted * x * x
            there[4] += counted * x * y
            there[5] += counted * y * y
            there[6] += weight * height
            there[7] += weight * height * x
            there[8] += weight * height * y


@compiled
def _queue(first, after, before, level, cell, sure):
    """Put a cell where its log odds belong; return that level."""
    new = int(min(_LEVELS - 1.0, max(0.0, sure * _PER_NAT)))
    if new != level[cell]:
        if level[cell] >= 0:
            _remove_cell(first, after, before, level, cell)
        level[cell], before[cell], after[cell] = new, -1, first[new]
        if first[new] >= 0:
            before[first[new]] = cell
        first[new] = cell
    return new


@compiled
def _remove_cell(first, after, before, level, cell):
    if before[cell] >= 0:
        after[before[cell]] = after[cell]
    else:
        first[level[cell]] = after[cell]
    if after[cell] >= 0:
        before[after[cell]] = before[cell]


Field = NDArray[np.float64]

LEAST_ODDS = 20.0  # of the cycles taken over the next best ones, below which a cell is flagged
BEYOND = 5.0  # of the sea's rms heights; crests rise to a significant wave height and a quarter
_SLOPE = 0.14  # rms of the sea's slopes as cells of some metres show them, steep wind seas
_STRAY = 0.001  # m² per m² of distance, by which such seas are let stray from a plane
_RADIUS = 6.0  # m, of the neighbourhood: an eighth of the length of a wind sea's waves
_MOST_LOOKS = 6  # to either side
_NEIGHBOUR_VARIANCE = (0.5 * _SLOPE * _RADIUS) ** 2  # m², of heights about their neighbourhood's mean
_RELIABLE_CYCLE = 8.0  # standard deviations to a cycle, four to half of one: then neighbours are not used
_FIXED_PRECISION = 1e9  # precision of what is fixed, over that of a whole cycle
_UNIFORM_STD = np.pi / np.sqrt(3.0)  # rad, standard deviation of a phase that is uniform over the circle
_LEAST_RESULTANT = 0.3  # of a gate's phases, below which it counts as none
_FEW = 8  # cells, too few for a mean


@dataclass(frozen=True)
class CycleEstimate:
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


def neighbourhood(spacing: float) -> Neighbourhood:
    """That of cells whose gates lie `spacing` metres apart."""
    return Neighbourhood(float(spacing), _RADIUS, _MOST_LOOKS, _STRAY, 1.0 / _SLOPE**2)


def ambiguous_gates(gain: Field, known: NDArray[np.bool_], size: float) -> NDArray[np.bool_]:
    """Gates (gate,) in which a sea of that rms height [m] reaches beyond half an ambiguity, π |dz/dφ|."""
    with np.errstate(invalid="ignore"):
        return np.any(known & (np.pi * np.abs(gain) < BEYOND * size), axis=0)


def doubtful_cycle(off: Field, step: Field) -> NDArray[np.bool_]:
    """Cells whose height may well lie on another cycle than the one that is nearest to its neighbourhood's mean.

    Arrays (look, gate). off: cycles by which the phase differs from the mean's, whole ones do not matter; step: metres
    of a cycle. A steep wind sea strays from the mean over _RADIUS by its slope times half of that. True of NaN.
    """
    return ~is_reliable(off, step, _NEIGHBOUR_VARIANCE)


def is_reliable(off: Field, step: Field, variance: Field | float) -> NDArray[np.bool_]:
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
) -> CycleEstimate:
    """The cycles of each cell of a polar map, and where they stay ambiguous.

    Arrays (look, gate). residual: phase less that of mean sea level [rad], its own cycles do not matter; phase_std: its
    standard error [rad]; gain: dz/dφ [m/rad], signed or not (then heights are too, as those of `expected` must be);
    known: cells with an echo. spacing: metres between gates; across (gate,): metres between looks. The first and the
    last look are no neighbours: of a circle they lie a turn apart in time. Where the ambiguity is far beyond the sea's
    size (`ambiguous_gates`) nothing is done, and it costs nothing.
    """
    known = known & np.isfinite(residual) & np.isfinite(phase_std) & np.isfinite(gain) & (gain != 0.0)
    resolved = CycleEstimate(np.zeros(residual.shape, np.int64), np.zeros(residual.shape, np.bool_))
    phase = np.where(known, residual, 0.0)
    whole = np.round(phase / (2.0 * np.pi))
    gain = np.where(known, gain, 1.0)
    size = max([sea_size(phase, gain, known), *(_rms(each.height[known]) for each in expected)])
    most = max(size, largest_size(phase, gain, known))
    gates = np.flatnonzero(ambiguous_gates(gain, known, most))
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
    height, precision = _prior_height(size, others, gain.shape)
    step = 2.0 * np.pi * np.abs(gain)
    # A cell known well enough by itself does not follow its neighbours' plane, which may be wrong at a map's edge.
    sure = wanted & (noise + 1.0 / precision < (step / _RELIABLE_CYCLE) ** 2)
    first = np.where(sure, np.round((height - folded) / step), 0.0)
    folded = folded + first * step
    height, precision = np.where(sure, folded, height), np.where(sure, _FIXED_PRECISION / step**2, precision)
    around = neighbourhood(spacing)
    beside = np.ascontiguousarray(across[part[1]])
    cycles, odds = unwrap(folded, step, noise, height, precision, np.ascontiguousarray(wanted), beside, around)
    resolved.cycles[:] = -whole
    resolved.cycles[part] += np.where(wanted, np.sign(gain) * (first + cycles), 0.0).astype(np.int64)
    resolved.ambiguous[part] = wanted & ~sure & (odds < np.log(LEAST_ODDS))
    island = wanted & _islands(wanted, spacing, beside)
    if island.any():
        height, precision = _prior_height(most, others, gain.shape)
        off = (folded + cycles * step - height) / step
        resolved.ambiguous[part] |= island & ~is_reliable(off, step, 1.0 / np.maximum(precision, 1e-12) + noise)
    return resolved


def _rms(height: Field) -> float:
    some = height[np.isfinite(height)]
    return float(np.sqrt(np.mean(some**2))) if some.size else 0.0


def _prior_height(size: float, others: list[HeightEstimate], shape: tuple[int, ...]) -> tuple[Field, Field]:
    """Height [m] and one over its variance: mean sea level within the sea's size, and whatever else there is."""
    height, precision = np.zeros(shape), np.full(shape, max(size, 1e-9) ** -2.0)
    for other in others:
        with np.errstate(divide="ignore", invalid="ignore"):
            more = np.where(np.isfinite(other.height) & (other.std > 0.0), 1.0 / other.std**2, 0.0)
        height += more * np.where(more > 0.0, other.height, 0.0)
        precision += more
    return height / np.maximum(precision, 1e-12), precision
