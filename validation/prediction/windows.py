"""Quiet windows that are called from maps, against the sea that came.

    python -m validation.prediction.windows [--seeds 6] [--first 601] [--turns 40] [--sea choppy_sea]
        [--out validation/figures/quiet_windows.png]
    python -m validation.prediction.windows --draw N

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

With --draw N six seas are drawn instead, as those of `forecasts --draw`: two crossing, one long, three others; a line a
sea, and the figures of all together.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.prediction import Predictor, WaveField
from seamap_rt.report import style
from seamap_rt.report.forecast_figures import quiet_windows
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator
from seamap_rt.window_errors import Windows, area, judge_windows, reliability

from ..draws import in_words
from .forecasts import FIRST, SEAS, scene_of, scenes_drawn

Field = NDArray[np.float64]

LIMIT, LASTS_S, CONFIDENCE = 0.35, 5.0, 0.9  # of the significant wave height
LEADS = np.arange(5.0, 16.0)
STEP_S = 0.1
HIGHEST_S = 15.0


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


def run(scene: Scene) -> tuple[Windows, Field]:
    """A scene's windows (issue · lead,) with every method's score, and rows of its highest crests."""
    simulator, predictor = Simulator(scene), Predictor()
    height = np.sqrt(sum(each.model_dump()["significant_wave_height_m"] ** 2 for each in scene.sea.waves))
    rows: dict[str, list[Field]] = {"quiet": [], "forecast": [], "persistence": [], "group law": [], "crest": []}
    for number in range(scene.turns):
        polar = sr.retrieve(simulator.turn(number).echoes, scene.resolved_retrieval)["polar"].to_dataset()
        field = predictor.turn(polar.isel(turn=0))
        if field is None or number < FIRST:
            continue
        limit = LIMIT * height
        drawn = sr.forecast(field, lead_s=np.arange(0.0, LEADS[-1] + LASTS_S + 0.25, 0.25), draws=200)
        called = sr.quiet_windows(drawn, {"elevation": limit}, LASTS_S, CONFIDENCE).sel(lead=LEADS)
        low, expected = group_law(field)
        rows["quiet"].append(came_true(simulator, field.issued, limit).astype(np.float64))
        rows["forecast"].append(called["probability"].values.ravel())
        rows["persistence"].append(np.full(LEADS.size, low))
        rows["group law"].append(expected)
        highest = sr.highest_wave(drawn, HIGHEST_S).squeeze()
        told = [float(highest[name]) for name in ("crest", "crest_low", "crest_high", "lead", "chance")]
        rows["crest"].append(np.array([[*told, *crest_that_came(simulator, field.issued), height / 4.0]]))
    if not rows["crest"]:
        raise LookupError("no turn shows a sea")
    every = {key: np.concatenate(part) for key, part in rows.items()}
    others = {key: every[key] for key in ("persistence", "group law")}
    return Windows(every["forecast"], every["quiet"] > 0.5, others), every["crest"]


def print_crests(rows: Field) -> None:
    """rows (issue, …): told crest, low, high, lead and chance; the crest that came and when; σ."""
    crest, low, high, lead, chance, came, when, sigma = rows.T
    print(
        f"highest crest of {HIGHEST_S:g} s: correlation {np.corrcoef(crest, came)[0, 1]:.3f}, rms "
        f"{np.sqrt(np.mean(((crest - came) / sigma) ** 2)):.3f} σ, between low and high "
        f"{np.mean((came > low) & (came < high)):.0%}; within a second of its time "
        f"{np.mean(np.abs(when - lead) <= 1.0):.0%}, stated {chance.mean():.0%}"
    )


def report(runs: list[Windows], crests: Field) -> None:
    """Print what was called, how often it came true, and how much better than the baselines that is."""
    chance, quiet = (np.concatenate([getattr(each, name) for each in runs]) for name in ("chance", "quiet"))
    told = {name: np.concatenate([each.others[name] for each in runs]) for name in runs[0].others}
    found = judge_windows(Windows(chance, quiet, told), CONFIDENCE)
    print(f"{found['windows']} windows, {found['quiet_share']:.0%} quiet")
    print(
        f"called {found['called']}: right {found['right']:.1%}, stated {chance[chance >= CONFIDENCE].mean():.1%}; "
        f"called of the quiet ones {found['found']:.1%}"
    )
    print(f"Brier {found['brier']:.3f}, climatology {found['climatology_brier']:.3f}")
    for name, score in ({"forecast": chance} | told).items():
        areas = [area(each.others.get(name, each.chance), each.quiet) for each in runs]
        print(f"AUC {name}: {area(score, quiet):.3f} (runs {np.nanmin(areas):.3f}–{np.nanmax(areas):.3f})")
    for each in reliability(runs):
        band = f"[{each.low:.2f}, {each.high:.2f}]"
        print(f"  {each.count} windows, {each.stated:.2f} stated, {each.found:.2f} quiet {band}")
    print_crests(crests)


def drawn_runs(number: int) -> list[tuple[Windows, Field]]:
    """Six drawn seas, a line each."""
    scenes, parts = scenes_drawn(number), []
    for scene in (*scenes[:2], *scenes[4:5], *scenes[6:9]):
        try:
            parts.append(run(scene))
        except LookupError as none:
            print(f"{scene.name}: {in_words(scene)}: {none}", flush=True)
            continue
        windows, chance = parts[-1][0], parts[-1][0].chance
        called = chance >= CONFIDENCE
        print(
            f"{scene.name}: {in_words(scene)}: {windows.quiet.mean():.0%} quiet; called {called.sum()}, right "
            f"{windows.quiet[called].sum()}; stated in the mean {chance.mean():.2f}",
            flush=True,
        )
    return parts


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--first", type=int, default=601)
    parser.add_argument("--turns", type=int, default=40)
    parser.add_argument("--sea", default="choppy_sea", choices=list(SEAS))
    parser.add_argument("--out", type=Path)
    parser.add_argument("--draw", type=int)
    given = parser.parse_args()
    if given.draw is not None:
        parts = drawn_runs(given.draw)
    else:
        print(f"{given.sea}:")
        parts = [run(scene_of(given.sea, given.first + n, given.turns)) for n in range(given.seeds)]
    runs = [part[0] for part in parts]
    report(runs, np.concatenate([part[1] for part in parts]))
    if given.out:
        given.out.write_bytes(style.png(quiet_windows(runs, CONFIDENCE)))


if __name__ == "__main__":
    main()
