"""The place where two runs are held against each other: figures, maps on one scale, whose errors are less by more than
chance."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from nicegui import ui
from numpy.typing import NDArray
from scipy.special import stdtrit

from ..conventions import turn_name
from ..metrics import BIN_M, HEADLINE_M, counts
from ..report.page_elements import draw_images
from . import drawing
from .draft import flatten
from .drawing import MapPanels, Panel, ground_raster
from .folders import find_runs
from .maps_panel import MapsPanel
from .page import Image, Images, Page, choice, count_on, flat_button, make_stage, number, slider, tile
from .panels import errors_by_range, range_pictures
from .source import Results, Source, error_scale

Array = NDArray[np.floating]
_SLOTS, _SECTORS, _FEWEST = 24, 12, 4  # of azimuth


_MOST_TURNS, _MOST_KEYS = 40, 8


_FIGURES = (  # where it stands in metrics.json, words, unit, digits
    ("measured.reach_m", "Measures waves out to", "m", 0),
    ("measured.fully_measured_radius_m", "Fully measured radius", "m", 0),
    ("overall.height_rmse_m", "Height error, rms", "m", 3),
    ("overall.height_robust_m", "Height error, robust", "m", 3),
    ("overall.height_bias_m", "Height bias", "m", 3),
    ("overall.height_correlation", "Correlation with the sea", "", 3),
    ("measured.missed_share", "Cells missed", "", 2),
    ("overall.hs_true_m", "True wave height", "m", 2),
    ("overall.hs_retrieved_m", "Wave height by the maps' spread", "m", 2),
    ("facets", "Facets a turn", "", 0),
    ("run_s", "Wall time", "s", 1),
)


def figures_of(first: Mapping[str, Any], second: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What metrics.json says of both runs, in words: what it is with its unit, and its values."""
    made = []
    for key, words, unit, digits in _FIGURES:
        pair = _number(first, key), _number(second, key)
        if pair != (None, None):
            a, b = ("—" if each is None else number(each, digits) for each in pair)
            made.append((f"{words}{f' ({unit})' if unit else ''}", f"A {a} · B {b}"))
    return made


def _number(metrics: Any, key: str) -> float | None:
    for step in key.split("."):
        metrics = metrics.get(step) if isinstance(metrics, Mapping) else None
    return float(metrics) if isinstance(metrics, int | float) and not isinstance(metrics, bool) else None


def differences(first: Source, second: Source) -> str:
    """What the two were run with that is not the same: keys, seed, turns that they hold."""
    turns = tuple(len(each.results.turns()) for each in (first, second))
    scenes = [dict(flatten(each.scene.model_dump(mode="json"))) if each.scene else None for each in (first, second)]
    parts = [] if turns[0] == turns[1] else [f"turns (A {turns[0]}, B {turns[1]})"]
    a, b = scenes
    if a is None or b is None:
        return f"Differ in: {', '.join([*parts, 'perhaps more, since the scene of one is not known'])}."
    keys = [key for key in {**a, **b} if a.get(key) != b.get(key) and key not in ("title", "turns")]
    parts += [f"{key} (A {a.get(key, '—')}, B {b.get(key, '—')})" for key in keys[:_MOST_KEYS]]
    parts += [f"{len(keys) - _MOST_KEYS} keys more"] if len(keys) > _MOST_KEYS else []
    return f"Differ in: {', '.join(parts)}." if parts else "The same scene with the same seed."


class RangeVerdict(NamedTuple):
    """rms errors [m] of both in one range, and how far chance alone may move their ratio: a factor, NaN where there is
    too little to tell."""

    range_m: tuple[float, float]
    first: float
    second: float
    chance: float

    @property
    def verdict(self) -> str:
        """The verdict on B, where the difference is more than chance."""
        if not np.isfinite(self.first + self.second):
            return "in one of them alone"
        if not np.isfinite(self.chance):
            return "too little to tell"
        worse, better = self.second > self.chance * self.first, self.chance * self.second < self.first
        return "▼ B worse" if worse else "▲ B better" if better else "within chance"


