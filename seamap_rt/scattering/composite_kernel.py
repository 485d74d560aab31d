"""`composite`'s formulas as the processor's loops, for the facets of a turn: one pass from slopes to cross-sections.

A turn has a million facets, of which half are dark. Column by column, those that a ray reaches are listed, and all of a
facet's terms follow in one loop, which the processor's lanes take together and whose numbers stay in the cache. The
formulas are those of `facet_view`, `tilted_bragg`, `quasi_specular`, `breaking` and `modulation`, term for term, in
float32; tests hold the two together. Exponentials are polynomials, and Gauss's distribution is a table: no library's
function, which would take one number at a time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from seamap_rt.compute.compiled import compiled, compiled_step, compiled_step_fused
from seamap_rt.compute.lanes import LANES, add, less, load, store
from seamap_rt.scattering.breaking import ROUGHNESS, WALL, lean_of
from seamap_rt.scattering.composite import CompositeSea
from seamap_rt.scattering.modulation import ACTION_POWER, MOST_STRAIN
from seamap_rt.scattering.tilted_bragg import LEAST_COSINE, NODES

COLUMNS = LANES  # of the table of Bragg scattering
_FACETS, _ROWS = 64, 12  # worked on at a time, listed or not: whole groups of lanes; with so many numbers each

_REACH, _PER_UNIT = 6.0, 1024  # of the table of Gauss's distribution: linear between entries it errs by 3e-8
_NORMAL = ndtr(np.linspace(-_REACH, _REACH, int(2 * _REACH * _PER_UNIT) + 1)).astype(np.float32)
_NORMAL[0] = 0.0  # of what is seen from farther behind nothing faces the ray
_LAST = np.float32(_NORMAL.size - 1.001)
_MIDDLE, _STEPS = np.float32(_REACH * _PER_UNIT), np.float32(_PER_UNIT)
_HALF, _ONE, _TWO, _ZERO = (np.float32(value) for value in (0.5, 1.0, 2.0, 0.0))
_PER_LN_2, _LN_2_HIGH = np.float32(1.0 / np.log(2.0)), np.float32(0.693359375)  # few digits: times a small number exact
_LN_2_LOW = np.float32(np.log(2.0) - 0.693359375)
_LEAST = np.float32(-87.0)  # of an exponent: what is less comes out as 0
_E2, _E3, _E4, _E5, _E6, _E7 = (np.float32(1.0 / value) for value in (2, 6, 24, 120, 720, 5040))
_CROWDING, _BEND = np.float32(ACTION_POWER * MOST_STRAIN), np.float32(2.0 / MOST_STRAIN)
_SQUARE, _GRAZING = np.float32(1e-12), np.float32(LEAST_COSINE)
_FLATTEST, _STEEPEST, _DARK = np.float32(0.05), np.float32(1e-6), np.float32(1e-30)
_PER_ROUGHNESS, _SIDE = np.float32(1.0 / ROUGHNESS), np.float32(WALL / ROUGHNESS)


class FacetGeometry(NamedTuple):
    """The facets of a turn and how rays reach them. Of fields that are not there, an empty array stands."""

    reached: NDArray[np.bool_]  # (column, facet)
    distance: NDArray[np.float32]  # (facet,) m
    area: NDArray[np.float32]  # (facet,) m², horizontal
    level: NDArray[np.float64]  # (column,) m, where the frame's origin stands
    wind: NDArray[np.float32]  # (2, column) cosine and sine of the look against the wind
    height: NDArray[np.float64]  # (column, facet) m
    look: NDArray[np.float32]  # (column, facet) slope outward
    cross: NDArray[np.float32]  # (column, facet) slope clockwise
    strain: NDArray[np.float32]  # (column, facet)
    ray_slope: NDArray[np.float32]  # (column, facet) tan of the angle by which the ray falls; else a straight one's
    facing: NDArray[np.float32]  # (column, facet) share in sight of what faces the ray; else all


class Numbers(NamedTuple):
    """`CompositeSea` in float32, as the loops take it."""

    table: NDArray[np.float32]  # (node, column) of `TiltedBragg`: like, mixed, other; like_skew, other_skew
    low: np.float32
    per_cosine: np.float32
    per_crowding: np.float32
    breaking_level: np.float32
    mean: np.float32  # of `Mirror`'s exponent
    split: np.float32
    peak: np.float32
    steepness: np.float32
    lean: np.float32
    upright: np.float32
    normal: NDArray[np.float32]  # Gauss's distribution

    @classmethod
    def of(cls, sea: CompositeSea) -> Numbers:
        """Those of a sea."""
        bragg, mirror, lean = sea.bragg, sea.mirror, lean_of(sea.breakers.direction)
        columns = (*bragg.like, *bragg.mixed, *bragg.other, bragg.like_skew, bragg.other_skew)
        return cls(
            table=np.stack(columns, axis=1),
            low=np.float32(bragg.low),
            per_cosine=np.float32(NODES / (1.0 - bragg.low)),
            per_crowding=np.float32(1.0 / sea.mean_action_modulation),
            breaking_level=np.float32(sea.breaking_level),
            mean=np.float32(0.25 / mirror.along + 0.25 / mirror.across),
            split=np.float32(0.25 / mirror.along - 0.25 / mirror.across),
            peak=np.float32(mirror.peak),
            steepness=np.float32(mirror.steepness),
            lean=np.float32(lean),
            upright=np.float32(1.0 / np.sqrt(1.0 + lean * lean)),
            normal=_NORMAL,
        )


class Brought(NamedTuple):
    """What the terms are brought to: the measured mean, and single breakers. Empty arrays where they are not there."""

    level: NDArray[np.float32]  # (facet,) of the scale's exponent: level + flat + depth · lean
    depth: NDArray[np.float32]  # (facet,)
    flat: NDArray[np.float32]  # (column,)
    lean: NDArray[np.float32]  # (column,)
    least: np.float32
    most: np.float32
    spikes: NDArray[np.float32]  # (column, facet) factor of the breaking echo


@compiled
def fill_terms(begin, end, seen, numbers, bragg, specular, breaking):
    """Fill the rows from `begin` to `end` of radar cross-sections (column, facet) [m²] by what scatters; 0 in the
    dark."""
    number, columns = np.empty(seen.distance.size, np.uint32), np.empty((_FACETS, COLUMNS), np.float32)
    room = np.zeros((_ROWS, _FACETS), np.float32)
    for column in range(begin, end):
        bragg[column, :], specular[column, :], breaking[column, :] = _ZERO, _ZERO, _ZERO
        reached = _list_reached(column, seen, number)
        for first in range(0, reached, _FACETS):
            count = min(reached - first, _FACETS)
            _scatter(column, seen, number, first, count, numbers, columns, room)
            for n in range(count):
                facet = number[first + n]
                bragg[column, facet], specular[column, facet] = room[0, n], room[1, n]
                breaking[column, facet] = room[2, n]


@compiled
def fill_returns(begin, end, seen, numbers, brought, rcs, share):
    """Fill the rows from `begin` to `end` of radar cross-sections (column, facet) [m²] of all terms, and of the
    breakers' share in them; 0 in the dark."""
    number, columns = np.empty(seen.distance.size, np.uint32), np.empty((_FACETS, COLUMNS), np.float32)
    room = np.zeros((_ROWS, _FACETS), np.float32)
    for column in range(begin, end):
        rcs[column, :], share[column, :] = _ZERO, _ZERO
        reached = _list_reached(column, seen, number)
        for first in range(0, reached, _FACETS):
            count = min(reached - first, _FACETS)
            _scatter(column, seen, number, first, count, numbers, columns, room)
            if brought.spikes.size:
                for n in range(count):
                    room[2, n] *= brought.spikes[column, number[first + n]]
            room[3, :] = _ZERO
            if brought.level.size:
                flat, lean = brought.flat[column], brought.lean[column]
                for n in range(count):
                    facet = number[first + n]
                    exponent = (brought.level[facet] + flat) + brought.depth[facet] * lean
                    room[3, n] = min(max(exponent, brought.least), brought.most)
            for n in range(_FACETS):
                total = room[0, n] + room[1, n] + room[2, n]
                room[0, n], room[2, n] = total * exponential(room[3, n]), room[2, n] / max(total, _DARK)
            for n in range(count):
                facet = number[first + n]
                rcs[column, facet], share[column, facet] = room[0, n], room[2, n]


