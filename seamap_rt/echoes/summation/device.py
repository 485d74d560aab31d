"""The same sum as Dr.Jit kernels, for a graphics processor; on LLVM too, where tests hold it against the processor's.

Nothing is added atomically: who runs first changes no bits. Five kernels, each with a lane for every number it makes:

    patterns  (path or 1, column, gate, node)  the beam's voltage towards the mean sea at a gate
    numbers   (facet, mode)                    each facet's Gaussians, by counting: those of the processor's kernel
    voltages  (path, facet, node)              modes, beam and phase of a facet at the nodes of its column's window
    columns   (column, path, gate, node)       the facets near a gate, through its response, one after another
    sums      (path, gate, node)               the columns whose windows hold a node, one after another

Graphics processors are slow in float64, some of them 64 times. So it is used where a number is large beside what counts
of it, and once a facet or once a gate, never once a facet and node: a facet's phase in the middle of its window, which
is reduced to one cycle, its range from its own gate, and the entry of the beam's table. From there the nodes go on in
float32: a phase by what it advances, at most some ten cycles, of which float32 keeps 1e-6 rad.

The facets are a batch's, from the host (`sum_columns`), or listed there (`Heard`, of `echoes.on_device`); the sums come
back once.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compute.device import ONE_AT_A_TIME, Device, device
from .batch import ALIKE, ColumnBatch
from .gaussian_on_device import member, normals


class Heard(NamedTuple):
    """The facets of a batch that echo, on the device; arrays (facet,), of each path where there is a list of them."""

    column: Any  # UInt32, of the batch
    number: Any  # UInt32, in its column, key in the random source
    strength: list[Any]  # of each kind of scatterer, share of the voltage
    path: list[OnPath]


class OnPath(NamedTuple):
    """The same facets on one path."""

    cycles: Any  # of the phase in the middle of the window, ±½
    step: Any  # cycles from node to node
    own: Any  # UInt32, the gate whose middle is nearest, of those that there are
    first: Any  # Int32, the nearest gate that can hear it, there or not
    entry: Any  # of that gate's response, from the table's last, negative: the processor's, to the entry
    real: Any  # √W, of the amplitude
    imag: Any  # None where it is real
    begin: Any  # UInt32 (column, gate): between which facets all lie that a gate hears of a column; some between are
    end: Any  # too far, and heard with 0


def sum_columns(batch: ColumnBatch) -> NDArray[np.float32]:
    """The sum (component, path, gate, node) [√W] of the batch's columns; component: real, imaginary.

    Raises NoBackend where Dr.Jit has nothing to run on. Calls from several threads take turns.
    """
    starts = batch.columns.first_facet
    if starts[0] == starts[-1]:
        return np.zeros((2, len(batch.geometry.antennas), batch.beam.level.size, batch.nodes), dtype=np.float32)
    with ONE_AT_A_TIME:
        return fetched(batch, sum_heard(batch, _placed(batch)))


def fetched(batch: ColumnBatch, sums: list[tuple[Any, Any]]) -> NDArray[np.float32]:
    """The sums (component, path, gate, node), back here."""
    shape = batch.beam.level.size, batch.nodes
    out = np.empty((2, len(sums), *shape), dtype=np.float32)
    for path, parts in enumerate(sums):
        out[0, path], out[1, path] = (device().fetch(each, shape) for each in parts)
    return out


def sum_heard(batch: ColumnBatch, heard: Heard) -> list[tuple[Any, Any]]:
    """Real and imaginary part (gate, node) of each path's sum, of facets that are on the device; those of the batch are
    not looked at."""
    of = device()
    patterns = _patterns(of, batch)
    drawn = _numbers(of, batch, heard)
    voltages = _voltages(of, batch, heard, drawn, patterns)
    return _sums(of, batch, _columns(of, batch, heard, voltages))


def _placed(batch: ColumnBatch) -> Heard:
    """A batch's facets, placed there."""
    of, facets, geometry, response = device(), batch.facets, batch.geometry, batch.response
    starts = batch.columns.first_facet
    column = np.searchsorted(starts[1:-1], np.arange(facets.number.size), side="right").astype(np.uint32)
    at = of.place(column)
    middle = of.dr.gather(of.Float64, of.place(middle_s(batch)), at)
    once = of.place(facets.range_m)
    paths = []
    for number, (i, j) in enumerate(geometry.antennas):
        longer = facets.difference_m[i] + facets.difference_m[j]
        beyond = facets.range_m + 0.5 * longer - response.first_gate_m
        rate = facets.radial_velocity[i] + facets.radial_velocity[j]
        amplitude, bent = facets.amplitude[number], bool(facets.amplitude[number].imag.any())
        paths.append(
            on_path(
                batch, once, of.place(longer), of.place(rate), middle,
                of.place(amplitude.real), of.place(amplitude.imag) if bent else None,
                *(of.place(each) for each in _near(batch, beyond)),
            )
        )  # fmt: skip
    strength = [of.place(kind) for kind in np.moveaxis(batch.speckle.strength, 1, 0)]
    return Heard(at, of.place(facets.number.astype(np.uint32)), strength, alike(batch, paths))


