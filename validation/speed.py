"""How fast a turn is: seconds per stage of warm turns of a scene, medians over turns, each tracer in turn.

python validation/speed.py [--scene choppy_sea] [--turns 5] [--set sea.model=choppy]
"""

from __future__ import annotations

import argparse
import resource
import statistics
import time

import seamap_rt as sr
from seamap_rt.interferometry import retrieve_one
from seamap_rt.simulation import Simulator

STAGES = ("sea", "mesh", "trace", "echoes", "truth", "retrieve", "total")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="choppy_sea")
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="any key of the scene")
    arguments = parser.parse_args()
    changes = dict(pair.split("=", 1) for pair in arguments.set)
    print(f"{'tracer':8} {'turn':>6} " + " ".join(f"{stage:>9}" for stage in STAGES) + f" {'real time':>10}")
    for tracer in ("facets", "horizon"):
        scene = sr.load_scene(arguments.scene, overrides={**changes, "tracing.tracer": tracer})
        simulator, rows = Simulator(scene), []
        for number in range(arguments.turns + 1):
            turn = simulator.turn(number)
            start = time.perf_counter()
            retrieve_one(turn.echoes, scene.retrieval)
            timing = {**turn.timing, "retrieve": time.perf_counter() - start}
            timing["total"] += timing["retrieve"]
            rows.append(timing)
        for label, chosen in (("first", rows[:1]), ("warm", rows[1:])):
            middle = {stage: statistics.median(row[stage] for row in chosen) for stage in STAGES}
            busy = sum(middle[stage] for stage in ("sea", "mesh", "trace", "echoes"))
            factor = scene.turn_duration_s / busy
            shown = " ".join(f"{middle[stage]:9.3f}" for stage in STAGES)
            print(f"{tracer:8} {label:>6} {shown} {factor:10.2f}")
    print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.2f} GiB")


if __name__ == "__main__":
    main()
