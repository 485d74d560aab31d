"""What to steer: motions of a vessel by heading and speed, the best of them for a task, and how sure that is.

Each figure is given twice: `seen`, of the next seconds, from draws of the phase-resolved field along each course; and
`beyond`, of the sea state, by the spectrum at encounter: Gaussian motions whose upcrossings of a level L come at random
at √(m₂/m₀)/2π · exp(−L²/2m₀) a second (Rice 1944), slams by re-entry speed and green water by freeboard (Ochi 1964).
Draws are of one sea for all courses, so that courses are compared in pairs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError, must_be
from ..io.text import numbers
from .advice_motions import QUANTITIES, Hull, SeaPrediction, shares_of
from .field import WaveField
from .quantity import Course
from .spectrum import Field
from .vessel import Vessel

Drawn = NDArray[np.float32]  # (course, quantity, draw, moment)

MISSIONS = {"least_roll": "deg", "fewest_exceedances": "1", "most_way": "m"}
LIMITED = QUANTITIES[:4]
_UNITS = {"heave": "m", "roll": "deg", "pitch": "deg", "acceleration": "m/s^2"}
_STEP_S = 0.25  # a motion of 2 s peaks no more than 8 % above the greatest of such moments
_BEYOND_S = 600.0
_BAND = 2.5, 97.5  # per cent
_OUTER = 95.0
_ROUND, _SPEEDS = 24, (0.0, 2.0, 4.0, 6.0)
_LEAST = 2  # draws
_WITH_BOUND = 3  # numbers of what is held
_NOTES = (
    "straight courses, steered at once; linear motions at the encounter frequency; lift, trim, planing, surf-riding "
    "and the change of added mass and damping by speed are not modelled"
)
_NONE = "no difference that can be told"


def advise(
    field: WaveField,
    vessel: Vessel,
    headings: ArrayLike | None = None,
    speeds: ArrayLike | None = None,
    horizon_s: float = 30.0,
    *,
    limits: Mapping[str, float] | None = None,
    mission: str = "least_roll",
    hold: Sequence[float] | None = None,
    hull: Hull | None = None,
    draws: int = 40,
) -> xr.Dataset:
    """Motions and their dangers by heading and speed over ground, and what is best for a mission.

    field: as from `reconstruct`. headings: degrees clockwise from north, 24 all round if left out; speeds: m/s, 0 to 6
    by twos if left out. horizon_s: how long a course is held. limits: by magnitude, of heave [m], roll, pitch [deg] and
    vertical acceleration [m/s²] at `hull.place_m`. mission: `least_roll` (rms, deg), `fewest_exceedances` (of limits),
    `most_way` (m towards where the boat is bound, where the limits hold all the time; nothing elsewhere). hold: heading
    and speed now, the first ones if left out, and the direction in which the boat is bound [deg], that heading if left
    out. hull: places on board; left out, what the vessel's sizes give. draws: of what may come.

    Returns (heading, speed, part) rms and `_p95`, the magnitude that the highest stays below in 95 of 100 cases, of
    each motion, the probabilities that a limit is exceeded, of a slam and of green water, the distance made good; and
    (heading, speed) score, lower is better, its difference from the held course's with the 95 % band of paired draws,
    and the probability that it is lower. Attributes say what is best, and `verdict` in one line.
    Raises InputError for courses, limits, a mission or a number of draws that cannot be.
    """
    must_be("field", field, WaveField, "a WaveField, as reconstruct gives")
    if not hasattr(vessel, "response"):
        raise InputError(f"vessel = {vessel}: must be a vessel; give prediction.Box, Disc, Follower or read_capytaine")
    made = advise_on(
        SeaPrediction.of(field),
        vessel,
        field.spectrum.water.depth,
        headings,
        speeds,
        horizon_s,
        hull=hull,
        draws=draws,
        task={"mission": mission, "limits": limits, "hold": hold},
    )
    return made.assign_attrs(issued=float(field.issued))


def advise_on(
    sea: SeaPrediction,
    vessel: Vessel,
    depth_m: float,
    headings: ArrayLike | None = None,
    speeds: ArrayLike | None = None,
    horizon_s: float = 30.0,
    *,
    hull: Hull | None = None,
    draws: int = 40,
    seed: int = 0,
    task: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Advise as `advise` does, for any sea ahead. task: mission, limits and hold."""
    mission, limits, hold = _task(**(task or {}))
    heading, speed = _courses(headings, speeds)
    held = Course(float(heading[0]), float(speed[0])) if hold is None else Course(*hold[:2])
    bound = held.heading_deg if hold is None or len(hold) < _WITH_BOUND else hold[-1]
    if not (np.isfinite(horizon_s) and horizon_s >= 2.0 * _STEP_S):
        raise InputError(f"horizon_s = {horizon_s:g}: must be finite and at least {2.0 * _STEP_S:g}")
    if draws < _LEAST:
        raise InputError(f"draws = {draws}: must be at least {_LEAST}")
    hull = Hull.of(vessel) if hull is None else hull.with_threshold()
    courses = [Course(float(way), float(fast)) for way in heading for fast in speed] + [held]
    transfers = sea.transfers(courses, shares_of(vessel, hull, depth_m))
    lead = np.arange(0.0, horizon_s + 0.5 * _STEP_S, _STEP_S)
    drawn = sea.draw_motions(lead, transfers, draws, seed)
    drawn[:, 1:3] = np.degrees(drawn[:, 1:3])
    degrees = np.array([1.0, 180.0 / np.pi, 180.0 / np.pi, 1.0, 1.0])
    still, moving = (each * degrees for each in sea.moments(transfers))
    way = np.array([each.speed_m_s * np.cos(np.radians(each.heading_deg - bound)) for each in courses])
    seen, beyond = _figures_of_draws(drawn, limits, hull), _figures_of_spectrum(still, moving, limits, hull)
    seen["distance_made_good"], beyond["distance_made_good"] = way * horizon_s, way * _BEYOND_S
    shape = heading.size, speed.size
    parts = {
        name: np.stack((seen[name][:-1].reshape(shape), beyond[name][:-1].reshape(shape)), axis=-1) for name in seen
    }
    scores = _scores(drawn, way * horizon_s, mission, limits)
    return _dataset(parts, scores, (heading, speed), held, _attributes(mission, horizon_s, held, limits))


