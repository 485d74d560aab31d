"""Parts of See: the section along a look, and the report's figures of errors by range and of a shadowing study."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr
from nicegui import ui
from numpy.typing import NDArray

from ..conventions import turn_name, wrap_degrees
from ..io.opening import load, open_dataset
from ..io.text import csv_text
from ..metrics import counts
from ..physics.shadowing import SEEN_DB
from ..report import curves, reduce, style
from ..report import maps as report_maps
from ..report.page_elements import Picture, draw_images
from ..studies.shadowing_figures import LOOK_WORDS, draw_shadowing
from . import drawing
from .drawing import Figure
from .page import Image, Images, choice, slider, tile
from .prospects import Prospects, prospects
from .source import Source

if TYPE_CHECKING:
    from .see_view import SeeView


Array = NDArray[np.float64]
_BIN_M, _FEWEST = 10.0, 8  # by range


@dataclass(frozen=True)
class Section:
    """Heights along a look; arrays (gate,) in m. placed_m: where the retrieval put its heights."""

    azimuth_deg: float
    ground_m: Array
    true: Array
    visible: Array
    placed_m: Array
    retrieved: Array
    spread: Array
    antenna_m: float

    @classmethod
    def of(cls, source: Source, azimuth_deg: float, index: int) -> Section:
        """The section of a turn along the look that is nearest to an azimuth."""
        results, ground = source.results, source.ground_m
        look = int(np.argmin(np.abs(wrap_degrees(source.layout.azimuth - azimuth_deg))))

        def read_look(name: str) -> Array:
            known = results.has_truth if name.startswith("truth/") else results.has_maps
            return results.field(name, index)[look].astype(np.float64) if known else np.full(ground.size, np.nan)

        placed = read_look("maps/polar/ground_range")
        return cls(
            azimuth_deg=float(source.layout.azimuth[look] % 360.0),
            ground_m=ground,
            true=read_look("truth/polar/height"),
            visible=read_look("truth/polar/visible_fraction"),
            placed_m=np.where(np.isfinite(placed), placed, ground),
            retrieved=read_look("maps/polar/height"),
            spread=read_look("maps/polar/height_std"),
            antenna_m=source.height_m,
        )

    def shadows(self) -> list[tuple[float, float]]:
        """Ground ranges between which less than half is in sight."""
        borders = reduce.edges(self.ground_m)
        dark = np.nan_to_num(self.visible, nan=1.0) < 0.5
        return [(float(borders[begin]), float(borders[end])) for begin, end in drawing.pieces(dark)]

    def rays(self) -> list[tuple[float, float]]:
        """Where rays over the crests meet the sea again: the first lit place behind each shadow, and its height."""
        ends = (int(np.searchsorted(self.ground_m, end)) for _, end in self.shadows())
        lit = (gate for gate in ends if gate < self.ground_m.size and np.isfinite(self.true[gate]))
        return [(float(self.ground_m[gate]), float(self.true[gate])) for gate in lit]


class SectionPanel:
    """The section, with the look to be chosen."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        with ui.row().classes("w-full items-center gap-2 no-wrap"):
            ui.label("Look").classes("text-sm")
            self.slider = slider("Azimuth of the look", "azimuth", self._turn_view, 0, 359, round(view.azimuth) % 360)
        self.plot = ui.plotly(drawing.empty_figure(view.page.dark)).classes("w-full").mark("section")

    def _turn_view(self) -> None:
        self.view.set_azimuth(float(self.slider.value or 0.0))

    async def show(self, source: Source, turn: int) -> None:
        made = await drawing.quick(section_graph, source, self.view.azimuth, turn, self.view.page.dark)
        self.plot.update_figure(made)


def section_graph(source: Source, azimuth_deg: float, turn: int, dark: bool) -> Figure:
    """True and retrieved height along a look, shadows in grey, the antenna and its rays over the crests."""
    section = Section.of(source, azimuth_deg, turn)
    heights = np.abs(np.concatenate([section.true, section.retrieved]))
    limit_m = max(float(np.nanmax(heights)) if np.isfinite(heights).any() else 1.0, 0.2)
    ground = section.ground_m
    order = np.argsort(section.placed_m)
    placed = section.placed_m[order]
    data: list[Figure] = []
    if np.isfinite(section.retrieved).any():
        middle, wide = section.retrieved[order], 1.96 * section.spread[order]
        data = [
            drawing.band(placed, middle - wide, middle + wide, "± 1.96 stated errors", style.VERMILION),
            drawing.line(placed, middle, "retrieved", style.VERMILION),
        ]
    if np.isfinite(section.true).any():
        data.insert(0, drawing.line(ground, section.true, "true", drawing.ink(dark)))
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
    look = drawing.layout(
        dark, title, 420, shapes=shadows, margin={"l": 50, "r": 10, "t": 30, "b": 66},
        xaxis=drawing.axis("Ground range (m)", dark, range=[0, float(ground[-1])]),
        yaxis=drawing.axis("Height (m)", dark, range=[-1.3 * limit_m, top]),
    )  # fmt: skip
    return drawing.figure(data, look, drawing.CONFIG)


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
        self._status = ui.label().props("role=status").mark("view-words")
        self._choice = choice(label, "view-choice", self._redraw)
        self._choice.set_visibility(False)
        self._images = Images(columns=True)
        self._tiles = ui.element("div").classes("w-full grid gap-2 grid-cols-2 md:grid-cols-4")

    async def show(self, *of: Any) -> None:
        """Show the figures of a source's turn, or of a folder. OSError, KeyError where it holds none."""
        drawn = await drawing.slow(self._draw, *of, self._choice.value, self._view.page.dark)
        self._status.set_text(drawn.words)
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

    def _redraw(self) -> None:
        if self._folder is None:
            self._view.redraw()
        else:
            self._view.draw_study(self.show(self._folder))


