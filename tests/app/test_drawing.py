"""Drawing in processes of its own: what stands answers what was asked last, and a process that ends is no end."""

from __future__ import annotations

import asyncio
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from made_folders import write_run

from seamap_rt.app import drawing
from seamap_rt.app.drawing import DrawingProcess
from seamap_rt.app.page import Canvas
from seamap_rt.app.source import Results, Source
from seamap_rt.errors import InputError


@pytest.mark.parametrize("seed", range(20))
def test_what_stands_ungreyed_is_always_what_was_asked_for_last(seed: int) -> None:
    chance = random.Random(seed)
    asked, stands, grey = [0], [0], [False]  # the question that counts, the content's, whether it is greyed
    wrong: list[tuple[int, int]] = []
    drawn: list[int] = []

    def watch() -> None:
        if not grey[0] and stands[0] != asked[0]:
            wrong.append((asked[0], stands[0]))

    def greyed(words: str) -> None:
        grey[0] = bool(words)
        watch()

    async def draw(number: int, easel: Canvas) -> None:
        for _ in range(chance.randrange(3)):
            await asyncio.sleep(chance.choice((0.0, 0.002, 0.02)))
        stands[0] = number
        drawn.append(number)
        if chance.random() < 0.5:  # more follows
            easel.ready()
            watch()
            await asyncio.sleep(chance.choice((0.0, 0.01)))
            stands[0] = number
        watch()

    async def run() -> None:
        easel = Canvas(greyed)
        waiting = []
        for number in range(1, 40):
            asked[0] = number
            easel.drop("drawing")
            waiting.append(asyncio.ensure_future(easel.show("drawing", draw(number, easel))))
            watch()
            for _ in range(chance.randrange(4)):
                await asyncio.sleep(chance.choice((0.0, 0.005)))
                watch()
        await asyncio.gather(*waiting)
        assert (stands[0], grey[0], easel.busy) == (39, False, False)

    asyncio.run(run())
    assert wrong == []
    assert drawn == sorted(drawn)  # what comes late is dropped
    assert len(drawn) < 39


def test_an_error_of_a_drawing_that_counts_is_raised_and_greys_nothing_for_ever() -> None:
    said: list[str] = []

    async def fail() -> None:
        raise OSError("gone")

    async def run() -> None:
        easel = Canvas(said.append)
        with pytest.raises(OSError, match="gone"):
            await easel.show("drawing", fail())
        assert said[-1] == ""
        easel.drop("opening")
        assert said[-1] == "opening"

    asyncio.run(run())


def test_the_page_goes_on_while_a_process_draws_and_what_nobody_waits_for_is_never_begun(tmp_path: Path) -> None:
    async def run() -> None:
        lane = DrawingProcess()
        await lane(os.getpid)  # it has started
        first = asyncio.ensure_future(lane(_wait_and_touch, tmp_path / "go", tmp_path / "first"))
        await asyncio.sleep(0.1)
        dropped = [asyncio.ensure_future(lane(Path.touch, tmp_path / f"dropped{i}")) for i in range(5)]
        await asyncio.sleep(0.05)
        for each in dropped:
            each.cancel()
        last = asyncio.ensure_future(lane(Path.touch, tmp_path / "last"))
        for _ in range(20):  # the drawing ends because the loop turns
            await asyncio.sleep(0.01)
        assert not first.done()
        (tmp_path / "go").touch()
        await first
        await last
        assert await lane(os.getpid) != os.getpid()

    asyncio.run(run())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["first", "go", "last"]
    drawing.close()


def _wait_and_touch(awaited: Path, path: Path) -> None:
    until = time.monotonic() + 60.0
    while not awaited.exists() and time.monotonic() < until:
        pass
    path.touch()


def _refuse() -> None:
    raise InputError("a = 1: must be 2", "b = 1: must be 3")


def test_a_process_that_ends_is_said_and_the_next_drawing_has_another() -> None:
    async def run() -> None:
        lane = DrawingProcess()
        with pytest.raises(OSError, match="the process that draws has ended"):
            await lane(os._exit, 9)
        with pytest.raises(InputError, match="must be 2"):
            await lane(_refuse)
        first = await lane(os.getpid)
        assert await lane(os.getpid) == first

    asyncio.run(run())
    drawing.close()


_PAGE = """
import asyncio, os, time
from seamap_rt.app.drawing import quick
async def page():
    print(await quick(os.getpid), flush=True)
    await quick(time.sleep, 60.0)
if __name__ == "__main__":
    asyncio.run(page())
"""


def test_no_process_outlives_a_page_that_is_killed(tmp_path: Path) -> None:
    (tmp_path / "page.py").write_text(_PAGE)
    page = subprocess.Popen([sys.executable, tmp_path / "page.py"], stdout=subprocess.PIPE, text=True)
    assert page.stdout is not None
    child = int(page.stdout.readline())
    page.send_signal(signal.SIGKILL)
    page.wait(10.0)
    page.stdout.close()
    until = time.monotonic() + 20.0
    while _is_alive(child) and time.monotonic() < until:
        time.sleep(0.05)
    assert not _is_alive(child)


def _is_alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def test_a_run_is_opened_once_in_the_process_that_draws_and_its_scales_stay(tmp_path: Path) -> None:
    write_run(tmp_path / "run", turns=3)
    write_run(tmp_path / "other", turns=1)

    async def run() -> None:
        lane, source = DrawingProcess(), Source(Results(tmp_path / "run"))
        here = source.view("heights", 2)
        first, second = [await lane(Source.view, source, "heights", turn) for turn in (2, 0)]
        assert first.panels == here.panels == second.panels
        assert first.pictures == here.pictures
        (tmp_path / "run" / "maps.nc").unlink()  # it is open
        await lane(Source.view, source, "heights", 1)
        gone = Source(Results(tmp_path / "other"))
        shutil.rmtree(tmp_path / "other")
        with pytest.raises(InputError, match="holds no maps"):  # a refusal, and no end of the process
            await lane(Source.view, gone, "heights", 0)
        await lane(Source.view, source, "heights", 1)

    asyncio.run(run())
    drawing.close()
