"""Heights and error bars on fourteen seas that nothing was tuned on, masts of 3 to 20 m, baselines of 0.1 to 0.9 m, and
on another radar.

    python -m validation.retrieval.seas [--seeds 3] [--only "wind 0.7 m"] [--no-floor]

One turn each, 50–200 m, with the 1 W radar's noise, by the horizon tracer. Of unflagged cells: 1.4826 MAD of error over
stated error (the median of the seeds, least and most), and the share of errors within 1.96 of their error bars; rms,
correlation, and slope of retrieved on true heights. `lost`: share of the cells more than half visible that have no
height or an ambiguous one. `floor`: rms that the same estimator leaves on the same echoes where the sea's covariance,
each cell's coherence and the cycles are known (validation.retrieval.floor), over the cells that both answer; only of
maps of both ways, which from the highest masts are blurred near by.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

import seamap_rt as sr
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.metrics import HALF_VISIBLE, HEADLINE_M
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator

from ..options import options
from .floor import floors, law_of


def system(height: float, period: float, toward: float = 270.0, exponent: float = 10.0, peak: float = 3.3) -> dict:
    """A JONSWAP system of Hs [m] and Tp [s] from a direction [deg], of cos^2s spreading."""
    return {
        "spectrum": "jonswap",
        "significant_wave_height_m": height,
        "peak_period_s": period,
        "peak_enhancement": peak,
        "wave_from_deg": toward,
        "spreading": "cos2s",
        "spreading_exponent": exponent,
    }


@dataclass(frozen=True)
class Case:
    name: str
    waves: list[dict]
    polarization: str
    mast: float  # m
    baseline: float  # m
    radar: Mapping[str, Any] = field(default_factory=dict)  # keys of another radar

    def scene(self, seed: int, **more: Any) -> Scene:
        """Of choppy_sea's radar otherwise."""
        changes = {
            "seed": seed,
            "sea.waves": self.waves,
            "sea.extent_m": 1024.0,
            "scattering.polarization": self.polarization,
            "radar.height_m": self.mast,
            "radar.baseline_m": self.baseline,
            "radar.range_m": [max(15.0, self.mast + 5.0), 210.0],
            "tracing.tracer": "horizon",
        }
        return sr.load_scene("choppy_sea", overrides={**changes, **self.radar, **more})


WIDER_PULSE = {
    "radar.pulse_width_s": 25e-9,
    "radar.bandwidth_hz": 40e6,
    "radar.antenna.azimuth_beamwidth_deg": 1.4,
    "radar.antenna.width_m": 1.3,
    "radar.rotation_rpm": 42.0,
    "radar.transmit_power_w": 2.0,
}


CASES = (
    Case("wind 0.3 m 3.2 s", [system(0.3, 3.2)], "VV", 6.0, 0.3),
    Case("wind 0.5 m 4.5 s", [system(0.5, 4.5, 120.0)], "HH", 10.0, 0.4),
    Case("wind 0.7 m 4 s", [system(0.7, 4.0)], "VV", 8.0, 0.35),
    Case("wind 0.7 m 4 s", [system(0.7, 4.0)], "HH", 8.0, 0.35),
    Case("wind 0.9 m 4.8 s", [system(0.9, 4.8, 200.0)], "VV", 4.0, 0.15),
    Case("wind 1.2 m 6 s", [system(1.2, 6.0, 30.0)], "HH", 7.0, 0.3),
    Case("wind 1.6 m 6.5 s, no peak", [system(1.6, 6.5, 330.0, 6.0, 1.0)], "VV", 15.0, 0.6),
    Case("wind 2.2 m 7.5 s", [system(2.2, 7.5, 250.0)], "VV", 10.0, 0.5),
    Case("wind 3 m 9 s", [system(3.0, 9.0, 180.0)], "HH", 16.0, 0.7),
    Case("wind 4 m 11 s", [system(4.0, 11.0, 90.0)], "VV", 20.0, 0.9),
    Case("swell 0.8 m 12 s", [system(0.8, 12.0, 300.0, 60.0)], "VV", 3.0, 0.1),
    Case("swell 1 m 14 s, wind 0.6 m 4 s", [system(1.0, 14.0, 200.0, 60.0), system(0.6, 4.0)], "VV", 8.0, 0.35),
    Case("swell 2 m 12 s, wind 2.5 m 8 s", [system(2.0, 12.0, 200.0, 40.0), system(2.5, 8.0)], "VV", 8.0, 0.35),
    Case(
        "swell 2 m 13 s, 1.5 m 7 s, wind 0.5 m 4 s",
        [system(2.0, 13.0, 320.0, 40.0), system(1.5, 7.0, 270.0), system(0.5, 4.0, 200.0)],
        "HH",
        12.0,
        0.5,
    ),
    Case("another radar: wind 0.9 m 4.4 s", [system(0.9, 4.4, 205.0, 7.0, 2.0)], "VV", 8.3, 0.27, WIDER_PULSE),
    Case(
        "another radar: that with swell 1.2 m 10 s",
        [system(0.9, 4.4, 205.0, 7.0, 2.0), system(1.2, 10.0, 330.0, 30.0, 4.0)],
        "VV",
        8.3,
        0.27,
        WIDER_PULSE,
    ),
    Case("another radar: swell 1.2 m 10 s", [system(1.2, 10.0, 330.0, 30.0, 4.0)], "VV", 8.3, 0.27, WIDER_PULSE),
)


