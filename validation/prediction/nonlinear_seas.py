"""Maps, forecasts, shadows and echoes on nonlinear seas, beside linear seas of the same spectrum and seed.

    python -m validation.prediction.nonlinear_seas RECORDS [--seeds 813] [--looking-for WHAT] [--light]

RECORDS: a folder of recorded seas SEED-HS-ORDER/recorded_sea.nc, of Hs 0.944, 1.574 and 2.361 m (Hs/λ 1/50, 1/30 and
1/20 at 5.5 s), of order 3 (nonlinear) and 1 (linear). Those that are not there are made by `seamap-rt sea choppy_sea
--nonlinear`, in four minutes of a core each.

`choppy_sea`'s radar maps each of them by the horizon tracer (half a minute for 30 turns, kept beside the record).
Maps: 50–200 m, all turns; error over error bar is 1.4826 MAD, of unflagged cells. Forecasts: as
`validation.prediction.forecasts` compares them, over the record's standard deviation, at the boat and at eight places
40 m around it together; `found`: the current [m/s] and the share of amplitude dispersion that the fit came to.
--looking-for: for both (the default), for a current alone, or for nothing, whatever new turns say. --light: the range
where half of the sea is in sight, mean echo and texture instead. Mean echo: over 100–200 m, of the theory that is not
scaled to a model, in dB of one unit. Texture: ν of single looks and gates within 30° of along the waves
(`validation.scattering.texture`), 100–200 m.
"""

from __future__ import annotations

import argparse
import pickle
import subprocess
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import seamap_rt as sr
from seamap_rt.conventions import unit_from_azimuth, wrap_degrees
from seamap_rt.metrics import counted_cells, headline_gates
from seamap_rt.prediction import Predictor, WaveField
from seamap_rt.prediction.fit import Fit
from seamap_rt.prediction.innovations import Drift
from seamap_rt.resolved_scene import run_sea
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator

from .forecasts import LEADS, PLACES, Compared, Mapped, followed, joined, mapped

HEIGHTS_M = {"1/50": "0.944", "1/30": "1.574", "1/20": "2.361"}
ORDERS = {"linear": 1, "nonlinear": 3}
AHEAD = ("5–10 s", "11–20 s", "21–30 s")
AROUND_M = 40.0
BIN_M = 25.0
WAVES_FROM_DEG = 270.0
LIT = (0, 10, 20)  # turns, of the echo's mean and texture


def scene_of(record: Path, seed: int, turns: int, **more: Any) -> Scene:
    """`choppy_sea`'s radar on a recorded sea."""
    of_record = {"model": "recorded", "file": str(record.resolve())}  # side, spacing and spectrum are the file's
    return sr.load_scene(
        "choppy_sea", {"sea": of_record, "seed": seed, "turns": turns, "tracing.tracer": "horizon"} | more
    )


def turns_of(folder: Path, scene: Scene) -> list[Mapped]:
    """A scene's turns, simulated once."""
    kept = folder / "turns.pkl"
    made = pickle.loads(kept.read_bytes()) if kept.is_file() else []
    if len(made) != scene.turns:
        made = [Mapped(turn.polar.load(), turn.truth.load()) for turn in mapped(Simulator(scene))]
        kept.write_bytes(pickle.dumps(made))
    return made


class Still(Drift):
    """What is told is believed, whatever new turns say."""

    def learn(self, fit: Fit, number: int) -> bool:
        return False


class Looking(Predictor):
    """A predictor that looks for both, for a `current` alone, or for `nothing`; keeps its last field."""

    def __init__(self, what: str) -> None:
        super().__init__(amplitude_dispersion=None if what == "both" else 0.0)
        self.last: WaveField | None = None
        if what == "nothing":
            self._drift = Still(0.0)

    def turn(self, polar: xr.Dataset) -> WaveField | None:
        self.last = super().turn(polar)
        return self.last


def maps_of(turns: list[Mapped]) -> dict[str, float]:
    """Accuracy of the heights at 50–200 m."""
    error, stated, height, true, sure = [], [], [], [], []
    for turn in turns:
        cells = counted_cells(turn.polar, turn.truth) & headline_gates(turn.polar["range"].values)
        height.append(turn.polar["height"].values[cells].astype(np.float64))
        true.append(turn.truth["height"].values[cells])
        error.append(height[-1] - true[-1])
        stated.append(turn.polar["height_std"].values[cells])
        sure.append(turn.polar["quality"].values[cells] == 0)
    e, s, h, t, ok = (np.concatenate(each) for each in (error, stated, height, true, sure))
    ratio = (e / s)[ok]
    return {
        "rms": float(np.sqrt(np.mean(e**2))),
        "robust": float(1.4826 * np.median(np.abs(e - np.median(e)))),
        "bias": float(e.mean()),
        "corr": float(np.corrcoef(h, t)[0, 1]),
        "ratio": float(1.4826 * np.median(np.abs(ratio - np.median(ratio)))),
        "within": float(np.mean(np.abs(ratio) < 1.96)),
    }


def half_visible(turns: list[Mapped]) -> float:
    """m: where the visible share, of all looks in bins of range, passes a half."""
    share = np.mean([turn.truth["visible_fraction"].values.mean(axis=0) for turn in turns], axis=0)
    number = (turns[0].truth["range"].values / BIN_M).astype(int)
    mean = np.bincount(number, share) / np.maximum(np.bincount(number), 1)
    middle = (np.arange(mean.size) + 0.5) * BIN_M
    last = int(np.flatnonzero(mean >= 0.5)[-1])
    return float(np.interp(0.5, mean[[last + 1, last]], middle[[last + 1, last]]))


