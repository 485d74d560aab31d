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

from ...compute.compiled import compiled, compiled_step
from ...compute.machine import in_blocks


class Cells(NamedTuple):
    """A covariance whose unknown cells are 0."""

    fields: NDArray[np.float64]  # (4, look, gate) real and imaginary part of the cross product, both powers
    known: NDArray[np.float64]  # (look, gate) 1 or 0


class Phasors(NamedTuple):
    """What turns a neighbour's phase on to the cell's; real and imaginary parts."""

    per_gate: NDArray[np.float64]  # (part, look or 1, gate)
    per_look: NDArray[np.float64]  # (part, look or 1, gate)
    level: NDArray[np.float64]  # (part, offset, look, gate) of the sea so many gates on, as seen from the cell; or none


@compiled
def window_means(begin, end, cells, range_weights, look_weights, phasors, means):
    """Fill looks begin … end of the means (4, look, gate) of the fields, NaN of unknown cells; of a window that shrinks
    on both sides alike at edges and beside unknown cells."""
    (fields, known), (looks, gates) = cells, cells.known.shape
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    phasor, total, level = np.empty((2, gates)), np.empty(gates), phasors.level
    for look in range(begin, end):
        means[:, look], total[:] = 0.0, 0.0
        per_gate = phasors.per_gate[:, look % phasors.per_gate.shape[1]]
        per_look = phasors.per_look[:, look % phasors.per_look.shape[1]]
        reach = min(half_look, look, looks - 1 - look)
        for n in range(-reach, reach + 1):
            row, opposite = look + n, look - n
            phasor[0], phasor[1] = 1.0, 0.0
            for _ in range(abs(n)):
                _rotate(phasor, per_look, 1.0 if n > 0 else -1.0)
            for _ in range(half_range):
                _rotate(phasor, per_gate, -1.0)
            for m in range(-half_range, half_range + 1):
                weight, offset = range_weights[m + half_range] * look_weights[n + half_look], m + half_range
                away, shift = np.uint64(abs(m)), np.uint64(abs(m) + m)  # unsigned: what may be negative is slow
                for gate in range(np.uint64(max(0, gates - 2 * abs(m)))):
                    here, there, back = gate + away, gate + shift, gate + away + away - shift
                    share = weight * (known[row, there] * known[opposite, back])
                    cosine, sine = phasor[0, here], phasor[1, here]
                    if level.shape[1] > 0:
                        real, imaginary = level[0, offset, look, here], level[1, offset, look, here]
                        cosine, sine = cosine * real - sine * imaginary, cosine * imaginary + sine * real
                    real, imaginary = fields[0, row, there], fields[1, row, there]
                    means[0, look, here] += share * (real * cosine - imaginary * sine)
                    means[1, look, here] += share * (real * sine + imaginary * cosine)
                    means[2, look, here] += share * fields[2, row, there]
                    means[3, look, here] += share * fields[3, row, there]
                    total[here] += share
                _rotate(phasor, per_gate, 1.0)
        _divide(known[look], total, means[:, look])


@compiled
def window_means_as_they_are(begin, end, cells, range_weights, look_weights, means):
    """The same without turning any phase, over all cells of the window that are known, whatever lies opposite."""
    (fields, known), (looks, gates) = cells, cells.known.shape
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    total = np.empty(gates)
    for look in range(begin, end):
        means[:, look], total[:] = 0.0, 0.0
        for n in range(max(-half_look, -look), min(half_look, looks - 1 - look) + 1):
            for m in range(-half_range, half_range + 1):
                weight = range_weights[m + half_range] * look_weights[n + half_look]
                first, shift, row = np.uint64(max(0, -m)), np.uint64(max(0, m)), look + n
                inside = np.uint64(max(0, gates - abs(m)))
                for field in range(4):
                    for gate in range(inside):
                        means[field, look, gate + first] += weight * fields[field, row, gate + shift]
                for gate in range(inside):
                    total[gate + first] += weight * known[row, gate + shift]
        _divide(known[look], total, means[:, look])


