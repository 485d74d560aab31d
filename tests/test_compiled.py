"""Compiled loops and what is kept of them on disk."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

MODULE = """from typing import NamedTuple
import numpy as np
from seamap_rt.compute.compiled import compiled

class {name}(NamedTuple):
    height: float

@compiled
def twice(given):
    return 2.0 * given.height

print(twice({name}(1.5)))
"""


def test_a_source_that_renames_a_class_runs_beside_what_was_kept_of_the_old_one(tmp_path: Path) -> None:
    source = tmp_path / "loops.py"
    for n, name in enumerate(("Old", "New")):
        source.write_text(MODULE.format(name=name), encoding="utf-8")
        now = source.stat().st_mtime + 10.0 * n
        os.utime(source, (now, now))
        done = subprocess.run(
            [sys.executable, "-c", "import loops"], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stdout) == (0, "3.0\n"), done.stderr
    assert list(tmp_path.glob("__pycache__/*.nbi"))
