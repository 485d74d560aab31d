"""The inner loops of a turn's echoes: what some columns return into every gate, at every knot at which they are heard.

    V(path, gate, knot) = E(path, gate, knot) Σ_facets a(path) h(path, gate) s(knot) exp(−jk(R_tx + R_rx)(knot))

Knots are the innermost axis everywhere: a processor's lanes take them together. Real and imaginary parts stand in
arrays of their own for the same reason. A facet's phase is reduced in float64 and turns from knot to knot by a constant
factor (a rotation of some 50 steps in float32 errs by 1e-5 rad).
"""

from __future__ import annotations

import numpy as np

from ..compiled import compiled
from ..lanes import LANES, add, less, load, plus, product, store, zeros
from .gaussian import count_bits, key_of, normals, turned

_ALIKE = 1e-3  # rad that paths may turn against each other while a facet is heard, and share a phasor
_INVERSE_TURN = 1.0 / (2.0 * np.pi)


@compiled
def add_columns(first, start, facet, streams, key, speckle, phases, amplitude, length, response, beam, out):
    """Add columns to out (part, path, gate, knot), part being real and imaginary.

    first (column + 1,): where each column's facets begin among those given, (n,); start (column,): the knot of `out` at
    which each column's window begins. facet (n,): its number in its column; streams: keys of the random source for each
    kind of scatterer; key (column,): the columns' numbers in it.
    speckle: modes (column, part, mode, knot), the number of those of the first kind, strengths (n, kind).
    phases: at the first knot and from knot to knot, (path, n) rad. amplitude (path, n), complex.
    length (path, n): half-paths in steps of the response's table. response: table (path or 1, entry), first sample and
    spacing of the samples in its steps. beam: see `_beamed`.
    """
    modes, of_first, strengths = speckle
    begin, step = phases
    table, nearest, apart = response
    paths, samples, count, window = out.shape[1], out.shape[2], modes.shape[2], modes.shape[3]
    _, _, _, _, _, _, along, _, _ = beam
    middle = 0.5 * (along.shape[1] - 1)  # of the knots at which a column is heard
    room = (count + LANES - 1) // LANES * LANES
    bits, real, imag = np.zeros(room, np.uint64), np.empty(room, np.float32), np.empty(room, np.float32)
    phasor = np.empty((paths, 2, window), np.float32)
    turns_with = np.empty(paths, np.int64)
    constant = np.empty((paths, 2), np.float32)
    gates = np.zeros((paths, 2), np.int64)
    height = np.empty((paths, 2 * int(table.shape[1] / apart) + 3), np.float32)
    heard = np.empty((paths, samples, 2, window), np.float32)
    weight = np.empty(window, np.float32)
    for column in range(first.size - 1):
        heard[:] = np.float32(0.0)
        for n in range(first[column], first[column + 1]):
            _draw_modes(streams, key[column], facet[n], of_first, strengths[n], bits, real, imag, count)
            for path in range(paths):
                turns_with[path] = path
                for other in range(path):
                    if turns_with[other] == other and abs(step[path, n] - step[other, n]) * window <= _ALIKE:
                        turns_with[path] = other
                        break
                if turns_with[path] == path:
                    _turning(step[path, n], phasor[path])
                # Paths that share a phasor agree in the middle, where the beam is.
                shared = step[turns_with[path], n]
                value = amplitude[path, n]
                cosine, sine = _unit(-(begin[path, n] + (step[path, n] - shared) * middle))
                constant[path, 0] = value.real * cosine - value.imag * sine
                constant[path, 1] = value.real * sine + value.imag * cosine
                place = length[path, n] - nearest
                entries = table[path if table.shape[0] > 1 else 0]
                low, high = _heard_by(place, entries, apart, samples, height[path])
                gates[path, 0], gates[path, 1] = low, high if value != 0.0 else low
            _add_facet(modes[column], real, imag, phasor, turns_with, constant, gates, height, heard)
        _beamed(heard, column, start[column], beam, weight, out)


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
def _heard_by(place, entries, apart, samples, height):
    """Fill height with the response of the samples that hear a reflector, and give the first and the last + 1 of them.

    place: of the reflector beyond the first sample, apart: of neighbouring samples, both in steps of the table.
    """
    support = entries.size - 1
    low = max(int(np.ceil((place - support) / apart)), 0)
    high = min(int(np.floor((place + support) / apart)), samples - 1) + 1
    for gate in range(low, high):
        height[gate - low] = entries[min(int(abs(place - gate * apart)), support)]
    return low, max(high, low)


