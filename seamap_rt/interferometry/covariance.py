"""Covariance of the two receivers over a look's dwell and a window of gates and looks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .dwells import Dwells
from .pairs import PulsePairs, Rows

Level = Callable[[int], NDArray[np.float64]]


@dataclass(frozen=True)
class Covariance:
    """Sums over windows; arrays (look, gate). A look without pulses has count 0."""

    cross: NDArray[np.complex128]  # ⟨V_lower V_upper*⟩ [W]
    lower: NDArray[np.float64]  # ⟨|V_lower|²⟩ [W], noise included
    upper: NDArray[np.float64]

    @property
    def known(self) -> NDArray[np.bool_]:
        """Cells that hold a number: not those of a look without pulses, or of a receiver that gave NaN."""
        return np.isfinite(self.cross) & np.isfinite(self.lower) & np.isfinite(self.upper)

    def windowed_along(
        self,
        range_weights: NDArray[np.float64],
        look_weights: NDArray[np.float64],
        phase_per_gate: NDArray[np.float64],
        phase_per_look: NDArray[np.float64],
        level: Level | None = None,
    ) -> Covariance:
        """Power-weighted sums along a plane: a neighbour's phase is first brought to the cell by the local phase slopes
        [rad per gate, rad per look], which broadcast to (look, gate). A strong cell counts for more than a weak one.
        level(n): the phase (look, gate) of mean sea level n gates on, seen as from the cell itself; where the antennas
        move, what a neighbour has other than that is taken off as it is.

        Turned by a straight line, a single reflector keeps its phase exactly, and the sea's own slope (that of mean
        sea level, and of the waves if known) does not blur what is averaged. At the edges, and beside unknown cells,
        the window shrinks on both sides alike: half a gate's shift would cost centimetres. The first and the last look
        of a circle do not meet: they lie a turn apart in time. Unknown cells stay NaN.
        """
        shape, known = self.cross.shape, self.known
        cross, lower, upper = (np.where(known, field, 0.0) for field in (self.cross, self.lower, self.upper))
        total = Covariance(np.zeros_like(self.cross), np.zeros(shape), np.zeros(shape))
        weights = np.where(known, 0.0, np.nan)
        half_range, half_look = range_weights.size // 2, look_weights.size // 2
        phase_per_gate = np.broadcast_to(phase_per_gate, shape)
        phase_per_look = np.broadcast_to(phase_per_look, shape)
        for look in range(-half_look, half_look + 1):
            for gate in range(-half_range, half_range + 1):
                here, there = _overlap(shape, look, gate)
                opposite = _overlap(shape, -look, -gate)[1]
                weight = range_weights[gate + half_range] * look_weights[look + half_look]
                weight = weight * (known[there] & known[opposite])
                phase = gate * phase_per_gate[here] + look * phase_per_look[here]
                if level is not None:
                    phase = phase + level(0)[there] - level(gate)[here]
                turn = np.exp(-1j * phase)
                total.cross[here] += weight * cross[there] * turn
                total.lower[here] += weight * lower[there]
                total.upper[here] += weight * upper[there]
                weights[here] += weight
        with np.errstate(invalid="ignore"):
            for field in (total.cross, total.lower, total.upper):
                field /= weights
        return total

    def turned(self, phase: NDArray[np.float64]) -> Covariance:
        """The same with a phase [rad], (look, gate), added to that between the receivers."""
        return Covariance(self.cross * np.exp(1j * phase), self.lower, self.upper)

    @property
    def coherence(self) -> NDArray[np.float64]:
        """Sample coherence |⟨V₀V₁*⟩| / √(⟨|V₀|²⟩⟨|V₁|²⟩), NaN where there is no power."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.abs(self.cross) / np.sqrt(self.lower * self.upper)


