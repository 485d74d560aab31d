"""A simulation that turns on and on holds no more memory than it held once it was warm: no turn leaves anything behind.

The small scene runs in a process of its own, whose memory no other test has filled, with one arena for all threads:
else glibc gives threads arenas as they happen to meet, and what fills is theirs. `validation/speed/scaling.py` has 600
turns as they come, and their seconds: 0.014 to 0.052 more.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

TURNS, WARM, COMPARED = 70, 25, 15
FLAT = 0.03  # found: 0.001 to 0.004. Of 480 MB held, 0.6 MB a turn make 0.044.

MARCH = """
import json, os, sys
from pathlib import Path
import seamap_rt as sr
from seamap_rt.report import page
from seamap_rt.session import run
from seamap_rt.simulation import Simulator

turns, out = sys.argv[1:]
keys = {"radar.sector_deg": [265.0, 275.0], "radar.range_m": [15.0, 30.0], "sea.extent_m": 120.0}
scene = sr.load_scene("choppy_sea", {**keys, "tracing.tracer": "facets", "turns": int(turns)})
held, turn = [], Simulator.turn

def watched(self, number, *told):
    held.append(int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE"))
    return turn(self, number, *told)

Simulator.turn = watched
page.pictures = lambda *_: ()  # drawn after the last turn, before which its memory is read
run(scene, out)
print(json.dumps(held))
"""


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory held is read from Linux's /proc")
@pytest.mark.slow
def test_memory_is_flat_over_turns(tmp_path: Path) -> None:
    """With rays, of which scenes are kept from turn to turn, and all that a run adds to a simulation."""
    done = subprocess.run(
        [sys.executable, "-c", MARCH, str(TURNS), str(tmp_path / "out")],
        env={**os.environ, "MALLOC_ARENA_MAX": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    held = np.array(json.loads(done.stdout.splitlines()[-1]), dtype=np.float64)
    assert held.size == TURNS
    early, late = np.median(held[WARM : WARM + COMPARED]), np.median(held[-COMPARED:])
    assert late / early == pytest.approx(1.0, abs=FLAT), f"MB held: {(held[::5] / 1e6).round().tolist()}"
