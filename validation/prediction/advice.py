"""Boats that follow the advice, beside boats that hold their course, follow the spectrum alone, or know the sea ahead.

    python -m validation.prediction.advice [--seeds 12] [--first 751] [--minutes 10] [--boats 2] [--runs FILE]
    python -m validation.prediction.advice --radar --first 745 --seeds 4 --minutes 3 [--runs FILE] [--figure FILE]

A boat answers by a first-order lag: heading in 4 s, at most 8° a second, speed in 6 s. It is bound 60° off the waves,
at 4 m/s, and may steer up to 45° to either side and slow down to a half. Each 2 s it is advised for the next 20 s
(`seamap_rt.prediction.advice`), and changes what it does where the advice can be told from going on. Tasks: least roll;
most way within a limit of roll, 2.5 σ of the roll that the spectrum gives on the course that is held.

    hold       bound course at full speed
    spectrum   the same advice where no phase is known, solved once
    advice     of a forecast with errors
    foresight  the same planner, and the sea as it comes

Without --radar seas are of 250 free waves drawn from a spectrum, which repeat nowhere, and forecasts err as the
radar's do: a sea of its own spectrum is added, of a share by wavelength and lead (ERRORS). Orders are obeyed half a
second late. With --radar `choppy_sea`'s radar rides on the boat (heave, roll, pitch and course), turn by turn by the
horizon tracer: maps go to a Predictor, its field to the advice. Sharp crests are those of first-order Lagrangian waves;
the boat's motions are those of the waves whose water it floats on.

The true motions are the vessel's responses at the heading and speed of each moment: linear, and steady from moment to
moment. By task and sea: rms roll, roll's exceedances a minute, way lost against holding on, and what of foresight's
gain each has; 95 % bands by bootstrap over runs, which are paired. --runs keeps each run in a file as it ends, a line
of JSON; runs that are there are reported and not made anew.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

import seamap_rt as sr
from seamap_rt.conventions import unit_from_azimuth, wrap_degrees
from seamap_rt.physics.dispersion import DEEP_WATER
from seamap_rt.prediction import Box, Predictor, Spectrum
from seamap_rt.prediction.advice import advise_on, exceedances
from seamap_rt.prediction.advice_motions import Envelope, Expectation, SeaPrediction, Transfers, Waves
from seamap_rt.prediction.quantity import Course
from seamap_rt.prediction.vessel import Vessel
from seamap_rt.radar.platform import BoatState
from seamap_rt.simulation import Simulator

from ..options import options
from .forecasts import own_spectrum, scene_of

Field = NDArray[np.float64]
Key = tuple[int, str, str, str]  # seed, sea, boat, task

STEP_S, EACH_S, HORIZON_S, DELAY_S = 0.25, 2.0, 20.0, 0.5
FULL_M_S, WAVES_FROM_DEG, OFF_DEG, AWAY_DEG = 4.0, 270.0, 60.0, 45.0
LAG_S, RATE_DEG_S, SPEED_LAG_S = 4.0, 8.0, 6.0
SHARES = (0.5, 0.75, 1.0)  # of the full speed
LIMIT = 2.5  # of roll's standard deviation
LEADS_S = (0.0, 2.5, 7.5, 15.0, 20.0, 25.0)
EDGES_M = (28.0, 16.0, 11.0, 7.5)  # wavelengths between bands, longest first
ERRORS = (  # share of each band's variance that a forecast misses, by lead: `missed` on seed 122 of choppy_sea
    (0.002, 0.002, 0.003, 0.015, 0.037, 0.098),
    (0.007, 0.007, 0.014, 0.046, 0.090, 0.230),
    (0.025, 0.025, 0.045, 0.153, 0.287, 0.510),
    (0.140, 0.145, 0.270, 0.820, 0.930, 0.980),
    (1.000, 1.000, 1.000, 1.000, 1.000, 1.000),
)
WAVES, GROUPS, DRAWS = 250, 100, 16
HELD = 0.98  # of what a lattice's waves give to each motion
BOATS: dict[str, Vessel] = {"7 m": Box(7.0, 2.5, 0.45), "12 m": Box(12.0, 3.8, 0.8, roll_period_s=4.5)}
DRAWN_SEAS = ("choppy_sea", "choppy_sea, sharp crests", "swell 1.5 m 10 s across wind sea 1 m 5 s")
TASKS = ("least_roll", "most_way")
ARMS = ("hold", "spectrum", "advice", "foresight")
RIDE_S = 0.125  # of the track that the radar rides on, and its splines
WARM = 10  # turns before the radar's first advice
BOOTSTRAPS, FEWEST = 2000, 6


@dataclass(frozen=True)
class FreeSea:
    """Waves with amplitudes [m] (wave,) at the origin and time 0; sharp: whose water is where they move it."""

    waves: Waves
    amplitudes: NDArray[np.complex128]
    sharp: bool

    @classmethod
    def drawn(cls, spectrum: Spectrum, seed: int, sharp: bool) -> FreeSea:
        """Of a spectrum, each wave of its own wavevector."""
        stream = np.random.default_rng(seed)
        weights = spectrum.variances.ravel() / spectrum.variance
        ring, way = np.divmod(stream.choice(weights.size, WAVES, p=weights), spectrum.toward.size)
        ratio, step = spectrum.k[1] / spectrum.k[0], spectrum.toward[1] - spectrum.toward[0]
        k = spectrum.k[ring] * ratio ** (stream.random(WAVES) - 0.5)
        toward = spectrum.toward[way] + step * (stream.random(WAVES) - 0.5)
        kx, ky = k * np.sin(toward), k * np.cos(toward)
        parts = stream.standard_normal((2, WAVES)) * np.sqrt(spectrum.variance / WAVES)
        return cls(Waves(kx, ky, spectrum.omega(kx, ky, k)), parts[0] + 1j * parts[1], sharp)

    @classmethod
    def of(cls, sea: Any, sharp: bool, vessel: Vessel, course: Course) -> FreeSea:
        """The waves of a simulated sea that move a vessel on a course: nearly all of its heave, roll and pitch."""
        whole = sea.components()
        met = vessel.response(whole.east, whole.north, whole.omega, course.heading_deg, course.speed_m_s)
        kept = np.zeros(whole.omega.size, bool)
        for share in (met.heave, met.roll, met.pitch):
            power = np.abs(share * whole.amplitude) ** 2
            order = np.argsort(power)[::-1]
            kept[order[: int(np.searchsorted(np.cumsum(power[order]), HELD * power.sum())) + 1]] = True
        return cls(Waves(whole.east[kept], whole.north[kept], whole.omega[kept]), whole.amplitude[kept], sharp)

    def here(self, x: float, y: float, moment: float) -> NDArray[np.complex128]:
        """Amplitudes with the phases of a place and time."""
        turns = self.waves.kx * x + self.waves.ky * y - self.waves.omega * moment
        return self.amplitudes * np.exp(1j * turns)

    def at_home(self, x: float, y: float, moment: float) -> NDArray[np.complex128]:
        """The same, of a sharp sea those of where the water is at home that is at the place."""
        east, north = x, y
        for _ in range(2 if self.sharp else 0):
            orbit = 1j * self.here(east, north, moment) / np.hypot(self.waves.kx, self.waves.ky)
            east = x - float(np.sum(self.waves.kx * orbit).real)
            north = y - float(np.sum(self.waves.ky * orbit).real)
        return self.here(east, north, moment)


def band_of(waves: Waves) -> NDArray[np.intp]:
    """Number (wave,) of the band of ERRORS."""
    return np.searchsorted(2.0 * np.pi / np.array(EDGES_M), np.hypot(waves.kx, waves.ky))


@dataclass
class Boat:
    """A boat under way, by moments; what it is ordered."""

    course: Course
    ordered: Course
    rows: list[tuple[float, float, float, float]] = field(default_factory=lambda: [(0.0, 0.0, 0.0, 0.0)])
    step_s: float = STEP_S

    def __post_init__(self) -> None:
        self.rows = [(0.0, 0.0, self.course.heading_deg, self.course.speed_m_s)]

    @property
    def now(self) -> tuple[float, float, float]:
        """m east, m north, s."""
        return self.rows[-1][0], self.rows[-1][1], (len(self.rows) - 1) * self.step_s

    def run(self, until: float) -> None:
        """Goes on as it is ordered."""
        while self.now[2] < until - 1e-6:
            x, y, heading, speed = self.rows[-1]
            rate = wrap_degrees(self.ordered.heading_deg - heading) / LAG_S
            heading += float(np.clip(rate, -RATE_DEG_S, RATE_DEG_S)) * self.step_s
            speed += (self.ordered.speed_m_s - speed) / SPEED_LAG_S * self.step_s
            east, north = unit_from_azimuth(heading)
            way = speed * self.step_s
            self.rows.append((x + float(east) * way, y + float(north) * way, heading, speed))


def motions(sea: FreeSea, vessel: Vessel, rows: Sequence[tuple[float, ...]], step_s: float, first: int = 0) -> Field:
    """Heave [m], roll, pitch [deg] (3, moment) along a track, from one of its rows on."""
    made = []
    for number, (x, y, heading, speed) in enumerate(rows[first:], first):
        each = vessel.response(sea.waves.kx, sea.waves.ky, sea.waves.omega, heading, speed)
        here = sea.at_home(x, y, number * step_s)
        made.append([np.sum(part * here).real for part in (each.heave, each.roll, each.pitch)])
    return np.array(made).T * np.array([[1.0], [180.0 / np.pi], [180.0 / np.pi]])


@dataclass(frozen=True)
class Known:
    """A sea as a forecast has it, with a sea of errors of a share by wavelength and lead.

    scale: of those shares, 0 of foresight, inf: no phases.
    """

    sea: FreeSea
    errors: FreeSea
    scale: float

    def share(self, lead: Field) -> Field:
        """Of the variance (band, lead), that is not known."""
        if np.isinf(self.scale):
            return np.ones((len(ERRORS), lead.size))
        return self.scale * np.stack([np.interp(lead, LEADS_S, each) for each in ERRORS])

    @cached_property
    def groups(self) -> tuple[Waves, float]:
        """Waves of equal variance [m²] each, and that, at even steps of the variance from long waves to short."""
        waves, power = self.sea.waves, 0.5 * np.abs(self.sea.amplitudes) ** 2
        order = np.argsort(np.hypot(waves.kx, waves.ky))
        steps = (np.arange(GROUPS) + 0.5) / GROUPS * power.sum()
        chosen = order[np.searchsorted(np.cumsum(power[order]), steps)]
        return Waves(waves.kx[chosen], waves.ky[chosen], waves.omega[chosen]), float(power.sum()) / GROUPS

    def ahead(self, x: float, y: float, moment: float) -> SeaPrediction:
        """From a place and time on."""
        band = band_of(self.sea.waves)
        inside = np.arange(len(ERRORS))[:, None] == band
        sets = np.concatenate([inside * each.here(x, y, moment) for each in (self.sea, self.errors)])
        few, variance = self.groups
        variances = np.full(GROUPS, variance)
        return SeaPrediction(self.sea.waves, sets, self.expect, few, variances, np.arange(GROUPS), few, variances)

    def expect(self, envelopes: Envelope, lead: Field, transfers: Transfers) -> Expectation:
        """See `SeaPrediction`: the best guess by truth and error together."""
        share, (few, variance) = self.share(lead), self.groups
        true, wrong = np.split(envelopes.real, 2)
        of_band = share[:, None, None]
        mean = np.sum((1.0 - of_band) * true + np.sqrt(of_band * (1.0 - of_band)) * wrong, axis=0)
        return mean, variance * np.abs(transfers.groups) ** 2 @ share[band_of(few)]


@dataclass(frozen=True)
class Task:
    """mission; bound [deg]; limit of roll [deg]."""

    mission: str
    bound: float
    limit: float

    def order(self, ahead: SeaPrediction, vessel: Vessel, now: Course, draws: int = DRAWS, sure: bool = True) -> Course:
        """What to steer: what is best, where that can be told from going on or need not be sure."""
        headings = (self.bound + np.linspace(-AWAY_DEG, AWAY_DEG, 5)) % 360.0
        task = {"mission": self.mission, "limits": {"roll": self.limit}, "hold": (*now, self.bound)}
        speeds = np.array(SHARES) * FULL_M_S
        made = advise_on(ahead, vessel, np.inf, headings, speeds, HORIZON_S, draws=draws, task=task)
        if sure and made.attrs["verdict"].startswith("no difference"):
            return now
        return Course(made.attrs["best_heading_deg"], made.attrs["best_speed_m_s"])


@dataclass(frozen=True)
class Came:
    """Of one boat and its whole way: rms roll [deg], exceedances a minute, way made good [m/s]."""

    roll: float
    often: float
    way: float

    @classmethod
    def of(cls, boat: Boat, sea: FreeSea, vessel: Vessel, task: Task, skip_s: float = 0.0) -> Came:
        """skip_s: before any advice."""
        first = round(skip_s / boat.step_s)
        rows = boat.rows[:: round(STEP_S / boat.step_s)]
        roll = motions(sea, vessel, rows, STEP_S, round(skip_s / STEP_S))[1]
        seconds = (len(boat.rows) - 1 - first) * boat.step_s
        east, north = unit_from_azimuth(task.bound)
        away = np.array(boat.rows[-1][:2]) - boat.rows[first][:2]
        often = 60.0 * float(exceedances(roll, task.limit)) / seconds
        return cls(float(np.sqrt(np.mean(roll**2))), often, float(away @ (east, north)) / seconds)


def sailed(seconds: float, task: Task, order: Callable[[Boat], Course]) -> Boat:
    """A boat that asks for orders, and obeys each half a second later."""
    start = Course(task.bound, FULL_M_S)
    boat = Boat(start, start)
    while (now := boat.now[2]) < seconds:
        ordered = order(boat)
        boat.run(now + DELAY_S)
        boat.ordered = ordered
        boat.run(now + EACH_S)
    return boat


def tasks(sea: FreeSea, vessel: Vessel) -> Iterator[Task]:
    """Bound off the waves, with a limit by the spectrum."""
    bound = (WAVES_FROM_DEG + OFF_DEG) % 360.0
    for mission in TASKS:
        each = vessel.response(sea.waves.kx, sea.waves.ky, sea.waves.omega, bound, FULL_M_S)
        sigma = np.degrees(np.sqrt(0.5 * np.sum(np.abs(each.roll * sea.amplitudes) ** 2)))
        yield Task(mission, bound, LIMIT * float(sigma))


def arms(sea: FreeSea, errors: FreeSea, vessel: Vessel, task: Task, seconds: float) -> dict[str, Boat]:
    """Boats of all ways to decide but the radar's."""
    whole = {name: Known(sea, errors, scale) for name, scale in (("advice", 1.0), ("foresight", 0.0))}
    start, unknown = Course(task.bound, FULL_M_S), Known(sea, errors, np.inf).ahead(0.0, 0.0, 0.0)
    steady = task.order(unknown, vessel, start, draws=400, sure=False)
    made = {
        "hold": sailed(seconds, task, lambda boat: boat.ordered),
        "spectrum": sailed(seconds, task, lambda _: steady),
    }
    for name, known in whole.items():
        made[name] = sailed(seconds, task, lambda boat, k=known: task.order(k.ahead(*boat.now), vessel, boat.ordered))
    return made


