"""Seconds from a turn's echoes to its line out, by stage: what a helm waits for.

python -m validation.speed.latency [--scene choppy_sea] [--tracer horizon] [--turns 20] [--from-turn 6]

Each turn is simulated first, off the clock; then its map is retrieved, the wave field fitted, a forecast issued with
the motions of a box of 7 m × 2.5 m × 0.5 m, and the message written, which holds advice on 36 courses. Medians are of
the turns from --from-turn on, when most of the kept turns are there; the greatest is of all but the first.
"""

from __future__ import annotations

import time

import numpy as np

import seamap_rt as sr
from seamap_rt.prediction import Box, issue, predictor_of
from seamap_rt.session.streaming import Composer
from seamap_rt.simulation import Simulator

from ..options import options

STAGES = ("retrieve", "fit", "issue", "message", "in all")


def main() -> None:
    given = options(__doc__, scene="choppy_sea", tracer="horizon", turns=20, from_turn=6)
    scene = sr.load_scene(given.scene, {"turns": given.turns, "tracing.tracer": given.tracer})
    simulator, settings = Simulator(scene), scene.resolved_prediction
    predictor, vessel = predictor_of(settings), Box(7.0, 2.5, 0.5)
    composer = Composer(vessel)
    rows = []
    for number in range(scene.turns):
        echoes = simulator.turn(number).echoes
        clock = [time.perf_counter()]
        polar = sr.retrieve(echoes, scene.resolved_retrieval)["polar"].to_dataset().isel(turn=0)
        clock.append(time.perf_counter())
        field = predictor.turn(polar)
        clock.append(time.perf_counter())
        forecast = None if field is None else (field, issue(field, number, settings, vessel))
        clock.append(time.perf_counter())
        composer.compose(echoes, polar, forecast).line()
        clock.append(time.perf_counter())
        rows.append([*np.diff(clock), clock[-1] - clock[0]])
    found = np.array(rows)
    print("| stage | median (s) | greatest (s) |\n|---|---|---|")
    for stage, seconds in zip(STAGES, found.T, strict=True):
        print(f"| {stage} | {np.median(seconds[given.from_turn - 1 :]):.2f} | {seconds[1:].max():.2f} |")


if __name__ == "__main__":
    main()
