"""The report of a second process is the one that is drawn here; and what that process compiles is what a run needs."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import made_run
import pytest
from made_run import Run

from seamap_rt.report.page import write_report
from seamap_rt.session.report_process import ReportProcess

run, coarse_pictures = made_run.run, made_run.coarse_pictures  # fixtures

_COMPARE = """
import sys
from numba.core.registry import CPUDispatcher
from seamap_rt import load_scene, retrieve, simulate
from seamap_rt.session.report_process import compile_retrieval, compile_sum
from seamap_rt.wavefield import sea_state

def signatures():
    parts = ("interferometry", "wavefield", "echoes.summation")
    own = [name for name in sys.modules if name.startswith(tuple(f"seamap_rt.{part}" for part in parts))]
    loops = [each for name in own for each in vars(sys.modules[name]).values() if isinstance(each, CPUDispatcher)]
    return {(each.py_func.__qualname__, str(signature)) for each in loops for signature in each.signatures}

compile_sum()
compile_retrieval()
before = signatures()
sea_state(retrieve(simulate(load_scene("tiny", {"tracing.tracer": "horizon"})).echoes))
assert len(before) > 10, before
print(*sorted(map(str, signatures() - before)), sep="\\n")
"""


_DRAW = """
import os, sys
from seamap_rt.report.page_elements import Picture
from seamap_rt.session.report_process import draw_in_two

parent, dies = os.getpid(), "dies" in sys.argv

def draw():
    if dies and os.getpid() != parent:
        os._exit(1)
    return b"GIF of %d" % os.getpid()

images = draw_in_two([Picture(str(n), "", "", "", draw) for n in range(5)])
print(*[image.name for image in images], {image.kind for image in images}, len(images))
"""


@pytest.mark.parametrize("words", [(), ("dies",)])
def test_two_processes_draw_all_pictures_in_their_order(words: tuple[str, ...]) -> None:
    """Also where one of them is killed with what it has drawn."""
    command = [sys.executable, "-c", _DRAW, *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60.0)
    assert (done.returncode, done.stdout.split()) == (0, [*"01234", "{'gif'}", "5"]), done.stderr


_KILLED = """
import os, time
from seamap_rt.report.page_elements import Picture
from seamap_rt.session.report_process import draw_in_two

parent = os.getpid()

def draw():
    if os.getpid() == parent:
        time.sleep(60.0)
    print(os.getpid(), flush=True)
    return b"GIF" + bytes(10**6)  # more than a pipe holds

draw_in_two([Picture(str(n), "", "", "", draw) for n in range(2)])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere one process draws")
def test_none_of_two_processes_outlives_the_other() -> None:
    """What the second one has drawn waits in a pipe that the first no longer reads."""
    with subprocess.Popen([sys.executable, "-c", _KILLED], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        child = int(process.stdout.readline())
        try:
            process.kill()
            process.communicate(timeout=10.0)  # until nobody holds the pipe
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)


_SERVED = """
import time
from seamap_rt.session.report_process import ReportProcess

class Slow:
    def __reduce__(self):
        return time.sleep, (60.0,)

with ReportProcess() as draw:
    print(draw._process.pid, flush=True)
    draw(Slow())
"""


@pytest.mark.skipif(sys.platform != "linux", reason="Linux alone ends a process with its parent")
def test_it_ends_with_the_process_that_it_serves() -> None:
    """Also in the middle of its work: what it would write then is the next run's."""
    with subprocess.Popen([sys.executable, "-c", _SERVED], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        served = int(process.stdout.readline())
        time.sleep(3.0)  # it has been given its work, or soon will be
        process.kill()
    limit = time.monotonic() + 10.0
    while Path(f"/proc/{served}").exists():
        assert time.monotonic() < limit
        time.sleep(0.05)


def _given(run: Run, folder: Path) -> tuple[Any, ...]:
    return folder, run.scene, run.maps, run.truth, run.metrics, run.echoes


def test_both_processes_draw_the_same(run: Run, tmp_path: Path) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    write_report(*_given(run, here))
    with ReportProcess() as draw:
        assert draw(*_given(run, there)) == there / "report.html"
    names = sorted(each.name for each in here.iterdir())
    assert names == sorted(each.name for each in there.iterdir())
    one, other = (re.sub(r"base64,[^\"]*", "", (each / "report.html").read_text()) for each in (here, there))
    assert one == other  # but for pictures: this process draws them coarsely, for speed


def test_a_process_that_has_ended_leaves_the_drawing_here(run: Run, tmp_path: Path) -> None:
    with ReportProcess() as draw:
        assert draw._process is not None
        draw._process.kill()
        draw._process.wait()
        assert draw(*_given(run, tmp_path)).is_file()


def test_an_error_of_the_drawing_is_raised_here_and_no_module_of_the_users_own_folder_is_taken_for_a_library(
    tmp_path: Path, monkeypatch: Any, run: Run
) -> None:
    (tmp_path / "numpy.py").write_text(f"open({str(tmp_path / 'loaded')!r}, 'w').close()")
    (tmp_path / "file").write_text("no folder")
    monkeypatch.chdir(tmp_path)
    with ReportProcess() as draw, pytest.raises(OSError, match="file"):
        draw(*_given(run, tmp_path / "file"))
    assert not (tmp_path / "loaded").exists()


def test_nothing_is_left_of_a_process_that_was_given_nothing() -> None:
    with ReportProcess() as draw:
        process = draw._process
    assert process is not None
    assert process.returncode is not None


def test_what_is_compiled_before_is_what_a_retrieval_needs() -> None:
    ended = subprocess.run([sys.executable, "-c", _COMPARE], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.strip() == ""