def drawn_runs(
    seeds: Sequence[int], minutes: float, boats: int, known: Set[Key] = frozenset()
) -> Iterator[dict[str, Any]]:
    """One run after the other, seas, boats and tasks of a seed, but those that are known."""
    for seed in seeds:
        for number, name in enumerate(DRAWN_SEAS):
            spectrum = own_spectrum(scene_of(name, seed, 1), DEEP_WATER)
            sea = FreeSea.drawn(spectrum, 10 * seed + number, "sharp" in name)
            errors = replace(sea, amplitudes=FreeSea.drawn(spectrum, 10 * seed + number + 5, False).amplitudes)
            for boat, vessel in list(BOATS.items())[:boats]:
                for task in tasks(sea, vessel):
                    if (seed, name, boat, task.mission) in known:
                        continue
                    made = arms(sea, errors, vessel, task, 60.0 * minutes)
                    came = {arm: vars(Came.of(each, sea, vessel, task)) for arm, each in made.items()}
                    yield {"seed": seed, "sea": name, "boat": boat, "task": task.mission, "came": came}


class RadarRun:
    """A radar on a boat that steers by its maps."""

    def __init__(self, name: str, seed: int, seconds: float) -> None:
        more = {"radar.range_m": [15.0, 300.0], "scattering.sea_spikes": False}
        self.scene = scene_of(name, seed, round(seconds), **more)
        self.vessel, self.boat, self._moved = BOATS["7 m"], None, np.zeros((3, 0))
        self.simulator = Simulator(self.scene, motion=self.motion)
        course = Course((WAVES_FROM_DEG + OFF_DEG) % 360.0, FULL_M_S)
        self.sea = FreeSea.of(self.simulator.sea, "sharp" in name, self.vessel, course)

    def motion(self, times: Any) -> BoatState:
        """What the simulator asks for."""
        time = np.asarray(times, np.float64)
        boat = self.boat
        if boat is None:  # while the simulator is made
            return BoatState(np.zeros((time.size, 3)), np.zeros((time.size, 3)))
        first = self._moved.shape[1]
        if first < len(boat.rows):
            more = motions(self.sea, self.vessel, boat.rows, boat.step_s, first)
            self._moved = np.concatenate((self._moved, more), axis=1)
        begin = max(0, int(time.min() / boat.step_s) - 8)
        part = slice(begin, min(len(boat.rows), int(time.max() / boat.step_s) + 9))
        rows = np.array(boat.rows[part])
        columns = np.column_stack((rows, self._moved.T[part]))
        found = CubicSpline(boat.step_s * (begin + np.arange(len(rows))), columns)(time)
        x, y, heading, _, heave, roll, pitch = found.T
        return BoatState(np.column_stack((x, y, heave)), np.column_stack((roll, pitch, heading)))

    def sailed(self, task: Task) -> Boat:
        """By the radar's maps, which come each second."""
        start = Course(task.bound, FULL_M_S)
        self.boat = boat = Boat(start, start, step_s=RIDE_S)
        boat.run(1.0 + DELAY_S)
        predictor = Predictor()
        for number in range(self.scene.turns):
            echoes = self.simulator.turn(number).echoes
            polar = sr.retrieve(echoes, self.scene.resolved_retrieval)["polar"].to_dataset().isel(turn=0)
            wave_field = predictor.turn(polar)
            if wave_field is not None and number >= WARM and (number - WARM) % EACH_S == 0:
                boat.ordered = task.order(SeaPrediction.of(wave_field), self.vessel, boat.ordered)
            boat.run(number + 2.0 + DELAY_S)
        return boat


