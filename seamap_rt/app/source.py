"""A run's results, from its files: finished, growing, or left by a kill; and what views show of a turn: panels of maps,
curves against range, what estimators of waves read. Memory holds few turns."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import ground_range
from ..errors import InputError, SchemaError
from ..interferometry import open_echoes
from ..io.opening import LONG, read_json
from ..io.reading import ResultsFile, results_exist
from ..io.scenefile import read_toml
from ..report import maps, reduce, style
from ..scene import Scene, scene_of
from ..schema import SCHEMA
from .drawing import MapPanels, Panel, Raster, Scale, ground_raster, polar_raster

Array = NDArray[np.floating]
Result = TypeVar("Result")
Panels = list[tuple[Panel, Array]]

_KEPT_BYTES = 200e6  # of turns that were read
MAP_VIEWS = {"heights": "Heights", "slopes": "Slopes", "polar": "Radar cells", "echo": "Echo"}
_OF_WAVES = ("height", "height_std", "ground_range", "quality", "radial_velocity", "visible_share", "time")
_OF_WAVES += ("antenna_x", "antenna_y")  # of a boat that moves


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
        self.folder, self.maps, self.truth = folder, folder / "maps.nc", folder / "truth.nc"
        if not (self.has_maps or self.has_truth):
            raise InputError(f"{folder.name}: holds no maps; choose the folder of a run, or run it")
        self._kept: OrderedDict[tuple[str, int], Array] = OrderedDict()
        self._lock = threading.Lock()
        self._files = {path: ResultsFile(path) for path in (self.maps, self.truth)}

    # --------------------------------------------------------------------------------------------- what there is

    @property
    def has_truth(self) -> bool:
        return results_exist(self.truth)

    @property
    def has_maps(self) -> bool:
        """Whether anything was retrieved: a simulation alone has the true sea and the echoes."""
        return results_exist(self.maps)

    @property
    def _main_file(self) -> Path:
        """The file that there is in any case."""
        return self.maps if self.has_maps else self.truth

    @property
    def growing(self) -> bool:
        """Whether the maps, or what there is instead, are not finished."""
        return not self._main_file.exists()

    def turns(self) -> list[int]:
        """Numbers of the turns that are whole in the maps, and in the truth if there is one; none before the first."""
        try:
            numbers = [int(each) for each in self._files[self._main_file].read(lambda file: file["polar/turn"][:])]
            if self.has_truth and self.has_maps:
                numbers = numbers[: self._files[self.truth].read(lambda file: file["polar/turn"].shape[0])]
        except OSError:
            return []
        return numbers

    def layout(self) -> Layout:
        """The cells of polar and ground maps. OSError before the first turn."""

        def read(file: Any) -> Layout:
            names = ("polar/azimuth", "polar/range", "ground/x", "ground/y")
            return Layout(*(np.asarray(file[name][:], dtype=np.float64) for name in names))

        return self._files[self._main_file].read(read)

    def scene(self) -> Scene | None:
        """The scene that was run; None for a retrieval, which knows none, and for a scene of another version."""
        try:
            return scene_of(read_toml(self.folder / "scene.toml"))
        except InputError:
            return None

    def metrics(self) -> dict[str, Any]:
        """The metrics of a finished run; empty for any other."""
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
        with self._lock:
            if (name, index) in self._kept:
                self._kept.move_to_end((name, index))
                return self._kept[name, index]
        values = self._read_from(name, lambda file, path: np.asarray(file[path][index], dtype=np.float32))
        with self._lock:
            self._kept[name, index] = values
            while len(self._kept) > 1 and sum(each.nbytes for each in self._kept.values()) > _KEPT_BYTES:
                self._kept.popitem(last=False)
        return values

    def has_field(self, name: str) -> bool:
        """Whether there is such a field, named as for `field`."""
        try:
            return self._read_from(name, lambda file, path: path in file)
        except OSError:
            return False

    def attributes(self, name: str) -> dict[str, Any]:
        """Attributes of a group, named as "maps/polar". OSError, KeyError where there is none."""
        found = self._read_from(name, lambda file, path: dict(file[path].attrs))
        return {key: _scalar(each) for key, each in found.items()}

    def time(self, index: int) -> float:
        """When a turn began, s."""
        return float(np.min(self._files[self._main_file].read(lambda file: file["polar/time"][index])))

    def _read_from(self, name: str, read: Callable[[Any, str], Result]) -> Result:
        tree, path = name.split("/", 1)
        return self._files[{"maps": self.maps, "truth": self.truth}[tree]].read(lambda file: read(file, path))

    def close(self) -> None:
        """Close what is open."""
        for file in self._files.values():
            file.close()


def _scalar(value: Any) -> Any:
    """NetCDF keeps a number as an array of one."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


