"""What is requested: at which times, at which points, and whether memory and disk hold it."""

from __future__ import annotations

import math
import shutil
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, MachineLimitError
from ..io.text import number_list
from ..scene import Scene
from ..sea import resolution

_DEFAULT_POINTS = 512  # a side, at most
_MOST_POINTS = 10_000_000  # of a moment
_BYTES_IN_MEMORY, _BYTES_ON_FILE = 150.0, 29.0  # per point; on file before compression
_MOST_FILE_BYTES = 50e9
_MOST_TIMES = 100_000


def times_of(text: str) -> NDArray[np.float64]:
    """Rising times [s] of START:STOP:STEP (STOP too, where a step meets it) or T,T,…; InputError for anything else."""
    about, form = f"--times = '{text}'", "write START:STOP:STEP or T,T,… in seconds, as in 0:5:0.5"
    numbers = [float(each) for each in number_list(text, about, form, _MOST_TIMES)]
    if any(later <= earlier for earlier, later in pairwise(numbers)):
        raise InputError(f"{about}: each time must be later than the one before it; {form}")
    return np.array(numbers)


def square_points(scene: Scene, side: float | None = None, spacing: float | None = None) -> NDArray[np.float64]:
    """Points of a side [m]: centres of cells that fill a square around the antenna. InputError for impossible ones."""
    extent = scene.sea.extent_m
    try:
        finest = resolution(scene.sea)
    except ValueError as error:
        raise InputError(f"sea: {error}") from None
    side = min(2.0 * scene.radar.range_m[1], extent) if side is None else side
    if not 0.0 < side <= extent:
        raise InputError(f"--side = {side:g}: must be above 0 and at most {extent:g}, sea.extent_m; lower it")
    spacing = max(finest, side / _DEFAULT_POINTS) if spacing is None else spacing
    if not 0.0 < spacing <= 0.5 * side:
        raise InputError(
            f"--spacing = {spacing:g}: must be above 0 and at most {0.5 * side:g}, half of --side; lower it"
        )
    count = round(side / spacing)
    if count**2 > _MOST_POINTS:
        raise InputError(
            f"--spacing = {spacing:g}: {count} × {count} points take {_BYTES_IN_MEMORY * count**2 / 1e9:.3g} GB of "
            f"memory; raise --spacing to {side / math.sqrt(_MOST_POINTS):.3g} or lower --side (at most "
            f"{_MOST_POINTS:.3g} points)"
        )
    return side / count * (np.arange(count, dtype=np.float64) - 0.5 * (count - 1))


def point_spacing(points: NDArray[np.float64]) -> float:
    """Distance of neighbouring points, m."""
    return float(points[1] - points[0])


def refuse_too_large(folder: Path, times: int, points: int, name: str = "sea.nc") -> None:
    """InputError where so many times of points × points are too many, or do not fit the disk twice: by themselves, and
    in the file that is made of them. name: of the file."""
    needed, free = _BYTES_ON_FILE * times * points**2, shutil.disk_usage(folder).free
    if needed > min(_MOST_FILE_BYTES, free / 2.0):
        raise (InputError if needed > _MOST_FILE_BYTES else MachineLimitError)(
            f"{name}: {times} times of {points} × {points} points take up to {needed / 1e9:.3g} GB, and may take "
            f"{_MOST_FILE_BYTES / 1e9:g} (half of the {free / 1e9:.3g} that are free); ask for fewer --times or a "
            "wider --spacing"
        )
