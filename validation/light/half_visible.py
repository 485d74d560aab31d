"""How far water is visible to light, and to a radar in VV and in HH: wave optics on profiles that carry all waves.

    python -m validation.light.half_visible [--profiles 8] [--seed 7] [--only SEA] [--resolved]

Visible in a polarization is water whose two-way power per area is at least −3, −6 or −10 dB of that of the same water
lit. Seas of 1/60 to 1/20 (Hs over the peak's wavelength) are drawn as `unresolved_profiles` draws them, from 5 to
205 m, with fields by `wave_optics`. The water's own slope, and the ray that arrives, straight or from the last crest,
say what lit water returns: sine⁴ of the grazing angle in HH, ½ |1 + Γ| of it to the fourth in VV. Judged are facets
half a metre long: those that light sees; those that the program says a radar sees (`tracing/visibility.py`, on a mesh
of the resolved waves); and those that the fields do. Printed: visible share by range, and the range at which half is
visible, of the share from 0.75 to 1.25 of it. `--resolved`: without the small waves. Five seconds of processor time a
profile.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from typing import NamedTuple

import numpy as np

import seamap_rt as sr
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.physics.shadowing import SEEN_DB
from seamap_rt.radar.installation import Installation
from seamap_rt.scattering.permittivity import permittivity_of
from seamap_rt.tracing import tracer
from seamap_rt.tracing.visibility import water_powers

from .unresolved_profiles import POINTS, STEP_M, Array, Case, both, drawn, wavenumbers
from .wave_optics import Profile, surface_field
from .wave_shadows import FINE, WAVELENGTH_M, water

BEGIN_M, END_M, NEAR_M, FAR_M, FACET_M = 5.0, 205.0, 15.0, 200.0, 0.5
CASES = {
    "1/60, 3 m mast": Case(0.65, 5.0, 6.0, mast=3.0),
    "1/40, 4 m mast": Case(0.98, 5.0, 7.0, mast=4.0),
    "1/30, 5 m mast": Case(1.30, 5.0, 8.0, mast=5.0),
    "1/20, 8 m mast": Case(1.95, 5.0, 9.0, mast=8.0),
}
LEVELS_DB = (-3.0, -6.0, -10.0)
BANDS_M = (15.0, 25.0, 50.0, 75.0, 100.0, 150.0, 200.0)


class Facets(NamedTuple):
    """(facet,) ground range [m], whether light sees it; two-way power over that of the same water lit, by the program
    and by the fields."""

    range_m: Array
    light: Array
    vv: Array
    vv_field: Array
    hh: Array
    hh_field: Array


def facets(case: Case, seed: int, resolved_alone: bool) -> Facets:
    """Of one profile."""
    long, short = both(case, wavenumbers())
    random, x = np.random.default_rng(seed), STEP_M * POINTS / FINE * np.arange(FINE)
    resolved, small = drawn(random, long, FINE, 2), drawn(random, short, FINE, 2)
    whole = resolved if resolved_alone else [a + b for a, b in zip(resolved, small, strict=True)]
    part = (x >= BEGIN_M) & (x < END_M)
    profile = Profile(x[part], *(each[part] for each in whole))
    field = surface_field(profile, (0.0, case.mast), WAVELENGTH_M, water())
    range_m, light, vv, hh = by_program(x, resolved[0], case.mast)
    sine = sine_of_arrival(x[part], resolved[0][part], resolved[1][part], case.mast)
    place = np.rint((profile.x - range_m[0]) / FACET_M).astype(int)
    inside = (place >= 0) & (place < range_m.size)

    def mean(power: Array) -> Array:
        return np.bincount(place[inside], power[inside], range_m.size).astype(np.float64)

    faces, lit = mean(sine) > 0.0, np.maximum(sine, 0.0)
    powers = [(field.vv, lit / (lit + water())), (field.hh, lit)]
    fields = [
        np.where(faces, mean(np.abs(wave) ** 4) / np.maximum(mean(np.abs(plane) ** 4), 1e-30), 0.0)
        for wave, plane in powers
    ]
    return Facets(range_m, light, vv, fields[0], hh, fields[1])


def sine_of_arrival(x: Array, height: Array, slope: Array, mast: float) -> Array:
    """(point,) of the angle under which the water meets the ray that arrives, straight or from the last crest; negative
    where it leans away."""
    tangent = (height - mast) / x
    crest = np.maximum.accumulate(np.where(tangent >= np.maximum.accumulate(tangent), np.arange(x.size), 0))
    away = x - x[crest]
    falls = np.where(away > 0.0, (height[crest] - height) / np.where(away > 0.0, away, 1.0), -tangent)
    return np.sin(np.arctan(slope) + np.arctan(falls))


def by_program(x: Array, height: Array, mast: float) -> list[Array]:
    """Ranges of the facets, which of them light sees, and two-way power in VV and HH, on the program's mesh."""
    keys = {"radar.height_m": mast, "radar.baseline_m": 1e-3, "tracing.facet_m": FACET_M, "turns": 1}
    scene = sr.load_scene("choppy_sea", keys | {"radar.range_m": [10.0, FAR_M], "radar.sector_deg": [0.0, 2.0]})
    grid = polar_grid(Installation(scene.radar), scene.meshing, 0)
    level = np.interp(grid.ground_range, x, height)
    elevation = np.broadcast_to(level, (grid.azimuth.size, level.size))
    mesh = surface_mesh(grid, elevation, np.zeros((*elevation.shape, 3), dtype=np.float32))
    light = tracer("horizon", scene.radar, scene.scattering)(mesh.levelled)
    column = grid.columns // 2
    chosen = (light.distance >= NEAR_M) & (light.distance < FAR_M)
    chosen[1::2] = False  # near facets alone: a chain of their own
    permittivity = permittivity_of(scene.scattering, scene.radar.frequency_hz)
    powers = [each[column, chosen] for each in water_powers(mesh, permittivity, WAVELENGTH_M)]
    found = light.distance[chosen], light.visible_to_both[column, chosen], *powers
    return [np.asarray(each, dtype=np.float64) for each in found]