def radar_runs(seeds: Sequence[int], minutes: float, known: Set[Key] = frozenset()) -> Iterator[dict[str, Any]]:
    """The radar in the loop, and the other arms on the same sea."""
    for seed in seeds:
        for name in DRAWN_SEAS[:2]:
            if (seed, name, "7 m", TASKS[0]) in known:
                continue
            begin, run = time.process_time(), RadarRun(name, seed, 60.0 * minutes)
            task = next(tasks(run.sea, run.vessel))
            stream = np.random.default_rng(seed)
            turned = run.sea.amplitudes * np.exp(2j * np.pi * stream.random(run.sea.amplitudes.size))
            errors = FreeSea(run.sea.waves, turned, False)
            made = arms(run.sea, errors, run.vessel, task, 60.0 * minutes)
            made["radar"] = run.sailed(task)
            came = {arm: vars(Came.of(each, run.sea, run.vessel, task, WARM + 1.0)) for arm, each in made.items()}
            seconds = time.process_time() - begin
            yield {"seed": seed, "sea": name, "boat": "7 m", "task": task.mission, "came": came, "seconds": seconds}


def band(values: Field) -> tuple[float, float]:
    """95 % of bootstrapped means; NaN of fewer values than tell any."""
    if values.size < FEWEST:
        return np.nan, np.nan
    stream = np.random.default_rng(0)
    means = values[stream.integers(0, values.size, (BOOTSTRAPS, values.size))].mean(axis=1)
    return float(np.percentile(means, 2.5)), float(np.percentile(means, 97.5))


