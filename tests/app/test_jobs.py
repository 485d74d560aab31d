"""The queue: one command after another in processes of their own; how each ended is known, whoever ended it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from seamap_rt.app import jobs
from seamap_rt.app.jobs import Job, Queue, State, read_progress
from seamap_rt.io.process import VARIABLE

_PROGRAM = """
import os, signal, sys, time
from pathlib import Path
what, out = sys.argv[1], Path(sys.argv[2])
out.mkdir(exist_ok=True)
(out / "began").write_text(str(time.time()))
with open(os.environ["SEAMAP_RT_PROGRESS"], "a") as file:
    file.write(f"{time.time():.3f} turn 1 of 3: simulating\\n")
if what == "refuse":
    print("seamap-rt: radar.height_m = 500: must be lower", file=sys.stderr)
    sys.exit(2)
def stop(*_):
    print("seamap-rt: interrupted: 1 of 3 turns are complete", file=sys.stderr)
    sys.exit(130)
signal.signal(signal.SIGTERM, stop)
(out / "ready").touch()
if what == "wait":
    time.sleep(60)
(out / "ended").write_text(str(time.time()))
"""


@pytest.fixture
def queue(tmp_path: Path) -> Iterator[Queue]:
    made = Queue(tmp_path, (sys.executable, "-c", _PROGRAM))
    yield made
    made.close()


def _wait(true: Callable[[], bool]) -> None:
    until = time.monotonic() + 120.0  # of a machine that others use
    while not true():
        assert time.monotonic() < until, "did not come"
        time.sleep(0.01)


def _add(queue: Queue, what: str, folder: str) -> Job:
    return queue.add(what, folder, 'name = "x"\n', [what, "{out}"])


def test_jobs_run_one_after_another_and_end_as_done(queue: Queue, tmp_path: Path) -> None:
    first, second = _add(queue, "run", "a"), _add(queue, "run", "b")
    _wait(lambda: second.is_over)
    assert (first.state, second.state) == ("done", "done")
    assert (tmp_path / "a/ended").read_text() <= (tmp_path / "b/began").read_text()


def test_a_refusal_is_told_in_the_words_of_the_command(queue: Queue) -> None:
    job = _add(queue, "refuse", "a")
    _wait(lambda: job.is_over)
    assert (job.state, job.reason) == ("failed", "radar.height_m = 500: must be lower")
    assert queue.progress(job).line == job.reason


def test_a_running_job_is_asked_to_end_and_a_waiting_one_is_never_begun(queue: Queue, tmp_path: Path) -> None:
    running, waiting = _add(queue, "wait", "a"), _add(queue, "run", "b")
    _wait((tmp_path / "a/ready").exists)
    assert waiting.state == "queued"
    queue.cancel(waiting.name)
    queue.cancel(running.name)
    _wait(lambda: running.is_over and waiting.is_over)
    assert (running.state, running.reason) == ("cancelled", "interrupted: 1 of 3 turns are complete")
    assert waiting.state == "cancelled"
    assert not (tmp_path / "b").exists()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_job_cancelled_before_it_can_answer_is_cancelled(tmp_path: Path, number: signal.Signals) -> None:
    """While its modules load it dies of the signal, or of the interrupt that its handler raises."""
    program = "import os, signal, sys, time; from pathlib import Path; signal.signal(signal.SIGTERM, lambda *_: "
    program += f"(signal.signal({number:d}, signal.SIG_DFL), os.kill(os.getpid(), {number:d}))); "
    program += f"Path({str(tmp_path / 'ready')!r}).touch(); time.sleep(60)"
    queue = Queue(tmp_path, (sys.executable, "-c", program))
    job = _add(queue, "wait", "a")
    _wait((tmp_path / "ready").exists)
    queue.cancel(job.name)
    _wait(lambda: job.is_over)
    assert (job.state, job.reason) == ("cancelled", "cancelled before it began")
    queue.close()


def test_a_killed_job_says_so_and_the_next_one_runs(queue: Queue, tmp_path: Path) -> None:
    job, after = _add(queue, "wait", "a"), _add(queue, "run", "b")
    _wait((tmp_path / "a/ready").exists)
    os.kill(job.pid, signal.SIGKILL)
    _wait(lambda: after.is_over)
    assert job.state == "failed"
    assert "SIGKILL" in job.reason
    assert "no whole turn was left" in job.reason
    assert after.state == "done"


def test_a_server_that_is_started_again_finds_what_ran_and_what_runs_on(tmp_path: Path) -> None:
    first = Queue(tmp_path, (sys.executable, "-c", _PROGRAM))
    done, running = _add(first, "run", "a"), _add(first, "wait", "b")
    _wait((tmp_path / "b/ready").exists)
    second = Queue(tmp_path, (sys.executable, "-c", _PROGRAM))
    found = {job.folder: job for job in second.jobs()}
    assert (found["a"].state, found["b"].state) == ("done", "running")
    assert found["b"].pid == running.pid
    second.cancel(found["b"].name)
    _wait(lambda: found["b"].is_over and running.is_over)
    assert found["b"].state in ("cancelled", "failed")
    assert done.is_over
    for each in (first, second):
        each.close()


def test_a_damaged_note_of_a_job_is_passed_over(tmp_path: Path) -> None:
    folder = tmp_path / ".jobs"
    folder.mkdir()
    for name, content in (("a", "{"), ("b", "[]"), ("c", '{"words": 3}'), ("d", '{"name": "d", "words": []}')):
        (folder / f"{name}.json").write_text(content)
    queue = Queue(tmp_path)
    assert queue.jobs() == []
    queue.close()


# ----------------------------------------------------------------------------------------- whose a process is


def _note(runs: Path, job: str, /, **told: Any) -> None:
    (runs / ".jobs").mkdir(exist_ok=True)
    whole = {"name": job, "title": "t", "folder": "a", "words": ["wait"], "state": "running", "started": time.time()}
    (runs / ".jobs" / f"{job}.json").write_text(json.dumps({**whole, **told}))


@pytest.fixture(params=["nothing", "another job's file", "our own session"])
def stranger(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A process that no page began, by what its environment says, or in the group of the one that asks."""
    environment = dict(os.environ)
    if request.param == "another job's file":
        environment[VARIABLE] = str(tmp_path / ".jobs" / "a.11.progress")
    own = request.param != "our own session"
    with subprocess.Popen(["sleep", "600"], env=environment, start_new_session=own) as process:
        yield process
        process.kill()


