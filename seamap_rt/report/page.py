"""One page of a run: figures as PNGs beside it and inside it, tables, what was modelled and what was left out."""

from __future__ import annotations

import base64
import importlib.metadata
import importlib.resources
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
import numpy as np
import xarray as xr

from ..radar.array import antenna_array
from ..scene import Scene
from . import curves, evolution, gauge_figures, maps, reduce, style
from .parts import NOTHING, Picture, Table, count, digits, metres, percent
from .sea_words import fold_warning, ground_warning, sea_rows

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
) -> Path:
    """Draw the figures into `directory` and write report.html there, which needs no other file; its path.

    Maps and the echo's picture show the last turn; figures against range show all turns, an animation one after the
    other. gauges: what the scene's wave gauges read.
    """
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    shown = []
    for picture in pictures(scene, maps, truth, metrics, echoes, gauges):
        drawn = picture.draw()
        kind, data = ("gif", drawn) if isinstance(drawn, bytes) else ("png", style.png(drawn))
        _write(directory / f"{picture.name}.{kind}", data)
        shown.append({"picture": picture, "kind": kind, "data": base64.b64encode(data).decode("ascii")})
    page = _template().render(
        scene=scene,
        title=scene.title or scene.name,
        summary=summary(scene, truth, metrics),
        headline=headline(scene, truth, metrics),
        shown=shown,
        tables=tables(scene, maps, truth, metrics),
        accounts=(
            Account("What was modelled", "Cost", "Error of leaving it out", _entries(metrics.get("modelled"))),
            Account("What was left out", "", "Error that it costs", _entries(metrics.get("left_out"))),
        ),
        scene_toml=scene.to_toml(),
    )
    path = directory / REPORT
    _write(path, page.encode("utf-8"))
    return path


# ------------------------------------------------------------------------------------------------------ the words


def summary(scene: Scene, truth: xr.DataTree, metrics: Mapping[str, Any]) -> str:
    """The run in one paragraph."""
    figures = dict(headline(scene, truth, metrics))
    waves = "; ".join(maps.describe_waves(each, scene.sea.depth_m) for each in scene.sea.waves) or "no waves"
    radar, array = scene.radar, antenna_array(scene.radar)
    boat = {
        "sinusoidal": " on a rolling boat",
        "file": " on a moving boat",
        "wave_following": " on a boat that rides it",
    }
    return (
        f"A simulated radar {radar.height_m:g} m above the sea{boat.get(scene.platform.motion, '')}, "
        f"with {_few(len(array.elements))} antennas {array.baseline_m:g} m apart, "
        f"mapped this sea: {waves}. Between {reduce.JUDGED_M[0]:g} and {reduce.JUDGED_M[1]:g} m, in cells more than "
        f"half visible, the retrieved height is off by {figures['Height error, rms']} rms "
        f"({figures['Height error, robust']} robust, bias {figures['Height bias']}), and its "
        f"correlation with the true height is {figures['Correlation']}. Four "
        f"standard deviations of the true heights there are {figures['Hs, true']}, of the map's, which are means "
        f"of what may be, {figures['Hs, retrieved']}{_found_state(metrics)}. "
        f"Both antennas see {figures['Visible at 100 m']} of the sea at 100 m and "
        f"{figures['Visible at 160 m']} at 160 m; what lies in shadow stays blank in the maps, or is flagged."
    )


def _found_state(metrics: Mapping[str, Any]) -> str:
    words = metrics.get("sea_state_in_words")
    return f"; with its noise, gaps and cells allowed for it says {words}" if words else ""


def _few(number: int) -> str:
    return {2: "two", 3: "three", 4: "four"}.get(number, str(number))


