"""How far the phase of a sum over a window is off: speckle and noise, given how strong the echo is in that window.

Of one sample of speckle the phase between two receivers follows, given both amplitudes, von Mises' law of concentration
2|γ||V₁V₂|/((1 − |γ|²)⟨P⟩): a strong echo's phase is good, a faded one's bad. Lee's law (Lee et al. 1994), whose tails
are heavy, is its mean over all amplitudes. Those are seen, so that nothing need be averaged over: what is not
known of the phase is the part of the power that the receivers do not share, over the power that is there.

How many independent samples a window of dwells and gates holds, of the echo's speckle and of the noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..radar.waveform import RangeResponse
from .description import RadarDescription
from .windows import Covariance, independent_looks

Weights = tuple[NDArray[np.float64], NDArray[np.float64]]  # of a window: along range, across looks
ONE_CELL: Weights = (np.ones(1), np.ones(1))


@dataclass(frozen=True)
class DwellPulses:
    """What one look's dwell holds in a gate: pulses, and the speckle's correlation from pulse to pulse."""

    pulses: int
    correlation: NDArray[np.float64]  # |ρ| at lags of 0, 1, 2 … pulses
    looks: int = 1_000_000  # that there are: a window is no wider

    def resample(self, step: float) -> DwellPulses:
        """The same dwell where one pulse in 1/step is compared; step: a ratio, above 1 for more."""
        if not step > 0.0:  # a receiver that heard nothing
            return self
        count = max(1, round(self.pulses * step))
        lags = np.arange(count) / step
        return DwellPulses(count, np.interp(lags, np.arange(self.correlation.size), self.correlation), self.looks)

    def samples(self, window: Weights, radar: RadarDescription) -> Samples:
        """Of a window of such dwells; its looks are taken to be independent, its gates overlap by the pulse."""
        range_weights, look_weights = window
        beyond = max(0, look_weights.size // 2 - (self.looks - 1))
        look_weights = look_weights[beyond : look_weights.size - beyond]
        echo, noise = echo_correlations(radar.response, radar.spacing, range_weights.size)
        across = independent_looks(look_weights, np.eye(1, look_weights.size).ravel())
        speckle = max(1.0, independent_looks(np.ones(self.pulses), self.correlation))
        return Samples(
            speckle * independent_looks(range_weights, echo) * across,
            self.pulses * independent_looks(range_weights, noise) * across,
        )


@lru_cache(maxsize=8)
def echo_correlations(
    response: RangeResponse, spacing: float, gates: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of the echo and of the noise between gates 0, 1, 2 … apart."""
    lags = spacing * np.arange(gates)
    fine = np.linspace(-2.0 * response.support_m, 2.0 * response.support_m, 801)
    pulse = response(fine)
    return np.array([pulse @ response(fine + lag) for lag in lags]) / (pulse @ pulse), response.noise_correlation(lags)


@dataclass(frozen=True)
class Samples:
    """Independent samples in a window."""

    speckle: float
    noise: float


_TREND_GATES = 21  # over which the incoherent share is averaged where noise hides it
_SHARE_SPREAD = 0.7  # of a cell's incoherent share about its gate's mean, of itself
_FAINTEST = 0.02  # of the noise: power below it counts as none

Map = NDArray[np.float64]


def incoherent_power(wide: Covariance, noise_power: float, samples: float, kept: Map | float = 1.0) -> Map:
    """Power [W], (look, gate), that the receivers do not share, without the noise's: ½(P₁ + P₂) − |C| − N.

    wide: sums over a longer window, since one sample of speckle is always coherent with itself; samples: of noise in
    that window; kept: as `pulse_coherence_kept` gives it. What compared pulses lose they lose alike with the pulses
    before and after, and no phase is off by it. Where noise hides it the share of all looks at about that range stands
    in, as far as it does.
    """
    known = wide.has_value
    power = np.where(known, 0.5 * (wide.lower + wide.upper), noise_power) - noise_power
    shared = np.where(known, np.abs(wide.cross), 0.0)
    missing = np.where(known, kept * power - shared, 0.0)
    power = np.maximum(power, 0.0)
    around = np.ones(min(_TREND_GATES, power.shape[1]))
    all_missing, all_power = (np.convolve(each.sum(axis=0), around, "same") for each in (missing, power))
    share = np.divide(all_missing, all_power, out=np.ones_like(all_power), where=all_power > np.abs(all_missing))
    usual = np.clip(share, 0.0, 1.0) * power
    measured, expected = (noise_power / np.sqrt(samples)) ** 2, (_SHARE_SPREAD * usual) ** 2
    with np.errstate(invalid="ignore", divide="ignore"):
        trust = np.where(expected + measured > 0.0, expected / (expected + measured), 1.0)
    return trust * np.maximum(missing, 0.0) + (1.0 - trust) * usual


