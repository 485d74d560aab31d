"""How the errors of neighbouring dwells and gates go together: what of one gate's error its neighbours share.

To first order the phase of a gate is off by Im(y'y*)/|y|², y the gate's voltage and y' what differs between the
receivers: noise, the same scatterers at other heights (rough), or the same scatterers with the phase that the surface
turns through within the pulse (tilt). The covariance of y'y* over gates follows from the response p of the receiver:

- noise: ρ(d) R(d), ρ the noise's own correlation and R = ∫ p(s) p(s − d) ds that of the echo,
- rough: R²,
- tilt: QR − X², where Q = ∫ s p(s) (s − d) p(s − d) ds and X = ∫ s p(s) p(s − d) ds. A bright spot between two gates
  moves both to it, but from opposite sides, so that means over gates err less than a gate's own error says. For a
  Gaussian pulse this is −½ (R²)''. Where bright spots are taken off, what is left has BrightSpots.covariance.

Gaussian moments: Goodman, Speckle Phenomena in Optics (2007), ch. 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...radar.waveform import RangeResponse
from ..phase.uncertainty import Dwelt
from .bright_spots import BrightSpots
from .gate_moments import GateMoments

Map = NDArray[np.float64]

_NOTHING = 5e-3  # a smaller correlation is none


@dataclass(frozen=True)
class ErrorCovariance:
    """Of heights of single dwells and gates.

    parts (part, look, gate): standard deviations [m] of the errors by tilt, roughness and noise, infinite where there
    is no height; along (part, gates): their correlations at that many gates' distance; beside: that of speckle between
    neighbouring looks.
    """

    parts: Map
    along: Map
    beside: float

    @property
    def variance(self) -> Map:
        """(look, gate) m²."""
        return np.sum(self.parts**2, axis=0)

    @property
    def of_means(self) -> Map:
        """(look, gate) m²: variance of a mean over many alike, times their number."""
        along = np.maximum(1.0 + 2.0 * self.along[:, 1:].sum(axis=1), 0.0)
        along[:2] *= 1.0 + 2.0 * self.beside
        with np.errstate(invalid="ignore"):  # nothing of infinity
            return np.nan_to_num(np.tensordot(along, self.parts**2, 1), nan=np.inf, posinf=np.inf)


def correlation_by_range(response: RangeResponse, lags: NDArray[np.floating], spots: BrightSpots | None = None) -> Map:
    """Correlations (tilt, rough, noise; lag) of errors at those distances [m]; lags[0] = 0.

    spots: whose estimate has been taken off the phases.
    """
    moments, lags = GateMoments.of(response), np.asarray(lags, dtype=np.float64)
    echo = moments.echo(lags)
    tilt = moments.both_moved(lags) * echo - moments.moved(lags) ** 2 if spots is None else spots.covariance(lags)
    found = np.stack((tilt / tilt[0], echo**2, response.noise_correlation(lags) * echo))
    return found[:, : 1 + int(np.flatnonzero(np.any(np.abs(found) > _NOTHING, axis=0))[-1])]


def correlation_beside(dwelt: Dwelt) -> float:
    """Correlation of the speckle's errors between the dwells of neighbouring looks.

    From that of the pulses, of which the last of one dwell follow the first of the next; half at most, as for two
    dwells that share half of their pulses.
    """
    square = np.abs(dwelt.correlation[: dwelt.pulses]) ** 2
    lag = np.arange(square.size)
    within = dwelt.pulses + 2.0 * float(((dwelt.pulses - lag) * square)[1:].sum())
    return min(0.5, float((lag * square).sum()) / within)
