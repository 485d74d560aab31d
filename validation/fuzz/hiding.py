"""What is left out of the rays' tree changes no light: meshes of scenes drawn from lists, traced with all triangles and
with those that `tracing.hiding` keeps.

    python -m validation.fuzz.hiding [--seconds 200] [--seed 1]

Antennas low and high, upright and leaning, on boats that roll and boats at rest; seas of all scenes that come with the
package; coarse and fine meshes, on the water and levelled. The law is that not one facet's light differs, of either
antenna. Prints the scenes that break it, and the share of facets that was left out; exit 1 where any did.
"""

from __future__ import annotations

import random
import sys
import time
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

import seamap_rt as sr
from seamap_rt.errors import InputError
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.simulation import Simulator
from seamap_rt.tracing.rays import SeaScene, occluding_surface
from seamap_rt.tracing.shadow_rays import shadow_rays

from ..options import options

SCENES = ("tiny", "choppy_sea", "rough_ride", "wind_and_swell")
CHOICES: Mapping[str, list[Any]] = {
    "radar.height_m": [1.5, 3.0, 6.0, 10.0, 25.0, 60.0],
    "radar.range_m": [[15.0, 60.0], [15.0, 150.0], [15.0, 400.0]],
    "radar.tilt_deg": [0.0, 0.0, 10.0, 30.0, 50.0, -30.0],
    "radar.baseline_m": [0.3, 0.9, 2.0],
    "sea.model": ["linear", "choppy"],
    "tracing.facet_m": [0.4, 0.8, 2.0],
    "tracing.columns_per_beam": [2, 4, 9],
}
STARTS_DEG, WIDTHS_DEG = (0.0, 90.0, 250.0, 330.0), (5.0, 10.0, 30.0, 90.0)
WATER = 55.0 - 37.5j


def main() -> None:
    arguments = options(__doc__, seconds=200.0, seed=1)
    warnings.simplefilter("ignore")
    draw, end, broken, left_out = random.Random(arguments.seed), time.monotonic() + arguments.seconds, 0, []
    while time.monotonic() < end:
        name, keys, levelled = *drawn(draw), draw.random() < 0.5
        try:
            mesh = Simulator(sr.load_scene(name, keys)).mesh(0)
        except (InputError, ValueError):
            continue
        differ, out = compared(mesh.levelled if levelled else mesh)
        left_out.append(out)
        if differ:
            broken += 1
            print(f"light of {differ} facets differs: {name} {keys}, {'levelled' if levelled else 'on the water'}")
    print(f"{len(left_out)} scenes, {broken} broke the law; left out {np.mean(left_out):.0%} of the facets")
    sys.exit(1 if broken else 0)


def drawn(draw: random.Random) -> tuple[str, dict[str, Any]]:
    """A scene's name, and its keys."""
    start = draw.choice(STARTS_DEG)
    keys = {key: draw.choice(values) for key, values in CHOICES.items()}
    keys |= {"radar.sector_deg": [start, start + draw.choice(WIDTHS_DEG)], "seed": draw.randint(1, 9999)}
    return draw.choice(SCENES), keys


def compared(mesh: SurfaceMesh) -> tuple[int, float]:
    """How many facets' light differs, and the share of triangles left out."""
    differ, kept, whole = 0, 0, 0
    for sheet in mesh.sheets():
        rays, antennas = shadow_rays(mesh, mesh.facets, sheet), mesh.grid.antenna_positions[sheet[0].start]
        surfaces = mesh.trimesh(sheet), occluding_surface(mesh, sheet, rays)
        every, some = (rays.lit_facets(SeaScene(each, antennas, 10e9, WATER).hits(rays)) for each in surfaces)
        differ += int(np.count_nonzero(every != some))
        whole, kept = whole + len(surfaces[0].faces), kept + len(surfaces[1].faces)
    return differ, 1.0 - kept / whole


if __name__ == "__main__":
    main()
