"""Means over dwells of products of two voltages, whatever pair of pulses and receivers they are of, in one pass.

Which pulses the interferogram compares: the same one of both receivers, or neighbours where the receivers alternate.

Between neighbours τ apart an echo that recedes at v turns its phase by 2k v τ: pairs with the pulse after (forward)
see that turn one way, those with the pulse before the other way, and the mean of both products has none of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled_fused, compiled_step_fused
from ..compute.machine import pool
from ..errors import SchemaError
from .dwells import Dwells
from .windows import Covariance, complex_of

Rows = NDArray[np.intp]


@dataclass(frozen=True)
class PulsePairs:
    """Rows of the echoes: where each receiver is sampled, and the (lower, upper) rows that are multiplied."""

    lower: Rows
    upper: Rows
    pairs: tuple[tuple[Rows, Rows], ...]  # forward, backward, or both

    @property
    def members(self) -> tuple[Rows, Rows]:
        """Rows of all pulses in the products, each as often as it is in one, and the lower pulse of that product: how
        the array stood for a dwell is their mean, not that of all pulses, from which it is half a pulse off."""
        rows = np.concatenate([row for pair in self.pairs for row in pair])
        return rows, np.concatenate([n for n, _ in self.pairs for _ in range(2)])

    @property
    def noise_square(self) -> float:
        """How much of the noise's own beat is left per lower pulse.

        In the mean of forward and backward products each lower pulse meets two upper ones, so that the products of
        noise with noise are twice as many; those of noise with echo are no more than the pulses themselves.
        """
        return 1.0 / len(self.pairs)


def sampled(voltage: NDArray[np.complex64]) -> NDArray[np.bool_]:
    """Whether each receiver was sampled on each pulse, (pulse, receiver), of voltage (pulse, receiver, gate)."""
    known = np.asarray(np.isfinite(voltage[:, :, voltage.shape[2] // 2].real))  # one gate decides for most pulses
    rest = np.nonzero(~known)
    known[rest] = np.isfinite(voltage[rest].real).any(axis=1)
    return known


def neighbouring_pulses(heard: NDArray[np.bool_], time: NDArray[np.float64], interval: float, which: str) -> PulsePairs:
    """Pairs of alternating pulses. heard (pulse, 2) lower, upper; time (pulse,) and interval [s]; which: forward,
    backward or both. Only neighbours one interval apart are pairs: none is made across pulses that are missing.

    Raises SchemaError where receivers do not alternate, or are never neighbours in the order that is requested.
    """
    if heard.all(axis=1).any():
        raise SchemaError(
            "echoes: interferogram = 'alternating_pulse', yet both receivers hold voltages on the same pulse; "
            "set those that were not sampled to NaN"
        )
    following = np.abs(np.diff(time) - interval) < 0.5 * interval
    before, after = heard[:-1], heard[1:]
    forward = np.flatnonzero(following & before[:, 0] & after[:, 1])
    backward = np.flatnonzero(following & before[:, 1] & after[:, 0])
    made = {"forward": (forward, forward + 1), "backward": (backward + 1, backward)}
    chosen = tuple(made) if which == "both" else (which,)
    if heard.any(axis=0).all() and not all(made[each][0].size for each in chosen):
        raise SchemaError(
            f"echoes: no two neighbouring pulses make a {' and a '.join(chosen)} pair of the receivers; choose others "
            "by retrieval.receivers, or one direction by retrieval.pulse_pairs"
        )
    lower, upper = (np.flatnonzero(heard[:, receiver]) for receiver in (0, 1))
    return PulsePairs(lower, upper, tuple(made[each] for each in chosen))


def same_pulses(heard: NDArray[np.bool_]) -> PulsePairs:
    """Each pulse that both receivers heard, with itself. heard (pulse, 2)."""
    rows = np.flatnonzero(heard.all(axis=1))
    return PulsePairs(rows, rows, ((rows, rows),))


def two_way_pairs(
    heard: NDArray[np.bool_],
    transmitter: NDArray[np.integer],
    antennas: tuple[int, int],
    time: NDArray[np.float64],
    interval: float,
    which: str,
) -> PulsePairs | None:
    """Pairs of neighbouring pulses of which each antenna hears its own: an interferogram of both ways, p = 2.

    It exists beside that of one way where the transmitters alternate and both receivers hear all; None where it does
    not. heard (pulse, receiver), transmitter (pulse,), time (pulse,) and interval [s]; which: of PulsePairs.
    """
    own = heard & (np.asarray(transmitter)[:, None] == np.asarray(antennas))
    following = np.abs(np.diff(time) - interval) < 0.5 * interval
    forward, backward = ((own[:-1, n] & own[1:, 1 - n] & following).any() for n in (0, 1))
    there = {"forward": forward, "backward": backward, "both": forward and backward}[which]
    return neighbouring_pulses(own, time, interval, which) if there else None


def rows_apart(time: NDArray[np.float64], lag: float, interval: float) -> tuple[Rows, Rows]:
    """Rows of pulses of which the second comes `lag` [s] after the first, before it if negative, within half the
    interval [s] between pulses; times (pulse,) rise. Where one is missing there is no pair."""
    count, least, most = round(lag / interval), lag - 0.5 * interval, lag + 0.5 * interval
    if 0 < count < time.size:  # of pulses that never miss the answer is at hand
        beyond, within = time[count:] - time[:-count], time[count - 1 :] - time[: time.size - count + 1]
        if beyond.min() > least and beyond.max() < most and within.max() < least:
            there = np.arange(time.size - count)
            return there, there + count
    later = np.searchsorted(time, time + lag - 0.5 * interval)
    there = np.flatnonzero(later < time.size)
    there = there[np.abs(time[later[there]] - time[there] - lag) < 0.5 * interval]
    return there, later[there]


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
    for n in range(begin, end, 2):  # two at a time, in their order: sums are loaded and stored half as often
        m, share = min(n + 1, end - 1), 1.0 if n + 1 < end else 0.0
        a, b, c, d = rows[table.first[n]], rows[table.second[n]], rows[table.first[m]], rows[table.second[m]]
        if number >= 0:
            phasor = turns.phasor[number]
            of_a, of_b = phasor[table.first[n] // turns.receivers], phasor[table.second[n] // turns.receivers]
            of_c, of_d = phasor[table.first[m] // turns.receivers], phasor[table.second[m] // turns.receivers]
            for gate in range(np.uint64(start), np.uint64(stop)):
                one = _product(a[gate], b[gate], of_a[gate] * of_b[gate], 1.0)
                other = _product(c[gate], d[gate], of_c[gate] * of_d[gate], share)
                real[gate] = real[gate] + one[0] + other[0]
                imaginary[gate] = imaginary[gate] + one[1] + other[1]
                lower[gate] = lower[gate] + one[2] + other[2]
                upper[gate] = upper[gate] + one[3] + other[3]
                count[gate] = count[gate] + one[4] + other[4]
        else:
            for gate in range(np.uint64(start), np.uint64(stop)):  # unsigned: what may be negative is not vectorised
                one = _product(a[gate], b[gate], None, 1.0)
                other = _product(c[gate], d[gate], None, share)
                real[gate] = real[gate] + one[0] + other[0]
                imaginary[gate] = imaginary[gate] + one[1] + other[1]
                lower[gate] = lower[gate] + one[2] + other[2]
                upper[gate] = upper[gate] + one[3] + other[3]
                count[gate] = count[gate] + one[4] + other[4]


@compiled_step_fused
def _product(first, second, turn, share):
    """Of two voltages a b*, turned if so, its parts, their powers, and one; times a share, or nothing if not finite."""
    a, b = np.complex128(first), np.complex128(second)
    value = a * np.conj(b)
    if turn is not None:
        value *= turn
    power, other = a.real * a.real + a.imag * a.imag, b.real * b.real + b.imag * b.imag
    good = power + other < np.inf
    return (
        share * value.real if good else 0.0,
        share * value.imag if good else 0.0,
        share * power if good else 0.0,
        share * other if good else 0.0,
        share if good else 0.0,
    )


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
    share = sums.products
    share[share == 0.0] = np.nan
    np.reciprocal(share, out=share)
    for each in sums[:4]:
        each *= share  # in place: the kernel's pages for new memory cost more than the products
    cross = complex_of(sums.real, sums.imaginary)
    return [Covariance(*each) for each in zip(cross, sums.lower, sums.upper, strict=True)]
