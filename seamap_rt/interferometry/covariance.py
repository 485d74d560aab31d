"""Covariance of the two receivers over a look's dwell and a window of gates and looks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


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
    ) -> Covariance:
        """Power-weighted sums along a plane: a neighbour's phase is first brought to the cell by the local phase slopes
        [rad per gate, rad per look], which broadcast to (look, gate). A strong cell counts for more than a weak one.

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
                turn = np.exp(-1j * (gate * phase_per_gate[here] + look * phase_per_look[here]))
                total.cross[here] += weight * cross[there] * turn
                total.lower[here] += weight * lower[there]
                total.upper[here] += weight * upper[there]
                weights[here] += weight
        with np.errstate(invalid="ignore"):
            for field in (total.cross, total.lower, total.upper):
                field /= weights
        return total

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


def dwell_covariance(voltage: NDArray[np.complex64], look: NDArray[np.intp], looks: int) -> Covariance:
    """Mean over each look's pulses, whatever antenna transmitted: with one pulse for both receivers p = 1 for either.

    voltage (pulse, receiver, gate); look (pulse,) the number of the look to which the pulse belongs, or −1. Pulses with
    a voltage that is not finite are left out, gate by gate.
    """
    inside = look >= 0
    if not inside.all():
        voltage, look = voltage[inside], look[inside]
    order = np.argsort(look, kind="stable")
    if not np.array_equal(order, np.arange(order.size)):
        voltage, look = voltage[order], look[order]
    lower, upper = voltage[:, 0], voltage[:, 1]
    cross = lower * upper.conj()
    power_lower = lower.real**2 + lower.imag**2
    power_upper = upper.real**2 + upper.imag**2
    good = np.isfinite(power_lower) & np.isfinite(power_upper)
    whole = bool(good.all())
    if not whole:
        cross, power_lower, power_upper = (np.where(good, f, 0.0) for f in (cross, power_lower, power_upper))
    shape = (looks, voltage.shape[2])
    total = Covariance(np.zeros(shape, dtype=np.complex128), np.zeros(shape), np.zeros(shape))
    sums = (total.cross, total.lower, total.upper)
    present, starts = np.unique(look, return_index=True)
    counts = np.zeros(shape)
    if present.size:
        for held, field in zip(sums, (cross, power_lower, power_upper), strict=True):
            held[present] = np.add.reduceat(field, starts, axis=0)
        pulses = np.diff(np.append(starts, look.size))[:, None]
        counts[present] = pulses if whole else np.add.reduceat(good.astype(np.float64), starts, axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        for held in sums:
            held /= counts
    return total


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
