"""The inner loops of a turn's echoes: what some columns return into every gate, at every knot at which they are heard.

    V(path, gate, knot) = Σ_facets E(path, facet, knot) a(path) h(path, gate) s(knot) exp(−jk(R_tx + R_rx)(knot))

Knots are the innermost axis everywhere: a processor's lanes take them together. Real and imaginary parts stand in
arrays of their own for the same reason. A facet's phase is reduced in float64 and turns from knot to knot by a constant
factor (a rotation of some 50 steps in float32 errs by 1e-5 rad).
"""

from __future__ import annotations

import numpy as np

from ..compute.compiled import compiled
from ..compute.lanes import LANES, add, less, load, plus, product, store, zeros
from .gaussian import count_bits, key_of, normals, turned

_ALIKE = 1e-3  # rad that paths may turn against each other while a facet is heard, and share a phasor
_INVERSE_TURN = 1.0 / (2.0 * np.pi)


@compiled
def add_columns(first, start, window, facet, streams, key, speckle, geometry, amplitude, response, beam, out):
    """Add columns to out (part, path, gate, knot), part being real and imaginary.

    first (column + 1,): where each column's facets begin among those given, (n,); start (column,): the knot of `out` at
    which each column's window of knots begins; behind the last there is room for a group of lanes. facet (n,): its
    number in its column; streams: keys of the random source for each kind of scatterer; key (column,): the columns'
    numbers in it.
    speckle: modes (column, part, mode, knot), 0 beyond the window, in whole groups of lanes; the number of those of the
    first kind, strengths (n, kind).
    geometry: see `_phase_of`. amplitude (path, n), complex.
    response: table (path or 1, entry), its entries a metre, the first sample's range and the samples' spacing [m].
    beam: see `_weigh`.
    """
    modes, of_first, strengths = speckle
    pairs, seconds, ranges = geometry[0], geometry[1], geometry[2]
    table, a_metre, nearest, spacing = response
    paths, samples, count, whole = out.shape[1], out.shape[2], modes.shape[2], modes.shape[3]
    middle = 0.5 * (window - 1)  # of the knots at which a column is heard
    room = (count + LANES - 1) // LANES * LANES
    bits, real, imag = np.zeros(room, np.uint64), np.empty(room, np.float32), np.empty(room, np.float32)
    phasor = np.empty((paths, 2, whole), np.float32)
    turns_with = np.empty(paths, np.int64)
    step = np.empty(paths)
    constant = np.empty((paths, 2), np.float32)
    gates = np.zeros((paths, 3), np.int64)
    height = np.empty((paths, 2 * int(table.shape[1] / (a_metre * spacing)) + 3), np.float32)
    weight = np.zeros((beam[0].shape[0], samples, whole), np.float32)
    for column in range(first.size - 1):
        _weigh(column, window, beam, weight)
        for n in range(first[column], first[column + 1]):
            _draw_modes(streams, key[column], facet[n], of_first, strengths[n], bits, real, imag, count)
            for path in range(paths):
                begin, step[path], longer = _phase_of(geometry, pairs[path, 0], pairs[path, 1], n, seconds[column])
                turns_with[path] = path
                for other in range(path):
                    if turns_with[other] == other and abs(step[path] - step[other]) * window <= _ALIKE:
                        turns_with[path] = other
                        break
                if turns_with[path] == path:
                    _turning(step[path], phasor, path)
                # Paths that share a phasor agree in the middle, where the beam is.
                shared = step[turns_with[path]]
                value = amplitude[path, n]
                cosine, sine = _unit(-(begin + (step[path] - shared) * middle))
                constant[path, 0] = value.real * cosine - value.imag * sine
                constant[path, 1] = value.real * sine + value.imag * cosine
                place = ranges[n] + 0.5 * longer - nearest
                low, high = _heard_by(place, table, path, a_metre, spacing, samples, height)
                gates[path, 0], gates[path, 1] = low, high if value != 0.0 else low
                gates[path, 2] = min(max(int(place / spacing + 0.5), 0), samples - 1)
            numbers, turning = (real, imag), (phasor, turns_with, constant)
            _add_facet(modes, column, numbers, turning, gates, height, weight, start[column], out)


@compiled
def _phase_of(geometry, i, j, n, begin):
    """Phase k(R_i + R_j) [rad] of facet n's path from antenna i to j at the first knot, what it turns by to the next,
    and by how much R_i + R_j is longer than twice the range from the first antenna [m].

    geometry: pairs (path, 2) of antennas; the first knot after the beam's passing (column,) s; ranges from the first
    antenna (n,) m; differences to it (antenna, n) m; radial velocities (antenna, n) m/s; rad/m; seconds between knots.
    """
    _, _, ranges, difference, coming, wavenumber, spacing = geometry
    longer, along = difference[i, n] + difference[j, n], coming[i, n] + coming[j, n]
    return wavenumber * (2.0 * ranges[n] + longer + along * begin), wavenumber * spacing * along, longer


@compiled
def _draw_modes(streams, column, facet, of_first, strength, bits, real, imag, count):
    """Fill real and imag (mode,) with a facet's numbers, those of each kind times its strength."""
    count_bits(key_of(key_of(streams[0], column), facet), bits[:of_first])
    if strength.size > 1:
        count_bits(key_of(key_of(streams[1], column), facet), bits[of_first:count])
    normals(bits, real, imag)
    for mode in range(count):
        root = strength[0] if mode < of_first else strength[1]
        real[mode] *= root
        imag[mode] *= root


