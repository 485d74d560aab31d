"""The page walked through all its places and views where every text that comes from elsewhere is hostile.

Names of folders, titles, keys, values, reasons, attributes, files and uploads: each would run a script if it ever
became part of props, HTML or a template. None does, and each is read as the text that it is.
"""

from __future__ import annotations

import json
import os
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import pytest
from browsing import Server, Watched, serve
from made_folders import forecasts, write_maps, write_run, write_shadowing, write_trade
from playwright.sync_api import Page, expect

from seamap_rt.scene import load_scene

pytestmark = pytest.mark.browser

PAYLOADS = (
    'x" :label="(window.PWNED=1)" y="',
    "x' :label='(window.PWNED=1)' y='",
    "<img src=x onerror=window.PWNED=1>",
    "{{window.PWNED=1}}",
    "${window.PWNED=1}`",
    "javascript:window.PWNED=1",
    "<a href='javascript:window.PWNED=1'>a<",
)
ALL = 'x" :label="(window.PWNED=1)" y=\'<img src=x onerror=window.PWNED=1>{{7*7}}${window.PWNED=1}` %2e?#&lt;'
_NESTED = "</script><script>window.PWNED=1</script>"  # as folders in each other
_PIXEL = bytes.fromhex(
    "89504e470d0a1a0a0000000d49484452000000010000000108060000001f15c4890000000d49444154789c6360606060000000050001a5f645"
    "400000000049454e44ae426082"
)


def _spoil(path: Path) -> None:
    """Every attribute of a file that is text, as one that is hostile."""
    with h5py.File(path, "a") as file:

        def visit(_: str, item: Any) -> None:
            for key, value in list(item.attrs.items()):
                if isinstance(value, str) and key.lower() not in ("class", "name", "units", "_ncproperties"):
                    item.attrs[key] = ALL

        visit("", file)
        file.visititems(visit)


