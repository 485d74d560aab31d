"""The standard error of each height, from the echo alone."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..analytic.phase import phase_std_lee94
from .covariance import Covariance, independent_looks, pulse_correlation
from .description import RadarDescription
from .heights import Heights


def height_std(
    voltage: NDArray[np.complex64],
    look: NDArray[np.intp],
    dwell: Covariance,
    echo_power: NDArray[np.float64],
    found: Heights,
    radar: RadarDescription,
    noise_square: float = 1.0,
) -> NDArray[np.float64]:
    """Standard error of the height: speckle and noise, which average at different rates, added in square.

    Speckle: Lee's statistics with the coherence that is left when the noise's share is taken out, from a longer window
    (one look's own coherence says nothing), and as many samples as the dwell's measured correlation leaves. Noise: it
    is new at every pulse; phase variance (2/SNR + 1/SNR²)/2N with the cell's own, faded SNR. The longer window follows
    the slopes that the heights were averaged along, or the waves would count as a lack of coherence.

    Of alternating pulses voltage and look are those that the lower receiver heard: half as many, and the noise on the
    upper ones, which each serve two pairs, averages no better. noise_square: what is left of the 1/SNR², the noise's
    beat with itself, of which two pairs a pulse make twice as many samples (PulsePairs).
    """
    range_weights, look_weights = found.window
    pulses = max(1, int(np.median(np.bincount(look[look >= 0])))) if (look >= 0).any() else 1
    correlation = pulse_correlation(voltage, look, radar.noise_power, pulses - 1)
    lags = radar.spacing * np.arange(range_weights.size)
    fine = np.linspace(-2.0 * radar.response.support_m, 2.0 * radar.response.support_m, 801)
    pulse = radar.response(fine)
    echo_lag = np.array([pulse @ radar.response(fine + lag) for lag in lags]) / (pulse @ pulse)
    in_azimuth = independent_looks(look_weights, np.eye(1, look_weights.size).ravel())
    looks = independent_looks(np.ones(pulses), correlation) * independent_looks(range_weights, echo_lag) * in_azimuth
    samples = pulses * independent_looks(range_weights, radar.response.noise_correlation(lags)) * in_azimuth

    wide = dwell.windowed_along(
        np.ones(2 * max(2, range_weights.size // 2 + 1) + 1),
        np.ones(look_weights.size),
        *found.phase_slopes,
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        clean = np.maximum(wide.lower - radar.noise_power, 0.0) * np.maximum(wide.upper - radar.noise_power, 0.0)
        coherence = np.clip(np.nan_to_num(np.abs(wide.cross) / np.sqrt(clean), posinf=1.0), 0.0, 0.999999)
        noise = radar.noise_power / np.maximum(echo_power, 0.0)
        from_noise = (2.0 * noise + noise_square * noise**2) / (2.0 * samples)
    speckle = np.interp(coherence, *_lee_table(round(max(1.0, looks), 1)))
    # A phase cannot be worse known than not at all: uniform over the circle.
    return found.gain * np.sqrt(np.minimum(speckle**2 + from_noise, np.pi**2 / 3.0))


@lru_cache(maxsize=64)
def _lee_table(looks: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coherences, and the phase's standard deviation at them for a number of looks."""
    coherence = np.concatenate((np.linspace(0.0, 0.95, 16), 1.0 - np.geomspace(0.04, 1e-6, 16)))
    return coherence, phase_std_lee94(coherence, looks)