class Source:
    """A run's results with what its views need beside them: rasters and scales, which stay while it is seen.

    Given to another process, it is opened there once, and stays while it is among the last.
    """

    def __init__(self, results: Results) -> None:
        self.results, self.layout, self.scene = results, results.layout(), results.scene()
        self.number = next(_NUMBERS)
        self._rasters: dict[str, Raster] = {}
        self._scales: dict[str, Scale] = {}
        self._echoes: xr.Dataset | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return _open_local, (self.results.folder, self.number)

    @cached_property
    def height_m(self) -> float:
        """The antennas' height: by the scene, else as the maps have slant and ground ranges, else as the echoes say."""
        if self.scene is not None:
            return self.scene.radar.height_m
        try:
            if self.results.has_maps:
                square = self.layout.range**2 - self.results.field("maps/polar/ground_range", 0).astype(np.float64) ** 2
                known = square[np.isfinite(square)]
                return float(np.sqrt(max(np.median(known), 0.0))) if known.size else 0.0
            return float(open_echoes(self.results.folder).attrs["height_m"])
        except (InputError, SchemaError, OSError, KeyError, IndexError, ValueError):
            return 0.0

    @property
    def ground_m(self) -> NDArray[np.float64]:
        """(gate,): where the gates meet mean sea level."""
        return ground_range(self.layout.range, self.height_m)

    # --------------------------------------------------------------------------------------------------- maps

    def view(self, name: str, index: int) -> MapPanels:
        """A view by its name in MAP_VIEWS, of a turn by its place. OSError where the turn is not there."""
        panels = getattr(self, f"_{name}")(index)
        raster = self._raster("ground" if name in ("heights", "slopes") else "polar", index)
        return MapPanels.of([panel for panel, _ in panels], raster, [values for _, values in panels])

    def _raster(self, kind: str, index: int) -> Raster:
        if kind not in self._rasters:
            if kind == "polar":
                self._rasters[kind] = polar_raster(self.layout.azimuth, self.layout.range, self.height_m)
            else:
                seen = self.covered_cells(index)
                self._rasters[kind] = ground_raster(self.layout.x, self.layout.y, seen)
        return self._rasters[kind]

    def covered_cells(self, index: int) -> NDArray[np.bool_]:
        """(row, column) of the ground cells that the beam passed in a turn."""
        tree = "maps" if self.results.has_maps else "truth"
        return np.isfinite(self.results.field(f"{tree}/ground/time", index))

    def _fields(self, name: str, index: int) -> tuple[Array | None, Array | None]:
        """The true and the retrieved field, named as "ground/height"; None where it is not known. The true one has only
        ground cells that the beam passed."""
        results = self.results
        true = results.field(f"truth/{name}", index) if results.has_truth else None
        if true is not None and name.startswith("ground/"):
            true = np.where(self.covered_cells(index), true, np.nan)
        return true, results.field(f"maps/{name}", index) if results.has_maps else None

    def _pair(self, words: str, scale: str, true: Array | None, retrieved: Array | None, digits: int = 2) -> Panels:
        """What there is of both on one scale."""
        there = [(name, each) for name, each in (("True", true), ("Retrieved", retrieved)) if each is not None]
        on = self._scale(scale, lambda: _signed_scale(there[0][1], there[-1][1], words.split()[0]))
        return [(Panel(f"{name} {words}", on, digits), each) for name, each in there]

    def _stated_error(self, group: str, index: int) -> Panels:
        """What the retrieval states of its heights; nothing of a simulation."""
        if not self.results.has_maps:
            return []
        spread = self.results.field(f"maps/{group}/height_std", index)
        return [(Panel("Stated error", self._scale(f"{group} spread", lambda: _spread_scale(spread)), 3), spread)]

    def _heights(self, index: int) -> Panels:
        true, retrieved = self._fields("ground/height", index)
        panels = self._pair("height", "height", true, retrieved)
        if true is not None and retrieved is not None:
            error = retrieved - true
            wrong = self._scale("error", lambda: error_scale(error, "Error (m)"))
            panels.append((Panel("Error", wrong, 3), error))
        return panels + self._stated_error("ground", index)

    def _slopes(self, index: int) -> Panels:
        pairs = {to: self._fields(f"ground/{name}", index) for name, to in (("slope_x", "east"), ("slope_y", "north"))}
        true, retrieved = ([pair[i] for pair in pairs.values() if pair[i] is not None] for i in (0, 1))
        self._scale("slope", lambda: _signed_scale(np.stack(true or retrieved), np.stack(retrieved or true), "slope"))  # type: ignore[arg-type]
        panels: Panels = []
        for to, (t, r) in pairs.items():
            panels += self._pair(f"slope to {to}", "slope", t, r, digits=3)
            if t is not None and r is not None:
                wrong = self._scale(f"error {to}", lambda e=r - t: error_scale(e, "Error", style.SLOPE_COLOURS))
                panels.append((Panel(f"Error to {to}", wrong, 3), r - t))
        return panels

    def _polar(self, index: int) -> Panels:
        panels = self._pair("height", "polar height", *self._fields("polar/height", index))
        if self.results.has_truth:
            seen = Scale(0.0, 1.0, "cividis", "Share in sight")
            share = self.results.field("truth/polar/visible_fraction", index)
            panels.append((Panel("In sight of both antennas", seen), share))
        return panels + self._stated_error("polar", index)

    def _echo(self, index: int) -> Panels:
        power, words = self._power(index)
        finite = power[np.isfinite(power)]
        low, high = (float(each) for each in np.quantile(finite, (0.02, 0.98))) if finite.size else (0.0, 1.0)
        strength = self._scale(f"echo {words}", lambda: Scale(low, max(high, low + 1.0), style.POWER_COLOURS, words))
        panels: Panels = [(Panel("Echo power", strength, 1), power)]
        if self.results.has_maps:
            for title, name, scale in (
                ("Interferometric phase", "phase", Scale(-np.pi, np.pi, "twilight", "Phase (rad)")),
                ("Coherence", "coherence", Scale(0.0, 1.0, "cividis", "Coherence")),
            ):
                panels.append((Panel(title, scale), self.results.field(f"maps/polar/{name}", index)))
        return panels

    def _power(self, index: int) -> tuple[Array, str]:
        """Mean power of the echoes (look, gate), and its unit; the cells' signal to noise ratio where they are gone."""
        try:
            if self._echoes is None or int(self._echoes["turn"].values[-1]) < index:
                self._echoes = open_echoes(self.results.folder)
            echoes, noise = self._echoes, reduce.number(self._echoes.attrs.get("noise_power_w", 0.0))
            power, _ = reduce.mean_power(echoes, self.layout.azimuth, self.results.turns()[index], 1.8)
            order, _ = reduce.look_edges(self.layout.azimuth, 1.8)
            level = np.empty_like(power)
            level[order] = reduce.power_db(power, noise)
            gates = np.asarray(echoes["range"].values)
            place = np.clip(np.searchsorted(gates, self.layout.range), 0, gates.size - 1)
            return level[:, place], "Power (dB over noise)" if noise > 0.0 else "Power (dB over 1 W)"
        except (InputError, SchemaError, OSError, IndexError, KeyError):
            return self.results.field("maps/polar/snr_db", index), "One pulse (dB over noise)"

    def _scale(self, name: str, make: Any) -> Scale:
        """Once made, a scale stays, so that turns are held against each other."""
        if name not in self._scales:
            self._scales[name] = make()
        return self._scales[name]

    def polar(self, index: int) -> xr.Dataset:
        """What estimators of waves read of a turn's polar map, (azimuth, range); of the truth's where no map is."""
        results = self.results
        tree = "maps/polar" if results.has_maps else "truth/polar"
        table = SCHEMA[tree]
        names = [name for name in _OF_WAVES if results.has_field(f"{tree}/{name}")]
        values: dict[str, Any] = {name: results.field(f"{tree}/{name}", index) for name in names}
        if "quality" in values:
            values["quality"] = np.nan_to_num(values["quality"]).astype(np.int16)
        values["time"] = values["time"].astype(np.float64)
        coordinates = {"azimuth": self.layout.azimuth, "range": self.layout.range, "turn": results.turns()[index]}
        variables = {name: (table[name].dims[1:], each) for name, each in values.items()}
        return xr.Dataset(variables, coordinates, results.attributes(tree))


