"""The inner loops of the local planes, compiled: each cell is summed by itself, always in the same order."""

from __future__ import annotations

import math

from ...compute.compiled import compiled


@compiled
def fit_planes(begin, end, height, weight, points, outward, reach, least, slopes):
    """Write looks begin … end of slopes (2, look, gate), outward and clockwise.

    Points whose spread across their line is less than a part `least` of it span no plane.
    points (2, look, gate) x and y, outward (2, look, gate) east and north, reach (2, gate) in gates and looks. Cells of
    weight 0 count nothing, but need finite numbers all the same.
    """
    looks, gates = height.shape
    for i in range(begin, end):
        for j in range(gates):
            if weight[i, j] == 0.0:
                continue
            far_gate, far_look = math.ceil(reach[0, j]) - 1, math.ceil(reach[1, j]) - 1
            rows = max(0, i - far_look), min(looks, i + far_look + 1)
            span = rows[0], rows[1], max(0, j - far_gate), min(gates, j + far_gate + 1)
            uu, uv, vv, uz, vz, spans = _moments(height, weight, points, outward, reach, i, j, span)
            determinant = uu * vv - uv * uv
            if not (spans and determinant > least * uu * vv):
                continue
            slopes[0, i, j] = (uz * vv - vz * uv) / determinant
            slopes[1, i, j] = (vz * uu - uz * uv) / determinant


@compiled
def _moments(height, weight, points, outward, reach, i, j, span):
    """Second moments of points (u, v) and heights; and whether several looks and gates have a part in them: one gate's
    own points lie on an arc, whose bend alone would seem to span a plane."""
    x, y, east, north = points[0, i, j], points[1, i, j], outward[0, i, j], outward[1, i, j]
    s = su = sv = suu = suv = svv = sz = suz = svz = of_gate = of_look = 0.0
    for a in range(span[0], span[1]):
        taper = 1.0 - ((a - i) / reach[1, j]) ** 2
        before = s
        for b in range(span[2], span[3]):
            # Relative to the cell itself, which keeps the sums well conditioned.
            dx, dy, z = points[0, a, b] - x, points[1, a, b] - y, height[a, b] - height[i, j]
            u, v = dx * east + dy * north, dx * north - dy * east
            w = weight[a, b] * taper * (1.0 - ((b - j) / reach[0, j]) ** 2)
            wu, wv = w * u, w * v
            s += w
            su += wu
            sv += wv
            suu += wu * u
            suv += wu * v
            svv += wv * v
            sz += w * z
            suz += wu * z
            svz += wv * z
        of_gate += weight[a, j] * taper
        if a == i:
            of_look = s - before
    spans = s - of_gate > 1e-9 * s and s - of_look > 1e-9 * s
    u, v, z = su / s, sv / s, sz / s
    return suu / s - u * u, suv / s - u * v, svv / s - v * v, suz / s - u * z, svz / s - v * z, spans
