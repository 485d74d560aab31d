"""Gauges that a scene refuses, and those that it takes."""

from __future__ import annotations

from pathlib import Path

import pytest
from made_gauges import with_gauges

from seamap_rt.errors import InputError
from seamap_rt.scene import load_scene

# --------------------------------------------------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("tables", "parts"),
    [
        (['name = "a"'], ["gauges.0: ", "east_m and north_m", "ground_range_m and azimuth_deg", "nothing"]),
        (['name = "a"\neast_m = 1.0'], ["gauges.0: ", "a mixture"]),
        (
            ['name = "a"\neast_m = -50.0\nnorth_m = 0.0\nazimuth_deg = 270.0\nground_range_m = 50.0'],
            ["gauges.0: ", "a mixture"],
        ),
        (["east_m = -50.0\nnorth_m = 0.0"], ["gauges.0.name: is missing"]),
        (['name = "$x"\neast_m = -50.0\nnorth_m = 0.0'], ['gauges.0.name = "$x"', "letters"]),
        (['name = "a"\neast_m = -50.0\nnorth_m = nan'], ["gauges.0.north_m = nan", "not a number"]),
        (
            ['name = "a"\neast_m = -50.0\nnorth_m = 0.0', 'name = "a"\neast_m = -40.0\nnorth_m = 0.0'],
            ["gauges.1.name = 'a'", "name of gauges.0", "its own"],
        ),
        (
            ['name = "a"\neast_m = -50.0\nnorth_m = 0.0', 'name = "b"\neast_m = -4.0\nnorth_m = 0.0\nsample_hz = 8.0'],
            ["gauges.1.sample_hz = 8: must be 4", "one rate"],
        ),
        (
            ['name = "a"\neast_m = -80.0\nnorth_m = 0.0'],
            ["gauges.0: 'a' stands 80 m from the antenna, and must stand 12.69 to 64.5 m", "radar.range_m"],
        ),
        (['name = "a"\neast_m = -12.0\nnorth_m = 0.0'], ["'a' stands 12 m", "12.69"]),
        (
            ['name = "a"\neast_m = 50.0\nnorth_m = 0.0'],
            ["gauges.0: 'a' stands at azimuth 90°, outside of radar.sector_deg (264° to 276°)", "move it"],
        ),
        (['name = "a"\neast_m = -50.0\nnorth_m = 0.0\nsample_hz = 0.0'], ["gauges.0.sample_hz = 0", "at least 0.1"]),
        (['name = "a"\neast_m = -50.0\nnorth_m = 0.0\nheight_m = 0.0'], ["gauges.0.height_m", "unknown key"]),
    ],
)
def test_a_gauge_that_cannot_be_is_refused_in_one_line(tmp_path: Path, tables: list[str], parts: list[str]) -> None:
    file = with_gauges(tmp_path, 1, *tables)
    with pytest.raises(InputError) as caught:
        load_scene(file)
    line = str(caught.value)
    assert line.splitlines() == list(caught.value.problems)
    for part in parts:
        assert part in line, line


@pytest.mark.parametrize(("away", "azimuth"), [(12.69, 264.0), (64.5, -84.0)])
def test_limits_that_a_refusal_names_pass(tmp_path: Path, away: float, azimuth: float) -> None:
    load_scene(with_gauges(tmp_path, 1, f'name = "a"\nground_range_m = {away}\nazimuth_deg = {azimuth}'))


def test_a_boat_under_way_may_come_to_its_gauges(tmp_path: Path) -> None:
    file = with_gauges(tmp_path, 1, 'name = "a"\neast_m = 50.0\nnorth_m = 0.0')
    assert load_scene(file, {"platform.speed_m_s": 3.0}).gauges[0].position == (50.0, 0.0)


def test_a_staring_radar_has_one_look(tmp_path: Path) -> None:
    table = 'name = "a"\nground_range_m = 50.0\nazimuth_deg = '
    load_scene(with_gauges(tmp_path, 1, f"{table}270.5"), {"radar.scan": "staring"})
    with pytest.raises(InputError, match=r"the one look of radar\.sector_deg"):
        load_scene(with_gauges(tmp_path, 1, f"{table}272.0"), {"radar.scan": "staring"})
