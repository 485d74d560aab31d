"""The page's further views in a real browser: forecasts that came out, gauges, studies, points of trades, uploads."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from browsing import Server, Watched, choose
from made_folders import write_maps, write_run, write_shadowing, write_trade
from playwright.sync_api import Page, expect

from seamap_rt.io.scenefile import list_shipped

pytestmark = pytest.mark.browser

_BUOY = next(iter(list_shipped().values())).parent / "objects" / "buoy.stl"


@pytest.fixture(scope="module", autouse=True)
def folders(server: Server) -> None:
    """One of each kind, made without a simulation."""
    write_run(server.runs / "whole")
    write_maps(server.runs / "kept", "maps")
    write_maps(server.runs / "only", "truth")
    write_shadowing(server.runs / "shadows")
    write_trade(server.runs / "masts")


def _place(page: Page, name: str) -> None:
    page.locator(".q-header").get_by_role("tab", name=name, exact=True).click()


def _view(page: Page, name: str) -> None:
    page.get_by_role("tab", name=name, exact=True).click()


def _upload(page: Page, label: str, file: Path | dict) -> None:
    with page.expect_file_chooser() as asked:
        page.get_by_role("button", name=label, exact=True).click()
    asked.value.set_files(file)  # type: ignore[arg-type]


def test_past_forecasts_gauges_spectrum_and_the_sea_from_the_mast(watched: Watched) -> None:
    page = watched.page
    _place(page, "See")
    choose(page, "Run", "whole")
    expect(page.get_by_text(re.compile(r"^turn 12 of 12 · "))).to_be_visible()
    _view(page, "Forecast")
    expect(page.get_by_text(re.compile(r"Of 8 forecasts, 10 s ahead: error 0\.10 m rms"))).to_be_visible()
    expect(page.get_by_alt_text("quiet windows after turn 12, and which came")).to_be_visible()
    expect(page.get_by_alt_text("what was forecast of it 10 s ahead")).to_be_visible()
    expect(page.get_by_alt_text("Hits against false alarms of forecast quiet windows")).to_be_visible()
    page.get_by_role("button", name="Turn before").click()  # step by step
    expect(page.get_by_alt_text("quiet windows after turn 11, and which came")).to_be_visible()
    choose(page, "Forecast so long before", "3 s before")
    expect(page.get_by_text(re.compile("Of 8 forecasts, 3 s ahead"))).to_be_visible()
    expect(page.get_by_alt_text("what was forecast of it 3 s ahead")).to_be_visible()

    _view(page, "Gauges")
    expect(page.get_by_text("At 60 m, 270°.")).to_be_visible()
    expect(page.get_by_text("Correlation with the wire")).to_be_visible()
    image = page.get_by_alt_text("Height at the gauge west against time")
    assert image.evaluate("e => e.complete && e.naturalWidth") > 900
    _view(page, "Sea state")
    expect(page.get_by_text("Wave spectrum", exact=True)).to_be_visible()
    expect(page.get_by_text("looks span less than 80°").or_(page.get_by_text("Too little of the sea"))).to_be_visible()
    _view(page, "3-D")
    expect(page.locator(".js-plotly-plot canvas").first).to_be_visible()
    page.get_by_role("button", name="From the mast", exact=True).click()
    picture = page.get_by_alt_text("The sea as one sees it from the mast")
    expect(picture).to_have_attribute("src", re.compile("^data:image/jpeg;base64,"))
    first = picture.get_attribute("src")
    page.get_by_role("slider", name="Azimuth of the look").or_(page.locator(".q-slider").last).locator(
        "[tabindex]"
    ).last.focus()
    page.keyboard.press("ArrowLeft")
    expect(picture).not_to_have_attribute("src", str(first))

    page.set_viewport_size({"width": 390, "height": 844})  # a phone
    for view, there in (("Forecast", "Of 8 forecasts"), ("Gauges", "At 60 m"), ("Sea state", "Wave spectrum")):
        tab = page.get_by_role("tab", name=view, exact=True)
        tab.scroll_into_view_if_needed()
        tab.click()
        expect(page.get_by_text(re.compile(there)).first).to_be_visible()
        page.wait_for_timeout(300)  # graphs follow the width
        assert page.evaluate("document.documentElement.scrollWidth") <= 391, view


def test_folders_of_any_kind_are_seen_as_far_as_they_go(watched: Watched, server: Server) -> None:
    page = watched.page
    _place(page, "See")
    choose(page, "Run", "kept · retrieval")
    expect(page.get_by_text("Retrieved height (m)")).to_be_visible()
    expect(page.locator(".imagelayer image")).to_have_count(2)  # and its stated error: nobody knows the true one
    _view(page, "Gauges")
    expect(page.get_by_text(re.compile("has no wave gauge"))).to_be_visible()
    _view(page, "Heights")
    choose(page, "Run", "only · simulation")
    expect(page.get_by_text("True height (m)")).to_be_visible()
    expect(page.locator(".imagelayer image")).to_have_count(1)
    choose(page, "Run", "shadows · shadowing")
    expect(page.get_by_text(re.compile(r"from a mast of 4 m: beyond 50 m .*8 m: beyond 100 m"))).to_be_visible()
    choose(page, "Look", "across the waves")
    expect(page.get_by_text(re.compile("Half of the sea is hidden, across the waves"))).to_be_visible()
    expect(page.get_by_alt_text("for each mast, across the waves")).to_be_visible()

    # a trade opens in its own place, and its points' maps are had by running them again
    _place(page, "Runs")
    page.get_by_role("button", name="See masts").click()
    expect(page.get_by_text(re.compile("^2 points are there"))).to_be_visible()
    choose(page, "Point", re.compile("antenna height 8 m, seed 1"))
    page.get_by_role("button", name="Run this point").click()
    waits_or_is_there = page.get_by_text(re.compile(r"^masts_height_m_8_seed=1: |^turn 1 of 1 · "))
    expect(waits_or_is_there.locator("visible=true").first).to_be_visible()
    note = json.loads((server.runs / ".jobs" / "masts_height_m_8_seed=1.1.json").read_text())
    assert note["words"][0] == "run"
    scene = (server.runs / ".jobs" / "masts_height_m_8_seed=1.1.toml").read_text()
    assert "\nheight_m = 8.0" in scene
    _place(page, "Runs")
    page.get_by_role("button", name="Cancel").or_(page.get_by_text("masts_height_m_8_seed=1 · done")).first.click()


def test_files_are_taken_at_their_fields_and_recordings_in_their_place(watched: Watched, server: Server) -> None:
    page = watched.page
    page.get_by_role("button", name="Add object").click()
    _upload(page, "Upload a mesh", {"name": "x.stl", "mimeType": "model/stl", "buffer": b"no mesh"})
    expect(page.get_by_text(re.compile(r"x\.stl.*is damaged, or not what its ending says"))).to_be_visible()
    _upload(page, "Upload a mesh", _BUOY)
    expect(page.get_by_label("Mesh", exact=True)).to_have_value(str(server.runs / ".uploads" / "buoy.stl"))
    page.get_by_role("button", name="Delete", exact=True).last.click()  # of the object: it asks first
    page.get_by_role("button", name="Keep it").click()
    expect(page.get_by_label("Mesh", exact=True)).to_be_visible()
    page.get_by_role("button", name="Delete", exact=True).last.click()
    page.get_by_role("button", name="Delete it").click()
    expect(page.get_by_label("Mesh", exact=True)).to_have_count(0)
    _place(page, "Runs")
    page.get_by_text("Recorded echoes").click()
    _upload(page, "Upload a recording", {"name": "night.npz", "mimeType": "x/y", "buffer": b"no recording"})
    expect(page.get_by_text(re.compile(r"night\.npz: cannot be read"))).to_be_visible()
    page.get_by_role("button", name="Retrieve the recording").click()
    expect(page.get_by_text("Choose a recording, or upload one.")).to_be_visible()
    assert [each.name for each in (server.runs / ".uploads").iterdir()] == ["buoy.stl"]
