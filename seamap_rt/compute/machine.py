"""The share of the machine that this process may use and has used."""

from __future__ import annotations

import contextlib
import os
import resource
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from threadpoolctl import ThreadpoolController

from ..errors import ResourceError

_MOST_THREADS = 16  # more gain nothing on blocks as short as ours
_BLOCK, _MOST_BLOCKS = 32, 64  # rows, at least; of many rows so many blocks
_AT_WORK = threading.local()

T = TypeVar("T")


def cores() -> list[int]:
    """The processors that this process may use, which on a shared machine are fewer than it has."""
    if hasattr(os, "sched_getaffinity"):
        return sorted(os.sched_getaffinity(0))
    return list(range(os.cpu_count() or 1))


def threads() -> int:
    """How many threads a pool takes."""
    return min(_MOST_THREADS, len(cores()))


class Workers(ThreadPoolExecutor):
    """`count` threads that are kept: to make two and to wait for their end costs ten times what a short block of rows
    does. They also run what is no compiled loop (transforms, batches that draw random numbers), which Numba's own
    parallel loops do not."""

    def __init__(self, count: int) -> None:
        super().__init__(count, "rows", initializer=lambda: setattr(_AT_WORK, "here", True))
        self.count = count

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """As of any executor. Work that itself asks for threads is done there and then: those who wait would never end
        where all of them wait."""
        if not getattr(_AT_WORK, "here", False):
            return super().submit(fn, *args, **kwargs)
        done: Future[T] = Future()
        try:
            done.set_result(fn(*args, **kwargs))
        except BaseException as error:
            done.set_exception(error)
        return done

    def __exit__(self, *_: object) -> None:
        """They are kept; who leaves has waited for what was wanted."""


kept_workers = cache(Workers)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=kept_workers.cache_clear)  # a child has none of its parent's threads


def pool() -> Workers:
    """`threads()` of them. Whoever maps work on it must give the same bits for any number of them."""
    return kept_workers(threads())


def run_blocks(work: Callable[[int, int], None], rows: int) -> None:
    """Call work(begin, end) for blocks of so many rows, in threads. Each row must have the same bits in any block."""
    if rows <= _BLOCK:
        work(0, rows)
        return
    block = max(_BLOCK, -(-rows // _MOST_BLOCKS))
    with pool() as workers:
        list(workers.map(work, range(0, rows, block), (*range(block, rows, block), rows)))


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """BLAS without threads of its own: they would compete with ours on small products, and could change the bits."""
    with _blas(len(sys.modules)).limit(limits=1, user_api="blas"):
        yield


@lru_cache(maxsize=1)
def _blas(_: int) -> ThreadpoolController:
    """The libraries that are loaded, looked for (3 ms) only where modules have come since: these may bring one."""
    return ThreadpoolController()


class Limit(NamedTuple):
    """Of memory: bytes that are left of it, bytes that this process holds of it, its name and what mends it."""

    left: float
    held: float
    name: str
    remedy: str


class Need(NamedTuple):
    """Of a whole process, bytes: memory, and addresses beyond these, which libraries and threads reserve."""

    memory: float
    reserved: float


A_TABLE = Need(1.5e8, 4e8)  # keys, scenes
A_MODEL = Need(3.5e8, 5.5e8)  # an outlook, a link budget
A_RUN = Need(6e8, 1.1e9)  # anything that compiles loops; on two cores


def memory_limits() -> Iterator[Limit]:
    """All that bound this process's memory (Linux; elsewhere what `resource` knows of them)."""
    resident = _kilobytes("/proc/self/status", "VmRSS:")
    if (free := _kilobytes("/proc/meminfo", "MemAvailable:")) is not None:
        yield Limit(free, resident or 0.0, "free memory", "end other programs, or take a larger machine")
    for most, used in _cgroups():
        yield Limit(most - used, resident or 0.0, "the container's memory", "give the container more")
    for kind, field, name in (
        (resource.RLIMIT_DATA, "VmData:", "ulimit -d"),
        (resource.RLIMIT_AS, "VmSize:", "ulimit -v"),
    ):
        most = resource.getrlimit(kind)[0]
        if most != resource.RLIM_INFINITY:
            held = _kilobytes("/proc/self/status", field) or 0.0
            yield Limit(most - held, held, name, f"raise it, as by {name} unlimited")


def free_memory() -> float:
    """Bytes that the system, the container and the process's limits can still give without paging."""
    return max(0.0, min((limit.left for limit in memory_limits()), default=float("inf")))


def check_memory(what: str, need: Need) -> None:
    """Raise ResourceError where a limit of memory leaves less than a process needs in all; what: it does."""
    for limit in memory_limits():
        wanted = need.memory + (need.reserved if limit.name == "ulimit -v" else 0.0)
        if wanted > (room := limit.left + limit.held):
            raise ResourceError(
                f"memory: {what} takes about {wanted / 1e9:.2g} GB, and {limit.name} allows {room / 1e9:.2g} GB; "
                f"{limit.remedy}"
            )


def _kilobytes(path: str, field: str) -> float | None:
    """Bytes that a field of a file of /proc states."""
    with contextlib.suppress(OSError, StopIteration, ValueError):
        lines = Path(path).read_text(encoding="ascii").splitlines()
        return 1024.0 * int(next(line for line in lines if line.startswith(field)).split()[1])
    return None


def _cgroups() -> Iterator[tuple[float, float]]:
    """Most and used bytes of the control groups of this process that bound its memory; caches do not count."""
    root = Path("/sys/fs/cgroup")
    lines: list[str] = []
    with contextlib.suppress(OSError, ValueError):
        lines = Path("/proc/self/cgroup").read_text().splitlines()
    for _, kinds, path in (line.split(":", 2) for line in lines if line.count(":") >= 2):
        if kinds and "memory" not in kinds.split(","):
            continue
        names = ("memory.limit_in_bytes", "memory.usage_in_bytes") if kinds else ("memory.max", "memory.current")
        base = root / "memory" if kinds else root
        place = base / path.strip("/")
        for folder in (place, *place.parents):
            with contextlib.suppress(OSError, ValueError):
                most, used = (float((folder / name).read_text()) for name in names)
                fields = dict(line.split() for line in (folder / "memory.stat").read_text().splitlines())
                yield most, used - float(fields.get("total_inactive_file", fields.get("inactive_file", 0)))
            if folder == base:
                break


def peak_memory() -> int:
    """Most memory [bytes] that this process has held, since `forget_peak_memory` where the system supports it."""
    # A process's own on Linux, where getrusage counts what its parent held when it was started.
    if (peak := _kilobytes("/proc/self/status", "VmHWM:")) is not None:
        return int(peak)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(peak if sys.platform == "darwin" else 1024 * peak)


def forget_peak_memory() -> None:
    """From here on the peak counts anew (Linux; elsewhere it stays that of the whole process)."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
