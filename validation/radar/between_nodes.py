"""What the pulses between slow-time nodes cost, beside what the law of `echoes.slow_time` expects.

python -m validation.radar.between_nodes [--height-errors 0.005,0.01,0.02,0.05,0.1,0.2]

The same facets of a turn without noise, whose speckle never changes, once with every pulse summed and once with the
nodes that each height error allowed asks for; the mesh stays. Prints nodes and taps, the share of the power that the
law says is missed and that which is, √p σ, and the change of the heights of cells more than half visible, rms and
robust (1.4826 MAD), by range. The beam's sides are summed as far as they go: its cut is another share.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.echoes import turn as summing
from seamap_rt.echoes.response import truncation_share
from seamap_rt.echoes.slow_time import Nodes, choose_nodes
from seamap_rt.interferometry import retrieve_one
from seamap_rt.metrics import HALF_VISIBLE
from seamap_rt.radar.scan import BEAMS_BEYOND
from seamap_rt.simulation import Simulator
from validation.radar.height_change import RANGES_M, change_by_range

CASES = (
    ("choppy_sea", {}),
    ("choppy_sea", {"sea.waves.0.significant_wave_height_m": 2.8, "sea.waves.0.peak_period_s": 8.0}),
    ("wide_baseline", {}),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--height-errors", default="0.005,0.01,0.02,0.05,0.1,0.2", help="m")
    arguments = parser.parse_args()
    bins = " | ".join(f"{near:.0f}–{far:.0f} m" for near, far in RANGES_M)
    print(f"| scene | height error, m | pulses a node, taps | said | missed | √p σ, mm | {bins}, mm |")
    print("|---" * (6 + len(RANGES_M)) + "|")
    for name, changes in CASES:
        quiet = {"tracing.tracer": "horizon", "radar.noise": False, "scattering.doppler": "orbital"}
        still = {"scattering.decorrelation_time_s": np.inf}
        simulator = Simulator(sr.load_scene(name, overrides=quiet | still | changes))
        sigma, kept = simulator.sea.resolved.elevation_std, list[Nodes]()
        voltage, heights = _turn(simulator, _every_pulse)
        said = ", ".join((name, *(f"{key.split('.')[-1]} = {value:g}" for key, value in changes.items())))
        for allowed in map(float, arguments.height_errors.split(",")):
            share = truncation_share(sigma, allowed)

            found, moved = _turn(simulator, partial(_noted, kept, share))
            nodes = kept[-1]
            missed = float(np.nanmean(np.abs(found - voltage) ** 2) / np.nanmean(np.abs(voltage) ** 2))
            cells = change_by_range(simulator.installation.radar, moved - heights, 2)
            shape = f"{nodes.stride}, {nodes.weights.shape[1]}"
            law = 1e3 * np.sqrt(nodes.missed) * sigma
            print(
                f"| {said} | {allowed:g} | {shape} | {nodes.missed:.1e} | {missed:.1e} | {law:.2f} | {cells} |",
                flush=True,
            )


def _noted(kept: list[Nodes], share: float, *known: Any) -> Nodes:
    kept.append(choose_nodes(*known[:6], neglected=share))
    return kept[-1]


def _every_pulse(*known: Any) -> Nodes:
    nodes = choose_nodes(*known[:6])
    pulses, alone = known[2], np.ones((1, 1), np.float32)
    return Nodes(1, 0, pulses.time.size, nodes.spacing_s / nodes.stride, pulses.time, alone, 0.0)


def _turn(simulator: Simulator, nodes: Callable[..., Nodes]) -> tuple[NDArray[np.complex64], NDArray[np.float64]]:
    """Voltages, and heights (look, gate) of cells more than half visible."""
    truncation, summing.choose_nodes = summing.beam_truncation, nodes
    summing.beam_truncation = lambda *_: BEAMS_BEYOND  # pyright: ignore[reportAttributeAccessIssue]
    try:
        turn = simulator.turn(0)
    finally:
        summing.choose_nodes, summing.beam_truncation = choose_nodes, truncation
    voltage = turn.echoes["voltage"].values
    maps = retrieve_one(turn.echoes, simulator.scene.resolved_retrieval)
    cells = maps["polar"].to_dataset().isel(turn=0)
    return voltage, np.where(cells["visible_share"].values > HALF_VISIBLE, cells["height"].values, np.nan)


if __name__ == "__main__":
    main()
