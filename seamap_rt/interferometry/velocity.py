"""Radial velocity and its spread by pulse pairs: how an echo's phase turns, and how soon it decorrelates.

An echo that recedes at v turns by exp(−j 2k v τ) from a pulse to one τ later, V ∝ exp(−jk(R_tx + R_rx)): v is read
from the phase of ⟨V(t + τ) V*(t)⟩ (Miller & Rochwarger 1972), and the standard deviation σ of the velocities from
|ρ(τ)| = exp(−½ (2k σ τ)²). Their errors: Zrnić 1977.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..conventions import unit_from_azimuth, wrap_phase
from .dwells import Dwells
from .products import Products, Rows, rows_apart
from .windows import Covariance, without_noise

_MOST_CYCLE = 16  # pulses after which a transmitter comes again at the latest
_STEADY_S = 0.1  # over which a boat's velocity is that of a straight line through its positions


@dataclass(frozen=True)
class Lag:
    """Means over dwells of products of voltages `seconds` apart, later times earlier conjugate, with their powers."""

    seconds: float
    products: Covariance
    share: float  # of the dwell that the lag is


@dataclass(frozen=True)
class LagKinds:
    """Which products make up each lag, and how many pulses a transmitter's cycle has."""

    cycle: int
    seconds: tuple[float, ...]
    shares: tuple[float, ...]
    kinds: tuple[list[Products], ...]

    def lags(self, means: Iterable[Covariance]) -> tuple[Lag, ...]:
        """With the means over dwells of each kind."""
        return tuple(Lag(*each) for each in zip(self.seconds, means, self.shares, strict=True))


NO_LAGS = LagKinds(1, (), (), ())


@dataclass(frozen=True)
class Doppler:
    """Arrays (look, gate), m/s; NaN where nothing is known. velocity: away from the antennas, as seen from them."""

    velocity: NDArray[np.float64]
    velocity_std: NDArray[np.float64]
    width: NDArray[np.float64]