def found(case: Case, seed: int, floor: bool = True) -> dict[str, float]:
    """The figures of one turn."""
    scene = case.scene(seed)
    turn = Simulator(scene).turn(0)
    maps = sr.retrieve(turn.echoes)
    figures, answered = against_truth(maps, turn.truth)
    if floor and maps["polar"].attrs["paths"] == 2:
        true = turn.truth["polar"].to_dataset()["height"].values[0]
        known = floors(scene, turn.echoes.load(), true, law_of(scene), seed)["known"]
        figures["floor"] = float(np.sqrt(np.nanmean((known - true)[answered] ** 2)))
    return figures


def against_truth(maps: xr.DataTree, truth: xr.DataTree) -> tuple[dict[str, float], np.ndarray]:
    """The figures of a turn's maps, and which cells (look, gate) they are of."""
    got, true = maps["polar"].to_dataset().isel(turn=0), truth["polar"].to_dataset().isel(turn=0)
    ranges = got["range"].values
    inside = (ranges >= HEADLINE_M[0]) & (ranges <= HEADLINE_M[1])
    height, height_true = got["height"].values.astype(np.float64), true["height"].values.astype(np.float64)
    error, quality = height - height_true, got["quality"].values
    answered = inside & np.isfinite(error)
    cells = answered & (quality == 0)
    visible = inside & (true["visible_fraction"].values > HALF_VISIBLE)
    useful = answered & ((quality & QUALITY_FLAGS["ambiguous"]) == 0)
    ratio = (error / got["height_std"].values)[cells]
    return {
        "ratio": float(1.4826 * np.median(np.abs(ratio - np.median(ratio)))),
        "within": float(np.mean(np.abs(ratio) < 1.96)),
        "hs": float(4.0 * np.std(height_true[cells])),
        "rms": float(np.sqrt(np.mean(error[cells] ** 2))),
        "correlation": float(np.corrcoef(height[cells], height_true[cells])[0, 1]),
        "slope": float(np.polyfit(height_true[cells], height[cells], 1)[0]),
        "lost": float(1.0 - np.mean(useful[visible])),
    }, cells


def main() -> None:
    arguments = options(__doc__, seeds=3, only="", no_floor=False)
    print("**50–200 m, with noise**\n")
    print("| sea | mast, baseline, m | error over bar | within 1.96 | rms | floor | correlation | slope | lost |")
    print("|---" * 9 + "|")
    for case in (each for each in CASES if arguments.only in each.name):
        turns = [found(case, seed, not arguments.no_floor) for seed in range(1, arguments.seeds + 1)]
        ratios = [each["ratio"] for each in turns]
        mean = {name: float(np.mean([each[name] for each in turns])) for name in turns[0]}
        label = f"{case.name}, {case.polarization} | {case.mast:g}, {case.baseline:g}"
        bars = f"{np.median(ratios):.2f} ({min(ratios):.2f}, {max(ratios):.2f}) | {100 * mean['within']:.1f} %"
        heights = " | ".join(f"{mean.get(name, np.nan):.3f}" for name in ("rms", "floor", "correlation"))
        print(f"| {label} | {bars} | {heights} | {mean['slope']:.2f} | {100 * mean['lost']:.1f} % |", flush=True)


if __name__ == "__main__":
    main()
