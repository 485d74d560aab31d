"""What hidden parts of cells add to a map's errors, by the share that the echo says is in sight.

    python -m validation.retrieval.hidden [--seeds 2]
    python -m validation.retrieval.hidden --draw N [--count 12]

Six wind seas that no other table has, 50–200 m. Of unflagged cells: the share in sight, true and found; how far the
visible part is said to stand above the cell's mean, and by how much heights are too high; error bar and rms error. On
these seas the constants of shadow.py can be judged.

With a number: on seas and radars that it draws, each in VV and in HH, of all cells with a height from 50 to 200 m, what
is said to be in sight less what is: the rms of all cells; and by tenths of what is said the mean over draws of 100 such
cells and more, how many draws those are, and the same of all cells together.
"""

from __future__ import annotations

import numpy as np

import seamap_rt as sr
from seamap_rt.metrics import HEADLINE_M
from seamap_rt.simulation import Simulator

from ..draws import drawn
from ..options import options
from .seas import Case, against_truth, system

SEAS = (
    Case("1 m 5.5 s", [system(1.0, 5.5, 200.0)], "VV", 7.0, 0.35),
    Case("2.8 m 8.5 s", [system(2.8, 8.5, 100.0)], "VV", 12.0, 0.5),
    Case("0.6 m 4.2 s", [system(0.6, 4.2, 30.0)], "HH", 6.0, 0.3),
    Case("1.8 m 7 s and 1.5 m 13 s", [system(1.8, 7.0, 300.0), system(1.5, 13.0, 250.0, 50.0)], "VV", 9.0, 0.4),
    Case("1.4 m 6.3 s", [system(1.4, 6.3)], "HH", 10.0, 0.4),
    Case("0.4 m 3.6 s", [system(0.4, 3.6, 90.0)], "VV", 5.0, 0.25),
)
SHARES = ((0.9, 1.0), (0.75, 0.9), (0.6, 0.75), (0.3, 0.6))
FEWEST = 200  # cells of a row
FEWEST_OF_DRAW = 100


def rows(case: Case, seed: int) -> list[list[float]]:
    """Of each share in sight: cells; share true and found; crest bias said, mean error; error bar, rms error."""
    scene = case.scene(seed)
    turn = Simulator(scene).turn(0)
    maps = sr.retrieve(turn.echoes)
    got, true = maps["polar"].to_dataset().isel(turn=0), turn.truth["polar"].to_dataset().isel(turn=0)
    _, counted = against_truth(maps, turn.truth)
    share, error = got["visible_share"].values, got["height"].values - true["height"].values
    found = []
    for low, high in SHARES:
        those = counted & (share > low) & (share <= high)
        if np.count_nonzero(those) < FEWEST:
            continue
        said = np.mean(got["height_std"].values[those] ** 2)
        found.append(
            [
                np.count_nonzero(those),
                float(true["visible_fraction"].values[those].mean()),
                float(share[those].mean()),
                float(got["crest_bias"].values[those].mean()),
                float(error[those].mean()),
                float(np.sqrt(said)),
                float(np.sqrt(np.mean(error[those] ** 2))),
            ]
        )
    return found


def calibration(number: int, count: int, polarization: str) -> tuple[list[str], str]:
    """Rows of the two tables of drawn scenes."""
    draws: list[list[float]] = [[] for _ in range(10)]
    total, cells, squares = np.zeros(10), np.zeros(10), 0.0
    for kind in ("seas", "radars"):
        for scene in drawn(number, kind, count, scattering__polarization=polarization):
            turn = Simulator(scene).turn(0)
            got, true = (each["polar"].to_dataset().isel(turn=0) for each in (sr.retrieve(turn.echoes), turn.truth))
            share, seen = got["visible_share"].values.astype(float), true["visible_fraction"].values
            known = np.isfinite(share) & np.isfinite(seen) & np.isfinite(got["height"].values)
            known &= (got["range"].values >= HEADLINE_M[0]) & (got["range"].values <= HEADLINE_M[1])
            tenth = np.minimum((10.0 * share[known]).astype(int), 9)
            off = np.bincount(tenth, (share - seen)[known], 10)
            held = np.bincount(tenth, minlength=10)
            total, cells, squares = total + off, cells + held, squares + float(((share - seen)[known] ** 2).sum())
            for n in np.flatnonzero(held >= FEWEST_OF_DRAW):
                draws[n].append(off[n] / held[n])
    tenths = {
        "mean over draws": [f"{np.mean(each) if each else np.nan:+.3f}" for each in draws],
        "draws": [f"{len(each)}" for each in draws],
        "all cells": [f"{a / max(b, 1):+.3f}" for a, b in zip(total, cells, strict=True)],
    }
    said = [f"| {polarization}, {name} | {' | '.join(values)} |" for name, values in tenths.items()]
    return said, f"| {polarization} | {np.sqrt(squares / cells.sum()):.3f} | {cells.sum():.0f} |"


def main() -> None:
    arguments = options(__doc__, seeds=2, draw=int, count=12)
    if arguments.draw is not None:
        found = [calibration(arguments.draw, arguments.count, each) for each in ("VV", "HH")]
        print("**said less true, by tenths of the share said to be in sight**\n")
        print("| said | " + " | ".join(f"{n / 10:.1f}–{(n + 1) / 10:.1f}" for n in range(10)) + " |")
        print("|---" * 11 + "|")
        print("\n".join(row for said, _ in found for row in said))
        print("\n**rms error of a cell's share**\n\n|  | rms | cells |\n|---|---|---|")
        print("\n".join(rms for _, rms in found))
        return
    print(f"{'sea':28} cells  in sight, found  crest bias, mean error  error bar, rms error")
    for case in SEAS:
        for seed in range(21, 21 + arguments.seeds):
            for cells, true, share, bias, mean, bar, rms in rows(case, seed):
                label = f"{case.name} {case.polarization}, {seed}"
                print(f"{label:28} {cells:5.0f}  {true:.2f} {share:.2f}  {bias:.4f} {mean:+.4f}  {bar:.4f} {rms:.4f}")


if __name__ == "__main__":
    main()
