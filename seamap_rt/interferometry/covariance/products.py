"""Means over dwells of products of two voltages, whatever pair of pulses and receivers they are of, in one pass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...compute.machine import pool
from .dwell_kernel import HalfTurns, Sums, Table, add_products
from .dwells import Dwells
from .pairs import Rows
from .windows import Covariance, complex_of

_BLOCK = 64  # pulses whose voltages are gone through for all products at once: they stay in the processor's cache
_GATES = 64  # at a multiple of which each thread begins


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
    voltage: NDArray[np.complex64], dwells: Dwells, kinds: Sequence[Sequence[Products]]
) -> list[Covariance]:
    """Of each kind of products their mean over each cell's dwell, and the mean powers of their first and second
    factors. voltage (pulse, receiver, gate).

    Voltages that are not finite are left out, product by product and gate by gate; cells without products are NaN.
    Sums are kept in float64, in the order of the pulses.
    """
    pulses, receivers, gates = voltage.shape
    rows = np.ascontiguousarray(voltage).reshape(pulses * receivers, gates)
    ends = np.minimum(_BLOCK * np.arange(-(-pulses // _BLOCK) + 1), pulses)
    first, second, owner, begin, start = [], [], [], np.zeros((len(kinds), ends.size), dtype=np.int64), 0
    turns = [next((p.level for p in kind if p.level is not None), None) for kind in kinds]
    for number, kind in enumerate(kinds):
        owners = np.concatenate([p.owner for p in kind])
        order = np.argsort(owners, kind="stable")
        owner.append(owners[order])
        first.append(np.concatenate([p.first[0] * receivers + p.first[1] for p in kind])[order])
        second.append(np.concatenate([p.second[0] * receivers + p.second[1] for p in kind])[order])
        begin[number] = start + np.searchsorted(owner[-1], ends)
        start += owners.size
    table = Table(np.concatenate(first), np.concatenate(second), np.concatenate(owner), begin)
    different = {id(turn): turn for turn in turns if turn is not None}
    phasor = np.stack(list(different.values())) if different else np.zeros((0, 0, 0), dtype=np.complex64)
    number = np.array([-1 if turn is None else list(different).index(id(turn)) for turn in turns])
    shape = len(kinds), dwells.looks, gates
    sums = Sums(*(np.zeros(shape) for _ in Sums._fields))
    given = rows, dwells.look.reshape(pulses, -1), table, HalfTurns(phasor, number, receivers)
    with pool() as workers:  # each has gates of its own, so that their number changes no bit
        count = workers.count
        edges = [*(gates * n // count // _GATES * _GATES for n in range(count)), gates]
        for each in [workers.submit(add_products, *given, low, high, sums) for low, high in pairwise(edges)]:
            each.result()
    share = 1.0 / np.where(sums.products > 0.0, sums.products, np.nan)
    cross = complex_of(sums.real * share, sums.imaginary * share)
    return [Covariance(*each) for each in zip(cross, sums.lower * share, sums.upper * share, strict=True)]
