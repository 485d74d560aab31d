"""What a run answers under limits of its memory: `python -m validation.hard_cases.limits` prints a table.

A run succeeds, or ends with exit code 4 and one line.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
from itertools import chain

TRACERS = ("facets", "horizon")
ADDRESSES_MB, DATA_MB = range(600, 1501, 100), range(150, 551, 100)
_MOST_S = 120.0


def under(kind: int, most: int, words: list[str]) -> tuple[int, list[str]]:
    """Exit code and lines on stderr of a command of the program whose limit of this kind is `most` bytes."""
    done = subprocess.run(
        [sys.executable, "-m", "seamap_rt.cli", *words],
        preexec_fn=lambda: resource.setrlimit(kind, (most, most)),
        capture_output=True,
        text=True,
        errors="replace",
        timeout=_MOST_S,
    )
    return done.returncode, done.stderr.splitlines()


def keeps_the_law(code: int, lines: list[str]) -> bool:
    """Success, or one line with exit code 4."""
    return code == 0 or (code == 4 and len(lines) == 1 and lines[0].startswith("seamap-rt: memory"))


def main() -> int:
    """Print the table; 1 where a limit breaks the law."""
    broken = 0
    limits = chain(
        ((resource.RLIMIT_AS, "RLIMIT_AS", most) for most in ADDRESSES_MB),
        ((resource.RLIMIT_DATA, "RLIMIT_DATA", most) for most in DATA_MB),
    )
    for kind, name, most in limits:
        for tracer in TRACERS:
            with tempfile.TemporaryDirectory() as folder:
                code, lines = under(kind, most * 10**6, ["run", "tiny", "--tracer", tracer, "--out", f"{folder}/run"])
            right = keeps_the_law(code, lines)
            broken += not right
            print(f"{name:<11} {most:>5} MB  {tracer:<8} {code:>3}  {'' if right else 'WRONG '}{' '.join(lines)[:150]}")
    return int(broken > 0)


if __name__ == "__main__":
    sys.exit(main())
