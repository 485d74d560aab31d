"""Maps, forecasts, shadows and echoes on nonlinear seas, beside linear seas of the same spectrum and seed.

    python -m validation.prediction.nonlinear_seas RECORDS [--seeds 801 802] [--turns 30] [--told SHARE]

RECORDS: a folder of recorded seas `<seed>-<Hs>-<order>/recorded_sea.nc`, Hs 0.944, 1.574 and 2.361 m (Hs/λ 1/50, 1/30 and
1/20 at 5.5 s), of order 3 (nonlinear) and 1 (linear), each made by

    seamap-rt sea choppy_sea --nonlinear --order ORDER --set sea.waves.0.significant_wave_height_m=HS --set seed=SEED
        --set sea.extent_m=900 --times=-2:66:0.25 --out RECORDS/SEED-HS-ORDER

(four minutes of a core each). `choppy_sea`'s radar maps each of them for 30 turns by the horizon tracer (a minute; kept
beside the record as turns.pkl). Maps: 50–200 m, cells more than half visible; error over error bar is 1.4826 MAD, of
unflagged cells. Forecasts: as `validation.prediction.forecasts` compares them, at the boat, over the standard deviation
of the record. Light: the range at which half of the sea is in sight, in bins of 25 m; mean power of the echo times range
cubed in dB about the linear sea of the same height; and ν, the shape of single looks' mean power along the waves
(`validation.scattering.texture`), of a speckle-free turn in four. --told: in place of what the predictor finds of the
share of amplitude dispersion, this one.
"""

from __future__ import annotations

import argparse
import pickle
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.metrics import counted_cells, headline_gates
from seamap_rt.prediction import Predictor
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator
from validation.prediction.forecasts import LEADS, Compared, Mapped, followed, joined, mapped

HEIGHTS_M = {"1/50": "0.944", "1/30": "1.574", "1/20": "2.361"}
ORDERS = {"linear": 1, "nonlinear": 3}
AHEAD = ("5–10 s", "11–20 s", "21–30 s")
BIN_M = 25.0


def scene_of(record: Path, seed: int, turns: int) -> Scene:
    """`choppy_sea`'s radar on a recorded sea."""
    of_record = {"model": "recorded", "file": str(record.resolve())}  # side, spacing and spectrum are the file's
    return sr.load_scene(
        "choppy_sea", {"sea": of_record, "seed": seed, "turns": turns, "tracing.tracer": "horizon"}
    )


def turns_of(folder: Path, seed: int, turns: int) -> tuple[list[Mapped], Simulator]:
    """The turns, simulated once, and the simulator whose sea they are of."""
    simulator, kept = Simulator(scene_of(folder / "recorded_sea.nc", seed, turns)), folder / "turns.pkl"
    if kept.is_file():
        made = pickle.loads(kept.read_bytes())
        if len(made) == turns:
            return made, simulator
    made = [Mapped(turn.polar.load(), turn.truth.load()) for turn in mapped(simulator)]
    kept.write_bytes(pickle.dumps(made))
    return made, simulator
