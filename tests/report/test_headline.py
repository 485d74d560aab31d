"""What a run says first: a sentence that a reader can act on, true at its edges too."""

from __future__ import annotations

from typing import Any

from made_run import small

from seamap_rt.report.headline import run_line, verdict, warnings, wave_height

MEASURED = {
    "fully_measured_radius_m": 141.3,
    "reach_m": 167.2,
    "reach_to_the_end": 0.0,
    "gross_share": 0.0,
    "missed_share": 0.284,
}
OVERALL = {"height_rmse_m": 0.0926, "range_m": [50.0, 200.0]}


def said(overall: dict[str, Any] | None = None, **changes: Any) -> str:
    return verdict({"measured": {**MEASURED, **changes}, "overall": {**OVERALL, **(overall or {})}})


def test_verdict_says_how_far_how_well_and_what_is_missed() -> None:
    assert said() == (
        "Sees the waves out to 167 m, their height to ± 9 cm: in all as much as a map without gaps or errors out to "
        "141 m (fully measured radius); it misses 28 % of the cells at 50 to 200 m."
    )


def test_verdict_says_where_the_radar_ends_and_not_the_sea() -> None:
    assert "out to more than 167 m" in said(reach_to_the_end=1.0)
    assert "at 50 to 150 m" in said({"range_m": [50.0, 150.0]})
    assert "of the cells." in said({"range_m": None})


def test_verdict_owns_up_to_gross_errors() -> None:
    assert "wrong by more than half the wave height" not in said(gross_share=0.004)
    assert "6 % of its heights are wrong by more than half the wave height" in said(gross_share=0.06)


def test_verdict_of_a_radar_that_sees_nothing_and_of_a_sea_without_waves() -> None:
    assert said(reach_m=0.0, fully_measured_radius_m=0.0).startswith("This radar hardly measures this sea")
    assert said(fully_measured_radius_m=None) == ""
    assert verdict({}) == ""
    assert "± 4 mm" in said({"height_rmse_m": 0.004})


def test_run_line_is_of_the_scene_as_run() -> None:
    words = run_line(small(radar__height_m=12.0, radar__baseline_m=0.4, turns=3))
    assert "12 m mast" in words
    assert "0.4 m apart" in words
    assert "3 turns" in words


def test_wave_height_is_that_of_all_turns_with_its_error() -> None:
    state = {"significant_wave_height": [1.48, 1.52], "significant_wave_height_std": [0.09, 0.06]}
    assert wave_height({"sea_state": state}) == "1.52 ± 0.06 m"
    few = {"significant_wave_height": [None], "significant_wave_height_least": [0.9]}
    assert wave_height({"sea_state": few}) == "at least 0.90 m"
    assert wave_height({"sea_state": {"significant_wave_height": [None]}}) == "—"
    assert wave_height({}) == "—"


def test_objects_that_outshine_the_sea_are_said_first() -> None:
    row = {"what": "objects", "value": 31.7, "unit": "dB", "error": "32 dB over the sea in its cell, at most"}
    (line,) = warnings({"modelled": [row]})
    assert "32 dB" in line
    assert warnings({"modelled": [{**row, "value": -3.0}]}) == []
    assert warnings({"modelled": [{**row, "unit": "objects"}]}) == []


def test_a_map_without_heights_of_a_sea_in_sight_says_both() -> None:
    measured = {"reach_m": 0.0, "fully_measured_radius_m": 0.0}
    text = verdict({"measured": measured, "overall": {"cells": 0, "visible_fraction": 0.99}})
    assert text.endswith("no cell gets a sure height, and 99 % of the sea is in sight.")
