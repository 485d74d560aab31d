"""Forecasts against the sea that the maps were made of, on seas and seeds that nothing was tuned on.

    python -m validation.prediction.forecasts [--seeds 6] [--first 301] [--turns 30] [--only choppy] [--own-spectrum]
    python -m validation.prediction.forecasts --draw N [--maps DIR] [--own-spectrum]

Maps of single turns by the horizon tracer, with the 1 W radar's noise, go to a Predictor one by one; from the tenth
turn on each third turn's forecast is compared with the scene's own sea at the boat, 100 m up-wave of it, and at random
places 30–150 m and 150–200 m away at the moment of the forecast, where the turn's truth says that cells are hidden.
Correlation and rms over the sea's standard deviation σ are of all seeds together; `worst` is the least correlation of a
seed; `ratio` is 1.4826 MAD of error over stated error, `within` the share of errors within 1.96 stated ones; `warm`
and `cold` are the wall seconds of a turn's update, the median and the first with all turns at once. With --own-spectrum
the fit is told the scene's own spectrum: what is left then is what those maps cannot tell.

With --draw N twelve seas are drawn instead (`validation.draws`): four crossing, two long, and six others of Tp up to
9 s, 26 turns each, at the boat and four places 40 m off. By sea and lead: rms of what came (`came`), of the error and
of what was stated, over σ; `ratio`, stated over true rms; `skill`, 1 − mean square error over that of what came; the
share within 1.96 stated errors; and by sea the median maximum prediction time. --maps DIR keeps maps and truth there,
and takes those that are there.
"""

from __future__ import annotations

import pickle
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast
from unittest import mock

import numpy as np
import xarray as xr
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.physics.dispersion import Water
from seamap_rt.prediction import Predictor, Spectrum, WaveField, reconstruction
from seamap_rt.prediction.forecast import maximum_prediction_time
from seamap_rt.scene import Scene
from seamap_rt.sea.systems import directional_density, spectral_system
from seamap_rt.settings import RandomWaves
from seamap_rt.simulation import Simulator

from ..draws import drawn, in_words
from ..options import options
from ..retrieval.seas import system

Field = NDArray[np.float64]

FIRST, EACH = 9, 3  # turns before the first forecast, and from one to the next
LEADS = {"now": (0, 0), "1–4 s": (1, 4), "5–10 s": (5, 10), "11–20 s": (11, 20), "21–30 s": (21, 30)}
PLACES = {"boat": (0.0, 0.0), "100 m up-wave": (-100.0, 0.0)}
SEAS: dict[str, dict[str, Any]] = {
    "choppy_sea": {},
    "choppy_sea, sharp crests": {"sea.model": "choppy"},
    "Hs 2.5 m, Tp 8 s": {"sea.waves": [system(2.5, 8.0)]},
    "Hs 2.5 m, Tp 8 s, sharp crests": {"sea.waves": [system(2.5, 8.0)], "sea.model": "choppy"},
    "swell 1.5 m 10 s across wind sea 1 m 5 s": {"sea.waves": [system(1.5, 10.0, 180.0, 30.0), system(1.0, 5.0)]},
}


@dataclass
class Compared:
    """Forecast, stated error and truth of one kind of place, over σ; lists of arrays (lead,) or (place,)."""

    mean: list[Field] = field(default_factory=list)
    std: list[Field] = field(default_factory=list)
    truth: list[Field] = field(default_factory=list)

    def add(self, wave_field: WaveField, sea: Any, sigma: float, x: Field, y: Field, moment: Field) -> None:
        mean, std = wave_field.elevation(x, y, moment)
        self.mean.append(mean / sigma)
        self.std.append(std / sigma)
        self.truth.append(sea.elevation(x, y, moment) / sigma)

    def figures(self, part: slice = slice(None)) -> dict[str, float]:
        """Of some leads, or of all places."""
        mean, std, truth = (np.concatenate([row[part] for row in rows]) for rows in (self.mean, self.std, self.truth))
        away = (truth - mean) / std
        return {
            "corr": float(np.corrcoef(mean, truth)[0, 1]),
            "rms": float(np.sqrt(np.mean((mean - truth) ** 2))),
            "stated": float(np.sqrt(np.mean(std**2))),
            "ratio": 1.4826 * float(np.median(np.abs(away))),
            "within": float(np.mean(np.abs(away) < 1.96)),
        }


