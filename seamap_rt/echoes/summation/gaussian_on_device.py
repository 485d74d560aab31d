"""The random numbers of `gaussian`, on the device: the same keys and bits, and normals that are alike to 1e-6."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...compute.device import Device

_GOLDEN = 0x9E3779B97F4A7C15


def member(of: Device, key: Any, number: Any) -> Any:
    """The key of one member of a stream, UInt64; see `gaussian.key_of`. number: any whole number ≥ 0."""
    return _mixed(of, key + of.UInt64(_GOLDEN) * (of.UInt64(number) + of.UInt64(1)))


def normals(of: Device, bits: Any) -> tuple[Any, Any, Any]:
    """Magnitude, cosine and sine of the unit complex Gaussians of random bits; see `gaussian.normals`."""
    dr = of.dr
    uniform = (of.Float(bits >> 41) + 0.5) * 2.0**-23
    radius = dr.sqrt(dr.maximum(-dr.log(uniform), 0.0))
    sine, cosine = dr.sincos(of.Float(of.Int32(of.UInt32(bits))) * (2.0 * np.pi * 2.0**-32))
    return radius, cosine, sine


def _mixed(of: Device, state: Any) -> Any:
    """SplitMix64's mixing of a state."""
    state = (state ^ (state >> 30)) * of.UInt64(0xBF58476D1CE4E5B9)
    state = (state ^ (state >> 27)) * of.UInt64(0x94D049BB133111EB)
    return state ^ (state >> 31)
