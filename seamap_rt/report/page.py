"""One page of a run: figures as PNGs beside it and inside it, tables, what was modelled and what was left out."""

from __future__ import annotations

import importlib.metadata
import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..conventions import turn_name
from ..forecast_errors import VerifiedForecasts
from ..io.results_folder import write_whole
from ..scene import Scene
from ..window_errors import Windows
from . import curves, evolution, forecast_figures, gauge_figures, maps, reduce, spectrum_figures
from .headline import fold_warning, ground_warning, headline, run_line, sea_rows, summary, verdict, warnings
from .page_elements import (
    NOTHING,
    Fold,
    Image,
    Picture,
    Table,
    columns_table,
    count,
    decimals,
    digits,
    draw_images,
    html_page,
    metres,
    percent,
)

REPORT = "report.html"
_PACKAGES = ("seamap_rt", "numpy", "scipy", "xarray", "matplotlib", "sionna-rt", "mitsuba", "drjit")


_MODELLED = {"what": "What", "why": "Why", "cost": "Cost", "error": "Error of leaving it out", "source": "By"}
_LEFT_OUT = {"what": "What", "why": "Why", "error": "Error that it costs", "source": "By"}


def write_report(
    directory: Path,
    scene: Scene,
    maps: xr.DataTree,
    truth: xr.DataTree,
    metrics: Mapping[str, Any],
    echoes: xr.Dataset,
    gauges: xr.Dataset | None = None,
    verified: VerifiedForecasts | None = None,
    windows: Windows | None = None,
    draw: Callable[[Sequence[Picture]], list[Image]] = draw_images,
) -> Path:
    """Draw the figures into `directory` and write report.html there, which needs no other file; its path.

    Maps and the echo's picture show the last turn; figures against range show all turns, an animation one after the
    other. gauges: what the scene's wave gauges read. verified: what was forecast, beside the sea that came;
    windows: the quiet ones among it. draw: draws the pictures, in their order.
    """
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    shown = draw(list(pictures(scene, maps, truth, metrics, echoes, gauges, verified, windows)))
    for image in shown:
        write_whole(directory / f"{image.name}.{image.kind}", image.data)
    answer = verdict(metrics)
    path = directory / REPORT
    page = html_page(
        scene.title or scene.name,
        [answer] if answer else [],
        shown,
        (
            Fold("What was modelled", _account(metrics.get("modelled"), _MODELLED)),
            Fold("What was left out", _account(metrics.get("left_out"), _LEFT_OUT)),
            Fold("Tables", tables(scene, maps, truth, metrics)),
            Fold("The scene, every key resolved", text=scene.to_toml()),
        ),
        run=run_line(scene),
        warnings=warnings(metrics),
        headline=headline(metrics),
        words=summary(scene, truth, metrics),
    )
    write_whole(path, page)
    return path


def _account(entries: Any, columns: Mapping[str, str]) -> list[Table]:
    """What the metrics say of a list of mappings or of plain sentences; columns: heads by the mappings' keys."""
    rows = []
    for entry in entries if isinstance(entries, list | tuple) else ():
        fields = entry if isinstance(entry, Mapping) else {"what": str(entry)}
        rows.append([str(fields.get(name) or NOTHING) for name in columns])
    return [Table("", list(columns.values()), rows, words=True, nothing="The metrics do not say.")]


# ------------------------------------------------------------------------------------------------------ the tables


def tables(scene: Scene, retrieved: xr.DataTree, truth: xr.DataTree, metrics: Mapping[str, Any]) -> list[Table]:
    """The tables of the page."""
    made = [*evolution.turn_table(retrieved, truth), *forecast_figures.forecast_table(metrics.get("prediction") or [])]
    made += [*forecast_figures.window_table(metrics.get("quiet_windows")), *gauge_figures.gauge_table(metrics)]
    made += [_range_table(scene, metrics), *_visible_table(metrics), _sea_table(metrics), *_calibration_table(metrics)]
    return [*made, *_mesh_table(metrics), _time_table(metrics), _run_table(scene, metrics)]


