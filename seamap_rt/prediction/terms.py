"""Terms of a wave's time, two in one complex transform, and the sums of them: the compiled loops of `wave_sum`.

Term m is c β_m (−j)^m with a carrier c of each wave and real β_m, and its field is real. Of the fields of an even term
and the odd one after it, one as the real and one as the imaginary part, the wave's amplitudes are f c a + g (c a)*
with real f and g; * is the conjugate of the wave that runs the other way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled

Waves = NDArray[np.complex64]


@dataclass(frozen=True)
class Terms:
    """carrier (n, n); mine and against (pair, n, n): f and g."""

    carrier: Waves
    mine: NDArray[np.float32]
    against: NDArray[np.float32]

    @classmethod
    def of(cls, carrier: NDArray[np.complexfloating], shares: Sequence[NDArray[np.floating]]) -> Terms:
        """shares: β (n, n) of an even number of terms."""
        signs = (1.0, 1.0, -1.0, -1.0)  # of j^m (−j)^m along the pairs: the odd term's j stands beside its (−j)^m
        signed = [signs[m % 4] * share for m, share in enumerate(shares)]
        even, odd = (np.stack(signed[first::2]) for first in (0, 1))
        mine, against = 0.5 * (even + odd), 0.5 * (even - odd)[:, ::-1, ::-1]
        return cls(
            carrier.astype(np.complex64), mine.astype(np.float32), np.ascontiguousarray(against, dtype=np.float32)
        )

    @property
    def count(self) -> int:
        """Of pairs."""
        return self.mine.shape[0]

    def pairs(self, amplitudes: Waves) -> Waves:
        """(pair, n, n) of amplitudes (n, n)."""
        made = np.empty(self.mine.shape, np.complex64)
        _pairs(self.carrier, self.mine, self.against, amplitudes, made)
        return made

    def amplitudes(self, pairs: Waves) -> Waves:
        """The adjoint of that."""
        made = np.empty(self.carrier.shape, np.complex64)
        _amplitudes(self.carrier, self.mine, self.against, pairs, made)
        return made


@compiled
def _pairs(
    carrier: Waves, mine: NDArray[np.float32], against: NDArray[np.float32], amplitudes: Waves, made: Waves
) -> None:
    count, rows, columns = mine.shape
    for i in range(rows):
        for j in range(columns):
            forth = carrier[i, j] * amplitudes[i, j]
            a, b = rows - 1 - i, columns - 1 - j
            back = np.conj(carrier[a, b] * amplitudes[a, b])
            for pair in range(count):
                made[pair, i, j] = mine[pair, i, j] * forth + against[pair, i, j] * back


@compiled
def _amplitudes(
    carrier: Waves, mine: NDArray[np.float32], against: NDArray[np.float32], pairs: Waves, made: Waves
) -> None:
    count, rows, columns = mine.shape
    for i in range(rows):
        for j in range(columns):
            a, b = rows - 1 - i, columns - 1 - j
            total = np.complex64(0.0)
            for pair in range(count):
                total += mine[pair, i, j] * pairs[pair, i, j] + against[pair, a, b] * np.conj(pairs[pair, a, b])
            made[i, j] = np.conj(carrier[i, j]) * total
