"""What two studies of neglected power share: ranges, and the change of heights that it makes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seamap_rt.settings import RadarSettings

RANGES_M = ((50.0, 100.0), (100.0, 200.0), (200.0, 400.0))


def change_by_range(radar: RadarSettings, change: NDArray[np.float64], digits: int) -> str:
    """Cells of a table: rms and 1.4826 MAD [mm] of a change (look, gate) [m] of heights, by range."""
    ranges = radar.range_m[0] + radar.range_sampling_m * np.arange(change.shape[1])
    cells = []
    for near, far in RANGES_M:
        some = change[:, (ranges >= near) & (ranges < far)]
        some = some[np.isfinite(some)]
        rms, robust = 1e3 * np.sqrt(np.mean(some**2)), 1482.6 * np.median(np.abs(some))
        cells.append(f"{rms:.{digits}f}, {robust:.{digits}f}")
    return " | ".join(cells)
