"""Coefficients at a field's knots, made on the device of waves that lie there: as `MovingField` makes them here.

Only the waves go up, once: their frequencies, their amplitudes along k and along −k, and each field's factor. A knot
then costs no byte. Sums and FFTs are of float32 as the host's are, in another order: some 1e-7 of the field's rms.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compute.array_library import ArrayLibrary
from ..compute.device import device
from .fields import Kind
from .half_plane import phasor
from .knots import Knot, Strip


class WavesOnDevice:
    """The waves of a lattice there, as arrays of a library."""

    def __init__(
        self,
        library: ArrayLibrary,
        ahead: NDArray[np.complex64],
        behind: NDArray[np.complex64],
        omega: NDArray[np.float64],
        shape: tuple[int, int],
        time_step: float,
    ) -> None:
        """ahead, behind: amplitudes (2m + 1, column) over the spline's transform, as `half_plane` takes them; omega:
        rad/s, on the quadrant (m + 1, column); shape: rows and columns of the periodic grid; time_step: s."""
        self._library, self._shape, self._time_step = library, shape, time_step
        self._ahead, self._behind, self._omega = (library.place(each) for each in (ahead, behind, omega))
        self._factors: dict[Kind, Any] = {}

    def coefficients(
        self,
        wanted: Sequence[Knot],
        per_elevation: Callable[[Kind], NDArray[np.complex64]],
        strip: Strip,
        columns: int,
    ) -> list[Any]:
        """Flat Float arrays (row, column) of each knot: the rows of the strip, and so many columns with their halo.

        per_elevation: a field's amplitude per elevation on the quadrant.
        """
        of, xp = device(), self._library.xp
        made = [of.dr.empty(of.Float, strip.count * columns) for _ in wanted]
        rows = (strip.first + xp.arange(strip.count)) % self._shape[0]
        places = xp.arange(columns) % self._shape[1]
        states: dict[int, Any] = {}
        with self._library.writing(made) as lent:
            for (number, kind), grid in zip(wanted, lent, strict=True):
                if number not in states:
                    states[number] = phasor(xp, self._omega, number * self._time_step)
                factor = states[number] * self._factor(kind, per_elevation)
                half = xp.fft.ifft(self._half_plane(factor, self._shape[0]), axis=0, norm="forward")
                values = xp.fft.irfft(half[rows], n=self._shape[1], axis=1, norm="forward")
                grid.reshape(strip.count, columns)[...] = values[:, places]
        return made

    def _factor(self, kind: Kind, per_elevation: Callable[[Kind], NDArray[np.complex64]]) -> Any:
        if kind == "elevation":
            return 1.0
        if kind not in self._factors:
            self._factors[kind] = self._library.place(per_elevation(kind))
        return self._factors[kind]

    def _half_plane(self, factor: Any, rows: int) -> Any:
        """What the compiled `half_plane` writes, (row, column)."""
        most = factor.shape[0] - 1
        half = self._library.xp.zeros((rows, factor.shape[1]), dtype=np.complex64)
        for waves, to, folded in (
            (slice(most + 1), slice(most + 1), factor),
            (slice(most + 1, None), slice(rows - most, None), factor[:0:-1]),
        ):
            half[to] = self._ahead[waves] * folded + self._behind[waves] * folded.conj()
        return half
