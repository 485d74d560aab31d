"""What the beam's sides cost the maps' heights when they are left out, beside what the sum over facets expects of that.

python -m validation.radar.truncation [--reach 1.25,1.5,1.75,2,2.5]

The same facets with the same speckle, without noise, once with the beam's table as far as it goes (±3.5 beam widths)
and once with zeros beyond each reach. Prints the rms and the robust (1.4826 MAD) change of the heights of cells more
than half visible, in mm, by range; √p σ, the law for a single sample; and the rms error of both maps against the sea.
A cell is the mean of some ten samples that do not depend on each other, so about a third of √p σ is to be expected.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.echoes import turn as summing
from seamap_rt.echoes.response import TwoWayBeams, share_aside, two_way_beams
from seamap_rt.interferometry import retrieve_one
from seamap_rt.metrics import HALF_VISIBLE
from seamap_rt.radar.array import antenna_array
from seamap_rt.settings import RadarSettings
from seamap_rt.simulation import Simulator
from validation.radar.height_change import RANGES_M, change_by_range

CASES = (
    ("choppy_sea", {}),
    ("choppy_sea", {"radar.height_m": 15.0}),
    ("choppy_sea", {"sea.waves.0.significant_wave_height_m": 2.8, "sea.waves.0.peak_period_s": 8.0}),
    ("wide_baseline", {}),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--reach", default="1.25,1.5,1.75,2,2.5", help="beam widths to either side")
    arguments = parser.parse_args()
    bins = " | ".join(f"{near:.0f}–{far:.0f} m" for near, far in RANGES_M)
    print(f"| scene | ± beam widths | √p σ, mm | {bins} | rms error, mm (whole) |")
    print("|---" * (4 + len(RANGES_M)) + "|")
    for name, changes in CASES:
        quiet = {"tracing.tracer": "horizon", "radar.noise": False}
        simulator = Simulator(sr.load_scene(name, overrides=quiet | changes))
        whole, error = _heights(simulator, None)
        sigma = simulator.sea.resolved.elevation_std
        said = ", ".join((name, *(f"{key.split('.')[-1]} = {value:g}" for key, value in changes.items())))
        for beams in map(float, arguments.reach.split(",")):
            heights, cut_error = _heights(simulator, beams)
            share = float(share_aside(simulator.installation.radar, [beams])[0])
            cells = change_by_range(simulator.installation.radar, heights - whole, 1)
            law = 1e3 * np.sqrt(share) * sigma
            print(
                f"| {said} | {beams:g} | {law:.1f} | {cells} | {1e3 * cut_error:.1f} ({1e3 * error:.1f}) |", flush=True
            )


def _heights(simulator: Simulator, beams: float | None) -> tuple[NDArray[np.float64], float]:
    """Heights (look, gate) of cells more than half visible, and the rms error of the headline's cells."""

    def cut(radar: RadarSettings) -> TwoWayBeams:
        made = two_way_beams(radar)
        entries = made.tables.shape[-1]
        aside = np.abs(np.arcsin((np.arange(entries) - 0.5 * (entries - 1)) / made.scale))
        heard = aside <= np.inf if beams is None else aside <= np.radians(beams * antenna_array(radar).beam_deg)
        return replace(made, tables=made.tables * heard)

    summing.two_way_beams, share = cut, summing.beam_truncation
    summing.beam_truncation = lambda *_: 3.0  # pyright: ignore[reportAttributeAccessIssue]
    try:
        turn = simulator.turn(0)
    finally:
        summing.two_way_beams, summing.beam_truncation = two_way_beams, share
    maps = retrieve_one(turn.echoes, simulator.scene.resolved_retrieval)
    cells = maps["polar"].to_dataset().isel(turn=0)
    heights = np.where(cells["visible_share"].values > HALF_VISIBLE, cells["height"].values, np.nan)
    return heights, float(sr.compare(maps, turn.truth)["overall_height_rmse_m"])


if __name__ == "__main__":
    main()
