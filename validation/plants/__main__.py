"""Plants errors in copies of the tree and demands that the named check of each fails.

python -m validation.plants [--only NAME] [--sample N] [--workers 2]

Some minutes on two cores. First each check runs without an error and must be green. Prints plant, check, seconds and
whether it turned red. Exit 1 where a plant stays green, cannot be planted, or its check ends by an error before it.
"""

from __future__ import annotations

import argparse
import sys

from .plant import Plant
from .rows import PLANTS
from .running import run


def chosen(only: str | None, sample: int | None) -> list[Plant]:
    """Plants whose name holds `only`, and of those `sample` evenly over the table."""
    plants = [plant for plant in PLANTS if only is None or only in plant.name]
    if sample is None or sample >= len(plants):
        return plants
    return [plants[number * len(plants) // sample] for number in range(sample)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", metavar="NAME", help="plants whose name holds this")
    parser.add_argument("--sample", type=int, metavar="N", help="so many, evenly over the table")
    parser.add_argument("--workers", type=int, default=2, help="copies of the tree that are worked on at a time")
    arguments = parser.parse_args()
    if min(arguments.workers, 1 if arguments.sample is None else arguments.sample) < 1:
        parser.error("--workers and --sample must be at least 1")
    plants = chosen(arguments.only, arguments.sample)
    if not plants:
        parser.error(f"--only {arguments.only}: no plant's name holds it; names: {', '.join(p.name for p in PLANTS)}")
    wrong = run(plants, arguments.workers, lambda line: print(line, flush=True))
    print(f"{len(plants)} plants, {len(wrong)} not as they must be" + (f": {', '.join(wrong)}" if wrong else ""))
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
