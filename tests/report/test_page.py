"""The report: whole, self-contained, and unmoved by hard cases."""

from __future__ import annotations

import html
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import made_run
import numpy as np
import pytest
from made_run import PICTURES, TINY, Run, images_of, shown, small, values
from matplotlib.patches import Rectangle
from numpy.testing import assert_allclose

from seamap_rt.io import results_folder
from seamap_rt.report import page
from seamap_rt.report.curves import height_scatter, timing
from seamap_rt.report.maps import height_maps
from seamap_rt.report.page import write_report
from seamap_rt.scene import load_scene

run, coarse_pictures = made_run.run, made_run.coarse_pictures  # fixtures


class _Resources(HTMLParser):
    """Everything that a page would load."""

    def __init__(self) -> None:
        super().__init__()
        self.images: list[dict[str, str | None]] = []
        self.loaded: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        named = [value or "" for name, value in attrs if name in ("src", "href", "srcset", "data", "action")]
        self.loaded += [address for address in named if not address.startswith("#")]  # a place on the page itself
        if tag == "img":
            self.images.append(dict(attrs))


# ------------------------------------------------------------------------------------------------------ the page


def test_page_is_whole_and_needs_no_other_file(run: Run, tmp_path: Path) -> None:
    path = write_report(tmp_path / "new" / "folder", run.scene, run.maps, run.truth, run.metrics, run.echoes)
    assert path.name == "report.html"
    assert sorted(item.name for item in path.parent.iterdir()) == sorted(
        ["report.html", *(f"{name}.png" for name in PICTURES)]
    )
    text = path.read_text(encoding="utf-8")
    assert len(text) < 6_000_000
    found = _Resources()
    found.feed(text)
    assert len(found.images) == len(PICTURES)
    assert all((image["src"] or "").startswith("data:image/png;base64,") for image in found.images)
    assert all(len(image["alt"] or "") > 20 for image in found.images)
    assert all(address.startswith("data:") for address in found.loaded)
    assert "script" not in found.tags
    without_pictures = re.sub(r"base64,[^\"]*", "", text)
    assert not re.search(r"https?://|url\(|@import|//[a-z]+\.", without_pictures)
    for name in PICTURES:
        assert f'<figure id="{name}">' in text
        assert (path.parent / f"{name}.png").read_bytes().startswith(b"\x89PNG\r\n")


@pytest.mark.usefixtures("no_pictures")
def test_page_says_the_headline_figures_and_the_scene(run: Run, tmp_path: Path) -> None:
    text = write_report(tmp_path, run.scene, run.maps, run.truth, run.metrics, run.echoes).read_text(encoding="utf-8")
    plain = html.unescape(re.sub(r"base64,[^\"]*", "", text))
    for words in ("0.123 m", "0.099 m", "−0.012 m", "0.951", "1.41 m", "1.54 ± 0.06 m", "1 234 567", "1.90 GB"):
        assert words in plain, words
    assert "Sees the waves out to 143 m, their height to ± 12 cm" in plain
    assert plain.index("Sees the waves out to") < plain.index("<nav>") < plain.index("How it was made</h2>")
    assert "5 m mast, antennas 0.2 m apart, 1 W" in plain
    assert run.scene.to_toml() in plain
    assert "Breaking <waves>" in plain
    assert "Breaking &lt;waves&gt;" in text
    assert "Shadowing" in plain
    assert "at 1° grazing it decides what is seen" in plain
    assert "Turn by turn" not in plain