def _task(
    mission: str = "least_roll", limits: Mapping[str, float] | None = None, hold: Sequence[float] | None = None
) -> tuple[str, dict[str, float], Sequence[float] | None]:
    """Checked."""
    if mission not in MISSIONS:
        raise InputError(f"mission = '{mission}': must be one of {', '.join(MISSIONS)}")
    limits = dict(limits or {})
    for name, value in limits.items():
        if name not in LIMITED:
            raise InputError(f"limits: '{name}' is not known; it must be of {', '.join(LIMITED)}")
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(f"limits: {name} = {value:g}: must be finite and above 0")
    if mission != "least_roll" and not limits:
        raise InputError(f"limits: is empty, and mission = '{mission}' needs one of {', '.join(LIMITED)}")
    if hold is not None and not (len(hold) in (2, _WITH_BOUND) and np.isfinite(hold).all() and hold[1] >= 0.0):
        raise InputError(
            f"hold = {hold}: must be a heading [deg] and a speed of at least 0 m/s, and where it is bound [deg]"
        )
    return mission, limits, hold


def _courses(headings: ArrayLike | None, speeds: ArrayLike | None) -> tuple[Field, Field]:
    heading, speed = (
        np.atleast_1d(np.asarray(numbers(name, default if given is None else given), np.float64))
        for name, given, default in (
            ("headings", headings, 360.0 / _ROUND * np.arange(_ROUND)),
            ("speeds", speeds, np.array(_SPEEDS)),
        )
    )
    for name, values in (("headings", heading), ("speeds", speed)):
        if values.ndim != 1 or not values.size or not np.isfinite(values).all():
            raise InputError(f"{name}: must be finite numbers in a row, one at least")
    if (speed < 0.0).any():
        raise InputError(f"speeds = {speed.min():g}: must be at least 0")
    return heading, speed


