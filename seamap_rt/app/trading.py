"""A trade while it is computed, and afterwards: what its points came to, from their own files.

A trade keeps the figures of its points, not their maps: the same scene with the same seed gives the same maps again.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..io.opening import load, open_dataset, read_json
from ..io.scenefile import apply_overrides
from ..report.keys import words_of
from ..scene import Scene, scene_of
from ..studies.point import MANIFEST
from ..studies.vary import parse_varies, parse_vary, refuse_limit
from . import figures
from .fields import Field, parts_of
from .safety import Roots, safe_name

MEASURES = {
    "fully_measured_radius_m": "Fully measured radius (m)",
    "reach_m": "Reach (m)",
    "missed_share": "Share of cells missed",
    "height_rmse_m": "Height error, rms (m)",
}
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
    for number, path in enumerate(sorted((folder / "points").glob("*.json"))):
        if number >= _MOST_FILES:
            break
        try:
            told = read_json(path, below=folder)
            metrics = {k: float(v) for k, v in (told.get("metrics") or {}).items() if isinstance(v, int | float)}
            found.append(
                Point(dict(told["keys"]), int(told["seed"]), str(told["status"]), str(told.get("reason", "")), metrics)
            )
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
    if not 1 <= seeds <= 64:
        raise InputError(f"--seeds {seeds}: must be 1 to 64")
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


def graph(points: list[Point], measure: str, dark: bool) -> figures.Figure | None:
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
        curves.setdefault(name, {}).setdefault(place_of(each.keys[first]), []).append(each.metrics[measure])
    colours = (figures.BLUE, figures.VERMILION, figures.GREEN, figures.PURPLE, figures.ORANGE, figures.SKY)
    data: list[figures.Figure] = []
    for number, (name, values) in enumerate(sorted(curves.items())):
        colour = colours[number % len(colours)]
        places = sorted(values, key=lambda each: (isinstance(each, str), each))
        label = ", ".join(name) or "mean over seeds"
        mean = [float(np.mean(values[place])) for place in places]
        data.append({
            "type": "scatter", "mode": "lines+markers", "x": places, "y": figures.plain(mean),
            "name": figures.text(label), "line": {"color": colour}, "marker": {"size": 9},
        })  # fmt: skip
        data.append({
            "type": "scatter", "mode": "markers", "x": [place for place in places for _ in values[place]],
            "y": figures.plain([each for place in places for each in values[place]]), "name": "one seed",
            "hoverinfo": "x+y+name", "showlegend": False, "marker": {"color": colour, "size": 6, "opacity": 0.5},
        })  # fmt: skip
    look = figures.layout(
        dark, "", 420, hovermode="closest", margin={"l": 56, "r": 10, "t": 10, "b": 70},
        xaxis=figures.axis(words_of(first).label, dark),
        yaxis=figures.axis(MEASURES[measure], dark, rangemode="tozero"),
    )  # fmt: skip
    return figures.figure(data, look, figures.CONFIG)


def place_of(value: Any) -> Any:
    """Where a value stands on a graph's axis: a number, or words."""
    return value if isinstance(value, int | float) and not isinstance(value, bool) else figures.text(str(value))


def scene_of_point(folder: Path, point: Point, roots: Roots) -> Scene:
    """That the trade ran at a point. InputError where the trade's own scene cannot be read, or is refused."""
    try:
        told: Any = read_json(folder / MANIFEST, below=folder)
        tree = tomllib.loads(str(told["scene"]))
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
    told = ", ".join(f"{words_of(key).name} {value} {words_of(key).unit}".strip() for key, value in point.keys.items())
    return f"{told}, seed {point.seed}"