def _mesh_table(metrics: Mapping[str, Any]) -> list[Table]:
    """What the mesh is predicted to cost the maps, by range; none if the metrics hold none."""
    mesh = metrics.get("mesh")
    if not isinstance(mesh, Mapping):
        return []
    note = (
        f"Rungs {mesh['facet_m']:g} m apart, {mesh['columns_per_beam']} columns a beam; what forbids a coarser mesh: "
        f"{mesh['limited_by'] or NOTHING}. Predicted from the sea's spectrum, rms over cells more than half visible, "
        "in the expectation over speckle, by straight rays: of light that bends over crests a finer mesh draws other "
        "errors, as large. Over the window, in the look that errs most, "
        f"{metres(mesh['height_error_m'])} and {digits(mesh['power_error_db'], 2)} dB."
    )
    columns = {
        "range_m": ("Range (m)", decimals(0)),
        "height_error_m": ("Height error (m)", decimals(3)),
        "power_error_db": ("Power error (dB)", decimals(2)),
        "visible_error": ("Visible share", percent),
    }
    return [columns_table("The mesh", columns, lambda key: [row[key] for row in mesh["by_range"]], note)]


def _calibration_table(metrics: Mapping[str, Any]) -> list[Table]:
    """What calibration adds to theory by grazing and direction; none if the metrics hold none."""
    scale = metrics.get("calibration")
    if not isinstance(scale, Mapping):
        return []
    columns = {
        "grazing_deg": ("Grazing (°)", decimals(2)),
        "up_wind_db": ("Up-wind (dB)", decimals(1, signed=True)),
        "cross_wind_db": ("Cross-wind (dB)", decimals(1, signed=True)),
        "down_wind_db": ("Down-wind (dB)", decimals(1, signed=True)),
    }
    note = "What is added to the theory's mean echo to make it that of the measured model, shadows included."
    return [columns_table("Calibration of the mean echo", columns, lambda key: scale[key], note)]


def _sea_table(metrics: Mapping[str, Any]) -> Table:
    note = (
        "Expectations over all seas that could be drawn. Waves that are not resolved shadow nothing and have no height "
        "of their own: which ones they are decides the shadowing. "
    )
    return Table("The sea", ["", ""], sea_rows(metrics), note + (fold_warning(metrics) or ""))


def _range_table(scene: Scene, metrics: Mapping[str, Any]) -> Table:
    bins = reduce.series(metrics.get("range_m")).size
    columns = {
        "range_m": ("Range (m)", decimals(1)),
        "height_rmse_m": ("Height error, rms (m)", decimals(3)),
        "height_robust_m": ("Robust (m)", decimals(3)),
        "height_bias_m": ("Bias (m)", decimals(3, signed=True)),
        "slope_rmse": ("Slope error, rms", decimals(3)),
        "visible_fraction": ("Visible share", percent),
        "cells": ("Cells", decimals(0)),
    }
    if metrics.get("illumination") not in (None, metrics.get("visible_fraction")):  # without diffraction one
        columns["illumination"] = ("Power with diffraction", percent)
    note = "Cells more than half visible; bins of few are not drawn."
    return columns_table("Against range", columns, lambda key: reduce.series(metrics.get(key), bins), note)


def _visible_table(metrics: Mapping[str, Any]) -> list[Table]:
    """Half ranges and visible shares, to light and to a radar; none where the metrics do not say."""
    _, shown = reduce.visible(metrics)
    if not shown:
        return []
    columns = {
        "sees": ("Visible to", str),
        "level_db": ("Power over the same water's when lit, at least (dB)", lambda x: f"{x:g}" if x else NOTHING),
        "half_visible_m": ("Half visible to (m)", decimals(0)),
        "visible_fraction": ("Share at 50–200 m", percent),
    }
    own = metrics["visible"]["polarization"]
    note = f"By ground range, of the first turn's looks. This radar's polarization is {own}."
    return [columns_table("What is visible", columns, lambda key: [row[key] for row in shown], note)]


def _time_table(metrics: Mapping[str, Any]) -> Table:
    runs = dict(curves.timing_runs(metrics))
    rows = [[stage, *(digits(run.get(stage), 3) for run in runs.values())] for stage in (*curves.STAGES, "total")]
    return Table("Wall time (s)", ["Stage", *runs], rows)


def _run_table(scene: Scene, metrics: Mapping[str, Any]) -> Table:
    memory = reduce.number(metrics.get("peak_memory_bytes")) / 1e9
    rows = [
        ["Seed", str(scene.seed)],
        ["Turns", str(scene.turns)],
        ["Facets", count(metrics.get("facets"))],
        ["Rays", count(metrics.get("rays"))],
        ["Peak memory", f"{digits(memory, 2)} GB" if np.isfinite(memory) else NOTHING],
        ["Real-time factor", digits(metrics.get("real_time_factor"), 3)],
        ["Python", platform.python_version()],
    ]
    return Table("The run", ["", ""], [*rows, *([package, _version(package)] for package in _PACKAGES)])


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return NOTHING