def scene_of(name: str, seed: int, turns: int, **more: Any) -> Scene:
    """One of SEAS, by the horizon tracer."""
    return sr.load_scene("choppy_sea", SEAS[name] | {"seed": seed, "turns": turns, "tracing.tracer": "horizon"} | more)


@dataclass(frozen=True)
class Mapped:
    """One turn's polar map, and the truth in its cells."""

    polar: xr.Dataset
    truth: xr.Dataset


def mapped(simulator: Simulator) -> Iterator[Mapped]:
    """The scene's turns, simulated and retrieved."""
    for number in range(simulator.scene.turns):
        turn = simulator.turn(number)
        polar = sr.retrieve(turn.echoes, simulator.scene.resolved_retrieval)["polar"].to_dataset().isel(turn=0)
        yield Mapped(polar, turn.truth["polar"].to_dataset().isel(turn=0))


def run(scene: Scene, turns: int = 10) -> tuple[dict[str, Compared], list[float], float]:
    """What one seed gives: the comparisons, seconds of each warm update, and the sharpness found."""
    simulator, predictor = Simulator(scene), Predictor(turns)
    sigma = np.sqrt(sum(each["significant_wave_height_m"] ** 2 for each in _systems(scene))) / 4.0
    compared, seconds = followed(mapped(simulator), simulator.sea, sigma, predictor, scene.seed)
    return compared, seconds, predictor.sharpness


def followed(
    turns: Iterable[Mapped],
    sea: Any,
    sigma: float,
    predictor: Predictor,
    seed: int,
    places: Mapping[str, tuple[float, float]] = PLACES,
) -> tuple[dict[str, Compared], list[float]]:
    """What a predictor makes of some turns of a sea of a standard deviation [m]: the comparisons, and seconds of each
    warm update. seed: of the hidden places that are looked at."""
    stream = np.random.default_rng(seed)
    compared = {name: Compared() for name in (*places, "hidden 30–150 m", "hidden 150–200 m")}
    seconds: list[float] = []
    lead = np.arange(0.0, LEADS["21–30 s"][1] + 1.0)
    for number, turn in enumerate(turns):
        begin = time.perf_counter()
        wave_field = predictor.turn(turn.polar)
        seconds.append(time.perf_counter() - begin)
        if wave_field is None or number < FIRST or (number - FIRST) % EACH:
            continue
        for name, (x, y) in places.items():
            at = np.full(lead.size, x), np.full(lead.size, y)
            compared[name].add(wave_field, sea, sigma, *at, wave_field.issued + lead)
        for name, ends in (("hidden 30–150 m", (30.0, 150.0)), ("hidden 150–200 m", (150.0, 200.0))):
            compared[name].add(wave_field, sea, sigma, *_hidden(turn.truth, ends, wave_field.issued, stream))
    return compared, seconds[FIRST + 1 :]


AROUND = np.array([(0.0, 0.0), (40.0, 0.0), (-40.0, 0.0), (0.0, 40.0), (0.0, -40.0)])  # m from the boat
DRAWN_TURNS, LONGEST_TP_S = 26, 9.0


def scenes_drawn(number: int) -> list[Scene]:
    """Four crossing seas, two long ones, and six others of waves of up to 9 s."""
    others = [
        scene
        for scene in drawn(number, "seas", 40, turns=DRAWN_TURNS)
        if max(each["peak_period_s"] for each in _systems(scene)) <= LONGEST_TP_S
    ]
    crossing, long = (drawn(number, kind, count, turns=DRAWN_TURNS) for kind, count in (("crossing", 4), ("long", 2)))
    return [*crossing, *long, *others[:6]]


