"""Maps against truth: errors by range, and the headline figures for 50 to 200 m."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .dataset import QUALITY_FLAGS, group_of
from .errors import InputError

if TYPE_CHECKING:
    import xarray as xr

BIN_M = 25.0
HEADLINE_M = (50.0, 200.0)
HALF_VISIBLE = 0.5  # accuracy is judged on cells of which more than this share is lit


_MEANINGS = {
    "height_rmse_m": ("m", "root-mean-square error of height"),
    "height_robust_m": ("m", "robust error of height, 1.4826 MAD about the median"),
    "height_bias_m": ("m", "mean error of height"),
    "height_bias_visible_m": ("m", "mean difference of height to the lit part of the cells"),
    "slope_rmse": ("1", "root-mean-square error of the slope in range"),
    "height_correlation": ("1", "correlation of heights with the true ones"),
    "hs_true_m": ("m", "four standard deviations of the true heights"),
    "hs_retrieved_m": ("m", "four standard deviations of the heights without a flag"),
    "visible_fraction": ("1", "mean share of the cells that both antennas see"),
    "illumination": ("1", "mean illumination of the cells"),
    "answered": ("1", "share of the visible cells that count"),
    "cells": ("1", "cells that count"),
}


def compare(maps: xr.DataTree, truth: xr.DataTree) -> xr.Dataset:
    """Maps against the truth: errors by range, dims (range,), and for all of 50 to 200 m without dims, as `overall_…`.

        compared = compare(maps, simulation.truth)
        float(compared["overall_height_rmse_m"]), compared["height_rmse_m"].sel(range=100.0, method="nearest")

    maps, truth: trees with a group `polar` (turn, azimuth, range) of the same cells. `range` [m] is the middle of each
    bin of 25 m. Cells count if they are more than half visible and have a retrieved height that is not flagged as
    ambiguous; `cells` is their number, `answered` their share of the visible cells. What is not defined is NaN. The
    attribute `overall_range_m` holds what of 50 to 200 m the maps hold; it is missing where that is nothing.
    Raises InputError for what are no trees or have different cells, SchemaError for trees that do not keep the schema.
    """
    import xarray as xr

    by_range = error_figures(maps, truth)
    overall = by_range.pop("overall")
    middles, band = by_range.pop("range_m"), overall.pop("range_m")
    result = xr.Dataset(
        {name: ("range", _figure_array(values), _attributes(name)) for name, values in by_range.items()}
        | {f"overall_{name}": ((), _figure_array(value), _attributes(name)) for name, value in overall.items()},
        {"range": ("range", middles, {"units": "m", "long_name": "middle of the range bin"})},
        {"title": "maps compared with the truth"},
    )
    return result if band is None else result.assign_attrs(overall_range_m=list(band))


def _attributes(name: str) -> dict[str, str]:
    units, meaning = _MEANINGS[name]
    return {"units": units, "long_name": meaning}


def _figure_array(values: Any) -> NDArray:
    """Figures as an array: counts stay whole, None is NaN."""
    array = np.asarray(values)
    return array if array.dtype.kind in "iu" else np.asarray(values, dtype=np.float64)


def error_figures(maps: xr.DataTree, truth: xr.DataTree) -> dict[str, Any]:
    """The part of `metrics.json` that compares maps with the truth: lists per range bin, and `overall`.

    maps, truth: trees with a group `polar` (turn, azimuth, range) of the same cells; ranges in m, heights in m. Cells
    count if they are more than half visible and have a retrieved height that is not flagged as ambiguous; `cells` is
    their number, `answered` their share of the visible cells. What is not defined is None. SchemaError for trees that
    do not keep the schema, InputError where maps and truth have different cells.
    """
    retrieved, true = group_of(maps, "maps/polar"), group_of(truth, "truth/polar")
    if retrieved["height"].shape != true["height"].shape:
        raise InputError(
            f"maps {retrieved['height'].shape} and truth {true['height'].shape} have different cells; "
            "retrieve with the cell size that the truth was made with"
        )
    ranges = retrieved["range"].values
    visible = true["visible_fraction"].values > HALF_VISIBLE
    height = retrieved["height"].values.astype(np.float64)
    true_height = true["height"].values.astype(np.float64)
    error = height - true_height
    counted = counted_cells(retrieved, true)
    # Without diffraction a point is either lit or not: the visible fraction is the illumination.
    illumination = true.get("illumination", true["visible_fraction"]).values
    error_to_visible = height - true["height_visible"].values
    slope_error = retrieved["slope_range"].values.astype(np.float64) - true["slope_range"].values
    # Hs from what a map holds without its truth: cells without a flag, lit or not, where the sea is known at all.
    unflagged = (retrieved["quality"].values == 0) & np.isfinite(true_height)
    rows = []
    for middle_m, inside in _range_bins(ranges):
        cells = counted[..., inside]
        rows.append(
            {
                "range_m": middle_m,
                **_errors(error[..., inside][cells]),
                "height_bias_visible_m": _mean(error_to_visible[..., inside][cells]),
                "slope_rmse": _rms(slope_error[..., inside][cells]),
                "visible_fraction": _mean(true["visible_fraction"].values[..., inside]),
                "illumination": _mean(illumination[..., inside]),
                "answered": _ratio(cells.sum(), visible[..., inside].sum()),
                "cells": int(cells.sum()),
            }
        )
    headline = headline_gates(ranges)
    cells = counted[..., headline]
    overall = {
        "range_m": headline_band(ranges),
        **_errors(error[..., headline][cells]),
        "height_bias_visible_m": _mean(error_to_visible[..., headline][cells]),
        "height_correlation": _correlation(height[..., headline][cells], true_height[..., headline][cells]),
        "slope_rmse": _rms(slope_error[..., headline][cells]),
        "hs_true_m": _hs(true_height[..., headline]),
        "hs_retrieved_m": _hs(height[..., headline][unflagged[..., headline]]),
        "visible_fraction": _mean(true["visible_fraction"].values[..., headline]),
        "illumination": _mean(illumination[..., headline]),
        "cells": int(cells.sum()),
    }
    by_range = {key: [row[key] for row in rows] for key in rows[0]}
    return {**by_range, "overall": overall}


def headline_gates(ranges: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which gates (range,) lie at 50 to 200 m."""
    return (ranges >= HEADLINE_M[0]) & (ranges <= HEADLINE_M[1])


