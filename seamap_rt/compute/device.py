"""Arrays on the device that Dr.Jit runs on: a graphics processor (CUDA), or this processor (LLVM), where tests run.

`device()` has the types of its arrays, puts arrays there (`place`) and brings them back (`fetch`). Every byte that
crosses goes through one of the two and is counted in `moved`; what a kernel gives to the next stays there. Kernels take
turns (`ONE_AT_A_TIME`): a device has one queue for us.
"""

from __future__ import annotations

import importlib
import threading
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .backend import prepare

ONE_AT_A_TIME = threading.RLock()


@dataclass
class Moved:
    """What has crossed between host and device since `forget`."""

    up_bytes: int = 0
    up_count: int = 0
    down_bytes: int = 0
    down_count: int = 0

    def up(self, values: NDArray[Any]) -> NDArray[Any]:
        """Count values that are on their way to the device."""
        self.up_bytes += values.nbytes
        self.up_count += 1
        return values

    def down(self, values: NDArray[Any]) -> NDArray[Any]:
        """Count values that have come back."""
        self.down_bytes += values.nbytes
        self.down_count += 1
        return values

    def forget(self) -> None:
        """Begin anew."""
        self.up_bytes = self.up_count = self.down_bytes = self.down_count = 0


moved = Moved()


def copied(kind: Any, values: NDArray[Any]) -> Any:
    """Values (n,) of the host as an array of a type of Dr.Jit's, in memory of its own, counted.

    On LLVM it would share NumPy's memory otherwise: be changed with it, or freed while a kernel still runs, and be read
    beyond its end, for kernels take whole packets of lanes, which Dr.Jit's own memory has room for.
    """
    dr = importlib.import_module("drjit")
    if dr.backend_v(kind) != dr.JitBackend.LLVM or not values.size:
        return kind(moved.up(values))
    made = dr.empty(kind, values.size)
    np.array(made, copy=False)[...] = moved.up(values)
    return made


@dataclass(frozen=True)
class Device:
    """Dr.Jit, and its arrays on the backend."""

    dr: Any
    Float: Any
    Float64: Any
    Int32: Any
    UInt32: Any
    UInt64: Any
    Bool: Any

    def place(self, values: NDArray[Any]) -> Any:
        """A copy on the device, flat: of float32 or 64, int32, uint32 or 64, or truth values."""
        kinds = {"f4": self.Float, "f8": self.Float64, "i4": self.Int32, "u4": self.UInt32, "u8": self.UInt64}
        flat = np.ascontiguousarray(values).ravel()
        kind = self.Bool if flat.dtype == np.bool_ else kinds[flat.dtype.str[1:]]
        return copied(kind, flat)

    def place_single(self, values: NDArray[Any]) -> Any:
        """The same in float32."""
        return self.place(np.asarray(values, dtype=np.float32))

    def fetch(self, values: Any, shape: tuple[int, ...]) -> NDArray[Any]:
        """An array of the device, back here."""
        return moved.down(np.array(values)).reshape(shape)

    def number(self, value: Any) -> float:
        """The one number of an array of the device, back here."""
        return float(self.fetch(value, ())[()])


@cache
def device() -> Device:
    """The one there is. Raises NoBackend where Dr.Jit has nothing to run on."""
    arrays = importlib.import_module(f"drjit.{prepare().kind}")
    names = ("Float", "Float64", "Int", "UInt", "UInt64", "Bool")
    return Device(importlib.import_module("drjit"), *(getattr(arrays, name) for name in names))
