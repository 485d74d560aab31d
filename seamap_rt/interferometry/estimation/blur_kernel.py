"""Blurring of a table by a Gaussian, compiled: neighbours of a row are taken whole, by a processor's lanes."""

from __future__ import annotations

import numpy as np

from ...compute.compiled import compiled


@compiled
def blur_rows(field, weights, blurred):
    """Write into blurred (row, column) the means of each row and its neighbours; beyond the edges those at them stand.

    weights (neighbour,): of the row itself, and of either row 1, 2 … away.
    """
    rows, columns = field.shape
    for i in range(rows):
        own, middle = blurred[i], field[i]
        for j in range(np.uint64(columns)):
            own[j] = weights[0] * middle[j]
        for n in range(1, weights.size):
            before, behind, weight = field[max(0, i - n)], field[min(rows - 1, i + n)], weights[n]
            for j in range(np.uint64(columns)):
                own[j] += weight * (before[j] + behind[j])
