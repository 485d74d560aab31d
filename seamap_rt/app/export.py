"""What is downloaded from a view: its numbers as CSV, its maps as the report's own picture."""

from __future__ import annotations

import math
from collections.abc import Iterable

import xarray as xr

from ..conventions import turn_name
from ..io.csv_text import csv_text
from ..report import maps as report_maps
from ..report import style
from .views import Source


def turn_csv(source: Source, azimuth_deg: float, index: int) -> str:
    """The section along a look and the errors by range of a turn; a table below the other, each with its heading."""
    section, told = source.section(azimuth_deg, index), source.by_range(index)
    columns = (section.ground_m, section.true, section.visible, section.placed_m, section.retrieved, section.spread)
    return csv_text([
        [f"section along {section.azimuth_deg:.2f} degrees; {turn_name(source.results.turns()[index])}"],
        ["ground_range_m", "true_height_m", "visible_fraction", "placed_at_m", "height_m", "height_std_m"],
        *_rows(columns),
        [],
        ["errors by ground range, cells more than half visible"],
        ["ground_range_m", "rms_m", "bias_m", "stated_m", "visible_fraction", "answered_fraction"],
        *_rows((told.centre_m, told.rms, told.bias, told.stated, told.visible, told.answered)),
    ])  # fmt: skip


def _rows(columns: Iterable[Iterable[float]]) -> list[list[str]]:
    return [[f"{value:.6g}" if math.isfinite(value) else "" for value in row] for row in zip(*columns, strict=True)]


def turn_png(source: Source, index: int) -> bytes | None:
    """The report's maps of one turn; None where the scene or the truth is not known."""
    results, scene = source.results, source.scene
    if scene is None or not results.has_truth or results.growing:
        return None
    with xr.open_datatree(results.maps) as seen, xr.open_datatree(results.truth) as true:
        turn = {"turn": slice(index, index + 1)}
        one = [
            xr.DataTree.from_dict({"/ground": tree["ground"].to_dataset().isel(turn).load()}) for tree in (seen, true)
        ]
    return style.png(report_maps.height_maps(scene, one[0], one[1]))