def squares(source: Source) -> tuple[Array, Array]:
    """Ranges' lower ends (range,) [m] of 25 m each, and what is counted there: cells, and the sum of the squares of
    their errors of height [m²], (15° of azimuth, range, 2). Of cells as metrics.json counts them, of 40 turns at most.

    OSError, KeyError where there is no true sea to err from.
    """
    field, layout = source.results.field, source.layout
    place = np.floor(layout.range / BIN_M).astype(np.intp)
    place -= place[0]
    sums = np.zeros((_SLOTS, place[-1] + 1, 2))
    slot = np.floor(layout.azimuth % 360.0 * (_SLOTS / 360.0)).astype(np.intp) % _SLOTS
    at = slot[:, None], place[None, :]
    turns = len(source.results.turns())
    for turn in np.unique(np.linspace(0, turns - 1, min(turns, _MOST_TURNS)).astype(int)):
        error = field("maps/polar/height", turn) - field("truth/polar/height", turn)
        counted = counts(error, field("maps/polar/quality", turn), field("truth/polar/visible_fraction", turn))
        np.add.at(sums[..., 0], at, counted)
        np.add.at(sums[..., 1], at, np.where(counted, error, 0.0).astype(np.float64) ** 2)
    return np.floor(layout.range[0] / BIN_M) * BIN_M + BIN_M * np.arange(sums.shape[1]), sums


def judge(first: tuple[Array, Array], second: tuple[Array, Array]) -> list[RangeVerdict]:
    """`squares` of both: first the headline's ranges, where they are seen, then range by range.

    The scatter of θ = ln(rms B / rms A) is the jackknife's over up to twelve sectors of azimuth that both see, all
    turns of a sector together, so that cells and turns of one wave count once. With θᵢ that without sector i of n:
    σ² = (n − 1)/n Σ(θᵢ − θ̄)², times 1 + 2ρ for the correlation ρ > 0 of neighbours. For N independent cells of normal
    errors that is 1/(2N) of each run. Few sectors give σ a wide scatter: of a range it is at least the median of all.
    A difference is more than chance beyond t σ, with Student's t of n − 2, one for θ̄ and one for ρ: 2.5 % for the
    headline and 2.5 % for all ranges together (Bonferroni). Sectors of one long crest, as of a regular wave, are not
    independent.
    """
    start = np.union1d(first[0], second[0])
    both = np.zeros((2, _SLOTS, start.size, 2))
    for into, (ends, sums) in zip(both, (first, second), strict=True):
        into[:, np.searchsorted(start, ends)] = sums
    there = both[..., 0].any(axis=(0, 1))
    start, both = start[there], both[:, :, there]
    headline = np.flatnonzero((start >= HEADLINE_M[0]) & (start < HEADLINE_M[1]))
    ranges = [np.array([each]) for each in range(start.size)]
    scatters = [_scatter(both[:, :, of].sum(axis=2)) for of in ranges]
    known = [sigma for sigma, _ in scatters if np.isfinite(sigma)]
    floor = float(np.median(known)) if known else 0.0
    tested = [(of, max(sigma, floor), n, len(ranges)) for of, (sigma, n) in zip(ranges, scatters, strict=True)]
    if headline.size:
        tested.insert(0, (headline, *_scatter(both[:, :, headline].sum(axis=2)), 1))
    verdicts = []
    for of, sigma, n, tests in tested:
        cells, square = np.moveaxis(both[:, :, of].sum(axis=(1, 2)), -1, 0)
        a, b = np.sqrt(np.divide(square, cells, out=np.full(2, np.nan), where=cells > 0.0))
        chance = np.exp(stdtrit(n - 2, 1.0 - 0.0125 / tests) * sigma) if np.isfinite(sigma) else np.nan
        verdicts.append(
            RangeVerdict((float(start[of][0]), float(start[of][-1]) + BIN_M), float(a), float(b), float(chance))
        )
    return verdicts


def _scatter(sums: Array) -> tuple[float, int]:
    """σ of θ, NaN where there is too little to tell, and of how many sectors. sums: (run, slot, 2)."""
    seen = np.flatnonzero((sums[:, :, 0] > 0.0).all(axis=0))
    n = min(_SECTORS, seen.size)
    if n < _FEWEST:
        return float("nan"), n
    sectors = np.stack([sums[:, part].sum(axis=1) for part in np.array_split(seen, n)], axis=1)
    cells, square = np.moveaxis(sectors.sum(axis=1, keepdims=True) - sectors, -1, 0)
    if not (square > 0.0).all():
        return float("nan"), n
    off = 0.5 * np.diff(np.log(square / cells), axis=0)[0]
    off -= off.mean()
    spread = float(np.sum(off**2))
    near = (
        float(np.sum(off * np.roll(off, 1))) / spread + 1.0 / (n - 1) if spread else 0.0
    )  # about −1/(n − 1) by chance
    return float(np.sqrt((n - 1) / n * spread * (1.0 + 2.0 * max(0.0, near)))), n


