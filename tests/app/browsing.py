"""A served page and what watches it in a browser."""

from __future__ import annotations

import os
import re
import select
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from playwright.sync_api import Browser, ConsoleMessage, Page, Request, Route, TimeoutError, expect

_PATIENCE_S = 60.0
expect.set_options(timeout=1000.0 * _PATIENCE_S)


@dataclass
class Server:
    """A page that is served. address: with its token. runs: its folder."""

    address: str
    runs: Path
    process: subprocess.Popen[str]
    began_s: float  # from the command to the address

    @property
    def origin(self) -> str:
        return self.address.split("/?")[0]

    def end(self) -> int:
        """As Ctrl-C does; the exit code. What went wrong in the server meanwhile is no end."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            code = self.process.wait(30.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = self.process.wait(10.0)
        if self.process.stdout is not None:
            said = "" if self.process.stdout.closed else self.process.stdout.read()
            self.process.stdout.close()
            assert "Traceback" not in said, said  # of a drawing, or of a page that has gone
        return code


def serve(runs: Path, program: tuple[str, ...] = ("-m", "seamap_rt.cli")) -> Server:
    """Start a page on a free port. program: that takes the command, for Python."""
    begin = time.monotonic()
    process = subprocess.Popen(
        [sys.executable, *program, "app", "--port", "0", "--runs", str(runs), "--no-browser"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    assert process.stdout is not None
    said = ""
    while time.monotonic() - begin < _PATIENCE_S and process.poll() is None:
        if select.select([process.stdout], [], [], 0.5)[0]:
            said += process.stdout.readline()
            if found := re.search(r"http://\S+", said):
                return Server(found[0], runs, process, time.monotonic() - begin)
    process.kill()
    raise AssertionError(f"no page: {said}")


@dataclass
class Watched:
    """A browser's page with what went wrong in it, and what it asked of others than the server."""

    page: Page
    wrong: list[str] = field(default_factory=list)
    outside: list[str] = field(default_factory=list)


def open_page(
    browser: Browser, server: Server, width: int = 1400, height: int = 900, colours: Literal["light", "dark"] = "light"
) -> Watched:
    """A fresh browser at the page's address. Requests to anything but the server are noted, and not let through."""
    context = browser.new_context(
        viewport={"width": width, "height": height}, accept_downloads=True, color_scheme=colours
    )
    watched = Watched(context.new_page())

    def ask(route: Route, request: Request) -> None:
        if request.url.startswith((server.origin, "data:", "blob:")):
            route.continue_()
        else:
            watched.outside.append(request.url)
            route.abort()

    def heard(message: ConsoleMessage) -> None:
        if message.type == "error":
            watched.wrong.append(message.text)

    context.route("**/*", ask)
    watched.page.on("console", heard)
    watched.page.on("pageerror", lambda error: watched.wrong.append(str(error)))
    watched.page.set_default_timeout(1000.0 * _PATIENCE_S)
    watched.page.goto(server.address)
    watched.page.get_by_label("Antenna height above the sea (m)").wait_for()
    expect(watched.page.get_by_text("Likely to measure waves")).to_be_visible()
    return watched


def choose(page: Page, label: str, option: str | re.Pattern[str]) -> None:
    """Choose in a list. It may close as it is drawn anew, on a machine that is busy: then it is opened again."""
    wanted = page.get_by_role("option", name=option)
    for _ in range(6):
        page.get_by_label(label, exact=True).click()
        try:
            wanted.first.click(timeout=5000)
            return
        except TimeoutError:
            page.keyboard.press("Escape")
    raise AssertionError(f"{label}: no {option}")
