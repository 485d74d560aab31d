"""Sea spikes on the facets of a turn: how much brighter than their mean the breakers of each facet are, and how fast.

Births are counted out in cells of space and time, each cell's from its own key (`random_streams.Stream.SPIKES`): a
breaker is the same in whichever turn, sector or order it is met, and keeps its bits for any number of threads. Each
column looks at its own time. A breaker's echo is laid on the facets under points of its crest, over their own areas:
so the factor has the mean 1 on every facet, however small.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import random_streams
from ..compute.compiled import compiled, compiled_step
from ..conventions import unit_from_azimuth
from ..mesh import Facets
from ..mesh.grid import INNERMOST_M
from ..random_streams import Stream
from ..scattering.sea_spikes import LONGEST_LIFE, SeaSpikes
from .summation.gaussian import key_of

_CUT = 1.0 - math.exp(-LONGEST_LIFE)
_ONE_IN_A_CELL = math.exp(-1.0)
_MOST_IN_A_CELL = 20


class BreakerClass(NamedTuple):
    """The breakers of one class of waves. One is born in each cell of space and slot of time in the mean."""

    cell: float  # m, side
    slot: float  # s, the longest life
    scale: float  # s, of the exponential that lives are drawn from
    celerity: float  # m/s
    brightness: float  # m²
    ways: NDArray[np.float64]  # (quantile,) rad, azimuths that they run to
    crest: float  # m
    points: int  # of a crest
    drift_east: float  # m/s
    drift_north: float


class Sweep(NamedTuple):
    """What the beam passes: columns of facets about a mast, each at its own time."""

    start: float  # rad, azimuth of the first column's edge
    spacing: float  # rad, of columns
    per_circle: int  # columns
    time: NDArray[np.float64]  # (column,) s
    origin_east: NDArray[np.float64]  # (column,) m, of the mast
    origin_north: NDArray[np.float64]
    innermost: float  # m, where the first rung begins
    step: float  # m, of rungs
    area: NDArray[np.float64]  # (facet,) m²


class Breaker(NamedTuple):
    """One breaker: when and where its crest's middle is born, how long it lives and where it runs."""

    born: float  # s
    life: float  # s
    east: float  # m
    north: float
    run_east: float  # m/s, over the water
    run_north: float


class Passage(NamedTuple):
    """One passage of the beam over a cell: columns first to last, of which some may see what is born there."""

    middle: float  # column, the cell's
    first: float
    last: float


@compiled
def uniform(key, number):
    """A number of a key, evenly distributed over 0 to 1."""
    return (np.float64(key_of(key, number) >> np.uint64(11)) + 0.5) * 2.0**-53


@compiled
def cell_number(i, j, slot):
    """One number for a cell of space, 21 bits either way, and of time, 22 bits."""
    return ((i & 0x1FFFFF) << 43) | ((j & 0x1FFFFF) << 22) | (slot & 0x3FFFFF)


@compiled
def column_at(east, north, near, sweep):
    """Which column sees a place [m from the mast], with the fraction of its width: of those a whole number of circles
    apart the one within half a circle of `near`."""
    place = (math.atan2(east, north) - sweep.start) / sweep.spacing
    return place - sweep.per_circle * math.floor((place - near) / sweep.per_circle + 0.5)


@compiled_step
def poisson_count(member):
    """How many are born in a cell and slot: Poisson with the mean 1, by inversion."""
    chance, term, count = uniform(member, 0), _ONE_IN_A_CELL, 0
    while chance > term and count < _MOST_IN_A_CELL:
        chance -= term
        count += 1
        term /= count
    return count


@compiled_step
def direction_bin(chance, ways):
    """The azimuth at a probability, from the table."""
    way = chance * (ways.size - 1)
    entry = min(int(way), ways.size - 2)
    return ways[entry] + (way - entry) * (ways[entry + 1] - ways[entry])


@compiled_step
def lifetime(own, slot, breed):
    """When the breaker of a key is born in a slot, and how long it lives [s]."""
    return (slot + uniform(own, 0)) * breed.slot, -breed.scale * math.log(1.0 - _CUT * uniform(own, 1))