def _figures_of_draws(drawn: Drawn, limits: Mapping[str, float], hull: Hull) -> dict[str, Field]:
    """Figures (course,) of the seconds that were drawn."""
    made: dict[str, Field] = {}
    highest = np.abs(drawn).max(axis=-1)  # (course, quantity, draw)
    for number, name in enumerate(LIMITED):
        made[f"{name}_rms"] = np.sqrt(np.mean(drawn[:, number].astype(np.float64) ** 2, axis=(1, 2)))
        made[f"{name}_p95"] = np.percentile(highest[:, number], _OUTER, axis=-1)
    over = np.zeros(highest[:, 0].shape, bool)
    for name, limit in limits.items():
        over |= highest[:, LIMITED.index(name)] > limit
    nothing = np.full(drawn.shape[0], np.nan)
    made["exceedance_probability"] = over.mean(axis=-1) if limits else nothing
    bow = drawn[:, QUANTITIES.index("bow")]
    slams = green = nothing
    if hull.bow_m is not None and hull.draught_m is not None and hull.slam_speed_m_s is not None:
        enters = (bow[..., :-1] > hull.draught_m) & (bow[..., 1:] <= hull.draught_m)
        fast = (bow[..., :-1] - bow[..., 1:]) / _STEP_S > hull.slam_speed_m_s
        slams = (enters & fast).any(axis=-1).mean(axis=-1)
    if hull.bow_m is not None and hull.freeboard_m is not None:
        green = (-bow > hull.freeboard_m).any(axis=-1).mean(axis=-1)
    return made | {"slam_probability": slams, "green_water_probability": green}


def _figures_of_spectrum(still: Field, moving: Field, limits: Mapping[str, float], hull: Hull) -> dict[str, Field]:
    """Figures (course,) of some minutes by standard deviations (course, quantity) of motions and their rates."""
    made: dict[str, Field] = {}
    times = moving / np.maximum(still, 1e-300) / (2.0 * np.pi) * _BEYOND_S  # of upcrossings of 0
    rare = -np.log(0.01 * _OUTER)
    for number, name in enumerate(LIMITED):
        made[f"{name}_rms"] = still[:, number]
        level = np.sqrt(2.0 * np.log(np.maximum(2.0 * times[:, number] / rare, 1.0)))
        made[f"{name}_p95"] = still[:, number] * level

    def crossings(number: int, level: float) -> Field:
        return times[:, number] * np.exp(-0.5 * (level / np.maximum(still[:, number], 1e-150)) ** 2)

    nothing = np.full(still.shape[0], np.nan)
    often = sum((2.0 * crossings(LIMITED.index(name), limit) for name, limit in limits.items()), np.zeros(len(still)))
    made["exceedance_probability"] = -np.expm1(-often) if limits else nothing
    bow, slams, green = QUANTITIES.index("bow"), nothing, nothing
    if hull.bow_m is not None and hull.draught_m is not None and hull.slam_speed_m_s is not None:
        fast = np.exp(-0.5 * (hull.slam_speed_m_s / np.maximum(moving[:, bow], 1e-150)) ** 2)
        slams = -np.expm1(-crossings(bow, hull.draught_m) * fast)
    if hull.bow_m is not None and hull.freeboard_m is not None:
        green = -np.expm1(-crossings(bow, hull.freeboard_m))
    return made | {"slam_probability": slams, "green_water_probability": green}