def middle_s(batch: ColumnBatch) -> NDArray[np.float64]:
    """(column,) s after the beam's passing, of the middle of the window."""
    half = 0.5 * (batch.window - 1) * batch.geometry.node_spacing_s
    return np.asarray(batch.columns.begin_s + half, dtype=np.float64)


def on_path(
    batch: ColumnBatch,
    range_m: Any,
    longer: Any,
    rate: Any,
    middle: Any,
    real: Any,
    imag: Any,
    begin: Any,
    end: Any,
) -> OnPath:
    """Facets on a path, from float64: R₀ [m], by how much both legs are longer than it [m], the rate of both together
    [m/s], and s of the middle of their windows."""
    of, geometry, response = device(), batch.geometry, batch.response
    per_metre = geometry.wavenumber / (2.0 * np.pi)
    cycles = (2.0 * range_m + longer + rate * middle) * -per_metre
    beyond = range_m + 0.5 * longer - response.first_gate_m
    own = of.dr.clip(of.Int32(beyond / response.gate_spacing_m + 0.5), 0, batch.beam.level.size - 1)
    last, spacing = response.table.shape[1] - 1, response.gate_spacing_m
    near = beyond - last / response.entries_per_m
    first = of.dr.ceil(near / spacing)
    rows = int(np.ceil(spacing * response.entries_per_m))
    row = of.dr.minimum(of.Int32((first * spacing - near) * response.entries_per_m), rows - 1)
    return OnPath(
        cycles=of.Float(cycles - of.dr.round(cycles)),
        step=of.Float(rate * (-per_metre * geometry.node_spacing_s)),
        own=of.UInt32(own),
        first=of.Int32(first),
        entry=of.Float(row) + (0.5 - last),
        real=real,
        imag=imag,
        begin=begin,
        end=end,
    )


def alike(batch: ColumnBatch, paths: list[OnPath]) -> list[OnPath]:
    """The paths, of which facets that hardly differ in step have the same, as the processor lets them share a phasor:
    what agrees in the middle of the window errs by at most half of ALIKE at its ends."""
    of, made = device(), list[OnPath]()
    most = ALIKE / (2.0 * np.pi * batch.window)
    own = list[Any]()  # whether a facet's step on a path is not another's
    for path in paths:
        step, alone = path.step, of.Bool(True)
        for other, its_own in zip(made, own, strict=True):
            same = alone & its_own & (abs(path.step - other.step) <= most)
            step, alone = of.dr.select(same, other.step, step), alone & ~same
        made.append(path._replace(step=step))
        own.append(alone)
    return made


def _near(batch: ColumnBatch, beyond: NDArray[np.float64]) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """`OnPath`'s begin and end. beyond (facet,): m of a facet from the first gate. Facets stand nearly, not wholly, by
    range."""
    starts, middle, support = batch.columns.first_facet, gate_middles(batch), support_m(batch)
    begin, end = (np.zeros((starts.size - 1, middle.size), np.uint32) for _ in range(2))
    for column, (low, high) in enumerate(pairwise(starts)):
        ranges = beyond[low:high]
        begin[column] = low + np.searchsorted(np.maximum.accumulate(ranges), middle - support)
        end[column] = low + np.searchsorted(np.minimum.accumulate(ranges[::-1])[::-1], middle + support, side="right")
    return begin, np.maximum(begin, end)


def gate_middles(batch: ColumnBatch) -> NDArray[np.float64]:
    """(gate,) m from the first one's."""
    return np.asarray(batch.response.gate_spacing_m * np.arange(batch.beam.level.size), dtype=np.float64)


def support_m(batch: ColumnBatch) -> float:
    """m off a gate's middle, from which on it hears nothing."""
    return batch.response.table.shape[1] / batch.response.entries_per_m


