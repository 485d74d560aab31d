"""Parts of See: the section along a look; the report's figures of errors by range and of wave gauges; a shadowing
study, and the sea on file in its pictures."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr
from nicegui import ui
from numpy.typing import NDArray

from ..conventions import turn_name
from ..errors import InputError
from ..gauges import judge_one
from ..io.opening import load, open_dataset, open_file
from ..io.text import csv_text
from ..io.turn_files import GrowingFile, read_whole_turns
from ..physics.shadowing import SEEN_DB
from ..report import curves, style
from ..report import maps as report_maps
from ..report.gauge_figures import gauge_picture
from ..report.page_elements import Picture
from ..studies.shadowing_figures import LOOK_WORDS, draw_shadowing
from . import drawing, figures
from .figures import Figure
from .folders import address
from .results import Results
from .source import Section, Source
from .widgets import Image, Images, choice, draw_images, number, slider, tile

if TYPE_CHECKING:
    from .prospects import Prospects
    from .see_view import SeeView


Array = NDArray[np.float64]


_MARGIN = {"l": 50, "r": 10, "t": 30, "b": 66}


class SectionPanel:
    """The section, with the look to be chosen."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        with ui.row().classes("w-full items-center gap-2 no-wrap"):
            ui.label("Look").classes("text-sm")
            self.slider = slider("Azimuth of the look", "azimuth", self._turned, 0, 359, round(view.azimuth) % 360)
        self.plot = ui.plotly(figures.nothing(view.page.dark)).classes("w-full").mark("section")

    def _turned(self) -> None:
        self.view.set_azimuth(float(self.slider.value or 0.0))

    async def show(self, source: Source, turn: int) -> None:
        made = await drawing.quick(section_of, source, self.view.azimuth, turn, self.view.page.dark)
        self.plot.update_figure(made)


def section_of(source: Source, azimuth_deg: float, turn: int, dark: bool) -> Figure:
    """The section of a turn along a look."""
    section = source.section(azimuth_deg, turn)
    heights = np.abs(np.concatenate([section.true, section.retrieved]))
    limit = max(float(np.nanmax(heights)) if np.isfinite(heights).any() else 1.0, 0.2)
    return section_graph(section, limit, dark)


def section_graph(section: Section, limit_m: float, dark: bool) -> Figure:
    """True and retrieved height along a look, shadows in grey, the antenna and its rays over the crests."""
    ground = section.ground_m
    order = np.argsort(section.placed_m)
    placed = section.placed_m[order]
    data: list[Figure] = []
    if np.isfinite(section.retrieved).any():
        low, high = section.low[order], section.high[order]
        data = [
            *figures.band(placed, low, high, "± 1.96 stated errors", style.VERMILION, 0.2),
            figures.line(placed, section.retrieved[order], "retrieved", style.VERMILION),
        ]
    if np.isfinite(section.true).any():
        data.insert(0, figures.line(ground, section.true, "true", figures.ink(dark)))
    top = max(limit_m, section.antenna_m) * 1.1
    for x, y in section.rays():
        data.append({
            "type": "scatter", "mode": "lines", "x": [0.0, x], "y": [section.antenna_m, y], "hoverinfo": "skip",
            "showlegend": False, "line": {"color": style.ORANGE, "width": 0.7},
        })  # fmt: skip
    data.append({
        "type": "scatter", "mode": "markers", "x": [0.0], "y": [section.antenna_m], "name": "antenna and its rays",
        "marker": {"symbol": "triangle-up", "size": 11, "color": style.ORANGE},
    })  # fmt: skip
    shadows = [
        {
            "type": "rect", "x0": a, "x1": b, "y0": 0, "y1": 1, "yref": "paper", "line": {"width": 0},
            "fillcolor": "#808890", "opacity": 0.25, "layer": "below",
        }
        for a, b in section.shadows()
    ]  # fmt: skip
    title = f"Along {section.azimuth_deg:.0f}°; grey: less than half in sight"
    look = figures.layout(
        dark, title, 420, shapes=shadows, margin=_MARGIN,
        xaxis=figures.axis("Ground range (m)", dark, range=[0, float(ground[-1])]),
        yaxis=figures.axis("Height (m)", dark, range=[-1.3 * limit_m, top]),
    )  # fmt: skip
    return figures.figure(data, look, figures.CONFIG)


