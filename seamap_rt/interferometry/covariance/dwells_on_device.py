"""Dwells of voltages that lie on the device: what is asked of voltages there, by kernels of which only cells come back.

The formulas are those of `products`, `pairs` and `windows`. Nothing is added atomically: a lane is a number that comes
out, and goes through the pulses that may be in it, one after another, so that who runs first changes no bits.

    means    (kind, look, gate)   products of the pulses of a dwell, their powers, and how many they are
    heard    (pulse, receiver)    gates one after another, until one is finite
    powers   (pulse, gate)        of chosen ones

Sums are float32, of a dwell's tens to hundreds of products: √N roundings of 6e-8, a millionth of the powers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...compute.complex_on_device import ComplexOnDevice
from ...compute.device import ONE_AT_A_TIME, Device, device
from .dwells import Dwells
from .windows import Covariance

if TYPE_CHECKING:
    from .products import Products

_Edges = tuple[NDArray[np.uint32], NDArray[np.uint32]]


def dwell_means_on_device(
    voltage: ComplexOnDevice, dwells: Dwells, kinds: Sequence[Sequence[Products]]
) -> list[Covariance]:
    """See `products.dwell_means`."""
    pulses, receivers, gates = voltage.shape
    look = dwells.look.reshape(pulses, -1)
    with ONE_AT_A_TIME:
        of, levels = device(), dict[int, ComplexOnDevice]()
        number = of.place(look.astype(np.int32))
        sums = []
        for kind in kinds:
            owner = np.concatenate([each.owner for each in kind])
            order = np.argsort(owner, kind="stable")
            first, second = (
                np.concatenate([getattr(each, side)[0] * receivers + getattr(each, side)[1] for each in kind])[order]
                for side in ("first", "second")
            )
            level = next((each.level for each in kind if each.level is not None), None)
            if level is not None and id(level) not in levels:
                levels[id(level)] = ComplexOnDevice.of(np.broadcast_to(level, (pulses, gates)))
            rows = tuple(of.place(each.astype(np.uint32)) for each in (first, second, owner[order]))
            edges = _edges(look[owner[order]], dwells.looks)
            turn = None if level is None else levels[id(level)]
            sums.append(_summed(of, voltage, number, look.shape[1], rows, edges, turn))
        of.dr.eval(sums)
        return [_fetched(of, each, (dwells.looks, gates)) for each in sums]


def _edges(look: NDArray[np.intp], looks: int) -> _Edges:
    """(look,): between which products all lie that any of its cells has, of the looks (product, 1 or gate) of each."""
    low, high = np.where(look < 0, looks, look).min(axis=1), look.max(axis=1)  # −1 is no look
    begin, end = np.full(looks, look.shape[0]), np.zeros(looks, dtype=np.intp)
    there = np.flatnonzero(high >= 0)
    for beyond in range(int((high - low)[there].max(initial=-1)) + 1):
        within = there[low[there] + beyond <= high[there]]
        np.minimum.at(begin, low[within] + beyond, within)
        np.maximum.at(end, low[within] + beyond, within + 1)
    return np.minimum(begin, end).astype(np.uint32), end.astype(np.uint32)


def _summed(
    of: Device,
    voltage: ComplexOnDevice,
    number: Any,
    columns: int,
    rows: tuple[Any, Any, Any],
    edges: _Edges,
    level: ComplexOnDevice | None,
) -> list[Any]:
    """(look, gate) means of products: real and imaginary part, and both powers; NaN where there are none.

    number: look (pulse, column) of each pulse, the same for all gates where there is one column; rows: of both factors,
    pulse by receiver, and the pulse to whose dwell they count.
    """
    dr, (_, receivers, gates) = of.dr, voltage.shape
    lane = dr.arange(of.UInt32, edges[0].size * gates)
    look, gate = lane // gates, lane % gates
    own, column = of.Int32(look), gate if columns > 1 else of.UInt32(0)
    begin, end = (dr.gather(of.UInt32, of.place(each), look) for each in edges)

    def factor(row: Any) -> tuple[Any, Any]:
        place = row * gates + gate
        return dr.gather(of.Float, voltage.real_there, place), dr.gather(of.Float, voltage.imag_there, place)

    def turn(row: Any) -> tuple[Any, Any]:
        assert level is not None
        place = row // receivers * gates + gate
        return dr.gather(of.Float, level.real_there, place), dr.gather(of.Float, level.imag_there, place)

    def add(n: Any, *sums: Any) -> tuple[Any, ...]:
        one, other, owner = (dr.gather(of.UInt32, each, n) for each in rows)
        (a, b), (c, d) = factor(one), factor(other)
        real, imag, lower, upper = a * c + b * d, b * c - a * d, a * a + b * b, c * c + d * d
        if level is not None:
            (p, q), (r, s) = turn(one), turn(other)
            cosine, sine = p * r - q * s, p * s + q * r
            real, imag = real * cosine - imag * sine, real * sine + imag * cosine
        good = dr.isfinite(lower + upper) & (dr.gather(of.Int32, number, owner * columns + column) == own)
        added = (real, imag, lower, upper, of.Float(1.0))
        return n + 1, *(s + dr.select(good, each, 0.0) for s, each in zip(sums, added, strict=True))

    state = begin, *(dr.zeros(of.Float, dr.width(lane)) for _ in range(5))
    *total, count = dr.while_loop(state, lambda n, *_: n < end, add)[1:]
    return [dr.select(count > 0.0, each / count, of.Float(np.nan)) for each in total]


def _fetched(of: Device, parts: list[Any], shape: tuple[int, int]) -> Covariance:
    real, imag, lower, upper = (of.fetch(each, shape).astype(np.float64) for each in parts)
    return Covariance(real + 1j * imag, lower, upper, there=True)


def sampled_on_device(voltage: ComplexOnDevice) -> NDArray[np.bool_]:
    """See `pairs.sampled`."""
    pulses, receivers, gates = voltage.shape
    with ONE_AT_A_TIME:
        of = device()
        dr, lane = of.dr, of.dr.arange(of.UInt32, pulses * receivers)

        def look(gate: Any, _: Any) -> tuple[Any, Any]:
            return gate + 1, dr.isfinite(dr.gather(of.Float, voltage.real_there, lane * gates + gate))

        state = dr.zeros(of.UInt32, pulses * receivers), dr.zeros(of.Float, pulses * receivers) > 0.0
        heard = dr.while_loop(state, lambda gate, heard: (gate < gates) & ~heard, look)[1]
        return of.fetch(heard, (pulses, receivers))


def powers_on_device(
    voltage: ComplexOnDevice, receiver: int, rows: NDArray[np.intp], gates: NDArray[np.intp] | None = None
) -> NDArray[np.float64]:
    """See `windows.powers`."""
    _, receivers, count = voltage.shape
    gates = np.arange(count) if gates is None else gates
    with ONE_AT_A_TIME:
        of = device()
        dr, lane = of.dr, of.dr.arange(of.UInt32, rows.size * gates.size)
        row = dr.gather(of.UInt32, of.place((rows * receivers + receiver).astype(np.uint32)), lane // gates.size)
        place = row * count + dr.gather(of.UInt32, of.place(gates.astype(np.uint32)), lane % gates.size)
        real, imag = (dr.gather(of.Float, each, place) for each in (voltage.real_there, voltage.imag_there))
        power = real * real + imag * imag
        power = dr.select(dr.isfinite(power), power, 0.0)
        return of.fetch(power, (rows.size, gates.size)).astype(np.float64)
