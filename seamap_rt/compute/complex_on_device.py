"""Complex numbers that lie on the device, in a form that NumPy and xarray take for an array.

A dataset holds them as it holds any array, and whoever knows what they are computes where they lie. Anybody else asks
NumPy something of them, and then they come here, once, and are counted in `moved`.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import NDArray

from .device import ONE_AT_A_TIME, device


class ComplexOnDevice(NDArrayOperatorsMixin):
    """Complex64 numbers of a shape, their real and imaginary parts flat arrays of the device."""

    dtype = np.dtype(np.complex64)

    def __init__(self, real: Any, imag: Any, shape: tuple[int, ...]) -> None:
        self.real_there, self.imag_there, self.shape = real, imag, shape

    @classmethod
    def of(cls, values: NDArray[np.complex64]) -> ComplexOnDevice:
        """Values of the host, placed there."""
        with ONE_AT_A_TIME:
            return cls(device().place_single(values.real), device().place_single(values.imag), values.shape)

    @property
    def ndim(self) -> int:
        """How many axes."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """How many numbers."""
        return int(np.prod(self.shape))

    @property
    def nbytes(self) -> int:
        """Of them all."""
        return self.dtype.itemsize * self.size

    @cached_property
    def here(self) -> NDArray[np.complex64]:
        """The same on the host."""
        values = np.empty(self.shape, dtype=self.dtype)
        with ONE_AT_A_TIME:
            values.real = device().fetch(self.real_there, self.shape)
            values.imag = device().fetch(self.imag_there, self.shape)
        return values

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.here, dtype=dtype, copy=copy)

    def __getitem__(self, key: Any) -> Any:
        return self.here[key]

    def __len__(self) -> int:
        return self.shape[0]

    def __array_ufunc__(self, function: Any, method: str, *given: Any, **options: Any) -> Any:
        return getattr(function, method)(*_here(given), **_here(options))

    def __array_function__(self, function: Any, _: Any, given: Any, options: Any) -> Any:
        return function(*_here(given), **_here(options))

    def __reduce__(self) -> tuple[Any, ...]:
        return np.asarray, (self.here,)  # a copy, and what another process is given, lies on the host


def _here(value: Any) -> Any:
    """What was given to a function of NumPy, with such arrays on the host."""
    if isinstance(value, ComplexOnDevice):
        return value.here
    if isinstance(value, tuple | list):
        return type(value)(_here(each) for each in value)
    if isinstance(value, dict):
        return {key: _here(each) for key, each in value.items()}
    return value