def _overlap(shape: tuple[int, ...], look: int, gate: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Slices of the cells that have neighbours (look, gate) on and as far back, and of those that lie on."""

    def pair(count: int, shift: int) -> tuple[slice, slice]:
        low, high = abs(shift), max(count - abs(shift), abs(shift))
        return slice(low, high), slice(low + shift, high + shift)

    (looks, looks_on), (gates, gates_on) = pair(shape[0], look), pair(shape[1], gate)
    return (looks, gates), (looks_on, gates_on)


def dwell_covariance(
    voltage: NDArray[np.complex64],
    dwells: Dwells,
    pairs: PulsePairs | None = None,
    level: NDArray[np.float64] | None = None,
) -> Covariance:
    """Mean over each cell's pulses, whatever antenna transmitted.

    voltage (pulse, 2, gate), lower receiver first. pairs: of alternating pulses; each product counts to the dwell of
    its lower pulse, and the means of forward and backward products are averaged, so that their Doppler phases cancel.
    level (pulse, gate): phase of mean sea level on each pulse, of which products are freed before they are added: where
    a heeled baseline has a part across the look, it changes within a dwell. Voltages that are not finite are left out,
    pulse by pulse and gate by gate.
    """
    lower, upper = voltage[:, 0], voltage[:, 1]
    if level is not None:  # half from either side: a product of two pulses is freed of the mean of their levels
        half = np.exp(-0.5j * level).astype(np.complex64)
        lower, upper = lower * half, upper * half.conj()
    if pairs is None:
        powers = _power(lower), _power(upper)
        return Covariance(
            *_means(dwells, np.isfinite(powers[0]) & np.isfinite(powers[1]), lower * upper.conj(), *powers)
        )

    def mean(rows: Rows, field: NDArray) -> NDArray:
        return _means(dwells[rows], np.isfinite(field), field)[0]

    return Covariance(
        np.mean([mean(n, lower[n] * upper[m].conj()) for n, m in pairs.pairs], axis=0),
        mean(pairs.lower, _power(lower[pairs.lower])),
        mean(pairs.upper, _power(upper[pairs.upper])),
    )


def _power(voltage: NDArray[np.complex64]) -> NDArray[np.float32]:
    return voltage.real**2 + voltage.imag**2


def _means(dwells: Dwells, good: NDArray[np.bool_], *fields: NDArray) -> list[NDArray]:
    """Means (look, gate) of fields (pulse, gate) over each cell's good pulses."""
    if whole := bool(good.all()):
        counts = np.broadcast_to(dwells.pulses, (dwells.looks, good.shape[1]))
    else:
        counts = dwells.sums(good.astype(np.float64))
    with np.errstate(invalid="ignore", divide="ignore"):
        return [dwells.sums(field if whole else np.where(good, field, 0.0)) / counts for field in fields]


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
    """How many independent samples a weighted mean is worth: (Σw)² / ΣΣ w_i w_j |ρ(i−j)|²."""
    lag = np.abs(np.arange(weights.size)[:, None] - np.arange(weights.size)[None, :])
    return float(weights.sum() ** 2 / (weights @ np.abs(correlation[lag]) ** 2 @ weights))


def pulse_correlation(
    voltage: NDArray[np.complex64], look: NDArray[np.intp], noise_power: float, most_lag: int
) -> NDArray[np.float64]:
    """|ρ| of the echo between pulses 0 … most_lag apart, estimated from the strongest tenth of the gates.

    It tells how many independent samples of speckle a dwell holds, which neither the scene nor the radar can say. Taken
    from the powers of Gaussian speckle, ⟨P P'⟩ = (w + n)² + w² |ρ|² with n the noise's: they know neither the Doppler
    frequency, different from cell to cell, nor which antenna transmitted, and a dwell of few samples does not bias
    them as it would |⟨V V'*⟩|.
    """
    rows = np.flatnonzero(look >= 0)
    correlation = np.ones(most_lag + 1)
    if rows.size == 0 or most_lag == 0:
        return correlation
    rough = np.mean(np.nan_to_num(np.abs(voltage[rows[:: max(1, rows.size // 500)], 0])) ** 2, axis=0)
    gates = np.argsort(rough)[::-1][: max(1, rough.size // 10)]
    series = voltage[rows][:, 0, gates]
    power = np.nan_to_num(np.square(series.real, dtype=np.float64) + np.square(series.imag, dtype=np.float64))
    number = look[rows]
    mean, square = power.mean(), 0.5 * np.mean(power**2)  # ⟨w + n⟩, ⟨(w + n)²⟩
    echo = square - 2.0 * noise_power * mean + noise_power**2  # ⟨w²⟩
    if not (mean > noise_power and echo > 0.0):
        return correlation  # nothing is heard
    lags = np.unique(np.linspace(1, most_lag, min(most_lag, 16)).astype(int))
    values = []
    for lag in lags:
        alike = number[:-lag] == number[lag:]
        product = np.mean(power[:-lag][alike] * power[lag:][alike]) if alike.any() else square
        values.append(np.sqrt(np.clip((product - square) / echo, 0.0, 1.0)))
    correlation[1:] = np.interp(np.arange(1, most_lag + 1), lags, values)
    return correlation