@compiled
def _heard_by(place, table, path, a_metre, spacing, samples, height):
    """Fill height[path] with the response of the samples that hear a reflector, and give the first of them and the last
    + 1. place [m]: of the reflector beyond the first sample."""
    row, last = path if table.shape[0] > 1 else 0, table.shape[1] - 1
    support = last / a_metre
    low = max(int(np.ceil((place - support) / spacing)), 0)
    high = min(int(np.floor((place + support) / spacing)), samples - 1) + 1
    for gate in range(low, high):
        height[path, gate - low] = table[row, min(int(abs(place - gate * spacing) * a_metre), last)]
    return low, max(high, low)


@compiled
def _add_facet(modes, column, numbers, turning, gates, height, weight, start, out):
    """Add one facet to out (part, path, gate, knot) from knot `start` on: its numbers times the column's modes, turned
    by the phasors (path, part, knot), those that each path uses (path,), times each path's constant (path, part), the
    weight (path or 1, gate, knot) of the beam at its own gate, and its response in the gates that hear it (path: first,
    last + 1, own).
    """
    (real, imag), (phasor, turns_with, constant) = numbers, turning
    count, whole = modes.shape[2], modes.shape[3]
    samples, knots = out.shape[2], out.shape[3]
    imaginary = out.shape[1] * samples * knots
    first_mode = column * 2 * count * whole
    for knot in range(0, whole, LANES):
        xa = yb = xb = ya = zeros()  # sums of their own: none waits for another
        for mode in range(count):
            x, y = real[mode], imag[mode]
            place = first_mode + mode * whole + knot
            a, b = load(modes, place), load(modes, place + count * whole)
            xa, yb, xb, ya = add(xa, x, a), add(yb, y, b), add(xb, x, b), add(ya, y, a)
        re, im = less(xa, yb), plus(xb, ya)
        turned_re, turned_im = re, im
        last = -1
        for path in range(gates.shape[0]):
            if turns_with[path] != last:
                last = turns_with[path]
                c, d = load(phasor, 2 * last * whole + knot), load(phasor, (2 * last + 1) * whole + knot)
                turned_re = less(product(re, c), product(im, d))
                turned_im = plus(product(re, d), product(im, c))
            u, v = constant[path, 0], constant[path, 1]
            row = path if weight.shape[0] > 1 else 0
            heard = load(weight, (row * samples + gates[path, 2]) * whole + knot)
            part_re = product(heard, add(add(zeros(), u, turned_re), -v, turned_im))
            part_im = product(heard, add(add(zeros(), u, turned_im), v, turned_re))
            place = (path * samples + gates[path, 0]) * knots + start + knot
            for n in range(gates[path, 1] - gates[path, 0]):
                response = height[path, n]
                store(out, place, add(load(out, place), response, part_re))
                store(out, place + imaginary, add(load(out, place + imaginary), response, part_im))
                place += knots


@compiled
def _unit(phase):
    """Cosine and sine of a phase [rad], reduced in float64."""
    turns = phase * _INVERSE_TURN
    return turned(np.float32(turns - np.rint(turns)))


@compiled
def _turning(phase, phasor, path):
    """Fill phasor[path] (part, knot) with exp(−j n phase): a group of lanes, and each further one by a group's turn."""
    turns = -phase * _INVERSE_TURN
    for knot in range(LANES):
        part = knot * turns
        phasor[path, 0, knot], phasor[path, 1, knot] = turned(np.float32(part - np.rint(part)))
    whole = phasor.shape[2]
    place = path * 2 * whole
    re, im = load(phasor, place), load(phasor, place + whole)
    cosine, sine = _unit(-phase * LANES)
    for knot in range(LANES, whole, LANES):
        re, im = add(add(zeros(), cosine, re), -sine, im), add(add(zeros(), cosine, im), sine, re)
        store(phasor, place + knot, re)
        store(phasor, place + whole + knot, im)


@compiled
def _weigh(column, window, beam, weight):
    """Fill weight (path or 1, gate, knot) with the beam towards the mean sea at each gate, out and back.

    beam: tables (path or 1, way, entry) of voltage against the direction cosine, their scale, what each way's antenna
    stands aside (path or 1, way) m; then the cosine's parts. It is level[gate] along[column, knot] − drop[gate]
    up[column, knot] − past[column, knot]/range[gate].
    """
    tables, scale, aside, level, drop, inverse_range, along, up, past = beam
    last = np.int32(tables.shape[2] - 1)
    for gate in range(weight.shape[1]):
        ahead, below, beyond = level[gate] * scale, drop[gate] * scale, inverse_range[gate] * scale
        for path in range(tables.shape[0]):
            for way in range(tables.shape[1]):
                # Half an entry on: the cast cuts, and so rounds.
                shift = 0.5 * tables.shape[2] - aside[path, way] * beyond
                for knot in range(window):
                    place = ahead * along[column, knot] - below * up[column, knot] - beyond * past[column, knot]
                    entry = min(max(np.int32(place + shift), np.int32(0)), last)
                    value = tables[path, way, np.uint32(entry)]
                    weight[path, gate, knot] = value if way == 0 else weight[path, gate, knot] * value
