"""Coherent integration: pulses are added before they are multiplied, for echoes below a single pulse's noise.

The sum of the pulses that lie within half of `coherent_s` of a pulse, times that pulse of the other receiver, is a sum
of products of pulses that lie apart. Each is freed of the Doppler phase that the velocity about the cell gives it, and
they are averaged: K products for each pulse instead of one leave 1/K of the noise's beat with itself. Lags of both
signs are treated alike, so that an error of the velocity costs some power and changes no phase.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .pairs import PulsePairs, Rows, rows_apart
from .velocity import Lag, phase_rate
from .windows import Covariance

# Gates and looks over which the velocity is averaged: a single cell's, where it is needed, is mostly noise.
_AROUND = (np.ones(5), np.ones(3))


@dataclass(frozen=True)
class Extended:
    """Rows of the lower and the upper receiver that are multiplied, and the pulses whose dwells they count to; how
    much longer [s] each lag, lower less upper, is than that of the pair it extends."""

    members: tuple[tuple[Rows, Rows, Rows], ...]
    beyond: tuple[float, ...]


def extended(
    pairs: PulsePairs,
    transmitter: NDArray[np.integer],
    heard: NDArray[np.bool_],
    time: NDArray[np.float64],
    interval: float,
    coherent_s: float,
    cycle: int,
) -> Extended:
    """The pairs themselves, and those with the lower pulses of the same transmitter up to half of coherent_s away,
    `cycle` pulses apart; heard (pulse, 2)."""
    members, beyonds = [], []
    for lower, upper in pairs.pairs:
        lag = int(np.sign(np.median(lower - upper))) if lower.size else 0
        members.append((lower, upper, lower))
        partner = np.full(time.size, -1)
        partner[lower] = upper
        beyonds.append(0.0)
        for step in range(1, int(0.5 * coherent_s / (cycle * interval) + 1e-9) + 1):
            for beyond in (away := step * cycle * interval, -away) if lag == 0 else (lag * step * cycle * interval,):
                owner, other = rows_apart(time, beyond, interval)
                good = (partner[owner] >= 0) & heard[other, 0] & (transmitter[other] == transmitter[owner])
                if good.any():
                    members.append((other[good], partner[owner[good]], owner[good]))
                    beyonds.append(beyond)
    return Extended(tuple(members), tuple(beyonds))


def integrated(means: Sequence[Covariance], extended: Extended, lags: Sequence[Lag]) -> Covariance:
    """Their mean, each freed of the Doppler phase that it has beyond that of the pair it extends; powers are those of
    single pulses, noise and all."""
    base = [each for each, beyond in zip(means, extended.beyond, strict=True) if beyond == 0.0]
    cross: NDArray[np.complex128] = np.sum([each.cross for each in base], axis=0)
    count = np.full(np.shape(cross), float(len(base)))
    if len(base) < len(means):
        rate = np.nan_to_num(
            phase_rate([Lag(each.seconds, each.products.windowed(*_AROUND), each.share) for each in lags])
        )
        for each, beyond in zip(means, extended.beyond, strict=True):
            if beyond:
                # The first and the last looks have no pulses before and after them.
                cross = cross + np.where(each.known, each.cross * np.exp(-1j * rate * beyond), 0.0)
                count = count + each.known
    return Covariance(
        np.asarray(cross / count, dtype=np.complex128),
        np.asarray(sum(each.lower for each in base) / len(base)),
        np.asarray(sum(each.upper for each in base) / len(base)),
    )
