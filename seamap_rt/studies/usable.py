"""Up to which range a map can be used: a stated criterion on its errors and its gaps, bin by bin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..metrics import BIN_M


class Window(NamedTuple):
    """From where to where [m] a map is usable; NaN where it is nowhere, or where there are no waves to map."""

    nearest: float
    furthest: float


@dataclass(frozen=True)
class Criterion:
    """When a range bin is usable: its heights are accurate enough for the waves, and its cells dense enough.

    error_over_height: rms height error over true significant wave height Hs, at most. The sea's standard deviation is
    Hs/4, so an error of 0.1 Hs is 0.4 of it, and a map with such errors correlates with the sea by 1/√(1 + 0.4²) =
    0.93: a little above the 0.90 that phase-resolved wave reconstructions from radar report as good.

    known_share: cells that are more than half visible and answered, over all cells, at least. A third of cells 3 m long
    leaves one in 9 m along the look. Waves of 18 m and more then have two and more known cells a wavelength on the
    average, which is the least density from which they can be rebuilt (Landau 1967); a peak of 47 m has five.
    """

    error_over_height: float = 0.1
    known_share: float = 1.0 / 3.0

    def __str__(self) -> str:
        return (
            f"the longest unbroken run of whole {BIN_M:g} m bins in which the rms height error is at most "
            f"{self.error_over_height:g} of the true Hs, and at least {self.known_share:.0%} of all cells are both "
            "more than half visible and answered"
        )

    def window(
        self, range_m: Sequence[float], rmse_m: Sequence[float], known_share: Sequence[float], height_m: float
    ) -> Window:
        """Edges of the longest run of usable bins, the nearest of several. What is NaN is not usable.

        It need not begin at the first bin, because a tall mast looks over what is near.
        range_m (bin,): centres [m], rising; rmse_m, known_share (bin,); height_m: significant wave height [m].
        """
        if not height_m > 0.0:
            return Window(np.nan, np.nan)
        first, best = 0, (0, 0)  # bins of a run: its first, and the one after its last
        for number, (rmse, share) in enumerate(zip(rmse_m, known_share, strict=True)):
            if not (rmse <= self.error_over_height * height_m and share >= self.known_share):
                first = number + 1
                continue
            if number > first and range_m[number] - range_m[number - 1] > 1.5 * BIN_M:
                first = number
            if number + 1 - first > best[1] - best[0]:
                best = (first, number + 1)
        if best == (0, 0):
            return Window(np.nan, 0.0)
        return Window(range_m[best[0]] - 0.5 * BIN_M, range_m[best[1] - 1] + 0.5 * BIN_M)
