"""A library of NumPy's interface that works in the device's memory, for what Dr.Jit has not: FFTs.

It is CuPy on a graphics processor, with cuFFT, and NumPy on LLVM. The memory is Dr.Jit's own, which it lends by DLPack
(`writing`) and the library writes into. An array of CuPy's that is given to Dr.Jit would not do: each of the two reuses
memory in the order of its own stream, so that CuPy could write into what a kernel of Dr.Jit's is still to read; and on
LLVM kernels read beyond an array's end, for which Dr.Jit's memory alone has room (`device.copied`).
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import one_line
from .backend import prepare
from .device import ONE_AT_A_TIME, device, moved

REMEDY = "`pip install 'seamap_rt[cuda]'` brings CuPy and its libraries"


@dataclass(frozen=True)
class ArrayLibrary:
    """xp: the library. lent: an array of Dr.Jit's as one of its own, in the same memory. wait: until all is done that
    it was asked for."""

    name: str
    xp: Any
    lent: Callable[[Any], Any]
    wait: Callable[[], None]

    def place(self, values: NDArray[Any]) -> Any:
        """Values of the host as an array of the library's on the device, counted."""
        return self.xp.asarray(moved.up(values))

    @contextmanager
    def writing(self, there: Iterable[Any]) -> Iterator[list[Any]]:
        """Evaluated arrays of Dr.Jit's (n,), lent to be written into.

        The library and Dr.Jit ask the device by streams of their own, neither of which waits for the other. So Dr.Jit
        ends first what it was asked for: kernels may still read the memory that new arrays were given. And the library
        ends before Dr.Jit goes on, also where it fails: the arrays may be let go then.
        """
        with ONE_AT_A_TIME:
            device().dr.sync_thread()
            try:
                yield [self.lent(each) for each in there]
            finally:
                self.wait()


@cache
def array_library() -> ArrayLibrary | str:
    """The one for the device that there is, tried; or why there is none, and what mends it, in one line."""
    try:
        library = cupy_library() if prepare().kind == "cuda" else numpy_library()
        fault = _fault_of(library)
    except Exception as error:  # not installed, or of another CUDA, or one of its own libraries is missing
        return f"{one_line(str(error)) or type(error).__name__}; {REMEDY}"
    return f"{library.name} {fault}" if fault else library


def cupy_library() -> ArrayLibrary:
    """CuPy. Raises ImportError where it is not installed."""
    xp = importlib.import_module("cupy")
    return ArrayLibrary("CuPy", xp, xp.from_dlpack, lambda: xp.cuda.get_current_stream().synchronize())


def numpy_library() -> ArrayLibrary:
    """NumPy. What it gets by `from_dlpack` it does not write into; so it asks for the same memory by its own protocol,
    and is never late."""
    return ArrayLibrary("NumPy", np, lambda there: np.array(there, copy=False), lambda: None)


def _fault_of(library: ArrayLibrary) -> str:
    """What it does wrong, in words, with a little of what it is for: FFTs, functions, and Dr.Jit's memory."""
    of, xp = device(), library.xp
    there = of.place_single(np.full(4, np.nan))
    with library.writing([there]) as (lent,):
        lent[...] = xp.fft.irfft(xp.exp(xp.zeros(3, dtype=xp.complex64)), n=4, norm="forward")
    found = of.fetch(there, (4,))
    return "" if np.allclose(found, [4.0, 0.0, 0.0, 0.0], atol=1e-6) else f"makes {found} of an impulse"
