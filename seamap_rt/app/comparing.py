"""Two runs against each other: their figures, and the maps of the second laid on the cells of the first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..report import style
from .maps_panel import Panel
from .pictures import Raster, Scale, ground_raster
from .views import Source

Array = NDArray[np.floating]


class Figure(NamedTuple):
    """One figure of both runs; None where a run has none. better: 1 where more is, −1 where less is, 0 of neither."""

    words: str
    unit: str
    digits: int
    better: int
    first: float | None
    second: float | None

    @property
    def verdict(self) -> int:
        """1 where the second is better, −1 where it is worse, 0 where nothing can be said."""
        if self.first is None or self.second is None or not self.better:
            return 0
        change = self.better * (self.second - self.first)
        return 0 if abs(change) < 0.5 * 10.0**-self.digits else (1 if change > 0.0 else -1)


_FIGURES = (  # where it stands in metrics.json, words, unit, digits, which way is better
    ("measured.reach_m", "Measures waves out to", "m", 0, 1),
    ("measured.fully_measured_radius_m", "As a perfect map of radius", "m", 0, 1),
    ("overall.height_rmse_m", "Height error, rms", "m", 3, -1),
    ("overall.height_robust_m", "Height error, robust", "m", 3, -1),
    ("overall.height_bias_m", "Height bias", "m", 3, 0),
    ("overall.height_correlation", "Correlation with the sea", "", 3, 1),
    ("measured.missed_share", "Cells missed", "", 2, -1),
    ("overall.hs_true_m", "True wave height", "m", 2, 0),
    ("overall.hs_retrieved_m", "Wave height by the maps' spread", "m", 2, 0),
    ("facets", "Facets a turn", "", 0, 0),
    ("run_s", "Wall time", "s", 1, 0),
)


def figures_of(first: Mapping[str, Any], second: Mapping[str, Any]) -> list[Figure]:
    """What metrics.json says of both runs."""
    made = [
        Figure(words, unit, digits, better, _number(first, key), _number(second, key))
        for key, words, unit, digits, better in _FIGURES
    ]
    return [each for each in made if each.first is not None or each.second is not None]


def _number(metrics: Any, key: str) -> float | None:
    for step in key.split("."):
        metrics = metrics.get(step) if isinstance(metrics, Mapping) else None
    return float(metrics) if isinstance(metrics, int | float) and not isinstance(metrics, bool) else None


def side_by_side(
    first: Source, second: Source, turn: int, names: tuple[str, str]
) -> tuple[tuple[Panel, ...], Raster, tuple[Array, ...]]:
    """Retrieved heights of both on one scale and, where the truth is known, both errors on another.

    turn: by its place, of both. OSError, IndexError where a run has no such turn.
    """
    fields = [_fields(each, turn) for each in (first, second)]
    x, y = first.layout.x, first.layout.y
    onto = _nearest(second.layout.x, x), _nearest(second.layout.y, y)
    moved = {name: _laid(values, *onto) for name, values in fields[1].items()}
    both = (fields[0], moved)
    seen = np.any([np.isfinite(each["seen"]) for each in both], axis=0)
    raster = ground_raster(x, y, seen)
    height = _scale([each["height"] for each in both], "Height (m)")
    panels = [Panel(f"{name}: retrieved height", height) for name in names]
    values = [each["height"] for each in both]
    if all("error" in each for each in both):
        error = _scale([each["error"] for each in both], "Error (m)")
        panels += [Panel(f"{name}: error", error, 3) for name in names]
        values += [each["error"] for each in both]
    return tuple(panels), raster, tuple(raster.of(each) for each in values)


def _fields(source: Source, turn: int) -> dict[str, Array]:
    height = source.results.field("maps/ground/height", turn)
    found = {"height": height, "seen": source.results.field("maps/ground/time", turn)}
    if source.results.has_truth:
        found["error"] = height - source.results.field("truth/ground/height", turn)
    return found


def _nearest(centres: Array, wanted: Array) -> NDArray[np.intp]:
    """Of each wanted place the nearest centre; −1 where it is farther away than a cell."""
    step = float(abs(centres[1] - centres[0])) if centres.size > 1 else 1.0
    place = np.rint((wanted - centres[0]) / (centres[1] - centres[0] if centres.size > 1 else 1.0)).astype(np.intp)
    inside = np.clip(place, 0, centres.size - 1)
    return np.where(np.abs(centres[inside] - wanted) <= step, inside, -1)


def _laid(values: Array, columns: NDArray[np.intp], rows: NDArray[np.intp]) -> Array:
    found = values[np.ix_(np.maximum(rows, 0), np.maximum(columns, 0))]
    return np.where((rows >= 0)[:, None] & (columns >= 0)[None, :], found, np.nan)


def _scale(fields: list[Array], words: str) -> Scale:
    finite = np.abs(np.concatenate([each[np.isfinite(each)] for each in fields]))
    limit = float(f"{max(np.quantile(finite, 0.99), 0.01):.2g}") if finite.size else 0.1
    return Scale(-limit, limit, style.HEIGHT_COLOURS, words)