def echo(scene: Scene) -> tuple[float, float]:
    """Mean power times range cubed over 100–200 m, and ν of single looks along the waves there."""
    made, weights = [], []
    for turn in LIT:
        power = sr.expected(scene, turn)["power"]
        ranges, levels = power["range"].values, power.values[0, 0]
        gates = (ranges >= 100.0) & (ranges < 200.0)
        levels = levels[:, gates] * ranges[gates] ** 3
        away = wrap_degrees(power["azimuth"].values - WAVES_FROM_DEG)
        along = np.minimum(np.abs(away), 180.0 - np.abs(away)) <= 30.0
        made.append((levels[along] / levels[along].mean(axis=0)).ravel())
        weights.append(levels.mean())
    looks = np.concatenate(made)
    return float(np.mean(weights)), 1.0 / float(np.mean(looks**2) / looks.mean() ** 2 - 1.0)


def forecast_of(turns: list[Mapped], scene: Scene, what: str) -> tuple[dict[str, Compared], tuple[float, float], float]:
    """The comparisons at the boat, up-wave and around the boat, and the current [m/s] and the share that were found."""
    sea, predictor = run_sea(scene), Looking(what)
    side = np.arange(-300.0, 300.0, 3.0)
    x, y = (each.ravel() for each in np.meshgrid(side, side))
    sigma = float(np.std(sea.elevation(x, y, np.full(x.size, 0.5 * scene.turns))))
    ring: dict[str, tuple[float, float]] = {}
    for angle in range(0, 360, 45):
        east, north = unit_from_azimuth(angle)
        ring[f"at {angle}°"] = AROUND_M * float(east), AROUND_M * float(north)
    compared, _ = followed(turns, sea, sigma, predictor, scene.seed, PLACES | ring)
    around = joined([compared["boat"], *(compared[name] for name in ring)])
    assert predictor.last is not None
    spectrum = predictor.last.spectrum
    return compared | {"around": around}, spectrum.water.current, spectrum.amplitude_dispersion


def make_record(folder: Path, height: str, seed: int, order: int) -> None:
    """Write recorded_sea.nc of `choppy_sea` with another height [m] and seed, to an order of steepness."""
    keys = {"sea.waves.0.significant_wave_height_m": height, "seed": seed, "sea.extent_m": 900}
    changed = [word for key, value in keys.items() for word in ("--set", f"{key}={value}")]
    asked = ["choppy_sea", "--nonlinear", "--order", str(order), "--times=-2:66:0.25", "--out", str(folder)]
    command = [sys.executable, "-m", "seamap_rt.cli", "sea", *asked, *changed]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def each_record(given: argparse.Namespace, **more: Any) -> Iterator[tuple[str, int, str, Path, Scene]]:
    """Steepness, seed, kind of sea, folder and scene of each record that is asked for."""
    for steepness, seed, name in product(given.steepness, given.seeds, given.seas):
        folder = given.records / f"{seed}-{HEIGHTS_M[steepness]}-{ORDERS[name]}"
        if not (folder / "recorded_sea.nc").is_file():
            make_record(folder, HEIGHTS_M[steepness], seed, ORDERS[name])
        yield steepness, seed, name, folder, scene_of(folder / "recorded_sea.nc", seed, given.turns, **more)


def print_light(given: argparse.Namespace) -> None:
    print("Hs/λ  seed sea        half visible m   echo dB      ν")
    unscaled = {"scattering.calibrated_to": "none", "radar.noise": False}
    for steepness, seed, name, folder, scene in each_record(given, **unscaled):
        level, shape = echo(scene)
        half = half_visible(turns_of(folder, scene))
        print(f"{steepness:5} {seed} {name:10} {half:13.0f} {10 * np.log10(level):9.2f} {shape:8.2f}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", type=Path)
    parser.add_argument("--seeds", type=int, nargs="+", default=[813])
    parser.add_argument("--steepness", nargs="+", choices=list(HEIGHTS_M), default=list(HEIGHTS_M))
    parser.add_argument("--seas", nargs="+", choices=list(ORDERS), default=list(ORDERS))
    parser.add_argument("--turns", type=int, default=30)
    parser.add_argument("--looking-for", choices=["both", "current", "nothing"], default="both")
    parser.add_argument("--light", action="store_true")
    given = parser.parse_args()
    if given.light:
        print_light(given)
        return
    spans = " | ".join(f"{ahead}: boat; around: correlation, rms, stated, within" for ahead in AHEAD)
    print(f"| Hs/λ, sea, seed | maps: rms, robust, bias (m) | correlation | ratio, within | {spans} | found |")
    print("|---" * (5 + len(AHEAD)) + "|")
    for steepness, seed, name, folder, scene in each_record(given):
        turns = turns_of(folder, scene)
        compared, current, share = forecast_of(turns, scene, given.looking_for)
        found = "{rms:.3f}, {robust:.3f}, {bias:+.3f} | {corr:.3f} | {ratio:.2f}, {within:.1%}".format(**maps_of(turns))
        row = [f"{steepness} {name}, {seed}", found]
        for ahead in AHEAD:
            part = slice(LEADS[ahead][0], LEADS[ahead][1] + 1)
            boat, around = (compared[place].figures(part) for place in ("boat", "around"))
            row.append("{:.3f}; {corr:.3f}, {rms:.3f}, {stated:.3f}, {within:.0%}".format(boat["corr"], **around))
        row.append(f"{np.hypot(*current):.2f} m/s, {share:.2f}")
        print(f"| {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    main()
