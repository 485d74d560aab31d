"""The sum over facets, the innermost loop of the echoes: one typed batch in, sums at slow-time nodes out.

`sum_columns(batch)` is the interface, and there are two of it: the processor's compiled loops (`processor`), and Dr.Jit
kernels for a graphics processor (`device`). `kernel()` chooses: the environment's SEAMAP_RT_ECHOES is processor or
device. Random numbers by counting are in `gaussian`; both draw the same ones.

The same word has a whole turn, from its light to its gates, worked out on the device (`echoes.turn_on_device`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compute.placement import ECHOES as VARIABLE
from ...compute.placement import echoes_on_device as on_device
from .batch import Beam, ColumnBatch, Columns, Geometry, ListedFacets, RangeTable, Speckle

COLUMNS_ON_DEVICE = 256  # lanes for a whole device, in half a gigabyte of it

__all__ = [
    "COLUMNS_ON_DEVICE",
    "VARIABLE",
    "Beam",
    "ColumnBatch",
    "Columns",
    "Geometry",
    "Kernel",
    "ListedFacets",
    "RangeTable",
    "Speckle",
    "kernel",
    "on_device",
]


class Kernel(NamedTuple):
    """sum_columns: a batch to its sums (component, path, gate, node). columns: how many a batch of it best has."""

    sum_columns: Callable[[ColumnBatch], NDArray[np.float32]]
    columns: int


def kernel() -> Kernel:
    """The one that the environment names. Raises InputError for one that there is not."""
    if on_device():
        from .device import sum_columns

        return Kernel(sum_columns, COLUMNS_ON_DEVICE)
    from .processor import sum_columns

    return Kernel(sum_columns, 32)  # their sums stay near the cache
