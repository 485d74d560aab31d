"""Error bars by range: heights' errors over stated ones on shipped scenes with waves, short waves, and drawn scenes.

    python -m validation.retrieval.bars [--draw 500] [--seeds 2] [--only wide]

The drawn scenes (validation.draws, kind "radars") have radar, mast, sea and seed of their own. One turn a seed, to
210 m, by the horizon tracer. Of unflagged cells: 1.4826 MAD of error over stated error (median of the seeds), share
within 1.96 of their bars, rms. At the end: how many scenes lie within 0.9–1.1 and 93–97 %.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np

import seamap_rt as sr
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator

from ..draws import drawn
from ..options import options

BANDS = (15.0, 25.0), (25.0, 50.0), (50.0, 200.0)  # m
FARTHEST_M = 210.0
FEWEST = 30  # cells
SHIPPED = (
    "calm",
    "choppy_sea",
    "harbour",
    "long_crested_swell",
    "magnetron_pair",
    "pier",
    "sinusoid",
    "solid_state_chirp",
    "tiny",
    "wide_baseline",
    "wind_and_swell",
)  # rough_ride states its motion sensors' errors


SHORT = {  # seas of waves shorter than a map holds: seed; height, period, mast, baseline, wind, polarization
    "short waves, 2 s": (7701, (0.15, 2.0, 8.0, 0.4, 3.0, "VV")),
    "short waves, 2.4 s": (7702, (0.25, 2.4, 3.0, 0.15, 5.0, "VV")),
    "short waves, 2.1 s": (7703, (0.2, 2.1, 6.0, 0.3, 5.0, "HH")),
}
KEYS = (
    "sea.waves.0.significant_wave_height_m",
    "sea.waves.0.peak_period_s",
    "radar.height_m",
    "radar.baseline_m",
    "scattering.wind_speed_m_s",
    "scattering.polarization",
)


def scenes(number: int, seeds: int) -> Iterator[tuple[str, list[Scene]]]:
    """Name and scenes, one a seed."""
    for name in SHIPPED:
        near, far = sr.load_scene(name).radar.range_m
        changes = {"turns": 1, "tracing.tracer": "horizon", "radar.range_m": [near, min(far, FARTHEST_M)]}
        yield name, [sr.load_scene(name, overrides={**changes, "seed": seed}) for seed in range(1, seeds + 1)]
    same = {"turns": 1, "tracing.tracer": "horizon", "sea.resolution_m": 0.4, "sea.extent_m": 512.0}
    for name, (first, values) in SHORT.items():
        keys = dict(zip(KEYS, values, strict=True))
        changes = same | keys | {"radar.range_m": [15.0, FARTHEST_M]}
        yield name, [sr.load_scene("choppy_sea", changes | {"seed": first + n}) for n in range(seeds)]
    for scene in drawn(number, "radars", 12):
        yield scene.name, [scene.model_copy(update={"seed": scene.seed + n}) for n in range(seeds)]


def by_range(scene: Scene) -> np.ndarray:
    """(band, figure): ratio, share within, mean square error [m²]; NaN of fewer cells than FEWEST."""
    turn = Simulator(scene).turn(0)
    got = sr.retrieve(turn.echoes)["polar"].to_dataset().isel(turn=0)
    error = got["height"].values - turn.truth["polar"].to_dataset()["height"].values[0]
    figures = np.full((len(BANDS), 3), np.nan)
    for row, (low, high) in zip(figures, BANDS, strict=True):
        inside = (got["range"].values >= low) & (got["range"].values <= high)
        cells = inside & np.isfinite(error) & (got["quality"].values == 0)
        if np.count_nonzero(cells) >= FEWEST:
            ratio = (error / got["height_std"].values)[cells]
            robust = 1.4826 * np.median(np.abs(ratio - np.median(ratio)))
            row[:] = robust, np.mean(np.abs(ratio) < 1.96), np.mean(error[cells] ** 2)
    return figures


def main() -> None:
    arguments = options(__doc__, draw=100, seeds=2, only="")
    bands = [f"{low:g}–{high:g} m" for low, high in BANDS]
    print("**error over bar, share within, rms**\n")
    print(f"| scene | {' | '.join(bands)} |\n" + "|---" * (1 + len(BANDS)) + "|")
    good = np.zeros((len(BANDS), 4), dtype=int)
    for name, each in scenes(arguments.draw, arguments.seeds):
        if arguments.only not in name:
            continue
        turns = np.stack([by_range(scene) for scene in each])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of bands without cells
            ratio = np.nanmedian(turns[..., 0], axis=0)
            within, square = np.nanmean(turns[..., 1:], axis=0).T
        fits, covers = (ratio > 0.895) & (ratio < 1.105), (within > 0.925) & (within < 0.975)
        good += np.stack((np.isfinite(ratio), fits, covers, fits & covers), axis=1)
        cells = [
            f"{each:.2f}, {share:.1%}, {rms:.3f} m" if np.isfinite(each) else "–"
            for each, share, rms in zip(ratio, within, np.sqrt(square), strict=True)
        ]
        print(f"| {name} | {' | '.join(cells)} |", flush=True)
    print("\n**how many scenes: known, ratio and share as asked**\n\n|  | known | ratio | within | both |")
    print("|---" * 5 + "|")
    for band, counts in zip(bands, good, strict=True):
        print(f"| {band} | {' | '.join(str(each) for each in counts)} |")


if __name__ == "__main__":
    main()
