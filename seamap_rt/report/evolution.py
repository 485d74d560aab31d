"""What changes from turn to turn: an animation of true and retrieved height, and a table of the turns.

A run of one turn has neither.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from PIL import Image

from ..conventions import turn_name
from ..metrics import HALF_VISIBLE, error_figures
from ..scene import Scene
from . import reduce, style
from .maps import draw_ground, height_limit, looked_at
from .page_elements import Picture, Table, digits, percent
from .reduce import Array
from .style import gif

MOST_BYTES = 2_200_000  # of the animation: inlined as text it is a third more, under 3 MB
MOST_FRAMES = 120
MOST_ROWS = 200
_LONGEST_S = 0.4  # that a frame is shown
_PIXELS = (760, 300)  # width of a frame: to begin with, and the least before turns are skipped instead
_COLOURS = 96
_BESIDE = 0.52, 0.3, 0.1  # inches left of the first panel, between panels, right of the second
_ABOVE, _BELOW = 0.44, 0.92  # inches, the colour bar's included


class Animation(NamedTuple):
    """An animation and what it shows."""

    data: bytes
    shown: int  # turns
    faster: float  # than the sea


@style.styled
def animation(scene: Scene, maps: xr.DataTree, truth: xr.DataTree, most_bytes: int = MOST_BYTES) -> Animation:
    """True and retrieved height side by side, turn by turn, as a GIF of at most so many bytes: smaller, then with
    fewer turns, until it fits. Memory holds one turn's maps and the frames."""
    turns = maps["ground"].sizes["turn"]
    every, width = -(-turns // MOST_FRAMES), _PIXELS[0]
    wait = min(scene.turn_duration_s, _LONGEST_S)
    stage = _Stage.of(scene, maps, truth, range(0, turns, every))
    while True:
        chosen = range(0, turns, every)
        data = gif(list(_frames(scene, maps, truth, stage, chosen, width)), [round(1e3 * wait)] * len(chosen), _COLOURS)
        if len(data) <= most_bytes or (width == _PIXELS[1] and len(chosen) < 2):
            return Animation(data, len(chosen), scene.turn_duration_s * every / wait)
        if width > _PIXELS[1]:
            width = max(_PIXELS[1], int(0.95 * width * np.sqrt(most_bytes / len(data))))
        else:
            every *= 2


class _Stage(NamedTuple):
    """The part of the ground that is drawn in all frames [m], and half the span of their heights [m]."""

    west: float
    east: float
    south: float
    north: float
    limit: float

    @classmethod
    def of(cls, scene: Scene, maps: xr.DataTree, truth: xr.DataTree, chosen: range) -> _Stage:
        limits, some = [], np.zeros((truth["ground"].sizes["y"], truth["ground"].sizes["x"]), dtype=bool)
        for turn in chosen:
            true, result = _heights(truth, turn), _heights(maps, turn)
            limits.append(height_limit(true, result))
            some |= np.isfinite(true) | np.isfinite(result)
        x, y = (reduce.coordinate(truth, "ground", name) for name in ("x", "y"))
        x, y = np.append(x[some.any(axis=0)], 0.0), np.append(y[some.any(axis=1)], 0.0)
        margin = 2.0 * scene.retrieval.ground_m
        west, east, south, north = x.min() - margin, x.max() + margin, y.min() - margin, y.max() + margin
        wide, high = east - west, north - south
        grow = 0.5 * max(0.0, 0.4 * wide - high), 0.5 * max(0.0, 0.7 * high - wide)  # narrow sectors get more ground
        return cls(west - grow[1], east + grow[1], south - grow[0], north + grow[0], float(np.median(limits)))


def _heights(tree: xr.DataTree, turn: int) -> Array:
    return np.asarray(tree["ground"].dataset["height"].isel(turn=turn).values, dtype=np.float64)


def _frames(
    scene: Scene, maps: xr.DataTree, truth: xr.DataTree, stage: _Stage, chosen: range, pixels: int
) -> Iterator[Image.Image]:
    """The pair of maps at the chosen turns."""
    inches = style.WIDTH * max(0.62, pixels / _PIXELS[0])  # small frames have fewer inches, or their text is too small
    wide = 0.5 * (inches - sum(_BESIDE))
    high = wide * (stage.north - stage.south) / (stage.east - stage.west)
    figure, pair = style.new_figure(_ABOVE + high + _BELOW, inches, pixels / inches), list[AxesImage]()
    for number, (tree, title) in enumerate(((truth, "True height"), (maps, "Retrieved height"))):
        axes = style.place(figure, _BESIDE[0] + number * (wide + _BESIDE[1]), _ABOVE, wide, high)
        pair.append(_panel(axes, scene, stage, tree, title))
        axes.set_ylabel("" if number else "North (m)", labelpad=1.0)
        axes.tick_params(labelleft=not number)
    style.colour_bar(
        figure, pair[0], 0.3 * inches, _ABOVE + high + 0.38, 0.4 * inches, "Height above mean sea level (m)", "both"
    )
    words = figure.text(0.5, 1.0 - 0.06 / figure.get_size_inches()[1], "", ha="center", va="top", fontsize=style.FONT)
    # What stays is drawn once; a frame draws the maps, what lies over them, and the words.
    moving = [artist for image in pair for artist in (image, *image.axes.lines)] + [words]
    for artist in moving:
        artist.set_animated(True)
    canvas: Any = figure.canvas
    canvas.draw()
    still = canvas.copy_from_bbox(figure.bbox)
    numbers = reduce.coordinate(maps, "ground", "turn")
    for turn in chosen:
        canvas.restore_region(still)
        for tree, image in zip((truth, maps), pair, strict=True):
            image.set_data(style.masked(_heights(tree, turn)))
        words.set_text(f"{turn_name(numbers[turn])}, from {numbers[turn] * scene.turn_duration_s:.2f} s")
        for artist in moving:
            figure.draw_artist(artist)
        yield style.snapshot(figure)


def _panel(axes: Axes, scene: Scene, stage: _Stage, tree: xr.DataTree, title: str) -> AxesImage:
    """Set up the axes of one map and draw its first turn; grey is where the radar looks."""
    if not scene.platform.speed_m_s:
        axes.add_patch(looked_at(scene, style.BLANK))
    x, y = (reduce.coordinate(tree, "ground", name) for name in ("x", "y"))
    image = draw_ground(axes, (x, y, _heights(tree, 0)), style.HEIGHT_COLOURS, -stage.limit, stage.limit)
    axes.set_xlim(stage.west, stage.east)
    axes.set_ylim(stage.south, stage.north)
    axes.set_title(title)
    axes.set_xlabel("East (m)", labelpad=1.0)
    style.mark_antenna(axes)
    for gauge in scene.gauges:
        axes.plot(*gauge.position, marker="+", color="black", markersize=5.0, markeredgewidth=0.8, zorder=4.0)
    return image


def film(scene: Scene, maps: xr.DataTree, truth: xr.DataTree) -> list[Picture]:
    """The animation as a picture of the page; none for a single turn."""
    turns = maps["ground"].sizes["turn"]
    if turns < 2:
        return []
    made = animation(scene, maps, truth)
    every = f"all {turns} turns" if made.shown == turns else f"{made.shown} of {turns} turns, the others are skipped"
    instant = scene.retrieval.map_time_s
    moment = "when the beam passed each cell" if instant is None else f"{instant:g} s after the turn's start"
    crosses = " Crosses are wave gauges." if scene.gauges else ""
    return [
        Picture(
            "evolution",
            "True and retrieved height, turn by turn",
            f"Animation of two maps, north up, over {every}: true height and retrieved height.",
            f"Height above mean sea level on the ground cells, {every}, {made.faster:.2g} times as fast as the sea, "
            f"on one scale. Left: the sea as it was {moment}, lit or not. Right: what the "
            f"retrieval made of the echoes; grey is where it gave no height.{crosses}",
            lambda: made.data,
        )
    ]


_ERRORS = ("rmse_m", "robust_m", "bias_m", "correlation")


def turn_table(maps: xr.DataTree, truth: xr.DataTree) -> list[Table]:
    """Each turn judged by itself; none for a single turn, every nth of very many."""
    turns = reduce.coordinate(maps, "polar", "turn")
    if turns.size < 2:
        return []
    every = -(-turns.size // MOST_ROWS)
    rows = [_row(maps, truth, index) for index in range(0, turns.size, every)]
    head = (
        "Turn", "Time (s)", "Cells", "Height error, rms (m)", "Robust (m)", "Bias (m)", "Correlation", "Hs true (m)",
        "Hs retrieved (m)", "Visible", "Answered",
    )  # fmt: skip
    few = f" Every {every}. turn of {turns.size} is listed." if every > 1 else ""
    note = (
        "Polar cells at 50–200 m. Errors: of cells more than half visible whose height is not called ambiguous; "
        "answered: their share of the cells more than half visible. Hs = 4 std of all true heights, and of the heights "
        "without a flag. Time: when the beam passes the middle look."
    )
    return [Table("Turn by turn", head, rows, note + few)]


def _row(maps: xr.DataTree, truth: xr.DataTree, index: int) -> list[str]:
    result, real = (
        xr.DataTree.from_dict({"/polar": tree["polar"].to_dataset().isel(turn=[index])}) for tree in (maps, truth)
    )
    visible = reduce.polar(real, "visible_fraction")[0][:, reduce.judged_gates(real)] > HALF_VISIBLE
    time = reduce.coordinate(result, "polar", "time")[0]
    figures = error_figures(result, real)["overall"]
    answered = figures["cells"] / visible.sum() if visible.any() else float("nan")
    return [
        turn_name(reduce.coordinate(result, "polar", "turn")[0]).removeprefix("turn "),
        digits(time[time.size // 2], 2),
        str(figures["cells"]),
        *(digits(figures[f"height_{name}"], 3, signed=name == "bias_m") for name in _ERRORS),
        digits(figures["hs_true_m"], 2),
        digits(figures["hs_retrieved_m"], 2),
        percent(figures["visible_fraction"]),
        percent(answered),
    ]
