"""The square maps on the ground, from the polar map and the points of its cells; also at one instant.

From a boat at rest a look's cells lie on a straight line. Those of a boat that moves or rolls do not: they are laid
where their own heights put them, by azimuth and distance from one centre, first along each look and then across the
looks, and sampled on a square grid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..compute.compiled import compiled
from ..compute.machine import run_blocks
from ..conventions import unit_from_azimuth, wrap_degrees
from ..dataset import WATER_ATTRIBUTES, build
from ..physics.dispersion import Water
from ..radar.grid import GroundGrid, LookFan, ground_grid, look_sweeps
from ..settings import RetrievalSettings
from ..wavefield.advance import GroundFields, advanced
from ..wavefield.wave_direction import map_travel, travel
from .description import RadarDescription
from .poses import Heights, LookPoses


@compiled
def resample_rows(position, fields, at, widest_gap, result):
    """Write into result (row, at, field) the fields (field, row, cell), linear in position (row, cell) between valid
    cells no more than widest_gap apart. `at` rises."""
    order = np.empty(position.shape[1], np.int64)
    for row in range(position.shape[0]):
        own = position[row]
        known = 0
        for cell in range(own.size):  # sorted by insertion: points mostly rise
            if not math.isfinite(own[cell]):
                continue
            n = known
            while n > 0 and own[order[n - 1]] > own[cell]:
                order[n] = order[n - 1]
                n -= 1
            order[n] = cell
            known += 1
        if known < 2:
            continue
        after = 1
        for m in range(at.size):
            while after < known - 1 and own[order[after]] < at[m]:
                after += 1
            before, behind = order[after - 1], order[after]
            gap = own[behind] - own[before]
            if own[before] <= at[m] <= own[behind] and gap <= widest_gap:
                share = (at[m] - own[before]) / gap if gap > 0.0 else 0.0
                for field in range(fields.shape[0]):
                    low, high = fields[field, row, before], fields[field, row, behind]
                    result[row, m, field] = low + share * (high - low)


@compiled
def mean_of_samples(begin, end, laid, fan, middle, x, y, sweep, result):
    """Write into rows begin … end of result (field, row, column) the mean of each square's bilinear values, if more
    than half are known.

    laid (look, distance, field); fan: the first look's angle and the spacing [deg], whether it closes, the first
    distance and their spacing [m]. middle (row, column): angle of the squares' centres [deg]; x and y [m] from the
    fan's centre of evenly many columns and rows of samples in each, and the angle (y, x) of each, whole turns apart.
    """
    looks, distances, fields = laid.shape
    high, wide = sweep.shape[0] // middle.shape[0], sweep.shape[1] // middle.shape[1]
    per_look, per_metre, closed = 1.0 / fan[1], 1.0 / fan[4], fan[2] > 0.0
    flat, corner, share = laid.ravel(), np.empty((4, high * wide), np.uint64), np.empty((4, high * wide))
    for row in range(begin, end):
        for column in range(middle.shape[1]):
            samples = 0
            for n in range(row * high, (row + 1) * high):
                for m in range(column * wide, (column + 1) * wide):
                    reach = (math.sqrt(x[m] * x[m] + y[n] * y[n]) - fan[3]) * per_metre
                    # A square that straddles the start of the turn stays on its centre's side: beyond it is a turn ago.
                    beside = sweep[n, m] - middle[row, column]
                    beside -= 360.0 * math.floor(beside * (1.0 / 360.0) + 0.5)
                    number = (middle[row, column] + beside - fan[0]) * per_look
                    # Before the first look and after the last the nearest of them serves, as far as half a look; all
                    # the way in a full circle, whose ends lie a turn apart in time and are not blended.
                    inside = closed or -0.5 <= number <= looks - 0.5
                    if not (inside and 0.0 <= reach <= distances - 1.0):
                        continue
                    number = min(max(number, 0.0), looks - 1.0)
                    low, near = int(number), min(int(reach), distances - 2)
                    across, along = number - low, reach - near
                    first = (low * distances + near) * fields
                    second = first + distances * fields if across > 0.0 else first
                    corner[0, samples], corner[1, samples] = first, first + fields
                    corner[2, samples], corner[3, samples] = second, second + fields
                    share[0, samples], share[1, samples] = (1.0 - across) * (1.0 - along), (1.0 - across) * along
                    share[2, samples], share[3, samples] = across * (1.0 - along), across * along
                    samples += 1
            if 2 * samples <= high * wide:
                continue
            for field in range(np.uint64(fields)):
                total, count = 0.0, 0
                for sample in range(np.uint64(samples)):
                    value = 0.0
                    for n in range(4):
                        value += share[n, sample] * flat[corner[n, sample] + field]
                    if value == value:
                        total += value
                        count += 1
                if 2 * count > high * wide:
                    result[field, row, column] = total / count


@dataclass(frozen=True)
class Ground:
    """Where a moving or rolling boat's cells lie: arrays (look, gate) [m], None for one at rest and upright; `centre`
    is the mean place of its antennas over the turn."""

    x: NDArray[np.float64] | None = None
    y: NDArray[np.float64] | None = None
    centre: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, poses: LookPoses, heights: Heights, sweeps: NDArray[np.float64]) -> Ground:
        """Where cells lie; sweeps: centres of the looks [deg], (look,)."""
        if poses.at_rest:
            return cls()
        if sweeps.size < 2:  # a single look has no neighbours to lie askew of
            return cls(centre=poses.centre)
        x, y = poses.world(heights.points)
        return cls(x, y, poses.centre)


def ground_map(
    cells: xr.Dataset,
    points: Ground,
    radar: RadarDescription,
    settings: RetrievalSettings,
    turn: int,
    usable: NDArray[np.bool_] | None = None,
) -> xr.Dataset:
    """The ground maps of one turn: each square cell the mean of a few samples of the polar map at its points.

    usable (look, gate): cells that have a part in it; the others are bridged like those without an echo.
    """
    grid = ground_grid(float(radar.ranges[-1]), settings.ground_m)
    sweeps = look_sweeps(radar.sector, settings.cell_azimuth_deg, radar.staring)
    fan = LookFan(sweeps, radar.sector[0], radar.closed, radar.period, turn, settings.cell_azimuth_deg)
    distance = np.arange(0.5 * settings.ground_m, radar.ranges[-1] + settings.ground_m, 0.25 * settings.ground_m)
    fields = _fields(cells, points)
    widest_gap = 1.5 * settings.cell_range_m + radar.spacing
    laid_on, laid = _laid(cells, fields, points, usable, fan, distance, widest_gap)
    x, y = np.meshgrid(grid.x - points.centre[0], grid.y - points.centre[1])
    sweep = fan.sweep_of(x, y)
    values = dict(zip(fields, square_means(laid_on, laid, distance, grid, points.centre, sweep), strict=True))
    inside = np.hypot(x, y) <= radar.ranges[-1]
    if radar.staring:
        inside &= np.abs(sweep - sweeps[0]) <= 0.5 * settings.cell_azimuth_deg
    elif not radar.closed:
        inside &= sweep <= radar.sector[1] - radar.sector[0]
    time = np.where(inside, cells["time"].values[0][0] if radar.staring else fan.time(sweep), np.nan)
    if points.x is not None:
        # Of cells without an echo, when the beam passes their azimuth.
        passes = np.interp(sweep, fan.sweep, cells["time"].values[0])
        time = np.where(inside, np.where(np.isfinite(values["time"]), values["time"], passes), np.nan)
    values["time"] = time
    return build(
        "maps/ground",
        {name: value[None] for name, value in values.items()},
        {"turn": [turn], "y": grid.y, "x": grid.x},
        {"cell_m": settings.ground_m} | {name: cells.attrs[name] for name in WATER_ATTRIBUTES if name in cells.attrs},
    )


def _fields(cells: xr.Dataset, points: Ground) -> dict[str, NDArray[np.float64]]:
    """What the ground map holds of each cell (look, gate)."""
    names = ("range", "azimuth", "range_std", "azimuth_std", "correlation")
    outward, clockwise, along, across, correlation = (cells[f"slope_{name}"].values[0] for name in names)
    east, north = (part[:, None] for part in unit_from_azimuth(cells["azimuth"].values))
    both = 2.0 * correlation * along * across * east * north
    fields = {
        "height": cells["height"].values[0],
        "height_std": cells["height_std"].values[0],
        # Outward is (east, north); clockwise of it is (north, −east).
        "slope_x": outward * east + clockwise * north,
        "slope_y": outward * north - clockwise * east,
        "slope_x_std": np.sqrt((along * east) ** 2 + (across * north) ** 2 + both),
        "slope_y_std": np.sqrt((along * north) ** 2 + (across * east) ** 2 - both),
    }
    if points.x is not None:
        fields["time"] = np.broadcast_to(cells["time"].values[0][:, None], outward.shape)
    return fields


def _laid(
    cells: xr.Dataset,
    fields: dict[str, NDArray[np.float64]],
    points: Ground,
    usable: NDArray[np.bool_] | None,
    fan: LookFan,
    distance: NDArray[np.float64],
    widest_gap: float,
) -> tuple[LookFan, NDArray[np.float64]]:
    """The fields at equal ground ranges (look, distance, field), and the fan of those looks."""
    values = np.array(list(fields.values()), dtype=np.float64)
    ground_range = cells["ground_range"].values[0].astype(np.float64)
    if usable is not None:
        ground_range = np.where(usable, ground_range, np.nan)
    if points.x is None or points.y is None:
        return fan, resample_looks(ground_range, values, distance, widest_gap)
    x, y = points.x - points.centre[0], points.y - points.centre[1]
    away = np.where(np.isfinite(ground_range), np.hypot(x, y), np.nan)
    sweep = fan.sweep[:, None] + wrap_degrees(fan.sweep_of(x, y) - fan.sweep[:, None])
    return centred_looks(fan, sweep, away, values, distance, widest_gap)


_OVERSAMPLING = 3  # looks for one; coarser ones would blur waves across the looks
_SAMPLES = 3  # per side of a ground cell


def resample_looks(
    ground_range: NDArray[np.float64], fields: NDArray[np.float64], distance: NDArray[np.float64], widest_gap: float
) -> NDArray[np.float64]:
    """Fields (field, look, gate) at equal ground ranges, (look, distance, field): linear between valid cells, NaN
    across gaps.

    Cells are sorted by ground range first: on a steep face a nearer gate can lie further out.
    """
    laid = np.full((ground_range.shape[0], distance.size, fields.shape[0]), np.nan)
    resample_rows(np.ascontiguousarray(ground_range), fields, distance, widest_gap, laid)
    return laid


def centred_looks(
    fan: LookFan,
    azimuth_sweep: NDArray[np.float64],
    ground_range: NDArray[np.float64],
    fields: NDArray[np.float64],
    distance: NDArray[np.float64],
    widest_gap: float,
) -> tuple[LookFan, NDArray[np.float64]]:
    """Fields (field, look, gate) of cells that lie anywhere, on a finer fan from a common centre, (look, distance,
    field).

    azimuth_sweep [deg from the sector's start, not wrapped] and ground_range [m] are the cells' own, from that centre.
    Looks more than one and a half apart have a gap between them.
    """
    laid = resample_looks(ground_range, np.concatenate((azimuth_sweep[None], fields)), distance, widest_gap)
    sweep, half = laid[..., 0], 0.5 * fan.spacing
    # The first and the last look serve as far as half a look beyond.
    sweep = np.concatenate((sweep[:1] - half, sweep, sweep[-1:] + half))
    beside = np.concatenate((laid[:1], laid, laid[-1:]))[..., 1:]
    looks = _OVERSAMPLING * fan.sweep.size
    fine = fan.sweep[0] - half + (np.arange(looks) + 0.5) * fan.spacing / _OVERSAMPLING
    across = resample_looks(sweep.T, np.ascontiguousarray(beside.transpose(2, 1, 0)), fine, 1.5 * fan.spacing)
    return replace(fan, sweep=fine), np.ascontiguousarray(across.transpose(1, 0, 2))


def square_means(
    fan: LookFan,
    laid: NDArray[np.float64],
    distance: NDArray[np.float64],
    grid: GroundGrid,
    centre: tuple[float, float],
    middle: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Means (field, y, x) of the fields of a fan (look, distance, field) around `centre` over each square of the grid:
    of a few samples, bilinear in angle and ground range; NaN unless more than half of them are known. middle (y, x):
    the angle from the sector's start to the squares' own centres, 0 … 360 deg.

    Before the first look and after the last the nearest of them serves, as far as half a look; all the way in a full
    circle, whose ends lie a turn apart in time and are not blended.
    """
    x, y, bearing = _samples(grid.x.size // 2, grid.side, *centre)
    sweep = bearing - fan.start_deg if fan.start_deg else bearing
    polar = fan.sweep[0], fan.spacing, float(fan.closed), distance[0], distance[1] - distance[0]
    means = np.full((laid.shape[2], *middle.shape), np.nan)
    laid = np.ascontiguousarray(laid)
    run_blocks(lambda *rows: mean_of_samples(*rows, laid, polar, middle, x, y, sweep, means), len(middle))
    return means


@lru_cache(maxsize=1)
def _samples(reach: int, side: float, east: float, north: float) -> tuple[NDArray[np.float64], ...]:
    """Of a grid that reaches so many squares to either side, east (x,) and north (y,) of its samples from a centre, and
    their bearing (y, x) deg: of a boat that does not move the same at each turn, and as much work as the means."""
    within = side * ((np.arange(_SAMPLES) + 0.5) / _SAMPLES - 0.5)
    centres = side * np.arange(-reach, reach + 1)
    x, y = (((centres - at)[:, None] + within).ravel() for at in (east, north))
    return x, y, np.degrees(np.arctan2(x, y[:, None]))


def advance_to_instant(ground: xr.Dataset, cells: xr.Dataset, to_s: float, water: Water) -> xr.Dataset:
    """The ground map of one turn as the sea stood at to_s [s]; water: that its waves run on.

    The direction in which waves run follows from the radial velocities of the polar map `cells`: water moves with
    the wave at its crests. Where they give none the map stays as it was scanned, each cell at its own time.
    """
    if "radial_velocity" not in cells:
        return ground
    side = float(ground.attrs["cell_m"])
    names = ("height", "height_std", "radial_velocity", "ground_range")
    height, spread, velocity, distance = (np.asarray(cells[name].values[0], dtype=np.float64) for name in names)
    direction = travel(height, spread, velocity, cells["azimuth"].values, distance, side)
    seen = GroundFields(*(np.asarray(ground[each.name].values[0], dtype=np.float64) for each in fields(GroundFields)))
    direction = map_travel(seen.height, seen.height_std, side, direction)
    if not np.isfinite(direction.wave_from_deg):
        return ground
    made = advanced(seen, side, to_s, direction, water)
    at_once = {}
    for each in fields(GroundFields):
        old = ground[each.name]
        at_once[each.name] = (old.dims, getattr(made, each.name)[None].astype(old.dtype), old.attrs)
    return ground.assign(at_once)