@compiled_step
def _list_reached(column, seen, number):
    """List the numbers of a column's facets that a ray reaches. Returns how many."""
    count = 0
    for facet in range(number.size):  # without a branch, which would be guessed wrong at every edge of a shadow
        number[count] = facet
        count += np.intp(seen.reached[column, facet])
    return count


@compiled_step
def _scatter(column, seen, number, first, count, sea, columns, room):
    """Fill room[:3, :count] with Bragg waves, mirrors and breakers [m²] of the facets that are listed from `first` on.
    columns (facet, column): of the table, room for them."""
    _gather(column, seen, number, first, count, room)
    _face(seen.wind[0, column], seen.wind[1, column], sea, room)
    for n in range(count):  # no lanes here: each looks up places of its own
        place = room[3, n]
        entry = np.int32(place)
        low, high = load(sea.table, np.uint64(entry) * COLUMNS), load(sea.table, np.uint64(entry + 1) * COLUMNS)
        store(columns, n * COLUMNS, add(low, place - np.float32(entry), less(high, low)))
        place = room[4, n]
        entry = np.uint32(np.int32(place))
        below, above = sea.normal[entry], sea.normal[entry + np.uint32(1)]
        room[4, n] = below + (place - np.float32(np.int32(place))) * (above - below)
    _sum_terms(sea, columns, room)


@compiled_step
def _gather(column, seen, number, first, count, room):
    """Fill room[:5, :count]: slope of the ray, slopes outward and clockwise, strain, horizontal area in sight."""
    level = seen.level[column]
    for n in range(count):
        facet = number[first + n]
        room[1, n], room[2, n] = seen.look[column, facet], seen.cross[column, facet]
        room[4, n] = seen.area[facet]
    if seen.ray_slope.size:
        for n in range(count):
            room[0, n] = seen.ray_slope[column, number[first + n]]
    else:
        for n in range(count):
            facet = number[first + n]
            room[0, n] = np.float32(level - seen.height[column, facet]) / seen.distance[facet]
    for n in range(count):
        room[3, n] = seen.strain[column, number[first + n]] if seen.strain.size else _ZERO
    if seen.facing.size:
        for n in range(count):
            room[4, n] *= seen.facing[column, number[first + n]]