def test_a_failed_drawing_leaves_the_old_page_and_no_scraps(run: Run, tmp_path: Path, monkeypatch: Any) -> None:
    every = page.pictures
    monkeypatch.setattr(page, "pictures", lambda *given: every(*given)[:2])
    path = write_report(tmp_path, run.scene, run.maps, run.truth, run.metrics, run.echoes)
    before = {item.name: item.read_bytes() for item in tmp_path.iterdir()}

    def fail(*_: Any) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(results_folder.os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        write_report(tmp_path, run.scene, run.maps, run.truth, run.metrics, run.echoes)
    assert path.exists()
    assert {item.name: item.read_bytes() for item in tmp_path.iterdir()} == before


def test_several_turns_have_a_table_and_the_last_is_shown(tmp_path: Path) -> None:
    run = Run(small(turns=3))
    values(run.maps, "ground/height")[2, 10, 20] = 0.777
    text = write_report(tmp_path, run.scene, run.maps, run.truth, run.metrics, run.echoes).read_text(encoding="utf-8")
    assert "Turn by turn" in text
    assert "The last of 3 turns (turn 3) is shown." in text
    last = shown(images_of(height_maps(run.scene, run.maps, run.truth))[1])
    assert_allclose(last[10, 20], 0.777, rtol=1e-6)


# ------------------------------------------------------------------------------------------------------- hard cases


def _empty(run: Run) -> None:
    for tree in (run.maps, run.truth):
        for group in ("polar", "ground"):
            for variable in tree[group].dataset.data_vars.values():
                if variable.dtype.kind == "f":
                    variable.values[...] = np.nan


HARD: dict[str, Any] = {
    "total shadow": lambda: Run(small(), lit=False),
    "flat sea": lambda: Run(
        load_scene("flat", {**TINY, "radar.range_m": [15.0, 150.0], "retrieval.ground_m": 6.0}), waves=0.0, noise=0.0
    ),
    "sector across north": lambda: Run(small(radar__sector_deg=[330.0, 390.0])),
    "one look": lambda: Run(small(radar__sector_deg=[90.0, 96.0])),
    "no noise": lambda: Run(small(radar__noise=False)),
    "far and coarse": lambda: Run(small(radar__range_m=[60.0, 170.0], radar__sector_deg=[0.0, 180.0])),
}


@pytest.mark.parametrize("case", HARD)
@pytest.mark.slow
def test_hard_cases_are_drawn(case: str, tmp_path: Path) -> None:
    run = HARD[case]()
    if case == "no noise":
        run.echoes.attrs["noise_power_w"] = 0.0
    text = write_report(tmp_path, run.scene, run.maps, run.truth, run.metrics, run.echoes).read_text(encoding="utf-8")
    assert text.count("<figure id=") == len(PICTURES)
    limits = images_of(height_maps(run.scene, run.maps, run.truth))[0].images[0].get_clim()
    assert limits[1] >= 0.05


def test_nothing_but_missing_values_is_drawn_and_said_with_dashes(tmp_path: Path) -> None:
    run = Run(small(radar__sector_deg=[0.0, 90.0]))
    _empty(run)
    run.echoes["voltage"].values[...] = np.nan
    text = write_report(tmp_path, run.scene, run.maps, run.truth, {}, run.echoes).read_text(encoding="utf-8")
    plain = html.unescape(re.sub(r"base64,[^\"]*", "", text))
    assert "off by — rms (— robust, bias —)" in plain
    assert "nan" not in re.sub(r"<style>.*</style>", "", plain, flags=re.DOTALL).lower().replace("finance", "")
    assert "None" not in plain


@pytest.mark.parametrize(
    "metrics",
    [
        {"overall": None, "timing_s": None, "range_m": None, "modelled": None},
        {"timing_s": {"sea": 1.0, "trace": None, "total": 1.0}, "range_m": [50.0], "height_rmse_m": [None]},
        {"range_m": [50.0, 100.0], "height_rmse_m": [0.1], "left_out": ["rain"], "slope_rms_look": [0.1, 0.12]},
    ],
)
def test_missing_metrics_are_survived(run: Run, metrics: dict[str, Any], tmp_path: Path) -> None:
    text = write_report(tmp_path, run.scene, run.maps, run.truth, metrics, run.echoes).read_text(encoding="utf-8")
    assert text.count("<figure id=") == len(PICTURES)
    assert "—" in text


def test_each_figure_stands_alone(run: Run) -> None:
    for figure in (height_scatter(run.maps, run.truth), timing(run.scene, run.metrics)):
        assert figure.get_size_inches()[0] == 7.2
    bars = [bar for bar in timing(run.scene, run.metrics).axes[0].patches if isinstance(bar, Rectangle)]
    assert_allclose([bar.get_width() for bar in bars[:6]], [1.2, 0.4, 3.1, 2.2, 0.6, 0.2])
