"""How quick the page is, in the system's Chromium: `python -m validation.app.speed [--only NAME]…`.

usable: from the command to a form that may be typed into and a stated consequence. consequences: from the last key to
what it does. turn: from a whole turn on the disk to its maps on the screen. scrub: maps of 400 × 200 cells a second.
open: a run of 600 turns, and the memory of the page's process. beside: the simulation's own time with an open page that
watches it, over its time without. Medians; the machine's load is told, since all of them rise with it.
"""

from __future__ import annotations

import argparse
import os
import re
import select
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import xarray as xr
from playwright.sync_api import Page, expect, sync_playwright

from seamap_rt.io.appendable import AppendableNetCDF
from seamap_rt.scene import load_scene
from seamap_rt.session import run

MAST = "Antenna height above the sea (m)"
_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
_TURNS = 600


@contextmanager
def served(runs: Path) -> Iterator[tuple[str, subprocess.Popen[str], float]]:
    """The address of a page, its process, and when its command was given."""
    began = time.perf_counter()
    command = [sys.executable, "-m", "seamap_rt.cli", "app", "--port", "0", "--runs", str(runs), "--no-browser"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        while not (found := re.search(r"http://\S+", process.stdout.readline())):
            select.select([process.stdout], [], [], 0.1)
        yield found[0], process, began
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(30)
        process.stdout.close()


@contextmanager
def opened(address: str, height: int = 900) -> Iterator[Page]:
    """The page in a fresh browser, in a window 1400 pixels wide and as high as is asked for."""
    path = next(found for name in _NAMES if (found := shutil.which(name)))
    with sync_playwright() as player:
        browser = player.chromium.launch(executable_path=path, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1400, "height": height})
        page.set_default_timeout(120_000)
        expect.set_options(timeout=120_000)
        page.goto(address)
        page.get_by_label(MAST).wait_for()
        yield page
        browser.close()


def usable() -> str:
    """Cold processes, warm file cache: the second of two starts."""
    seconds = []
    for _ in range(3):
        with tempfile.TemporaryDirectory() as runs, served(Path(runs)) as (address, _, began):
            path = next(found for name in _NAMES if (found := shutil.which(name)))
            with sync_playwright() as player:
                before = time.perf_counter()
                browser = player.chromium.launch(executable_path=path, args=["--no-sandbox"])
                page = browser.new_page()
                spent = time.perf_counter() - before  # a user's browser is open already
                page.goto(address)
                page.get_by_label(MAST).wait_for()
                page.get_by_label(MAST).fill("6")
                seconds.append(time.perf_counter() - began - spent)
                browser.close()
    return f"usable {statistics.median(seconds):.2f} s after the command (at most {max(seconds):.2f})"


def consequences(page: Page) -> str:
    """From the key to the changed answer, with the 0.12 s for which the page waits for another key."""
    answer, seconds = page.get_by_text("Likely to measure waves"), []
    expect(answer).to_be_visible()
    page.wait_for_timeout(2000)  # the graphs have come, and the other places are loaded
    for number in range(12):
        before = answer.inner_text()
        page.get_by_label(MAST).fill(f"{4.0 + 0.7 * number:g}")
        begin = time.perf_counter()
        page.wait_for_function("old => !document.body.innerText.includes(old)", arg=before, polling="raf")
        seconds.append(time.perf_counter() - begin)
        page.wait_for_timeout(500)  # a person reads it
    return f"consequences {statistics.median(seconds):.2f} s after the key (at most {max(seconds):.2f})"


def large_run(folder: Path, turns: int = _TURNS) -> None:
    """A run of many turns of 200 × 400 polar and 201 × 201 ground cells: one simulated turn, repeated with noise."""
    scene = load_scene("choppy_sea", {"turns": 1, "tracing.tracer": "horizon", "retrieval.cell_range_m": 1.5})
    run(scene, folder)
    with xr.open_datatree(folder / "maps.nc") as maps, xr.open_datatree(folder / "truth.nc") as truth:
        trees = {"maps.nc": maps.load(), "truth.nc": truth.load()}
    random = np.random.default_rng(1)
    for name, tree in trees.items():
        with AppendableNetCDF(folder / f"grown_{name}") as file:
            for number in range(turns):
                groups = {}
                for group in ("polar", "ground"):
                    one = tree[group].to_dataset().copy(deep=True)
                    one["turn"] = ("turn", np.array([number], dtype=np.int32))
                    one["height"] = one["height"] + np.float32(0.05) * random.standard_normal(1).astype(np.float32)
                    groups[f"/{group}"] = one
                file.append(xr.DataTree.from_dict(groups))
        os.replace(folder / f"grown_{name}", folder / name)
    shutil.rmtree(folder / "run.zarr")


