"""The inner loops of a turn's echoes: what some columns return into every gate, at every knot at which they are heard.

    V(path, gate, knot) = E(path, gate, knot) Σ_facets a(path) h(path, gate) s(knot) exp(−jk(R_tx + R_rx)(knot))

Knots are the innermost axis everywhere: a processor's lanes take them together. Real and imaginary parts stand in
arrays of their own for the same reason. A facet's phase is reduced in float64 and turns from knot to knot by a constant
factor (a rotation of some 50 steps in float32 errs by 1e-5 rad).
"""

from __future__ import annotations

import numpy as np

from ..compiled import compiled
from .gaussian import draw, key_of, turned

LANES = 8  # knots are padded to whole groups of so many,
GROUP = 4  # modes of each kind of scatterer likewise
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
    spacing of the samples in its steps. beam: see `_beam`.
    """
    modes, of_first, strengths = speckle
    begin, step = phases
    table, nearest, apart = response
    paths, samples = out.shape[1], out.shape[2]
    window = modes.shape[3]
    count = modes.shape[2]
    bits, real, imag = np.empty(count, np.uint64), np.empty(count, np.float32), np.empty(count, np.float32)
    series = np.empty((2, window), np.float32)
    phasor = np.empty((2, window), np.float32)
    turning = np.empty((2, window), np.float32)
    part = np.empty((2, window), np.float32)
    heard = np.empty((2, paths, samples, window), np.float32)
    weight = np.empty(window, np.float32)
    for column in range(first.size - 1):
        heard[:] = np.float32(0.0)
        for n in range(first[column], first[column + 1]):
            _draw_modes(streams, key[column], facet[n], of_first, strengths[n], bits, real, imag)
            _series(modes[column], strengths[n], of_first, real, imag, series)
            _turning(step[0, n], phasor)
            _times(series, phasor, turning)
            turned_by = step[0, n]
            for path in range(paths):
                if abs(step[path, n] - turned_by) * window > _ALIKE:
                    turned_by = step[path, n]
                    _turning(turned_by, phasor)
                    _times(series, phasor, turning)
                value = amplitude[path, n]
                if value == 0.0:
                    continue
                cosine, sine = _unit(-begin[path, n])
                real_part = np.float32(value.real * cosine - value.imag * sine)
                imag_part = np.float32(value.real * sine + value.imag * cosine)
                for knot in range(window):
                    part[0, knot] = real_part * turning[0, knot] - imag_part * turning[1, knot]
                    part[1, knot] = real_part * turning[1, knot] + imag_part * turning[0, knot]
                entries = table[path if table.shape[0] > 1 else 0]
                support = entries.size - 1
                place = length[path, n] - nearest
                low = max(int(np.ceil((place - support) / apart)), 0)
                high = min(int(np.floor((place + support) / apart)), samples - 1)
                for gate in range(low, high + 1):
                    entry = int(abs(place - gate * apart))
                    height = entries[min(entry, support)]
                    for knot in range(window):
                        heard[0, path, gate, knot] += height * part[0, knot]
                        heard[1, path, gate, knot] += height * part[1, knot]
        _beamed(heard, column, start[column], beam, weight, out)


@compiled
def _draw_modes(streams, column, facet, of_first, strength, bits, real, imag):
    """Fill real and imag (mode,) with a facet's numbers; a kind without strength is not drawn."""
    if strength[0] > 0.0:
        key = key_of(key_of(streams[0], column), facet)
        draw(key, bits[:of_first], real[:of_first], imag[:of_first])
    if strength.size > 1 and strength[1] > 0.0:
        key = key_of(key_of(streams[1], column), facet)
        draw(key, bits[of_first:], real[of_first:], imag[of_first:])


@compiled
def _series(modes, strength, of_first, real, imag, series):
    """Speckle (part, knot) of one facet: its numbers times the modes (part, mode, knot), four modes at a time."""
    series[:] = np.float32(0.0)
    for mode in range(0, real.size, GROUP):
        root = strength[0] if mode < of_first else strength[1]
        if root == 0.0:
            continue
        x0, y0 = root * real[mode], root * imag[mode]
        x1, y1 = root * real[mode + 1], root * imag[mode + 1]
        x2, y2 = root * real[mode + 2], root * imag[mode + 2]
        x3, y3 = root * real[mode + 3], root * imag[mode + 3]
        for knot in range(series.shape[1]):
            a0, b0 = modes[0, mode, knot], modes[1, mode, knot]
            a1, b1 = modes[0, mode + 1, knot], modes[1, mode + 1, knot]
            a2, b2 = modes[0, mode + 2, knot], modes[1, mode + 2, knot]
            a3, b3 = modes[0, mode + 3, knot], modes[1, mode + 3, knot]
            series[0, knot] += (x0 * a0 - y0 * b0) + (x1 * a1 - y1 * b1) + (x2 * a2 - y2 * b2) + (x3 * a3 - y3 * b3)
            series[1, knot] += (x0 * b0 + y0 * a0) + (x1 * b1 + y1 * a1) + (x2 * b2 + y2 * a2) + (x3 * b3 + y3 * a3)


@compiled
def _unit(phase):
    """Cosine and sine of a phase [rad], reduced in float64."""
    turns = phase * _INVERSE_TURN
    return turned(np.float32(turns - np.rint(turns)))


@compiled
def _turning(phase, phasor):
    """Fill phasor (part, knot) with exp(−j n phase): one group of lanes by sines, the others a group's turn on."""
    for lane in range(LANES):
        phasor[0, lane], phasor[1, lane] = _unit(-phase * lane)
    cosine, sine = _unit(-phase * LANES)
    for knot in range(LANES, phasor.shape[1]):
        x, y = phasor[0, knot - LANES], phasor[1, knot - LANES]
        phasor[0, knot] = x * cosine - y * sine
        phasor[1, knot] = x * sine + y * cosine


@compiled
def _times(first, second, product):
    """Products of complex numbers (part, knot)."""
    for knot in range(product.shape[1]):
        product[0, knot] = first[0, knot] * second[0, knot] - first[1, knot] * second[1, knot]
        product[1, knot] = first[0, knot] * second[1, knot] + first[1, knot] * second[0, knot]


@compiled
def _beamed(heard, column, start, beam, weight, out):
    """Add what a column returns, (part, path, gate, knot), weighed by the beam towards the mean sea that a gate hears.

    beam: tables (beam, way, entry) of voltage against the direction cosine, their scale, what each way's antenna stands
    aside (beam, way) m; then the cosine's parts. It is level[gate] along[column, knot] − drop[gate] up[column, knot] −
    past[column, knot]/range[gate].
    """
    tables, scale, aside, level, drop, inverse_range, along, up, past = beam
    entries = tables.shape[2]
    middle = np.float32(0.5 * entries)  # half an entry on: the cast cuts, and so rounds
    for gate in range(heard.shape[2]):
        for path in range(heard.shape[1]):
            if path < tables.shape[0]:
                weight[:] = np.float32(1.0)
                for way in range(tables.shape[1]):
                    shift = aside[path, way] * inverse_range[gate]
                    for knot in range(weight.size):
                        cosine = level[gate] * along[column, knot] - drop[gate] * up[column, knot]
                        cosine = cosine - past[column, knot] * inverse_range[gate] - shift
                        entry = min(max(int(cosine * scale + middle), 0), entries - 1)
                        weight[knot] *= tables[path, way, entry]
            for knot in range(weight.size):
                out[0, path, gate, start + knot] += weight[knot] * heard[0, path, gate, knot]
                out[1, path, gate, start + knot] += weight[knot] * heard[1, path, gate, knot]
