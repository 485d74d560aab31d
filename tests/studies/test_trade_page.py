"""The page of a trade: its first words are the answer, its words are a reader's, and it needs no other file."""

from __future__ import annotations

import html
import re
from typing import Any

import numpy as np
import pytest
import xarray as xr

from seamap_rt.report.keys import words_of
from seamap_rt.report.style import png
from seamap_rt.studies.paired import seeds_for, significant_difference
from seamap_rt.studies.trade_figures import (
    draw_pareto,
    draw_quality,
    draw_shares,
    draw_trade,
    pareto_front,
    trade_images,
)
from seamap_rt.studies.trade_table import Criterion, trade_page, trade_table

HEIGHTS, BASELINES = [4.0, 8.0, 12.0], [0.2, 0.9]
RADIUS = np.array([[110.0, 112.0], [150.0, 151.0], [152.0, 153.0]])  # 8 m is within 5 % of the best


def made_up(seeds: int, scatter: float = 1.0) -> xr.Dataset:
    stream, ends = np.random.default_rng(4), dict[tuple[int, ...], dict[str, Any]]()
    ranges = np.arange(12.5, 300.0, 25.0)
    shared = scatter * stream.normal(size=seeds)
    for at in np.ndindex(3, 2, seeds):
        radius = RADIUS[at[:2]] + shared[at[2]] + 0.1 * scatter * stream.normal()
        score = np.clip(1.0 - ranges / (2.0 * radius), 0.0, 1.0)
        some = dict.fromkeys(("height_rmse_m", "height_bias_m", "slope_rmse", "visible_fraction", "answered",
                              "known_share"), [0.1] * ranges.size)  # fmt: skip
        ends[at] = {
            "status": "done",
            "reason": "",
            "cost": {"seconds": {"total": 3.0}, "peak_memory_bytes": 1e9},
            "metrics": {
                "fully_measured_radius_m": radius, "reach_m": 1.2 * radius, "reach_to_the_end": 0.0,
                "gross_share": 0.012, "missed_share": 0.3, "height_rmse_m": 0.09, "visible_fraction": 0.6,
                "half_visible_m": 120.0, "half_visible_vv_m": 104.0, "half_visible_hh_m": 106.0,
            },
            "by_range": {"range_m": ranges.tolist(), "quality": score.tolist(), **some},
            "facts": {"significant_height_m": 1.4},
        }  # fmt: skip
    vary = {"radar.height_m": HEIGHTS, "radar.baseline_m": BASELINES}
    return trade_table(
        vary, list(range(seeds)), ends, Criterion(), {"scene": 'name = "<made up>"', "polarization": "HH"}
    )


def page(table: xr.Dataset) -> str:
    return re.sub(r"base64,[^\"]*", "base64,", trade_page(table, trade_images(table, b"picture")))


def test_the_page_begins_with_what_to_choose() -> None:
    text = page(made_up(3))
    first = text.index("Baseline 0.2 m: lowest antenna height within 5% of the best: 8 m (confidence")
    assert first < text.index("<figure")
    assert text.count("<figure") == 5
    assert "half of the sea is visible to the radar in HH to 106 m (to light to 120 m)" in text[: first + 600]
    assert "radar.height_m" not in text[: text.index("<details")]  # a key's name is small print
    assert '<td data-by="8.0">8</td>' in text
    assert "1.2</td>" in text  # per cent of gross errors
    assert "&lt;made up&gt;" in text
    assert not re.search(r"https?://|url\(|@import|src=\"(?!data:)", text)


_MARKUP = "</td><script>x</script><img src=x onerror=alert(1)>{{7*7}}"
_FORMULA = "$\\frac{$ $a$"  # no whole one: Matplotlib refuses it
_GATES = {"radar.height_m": HEIGHTS, "radar.gates": [8, 9]}


