"""What asyncio says of tasks whose exception another one has raised: not of these libraries' tasks, of all others."""

from __future__ import annotations

import logging

import pytest

from seamap_rt.io.process import filter_asyncio_log


class Told(Exception):
    __module__ = "distributed.comm.core"


def raised_in(file: str) -> Exception:
    """An error of Python's own that a library's code has raised."""
    try:
        exec(compile("raise RuntimeError('Nanny failed to start.')", file, "exec"))
    except RuntimeError as error:
        return error
    raise AssertionError


@pytest.mark.parametrize(
    ("text", "error", "heard"),
    [
        ("Task exception was never retrieved\nfuture: <Task coro=<f() at /lib/zarr/core/group.py:3503>>", None, False),
        ("Task was destroyed but it is pending!\ntask: <Task coro=<f() at /lib/zarr/core/sync.py:113>>", None, False),
        ("Task was destroyed but it is pending!\ntask: <Task coro=<f() at /lib/mine.py:3>>", None, True),
        ("Future exception was never retrieved", Told(), False),
        ("Task exception was never retrieved", raised_in("/lib/distributed/core.py"), False),
        ("Task exception was never retrieved", raised_in("/lib/mine.py"), True),
        ("Future exception was never retrieved", ValueError(), True),
        ("Executing a slow task of zarr", None, True),
    ],
)
def test_only_what_is_told_already_is_left_out(
    caplog: pytest.LogCaptureFixture, text: str, error: Exception | None, heard: bool
) -> None:
    filter_asyncio_log()
    filter_asyncio_log()
    logging.getLogger("asyncio").error(text, exc_info=error)
    assert bool(caplog.records) == heard
