"""The page in a real browser: from a scene to its maps, what goes wrong on the way, and what it says of that."""

from __future__ import annotations

import json
import os
import re
import signal
import time
from pathlib import Path

import pytest
from browsing import Server, Watched, choose, open_page
from playwright.sync_api import Browser, Page, expect

pytestmark = pytest.mark.browser

_MAST = "Antenna height above the sea (m)"


def _begin_with(page: Page, scene: str, window: str, turns: int) -> None:
    choose(page, "Begin with", f"{scene}:")
    expect(page.get_by_label("Range window (m)")).to_have_value(window)
    page.get_by_text("Shadows and mesh").click()
    choose(page, "Tracer", "horizon")
    page.get_by_label("Turns", exact=True).fill(str(turns))
    expect(page.get_by_label("Turns", exact=True)).to_have_value(str(turns))


def _place(page: Page, name: str) -> None:
    page.locator(".q-header").get_by_role("tab", name=name, exact=True).click()


def _view(page: Page, name: str) -> None:
    page.get_by_role("tab", name=name, exact=True).click()


def _job(server: Server, folder: str) -> dict:
    return json.loads((server.runs / ".jobs" / f"{folder}.1.json").read_text())


def _wait_for_state(server: Server, folder: str, *states: str) -> dict:
    until = time.monotonic() + 120.0
    while (told := _job(server, folder))["state"] not in states:
        assert time.monotonic() < until, told
        time.sleep(0.1)
    return told


def test_from_a_scene_to_maps_section_comparison_and_files(watched: Watched, server: Server) -> None:
    page = watched.page
    _begin_with(page, "choppy_sea", "15, 400", 3)
    page.get_by_role("button", name="Keep to compare").click()
    answer = page.get_by_text(re.compile("Likely to measure waves out to"))
    before = answer.inner_text()
    page.get_by_label(_MAST).fill("8")
    expect(page.get_by_text("▲ better").first).to_be_visible()  # against the kept design
    assert answer.inner_text() != before
    page.get_by_role("button", name="Run", exact=True).click()
    expect(page.get_by_text(re.compile(r"choppy_sea-1 · (runs|done)"))).to_be_visible()
    # a second design waits behind the first
    _place(page, "Design")
    page.get_by_label(_MAST).fill("5")
    expect(page.get_by_text("▲ better")).to_have_count(0)  # the kept design again; fewer turns then take less time
    page.get_by_label("Turns", exact=True).fill("1")
    page.get_by_role("button", name="Run", exact=True).click()
    expect(page.get_by_text(re.compile("choppy_sea-1-2 · (waits|runs)"))).to_be_visible()

    # maps arrive while the run goes on, or has just ended
    _place(page, "See")
    choose(page, "Run", re.compile("^choppy_sea-1$"))
    expect(page.get_by_text(re.compile(r"^turn 3 of 3 · "))).to_be_visible()
    images = page.locator(".imagelayer image")
    expect(images).to_have_count(4)
    last = images.nth(1).get_attribute("href")
    assert last is not None
    assert last.startswith("data:image/png")
    page.get_by_role("button", name="Turn before").click()
    expect(page.get_by_text(re.compile(r"^turn 2 of 3 · "))).to_be_visible()
    page.wait_for_function(
        "old => { const e = document.querySelectorAll('.imagelayer image')[1]; return e && e.href.baseVal !== old; }",
        arg=last,
    )

    page.get_by_role("slider").first.locator("[tabindex]").focus()
    page.keyboard.press("ArrowLeft")  # the keyboard scrubs too
    expect(page.get_by_text(re.compile(r"^turn 1 of 3 · "))).to_be_visible()

    # the pointer tells values, and a click cuts along that look
    box = page.locator(".js-plotly-plot .nsewdrag").first.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.35 * box["width"], box["y"] + 0.5 * box["height"], steps=4)
    expect(page.get_by_text(re.compile(r"\d+ m at 2\d\d° · true height"))).to_be_visible()
    page.mouse.click(box["x"] + 0.35 * box["width"], box["y"] + 0.5 * box["height"])
    expect(page.get_by_text(re.compile(r"Along 2\d\d°; grey"))).to_be_visible()
    for view in ("Slopes", "Radar cells", "Echo"):
        _view(page, view)
        expect(page.get_by_text(re.compile("^(True slope to east|True height|Echo power)")).first).to_be_visible()
    _view(page, "By range")
    for alt in ("Graphs of height error", "Share of the sea in sight of both antennas"):
        image = page.get_by_alt_text(alt)
        expect(image).to_be_visible()
        assert image.evaluate("e => e.complete && e.naturalWidth") > 900
    _view(page, "3-D")
    expect(page.locator(".js-plotly-plot canvas").first).to_be_visible()

    _wait_for_state(server, "choppy_sea-1-2", "done")
    _view(page, "Sea state")
    expect(page.get_by_text(re.compile(r"^Hs \d\.\d+ ± \d\.\d+ m, Tp "))).to_be_visible()
    expect(page.get_by_alt_text("Wave spectrum by the maps")).to_be_visible()
    expect(page.get_by_text(re.compile("Sees the waves out to"))).to_be_visible()
    _place(page, "Compare")
    expect(page.get_by_text(re.compile(r"A \d+ · B \d+")).first).to_be_visible()
    expect(page.get_by_text(re.compile(r"^Differ in: .*turns \(A \d, B \d\)|^Differ in: .*seed"))).to_be_visible()
    expect(
        page.get_by_text(re.compile(r"^50–200 m: (no difference beyond chance|B better|B worse) \(A 0"))
    ).to_be_visible()
    expect(page.get_by_role("cell", name="within chance").first).to_be_visible()
    expect(page.get_by_text(re.compile(r"^turn 1 of \d$"))).to_be_visible()

    _place(page, "See")
    page.get_by_role("button", name="Download", exact=True).click()
    with page.expect_download() as taken:
        page.get_by_text("section and curves (CSV)").click()
    text = Path(taken.value.path()).read_text()
    assert text.startswith("section along 2")
    assert len(text.splitlines()) > 90  # a line a gate
    page.get_by_role("button", name="Download", exact=True).click()
    with page.context.expect_page() as opened:
        page.get_by_text("report.html").click()
    expect(opened.value.get_by_text(re.compile("Sees the waves out to")).first).to_be_visible()