def _rms(values: Array) -> Any:
    return np.sqrt(np.nanmean(np.square(values)))


def _robust_spread(error: Array) -> Any:
    """1.4826 × the median absolute deviation, of what is known."""
    return reduce.MAD_TO_STD * np.nanmedian(np.abs(error - np.nanmedian(error)))


def errors_by_range(source: Source, index: int) -> curves.ByRange:
    """Errors of a turn by ground range, what it states of them, and how much is seen."""
    results, field = source.results, source.results.field
    blank = np.full((source.layout.azimuth.size, source.layout.range.size), np.nan)
    retrieved, stated, visible, error, slope, slope_stated = [blank] * 6
    if results.has_maps:
        retrieved, stated = (field(f"maps/polar/{name}", index) for name in ("height", "height_std"))
    counted = np.isfinite(retrieved)
    if results.has_truth:
        visible = field("truth/polar/visible_fraction", index)
        error = retrieved - field("truth/polar/height", index)
        flags = field("maps/polar/quality", index) if results.has_maps else np.zeros(blank.shape)
        counted = counts(error, flags, visible)
        if results.has_field("maps/polar/slope_range_std"):
            slope = field("maps/polar/slope_range", index) - field("truth/polar/slope_range", index)
            slope_stated = field("maps/polar/slope_range_std", index)
    error, stated, slope, slope_stated = (
        np.where(counted, each, np.nan) for each in (error, stated, slope, slope_stated)
    )
    edges = np.arange(0.0, source.ground_m[-1] + _BIN_M, _BIN_M)
    place = np.searchsorted(edges, source.ground_m, side="right") - 1

    def bin_values(values: NDArray[Any], of: Callable[[Array], Any] = np.nanmean) -> Array:
        held = [values[:, place == bin_] for bin_ in range(edges.size - 1)]
        return np.array([of(each) if np.isfinite(each).sum() >= _FEWEST else np.nan for each in held])

    return curves.ByRange(
        0.5 * (edges[1:] + edges[:-1]),
        bin_values(error, _rms),
        bin_values(error, _robust_spread),
        bin_values(error),
        bin_values(stated, np.nanmedian),
        bin_values(slope, _rms),
        bin_values(slope_stated, np.nanmedian),
        bin_values(visible),
        bin_values(1.0 * np.isfinite(retrieved)),
    )


def view_by_range(source: Source, turn: int, _: None, dark: bool) -> Content:
    """Errors of a turn against range, where there is a true or a stated one, and what is in sight."""
    expected = prospects(source.scene) if source.scene is not None else None  # by floors and closed forms
    return Content("", draw_images(range_pictures({"": errors_by_range(source, turn)}, expected), dark))


def range_pictures(by_range: Mapping[str, curves.ByRange], law: Prospects | None = None) -> list[Picture]:
    """Errors and shares of one run, beside what its design was likely to do, or of several runs by name."""
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
    section, errors = Section.of(source, azimuth_deg, index), errors_by_range(source, index)
    columns = (section.ground_m, section.true, section.visible, section.placed_m, section.retrieved, section.spread)
    return csv_text([
        [f"section along {section.azimuth_deg:.2f} degrees; {turn_name(source.results.turns()[index])}"],
        ["ground_range_m", "true_height_m", "visible_fraction", "placed_at_m", "height_m", "height_std_m"],
        *_rows(columns),
        [],
        ["errors by ground range, cells more than half visible"],
        ["ground_range_m", "rms_m", "bias_m", "stated_m", "visible_fraction", "answered_fraction"],
        *_rows((errors.centre_m, errors.rms, errors.bias, errors.stated, errors.visible, errors.answered)),
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


def read_shadowing(folder: Path) -> xr.Dataset:
    """The dataset of a finished study. OSError where there is none."""
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
    return Content(shadowing_in_words(data, look), draw_images([picture], dark), choices=LOOK_WORDS, chosen=look)


def shadowing_in_words(data: xr.Dataset, look: str) -> str:
    """Where half of the sea is hidden, mast by mast."""
    parts = []
    for height in data["height"].values:
        mast = data.sel(height=height, look=look)
        half, beside = float(mast["look_r50"]), {}
        where = f"beyond {half:.0f} m" if np.isfinite(half) else f"nowhere up to {float(data['range'][-1]):.0f} m"
        if "look_radar_r50" in mast:
            radar = mast["look_radar_r50"].sel(level=SEEN_DB)
            beside = dict(zip(radar["polarization"].values, radar.values, strict=True))
        if "look_r50_smith" in mast:
            beside["Smith"] = float(mast["look_r50_smith"])
        known = ", ".join(f"{name} {to:.0f} m" for name, to in beside.items() if np.isfinite(to))
        parts.append(f"{height:g} m: {where}" + (f" ({known})" if known else ""))
    level = f" VV and HH: where {SEEN_DB:g} dB are left of its power." if "level" in data else ""
    return f"Half of the sea is hidden, {LOOK_WORDS.get(look, look)}, from a mast of {'; '.join(parts)}.{level}"


RangePanel = partial(FiguresPanel, draw=view_by_range)
ShadowingPanel = partial(FiguresPanel, draw=view_shadowing, label="Look")
