"""Recorded motions: what the columns mean, how they are interpolated, and one line for whatever is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from seamap_rt.errors import InputError
from seamap_rt.io.motionfile import MotionRecord, read_motion


def written(folder: Path, text: str) -> Path:
    path = folder / "motion.csv"
    path.write_bytes(text.encode())
    return path


def read(folder: Path, text: str, heading_deg: float = 0.0) -> MotionRecord:
    return read_motion(written(folder, text), heading_deg)


def refusal(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        read_motion(path)
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith("file '")
    assert ";" in line  # what to do about it
    return line


# ------------------------------------------------------------------------------------------------ what is in a file


def test_columns_are_found_by_their_names_in_any_order(tmp_path: Path) -> None:
    record = read(tmp_path, "heave_m,y_m,time_s,pitch_deg,x_m,heading_deg,roll_deg\n7,6,0,2,5,3,1\n7,6,1,2,5,3,1\n")
    np.testing.assert_array_equal(record.time, [0.0, 1.0])
    np.testing.assert_array_equal(record.attitude, [[1.0, 2.0, 3.0]] * 2)
    np.testing.assert_array_equal(record.position, [[0.0, 0.0, 7.0]] * 2)  # places count from time 0, heights do not


def test_columns_left_out_are_zero_and_the_heading_is_the_settings_own(tmp_path: Path) -> None:
    record = read(tmp_path, "time_s,roll_deg\n0,1\n1,2\n", heading_deg=-75.0)
    np.testing.assert_array_equal(record.attitude, [[1.0, 0.0, -75.0], [2.0, 0.0, -75.0]])
    np.testing.assert_array_equal(record.position, 0.0)
    # A heading in the file is the heading.
    assert read(tmp_path, "time_s,heading_deg\n0,10\n1,20\n", heading_deg=-75.0).attitude[0, 2] == 10.0


def test_other_names_comments_spaces_capitals_and_dos_lines(tmp_path: Path) -> None:
    text = "\ufeff# logged aboard\r\n\r\nTime_s, Yaw_deg , z_m\r\n0, 10, 1\r\n# a remark\r\n 1,11,2\r\n"
    record = read(tmp_path, text)
    np.testing.assert_array_equal(record.attitude[:, 2], [10.0, 11.0])
    np.testing.assert_array_equal(record.position[:, 2], [1.0, 2.0])


def test_the_heading_does_not_jump_through_north(tmp_path: Path) -> None:
    heading = np.arange(340.0, 800.0, 7.0)  # a turn and a quarter
    rows = "".join(f"{0.2 * n:.1f},{value % 360.0}\n" for n, value in enumerate(heading))
    record = read(tmp_path, f"time_s,heading_deg\n{rows}")
    np.testing.assert_allclose(record.attitude[:, 2], heading, atol=1e-9)
    between = record.pose_at([0.5, 0.65])[1][:, 2]
    np.testing.assert_allclose(between, [340.0 + 7.0 * 2.5, 340.0 + 7.0 * 3.25], atol=1e-9)


def test_places_count_from_where_the_boat_is_at_time_0(tmp_path: Path) -> None:
    rows = "".join(f"{t},{350_000.0 + 3.0 * t},{5_600_000.0 - 4.0 * t},{0.1 * t}\n" for t in (-0.5, 0.25, 1.0))
    record = read(tmp_path, f"time_s,x_m,y_m,heave_m\n{rows}")
    position = record.pose_at([-0.5, 0.0, 1.0])[0]
    # Rounding of UTM's northing: 1e-9 m.
    np.testing.assert_allclose(position, [[-1.5, 2.0, -0.05], [0.0, 0.0, 0.0], [3.0, -4.0, 0.1]], atol=5e-9)
    late = read(tmp_path, "time_s,x_m\n100,7\n100.5,9\n")
    np.testing.assert_array_equal(late.position[:, 0], [0.0, 2.0])


# ------------------------------------------------------------------------------------------------- between readings


def test_a_cubic_is_met_exactly(tmp_path: Path) -> None:
    time = np.array([0.0, 0.3, 0.5, 0.9, 1.2, 1.6])
    rows = "".join(f"{t!r},{t**3 - 2.0 * t!r}\n" for t in time.tolist())
    record = read(tmp_path, f"time_s,roll_deg\n{rows}")
    asked = np.linspace(0.0, 1.6, 41)
    np.testing.assert_allclose(record.pose_at(asked)[1][:, 0], asked**3 - 2.0 * asked, atol=1e-14)


def test_between_readings_it_is_smooth(tmp_path: Path) -> None:
    period, step = 4.0, 0.1
    time = np.arange(0.0, 12.0, step)
    rows = "".join(f"{t:.1f},{10.0 * np.sin(2.0 * np.pi * t / period):.15g}\n" for t in time)
    record = read(tmp_path, f"time_s,pitch_deg\n{rows}")
    asked = np.linspace(1.0, 10.0, 5001)
    error = record.pose_at(asked)[1][:, 1] - 10.0 * np.sin(2.0 * np.pi * asked / period)
    # A cubic spline between even readings errs by (ω Δ)⁴/384 of the amplitude (Hall 1968): 1.6e-6.
    assert np.max(np.abs(error)) < 1.1 * 10.0 * (2.0 * np.pi / period * step) ** 4 / 384.0
    # Second differences do not jump where it passes a reading.
    near = 3.0 + np.array([-2e-3, -1e-3, 0.0, 1e-3, 2e-3])
    bend = np.diff(record.pose_at(near)[1][:, 1], n=2) / 1e-6
    assert np.ptp(bend) < 10.0 * (2.0 * np.pi / period) ** 3 * 4e-3  # as it changes anyway


def test_beyond_the_record_it_is_refused(tmp_path: Path) -> None:
    record = read(tmp_path, "time_s,roll_deg\n0,1\n0.5,2\n1,3\n")
    _, attitude = record.pose_at([-0.4, 1.4])  # a turn hears the sea beside it: so far the boat keeps its rates
    np.testing.assert_allclose(attitude[:, 0], [0.2, 3.8], rtol=1e-12)
    for time in (-0.6, 1.6, np.nan):
        with pytest.raises(InputError) as caught:
            record.pose_at([0.5, time])
        line = str(caught.value)
        assert "0 to 1 s" in line
        assert f"{time:.10g} s was asked for" in line
        assert "motion.csv" in line


# ------------------------------------------------------------------------------------------------- what is refused


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("roll_deg,pitch_deg\n1,2\n1,2\n", 1, "no column time_s"),
        ("time_s;roll_deg\n0;1\n1;2\n", 1, "commas between them and points"),
        ("", 1, "no column time_s"),
        ("time_s,rol_deg\n0,1\n1,2\n", 1, "column 'rol_deg'"),
        ("time_s,roll_deg,roll_deg\n0,1,1\n1,2,2\n", 1, "column roll_deg: must be there once"),
        ("time_s,heading_deg,yaw_deg\n0,1,1\n1,2,2\n", 1, "column heading_deg: must be there once"),
        ("time_s,roll_deg\n0,1\n0.2,2\n0.1,3\n", 4, "time_s = 0.1: must be later than 0.2"),
        ("time_s,roll_deg\n0,1\n# two of one time\n0.2,2\n0.2,3\n", 5, "time_s = 0.2: must be later than 0.2"),
        ("time_s,roll_deg\n0,1\n0.1,nan\n", 3, "roll_deg = 'nan': must be a finite number"),
        ("time_s,heave_m\n0,1\n0.1,-1e308\n", 3, "heave_m = -1e+308: must lie within ±100"),
        ("time_s,x_m\n0,1e9\n0.1,0\n", 2, "x_m = 1e+09: must lie within ±1e+08"),
        ("time_s,roll_deg\n0,1\n0.1,inf\n", 3, "roll_deg = 'inf': must be a finite number"),
        ("time_s,roll_deg\n0,1\n0.1,\n", 3, "roll_deg = '': must be a finite number"),
        ("time_s,roll_deg\n0,1\nsoon,2\n", 3, "time_s = 'soon': must be a finite number"),
        ("time_s,roll_deg\n0,1\n0.1\n", 3, "1 values: must be 2"),
        ("time_s,roll_deg\n", 1, "holds 0 readings: must be at least 2"),
        ("time_s,roll_deg\n0,1\n", 2, "holds 1 readings: must be at least 2"),
        (
            "time_s,roll_deg\n0,1\n0.1,2\n0.2,3\n0.8,4\n0.9,5\n",
            5,
            "a gap of 0.6 s from 0.2 to 0.8 s: must be at most 0.5",
        ),
        ("time_s,roll_deg\n0,1\n1,2\n2,3\n7.5,4\n8.5,5\n", 5, "a gap of 5.5 s from 2 to 7.5 s: must be at most 5"),
        ("time_s,roll_deg\n0,1\n0.1,60.5\n", 3, "roll_deg = 60.5: must lie within ±60"),
        ("time_s,pitch_deg\n0,-61\n0.1,0\n", 2, "pitch_deg = -61: must lie within ±60"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path: Path, text: str, line: int, words: str) -> None:
    said = refusal(written(tmp_path, text))
    assert f"motion.csv', line {line}: " in said
    assert words in said


@pytest.mark.parametrize(
    "text",
    [
        "time_s,roll_deg\n0,1\n0.1,2\n0.2,3\n0.7,4\n",  # half a second is no gap
        "time_s,roll_deg\n0,1\n1,2\n2,3\n7,4\n8,5\n9,6\n",  # nor are five steps
        "time_s,roll_deg,pitch_deg\n0,60,-60\n0.1,0,0\n",
    ],
)
def test_what_lies_on_a_limit_passes(tmp_path: Path, text: str) -> None:
    """… and every reading of it is kept."""
    record = read(tmp_path, text)
    rows = [[float(cell) for cell in line.split(",")] for line in text.split()[1:]]
    np.testing.assert_array_equal(record.time, [row[0] for row in rows])
    np.testing.assert_array_equal(record.attitude[:, 0], [row[1] for row in rows])


def test_files_that_are_none(tmp_path: Path) -> None:
    assert "no such file" in refusal(tmp_path / "none.csv")
    assert "is a folder" in refusal(tmp_path)
    path = tmp_path / "motion.csv"
    path.write_bytes(b"time_s,roll_deg\n0,\xff\xfe\n")
    assert "not UTF-8" in refusal(path)
    path.write_bytes(b"time_s,roll_deg\n0,1\n\x001,2\n")
    refusal(path)