# ---------------------------------------------------------------------------------------------------- the figures


def pictures(
    scene: Scene,
    retrieved: xr.DataTree,
    truth: xr.DataTree,
    metrics: Mapping[str, Any],
    echoes: xr.Dataset,
    gauges: xr.Dataset | None = None,
    verified: VerifiedForecasts | None = None,
    windows: Windows | None = None,
) -> list[Picture]:
    """The figures of the page, in order, with what is to be said of each. Nothing is drawn yet but the animation."""
    run = _Run(scene, retrieved, truth, metrics, echoes)
    return [
        _height_maps(run),
        *evolution.film(scene, retrieved, truth),
        *(spectrum_figures.wave_height_pictures(metrics) if run.turns.size > 1 else ()),
        *forecast_figures.forecast_pictures(scene, retrieved, verified),
        *forecast_figures.window_pictures(windows, scene.prediction.quiet.confidence),
        *gauge_figures.gauge_pictures(gauges),
        *_graphs(run),
    ]


class _Run:
    """What is shown, and the words that several captions share."""

    def __init__(
        self,
        scene: Scene,
        retrieved: xr.DataTree,
        truth: xr.DataTree,
        metrics: Mapping[str, Any],
        echoes: xr.Dataset,
    ) -> None:
        self.scene, self.retrieved, self.truth, self.metrics, self.echoes = scene, retrieved, truth, metrics, echoes
        self.figures, self.judged = dict(headline(metrics)), reduce.judged_band(truth)
        self.turns = reduce.coordinate(retrieved, "polar", "turn")
        several, last = self.turns.size > 1, turn_name(self.turns[-1])
        self.which_turn = f" The last of {self.turns.size} turns ({last}) is shown." if several else ""
        self.over_turns = f", over all {self.turns.size} turns" if several else ""
        self.cells = f"{scene.retrieval.cell_range_m:g} m × {scene.retrieval.cell_azimuth_deg:g}°"
        self.blank = (  # what the grey of the maps means
            "Grey is where the radar looked and got no height: shadow, an echo under the threshold, or a cell that the "
            "retrieval would not vouch for. Nothing is filled in. "
        )
        if left := ground_warning(metrics):
            self.blank += f"{left[0].upper()}{left[1:]}. "


def _height_maps(run: _Run) -> Picture:
    settings, instant = run.scene.retrieval, run.scene.retrieval.map_time_s
    window = f"{settings.window_range_m:g} m × {settings.window_azimuth_deg:g}°"
    averaged = {
        "adaptive": "by optimal interpolation, which averages more where the echo is weak or unclear",
        "sliding_plane": f"averaged over {window}",
        "single_cell": "averaged over one cell",
    }[settings.estimator]
    moment = "when the beam passed each cell" if instant is None else f"{instant:g} s after the turn's start"
    snapshot = ": the maps are no snapshot" if instant is None else ", over which the maps were brought to one instant"
    return Picture(
        "height_maps",
        "True and retrieved height",
        "Four maps, north up: true height, retrieved height, their difference (rms "
        f"{run.figures['Height error, rms']} at {run.judged}) and the standard error stated by the retrieval.",
        f"Height above mean sea level on ground cells of {settings.ground_m:g} m. (a) The sea as it was {moment}, "
        "lit or not. (b) What the retrieval made of the echoes, "
        f"{averaged}, on the same scale. (c) Their "
        "difference, on its own scale; unlike the figures against range it includes cells that are less than half "
        f"visible. (d) The standard error that the retrieval states for itself. {run.blank}Colour bars end in arrows "
        "where values lie beyond. North is up, the antenna (triangle) at the origin; azimuth is time, since a turn "
        f"takes {run.scene.turn_duration_s:.3g} s and the waves move on meanwhile{snapshot}." + run.which_turn,
        lambda: maps.height_maps(run.scene, run.retrieved, run.truth),
    )