@compiled_step
def breaker_of(own, born, life, i, j, breed):
    """The breaker of a key with that lifetime, in a cell."""
    azimuth = direction_bin(uniform(own, 2), breed.ways)
    east, north = (i + uniform(own, 3)) * breed.cell, (j + uniform(own, 4)) * breed.cell
    return Breaker(born, life, east, north, breed.celerity * math.sin(azimuth), breed.celerity * math.cos(azimuth))


@compiled_step
def passing_column(breaker, east, north, passage, columns, breed, sweep):
    """About which column's beam passes a point of a crest that was born at a place: found in three steps, for the beam
    passes many times faster than breakers run."""
    guess = int(passage.first)
    for _ in range(3):
        past = sweep.time[guess] - breaker.born
        place = column_at(
            east + (breaker.run_east + breed.drift_east) * past - sweep.origin_east[guess],
            north + (breaker.run_north + breed.drift_north) * past - sweep.origin_north[guess],
            passage.middle, sweep,
        )  # fmt: skip
        guess = min(max(int(place), 0), columns - 1)
    return guess


@compiled_step
def lay_point(breaker, east, north, passage, breed, sweep, factor, speed):
    """Add a point of a crest to the facet that has it when the beam passes: its share of the light, and that times its
    outward speed."""
    columns, facets = factor.shape
    guess = passing_column(breaker, east, north, passage, columns, breed, sweep)
    for column in range(max(guess - 1, 0), min(guess + 2, columns)):
        past = sweep.time[column] - breaker.born
        if not 0.0 <= past < breaker.life:
            continue
        x = east + (breaker.run_east + breed.drift_east) * past - sweep.origin_east[column]
        y = north + (breaker.run_north + breed.drift_north) * past - sweep.origin_north[column]
        across = column_at(x, y, passage.middle, sweep) - column
        if not 0.0 <= across < 1.0:
            continue
        away = math.hypot(x, y)
        rung = math.floor((away - sweep.innermost) / sweep.step)
        if rung < 0 or 2 * rung >= facets:
            continue
        # A column's quadrilaterals are cut by a diagonal (`mesh.facets`): below it is "near".
        facet = 2 * rung + int((away - sweep.innermost) / sweep.step - rung >= across)
        grown = past / breaker.life
        light = breed.brightness * 6.0 * grown * (1.0 - grown) / (breed.points * sweep.area[facet])
        factor[column, facet] += light
        speed[column, facet] += light * (breaker.run_east * x + breaker.run_north * y) / away


@compiled_step
def add_breaker(breaker, passage, breed, sweep, factor, speed):
    """A breaker's crest, point by point along it."""
    for point in range(breed.points):
        aside = ((point + 0.5) / breed.points - 0.5) * breed.crest / breed.celerity
        east, north = breaker.east + aside * breaker.run_north, breaker.north - aside * breaker.run_east
        lay_point(breaker, east, north, passage, breed, sweep, factor, speed)


@compiled_step
def lay_cell(key, i, j, passage, breed, sweep, factor, speed):
    """All that is born in a cell and may be seen in a passage."""
    begin, end = sweep.time[int(passage.first)], sweep.time[int(passage.last)]
    for slot in range(math.floor(begin / breed.slot) - 1, math.floor(end / breed.slot) + 1):
        member = key_of(key, cell_number(i, j, slot))
        for each in range(poisson_count(member)):
            own = key_of(member, 1 + each)
            born, life = lifetime(own, slot, breed)
            if born + life > begin and born <= end:
                add_breaker(breaker_of(own, born, life, i, j, breed), passage, breed, sweep, factor, speed)


