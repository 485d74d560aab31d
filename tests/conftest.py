"""How many processes share the tests, and what many of them use."""

from __future__ import annotations

import contextlib
import gc
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

_MAKE_ECHOES = ("sea", "mesh", "tracing", "echoes", "scattering", "radar")
_READ_ECHOES = ("interferometry", "wavefield", "prediction")
_START_PROCESSES = ("cli", "studies", "stability", "gauges", "validate")
_MOST = 8  # each holds up to 2 GB, and collects all tests anew: more gain little


def _settle(worker: str, workers: int) -> None:
    """A worker gets cores of its own, and all that it starts: on the same cores the threads of two of them wait for
    each other, a fifth of the time. Before NumPy is imported: a BLAS thread that waits for its core does so busily."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        first = int(worker.removeprefix("gw")) % len(cores)
        os.sched_setaffinity(0, cores[first::workers])


settings.register_profile("any machine", deadline=None)  # an example's time is the machine's, and its neighbours'
settings.load_profile("any machine")

if "PYTEST_XDIST_WORKER" in os.environ:
    _settle(os.environ["PYTEST_XDIST_WORKER"], int(os.environ["PYTEST_XDIST_WORKER_COUNT"]))


def pytest_configure(config: pytest.Config) -> None:
    """What a turn frees the next takes again: given back to the system in between, pages cost the tests a twentieth.

    Before workers start, which read it as they do. Some fifty processes keep what they compile of the package, half a
    second each, and workers what they compile of the tests, whatever the environment says.
    """
    if not hasattr(config, "workerinput"):
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        os.environ.setdefault("MALLOC_MMAP_THRESHOLD_", str(2**25))
        os.environ.setdefault("MALLOC_TRIM_THRESHOLD_", str(2**31))


@pytest.fixture
def drawn_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """`seamap-rt run` draws its report in this process, where fixtures reach it: another one takes seconds to load, and
    draws as finely as for a reader. The other one's law is `test_both_processes_draw_the_same`."""

    @contextlib.contextmanager
    def here() -> Iterator[Callable[..., Path]]:
        from seamap_rt.report.page import write_report

        yield write_report

    monkeypatch.setattr("seamap_rt.session.report_process.ReportProcess", here)


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch, drawn_here: None) -> None:
    """The report holds words and tables alone: drawing takes most of a small run's time, and not each test looks."""
    monkeypatch.setattr("seamap_rt.report.page.pictures", lambda *_: ())


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """In a fresh clone a worker compiles the loops that make echoes, and another, which begins in the middle of all
    tests, those that read them: each finds the other's kept. Between them lie tests of files, which need none.

    Tests that start processes come last: each process that came first would compile all loops.
    """
    order = (*_MAKE_ECHOES, "settings", "io", *_READ_ECHOES, "", *_START_PROCESSES)
    places = {name: place for place, name in enumerate(order)}
    items.sort(key=lambda item: places.get(item.path.parent.name, places[""]))


def pytest_collection_finish() -> None:
    """What is there once all tests are collected stays to the end: the collector need not visit a million objects."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """A worker for each core that this process may use; none for a few files, which end before workers would begin."""
    named = [Path(each.split("::")[0]) for each in config.args]
    if config.args_source is pytest.Config.ArgsSource.ARGS and len(named) < 4 and all(path.is_file() for path in named):
        return 0
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return 0 if cores == 1 else min(cores, _MOST)
