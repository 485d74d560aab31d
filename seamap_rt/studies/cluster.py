"""Where points are computed: in this process, on a cluster of local processes, or on one that runs already.

Whoever can connect to a cluster's ports can have its processes run any code. The local one makes keys of its own, for
TLS in both directions, which only its user can read. One that runs already is asked by what its address says: tls://
takes certificates from dask's configuration, tcp:// trusts its network.

Local workers are spawned, never forked: threads and Dr.Jit do not survive a fork. Each takes one point at a time, on
cores of its own, and every pool of threads in it follows those cores; results do not depend on their number. A script
that starts them must stand under `if __name__ == "__main__":`, since spawned processes import it.
"""

from __future__ import annotations

import asyncio
import logging
import multiprocessing
import os
import signal
import uuid
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from dask import config
from distributed import Client, Future, KilledWorker, LocalCluster, Security, Worker, WorkerPlugin, as_completed
from distributed.client import FutureCancelledError, FuturesCancelledError
from distributed.comm.core import connect
from distributed.utils import LoopRunner, silence_logging_cmgr

from ..compute.locks import scratch_folder
from ..compute.machine import cores
from ..errors import InputError
from ..io.opening import read_json
from ..io.process import filter_asyncio_log
from .point import BySea, Outcome, SchedulerLost, Task, compute, ended

_KEYS = (
    "tls_ca_file",
    *(f"tls_{role}_{what}" for role in ("client", "scheduler", "worker") for what in ("key", "cert")),
)
_TLS = {"ca-file": "CA_FILE", "client.cert": "CLIENT__CERT", "client.key": "CLIENT__KEY"}
_GUARD = 'start sweeps under `if __name__ == "__main__":`, or give workers=0'
_LOST = (OSError, TimeoutError, FutureCancelledError, FuturesCancelledError)
_DIED = (
    "the worker process died while it computed the point (killed, out of memory, or a crash); "
    "fewer workers leave each of them more memory"
)
# Points leave nothing in a worker that could be spilled, so memory matters only where it ends.
_SETTINGS: dict[str, Any] = {
    "distributed.scheduler.allowed-failures": 0,  # a point that crashes its worker would crash the next one too
    "distributed.scheduler.worker-ttl": None,
    "distributed.scheduler.http.routes": [],
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.worker.multiprocessing-method": "spawn",
    "distributed.worker.http.routes": [],
    "distributed.worker.profile.enabled": False,
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.terminate": 0.95,
    "distributed.diagnostics.nvml": False,
}


def shares(workers: int) -> dict[int, list[int]]:
    """Each worker's own cores; where there are more workers than cores, they share them in turn."""
    mine = cores()
    return {number: mine[number::workers] or [mine[number % len(mine)]] for number in range(workers)}


class CoreAffinity(WorkerPlugin):
    """Keeps a local worker to its cores where the system can, and leaves Ctrl-C to the client."""

    def __init__(self, by_worker: dict[int, list[int]]) -> None:
        self.by_worker = by_worker

    def setup(self, worker: Worker) -> None:
        """Called by the worker: pins it to its cores."""
        if hasattr(os, "sched_setaffinity"):  # not on macOS
            os.sched_setaffinity(0, self.by_worker[int(worker.name)])  # threads started later inherit it
        signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def local_client(workers: int) -> Iterator[Client]:
    """A cluster of so many spawned processes; it and its files are gone afterwards."""
    filter_asyncio_log()
    with scratch_folder() as scratch:
        settings = {**_SETTINGS, "temporary-directory": str(scratch)}
        with (
            config.set(settings),
            _local_cluster(workers, scratch) as cluster,
            Client(cluster, set_as_default=False) as client,
        ):
            client.register_plugin(CoreAffinity(shares(workers)))
            yield client


def _make_keys(folder: Path) -> Security:
    """Keys made for one cluster, in a folder that its user alone can read. dask itself would put them into folders
    that a killed process leaves."""
    made, files = Security.temporary(), {field: folder / f"{field}.pem" for field in _KEYS}
    for field, file in files.items():
        file.touch(mode=0o600)
        file.write_text(getattr(made, field), encoding="ascii")
    return Security(require_encryption=True, **{field: str(file) for field, file in files.items()})


def _local_cluster(workers: int, scratch: Path) -> LocalCluster:
    try:
        return LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address=None,  # pyright: ignore[reportArgumentType]
            # The scheduler always opens a port for HTTP; this one is free, local, and serves nothing.
            scheduler_kwargs={"dashboard": False, "dashboard_address": "127.0.0.1:0"},
            local_directory=str(scratch),
            security=_make_keys(scratch),
            silence_logs=logging.CRITICAL,
        )
    except RuntimeError as error:
        raise InputError(
            f"--workers = {workers}: a worker process ended while it started ({error}): it was killed or short of "
            f"memory, then give fewer; or it imports a script that does not {_GUARD}"
        ) from None