def describe(verdicts: Sequence[RangeVerdict]) -> str:
    """What is better where, in a line or two."""
    first, *ranges = verdicts
    words = {"▲ B better": "B better", "▼ B worse": "B worse"}.get(first.verdict, "no difference beyond chance")
    by = "" if not np.isfinite(first.chance) else f"; chance alone makes {chance_in_words(first.chance)}"
    line = f"{_span(first)}: {words} (A {first.first:.3f} m, B {first.second:.3f} m rms{by})."
    for verdict, name in (("▲ B better", "better"), ("▼ B worse", "worse")):
        held = [_span(each) for each in ranges if each.verdict == verdict]
        line += f" B is {name} at {', '.join(held)}." if held else ""
    return line


def chance_in_words(factor: float) -> str:
    if not np.isfinite(factor):
        return "—"
    return "more than 300 %" if factor > 4.0 else f"{100.0 * (factor - 1.0):.0f} %"


def _span(judged: RangeVerdict) -> str:
    return f"{judged.range_m[0]:.0f}–{judged.range_m[1]:.0f} m"


class Comparison(NamedTuple):
    """What is shown of two: maps, curves, figures, what differs, and whose errors are less."""

    shown: MapPanels
    images: list[Image]
    figures: list[tuple[str, str]]
    differ: str
    judged: list[RangeVerdict]


def drawing_of(first: Source, second: Source, turn: int, names: tuple[str, str], dark: bool, whole: bool) -> Comparison:
    """What is shown of two. whole: with what is of all turns. OSError, IndexError where a run has no such turn."""
    errors = {name: errors_by_range(each, turn) for name, each in zip(names, (first, second), strict=True)}
    known = whole and first.results.has_truth and second.results.has_truth
    return Comparison(
        paired_panels(first, second, turn, names),
        draw_images(range_pictures(errors), dark),
        figures_of(first.results.metrics(), second.results.metrics()),
        differences(first, second),
        judge(squares(first), squares(second)) if known else [],
    )


def paired_panels(first: Source, second: Source, turn: int, names: tuple[str, str]) -> MapPanels:
    """Retrieved heights of both on one scale and, where the truth is known, both errors on another.

    turn: by its place, of both. OSError, IndexError where a run has no such turn.
    """
    one, other = (_fields(each, turn) for each in (first, second))
    x, y, cell = one["x"].values, one["y"].values, float(np.diff(other["x"].values[:2]).max(initial=0.0)) or 1.0
    both = one, other.reindex(x=x, y=y, method="nearest", tolerance=cell)
    raster = ground_raster(x, y, np.any([each["seen"].notnull() for each in both], axis=0))
    values = [each["height"].values for each in both]
    height = error_scale(np.stack(values), "Height (m)")
    panels = [Panel(f"{name}: retrieved height", height) for name in names]
    if all("error" in each for each in both):
        errors = [each["error"].values for each in both]
        error = error_scale(np.stack(errors), "Error (m)")
        panels += [Panel(f"{name}: error", error, 3) for name in names]
        values += errors
    return MapPanels.of(panels, raster, values)


def _fields(source: Source, turn: int) -> xr.Dataset:
    field, over = source.results.field, ("y", "x")
    height = field("maps/ground/height", turn)
    found = {"height": (over, height), "seen": (over, field("maps/ground/time", turn))}
    if source.results.has_truth:
        found["error"] = over, height - field("truth/ground/height", turn)
    return xr.Dataset(found, {"x": source.layout.x, "y": source.layout.y})


_COLUMNS = [
    {"name": name, "label": label, "field": name, "align": "left"}
    for name, label in (
        ("range", "Range (m)"),
        ("a", "A: rms error (m)"),
        ("b", "B: rms error (m)"),
        ("verdict", "B against A"),
        ("chance", "Chance alone makes"),
    )
]


