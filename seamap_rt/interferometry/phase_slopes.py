"""Slopes of a wrapped phase: products of neighbours know no ambiguity, as long as it turns by less than half a circle.

They are those of single heights' folded map without its folds, for windows that follow the waves; once a map is
resolved, planes through its heights give better ones.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_APART = 2  # gates: the pulse is about a gate long, and a reflector that two gates share keeps its phase in both


def phase_slopes(
    residual: NDArray[np.complex128], reach: tuple[int, int]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Phase slopes (look, gate), rad per gate and rad per look, of a cross product freed of mean sea level's phase.

    residual: complex (look, gate), NaN where unknown; its power counts by its root, or single strong cells would speak
    for all about them. reach: looks and gates to either side that are averaged. Both slopes are shrunk by how well the
    products agree: by |Σp| / Σ|p|, 0 where there are none. Slopes beyond ± π/2 per gate, ± π per look are folded.
    """
    power = np.abs(residual)
    with np.errstate(invalid="ignore", divide="ignore"):
        even = np.where(np.isfinite(power) & (power > 0.0), residual / np.sqrt(power), 0.0)
    along, across = np.zeros_like(even), np.zeros_like(even)
    half = _APART // 2
    along[:, half : even.shape[1] - half] = even[:, _APART:] * even[:, :-_APART].conj()
    steps = even[1:] * even[:-1].conj()
    across[1:] += steps
    across[:-1] += steps
    return _mean_angle(along, reach) / _APART, _mean_angle(across, reach)


def _mean_angle(products: NDArray[np.complex128], reach: tuple[int, int]) -> NDArray[np.float64]:
    total, most = _window_sum(products, reach), _window_sum(np.abs(products), reach)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.angle(total) * np.nan_to_num(np.abs(total) / most, posinf=0.0)


def _window_sum(field: NDArray, reach: tuple[int, int]) -> NDArray:
    """Sums over as many cells to either side; nothing lies beyond the map."""
    for axis, n in enumerate(reach):
        padded = np.pad(field, [(n, n) if each == axis else (0, 0) for each in (0, 1)])
        field = np.lib.stride_tricks.sliding_window_view(padded, 2 * n + 1, axis=axis).sum(axis=-1)
    return field