def _write(runs: Path) -> None:
    for number, name in enumerate((*PAYLOADS, _NESTED)):
        write_maps(runs / name, "maps" if number % 2 else "truth")
    write_run(runs / f"run {ALL}")
    scene = load_scene("tiny", {"turns": 12, "title": ALL})
    (runs / f"run {ALL}" / "scene.toml").write_text(scene.to_toml())
    (runs / f"run {ALL}" / "metrics.json").write_text(json.dumps({"sea_state_in_words": ALL, "verdict": ALL, ALL: ALL}))
    with h5py.File(runs / f"run {ALL}" / "gauges.nc", "a") as file:
        file["gauge"][...] = ALL  # type: ignore[index]
    write_maps(runs / f"retrieval {ALL}", "maps")
    write_maps(runs / f"simulation {ALL}", "truth")
    write_shadowing(runs / f"shadowing {ALL}")
    sea = runs / f"sea {ALL}"
    sea.mkdir()
    for name in ("sea.nc", "from_mast.png", "statistics.txt"):
        (sea / name).write_bytes(_PIXEL if name.endswith("png") else ALL.encode())
    forecast = runs / f"forecast {ALL}"
    forecast.mkdir()
    forecasts().to_netcdf(forecast / "prediction.nc", engine="h5netcdf")
    for path in (*runs.glob("*/*.nc"),):
        if path.parent != sea:
            _spoil(path)
    trade = runs / f"trade {ALL}"
    write_trade(trade)
    for number, path in enumerate((trade / "points").iterdir()):
        told = json.loads(path.read_text())
        told["keys"] = {ALL: f"{number} {ALL}", **told["keys"]}
        told["metrics"] |= {"reach_m": 10.0}
        path.write_text(json.dumps(told))
    (trade / "points" / "refused.json").write_text(
        json.dumps({"keys": {ALL: ALL}, "seed": 1, "status": "refused", "reason": ALL})
    )
    (runs / ".jobs").mkdir()
    for number, state in enumerate(("failed", "cancelled", "done", "running")):
        note = {"name": f"{number} {ALL}", "title": ALL, "folder": f"{number} {ALL}", "words": [ALL], "reason": ALL}
        (runs / ".jobs" / f"{number} {ALL}.json").write_text(json.dumps({**note, "state": state}))
        (runs / ".jobs" / f"{number} {ALL}.progress").write_text(f"{time.time()} {ALL}\n")
    (runs / ".uploads").mkdir()
    for ending in (".npz", ".toml", ".csv"):
        (runs / ".uploads" / f"{ALL}{ending}").write_bytes(b"")
    (Path(os.fsdecode(os.fsencode(runs) + b"/\xff\xfe"))).mkdir()
    write_maps(runs / "\udcff", "maps")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A page of hostile folders."""
    runs = tmp_path_factory.mktemp("runs")
    _write(runs)
    served = serve(runs)
    yield served
    assert served.end() in (0, 130)


def _go(page: Page, place: str) -> None:
    page.locator(".q-header").get_by_role("tab", name=place, exact=True).click()


def _choose(page: Page, label: str, option: str) -> None:
    page.get_by_label(label, exact=True).locator("visible=true").first.click()
    page.get_by_role("option", name=option, exact=True).last.click()  # a list that was just shut may still be there


def _unharmed(page: Page, where: str) -> None:
    page.wait_for_timeout(300)
    assert page.evaluate("window.PWNED") is None, where
    assert page.locator("img[src=x], script:has-text('PWNED'), a[href^=javascript]").count() == 0, where
    assert "49" not in page.locator("body").inner_text().replace(ALL, ""), where  # {{7*7}}


def test_runs_lists_every_name_as_it_is(watched: Watched) -> None:
    page = watched.page
    _go(page, "Runs")
    for name in (*PAYLOADS, _NESTED, *(f"{kind} {ALL}" for kind in ("run", "trade", "sea", "forecast"))):
        expect(page.get_by_text(name, exact=False).first).to_be_visible()
        expect(page.get_by_role("button", name=f"See {name}", exact=True)).to_be_visible()
    page.get_by_text("Recorded echoes").click()
    page.get_by_label("Recording", exact=True).click()
    expect(page.get_by_role("option", name=f"{ALL}.npz", exact=True)).to_be_visible()
    page.keyboard.press("Escape")
    _unharmed(page, "Runs")


def test_see_shows_every_kind_of_folder_and_every_view(watched: Watched) -> None:
    page = watched.page
    _go(page, "See")
    _choose(page, "Run", f"run {ALL}")
    expect(page.get_by_text(re.compile(r"^turn 12 of 12 · "))).to_be_visible()
    views = page.get_by_role("tabpanel").get_by_role("tab").all_inner_texts()
    assert len(views) == 11
    for view in views:
        page.get_by_role("tab", name=view, exact=True).click()
        page.wait_for_timeout(700)
        _unharmed(page, view)
    page.get_by_role("tab", name="Gauges", exact=True).click()
    expect(page.get_by_text("At 60 m, 270°.")).to_be_visible()
    page.get_by_role("button", name="Download", exact=True).click()
    with page.expect_download() as taken:
        page.get_by_text("section and curves (CSV)").click()
    assert Path(taken.value.path()).read_text().startswith("section along")
    page.get_by_role("tab", name="Heights", exact=True).click()
    for kind, shown in (
        ("retrieval", "Retrieved height (m)"),
        ("simulation", "True height (m)"),
        ("shadowing", "Half of the sea is hidden"),
        ("sea", "The sea from the mast, rendered"),
        ("forecast", "Forecast"),
    ):
        _choose(page, "Run", f"{kind} {ALL} · {kind}")
        expect(page.get_by_text(shown).locator("visible=true").first).to_be_visible()
        if kind == "sea":
            expect(page.locator(".font-mono", has_text=ALL).locator("visible=true")).to_have_text(ALL)
            image = page.get_by_alt_text("The sea from the mast")
            assert image.evaluate("e => e.complete && e.naturalWidth") == 1  # its address is the folder's own
        _unharmed(page, kind)
    page.get_by_role("button", name="Download", exact=True).click()


def test_compare_shows_two_runs(watched: Watched) -> None:
    page = watched.page
    _go(page, "Compare")
    _choose(page, "A", f"run {ALL}")
    _choose(page, "B", f"retrieval {ALL}")
    expect(page.locator(".js-plotly-plot").first).to_be_visible()
    _unharmed(page, "Compare")


def test_a_trade_shows_its_keys_values_and_reasons(watched: Watched) -> None:
    page = watched.page
    _go(page, "Trade")
    _choose(page, "Trade", f"trade {ALL}")
    expect(page.get_by_text(re.compile('^2 points are there.*came to nothing, as: x"'))).to_be_visible()
    page.get_by_label("Point", exact=True).click()
    expect(page.get_by_role("option").filter(has_text=ALL).first).to_be_visible()
    page.get_by_role("option").first.click()
    expect(page.locator(".js-plotly-plot .xtick text", has_text="<img src=x").first).to_be_visible()
    expect(page.locator(".js-plotly-plot .g-xtitle", has_text="PWNED=1}`").first).to_be_visible()
    _unharmed(page, "Trade")
    page.get_by_role("button", name="Use these values in Design").click()
    _unharmed(page, "Trade, into the design")


def _load(page: Page, name: str, content: str) -> None:
    given: Any = {"name": name, "mimeType": "text/plain", "buffer": content.encode()}
    page.locator(".q-uploader input[type=file]").set_input_files(given)


def test_a_design_shows_what_was_typed_and_loaded(watched: Watched, server: Server) -> None:
    page = watched.page
    page.get_by_text("Scene file and command line").click()
    title = f"{ALL}\n```\n<img src=x onerror=window.PWNED=1>\n"
    _load(page, f"{ALL}.toml", load_scene("tiny", {"title": title}).to_toml())
    expect(page.get_by_text(re.compile(r"\.toml is loaded\."))).to_be_visible()
    expect(page.locator("code, pre").filter(has_text="```").first).to_be_visible()
    _unharmed(page, "a scene loaded")
    for content in (
        f"{json.dumps(ALL)} = 1",
        f"[radar]\ntype = {json.dumps(ALL)}",
        f"[[objects]]\nmesh = {json.dumps(ALL)}",
    ):
        _load(page, f"{ALL}.toml", content)
        expect(page.get_by_text("<img src=x").first).to_be_visible()
        _unharmed(page, content)
    _load(page, f"{ALL}.csv", "x")
    expect(page.get_by_text(re.compile("^Kept as"))).to_be_visible()
    _unharmed(page, "a file kept")
    for label in ("Antenna height above the sea (m)", "Range window (m)"):
        page.get_by_label(label, exact=True).fill(ALL)
        expect(page.get_by_text("must be").first).to_be_visible()
        _unharmed(page, label)
    assert all(each.name.isascii() for each in (server.runs / ".uploads").iterdir())
