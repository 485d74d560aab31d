"""The page's pictures in the README, in the system's Chromium: `python -m validation.app.pictures [--out FOLDER]`.

A mast of 8 m beside the shipped one of 5 m, as the page predicts it; and the maps of a turn of that mast. A minute.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from playwright.sync_api import Page, expect

from seamap_rt.scene import load_scene
from seamap_rt.session import run

from .. import FIGURES
from ..options import options
from .speed import MAST, opened, served

_SETTLED_MS = 4000  # graphs have come, and no key is waited for


def draw_design(page: Page, out: Path) -> None:
    page.get_by_role("button", name="Keep to compare").click()
    page.get_by_label(MAST).fill("8")
    page.get_by_label(MAST).blur()
    expect(page.get_by_text("drawing the graphs")).to_have_count(0)
    page.wait_for_timeout(_SETTLED_MS)
    page.evaluate("window.scrollTo(0, 0)")
    page.screenshot(path=out / "app_design.jpg", type="jpeg", quality=85)


def draw_maps(page: Page, out: Path) -> None:
    page.locator(".q-header").get_by_role("tab", name="See", exact=True).click()
    expect(page.locator(".imagelayer image")).to_have_count(4)
    page.wait_for_timeout(_SETTLED_MS)
    page.screenshot(path=out / "app_see.jpg", type="jpeg", quality=85)


def main() -> None:
    asked = options(__doc__, out=str(FIGURES))
    with tempfile.TemporaryDirectory() as folder:
        run(load_scene("choppy_sea", {"turns": 4, "radar.height_m": 8.0}), Path(folder) / "mast_8m")
        with served(Path(folder)) as (address, _, _):
            for draw, height in ((draw_design, 900), (draw_maps, 1360)):
                with opened(address, height) as page:
                    draw(page, Path(asked.out))


if __name__ == "__main__":
    main()
