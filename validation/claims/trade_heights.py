"""What a taller mast gains: fully measured radius against antenna height, for three seas and two baselines.

    python -m validation.claims.trade_heights [--seeds 3] [--judge] [--out runs/trade_heights] [--resume]

Significant wave heights of 0.7, 1.4 and 2.8 m, all as steep as choppy_sea's and with the wind scaled alike, so that
they are one sea at three scales; antennas 0.2 and 0.9 m apart (the phase of two ways then comes round every 0.075 R and
0.017 R of height at range R: 7.5 and 1.7 m at 100 m). Whole turns, one a point; light by the horizon. --judge: of more
seeds, bands and recommendations by three are held against those of the others. Copy this file for a trade of your own.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr

import seamap_rt as sr
from seamap_rt.report import style
from seamap_rt.studies.choices import choice_in_words, headline
from seamap_rt.studies.paired import choose, means
from seamap_rt.studies.sweep import write_trade
from seamap_rt.studies.trade_figures import draw_pareto, draw_trade

from .. import FIGURES
from ..options import options

WAVE_HEIGHT = "sea.waves.0.significant_wave_height_m"
CHOICES = {"radar.height_m": [3.0, 5.0, 7.0, 10.0, 14.0, 20.0], "radar.baseline_m": [0.2, 0.9]}


def scene(wave_height_m: float) -> sr.Scene:
    """choppy_sea at another scale: lengths by its wave height, times and winds by the root of that."""
    scale = math.sqrt(wave_height_m / 1.4)
    keys = {
        WAVE_HEIGHT: wave_height_m,
        "sea.waves.0.peak_period_s": 5.5 * scale,
        "scattering.wind_speed_m_s": 8.0 * scale,
        "tracing.tracer": "horizon",
    }
    return sr.load_scene("choppy_sea", overrides=keys)


def workers_against_time(out: Path) -> None:
    """Wall time of the same eight points by one worker and by two, their start included."""
    for workers in (1, 2):
        start = time.perf_counter()
        write_trade(
            scene(1.4), out / f"by_{workers}", {"radar.height_m": [5.0, 10.0]}, 4, workers=workers, overwrite=True
        )
        print(f"8 points by {workers} worker{'s' * (workers > 1)}: {time.perf_counter() - start:.1f} s")


def judged(table: xr.Dataset, taken: int = 3, draws: int = 400) -> Iterator[str]:
    """What `taken` seeds say of what all others say: width and coverage of bands, and how often they choose alike.

    The others' mean is itself uncertain: the band of the difference is wider by √(1 + taken/others).
    """
    stream, radius = np.random.default_rng(1), table["fully_measured_radius_m"].dropna("seed")
    covered, halves, alike, sure = [], [], [], []
    for _ in range(draws):
        order = stream.permutation(radius.sizes["seed"])
        some, rest = radius.isel(seed=order[:taken]), radius.isel(seed=order[taken:])
        band = means(some)
        half = 0.5 * (band["high"] - band["low"])
        wider = np.sqrt(1.0 + taken / rest.sizes["seed"])
        covered.append(float((abs(band["mean"] - rest.mean("seed")) < wider * half).mean()))
        halves.append(half.values.ravel())
        for height, baseline in product(radius[WAVE_HEIGHT].values, radius["radar.baseline_m"].values):
            at = {WAVE_HEIGHT: height, "radar.baseline_m": baseline}
            mine, theirs = (choose(each.sel(at), "radar.height_m") for each in (some, rest))
            assert mine is not None
            assert theirs is not None
            alike.append(mine.value == theirs.value)
            sure.append(mine.confidence)
    width = np.concatenate(halves)
    yield f"{radius.sizes['seed']} seeds, {draws} draws of {taken}: half bands {np.median(width):.1f} m in the median, "
    yield f"90 % within {np.quantile(width, 0.9):.1f} m, at most {width.max():.1f} m; coverage {np.mean(covered):.1%}"
    yield f"choice as by the other seeds: {np.mean(alike):.1%}; stated confidence {np.mean(sure):.1%}"
    for height, baseline in product(radius[WAVE_HEIGHT].values, radius["radar.baseline_m"].values):
        choice = choose(radius.sel({WAVE_HEIGHT: height, "radar.baseline_m": baseline}), "radar.height_m")
        assert choice is not None
        yield f"  Hs {height:g} m, baseline {baseline:g} m, all seeds: {choice_in_words(choice)}"


def main() -> None:
    arguments = options(__doc__, seeds=3, out=Path("runs/trade_heights"), judge=False, resume=False)
    tables: list[xr.Dataset] = []
    start = time.perf_counter()
    for height in (0.7, 1.4, 2.8):
        vary = {WAVE_HEIGHT: [height], **CHOICES}
        folder = arguments.out / f"{height:g}"
        made = write_trade(scene(height), folder, vary, arguments.seeds, resume=arguments.resume)
        print(f"Hs {height:g} m: " + "; ".join(made.lines), flush=True)
        tables.append(made.table)
    print(f"all {sum(table['status'].size for table in tables)} points: {time.perf_counter() - start:.0f} s")
    table = xr.concat(tables, WAVE_HEIGHT, join="outer", combine_attrs="override")
    print(means(table["fully_measured_radius_m"])["mean"].to_series().unstack("radar.height_m").to_string())
    print("\n".join(headline(table)))
    print("\n| sea, baseline | lowest mast within 5 % of the best, m | fully measured radius, m | surely, % |")
    print("|---|---|---|---|")
    for height, baseline in product(table[WAVE_HEIGHT].values, table["radar.baseline_m"].values):
        of_one = table["fully_measured_radius_m"].sel({WAVE_HEIGHT: height, "radar.baseline_m": baseline})
        choice = choose(of_one.dropna("seed"), "radar.height_m")
        assert choice is not None
        radius = float(of_one.sel({"radar.height_m": choice.value}).mean())
        name = f"Hs {height:g} m, baseline {baseline:g} m"
        print(f"| {name} | {choice.value:g} | {radius:.0f} | {100.0 * choice.confidence:.0f} |")
    print()
    if arguments.judge:
        for line in judged(table):
            print(line)
        return
    (FIGURES / "trade_heights.png").write_bytes(style.png(draw_trade(table)))
    (FIGURES / "trade_pareto.png").write_bytes(style.png(draw_pareto(table)))
    workers_against_time(arguments.out)


if __name__ == "__main__":
    main()