def scrub(page: Page) -> str:
    """Turns that follow each other as fast as the page draws them: pictures that came on the screen in five seconds."""
    page.locator(".q-header").get_by_role("tab", name="See", exact=True).click()
    begin = time.perf_counter()
    expect(page.locator(".imagelayer image")).to_have_count(4)
    took = time.perf_counter() - begin
    page.get_by_role("tab", name="Radar cells", exact=True).click()
    expect(page.get_by_text("In sight of both antennas")).to_be_visible()
    page.evaluate(
        """() => { window.frames_ = 0; let last = ""; const look = () => {
        const now = document.querySelector('.imagelayer image')?.href.baseVal ?? "";
        if (now !== last) { last = now; window.frames_ += 1; } requestAnimationFrame(look); }; look(); }"""
    )
    page.get_by_role("slider").first.locator("[tabindex]").focus()
    begin = time.perf_counter()
    while time.perf_counter() - begin < 5.0:
        page.keyboard.press("ArrowLeft")
        page.wait_for_timeout(40)  # a key that is held repeats some 25 times a second
    rate = page.evaluate("window.frames_") / (time.perf_counter() - begin)
    return f"a run of {_TURNS} turns opens in {took:.2f} s; scrubbing shows {rate:.1f} turns a second, four maps each"


def memory(process: subprocess.Popen[str]) -> str:
    """Of the page's process."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    found = re.search(r"VmRSS:\s+(\d+) kB", status)
    return f"the page's process holds {int(found[1]) / 1000.0:.0f} MB" if found else "memory is not told here"


def turn(page: Page, runs: Path) -> str:
    """Of choppy_sea, a second a turn: from the note of the next turn, made when one is written, to its maps."""
    page.locator(".q-header").get_by_role("tab", name="Design", exact=True).click()
    page.get_by_label("Turns", exact=True).fill("9")
    page.get_by_text("Shadows and mesh").click()
    page.get_by_label("Tracer", exact=True).click()
    page.get_by_role("option", name="horizon").click()
    page.get_by_label("Turns", exact=True).blur()
    page.get_by_role("button", name="Run", exact=True).click()
    page.get_by_role("button", name="See").first.click()
    late = []
    for number in range(2, 9):
        page.wait_for_function(f"document.body.innerText.includes('turn {number} of 9 · ')", polling=20)
        seen = time.time()
        lines = next((runs / ".jobs").glob("*.progress")).read_text().splitlines()
        then = [float(line.split()[0]) for line in lines if f"turn {number + 1} of 9: " in line][:1]
        late += [seen - each for each in then]
    return f"a whole turn is on the screen {statistics.median(late):.2f} s after it (at most {max(late):.2f})"


def simulated(runs: Path) -> float:
    """Seconds of twelve turns of choppy_sea, simulated by the command line."""
    command = [sys.executable, "-m", "seamap_rt.cli", "simulate", "choppy_sea", "--turns", "12", "--tracer", "horizon"]
    begin = time.perf_counter()
    subprocess.run([*command, "--out", str(runs / "simulated"), "--overwrite"], check=True, capture_output=True)
    return time.perf_counter() - begin


def beside(runs: Path) -> str:
    """Alone and beside an open page in turn, so that what else the machine does meets both."""
    ratios = []
    for _ in range(3):
        alone = simulated(runs)
        with served(runs) as (address, _, _), opened(address) as page:
            page.locator(".q-header").get_by_role("tab", name="Runs", exact=True).click()
            expect(page.get_by_text("Results", exact=True)).to_be_visible()
            ratios.append(simulated(runs) / alone)
    spread = f"{min(ratios):.2f} to {max(ratios):.2f}"
    return f"beside an open page a simulation takes {statistics.median(ratios):.2f} times as long ({spread})"


def main() -> None:
    """Measure, and print a line each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", action="append", choices=("usable", "consequences", "turn", "scrub", "beside"))
    only = parser.parse_args().only

    def wanted(name: str) -> bool:
        return not only or name in only

    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    if wanted("usable"):
        print(usable())
    with tempfile.TemporaryDirectory() as folder:
        runs = Path(folder)
        if wanted("scrub"):
            large_run(runs / "large")
        with served(runs) as (address, process, _), opened(address) as page:
            if wanted("consequences"):
                print(consequences(page))
            if wanted("scrub"):
                print(scrub(page), "·", memory(process))
            if wanted("turn"):
                print(turn(page, runs))
        if wanted("beside"):
            print(beside(runs))
    print(f"load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