def test_what_is_wrong_stands_at_its_field_as_on_the_command_line(watched: Watched) -> None:
    page = watched.page
    page.get_by_label(_MAST).fill("500")
    line = "radar.range_m = [15,400]: its far end must be greater than radar.height_m = 500"
    expect(page.get_by_text(line, exact=False)).to_be_visible()
    page.get_by_role("button", name="Run", exact=True).click()
    expect(page.get_by_text("This design does not stand yet")).to_be_visible()
    page.get_by_label(_MAST).fill("<img src=x onerror=alert(1)>")
    expect(page.get_by_text("must be a number").first).to_be_visible()
    assert page.locator("img[src=x]").count() == 0
    page.get_by_role("button", name="Undo").click()
    page.get_by_role("button", name="Undo").click()
    expect(page.get_by_label(_MAST)).to_have_value("5")
    expect(page.get_by_text(re.compile("Likely to measure"))).to_be_visible()


def test_a_scene_is_loaded_and_its_command_is_told(watched: Watched, tmp_path: Path) -> None:
    page = watched.page
    page.get_by_text("Scene file and command line").click()
    expect(page.get_by_text("seamap-rt run choppy_sea", exact=True)).to_be_visible()
    page.get_by_label(_MAST).fill("7.5")
    expect(page.get_by_text("seamap-rt run choppy_sea --set radar.height_m=7.5")).to_be_visible()
    mine = tmp_path / "mine.toml"
    mine.write_text('name = "mine"\ntitle = "<b>bold</b>"\n[radar]\nheight_m = 11.5\n')
    page.locator("input[type=file]").set_input_files(mine)
    expect(page.get_by_label(_MAST)).to_have_value("11.5")
    page.locator("input[type=file]").set_input_files({"name": "x.toml", "mimeType": "text/plain", "buffer": b"a = ["})
    expect(page.get_by_text(re.compile("is not TOML"))).to_be_visible()


