"""Numpy's values as plain Python ones, and as JSON that any reader takes."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np


def plain(value: Any) -> Any:
    """Numpy's scalars and arrays, tuples and mappings as Python's own numbers, lists and dictionaries, at any depth;
    all else as it is."""
    if isinstance(value, np.generic | np.ndarray):
        return plain(value.tolist())
    if isinstance(value, Mapping):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    return value


def plain_attribute(value: Any) -> Any:
    """A value of an attribute as it was meant: HDF5 and JSON may make an array or list of one entry of it, or bytes."""
    while isinstance(value, np.ndarray | list | tuple) and np.size(value) == 1 and np.ndim(value) > 0:
        value = value[0]
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist() if value.dtype.kind != "V" else value
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def to_json(value: Any) -> str:
    """Strict JSON of plain or numpy values; what is not finite becomes null."""
    return json.dumps(_finite(plain(value)), indent=1, allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _finite(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