class Content(NamedTuple):
    """What a view says: a line, images, figures under their words, and of which things which one was chosen."""

    words: str
    images: Sequence[Image] = ()
    figures: Sequence[tuple[str, str]] = ()
    choices: Mapping[str, str] = {}
    chosen: str | None = None


class FiguresPanel:
    """Figures of the report. draw: gives `Content` of a source and a turn, or of a folder, with what is chosen and
    whether the page is dark. label: of the choice."""

    def __init__(self, view: SeeView, draw: Callable[..., Content], label: str = "") -> None:
        self._view, self._draw = view, draw
        self._folder: Path | None = None
        self._said = ui.label().props("role=status").mark("view-words")
        self._choice = choice(label, "view-choice", self._chosen)
        self._choice.set_visibility(False)
        self._images = Images(columns=True)
        self._tiles = ui.element("div").classes("w-full grid gap-2 grid-cols-2 md:grid-cols-4")

    async def show(self, *of: Any) -> None:
        """Of a source's turn or of a folder. OSError, KeyError where it holds none."""
        drawn = await drawing.slow(self._draw, *of, self._choice.value, self._view.page.dark)
        self._said.set_text(drawn.words)
        self._choice.set_options(dict(drawn.choices), value=drawn.chosen)
        self._choice.set_visibility(bool(drawn.choices))
        self._images.show(drawn.images)
        self._tiles.clear()
        with self._tiles:
            for words, figure in drawn.figures:
                with tile(words)[1]:
                    ui.label(figure).classes("font-bold figure-value")

    async def show_folder(self, folder: Path) -> None:
        self._folder = folder
        await self.show(folder)

    def _chosen(self) -> None:
        if self._folder is None:
            self._view.redraw()
        else:
            self._view.draw_study(self.show(self._folder))


def view_by_range(source: Source, turn: int, _: None, dark: bool) -> Content:
    """Errors of a turn against range, where there is a true or a stated one, and what is in sight."""
    return Content("", draw_images(range_pictures({"": source.by_range(turn)}, source.expected()), dark))


def range_pictures(by_range: Mapping[str, curves.ByRange], law: Prospects | None = None) -> list[Picture]:
    """Of one run, beside what its design was likely to do, or of several by name."""
    floors, laws = [], []
    if law is not None:
        if law.ahead is not None:
            profile = law.ahead.profile["height_error"]
            floors.append(curves.Curve("expected before the run", law.ahead_ground_m, profile))
        floors.append(curves.Curve("noise of one dwell alone", law.ground_m, law.noise_error_m))
        laws = curves.analytic_shares(law.ground_m, law.smith, law.wagner)
    errors = Picture(
        "error_by_range",
        "Height error against range",
        "Graphs of height error, what is stated of it, and bias against ground range.",
        "Of cells more than half in sight, in bins of 10 m.",
        lambda: curves.draw_errors(by_range, floors, "Ground range (m)"),
    )
    shares = Picture(
        "share_by_range",
        "Share of the sea in sight",
        "Share of the sea in sight of both antennas and of cells with a height against ground range.",
        "Smith, Wagner: closed forms for a sea of normally distributed slopes." if laws else "",
        lambda: curves.draw_shares([*laws, *curves.run_shares(by_range)]),
    )
    known = any(np.isfinite(value).any() for each in by_range.values() for value in (each.rms, each.stated))
    return [errors, shares] if known else [shares]


