"""The same sum as Dr.Jit kernels, for a graphics processor; on LLVM too, where tests hold it against the processor's.

Nothing is added atomically: who runs first changes no bits. Three kernels, each with a lane for every number it makes:

    numbers   (facet, mode)                  each facet's Gaussians, by counting: those of the processor's kernel
    voltages  (path, facet, node)            modes, beam and phase of a facet at the nodes of its column's window
    columns   (column, path, gate, node)     the facets near a gate, through its response, one after another
    sums      (path, gate, node)             the columns whose windows hold a node, one after another

Phases are reduced to one cycle in float64, as the processor's are. Arrays go to the device once a batch, and the sums
come back once.
"""

from __future__ import annotations

import importlib
import threading
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compute.backend import prepare
from .batch import ColumnBatch

_GOLDEN = 0x9E3779B97F4A7C15
_ONE_AT_A_TIME = threading.Lock()  # a device has one queue for us


class _Types(NamedTuple):
    """Dr.Jit, and its arrays on the backend."""

    dr: Any
    Float: Any
    Float64: Any
    Int32: Any
    UInt32: Any
    UInt64: Any
    Bool: Any

    def place(self, values: NDArray[Any]) -> Any:
        """An array on the device, flat."""
        kind = {"f4": self.Float, "f8": self.Float64, "i4": self.Int32, "u4": self.UInt32, "u8": self.UInt64}
        flat = np.ascontiguousarray(values).ravel()
        return kind[flat.dtype.str[1:]](flat)

    def fetch(self, values: Any, shape: tuple[int, ...]) -> NDArray[np.float32]:
        """An array of the device, back here."""
        return np.array(values).reshape(shape)


def sum_columns(batch: ColumnBatch) -> NDArray[np.float32]:
    """The sum (component, path, gate, node) [√W] of the batch's columns; component: real, imaginary.

    Raises NoBackend where Dr.Jit has nothing to run on. Calls from several threads take turns.
    """
    paths, gates = len(batch.geometry.antennas), batch.beam.level.size
    starts = batch.columns.first_facet
    if starts[0] == starts[-1]:
        return np.zeros((2, paths, gates, batch.nodes), dtype=np.float32)
    with _ONE_AT_A_TIME:
        types = _types()
        column = np.searchsorted(starts[1:-1], np.arange(batch.facets.number.size), side="right").astype(np.uint32)
        drawn = _numbers(types, batch, column)
        voltages = _voltages(types, batch, column, drawn)
        return _sums(types, batch, _columns(types, batch, voltages))


def _types() -> _Types:
    kind = prepare().kind
    arrays = importlib.import_module(f"drjit.{kind}")
    names = ("Float", "Float64", "Int", "UInt", "UInt64", "Bool")
    return _Types(importlib.import_module("drjit"), *(getattr(arrays, name) for name in names))


# ------------------------------------------------------------------------------------------------------- numbers


def _mixed(types: _Types, state: Any) -> Any:
    """SplitMix64's mixing of a state."""
    state = (state ^ (state >> 30)) * types.UInt64(0xBF58476D1CE4E5B9)
    state = (state ^ (state >> 27)) * types.UInt64(0x94D049BB133111EB)
    return state ^ (state >> 31)


def _member(types: _Types, key: Any, number: Any) -> Any:
    return _mixed(types, key + types.UInt64(_GOLDEN) * (types.UInt64(number) + types.UInt64(1)))


def _numbers(types: _Types, batch: ColumnBatch, column: NDArray[np.uint32]) -> tuple[Any, Any]:
    """Real and imaginary part (facet, mode) of the facets' Gaussians, times the strength of their kind."""
    dr, speckle = types.dr, batch.speckle
    count, modes, kinds = batch.facets.number.size, speckle.modes.shape[1], speckle.streams.size
    lane = dr.arange(types.UInt32, count * modes)
    facet, mode = lane // modes, lane % modes
    second = mode >= speckle.first_kind_modes
    kind = dr.select(second, types.UInt32(1), types.UInt32(0))
    of_kind = dr.select(second, mode - speckle.first_kind_modes, mode)
    stream = dr.gather(types.UInt64, types.place(speckle.streams), dr.minimum(kind, kinds - 1))
    number = dr.gather(types.UInt64, types.place(batch.columns.number.astype(np.uint64)[column]), facet)
    key = _member(types, stream, number)
    key = _member(types, key, dr.gather(types.UInt64, types.place(batch.facets.number.astype(np.uint64)), facet))
    bits = _member(types, key, of_kind)
    uniform = (types.Float(bits >> 41) + 0.5) * 2.0**-23
    radius = dr.sqrt(dr.maximum(-dr.log(uniform), 0.0))
    sine, cosine = dr.sincos(types.Float(types.Int32(types.UInt32(bits))) * (2.0 * np.pi * 2.0**-32))
    radius *= dr.gather(types.Float, types.place(speckle.strength), facet * kinds + dr.minimum(kind, kinds - 1))
    made = radius * cosine, radius * sine
    dr.eval(made)
    return made


