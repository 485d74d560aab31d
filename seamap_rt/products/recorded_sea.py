"""A scene's nonlinear sea, worked out once and written frame by frame as a recorded sea.

recorded_sea.nc holds η and φs on even points of the square on which the sea repeats, from its south-west corner on, the
antenna in its middle. A sea of waves along one axis has alike rows or columns, and its square is as long as the line.
"""

from __future__ import annotations

import json
import os
import time as clock
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..compute.machine import free_memory
from ..conventions import unit_from_azimuth
from ..dataset import build
from ..errors import InputError, MachineLimitError, report_partial_results
from ..io.appendable import AppendableNetCDF
from ..io.opening import read_npz
from ..io.process import Progress, duration, hold_interruptions, ignore_progress
from ..io.results_folder import clear_folder, lock_folder, note_growing, results_folder
from ..resolved_scene import run_sea
from ..scene import Scene
from ..sea.high_order import Evolution, Plan, State
from ..sea.high_order.rates import fast_size
from .sampling import refuse_too_large, times_of

RECORD = "recorded_sea.nc"
PRODUCTS = (RECORD,)
DEFAULT_TIMES = "0:60:0.25"
DEFAULT_ORDER = 3
ROUNDING = {"m": 2.0**-13, "m2 s-1": 2.0**-13}
_NUMBERS = ("frames", "variance", "skewness", "energy_first", "broken_first")
_KEEP_EVERY = 30.0  # s of work before the record begins, after which the state is kept
_UNEVEN = 1e-9
_MOST_GROWN = 8.0  # significant height over the linear waves' standard deviation, of which it is 4 times


@dataclass(frozen=True)
class RecordedSea:
    """What was left behind: the file, what it says of itself, and what one should know of it."""

    file: Path
    attributes: dict[str, Any]
    notes: tuple[str, ...]

    def headline(self) -> str:
        """Height, energy and breaking in one line."""
        attr = self.attributes
        return (
            f"Hs {attr['significant_wave_height_m']:.3f} m over the record, "
            f"{attr['significant_wave_height_asked_m']:.3f} m of the linear waves that it began as; "
            f"skewness {attr['elevation_skewness']:.3f}; energy changed by {attr['energy_change']:.2%} in the record, "
            f"breaking took {attr['energy_broken']:.2%} ({attr['energy_broken_since_start']:.2%} since its start), "
            f"{attr['energy_drift']:.1e} is neither"
        )


@dataclass(frozen=True)
class RecordState:
    """The state from which the next frame follows, and sums over the frames that are on file."""

    state: State
    frames: int = 0
    variance: float = 0.0  # m², of the elevation, added up
    skewness: float = 0.0
    energy_first: float = np.nan  # m³/s², at the first frame
    broken_first: float = 0.0  # taken out by then

    def with_frame(self, state: State, elevation: NDArray[np.float32], evolution: Evolution) -> RecordState:
        """The state with one more frame."""
        heights = elevation.astype(np.float64)
        heights -= heights.mean()
        variance = float(np.mean(heights**2))
        first = {} if self.frames else {"energy_first": evolution.energy(state), "broken_first": state.broken}
        return replace(
            self,
            state=state,
            frames=self.frames + 1,
            variance=self.variance + variance,
            skewness=self.skewness + float(np.mean(heights**3)) / variance**1.5,
            **first,
        )


def state_file(folder: Path) -> Path:
    """Where the state is kept while the record is not finished."""
    return folder / ".recorded_sea.state.npz"


def save_state(folder: Path, attributes: Mapping[str, Any], at: RecordState) -> None:
    """Write the state, whole or not at all. attributes: what the record says of itself."""
    path = state_file(folder)
    part = path.with_name(f"{path.name}.part")
    state = at.state
    with part.open("wb") as file:
        np.savez(
            file,
            told=np.array(_attributes_text(attributes)),
            elevation=state.elevation,
            potential=state.potential,
            of_state=np.array([state.time, state.energy, state.broken]),
            numbers=np.array([getattr(at, name) for name in _NUMBERS], dtype=np.float64),
        )
    os.replace(part, path)


