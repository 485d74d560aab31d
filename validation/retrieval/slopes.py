"""Slopes and their error bars against the true mean slopes of the cells, by range, on shipped and on drawn scenes.

    python -m validation.retrieval.slopes [--draw N] [--count 12] [--of seas,radars]

One turn each, by the horizon tracer; of unflagged cells, outward and clockwise: rms of the error, of the stated
one, 1.4826 MAD of error over stated error, and share of errors within 1.96 of them. The truth is a cell's mean slope
over all its facets, lit or not (`truth/polar`), not that of the plane that was fitted. `ground`: the same of the square
cells' slopes towards east and north, where the centre's polar cell has no flag.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import xarray as xr

import seamap_rt as sr
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator

from ..draws import drawn, in_words
from ..options import options
from .cells import LEAST_CELLS, rms, robust

BANDS_M = ((15.0, 25.0), (25.0, 50.0), (50.0, 200.0))
SHIPPED = ("choppy_sea", "wind_and_swell", "rough_ride", "long_crested_swell", "magnetron_pair")
WHERE = (("outward", "slope_range"), ("clockwise", "slope_azimuth"))

Figures = dict[tuple[str, str], tuple[float, float, float, float]]


def figures(maps: xr.DataTree, truth: xr.DataTree) -> Figures:
    """(band, direction) → rms error, rms stated error, robust spread of error over stated error, share within 1.96."""
    got, true = (each["polar"].to_dataset().isel(turn=0) for each in (maps, truth))
    clear, made = got["quality"].values == 0, {}
    for label, name in WHERE:
        for band in BANDS_M:
            add(made, band, label, got, true, name, clear & _within(got["range"].values, band))
    ground, sea = (each["ground"].to_dataset().isel(turn=0) for each in (maps, truth))
    x, y = np.meshgrid(ground["x"].values, ground["y"].values)
    away, bearing = np.hypot(x, y), np.degrees(np.arctan2(x, y)) % 360.0
    mast = float(got.attrs["height_m"])
    gate = np.abs(np.hypot(away, mast)[..., None] - got["range"].values).argmin(axis=-1)
    apart = np.abs((bearing[..., None] - got["azimuth"].values + 180.0) % 360.0 - 180.0)
    unflagged = clear[apart.argmin(axis=-1), gate]
    for name in ("slope_x", "slope_y"):
        add(made, BANDS_M[2], f"ground {name[-1]}", ground, sea, name, unflagged & _within(away, BANDS_M[2]))
    return made


def add(
    made: Figures, band: tuple[float, float], label: str, got: xr.Dataset, true: xr.Dataset, name: str, some: np.ndarray
) -> None:
    error, stated = (got[name] - true[name]).values.astype(np.float64), got[f"{name}_std"].values.astype(np.float64)
    some = some & np.isfinite(error) & (stated > 0.0)
    if np.count_nonzero(some) >= LEAST_CELLS:
        ratio = (error / np.where(stated > 0.0, stated, 1.0))[some]
        within = float(np.mean(np.abs(ratio) < 1.96))
        made[f"{band[0]:.0f}–{band[1]:.0f} m", label] = rms(error[some]), rms(stated[some]), robust(ratio), within


def _within(away: np.ndarray, band: tuple[float, float]) -> np.ndarray:
    return (away >= band[0]) & (away < band[1])


def judged(scene: Scene) -> Figures:
    turn = Simulator(scene).turn(0)
    return figures(sr.retrieve(turn.echoes), turn.truth)


def main() -> None:
    arguments = options(__doc__, draw=int, count=12, of="seas,radars")
    if arguments.draw is None:
        scenes = [sr.load_scene(name, {"tracing.tracer": "horizon"}) for name in SHIPPED]
    else:
        scenes = [each for kind in arguments.of.split(",") for each in drawn(arguments.draw, kind, arguments.count)]
    whole = defaultdict(list)
    for scene in scenes:
        found = judged(scene)
        print(f"\n{scene.name}" + ("" if arguments.draw is None else f": {in_words(scene)}"))
        for key, each in found.items():
            whole[key].append(each)
            print(f"  {key[0]:9} {key[1]:9} {_row(each)}", flush=True)
    print("\n**median over scenes**\n\n| slope, range | rms | stated | ratio | least, most | in 0.9–1.1 | within |")
    print("|---" * 7 + "|")
    for (band, kind), each in whole.items():
        rms, stated, ratio, within = np.median(each, axis=0)
        ratios = [every for _, _, every, _ in each]
        held = sum(0.9 <= every <= 1.1 for every in ratios)
        cells = f"{rms:.4f} | {stated:.4f} | {ratio:.2f} | {min(ratios):.2f}, {max(ratios):.2f}"
        print(f"| {kind}, {band} | {cells} | {held} of {len(each)} | {within:.0%} |")


def _row(each: np.ndarray | tuple[float, ...]) -> str:
    return f"rms {each[0]:.4f}, stated {each[1]:.4f}, ratio {each[2]:.2f}, within {100.0 * each[3]:.0f} %"


if __name__ == "__main__":
    main()
