"""Damaged scenes and files against the laws of the program's answers: see the package.

python -m validation.fuzz [--scenes 10000] [--files 2000] [--seed 1] [--keep DIR] [--case KIND/NUMBER]

Some minutes on two cores. Prints how many of each kind were accepted and refused, and each failure with its case, which
`--case` does again; its file stays in the folder of `--keep`. Exit 1 where a case broke a law.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from .running import Plan, run


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=10_000)
    parser.add_argument("--files", type=int, default=2_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder for the files of cases that fail; default a temporary one")
    parser.add_argument("--case", help="KIND/NUMBER, to do a single one again")
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    kept = arguments.keep or Path(tempfile.mkdtemp(prefix="fuzz-"))
    plan = Plan(arguments.seed, arguments.scenes, arguments.files, arguments.case)
    failures = run(plan, kept, arguments.workers, print)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