def headline(scene: Scene, truth: xr.DataTree, metrics: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The figures at the top of the page: label and value."""
    overall = metrics.get("overall")
    overall = overall if isinstance(overall, Mapping) else {}
    return [
        ("Height error, rms", metres(overall.get("height_rmse_m"))),
        ("Height error, robust", metres(overall.get("height_robust_m"))),
        ("Height bias", metres(overall.get("height_bias_m"), signed=True)),
        ("Correlation", digits(overall.get("height_correlation"), 3)),
        ("Hs, true", metres(overall.get("hs_true_m"), 2)),
        ("Hs, retrieved", metres(overall.get("hs_retrieved_m"), 2)),
        ("Visible at 100 m", percent(reduce.visible_at(truth, scene.radar.height_m, 100.0))),
        ("Visible at 160 m", percent(reduce.visible_at(truth, scene.radar.height_m, 160.0))),
    ]


def pictures(
    scene: Scene,
    retrieved: xr.DataTree,
    truth: xr.DataTree,
    metrics: Mapping[str, Any],
    echoes: xr.Dataset,
    gauges: xr.Dataset | None = None,
) -> list[Picture]:
    """The figures of the page, in order, with what is to be said of each."""
    words = dict(headline(scene, truth, metrics))
    turns = reduce.coordinate(retrieved, "polar", "turn")
    turn = int(turns[-1])
    which = f" The last of {turns.size} turns (turn {turn}) is shown." if turns.size > 1 else ""
    over = f", over all {turns.size} turns" if turns.size > 1 else ""
    cell, look, side = scene.retrieval.cell_range_m, scene.retrieval.cell_azimuth_deg, scene.retrieval.ground_m
    azimuth = reduce.coordinate(retrieved, "polar", "azimuth")
    size = f"{scene.retrieval.window_range_m:g} m × {scene.retrieval.window_azimuth_deg:g}°"
    averaged = {
        "adaptive": "by optimal interpolation, which averages more where the echo is weak or unclear",
        "sliding_plane": f"averaged over {size}",
        "single_cell": "averaged over one cell",
    }[scene.retrieval.estimator]
    instant = scene.retrieval.map_time_s
    moment = "when the beam passed each cell" if instant is None else f"{instant:g} s after the turn's start"
    snapshot = ": the maps are no snapshot" if instant is None else ", over which the maps were brought to one instant"
    slope, from_cells = reduce.slope_rms_along_look(truth, metrics)
    source = (
        f"taken from the mean slopes of the {cell:g} m cells, so that shorter waves are missing from it and the curves "
        "lie too high"
        if from_cells
        else "of the simulated surface"
    )
    noise = reduce.number(echoes.attrs.get("noise_power_w", 0.0))
    over_noise = (
        f"in dB over the thermal noise of one gate ({noise:.3g} W); noise is part of the power, so 0 dB means no echo"
        if noise > 0.0
        else "in dB over 1 W (no noise was added)"
    )
    blank = (
        "Grey is where the radar looked and got no height: shadow, an echo under the threshold, or a cell that the "
        "retrieval would not vouch for. Nothing is filled in. "
    )
    if left := ground_warning(metrics):
        blank += f"{left[0].upper()}{left[1:]}. "
    return [
        Picture(
            "height_maps",
            "True and retrieved height",
            f"Four maps, north up: true height, retrieved height, their difference (rms {words['Height error, rms']} "
            "at 50 to 200 m) and the standard error stated by the retrieval.",
            f"Height above mean sea level on ground cells of {side:g} m. (a) The sea as it was {moment}, "
            "lit or not. (b) What the retrieval made of the echoes, "
            f"{averaged}, on the same scale. (c) Their "
            "difference, on its own scale; unlike the figures against range it includes cells that are less than half "
            f"visible. (d) The standard error that the retrieval states for itself. {blank}Colour bars end in arrows "
            "where values lie beyond. North is up, the antenna (triangle) at the origin; azimuth is time, since a turn "
            f"takes {scene.turn_duration_s:.3g} s and the waves move on meanwhile{snapshot}." + which,
            lambda: maps.height_maps(scene, retrieved, truth),
        ),
        *evolution.film(scene, retrieved, truth),
        *gauge_figures.gauge_pictures(gauges),
        Picture(
            "slope_maps",
            "True and retrieved slope",
            "Four maps, north up: true and retrieved slope towards east, true and retrieved slope towards north.",
            f"Slope of the sea surface, averaged over ground cells of {side:g} m, all four panels on one scale; "
            f"positive where the sea rises towards east (upper row) or north (lower row). {blank}" + which,
            lambda: maps.slope_maps(scene, retrieved, truth),
        ),
        Picture(
            "error_against_range",
            "Error against range",
            f"Graphs of height error, bias and slope error against range; overall rms {words['Height error, rms']}, "
            f"robust {words['Height error, robust']}, bias {words['Height bias']}.",
            f"Errors per range bin of the polar cells ({cell:g} m × {look:g}°) that are more than half visible{over}: "
            "rms, robust (1.4826 × the median absolute deviation, blind to outliers) and mean (positive: retrieved too "
            "high; the truth is the mean of the whole cell, while the radar sees crests more than troughs). Dashed: "
            "the median of the retrieval's own standard error in the same cells; where it lies below the rms, the "
            f"retrieval is too sure of itself. Over {reduce.JUDGED_M[0]:g}–{reduce.JUDGED_M[1]:g} m: rms "
            f"{words['Height error, rms']}, robust {words['Height error, robust']}, bias {words['Height bias']}. (c) "
            "The rms error of the slope, as metrics.json gives it.",
            lambda: curves.error_against_range(retrieved, truth, metrics),
        ),
        Picture(
            "height_scatter",
            "Retrieved against true height",
            f"Two-dimensional histogram of retrieved against true height, correlation {words['Correlation']}, and "
            "histogram of the error over its stated standard error.",
            f"Polar cells ({cell:g} m × {look:g}°) between {reduce.JUDGED_M[0]:g} and {reduce.JUDGED_M[1]:g} m that "
            f"are more than half visible{over}. (a) Counted in squares; the dashed line is a perfect retrieval. (b) "
            "The height error over the standard error that the retrieval states for the cell: one that knows its own "
            "error follows the normal distribution, with 68 % within ±1 and 95 % within ±2.",
            lambda: curves.height_scatter(retrieved, truth),
        ),
        Picture(
            "visible_share",
            "Visible share against range",
            f"Visible share of the sea against ground range with the curves of Smith and Wagner: "
            f"{words['Visible at 100 m']} at 100 m, {words['Visible at 160 m']} at 160 m.",
            f"Share of the horizontal area of the polar cells that is lit for both antennas{over}: all looks, and "
            "sectors of ±22.5° about the direction from which the highest waves come (up-wave), the opposite one "
            "(down-wave) and both at right angles (across). Smith (1967) and Wagner (1967) for a Gaussian sea with an "
            f"rms slope along the look of {digits(slope, 3)}, {source}, at the grazing angle atan(antenna height / "
            "ground range). Both ignore that height and slope are correlated along the ray, and overestimate "
            "visibility against exact ray tracing: Smith by some 3–16 %, Wagner by 20–45 %.",
            lambda: curves.visible_share(scene, truth, metrics),
        ),
        Picture(
            "echo_power",
            "The echo",
            "Plan position indicator of mean echo power, north up, and its profile against range.",
            f"Mean power per look and range gate, over its pulses and both receivers, {over_noise}. (a) Plan position "
            "indicator: north up, azimuth clockwise, gates placed at the ground range of mean sea level. (b) The mean "
            f"over the looks (of power, not of dB) and the spread of the looks, against slant range." + which,
            lambda: maps.echo_power(scene, echoes, azimuth, turn),
        ),
        Picture(
            "timing",
            "Where the time went",
            f"Bars of wall time per stage; real-time factor {digits(metrics.get('real_time_factor'), 3)}.",
            "Wall time of each stage. The first turn includes what is done once (compiling kernels, realising the "
            "sea). The real-time factor is a turn's duration over the warm wall time of "
            f"{' + '.join(curves.REAL_TIME_STAGES)}, in memory: above 1 the simulation is faster than the radar.",
            lambda: curves.timing(scene, metrics),
        ),
    ]


# ------------------------------------------------------------------------------------------------------ the tables


def tables(scene: Scene, retrieved: xr.DataTree, truth: xr.DataTree, metrics: Mapping[str, Any]) -> list[Table]:
    """The tables of the page."""
    found = [*evolution.turn_table(retrieved, truth), *gauge_figures.gauge_table(metrics)]
    found += [_range_table(scene, metrics), _sea_table(metrics), *_calibration_table(metrics)]
    return [*found, *_mesh_table(metrics), _time_table(metrics), _run_table(scene, metrics)]


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
        "Expectations, before the dice. Waves that are not resolved shadow nothing and have no height of their own: "
        "which ones they are decides the shadowing. "
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
                *((("Power with diffraction", "illumination", percent),) if diffracted else ()),
            )
        ),
    ]
    rows = [[write(values[index]) for _, values, write in columns] for index in range(centres.size)]
    return Table("Against range", [title for title, _, _ in columns], rows, "Cells more than half visible.")


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
    found = [("Python", platform.python_version())]
    for package in _PACKAGES:
        try:
            found.append((package, importlib.metadata.version(package)))
        except importlib.metadata.PackageNotFoundError:
            found.append((package, NOTHING))
    return found


def _entries(entries: Any) -> list[Entry]:
    """What the metrics say of a list of {"what", "why", "cost", "error", "source"} or of plain sentences."""
    found = []
    for entry in entries if isinstance(entries, list | tuple) else ():
        if isinstance(entry, Mapping):
            found.append(Entry(*(str(entry.get(name) or NOTHING) for name in Entry._fields)))
        else:
            found.append(Entry(str(entry), *[NOTHING] * (len(Entry._fields) - 1)))
    return found


# --------------------------------------------------------------------------------------------------------- the file


def _template() -> jinja2.Template:
    source = importlib.resources.files("seamap_rt.report").joinpath("report.html.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.from_string(source)


def _write(path: Path, data: bytes) -> None:
    """The file, whole or not at all."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_bytes(data)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