def exceedances(motion: NDArray[np.floating], limit: float) -> NDArray[np.intp]:
    """How often magnitudes (…, moment) rise above a limit."""
    over = np.abs(motion) > limit
    return np.sum(over[..., 1:] & ~over[..., :-1], axis=-1) + over[..., 0]


def _scores(drawn: Drawn, way: Field, mission: str, limits: Mapping[str, float]) -> Field:
    """(course, draw), lower is better."""
    if mission == "least_roll":
        return np.sqrt(np.mean(drawn[:, 1].astype(np.float64) ** 2, axis=-1))
    often = sum(exceedances(drawn[:, LIMITED.index(name)], limit) for name, limit in limits.items())
    often = np.asarray(often, np.float64)
    return often if mission == "fewest_exceedances" else -way[:, None] * (often == 0.0)


def _dataset(
    parts: Mapping[str, Field],
    scores: Field,
    grid: tuple[Field, Field],
    held: Course,
    attributes: dict[str, Any],
) -> xr.Dataset:
    heading, speed = grid
    shape = heading.size, speed.size
    apart = scores[:-1] - scores[-1]
    low, high = np.percentile(apart, _BAND, axis=-1)
    better = np.mean(apart < 0.0, axis=-1) + 0.5 * np.mean(apart == 0.0, axis=-1)
    score = scores[:-1].mean(axis=-1)
    best = int(np.argmin(score))
    unit = attributes["score_units"]
    both, dims = ("heading", "speed"), ("heading", "speed", "part")
    table = {
        "score": (score, unit, "mission's score, lower is better"),
        "better_probability": (better, "1", "that the score is lower than the held course's"),
        "difference": (apart.mean(axis=-1), unit, "score less the held course's"),
        "difference_low": (low, unit, "lower end of the difference's 95 % band"),
        "difference_high": (high, unit, "upper end of the difference's 95 % band"),
    }
    variables: dict[str, Any] = {
        name: (dims, values.astype(np.float64), {"units": _unit(name), "long_name": name.replace("_", " ")})
        for name, values in parts.items()
    }
    for name, (values, units, words) in table.items():
        variables[name] = (both, values.reshape(shape), {"units": units, "long_name": words})
    steer = float(heading[best // speed.size]), float(speed[best % speed.size])
    attributes |= {"best_heading_deg": steer[0], "best_speed_m_s": steer[1], "better_probability": float(better[best])}
    significant = (low[best] > 0.0 or high[best] < 0.0) and steer != (held.heading_deg, held.speed_m_s)
    mark = {"deg": "°", "1": ""}.get(unit, f" {unit}")
    words = (
        f"steer {steer[0]:03.0f}° at {steer[1]:.1f} m/s: {attributes['mission'].replace('_', ' ')} "
        f"{abs(score[best]):.2g}{mark} instead of {abs(scores[-1].mean()):.2g} (probability {better[best]:.2f})"
    )
    attributes["verdict"] = words if significant else _NONE
    coords = {
        "heading": ("heading", heading, {"units": "degree", "long_name": "heading, clockwise from north"}),
        "speed": ("speed", speed, {"units": "m/s", "long_name": "speed over ground along the heading"}),
        "part": ("part", ["seen", "beyond"]),
    }
    return xr.Dataset(variables, coords, attributes)


def _unit(name: str) -> str:
    first = name.rpartition("_")[0]
    return "m" if name == "distance_made_good" else _UNITS.get(first, "1")


def _attributes(mission: str, horizon_s: float, held: Course, limits: Mapping[str, float]) -> dict[str, Any]:
    return {
        "mission": mission,
        "score_units": MISSIONS[mission],
        "horizon_s": float(horizon_s),
        "beyond_s": _BEYOND_S,
        "heading_deg": float(held.heading_deg),
        "speed_m_s": float(held.speed_m_s),
        "model_notes": _NOTES,
    } | {f"limit_{name}": float(value) for name, value in limits.items()}


__all__ = ["LIMITED", "MISSIONS", "advise", "advise_on", "exceedances"]
