"""Visible share of a turn's water by ground range: to light, and to a radar in VV and in HH."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .conventions import POLARIZATIONS, from_db
from .mesh import PolarGrid
from .metrics import headline_gates
from .physics.shadowing import LEVELS_DB, SEEN_DB, half_range
from .radar.scan import sector_width
from .settings import RadarSettings
from .tracing import Illumination

Array = NDArray[np.float64]

LIGHT = "light"
_BIN_M, _LEAST_RUNGS = 5.0, 4  # of ground range, and of the mesh in it


class Curve(NamedTuple):
    """Visible share (bin,) to `sees`, light or a polarization; level_db: of two-way power, 0 of light."""

    sees: str
    level_db: float
    share: Array


@dataclass(frozen=True)
class VisibleShare:
    """range_m (bin,): middles of bins of ground range [m]; light (bin,): share of horizontal area that both antennas
    see; radar (polarization, level, bin): share whose two-way power reaches `LEVELS_DB` of the same water's when lit.

    Of the looks of one turn's sector, objects' shadows and those of waves beyond the mesh included.
    """

    range_m: Array
    light: Array
    radar: Array

    @classmethod
    def of(
        cls,
        parts: Iterable[tuple[Illumination, Sequence[NDArray[np.float64]]]],
        grid: PolarGrid,
        radar: RadarSettings,
    ) -> VisibleShare:
        """parts: neighbouring columns of one turn's light, with their powers as `water_powers` gives them; grid: of the
        whole turn."""
        inside = (grid.column_sweep > 0.0) & (grid.column_sweep < sector_width(radar))
        inside |= not inside.any()
        sums, columns, facets, first = 0.0, 0, None, 0
        for facets, powers in parts:
            chosen = inside[first : first + facets.grid.columns]
            first += facets.grid.columns
            seen = [power >= from_db(level) for power in powers for level in LEVELS_DB]
            whole = 1.0 if facets.in_sight is None else facets.in_sight
            shown = np.array([(each * whole)[chosen].sum(axis=0) for each in (facets.visible_to_both, *seen)])
            sums, columns = sums + shown, columns + int(chosen.sum())
        assert facets is not None
        (near, far), distance, rungs = radar.range_m, facets.distance, np.diff(grid.ground_range).max()
        width = max(_BIN_M, _LEAST_RUNGS * float(rungs))
        number = np.floor(distance / width).astype(int)
        area = facets.horizontal_area * ((distance >= near) & (distance <= far))
        bins = np.flatnonzero(np.bincount(number, area))
        share = np.array([np.bincount(number, each * area)[bins] for each in np.asarray(sums)])
        share /= columns * np.bincount(number, area)[bins]
        by_level = share[1:].reshape(len(POLARIZATIONS), len(LEVELS_DB), bins.size)
        middle: Array = np.asarray(width * (bins + 0.5), dtype=np.float64)
        return cls(middle, share[0], by_level)

    @property
    def curves(self) -> Iterator[Curve]:
        """Light's, then each polarization's by level."""
        yield Curve(LIGHT, 0.0, self.light)
        for name, levels in zip(POLARIZATIONS, self.radar, strict=True):
            for level, share in zip(LEVELS_DB, levels, strict=True):
                yield Curve(name, level, share)

    def half_m(self, share: Array) -> float | None:
        """Ground range [m] to which half is visible; None where there is none."""
        half = float(half_range(self.range_m, share)) if self.range_m.size > 1 else np.nan
        return half if np.isfinite(half) else None

    def mean(self, share: Array) -> float | None:
        """Share at 50 to 200 m, each range alike, as of a map's cells; None without any."""
        inside = headline_gates(self.range_m)
        return float(share[inside].mean()) if inside.any() else None

    @property
    def facts(self) -> dict[str, Any]:
        """`visible` of metrics.json; `seen_db` is the level from which on water is visible to a radar."""
        curves = [
            {
                "sees": each.sees,
                "level_db": each.level_db,
                "half_visible_m": self.half_m(each.share),
                "visible_fraction": self.mean(each.share),
                "by_range": each.share.tolist(),
            }
            for each in self.curves
        ]
        return {"seen_db": SEEN_DB, "range_m": self.range_m.tolist(), "curves": curves}

    @property
    def figures(self) -> dict[str, float | None]:
        """Half ranges [m] and shares at 50 to 200 m, of light and of each polarization at `SEEN_DB`."""
        found: dict[str, float | None] = {"half_visible_m": self.half_m(self.light)}
        for each in self.curves:
            if each.level_db == SEEN_DB:
                found[f"half_visible_{each.sees.lower()}_m"] = self.half_m(each.share)
                found[f"visible_{each.sees.lower()}_fraction"] = self.mean(each.share)
        return found