@compiled
def fill_spikes(key, breed, sweep, factor, speed):
    """Add one class's breakers to factor (column, facet), and its product with their outward speed to speed."""
    columns, facets = factor.shape
    cell, origin_east, origin_north = breed.cell, sweep.origin_east, sweep.origin_north
    far = sweep.innermost + 0.5 * facets * sweep.step
    drift = math.hypot(breed.drift_east, breed.drift_north)
    moved = (breed.celerity + drift) * breed.slot + 0.5 * breed.crest  # from birth on, at most
    west, east = origin_east.min() - far - moved, origin_east.max() + far + moved
    south, north = origin_north.min() - far - moved, origin_north.max() + far + moved
    middle = columns // 2
    swing = math.hypot(origin_east.max() - origin_east.min(), origin_north.max() - origin_north.min())
    reach = 0.7072 * cell + moved + swing
    for i in range(math.floor(west / cell), math.floor(east / cell) + 1):
        for j in range(math.floor(south / cell), math.floor(north / cell) + 1):
            x, y = (i + 0.5) * cell - origin_east[middle], (j + 0.5) * cell - origin_north[middle]
            away = math.hypot(x, y)
            if away - reach > far:
                continue
            half = 0.5 * sweep.per_circle
            turned = column_at(x, y, half, sweep)
            pad = half if away <= reach else min(math.asin(reach / away) / sweep.spacing + 1.0, half)
            for lap in range(-1, (columns - 1) // sweep.per_circle + 2):
                # Of what the beam passes again and again each time is its own; a circle's seam is no end of it.
                seen = turned + lap * sweep.per_circle
                passage = Passage(seen, max(seen - pad, 0.0), min(seen + pad, columns - 1.0))
                if passage.first <= passage.last:
                    lay_cell(key, i, j, passage, breed, sweep, factor, speed)


_POINT_M = 0.5  # of a crest between the points that stand for it
_MEAN_LIFE = 1.0 - LONGEST_LIFE / np.expm1(LONGEST_LIFE)  # of an exponential cut off, over its scale


class IlluminatedFacets(NamedTuple):
    """Breakers on the facets of a turn; arrays (column, facet)."""

    factor: NDArray[np.float32]  # of the breaking echo, mean 1
    speed: NDArray[np.float32]  # m/s outward, of the breakers' scatterers over the water, weighted by their echo


@dataclass(frozen=True)
class SpikeField:
    """All breakers of a run, everywhere and at all times."""

    spikes: SeaSpikes
    seed: int
    wind_from_deg: float
    current: tuple[float, float] = (0.0, 0.0)  # m/s east, north, with which they drift

    def evaluate(self, facets: Facets) -> IlluminatedFacets:
        """The breakers of one turn, each where it is when the beam passes it."""
        grid, spikes = facets.grid, self.spikes
        left = np.float32(spikes.remaining_share)
        factor = np.full(facets.height.shape, left, dtype=np.float32)
        east, north = unit_from_azimuth(grid.column_azimuth)
        wind = np.radians(self.wind_from_deg + 180.0)  # they run with it
        along = np.sin(wind) * east + np.cos(wind) * north
        speed = np.repeat((left * spikes.left_speed * along).astype(np.float32)[:, None], facets.distance.size, axis=1)
        sweep = _sweep(facets)
        for number, density in enumerate(spikes.density):
            scale = spikes.life_s[number] / _MEAN_LIFE
            slot = LONGEST_LIFE * scale
            per_area = density / spikes.life_s[number] * slot  # born in a slot, 1/m²
            breed = BreakerClass(
                cell=float(1.0 / np.sqrt(per_area)),  # in which one is born in a slot
                slot=float(slot),
                scale=float(scale),
                celerity=float(spikes.speed[number]),
                brightness=float(spikes.brightness_m2[number]),
                ways=wind + spikes.angle[number],
                crest=float(spikes.crest_m[number]),
                points=1 + int(spikes.crest_m[number] / _POINT_M),
                drift_east=float(self.current[0]),
                drift_north=float(self.current[1]),
            )
            key = np.uint64(key_of(random_streams.key(self.seed, Stream.SPIKES), number))
            fill_spikes(key, breed, sweep, factor, speed)
        np.divide(speed, factor, out=speed, where=factor > 0.0)
        return IlluminatedFacets(factor, speed)


def _sweep(facets: Facets) -> Sweep:
    """The facets of a turn as the kernel takes them."""
    grid, pose = facets.grid, facets.grid.column_pose
    return Sweep(
        start=float(np.radians(grid.azimuth[0])),
        spacing=float(np.radians(grid.spacing_deg)),
        per_circle=grid.per_circle,
        time=pose.time,
        origin_east=np.ascontiguousarray(pose.origin[:, 0]),
        origin_north=np.ascontiguousarray(pose.origin[:, 1]),
        innermost=INNERMOST_M,
        step=float(grid.ground_range[1] - grid.ground_range[0]),
        area=facets.horizontal_area,
    )
