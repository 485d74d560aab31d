"""What of the machine this process may use and has used."""

from __future__ import annotations

import contextlib
import os
import resource
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

from threadpoolctl import ThreadpoolController

_MOST_THREADS = 16  # more gain nothing on blocks as short as ours
_BLOCK = 32  # rows


def cores() -> list[int]:
    """The processors that this process may use, which on a shared machine are fewer than it has."""
    if hasattr(os, "sched_getaffinity"):
        return sorted(os.sched_getaffinity(0))
    return list(range(os.cpu_count() or 1))


def threads() -> int:
    """How many threads a pool takes."""
    return min(_MOST_THREADS, len(cores()))


def pool() -> ThreadPoolExecutor:
    """A pool of `threads()`. Whoever maps work on it must give the same bits for any number of them."""
    return ThreadPoolExecutor(threads())


def in_blocks(work: Callable[[int, int], None], rows: int) -> None:
    """Call work(begin, end) for blocks of so many rows, in threads. Each row must have the same bits in any block."""
    if rows <= _BLOCK:
        work(0, rows)
        return
    with pool() as workers:
        list(workers.map(work, range(0, rows, _BLOCK), (*range(_BLOCK, rows, _BLOCK), rows)))


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """BLAS without threads of its own: they would compete with ours on small products, and could change the bits."""
    with _blas(len(sys.modules)).limit(limits=1, user_api="blas"):
        yield


@lru_cache(maxsize=1)
def _blas(_: int) -> ThreadpoolController:
    """The libraries that are loaded, looked for (3 ms) only where modules have come since: these may bring one."""
    return ThreadpoolController()


def free_memory() -> float:
    """Bytes that the system can still give without paging (Linux; elsewhere without a limit)."""
    with contextlib.suppress(OSError, StopIteration, ValueError):
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return 1024.0 * int(next(line for line in lines if line.startswith("MemAvailable:")).split()[1])
    return float("inf")


def peak_memory() -> int:
    """Most memory [bytes] that this process has held, since `forget_peak_memory` where the system supports it."""
    with contextlib.suppress(OSError, StopIteration, ValueError):
        # A process's own on Linux, where getrusage counts what its parent held when it was started.
        status = Path("/proc/self/status").read_text(encoding="ascii")
        return 1024 * int(next(line for line in status.splitlines() if line.startswith("VmHWM:")).split()[1])
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(peak if sys.platform == "darwin" else 1024 * peak)


def forget_peak_memory() -> None:
    """From here on the peak counts anew (Linux; elsewhere it stays that of the whole process)."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