def _graphs(run: _Run) -> Iterator[Picture]:
    """What stands below the heights and what was made of them."""
    words, slope = run.figures, digits(run.metrics.get("slope_rms_look"), 3)
    noise = reduce.number(run.echoes.attrs.get("noise_power_w", 0.0))
    over_noise = "in dB over 1 W (no noise was added)"
    if noise > 0.0:
        over_noise = f"in dB over the thermal noise of one gate ({noise:.3g} W); noise is part of the power, so "
        over_noise += "0 dB means no echo"
    azimuth = reduce.coordinate(run.retrieved, "polar", "azimuth")
    by_radar = ""
    if reduce.visible(run.metrics)[1]:
        by_radar = f"To a radar in VV and in HH: water that returns {run.metrics['visible']['seen_db']:g} dB or "
        by_radar += "more of its two-way power when lit, in the first turn. "
    yield Picture(
        "slope_maps",
        "True and retrieved slope, and the error",
        "Six maps, north up: true slope, retrieved slope and its error, towards east and towards north.",
        f"Slope of the sea surface, averaged over ground cells of {run.scene.retrieval.ground_m:g} m, and its error "
        "(retrieved − true), all panels on one scale; positive where the sea rises towards east (left) or north "
        f"(right). {run.blank}" + run.which_turn,
        lambda: maps.slope_maps(run.scene, run.retrieved, run.truth),
    )
    yield Picture(
        "error_against_range",
        "Error against range",
        f"Graphs of height error, bias and slope error against range; overall rms {words['Height error, rms']}, "
        f"robust {words['Height error, robust']}, bias {words['Height bias']}.",
        f"Errors per range bin of the polar cells ({run.cells}) that are more than half visible{run.over_turns}: "
        "rms, robust (1.4826 × the median absolute deviation, blind to outliers) and mean (positive: retrieved too "
        "high; the truth is the mean of the whole cell, while the radar sees crests more than troughs). Dashed: "
        "the median of the retrieval's own standard error in the same cells; where it lies below the rms, the "
        f"retrieval is too sure of itself. Over {run.judged}: rms "
        f"{words['Height error, rms']}, robust {words['Height error, robust']}, bias {words['Height bias']}. (c) "
        "The rms error of the slope, as metrics.json gives it.",
        lambda: curves.error_against_range(run.retrieved, run.truth, run.metrics),
    )
    yield Picture(
        "height_scatter",
        "Retrieved against true height",
        f"Two-dimensional histogram of retrieved against true height, correlation {run.figures['Correlation']}, and "
        "histogram of the error over its stated standard error.",
        f"Polar cells ({run.cells}) at {run.judged} that "
        f"are more than half visible{run.over_turns}. (a) Counted in squares; the dashed line is a perfect retrieval. "
        "(b) The height error over the standard error that the retrieval states for the cell: one that knows its own "
        "error follows the normal distribution, with 68 % within ±1 and 95 % within ±2.",
        lambda: curves.height_scatter(run.retrieved, run.truth),
    )
    yield Picture(
        "visible_share",
        "Visible share against range",
        f"Visible share of the sea against ground range with the curves of Smith and Wagner: "
        f"half of the sea is visible to {run.figures['Half visible to']}.",
        f"{by_radar}Share of the horizontal area of the polar cells that is lit for both "
        f"antennas{run.over_turns}: all looks, "
        "and sectors of ±22.5° about the direction from which the highest waves come (up-wave), the opposite one "
        "(down-wave) and both at right angles (across). Smith (1967) and Wagner (1967) for a Gaussian sea with an "
        f"rms slope along the look of {slope}, of the simulated surface, at the grazing angle atan(antenna height / "
        "ground range). Both ignore that height and slope are correlated along the ray, and overestimate "
        "visibility against exact ray tracing (in the seas of the validation, Smith by 3–16 %, Wagner by 20–45 %).",
        lambda: curves.visible_share(run.scene, run.truth, run.metrics),
    )
    yield Picture(
        "echo_power",
        "The echo",
        "Plan position indicator of mean echo power, north up, and its profile against range.",
        f"Mean power per look and range gate, over its pulses and both receivers, {over_noise}. (a) Plan position "
        "indicator: north up, azimuth clockwise, gates placed at the ground range of mean sea level. (b) The mean "
        f"over the looks (of power, not of dB) and the spread of the looks, against slant range." + run.which_turn,
        lambda: maps.echo_power(run.scene, run.echoes, azimuth, int(run.turns[-1])),
    )
    yield Picture(
        "timing",
        "Where the time went",
        f"Bars of wall time per stage; real-time factor {digits(run.metrics.get('real_time_factor'), 3)}.",
        "Wall time of each stage. The first turn includes what is done once (compiling kernels, realising the "
        "sea). The real-time factor is the simulated time of the warm turns over their wall time, maps and files "
        "included: above 1 the run is faster than the radar. Stages overlap, so that they add up to more.",
        lambda: curves.timing(run.scene, run.metrics),
    )