def test_a_run_goes_on_while_the_page_is_away_and_is_cancelled_or_killed(watched: Watched, server: Server) -> None:
    page = watched.page
    _begin_with(page, "tiny", "15, 150", 400)
    page.get_by_role("button", name="Run", exact=True).click()
    newest = max((server.runs / ".jobs").glob("*.1.json"), key=lambda path: json.loads(path.read_text())["asked"])
    folder = newest.stem.removesuffix(".1")
    expect(page.get_by_text(re.compile(r"turn \d+ of 400"))).to_be_visible()
    page.reload()
    expect(page.get_by_text(re.compile(rf"{folder} · runs"))).to_be_visible()
    expect(page.get_by_text(re.compile(r"turn ([3-9]|\d\d+) of 400: .* left"))).to_be_visible()
    page.get_by_role("button", name="Cancel").click()
    expect(page.get_by_text(re.compile(r"\d+ of 400 turns are complete"))).to_be_visible()
    page.get_by_role("button", name="See").first.click()
    expect(page.locator(".imagelayer image").first).to_be_visible()  # whole turns stay

    _place(page, "Design")
    page.get_by_role("button", name="Run", exact=True).click()
    expect(page.get_by_text(re.compile(r"turn [3-9] of 400"))).to_be_visible()
    notes = [json.loads(each.read_text()) for each in (server.runs / ".jobs").glob("*.json")]
    job = next(told for told in notes if told["state"] == "running")
    os.kill(job["pid"], signal.SIGKILL)
    expect(page.get_by_text(re.compile(r"killed by SIGKILL.*; \d+ whole turns stay readable"))).to_be_visible()


def test_on_a_phone_nothing_is_wider_than_the_screen_and_figures_come_first(browser: Browser, server: Server) -> None:
    opened = open_page(browser, server, 390, 844)
    page = opened.page
    expect(page.get_by_text(re.compile("Likely to measure"))).to_be_visible()
    tile, form = page.get_by_text("Fully measured radius").first, page.get_by_text("Scene file and command line")
    boxes = [each.bounding_box() for each in (tile, form)]
    above, below = (box["y"] for box in boxes if box is not None)
    assert 0.0 < above < min(844.0, below)  # on the first screen, above the form
    for name in ("Design", "Runs", "See", "Compare", "Trade"):
        tab = page.locator(".q-header").get_by_role("tab", name=name, exact=True)
        tab.scroll_into_view_if_needed()
        tab.click()
        page.wait_for_timeout(400)
        wide = page.evaluate("document.documentElement.scrollWidth")
        assert wide <= 391, name
    page.context.close()
    assert opened.wrong == []
    assert opened.outside == []


def test_who_does_not_know_the_token_gets_nothing(browser: Browser, server: Server) -> None:
    context = browser.new_context()
    for path in ("/", "/files/tiny-1/maps.nc", "/_nicegui_ws/socket.io/?EIO=4&transport=polling"):
        answer = context.request.get(server.origin + path)
        assert answer.status == 403, path
    context.close()


_ELSEWHERE = ("/files/../../etc/passwd", "/files/..%2f..%2fetc/passwd", "/files/x/.jobs", "/files/x/maps.nc")


@pytest.mark.parametrize("path", _ELSEWHERE)
def test_no_other_file_is_given_away(browser: Browser, server: Server, path: str) -> None:
    context = browser.new_context()
    context.request.get(server.address)
    answer = context.request.get(server.origin + path)
    assert "root:" not in answer.text()  # an address beside the files' is the page itself
    assert answer.status in (403, 404) or "seamap_rt" in answer.text()
    context.close()