def load_state(folder: Path, attributes: Mapping[str, Any]) -> RecordState:
    """What was kept. InputError where it is damaged, or of another record than the one that is asked for."""
    path = state_file(folder)
    try:
        _, stored = read_npz(path, ("told", "of_state", "numbers", "elevation", "potential"))
        before = json.loads(str(stored["told"]))
        time, energy, broken = map(float, stored["of_state"])
        numbers = dict(zip(_NUMBERS, map(float, stored["numbers"]), strict=True))
        state = State(time, stored["elevation"], stored["potential"], energy, broken)
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise InputError(f"{path}: cannot be read ({error}); run it again with --overwrite") from None
    now = json.loads(_attributes_text(attributes))
    other = [name for name in now if before.get(name) != now[name]]
    if other:
        raise InputError(
            f"--resume: '{folder}' was begun with another {other[0]}; give the command as it was, or --overwrite"
        )
    return RecordState(state, **{**numbers, "frames": int(numbers["frames"])})


def _attributes_text(attributes: Mapping[str, Any]) -> str:
    return json.dumps(dict(attributes), allow_nan=True, sort_keys=True)


@dataclass(frozen=True)
class _Frames:
    """Where and when a record stands."""

    plan: Plan
    seconds: NDArray[np.float64]
    current: tuple[float, float]

    @property
    def evolution(self) -> Evolution:
        return self.plan.evolution(float(self.seconds[0]), self.interval)

    @property
    def interval(self) -> float:
        return float(self.seconds[1] - self.seconds[0])

    @property
    def side(self) -> float:
        return max(self.plan.start.lengths)

    @property
    def points(self) -> int:
        """A side: even, and enough for the shortest wave."""
        most = max(self.plan.band.most_x, self.plan.band.most_y)
        count = fast_size(2 * most + 2)
        while count % 2:
            count = fast_size(count + 1)
        return count

    @property
    def coordinates(self) -> NDArray[np.float64]:
        """x or y of the points, m."""
        return self.side / self.points * (np.arange(self.points, dtype=np.float64) - self.points // 2)

    def frame(self, state: State, number: int) -> xr.Dataset:
        """The sea at a time of the record, where a current has carried it. FloatingPointError for one beyond reason."""
        band, seconds = self.plan.band, float(self.seconds[number])
        moved = np.exp(-1j * (band.east * self.current[0] + band.north * self.current[1]) * seconds)
        height = state.significant_height
        if not height < _MOST_GROWN * self.plan.sea.resolved.elevation_std:
            raise FloatingPointError(f"at {seconds:.4g} s its significant height is {height:.3g} m")
        fields = {"elevation": state.elevation, "surface_potential": state.potential}
        return build(
            "recorded_sea",
            {name: self._values_on_points(moved * waves)[None] for name, waves in fields.items()},
            {"time": [seconds], "x": self.coordinates, "y": self.coordinates},
        )

    def _values_on_points(self, waves: NDArray[np.complex128]) -> NDArray[np.float32]:
        """Values on the points from half a side south-west of the antenna on, where exp(i k·x) is 1 or −1."""
        band = self.plan.band
        row = np.concatenate((np.arange(band.most_y + 1.0), np.arange(-band.most_y, 0.0)))[:, None]
        centred = waves * (1.0 - 2.0 * np.remainder(np.arange(band.most_x + 1.0) + row, 2.0))
        shape = self.points if band.most_y else 1, self.points if band.most_x else 1
        return np.broadcast_to(band.to_points(centred, shape), (self.points, self.points)).astype(np.float32)


def write_recorded_sea(
    scene: Scene,
    out: str | Path,
    *,
    times: str = DEFAULT_TIMES,
    order: int = DEFAULT_ORDER,
    spacing: float | None = None,
    overwrite: bool = False,
    resume: bool = False,
    progress: Progress | None = None,
) -> RecordedSea:
    """Write a scene's nonlinear sea into a folder: recorded_sea.nc, which grows frame by frame.

    times: START:STOP:STEP [s]. order: 1 … 5. spacing: half the shortest wave [m], see `Plan`. resume: go on where a
    kill or Ctrl-C has left the same command; the bits are those of a run that was never stopped.
    Raises InputError for bad input, too little memory or disk, and a sea that comes to no finite state.
    """
    say, folder = progress or ignore_progress, Path(out)
    say("preparing the sea")
    frames = _frames(scene, times, order, spacing)
    attributes = _attributes(scene, frames, times)
    if resume:
        if not state_file(folder).exists():
            raise InputError(f"--out = '{folder}': holds no recorded sea that was stopped; leave --resume out")
        with lock_folder(folder, "--out"):
            return _write_frames(folder, frames, attributes, load_state(folder, attributes), say)
    if state_file(folder).exists() and not overwrite:
        raise InputError(
            f"--out = '{folder}': holds a recorded sea that was not finished; --resume goes on with it, --overwrite "
            "removes it"
        )
    with results_folder(folder, overwrite, PRODUCTS):
        refuse_too_large(folder, frames.seconds.size, frames.points, RECORD)
        clear_folder(folder, PRODUCTS)
        state_file(folder).unlink(missing_ok=True)
        return _write_frames(folder, frames, attributes, None, say)


def _frames(scene: Scene, times: str, order: int, spacing: float | None) -> _Frames:
    """InputError for times that are not even, and for what `Plan` and the memory refuse."""
    seconds = times_of(times)
    even = seconds.size > 1 and np.ptp(np.diff(seconds)) <= _UNEVEN * max(1.0, float(np.abs(seconds).max()))
    if not even:
        raise InputError(f"--times = '{times}': a recorded sea has even times, two at least; write START:STOP:STEP")
    if scene.sea.model not in ("linear", "choppy"):
        raise InputError(f"sea.model = '{scene.sea.model}': has no waves to begin with; must be linear or choppy")
    linear = scene.model_copy(update={"sea": scene.sea.model_copy(update={"model": "linear"})})
    plan = Plan(scene.sea, run_sea(linear), order, spacing)
    if plan.memory > free_memory():
        raise MachineLimitError(
            f"--spacing = {plan.spacing:.4g}: order {order} takes {plan.memory / 1e9:.3g} GB of memory, and "
            f"{free_memory() / 1e9:.3g} GB are free; raise --spacing, or lower --order or sea.extent_m"
        )
    east, north = unit_from_azimuth(scene.sea.current_toward_deg)
    current = scene.sea.current_m_s * float(east), scene.sea.current_m_s * float(north)
    return _Frames(plan, seconds, current)


def _attributes(scene: Scene, frames: _Frames, times: str) -> dict[str, Any]:
    """What the file says from the beginning. A record goes on only with the same."""
    plan = frames.plan
    evolution = frames.evolution
    return {
        "title": f"{scene.name}: nonlinear sea",
        "model": "high-order spectral (Dommermuth & Yue 1987; West et al. 1987)",
        "order": plan.order,
        "seed": scene.seed,
        "depth_m": scene.sea.depth_m,
        "periodic": 1,
        "length_m": frames.side,
        "spacing_m": frames.side / frames.points,
        "first_x_m": float(frames.coordinates[0]),
        "first_y_m": float(frames.coordinates[0]),
        "shortest_wave_m": 2.0 * plan.spacing,
        "current_east_m_s": frames.current[0],
        "current_north_m_s": frames.current[1],
        "times": times,
        "time_step_s": evolution.step,
        "relaxed_from_s": evolution.relaxed_from,
        "relaxing_s": plan.relaxing,
        "breaking": "none" if plan.breaking is None else "low-pass filter exp(-(k/k_c)^30) (Xiao et al. 2013)",
        "breaking_cut_off_rad_m": np.inf if plan.breaking is None else plan.breaking.cut_off,
        "breaking_rate_s": 0.0 if plan.breaking is None else plan.breaking.rate,
        "significant_wave_height_asked_m": plan.beginning(evolution).significant_height,
        "scene": scene.to_toml(),
    }


@dataclass
class _Pace:
    """Tells how far the work is, and how long it will take from what it took."""

    say: Progress
    first: float
    last: float
    began: float = field(default_factory=clock.perf_counter)

    def report(self, now: float, words: str) -> None:
        done = (now - self.first) / max(self.last - self.first, 1e-9)
        spent = clock.perf_counter() - self.began
        left = f", {duration(spent * (1.0 - done) / done)} left" if done > 0.0 and spent > 1.0 else ""
        self.say(f"{words}: {now:.4g} s of {self.last:.4g} s{left}")


def _write_frames(
    folder: Path, frames: _Frames, attributes: dict[str, Any], begun: RecordState | None, say: Progress
) -> RecordedSea:
    """All frames that are missing, one by one, each with the state from which the next can go on."""
    evolution = frames.evolution
    at = begun or RecordState(frames.plan.beginning(evolution))
    pace = _Pace(say, at.state.time, float(frames.seconds[-1]))
    path = folder / RECORD
    try:
        with (
            note_growing(folder, PRODUCTS, "times"),
            AppendableNetCDF(path, ("time",), compressed=True, rounding=ROUNDING, whole=at.frames) as file,
        ):
            whole = f"of {frames.seconds.size} times are complete; --resume goes on from there"
            with report_partial_results(lambda: f"{file.complete} {whole}"):
                at = _append_frames(file, folder, frames, attributes, at, pace)
                file.annotate(_record_facts(at, evolution))
    except FloatingPointError as error:
        state_file(folder).unlink(missing_ok=True)
        raise InputError(
            f"the sea breaks beyond what the model bears ({error}); raise --spacing above {frames.plan.spacing:.4g}, "
            f"lower --order, or lower the waves; {RECORD} holds what came before"
        ) from None
    except (ValueError, KeyError, FileNotFoundError, BadZipFile) as error:
        if begun is None or isinstance(error, InputError):
            raise
        raise InputError(
            f"--out = '{folder}': what is there cannot be gone on with ({error}); run it again with --overwrite"
        ) from None
    state_file(folder).unlink(missing_ok=True)
    return RecordedSea(path, attributes | _record_facts(at, evolution), _notes(frames))


def _append_frames(
    file: AppendableNetCDF, folder: Path, frames: _Frames, attributes: dict[str, Any], at: RecordState, pace: _Pace
) -> RecordState:
    evolution = frames.evolution
    steps = round(frames.interval / evolution.step)
    if not at.frames:
        with hold_interruptions():
            save_state(folder, attributes, at)  # from here on an interruption leaves what --resume goes on from
        stored = clock.perf_counter()
        for _ in range(round((float(frames.seconds[0]) - at.state.time) / evolution.step)):  # the slow beginning
            at = replace(at, state=evolution.advanced(at.state))
            if clock.perf_counter() - stored > _KEEP_EVERY:
                with hold_interruptions():
                    save_state(folder, attributes, at)
                stored = clock.perf_counter()
            pace.report(at.state.time, f"order {frames.plan.order}, nonlinear terms set in")
    while at.frames < frames.seconds.size:
        state = evolution.advanced(at.state, steps) if at.frames else at.state
        frame = frames.frame(state, at.frames)
        at = at.with_frame(state, frame["elevation"].values, evolution)
        with hold_interruptions():
            file.append(frame.assign_attrs(attributes))
            save_state(folder, attributes, at)
        pace.report(float(frames.seconds[at.frames - 1]), f"order {frames.plan.order}, recorded")
    return at


def _record_facts(at: RecordState, evolution: Evolution) -> dict[str, Any]:
    """Facts of the finished record: height, skewness and energy."""
    change = evolution.energy(at.state) / at.energy_first - 1.0
    broken = (at.state.broken - at.broken_first) / at.energy_first
    return {
        "significant_wave_height_m": 4.0 * float(np.sqrt(at.variance / at.frames)),
        "elevation_skewness": float(at.skewness / at.frames),
        "energy_change": change,
        "energy_broken": broken,
        "energy_broken_since_start": at.state.broken / at.energy_first,
        "energy_drift": change + broken,
    }


def _notes(frames: _Frames) -> tuple[str, ...]:
    plan = frames.plan
    notes = [
        f"{frames.seconds.size} times of {frames.points} × {frames.points} points, {frames.side / frames.points:.3g} m "
        f"apart, waves down to {2.0 * plan.spacing:.3g} m; step {plan.evolution(0.0, frames.interval).step:.3g} s"
    ]
    finest = plan.sea.resolved.resolution_m
    if plan.spacing > 1.01 * finest:
        notes.append(
            f"the scene's waves between {2.0 * finest:.3g} m and {2.0 * plan.spacing:.3g} m are left out: breaking "
            f"takes waves beyond 8 wavenumbers of the steepest system's peak; --spacing {finest:.3g} keeps them"
        )
    return tuple(notes)