def pulse_pair_lags(
    transmitter: NDArray[np.integer],
    heard: NDArray[np.bool_],
    time: NDArray[np.float64],
    interval: float,
    dwell: int,
    receivers: tuple[int, int],
) -> LagKinds:
    """Products of the same transmitter and receiver at three lags: the shortest there is, which sees the fastest echo
    unfolded; about a third of a dwell of `dwell` pulses, over which the phase turns most before the speckle is another
    one; and one between, by which the shortest resolves the cycles of the longest. heard (pulse, 2) lower, upper."""

    hears = [np.ascontiguousarray(each) for each in heard.T]

    def pair_pulses(lag: int) -> tuple[Rows, Rows, list[NDArray[np.bool_]]]:
        early, late = rows_apart(time, lag * interval, interval)
        same = transmitter[early] == transmitter[late]
        return early, late, [same & each[early] & each[late] for each in hears]

    def pairs(lag: int) -> list[Products]:
        early, late, good = pair_pulses(lag)
        return [
            Products((late[rows], receiver), (early[rows], receiver), early[rows])
            for rows, receiver in zip(good, receivers, strict=True)
            if rows.any()
        ]

    counts = [sum(map(np.count_nonzero, pair_pulses(lag)[2])) for lag in range(1, min(_MOST_CYCLE, time.size - 1) + 1)]
    if not any(counts):
        return NO_LAGS
    cycle = 1 + next(n for n, count in enumerate(counts) if count >= 0.5 * max(counts))
    longest = max(1, dwell // (3 * cycle))
    chosen = [cycle * n for n in sorted({1, round(longest**0.5), longest})]
    kinds = {lag: pairs(lag) for lag in chosen if lag < time.size}
    kinds = {lag: each for lag, each in kinds.items() if each}
    shares = tuple(min(lag / dwell, 0.5) for lag in kinds)
    return LagKinds(cycle, tuple(lag * interval for lag in kinds), shares, tuple(kinds.values()))


def phase_rate(lags: Sequence[Lag]) -> NDArray[np.float64]:
    """How fast each cell's phase turns [rad/s]: by the longest lag, its whole cycles resolved by the shorter ones."""
    if not lags:
        return np.full((1, 1), np.nan)
    rate = np.zeros_like(lags[0].products.lower)
    for lag in lags:
        expected = rate * lag.seconds
        rate = (expected + wrap_phase(np.angle(lag.products.cross) - expected)) / lag.seconds
    return rate


def doppler(
    lags: Sequence[Lag],
    wavelength: float,
    noise_power: float,
    window: tuple[NDArray[np.float64], NDArray[np.float64]],
    samples: float,
    looks: float,
    passage_s: float = np.inf,
) -> Doppler:
    """Velocity and width over a window of weights along range and across looks, from the lags of dwells.

    noise_power [W] of one receiver. For the standard error samples: voltages in a window, of both receivers, each with
    noise of its own, and looks: independent samples of its speckle. passage_s (`beam_passage`): the echo decorrelates
    as well because the antenna turns on to other water, which is taken from the width. Raises ValueError without lags.
    """
    if not lags:
        raise ValueError("lags = (): must hold at least one lag; echoes of single pulses have no velocity")
    lags = [Lag(lag.seconds, lag.products.windowed(*window), lag.share) for lag in lags]
    scale = wavelength / (4.0 * np.pi)
    velocity = -scale * phase_rate(lags)
    last = lags[-1]
    with np.errstate(invalid="ignore", divide="ignore"):
        clean = [without_noise(lag.products, noise_power) for lag in (lags[0], last)]
        echo = [np.sqrt(each.lower * each.upper) for each in clean]
        kept = [np.abs(each.cross) / power for each, power in zip(clean, echo, strict=True)]
        noise = noise_power / np.where(echo[-1] > 0.0, echo[-1], np.nan)
        rho = np.clip(kept[-1], 0.0, 1.0)
        # A pulse's noise stands in two products, turned to opposite sides: of a steady echo that of the dwell's ends
        # alone is left.
        products, ends = samples * (1.0 - last.share), last.share / (1.0 - last.share)
        beat = noise**2 + 2.0 * noise * (1.0 - rho**4 * (1.0 - ends))
        variance = ((1.0 - rho**2) / looks + beat / products) / (2.0 * rho**2)
        spread = scale / last.seconds * np.sqrt(np.minimum(variance, np.pi**2 / 3.0))
        width = np.full(velocity.shape, np.nan)
        if len(lags) > 1:
            fall = 2.0 * np.log(kept[0] / kept[-1]) / (last.seconds**2 - lags[0].seconds ** 2)
            square = scale**2 * (fall - 2.0 / passage_s**2)
            audible = np.abs(last.products.cross) > 3.0 * noise_power / np.sqrt(samples)
            width = np.where(audible & np.isfinite(square), np.sqrt(np.maximum(square, 0.0)), np.nan)
    known = np.isfinite(spread)
    return Doppler(np.where(known, velocity, np.nan), spread, width)


def beam_passage(beamwidth_deg: float, period_s: float) -> float:
    """Time constant τ [s] of exp(−(lag/τ)²), by which the echo of a Gaussian beam that turns decorrelates: two-way
    amplitudes exp(−4 ln2 (α/θ)²), shifted by Ω·lag against each other."""
    return beamwidth_deg / (360.0 / period_s) / np.sqrt(2.0 * np.log(2.0))


def own_velocity(position: NDArray[np.float64], time: NDArray[np.float64], dwells: Dwells) -> NDArray[np.float64]:
    """Velocity [m/s] (look or 1, 1 or gate, 3) of the antennas in each cell's dwell; position (pulse, antenna, 3) [m].

    It is that of straight lines through a tenth of a second: between two pulses the sensors' noise would be all of it.
    """
    middle, when = position.mean(axis=1), time - time.mean()
    if not np.ptp(middle, axis=0).any():
        return np.zeros((1, 1, 3))
    middle = middle - middle.mean(axis=0)
    low = np.searchsorted(when, when - 0.5 * _STEADY_S, side="left")
    high = np.searchsorted(when, when + 0.5 * _STEADY_S, side="right")

    def mean(field: NDArray[np.float64]) -> NDArray[np.float64]:
        sums = np.concatenate((np.zeros((1, *field.shape[1:])), np.cumsum(field, axis=0)))
        return (sums[high] - sums[low]) / (high - low).reshape(-1, *(1,) * (field.ndim - 1))

    with np.errstate(invalid="ignore", divide="ignore"):
        square = mean(when**2) - mean(when) ** 2
        slope = (mean(when[:, None] * middle) - mean(when)[:, None] * mean(middle)) / square[:, None]
    return np.moveaxis(dwells.means(np.where(high[:, None] - low[:, None] > 1, slope, 0.0)), 0, -1)


def ground_velocity(
    velocity: NDArray[np.float64],
    own: NDArray[np.float64],
    azimuth_deg: NDArray[np.float64],
    ground_range: NDArray[np.float64],
    height: NDArray[np.float64] | float,
) -> NDArray[np.float64]:
    """Velocity (look, gate) of what echoes over ground, away from the radar, of that which antennas see that move
    themselves: own (look, 1 or gate, 3) [m/s]; azimuth_deg of the look; ground_range (look, gate) and height [m] of
    the antennas above what echoes."""
    east, north = unit_from_azimuth(azimuth_deg)
    slant = np.hypot(ground_range, height)
    outward = own[..., 0] * east + own[..., 1] * north
    return velocity + (outward * ground_range - own[..., 2] * height) / slant