@compiled_step
def _face(along, across, sea, room):
    """From `_gather`'s rows: how the facets face the ray and the wind, and how the strain crowds short waves on them.

    along, across: cosine and sine of the look against the wind. Fills room[3:12]: places in the table of Bragg
    scattering and in Gauss's, cos θi and that of a breaker's zone, cos 2φ, A², A B sin 2φ, modulation, area.
    """
    axis_cosine, axis_sine = along * along - across * across, _TWO * along * across
    for n in range(_FACETS):
        fall, p, q, strain, area = room[0, n], room[1, n], room[2, n], room[3, n], room[4, n]
        sine = _ONE / np.sqrt(_ONE + fall * fall)  # of the incidence
        cosine = fall * sine
        steep = _ONE + p * p + q * q
        in_plane, normal_up = _ONE / (_ONE + p * p), _ONE / steep
        towards, away = cosine + p * sine, sine - p * cosine
        up, root = np.sqrt(normal_up), np.sqrt(in_plane)
        along_range, along_cross = away * root, towards * root * (q * up)
        sine2 = along_range * along_range + along_cross * along_cross
        square = sine2 < _SQUARE
        inverse = _ZERO if square else _ONE / sine2
        b = q * normal_up * inverse
        local = min(towards * up, _ONE)
        turned_cosine = _ONE if square else (along_range * along_range - along_cross * along_cross) * inverse
        turned_sine = _TWO * along_range * along_cross * inverse
        leaning = (local + sea.lean * (along * along_range + across * along_cross)) * sea.upright
        faces = local * sea.steepness / np.sqrt(max(_ONE - local * local, _STEEPEST))
        # In this order what is not a number is 0, a place in the tables all the same.
        room[3, n] = max(_ZERO, local - sea.low) * sea.per_cosine
        room[4, n] = min(_LAST, max(_ZERO, faces * _STEPS + _MIDDLE))
        room[5, n], room[6, n] = local, leaning
        room[7, n] = axis_cosine * turned_cosine + axis_sine * turned_sine
        room[8, n] = _ONE - min(q * b, _ONE)
        room[9, n] = away * b * (axis_sine * turned_cosine - axis_cosine * turned_sine)
        room[10, n] = exponential(_CROWDING * (_ONE - _TWO / (exponential(strain * _BEND) + _ONE)))
        room[11, n] = np.sqrt(steep) * area  # a local σ0 multiplies the facet's true area


@compiled_step
def _sum_terms(sea, columns, room):
    """From `_face`'s rows, with the columns (facet, column) of the table and Gauss's distribution in row 4."""
    for n in range(_FACETS):
        facing, local, leaning, wind, a2 = room[4, n], room[5, n], room[6, n], room[7, n], room[8, n]
        skewed, crowded, area = room[9, n], room[10, n], room[11, n]
        b2 = _ONE - a2
        like, mixed = columns[n, 0] + columns[n, 1] * wind, columns[n, 2] + columns[n, 3] * wind
        other, skew = columns[n, 4] + columns[n, 5] * wind, columns[n, 6] * a2 + columns[n, 7] * b2
        bragg = max(like * a2 * a2 + mixed * (a2 * b2) + other * b2 * b2 + skew * skewed, _ZERO)
        bounded = max(local, _GRAZING)
        secant2 = _ONE / (bounded * bounded)
        mirrored = sea.peak * secant2 * secant2
        mirrored *= exponential((_ONE - secant2) * (sea.mean + sea.split * wind))
        bounded = max(leaning, _FLATTEST)
        secant2 = _ONE / (bounded * bounded)
        zone = secant2 * secant2 * _PER_ROUGHNESS * exponential((_ONE - secant2) * _PER_ROUGHNESS) + _SIDE
        cube = crowded * crowded * crowded
        often = sea.breaking_level * (cube * cube)
        share = often / (_ONE + often)
        left = (_ONE - share) * area
        room[0, n], room[1, n] = bragg * (crowded * sea.per_crowding) * left, mirrored * left
        room[2, n] = share * zone * facing * area


@compiled_step_fused
def exponential(value):
    """exp of a float32 up to 88, within 2e-7 of itself; 0 below −87."""
    whole = np.rint(value * _PER_LN_2)
    whole = max(whole, np.float32(-126.0))
    rest = (value - whole * _LN_2_HIGH) - whole * _LN_2_LOW
    series = _E2 + rest * (_E3 + rest * (_E4 + rest * (_E5 + rest * (_E6 + rest * _E7))))
    power = np.int32((np.int32(whole) + np.int32(127)) << np.int32(23)).view(np.float32)
    return _ZERO if value < _LEAST else (_ONE + rest + rest * rest * series) * power
