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

    cross: NDArray[np.complex128]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    count: NDArray[np.float64]


@compiled_fused
def add_products(rows, look, table, turns, low, high, sums):
    """Add the products of gates low … high to the sums of their looks, block by block of pulses. rows (row, gate):
    voltages of a pulse and receiver; look (pulse, gate or 1), −1 for none. Those that are not finite are left out."""
    for block in range(table.begin.shape[1] - 1):
        for kind in range(table.begin.shape[0]):
            for n in range(table.begin[kind, block], table.begin[kind, block + 1]):
                one, other, looks = table.first[n], table.second[n], look[table.owner[n]]
                gate = low
                while gate < high:  # those of the same look that lie together are taken together
                    here, stop = looks[min(gate, looks.size - 1)], gate + 1
                    while stop < high and (looks.size == 1 or looks[stop] == here):
                        stop = stop + 1 if looks.size > 1 else high
                    number = turns.number[kind]
                    if here >= 0 and number < 0:
                        _add(rows[one], rows[other], gate, stop, kind, here, sums)
                    elif here >= 0:
                        turn = turns.phasor[number, one // turns.receivers]
                        its = turns.phasor[number, other // turns.receivers]
                        _add_turned(rows[one], rows[other], turn, its, gate, stop, kind, here, sums)
                    gate = stop


@compiled_step_fused
def _add(first, second, start, stop, kind, look, sums):
    cross, lower, upper = sums.cross[kind, look], sums.lower[kind, look], sums.upper[kind, look]
    count = sums.count[kind, look]
    for gate in range(np.uint64(start), np.uint64(stop)):  # unsigned: an index that may be negative is not vectorised
        a, b = np.complex128(first[gate]), np.complex128(second[gate])
        power, other = a.real * a.real + a.imag * a.imag, b.real * b.real + b.imag * b.imag
        good = power + other < np.inf
        cross[gate] += a * np.conj(b) if good else 0.0j
        lower[gate] += power if good else 0.0
        upper[gate] += other if good else 0.0
        count[gate] += 1.0 if good else 0.0


@compiled_step_fused
def _add_turned(first, second, turn, other_turn, start, stop, kind, look, sums):
    cross, lower, upper = sums.cross[kind, look], sums.lower[kind, look], sums.upper[kind, look]
    count = sums.count[kind, look]
    for gate in range(np.uint64(start), np.uint64(stop)):
        a, b = np.complex128(first[gate]), np.complex128(second[gate])
        power, other = a.real * a.real + a.imag * a.imag, b.real * b.real + b.imag * b.imag
        good = power + other < np.inf
        cross[gate] += a * np.conj(b) * (turn[gate] * other_turn[gate]) if good else 0.0j
        lower[gate] += power if good else 0.0
        upper[gate] += other if good else 0.0
        count[gate] += 1.0 if good else 0.0


@compiled
def add_fields(look, fields, totals):
    """Add fields (pulse, field) to the totals (look, gate, field) of each gate's look (pulse, gate), −1 for none."""
    for pulse in range(look.shape[0]):
        for gate in range(look.shape[1]):
            if look[pulse, gate] >= 0:
                total = totals[look[pulse, gate], gate]
                for n in range(fields.shape[1]):
                    total[n] += fields[pulse, n]
