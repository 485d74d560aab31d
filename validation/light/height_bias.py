"""By how much wave optics puts lit water too low or too high in an interferometer's map.

    python -m validation.light.height_bias [--profiles 8] [--seed 77] [--baseline 0.2] [--maps 3] [--resolved]

Crests cut into the field over the water behind them, lit or not, and so turn its phase from what its range alone says,
by another angle at either antenna. Profiles, seas and fields as in `half_visible`: full waves in VV and HH, and the
program's knife edges (`tracing/diffraction.py`) times the sine of the grazing angle. An echo goes as the field squared.
Cells are 3 m long; of a cell the height that is found less the true one is −λR/(4πB) arg Σ ψ²(lower) ψ²*(upper): both
ways, as the switched modes measure. Printed: mean and rms of cells that light sees more than half of. Last, maps of the
program with and without knife edges over these seas: their errors against their bars, and against what these would be
if they held nothing of it (`retrieval.diffraction_mrad`). --resolved: waves meet the mesh's waves alone, as edges do.
"""

from __future__ import annotations

from itertools import pairwise, product
from typing import NamedTuple

import numpy as np

import seamap_rt as sr
from seamap_rt.simulation import Simulator
from seamap_rt.tracing.diffraction import field_over_profiles

from ..options import options
from ..retrieval.seas import against_truth, system
from .half_visible import BEGIN_M, CASES, END_M, Array, sine_of_arrival
from .unresolved_profiles import POINTS, STEP_M, Case, both, drawn, wavenumbers
from .wave_optics import Complex, Profile, surface_field
from .wave_shadows import FINE, WAVELENGTH_M, water

BANDS_M = (25.0, 50.0, 100.0, 150.0, 200.0)
_CELL_M, _FACET_M = 3.0, 0.25


class Cells(NamedTuple):
    """(cell,): range [m], share that light sees, and bias of the height [m] by knife edges and by full waves."""

    range_m: Array
    seen: Array
    edges: Array
    vv: Array
    hh: Array


def height_bias(lower: Complex, upper: Complex, x: Array, baseline_m: float) -> Array:
    """(cell,) m, NaN where nothing echoes; fields (point,) over those of free space, at ranges x [m]."""
    cross, cell = (lower * np.conj(upper)) ** 2, (x / _CELL_M).astype(int)
    total = np.bincount(cell, cross.real) + 1j * np.bincount(cell, cross.imag)
    metres = WAVELENGTH_M * _CELL_M * (np.arange(total.size) + 0.5) / (4.0 * np.pi * baseline_m)
    return np.where(total == 0.0, np.nan, -metres * np.angle(total))


def cells(case: Case, seed: int, baseline_m: float, resolved_alone: bool) -> Cells:
    """Of one profile."""
    long, short = both(case, wavenumbers())
    random, x = np.random.default_rng(seed), STEP_M * POINTS / FINE * np.arange(FINE)
    resolved, small = drawn(random, long, FINE, 2), drawn(random, short, FINE, 2)
    part = (x >= BEGIN_M) & (x < END_M)
    waves_of = [a if resolved_alone else a + b for a, b in zip(resolved, small, strict=True)]
    profile = Profile(x[part], *(each[part] for each in waves_of))
    masts = case.mast - 0.5 * baseline_m, case.mast + 0.5 * baseline_m
    waves = [surface_field(profile, (0.0, mast), WAVELENGTH_M, water()) for mast in masts]
    lean = np.maximum(sine_of_arrival(x[part], resolved[0][part], resolved[1][part], case.mast), 0.0)
    edges = [lean * over_edges(profile.x, x, resolved[0], mast) for mast in masts]
    tangent, cell = (profile.height - case.mast) / profile.x, (profile.x / _CELL_M).astype(int)
    lit = tangent >= np.maximum.accumulate(tangent)
    seen = np.bincount(cell, lit) / np.maximum(np.bincount(cell), 1)
    pairs = (edges, [each.vv for each in waves], [each.hh for each in waves])
    biases = [height_bias(lower, upper, profile.x, baseline_m) for lower, upper in pairs]
    return Cells(_CELL_M * (np.arange(seen.size) + 0.5), seen, *biases)


def over_edges(points: Array, x: Array, height: Array, mast: float) -> Complex:
    """The program's field (point,) over that of free space, between facets' middles."""
    corners = np.arange(BEGIN_M, END_M, _FACET_M)
    found = field_over_profiles(corners, (np.interp(corners, x, height) - mast)[None], WAVELENGTH_M)[0][0]
    middles = 0.5 * (corners[1:] + corners[:-1])
    return np.interp(points, middles, found.real) + 1j * np.interp(points, middles, found.imag)


def main() -> None:
    asked = options(__doc__, profiles=8, seed=77, baseline=0.2, maps=3, resolved=False)
    print("**Height found less the true one, mean ± rms (m)**\n")
    print("| sea, mast | by | " + " | ".join(f"{near:.0f}–{far:.0f} m" for near, far in pairwise(BANDS_M)) + " |")
    print("|---" * (1 + len(BANDS_M)) + "|")
    for name, case in CASES.items():
        seeds = range(1000 * asked.seed, 1000 * asked.seed + asked.profiles)
        parts = [cells(case, seed, asked.baseline, asked.resolved) for seed in seeds]
        made = Cells(*(np.concatenate(each) for each in zip(*parts, strict=True)))
        for who in ("edges", "vv", "hh"):
            shown, bias = [], getattr(made, who)
            for near, far in pairwise(BANDS_M):
                inside = (made.range_m >= near) & (made.range_m < far) & (made.seen > 0.5) & np.isfinite(bias)
                shown.append(f"{bias[inside].mean():+.3f} ± {np.sqrt(np.mean(bias[inside] ** 2)):.3f}")
            label = {"edges": "knife edges", "vv": "waves, VV", "hh": "waves, HH"}[who]
            print(f"| {name} | {label} | {' | '.join(shown)} |", flush=True)
    print("\n**Maps of the program, 50–200 m, mean of seeds**\n")
    columns = "rms (m) | error over bar | within 1.96 | error over bar without diffraction's | within 1.96"
    print(f"| sea, mast | diffraction | {columns} |\n" + "|---" * 7 + "|")
    for (name, case), how in product(CASES.items() if asked.maps else (), ("none", "knife_edge")):
        found = []
        for seed in range(1000 * asked.seed, 1000 * asked.seed + asked.maps):
            keys = {"seed": seed, "sea.waves": [system(case.hs, case.tp)], "radar.height_m": case.mast}
            keys |= {"radar.range_m": [15.0, 210.0], "tracing.tracer": "horizon", "tracing.diffraction": how}
            turn = Simulator(sr.load_scene("choppy_sea", keys)).turn(0)
            maps = [sr.retrieve(turn.echoes, changes) for changes in (None, {"diffraction_mrad": 0.0})]
            held, bare = (against_truth(each, turn.truth)[0] for each in maps)
            found.append((held["rms"], held["ratio"], held["within"], bare["ratio"], bare["within"]))
        rms, ratio, within, bare_ratio, bare_within = np.mean(found, axis=0)
        bars = f"{ratio:.2f} | {within:.1%} | {bare_ratio:.2f} | {bare_within:.1%}"
        print(f"| {name} | {how} | {rms:.3f} | {bars} |", flush=True)


if __name__ == "__main__":
    main()
