"""One page of a run: figures as PNGs beside it and inside it, tables, what was modelled and what was left out."""

from __future__ import annotations

import importlib.metadata
import platform
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..forecast_errors import Verified
from ..io.results_folder import write_whole
from ..scene import Scene
from ..window_errors import Windows
from . import curves, evolution, forecast_figures, gauge_figures, reduce
from .headline import headline, run_line, summary, verdict
from .page_elements import NOTHING, Fold, Table, columns_table, count, decimals, digits, html_page, metres, percent
from .pictures import pictures
from .sea_statistics import fold_warning, sea_rows, warnings

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
    verified: Verified | None = None,
    windows: Windows | None = None,
) -> Path:
    """Draw the figures into `directory` and write report.html there, which needs no other file; its path.

    Maps and the echo's picture show the last turn; figures against range show all turns, an animation one after the
    other. gauges: what the scene's wave gauges read. verified: what was forecast, beside the sea that came;
    windows: the quiet ones among it.
    """
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    shown = []
    for picture in pictures(scene, maps, truth, metrics, echoes, gauges, verified, windows):
        shown.append(picture.image())
        write_whole(directory / f"{picture.name}.{shown[-1].kind}", shown[-1].data)
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
        told = entry if isinstance(entry, Mapping) else {"what": str(entry)}
        rows.append([str(told.get(name) or NOTHING) for name in columns])
    return [Table("", list(columns.values()), rows, words=True, nothing="The metrics do not say.")]


# ------------------------------------------------------------------------------------------------------ the tables


def tables(scene: Scene, retrieved: xr.DataTree, truth: xr.DataTree, metrics: Mapping[str, Any]) -> list[Table]:
    """The tables of the page."""
    made = [*evolution.turn_table(retrieved, truth), *forecast_figures.forecast_table(metrics.get("prediction") or [])]
    made += [*forecast_figures.window_table(metrics.get("quiet_windows")), *gauge_figures.gauge_table(metrics)]
    made += [_range_table(scene, metrics), _sea_table(metrics), *_calibration_table(metrics)]
    return [*made, *_mesh_table(metrics), _time_table(metrics), _run_table(scene, metrics)]


def _mesh_table(metrics: Mapping[str, Any]) -> list[Table]:
    """What the mesh is predicted to cost the maps, by range; none if the metrics hold none."""
    mesh = metrics.get("mesh")
    if not isinstance(mesh, Mapping):
        return []
    note = (
        f"Rungs {mesh['facet_m']:g} m apart, {mesh['columns_per_beam']} columns a beam; what forbids a coarser mesh: "
        f"{mesh['limited_by'] or NOTHING}. Predicted from the sea's spectrum, rms over cells more than half visible, "
        "in the expectation over speckle; over the window, in the look that errs most, "
        f"{metres(mesh['height_error_m'])} and {digits(mesh['power_error_db'], 2)} dB."
    )
    columns = {
        "range_m": ("Range (m)", decimals(0)),
        "height_error_m": ("Height error (m)", decimals(3)),
        "power_error_db": ("Power error (dB)", decimals(2)),
        "visible_error": ("Visible share", percent),
    }
    by_range = mesh.get("by_range", ())
    return [
        columns_table(
            "The mesh", [(head, [row[k] for row in by_range], write) for k, (head, write) in columns.items()], note
        )
    ]


def _calibration_table(metrics: Mapping[str, Any]) -> list[Table]:
    """What calibration adds to theory by grazing and direction; none if the metrics hold none."""
    scale = metrics.get("calibration")
    if not isinstance(scale, Mapping):
        return []
    heads = {"grazing_deg": "Grazing (°)", "up_wind_db": "Up-wind (dB)", "cross_wind_db": "Cross-wind (dB)"}
    heads |= {"down_wind_db": "Down-wind (dB)"}
    writers = [decimals(2), *[decimals(1, signed=True)] * 3]
    columns = [(heads[k], reduce.series(scale.get(k)), write) for k, write in zip(heads, writers, strict=True)]
    note = "What is added to the theory's mean echo to make it that of the measured model, shadows included."
    return [columns_table("Calibration of the mean echo", columns, note)]


def _sea_table(metrics: Mapping[str, Any]) -> Table:
    note = (
        "Expectations over all seas that could be drawn. Waves that are not resolved shadow nothing and have no height "
        "of their own: which ones they are decides the shadowing. "
    )
    return Table("The sea", ["", ""], sea_rows(metrics), note + (fold_warning(metrics) or ""))


def _range_table(scene: Scene, metrics: Mapping[str, Any]) -> Table:
    centres = reduce.series(metrics.get("range_m"))
    columns = {
        "height_rmse_m": ("Height error, rms (m)", decimals(3)),
        "height_robust_m": ("Robust (m)", decimals(3)),
        "height_bias_m": ("Bias (m)", decimals(3, signed=True)),
        "slope_rmse": ("Slope error, rms", decimals(3)),
        "visible_fraction": ("Visible share", percent),
        "cells": ("Cells", decimals(0)),
    }
    if scene.tracing.diffraction != "none":
        columns["illumination"] = ("Power with diffraction", percent)
    shown = [(head, reduce.series(metrics.get(k), centres.size), write) for k, (head, write) in columns.items()]
    note = "Cells more than half visible; bins of few are not drawn."
    return columns_table("Against range", [("Range (m)", centres, decimals(1)), *shown], note)


def _time_table(metrics: Mapping[str, Any]) -> Table:
    stages = (*curves.STAGES, "total")
    runs = [(name, [run.get(stage) for stage in stages], decimals(3)) for name, run in curves.timing_runs(metrics)]
    return columns_table("Wall time (s)", [("Stage", stages, str), *runs])


def _run_table(scene: Scene, metrics: Mapping[str, Any]) -> Table:
    memory = reduce.number(metrics.get("peak_memory_bytes")) / 1e9
    rows = [
        ["Seed", str(scene.seed)],
        ["Turns", str(scene.turns)],
        ["Facets", count(metrics.get("facets"))],
        ["Rays", count(metrics.get("rays"))],
        ["Peak memory", f"{digits(memory, 2)} GB" if np.isfinite(memory) else NOTHING],
        ["Real-time factor", digits(metrics.get("real_time_factor"), 3)],
    ]
    rows += [[name.capitalize(), str(metrics[name])] for name in ("backend", "device") if metrics.get(name)]
    rows += [[name, version] for name, version in _versions(metrics)]
    return Table("The run", ["", ""], rows)


def _versions(metrics: Mapping[str, Any]) -> list[tuple[str, str]]:
    given = metrics.get("versions")
    if isinstance(given, Mapping):
        return [(str(name), str(version)) for name, version in given.items()]
    versions = [("Python", platform.python_version())]
    for package in _PACKAGES:
        try:
            versions.append((package, importlib.metadata.version(package)))
        except importlib.metadata.PackageNotFoundError:
            versions.append((package, NOTHING))
    return versions
