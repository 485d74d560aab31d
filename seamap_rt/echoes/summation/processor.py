"""The processor's kernel: what some columns return into every gate, at every node at which they are heard.

    V(path, gate, node) = Σ_facets E(path, facet, node) a(path) h(path, gate) s(node) exp(−jk(R_tx + R_rx)(node))

Nodes are the innermost axis everywhere: a processor's lanes take them together. Real and imaginary components are kept
in separate arrays for the same reason. A facet's phase is reduced to one cycle in float64, and advances from node to
node by a constant factor (a rotation of some 50 steps in float32 errs by 1e-5 rad).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...compute.compiled import compiled
from ...compute.lanes import LANES, add, less, load, plus, product, store, zeros
from .batch import ColumnBatch
from .gaussian import count_bits, key_of, normals, unit_phasor

_ALIKE = 1e-3  # rad by which the phases of paths may drift apart while a facet is heard, and share a phasor
_CYCLES_PER_RAD = 1.0 / (2.0 * np.pi)


def sum_columns(batch: ColumnBatch) -> NDArray[np.float32]:
    """The sum (component, path, gate, node) [√W] of the batch's columns; component: real, imaginary.

    Serial, with the same bits for the same batch; it releases Python's lock, so that batches run in threads.
    """
    lanes = -(-batch.window // LANES) * LANES  # whole groups: zeros behind the window
    source = batch.speckle.modes
    modes = np.zeros((batch.columns.number.size, 2, source.shape[1], lanes), dtype=np.float32)
    modes[:, 0, :, : batch.window], modes[:, 1, :, : batch.window] = source.real, source.imag
    paths, gates = len(batch.geometry.antennas), batch.beam.level.size
    out = np.zeros((2, paths, gates, batch.nodes - batch.window + lanes), dtype=np.float32)
    _add_columns(batch, modes, out)
    return out[..., : batch.nodes]


@compiled
def _add_columns(batch, modes, out):
    """Add a batch to out (component, path, gate, node), by its modes (column, component, mode, node): 0 beyond the
    window, in whole groups of lanes, for which `out` has room behind its last node."""
    columns, facets, speckle, geometry = batch.columns, batch.facets, batch.speckle, batch.geometry
    window, beam, table = batch.window, batch.beam, batch.response
    numbers, first_facet, antennas, amplitudes = (
        columns.number,
        columns.first_facet,
        geometry.antennas,
        facets.amplitude,
    )
    paths, gates, count, whole = out.shape[1], out.shape[2], modes.shape[2], modes.shape[3]
    middle = 0.5 * (window - 1)  # of the nodes at which a column is heard
    room = (count + LANES - 1) // LANES * LANES
    bits, real, imag = np.zeros(room, np.uint64), np.empty(room, np.float32), np.empty(room, np.float32)
    phasor = np.empty((paths, 2, whole), np.float32)
    phasor_of = np.empty(paths, np.int64)
    step = np.empty(paths)
    constant = np.empty((paths, 2), np.float32)
    heard = np.zeros((paths, 3), np.int64)
    longest = 2 * int(table.table.shape[1] / (table.entries_per_m * table.gate_spacing_m)) + 3
    response = np.empty((paths, longest), np.float32)
    weight = np.zeros((beam.table.shape[0], gates, whole), np.float32)
    for column in range(first_facet.size - 1):
        _weigh(column, window, beam, weight)
        for n in range(first_facet[column], first_facet[column + 1]):
            _draw_modes(speckle, numbers[column], facets.number[n], n, bits, real, imag, count)
            for path in range(paths):
                begin, step[path], longer = _phase_of(
                    geometry, facets, antennas[path, 0], antennas[path, 1], n, columns.begin_s[column]
                )
                phasor_of[path] = path
                for other in range(path):
                    if phasor_of[other] == other and abs(step[path] - step[other]) * window <= _ALIKE:
                        phasor_of[path] = other
                        break
                if phasor_of[path] == path:
                    _fill_phasor(step[path], phasor, path)
                # Paths that share a phasor agree in the middle, where the beam is.
                shared = step[phasor_of[path]]
                value = amplitudes[path, n]
                cosine, sine = _cosine_and_sine(-(begin + (step[path] - shared) * middle))
                constant[path, 0] = value.real * cosine - value.imag * sine
                constant[path, 1] = value.real * sine + value.imag * cosine
                beyond = facets.range_m[n] + 0.5 * longer - table.first_gate_m
                low, high = _fill_response(beyond, table, path, gates, response)
                heard[path, 0], heard[path, 1] = low, high if value != 0.0 else low
                heard[path, 2] = min(max(int(beyond / table.gate_spacing_m + 0.5), 0), gates - 1)
            start = columns.first_node[column]
            _add_facet(modes, column, real, imag, phasor, phasor_of, constant, heard, response, weight, start, out)


@compiled
def _phase_of(geometry, facets, i, j, n, begin_s):
    """Phase k(R_i + R_j) [rad] of facet n's path from antenna i to j at the window's first node, by what it advances to
    the next, and by how much R_i + R_j is longer than twice the range from the first antenna [m]."""
    difference, velocity = facets.difference_m, facets.radial_velocity
    longer, along = difference[i, n] + difference[j, n], velocity[i, n] + velocity[j, n]
    phase = geometry.wavenumber * (2.0 * facets.range_m[n] + longer + along * begin_s)
    return phase, geometry.wavenumber * geometry.node_spacing_s * along, longer


@compiled
def _draw_modes(speckle, column, facet, n, bits, real, imag, count):
    """Fill real and imag (mode,) with the numbers of facet n, those of each kind times its strength. column, facet:
    their keys in the random source."""
    streams, strength, of_first = speckle.streams, speckle.strength[n], speckle.first_kind_modes
    count_bits(key_of(key_of(streams[0], column), facet), bits[:of_first])
    if strength.size > 1:
        count_bits(key_of(key_of(streams[1], column), facet), bits[of_first:count])
    normals(bits, real, imag)
    for mode in range(count):
        root = strength[0] if mode < of_first else strength[1]
        real[mode] *= root
        imag[mode] *= root


@compiled
def _fill_response(beyond, range_table, path, gates, response):
    """Fill response[path] with that of the gates that hear a reflector, and give the first of them and the last + 1.
    beyond [m]: of the reflector from the first gate."""
    table, entries_per_m, spacing = range_table.table, range_table.entries_per_m, range_table.gate_spacing_m
    row, last = path if table.shape[0] > 1 else 0, table.shape[1] - 1
    support = last / entries_per_m
    low = max(int(np.ceil((beyond - support) / spacing)), 0)
    high = min(int(np.floor((beyond + support) / spacing)), gates - 1) + 1
    for gate in range(low, high):
        response[path, gate - low] = table[row, min(int(abs(beyond - gate * spacing) * entries_per_m), last)]
    return low, max(high, low)


@compiled
def _add_facet(modes, column, real, imag, phasor, phasor_of, constant, heard, response, weight, start, out):
    """Add one facet to out (component, path, gate, node) from node `start` on.

    Its numbers real and imag (mode,) times the column's modes, rotated by the phasors (path, component, node), the one
    that each path uses (path,), times each path's constant (path, component), the weight (path or 1, gate, node) of the
    beam at the facet's own gate, and the response (path, gate) of the gates that hear it: heard (path, 3) holds the
    first of them, the last + 1, and the facet's own.
    """
    count, whole = modes.shape[2], modes.shape[3]
    gates, nodes = out.shape[2], out.shape[3]
    imaginary = out.shape[1] * gates * nodes
    first_mode = column * 2 * count * whole
    for node in range(0, whole, LANES):
        xa = yb = xb = ya = zeros()  # separate sums: no addition waits for another
        for mode in range(count):
            x, y = real[mode], imag[mode]
            index = first_mode + mode * whole + node
            a, b = load(modes, index), load(modes, index + count * whole)
            xa, yb, xb, ya = add(xa, x, a), add(yb, y, b), add(xb, x, b), add(ya, y, a)
        re, im = less(xa, yb), plus(xb, ya)
        rotated_re, rotated_im = re, im
        last = -1
        for path in range(heard.shape[0]):
            if phasor_of[path] != last:
                last = phasor_of[path]
                c, d = load(phasor, 2 * last * whole + node), load(phasor, (2 * last + 1) * whole + node)
                rotated_re = less(product(re, c), product(im, d))
                rotated_im = plus(product(re, d), product(im, c))
            u, v = constant[path, 0], constant[path, 1]
            row = path if weight.shape[0] > 1 else 0
            pattern = load(weight, (row * gates + heard[path, 2]) * whole + node)
            echo_re = product(pattern, add(add(zeros(), u, rotated_re), -v, rotated_im))
            echo_im = product(pattern, add(add(zeros(), u, rotated_im), v, rotated_re))
            index = (path * gates + heard[path, 0]) * nodes + start + node
            for n in range(heard[path, 1] - heard[path, 0]):
                height = response[path, n]
                store(out, index, add(load(out, index), height, echo_re))
                store(out, index + imaginary, add(load(out, index + imaginary), height, echo_im))
                index += nodes


@compiled
def _cosine_and_sine(phase):
    """Of a phase [rad], reduced in float64."""
    cycles = phase * _CYCLES_PER_RAD
    return unit_phasor(np.float32(cycles - np.rint(cycles)))


@compiled
def _fill_phasor(phase, phasor, path):
    """Fill phasor[path] (component, node) with exp(−j n phase): one group of lanes, then each from the group before."""
    cycles = -phase * _CYCLES_PER_RAD
    for node in range(LANES):
        each = node * cycles
        phasor[path, 0, node], phasor[path, 1, node] = unit_phasor(np.float32(each - np.rint(each)))
    whole = phasor.shape[2]
    index = path * 2 * whole
    re, im = load(phasor, index), load(phasor, index + whole)
    cosine, sine = _cosine_and_sine(-phase * LANES)
    for node in range(LANES, whole, LANES):
        re, im = add(add(zeros(), cosine, re), -sine, im), add(add(zeros(), cosine, im), sine, re)
        store(phasor, index + node, re)
        store(phasor, index + whole + node, im)


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
