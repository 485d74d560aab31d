"""Means over dwells of products of two voltages, whatever pair of pulses and receivers they are of, in one pass."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...compute.compiled import compiled_fused
from ...compute.complex_on_device import ComplexOnDevice
from ...compute.machine import threads
from .dwells import Dwells
from .pairs import Rows
from .windows import Covariance

_BLOCK = 64  # pulses whose voltages are gone through for all products at once: they stay in the processor's cache


@dataclass(frozen=True)
class Products:
    """Voltages that are multiplied, V_first V_second*, one receiver each; a product counts to the dwell of `owner`."""

    first: tuple[Rows, int]  # pulses, receiver
    second: tuple[Rows, int]
    owner: Rows  # pulses
    level: NDArray[np.complex64] | None = None  # (pulse, gate) that both factors are turned by, see `half_turns`


def half_turns(level: NDArray[np.float64]) -> NDArray[np.complex64]:
    """What frees products of two pulses of the mean of their levels (pulse, gate) [rad]: half from either side."""
    half = np.remainder(-0.5 * level, 2.0 * np.pi).astype(np.float32)
    return (np.cos(half) + 1j * np.sin(half)).astype(np.complex64)


def dwell_means(
    voltage: NDArray[np.complex64] | ComplexOnDevice, dwells: Dwells, kinds: Sequence[Sequence[Products]]
) -> list[Covariance]:
    """Of each kind of products their mean over each cell's dwell, and the mean powers of their first and second
    factors. voltage (pulse, receiver, gate).

    Voltages that are not finite are left out, product by product and gate by gate; cells without products are NaN.
    Sums are kept in float64, in the order of the pulses. Of voltages on the device the means alone come here.
    """
    if isinstance(voltage, ComplexOnDevice):
        from .dwells_on_device import dwell_means_on_device  # loaded where there is one

        return dwell_means_on_device(voltage, dwells, kinds)
    pulses, receivers, gates = voltage.shape
    rows = np.ascontiguousarray(voltage).reshape(pulses * receivers, gates)
    ends = np.minimum(_BLOCK * np.arange(-(-pulses // _BLOCK) + 1), pulses)
    first, second, owner, begin, start = [], [], [], np.zeros((len(kinds), ends.size), dtype=np.uint64), 0
    turns = [next((p.level for p in kind if p.level is not None), None) for kind in kinds]
    for number, kind in enumerate(kinds):
        owners = np.concatenate([p.owner for p in kind])
        order = np.argsort(owners, kind="stable")
        owner.append(owners[order])
        first.append(np.concatenate([p.first[0] * receivers + p.first[1] for p in kind])[order])
        second.append(np.concatenate([p.second[0] * receivers + p.second[1] for p in kind])[order])
        begin[number] = start + np.searchsorted(owner[-1], ends)
        start += owners.size
    look = dwells.look.reshape(pulses, -1)
    table = np.stack([np.concatenate(part) for part in (first, second, owner)]).astype(np.int64)
    totals = np.zeros((len(kinds), dwells.looks, 5, gates))
    different = {id(turn): turn for turn in turns if turn is not None}
    stack = np.stack(list(different.values())) if different else np.zeros((0, 0, 0), dtype=np.complex64)
    which = np.array([-1 if turn is None else list(different).index(id(turn)) for turn in turns])
    count = threads()  # each has gates of its own, so that their number changes no bit
    edges = [gates * n // count for n in range(count + 1)]
    with ThreadPoolExecutor(count) as pool:
        work = [
            pool.submit(_accumulate, rows, look, table, begin, stack, which, receivers, low, high, totals)
            for low, high in pairwise(edges)
        ]
    for each in work:
        each.result()
    return [_mean(total) for total in totals]


def _mean(total: NDArray[np.float64]) -> Covariance:
    """Of sums (look, 5, gate): real and imaginary parts, both powers, and how many they are."""
    with np.errstate(invalid="ignore"):
        mean = total[:, :4] / np.where(total[:, 4:] > 0.0, total[:, 4:], np.nan)
    return Covariance(mean[:, 0] + 1j * mean[:, 1], mean[:, 2], mean[:, 3])


@compiled_fused
def _accumulate(rows, look, table, begin, turns, which, receivers, low, high, totals):
    """Add the products of each kind at gates low … high to totals (kind, look, 5, gate), block by block of pulses.

    Along a row, gates of the same look are taken together: of an upright fan they all are.
    """
    for block in range(begin.shape[1] - 1):
        for kind in range(begin.shape[0]):
            for n in range(begin[kind, block], begin[kind, block + 1]):
                one, other, number = table[0, n], table[1, n], look[table[2, n]]
                gate = low
                while gate < high:
                    here, stop = number[min(gate, number.size - 1)], gate + 1
                    while stop < high and (number.size == 1 or number[stop] == here):
                        stop = stop + 1 if number.size > 1 else high
                    if here >= 0 and which[kind] < 0:
                        _add(rows[one], rows[other], gate, stop, totals[kind, here])
                    elif here >= 0:
                        turn = turns[which[kind]]
                        _add_rotated(
                            rows[one],
                            rows[other],
                            turn[one // receivers],
                            turn[other // receivers],
                            gate,
                            stop,
                            totals[kind, here],
                        )
                    gate = stop


@compiled_fused
def _add(a, b, start, stop, total):
    for g in range(np.uint64(start), np.uint64(stop)):  # unsigned: an index that may be negative is not vectorised
        real = a[g].real * b[g].real + a[g].imag * b[g].imag
        imaginary = a[g].imag * b[g].real - a[g].real * b[g].imag
        power, other = a[g].real ** 2 + a[g].imag ** 2, b[g].real ** 2 + b[g].imag ** 2
        good = power + other < np.inf
        total[0, g] += real if good else 0.0
        total[1, g] += imaginary if good else 0.0
        total[2, g] += power if good else 0.0
        total[3, g] += other if good else 0.0
        total[4, g] += 1.0 if good else 0.0


@compiled_fused
def _add_rotated(a, b, turn, other_turn, start, stop, total):
    for g in range(np.uint64(start), np.uint64(stop)):
        real = a[g].real * b[g].real + a[g].imag * b[g].imag
        imaginary = a[g].imag * b[g].real - a[g].real * b[g].imag
        cosine = turn[g].real * other_turn[g].real - turn[g].imag * other_turn[g].imag
        sine = turn[g].real * other_turn[g].imag + turn[g].imag * other_turn[g].real
        power, other = a[g].real ** 2 + a[g].imag ** 2, b[g].real ** 2 + b[g].imag ** 2
        good = power + other < np.inf
        total[0, g] += real * cosine - imaginary * sine if good else 0.0
        total[1, g] += real * sine + imaginary * cosine if good else 0.0
        total[2, g] += power if good else 0.0
        total[3, g] += other if good else 0.0
        total[4, g] += 1.0 if good else 0.0
