"""The upper receiver's channel over the lower's, as it is given or as measured on the echoes by reciprocity.

From the lower antenna to the upper one an echo takes the very path that it takes from the upper to the lower. With T
and R what transmitter and receiver put to it, V₀₁ = T₀ R₁ s and V₁₀ = T₁ R₀ s: their ratio is R₁/R₀ · T₀/T₁. One
transmitter that is switched between the antennas leaves the receivers' ratio; what lies between the switch and an
antenna's phase centre is in T and R alike, cancels, and stays unknown. Noise is taken to be amplified as the echo is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...conventions import from_db
from ...errors import SchemaError
from .products import Products
from .windows import Covariance


@dataclass(frozen=True)
class Channel:
    """Complex gain of the upper receiver's channel over the lower's."""

    ratio: complex = 1.0 + 0.0j

    @classmethod
    def given(cls, gain_db: float, phase_deg: float) -> Channel:
        """The upper receiver's voltage gain over the lower's, from a power gain [dB] and a phase [deg]."""
        return cls(complex(np.sqrt(from_db(gain_db)) * np.exp(1j * np.radians(phase_deg))))

    def corrected(self, covariance: Covariance) -> Covariance:
        """As it would be had the upper receiver been the lower's like."""
        if self.ratio == 1.0:
            return covariance
        cross, upper = covariance.cross / np.conj(self.ratio), covariance.upper / abs(self.ratio) ** 2
        return replace(covariance, cross=cross, upper=upper)

    def noise_power(self, recorded: float) -> float:
        """Noise [W] of either receiver once corrected, of the mean of both as it was recorded."""
        return 2.0 * recorded / (1.0 + abs(self.ratio) ** 2)


def crossing(
    heard: NDArray[np.bool_],
    transmitter: NDArray[np.integer],
    antennas: tuple[int, int],
    time: NDArray[np.float64],
    interval: float,
    receivers: tuple[int, int],
) -> list[list[Products]]:
    """Products of what goes from the lower antenna to the upper with what goes back, on neighbouring pulses: those
    that follow and those that go before, whose Doppler phases cancel.

    heard (pulse, 2) lower, upper receiver. Raises SchemaError where there are none.
    """
    up, down = heard[:, 1] & (transmitter == antennas[0]), heard[:, 0] & (transmitter == antennas[1])
    following = np.abs(np.diff(time) - interval) < 0.5 * interval
    after, before = np.flatnonzero(following & up[:-1] & down[1:]), np.flatnonzero(following & down[:-1] & up[1:])
    if not (after.size and before.size):
        raise SchemaError(
            "echoes: retrieval.channels = 'from_cross_paths': must hold, on neighbouring pulses, the lower antenna's "
            "pulse at the upper receiver and the upper one's at the lower; record both receivers while the "
            "transmitters alternate, or give the channel by retrieval.channel_gain_db and channel_phase_deg"
        )
    return [
        [Products((after, receivers[1]), (after + 1, receivers[0]), after)],
        [Products((before + 1, receivers[1]), (before, receivers[0]), before + 1)],
    ]


def ratio_of(crossings: Sequence[Covariance]) -> Channel:
    """The channel that the products of both directions give, over all cells together.

    Raises SchemaError where a receiver has no echo on its cross path.
    """
    known = np.logical_and.reduce([each.known for each in crossings])
    product = sum(complex(each.cross[known].sum()) for each in crossings)
    up, down = (sum(float(getattr(c, name)[known].sum()) for c in crossings) for name in ("lower", "upper"))
    if not (up > 0.0 and down > 0.0):
        raise SchemaError(
            "echoes: retrieval.channels = 'from_cross_paths': must hold echoes on both cross paths; one of the "
            "receivers heard nothing"
        )
    return Channel(complex(np.sqrt(up / down) * np.exp(1j * np.angle(product))))
