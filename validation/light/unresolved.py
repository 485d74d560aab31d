"""Shadows of waves that a mesh does not carry, against the same sea on a mesh that does.

    python -m validation.light.unresolved [--seeds 2] [--echoes]

Each sea is drawn twice from one seed: as coarse as a run draws it, and four times as fine. The waves between the two
are hidden from the coarse mesh, and their slopes are given to `UnresolvedWaves`: what Smith's law takes away must be
what the fine mesh does not see. Printed: visible share of the window and of rings, without and with the law, and on the
fine mesh. `--echoes` adds what that does to the echoes and to the heights of maps. Some minutes on two cores.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.echoes import expected_look_gates
from seamap_rt.simulation import Simulator
from seamap_rt.tracing import UnresolvedWaves

from ..options import options
from .share import waves

Array = NDArray[np.float64]
EDGES_M = np.array([25.0, 50.0, 75.0, 100.0, 150.0, 200.0])
FINER = 4
WAVES_FROM = 270.0


@dataclass(frozen=True)
class Case:
    """A sea with waves from the west, its grid, a mast, and how far one looks."""

    hs: float
    tp: float
    exponent: float
    resolution_m: float
    mast_m: float
    sector_deg: tuple[float, float]

    def scene(self, seed: int, finer: int = 1) -> sr.Scene:
        keys: dict[str, Any] = {
            "seed": seed,
            "sea.waves": [waves(self.hs, self.tp, WAVES_FROM, self.exponent)],
            "sea.resolution_m": self.resolution_m / finer,
            "sea.extent_m": 480.0,
            "radar.range_m": [15.0, 200.0],
            "radar.height_m": self.mast_m,
            "radar.sector_deg": list(self.sector_deg),
            "radar.noise": False,
            "tracing.tracer": "horizon",
        }
        detail = sr.load_scene("choppy_sea", keys | {"sea.resolution_m": self.resolution_m}).detail
        keys["tracing.facet_m"] = detail.facet_m / finer
        keys["tracing.columns_per_beam"] = detail.columns_per_beam * (2 if finer > 1 else 1)
        return sr.load_scene("choppy_sea", keys)


CASES = {
    "1.4 m 5.5 s, 5 m mast, up the waves": Case(1.4, 5.5, 10.0, 0.8, 5.0, (255.0, 285.0)),
    "1.4 m 5.5 s, 5 m mast, across": Case(1.4, 5.5, 4.0, 0.8, 5.0, (345.0, 375.0)),
    "0.7 m 4 s, 3 m mast, at 45°": Case(0.7, 4.0, 4.0, 0.8, 3.0, (210.0, 240.0)),
    "2.5 m 7 s, 10 m mast, down the waves": Case(2.5, 7.0, 6.0, 1.6, 10.0, (75.0, 105.0)),
    "0.3 m 3 s, 4 m mast, up the waves": Case(0.3, 3.0, 4.0, 0.8, 4.0, (255.0, 285.0)),
}


def between(coarse: Simulator, fine: Simulator) -> UnresolvedWaves:
    """The waves that only the finer sea has; they run east or west, as all do here."""
    low, high = coarse.sea.resolved, fine.sea.resolved
    along, across = high.slope_std_east**2 - low.slope_std_east**2, high.slope_std_north**2 - low.slope_std_north**2
    return UnresolvedWaves((along, across), WAVES_FROM)


def three(case: Case, seed: int) -> dict[str, Simulator]:
    """The coarse mesh without and with shadows of the waves that it lacks, and the fine one."""
    plain, shaded, fine = (Simulator(case.scene(seed, finer)) for finer in (1, 1, FINER))
    shaded.unresolved = between(plain, fine)
    return {"without": plain, "with": shaded, "fine": fine}


def seen(simulator: Simulator) -> Array:
    """Share of the water that both antennas see: of the window between the outer edges by range, then of each ring."""
    light, _, _ = simulator.light(0)
    share = light.visible_to_both if light.in_sight is None else light.visible_to_both * light.in_sight
    mean = share.mean(axis=0, dtype=np.float64)
    ring = np.digitize(light.distance, EDGES_M) - 1
    within = (ring >= 0) & (ring < EDGES_M.size - 1)
    return np.array([mean[within].mean(), *(mean[ring == number].mean() for number in range(EDGES_M.size - 1))])


def shares(name: str, seeds: int) -> dict[str, Array]:
    """`seen` of each of `three`, means over seeds."""
    found = [{key: seen(each) for key, each in three(CASES[name], seed).items()} for seed in range(11, 11 + seeds)]
    return {key: np.mean([each[key] for each in found], axis=0) for key in found[0]}


@dataclass(frozen=True)
class Echoes:
    """What a turn says by cell (look, gate), between the outer edges."""

    power: Array  # W, in the expectation, mean over transmitters and receivers
    mapped: Array  # m, height by the retrieval, with speckle and without noise
    height: Array  # m, true
    visible: Array  # share, true


def echoes(simulator: Simulator) -> Echoes:
    """Those of turn 0."""
    light, returns, _ = simulator.light(0)
    gates = expected_look_gates(light, returns.rcs, simulator.installation, simulator.scene.retrieval.cell_azimuth_deg)
    turn = simulator.turn(0)
    heights = sr.retrieve(turn.echoes)["polar"].to_dataset()["height"].values[0]
    truth = turn.truth["polar"].to_dataset()
    far = (gates.range > EDGES_M[1]) & (gates.range < EDGES_M[-1])
    fields = heights, truth["height"].values[0], truth["visible_fraction"].values[0]
    return Echoes(gates.power.mean(axis=(0, 1))[:, far], *(each[:, far] for each in fields))


def echo_errors(name: str, seeds: int) -> dict[str, Array]:
    """Of the coarse mesh without and with the law: mean and standard deviation [dB] of power over that of the fine mesh
    in cells more than half visible on it, the same in those visible by 0.1 to 0.5, and the rms and mean error of the
    maps' heights [m] in the former; of the fine mesh the latter alone."""
    found: dict[str, list[Array]] = {}
    for seed in range(11, 11 + seeds):
        made = {key: echoes(each) for key, each in three(CASES[name], seed).items()}
        seen = made["fine"].visible
        for key, each in made.items():
            with np.errstate(divide="ignore", invalid="ignore"):
                level = 10.0 * np.log10(each.power / made["fine"].power)
            error = (each.mapped - made["fine"].height)[seen > 0.5]
            error = error[np.isfinite(error)]
            groups = level[seen > 0.5], level[(seen > 0.1) & (seen <= 0.5)]
            powers = [figure for group in groups for figure in (group.mean(), group.std())]
            found.setdefault(key, []).append(np.array([*powers, np.sqrt(np.mean(error**2)), error.mean()]))
    return {key: np.mean(each, axis=0) for key, each in found.items()}


def main() -> None:
    arguments = options(__doc__, seeds=2, echoes=False)
    if arguments.echoes:
        heads = "half visible, dB", "std", "less, dB", "std", "rms, m", "mean, m"
        print(" " * 42 + "".join(f"{each:>18}" for each in heads))
        for name in CASES:
            print(name)
            for key, errors in echo_errors(name, arguments.seeds).items():
                print(f"    {key:38}" + "".join(f"{each:18.3f}" for each in errors), flush=True)
        return
    print(f"{'visible, %':44}{'window':>8}" + "".join(f"{a:6.0f}–{b:<4.0f}" for a, b in pairwise(EDGES_M)))
    for name in CASES:
        print(name)
        for key, share in shares(name, arguments.seeds).items():
            print(f"    {key:38}" + "".join(f"{100.0 * each:10.2f}" for each in share), flush=True)


if __name__ == "__main__":
    main()