@dataclass(frozen=True)
class Run:
    """A scene's polar maps, and its sea [m] (place, moment) AROUND the boat at the moments [s] of forecasts."""

    maps: list[xr.Dataset]
    moment: Field
    sea: Field

    @classmethod
    def of(cls, scene: Scene, folder: Path | None) -> Run:
        """Simulated, or as a folder keeps it from before."""
        path = folder / f"{scene.name}.pkl" if folder else None
        if path and path.exists():
            return cls(*pickle.loads(path.read_bytes()))
        simulator = Simulator(scene)
        maps = [turn.polar.load() for turn in mapped(simulator)]
        issued = [float(each["time"].max()) for each in maps[FIRST::EACH]]
        moment = np.asarray(np.unique(np.round(np.add.outer(issued, np.arange(31.0)), 3)), np.float64)
        places = [(np.full(moment.size, x), np.full(moment.size, y)) for x, y in AROUND]
        sea = np.stack([simulator.sea.elevation(x, y, moment) for x, y in places])
        if path:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(pickle.dumps((maps, moment, sea)))
        return cls(maps, moment, sea)


def forecasts_of(scene: Scene, ran: Run, told: bool) -> tuple[Field, Field, Field, Field]:
    """Forecast, stated error and what came over σ (issue, place, lead), maximum prediction times [s] (issue, place)."""
    sigma = np.sqrt(sum(each["significant_wave_height_m"] ** 2 for each in _systems(scene))) / 4.0
    predictor, lead, rows, longest = Predictor(), np.arange(31.0), [], []
    with own_spectrum_known(scene) if told else nullcontext():
        for number, polar in enumerate(ran.maps):
            made = predictor.turn(polar)
            if made is None or number < FIRST or (number - FIRST) % EACH:
                continue
            x, y, moment = np.broadcast_arrays(*AROUND.T[:, :, None], made.issued + lead)
            mean, std = made.elevation(x, y, moment)
            came = ran.sea[:, np.searchsorted(ran.moment, moment[0] - 0.01)]
            rows.append(np.stack((mean, std, came)) / sigma)
            longest.append(maximum_prediction_time(lead, std.T, made.sea_std))
    if not rows:
        return np.array([]), np.array([]), np.array([]), np.array([])
    return (*np.stack(rows, axis=1), np.array(longest))


def report_drawn(number: int, folder: Path | None, told: bool) -> None:
    """The table of a number's twelve seas, and its summary."""
    scenes = scenes_drawn(number)
    all_rows: dict[str, dict[str, dict[str, float]]] = {lead: {} for lead in LEADS}
    ten: dict[str, float] = {}
    for scene in scenes:
        mean, std, came, longest = forecasts_of(scene, Run.of(scene, folder), told)
        if not mean.size:
            print(f"{scene.name}: {in_words(scene)}\n  no turn shows a sea", flush=True)
            continue
        print(f"{scene.name}: {in_words(scene)}\n  maximum prediction time {np.median(longest):.1f} s", flush=True)
        print(f"  {'lead':8}   came    rms stated  ratio  skill  within")
        ten[scene.name] = float(1.0 - np.mean((mean - came)[:, :, 10] ** 2) / np.mean(came[:, :, 10] ** 2))
        for lead, (first, last) in LEADS.items():
            a, b, c = (each[:, :, first : last + 1] for each in (mean, std, came))
            row = {
                name: float(np.sqrt(np.mean(each**2))) for name, each in (("came", c), ("rms", a - c), ("stated", b))
            }
            row |= {"ratio": row["stated"] / row["rms"], "skill": 1.0 - (row["rms"] / row["came"]) ** 2}
            row["within"] = float(np.mean(np.abs(a - c) < 1.96 * b))
            all_rows[lead][scene.name] = row
            print(f"  {lead:8}" + "".join(f"{value:7.2f}" for value in row.values()), flush=True)
    print("\n**all twelve**\n\n| lead | rms | stated | ratio | by sea | least skill | within |\n" + "|---" * 7 + "|")
    for lead, rows in all_rows.items():
        rms, stated = (np.sqrt(np.mean([row[name] ** 2 for row in rows.values()])) for name in ("rms", "stated"))
        ratio, skill, within = ([row[name] for row in rows.values()] for name in ("ratio", "skill", "within"))
        print(
            f"| {lead} | {rms:.2f} | {stated:.2f} | {stated / rms:.2f} | {min(ratio):.2f}–{max(ratio):.2f} "
            f"| {min(skill):.2f} | {np.mean(within):.0%} |"
        )
    print()
    crossing = [f"{skill:.2f}" for name, skill in ten.items() if name.startswith("crossing")]
    print(f"crossing seas at 10 s: skill {', '.join(crossing)}")


