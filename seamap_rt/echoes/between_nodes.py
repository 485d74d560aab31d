"""Pulses between slow-time nodes: how the nodes around one are weighed, and what share of its power that misses.

Of all weights of a few nodes those miss least of an echo of autocorrelation ρ, in the mean, that solve R w = r, with
R_mn = ρ(t_m − t_n) between the nodes and r_n = ρ(t − t_n) between the pulse and them (Wiener 1949). The share missed is

    p(t) = 1 − 2 w·r + w·R w,      ρ(τ) = ρ_beam(ωτ) exp(−(τ/τc)²) sinc(2Fτ)

ρ_beam is the two-way beam's correlation with itself turned; F is the Doppler frequency of the fastest scatterer, up to
which all are taken to be alike: the seas' speeds are nearer to 0, and of them less is missed.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from ..radar.antenna import pattern_stamps
from ..settings import RadarSettings
from .beams import two_way_beams

_LEAST = 1e-6  # of the power, where nothing may be left out: what the tables of range and beam miss is no less
_MOST_TAPS = 12  # a pulse's: more cost what wider nodes save
_NOISE = 1e-9  # of a node's power that is not known: it bounds the weights where nodes say the same

Correlation = Callable[[NDArray[np.float64]], NDArray[np.float64]]  # ρ at lags [s]


class Between(NamedTuple):
    """Nodes every `stride` pulses, and the pulses between."""

    stride: int  # pulses
    weights: NDArray[np.float32]  # (phase, tap): pulse n·stride + phase of node n + tap − taps/2 + 1
    missed: float  # share of the power, in the mean over the phases


def interpolation_loss(share: float) -> float:
    """Share of the power that may be missed between nodes where that share may be left out."""
    return max(share, _LEAST)


def widest(correlation: Correlation, pulse_s: float, share: float, longest: int) -> Between:
    """The widest stride, up to `longest`, at which no more than a share of the power is missed, and the fewest taps for
    it; pulse_s [s]: between pulses."""
    share, narrow, wide = interpolation_loss(share), 1, longest + 1
    while wide - narrow > 1:  # what is missed grows with the stride
        middle = (narrow + wide) // 2
        narrow, wide = (
            (middle, wide)
            if interpolation_weights(correlation, pulse_s, middle, _MOST_TAPS).missed <= share
            else (narrow, middle)
        )
    if narrow == 1:
        return Between(1, np.ones((1, 1), np.float32), 0.0)
    made = (interpolation_weights(correlation, pulse_s, narrow, taps) for taps in range(2, _MOST_TAPS + 1, 2))
    return next(each for each in made if each.missed <= share or each.weights.shape[1] == _MOST_TAPS)


def interpolation_weights(correlation: Correlation, pulse_s: float, stride: int, taps: int) -> Between:
    """The weights of so many nodes, an even number, around each pulse between nodes `stride` apart."""
    node = np.arange(taps, dtype=np.float64) * stride - (taps // 2 - 1) * stride
    among = correlation(pulse_s * (node[:, None] - node))
    towards = correlation(pulse_s * (np.arange(stride, dtype=np.float64)[:, None] - node))
    weights = np.linalg.solve(among + _NOISE * np.eye(taps), towards.T).T
    missed = 1.0 - 2.0 * np.sum(weights * towards, axis=1) + np.sum((weights @ among) * weights, axis=1)
    return Between(stride, weights.astype(np.float32), float(missed.mean()))


def correlation_of(radar: RadarSettings, sweep_deg_s: float, doppler_hz: float, time_constant_s: float) -> Correlation:
    """ρ of what a beam hears that turns so fast [°/s], with the fastest scatterer's Doppler frequency and the shortest
    decorrelation time τc of any, which may be infinite."""
    step, beam = _beam_correlation(cast(Hashable, radar), pattern_stamps(radar))
    turned = np.arange(beam.size) * (step / max(np.radians(sweep_deg_s), 1e-12))  # s

    def correlation(lag: NDArray[np.float64]) -> NDArray[np.float64]:
        smooth = np.exp(-((lag / time_constant_s) ** 2)) * np.sinc(2.0 * doppler_hz * lag)
        return smooth * np.interp(np.abs(lag), turned, beam, right=0.0)

    return correlation


@lru_cache(maxsize=8)
def _beam_correlation(settings: Hashable, _: Hashable) -> tuple[float, NDArray[np.float64]]:
    """Size of a step [rad], and the two-way beam's correlation with itself turned by so many; of all paths' beams, that
    which changes fastest."""
    beams = two_way_beams(cast(RadarSettings, settings))
    voltage = beams.tables.astype(np.float64).prod(axis=1)
    changes = np.sum(np.diff(voltage, axis=1) ** 2, axis=1) / np.sum(voltage**2, axis=1)
    spectrum = np.abs(np.fft.rfft(voltage[np.argmax(changes)], 2 * voltage.shape[1])) ** 2
    correlation = np.fft.irfft(spectrum)[: voltage.shape[1]]
    return 1.0 / beams.scale, correlation / correlation[0]
