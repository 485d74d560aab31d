"""How accurate a map is: height errors of `choppy_sea`, 50–200 m, cells more than half visible, over seeds.

    python -m validation.retrieval.accuracy [--seeds 3] [--scene choppy_sea]

All three estimators, without noise (the floor that speckle sets) and with the 1 W radar's noise, for VV and HH: a table
for any scene, by its own tracer. More on `choppy_sea`: `python -m validation.retrieval.maps`.
"""

from __future__ import annotations

import argparse

import numpy as np
import xarray as xr

import seamap_rt as sr
from seamap_rt.metrics import HEADLINE_M, error_figures
from seamap_rt.settings import RetrievalSettings
from seamap_rt.simulation import Simulator

CASES = (("VV", False), ("VV", True), ("HH", False), ("HH", True))
ESTIMATORS = ("single_cell", "sliding_plane", "adaptive")
FIELDS = (
    "height_rmse_m",
    "height_robust_m",
    "height_bias_m",
    "height_bias_visible_m",
    "height_correlation",
    "slope_rmse",
    "error_over_std",
    "within_1.96",
)


def error_bars(maps: xr.DataTree, truth: xr.DataTree) -> dict[str, float]:
    """Over the headline's unflagged cells: 1.4826 MAD of error over stated error, and the share within ±1.96."""
    got, true = maps["polar"].to_dataset(), truth["polar"].to_dataset()
    headline = (got["range"] >= HEADLINE_M[0]) & (got["range"] <= HEADLINE_M[1])
    ratio = ((got["height"] - true["height"]) / got["height_std"]).where(headline & (got["quality"] == 0))
    known = ratio.values[np.isfinite(ratio.values)]
    robust = 1.4826 * np.median(np.abs(known - np.median(known)))
    return {"error_over_std": float(robust), "within_1.96": float(np.mean(np.abs(known) < 1.96))}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--scene", default="choppy_sea")
    arguments = parser.parse_args()
    heading = " ".join(f"{name.removeprefix('height_'):>14}" for name in FIELDS)
    print(f"{'case':32} {heading} {'cells':>7}")
    for polarization, noise in CASES:
        results: dict[str, list[dict]] = {estimator: [] for estimator in ESTIMATORS}
        for seed in range(1, arguments.seeds + 1):
            scene = sr.load_scene(
                arguments.scene,
                overrides={"seed": seed, "radar.noise": noise, "scattering.polarization": polarization},
            )
            turn = Simulator(scene).turn(0)
            for estimator in ESTIMATORS:
                settings = RetrievalSettings(**{**scene.retrieval.model_dump(), "estimator": estimator})
                maps = sr.retrieve(turn.echoes, settings)
                results[estimator].append(error_figures(maps, turn.truth)["overall"] | error_bars(maps, turn.truth))
        for estimator, rows in results.items():
            label = f"{polarization} {'with noise' if noise else 'no noise'} {estimator}"
            values = [[row[name] for row in rows] for name in FIELDS]
            shown = " ".join(f"{np.mean(v):7.4f}±{np.std(v):6.4f}" for v in values)
            print(f"{label:32} {shown} {int(np.mean([row['cells'] for row in rows])):7d}", flush=True)


if __name__ == "__main__":
    main()