_NUMBERS = count()
_MOST_OPEN = 4
_OPEN: dict[int, Source] = {}  # in a process that draws, those of the page by their numbers


def _open_local(folder: Path, number: int) -> Source:
    if number not in _OPEN:
        _OPEN[number] = Source(Results(folder))
        while len(_OPEN) > _MOST_OPEN:
            _OPEN.pop(next(iter(_OPEN))).results.close()
    _OPEN[number] = _OPEN.pop(number)  # the one used last is the last
    return _OPEN[number]


def _signed_scale(true: Array, retrieved: Array, what: str) -> Scale:
    of_slope = what == "slope"
    limit = (maps.slope_limit if of_slope else maps.height_limit)(true.astype(np.float64), retrieved.astype(np.float64))
    colours = style.SLOPE_COLOURS if of_slope else style.HEIGHT_COLOURS
    return Scale(-limit, limit, colours, "Slope" if of_slope else "Height (m)")


def error_scale(error: Array, words: str, colours: str = style.HEIGHT_COLOURS) -> Scale:
    """A scale that reaches as far to either side as nearly all values."""
    limit = reduce.quantile(np.abs(error), 0.98)
    limit = float(f"{max(limit, 0.01):.2g}") if np.isfinite(limit) else 0.1
    return Scale(-limit, limit, colours, words)


def _spread_scale(spread: Array) -> Scale:
    high = reduce.quantile(spread, 0.95)
    return Scale(0.0, float(f"{max(high, 0.01):.2g}") if np.isfinite(high) else 0.1, style.SPREAD_COLOURS, "Error (m)")