# ------------------------------------------------------------------------------------------------------ voltages


def _voltages(types: _Types, batch: ColumnBatch, column: NDArray[np.uint32], drawn: tuple[Any, Any]) -> list[Any]:
    """For each path, real and imaginary part (facet, node) of what a facet returns, before the gates' response."""
    dr, window, facets, geometry = types.dr, batch.window, batch.facets, batch.geometry
    lane = dr.arange(types.UInt32, facets.number.size * window)
    facet, node = lane // window, lane % window
    at = dr.gather(types.UInt32, types.place(column), facet)
    real, imag = _speckle(types, batch, drawn, facet, node, at)
    begin = dr.gather(types.Float64, types.place(batch.columns.begin_s), at)
    seconds = begin + types.Float64(node) * geometry.node_spacing_s
    made = []
    for path, antennas in enumerate(geometry.antennas):
        longer = facets.difference_m[antennas].sum(axis=0)
        rate = dr.gather(types.Float64, types.place(facets.radial_velocity[antennas].sum(axis=0)), facet)
        length = dr.gather(types.Float64, types.place(2.0 * facets.range_m + longer), facet)
        cycles = (length + rate * seconds) * (-geometry.wavenumber / (2.0 * np.pi))
        sine, cosine = dr.sincos(types.Float(cycles - dr.round(cycles)) * (2.0 * np.pi))
        beyond = facets.range_m + 0.5 * longer - batch.response.first_gate_m
        own = (beyond / batch.response.gate_spacing_m + 0.5).astype(np.int64).clip(0, batch.beam.level.size - 1)
        pattern = _pattern(
            types, batch, path, dr.gather(types.UInt32, types.place(own.astype(np.uint32)), facet), at, node
        )
        amplitude = facets.amplitude[path]
        u, v = (dr.gather(types.Float, types.place(part), facet) * pattern for part in (amplitude.real, amplitude.imag))
        turned = real * cosine - imag * sine, real * sine + imag * cosine
        made.append((u * turned[0] - v * turned[1], u * turned[1] + v * turned[0]))
    dr.eval(made)
    return made


def _speckle(
    types: _Types, batch: ColumnBatch, drawn: tuple[Any, Any], facet: Any, node: Any, column: Any
) -> tuple[Any, Any]:
    """A facet's speckle at a node: its numbers times the modes of its column."""
    dr, modes, window = types.dr, batch.speckle.modes, batch.window
    a, b = types.place(modes.real), types.place(modes.imag)
    first = column * (modes.shape[1] * window) if modes.shape[0] > 1 else types.UInt32(0)
    real, imag = types.Float(0.0), types.Float(0.0)
    for mode in range(modes.shape[1]):
        x, y = (dr.gather(types.Float, each, facet * modes.shape[1] + mode) for each in drawn)
        place = first + (mode * window) + node
        c, d = dr.gather(types.Float, a, place), dr.gather(types.Float, b, place)
        real, imag = real + x * c - y * d, imag + x * d + y * c
    return real, imag


def _pattern(types: _Types, batch: ColumnBatch, path: int, gate: Any, column: Any, node: Any) -> Any:
    """The beam's voltage, out and back, towards the mean sea at a gate, from a node of a column's window."""
    dr, beam = types.dr, batch.beam
    row = path % beam.table.shape[0]
    place = column * batch.window + node
    level, drop, inverse = (
        dr.gather(types.Float64, types.place(each * beam.entries_per_cosine), gate)
        for each in (beam.level, beam.drop, beam.inverse_range)
    )
    along, up, past = (
        dr.gather(types.Float64, types.place(each), place) for each in (beam.along, beam.up, beam.past_m)
    )
    entry = level * along - drop * up - inverse * past
    entries, pattern = beam.table.shape[2], types.Float(1.0)
    for leg in range(beam.table.shape[1]):
        shifted = entry + (0.5 * entries - float(beam.aside_m[row, leg]) * inverse)
        number = types.UInt32(dr.clip(shifted, 0.0, entries - 1.0))
        pattern *= dr.gather(types.Float, types.place(beam.table[row, leg]), number)
    return pattern


# ---------------------------------------------------------------------------------------------------------- sums


