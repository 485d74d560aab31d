"""What a sweep varies: keys of the scene and their values, and the grid of points that they span with the seeds."""

from __future__ import annotations

import itertools
import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, must_be
from ..io.scenefile import apply_overrides
from ..io.text import number_list
from ..scene import Scene, with_keys

MOST_POINTS = 10_000
_FORM = "write KEY=START:STOP:STEP or KEY=A,B,C, as in radar.height_m=3:20:1"

CIRCUMSTANCES = ("sea.", "scattering.", "platform.")  # keys that nobody chooses, unlike those of the radar

Vary = dict[str, list[Any]]


# ------------------------------------------------------------------------------------------------ as it is written


def parse_vary(text: str) -> tuple[str, list[Any]]:
    """Key and values of KEY=START:STOP:STEP (STOP too, where a step meets it) or KEY=A,B,C.

    The steps are taken in decimals, so that 0.1:0.4:0.1 holds 0.3 and 0.4. Values are read as a scene file's: numbers,
    true and false, lists in brackets, else text. Raises InputError for anything else.
    """
    key, equals, written = (part.strip() for part in text.partition("="))
    if not equals or not key or not written:
        raise InputError(f"--vary {text}: must name a key and its values; {_FORM}")
    if re.fullmatch(r"[^:,\[\]\"']+(:[^:,\[\]\"']+)+", written):
        whole = re.fullmatch(r"[\s+\-\d:]+", written)
        return key, [
            int(each) if whole else float(each) for each in number_list(written, f"--vary {text}", _FORM, MOST_POINTS)
        ]
    whole = apply_overrides({}, {"values": f"[{written}]"})["values"]
    if isinstance(whole, list):
        return key, whole
    return key, [apply_overrides({}, {"value": part.strip()})["value"] for part in written.split(",")]


def parse_varies(texts: Sequence[str]) -> Vary:
    """Values by key, from texts `key=value,…`. Raises InputError for a key given twice."""
    result: Vary = {}
    for text in texts:
        key, values = parse_vary(text)
        if key in result:
            raise InputError(f"--vary {text}: {key} is varied twice; put all its values in one --vary")
        result[key] = values
    return result


def chosen_key(vary: Mapping[str, Sequence[Any]]) -> str:
    """The key among whose values a study recommends: the antenna's height where it varies, else the one with the most
    numbers that is no circumstance; empty where there is none."""
    numbers = {
        key: len(values)
        for key, values in vary.items()
        if len(values) > 1 and labels(values).dtype.kind == "f" and not key.startswith(CIRCUMSTANCES)
    }
    return "radar.height_m" if "radar.height_m" in numbers else max(numbers, key=lambda key: numbers[key], default="")


def refuse_limit(vary: Mapping[str, Sequence[Any]], at_most: float | None) -> None:
    """Raise InputError for a limit of the chosen key that leaves none of its values; None limits nothing."""
    if at_most is None:
        return
    key = chosen_key(vary)
    if not key:
        raise InputError(f"--at-most {at_most:g}: limits the key that is chosen, and no number that a design chooses "
                         "is varied; vary radar.height_m, or leave it out")  # fmt: skip
    least = min(vary[key])
    if not at_most >= least:
        raise InputError(f"--at-most {at_most:g}: must be at least {least:g}, the least {key} that is varied; raise it")


# ---------------------------------------------------------------------------------------------------------- the grid


@dataclass(frozen=True)
class Point:
    """One scene of the grid."""

    number: int  # of its values: one for all its seeds, so that more seeds leave the names of files as they are
    index: tuple[int, ...]  # of each varied key's value, and of the seed
    keys: dict[str, Any]
    seed: int

    @property
    def name(self) -> str:
        """Name of its file: the same in every run of the same grid."""
        short = {k: f"{v:.10g}" if isinstance(v, float) else write_value(v) for k, v in self.keys.items()}
        words = "_".join(f"{key}={value}" for key, value in short.items())
        return f"{self.number:05d}_{re.sub(r'[^A-Za-z0-9._=+-]+', '-', words)[:100]}_seed={self.seed}"


