"""The loop over the breakers of one class of waves: born cell by cell, laid on the facets that the beam then passes."""

from __future__ import annotations

import math

import numpy as np

from ..compute.compiled import compiled
from ..scattering.sea_spikes import LONGEST_LIFE
from .summation.gaussian import key_of

_CUT = 1.0 - math.exp(-LONGEST_LIFE)
_ONE_IN_A_CELL = math.exp(-1.0)
_TURN = 2.0 * math.pi


@compiled
def uniform(key, number):
    """A number of a key, evenly distributed over 0 to 1."""
    return (np.float64(key_of(key, number) >> np.uint64(11)) + 0.5) * 2.0**-53


@compiled
def cell_number(i, j, slot):
    """One number for a cell of space, 21 bits either way, and of time, 22 bits."""
    return ((i & 0x1FFFFF) << 43) | ((j & 0x1FFFFF) << 22) | (slot & 0x3FFFFF)


@compiled
def column_at(east, north, start, spacing, per_circle, near):
    """Which column sees a place [m from the origin], with the fraction of its width: of those a whole number of circles
    apart the one within half a circle of `near`."""
    place = (math.atan2(east, north) - start) / spacing
    return place - per_circle * math.floor((place - near) / per_circle + 0.5)


@compiled
def fill_spikes(
    key, cell, slot, scale, celerity, brightness, ways, crest, points, drift_east, drift_north,
    start, spacing, per_circle, time, origin_east, origin_north, innermost, step, area, factor, speed,
):  # fmt: skip
    """Add one class's breakers to factor (column, facet), and its product with their outward speed to speed.

    One is born in each cell [m] and slot [s] in the mean. ways (quantile,): azimuths that they run to [rad].
    """
    columns, facets = factor.shape
    far = innermost + 0.5 * facets * step
    moved = (celerity + math.hypot(drift_east, drift_north)) * slot + 0.5 * crest  # from birth on, at most
    west, east = origin_east.min() - far - moved, origin_east.max() + far + moved
    south, north = origin_north.min() - far - moved, origin_north.max() + far + moved
    middle = columns // 2
    swing = math.hypot(origin_east.max() - origin_east.min(), origin_north.max() - origin_north.min())
    laps = (columns - 1) // per_circle + 1
    for i in range(math.floor(west / cell), math.floor(east / cell) + 1):
        for j in range(math.floor(south / cell), math.floor(north / cell) + 1):
            x, y = (i + 0.5) * cell - origin_east[middle], (j + 0.5) * cell - origin_north[middle]
            away, reach = math.hypot(x, y), 0.7072 * cell + moved + swing
            if away - reach > far:
                continue
            turned = column_at(x, y, start, spacing, per_circle, 0.5 * per_circle)
            half = 0.5 * per_circle
            pad = half if away <= reach else min(math.asin(reach / away) / spacing + 1.0, half)
            for lap in range(-1, laps + 1):
                # Of what the beam passes again and again each time is its own; a circle's seam is no end of it.
                seen = turned + lap * per_circle
                first, last = max(seen - pad, 0.0), min(seen + pad, columns - 1.0)
                if first > last:
                    continue
                first_slot = math.floor(time[int(first)] / slot) - 1
                for n in range(first_slot, math.floor(time[int(last)] / slot) + 1):
                    member = key_of(key, cell_number(i, j, n))
                    # Poisson by inversion.
                    chance, term, count = uniform(member, 0), _ONE_IN_A_CELL, 0
                    while chance > term and count < 20:
                        chance -= term
                        count += 1
                        term /= count
                    for each in range(count):
                        own = key_of(member, 1 + each)
                        born = (n + uniform(own, 0)) * slot
                        life = -scale * math.log(1.0 - _CUT * uniform(own, 1))
                        if born + life <= time[int(first)] or born > time[int(last)]:
                            continue
                        way = uniform(own, 2) * (ways.size - 1)
                        entry = min(int(way), ways.size - 2)
                        azimuth = ways[entry] + (way - entry) * (ways[entry + 1] - ways[entry])
                        run_east, run_north = celerity * math.sin(azimuth), celerity * math.cos(azimuth)
                        birth_east, birth_north = (i + uniform(own, 3)) * cell, (j + uniform(own, 4)) * cell
                        for point in range(points):
                            aside = ((point + 0.5) / points - 0.5) * crest / celerity
                            from_east, from_north = birth_east + aside * run_north, birth_north - aside * run_east
                            guess = int(first)
                            for _ in range(3):  # the beam passes many times faster than breakers run
                                past = time[guess] - born
                                place = column_at(
                                    from_east + (run_east + drift_east) * past - origin_east[guess],
                                    from_north + (run_north + drift_north) * past - origin_north[guess],
                                    start, spacing, per_circle, seen,
                                )  # fmt: skip
                                guess = min(max(int(place), 0), columns - 1)
                            for column in range(max(guess - 1, 0), min(guess + 2, columns)):
                                past = time[column] - born
                                if not 0.0 <= past < life:
                                    continue
                                x = from_east + (run_east + drift_east) * past - origin_east[column]
                                y = from_north + (run_north + drift_north) * past - origin_north[column]
                                place = column_at(x, y, start, spacing, per_circle, seen)
                                across = place - column
                                if not 0.0 <= across < 1.0:
                                    continue
                                away = math.hypot(x, y)
                                rung = math.floor((away - innermost) / step)
                                if rung < 0 or 2 * rung >= facets:
                                    continue
                                # A column's quadrilaterals are cut by a diagonal (`mesh.facets`): below it is "near".
                                facet = 2 * rung + int((away - innermost) / step - rung >= across)
                                grown = past / life
                                light = brightness * 6.0 * grown * (1.0 - grown) / (points * area[facet])
                                factor[column, facet] += light
                                speed[column, facet] += light * (run_east * x + run_north * y) / away
