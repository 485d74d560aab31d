"""Speed against the error of the decision: which mast, how far it sees and how far it measures, by cheaper settings.

python -m validation.speed.decisions [--scene choppy_sea] [--seeds 4] [--first 961] [--heights 3,5,7,10,14,20]

Each row is a trade of antenna heights over the same seas with other settings: mesh, tracer, turns. The first, with the
finest mesh, is the judge. By row: the mast that is recommended and how sure that is; at the second height the fully
measured radius and the reach, and the range to which half of the water is visible to light, VV and HH: the difference
from the judge's in per cent, ± the half band (95 %) of the seeds' paired differences; processor seconds of a point.
"same": the mast is the judge's and every difference is below 2 %, its band included. "differs": another mast, or a
difference beyond 2 % with all of its band. "open": these seeds do not tell. The last rows take fewer seeds of the
default settings: their scatter from sea to sea is what settings have to be held against.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import xarray as xr
from scipy.special import stdtrit

import seamap_rt as sr
from seamap_rt.studies import trade
from seamap_rt.studies.paired import choose

from ..options import options

KEY = "radar.height_m"
SETTINGS: dict[str, dict[str, Any]] = {
    "rays, 0.4 m × 6 columns, judge": {"tracing.facet_m": 0.4, "tracing.columns_per_beam": 6},
    "rays, as shipped": {},
    "rays, 1.6 m × 4": {"tracing.facet_m": 1.6, "tracing.columns_per_beam": 4},
    "rays, 3 m × 3": {"tracing.facet_m": 3.0, "tracing.columns_per_beam": 3},
    "horizon, as shipped": {"tracing.tracer": "horizon"},
    "horizon, 1.6 m × 4": {"tracing.tracer": "horizon", "tracing.facet_m": 1.6, "tracing.columns_per_beam": 4},
    "horizon, 3 m × 3": {"tracing.tracer": "horizon", "tracing.facet_m": 3.0, "tracing.columns_per_beam": 3},
    "horizon, sea of 1.6 m": {"tracing.tracer": "horizon", "sea.resolution_m": 1.6},
    "horizon, four turns": {"tracing.tracer": "horizon", "turns": 4},
}
FIGURES = {
    "fully_measured_radius_m": "radius",
    "reach_m": "reach",
    "half_visible_m": "half, light",
    "half_visible_vv_m": "half, VV",
    "half_visible_hh_m": "half, HH",
}
SAME = 2.0  # per cent


def half_band(values: np.ndarray) -> float:
    """95 %, of the mean of paired differences (seed,)."""
    if values.size < 2:
        return np.nan
    return float(stdtrit(values.size - 1, 0.975) * values.std(ddof=1) / np.sqrt(values.size))


def row(name: str, table: xr.Dataset, judge: xr.Dataset, seconds: float) -> str:
    """Of one trade beside the judge's."""
    mast, of_judge = (choose(each["fully_measured_radius_m"], KEY) for each in (table, judge))
    assert mast is not None
    assert of_judge is not None
    cells, least, most = [], 0.0, 0.0
    for figure in FIGURES:
        mine, other = (each[figure].isel({KEY: 1}).values for each in (table, judge.sel(seed=table["seed"])))
        apart = 100.0 * (mine - other) / other.mean()
        band = half_band(apart)
        least = max(least, float(abs(apart.mean()) - np.nan_to_num(band)))
        most = max(most, float(abs(apart.mean()) + np.nan_to_num(band)))
        cells.append(f"{apart.mean():+.1f} ± {band:.1f}")
    sure = "" if np.isnan(mast.confidence) else f" ({mast.confidence:.0%})"
    changed = mast.value != of_judge.value or least > SAME
    answer = "differs" if changed else "same" if most <= SAME else "open"
    return " | ".join([name, f"{mast.value:g} m{sure}", *cells, f"{seconds:.2f}", answer])


def main() -> None:
    given = options(__doc__, scene="choppy_sea", seeds=4, first=961, heights="3,5,7,10,14,20")
    vary = {KEY: [float(each) for each in given.heights.split(",")]}
    scene = sr.load_scene(given.scene, {"seed": given.first})
    trade(scene, {KEY: vary[KEY][:1]}, 1, workers=0)  # compiles and calibrates
    print("| settings | mast | " + " | ".join(f"{each} (%)" for each in FIGURES.values()) + " | s a point | answer |")
    print("|---" * (4 + len(FIGURES)) + "|")
    tables: dict[str, xr.Dataset] = {}
    for name, keys in SETTINGS.items():
        begin = time.process_time()
        tables[name] = trade(sr.load_scene(given.scene, {"seed": given.first, **keys}), vary, given.seeds, workers=0)
        seconds = (time.process_time() - begin) / (given.seeds * len(vary[KEY]))
        judge = next(iter(tables.values()))
        print(f"| {row(name, tables[name], judge, seconds)} |", flush=True)
    judge, shipped = tables[next(iter(SETTINGS))], tables["rays, as shipped"]
    at_second = {figure: judge[figure].isel({KEY: 1}).mean().item() for figure in FIGURES}
    print(f"\njudge at {vary[KEY][1]:g} m: " + ", ".join(f"{FIGURES[k]} {v:.0f} m" for k, v in at_second.items()))
    scatter = {
        figure: 100.0 * (each := shipped[figure].isel({KEY: 1})).std("seed", ddof=1).item() / each.mean().item()
        for figure in FIGURES
    }
    print("scatter from sea to sea (%): " + ", ".join(f"{FIGURES[k]} {v:.1f}" for k, v in scatter.items()))
    for count in (1, 2):
        chosen = [
            choose(shipped["fully_measured_radius_m"].isel(seed=slice(first, first + count)), KEY)
            for first in range(0, given.seeds - count + 1, count)
        ]
        masts = ", ".join(f"{each.value:g}" for each in chosen if each)
        print(f"masts by {count} seed{'s' * (count > 1)} each: {masts} m")


if __name__ == "__main__":
    main()
