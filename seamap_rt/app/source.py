"""A run's results as its views need them: panels of maps, the section along a look, curves against range."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import wrap_degrees
from ..errors import InputError, SchemaError
from ..interferometry import open_echoes
from ..metrics import counts
from ..report import maps, reduce, style
from ..report.curves import ByRange
from ..schema import SCHEMA
from .figures import MapPanels, Panel, Raster, Scale, ground_raster, polar_raster
from .prospects import Prospects, prospects
from .results import Array, Results

Panels = list[tuple[Panel, Array]]
MAP_VIEWS = {"heights": "Heights", "slopes": "Slopes", "polar": "Radar cells", "echo": "Echo"}
_WIDE = 1.96


_BIN_M, _FEWEST = 10.0, 8


class Source:
    """A run's results with what its views need beside them: rasters and scales, which stay while it is seen.

    Given to another process, it is opened there once, and stays while it is among the last.
    """

    def __init__(self, results: Results) -> None:
        self.results, self.layout = results, results.layout()
        self.number = next(_NUMBERS)
        self.scene = results.scene()
        self._rasters: dict[str, Raster] = {}
        self._scales: dict[str, Scale] = {}
        self._echoes: xr.Dataset | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return _opened_here, (self.results.folder, self.number)

    @cached_property
    def height_m(self) -> float:
        """Of the antennas: by the scene, else as the maps have slant and ground ranges, else as the echoes say."""
        if self.scene is not None:
            return self.scene.radar.height_m
        try:
            if self.results.has_maps:
                square = self.layout.range**2 - self.results.field("maps/polar/ground_range", 0).astype(np.float64) ** 2
                known = square[np.isfinite(square)]
                return float(np.sqrt(max(np.median(known), 0.0))) if known.size else 0.0
            return float(open_echoes(self.results.folder / "echoes.zarr").attrs["height_m"])
        except (InputError, SchemaError, OSError, KeyError, IndexError, ValueError):
            return 0.0

    @property
    def ground_m(self) -> NDArray[np.float64]:
        """(gate,): where the gates meet mean sea level."""
        return reduce.ground_range(self.layout.range, self.height_m)

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
                seen = self.seen(index)
                self._rasters[kind] = ground_raster(self.layout.x, self.layout.y, seen)
        return self._rasters[kind]

    def seen(self, index: int) -> NDArray[np.bool_]:
        """(row, column) of the ground cells that the beam passed in a turn."""
        tree = "maps" if self.results.has_maps else "truth"
        return np.isfinite(self.results.field(f"{tree}/ground/time", index))

    def _both(self, name: str, index: int) -> tuple[Array | None, Array | None]:
        """A field, named as "ground/height", as it is and as it was retrieved; None of what is not known. Of the ground
        what the beam passed."""
        results = self.results
        true = results.field(f"truth/{name}", index) if results.has_truth else None
        if true is not None and name.startswith("ground/"):
            true = np.where(self.seen(index), true, np.nan)
        return true, results.field(f"maps/{name}", index) if results.has_maps else None

    def _pair(self, words: str, scale: str, true: Array | None, retrieved: Array | None, digits: int = 2) -> Panels:
        """What there is of both on one scale."""
        there = [(name, each) for name, each in (("True", true), ("Retrieved", retrieved)) if each is not None]
        on = self._scale(scale, lambda: _signed(there[0][1], there[-1][1], words.split()[0]))
        return [(Panel(f"{name} {words}", on, digits), each) for name, each in there]

    def _stated(self, group: str, index: int) -> Panels:
        """What the retrieval states of its heights; nothing of a simulation."""
        if not self.results.has_maps:
            return []
        spread = self.results.field(f"maps/{group}/height_std", index)
        return [(Panel("Stated error", self._scale(f"{group} spread", lambda: _spread(spread)), 3), spread)]

    def _heights(self, index: int) -> Panels:
        true, retrieved = self._both("ground/height", index)
        panels = self._pair("height", "height", true, retrieved)
        if true is not None and retrieved is not None:
            error = retrieved - true
            wrong = self._scale("error", lambda: error_scale(error, "Error (m)"))
            panels.append((Panel("Error", wrong, 3), error))
        return panels + self._stated("ground", index)

    def _slopes(self, index: int) -> Panels:
        pairs = {to: self._both(f"ground/{name}", index) for name, to in (("slope_x", "east"), ("slope_y", "north"))}
        true, retrieved = ([pair[i] for pair in pairs.values() if pair[i] is not None] for i in (0, 1))
        self._scale("slope", lambda: _signed(np.stack(true or retrieved), np.stack(retrieved or true), "slope"))  # type: ignore[arg-type]
        panels: Panels = []
        for to, (t, r) in pairs.items():
            panels += self._pair(f"slope to {to}", "slope", t, r, digits=3)
            if t is not None and r is not None:
                wrong = self._scale(f"error {to}", lambda e=r - t: error_scale(e, "Error", style.SLOPE_COLOURS))
                panels.append((Panel(f"Error to {to}", wrong, 3), r - t))
        return panels

    def _polar(self, index: int) -> Panels:
        panels = self._pair("height", "polar height", *self._both("polar/height", index))
        if self.results.has_truth:
            seen = Scale(0.0, 1.0, "cividis", "Share in sight")
            share = self.results.field("truth/polar/visible_fraction", index)
            panels.append((Panel("In sight of both antennas", seen), share))
        return panels + self._stated("polar", index)

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
                self._echoes = open_echoes(self.results.folder / "echoes.zarr")
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

    # -------------------------------------------------------------------------------------------------- section

    def section(self, azimuth_deg: float, index: int) -> Section:
        """The look that is nearest to an azimuth."""
        look = int(np.argmin(np.abs(wrap_degrees(self.layout.azimuth - azimuth_deg))))
        field, ground = self.results.field, self.ground_m
        missing = np.full(ground.size, np.nan)
        known, mapped = self.results.has_truth, self.results.has_maps
        placed = field("maps/polar/ground_range", index)[look] if mapped else missing
        return Section(
            azimuth_deg=float(self.layout.azimuth[look] % 360.0),
            ground_m=ground,
            true=field("truth/polar/height", index)[look].astype(np.float64) if known else missing,
            visible=field("truth/polar/visible_fraction", index)[look].astype(np.float64) if known else missing,
            placed_m=np.where(np.isfinite(placed), placed, ground).astype(np.float64),
            retrieved=field("maps/polar/height", index)[look].astype(np.float64) if mapped else missing,
            spread=field("maps/polar/height_std", index)[look].astype(np.float64) if mapped else missing,
            antenna_m=self.height_m,
        )

    def polar(self, index: int) -> xr.Dataset:
        """What estimators of waves read of a turn's polar map, (azimuth, range); of the truth's where no map is."""
        results = self.results
        tree = "maps/polar" if results.has_maps else "truth/polar"
        table = SCHEMA[tree]
        names = [name for name in _OF_WAVES if results.has(f"{tree}/{name}")]
        values: dict[str, Any] = {name: results.field(f"{tree}/{name}", index) for name in names}
        if "quality" in values:
            values["quality"] = np.nan_to_num(values["quality"]).astype(np.int16)
        values["time"] = values["time"].astype(np.float64)
        coordinates = {"azimuth": self.layout.azimuth, "range": self.layout.range, "turn": results.turns()[index]}
        variables = {name: (table[name].dims[1:], each) for name, each in values.items()}
        return xr.Dataset(variables, coordinates, results.attributes(tree))

    # ------------------------------------------------------------------------------------------------- by range

    def by_range(self, index: int) -> ByRange:
        """Errors of a turn by ground range, what it states of them, and how much is seen."""
        field, ground = self.results.field, self.ground_m
        blank_map = np.full((self.layout.azimuth.size, ground.size), np.nan)
        spread, retrieved = (
            field(f"maps/polar/{name}", index) if self.results.has_maps else blank_map
            for name in ("height_std", "height")
        )
        edges = np.arange(0.0, ground[-1] + _BIN_M, _BIN_M)
        place = np.searchsorted(edges, ground, side="right") - 1
        centres = 0.5 * (edges[1:] + edges[:-1])
        count, blank = centres.size, np.full(centres.size, np.nan)
        known = np.isfinite(retrieved)
        answered = _binned(known.astype(float), place, count, np.mean)
        if not self.results.has_truth:
            stated = _binned(np.where(known, spread, np.nan), place, count, np.nanmedian)
            return ByRange(centres, blank, blank, blank, stated, blank, blank, blank, answered)
        visible = field("truth/polar/visible_fraction", index)
        error = retrieved - field("truth/polar/height", index)
        flags = field("maps/polar/quality", index) if self.results.has_maps else np.zeros(visible.shape)
        counted = counts(error, flags, visible)
        error = np.where(counted, error, np.nan)
        slope, slope_spread = blank_map, blank_map
        if self.results.has("maps/polar/slope_range_std"):
            slope = field("maps/polar/slope_range", index) - field("truth/polar/slope_range", index)
            slope_spread = field("maps/polar/slope_range_std", index)
        return ByRange(
            centres,
            _binned(error, place, count, _rms),
            _binned(error, place, count, _robust),
            _binned(error, place, count, np.nanmean),
            _binned(np.where(counted, spread, np.nan), place, count, np.nanmedian),
            _binned(np.where(counted, slope, np.nan), place, count, _rms),
            _binned(np.where(counted, slope_spread, np.nan), place, count, np.nanmedian),
            _binned(visible, place, count, np.nanmean),
            answered,
        )

    def expected(self) -> Prospects | None:
        """What its design was likely to do, for floors and closed forms; None of a retrieval."""
        return prospects(self.scene) if self.scene is not None else None


_OF_WAVES = ("height", "height_std", "ground_range", "quality", "radial_velocity", "visible_share", "time")
_OF_WAVES += ("antenna_x", "antenna_y")  # of a boat that moves

_NUMBERS = count()
_MOST_OPEN = 4
_OPEN: dict[int, Source] = {}  # in a process that draws, those of the page by their numbers


def _opened_here(folder: Path, number: int) -> Source:
    if number not in _OPEN:
        _OPEN[number] = Source(Results(folder))
        while len(_OPEN) > _MOST_OPEN:
            _OPEN.pop(next(iter(_OPEN))).results.close()
    _OPEN[number] = _OPEN.pop(number)  # the one used last is the last
    return _OPEN[number]


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

    @property
    def low(self) -> Array:
        return self.retrieved - _WIDE * self.spread

    @property
    def high(self) -> Array:
        return self.retrieved + _WIDE * self.spread

    def shadows(self) -> list[tuple[float, float]]:
        """From where to where less than half is in sight."""
        dark = np.concatenate(([False], np.nan_to_num(self.visible, nan=1.0) < 0.5, [False]))
        begin, end = np.flatnonzero(dark[1:] & ~dark[:-1]), np.flatnonzero(dark[:-1] & ~dark[1:])
        borders = reduce.edges(self.ground_m)
        return [(float(borders[a]), float(borders[b])) for a, b in zip(begin, end, strict=True)]

    def rays(self) -> list[tuple[float, float]]:
        """Where rays over the crests meet the sea again: the first lit place behind each shadow, and its height."""
        landed = []
        for _, end in self.shadows():
            gate = int(np.searchsorted(self.ground_m, end))
            if gate < self.ground_m.size and np.isfinite(self.true[gate]):
                landed.append((float(self.ground_m[gate]), float(self.true[gate])))
        return landed


def _rms(values: Array) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))


def _robust(error: Array) -> float:
    """1.4826 × the median absolute deviation, of what is known."""
    return reduce.MAD_TO_STD * float(np.nanmedian(np.abs(error - np.nanmedian(error))))


def _binned(values: Array, place: NDArray[np.intp], count: int, of: Any) -> NDArray[np.float64]:
    found = np.full(count, np.nan)
    for number in range(count):
        held = values[:, place == number]
        if np.isfinite(held).sum() >= _FEWEST:
            found[number] = float(of(held))
    return found


def _signed(true: Array, retrieved: Array, what: str) -> Scale:
    of_slope = what == "slope"
    limit = (maps.slope_limit if of_slope else maps.height_limit)(true.astype(np.float64), retrieved.astype(np.float64))
    colours = style.SLOPE_COLOURS if of_slope else style.HEIGHT_COLOURS
    return Scale(-limit, limit, colours, "Slope" if of_slope else "Height (m)")


def error_scale(error: Array, words: str, colours: str = style.HEIGHT_COLOURS) -> Scale:
    """As far to either side as nearly all values go."""
    limit = reduce.quantile(np.abs(error), 0.98)
    limit = float(f"{max(limit, 0.01):.2g}") if np.isfinite(limit) else 0.1
    return Scale(-limit, limit, colours, words)


def _spread(spread: Array) -> Scale:
    high = reduce.quantile(spread, 0.95)
    return Scale(0.0, float(f"{max(high, 0.01):.2g}") if np.isfinite(high) else 0.1, style.SPREAD_COLOURS, "Error (m)")
