"""What power that is left out of the echoes costs the maps' heights, beside what its law expects.

    python -m validation.radar.neglected_power [--of sides,nodes]

sides: the same facets with the same speckle, without noise, once with the beam's table as far as it goes (±3.5 beam
widths) and once with zeros beyond each reach, beside √p σ for a single sample (`echoes.response`) and the rms error of
both maps against the sea. A cell is the mean of some ten independent samples: a third of √p σ is to be expected.

nodes: the same facets of a turn whose speckle never changes, once with every pulse summed and once with the slow-time
nodes that each height error allowed asks for (`echoes.slow_time`), with the share of the power that the law says is
missed and that which is; the beam's sides are summed as far as they go.

By range: rms and robust (1.4826 MAD) change of the heights of cells more than half visible, in mm.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.echoes import turn as summing
from seamap_rt.echoes.response import TwoWayBeams, share_aside, truncation_share, two_way_beams
from seamap_rt.echoes.slow_time import Nodes, choose_nodes
from seamap_rt.interferometry import retrieve_one
from seamap_rt.metrics import HALF_VISIBLE
from seamap_rt.radar.array import antenna_array
from seamap_rt.radar.scan import BEAMS_BEYOND
from seamap_rt.settings import RadarSettings
from seamap_rt.simulation import Simulator

from ..options import options

BEAMS = (1.25, 1.5, 1.75, 2.0, 2.5)  # widths to either side
ALLOWED_M = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2)  # height errors
RANGES_M = ((50.0, 100.0), (100.0, 200.0), (200.0, 400.0))


def change_by_range(radar: RadarSettings, change: NDArray[np.float64], digits: int) -> str:
    """Cells of a table: rms and 1.4826 MAD [mm] of a change (look, gate) [m] of heights, by range."""
    ranges = radar.range_m[0] + radar.range_sampling_m * np.arange(change.shape[1])
    cells = []
    for near, far in RANGES_M:
        some = change[:, (ranges >= near) & (ranges < far)]
        some = some[np.isfinite(some)]
        rms, robust = 1e3 * np.sqrt(np.mean(some**2)), 1482.6 * np.median(np.abs(some))
        cells.append(f"{rms:.{digits}f}, {robust:.{digits}f}")
    return " | ".join(cells)


CASES = (
    ("choppy_sea", {}),
    ("choppy_sea", {"radar.height_m": 15.0}),
    ("choppy_sea", {"sea.waves.0.significant_wave_height_m": 2.8, "sea.waves.0.peak_period_s": 8.0}),
    ("wide_baseline", {}),
)


def sides() -> None:
    bins = " | ".join(f"{near:.0f}–{far:.0f} m" for near, far in RANGES_M)
    print(f"| scene | ± beam widths | √p σ, mm | {bins} | rms error, mm (whole) |")
    print("|---" * (4 + len(RANGES_M)) + "|")
    for name, changes in CASES:
        quiet = {"tracing.tracer": "horizon", "radar.noise": False}
        simulator = Simulator(sr.load_scene(name, overrides=quiet | changes))
        whole, error = _without_sides(simulator, None)
        sigma = simulator.sea.resolved.elevation_std
        said = ", ".join((name, *(f"{key.split('.')[-1]} = {value:g}" for key, value in changes.items())))
        for beams in BEAMS:
            heights, cut_error = _without_sides(simulator, beams)
            share = float(share_aside(simulator.installation.radar, [beams])[0])
            cells = change_by_range(simulator.installation.radar, heights - whole, 1)
            law = 1e3 * np.sqrt(share) * sigma
            print(
                f"| {said} | {beams:g} | {law:.1f} | {cells} | {1e3 * cut_error:.1f} ({1e3 * error:.1f}) |", flush=True
            )


def _without_sides(simulator: Simulator, beams: float | None) -> tuple[NDArray[np.float64], float]:
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
    return _heights(maps), float(sr.compare(maps, turn.truth)["overall_height_rmse_m"])


def nodes() -> None:
    bins = " | ".join(f"{near:.0f}–{far:.0f} m" for near, far in RANGES_M)
    print(f"| scene | height error, m | pulses a node, taps | said | missed | √p σ, mm | {bins}, mm |")
    print("|---" * (6 + len(RANGES_M)) + "|")
    for name, changes in (CASES[0], *CASES[2:]):
        quiet = {"tracing.tracer": "horizon", "radar.noise": False, "scattering.doppler": "orbital"}
        still = {"scattering.decorrelation_time_s": np.inf}
        simulator = Simulator(sr.load_scene(name, overrides=quiet | still | changes))
        sigma, kept = simulator.sea.resolved.elevation_std, list[Nodes]()
        voltage, heights = _turn(simulator, _every_pulse)
        said = ", ".join((name, *(f"{key.split('.')[-1]} = {value:g}" for key, value in changes.items())))
        for allowed in ALLOWED_M:
            share = truncation_share(sigma, allowed)
            found, moved = _turn(simulator, partial(_noted, kept, share))
            chosen = kept[-1]
            missed = float(np.nanmean(np.abs(found - voltage) ** 2) / np.nanmean(np.abs(voltage) ** 2))
            cells = change_by_range(simulator.installation.radar, moved - heights, 2)
            shape = f"{chosen.stride}, {chosen.weights.shape[1]}"
            law = 1e3 * np.sqrt(chosen.missed) * sigma
            print(
                f"| {said} | {allowed:g} | {shape} | {chosen.missed:.1e} | {missed:.1e} | {law:.2f} | {cells} |",
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
    return voltage, _heights(retrieve_one(turn.echoes, simulator.scene.resolved_retrieval))


def _heights(maps: xr.DataTree) -> NDArray[np.float64]:
    """(look, gate) of cells more than half visible."""
    cells = maps["polar"].to_dataset().isel(turn=0)
    return np.where(cells["visible_share"].values > HALF_VISIBLE, cells["height"].values, np.nan)


def main() -> None:
    chosen = options(__doc__, of="sides,nodes").of.split(",")
    for study in (sides, nodes):
        if study.__name__ in chosen:
            study()


if __name__ == "__main__":
    main()
