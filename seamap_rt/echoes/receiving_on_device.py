"""A turn's voltages from its sums at nodes, both on the device: the pulses between nodes, and the receivers.

These are `slow_time`'s and `receiving`'s formulas, for the receivers that need no more: of a plain pulse, a coherent
transmitter and no converter. Three kernels, each with a lane for every number it makes:

    pulses   (pulse, receiver, gate)  the nodes around a pulse, by a windowed sinc
    numbers  (pulse, receiver, tap)   the Gaussians of the noise, those of the processor
    noise    (pulse, receiver, gate)  the numbers through the receiver's filter, and its channel

Nothing goes up but tables, and each pulse's slot in the mode's cycle.
"""

from __future__ import annotations

from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from .. import random_streams
from ..compute.complex_on_device import ComplexOnDevice
from ..compute.device import ONE_AT_A_TIME, Device, device
from ..radar.array import antenna_array
from ..radar.receiver import noise_taps
from ..radar.scan import Pulses
from ..radar.waveform import gate_spacing_m
from ..random_streams import Stream
from ..settings import RadarSettings
from .receiving import Received
from .slow_time import Nodes, paths_of_cycle
from .summation.gaussian_on_device import member, normals


class SumsThere(NamedTuple):
    """Real and imaginary part of a turn's sums, flat (path, gate, node)."""

    real: Any
    imag: Any
    gates: int


def can_receive(radar: RadarSettings) -> bool:
    """Whether a radar's receivers are among those that are worked out here."""
    plain = radar.waveform == "pulse" and radar.transmitter == "coherent"
    return plain and radar.receiver.chain == "baseband"


def received_on_device(total: SumsThere, nodes: Nodes, radar: RadarSettings, pulses: Pulses, seed: int) -> Received:
    """What the receivers record of a turn; see `turn.received`. The voltages stay there."""
    shape = pulses.number.size, len(antenna_array(radar).receivers), total.gates
    with ONE_AT_A_TIME:
        of = device()
        real, imag = _pulses(of, total, nodes, radar, pulses)
        if radar.noise:
            x, y = _noise(of, radar, int(pulses.number[0]), shape, seed)
            real, imag = real + x, imag + y
        real, imag = _through_channels(of, radar, shape, real, imag)
        of.dr.eval(real, imag)
    return Received(cast("NDArray[np.complex64]", ComplexOnDevice(real, imag, shape)), None)


def _pulses(of: Device, total: SumsThere, nodes: Nodes, radar: RadarSettings, pulses: Pulses) -> tuple[Any, Any]:
    """See `slow_time.pulses_from_nodes`."""
    dr, path, weights = of.dr, paths_of_cycle(radar), nodes.weights
    receivers, taps = path.shape[1], weights.shape[1]
    lane = dr.arange(of.UInt32, pulses.number.size * receivers * total.gates)
    gate, cell = lane % total.gates, lane // total.gates
    pulse, receiver = cell // receivers, cell % receivers
    slot = dr.gather(of.UInt32, of.place(pulses.slot.astype(np.uint32)), pulse)
    own = dr.gather(of.Int32, of.place(path.astype(np.int32)), slot * receivers + receiver)
    heard = own >= 0
    first = of.Int32(pulse // nodes.stride) + (1 - taps // 2 - nodes.first)
    entry, table = pulse % nodes.stride * taps, of.place(weights)
    row = (of.UInt32(dr.maximum(own, 0)) * total.gates + gate) * nodes.count
    real = imag = dr.select(heard, of.Float(0.0), of.Float(np.nan))
    for tap in range(taps):
        node = first + tap
        there = heard & (node >= 0) & (node < nodes.count)
        weight, place = dr.gather(of.Float, table, entry + tap), row + of.UInt32(dr.maximum(node, 0))
        real = real + weight * dr.gather(of.Float, total.real, place, there)
        imag = imag + weight * dr.gather(of.Float, total.imag, place, there)
    return real, imag


def _noise(of: Device, radar: RadarSettings, first: int, shape: tuple[int, int, int], seed: int) -> tuple[Any, Any]:
    """See `receiving.add_noise`. first: number of the first pulse."""
    dr, (pulses, receivers, gates) = of.dr, shape
    taps = noise_taps(radar, gate_spacing_m(radar), gates).astype(np.float32)
    whole = gates + taps.size - 1
    lane = dr.arange(of.UInt32, pulses * receivers * whole)
    cell = lane // whole
    key = of.UInt64(int(random_streams.key(seed, Stream.NOISE)))
    key = member(of, member(of, key, of.UInt64(cell // receivers) + first), cell % receivers)
    radius, cosine, sine = normals(of, member(of, key, lane % whole))
    x, y = radius * cosine, radius * sine
    dr.eval(x, y)

    lane = dr.arange(of.UInt32, pulses * receivers * gates)
    begin, table = lane // gates * whole + lane % gates, of.place(taps)

    def add(tap: Any, real: Any, imag: Any) -> tuple[Any, Any, Any]:
        weight, place = dr.gather(of.Float, table, tap), begin + tap
        real = real + weight * dr.gather(of.Float, x, place)
        return tap + 1, real, imag + weight * dr.gather(of.Float, y, place)

    state = dr.zeros(of.UInt32, dr.width(lane)), *(dr.zeros(of.Float, dr.width(lane)) for _ in range(2))
    return dr.while_loop(state, lambda tap, *_: tap < taps.size, add)[1:]


def _through_channels(
    of: Device, radar: RadarSettings, shape: tuple[int, int, int], real: Any, imag: Any
) -> tuple[Any, Any]:
    """Voltages times what each receiver's channel puts to them, its own noise too."""
    array = antenna_array(radar)
    channel = np.array([array.elements[antenna].channel for antenna in array.receivers], dtype=np.complex64)
    if (channel == 1.0).all():
        return real, imag
    dr = of.dr
    receiver = dr.arange(of.UInt32, int(np.prod(shape))) // shape[2] % shape[1]
    a, b = (dr.gather(of.Float, of.place(each), receiver) for each in (channel.real, channel.imag))
    return real * a - imag * b, real * b + imag * a
