"""What some columns return into every gate, at every node at which they are heard.

    V(path, gate, node) = Σ_facets E(path, facet, node) a(path) h(path, gate) s(node) exp(−jk(R_tx + R_rx)(node))

Nodes are the innermost axis everywhere, and real and imaginary components are kept in separate arrays: so the compiler
takes some together. A facet's phase, and what it advances by up to each node, are reduced to one cycle in float64.

Facets are worked on some at a time: what each needs once (its random numbers, its phases, the gates that hear it) is
computed for all of them. A column is summed in a place of its own, which stays in the cache.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compute.compiled import compiled, compiled_step
from .batch import ALIKE, ColumnBatch
from .gaussian import key_of, normals, unit_phasor

_CYCLES_PER_RAD = 1.0 / (2.0 * np.pi)
_FACETS = 32  # worked on at a time
NODES = 16  # a multiple of these, as vector registers hold
BATCH_COLUMNS = 32  # of which the sums stay near the cache


def sum_columns(batch: ColumnBatch) -> NDArray[np.float32]:
    """The sum (component, path, gate, node) [√W] of the batch's columns; component: real, imaginary.

    Serial, with the same bits for the same batch; it releases Python's lock, so that batches run in threads.
    """
    whole = _whole(batch.window)  # whole groups: zeros behind the window
    source = batch.speckle.modes
    modes = np.zeros((batch.columns.number.size, 2, source.shape[1], 2, whole), dtype=np.float32)
    modes[:, 0, :, 0, : batch.window], modes[:, 0, :, 1, : batch.window] = source.real, source.imag
    modes[:, 1, :, 0, : batch.window], modes[:, 1, :, 1, : batch.window] = -source.imag, source.real
    modes = modes.reshape(len(modes), -1, 2 * whole)
    paths, gates, taps = len(batch.geometry.antennas), batch.beam.level.size, _most_gates(batch)
    out = np.zeros((2, paths, gates, batch.nodes - batch.window + whole), dtype=np.float32)
    _add_columns(batch, modes, np.zeros((paths, gates + 2 * taps, 2, whole), dtype=np.float32), taps, out)
    return out[..., : batch.nodes]


def _most_gates(batch: ColumnBatch) -> int:
    """Gates that can hear a reflector."""
    table = batch.response
    return int(2.0 * (table.table.shape[1] - 1) / (table.entries_per_m * table.gate_spacing_m)) + 1


@compiled
def _whole(count):
    """So many in whole groups of NODES."""
    return (count + NODES - 1) // NODES * NODES


class _FacetTerms(NamedTuple):
    """What the sum needs of some facets, one by one."""

    numbers: NDArray[np.float32]  # (component, mode, facet) random, of the facet's strength
    step: NDArray[np.float64]  # (path, facet) rad, what the phase k(R_i + R_j) advances from node to node
    phase: NDArray[np.float64]  # (path, facet) rad, at the window's first node
    phasor_of: NDArray[np.int64]  # (path, facet) the path whose phasor it uses
    constant: NDArray[np.float32]  # (path, component, facet) a exp(−j phase)
    cycles: NDArray[np.float64]  # (path, facet) −step in cycles, within ±½
    first_gate: NDArray[np.int64]  # (path, facet) that hears it, counted from `taps` before the first that there is
    own_gate: NDArray[np.int64]  # (path, facet)
    response_row: NDArray[np.int64]  # (path, facet) of the gates that hear it; −1 where none does


@compiled
def _add_columns(batch, modes, column_sum, taps, out):
    """Add a batch to out (component, path, gate, node), by its modes (column, component, mode, node): 0 beyond the
    window, in whole groups of nodes, for which `out` has room behind its last node. column_sum (path, gate, component,
    node): zeros, with room for `taps` gates before the first and behind the last."""
    columns, speckle, table = batch.columns, batch.speckle, batch.response
    window, paths, gates, whole = batch.window, out.shape[1], out.shape[2], modes.shape[2] // 2
    drawn = _FACETS * modes.shape[1] // 2
    keys, bits, unit = np.empty(_FACETS, np.uint64), np.empty(drawn, np.uint64), np.empty((2, drawn), np.float32)
    by_path = (paths, _FACETS)
    terms = _FacetTerms(
        np.empty((2, modes.shape[1] // 2, _FACETS), np.float32),
        np.empty(by_path),
        np.empty(by_path),
        np.empty(by_path, np.int64),
        np.empty((paths, 2, _FACETS), np.float32),
        np.empty(by_path),
        np.empty(by_path, np.int64),
        np.empty(by_path, np.int64),
        np.empty(by_path, np.int64),
    )
    phasor, echo = np.empty((paths, 2, whole), np.float32), np.empty(2 * whole, np.float32)
    response = _gates_by_phase(table, taps)
    rows = response.shape[1]
    response = response.reshape(-1, taps)
    weight = np.zeros((batch.beam.table.shape[0], gates, whole), np.float32)
    for column in range(columns.number.size):
        _weigh(column, window, batch.beam, weight)
        end = columns.first_facet[column + 1]
        for first in range(columns.first_facet[column], end, _FACETS):
            count = min(end - first, _FACETS)
            _draw_modes(speckle, columns.number[column], batch.facets.number, first, count, keys, bits, unit, terms)
            _find_phases(batch, first, count, columns.begin_s[column], rows, taps, terms)
            _turn(batch.facets.amplitude, first, count, terms)
            sums = np.dot(terms.numbers.reshape(-1, _FACETS).T, modes[column])
            for n in range(count):
                for path in range(paths):
                    if terms.phasor_of[path, n] == path:
                        _fill_phasor(terms.cycles[path, n], phasor, path)
                _add_facet(n, sums, terms, phasor, response, weight, echo, column_sum)
        _add_column(column_sum, taps, columns.first_node[column], out)


@compiled_step
def _draw_modes(speckle, column, facets, first, count, keys, bits, unit, terms):
    """Fill the numbers of `count` facets from `first` on, those of each kind times its strength. column, facets
    (facet,): their keys in the random source. keys (facet,), bits, unit (component, number): room."""
    numbers = terms.numbers
    streams, strength, kinds = speckle.streams, speckle.strength, speckle.strength.shape[1]
    of_first, modes = speckle.first_kind_modes, numbers.shape[1]
    for kind in range(kinds):
        key, begin, end = key_of(streams[kind], column), of_first * kind, of_first if kind == 0 else modes
        for n in range(count):
            keys[n] = key_of(key, facets[first + n])
        for mode in range(begin, end):
            for n in range(count):
                bits[mode * count + n] = key_of(keys[n], mode - begin)
    drawn, real, imag = modes * count, unit[0], unit[1]
    normals(bits[:drawn], real, imag)
    for mode in range(modes):
        kind = 0 if mode < of_first else kinds - 1
        for n in range(count):
            root = strength[first + n, kind]
            numbers[0, mode, n], numbers[1, mode, n] = root * real[mode * count + n], root * imag[mode * count + n]


@compiled_step
def _find_phases(batch, first, count, begin_s, rows, taps, terms):
    """Fill step, phase, phasor_of and gates of `count` facets from `first` on. rows: of the response of a path, or of
    all; taps: gates that can hear a facet."""
    facets, geometry, table, gates = batch.facets, batch.geometry, batch.response, batch.beam.level.size
    difference, velocity, antennas = facets.difference_m, facets.radial_velocity, geometry.antennas
    step, phase, phasor_of = terms.step, terms.phase, terms.phasor_of
    spacing, support = table.gate_spacing_m, (table.table.shape[1] - 1) / table.entries_per_m
    middle = 0.5 * (batch.window - 1)  # of the nodes at which a column is heard
    for path in range(antennas.shape[0]):
        i, j, row_of = antennas[path, 0], antennas[path, 1], path if table.table.shape[0] > 1 else 0
        for n in range(count):
            facet = first + n
            longer, along = difference[i, facet] + difference[j, facet], velocity[i, facet] + velocity[j, facet]
            phase[path, n] = geometry.wavenumber * (2.0 * facets.range_m[facet] + longer + along * begin_s)
            step[path, n] = geometry.wavenumber * geometry.node_spacing_s * along
            beyond = facets.range_m[facet] + 0.5 * longer - table.first_gate_m
            nearest = np.ceil((beyond - support) / spacing)
            row = min(int((nearest * spacing - (beyond - support)) * table.entries_per_m), rows - 1)
            gate = int(nearest)
            terms.first_gate[path, n] = gate + taps
            terms.own_gate[path, n] = min(max(int(beyond / spacing + 0.5), 0), gates - 1)
            terms.response_row[path, n] = row_of * rows + row if -taps < gate < gates else -1
        for n in range(count):
            phasor_of[path, n] = path
            for other in range(path):
                if phasor_of[other, n] == other and abs(step[path, n] - step[other, n]) * batch.window <= ALIKE:
                    phasor_of[path, n] = other
                    # Paths that share a phasor agree in the middle, where the beam is.
                    phase[path, n] += (step[path, n] - step[other, n]) * middle
                    break


@compiled_step
def _turn(amplitude, first, count, terms):
    """Fill the constants and cycles of `count` facets from `first` on. Angles are reduced in float64."""
    for path in range(terms.step.shape[0]):
        for n in range(count):
            cycles = -terms.phase[path, n] * _CYCLES_PER_RAD
            cosine, sine = unit_phasor(np.float32(cycles - np.rint(cycles)))
            value = amplitude[path, first + n]
            terms.constant[path, 0, n] = value.real * cosine - value.imag * sine
            terms.constant[path, 1, n] = value.real * sine + value.imag * cosine
        for n in range(count):
            cycles = -terms.step[path, n] * _CYCLES_PER_RAD
            terms.cycles[path, n] = cycles - np.rint(cycles)


@compiled
def _gates_by_phase(table, taps):
    """Response (path or 1, row, tap) of the `taps` gates that can hear a reflector, the nearest first: row n for one
    that lies n + ½ entries nearer than where the first of them ceases to hear."""
    entries, last = table.table, table.table.shape[1] - 1
    spacing = table.gate_spacing_m * table.entries_per_m
    made = np.empty((entries.shape[0], int(np.ceil(spacing)), taps), np.float32)
    for path in range(made.shape[0]):
        for row in range(made.shape[1]):
            for tap in range(taps):
                made[path, row, tap] = entries[path, min(int(abs(row + 0.5 + tap * spacing - last)), last)]
    return made


@compiled_step
def _add_facet(n, sums, terms, phasor, response, weight, echo, column_sum):
    """Add facet n of those at work to column_sum (path, gate, component, node).

    The sum of its modes (facet, component, node), rotated by the phasor (path, component, node) that each path uses,
    times each path's constant, the weight (path or 1, gate, node) of the beam at the facet's own gate, and the response
    (row, tap) of the gates that hear it. echo (component, node): room.
    """
    whole, gates, taps = np.uint64(weight.shape[2]), column_sum.shape[1], np.uint64(response.shape[1])
    flat_sums, flat_phasor, flat_weight, flat_sum = sums.ravel(), phasor.ravel(), weight.ravel(), column_sum.ravel()
    both = np.uint64(2) * whole
    start = np.uint64(n) * both
    for path in range(terms.phasor_of.shape[0]):
        row = terms.response_row[path, n]
        if row < 0:
            continue
        u, v = terms.constant[path, 0, n], terms.constant[path, 1, n]
        by = np.uint64(terms.phasor_of[path, n]) * both
        seen = np.uint64((path if weight.shape[0] > 1 else 0) * weight.shape[1] + terms.own_gate[path, n]) * whole
        for node in range(whole):
            real, imag = flat_sums[start + node], flat_sums[start + whole + node]
            c, d = flat_phasor[by + node], flat_phasor[by + whole + node]
            turned_real, turned_imag = real * c - imag * d, real * d + imag * c
            pattern = flat_weight[seen + node]
            echo[node] = pattern * (u * turned_real - v * turned_imag)
            echo[whole + node] = pattern * (u * turned_imag + v * turned_real)
        into = np.uint64(path * gates + terms.first_gate[path, n]) * both
        for tap in range(taps):
            height = response[np.uint64(row), tap]
            for k in range(both):
                flat_sum[into + k] += height * echo[k]
            into += both


@compiled
def _add_column(column_sum, taps, start, out):
    """Add a column's sum (path, gate, component, node) to out (component, path, gate, node) from node `start` on, and
    make it zero again."""
    whole, nodes = column_sum.shape[3], out.shape[3]
    paths, gates, flat, sums = out.shape[1], out.shape[2], out.ravel(), column_sum.ravel()
    for path in range(paths):
        for gate in range(gates):
            for component in range(2):
                place = ((component * paths + path) * gates + gate) * nodes + start
                index = ((path * column_sum.shape[1] + taps + gate) * 2 + component) * whole
                for node in range(np.uint64(whole)):
                    flat[np.uint64(place) + node] += sums[np.uint64(index) + node]
    column_sum[:] = 0.0


@compiled_step
def _fill_phasor(cycles, phasor, path):
    """Fill phasor[path] (component, node) with exp(2πj cycles · node)."""
    for node in range(phasor.shape[2]):
        turns = cycles * node
        phasor[path, 0, node], phasor[path, 1, node] = unit_phasor(np.float32(turns - np.rint(turns)))


@compiled
def _weigh(column, window, beam, weight):
    """Fill weight (path or 1, gate, node) with the beam's voltage towards the mean sea at each gate, out and back."""
    table, along, up, past = beam.table, beam.along, beam.up, beam.past_m
    scale, aside = beam.entries_per_cosine, beam.aside_m
    level, drop, inverse_range = beam.level, beam.drop, beam.inverse_range
    last = np.int32(table.shape[2] - 1)
    for gate in range(weight.shape[1]):
        ahead, below, beyond = level[gate] * scale, drop[gate] * scale, inverse_range[gate] * scale
        for path in range(table.shape[0]):
            for leg in range(table.shape[1]):
                # Half an entry on: the conversion to an integer truncates, and so rounds.
                shift = 0.5 * table.shape[2] - aside[path, leg] * beyond
                for node in range(window):
                    entry = ahead * along[column, node] - below * up[column, node] - beyond * past[column, node]
                    number = min(max(np.int32(entry + shift), np.int32(0)), last)
                    value = table[path, leg, np.uint32(number)]
                    weight[path, gate, node] = value if leg == 0 else weight[path, gate, node] * value
