"""How much of the sea a radar measures, and how far: a score of each cell, and two radii that it comes to.

A cell that is more than half visible and has a height without ambiguity scores 1 − min(e², σ²)/σ² by its error e, of a
sea whose standard deviation is σ; any other scores 0, as does a height that is no better than the mean level. q(R), the
mean score of all cells of a ring, falls without a threshold, so that it hardly scatters from sea to sea. Beside it
stands the share of heights that are wrong by more than 2σ, which the score does not tell from those wrong by σ.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy
from numpy.typing import NDArray

from .metrics import counted_cells, headline_gates

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

LEVEL = 0.28  # of q: where the reach ends
FULLY_MEASURED = (
    "fully measured radius: of a disc of perfect heights that holds as much as all cells' scores; reach: where their "
    f"mean falls below {LEVEL:g}"
)
GROSS = 2.0  # σ, that is half the significant wave height
_BESIDE, _FEWEST = 0.2, 5  # of the reach, and rings: through which a line is drawn


@dataclass(frozen=True)
class CoverageProfile:
    """range_m (ring,), of even steps; score (ring,), the sum over the cells of a ring; cells (ring,), all of them; and
    of those with a height that counts: sure (ring,), how many, and gross (ring,), how many of these are wrong by more
    than GROSS. Those of several turns add."""

    range_m: Array
    score: Array
    cells: Array
    sure: Array
    gross: Array

    @classmethod
    def of(cls, polar: xr.Dataset, truth: xr.Dataset, sigma: float) -> CoverageProfile:
        """polar, truth: of the same cells (turn, azimuth, range); those without truth are not judged, nor rings without
        any. sigma: m, of the sea: without waves there is no score, and sums of it are NaN."""
        known = np.isfinite(truth["height"].values)
        judged = known.any(axis=tuple(range(known.ndim - 1)))
        if judged.any() and not judged.all():
            polar, truth, known = polar.isel(range=judged), truth.isel(range=judged), known[..., judged]
        error = polar["height"].values.astype(np.float64) - truth["height"].values
        counts = counted_cells(polar, truth)
        share = np.where(counts, (error / sigma) ** 2 if sigma > 0.0 else np.nan, 1.0)
        around = tuple(range(share.ndim - 1))
        return cls(
            polar["range"].values.astype(np.float64),
            np.sum(1.0 - np.minimum(share, 1.0), axis=around) if sigma > 0.0 else np.full(share.shape[-1], np.nan),
            known.sum(axis=around).astype(np.float64),
            counts.sum(axis=around).astype(np.float64),
            np.sum(share > GROSS**2, axis=around).astype(np.float64),
        )

    def __add__(self, other: CoverageProfile) -> CoverageProfile:
        sums = (getattr(self, name) + getattr(other, name) for name in ("score", "cells", "sure", "gross"))
        return CoverageProfile(self.range_m, *sums)

    @property
    def quality(self) -> Array:
        """q (ring,)."""
        return self.score / self.cells

    @property
    def gross_share(self) -> float:
        """Share of gross errors among all heights that count; NaN where there are none."""
        return float(self.gross.sum() / self.sure.sum()) if self.sure.any() else np.nan

    @property
    def missed_share(self) -> float:
        """Share of the cells at 50 to 200 m that have no height that counts; NaN where there are no cells."""
        inside = headline_gates(self.range_m)
        return float(1.0 - self.sure[inside].sum() / self.cells[inside].sum()) if inside.any() else np.nan

    @property
    def fully_measured_radius(self) -> float:
        """m: of a disc that holds as much, if every cell of it scores 1: √(2 ∫ q R dR). By slant ranges, between which
        lie rings of the same area as between their ground ranges."""
        step = float(self.range_m[1] - self.range_m[0]) if self.range_m.size > 1 else 0.0
        return float(np.sqrt(2.0 * np.sum(self.quality * self.range_m) * step))

    @property
    def reach(self) -> tuple[float, bool]:
        """m: where q passes LEVEL, 0 if it lies below from the first ring on; and whether it does not pass within the
        rings, and the reach is their end.

        The nearest q that only falls says about where. A line through the rings around says it by what all of them
        hold: over seas it scatters by a fifth as much.
        """
        if not np.isfinite(self.quality).all():
            return np.nan, False
        weights = self.cells * self.range_m
        falling = scipy.optimize.isotonic_regression(self.quality, weights=weights, increasing=False).x
        above = int(np.count_nonzero(falling >= LEVEL))
        if not above:
            return 0.0, False
        if above == falling.size:
            return float(self.range_m[-1]), True
        about = float(self.range_m[above - 1])
        beside = np.abs(self.range_m - about) <= _BESIDE * about
        if np.count_nonzero(beside) < _FEWEST:
            return about, False
        at, q = self.range_m[beside] - about, self.quality[beside]
        slope, level = np.polyfit(at, q, 1)
        if not slope < 0.0:
            return about, False
        return float(about + np.clip((LEVEL - level) / slope, at[0], at[-1])), False

    @property
    def figures(self) -> dict[str, float | None]:
        """What metrics hold of it; None of a sea without waves, and where a share is of nothing."""
        reach, to_the_end = self.reach
        values = {
            "fully_measured_radius_m": self.fully_measured_radius,
            "reach_m": reach,
            "reach_to_the_end": float(to_the_end),
            "gross_share": self.gross_share,
            "missed_share": self.missed_share,
        }
        waves = np.isfinite(values["fully_measured_radius_m"])
        return {name: value if waves and np.isfinite(value) else None for name, value in values.items()}
