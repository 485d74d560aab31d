"""The inner loops of the means over dwells, compiled.

Voltages stay as they lie, real and imaginary parts in turn, and so do their sums: of a b* the products of like parts
(whose sum is its real part) and of unlike ones (the second less the first is its imaginary part), and the squares of
either. So a processor's lanes need no sorting of parts, and what is a sum of many pulses stays in its registers.
"""

from __future__ import annotations

import numpy as np

from ...compute.compiled import compiled, compiled_fused, compiled_step
from ...compute.lanes import LANES, add_product, dot, doubled, load, plus, spread, store, swapped


@compiled_fused
def add_products(rows, look, table, begin, turns, which, receivers, low, high, totals, counts):
    """Add the products of each kind at gates low … high to totals (kind, look, 4, 2 · gate) and counts (kind, look,
    gate), block by block of pulses.

    rows (row, gate) complex64: voltages of a pulse and receiver; look (pulse, gate or 1); table (3, product): rows of
    both factors, and the pulse whose dwell it counts to, kind by kind in the order of these; begin (kind, block + 1):
    where in it a block of pulses begins. turns (…, pulse, gate): what both factors are turned by, of which `which`
    (kind,) has the number, −1 for none.
    """
    parts = rows.view(np.float32)
    upright = look.shape[1] == 1
    for block in range(begin.shape[1] - 1):
        for kind in range(begin.shape[0]):
            n, end = begin[kind, block], begin[kind, block + 1]
            total, count = totals[kind], counts[kind]
            while n < end:
                stop, here = n + np.uint64(1), look[table[2, n], 0]
                if upright and which[kind] < 0:  # as many of a look as come one after the other
                    while stop < end and look[table[2, stop], 0] == here:
                        stop += np.uint64(1)
                    if here >= 0:
                        _add_all(rows, parts, table, n, stop, low, high, total[here], count[here])
                else:
                    number, one, other = look[table[2, n]], table[0, n], table[1, n]
                    _add_by_looks(rows, number, one, other, turns, which[kind], receivers, low, high, total, count)
                n = stop


