"""What a run wrote, a turn at a time, from its files: finished, growing, or left by a kill; and what of a turn is
shown: panels of each view, the section along a look, curves against range. Memory holds few turns."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..io.opening import LONG, read_json
from ..io.scenefile import read_toml
from ..io.turn_files import GrowingFile, part_of, read_whole_turns
from ..scene import Scene, scene_of

Array = NDArray[np.floating]
Result = TypeVar("Result")

_KEPT_BYTES = 200e6  # of turns that were read


@dataclass(frozen=True)
class Layout:
    """What does not change from turn to turn: the cells of the maps."""

    azimuth: NDArray[np.float64]  # (look,) degrees
    range: NDArray[np.float64]  # (gate,) m, slant
    x: NDArray[np.float64]  # (column,) m east
    y: NDArray[np.float64]  # (row,) m north


class Results:
    """A folder of `run`, `simulate` or `retrieve`. Safe to use in several threads.

    Raises InputError for a folder that holds no maps.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        if not any((folder / name).exists() or part_of(folder / name).exists() for name in ("maps.nc", "truth.nc")):
            raise InputError(f"{folder.name}: holds no maps; choose the folder of a run, or run it")
        self._kept: OrderedDict[tuple[str, str, int], Array] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()
        self._open: dict[str, GrowingFile] = {}
        self._scene: Scene | None = None

    # --------------------------------------------------------------------------------------------- what there is

    @property
    def maps(self) -> Path:
        return self.folder / "maps.nc"

    @property
    def truth(self) -> Path:
        return self.folder / "truth.nc"

    @property
    def has_truth(self) -> bool:
        return self.truth.exists() or part_of(self.truth).exists()

    @property
    def has_maps(self) -> bool:
        """Whether anything was retrieved: a simulation alone has the true sea and the echoes."""
        return self.maps.exists() or part_of(self.maps).exists()

    @property
    def _main(self) -> Path:
        """What there is in any case."""
        return self.maps if self.has_maps else self.truth

    @property
    def growing(self) -> bool:
        """Whether the maps, or what there is instead, are not finished."""
        return not self._main.exists()

    def turns(self) -> list[int]:
        """Numbers of the turns that are whole in the maps, and in the truth if there is one; none before the first."""
        try:
            numbers = [int(each) for each in self._read(self._main, lambda file: file.array("polar/turn")[:])]
            if self.has_truth and self.has_maps:
                held = self._read(self.truth, lambda file: len(file.array("polar/turn")))
                numbers = numbers[:held]
        except OSError:
            return []
        return numbers

    def layout(self) -> Layout:
        """The cells of polar and ground maps. OSError before the first turn."""

        def read(file: GrowingFile) -> Layout:
            names = ("polar/azimuth", "polar/range", "ground/x", "ground/y")
            return Layout(*(np.asarray(file.array(name)[:], dtype=np.float64) for name in names))

        return self._read(self._main, read)

    def scene(self) -> Scene | None:
        """That was run; None of a retrieval, which knows none, and of a scene of another version."""
        path = self.folder / "scene.toml"
        if self._scene is None and path.exists():
            try:
                self._scene = scene_of(read_toml(path))
            except InputError:
                return None
        return self._scene

    def metrics(self) -> dict[str, Any]:
        """Of a finished run; empty of another one."""
        try:
            content = read_json(self.folder / "metrics.json", most=LONG)
        except (OSError, ValueError):
            return {}
        return content if isinstance(content, dict) else {}

    # ----------------------------------------------------------------------------------------------------- turns

    def field(self, name: str, index: int) -> Array:
        """A field of a turn by its place from 0, as "maps/ground/height" or "truth/polar/visible_fraction".

        Shape (row, column) or (look, gate). OSError, KeyError where there is none.
        """
        key = (name, "", index)
        with self._lock:
            kept = self._kept.get(key)
            if kept is not None:
                self._kept.move_to_end(key)
                return kept
        tree, path = name.split("/", 1)
        file = {"maps": self.maps, "truth": self.truth}[tree]
        values = self._read(file, lambda opened: np.asarray(opened.array(path)[index], dtype=np.float32))
        with self._lock:
            self._kept[key] = values
            self._bytes += values.nbytes
            while self._bytes > _KEPT_BYTES and len(self._kept) > 1:
                _, old = self._kept.popitem(last=False)
                self._bytes -= old.nbytes
        return values

    def has(self, name: str) -> bool:
        """Whether there is such a field, named as for `field`."""
        tree, path = name.split("/", 1)
        file = {"maps": self.maps, "truth": self.truth}[tree]
        try:
            return self._read(file, lambda opened: path in opened)
        except OSError:
            return False

    def attributes(self, name: str) -> dict[str, Any]:
        """Of a group, named as "maps/polar". OSError, KeyError where there is none."""
        tree, path = name.split("/", 1)
        file = {"maps": self.maps, "truth": self.truth}[tree]
        return self._read(file, lambda opened: {key: _plain(each) for key, each in opened.attributes(path).items()})

    def time(self, index: int) -> float:
        """When a turn began, s."""
        return float(np.min(self._read(self._main, lambda file: file.array("polar/time")[index])))

    def _read(self, path: Path, read: Callable[[GrowingFile], Result]) -> Result:
        """Of a file that is finished, which stays open, or of one that grows."""
        try:
            with self._lock:
                if path.name not in self._open and path.exists():
                    self._open[path.name] = GrowingFile(path)
                held = self._open.get(path.name)
            return read_whole_turns(path, read) if held is None else read(held)
        except (IndexError, ValueError) as error:
            raise OSError(f"{path.name}: {error}") from None

    def close(self) -> None:
        """Close what is open."""
        with self._lock:
            for file in self._open.values():
                file.close()
            self._open.clear()


def _plain(value: Any) -> Any:
    """NetCDF keeps a number as an array of one."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value