def headline_band(ranges: NDArray[np.float64]) -> tuple[float, float] | None:
    """The part [m] of 50 to 200 m that the maps hold; None if they hold nothing of it."""
    if not headline_gates(ranges).any():
        return None
    return max(HEADLINE_M[0], float(ranges[0])), min(HEADLINE_M[1], float(ranges[-1]))


def counted_cells(retrieved: xr.Dataset, true: xr.Dataset) -> NDArray[np.bool_]:
    """Cells that are more than half visible and have a height, not flagged as ambiguous, of polar maps and truth."""
    error = retrieved["height"].values - true["height"].values
    return counts(error, retrieved["quality"].values, true["visible_fraction"].values)


def counts(error: NDArray[Any], quality: NDArray[Any], visible_fraction: NDArray[Any]) -> NDArray[np.bool_]:
    """The same of arrays of one shape: errors of height [m], flags, and visible fractions."""
    ambiguous = (quality.astype(np.int64) & QUALITY_FLAGS["ambiguous"]) != 0
    return (visible_fraction > HALF_VISIBLE) & np.isfinite(error) & ~ambiguous


def _range_bins(ranges: NDArray[np.float64]) -> Iterator[tuple[float, NDArray[np.bool_]]]:
    """The middle [m] of each bin of 25 m that holds gates, and which gates (range,) those are."""
    first, last = np.floor(ranges[0] / BIN_M), np.floor(ranges[-1] / BIN_M)
    edges = BIN_M * np.arange(first, last + 2.0)  # the last gate, even one on an edge, lies below the last edge
    number = np.digitize(ranges, edges) - 1
    for index in range(edges.size - 1):
        inside = number == index
        if inside.any():
            yield 0.5 * (edges[index] + edges[index + 1]), inside


def _finite(values: NDArray) -> NDArray[np.float64]:
    values = np.asarray(values, dtype=np.float64)
    return values[np.isfinite(values)]


def _mean(values: NDArray) -> float | None:
    values = _finite(values)
    return float(values.mean()) if values.size else None


def _rms(values: NDArray) -> float | None:
    values = _finite(values)
    return float(np.sqrt(np.mean(values**2))) if values.size else None


def _hs(values: NDArray) -> float | None:
    values = _finite(values)
    return float(4.0 * values.std()) if values.size > 1 else None


def _ratio(part: float, whole: float) -> float | None:
    return float(part / whole) if whole else None


def _errors(error: NDArray) -> dict[str, float | None]:
    """RMSE, robust spread (1.4826 MAD about the median) and bias."""
    error = _finite(error)
    if not error.size:
        return {"height_rmse_m": None, "height_robust_m": None, "height_bias_m": None}
    return {
        "height_rmse_m": float(np.sqrt(np.mean(error**2))),
        "height_robust_m": float(1.4826 * np.median(np.abs(error - np.median(error)))),
        "height_bias_m": float(error.mean()),
    }


def _correlation(a: NDArray, b: NDArray) -> float | None:
    if a.size < 3 or a.std() == 0.0 or b.std() == 0.0:
        return None
    return float(np.corrcoef(a, b)[0, 1])