class CompareView:
    """Two runs, A and B: figures, maps on one scale, curves in one graph."""

    def __init__(self, page: Page) -> None:
        self.page, self.tab = page, page.tab
        self._sources: dict[str, Source] = {}
        self._shown: tuple[Any, ...] = ()
        with ui.row().classes("w-full items-center gap-2"):
            self._choices = [choice(label, f"compare-{label}", self._choose_runs) for label in "AB"]
            flat_button("Swap A and B", icon="swap_horiz", on_click=self._swap)
        self._status = ui.label().classes("text-sm").props("role=status")
        self._body, self._easel = make_stage()
        with self._body.classes("gap-2"):
            self._verdict = ui.label().classes("font-bold").mark("compared")
            self._table = ui.element("div").classes("w-full grid gap-2 grid-cols-2 md:grid-cols-4").mark("figures")
            self._ranges = ui.table(rows=[], columns=_COLUMNS, row_key="range").props("dense flat bordered")
            self._ranges.classes("w-full").mark("compared-ranges")
            with ui.row().classes("w-full items-center no-wrap gap-2"):
                self._turn = ui.label("Turn").classes("text-sm figure-value whitespace-nowrap")
                self._slider = slider("Turn", "compared-turn", self._redraw)
            self._maps = MapsPanel(page, lambda *_: None)
            self._images = Images(columns=True)
        self._body.set_visibility(False)

    async def enter(self) -> None:
        """Look for runs again, and draw those that are chosen."""
        self._shown = ()
        entries = await asyncio.to_thread(find_runs, self.page.server.roots.runs)
        names = [entry.name for entry in entries if entry.kind in ("run", "retrieval")]
        if len(names) < 2:
            self._status.set_text("Two runs are needed: run a design, change it, and run it again.")
            self._body.set_visibility(False)
            return
        if self.tab.run not in names:
            self.tab.run = names[0]
        if self.tab.other not in names or self.tab.other == self.tab.run:
            self.tab.other = next(name for name in names if name != self.tab.run)
        for each, value in zip(self._choices, (self.tab.run, self.tab.other), strict=True):
            each.set_options(names, value=value)
        self._redraw()

    async def _choose_runs(self) -> None:
        first, second = (str(each.value) for each in self._choices)
        if first == second:  # the other one: they change places
            first, second = self.tab.other, self.tab.run
        self.tab.run, self.tab.other = first, second
        await self.enter()

    async def _swap(self) -> None:
        self.tab.run, self.tab.other = self.tab.other, self.tab.run
        await self.enter()

    def _source(self, name: str) -> Source:
        if name not in self._sources or self._sources[name].results.growing:
            self._sources[name] = Source(Results(self.page.server.roots.run(name)))
        return self._sources[name]

    def _redraw(self) -> None:
        self._easel.ask(f"drawing {self.tab.run} and {self.tab.other} …", self._draw_both(), self._refuse)

    def _refuse(self, why: Exception) -> None:
        self._status.set_text(f"These two cannot be held against each other: {why}")
        self._body.set_visibility(False)

    async def _draw_both(self) -> None:
        names = (self.tab.run, self.tab.other)
        first, second = [await asyncio.to_thread(self._source, name) for name in names]
        count = min([len(await asyncio.to_thread(each.results.turns)) for each in (first, second)])
        turn = min(int(self._slider.value or 1), count) - 1
        key = (*names, self.page.dark)
        whole = key != self._shown
        made = await drawing.quick(drawing_of, first, second, turn, names, self.page.dark, whole)
        self._status.set_text(made.differ)
        self._body.set_visibility(True)
        count_on(self._slider, count)
        self._turn.set_text(turn_name(turn, count))
        if not whole:
            self._maps.frame(made.shown)
        else:
            self._shown = key
            self._maps.show(made.shown)
            self._fill_table(made.figures)
            self._fill_ranges(made.judged)
        self._images.show(made.images)

    def _fill_table(self, rows: list[tuple[str, str]]) -> None:
        self._table.clear()
        with self._table:
            if not rows:
                ui.label("Figures follow when both runs have ended.").classes("text-sm")
            for words, values in rows:
                with tile(words)[1]:
                    ui.label(values).classes("font-bold figure-value")

    def _fill_ranges(self, judged: list[RangeVerdict]) -> None:
        """Whose heights err less, range by range."""
        self._verdict.set_text(describe(judged) if judged else "Whose heights err less is not known: a true sea lacks.")
        self._ranges.set_visibility(bool(judged))
        self._ranges.rows = [
            {
                "range": f"{each.range_m[0]:.0f}–{each.range_m[1]:.0f}",
                "a": number(each.first, 3), "b": number(each.second, 3), "verdict": each.verdict,
                "chance": chance_in_words(each.chance),
            }
            for each in judged
        ]  # fmt: skip
