"""Measured patterns: what comes back of a known one, the two formats' conventions, one-line refusals."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from seamap_rt.conventions import db, from_db
from seamap_rt.errors import InputError
from seamap_rt.io.patternfile import read_pattern
from seamap_rt.radar.antenna import Antenna, antenna, antenna_of, directivity
from seamap_rt.settings import AntennaSettings, RadarSettings

Level = Callable[[np.ndarray], np.ndarray]  # deg → dB
CIRCLE = np.arange(0.0, 360.0)


def gaussian(beamwidth_deg: float, peak_deg: float = 0.0, floor_db: float = -60.0) -> Level:
    def level(angle_deg: np.ndarray) -> np.ndarray:
        off = (angle_deg - peak_deg + 180.0) % 360.0 - 180.0
        return np.maximum(40.0 * np.log10(0.5) * (off / beamwidth_deg) ** 2, floor_db)

    return level


def csv(azimuth: Level, elevation: Level, step: float = 0.1, reach: float = 90.0, offset_db: float = 0.0) -> str:
    count = round(180.0 / step) + 1
    lines = ["cut,angle_deg,gain_db"]
    for name, level, most in (("azimuth", azimuth, reach), ("elevation", elevation, 90.0)):
        angle = np.linspace(-90.0, 90.0, count)
        angle = angle[np.abs(angle) <= most + 1e-9]
        lines += [f"{name},{a:.10g},{g + offset_db:.10g}" for a, g in zip(angle, level(angle), strict=True)]
    return "\n".join(lines) + "\n"


def msi(horizontal: Level, vertical: Level, gain: str = "GAIN 30.0 dBi\n") -> str:
    """Angles as the format counts them; levels are given in its angles too."""
    lines = [f"NAME made for a test\nFREQUENCY 9410\n{gain}COMMENT none"]
    for name, level in (("HORIZONTAL", horizontal), ("VERTICAL", vertical)):
        lines += [f"{name} 360", *(f"{a:.0f} {-g:.6f}" for a, g in zip(CIRCLE, level(CIRCLE), strict=True))]
    return "\n".join(lines) + "\n"


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_bytes(text.encode())
    return path


def of_file(path: Path, **keys: float) -> Antenna:
    return antenna_of(AntennaSettings(pattern="file", file=str(path), **keys), 10e9, 0.0)  # type: ignore[arg-type]


COSINES = np.sin(np.radians(np.linspace(-60.0, 60.0, 4001)))
GOOD_CSV = csv(gaussian(2.0), gaussian(20.0), step=0.5)
GOOD_MSI = msi(gaussian(5.0), gaussian(20.0))


# -------------------------------------------------------------------------------------------------- what comes back


def test_a_sampled_known_pattern_comes_back(tmp_path: Path) -> None:
    known = antenna(RadarSettings())
    levels = [
        lambda angle, cut=cut: db(cut(np.sin(np.radians(angle))) ** 2 + 1e-30)
        for cut in (known.azimuth, known.elevation)
    ]
    found = of_file(write(tmp_path, "taylor.csv", csv(*levels, step=0.08)))  # type: ignore[arg-type]
    # 22 points a beam, none at half power; measured 2e-5, 5e-10, 1e-4 dB and 4e-5
    assert found.azimuth_beamwidth_deg == pytest.approx(1.8, rel=1e-4)
    assert found.elevation_beamwidth_deg == pytest.approx(18.0, rel=1e-8)
    assert db(found.gain / known.gain) == pytest.approx(0.0, abs=1e-3)
    inside = np.sin(np.radians(np.linspace(-1.5, 1.5, 1001)))
    np.testing.assert_allclose(found.azimuth(inside), known.azimuth(inside), atol=1e-4)
    # Beyond, the sign is lost: decibels have none. Nulls are filled between points, to 8e-3 and 7e-4.
    np.testing.assert_allclose(found.azimuth(COSINES), np.abs(known.azimuth(COSINES)), atol=1.2e-2)
    np.testing.assert_allclose(found.elevation(COSINES), np.abs(known.elevation(COSINES)), atol=2e-3)


@pytest.mark.parametrize("step", [0.1, 0.25, 0.5])
def test_beam_widths_of_sampled_beams_within_half_a_percent(tmp_path: Path, step: float) -> None:
    for azimuth, elevation in ((1.8, 18.0), (3.0, 25.0)):
        found = of_file(write(tmp_path, f"{azimuth}.csv", csv(gaussian(azimuth), gaussian(elevation), step=step)))
        # Akima's spline is exact on a parabola; ten digits are written
        assert found.azimuth_beamwidth_deg == pytest.approx(azimuth, rel=1e-8)
        assert found.elevation_beamwidth_deg == pytest.approx(elevation, rel=1e-8)


def test_a_peak_between_points_is_1_and_stays_where_it_is(tmp_path: Path) -> None:
    text = csv(gaussian(2.0, peak_deg=1.27), gaussian(20.0, peak_deg=-6.21), step=0.5)
    found = read_pattern(write(tmp_path, "beside.csv", text))
    for cut, peak in ((found.azimuth, 1.27), (found.elevation, -6.21)):
        near = np.linspace(peak - 1.0, peak + 1.0, 2001)
        voltage = cut(np.sin(np.radians(near)))
        assert near[np.argmax(voltage)] == pytest.approx(peak, abs=0.0011)  # the angles' spacing
        assert voltage.max() == pytest.approx(1.0, abs=1e-6)
        assert voltage.max() <= 1.0 + 1e-15


def test_absolute_levels_mean_the_same_pattern_and_tell_a_gain(tmp_path: Path) -> None:
    relative = write(tmp_path, "relative.csv", GOOD_CSV)
    absolute = write(tmp_path, "absolute.csv", csv(gaussian(2.0), gaussian(20.0), step=0.5, offset_db=29.5))
    assert read_pattern(relative).gain_dbi is None
    assert read_pattern(absolute).gain_dbi == pytest.approx(29.5)
    np.testing.assert_allclose(
        read_pattern(absolute).azimuth(COSINES), read_pattern(relative).azimuth(COSINES), rtol=1e-8
    )
    # Neither is the gain that counts: that is the directivity less ohmic loss, 16 ln 2/(θa θe) but for the cuts' floor
    # at −60 dB, which takes 1e-6 · 180°/(1.064 · 2°) = 8.5e-5 of the power.
    closed = 16.0 * np.log(2.0) / np.radians(2.0) / np.radians(20.0)
    assert of_file(absolute).gain == pytest.approx(closed, rel=1e-4)
    assert of_file(absolute, ohmic_loss_db=1.0).gain == pytest.approx(closed * float(from_db(-1.0)), rel=1e-4)
    assert of_file(absolute, gain_dbi=27.0).gain == pytest.approx(float(from_db(27.0)))


def test_nothing_beyond_the_ends_of_an_azimuth_cut(tmp_path: Path) -> None:
    found = read_pattern(write(tmp_path, "short.csv", csv(gaussian(2.0), gaussian(20.0), step=0.5, reach=6.0)))
    voltage = found.azimuth(np.sin(np.radians([-6.1, -5.9, 5.9, 6.1, 90.0])))
    assert np.all(voltage[[0, 3, 4]] == 0.0)
    assert np.all(voltage[[1, 2]] > 1e-6)


def test_a_short_null_does_not_swing_its_neighbours(tmp_path: Path) -> None:
    def notched(angle: np.ndarray) -> np.ndarray:
        return np.where(np.abs(np.abs(angle) - 20.0) < 0.1, -90.0, np.maximum(gaussian(4.0)(angle), -30.0))

    found = read_pattern(write(tmp_path, "notch.csv", csv(notched, gaussian(20.0), step=0.5)))
    away = np.concatenate((np.linspace(15.0, 19.5, 91), np.linspace(20.5, 25.0, 91)))
    np.testing.assert_allclose(db(found.azimuth(np.sin(np.radians(away))) ** 2), -30.0, atol=1e-6)


# ---------------------------------------------------------------------------------------------------- MSI's conventions


@pytest.mark.parametrize("ending", ["msi", "pln", "ant", "MSI"])
def test_msi_counts_clockwise_and_down(tmp_path: Path, ending: str) -> None:
    # A beam 2° clockwise and 6° down: MSI's 2 and 6, our +2 and −6.
    path = write(tmp_path, f"tilted.{ending}", msi(gaussian(5.0, peak_deg=2.0), gaussian(20.0, peak_deg=6.0)))
    found = read_pattern(path)
    angle = np.linspace(-20.0, 20.0, 4001)
    assert angle[np.argmax(found.azimuth(np.sin(np.radians(angle))))] == pytest.approx(2.0, abs=0.011)
    assert angle[np.argmax(found.elevation(np.sin(np.radians(angle))))] == pytest.approx(-6.0, abs=0.011)
    assert found.frequency_hz == 9.41e9
    measured = of_file(path)
    assert measured.azimuth_beamwidth_deg == pytest.approx(5.0, rel=1e-5)  # six digits are written
    assert measured.elevation_beamwidth_deg == pytest.approx(20.0, rel=1e-5)
    assert measured.gain == pytest.approx(directivity(found.azimuth, found.elevation))


@pytest.mark.parametrize(
    ("line", "gain"),
    [
        ("GAIN 17.5 dBi\n", 17.5),
        ("gain\t17.5dBd\n", 19.65),
        ("Gain 17,5 DBD\n", 19.65),
        ("GAIN 17.5\n", 19.65),  # dBd where it says nothing
        ("GAIN\n", None),
        ("", None),
    ],
)
def test_msi_gain_in_either_unit(tmp_path: Path, line: str, gain: float | None) -> None:
    found = read_pattern(write(tmp_path, "gain.msi", msi(gaussian(5.0), gaussian(20.0), line)))
    assert found.gain_dbi == (gain if gain is None else pytest.approx(gain))


@pytest.mark.parametrize(
    "change",
    [
        str.lower,
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace(" ", "\t"),
        lambda text: "# a comment\n\n" + text.replace("VERTICAL", "\n! another\nVERTICAL"),
        lambda text: text.replace("NAME made for a test\n", "742 211 of some maker\n"),
        lambda text: text.replace("FREQUENCY 9410\n", "FREQUENCY 9300-9500\n").replace("COMMENT none\n", ""),
        lambda text: text.replace("HORIZONTAL 360", "HORIZONTAL").replace("VERTICAL 360", "VERTICAL"),
        lambda text: text.replace(".", ","),
        lambda text: re.sub(r"(?m)^(\d+) ", r"\1 -", text),  # levels instead of attenuations
        lambda text: "\ufeff" + text + "\n\nTILT 0\n",
    ],
)
def test_makers_habits_change_nothing(tmp_path: Path, change: Callable[[str], str]) -> None:
    plain = read_pattern(write(tmp_path, "plain.msi", GOOD_MSI))
    other = read_pattern(write(tmp_path, "other.msi", change(GOOD_MSI)))
    near = np.sin(np.radians(np.linspace(-5.0, 5.0, 101)))
    np.testing.assert_array_equal(plain.azimuth(near), other.azimuth(near))
    np.testing.assert_array_equal(plain.elevation(near), other.elevation(near))


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n").upper(),
        lambda text: "\ufeff# a comment\n\n" + text.replace(",", " ,\t"),
        lambda text: text.replace("gain_db", "gain_db,phase_deg").replace("\n", ",0\n").replace("deg,0", "deg"),
    ],
)
def test_csv_as_people_write_it(tmp_path: Path, change: Callable[[str], str]) -> None:
    plain = read_pattern(write(tmp_path, "plain.csv", GOOD_CSV))
    other = read_pattern(write(tmp_path, "other.csv", change(GOOD_CSV)))
    np.testing.assert_array_equal(plain.azimuth(COSINES), other.azimuth(COSINES))


def test_a_circle_may_start_anywhere(tmp_path: Path) -> None:
    def whole(first: int, last: int) -> str:
        angle = np.arange(first, last + 1.0)
        rows = [
            f"{name},{a:g},{g:.8f}"
            for name, level in (("azimuth", gaussian(5.0, 1.0)), ("elevation", gaussian(20.0, -3.0)))
            for a, g in zip(angle, level(angle), strict=True)
        ]
        return "\n".join(["cut,angle_deg,gain_db", *rows])

    plain = read_pattern(write(tmp_path, "plain.csv", whole(-180, 180)))
    for name, text in (("turn.csv", whole(0, 360)), ("ahead.csv", whole(-90, 90)), ("odd.csv", whole(-120, 239))):
        other = read_pattern(write(tmp_path, name, text))
        np.testing.assert_array_equal(other.azimuth(COSINES), plain.azimuth(COSINES))
        np.testing.assert_array_equal(other.elevation(COSINES), plain.elevation(COSINES))


def test_a_file_is_read_again_when_it_has_changed(tmp_path: Path) -> None:
    path = write(tmp_path, "changing.csv", GOOD_CSV)
    first = of_file(path)
    assert of_file(path).azimuth is first.azimuth
    path.write_text(csv(gaussian(3.0), gaussian(20.0), step=0.5))
    os.utime(path, ns=(1, 1))
    assert of_file(path).azimuth_beamwidth_deg == pytest.approx(3.0)


# ------------------------------------------------------------------------------------------------------------- refusals


def lines_but(text: str, number: int, new: str) -> str:
    lines = text.splitlines()
    lines[number - 1] = new
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.csv", "", "line 1: header = : must be cut,angle_deg,gain_db"),
        ("a.csv", GOOD_CSV.split("elevation")[0], "line 362: elevation cut: is missing"),
        ("a.csv", GOOD_CSV.replace("gain_db", "level"), "line 1: header = cut,angle_deg,level: must be"),
        ("a.csv", lines_but(GOOD_CSV, 5, "azimuth,-88.5"), "line 5: 2 values: must be 3"),
        ("a.csv", lines_but(GOOD_CSV, 5, "sideways,-88.5,-60"), "line 5: cut = sideways: must be azimuth or elevation"),
        ("a.csv", lines_but(GOOD_CSV, 5, "azimuth,-88.5,nan"), "line 5: gain_db = 'nan': must be a finite number"),
        ("a.csv", lines_but(GOOD_CSV, 5, "azimuth,-88.5,-inf"), "line 5: gain_db = '-inf': must be a finite number"),
        ("a.csv", lines_but(GOOD_CSV, 5, "azimuth,x,-60"), "line 5: angle_deg = 'x': must be a finite number"),
        (
            "a.csv",
            lines_but(GOOD_CSV, 5, "azimuth,-89,-60"),
            "line 5: azimuth cut: angle = -89: must be above the last",
        ),
        ("a.csv", lines_but(GOOD_CSV, 2, "azimuth,-181,-60"), "line 2: azimuth cut: angle = -181: must be within −180"),
        (
            "a.csv",
            GOOD_CSV + "elevation,300,-60\n",
            "line 724: elevation cut: angle = 300: must be within 360 of the fir",
        ),
        (
            "a.csv",
            "cut,angle_deg,gain_db\n" + "".join(f"azimuth,{a},0\n" for a in range(7)),
            "line 8: azimuth cut: 7 points: must be at least 8",
        ),
        (
            "a.csv",
            lines_but(GOOD_CSV, 1, "cut,angle_deg,gain_db,phase_deg").replace("-60\n", "-60,12\n"),
            "line 2: phase_deg = 12: must be 0",
        ),
        (
            "a.csv",
            csv(gaussian(2.0), gaussian(20.0), step=0.5, reach=5.5),
            "line 2: azimuth cut: ends at -5.5°: must reach -6°, 3 of its beam widths",
        ),
        (
            "a.csv",
            "\n".join(GOOD_CSV.splitlines()[:-3]),
            "line 720: elevation cut: ends at 88.5°: must reach 90°; measure",
        ),
        (
            "a.csv",
            csv(gaussian(2.0, peak_deg=5.0), gaussian(20.0), step=0.5),
            "line 192: azimuth cut: its peak, at 5°: must be within 2 beam widths (2° each) of boresight",
        ),
        ("a.msi", "NAME nothing\nGAIN 3 dBi\n", "line 2: azimuth cut: is missing"),
        ("a.msi", GOOD_MSI.split("VERTICAL")[0], "line 365: elevation cut: is missing"),
        ("a.msi", lines_but(GOOD_MSI, 9, "nan 3"), "line 9: angle = 'nan': must be a finite number"),
        ("a.msi", lines_but(GOOD_MSI, 9, "3 0.1 0.2"), "line 9: 3 values: must be 2"),
        ("a.msi", lines_but(GOOD_MSI, 9, ""), "line 5: azimuth cut: must have the 360 points announced, not 359"),
        (
            "a.msi",
            msi(gaussian(5.0), gaussian(20.0), "GAIN much\n"),
            "line 3: GAIN much: must be GAIN, a number and dBi",
        ),
        (
            "a.msi",
            msi(gaussian(5.0, 180.0), gaussian(20.0)),
            "line 186: azimuth cut: its peak, at 180°: must be ahead, within ±90",
        ),
        (
            "a.msi",
            msi(gaussian(5.0), gaussian(20.0, 90.0 + 30.0)),
            "line 487: elevation cut: its peak, at -120°: must be ahead, within ±90",
        ),
    ],
)
def test_refusals_name_file_and_line(tmp_path: Path, name: str, text: str, message: str) -> None:
    path = write(tmp_path, name, text)
    with pytest.raises(InputError) as refusal:
        read_pattern(path)
    assert str(refusal.value).startswith(f"file '{path}', {message}")
    assert "\n" not in str(refusal.value)
    with pytest.raises(InputError):
        of_file(path)


def test_refusals_of_a_file_as_a_whole(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"^file '.*a\.txt': is no antenna pattern: must be CSV with the header cut,.*$"
    ):
        read_pattern(write(tmp_path, "a.txt", "NAME an antenna\nGAIN 20 dBi\n"))
    with pytest.raises(InputError, match=r"^file '.*none\.csv': no such file; .*$"):
        of_file(tmp_path / "none.csv")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(InputError, match=r"^file '.*folder\.csv': is a folder, not a file; .*$"):
        read_pattern(tmp_path / "folder.csv")


@pytest.mark.parametrize("ending", ["csv", "msi", "pln", "ant", "txt", "dat", "MSI.TXT"])
@pytest.mark.parametrize("text", [GOOD_CSV, GOOD_MSI])
def test_a_pattern_is_known_by_its_content_whatever_its_ending(text: str, ending: str, tmp_path: Path) -> None:
    found = read_pattern(write(tmp_path, f"a.{ending}", text))
    right = read_pattern(write(tmp_path, "csv.csv" if text is GOOD_CSV else "msi.msi", text))
    for name in ("azimuth", "elevation"):
        np.testing.assert_array_equal(getattr(found, name)(COSINES), getattr(right, name)(COSINES))
    assert (found.gain_dbi, found.frequency_hz) == (right.gain_dbi, right.frequency_hz)