def seeds_of(scene: Scene, seeds: int) -> list[int]:
    """The scene's own seed and those that follow it. Raises InputError for fewer than one."""
    if seeds < 1:
        raise InputError(f"seeds = {seeds}: must be at least 1; raise it")
    return [scene.seed + number for number in range(seeds)]


def _refuse_key(scene: Scene, key: str, values: Sequence[Any]) -> None:
    if isinstance(values, str) or len(values) == 0:
        raise InputError(f"--vary {key}: must have a list of at least one value; {_FORM}")
    words = [write_value(value) for value in values]
    if len(set(words)) < len(words):
        twice = next(value for value in words if words.count(value) > 1)
        raise InputError(f"--vary {key}: {twice} is named twice; name each value once")
    if len({isinstance(value, str) for value in values}) > 1:
        text = next(value for value in values if isinstance(value, str))
        raise InputError(f"--vary {key}: {text} is text and other values are not; correct it, or leave it out")
    if key == "seed":
        raise InputError("--vary seed: seeds are counted from the scene's own; give --seeds N instead")
    if key.startswith("radar.antenna.") and scene.radar.antennas:
        raise InputError(f"--vary {key}: the scene's radar.antennas hold their own; vary radar.antennas.0 and so on")


def write_value(value: Any) -> str:
    """A value as text: one text for one value."""
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return value if isinstance(value, str) else json.dumps(value, default=str)


def labels(values: Sequence[Any]) -> NDArray:
    """Values as coordinates: numbers as numbers, all else as text."""
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return np.array(values, dtype=np.float64)
    return np.array([write_value(value) for value in values], dtype=object)


@dataclass(frozen=True)
class Grid:
    """Scenes over values of keys and over seeds."""

    scene: Scene
    vary: Vary
    seeds: list[int]

    @classmethod
    def of(cls, scene: Scene, vary: Mapping[str, Sequence[Any]], seeds: int = 1, *more: Any) -> Self:
        """vary: values by scene key; seeds: how many. Raises InputError for fewer than one seed."""
        wanted = "a dict of lists, such as {'radar.height_m': [3, 5, 10]}"
        must_be("vary", vary, Mapping, wanted)
        for key, each in vary.items():
            must_be(f"vary: {key}", each, Iterable, wanted)
        plain = {key: apply_overrides({}, {"values": list(each)})["values"] for key, each in vary.items()}
        values = json.loads(json.dumps(plain, default=str))  # dates, too, are what was written
        return cls(scene, values, seeds_of(scene, seeds), *more)

    @cached_property
    def points(self) -> list[Point]:
        """The first key varies slowest and the seed fastest. Raises InputError for keys that cannot vary."""
        if not self.vary:
            raise InputError(f"--vary: is missing; {_FORM}")
        for key, values in self.vary.items():
            _refuse_key(self.scene, key, values)
        sizes = [*map(len, self.vary.values()), len(self.seeds)]
        if (count := math.prod(sizes)) > MOST_POINTS:
            many = f"spans {count} points, and at most {MOST_POINTS} are taken"
            raise InputError(f"--vary: {many}; vary less, or fewer seeds")
        result = []
        for number, index in enumerate(itertools.product(*map(range, sizes))):
            keys = {key: values[i] for (key, values), i in zip(self.vary.items(), index, strict=False)}
            result.append(Point(number // sizes[-1], index, keys, self.seeds[index[-1]]))
        return result

    @cached_property
    def scenes(self) -> list[Scene | InputError]:
        """The scene of each point, or why it has none. Raises InputError where no point has one."""
        result: list[Scene | InputError] = []
        for point in self.points:
            try:
                result.append(with_keys(self.scene, {**point.keys, "seed": point.seed}))
            except InputError as refusal:
                result.append(refusal)
        first = result[0]
        if isinstance(first, InputError) and all(isinstance(each, InputError) for each in result):
            message = f"no point of the sweep can be run, for the first: {first.problems[0]}"
            raise InputError(message, *first.problems[1:])
        return result

    @property
    def designs(self) -> dict[tuple[int, ...], Scene | InputError]:
        """The scenes of the first seed, by their place in the grid without the seeds."""
        every = zip(self.points, self.scenes, strict=True)
        return {point.index[:-1]: scene for point, scene in every if point.index[-1] == 0}
