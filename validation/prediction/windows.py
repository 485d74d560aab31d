"""Quiet windows that are called from maps, against the sea that came.

    python -m validation.prediction.windows [--seeds 6] [--first 601] [--turns 40] [--sea choppy_sea]
        [--out validation/figures/quiet_windows.png]

Windows of 5 s in which the sea at the boat stays within 0.35 of its significant wave height, that begin 5 to 15 s after
the last look. From the tenth turn on each turn's forecast states a probability for each, and calls those of 0.9 and
more. `right`: share of calls that came true; `called`: share of the quiet windows that were called; `stated`: the mean
probability of what was called; `AUC`: area under the curve of hits against false alarms, as the threshold varies;
`Brier`: mean square of probability less outcome. Baselines: climatology knows the sea state alone (one probability for
all, AUC 0.5); persistence takes how high the water stood in the last 5 s; the group law lets the square of the envelope
of the last 5 s fade to the sea's own by the spectrum's coherence.

The highest crest of the next 15 s at the boat is forecast beside them: its correlation and rms with the one that came,
over σ, how often that lay where nine of ten draws have it, and how often it came within a second of the stated time,
beside the stated chance of that.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.prediction import Predictor, WaveField
from seamap_rt.report import style
from seamap_rt.simulation import Simulator
from validation.prediction.forecasts import FIRST, SEAS, scene_of

Field = NDArray[np.float64]

LIMIT, LASTS_S, CONFIDENCE = 0.35, 5.0, 0.9  # of the significant wave height
LEADS = np.arange(5.0, 16.0)
STEP_S = 0.1
HIGHEST_S = 15.0
CLASSES = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.01)


def came_true(simulator: Simulator, issued: float, limit: float) -> NDArray[np.bool_]:
    """Whether each window was quiet."""
    fine = np.arange(0.0, LASTS_S + 0.5 * STEP_S, STEP_S)
    moment = issued + LEADS[:, None] + fine
    at = np.zeros(moment.size)
    height = simulator.sea.elevation(at, at, moment.ravel()).reshape(moment.shape)
    return np.all(np.abs(height) < limit, axis=1)


def crest_that_came(simulator: Simulator, issued: float) -> tuple[float, float]:
    """Height [m] of the highest crest of the next seconds, and when it came [s]."""
    lead = np.arange(0.0, HIGHEST_S + 0.5 * STEP_S, STEP_S)
    height = simulator.sea.elevation(np.zeros(lead.size), np.zeros(lead.size), issued + lead)
    return float(height.max()), float(lead[np.argmax(height)])


def group_law(field: WaveField) -> tuple[float, Field]:
    """What persistence and the group law say: how low the sea was, and how low it is expected at each lead."""
    past = field.issued - np.arange(0.0, LASTS_S, 0.25)
    height, _ = field.elevation(0.0, 0.0, past)
    power, variance = float(np.mean(height**2)), field.spectrum.variance
    omega = field.spectrum.water.frequency(field.spectrum.k)
    ring = field.spectrum.variances.sum(axis=1)
    middle = LEADS + 0.5 * LASTS_S
    coherence = np.abs(np.exp(1j * np.multiply.outer(middle, omega)) @ ring / ring.sum()) ** 2
    return -float(np.max(np.abs(height))), -(variance + coherence * (power - variance))


def run(name: str, seed: int, turns: int) -> dict[str, Field]:
    """One seed's windows: outcome and every method's score (issue · lead,)."""
    scene = scene_of(name, seed, turns)
    simulator, predictor = Simulator(scene), Predictor()
    height = np.sqrt(sum(each.model_dump()["significant_wave_height_m"] ** 2 for each in scene.sea.waves))
    rows: dict[str, list[Field]] = {"outcome": [], "forecast": [], "persistence": [], "group law": [], "crest": []}
    for number in range(turns):
        polar = sr.retrieve(simulator.turn(number).echoes, scene.resolved_retrieval)["polar"].to_dataset()
        field = predictor.turn(polar.isel(turn=0))
        if field is None or number < FIRST:
            continue
        limit = LIMIT * height
        drawn = sr.forecast(field, lead_s=np.arange(0.0, LEADS[-1] + LASTS_S + 0.25, 0.25), draws=200)
        called = sr.quiet_windows(drawn, {"elevation": limit}, LASTS_S, CONFIDENCE).sel(lead=LEADS)
        low, expected = group_law(field)
        rows["outcome"].append(came_true(simulator, field.issued, limit).astype(np.float64))
        rows["forecast"].append(called["probability"].values.ravel())
        rows["persistence"].append(np.full(LEADS.size, low))
        rows["group law"].append(expected)
        highest = sr.highest_wave(drawn, HIGHEST_S).squeeze()
        told = [float(highest[name]) for name in ("crest", "crest_low", "crest_high", "lead", "chance")]
        rows["crest"].append(np.array([[*told, *crest_that_came(simulator, field.issued), height / 4.0]]))
    return {key: np.concatenate(part) for key, part in rows.items()}


def area(score: Field, outcome: Field) -> float:
    """Under the curve of hits against false alarms: how often a quiet window scores above one that is not."""
    quiet, other = score[outcome > 0.5], score[outcome < 0.5]
    above = np.mean(quiet[:, None] > other) + 0.5 * np.mean(quiet[:, None] == other)
    return float(above)


def print_crests(rows: Field) -> None:
    """rows (issue, …): told crest, low, high, lead and chance; the crest that came and when; σ."""
    crest, low, high, lead, chance, came, when, sigma = rows.T
    print(
        f"highest crest of {HIGHEST_S:g} s: correlation {np.corrcoef(crest, came)[0, 1]:.3f}, rms "
        f"{np.sqrt(np.mean(((crest - came) / sigma) ** 2)):.3f} σ, between low and high "
        f"{np.mean((came > low) & (came < high)):.0%}; within a second of its time "
        f"{np.mean(np.abs(when - lead) <= 1.0):.0%}, stated {chance.mean():.0%}"
    )


def reliability(chance: Field, outcome: Field) -> list[tuple[float, float, int]]:
    """Stated probability, share that came true, and number of the windows of each class of probability."""
    found = []
    for low, high in pairwise(CLASSES):
        inside = (chance >= low) & (chance < high)
        if inside.any():
            found.append((float(chance[inside].mean()), float(outcome[inside].mean()), int(inside.sum())))
    return found


@style.styled
def draw(every: dict[str, Field]) -> Figure:
    """Hits against false alarms as the threshold varies, and what stated probabilities came to."""
    figure = style.new_figure(2.75)
    outcome = every["outcome"] > 0.5
    curves, stated = (style.place(figure, left, 0.15, 2.7, 2.1) for left in (0.6, 4.2))
    colours = {"forecast": style.BLUE, "group law": style.ORANGE, "persistence": style.GREY}
    for name, colour in colours.items():
        order = np.argsort(-every[name], kind="stable")
        hits, alarms = (np.cumsum(each[order]) / each.sum() for each in (outcome, ~outcome))
        label = f"{name}, area {area(every[name], every['outcome']):.3f}"
        curves.plot(np.append(0.0, alarms), np.append(0.0, hits), color=colour, label=label)
    called = every["forecast"] >= CONFIDENCE
    point = float(called[~outcome].mean()), float(called[outcome].mean())
    curves.plot(*point, "o", color=style.BLUE, label=f"calls at {CONFIDENCE:.0%}")
    curves.legend(loc="lower right", fontsize="small")
    style.graph(curves, "Share of other windows called", "Share of quiet windows called", "")
    stated.plot([0.0, 1.0], [0.0, 1.0], "--", color=style.GREY)
    found = reliability(every["forecast"], every["outcome"])
    stated.plot([each[0] for each in found], [each[1] for each in found], "o-", color=style.BLUE)
    for told, true, count in found:
        stated.annotate(str(count), (told, true), textcoords="offset points", xytext=(5, -9), fontsize="small")
    style.graph(stated, "Stated probability", "Share that were quiet", "")
    for axes in (curves, stated):
        axes.set_xlim(-0.02, 1.02)
        axes.set_ylim(-0.02, 1.02)
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--first", type=int, default=601)
    parser.add_argument("--turns", type=int, default=40)
    parser.add_argument("--sea", default="choppy_sea", choices=list(SEAS))
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    parts = [run(given.sea, given.first + n, given.turns) for n in range(given.seeds)]
    every = {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}
    outcome, chance = every["outcome"], every["forecast"]
    called = chance >= CONFIDENCE
    base = float(outcome.mean())
    print(f"{given.sea}: {outcome.size} windows, {base:.0%} quiet")
    print(
        f"called {called.sum()}: right {outcome[called].mean():.1%}, stated {chance[called].mean():.1%}; "
        f"called of the quiet ones {called[outcome > 0.5].mean():.1%}"
    )
    print(f"Brier {np.mean((chance - outcome) ** 2):.3f}, climatology {base * (1.0 - base):.3f}")
    for key in ("forecast", "persistence", "group law"):
        both = [part for part in parts if 0.0 < part["outcome"].mean() < 1.0]
        each = [area(part[key], part["outcome"]) for part in both] or [np.nan]
        print(f"AUC {key}: {area(every[key], outcome):.3f} (seeds {min(each):.3f}–{max(each):.3f})")
    for stated, found, count in reliability(chance, outcome):
        print(f"  {count} windows, {stated:.2f} stated, {found:.2f} quiet")
    print_crests(every["crest"])
    if given.out:
        given.out.write_bytes(style.png(draw(every)))


if __name__ == "__main__":
    main()
