"""Sums over windows of neighbouring cells whose phases are first brought to the cell's own."""

from __future__ import annotations

import numpy as np

from ...compute.compiled import compiled


@compiled
def window_sums(
    begin, end, cross, lower, upper, known, range_weights, look_weights, per_gate, per_look, here, there,
    sums, powers, weights,
):  # fmt: skip
    """Fills looks begin … end of sums (look, gate) complex, powers (2, look, gate) and weights (look, gate).

    per_gate, per_look (look, gate) complex: what turns the phase of the neighbour one gate or one look on to the
    cell's; here (offset, look, gate), there (look, gate) complex: as well, the level of the sea n gates on as seen from
    the cell, and the neighbour's own; of no gates where the sea is level.
    """
    looks, gates = cross.shape
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    rows, columns = per_gate.shape
    looks_in, gates_in = per_look.shape
    for look in range(begin, end):
        for gate in range(gates):
            along = per_gate[look if rows > 1 else 0, gate if columns > 1 else 0]
            aside = per_look[look if looks_in > 1 else 0, gate if gates_in > 1 else 0]
            sum_cross, sum_lower, sum_upper, total = 0.0j, 0.0, 0.0, 0.0
            for n in range(-half_look, half_look + 1):
                if look + n < 0 or look + n >= looks or look - n < 0 or look - n >= looks:
                    continue
                turn = 1.0 + 0.0j
                for _ in range(abs(n)):
                    turn *= aside if n > 0 else aside.conjugate()
                for _ in range(half_range):
                    turn *= along.conjugate()
                for m in range(-half_range, half_range + 1):
                    inside = 0 <= gate + m < gates and 0 <= gate - m < gates
                    if inside and known[look + n, gate + m] and known[look - n, gate - m]:
                        weight = range_weights[m + half_range] * look_weights[n + half_look]
                        value = cross[look + n, gate + m] * turn
                        if here.shape[0] > 0:
                            value *= here[m + half_range, look, gate] * there[look + n, gate + m]
                        sum_cross += weight * value
                        sum_lower += weight * lower[look + n, gate + m]
                        sum_upper += weight * upper[look + n, gate + m]
                        total += weight
                    turn *= along
            sums[look, gate] = sum_cross
            powers[0, look, gate] = sum_lower
            powers[1, look, gate] = sum_upper
            weights[look, gate] = total if known[look, gate] else np.nan
