"""Wide baselines: how many visible cells are on a wrong cycle of phase, and how many of those are flagged.

A cell is wrong if its height is more than half an ambiguity, λR/(2pB), off the truth.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import xarray as xr
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.metrics import HALF_VISIBLE
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator

from .cells import heading, row

MODES = ("alternating_pulse", "single_pulse")  # both ways alone, and both ways beside one
BASELINES_M = (0.9, 1.8)
BANDS_M = ((50.0, 100.0), (100.0, 300.0))


def scene_of(mode: str, baseline_m: float, seed: int) -> Scene:
    changes = {"radar.interferogram": mode, "radar.baseline_m": baseline_m, "radar.transmit": "switched", "seed": seed}
    return sr.load_scene("wide_baseline", {**changes, "tracing.tracer": "horizon"})


def counts(maps: xr.DataTree, truth: xr.DataTree, scene: Scene) -> NDArray[np.int64]:
    """(band, of: visible cells with a height, wrong ones, flagged as ambiguous, unflagged, wrong ones of those)."""
    got, true = (each["polar"].isel(turn=0).to_dataset() for each in (maps, truth))
    ranges, error = got["range"].values, (got["height"] - true["height"].values).values
    ambiguity = SPEED_OF_LIGHT / scene.radar.frequency_hz * ranges / (got.attrs["paths"] * scene.radar.baseline_m)
    wrong = np.abs(error) > 0.5 * ambiguity
    known = np.isfinite(error) & (true["visible_fraction"].values > HALF_VISIBLE)
    quality = got["quality"].values
    kinds = (known, known & wrong, known & ((quality & QUALITY_FLAGS["ambiguous"]) > 0))
    kinds += (known & (quality == 0), known & (quality == 0) & wrong)
    bands = [(ranges >= near) & (ranges < far) for near, far in BANDS_M]
    return np.array([[np.count_nonzero(kind[:, band]) for kind in kinds] for band in bands])


def main(seeds: int) -> None:
    title = "Wide baselines, visible cells: on a wrong cycle, of all and of unflagged ones; flagged as ambiguous"
    names = ("wrong", "of unflagged", "ambiguous")
    bands = [f"{near:.0f}–{far:.0f} m {name}" for near, far in BANDS_M for name in names]
    heading(title, "interferogram", "B m", "ambiguity", "p", *bands)
    for mode, baseline in product(MODES, BASELINES_M):
        totals = {how: np.zeros((len(BANDS_M), 5), dtype=np.int64) for how in ("fold", "resolve")}
        paths = 0
        for seed in range(1, seeds + 1):
            scene = scene_of(mode, baseline, seed)
            turn = Simulator(scene).turn(0)
            for how, total in totals.items():
                maps = sr.retrieve(turn.echoes, {"ambiguity": how})
                total += counts(maps, turn.truth, scene)
                paths = int(maps["polar"].attrs["paths"])
        for how, total in totals.items():
            shown = []
            for cells, wrong, flagged, usable, missed in total:
                shown += [f"{wrong / cells:.2%}", f"{missed / max(usable, 1):.2%}", f"{flagged / cells:.1%}"]
            row(mode, baseline, how, paths, *shown)
