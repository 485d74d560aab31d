"""The place where keys of the design are varied: a grid of runs in the queue, whose points arrive one by one.

A trade keeps the figures of its points, not their maps: the same scene with the same seed gives the same maps again.
"""

from __future__ import annotations

import asyncio
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from nicegui import events, ui

from ..errors import InputError
from ..io.opening import load, open_dataset, read_json
from ..io.process import duration
from ..io.scenefile import apply_overrides
from ..report import style
from ..report.keys import words_of
from ..scene import Scene, scene_of
from ..studies.paired import MOST_SEEDS
from ..studies.point import MANIFEST
from ..studies.trade_table import SHOWN, percent
from ..studies.vary import parse_varies, parse_vary, refuse_limit
from . import drawing
from .draft import Field, parts_of
from .folders import Roots, find_runs, safe_name
from .maps_panel import point_of
from .page import Page, choice, flat_button
from .prospects import run_seconds
from .runs_view import offer_products

MEASURES = {name: SHOWN[name][0] for name in ("fully_measured_radius_m", "reach_m", "missed_share", "height_rmse_m")}
_MOST_FILES = 20_000


@dataclass(frozen=True)
class Point:
    """One point: the varied keys' values, its seed, how it ended and its figures."""

    keys: dict[str, Any]
    seed: int
    status: str
    reason: str
    metrics: dict[str, float]


def read_points(folder: Path) -> list[Point]:
    """What is there of a trade's points. Files that are not whole are left out."""
    found = []
    for path in sorted((folder / "points").glob("*.json"))[:_MOST_FILES]:
        try:
            content = read_json(path, below=folder)
            metrics = {k: float(v) for k, v in (content.get("metrics") or {}).items() if isinstance(v, int | float)}
            keys, seed, status = dict(content["keys"]), int(content["seed"]), str(content["status"])
            found.append(Point(keys, seed, status, str(content.get("reason", "")), metrics))
        except (OSError, ValueError, TypeError, KeyError, AttributeError):
            continue
    return found


def numeric_fields(scene: Scene) -> list[Field]:
    """The keys of a scene that are numbers, which can be varied in steps."""
    tree = scene.model_dump(mode="python")
    return [field for part in parts_of(tree) for field in part.fields if field.kind == "number"]


def command_words(vary: list[str], seeds: int, at_most: float | None = None) -> list[str]:
    """The command's words for what is varied. InputError, as the command line says it, for what cannot be."""
    varied = parse_varies(vary)
    refuse_limit(varied, at_most)
    if not 1 <= seeds <= MOST_SEEDS:
        raise InputError(f"--seeds {seeds}: must be 1 to {MOST_SEEDS}")
    limit = [] if at_most is None else ["--at-most", f"{at_most:g}"]
    return [word for each in vary for word in ("--vary", each)] + ["--seeds", str(seeds), *limit]


def advice(folder: Path) -> str:
    """What a trade that has ended recommends, as its own page says it; empty before."""
    from ..studies.choices import recommendations

    path = folder / "trade.nc"
    try:
        with open_dataset(path, below=folder) as opened:
            table = load(opened, path.name, path)
            return ". ".join(line[0].upper() + line[1:] for line in recommendations(table))
    except (OSError, ValueError, KeyError):
        return ""


def count_of(vary: list[str], seeds: int) -> int:
    """Points that a trade has."""
    return int(np.prod([len(parse_vary(each)[1]) for each in vary])) * seeds


def value_of(point: Point, measure: str) -> float:
    """The measure in the unit of its label; infinite where the point has none."""
    return percent(measure) * point.metrics.get(measure, float("inf"))


