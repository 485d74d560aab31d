"""Covariance of the two receivers over a look's dwell and a window of gates and looks.

In the compiled loops complex numbers are real and imaginary parts: loops over gates then fill a processor's registers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled, compiled_step
from ..compute.machine import run_blocks

_MARGIN = 8  # gates, of which the margins are multiples
_GROUP = 32  # gates: loops over whole groups leave no remainder to be gone through one by one


class Cells(NamedTuple):
    """A covariance, 0 where it is unknown, with a margin of unknown cells before the first gate and after the last."""

    fields: NDArray[np.float64]  # (4, look, margin + lane + margin) real and imaginary part, both powers
    known: NDArray[np.float64]  # (look, the same) 1 or 0


class Phasors(NamedTuple):
    """What turns a neighbour's phase on to the cell's; real and imaginary parts. Lanes: the gates, to whole groups."""

    per_gate: NDArray[np.float64]  # (part, look or 1, lane)
    per_look: NDArray[np.float64]  # (part, look or 1, lane)
    level: NDArray[np.float64]  # (part, offset, look, lane) of the sea so many gates on, as seen from the cell; or none


@compiled
def window_means(begin, end, cells, range_weights, look_weights, phasors, means):
    """Fill looks begin … end of the means (4, look, gate) of the fields, NaN of unknown cells; of a window that shrinks
    on both sides alike at edges and beside unknown cells."""
    (fields, known), level, looks = cells, phasors.level, len(cells.known)
    half_range, half_look, lanes = range_weights.size // 2, look_weights.size // 2, phasors.per_gate.shape[2]
    margin, sums, total, share = (known.shape[1] - lanes) // 2, np.empty((4, lanes)), np.empty(lanes), np.empty(lanes)
    real, imaginary, beside, aside = np.empty(lanes), np.empty(lanes), np.empty(lanes), np.empty(lanes)
    for look in range(begin, end):
        gate_look, look_look = look % phasors.per_gate.shape[1], look % phasors.per_look.shape[1]
        cosine, sine = phasors.per_gate[0, gate_look], phasors.per_gate[1, gate_look]
        reach = min(half_look, look, looks - 1 - look)
        sums[:], total[:] = 0.0, 0.0
        for n in range(-reach, reach + 1):
            row, real[:], imaginary[:] = look + n, 0.0, 0.0
            for m in range(half_range, -half_range - 1, -1):  # by Horner's rule: what is there is turned gate by gate
                there, back = margin + m, margin - m
                weight = range_weights[m + half_range] * look_weights[n + half_look]
                _share(weight, known[row, there : there + lanes], known[look - n, back : back + lanes], share, total)
                first, second = fields[0, row, there : there + lanes], fields[1, row, there : there + lanes]
                if level.shape[1] > 0:
                    offset = m + half_range
                    beside[:], aside[:] = first, second
                    _turn(beside, aside, level[0, offset, look], level[1, offset, look], 1.0)
                    first, second = beside, aside
                _turn(real, imaginary, cosine, sine, 1.0)
                _add(share, first, real)
                _add(share, second, imaginary)
                for power in range(2, 4):
                    _add(share, fields[power, row, there : there + lanes], sums[power])
            for _ in range(half_range):
                _turn(real, imaginary, cosine, sine, -1.0)
            for _ in range(abs(n)):
                sense = 1.0 if n > 0 else -1.0
                _turn(real, imaginary, phasors.per_look[0, look_look], phasors.per_look[1, look_look], sense)
            sums[0] += real
            sums[1] += imaginary
        _divide(known[look, margin:], total, sums, look, means)


@compiled
def unaligned_window_means(begin, end, cells, range_weights, look_weights, means):
    """The same without turning any phase, over all cells of the window that are known, whatever lies opposite."""
    (fields, known), looks = cells, len(cells.known)
    half_range, half_look, lanes = range_weights.size // 2, look_weights.size // 2, _lanes(means.shape[2])
    margin, sums, total = (known.shape[1] - lanes) // 2, np.empty((4, lanes)), np.empty(lanes)
    for look in range(begin, end):
        sums[:], total[:] = 0.0, 0.0
        for row in range(max(0, look - half_look), min(looks, look + half_look + 1)):
            for m in range(-half_range, half_range + 1):
                weight = range_weights[m + half_range] * look_weights[row - look + half_look]
                there = margin + m
                for field in range(4):
                    _add_weighted(weight, fields[field, row, there : there + lanes], sums[field])
                _add_weighted(weight, known[row, there : there + lanes], total)
        _divide(known[look, margin:], total, sums, look, means)


@compiled
def window_powers(begin, end, cells, range_weights, look_weights, means):
    """Fill looks begin … end of means (1, look, gate) of the mean of both powers over such a window as `window_means`
    has."""
    (fields, known), looks = cells, len(cells.known)
    half_range, half_look, lanes = range_weights.size // 2, look_weights.size // 2, _lanes(means.shape[2])
    margin, sums, total, share = (known.shape[1] - lanes) // 2, np.empty((1, lanes)), np.empty(lanes), np.empty(lanes)
    for look in range(begin, end):
        sums[:], total[:] = 0.0, 0.0
        reach = min(half_look, look, looks - 1 - look)
        for n in range(-reach, reach + 1):
            for m in range(-half_range, half_range + 1):
                row, there, back = look + n, margin + m, margin - m
                weight = range_weights[m + half_range] * look_weights[n + half_look]
                _share(weight, known[row, there : there + lanes], known[look - n, back : back + lanes], share, total)
                lower, upper = fields[2, row, there : there + lanes], fields[3, row, there : there + lanes]
                _add_mean(share, lower, upper, sums[0])
        _divide(known[look, margin:], total, sums, look, means)


@compiled_step
def _lanes(gates):
    """So many gates in whole groups."""
    return -(-gates // _GROUP) * _GROUP


@compiled_step
def _share(weight, known, opposite, share, total):
    """The weight of neighbours that are known, and whose opposites are."""
    for lane in range(total.size):
        share[lane] = weight * (known[lane] * opposite[lane])
        total[lane] += share[lane]


@compiled_step
def _add(share, field, total):
    for lane in range(total.size):
        total[lane] += share[lane] * field[lane]


@compiled_step
def _add_mean(share, one, other, total):
    for lane in range(total.size):
        total[lane] += share[lane] * (0.5 * (one[lane] + other[lane]))


@compiled_step
def _add_weighted(weight, field, total):
    for lane in range(total.size):
        total[lane] += weight * field[lane]


@compiled_step
def _turn(real, imaginary, cosine, sine, sense):
    """Turn complex numbers on by phasors, or back."""
    for lane in range(real.size):
        one, other, turn = real[lane], imaginary[lane], sense * sine[lane]
        real[lane] = one * cosine[lane] - other * turn
        imaginary[lane] = one * turn + other * cosine[lane]


@compiled_step
def _divide(known, total, sums, look, means):
    """A look's sums (field, lane) into means (field, look, gate); NaN of unknown cells."""
    for lane in range(total.size):
        total[lane] = known[lane] / (known[lane] * total[lane])
    for field in range(len(means)):
        mean, its = means[field, look], sums[field]
        for gate in range(mean.size):
            mean[gate] = total[gate] * its[gate]