def refuse_while_spawned() -> None:
    """InputError in a worker that is just importing the user's script: it would begin the sweep once more."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise InputError(f"a worker imports this script: {_GUARD}")


@contextmanager
def existing_client(scheduler: str, connect_s: float = 10.0) -> Iterator[Client]:
    """A client of a scheduler at tls://host:port or tcp://host:port, or of the one that a scheduler file names.

    tls: certificates as dask's configuration names them. connect_s: that each answer may take. Raises InputError where
    certificates are missing, where no scheduler answers, or where it has no workers.
    """
    filter_asyncio_log()
    address = _address(scheduler)
    _refuse_without_certificates(scheduler, address)
    try:
        _reach(address, connect_s)
        client = Client(address, timeout=connect_s, set_as_default=False)
    except Exception as error:  # what something else greets with makes errors of many types
        why = (isinstance(error, OSError) and str(error)) or "something else does"
        raise InputError(
            f"--scheduler = '{scheduler}': no scheduler answers at {address} ({why}); start one, or leave "
            "--scheduler out to compute here"
        ) from None
    with silence_logging_cmgr(logging.CRITICAL), client:
        try:
            client.wait_for_workers(1, timeout=connect_s)
        except TimeoutError:
            raise InputError(
                f"--scheduler = '{scheduler}': has no workers; start some, as by dask worker {address}"
            ) from None
        yield client


def network_notes(scheduler: str | None) -> tuple[str, ...]:
    """A line for a scheduler whose connections anyone on its network can make, read and change."""
    if scheduler is None or urlsplit(_address(scheduler)).scheme in ("tls", "wss"):
        return ()
    return (
        f"flag: --scheduler = '{scheduler}' trusts its network: whoever reaches its ports can run code as its workers "
        "and as you; tls:// with certificates does not",
    )


def _refuse_without_certificates(scheduler: str, address: str) -> None:
    """dask finds them in its configuration, or in variables of the environment."""
    named = [key for key in _TLS if config.get(f"distributed.comm.tls.{key}", None)]
    if urlsplit(address).scheme == "tls" and not {"ca-file", "client.cert"}.issubset(named):
        missing = next(key for key in _TLS if key not in named)
        raise InputError(
            f"--scheduler = '{scheduler}': needs certificates, and dask's configuration has no distributed.comm.tls."
            f"{missing}; set it, or DASK_DISTRIBUTED__COMM__TLS__{_TLS[missing]}, to a PEM file"
        )


def _reach(address: str, connect_s: float) -> None:
    """Raise where no scheduler answers: a client would wait for ever for its greeting."""

    async def greeted() -> None:
        security = Security().get_connection_args("client")
        comm = await asyncio.wait_for(connect(address, connect_s, **security), connect_s)
        comm.abort()

    loop = LoopRunner()
    loop.start()
    try:
        loop.run_sync(greeted)
    finally:
        loop.stop()


def _address(scheduler: str) -> str:
    """The address itself, or the one in a scheduler file."""
    if "://" not in scheduler:
        try:
            return str(read_json(scheduler)["address"])
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            raise InputError(
                f"--scheduler = '{scheduler}': is neither an address, such as tcp://host:8786, nor a scheduler file; "
                "correct it"
            ) from None
    return scheduler


@contextmanager
def open_local_cluster(workers: int | None) -> Iterator[Callable[[list[Task]], Iterator[tuple[Task, Outcome]]]]:
    """What computes tasks on local processes: they start with the first tasks, and stay for those that follow."""
    most = len(cores()) if workers is None else workers
    clients: list[Client] = []
    with ExitStack() as stack:

        def answers(tasks: list[Task]) -> Iterator[tuple[Task, Outcome]]:
            if not clients:
                clients.append(stack.enter_context(local_client(min(most, len(tasks)))))
            try:
                yield from gather_results(clients[0], tasks)
            except BaseException:  # left in the middle: what workers do from here on would belong to nobody
                clients.clear()
                stack.close()
                raise

        yield answers


def gather_results(client: Client, tasks: Iterable[Task]) -> Iterator[tuple[Task, Outcome]]:
    """What comes of the tasks, in the order in which workers finish them.

    No more tasks are with the scheduler than there are workers: one that crashes takes no other point with it, and an
    interruption leaves nothing behind. Each worker is given tasks of one sea as long as there are any, for it keeps
    that sea. Raises SchedulerLost if the scheduler is gone.
    """
    running: dict[str, tuple[Task, str]] = {}
    waiting = BySea(tasks)
    completed = as_completed(loop=client.loop)
    run = uuid.uuid4().hex[:8]  # a cluster may still know the tasks of an earlier sweep

    def refill() -> None:
        busy = {worker for _, worker in running.values()}
        addresses: list[str] = list(client.nthreads())  # pyright: ignore[reportArgumentType]
        idle = [worker for worker in addresses if worker not in busy]
        for worker in idle if idle or running else [""]:  # without any the scheduler waits for one
            task = waiting.take(worker)
            if task is None:
                break
            # Another may take it: this one may end meanwhile.
            where = {"workers": [worker], "allow_other_workers": True} if worker else {}
            future = client.submit(compute, task, key=f"{task.name}-{run}", pure=False, **where)
            running[str(future.key)] = task, worker
            completed.add(future)

    try:
        refill()
        for future in completed:
            task, _ = running.pop(str(future.key))
            yield task, _outcome_of(future, task)
            refill()
    except _LOST:
        raise SchedulerLost from None
    finally:
        completed.clear()


def _outcome_of(future: Future, task: Task) -> Outcome:
    try:
        return future.result()
    except KilledWorker:
        return ended(task, "failed", _DIED)
    except _LOST:
        raise
    except Exception as error:  # such as a worker that has not this package
        return ended(task, "failed", f"{type(error).__name__}: {error}")