def test_a_stranger_who_has_the_number_of_a_run_is_no_run_and_is_never_signalled(
    tmp_path: Path, stranger: subprocess.Popen[bytes]
) -> None:
    """By a note of any state; a new job does not wait for it, and neither Cancel, twice, nor the end of the page."""
    for number, state in enumerate(("queued", "running", "done", "cancelled", "failed")):
        _note(tmp_path, f"a.{number}", state=state, pid=stranger.pid)
    _note(tmp_path, "a.9", pid=stranger.pid, reason="stopped by the user")
    queue = Queue(tmp_path, (sys.executable, "-c", _PROGRAM))
    try:
        assert all(job.is_over for job in queue.jobs())
        after = _add(queue, "run", "b")
        _wait(lambda: after.is_over)
        assert after.state == "done"
        for job in queue.jobs():  # and where a note came between
            job.state, job.pid = "running", stranger.pid
            queue.cancel(job.name)
            queue.cancel(job.name)
    finally:
        queue.close()
    with pytest.raises(subprocess.TimeoutExpired):
        stranger.wait(0.5)


def test_the_end_of_a_page_ends_what_it_began_alone_and_cancel_a_run_of_an_earlier_one_too(tmp_path: Path) -> None:
    first = Queue(tmp_path, (sys.executable, "-c", _PROGRAM))
    running = _add(first, "wait", "a")
    _wait((tmp_path / "a/ready").exists)
    second = Queue(tmp_path, (sys.executable, "-c", _PROGRAM))
    assert [job.state for job in second.jobs()] == ["running"]
    begin = time.monotonic()
    second.close()
    assert time.monotonic() - begin < 5.0  # it does not wait for what it has not begun
    time.sleep(0.3)
    assert not running.is_over
    first.close()
    assert running.state == "cancelled"


