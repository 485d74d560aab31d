"""Damaged scenes and files against the laws of the program's answers: see the package.

python -m validation.fuzz [--scenes 10000] [--files 2000] [--seed 1] [--keep DIR] [--case KIND/NUMBER]
    [--workers 2]

Some minutes on two cores. Prints how many of each kind were accepted and refused, and each failure with its case, which
`--case` does again; its file stays in the folder of `--keep`. Exit 1 where a case broke a law.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from ..options import options
from .running import Plan, run


def main() -> None:
    arguments = options(__doc__, scenes=10_000, files=2_000, seed=1, keep=Path, case=str, workers=2)
    kept = arguments.keep or Path(tempfile.mkdtemp(prefix="fuzz-"))
    plan = Plan(arguments.seed, arguments.scenes, arguments.files, arguments.case)
    failures = run(plan, kept, arguments.workers, print)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
