"""How far speckle and noise spread an interferometer's phase."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def cramer_rao_phase_std(coherence: ArrayLike, looks: ArrayLike) -> NDArray[np.float64]:
    """Least standard deviation [rad] of a phase of coherence γ over N independent looks: √((1 − γ²)/(2N))/γ.

    Rodríguez & Martin, IEE Proc. F 139(2), 147–159 (1992). The arguments broadcast; infinite at γ = 0. ValueError for
    coherences outside of 0 to 1 and fewer looks than 1.
    """
    gamma, count = np.asarray(coherence, dtype=np.float64), np.asarray(looks, dtype=np.float64)
    if not (np.all((gamma >= 0.0) & (gamma <= 1.0)) and np.all(count >= 1.0)):
        raise ValueError("coherence must lie within 0 to 1, and looks must be at least 1")
    with np.errstate(divide="ignore"):
        return np.sqrt((1.0 - gamma) * (1.0 + gamma) / (2.0 * count)) / gamma