@compiled_fused
def _add_all(rows, parts, table, first, last, low, high, total, count):
    """Add products first … last − 1 of the table, in their order, to the sums of their look."""
    wide, at = parts.shape[1], 2 * low
    while at + 2 * LANES <= 2 * high:
        like, unlike, one, other = _sums(total, wide, at)
        like_on, unlike_on, one_on, other_on = _sums(total, wide, at + LANES)
        for n in range(first, last):
            mine, its = table[0, n] * wide + at, table[1, n] * wide + at
            a, b = doubled(load(parts, mine)), doubled(load(parts, its))
            like, unlike = add_product(like, a, b), add_product(unlike, a, swapped(b))
            one, other = add_product(one, a, a), add_product(other, b, b)
            a, b = doubled(load(parts, mine + LANES)), doubled(load(parts, its + LANES))
            like_on, unlike_on = add_product(like_on, a, b), add_product(unlike_on, a, swapped(b))
            one_on, other_on = add_product(one_on, a, a), add_product(other_on, b, b)
        gate = at // 2
        if dot(spread(1.0), plus(plus(one, other), plus(one_on, other_on))) < np.inf:
            _store_sums(total, wide, at, like, unlike, one, other)
            _store_sums(total, wide, at + LANES, like_on, unlike_on, one_on, other_on)
            for g in range(gate, gate + LANES):
                count[g] += float(last - first)
        else:  # a voltage is not finite: those products are left out
            _add_each(rows, table, first, last, gate, gate + LANES, total, count)
        at += 2 * LANES
    _add_each(rows, table, first, last, at // 2, high, total, count)


@compiled_step
def _sums(total, wide, at):
    return load(total, at), load(total, wide + at), load(total, 2 * wide + at), load(total, 3 * wide + at)


@compiled_step
def _store_sums(total, wide, at, like, unlike, one, other):
    store(total, at, like)
    store(total, wide + at, unlike)
    store(total, 2 * wide + at, one)
    store(total, 3 * wide + at, other)


@compiled_fused
def _add_each(rows, table, first, last, start, stop, total, count):
    """The same product by product, of gates start … stop − 1; those that are not finite are left out."""
    for n in range(first, last):
        _add(rows[table[0, n]], rows[table[1, n]], start, stop, total, count)


@compiled_fused
def _add_by_looks(rows, number, one, other, turns, which, receivers, low, high, total, count):
    """Add one product, of rows `one` and `other`, to the looks `number` (gate or 1) of its gates: those of the same
    look that lie together are taken together."""
    gate = low
    while gate < high:
        here, stop = number[min(gate, number.size - 1)], gate + 1
        while stop < high and (number.size == 1 or number[stop] == here):
            stop = stop + 1 if number.size > 1 else high
        if here >= 0 and which < 0:
            _add(rows[one], rows[other], gate, stop, total[here], count[here])
        elif here >= 0:
            turn, its = turns[which, one // receivers], turns[which, other // receivers]
            _add_rotated(rows[one], rows[other], turn, its, gate, stop, total[here], count[here])
        gate = stop


@compiled_fused
def _add(a, b, start, stop, total, count):
    for g in range(np.uint64(start), np.uint64(stop)):  # unsigned: an index that may be negative is not vectorised
        x, y = np.complex128(a[g]), np.complex128(b[g])
        if x.real**2 + x.imag**2 + y.real**2 + y.imag**2 < np.inf:
            real, imaginary = np.uint64(2) * g, np.uint64(2) * g + np.uint64(1)
            total[0, real] += x.real * y.real
            total[0, imaginary] += x.imag * y.imag
            total[1, real] += x.real * y.imag
            total[1, imaginary] += x.imag * y.real
            total[2, real] += x.real**2
            total[2, imaginary] += x.imag**2
            total[3, real] += y.real**2
            total[3, imaginary] += y.imag**2
            count[g] += 1.0


@compiled_fused
def _add_rotated(a, b, turn, other_turn, start, stop, total, count):
    for g in range(np.uint64(start), np.uint64(stop)):
        real = a[g].real * b[g].real + a[g].imag * b[g].imag
        imaginary = a[g].imag * b[g].real - a[g].real * b[g].imag
        cosine = turn[g].real * other_turn[g].real - turn[g].imag * other_turn[g].imag
        sine = turn[g].real * other_turn[g].imag + turn[g].imag * other_turn[g].real
        power, other = a[g].real ** 2 + a[g].imag ** 2, b[g].real ** 2 + b[g].imag ** 2
        good = power + other < np.inf
        first = np.uint64(2) * g
        total[0, first] += real * cosine - imaginary * sine if good else 0.0
        total[1, first + np.uint64(1)] += real * sine + imaginary * cosine if good else 0.0
        total[2, first] += power if good else 0.0
        total[3, first] += other if good else 0.0
        count[g] += 1.0 if good else 0.0


@compiled
def means_of(total, count, cross, lower, upper):
    """Fill cross, lower and upper (look, gate) with the means of sums (look, 4, 2 · gate); NaN of none."""
    for look in range(count.shape[0]):
        like, unlike, one, other = total[look]
        for gate in range(count.shape[1]):
            share = 1.0 / count[look, gate] if count[look, gate] > 0.0 else np.nan
            first, second = 2 * gate, 2 * gate + 1
            cross[look, gate] = complex((like[first] + like[second]) * share, (unlike[second] - unlike[first]) * share)
            lower[look, gate] = (one[first] + one[second]) * share
            upper[look, gate] = (other[first] + other[second]) * share


@compiled
def add_fields(look, fields, totals):
    """Add fields (pulse, field) to the totals (look, gate, field) of each gate's look (pulse, gate), −1 for none."""
    for pulse in range(look.shape[0]):
        for gate in range(look.shape[1]):
            if look[pulse, gate] >= 0:
                total = totals[look[pulse, gate], gate]
                for n in range(fields.shape[1]):
                    total[n] += fields[pulse, n]