def half_range(range_m: Array, seen: Array) -> float:
    """Where the share, from 0.75 to 1.25 of a range, first falls below a half [m]; NaN where it does not."""
    at = np.arange(NEAR_M / 0.75, FAR_M / 1.25, 1.0)
    share = np.array([seen[(range_m >= 0.75 * each) & (range_m < 1.25 * each)].mean() for each in at])
    below = np.flatnonzero(share < 0.5)
    return float(at[below[0]]) if below.size and below[0] else np.nan


def visible(made: Facets, name: str, level_db: float) -> Array:
    """(facet,) 1 or 0. Water that leans away from the ray that arrives is not."""
    if name == "light":
        return made.light
    return 1.0 * (getattr(made, name) >= 10.0 ** (0.1 * level_db))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--profiles", type=int, default=8)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--only", choices=list(CASES))
    parser.add_argument("--resolved", action="store_true")
    arguments = parser.parse_args()
    halves: dict[str, dict[tuple[str, float], float]] = {}
    for name in [arguments.only] if arguments.only else CASES:
        seeds = range(1000 * arguments.seed, 1000 * arguments.seed + arguments.profiles)
        parts = [facets(CASES[name], seed, arguments.resolved) for seed in seeds]
        made = Facets(*(np.concatenate(each) for each in zip(*parts, strict=True)))
        print(f"{name}: visible share by range, half visible to")
        print(f"{'':22}" + "".join(f"{a:5.0f}–{b:<3.0f}" for a, b in pairwise(BANDS_M)))
        band = np.digitize(made.range_m, BANDS_M) - 1
        for who, level in [("light", 0.0), *((each, level) for level in LEVELS_DB for each in Facets._fields[2:])]:
            seen = visible(made, who, level)
            shares = [seen[band == n].mean() for n in range(len(BANDS_M) - 1)]
            label = who if who == "light" else f"{who.replace('_', ' by ')} {level:.0f} dB"
            print(f"{label:22}" + "".join(f"{each:9.2f}" for each in shares), end="")
            half = halves.setdefault(name, {})[who, level] = half_range(made.range_m, seen)
            print(f"{half:9.0f} m", flush=True)
    shown = [("light", 0.0), *((who, SEEN_DB) for who in Facets._fields[2:])]
    print(f"Half visible to (m), to a radar from {SEEN_DB:g} dB on\n")
    print("| sea, mast | light | VV | VV, field | HH | HH, field |")
    print("|---" * (1 + len(shown)) + "|")
    for name, by in halves.items():
        print(f"| {name} | " + " | ".join(f"{by[each]:.0f}" for each in shown) + " |")


if __name__ == "__main__":
    main()