def run_told(scene: Scene) -> tuple[dict[str, Compared], list[float], float]:
    """`run` with the scene's own spectrum in place of that of its maps."""
    with own_spectrum_known(scene):
        return run(scene)


def own_spectrum_known(scene: Scene) -> AbstractContextManager[object]:
    """Predictors take the scene's own spectrum in place of that of its maps."""
    return mock.patch.object(reconstruction, "spectrum_of_turns", lambda _, water, *__: own_spectrum(scene, water))


def own_spectrum(scene: Scene, water: Water) -> Spectrum:
    """The spectrum that a scene's sea is drawn from."""
    k, toward = Spectrum.even(water)
    hertz, comes_from = water.frequency(k) / (2.0 * np.pi), np.degrees(toward) + 180.0
    systems = [spectral_system(cast("RandomWaves", waves), water.depth) for waves in scene.sea.waves]
    density = sum(directional_density(each, hertz, comes_from, water.depth) for each in systems)
    per_wavevector = np.degrees(1.0) * water.group_speed(k) / (2.0 * np.pi * k)  # of 1/(Hz · degree)
    return Spectrum(k, toward, density * per_wavevector[:, None], water)


def _hidden(
    truth: xr.Dataset, ends: tuple[float, float], moment: float, stream: np.random.Generator
) -> tuple[Field, Field, Field]:
    """Sixty cells that the turn did not see."""
    ranges = truth["range"].values
    dark = (truth["visible_fraction"].values < 0.05) & (ranges > ends[0]) & (ranges < ends[1])
    look, gate = np.nonzero(dark)
    chosen = stream.choice(look.size, min(60, look.size), replace=False)
    east, north = unit_from_azimuth(truth["azimuth"].values[look[chosen]])
    out = ranges[gate[chosen]]
    return out * east, out * north, np.full(out.size, moment)


def _systems(scene: Scene) -> list[dict[str, Any]]:
    return [waves.model_dump() for waves in scene.sea.waves]


def joined(parts: list[Compared]) -> Compared:
    """Of several seeds."""
    return Compared(*([row for part in parts for row in getattr(part, name)] for name in ("mean", "std", "truth")))


def _line(name: str, figures: dict[str, float], worst: float | None = None) -> str:
    least = "" if worst is None else f"{worst:.3f}"
    shown = f"{figures['corr']:.3f} | {least} | {figures['rms']:.3f} | {figures['stated']:.3f}"
    return f"| {name} | {shown} | {figures['ratio']:.2f} | {figures['within']:.1%} |"


def main() -> None:
    given = options(__doc__, seeds=6, first=301, turns=30, only="", own_spectrum=False, draw=int, maps=Path)
    if given.draw is not None:
        report_drawn(given.draw, given.maps, given.own_spectrum)
        return
    for name in SEAS:
        if given.only not in name:
            continue
        scenes = [scene_of(name, given.first + n, given.turns) for n in range(given.seeds)]
        rows = [run_told(scene) if given.own_spectrum else run(scene) for scene in scenes]
        warm = float(np.median(np.concatenate([seconds for _, seconds, _ in rows])))
        sharp = ", ".join(f"{each:.2f}" for *_, each in rows)
        print(f"**{name}**\n\n| | correlation | worst | rms | stated | ratio | within 1.96 |\n" + "|---" * 7 + "|")
        for place in rows[0][0]:
            parts = [compared[place] for compared, *_ in rows]
            if place.startswith("hidden"):
                print(_line(place, joined(parts).figures()), flush=True)
                continue
            for lead, (first, last) in LEADS.items():
                part = slice(first, last + 1)
                worst = min(each.figures(part)["corr"] for each in parts)
                print(_line(f"{place}, {lead}", joined(parts).figures(part), worst), flush=True)
        print(f"\n{name}: warm update {warm:.2f} s; sharpness {sharp}\n", flush=True)


if __name__ == "__main__":
    main()
