"""The functions of a formula that is written once and works on NumPy's arrays and on those of the device.

`functions_of(value)` gives NumPy's for an array or a number, and for an array of Dr.Jit its own under NumPy's names.
A formula for both keeps to these functions and to operators with arrays and Python's own numbers: a scalar of NumPy on
the left of an array of the device would bring that back to the host.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray


class _Numpy:
    """NumPy's."""

    sqrt, exp, tanh, sin, cos = np.sqrt, np.exp, np.tanh, np.sin, np.cos
    arctan, square, where, minimum, maximum, clip = np.arctan, np.square, np.where, np.minimum, np.maximum, np.clip

    @staticmethod
    def ndtr(value: Any) -> Any:
        """The normal distribution's cumulative share."""
        return scipy.special.ndtr(value)

    @staticmethod
    def split(position: Any) -> tuple[Any, Any]:
        """The whole part of numbers ≥ 0, as an index, and the rest."""
        index = position.astype(np.intp)
        return index, position - index.astype(np.float32)

    @staticmethod
    def take(table: NDArray[Any], index: Any) -> Any:
        """The table's entries at these places."""
        return table.take(index)


class _Device:
    """Dr.Jit's."""

    def __init__(self) -> None:
        from .device import device

        self._device = device()
        dr = self._device.dr
        self.sqrt, self.exp, self.tanh, self.sin, self.cos = dr.sqrt, dr.exp, dr.tanh, dr.sin, dr.cos
        self.arctan, self.square, self.where, self.clip = dr.atan, dr.square, dr.select, dr.clip
        self.minimum, self.maximum = dr.minimum, dr.maximum

    def ndtr(self, value: Any) -> Any:
        """Gauss's distribution, to 1e-7 of 1."""
        return 0.5 + 0.5 * self._device.dr.erf(value * float(np.sqrt(0.5)))

    def split(self, position: Any) -> tuple[Any, Any]:
        """See `_Numpy`."""
        index = self._device.UInt32(position)
        return index, position - self._device.Float(index)

    def take(self, table: NDArray[Any], index: Any) -> Any:
        """See `_Numpy`: of a table on the host."""
        return self._device.dr.gather(self._device.Float, self._device.place(table), index)


def functions_of(value: Any) -> Any:
    """Those that go with an array or a number."""
    return _Numpy if isinstance(value, np.ndarray | np.generic | float | int) else _Device()