@pytest.mark.parametrize(
    ("text", "others"),
    [(_MARKUP, {}), (_FORMULA, {}), (_FORMULA, {"radar.height_m": HEIGHTS}), (_FORMULA, _GATES)],
)
@pytest.mark.slow
def test_a_value_in_words_is_those_words_on_the_page_and_in_its_figures(text: str, others: dict[str, Any]) -> None:
    table = made_up(3).isel({"radar.baseline_m": [0]}, drop=True)
    for key, values in {"sea.waves.0.file": [text, f"{text}2"], **others}.items():
        if key not in table.dims:
            table = xr.concat([table] * len(values), key).assign_coords({key: values})
    table = table.transpose(*(dim for dim in table.dims if dim != "seed"), "seed")
    table["reason"] = xr.full_like(table["status"], text, dtype=object)
    made = page(table)
    assert html.escape(text) in made.replace("&#39;", "&#x27;").replace("&#34;", "&quot;")
    assert "<img src=x" not in made
    assert "<script>x" not in made
    for figure in (draw_trade(table), draw_pareto(table)):
        assert png(figure)


def test_one_seed_says_that_nothing_is_sure() -> None:
    text = page(made_up(1))
    assert "One seed: no bands" in text
    assert "confidence" not in text[: text.index("<figure")].replace("no word on how sure", "")


def test_seeds_that_a_band_asks_for_grow_by_the_square() -> None:
    """Of a scatter of 50 m a seed, (1.96 · 5)² = 96 seeds have a mean known to ± 10 m; t asks for a few more."""
    half = 50.0 / np.sqrt(3.0) * 4.303  # t of two degrees of freedom
    assert 97 <= int(re.findall(r"about (\d+) seeds", seeds_for(3, half))[0]) <= 100
    assert "seeds" in page(made_up(3, scatter=15.0)).split("Bands of ± 10 m ask for about")[1][:20]
    assert "ask for about" not in page(made_up(3, scatter=0.1))


def test_a_page_without_results_says_so() -> None:
    empty = trade_table({"radar.height_m": HEIGHTS}, [1], {}, Criterion(), {})
    text = page(empty)
    assert "Nothing has a result yet" in text
    assert text.count("<figure") == 1


def test_a_front_counts_what_the_seeds_tell_from_chance() -> None:
    cost, gain = np.array([1.0, 2.0, 3.0, 4.0]), np.array([100.0, 101.0, 140.0, 141.5])
    assert pareto_front(cost, gain).tolist() == [0, 1, 2, 3]
    assert pareto_front(cost, gain, 5.0).tolist() == [0, 2]


def test_a_significant_difference_holds_nineteen_of_twenty() -> None:
    """Two designs alike, over seas that they share: their means differ by more in one sweep of twenty."""
    stream, beyond = np.random.default_rng(5), []
    for _ in range(2000):
        values = 20.0 * stream.normal(size=(1, 4)) + stream.normal(size=(5, 4))
        table = xr.DataArray(values, dims=("radar.height_m", "seed"))
        mean = table.mean("seed").values
        beyond.append(abs(mean[1] - mean[0]) > significant_difference(table))
    assert np.mean(beyond) == pytest.approx(0.05, abs=0.015)  # 3 σ of 2000 draws
    assert np.isnan(significant_difference(xr.DataArray([[1.0], [2.0]], dims=("radar.height_m", "seed"))))


def test_pictures_show_scores_and_shares() -> None:
    table = made_up(2)
    axes = draw_quality(table).axes
    assert len(axes) == len(BASELINES)
    assert [line.get_label() for line in axes[0].lines[:3]] == ["4", "8", "12"]
    assert np.allclose(axes[0].lines[0].get_ydata(), table["quality_by_range"].mean("seed")[0, 0])
    wrong = draw_shares(table).axes[0]
    assert np.allclose(wrong.lines[0].get_ydata(), 1.2)


@pytest.mark.parametrize(
    ("key", "label", "value"),
    [
        ("radar.height_m", "Antenna height (m)", "3 m"),
        ("sea.waves.0.significant_wave_height_m", "Significant wave height (m)", "3 m"),
        ("radar.antenna.ohmic_loss_db", "Antenna ohmic loss (dB)", "3 dB"),
        ("platform.speed_m_s", "Platform speed (m/s)", "3 m/s"),
        ("scattering.nrcs", "Echo model", "3"),
    ],
)
def test_keys_have_words_and_units(key: str, label: str, value: str) -> None:
    words = words_of(key)
    assert (words.label, words.value(3.0)) == (label, value)
    assert words.meaning.endswith(".") or "`" in words.meaning
