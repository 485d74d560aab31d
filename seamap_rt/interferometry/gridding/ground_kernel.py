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