@compiled
def _add_facet(modes, real, imag, phasor, turns_with, constant, gates, height, heard):
    """Add one facet to heard (path, gate, part, knot): its numbers times the modes (part, mode, knot), turned by the
    phasors (path, part, knot), times each path's constant (path, part) and its response in the gates that hear it."""
    count, window = modes.shape[1], modes.shape[2]
    samples = heard.shape[1]
    for knot in range(0, window, LANES):
        xa = yb = xb = ya = zeros()  # sums of their own: none waits for another
        for mode in range(count):
            x, y = real[mode], imag[mode]
            a, b = load(modes, mode * window + knot), load(modes, (count + mode) * window + knot)
            xa, yb, xb, ya = add(xa, x, a), add(yb, y, b), add(xb, x, b), add(ya, y, a)
        re, im = less(xa, yb), plus(xb, ya)
        turned_re, turned_im = re, im
        last = -1
        for path in range(gates.shape[0]):
            if turns_with[path] != last:
                last = turns_with[path]
                c, d = load(phasor, 2 * last * window + knot), load(phasor, (2 * last + 1) * window + knot)
                turned_re = less(product(re, c), product(im, d))
                turned_im = plus(product(re, d), product(im, c))
            u, v = constant[path, 0], constant[path, 1]
            part_re = add(add(zeros(), u, turned_re), -v, turned_im)
            part_im = add(add(zeros(), u, turned_im), v, turned_re)
            place = (path * samples + gates[path, 0]) * 2 * window + knot
            for n in range(gates[path, 1] - gates[path, 0]):
                response = height[path, n]
                store(heard, place, add(load(heard, place), response, part_re))
                store(heard, place + window, add(load(heard, place + window), response, part_im))
                place += 2 * window


@compiled
def _unit(phase):
    """Cosine and sine of a phase [rad], reduced in float64."""
    turns = phase * _INVERSE_TURN
    return turned(np.float32(turns - np.rint(turns)))


@compiled
def _turning(phase, phasor):
    """Fill phasor (part, knot) with exp(−j n phase): each of two before it, for as long as that errs by 1e-6 at most;
    groups of lanes then go on by a group's turn."""
    phasor[0, 0], phasor[1, 0] = 1.0, 0.0
    phasor[0, 1], phasor[1, 1] = _unit(-phase)
    for knot in range(2, LANES):
        one, other = knot // 2, knot - knot // 2
        phasor[0, knot] = phasor[0, one] * phasor[0, other] - phasor[1, one] * phasor[1, other]
        phasor[1, knot] = phasor[0, one] * phasor[1, other] + phasor[1, one] * phasor[0, other]
    cosine, sine = _unit(-phase * LANES)
    for knot in range(LANES, phasor.shape[1]):
        x, y = phasor[0, knot - LANES], phasor[1, knot - LANES]
        phasor[0, knot] = x * cosine - y * sine
        phasor[1, knot] = x * sine + y * cosine


@compiled
def _beamed(heard, column, start, beam, weight, out):
    """Add what a column returns, (path, gate, part, knot), weighed by the beam towards the mean sea that a gate hears.

    beam: tables (beam, way, entry) of voltage against the direction cosine, their scale, what each way's antenna stands
    aside (beam, way) m; then the cosine's parts. It is level[gate] along[column, knot] − drop[gate] up[column, knot] −
    past[column, knot]/range[gate].
    """
    tables, scale, aside, level, drop, inverse_range, along, up, past = beam
    entries, window = tables.shape[2], along.shape[1]
    middle = np.float32(0.5 * entries)  # half an entry on: the cast cuts, and so rounds
    for gate in range(heard.shape[1]):
        for path in range(heard.shape[0]):
            if path < tables.shape[0]:
                weight[:] = np.float32(1.0)
                for way in range(tables.shape[1]):
                    shift = aside[path, way] * inverse_range[gate]
                    for knot in range(window):
                        cosine = level[gate] * along[column, knot] - drop[gate] * up[column, knot]
                        cosine = cosine - past[column, knot] * inverse_range[gate] - shift
                        entry = min(max(int(cosine * scale + middle), 0), entries - 1)
                        weight[knot] *= tables[path, way, entry]
            for knot in range(window):
                out[0, path, gate, start + knot] += weight[knot] * heard[path, gate, 0, knot]
                out[1, path, gate, start + knot] += weight[knot] * heard[path, gate, 1, knot]
