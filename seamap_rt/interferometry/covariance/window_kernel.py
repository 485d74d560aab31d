"""Means over windows of neighbouring cells whose phases are first brought to the cell's own.

Rows of gates have a margin of cells that are not known, as wide as half the window and a group of lanes: so all gates
are alike, and a processor's lanes take them together, real and imaginary parts each by themselves.
"""

from __future__ import annotations

from ...compute.compiled import compiled, compiled_step
from ...compute.lanes import LANES, add, less, load, plus, product, ratio, spread, store


@compiled
def window_means(begin, end, margin, fields, known, range_weights, look_weights, along, aside, here, means):
    """Fills looks begin … end of means (4, look, lane): real and imaginary part, both powers; NaN of unknown cells.

    fields (4, look, margin + lane + margin) of these; known (look, the same): 1 or 0, where the fields are 0. along,
    aside (component, look or 1, lane): what turns the phase of the neighbour one gate or one look on to the cell's;
    here (component, offset, look, lane): as well, the level of the sea so many gates on as seen from the cell; of no
    offsets where the sea is level. Lanes are the gates, and more to whole groups of LANES.
    """
    looks, wide, lanes = known.shape[0], known.shape[1], means.shape[2]
    part, rows, component = looks * wide, along.shape[1] * lanes, aside.shape[1] * lanes
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    offsets = here.shape[1]
    for look in range(begin, end):
        first, beside = look % along.shape[1] * lanes, look % aside.shape[1] * lanes
        for gate in range(0, lanes, LANES):
            out = load(along, first + gate), load(along, rows + first + gate)
            clockwise = load(aside, beside + gate), load(aside, component + beside + gate)
            real, imaginary, lower, upper, total = spread(0.0), spread(0.0), spread(0.0), spread(0.0), spread(0.0)
            for n in range(-half_look, half_look + 1):
                if look + n < 0 or look + n >= looks or look - n < 0 or look - n >= looks:
                    continue
                turn = spread(1.0), spread(0.0)
                for _ in range(abs(n)):
                    turn = _turned(turn, clockwise) if n > 0 else _turned_back(turn, clockwise)
                for _ in range(half_range):
                    turn = _turned_back(turn, out)
                for m in range(-half_range, half_range + 1):
                    there, opposite = (look + n) * wide + margin + gate + m, (look - n) * wide + margin + gate - m
                    weight = spread(range_weights[m + half_range] * look_weights[n + half_look])
                    weight = product(weight, product(load(known, there), load(known, opposite)))
                    value = load(fields, there), load(fields, part + there)
                    if offsets > 0:
                        level = (m + half_range) * looks * lanes + look * lanes + gate
                        value = _turned(value, (load(here, level), load(here, offsets * looks * lanes + level)))
                    value = _turned(value, turn)
                    real, imaginary = plus(real, product(weight, value[0])), plus(imaginary, product(weight, value[1]))
                    lower = plus(lower, product(weight, load(fields, 2 * part + there)))
                    upper = plus(upper, product(weight, load(fields, 3 * part + there)))
                    total = plus(total, weight)
                    turn = _turned(turn, out)
            mine, at = load(known, look * wide + margin + gate), look * lanes + gate
            total = product(mine, total)
            store(means, at, ratio(product(mine, real), total))
            store(means, looks * lanes + at, ratio(product(mine, imaginary), total))
            store(means, 2 * looks * lanes + at, ratio(product(mine, lower), total))
            store(means, 3 * looks * lanes + at, ratio(product(mine, upper), total))


@compiled
def window_means_as_they_are(begin, end, margin, fields, known, range_weights, look_weights, means):
    """The same without turning any phase, over all cells of the window that are known, whatever lies opposite."""
    looks, wide, lanes = known.shape[0], known.shape[1], means.shape[2]
    part, half_range, half_look = looks * wide, range_weights.size // 2, look_weights.size // 2
    for look in range(begin, end):
        for gate in range(0, lanes, LANES):
            real, imaginary, lower, upper, total = spread(0.0), spread(0.0), spread(0.0), spread(0.0), spread(0.0)
            for n in range(max(-half_look, -look), min(half_look, looks - 1 - look) + 1):
                for m in range(-half_range, half_range + 1):
                    there = (look + n) * wide + margin + gate + m
                    weight = range_weights[m + half_range] * look_weights[n + half_look]
                    real, imaginary = (
                        add(real, weight, load(fields, there)),
                        add(imaginary, weight, load(fields, part + there)),
                    )
                    lower = add(lower, weight, load(fields, 2 * part + there))
                    upper = add(upper, weight, load(fields, 3 * part + there))
                    total = add(total, weight, load(known, there))
            mine, at = load(known, look * wide + margin + gate), look * lanes + gate
            total = product(mine, total)
            store(means, at, ratio(product(mine, real), total))
            store(means, looks * lanes + at, ratio(product(mine, imaginary), total))
            store(means, 2 * looks * lanes + at, ratio(product(mine, lower), total))
            store(means, 3 * looks * lanes + at, ratio(product(mine, upper), total))


@compiled
def window_powers(begin, end, margin, power, known, range_weights, look_weights, means):
    """Fills looks begin … end of means (look, lane) of a power; arguments as of `window_means`."""
    looks, wide, lanes = known.shape[0], known.shape[1], means.shape[1]
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    for look in range(begin, end):
        for gate in range(0, lanes, LANES):
            mean, total = spread(0.0), spread(0.0)
            for n in range(-half_look, half_look + 1):
                if look + n < 0 or look + n >= looks or look - n < 0 or look - n >= looks:
                    continue
                for m in range(-half_range, half_range + 1):
                    there, opposite = (look + n) * wide + margin + gate + m, (look - n) * wide + margin + gate - m
                    weight = spread(range_weights[m + half_range] * look_weights[n + half_look])
                    weight = product(weight, product(load(known, there), load(known, opposite)))
                    mean, total = plus(mean, product(weight, load(power, there))), plus(total, weight)
            mine = load(known, look * wide + margin + gate)
            store(means, look * lanes + gate, ratio(product(mine, mean), product(mine, total)))


@compiled_step
def _turned(value, by):
    """The product of two complex numbers."""
    return (
        less(product(value[0], by[0]), product(value[1], by[1])),
        plus(product(value[0], by[1]), product(value[1], by[0])),
    )


@compiled_step
def _turned_back(value, by):
    """The first times the second's conjugate."""
    return (
        plus(product(value[0], by[0]), product(value[1], by[1])),
        less(product(value[1], by[0]), product(value[0], by[1])),
    )
