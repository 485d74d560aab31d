"""Waves that run along +k and along −k, moved in time and made ready for a real FFT; compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled


def phasor(omega: NDArray[np.float64], time: float) -> NDArray[np.complex64]:
    """exp(−iωt), in the shape of omega [rad/s]; time: s.

    The phase is reduced in float64: 12 hours lose nothing.
    """
    turns = omega * (time / (2.0 * np.pi))
    turns -= np.rint(turns)
    phase = (turns * (-2.0 * np.pi)).astype(np.float32)
    made = np.empty(phase.shape, dtype=np.complex64)
    np.cos(phase, out=made.real)
    np.sin(phase, out=made.imag)
    return made


@compiled
def half_plane(ahead, behind, factor, out):
    """Write ahead·f + behind·f* into the rows of an FFT, with zeros between its positive and its negative waves.

    ahead, behind: complex64 amplitudes of the waves along k and along −k, (2m + 1, column), rows 0 … m, −m … −1;
    factor f: what is the same for all directions, (m + 1, column); out: complex64 (2m + 1 or more, column).
    """
    most, rows = factor.shape[0] - 1, ahead.shape[0]
    for row in range(rows):
        folded, to = (row, row) if row <= most else (rows - row, out.shape[0] - rows + row)
        for column in range(factor.shape[1]):
            f = factor[folded, column]
            out[to, column] = ahead[row, column] * f + behind[row, column] * np.conj(f)
    out[most + 1 : out.shape[0] - most] = 0.0
