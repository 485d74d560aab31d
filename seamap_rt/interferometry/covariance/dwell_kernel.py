"""The inner loops of the means over dwells, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compute.compiled import compiled, compiled_fused, compiled_step_fused


class Table(NamedTuple):
    """Products of two rows of voltages, kind by kind in the order of the pulses to whose dwells they count."""

    first: NDArray[np.int64]  # (product,) row
    second: NDArray[np.int64]  # (product,) row
    owner: NDArray[np.int64]  # (product,) pulse
    begin: NDArray[np.int64]  # (kind, block + 1) product with which a block of pulses begins


class HalfTurns(NamedTuple):
    """What both factors of a product are turned by."""

    phasor: NDArray[np.complex64]  # (number, pulse, gate)
    number: NDArray[np.int64]  # (kind,) −1 for none
    receivers: int  # rows of a pulse


class Sums(NamedTuple):
    """Of products, and of the squares of either factor; (kind, look, gate)."""

    real: NDArray[np.float64]
    imaginary: NDArray[np.float64]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    products: NDArray[np.float64]  # how many


@compiled_fused
def add_products(rows, look, table, turns, low, high, sums):
    """Add the products of gates low … high to the sums of their looks, block by block of pulses. rows (row, gate):
    voltages of a pulse and receiver; look (pulse, gate or 1), −1 for none. Those that are not finite are left out."""
    for block in range(table.begin.shape[1] - 1):
        for kind in range(table.begin.shape[0]):
            n, end = table.begin[kind, block], table.begin[kind, block + 1]
            while n < end:
                looks, last = look[table.owner[n]], n + 1
                while looks.size == 1 and last < end and look[table.owner[last], 0] == looks[0]:
                    last += 1
                gate = low
                while gate < high:  # what is of the same look and lies together is taken together
                    here, stop = looks[min(gate, looks.size - 1)], gate + 1
                    while stop < high and (looks.size == 1 or looks[stop] == here):
                        stop = stop + 1 if looks.size > 1 else high
                    if here >= 0:
                        _add(rows, table, turns, n, last, gate, stop, kind, here, sums)
                    gate = stop
                n = last


@compiled_step_fused
def _add(rows, table, turns, begin, end, start, stop, kind, look, sums):
    """Add products begin … end of gates start … stop to the sums of a look."""
    real, imaginary = sums.real[kind, look], sums.imaginary[kind, look]
    lower, upper = sums.lower[kind, look], sums.upper[kind, look]
    count, number = sums.products[kind, look], turns.number[kind]
    for n in range(begin, end):
        first, second = rows[table.first[n]], rows[table.second[n]]
        if number >= 0:
            turn = turns.phasor[number, table.first[n] // turns.receivers]
            its = turns.phasor[number, table.second[n] // turns.receivers]
            for gate in range(np.uint64(start), np.uint64(stop)):
                value, power, other = _product(first[gate], second[gate])
                good = power + other < np.inf
                value *= turn[gate] * its[gate]
                real[gate] += value.real if good else 0.0
                imaginary[gate] += value.imag if good else 0.0
                lower[gate] += power if good else 0.0
                upper[gate] += other if good else 0.0
                count[gate] += 1.0 if good else 0.0
        else:
            for gate in range(np.uint64(start), np.uint64(stop)):  # unsigned: what may be negative is not vectorised
                value, power, other = _product(first[gate], second[gate])
                good = power + other < np.inf
                real[gate] += value.real if good else 0.0
                imaginary[gate] += value.imag if good else 0.0
                lower[gate] += power if good else 0.0
                upper[gate] += other if good else 0.0
                count[gate] += 1.0 if good else 0.0


@compiled_step_fused
def _product(first, second):
    """Of two voltages a b*, and their powers."""
    a, b = np.complex128(first), np.complex128(second)
    return a * np.conj(b), a.real * a.real + a.imag * a.imag, b.real * b.real + b.imag * b.imag


@compiled
def add_fields(look, fields, totals):
    """Add fields (pulse, field) to the totals (look, gate, field) of each gate's look (pulse, gate), −1 for none."""
    for pulse in range(look.shape[0]):
        for gate in range(look.shape[1]):
            if look[pulse, gate] >= 0:
                total = totals[look[pulse, gate], gate]
                for n in range(fields.shape[1]):
                    total[n] += fields[pulse, n]