def turn_csv(source: Source, azimuth_deg: float, index: int) -> str:
    """The section along a look and the errors by range of a turn; a table below the other, each with its heading."""
    section, by_range = source.section(azimuth_deg, index), source.by_range(index)
    columns = (section.ground_m, section.true, section.visible, section.placed_m, section.retrieved, section.spread)
    return csv_text([
        [f"section along {section.azimuth_deg:.2f} degrees; {turn_name(source.results.turns()[index])}"],
        ["ground_range_m", "true_height_m", "visible_fraction", "placed_at_m", "height_m", "height_std_m"],
        *_rows(columns),
        [],
        ["errors by ground range, cells more than half visible"],
        ["ground_range_m", "rms_m", "bias_m", "stated_m", "visible_fraction", "answered_fraction"],
        *_rows((by_range.centre_m, by_range.rms, by_range.bias, by_range.stated, by_range.visible, by_range.answered)),
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


_TURN = ("height", "height_std", "seen_time", "quality", "seen_true_height", "seen_cell_height")
_FIGURES = (  # of `judge_one`: words, unit, digits
    ("correlation", "Correlation with the wire", "", 3),
    ("rms_error_m", "Error, rms", "m", 3),
    ("stated_error_m", "Error that is stated", "m", 3),
    ("bias_m", "Bias", "m", 3),
    ("averaging_rms_m", "Of that by averaging over cells", "m", 3),
    ("hs_wire_m", "Wave height by the wire", "m", 2),
    ("hs_retrieved_m", "Wave height by the map", "m", 2),
    ("answered", "Turns with a height", "%", 0),
)


def has_gauges(results: Results) -> bool:
    """Whether a run writes, or wrote, what gauges read."""
    path = results.folder / "gauges.nc"
    return path.exists() or any(results.folder.glob(f".{path.name}*"))


def read_gauges(results: Results) -> xr.Dataset:
    """All whole turns (schema `gauges`), also while they grow. OSError where there are none yet."""
    return read_whole_turns(results.folder / "gauges.nc", _read)


def _read(file: GrowingFile) -> xr.Dataset:
    def values(name: str) -> np.ndarray[Any, Any]:
        return np.asarray(file.array(name)[:])

    names = [each.decode("utf-8", "replace") if isinstance(each, bytes) else str(each) for each in values("gauge")]
    variables: dict[str, Any] = {name: (("gauge", "turn"), values(name)) for name in _TURN if name in file}
    variables |= {name: (("gauge",), values(name)) for name in ("east", "north")}
    if "true_height" in file:
        variables["true_height"] = ("gauge", "sample"), values("true_height")
    coordinates = {"gauge": names, "turn": values("turn"), "time": (("sample",), values("time"))}
    return xr.Dataset(variables, coordinates)


def view_gauge(source: Source, turn: int, chosen: str | None, dark: bool) -> Content:
    """What there is up to a turn of the gauge that is chosen, else of the first."""
    if not has_gauges(source.results):
        return Content(
            "This run has no wave gauge. Press “Add wave gauge” at the end of the form in Design, say where it stands, "
            "and run the design: its record of the surface is held against the map there."
        )
    read = read_gauges(source.results)
    names = [str(each) for each in read["gauge"].values]
    name = chosen if chosen in names else names[0]
    gauge = read.sel(gauge=name)
    east, north = (float(gauge[each]) for each in ("east", "north"))
    place = f"At {np.hypot(east, north):.0f} m, {np.degrees(np.arctan2(east, north)) % 360.0:.0f}°."
    picture = gauge_picture(names.index(name), name, gauge, source.results.turns()[turn])
    judged, figures = judge_one(gauge), []
    for key, words, unit, digits in _FIGURES:
        value = float(judged[key]) * (100.0 if unit == "%" else 1.0)
        figures.append((words, f"{number(value, digits)} {unit}".strip()))
    return Content(
        place, draw_images([replace(picture, name="gauge")], dark), figures, {each: each for each in names}, name
    )


PICTURES = {  # that the sea on file has, with what they show
    "from_mast.png": "The sea from the mast, rendered with the sun's light",
    "sea_surface.png": "The sea from above",
    "sea.gif": "The sea in motion",
    "directional_spectrum.png": "Its spectrum by frequency and direction",
}
_MOST_TEXT = 20_000


def read_shadowing(folder: Path) -> xr.Dataset:
    """Of a finished study. OSError where there is none."""
    path = folder / "shadowing.nc"
    with open_dataset(path) as opened:
        return load(opened, path.name, path)


def view_shadowing(folder: Path, chosen: str | None, dark: bool) -> Content:
    """A study in words, and its figure for a look. OSError, KeyError where there is none."""
    data, look = read_shadowing(folder), chosen or "all looks"
    picture = Picture(
        "shadowing",
        "Visible share of the sea",
        f"Visible share of the sea against ground range for each mast, {LOOK_WORDS[look]}, beside the curves of Smith "
        "and Wagner; and the range beyond which half is hidden, by the look.",
        "Smith, Wagner: closed forms for a sea of normally distributed slopes.",
        lambda: draw_shadowing(data, (look,)),
    )
    return Content(in_words(data, look), draw_images([picture], dark), choices=LOOK_WORDS, chosen=look)


def in_words(data: xr.Dataset, look: str) -> str:
    """Where half of the sea is hidden, mast by mast."""
    parts = []
    for height in data["height"].values:
        mast = data.sel(height=height, look=look)
        half, smith = float(mast["look_r50"]), float(mast["look_r50_smith"]) if "look_r50_smith" in mast else np.nan
        where = f"beyond {half:.0f} m" if np.isfinite(half) else f"nowhere up to {float(data['range'][-1]):.0f} m"
        beside = [("Smith", smith)]
        if "look_radar_r50" in mast:
            radar = mast["look_radar_r50"].sel(level=SEEN_DB)
            beside = [
                (str(each), float(radar.sel(polarization=each))) for each in radar["polarization"].values
            ] + beside
        known = ", ".join(f"{name} {to:.0f} m" for name, to in beside if np.isfinite(to))
        parts.append(f"{height:g} m: {where}" + (f" ({known})" if known else ""))
    level = f" VV and HH: where {SEEN_DB:g} dB are left of its power." if "level" in data else ""
    return f"Half of the sea is hidden, {LOOK_WORDS.get(look, look)}, from a mast of {'; '.join(parts)}.{level}"


RangePanel = partial(FiguresPanel, draw=view_by_range)
GaugePanel = partial(FiguresPanel, draw=view_gauge, label="Wave gauge")
ShadowingPanel = partial(FiguresPanel, draw=view_shadowing, label="Look")


class PicturedPanel:
    """Pictures one below the other, then what was counted."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._place = ui.column().classes("w-full min-w-0 gap-3").mark("pictures")

    async def show_folder(self, folder: Path) -> None:
        """Of a folder below the runs."""
        name = folder.relative_to(self.view.page.server.roots.runs).as_posix()
        there = [each for each in PICTURES if (folder / each).is_file()]
        text = await asyncio.to_thread(_text, folder / "statistics.txt")
        self._place.clear()
        with self._place:
            if not there and not text:
                ui.label("No picture is here yet.").classes("text-sm")
            for each in there:
                ui.label(PICTURES[each]).classes("font-bold")
                stamp = (folder / each).stat().st_mtime_ns  # so that no older picture is shown
                shown = ui.element("img").classes("max-w-full")
                shown.props["src"], shown.props["alt"] = f"{address(name, each)}?at={stamp}", PICTURES[each]
            if text:
                ui.label(text).classes("w-full text-xs font-mono whitespace-pre overflow-x-auto").props("tabindex=0")


def _text(path: Path) -> str:
    try:
        with open_file(path) as file:
            return file.read(_MOST_TEXT).decode("utf-8", "replace")
    except (OSError, InputError):
        return ""
