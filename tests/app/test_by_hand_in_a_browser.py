"""The page for every hand and eye: by the keyboard alone, in two tabs at once, read aloud; a trade from the form."""

from __future__ import annotations

import re

import pytest
from axe_playwright_python.sync_playwright import Axe
from browsing import Server, Watched, choose, open_page
from playwright.sync_api import Browser, Page, expect

pytestmark = pytest.mark.browser

_MAST = "Antenna height above the sea (m)"
_PLACES = ("Design", "Runs", "See", "Compare", "Trade")
_FOCUSED = """() => { const e = document.activeElement; const box = e.getBoundingClientRect();
  return [e.getAttribute("aria-label") || e.innerText || "", e.getAttribute("role") || e.tagName, box.width]; }"""


def _place(page: Page, name: str) -> None:
    page.locator(".q-header").get_by_role("tab", name=name, exact=True).click()


def _tab_to(page: Page, name: str, *, backwards: bool = False, most: int = 150) -> None:
    """Press Tab until an element of that name has the focus, as somebody without a mouse does."""
    for _ in range(most):
        page.keyboard.press("Shift+Tab" if backwards else "Tab")
        if page.evaluate(_FOCUSED)[0].strip().split("\n")[-1] == name:
            return
    raise AssertionError(f"{name}: not reached by {most} keys")


def test_by_the_keyboard_alone_from_a_scene_to_its_maps(watched: Watched, server: Server) -> None:
    page = watched.page
    page.locator("body").press("Tab")
    _tab_to(page, "Begin with")
    page.keyboard.press("ArrowDown")
    wanted = page.get_by_role("option", name=re.compile("^tiny:"))
    expect(wanted).to_be_visible()
    count = page.get_by_role("option").count()
    for _ in range(count):
        chosen = page.locator("[role=option].q-manual-focusable--focused")
        if chosen.count() and chosen.inner_text().startswith("tiny:"):
            break
        page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    expect(page.get_by_label("Range window (m)")).to_have_value("15, 150")
    _tab_to(page, _MAST)
    page.keyboard.press("Control+A")
    page.keyboard.type("9")
    expect(page.get_by_text("of a radar")).to_have_count(0)
    expect(page.get_by_label(_MAST)).to_have_value("9")
    _tab_to(page, 'Expand "Shadows and mesh"')
    page.keyboard.press("Enter")
    expect(page.get_by_label("Tracer", exact=True)).to_be_visible()
    _tab_to(page, "Tracer")
    page.keyboard.press("ArrowDown")
    expect(page.get_by_role("option", name="horizon")).to_be_visible()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    _tab_to(page, "Run", backwards=True)
    page.keyboard.press("Enter")
    expect(page.get_by_text(re.compile(r"tiny-1.* · done"))).to_be_visible()
    _tab_to(page, "See")
    page.keyboard.press("Enter")
    expect(page.locator(".imagelayer image")).to_have_count(4)
    _tab_to(page, "Heights")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    expect(page.get_by_text(re.compile("^True slope to east"))).to_be_visible()
    assert (server.runs / "tiny-1" / "report.html").exists()


def test_two_tabs_have_a_design_each_and_the_runs_together(browser: Browser, server: Server) -> None:
    first = open_page(browser, server)
    second = first.page.context.new_page()
    second.goto(server.address)
    second.get_by_label(_MAST).wait_for()
    first.page.get_by_label(_MAST).fill("8")
    second.get_by_label(_MAST).fill("11")
    expect(first.page.get_by_text(re.compile("Likely to measure"))).to_be_visible()
    choose(second, "Begin with", "tiny:")
    expect(second.get_by_label("Range window (m)")).to_have_value("15, 150")
    expect(first.page.get_by_label(_MAST)).to_have_value("8")
    expect(first.page.get_by_label("Range window (m)")).to_have_value("15, 400")
    second.get_by_label("Turns", exact=True).fill("400")
    second.get_by_role("button", name="Run", exact=True).click()
    _place(first.page, "Runs")
    expect(first.page.get_by_text(re.compile(r"tiny-1(-\d)? · runs"))).to_be_visible()
    first.page.get_by_role("button", name="Cancel").first.click()
    expect(second.get_by_text(re.compile("cancelled")).first).to_be_visible()
    first.page.reload()
    _place(first.page, "Design")
    expect(first.page.get_by_label(_MAST)).to_have_value("8")  # a tab's design outlives a reload
    first.page.context.close()
    assert first.wrong == []
    assert first.outside == []


def test_axe_finds_nothing_serious_in_any_place_light_or_dark(watched: Watched) -> None:
    page = watched.page
    page.locator("img.drawn-figure").first.wait_for()
    found = []
    for colours in ("light", "dark"):
        for place in _PLACES:
            _place(page, place)
            page.wait_for_timeout(500)
            told = Axe().run(page).response["violations"]
            found += [
                (colours, place, each["id"], each["nodes"][0]["html"])
                for each in told
                if each["impact"] in ("serious", "critical")
            ]
        page.get_by_role("button", name="Light or dark").click()
    assert found == []


def test_a_trade_from_the_form_says_what_each_mast_is_worth(watched: Watched, server: Server) -> None:
    page = watched.page
    choose(page, "Begin with", "tiny:")
    expect(page.get_by_label("Range window (m)")).to_have_value("15, 150")  # the form is tiny's
    page.get_by_text("Shadows and mesh").click()
    choose(page, "Tracer", "horizon")
    expect(page.get_by_text(re.compile("Likely to measure"))).to_be_visible()
    _place(page, "Trade")
    page.get_by_label("Seeds").fill("1")
    page.get_by_label("Values: from:to:step, or a,b,c").first.fill("a:b")
    expect(page.get_by_text(re.compile("a:b"))).to_be_visible()  # refused in a line
    page.get_by_label("Values: from:to:step, or a,b,c").first.fill("4,8")
    expect(page.get_by_text(re.compile("^2 points"))).to_be_visible()
    page.get_by_role("button", name="Run all points").click()
    expect(page.get_by_text(re.compile("^2 points are there"))).to_be_visible()
    _place(page, "Runs")
    expect(page.get_by_text(re.compile("tiny-trade · done"))).to_be_visible()
    assert (server.runs / "tiny-trade" / "trade.nc").exists()
