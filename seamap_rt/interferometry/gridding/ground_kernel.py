"""The inner loops of the ground map, compiled."""

from __future__ import annotations

import math

import numpy as np

from ...compute.compiled import compiled


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
    pieces = laid.shape[2]
    high, wide = sweep.shape[0] // middle.shape[0], sweep.shape[1] // middle.shape[1]
    total, count, value = np.empty(pieces), np.empty(pieces, np.int64), np.empty(pieces)
    for row in range(begin, end):
        for column in range(middle.shape[1]):
            total[:] = 0.0
            count[:] = 0
            for n in range(row * high, (row + 1) * high):
                for m in range(column * wide, (column + 1) * wide):
                    reach = (math.sqrt(x[m] * x[m] + y[n] * y[n]) - fan[3]) / fan[4]
                    if not 0.0 <= reach <= laid.shape[1] - 1.0:
                        continue
                    # A square that straddles the start of the turn stays on its centre's side: beyond it is a turn ago.
                    beside = sweep[n, m] - middle[row, column]
                    beside -= 360.0 * math.floor(beside / 360.0 + 0.5)
                    number = (middle[row, column] + beside - fan[0]) / fan[1]
                    if _bilinear(laid, number, reach, fan[2] > 0.0, value):
                        for part in range(pieces):
                            if not math.isnan(value[part]):
                                total[part] += value[part]
                                count[part] += 1
            for part in range(pieces):
                if 2 * count[part] > high * wide:
                    result[part, row, column] = total[part] / count[part]


@compiled
def _bilinear(laid, number, reach, closed, value):
    """Write the fields at a fractional look and distance; False outside of the looks.

    Before the first look and after the last the nearest of them serves, as far as half a look; all the way in a full
    circle, whose ends lie a turn apart in time and are not blended.
    """
    last = laid.shape[0] - 1
    if not closed and (number < -0.5 or number > last + 0.5):
        return False
    number = min(max(number, 0.0), float(last))
    low, near = int(number), min(int(reach), laid.shape[1] - 2)
    across, along = number - low, reach - near
    first, second = laid[low], laid[low + 1 if across > 0.0 else low]
    for part in range(value.size):
        on_first = first[near, part] * (1.0 - along) + first[near + 1, part] * along
        on_second = second[near, part] * (1.0 - along) + second[near + 1, part] * along
        value[part] = on_first * (1.0 - across) + on_second * across
    return True
