"""What changes from turn to turn: an animation of true and retrieved height, and a table of the turns.

A run of one turn has neither.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Wedge
from numpy.typing import NDArray
from PIL import Image

from ..conventions import turn_name
from ..metrics import HALF_VISIBLE, error_figures
from ..scene import Scene
from . import reduce, style
from .maps import draw_ground, height_limit
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


class Film(NamedTuple):
    """An animation and what it shows."""

    data: bytes
    shown: int  # turns
    faster: float  # than the sea


@style.styled
def animation(scene: Scene, maps: xr.DataTree, truth: xr.DataTree, most_bytes: int = MOST_BYTES) -> Film:
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
            return Film(data, len(chosen), scene.turn_duration_s * every / wait)
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
    panel = 0.5 * (inches - sum(_BESIDE))
    high = panel * (stage.north - stage.south) / (stage.east - stage.west)
    figure = Figure(figsize=(inches, _ABOVE + high + _BELOW), dpi=pixels / inches)
    canvas = FigureCanvasAgg(figure)
    pair = []
    for number, (tree, title) in enumerate(((truth, "True height"), (maps, "Retrieved height"))):
        size = figure.get_size_inches()
        box = (_BESIDE[0] + number * (panel + _BESIDE[1]), _BELOW, panel, high)
        axes = figure.add_axes((box[0] / size[0], box[1] / size[1], box[2] / size[0], box[3] / size[1]))
        pair.append((tree, _panel(axes, scene, stage, tree, title)))
        if number:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel("North (m)", labelpad=1.0)
    style.colour_bar(
        figure, pair[0][1], 0.3 * inches, _ABOVE + high + 0.38, 0.4 * inches, "Height above mean sea level (m)", "both"
    )
    words = figure.text(0.5, 1.0 - 0.06 / figure.get_size_inches()[1], "", ha="center", va="top", fontsize=style.FONT)
    # What stays is drawn once; a frame draws the maps, what lies over them, and the words.
    moving = [artist for _, image in pair for artist in (image, *image.axes.lines)] + [words]
    for artist in moving:
        artist.set_animated(True)
    canvas.draw()
    still = canvas.copy_from_bbox(figure.bbox)
    numbers = reduce.coordinate(maps, "ground", "turn")
    for turn in chosen:
        canvas.restore_region(still)
        for tree, image in pair:
            image.set_data(style.masked(_heights(tree, turn)))
        words.set_text(f"{turn_name(numbers[turn])}, from {numbers[turn] * scene.turn_duration_s:.2f} s")
        for artist in moving:
            figure.draw_artist(artist)
        yield Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")


def _panel(axes: Axes, scene: Scene, stage: _Stage, tree: xr.DataTree, title: str) -> AxesImage:
    """Set up the axes of one map and draw its first turn; grey is where the radar looks."""
    x, y = (reduce.coordinate(tree, "ground", name) for name in ("x", "y"))
    near = float(reduce.ground_range(scene.radar.range_m[0], scene.radar.height_m))
    start, stop = scene.radar.sector_deg
    if not scene.platform.speed_m_s:
        wedge = Wedge(
            (0.0, 0.0), scene.far_ground_range, 90.0 - stop, 90.0 - start, width=scene.far_ground_range - near,
            facecolor=style.BLANK, edgecolor="none", zorder=1.0,
        )  # fmt: skip
        axes.add_patch(wedge)
    limit = stage.limit
    image = draw_ground(axes, (x, y, _heights(tree, 0)), style.HEIGHT_COLOURS, -limit, limit)
    axes.set_xlim(stage.west, stage.east)
    axes.set_ylim(stage.south, stage.north)
    axes.set_title(title)
    axes.set_xlabel("East (m)", labelpad=1.0)
    axes.plot(0.0, 0.0, marker="^", color="black", markersize=3.5, linestyle="none", zorder=4.0)
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
    near = reduce.at_judged_ranges(real)
    visible = reduce.polar(real, "visible_fraction")[0][:, near] > HALF_VISIBLE
    time: NDArray[np.float64] = reduce.coordinate(result, "polar", "time")[0]
    figures = error_figures(result, real)["overall"]
    answered = figures["cells"] / visible.sum() if visible.any() else float("nan")
    return [
        turn_name(reduce.coordinate(result, "polar", "turn")[0]).removeprefix("turn "),
        digits(time[time.size // 2], 2),
        str(figures["cells"]),
        digits(figures["height_rmse_m"], 3),
        digits(figures["height_robust_m"], 3),
        digits(figures["height_bias_m"], 3, signed=True),
        digits(figures["height_correlation"], 3),
        digits(figures["hs_true_m"], 2),
        digits(figures["hs_retrieved_m"], 2),
        percent(figures["visible_fraction"]),
        percent(answered),
    ]