def report(runs: list[dict[str, Any]]) -> None:
    """Tables by task and sea, and over all."""
    for task in sorted({run["task"] for run in runs}):
        of_task = [run for run in runs if run["task"] == task]
        print(f"\n**{task}**\n")
        print("| sea, boats by | runs | roll (deg) | exceedances a minute | way lost | share of foresight's gain |")
        print("|---|---|---|---|---|---|")
        for sea in (*sorted({run["sea"] for run in of_task}), "all"):
            chosen = [run["came"] for run in of_task if sea in ("all", run["sea"])]
            value = "roll" if task == "least_roll" else "often"
            for arm in chosen[0]:
                roll, often, way = (np.array([run[arm][name] for run in chosen]) for name in ("roll", "often", "way"))
                lost = 1.0 - way / np.array([run["hold"]["way"] for run in chosen])
                gain, most = (
                    np.mean([run["hold"][value] - run[which][value] for run in chosen]) for which in (arm, "foresight")
                )
                share = gain / most if abs(most) > 1e-9 else np.nan
                cells = f"{len(chosen)} | {roll.mean():.2f} | {often.mean():.2f} | {100 * lost.mean():.1f} %"
                print(f"| {sea}, {arm} | {cells} | {share:.2f} |")
        print(f"\n**{task}, paired differences over all runs**\n")
        print("| less | roll (deg) | 95 % | exceedances a minute | 95 % | way (m/s) | 95 % |")
        print("|---|---|---|---|---|---|---|")
        whole = [run["came"] for run in of_task]
        last = "radar" if "radar" in whole[0] else "advice"
        for one, other in ((last, "hold"), (last, "spectrum"), (last, "foresight"), ("radar", "advice")):
            if one not in whole[0]:
                continue
            cells = []
            for name in ("roll", "often", "way"):
                apart = np.array([run[one][name] - run[other][name] for run in whole])
                low, high = band(apart)
                cells.append(f"{apart.mean():+.3f} | " + ("–" if np.isnan(low) else f"{low:+.3f} to {high:+.3f}"))
            print(f"| {one} less {other} | " + " | ".join(cells) + " |")


