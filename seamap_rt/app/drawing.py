"""Drawings in processes of their own, so that the page answers meanwhile."""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from typing import Any, TypeVar

Result = TypeVar("Result")


class DrawingProcess:
    """A process that draws one thing after another; it starts with the first. most: after so many another follows."""

    def __init__(self, most: int | None = None) -> None:
        self._most = most
        self._pool: ProcessPoolExecutor | None = None
        self._free = asyncio.Lock()

    async def __call__(self, make: Callable[..., Result], *given: Any) -> Result:
        """What a function of a module gives. Cancelled while it waits, it is never begun.

        Raises OSError where the process ended, and what the function raises.
        """
        packed = pickle.dumps((make, given))
        await self._free.acquire()
        loop = asyncio.get_running_loop()
        spawn = multiprocessing.get_context("spawn")
        pool = self._pool = self._pool or ProcessPoolExecutor(1, spawn, _begin, max_tasks_per_child=self._most)
        try:
            future = pool.submit(_call, packed)
        except BrokenExecutor as error:
            self._pool = None
            self._free.release()
            raise OSError(_LOST) from error

        def release(_: object) -> None:
            with contextlib.suppress(RuntimeError):  # the page has ended, and its loop with it
                loop.call_soon_threadsafe(self._free.release)

        future.add_done_callback(release)
        try:
            return await asyncio.wrap_future(future)
        except BrokenExecutor as error:
            self._pool = None
            raise OSError(_LOST) from error


_LOST = "the process that draws has ended, as it does where memory runs out; choose the view again"


quick, slow = DrawingProcess(), DrawingProcess()  # maps, sections, curves; what may take seconds


alone = DrawingProcess(1)  # what takes much memory


def close() -> None:
    """End what is drawn."""
    for child in multiprocessing.active_children():
        child.terminate()


def _call(packed: bytes) -> Any:
    make, given = pickle.loads(packed)  # here, so that what cannot be opened is an answer
    return make(*given)


def _begin() -> None:
    """In a process that draws: Ctrl-C is for the page, and the process ends with the page, however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    page = multiprocessing.parent_process()
    assert page is not None

    def follow() -> None:
        page.join()
        os._exit(0)

    threading.Thread(target=follow, daemon=True, name="follow").start()