# ------------------------------------------------------------------------------------------------------ patterns


def _patterns(of: Device, batch: ColumnBatch) -> list[Any]:
    """Of each path, or of the one that stands for all: the beam's voltage (column, gate, node), out and back."""
    dr, beam, window, gates = of.dr, batch.beam, batch.window, batch.beam.level.size
    lane = dr.arange(of.UInt32, batch.columns.number.size * gates * window)
    cell, node = lane // window, lane % window
    gate, place = cell % gates, (cell // gates) * window + node
    level, drop, inverse = (
        dr.gather(of.Float64, of.place(each * beam.entries_per_cosine), gate)
        for each in (beam.level, beam.drop, beam.inverse_range)
    )
    along, up, past = (dr.gather(of.Float64, of.place(each), place) for each in (beam.along, beam.up, beam.past_m))
    entry = level * along - drop * up - inverse * past
    entries, made = beam.table.shape[2], []
    for table, aside in zip(beam.table, beam.aside_m, strict=True):
        pattern = of.Float(1.0)
        for leg, off in zip(table, aside, strict=True):
            shifted = entry + (0.5 * entries - float(off) * inverse)
            number = of.UInt32(dr.clip(shifted, 0.0, entries - 1.0))
            pattern = pattern * dr.gather(of.Float, of.place(leg), number)
        made.append(pattern)
    dr.eval(made)
    return made


# ------------------------------------------------------------------------------------------------------- numbers


def _numbers(of: Device, batch: ColumnBatch, heard: Heard) -> tuple[Any, Any]:
    """Real and imaginary part (facet, mode) of the facets' Gaussians, times the strength of their kind."""
    dr, speckle, modes = of.dr, batch.speckle, batch.speckle.modes.shape[1]
    lane = dr.arange(of.UInt32, dr.width(heard.column) * modes)
    facet, mode = lane // modes, lane % modes
    second = mode >= speckle.first_kind_modes
    of_kind = dr.select(second, mode - speckle.first_kind_modes, mode)
    first, other = (of.UInt64(int(stream)) for stream in (speckle.streams[0], speckle.streams[-1]))
    column = dr.gather(of.UInt32, heard.column, facet)
    number = dr.gather(of.UInt64, of.place(batch.columns.number.astype(np.uint64)), column)
    key = member(of, dr.select(second, other, first), number)
    key = member(of, key, dr.gather(of.UInt32, heard.number, facet))
    radius, cosine, sine = normals(of, member(of, key, of_kind))
    strengths = (dr.gather(of.Float, each, facet) for each in (heard.strength[0], heard.strength[-1]))
    of_first, of_other = strengths
    radius *= dr.select(second, of_other, of_first)
    made = radius * cosine, radius * sine
    dr.eval(made)
    return made


# ------------------------------------------------------------------------------------------------------ voltages


def _voltages(
    of: Device, batch: ColumnBatch, heard: Heard, drawn: tuple[Any, Any], patterns: list[Any]
) -> list[tuple[Any, Any]]:
    """For each path, real and imaginary part (facet, node) of what a facet returns, before the gates' response."""
    dr, window, gates = of.dr, batch.window, batch.beam.level.size
    lane = dr.arange(of.UInt32, dr.width(heard.column) * window)
    facet, node = lane // window, lane % window
    column = dr.gather(of.UInt32, heard.column, facet)
    real, imag = _speckle(of, batch, drawn, facet, node, column)
    since = of.Float(node) - 0.5 * (window - 1)
    made = []
    for number, path in enumerate(heard.path):
        cycles, step, amplitude = (dr.gather(of.Float, each, facet) for each in (path.cycles, path.step, path.real))
        cycles = cycles + step * since
        sine, cosine = dr.sincos((cycles - dr.round(cycles)) * (2.0 * np.pi))
        place = (column * gates + dr.gather(of.UInt32, path.own, facet)) * window + node
        pattern = dr.gather(of.Float, patterns[number % len(patterns)], place)
        turned = real * cosine - imag * sine, real * sine + imag * cosine
        u = amplitude * pattern
        if path.imag is None:
            made.append((u * turned[0], u * turned[1]))
            continue
        v = dr.gather(of.Float, path.imag, facet) * pattern
        made.append((u * turned[0] - v * turned[1], u * turned[1] + v * turned[0]))
    dr.eval(made)
    return made


def _speckle(
    of: Device, batch: ColumnBatch, drawn: tuple[Any, Any], facet: Any, node: Any, column: Any
) -> tuple[Any, Any]:
    """A facet's speckle at a node: its numbers times the modes of its column."""
    dr, modes, window = of.dr, batch.speckle.modes, batch.window
    a, b = of.place(modes.real), of.place(modes.imag)
    first = column * (modes.shape[1] * window) if modes.shape[0] > 1 else of.UInt32(0)
    real, imag = of.Float(0.0), of.Float(0.0)
    for mode in range(modes.shape[1]):
        x, y = (dr.gather(of.Float, each, facet * modes.shape[1] + mode) for each in drawn)
        place = first + (mode * window) + node
        c, d = dr.gather(of.Float, a, place), dr.gather(of.Float, b, place)
        real, imag = real + x * c - y * d, imag + x * d + y * c
    return real, imag


# ---------------------------------------------------------------------------------------------------------- sums


def _columns(of: Device, batch: ColumnBatch, heard: Heard, voltages: list[tuple[Any, Any]]) -> list[tuple[Any, Any]]:
    """For each path, real and imaginary part (column, gate, node of the window) of what gates hear of a column."""
    dr, window, gates, response = of.dr, batch.window, batch.beam.level.size, batch.response
    lane = dr.arange(of.UInt32, batch.columns.number.size * gates * window)
    cell, node = lane // window, lane % window
    gate = of.Int32(cell % gates)
    apart, last = response.gate_spacing_m * response.entries_per_m, float(response.table.shape[1] - 1)
    tables = [of.place(table) for table in response.table]
    made = []
    for number, (path, (re, im)) in enumerate(zip(heard.path, voltages, strict=True)):
        table = tables[number % len(tables)]

        def hear(facet: Any, stop: Any, real: Any, imag: Any, path=path, table=table, re=re, im=im) -> tuple[Any, ...]:
            beyond = of.Float(gate - dr.gather(of.Int32, path.first, facet))
            away = dr.gather(of.Float, path.entry, facet) + beyond * apart
            height = dr.gather(of.Float, table, of.UInt32(dr.minimum(abs(away), last)))
            place = facet * window + node
            real = real + height * dr.gather(of.Float, re, place)
            return facet + 1, stop, real, imag + height * dr.gather(of.Float, im, place)

        first, stop = dr.gather(of.UInt32, path.begin, cell), dr.gather(of.UInt32, path.end, cell)
        state = first, stop, dr.zeros(of.Float, dr.width(lane)), dr.zeros(of.Float, dr.width(lane))
        real, imag = dr.while_loop(state, lambda facet, stop, real, imag: facet < stop, hear)[2:]
        made.append((real, imag))
    dr.eval(made)
    return made


def _sums(of: Device, batch: ColumnBatch, columns: list[tuple[Any, Any]]) -> list[tuple[Any, Any]]:
    """For each path, real and imaginary part (gate, node) of the windows of all columns, each from its own first node
    on."""
    dr, window, nodes, gates = of.dr, batch.window, batch.nodes, batch.beam.level.size
    first_node, number = batch.columns.first_node, np.arange(nodes)
    holds = (number[:, None] >= first_node) & (number[:, None] < first_node + window)  # (node, column)
    some = holds.any(axis=1)
    begin = of.place(np.where(some, holds.argmax(axis=1), 0).astype(np.uint32))
    end = of.place(np.where(some, first_node.size - holds[:, ::-1].argmax(axis=1), 0).astype(np.uint32))
    starts = of.place(first_node.astype(np.int32))
    lane = dr.arange(of.UInt32, gates * nodes)
    gate, node = lane // nodes, lane % nodes
    made = []
    for re, im in columns:

        def add(column: Any, stop: Any, real: Any, imag: Any, re=re, im=im) -> tuple[Any, ...]:
            within = of.Int32(node) - dr.gather(of.Int32, starts, column)
            held = (within >= 0) & (within < window)
            place = (column * gates + gate) * window + of.UInt32(dr.maximum(within, 0))
            real = real + dr.gather(of.Float, re, place, held)
            return column + 1, stop, real, imag + dr.gather(of.Float, im, place, held)

        first, stop = dr.gather(of.UInt32, begin, node), dr.gather(of.UInt32, end, node)
        state = first, stop, dr.zeros(of.Float, dr.width(lane)), dr.zeros(of.Float, dr.width(lane))
        real, imag = dr.while_loop(state, lambda column, stop, real, imag: column < stop, add)[2:]
        made.append((real, imag))
    dr.eval(made)
    return made
