"""A recorded sea: its surface over a square patch, frame by frame, from a file of any size.

NetCDF or Zarr by the rules below, and the other layouts of `recorded_layouts`. The variable of the elevation has the
axes time, y and x in any order, evenly spaced; its name is one of `NAMES`, or its standard_name one of CF's for the
height of the sea surface. Axes are known by their names, or by CF's `axis` or standard_name (a map projection's
coordinates). Lengths may be in mm, cm, m or km, times in seconds or dates. `surface_potential` [m² s⁻¹], where it is
there, is the velocity potential at the surface; else the water's velocity there may be given by `FLOWS`, or CF's names.
Global attributes: periodic (1: the patch repeats), depth_m. One frame is read at a time.

Cameras do not see all of their grid. What is missing at the patch's edges in most frames is cut off: the patch is the
largest square without. Other gaps are filled (`sea_grid`), and each frame states how wide they are.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..errors import InputError, Refusal, say_of
from .opening import bytes_held, check_declared_size
from .recorded_layouts import open_layout
from .sea_grid import (
    UNEVEN,
    axes_of,
    check_step,
    even_step,
    fill_gaps,
    half_width,
    largest_square,
    places_of,
    seconds_of,
    unit_scale,
    unseen_edges,
)

NAMES = ("elevation", "eta", "sea_surface_elevation", "surface_elevation", "zeta", "ssh", "height", "z", "zgrid")
POTENTIAL = "surface_potential"
FLOWS = (  # names of the water's horizontal velocity at the surface, east and north
    ("velocity_east", "velocity_north"),
    ("u", "v"),
)
_FLOW_STANDARDS = (
    ("sea_water_x_velocity", "sea_water_y_velocity"),
    ("eastward_sea_water_velocity", "northward_sea_water_velocity"),
)
_STANDARD = "sea_surface_height"
_HIGHEST_M = 30.0
_SPACINGS_M, _STEPS_S = (1e-3, 100.0), (1e-3, 10.0)  # those of any sea that a radar maps
_FEWEST_POINTS, _FEWEST_FRAMES = 16, 14
_LOOKED_AT = 12  # frames from which the mean level is taken, and what is never seen
_MOST_MISSING = 0.5  # of a frame
_RIM = 0.05  # of a patch's side that does not repeat, at its edges


@dataclass(frozen=True)
class RecordedSea:
    """What a file of a recorded sea holds; frames are read as they are asked for. Safe in threads.

    begin_s: the file's time of its first frame, 0 of dates, and then began: that date;
    spacing_m, points: of the square patch, a side; west_m, south_m: of its first point from the antenna; step_s,
    frames: in time; depth_m: None where the file does not say; flow: names of its velocities, where it has them; cut:
    of the file's own points, those of the patch are fewer; level_m: the file's mean level, which is taken off, 0 where
    the patch repeats; long_share: of the variance, by which a patch that ends rises and falls as a whole: waves that it
    is too small for."""

    path: str
    name: str
    frames: int
    step_s: float
    points: int
    spacing_m: float
    west_m: float
    south_m: float
    periodic: bool
    depth_m: float | None
    potential: bool
    flow: tuple[str, str] | None
    cut: bool
    level_m: float
    long_share: float
    begin_s: float
    began: np.datetime64 | None
    _first: tuple[int, int]  # row and column of the patch in the file

    def time_in_words(self, time_s: float) -> str:
        """A time of the file, in s as `begin_s`, in its own words."""
        if self.began is None:
            return f"{time_s:.6g} s"
        return str(np.datetime_as_string(self.began + np.timedelta64(round(1e9 * time_s), "ns"), unit="ms"))

    @property
    def side_m(self) -> float:
        """The patch's side, with a cell around each of its points: the period of a patch that repeats."""
        return self.points * self.spacing_m

    @property
    def edges_m(self) -> tuple[float, float, float, float]:
        """West, east, south and north of the cells of its points, from the antenna."""
        west, south = self.west_m - 0.5 * self.spacing_m, self.south_m - 0.5 * self.spacing_m
        return west, west + self.side_m, south, south + self.side_m

    @property
    def rim(self) -> int:
        """Points at its edges in which a patch that does not repeat may be brought to its mean level."""
        return 0 if self.periodic else max(4, round(_RIM * self.points))

    @property
    def rim_m(self) -> float:
        """How wide at its edges a patch that does not repeat is not judged: its rim, and a point."""
        return 0.0 if self.periodic else (self.rim + 1) * self.spacing_m

    @property
    def judged_m(self) -> tuple[float, float, float, float]:
        """West, east, south and north, from the antenna, of what may be judged: `edges_m` less the rim."""
        west, east, south, north = self.edges_m
        return west + self.rim_m, east - self.rim_m, south + self.rim_m, north - self.rim_m

    @property
    def reach_m(self) -> float:
        """How far around the antenna the sea is that of the file: half the side of a patch that repeats; below 0 where
        the antenna stands in the rim."""
        if self.periodic:
            return 0.5 * self.side_m
        west, east, south, north = self.judged_m
        return min(-west, east, -south, north)

    def holds(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which places, m from the antenna, lie in the patch and not in its rim; all, where it repeats."""
        if self.periodic:
            return np.ones(np.broadcast(x, y).shape, dtype=bool)
        west, east, south, north = self.judged_m
        return (x >= west) & (x <= east) & (y >= south) & (y <= north)

    def elevation(self, frame: int) -> NDArray[np.float64]:
        """(row, column) m above its mean, rows to the north; see `elevation_and_gap`."""
        return self.elevation_and_gap(frame)[0]

    def elevation_and_gap(self, frame: int) -> tuple[NDArray[np.float64], float]:
        """(row, column) m above its mean, rows to the north, gaps filled; and the half-width [m] of the widest gap.

        Raises InputError for a frame that is not a sea's, and for gaps that cannot be filled: of most of it, or from
        the patch's edge into what is judged.
        """
        values = self._read(self.name, frame) - self.level_m
        gap = ~np.isfinite(values)
        wide = 0.0
        with say_of(f"sea.file = '{self.path}': frame {frame} "):
            if gap.any():
                share = float(np.mean(gap))
                if share > _MOST_MISSING:
                    raise Refusal(f"has gaps ({share:.1%}), and at most {_MOST_MISSING:.0%} may be; leave it out")
                middle = slice(self.rim, self.points - self.rim)
                if unseen_edges(gap)[middle, middle].any():
                    raise Refusal(f"has gaps from the edge of the patch inwards ({share:.1%}); cut them off")
                wide = half_width(gap) * self.spacing_m
                values = fill_gaps(values, gap)
            if (highest := float(np.abs(values).max())) > _HIGHEST_M:
                raise Refusal(
                    f"holds {highest:.4g} m: must be at most {_HIGHEST_M:g} (no sea above 30 m); check the units of "
                    f"{self.name}"
                )
        return values, wide

    def surface_potential(self, frame: int) -> NDArray[np.float64]:
        """(row, column) m²/s, gaps filled."""
        return self._read_filled(POTENTIAL, frame)

    def surface_flow(self, frame: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The water's velocity at the surface to east and north, each (row, column) m/s, gaps filled."""
        assert self.flow is not None
        return self._read_filled(self.flow[0], frame), self._read_filled(self.flow[1], frame)

    def _read_filled(self, name: str, frame: int) -> NDArray[np.float64]:
        values = self._read(name, frame)
        gap = ~np.isfinite(values)
        return fill_gaps(values, gap) if gap.any() and not gap.all() else np.nan_to_num(values)

    def _read(self, name: str, frame: int) -> NDArray[np.float64]:
        with say_of(f"sea.file = '{self.path}': "):
            if not 0 <= frame < self.frames:
                raise Refusal(f"holds frames 0 to {self.frames - 1}, asked for {frame}")
            with _LOCK:
                whole = _open_dataset(self.path, _file_version(self.path))
                cut = _read_square(whole, whole[name], frame, self._first, (self.points, self.points))
            return cut * unit_scale(whole[name], {self.name: "m", POTENTIAL: "m²/s"}.get(name, "m/s"))


_LOCK = threading.Lock()


def recorded_sea(path: str) -> RecordedSea:
    """What a file holds. Raises InputError of one line for a file that is not a recorded sea."""
    with say_of(f"sea.file = '{path}': "):
        try:
            return _describe_file(path, _file_version(path))
        except InputError:
            raise
        except (OSError, ValueError, KeyError) as error:
            what = str(error).split("\n")[0][:160]
            raise Refusal(
                f"cannot be read as NetCDF or Zarr ({what}); give a file with the elevation over time, y and x"
            ) from None


@lru_cache(maxsize=8)
def _describe_file(path: str, version: tuple[int, int]) -> RecordedSea:
    with _LOCK:
        opened = _open_dataset(path, version)
    grids = [str(name) for name in opened.data_vars if len(axes_of(opened[name])) == 3 and opened[name].ndim == 3]
    named = [name for wanted in NAMES for name in grids if name.lower() == wanted]
    named += [name for name in grids if str(opened[name].attrs.get("standard_name", "")).startswith(_STANDARD)]
    if not named:
        there = (
            ", ".join(f"{each} ({', '.join(map(str, opened[each].dims))})" for each in opened.data_vars) or "nothing"
        )
        raise Refusal(
            f"holds no elevation over time, y and x (it has {there}); "
            f"name the variable one of {', '.join(NAMES[:6])}, and its axes time, y and x"
        )
    name = named[0]
    axes = axes_of(opened[name])
    scale = unit_scale(opened[name], "m")
    x, y = (places_of(opened[axes[each]]) for each in ("x", "y"))
    spacing = [even_step(values, _FEWEST_POINTS, axes[each]) for each, values in (("x", x), ("y", y))]
    if abs(spacing[0] - spacing[1]) > UNEVEN * spacing[0]:
        raise Refusal(f"x and y are {spacing[0]:.4g} and {spacing[1]:.4g} m apart: must be alike; resample it")
    check_step(spacing[0], _SPACINGS_M, "m", f"{axes['x']} and {axes['y']}: points")
    times, began = seconds_of(opened[axes["time"]])
    step = even_step(times, _FEWEST_FRAMES, axes["time"])
    if times[1] < times[0]:
        raise Refusal(f"{axes['time']} runs backwards; turn it round")
    check_step(step, _STEPS_S, "s", f"{axes['time']}: frames")
    periodic = bool(int(opened.attrs.get("periodic", 0)))
    if periodic and x.size != y.size:
        raise Refusal(f"is {x.size} × {y.size} points: a patch that repeats must be square; resample it")
    check_declared_size(f"sea.file = '{path}'", 8.0 * x.size * y.size, bytes_held(path))
    x, y = np.sort(x), np.sort(y)
    free, level, long_share = np.ones((y.size, x.size), dtype=bool), 0.0, 0.0
    if not periodic:
        free, level, long_share = _uncut_points(opened, name, times.size, scale)
    first, points = _square(x, y, free)
    if points < _FEWEST_POINTS:
        raise Refusal(
            f"the largest square without gaps at its edges has {points} points a side: must have at least "
            f"{_FEWEST_POINTS}; give more of it"
        )
    corner = _corner(x, y, first, points)
    depth = opened.attrs.get("depth_m")
    return RecordedSea(
        path=path,
        name=name,
        frames=times.size,
        step_s=step,
        points=points,
        spacing_m=spacing[0],
        west_m=corner[1],
        south_m=corner[0],
        periodic=periodic,
        depth_m=None if depth is None else float(depth),
        potential=POTENTIAL in opened and set(opened[POTENTIAL].dims) == set(opened[name].dims),
        flow=_flow_of(opened, opened[name]),
        cut=points < max(x.size, y.size),
        _first=first,
        level_m=level,
        long_share=min(long_share, 1.0),
        begin_s=float(times[0]),
        began=began,
    )


def _uncut_points(opened: xr.Dataset, name: str, frames: int, scale: float) -> tuple[NDArray[np.bool_], float, float]:
    """Which points (row, column), rows to the north, are not cut off: those that reach the edge through points missing
    in most frames are; the mean level of the others, m; and the share of the variance by which whole frames rise and
    fall."""
    axes = axes_of(opened[name])
    size = opened[name].sizes[axes["y"]], opened[name].sizes[axes["x"]]
    seen, total, square, means = np.zeros(size), np.zeros(size), 0.0, []
    chosen = np.unique(np.linspace(0, frames - 1, _LOOKED_AT).astype(int))
    for frame in chosen:
        with _LOCK:
            values = _read_square(opened, opened[name], int(frame), (0, 0), size)
        known = np.isfinite(values)
        seen += known
        total += np.where(known, values, 0.0)
        square += float(np.sum(np.square(values[known])))
        means += [float(values[known].mean())] if known.any() else []
    if not means:
        raise Refusal(f"{name} is missing everywhere in the frames that were looked at; give others")
    free = ~unseen_edges(seen <= 0.5 * chosen.size)
    level = float(total[free].sum() / max(seen[free].sum(), 1.0))
    variance = square / float(seen.sum()) - level**2
    return free, scale * level, float(np.var(means) / variance) if variance > 0.0 else 0.0


def _square(x: NDArray, y: NDArray, free: NDArray[np.bool_]) -> tuple[tuple[int, int], int]:
    """First row and column of the patch, and its points a side: the largest free square, as near as can be to the
    antenna at 0, 0, or where that is not in the grid to its middle."""
    inside = x[0] <= 0.0 <= x[-1] and y[0] <= 0.0 <= y[-1]
    middle = [float(np.argmin(np.abs(axis))) if inside else 0.5 * (axis.size - 1) for axis in (y, x)]
    if free.all():
        points = min(x.size, y.size)
        row, column = (
            int(np.clip(round(at) - points // 2, 0, axis.size - points))
            for at, axis in zip(middle, (y, x), strict=True)
        )
        return (row, column), points
    return largest_square(free, (middle[0], middle[1]))


def _corner(x: NDArray, y: NDArray, first: tuple[int, int], points: int) -> tuple[float, float]:
    """South and west of the patch's first point from the antenna, which stands at 0, 0, or where that is not in the
    patch in its middle."""
    parts = [axis[start : start + points] for axis, start in zip((y, x), first, strict=True)]
    inside = all(part[0] <= 0.0 <= part[-1] for part in parts)
    antenna = [0.0 if inside else float(0.5 * (part[0] + part[-1])) for part in parts]
    return float(parts[0][0] - antenna[0]), float(parts[1][0] - antenna[1])


# ------------------------------------------------------------------------------------------------------ the file


def _file_version(path: str) -> tuple[int, int]:
    status = Path(path).stat()
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=4)
def _open_dataset(path: str, _: tuple[int, int]) -> xr.Dataset:
    return open_layout(Path(path))


def _read_square(
    opened: xr.Dataset, values: xr.DataArray, frame: int, first: tuple[int, int], size: tuple[int, int]
) -> NDArray[np.float64]:
    """Points (row, column) of a frame from the first row and column on, rows to the north and columns to the east."""
    axes = axes_of(values)
    one = values.isel({axes["time"]: frame}).transpose(axes["y"], axes["x"])
    falling = [axis for axis in one.dims if opened[axis].values[-1] < opened[axis].values[0]]
    one = one.isel({axis: slice(None, None, -1) for axis in falling})
    taken = (slice(start, start + count) for start, count in zip(first, size, strict=True))
    return one.isel(dict(zip(one.dims, taken, strict=True))).values.astype(np.float64)


def _flow_of(opened: xr.Dataset, elevation: xr.DataArray) -> tuple[str, str] | None:
    """The names of both velocities over the elevation's axes, if the file has them."""
    there = {str(name): each for name, each in opened.data_vars.items() if set(each.dims) == set(elevation.dims)}
    standard = {str(each.attrs.get("standard_name", "")): name for name, each in there.items()}
    for known, held in ((FLOWS, {name: name for name in there}), (_FLOW_STANDARDS, standard)):
        for east, north in known:
            if east in held and north in held:
                for name in (held[east], held[north]):
                    unit_scale(there[name], "m/s")
                return held[east], held[north]
    return None