def _columns(types: _Types, batch: ColumnBatch, voltages: list[Any]) -> list[Any]:
    """For each path, real and imaginary part (column, gate, node of the window) of what gates hear of a column."""
    dr, window, gates, response = types.dr, batch.window, batch.beam.level.size, batch.response
    lane = dr.arange(types.UInt32, batch.columns.number.size * gates * window)
    cell, node = lane // window, lane % window
    middle = types.Float64(cell % gates) * response.gate_spacing_m
    last = response.table.shape[1] - 1
    made = []
    for path, antennas in enumerate(batch.geometry.antennas):
        beyond = batch.facets.range_m + 0.5 * batch.facets.difference_m[antennas].sum(axis=0) - response.first_gate_m
        begin, end = (types.place(each) for each in _near(batch, beyond))
        far, table = types.place(beyond), types.place(response.table[path % response.table.shape[0]])
        re, im = voltages[path]

        def hear(facet: Any, stop: Any, real: Any, imag: Any, far=far, table=table, re=re, im=im) -> tuple[Any, ...]:
            away = abs(dr.gather(types.Float64, far, facet) - middle) * response.entries_per_m
            height = dr.gather(types.Float, table, types.UInt32(dr.minimum(away, float(last))))
            place = facet * window + node
            real = real + height * dr.gather(types.Float, re, place)
            return facet + 1, stop, real, imag + height * dr.gather(types.Float, im, place)

        first, stop = dr.gather(types.UInt32, begin, cell), dr.gather(types.UInt32, end, cell)
        state = first, stop, dr.zeros(types.Float, dr.width(lane)), dr.zeros(types.Float, dr.width(lane))
        made.append(dr.while_loop(state, lambda facet, stop, real, imag: facet < stop, hear)[2:])
    dr.eval(made)
    return made


def _near(batch: ColumnBatch, beyond: NDArray[np.float64]) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """(column, gate): between which of its facets all lie that a gate hears of a column. beyond (facet,): m of a facet
    from the first gate. Facets stand nearly, not wholly, by range: some between are too far, and heard with 0."""
    response, starts = batch.response, batch.columns.first_facet
    middle = response.gate_spacing_m * np.arange(batch.beam.level.size)
    support = (response.table.shape[1] - 1) / response.entries_per_m + 1.0 / response.entries_per_m
    begin, end = (np.zeros((starts.size - 1, middle.size), np.uint32) for _ in range(2))
    for column, (low, high) in enumerate(pairwise(starts)):
        ranges = beyond[low:high]
        begin[column] = low + np.searchsorted(np.maximum.accumulate(ranges), middle - support)
        end[column] = low + np.searchsorted(np.minimum.accumulate(ranges[::-1])[::-1], middle + support, side="right")
    return begin, np.maximum(begin, end)


def _sums(types: _Types, batch: ColumnBatch, columns: list[Any]) -> NDArray[np.float32]:
    """The windows of all columns, each from its own first node on."""
    dr, window, nodes, gates = types.dr, batch.window, batch.nodes, batch.beam.level.size
    first_node, number = batch.columns.first_node, np.arange(nodes)
    holds = (number[:, None] >= first_node) & (number[:, None] < first_node + window)  # (node, column)
    some = holds.any(axis=1)
    begin = types.place(np.where(some, holds.argmax(axis=1), 0).astype(np.uint32))
    end = types.place(np.where(some, first_node.size - holds[:, ::-1].argmax(axis=1), 0).astype(np.uint32))
    starts = types.place(first_node.astype(np.int32))
    lane = dr.arange(types.UInt32, gates * nodes)
    gate, node = lane // nodes, lane % nodes
    out = np.empty((2, len(columns), gates, nodes), dtype=np.float32)
    for path, (re, im) in enumerate(columns):

        def add(column: Any, stop: Any, real: Any, imag: Any, re=re, im=im) -> tuple[Any, ...]:
            within = types.Int32(node) - dr.gather(types.Int32, starts, column)
            held = (within >= 0) & (within < window)
            place = (column * gates + gate) * window + types.UInt32(dr.maximum(within, 0))
            real = real + dr.gather(types.Float, re, place, held)
            return column + 1, stop, real, imag + dr.gather(types.Float, im, place, held)

        first, stop = dr.gather(types.UInt32, begin, node), dr.gather(types.UInt32, end, node)
        state = first, stop, dr.zeros(types.Float, dr.width(lane)), dr.zeros(types.Float, dr.width(lane))
        real, imag = dr.while_loop(state, lambda column, stop, real, imag: column < stop, add)[2:]
        out[0, path], out[1, path] = (types.fetch(each, (gates, nodes)) for each in (real, imag))
    return out