@pytest.mark.parametrize("pid", [0, -1, 1, "this", 2**31, 2**70])
def test_no_number_in_a_note_is_a_run_by_itself(tmp_path: Path, pid: Any) -> None:
    _note(tmp_path, "a.1", pid=os.getpid() if pid == "this" else pid)
    queue = Queue(tmp_path)
    assert all(job.is_over for job in queue.jobs())
    queue.close()


@pytest.mark.parametrize(
    "told",
    [
        {"name": "../../a"},  # which "take off the list" would remove
        {"name": "b"},
        {"folder": "../elsewhere"},
        {"folder": "/etc"},
        {"folder": "a\0b"},
        {"state": "sailing"},
        {"words": []},
        {"words": [1]},
        {"asked": "now"},
        {"asked": {}},
    ],
    ids=str,
)
def test_a_note_that_is_none_of_a_job_is_passed_over(tmp_path: Path, told: dict[str, Any]) -> None:
    _note(tmp_path, "a.1", **told)
    queue = Queue(tmp_path)
    assert queue.jobs() == []
    queue.close()


def test_signals_are_sent_in_one_place_and_numbers_of_processes_believed_in_one() -> None:
    """Whoever sends a signal, or asks whether a number lives, must ask whose it is: few do."""
    package = Path(__file__).parents[2] / "seamap_rt"
    sends = ("os.kill(", "os.killpg(", ".send_signal(", ".terminate(", "pidfd_send_signal(", ".kill()", "alive(")
    found = {
        (str(path.relative_to(package)), word)
        for path in package.rglob("*.py")
        for word in sends
        if word in path.read_text()
    }
    assert found == {
        ("app/drawing.py", ".terminate("),  # of multiprocessing's own children
        ("app/jobs.py", "os.kill("),
        ("app/jobs.py", "os.killpg("),
        ("session/report_process.py", ".kill()"),  # of the process that it started itself
        ("compute/locks.py", "os.kill("),  # signal 0: whether there is one
        ("compute/locks.py", "alive("),
        ("io/stream.py", "alive("),  # of a thread of its own
    }


def test_a_process_that_is_started_takes_no_module_of_the_users_folder() -> None:
    """Python puts the folder it is started in first, where a user's numpy.py may lie; not with -P."""
    package = Path(__file__).parents[2] / "seamap_rt"
    started = [
        f"{path.relative_to(package)}: {line.strip()}"
        for path in package.rglob("*.py")
        for line in path.read_text().splitlines()
        if "sys.executable, " in line
    ]
    assert len(started) >= 4
    assert [each for each in started if 'sys.executable, "-P"' not in each] == []


# ---------------------------------------------------------------------------------------------------- progress


def _told(tmp_path: Path, *lines: tuple[float, str]) -> Path:
    path = tmp_path / "x.progress"
    path.write_text("".join(f"{when:.3f} {words}\n" for when, words in lines))
    return path


def _job(state: State = "running", started: float = 100.0) -> Job:
    return Job("x", "x", "x", ("run",), state=state, started=started, guess_s=30.0)


def test_the_time_left_is_that_of_the_turns_left_at_the_pace_of_the_warm_ones(tmp_path: Path) -> None:
    lines = [
        (100.0, "preparing"),
        *((110.0 + (8.0 if n else 0.0) + 2.0 * n, f"turn {n + 1} of 10: simulating") for n in range(4)),
    ]
    now = read_progress(_told(tmp_path, *lines), _job(), now=124.0)
    assert now.turns == 3
    assert now.left_s == pytest.approx(7 * 2.0 + 5.0)  # seven turns of two seconds, and what comes after
    assert 0.2 < now.share < 0.4


