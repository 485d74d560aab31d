"""The threads that a process keeps: lent for a piece of work."""

from __future__ import annotations

import subprocess
import sys
import threading

import numpy as np
import pytest

from seamap_rt.compute import machine
from seamap_rt.compute.machine import Workers, run_blocks


@pytest.mark.parametrize("rows", [0, 1, 32, 33, 200, 1000])
@pytest.mark.parametrize("count", [1, 2, 16])
def test_each_row_is_worked_on_once(rows: int, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "threads", lambda: count)
    times = np.zeros(rows, dtype=int)

    def work(begin: int, end: int) -> None:
        times[begin:end] += 1

    run_blocks(work, rows)
    np.testing.assert_array_equal(times, 1)


def test_threads_are_kept() -> None:
    run_blocks(lambda *_: None, 1000)
    before = {each.ident for each in threading.enumerate()}
    for _ in range(20):
        run_blocks(lambda *_: None, 1000)
    assert {each.ident for each in threading.enumerate()} <= before


def test_as_many_work_at_a_time_as_were_asked_for() -> None:
    together = threading.Barrier(3, timeout=10.0)
    with Workers(3) as workers:
        assert workers.count == 3
        list(workers.map(lambda _: together.wait(), range(3)))  # else the barrier breaks


def test_an_error_reaches_who_asked_and_ends_nothing_else() -> None:
    def fail(begin: int, _: int) -> None:
        if begin == 64:
            raise ValueError("row 64")

    with pytest.raises(ValueError, match="row 64"):
        run_blocks(fail, 200)
    rows: list[int] = []
    run_blocks(lambda begin, end: rows.extend(range(begin, end)), 200)
    assert sorted(rows) == list(range(200))


def test_work_may_ask_for_threads_itself() -> None:
    """All of them may be at work on what waits for more of them: that is done at once, not after they end."""
    inner: list[int] = []

    def outer(_: int) -> None:
        run_blocks(lambda begin, end: inner.append(end - begin), 100)

    with Workers(2) as workers:
        list(workers.map(outer, range(4)))
    assert sum(inner) == 400


def test_a_child_that_was_forked_makes_its_own() -> None:
    code = """
import os, sys
from seamap_rt.compute.machine import run_blocks
run_blocks(lambda *_: None, 100)
child = os.fork()
if child == 0:
    run_blocks(lambda *_: None, 100)
    os._exit(7)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", code], check=False)
    assert done.returncode == 7