def pulse_coherence_kept(products: Covariance, noise_power: float, lag: float) -> Map:
    """Share (look, gate) of an echo's covariance that is left between pulses `lag` times as far apart as those of
    `products`, by how fast its phase turns and how far that scatters; 1 where nothing is heard."""
    with np.errstate(invalid="ignore", divide="ignore"):
        share = products.cross.real / (0.5 * (products.lower + products.upper) - noise_power)
    return np.cos(lag * np.arccos(np.clip(np.nan_to_num(share, nan=1.0), -1.0, 1.0)))


def estimation_doubt(samples: float) -> float:
    """By how much a variance that was itself found from so many complex samples understates the errors' mean square:
    theirs is Student's law, ν/(ν − 2); at most 2.

    Of samples that fade, each counted by its power, half as many are as good as even ones: ν is their number, not twice
    that.
    """
    return min(2.0, samples / max(samples - 2.0, 1e-9))


def phase_variances(
    cells: Covariance,
    incoherent: Map,
    noise_power: float,
    looks: float,
    samples: float,
    noise_square: float = 1.0,
    doubt: float = 1.0,
) -> tuple[Map, Map]:
    """Variance [rad²], (look, gate), of the phase of `cells`, while it is small: by speckle, and by noise.

    incoherent: power [W] that the receivers do not share, and by `doubt` of how much more it may be; looks: independent
    samples of speckle in the cell's window; samples: of noise, which is new at each pulse. The noise's own beat with
    itself averages less or more than its beat with the echo: noise_square (PulsePairs). Infinite where nothing is
    heard.
    """
    # The law's is the product of both amplitudes: where one of them fades its mean with the other's is too large.
    power = np.minimum(0.5 * (cells.lower + cells.upper) - noise_power, np.abs(cells.cross))
    with np.errstate(invalid="ignore", divide="ignore"):
        power = np.where(power > 0.0, np.maximum(power, _FAINTEST * noise_power), np.nan)
        noise = noise_power / power
        parts = doubt * incoherent / power / looks, (2.0 * noise + noise_square * noise**2) / (2.0 * samples)
    known = np.isfinite(parts[0] + parts[1])
    return np.where(known, parts[0], np.inf), np.where(known, parts[1], np.inf)


def _von_mises_variances() -> Map:
    """Of inverse concentrations v/(1 + v) = 0 … 1, evenly spaced: v itself while small, π²/3 in the end."""
    share = np.linspace(0.0, 1.0, _TABLE)
    spread = np.full(_TABLE, np.pi**2 / 3.0)
    spread[0] = 0.0
    for n in range(1, _TABLE - 1):
        concentration = (1.0 - share[n]) / share[n]
        angle = np.linspace(0.0, min(np.pi, 12.0 / np.sqrt(concentration)), 1001)
        density = np.exp(concentration * (np.cos(angle) - 1.0))
        spread[n] = np.trapezoid(angle**2 * density, angle) / np.trapezoid(density, angle)
    return spread


_TABLE = 257
_VARIANCES = _von_mises_variances()


def wrapped_variance(variance: Map) -> Map:
    """Variance [rad²] of a phase that cannot leave the circle, of von Mises' law, whose inverse concentration is
    `variance`: itself while small, π²/3 at most."""
    with np.errstate(invalid="ignore"):
        position = (_TABLE - 1) * np.where(np.isinf(variance), 1.0, variance / (1.0 + variance))
    low = np.clip(np.nan_to_num(position).astype(int), 0, _TABLE - 2)
    part = position - low
    return _VARIANCES[low] * (1.0 - part) + _VARIANCES[low + 1] * part