@pytest.mark.parametrize(
    ("line", "left"),
    [("turn 2 of 9: mesh, at most 26 s left", 26.0), ("turn 2 of 9: trace, about 1.5 min left", 90.0)],
)
def test_the_time_left_is_the_commands_own_where_it_tells_one(tmp_path: Path, line: str, left: float) -> None:
    now = read_progress(_told(tmp_path, (110.0, "turn 1 of 9: mesh, … left"), (120.0, line)), _job(), now=121.0)
    assert (now.left_s, now.turns, now.of) == (left, 1, 9)
    assert "left" not in now.line


def test_of_a_trade_the_points_count(tmp_path: Path) -> None:
    now = read_progress(_told(tmp_path, (120.0, "3 of 12 points, about 60 s left")), _job(), now=130.0)
    assert (now.turns, now.of, now.share) == (3, 12, 0.25)
    assert now.left_s == pytest.approx(90.0)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\n", b"no time\n", b"1.0\n", b"1e999 turn 1 of 0: x\n"])
def test_a_damaged_file_of_progress_is_no_error(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.progress"
    path.write_bytes(content)
    for job in (_job(), _job("done")):
        now = read_progress(path, job, now=101.0)
        assert 0.0 <= now.share <= 1.0
        assert now.left_s is None or now.left_s >= 0.0


# -------------------------------------------------------------------------------------------------------- pace


def _done(runs: Path, kind: str, *took: tuple[float, float, float]) -> Queue:
    """A queue that finds jobs that were done: seconds that each took, was guessed to take, and how crowded it was."""
    (runs / ".jobs").mkdir(parents=True, exist_ok=True)
    for number, (seconds, guess, crowd) in enumerate(took):
        job = Job(f"{kind}{number}", "x", "x", (kind,), state="done", asked=float(number), guess_s=guess, crowd=crowd)
        job.started, job.ended = 1000.0 * number, 1000.0 * number + seconds
        (runs / ".jobs" / f"{job.name}.json").write_text(json.dumps(asdict(job)))
    return Queue(runs)


def test_nothing_is_called_about_so_long_before_one_was_done_here(tmp_path: Path) -> None:
    queue = _done(tmp_path, "trade", (20.0, 10.0, 1.0))
    assert queue.pace("run") is None
    for lines in ((), ((110.0, "preparing"),), ((110.0, "turn 1 of 9: mesh, … left"),), ((110.0, "comparing"),)):
        told = read_progress(_told(tmp_path, *lines), _job(), now=111.0, pace=queue.pace("run"))
        assert told.left_s is None
    queue.close()


@pytest.mark.parametrize(("load", "cores", "crowd"), [(0.3, 4, 1.0), (4.0, 4, 1.0), (6.0, 2, 3.0)])
def test_a_guess_is_scaled_by_the_last_runs_and_by_who_else_wants_the_cores(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, load: float, cores: int, crowd: float
) -> None:
    monkeypatch.setattr(os, "getloadavg", lambda: (load, 0.0, 0.0))
    monkeypatch.setattr(jobs, "cores", lambda: list(range(cores)))
    # the first is of long ago; the others took twice the guess, or eight times where four wanted each core
    queue = _done(tmp_path, "run", (900.0, 10.0, 1.0), (20.0, 10.0, 1.0), (80.0, 10.0, 4.0), (60.0, 30.0, 1.0))
    assert queue.pace("run") == pytest.approx(2.0 * crowd)
    told = read_progress(_told(tmp_path, (101.0, "preparing")), _job(), now=101.0, pace=queue.pace("run"))
    assert told.left_s == pytest.approx(30.0 * 2.0 * crowd)
    queue.close()


def test_a_run_gives_way_to_the_page(queue: Queue, tmp_path: Path) -> None:
    job = _add(queue, "wait", "a")
    _wait(lambda: (tmp_path / "a" / "ready").exists())
    assert os.getpriority(os.PRIO_PROCESS, job.pid) > os.getpriority(os.PRIO_PROCESS, 0)
