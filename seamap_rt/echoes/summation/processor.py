"""What some columns return into every gate, at every node at which they are heard.

    V(path, gate, node) = Σ_facets E(path, facet, node) a(path) h(path, gate) s(node) exp(−jk(R_tx + R_rx)(node))

Nodes are the innermost axis everywhere: a processor's lanes take them together. Real and imaginary components are kept
in separate arrays for the same reason. A facet's phase, and what it advances by up to each node, are reduced to one
cycle in float64.

Facets are worked on some at a time: what each needs once (its random numbers, its phases, the gates that hear it) is
computed for all of them by the processor's lanes. A column is summed in a place of its own, which stays in the cache.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...compute.compiled import compiled, compiled_step
from ...compute.lanes import add, less, load, plus, product, store, zeros
from .batch import ALIKE, ColumnBatch
from .gaussian import key_of, normals, unit_phasor

_CYCLES_PER_RAD = 1.0 / (2.0 * np.pi)
_FACETS = 32  # worked on at a time
NODES = 16  # taken together
BATCH_COLUMNS = 32  # of which the sums stay near the cache


def sum_columns(batch: ColumnBatch) -> NDArray[np.float32]:
    """The sum (component, path, gate, node) [√W] of the batch's columns; component: real, imaginary.

    Serial, with the same bits for the same batch; it releases Python's lock, so that batches run in threads.
    """
    lanes = _whole(batch.window)  # whole groups: zeros behind the window
    source = batch.speckle.modes
    modes = np.zeros((batch.columns.number.size, 2, source.shape[1], lanes), dtype=np.float32)
    modes[:, 0, :, : batch.window], modes[:, 1, :, : batch.window] = source.real, source.imag
    paths, gates, taps = len(batch.geometry.antennas), batch.beam.level.size, _most_gates(batch)
    out = np.zeros((2, paths, gates, batch.nodes - batch.window + lanes), dtype=np.float32)
    _add_columns(batch, modes, np.zeros((paths, gates + 2 * taps, 2, lanes), dtype=np.float32), taps, out)
    return out[..., : batch.nodes]


def _most_gates(batch: ColumnBatch) -> int:
    """Gates that can hear a reflector."""
    table = batch.response
    return int(2.0 * (table.table.shape[1] - 1) / (table.entries_per_m * table.gate_spacing_m)) + 1


@compiled
def _whole(count):
    """So many in whole groups of lanes."""
    return (count + NODES - 1) // NODES * NODES


@compiled
def _add_columns(batch, modes, column_sum, taps, out):
    """Add a batch to out (component, path, gate, node), by its modes (column, component, mode, node): 0 beyond the
    window, in whole groups of lanes, for which `out` has room behind its last node. column_sum (path, gate, component,
    node): zeros, with room for `taps` gates before the first and behind the last."""
    columns, speckle, table = batch.columns, batch.speckle, batch.response
    window, paths, gates, whole = batch.window, out.shape[1], out.shape[2], modes.shape[3]
    of_first, of_second = speckle.first_kind_modes, modes.shape[2] - speckle.first_kind_modes
    drawn = _FACETS * (of_first + of_second)
    keys, bits, unit = np.empty(_FACETS, np.uint64), np.empty(drawn, np.uint64), np.empty((2, drawn), np.float32)
    numbers = np.empty((2, of_first + of_second, _FACETS), np.float32)
    step, phase = np.empty((paths, _FACETS)), np.empty((paths, _FACETS))
    constant, turn = np.empty((paths, 2, _FACETS), np.float32), np.empty((paths, _FACETS))
    phasor_of, heard = np.empty((paths, _FACETS), np.int64), np.empty((3, paths, _FACETS), np.int64)
    phasor = np.empty((paths, 2, whole), np.float32)
    by_phase = _gates_by_phase(table, taps)
    response = by_phase.ravel()
    weight = np.zeros((batch.beam.table.shape[0], gates, whole), np.float32)
    for column in range(columns.number.size):
        _weigh(column, window, batch.beam, weight)
        end = columns.first_facet[column + 1]
        for first in range(columns.first_facet[column], end, _FACETS):
            count = min(end - first, _FACETS)
            _draw_modes(speckle, columns.number[column], batch.facets.number, first, count, keys, bits, unit, numbers)
            _find_phases(batch, first, count, columns.begin_s[column], by_phase.shape, step, phase, phasor_of, heard)
            _turn(batch.facets.amplitude, first, count, step, phase, constant, turn)
            for n in range(count):
                for path in range(paths):
                    if phasor_of[path, n] == path:
                        _fill_phasor(turn[path, n], phasor, path)
                _add_facet(n, modes[column], numbers, phasor, phasor_of, constant, heard, response, weight, column_sum)
        _add_column(column_sum, taps, columns.first_node[column], out)


@compiled_step
def _draw_modes(speckle, column, facets, first, count, keys, bits, unit, numbers):
    """Fill numbers (component, mode, facet) of `count` facets from `first` on, those of each kind times its strength.
    column, facets (facet,): their keys in the random source. keys (facet,), bits, unit (component, number): room."""
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
def _find_phases(batch, first, count, begin_s, by_phase, step, phase, phasor_of, heard):
    """Of `count` facets from `first` on, of each path (path, facet): fill in by what the phase k(R_i + R_j) [rad]
    advances from node to node, the phase at the window's first node, and the path whose phasor it uses; and heard, what
    hears the facet: the first gate, counted from `taps` before the first that there is, its own gate, and where
    by_phase, of that shape, holds the response. A facet that no gate hears has the last one negative."""
    facets, geometry, table, gates = batch.facets, batch.geometry, batch.response, batch.beam.level.size
    rows, taps = by_phase[1], by_phase[2]
    difference, velocity, antennas = facets.difference_m, facets.radial_velocity, geometry.antennas
    spacing, support = table.gate_spacing_m, (table.table.shape[1] - 1) / table.entries_per_m
    middle = 0.5 * (batch.window - 1)  # of the nodes at which a column is heard
    for path in range(antennas.shape[0]):
        i, j, row_of = antennas[path, 0], antennas[path, 1], path if by_phase[0] > 1 else 0
        for n in range(count):
            facet = first + n
            longer, along = difference[i, facet] + difference[j, facet], velocity[i, facet] + velocity[j, facet]
            phase[path, n] = geometry.wavenumber * (2.0 * facets.range_m[facet] + longer + along * begin_s)
            step[path, n] = geometry.wavenumber * geometry.node_spacing_s * along
            beyond = facets.range_m[facet] + 0.5 * longer - table.first_gate_m
            nearest = np.ceil((beyond - support) / spacing)
            row = min(int((nearest * spacing - (beyond - support)) * table.entries_per_m), rows - 1)
            gate = int(nearest)
            heard[0, path, n] = gate + taps
            heard[1, path, n] = min(max(int(beyond / spacing + 0.5), 0), gates - 1)
            heard[2, path, n] = (row_of * rows + row) * taps if -taps < gate < gates else -1
        for n in range(count):
            phasor_of[path, n] = path
            for other in range(path):
                if phasor_of[other, n] == other and abs(step[path, n] - step[other, n]) * batch.window <= ALIKE:
                    phasor_of[path, n] = other
                    # Paths that share a phasor agree in the middle, where the beam is.
                    phase[path, n] += (step[path, n] - step[other, n]) * middle
                    break


@compiled_step
def _turn(amplitude, first, count, step, phase, constant, turn):
    """Fill constant (path, component, facet) with a exp(−j phase) and turn (path, facet) with −step in cycles, within
    ±½, of `count` facets from `first` on. Angles are reduced in float64."""
    for path in range(step.shape[0]):
        for n in range(count):
            cycles = -phase[path, n] * _CYCLES_PER_RAD
            cosine, sine = unit_phasor(np.float32(cycles - np.rint(cycles)))
            value = amplitude[path, first + n]
            constant[path, 0, n] = value.real * cosine - value.imag * sine
            constant[path, 1, n] = value.real * sine + value.imag * cosine
        for n in range(count):
            cycles = -step[path, n] * _CYCLES_PER_RAD
            turn[path, n] = cycles - np.rint(cycles)


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
def _add_facet(n, modes, numbers, phasor, phasor_of, constant, heard, response, weight, column_sum):
    """Add facet n of those at work to column_sum (path, gate, component, node).

    Its numbers (facet, component, mode) times the column's modes, rotated by the phasors (path, component, node), the
    one that each path uses (path, facet), times each path's constant (path, component, facet), the weight (path or 1,
    gate, node) of the beam at the facet's own gate, and the response of the gates that hear it (see _find_phases).
    """
    count, whole = modes.shape[1], modes.shape[2]
    gates, rows, weights, paths = weight.shape[1], column_sum.shape[1], weight.shape[0], phasor_of.shape[0]
    taps = np.uint64((rows - gates) // 2)
    for node in range(0, whole, NODES):
        xa = yb = xb = ya = zeros(NODES)  # separate sums: no addition waits for another
        index = node
        for mode in range(count):
            x, y = numbers[0, mode, n], numbers[1, mode, n]
            a, b = load(modes, index, NODES), load(modes, index + count * whole, NODES)
            xa, yb, xb, ya = add(xa, x, a), add(yb, y, b), add(xb, x, b), add(ya, y, a)
            index += whole
        re, im = less(xa, yb), plus(xb, ya)
        rotated_re, rotated_im = re, im
        last = -1
        for path in range(paths):
            if heard[2, path, n] < 0:
                continue
            if phasor_of[path, n] != last:
                last = phasor_of[path, n]
                place = 2 * last * whole + node
                c, d = load(phasor, place, NODES), load(phasor, place + whole, NODES)
                rotated_re = less(product(re, c), product(im, d))
                rotated_im = plus(product(re, d), product(im, c))
            u, v = constant[path, 0, n], constant[path, 1, n]
            row = path if weights > 1 else 0
            pattern = load(weight, (row * gates + heard[1, path, n]) * whole + node, NODES)
            echo_re = product(pattern, add(add(zeros(NODES), u, rotated_re), -v, rotated_im))
            echo_im = product(pattern, add(add(zeros(NODES), u, rotated_im), v, rotated_re))
            index = (path * rows + heard[0, path, n]) * 2 * whole + node
            first = np.uint64(heard[2, path, n])  # unsigned: an index that is not looked at for its sign
            for tap in range(taps):
                height = response[first + tap]
                store(column_sum, index, add(load(column_sum, index, NODES), height, echo_re))
                store(column_sum, index + whole, add(load(column_sum, index + whole, NODES), height, echo_im))
                index += 2 * whole


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
