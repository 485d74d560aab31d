"""The page in a real browser while its drawings are slow: it answers, and nothing stands under another's name."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from browsing import Server, choose, open_page, serve
from made_folders import maps_tree, write_run
from playwright.sync_api import Browser, Page, expect

pytestmark = pytest.mark.browser

_DRAWS_S, _SOON_S = 3.0, 1.0  # the law of the page is 0.5 s; a machine that runs other tests is given twice that
_TURNS = 4
_VIEWS = ("Heights", "By range", "Forecast", "3-D")

# What stands there and is not greyed, by the view's name, the turn's and a print of all that is drawn.
_WATCH = """
() => {
  const print = (text) => { let h = 0; for (const c of text) h = (h * 31 + c.charCodeAt(0)) | 0; return h; };
  window.seen_ = [];
  window.look_ = () => {
    const shown = (each) => each.offsetParent !== null;
    const tab = [...document.querySelectorAll('[role=tab][aria-selected=true]')].filter(shown).map((e) => e.innerText);
    const clock = [...document.querySelectorAll('div')].filter(shown).map((e) => e.innerText)
      .find((t) => /^turn \\d+ of \\d+/.test(t) && t.length < 40) ?? "";
    const plots = [...document.querySelectorAll('.js-plotly-plot')].filter(shown);
    const drawn = plots.map((e) => e.querySelector('.gtitle')?.textContent + '|'
      + [...e.querySelectorAll('.imagelayer image')].map((i) => print(i.href.baseVal)) + '|'
      + [...e.querySelectorAll('.scatterlayer path.js-line')].map((p) => p.getAttribute('d').length) + '|'
      + print(JSON.stringify((e.data ?? []).map((d) => [d.y, d.z, d.vertexcolor]))));
    drawn.push(...[...document.querySelectorAll('img.drawn-figure')].filter(shown).map((e) => e.alt + print(e.src)));
    return [tab[tab.length - 1], clock.split(' · ')[0], drawn.join(';'),
            document.querySelector('.stale:not(.waits)') !== null];
  };
  setInterval(() => window.seen_.push([performance.now(), ...window.look_()]), 50);
}
"""


@pytest.fixture(scope="module")
def slowness(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Seconds that each drawing takes."""
    file = tmp_path_factory.mktemp("slow") / "seconds"
    file.write_text("0")
    return file


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory, slowness: Path) -> Iterator[Server]:
    served = serve(tmp_path_factory.mktemp("runs"), (str(Path(__file__).with_name("slow_page.py")), str(slowness)))
    folder = served.runs / "whole"
    write_run(folder, turns=_TURNS)
    for name in ("maps", "truth"):  # no two turns are alike
        tree = maps_tree(name == "maps", _TURNS)
        for group in ("polar", "ground"):
            one = tree[group].to_dataset()
            one["height"] = one["height"] * (1.0 - 0.2 * np.arange(_TURNS)[:, None, None])
            tree[group] = one
        tree.to_netcdf(folder / f"{name}.nc", engine="h5netcdf")
    yield served
    begin = time.monotonic()
    assert served.end() in (0, 130)
    assert time.monotonic() - begin < 15.0  # what draws is not waited for


def _view(page: Page, name: str) -> None:
    page.get_by_role("tab", name=name, exact=True).click()


def _stands(page: Page, view: str, turn: int) -> str:
    """What is drawn of a view and a turn, when it stands."""
    expect(page.get_by_text(re.compile(rf"^turn {turn} of {_TURNS} · "))).to_be_visible()
    expect(page.locator(".stale")).to_have_count(0)
    page.wait_for_timeout(700)  # the browser has drawn it
    told = page.evaluate("window.look_()")
    assert told[0] == view
    assert told[1] == f"turn {turn} of {_TURNS}"
    return told[2]


def test_under_a_tab_and_a_turn_stands_nothing_but_theirs_while_drawings_are_slow(
    browser: Browser, server: Server, slowness: Path
) -> None:
    watched = open_page(browser, server)
    page = watched.page
    page.locator(".q-header").get_by_role("tab", name="See", exact=True).click()
    choose(page, "Run", "whole")
    page.evaluate(_WATCH)
    known = {}
    before = page.get_by_role("button", name="Turn before")
    for view in _VIEWS:
        _view(page, view)
        for turn in range(_TURNS, 0, -1):
            known[view, turn] = _stands(page, view, turn)
            before.click()  # after the first the last follows
    assert len(set(known.values())) == len(known)  # all differ

    slowness.write_text(str(_DRAWS_S))
    answers = []
    page.evaluate("window.seen_.length = 0")
    for view in ("Forecast", "Heights", "3-D", "By range", "Forecast", "Heights"):
        begin = time.monotonic()
        _view(page, view)
        line = page.get_by_text(re.compile(rf"^drawing {re.escape(view)}, turn \d"))
        expect(line).to_be_visible()
        answers.append(time.monotonic() - begin)
        page.wait_for_timeout(300)
        before.click()  # six times: from the last turn to the second
        page.wait_for_timeout(300)
    for place, there in (
        ("Runs", page.get_by_role("button", name="See whole")),
        ("See", page.get_by_label("Next turn")),
    ):
        begin = time.monotonic()
        page.locator(".q-header").get_by_role("tab", name=place, exact=True).click()  # other places answer too
        expect(there).to_be_visible()
        answers.append(time.monotonic() - begin)
    seen = page.evaluate("window.seen_")
    slowness.write_text("0")
    _stands(page, "Heights", 2)
    print("answers", [f"{each:.2f}" for each in answers])
    assert sorted(answers)[len(answers) // 2] < _SOON_S
    assert any(stale for *_, stale in seen)
    wrong_s = _longest_wrong(seen, known)
    assert wrong_s < _SOON_S, json.dumps(seen)[-3000:]
    page.context.close()
    assert watched.wrong == []


def _longest_wrong(seen: list, known: dict[tuple[str, int], str]) -> float:
    """Seconds for which something stood ungreyed, on end, that is not what its view and turn show."""
    longest, since = 0.0, None
    for when, view, clock, drawn, stale in seen:
        turn = int(clock.split()[1]) if clock else 0
        if view not in _VIEWS or stale or not drawn or drawn == known.get((view, turn)):
            since = None
        else:
            since = when if since is None else since
            longest = max(longest, (when - since) / 1000.0)
    return longest
