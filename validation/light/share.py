"""The visible share of the sea by range: on the default mesh, and on one of four times the rungs and columns.

    python -m validation.light.share [--seeds 2] [--without]

For each sea and mast the share of the water that both antennas see, in rings, and by how much that of the default mesh
is off, with its sign: shadowing is what the program is for, and an error that is always in one direction does not
average out over turns. `--without` shows what the vertices on the water itself would give, as if
`SurfaceMesh.levelled` were not there. About three minutes on two cores.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.simulation import Simulator

from ..options import options

Array = NDArray[np.float64]
EDGES_M = np.array([25.0, 50.0, 100.0, 150.0, 200.0, 300.0, 400.0])
FINER = 4  # times the rungs and the columns
LEAST_SHARE = 0.02  # of a ring: below, a per cent of it is nothing


def waves(height: float, period: float, wave_from: float = 270.0, exponent: float = 10.0) -> dict[str, Any]:
    """A wind sea or a swell, as a scene's key holds it."""
    return {
        "spectrum": "jonswap",
        "significant_wave_height_m": height,
        "peak_period_s": period,
        "wave_from_deg": wave_from,
        "spreading": "cos2s",
        "spreading_exponent": exponent,
    }


SEAS: dict[str, dict[str, Any]] = {
    "1.4 m 5.5 s, 5 m mast": {},
    "0.7 m 4 s, 3 m mast": {"sea.waves": [waves(0.7, 4.0)], "radar.height_m": 3.0},
    "2.5 m 8 s, 8 m mast": {"sea.waves": [waves(2.5, 8.0)], "radar.height_m": 8.0},
    "3 m 9 s, 15 m mast": {"sea.waves": [waves(3.0, 9.0)], "radar.height_m": 15.0},
    "1 m 4.5 s and 2 m 12 s, 6 m mast": {
        "sea.waves": [waves(1.0, 4.5, 230.0), waves(2.0, 12.0, 300.0, 30.0)],
        "radar.height_m": 6.0,
    },
    "4 m 10 s, 20 m mast": {"sea.waves": [waves(4.0, 10.0)], "radar.height_m": 20.0},
}


@dataclass(frozen=True)
class Shares:
    """Visible shares (ring,), mean over seeds: of the default mesh, and of the finer one."""

    default: Array
    finer: Array
    facet_m: float
    columns: int

    @property
    def off(self) -> Array:
        """(ring,) relative, positive where too much is seen; NaN where next to nothing is."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.finer > LEAST_SHARE, self.default / self.finer - 1.0, np.nan)


def seen(scene: sr.Scene) -> Array:
    """Share (ring,) of the water that both antennas see in turn 0."""
    facets, _, _ = Simulator(scene).light(0)
    area = np.broadcast_to(facets.horizontal_area, facets.height.shape)
    ring = np.digitize(facets.distance, EDGES_M) - 1
    lit = facets.visible_to_both
    held = [ring == number for number in range(EDGES_M.size - 1)]
    return np.array([(area * lit)[:, each].sum() / area[:, each].sum() for each in held])


def shares(name: str, seeds: int = 1, sector: tuple[float, float] = (0.0, 360.0)) -> Shares:
    """Those of one of SEAS, over a sector [deg]."""
    keys = {**SEAS[name], "radar.sector_deg": list(sector), "tracing.tracer": "horizon"}
    detail = sr.load_scene("choppy_sea", keys).detail
    fine = {"tracing.facet_m": detail.facet_m / FINER, "tracing.columns_per_beam": FINER * detail.columns_per_beam}
    default, finer = [
        np.mean(
            [seen(sr.load_scene("choppy_sea", {**keys, **mesh, "seed": seed})) for seed in range(1, seeds + 1)], axis=0
        )
        for mesh in ({}, fine)
    ]
    return Shares(default, finer, detail.facet_m, detail.columns_per_beam)


def main() -> None:
    arguments = options(__doc__, seeds=2, without=False)
    if arguments.without:
        SurfaceMesh.levelled = property(lambda mesh: mesh)  # type: ignore[assignment]  # pyright: ignore[reportAttributeAccessIssue]
    print(f"{'rings, m':34}" + "".join(f"{a:5.0f}–{b:<4.0f}" for a, b in pairwise(EDGES_M)))
    worst = 0.0
    for name in SEAS:
        found = shares(name, arguments.seeds)
        print(f"{name:34}" + "".join(f"{each:10.3f}" for each in found.finer))
        mesh = f"  off, rungs {found.facet_m:g} m, {found.columns} columns"
        print(f"{mesh:34}" + "".join(f"{100.0 * each:9.1f}%" for each in found.off), flush=True)
        worst = max(worst, float(np.nanmax(np.abs(found.off))))
    print(f"\n|  | off |\n|---|---|\n| worst ring | {100.0 * worst:.1f} % |")


if __name__ == "__main__":
    main()
