"""What was asked of a sea last, for who asks for the same again: radars of other heights over the same sea and grid."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Hashable

import numpy as np
from numpy.typing import NDArray


class Memory:
    """Values by the points that they are of; the oldest go when they are more than `most_bytes` together."""

    def __init__(self, most_bytes: float) -> None:
        self._most = most_bytes
        self._values: OrderedDict[Hashable, NDArray[np.float64]] = OrderedDict()

    def recall(
        self, what: Hashable, points: tuple[NDArray[np.float64], ...], make: Callable[[], NDArray[np.float64]]
    ) -> NDArray[np.float64]:
        """The values of `what` at the points, made now unless they are known; the caller may write into them."""
        digest = hashlib.blake2b(digest_size=16)
        for each in points:
            digest.update(np.ascontiguousarray(each).data)
        key = what, points[0].size, digest.digest()
        values = self._values.pop(key, None)
        if values is None:
            values = make()
        self._values[key] = values
        while sum(each.nbytes for each in self._values.values()) > self._most and self._values:
            self._values.popitem(last=False)
        return values.copy()