def graph(points: list[Point], measure: str, dark: bool) -> drawing.Figure | None:
    """The measure against the first key, a curve for each value of the others: means over seeds, and every seed.

    None where no point has it yet.
    """
    done = [each for each in points if each.status == "done" and measure in each.metrics]
    keys = list(done[0].keys) if done else []
    if not keys:
        return None
    first, others = keys[0], {key: words_of(key) for key in keys[1:]}
    curves: dict[tuple[str, ...], dict[Any, list[float]]] = {}
    for each in done:
        name = tuple(f"{words.name} {words.value(each.keys[key])}" for key, words in others.items())
        curves.setdefault(name, {}).setdefault(place_of(each.keys[first]), []).append(value_of(each, measure))
    data: list[drawing.Figure] = []
    for number, (name, values) in enumerate(sorted(curves.items())):
        colour = style.FAMILY[number % len(style.FAMILY)]
        places = sorted(values, key=lambda each: (isinstance(each, str), each))
        label = ", ".join(name) or "mean over seeds"
        mean = [float(np.mean(values[place])) for place in places]
        data.append({
            "type": "scatter", "mode": "lines+markers", "x": places, "y": drawing.json_numbers(mean),
            "name": drawing.text(label), "line": {"color": colour}, "marker": {"size": 9},
        })  # fmt: skip
        data.append({
            "type": "scatter", "mode": "markers", "x": [place for place in places for _ in values[place]],
            "y": drawing.json_numbers([each for place in places for each in values[place]]), "name": "one seed",
            "hoverinfo": "x+y+name", "showlegend": False, "marker": {"color": colour, "size": 6, "opacity": 0.5},
        })  # fmt: skip
    look = drawing.layout(
        dark, "", 420, hovermode="closest", margin={"l": 56, "r": 10, "t": 10, "b": 70},
        xaxis=drawing.axis(words_of(first).label, dark),
        yaxis=drawing.axis(MEASURES[measure], dark, rangemode="tozero"),
    )  # fmt: skip
    return drawing.figure(data, look, drawing.CONFIG)


def place_of(value: Any) -> Any:
    """Where a value stands on a graph's axis: a number, or words."""
    return value if isinstance(value, int | float) and not isinstance(value, bool) else drawing.text(str(value))


def scene_of_point(folder: Path, point: Point, roots: Roots) -> Scene:
    """The scene that the trade ran at a point. InputError where the trade's own scene cannot be read, or is refused."""
    try:
        manifest: Any = read_json(folder / MANIFEST, below=folder)
        tree = tomllib.loads(str(manifest["scene"]))
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        raise InputError(f"{folder.name}: its {MANIFEST} cannot be read; the point cannot be run again") from None
    whole = apply_overrides(tree, {**point.keys, "seed": point.seed})
    roots.check_files(whole)
    return scene_of(whole)


def folder_of_point(trade: str, point: Point) -> str:
    """Where a run of a point goes: beside the trade, by its values and its seed."""
    values = "_".join(f"{key.rsplit('.', 1)[-1]}={value}" for key, value in point.keys.items())
    return f"{trade}_{safe_name(values, 'point')}_seed={point.seed}"


def words_of_point(point: Point) -> str:
    """A point in words: its values with their units, and its seed."""
    values = ", ".join(
        f"{words_of(key).name} {value} {words_of(key).unit}".strip() for key, value in point.keys.items()
    )
    return f"{values}, seed {point.seed}"


_LOOK_S = 1.0
_FIRST = "radar.height_m"


