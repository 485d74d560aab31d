"""What a point of a sweep costs: seconds of one core by stage, for each height of a trade, and how long workers take to
start.

python -m validation.speed.sweep [--scene choppy_sea] [--heights 5,6,7,8,10] [--seeds 1] [--workers 2]

Wall time counts what else the machine does; processor time does not, and the points of one core need no more.
"""

from __future__ import annotations

import argparse
import os
import statistics
import tempfile
import time
from pathlib import Path

from seamap_rt.scene import as_scene
from seamap_rt.studies.cluster import local_client
from seamap_rt.studies.point import BySea, compute
from seamap_rt.studies.sweep import Sweep

STAGES = ("sea", "mesh", "calibrate", "trace", "echoes", "truth", "retrieve", "total")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="choppy_sea")
    parser.add_argument("--heights", default="5,6,7,8,10", metavar="H,H,…")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    if arguments.workers:
        print(f"{arguments.workers} workers ready after {start_up(arguments.workers):.1f} s")
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    heights = [float(each) for each in arguments.heights.split(",")]
    print(f"{'height':>6} {'seed':>5} " + " ".join(f"{stage:>9}" for stage in STAGES) + f" {'processor':>9}")
    taken = points(arguments.scene, heights, arguments.seeds)
    print(f"median of all but the first: {statistics.median(taken[1:]):.2f} s of the processor")


def start_up(workers: int) -> float:
    """Seconds from nothing to workers that have loaded all that a point needs but the ray tracer."""
    start = time.perf_counter()
    with local_client(workers) as client:
        client.run(os.getpid)
        return time.perf_counter() - start


def points(scene: str, heights: list[float], seeds: int) -> list[float]:
    """Processor seconds of each point, in the order in which one worker takes them."""
    taken = []
    with tempfile.TemporaryDirectory() as folder:
        sweep = Sweep.of(as_scene(scene), {"radar.height_m": heights}, seeds, Path(folder))
        waiting = BySea(sweep.tasks)
        while (task := waiting.take("here")) is not None:
            start = time.process_time()
            outcome = compute(task)
            taken.append(time.process_time() - start)
            seconds = outcome["cost"]["seconds"]
            shown = " ".join(f"{seconds.get(stage, 0.0):9.2f}" for stage in STAGES)
            print(f"{task.keys['radar.height_m']:6g} {task.seed:5} {shown} {taken[-1]:9.2f}")
    return taken


if __name__ == "__main__":
    main()
