"""What the sea of a run was, in a table: which waves the mesh carries, which the scattering took over, and folds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from . import reduce

Row = tuple[str, str]
NO_WAVES_DB = -60.0  # a spectrum that begins so far below the resolved waves' has none there
_LEAST_COVERED = 0.9  # of the ground cells of the first turn


def sea_rows(metrics: Mapping[str, Any]) -> list[Row]:
    """Label and value of each fact that the metrics hold of the sea; none if they hold none."""
    sea = _group(metrics, "sea")
    if not sea:
        return []
    rows = [
        ("Resolved", f"waves longer than {_number(sea, 'resolution_m', 3, 2.0)} m"),
        ("Share of the variance resolved", _share(sea, "variance_share")),
        ("Share of the same spectra's mean square slope resolved", _share(sea, "mean_square_slope_share")),
        ("Significant height, resolved (4σ)", f"{_number(sea, 'elevation_std', 3, 4.0)} m"),
        ("Mean square slope, resolved", _number(sea, "mean_square_slope", 3)),
        ("Rms slope towards east, north", f"{_number(sea, 'slope_std_east', 3)}, {_number(sea, 'slope_std_north', 3)}"),
        ("Significant height over the peak's length", _number(sea, "significant_steepness", 2)),
    ]
    short = _group(metrics, "short_waves")
    if short:
        rows += [
            ("Left to the scattering: waves shorter than", f"{_length(short)} m"),
            ("Their mean square slope", _number(short, "mean_square_slope", 3)),
            ("Share of the whole mean square slope on the mesh", _share(short, "resolved_slope_share")),
            ("Step of the spectrum where they take over", _step(short)),
        ]
    choppy = _group(sea, "choppy")
    if choppy:
        rows += [
            ("Choppy: mean level put back", f"{_number(choppy, 'set_down', 2, 100.0)} cm"),
            ("Choppy: waves enlarged to keep the height", f"× {_number(choppy, 'amplitude_scale', 4)}"),
            ("Choppy: skewness of the elevation", _number(choppy, "skewness", 2)),
            ("Choppy: share of the water that folds over at time 0", _share(choppy, "folded_share", 3)),
            ("Choppy: most of a turn's mesh under a fold", _share(metrics, "folded_share", 3)),
        ]
    rows.append(("Skewness of a narrow-banded second-order sea (3kσ)", _number(sea, "skewness_stokes", 2)))
    return rows


def warnings(metrics: Mapping[str, Any]) -> list[str]:
    """What a reader must know before any figure, a line each."""
    told = (fold_warning(metrics), ground_warning(metrics), objects_warning(metrics))
    return [*(each for each in told if each), *(metrics.get("vessel_notes") or ())]


def fold_warning(metrics: Mapping[str, Any]) -> str | None:
    """One line if choppy waves folded over anywhere, else None."""
    water = reduce.number(_group(_group(metrics, "sea"), "choppy").get("folded_share"))
    mesh = reduce.number(metrics.get("folded_share"))
    worst = np.nanmax([water, mesh, 0.0])
    if worst <= 0.0:
        return None
    return (
        f"sea.model = 'choppy': crests fold over on {water:.2g} of the water and {mesh:.2g} of the mesh; the highest "
        "sheet is meshed there"
    )


def ground_warning(metrics: Mapping[str, Any]) -> str | None:
    """One line if the boat ran off the ground maps, else None."""
    covered = reduce.number(metrics.get("ground_covered"))
    if not covered < _LEAST_COVERED:
        return None
    return (
        f"the boat runs off the ground maps, which lie around its start: of the last turn they hold {covered:.0%}; the "
        "polar maps hold all of it"
    )


def objects_warning(metrics: Mapping[str, Any]) -> str | None:
    """One line if objects echo more than the sea around them, else None."""
    rows = [row for row in metrics.get("modelled") or () if row.get("what") == "objects"]
    over = reduce.number(rows[0].get("value")) if rows and str(rows[0].get("unit", "")).startswith("dB") else np.nan
    if not over > 0.0:
        return None
    return (
        f"objects echo up to {over:.0f} dB over the sea in their cells: there, and in their sidelobes, heights are "
        "theirs and not the sea's"
    )


def _group(metrics: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    result = metrics.get(name)
    return result if isinstance(result, Mapping) else {}


def _number(facts: Mapping[str, Any], name: str, digits: int, factor: float = 1.0) -> str:
    value = factor * reduce.number(facts.get(name))
    return f"{value:.{digits}g}" if np.isfinite(value) else "—"


def _share(facts: Mapping[str, Any], name: str, digits: int = 4) -> str:
    value = 100.0 * reduce.number(facts.get(name))
    return f"{value:.{digits}g} %" if np.isfinite(value) else "—"


def _step(short: Mapping[str, Any]) -> str:
    if reduce.number(short.get("level_step_db")) < NO_WAVES_DB:
        return "the wind raises no waves of that length"
    return f"{_number(short, 'level_step_db', 2)} dB"


def _length(short: Mapping[str, Any]) -> str:
    limit = reduce.number(short.get("wavenumber_from"))
    return f"{2.0 * np.pi / limit:.3g}" if limit > 0.0 else "—"
