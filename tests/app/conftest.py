"""A page and a browser: the program's own command, and the system's Chromium."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator

import pytest
from browsing import Server, Watched, open_page, serve
from playwright.sync_api import Browser, sync_playwright

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
_NEEDED = "SEAMAP_RT_NEEDS_BROWSER"


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """One page for the tests of a file."""
    served = serve(tmp_path_factory.mktemp("runs"))
    yield served
    assert served.end() in (0, 130)  # Ctrl-C ends it, and what it runs


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """The system's Chromium. Where it is missing, tests are skipped, but fail in the project's own checks."""
    path = next((found for name in _NAMES if (found := shutil.which(name))), None)
    if path is None and not os.environ.get(_NEEDED):
        pytest.skip("no Chromium: apt-get install -y chromium")
    assert path, "no Chromium: apt-get install -y chromium"
    with sync_playwright() as player:
        opened = player.chromium.launch(
            executable_path=path, args=["--no-sandbox", "--disable-gpu-compositing", "--enable-unsafe-swiftshader"]
        )
        yield opened
        opened.close()


@pytest.fixture
def watched(browser: Browser, server: Server) -> Iterator[Watched]:
    """The page, open; at the end nothing has gone wrong in it, and nothing was asked of anybody else."""
    opened = open_page(browser, server)
    yield opened
    opened.page.context.close()
    assert opened.wrong == []
    assert opened.outside == []
