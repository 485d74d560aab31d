"""One page of a run: figures as PNGs beside it and inside it, tables, what was modelled and what was left out."""

from __future__ import annotations

import base64
import importlib.metadata
import importlib.resources
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
import numpy as np
import xarray as xr

from ..forecast_errors import Verified
from ..io.results_folder import write_whole
from ..scene import Scene
from ..window_errors import Windows
from . import curves, evolution, forecast_figures, gauge_figures, reduce, style, window_figures
from .headline import headline, run_line, summary, verdict
from .page_elements import NOTHING, Table, count, digits, metres, percent
from .pictures import pictures
from .sea_statistics import fold_warning, sea_rows, warnings

REPORT = "report.html"
_PACKAGES = ("seamap_rt", "numpy", "scipy", "xarray", "matplotlib", "sionna-rt", "mitsuba", "drjit")


class Entry(NamedTuple):
    """A part of the simulation, in words."""

    what: str
    why: str
    cost: str
    error: str
    source: str


@dataclass(frozen=True)
class Account:
    """What was modelled, or was not; without a cost if its heading is empty."""

    title: str
    cost: str
    error: str
    entries: Sequence[Entry]


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
        drawn = picture.draw()
        kind, data = ("gif", drawn) if isinstance(drawn, bytes) else ("png", style.png(drawn))
        write_whole(directory / f"{picture.name}.{kind}", data)
        shown.append({"picture": picture, "kind": kind, "data": base64.b64encode(data).decode("ascii")})
    page = _template().render(
        scene=scene,
        run=run_line(scene),
        title=scene.title or scene.name,
        verdict=verdict(metrics),
        warnings=warnings(metrics),
        summary=summary(scene, truth, metrics),
        headline=headline(metrics),
        shown=shown,
        tables=tables(scene, maps, truth, metrics),
        accounts=(
            Account("What was modelled", "Cost", "Error of leaving it out", _entries(metrics.get("modelled"))),
            Account("What was left out", "", "Error that it costs", _entries(metrics.get("left_out"))),
        ),
        scene_toml=scene.to_toml(),
    )
    path = directory / REPORT
    write_whole(path, page)
    return path


# ------------------------------------------------------------------------------------------------------ the tables


def tables(scene: Scene, retrieved: xr.DataTree, truth: xr.DataTree, metrics: Mapping[str, Any]) -> list[Table]:
    """The tables of the page."""
    made = [*evolution.turn_table(retrieved, truth), *forecast_figures.forecast_table(metrics.get("prediction") or [])]
    made += [*window_figures.window_table(metrics.get("quiet_windows")), *gauge_figures.gauge_table(metrics)]
    made += [_range_table(scene, metrics), _sea_table(metrics), *_calibration_table(metrics)]
    return [*made, *_mesh_table(metrics), _time_table(metrics), _run_table(scene, metrics)]


def _mesh_table(metrics: Mapping[str, Any]) -> list[Table]:
    """What the mesh is predicted to cost the maps, by range; none if the metrics hold none."""
    mesh = metrics.get("mesh")
    if not isinstance(mesh, Mapping):
        return []
    errors = (("height_error_m", lambda v: digits(v, 3)), ("power_error_db", lambda v: digits(v, 2)))
    rows = [
        [digits(row["range_m"], 0), *(write(row[name]) for name, write in errors), percent(row["visible_error"])]
        for row in mesh.get("by_range", ())
    ]
    note = (
        f"Rungs {mesh['facet_m']:g} m apart, {mesh['columns_per_beam']} columns a beam; what forbids a coarser mesh: "
        f"{mesh['limited_by'] or NOTHING}. Predicted from the sea's spectrum, rms over cells more than half visible, "
        "in the expectation over speckle; over the window, in the look that errs most, "
        f"{metres(mesh['height_error_m'])} and {digits(mesh['power_error_db'], 2)} dB."
    )
    return [Table("The mesh", ("Range (m)", "Height error (m)", "Power error (dB)", "Visible share"), rows, note)]


def _calibration_table(metrics: Mapping[str, Any]) -> list[Table]:
    """What calibration adds to theory by grazing and direction; none if the metrics hold none."""
    scale = metrics.get("calibration")
    if not isinstance(scale, Mapping):
        return []
    names = ("grazing_deg", "up_wind_db", "cross_wind_db", "down_wind_db")
    columns = [reduce.series(scale.get(name)) for name in names]
    rows = [
        [digits(row[0], 2), *(digits(value, 1, signed=True) for value in row[1:])] for row in zip(*columns, strict=True)
    ]
    head = ("Grazing (°)", "Up-wind (dB)", "Cross-wind (dB)", "Down-wind (dB)")
    note = "What is added to the theory's mean echo to make it that of the measured model, shadows included."
    return [Table("Calibration of the mean echo", head, rows, note)]


def _sea_table(metrics: Mapping[str, Any]) -> Table:
    note = (
        "Expectations over all seas that could be drawn. Waves that are not resolved shadow nothing and have no height "
        "of their own: which ones they are decides the shadowing. "
    )
    return Table("The sea", ["", ""], sea_rows(metrics), note + (fold_warning(metrics) or ""))


def _range_table(scene: Scene, metrics: Mapping[str, Any]) -> Table:
    diffracted = scene.tracing.diffraction != "none"
    centres = reduce.series(metrics.get("range_m"))
    columns = [
        ("Range (m)", centres, lambda value: digits(value, 1)),
        *(
            (title, reduce.series(metrics.get(name), centres.size), write)
            for title, name, write in (
                ("Height error, rms (m)", "height_rmse_m", lambda value: digits(value, 3)),
                ("Robust (m)", "height_robust_m", lambda value: digits(value, 3)),
                ("Bias (m)", "height_bias_m", lambda value: digits(value, 3, signed=True)),
                ("Slope error, rms", "slope_rmse", lambda value: digits(value, 3)),
                ("Visible share", "visible_fraction", percent),
                ("Cells", "cells", lambda value: digits(value, 0)),
                *((("Power with diffraction", "illumination", percent),) if diffracted else ()),
            )
        ),
    ]
    rows = [[write(values[index]) for _, values, write in columns] for index in range(centres.size)]
    return Table(
        "Against range",
        [title for title, _, _ in columns],
        rows,
        "Cells more than half visible; bins of few are not drawn.",
    )


def _time_table(metrics: Mapping[str, Any]) -> Table:
    runs = curves.timing_runs(metrics)
    stages = (*curves.STAGES, "total")
    rows = [[stage, *(digits(run.get(stage), 3) for _, run in runs)] for stage in stages]
    return Table("Wall time (s)", ["Stage", *(name for name, _ in runs)], rows)


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


def _entries(entries: Any) -> list[Entry]:
    """What the metrics say of a list of {"what", "why", "cost", "error", "source"} or of plain sentences."""
    rows = []
    for entry in entries if isinstance(entries, list | tuple) else ():
        if isinstance(entry, Mapping):
            rows.append(Entry(*(str(entry.get(name) or NOTHING) for name in Entry._fields)))
        else:
            rows.append(Entry(str(entry), *[NOTHING] * (len(Entry._fields) - 1)))
    return rows


# --------------------------------------------------------------------------------------------------------- the file


def _template() -> jinja2.Template:
    source = importlib.resources.files("seamap_rt.report").joinpath("report.html.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.from_string(source)
