"""How accurate the maps are, how reliable their error bars, and how close the maps come to the lowest possible error.

    python -m validation.retrieval.maps [--seeds 5] [--only accuracy,floor,errorbars,slopes,ambiguity] [--out DIR]

Prints tables (Markdown rows) and draws `retrieval_accuracy.png` and `retrieval_errorbars.png`. Scenes are traced by the
`horizon` tracer; five seeds take about 10 min on two cores, 5 of them for `accuracy`, and 6 GB.

  accuracy   choppy_sea, VV and HH, without and with the 1 W radar's noise: the three estimators, and the best of all
             fixed windows, chosen for each case with the truth known
  floor      errors by range beside those of the same estimator that is given the truth (floor.py)
  errorbars  errors over stated errors, by SNR and by the visible share of a cell
  slopes     errors by range beside the slopes themselves
  ambiguity  wide baselines: cells on a wrong cycle, and how many of them are flagged (ambiguity.py)
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.estimators import sliding_plane
from seamap_rt.interferometry.looks import Looks, interferogram
from seamap_rt.metrics import HALF_VISIBLE, HEADLINE_M, error_figures
from seamap_rt.scene import Scene
from seamap_rt.settings import RetrievalSettings
from seamap_rt.simulation import Simulator, Turn

from .. import FIGURES
from . import ambiguity as retrieval_ambiguity
from . import figures as retrieval_figures
from .cells import (
    BINS_M,
    CASES,
    LEAST_CELLS,
    Case,
    between,
    by_range,
    cells_of,
    classes,
    heading,
    held,
    judged,
    name_of,
    rms,
    robust,
    row,
)
from .floor import floors, law_of

SECTIONS = ("accuracy", "floor", "errorbars", "slopes", "ambiguity")
ESTIMATORS = ("adaptive", "sliding_plane", "single_cell")
WINDOWS_M, WINDOWS_DEG = (3.0, 4.5, 6.0, 9.0), (1.8, 2.7, 3.6, 5.4)


def scene_of(case: Case, seed: int) -> Scene:
    polarization, noise = case
    changes = {"seed": seed, "radar.noise": noise, "scattering.polarization": polarization}
    return sr.load_scene("choppy_sea", {**changes, "tracing.tracer": "horizon"})


# ------------------------------------------------------------------------------------------------- one turn


Window = tuple[str, float, float]  # paths, m, deg


def window_errors(turn: Turn, maps: xr.DataTree, settings: RetrievalSettings) -> Iterator[tuple[Window, NDArray]]:
    """Squared errors of each fixed window and of the map, summed over the cells that both answer, and their number."""
    got, true = (each["polar"].isel(turn=0).to_dataset() for each in (maps, turn.truth))
    truth, ranges = true["height"].values, got["range"].values
    clear = (got["quality"].values & QUALITY_FLAGS["ambiguous"]) == 0
    counting = clear & np.isfinite(got["height"].values) & (true["visible_fraction"].values > HALF_VISIBLE)
    counting &= (ranges >= HEADLINE_M[0]) & (ranges <= HEADLINE_M[1])
    radar = RadarDescription.of(turn.echoes)
    for paths in ("best", "one_way"):
        given, _ = interferogram(Looks.of(turn.echoes, radar, settings.model_copy(update={"paths": paths})))
        for long, wide in product(WINDOWS_M, WINDOWS_DEG):
            window_settings = given.settings.model_copy(update={"window_range_m": long, "window_azimuth_deg": wide})
            estimate = sliding_plane(replace(given, settings=window_settings))
            both = counting & estimate.echoing & ~estimate.ambiguous & np.isfinite(estimate.heights.height)
            errors = (estimate.heights.height - truth)[both], (got["height"].values - truth)[both]
            sums = np.array([*(np.sum(error**2) for error in errors), errors[0].size])
            yield (paths, long, wide), sums


# ------------------------------------------------------------------------------------------------- all turns


class Results:
    """TurnAccumulator turn by turn: cells of the default map, and what `accuracy` needs of the others."""

    def __init__(self, sections: set[str], seeds: int) -> None:
        self.cells: dict[Case, dict[str, NDArray]] = {}
        self.overall: dict[tuple[Case, str], list[dict]] = defaultdict(list)
        self.windows: dict[Case, dict[Window, NDArray]] = defaultdict(lambda: defaultdict(lambda: np.zeros(3)))
        pieces: dict[Case, list[dict[str, NDArray]]] = defaultdict(list)
        for seed, polarization in product(range(1, seeds + 1), ("VV", "HH")):
            law = law_of(scene_of((polarization, False), seed)) if "floor" in sections else None
            for case in ((polarization, False), (polarization, True)):
                scene = scene_of(case, seed)
                turn = Simulator(scene).turn(0)
                maps = sr.retrieve(turn.echoes)
                height = turn.truth["polar"].to_dataset()["height"].values[0]
                stated = {} if law is None else floors(scene, turn.echoes, height, law, seed)
                pieces[case].append(cells_of(maps, turn.truth, stated))
                if "accuracy" in sections:
                    self._accuracy(case, turn, maps, scene.retrieval)
        for case, each in pieces.items():
            self.cells[case] = {name: np.concatenate([part[name] for part in each]) for name in each[0]}

    def _accuracy(self, case: Case, turn: Turn, maps: xr.DataTree, settings: RetrievalSettings) -> None:
        for estimator in ESTIMATORS:
            estimator_settings = settings.model_copy(update={"estimator": estimator})
            estimate = maps if estimator == settings.estimator else sr.retrieve(turn.echoes, estimator_settings)
            self.overall[case, estimator].append(error_figures(estimate, turn.truth)["overall"])
        for window, sums in window_errors(turn, maps, settings):
            self.windows[case][window] += sums


# ------------------------------------------------------------------------------------------------- tables


def accuracy(results: Results) -> None:
    names = ("rmse_m", "robust_m", "bias_m", "correlation")
    title = "Heights, 50–200 m, cells more than half visible: mean and spread over seeds"
    heading(title, "case", "estimator", *names, "cells")
    for case, estimator in product(CASES, ESTIMATORS):
        rows = results.overall[case, estimator]
        values = [[each[f"height_{name}"] for each in rows] for name in names]
        shown = [f"{np.mean(value):.4f} ± {np.std(value):.4f}" for value in values]
        row(name_of(case), estimator, *shown, round(np.mean([each["cells"] for each in rows])))
    title = "The best fixed window of each case, over all seeds, on cells that both answer"
    heading(title, "case", "paths", "m", "deg", "rmse_m", "adaptive", "better by", "default window")
    for case in CASES:
        windows = results.windows[case]
        best = min(windows, key=lambda window: windows[window][0] / windows[window][1])
        fixed, adaptive, number = windows[best]
        default = windows["best", 4.5, 2.7]
        errors = [f"{np.sqrt(total / number):.4f}" for total in (fixed, adaptive)]
        gain = f"{1.0 - np.sqrt(adaptive / fixed):.1%}"
        row(name_of(case), *best, *errors, gain, f"{np.sqrt(default[0] / default[2]):.4f}")


def floor(results: Results) -> None:
    for case in CASES:
        cells = results.cells[case]
        names = (
            "robust",
            "known",
            "drawn",
            "over known",
            "over drawn",
            "rms",
            "known",
            "drawn",
            "over known",
            "over drawn",
        )
        heading(f"Errors [m] by range beside the floor, {name_of(case)}", "range m", "cells", *names)
        estimate = [
            [by_range(cells, measure, name) for name in ("error", "known", "drawn")] for measure in (robust, rms)
        ]
        for n, edges in enumerate(pairwise(BINS_M)):
            shown = []
            for error, stated, drawn in np.array(estimate)[:, :, n]:
                shown += [f"{value:.4f}" for value in (error, stated, drawn)]
                shown += [f"{error / stated:.2f}", f"{error / drawn:.2f}"]
            if np.isfinite(estimate[0][0][n]):
                row(f"{edges[0]}–{edges[1]}", np.count_nonzero(judged(cells) & between(cells, *edges)), *shown)


def errorbars(results: Results) -> None:
    heading("Errors over stated errors, unflagged cells", "class", *(f"{name_of(c)}: MAD, ±1.96, cells" for c in CASES))
    tables = {case: dict(classes(cells)) for case, cells in results.cells.items()}
    for name in tables[CASES[0]]:
        shown = []
        for case in CASES:
            chosen, cells = tables[case][name], results.cells[case]
            spread, share = held((cells["error"] / cells["std"])[chosen]) if chosen.any() else (np.nan, np.nan)
            few = np.count_nonzero(chosen) < LEAST_CELLS
            shown.append("–" if few else f"{spread:.2f}, {share:.1%}, {np.count_nonzero(chosen)}")
        row(name, *shown)


def slopes(results: Results) -> None:
    for case in CASES:
        cells = results.cells[case]
        names = ("outward rms", "robust", "true rms", "clockwise rms", "robust", "true rms")
        heading(f"Errors of slopes by range, {name_of(case)}", "range m", "cells", *names)
        for edges in pairwise(BINS_M):
            shown, some = [], judged(cells) & between(cells, *edges)
            for name in ("outward", "clockwise"):
                good = some & np.isfinite(cells[f"{name}_error"])
                if np.count_nonzero(good) >= LEAST_CELLS:
                    error = cells[f"{name}_error"][good]
                    shown += [f"{value:.4f}" for value in (rms(error), robust(error), rms(cells[name][good]))]
            if shown:
                row(f"{edges[0]}–{edges[1]}", np.count_nonzero(some), *shown)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--only", default=",".join(SECTIONS), help="sections, with commas between them")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder of the figures")
    arguments = parser.parse_args()
    sections = set(arguments.only.split(","))
    if unknown := sections - set(SECTIONS):
        parser.error(f"--only = {','.join(sorted(unknown))}: must be of {','.join(SECTIONS)}")
    tables = {"accuracy": accuracy, "floor": floor, "errorbars": errorbars, "slopes": slopes}
    if sections & set(tables):
        results = Results(sections, arguments.seeds)
        for name in SECTIONS[: len(tables)]:
            if name in sections:
                tables[name](results)
        if {"floor", "slopes"} <= sections:
            retrieval_figures.accuracy(results.cells, arguments.out / "retrieval_accuracy.png")
        if "errorbars" in sections:
            retrieval_figures.errorbars(results.cells, arguments.out / "retrieval_errorbars.png")
    if "ambiguity" in sections:
        retrieval_ambiguity.main(arguments.seeds)


if __name__ == "__main__":
    main()
