"""The helm in a real browser, on a screen and on a phone."""

from __future__ import annotations

import re

import pytest
from browsing import Server, Watched, choose
from made_folders import write_run
from playwright.sync_api import expect

pytestmark = pytest.mark.browser


def test_the_helm_tells_the_countdown_and_the_highest_crest(watched: Watched, server: Server) -> None:
    write_run(server.runs / "helm")
    page = watched.page
    page.locator(".q-header").get_by_role("tab", name="See", exact=True).click()
    choose(page, "Run", "helm")
    page.get_by_role("tab", name="Helm", exact=True).click()
    expect(page.get_by_text(re.compile(r"^Highest: .* m in \d+ s$"))).to_be_visible(timeout=120_000)
    expect(page.get_by_text(re.compile("^Quiet: "))).to_be_visible()
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    polar = page.get_by_role("img", name=re.compile("^Polar chart"))
    box = polar.bounding_box()
    assert box is not None
    assert box["x"] >= 0.0
    assert box["x"] + box["width"] <= 390.0  # the best course is not out of sight