class TradeView:
    """What is varied above, what came of it below."""

    def __init__(self, page: Page) -> None:
        self.page, self.tab = page, page.tab
        self._points: list[Point] = []
        self._count = -1
        ui.label("Vary keys of the design that stands in Design, and see what they are worth").classes("font-bold")
        with ui.row().classes("w-full items-end gap-2"):
            self._keys = [self._make_key(number) for number in range(2)]
            self._seeds = ui.number("Seeds", value=3, min=1, max=MOST_SEEDS, precision=0, on_change=self._recount)
            self._seeds.props("dense outlined").classes("w-20").mark("seeds")
            self._at_most = ui.number("Recommend at most", on_change=self._recount).mark("at-most")
            self._at_most.props("dense outlined clearable").classes("w-40")
            ui.button("Run all points", icon="query_stats", on_click=self._queue_trade).props("no-caps").mark("trade")
        self._status = ui.label().classes("text-sm").props("role=status").mark("trade-status")
        with ui.row().classes("w-full items-center gap-2"):
            self._choice = choice("Trade", "trade-choice", self._refresh)
            self._measure = choice("Measure", "trade-measure", self._refresh, MEASURES, value=next(iter(MEASURES)))
            with flat_button("Download", icon="download"):
                self._menu = ui.menu()
        self._plot = ui.plotly(drawing.empty_figure(page.dark)).classes("w-full").mark("trade-graph")
        self._plot.on("plotly_click", self._choose_clicked, args=["points"])
        self._note = ui.label().classes("text-xs opacity-80")
        with ui.row().classes("w-full items-center gap-2") as self._chosen_row:
            self._point = choice("Point", "trade-point", self._show_chosen, width="wide")
            self._maps = ui.button("Run this point", icon="map", on_click=self._open_maps)
            self._maps.props("no-caps dense").mark("trade-maps")
            flat_button("Use these values in Design", icon="edit", on_click=self._apply_to_design, mark="trade-design")
        self._point_status = ui.label().classes("text-sm").props("role=status").mark("trade-point-status")
        ui.timer(_LOOK_S, self._look)

    def _make_key(self, number: int) -> Any:
        scene = self.tab.draft.scene
        options = {field.key: f"{field.label} · {field.key}" for field in numeric_fields(scene)} if scene else {}
        value = _FIRST if number == 0 and _FIRST in options else None
        label = "Vary" if number == 0 else "and, if wanted"
        key = ui.select(options, label=label, value=value, with_input=True, clearable=True, on_change=self._recount)
        key.props("dense outlined options-dense").classes("w-72 max-w-full").mark(f"vary-{number}")
        values = ui.input("Values: from:to:step, or a,b,c", value="4:10:2" if value else "", on_change=self._recount)
        values.props("dense outlined debounce=300").classes("w-56 max-w-full").mark(f"values-{number}")
        return key, values

    async def enter(self) -> None:
        """Look for trades again."""
        self._count = -1
        self._recount()
        entries = await asyncio.to_thread(find_runs, self.page.server.roots.runs)
        names = [entry.name for entry in entries if entry.kind == "trade"]
        queued = [job.folder for job in self.page.server.queue.jobs() if job.words[0] == "trade"]
        names = list(dict.fromkeys([*queued, *names]))
        wanted = self.tab.trade or self._choice.value
        chosen = wanted if wanted in names else next(iter(names), None)
        self.tab.trade = ""
        self._choice.set_options({name: name for name in names}, value=chosen)
        await self._look()

    # ----------------------------------------------------------------------------------------------- asking

    def _words(self) -> tuple[list[str], list[str], float]:
        """What is varied, the command's words, and how long it is guessed to take [s]; says that, and how many points
        it is. Raises InputError, ValueError where it is none."""
        scene, pace = self.tab.draft.scene, self.page.server.queue.pace("trade")
        vary = [f"{key.value}={values.value.strip()}" for key, values in self._keys if key.value and values.value]
        seeds = int(self._seeds.value or 0)
        words = command_words(vary, seeds, self._at_most.value)
        if not vary:
            raise InputError("Choose a key, and its values in the units of the scene file.")
        points = count_of(vary, seeds)
        guess_s = points * run_seconds(scene) / 2.0 if scene is not None else 0.0
        if scene is None:
            self._status.set_text(f"{points} points")
        elif pace is None:
            self._status.set_text(f"{points} points; guessed to take {duration(guess_s)} (no trade was run here)")
        else:
            self._status.set_text(f"{points} points, about {duration(guess_s * pace)}")
        return vary, words, guess_s

    def _recount(self) -> None:
        """How many points that is, or why it is none."""
        try:
            self._words()
        except (InputError, ValueError) as refusal:
            self._status.set_text(str(refusal))

    def _queue_trade(self) -> None:
        scene, server = self.tab.draft.scene, self.page.server
        try:
            if scene is None:
                raise InputError("The design does not stand yet: mend in Design what is marked.")
            vary, words, guess_s = self._words()
        except (InputError, ValueError) as refusal:
            self._status.set_text(str(refusal))
            return
        folder = server.free_folder(f"{scene.name}-trade")
        words = ["trade", "{scene}", *words, "--out", "{out}"]
        server.queue.add(", ".join(vary), folder, scene.to_toml(), words, guess_s)
        self._choice.set_options({folder: folder, **dict(self._choice.options)}, value=folder)
        self._count = -1
        self._status.set_text(f"Queued as {folder}: its points appear below.")

    # ---------------------------------------------------------------------------------------------- showing

    async def _refresh(self) -> None:
        self._count = -1
        await self._look()

    async def _look(self) -> None:
        name = self._choice.value
        if self.tab.place != "Trade":
            return
        if not name:
            self._note.set_text("No trade yet: choose a key and its values, and press Run all points.")
            self._plot.set_visibility(False)
            self._chosen_row.set_visibility(False)
            return
        folder = self.page.server.roots.runs / str(name)
        points = await asyncio.to_thread(read_points, folder)
        job = self.page.server.queue.job_of_folder(str(name))
        if job is not None and not job.is_over:
            self._status.set_text(self.page.server.queue.progress(job).line)
        elif job is not None and job.reason:
            self._status.set_text(f"{job.state}: {job.reason}")
        if len(points) == self._count:
            return
        self._count, self._points = len(points), points
        made = graph(points, str(self._measure.value), self.page.dark)
        self._plot.set_visibility(made is not None)
        if made is not None:
            self._plot.update_figure(made)
        text = await asyncio.to_thread(advice, folder)
        self._note.set_text(" ".join([text + "." if text else "", _points_in_words(points)]).strip())
        done = {i: words_of_point(each) for i, each in enumerate(points) if each.status == "done"}
        self._chosen_row.set_visibility(bool(done))  # to be chosen by the keyboard too
        self._point.set_options(done, value=self._point.value if self._point.value in done else next(iter(done), None))
        self._show_chosen()
        self._menu.clear()
        with self._menu:
            offer_products(folder, name)

    # ------------------------------------------------------------------------------------------------ one point

    def _choose_clicked(self, event: events.GenericEventArguments) -> None:
        """A point of the graph becomes the chosen one: of several seeds the one that is nearest to what was clicked."""
        pointed = point_of(event)
        if pointed is None:
            return
        (place, value), measure = pointed, str(self._measure.value)
        there = {
            i: value_of(each, measure)
            for i, each in enumerate(self._points)
            if each.status == "done" and place_of(next(iter(each.keys.values()))) == place
        }
        if there:
            self._point.value = min(there, key=lambda i: abs(there[i] - value))
            self._show_chosen()

    @property
    def _chosen_point(self) -> Point | None:
        number = self._point.value
        return self._points[number] if isinstance(number, int) and number < len(self._points) else None

    def _show_chosen(self) -> None:
        """What can be done with it."""
        point, trade = self._chosen_point, str(self._choice.value)
        if point is None:
            self._point_status.set_text("")
            return
        there = self.page.server.is_awaited(folder_of_point(trade, point))
        self._maps.set_text("See its maps" if there else "Run this point")
        self._point_status.set_text(
            "Its maps are there, or come." if there else
            "A trade keeps the figures of its points, not their maps. Run this point: the same scene with the same "
            "seed gives the same maps, and they open here turn by turn."
        )  # fmt: skip

    def _open_maps(self) -> None:
        """Show the maps of a run of the point: the one that is there, else one that is queued now."""
        point, trade, server = self._chosen_point, str(self._choice.value), self.page.server
        if point is None:
            return
        name = folder_of_point(trade, point)
        if not server.is_awaited(name):
            try:
                scene = scene_of_point(server.roots.runs / trade, point, server.roots)
            except InputError as refusal:
                self._point_status.set_text(str(refusal))
                return
            title = f"{trade}: {words_of_point(point)}"
            server.queue.add(title, name, scene.to_toml(), ["run", "{scene}", "--out", "{out}"], run_seconds(scene))
        self.page.see(name)

    def _apply_to_design(self) -> None:
        """The design with the point's values."""
        point = self._chosen_point
        if point is None:
            return
        for key, each in point.keys.items():
            self.tab.draft.set(key, each)
        self.page.go("Design")
        self.page.redraw_design()


def _points_in_words(points: list[Point]) -> str:
    done = sum(each.status == "done" for each in points)
    refused = next((each.reason for each in points if each.status != "done"), "")
    text = f"{done} points are there. Click one, or choose it below, to see its maps or take its values."
    return text + (f" {len(points) - done} came to nothing, as: {refused}" if refused else "")
