"""The strongest of the long waves, few in a circle: their part of a fit's normal matrix, inverted.

Observations determine a swell a million times better than its prior where it was seen, and not at all a wavelength
farther out. Conjugate gradients that stop early leave waves out there that are far too high, and these arrive as time
goes. So the normal matrix of such waves is written out, square by square, and factorised (Cholesky).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from .lattice import Lattice
from .observations import damped

if TYPE_CHECKING:
    from .assimilation import Batch

_MOST = 240  # waves
_LEAST = 1e-2  # of the strongest one's prior variance
_LONG = 0.15  # of how wide what was seen is: shorter waves are told well enough apart by zones
_SQUARES = 5.0  # a wavelength of the shortest of them


class StrongestWaves:
    """Of one lattice, as batches tell of them."""

    def __init__(self, lattice: Lattice, batches: Sequence[Batch]) -> None:
        power = lattice.scale**2
        seen = [np.ptp((each.seen.x, each.seen.y), axis=1).max() for each in batches if len(each.seen)]
        longest = 2.0 * np.pi / (_LONG * max(seen, default=0.0) + 1e-9)
        wanted = (power > _LEAST * power.max()) & (power > 0.0) & (lattice.k < longest)
        order = np.flatnonzero(wanted)
        self.chosen = order[np.argsort(power.ravel()[order])[::-1][:_MOST]]
        self._inverse = None if not self.chosen.size else cho_factor(self._operator(lattice, batches), lower=True)

    def _operator(self, lattice: Lattice, batches: Sequence[Batch]) -> NDArray[np.float64]:
        kx, ky, k, omega, root = (
            each.ravel()[self.chosen] for each in (lattice.kx, lattice.ky, lattice.k, lattice.omega, lattice.scale)
        )
        side, made = 2.0 * np.pi / (_SQUARES * k.max()), np.eye(2 * k.size)
        for batch in batches:
            seen, factor = batch.seen, lattice.factor(str(batch.seen.kind[0]), batch.sum.water).ravel()[self.chosen]
            i, j = (np.floor((each - each.min()) / side).astype(np.intp) for each in (seen.x, seen.y))
            _, square = np.unique(i * (int(j.max()) + 1) + j, return_inverse=True)
            information = np.bincount(square, batch.weight)
            x, y, time = (
                np.bincount(square, batch.weight * each) / information for each in (seen.x, seen.y, seen.time)
            )
            turns = np.outer(x, kx) + np.outer(y, ky) - np.outer(time, omega)
            size = root * factor * damped(batch.sum.blur.mean(axis=0), kx, ky)
            waves = np.sqrt(information)[:, None] * np.exp(1j * turns) * size
            rows = np.hstack((waves.real, -waves.imag)).astype(np.float32)
            made += rows.T @ rows
        return made

    def turned_back(self, unknowns: NDArray[np.complex64]) -> NDArray[np.complex64]:
        """Of the chosen waves (wave,)."""
        parts = np.concatenate((unknowns.real, unknowns.imag))
        real, imaginary = np.split(np.asarray(cho_solve(self._inverse, parts)), 2)
        return (real + 1j * imaginary).astype(np.complex64)