@compiled
def window_powers(begin, end, power, known, range_weights, look_weights, means):
    """Fill looks begin … end of means (look, gate) of a power, 0 where it is not known, over such a window as
    `window_means` has."""
    looks, gates = known.shape
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    total = np.empty(gates)
    for look in range(begin, end):
        means[look], total[:] = 0.0, 0.0
        reach = min(half_look, look, looks - 1 - look)
        for n in range(-reach, reach + 1):
            row, opposite = look + n, look - n
            for m in range(-half_range, half_range + 1):
                weight = range_weights[m + half_range] * look_weights[n + half_look]
                away, shift = np.uint64(abs(m)), np.uint64(abs(m) + m)
                for gate in range(np.uint64(max(0, gates - 2 * abs(m)))):
                    there, back = gate + shift, gate + away + away - shift
                    share = weight * (known[row, there] * known[opposite, back])
                    means[look, gate + away] += share * power[row, there]
                    total[gate + away] += share
        _divide(known[look], total, means[look : look + 1])


@compiled_step
def _divide(known, total, sums):
    """Sums (field, gate) into means; NaN of unknown cells."""
    for gate in range(total.size):
        share = known[gate] / (known[gate] * total[gate])
        for field in range(len(sums)):
            sums[field, gate] *= share


@compiled_step
def _rotate(phasor, by, sense):
    """Turn phasors (part, gate) on by others, or back."""
    for n in range(phasor.shape[1]):
        cosine, sine = by[0, n], sense * by[1, n]
        real, imaginary = phasor[0, n], phasor[1, n]
        phasor[0, n], phasor[1, n] = real * cosine - imaginary * sine, real * sine + imaginary * cosine


Level = Callable[[int], NDArray[np.float64]]


@dataclass(frozen=True)
class PhaseSlopes:
    """How the phase goes on along a surface: rad per gate and rad per look, which broadcast to a map (look, gate);
    level(n): the phase of mean sea level n gates on, seen as from the cell itself, of antennas that move."""

    per_gate: NDArray[np.float64]
    per_look: NDArray[np.float64]
    level: Level | None = None

    def phasors(self, shape: tuple[int, ...]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What turns a neighbour's phase back by either (part, look or 1, gate) of a map's shape (look, gate): kept,
        for windows come in several sizes."""
        if shape not in self._phasors:
            phasors = (_phasor(-np.atleast_2d(each)) for each in (self.per_gate, self.per_look))
            wide = (np.broadcast_to(each, (*each.shape[:2], shape[1])) for each in phasors)
            self._phasors[shape] = tuple(map(np.ascontiguousarray, wide))
        return self._phasors[shape]

    @cached_property
    def _phasors(self) -> dict[tuple[int, ...], Any]:
        return {}


@dataclass(frozen=True)
class Covariance:
    """Sums over windows; arrays (look, gate). A look without pulses has count 0."""

    cross: NDArray[np.complex128]  # ⟨V_lower V_upper*⟩ [W]
    lower: NDArray[np.float64]  # ⟨|V_lower|²⟩ [W], noise included
    upper: NDArray[np.float64]

    @cached_property
    def known(self) -> NDArray[np.bool_]:
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
        half, level, cells = range_weights.size // 2, along.level, self._cells
        beside = np.empty((2, 0, 1, 1))
        if level is not None:
            beside = _phasor(np.stack([level(gate) for gate in range(-half, half + 1)]))
            cells = replace(self, cross=self.cross * np.exp(-1j * level(0)))._cells
        phasors, weights = Phasors(*along.phasors(self.cross.shape), beside), (range_weights, look_weights)
        means = np.empty(cells.fields.shape)
        in_blocks(lambda *looks: window_means(*looks, cells, *weights, phasors, means), len(cells.known))
        return _covariance(means)

    def windowed(self, range_weights: NDArray[np.float64], look_weights: NDArray[np.float64]) -> Covariance:
        """Means over such a window as they are: no phase is turned, and cells that are not known are left out one by
        one. They stay NaN."""
        cells, means, weights = self._cells, np.empty((4, *self.cross.shape)), (range_weights, look_weights)
        in_blocks(lambda *looks: window_means_as_they_are(*looks, cells, *weights, means), len(cells.known))
        return _covariance(means)

    def power_in(self, range_weights: NDArray[np.float64], look_weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean power [W] (look, gate) of both receivers over such a window."""
        cells, weights = self._cells, (range_weights, look_weights)
        power, means = cells.fields[2:].mean(axis=0), np.empty(cells.known.shape)
        in_blocks(lambda *looks: window_powers(*looks, power, cells.known, *weights, means), len(means))
        return means

    @cached_property
    def _cells(self) -> Cells:
        """Kept, for windows come in several sizes."""
        parts = self.cross.real, self.cross.imag, self.lower, self.upper
        return Cells(np.where(self.known, np.stack(parts), 0.0), self.known.astype(np.float64))

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
