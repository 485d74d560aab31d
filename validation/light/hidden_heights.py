"""Whose height an echo has that bends over a crest: the hidden water's, or the crest's.

    python -m validation.light.hidden_heights [--crest 60] [--beyond 20] [--mast 5] [--baseline 0.2]

A crest, black and straight, stands at mean level `crest` metres away; water lies `beyond` metres behind it, at several
depths under the straight ray from the lower antenna over the crest. The field at either antenna, one way, is that of
free space times Fresnel's F(v) (`validation.analytic.diffraction`). The height that their phase difference means at the
water's range is held against the water's own. In deep shadow F is a ray from the edge: the height is that of the ray
over the crest, so the bias is the depth itself. Water that is clear of the ray has its own height, but for Fresnel's
oscillations. Printed: depth, v, two-way power of the same water's when lit, height that is found less the true one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..analytic.diffraction import knife_edge
from ..options import options

Array = NDArray[np.float64]
WAVELENGTH_M = 0.03
DEPTHS_M = (-1.0, -0.5, -0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3, 0.5, 1.0)


class Found(NamedTuple):
    """(depth,): Fresnel's v at the lower antenna, two-way power in dB, and bias of the height [m]."""

    v: Array
    power_db: Array
    bias_m: Array


def heights(depth_m: Array, crest_m: float, beyond_m: float, mast_m: float, baseline_m: float) -> Found:
    """depth_m (depth,): of the water under the ray from the lower antenna over the crest, negative above it."""
    away = crest_m + beyond_m
    lower, upper = mast_m - 0.5 * baseline_m, mast_m + 0.5 * baseline_m
    level = lower - lower * away / crest_m - np.asarray(depth_m)
    wave, measures, fields = 2.0 * np.pi / WAVELENGTH_M, [], []
    for antenna in (lower, upper):
        path = np.hypot(away, antenna - level)
        detour = np.hypot(crest_m, antenna) + np.hypot(beyond_m, level) - path
        dark = level < antenna - antenna * away / crest_m
        measures.append(np.where(dark, 1.0, -1.0) * 2.0 * np.sqrt(np.maximum(detour, 0.0) / WAVELENGTH_M))
        fields.append(knife_edge(measures[-1]))
    turned = np.angle(fields[0] * np.conj(fields[1]))
    grows = -wave * baseline_m * away**2 / (away**2 + (mast_m - level) ** 2) ** 1.5  # rad of phase a metre of height
    return Found(measures[0], 40.0 * np.log10(np.abs(fields[0])), turned / grows)


def main() -> None:
    asked = options(__doc__, crest=60.0, beyond=20.0, mast=5.0, baseline=0.2)
    found = heights(np.array(DEPTHS_M), asked.crest, asked.beyond, asked.mast, asked.baseline)
    print("depth (m)      v  two-way power (dB)  height found less true (m)")
    for depth, v, power, bias in zip(DEPTHS_M, *found, strict=True):
        print(f"{depth:9.2f}  {v:5.2f}  {power:18.1f}  {bias:26.3f}")


if __name__ == "__main__":
    main()