Level = Callable[[int], NDArray[np.float64]]


@dataclass(frozen=True)
class PhaseSlopes:
    """How the phase goes on along a surface: rad per gate and rad per look, which broadcast to a map (look, gate);
    level(n): the phase of mean sea level n gates on, seen as from the cell itself, of antennas that move."""

    per_gate: NDArray[np.float64]
    per_look: NDArray[np.float64]
    level: Level | None = None

    def phasors(self, gates: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What turns a neighbour's phase back by either (part, look or 1, lane) of a map with so many gates: kept, for
        windows come in several sizes."""
        if gates not in self._phasors:
            each = (np.atleast_2d(field) for field in (self.per_gate, self.per_look))
            wide = (np.broadcast_to(_phasor(-field), (2, len(field), gates)) for field in each)
            self._phasors[gates] = tuple(map(_pad_to_lanes, wide))
        return self._phasors[gates]

    @cached_property
    def _phasors(self) -> dict[int, Any]:
        return {}


@dataclass(frozen=True)
class Covariance:
    """Sums over windows; arrays (look, gate). A look without pulses has count 0."""

    cross: NDArray[np.complex128]  # ⟨V_lower V_upper*⟩ [W]
    lower: NDArray[np.float64]  # ⟨|V_lower|²⟩ [W], noise included
    upper: NDArray[np.float64]

    @cached_property
    def has_value(self) -> NDArray[np.bool_]:
        """(look, gate) of cells with a number: not those of a look without pulses, or of a receiver that gave NaN."""
        return np.isfinite(self.cross) & np.isfinite(self.lower) & np.isfinite(self.upper)

    def windowed_along(
        self,
        range_weights: NDArray[np.float64],
        look_weights: NDArray[np.float64],
        along: PhaseSlopes,
    ) -> Covariance:
        """Power-weighted sums along a plane: a neighbour's phase is first brought to the cell by the local phase
        slopes. A strong cell counts for more than a weak one. Where the antennas move, what a neighbour has other than
        the level of the sea as seen from the cell is taken off as it is.

        Turned by a straight line, a single reflector keeps its phase exactly, and the sea's own slope (that of mean
        sea level, and of the waves if known) does not blur what is averaged. At the edges, and beside unknown cells,
        the window shrinks on both sides alike: half a gate's shift would cost centimetres. The first and the last look
        of a circle do not meet: they lie a turn apart in time. Unknown cells stay NaN.
        """
        (looks, gates), half, level, cells = self.cross.shape, range_weights.size // 2, along.level, self
        beside = np.empty((2, 0, 1, 1))
        if level is not None:
            beside = _pad_to_lanes(_phasor(np.stack([level(gate) for gate in range(-half, half + 1)])))
            cells = replace(self, cross=self.cross * np.exp(-1j * level(0)))
        given, weights = cells._cells(half), (range_weights, look_weights)
        phasors, means = Phasors(*along.phasors(gates), beside), np.empty((4, looks, gates))
        run_blocks(lambda *rows: window_means(*rows, given, *weights, phasors, means), looks)
        return _covariance(means)

    def windowed(self, range_weights: NDArray[np.float64], look_weights: NDArray[np.float64]) -> Covariance:
        """Means over such a window as they are: no phase is turned, and cells that are not known are left out one by
        one. They stay NaN."""
        given, means = self._cells(range_weights.size // 2), np.empty((4, *self.cross.shape))
        weights = range_weights, look_weights
        run_blocks(lambda *rows: unaligned_window_means(*rows, given, *weights, means), len(self.cross))
        return _covariance(means)

    def power_in(self, range_weights: NDArray[np.float64], look_weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean power [W] (look, gate) of both receivers over such a window."""
        given, means = self._cells(range_weights.size // 2), np.empty((1, *self.cross.shape))
        run_blocks(lambda *rows: window_powers(*rows, given, range_weights, look_weights, means), len(self.cross))
        return means[0]

    def _cells(self, half: int) -> Cells:
        """For windows that reach `half` gates to either side: kept, for they come in several sizes."""
        margin = -(-half // _MARGIN) * _MARGIN
        if margin not in self._cache:
            looks, gates = self.cross.shape
            field, known = (np.zeros((*n, looks, 2 * margin + _lanes(gates))) for n in ((4,), ()))
            here = np.s_[..., margin : margin + gates]
            known[here] = self.has_value
            for mine, part in zip(field, (self.cross.real, self.cross.imag, self.lower, self.upper), strict=True):
                np.copyto(mine[here], part, where=self.has_value)
            self._cache[margin] = Cells(field, known)
        return self._cache[margin]

    @cached_property
    def _cache(self) -> dict[int, Cells]:
        return {}

    def rotated(self, phase: NDArray[np.float64]) -> Covariance:
        """The same with a phase [rad], (look, gate), added to that between the receivers."""
        return replace(self, cross=self.cross * np.exp(1j * phase))

    @property
    def coherence(self) -> NDArray[np.float64]:
        """Sample coherence |⟨V₀V₁*⟩| / √(⟨|V₀|²⟩⟨|V₁|²⟩), (look, gate); NaN where there is no power."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.abs(self.cross) / np.sqrt(self.lower * self.upper)


def _covariance(means: NDArray[np.float64]) -> Covariance:
    """Of real and imaginary part and both powers (4, look, gate)."""
    return Covariance(complex_of(*means[:2]), means[2], means[3])


def complex_of(real: NDArray[np.float64], imaginary: NDArray[np.float64]) -> NDArray[np.complex128]:
    made = np.empty(real.shape, dtype=np.complex128)
    made.real, made.imag = real, imaginary
    return made


def _pad_to_lanes(field: NDArray[np.float64]) -> NDArray[np.float64]:
    """A field (…, gate) with zeros behind it, to whole groups."""
    wide = np.zeros((*field.shape[:-1], _lanes(field.shape[-1])))
    wide[..., : field.shape[-1]] = field
    return wide


def _phasor(phase: NDArray[np.float64]) -> NDArray[np.float64]:
    """Real and imaginary part (2, …)."""
    return np.stack((np.cos(phase), np.sin(phase)))


def without_noise(covariance: Covariance, noise_power: float) -> Covariance:
    """The same with the noise [W] of each receiver taken from its power, NaN where that was all; after averaging.

    Its coherence is that of the echo, which noise of its own in either receiver does not lower. Of N looks it is no
    better than a sample coherence is: |γ| of unlike voltages reads √π Γ(N)/(2 Γ(N + ½)), 1 of a single look and
    √(π/4N) of many (Touzi et al. 1999); and where noise outweighs the echo it can come out above 1.
    """
    with np.errstate(invalid="ignore"):
        powers = (np.where(p > noise_power, p - noise_power, np.nan) for p in (covariance.lower, covariance.upper))
        return Covariance(covariance.cross, *powers)


def window_weights(width: float, spacing: float) -> NDArray[np.float64]:
    """Weights of samples `spacing` apart under a window of `width` centred on one of them: each by its overlap.

    Symmetric by construction: half a gate's shift would cost centimetres, since lit cells face the radar.
    """
    reach = max(0, int(np.ceil(0.5 * width / spacing - 0.5 - 1e-9)))
    offset = spacing * np.arange(-reach, reach + 1)
    high = np.minimum(offset + 0.5 * spacing, 0.5 * width)
    low = np.maximum(offset - 0.5 * spacing, -0.5 * width)
    return np.maximum(high - low, 0.0) / spacing


def independent_looks(weights: NDArray[np.float64], correlation: NDArray[np.float64]) -> float:
    """Number of independent samples in a weighted mean: (Σw)² / ΣΣ w_i w_j |ρ(i−j)|²."""
    if weights.size > 1000:  # a table of all pairs would fill the memory
        pairs = np.correlate(weights, weights, "full")[weights.size - 1 :] * np.where(np.arange(weights.size), 2.0, 1.0)
        return float(weights.sum() ** 2 / (pairs @ np.abs(correlation[: weights.size]) ** 2))
    lag = np.abs(np.arange(weights.size)[:, None] - np.arange(weights.size)[None, :])
    return float(weights.sum() ** 2 / (weights @ np.abs(correlation[lag]) ** 2 @ weights))


def pulse_correlation(
    voltage: NDArray[np.complex64],
    look: NDArray[np.intp],
    noise_power: float,
    most_lag: int,
    rows: NDArray[np.intp] | None = None,
    receiver: int = 0,
) -> NDArray[np.float64]:
    """|ρ| of the echo between pulses 0 … most_lag apart, estimated from the strongest tenth of the gates.

    It gives the number of independent samples of speckle in a dwell, which neither scene nor radar give. Taken
    from the powers of Gaussian speckle, ⟨P P'⟩ = (w + n)² + w² |ρ|² with n the noise's: they depend neither on the
    Doppler frequency, different from cell to cell, nor on which antenna transmitted, and a dwell of few samples does
    not bias them as it would |⟨V V'*⟩|.
    """
    rows = np.arange(look.size) if rows is None else rows
    rows = rows[look[rows] >= 0]
    correlation = np.ones(most_lag + 1)
    if rows.size == 0 or most_lag == 0:
        return correlation
    rough = np.mean(powers(voltage, receiver, rows[:: max(1, rows.size // 500)]), axis=0)
    gates = np.argsort(rough)[::-1][: max(1, rough.size // 10)]
    power = powers(voltage, receiver, rows, gates)
    number = look[rows]
    mean, square = power.mean(), 0.5 * np.mean(power**2)  # ⟨w + n⟩, ⟨(w + n)²⟩
    echo = square - 2.0 * noise_power * mean + noise_power**2  # ⟨w²⟩
    if not (mean > noise_power and echo > 0.0):
        return correlation  # nothing is heard
    lags = np.unique(np.linspace(1, most_lag, min(most_lag, 16)).astype(int))
    values = []
    for lag in lags:
        alike = number[:-lag] == number[lag:]
        beside = np.einsum("pg,pg->p", power[:-lag], power[lag:])[alike]
        product = beside.mean() / gates.size if beside.size else square
        values.append(np.sqrt(np.clip((product - square) / echo, 0.0, 1.0)))
    correlation[1:] = np.interp(np.arange(1, most_lag + 1), lags, values)
    return correlation


def powers(
    voltage: NDArray[np.complex64],
    receiver: int,
    rows: NDArray[np.intp],
    gates: NDArray[np.intp] | None = None,
) -> NDArray[np.float64]:
    """Power (row, gate) of some pulses' voltages and some gates', all if left out; 0 where that is not finite."""
    chosen = voltage[rows, receiver] if gates is None else voltage[rows[:, None], receiver, gates]
    with np.errstate(invalid="ignore"):  # of a file's own NaN
        power = np.square(chosen.real, dtype=np.float64) + np.square(chosen.imag, dtype=np.float64)
    return np.where(np.isfinite(power), power, 0.0)