def draw(runs: list[dict[str, Any]], file: Path) -> None:
    """Way lost against roll and exceedances, by who decides: a point a sea and task, its size the bands' over runs."""
    colours = {"hold": "0.5", "spectrum": "tab:orange", "advice": "tab:blue", "foresight": "tab:green", "radar": "k"}
    missions = sorted({run["task"] for run in runs})
    figure, axes = plt.subplots(
        1, len(missions), figsize=(5.0 * len(missions), 3.6), squeeze=False, layout="constrained"
    )
    for axis, task in zip(axes[0], missions, strict=True):
        value, words = ("roll", "roll rms (°)") if task == "least_roll" else ("often", "exceedances a minute")
        for marker, sea in zip("os^", sorted({run["sea"] for run in runs}), strict=False):
            came = [run["came"] for run in runs if (run["task"], run["sea"]) == (task, sea)]
            for arm in came[0]:
                across = np.array([run[arm][value] for run in came])
                lost = 100.0 * np.array([1.0 - run[arm]["way"] / run["hold"]["way"] for run in came])
                bars = np.abs(np.array([band(each) for each in (across, lost)]) - [[across.mean()], [lost.mean()]])
                label = f"{arm}; {sea}" if arm == "hold" else arm if marker == "o" else None
                axis.errorbar(
                    across.mean(),
                    lost.mean(),
                    bars[1][:, None],
                    bars[0][:, None],
                    marker,
                    color=colours[arm],
                    label=label,
                )
        axis.set(xlabel=words, ylabel="way lost (%)", title=task.replace("_", " "))
        axis.grid(alpha=0.3)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), fontsize="x-small", loc="outside lower center", ncols=3)
    figure.savefig(file, dpi=110)


def main() -> None:
    given = options(__doc__, seeds=12, first=751, minutes=10.0, boats=2, radar=False, runs=Path, figure=Path)
    seeds = range(given.first, given.first + given.seeds)
    kept = given.runs.read_text().splitlines() if given.runs and given.runs.exists() else []
    runs = [json.loads(line) for line in kept]
    known = {(run["seed"], run["sea"], run["boat"], run["task"]) for run in runs}
    drawn = (
        radar_runs(seeds, given.minutes, known) if given.radar else drawn_runs(seeds, given.minutes, given.boats, known)
    )
    for run in drawn:
        runs.append(run)
        if given.runs:
            with given.runs.open("a") as file:
                file.write(json.dumps(run) + "\n")
    report(runs)
    if given.figure:
        draw(runs, given.figure)


if __name__ == "__main__":
    main()
