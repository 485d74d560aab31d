"""Text that people write: what is no number for other programs is none here, and other encodings are said."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from test_spectrum_kinds import write_datawell, write_triaxys, write_ww3_station

from seamap_rt import load_scene
from seamap_rt.cli import main
from seamap_rt.errors import InputError
from seamap_rt.io.meshfile import load_mesh
from seamap_rt.io.motionfile import read_motion
from seamap_rt.io.patternfile import read_pattern
from seamap_rt.io.recording_header import read_header
from seamap_rt.io.spectrumfile import read_directional_spectrum
from seamap_rt.io.text import is_underscored
from seamap_rt.products.link import ranges_of
from seamap_rt.report.keys import read_value
from seamap_rt.settings import ObjectSettings

NO_NUMBERS = ("1_0", "1_0.5", "１０", "٣")
ANGLES = np.arange(-90.0, 91.0, 3.0)
MOTION = "time_s,roll_deg\n" + "".join(f"{n / 10},{n}\n" for n in range(20))
PATTERN = "cut,angle_deg,gain_db\n" + "".join(
    f"{cut},{angle:g},{-12.0 * (angle / width) ** 2:.2f}\n"
    for cut, width in (("azimuth", 12.0), ("elevation", 24.0))
    for angle in ANGLES
)
HEADER = "\n".join(
    f"{key} = {value}"
    for key, value in {
        "frequency_hz": 10e9, "pulse_width_s": 20e-9, "bandwidth_hz": 50e6, "height_m": 5.0, "baseline_m": 0.2,
        "azimuth_beamwidth_deg": 1.8, "elevation_beamwidth_deg": 18.0, "first_gate_m": 15.0, "gate_m": 1.5,
    }.items()
)  # fmt: skip
JSON = "{" + ", ".join('"{}": {}'.format(*line.split(" = ")) for line in HEADER.splitlines()) + "}"
OBJ = "v 0 0 0\nv 0 0 3\nv 10 0 0\nv 0 3 0\n" + "".join(f"f {a} {b} {c}\n" for a, b, c in ((1, 2, 3), (1, 3, 4)))


def mesh(path: Path) -> object:
    return load_mesh(ObjectSettings(mesh=str(path), position_m=(0.0, 0.0, 0.0)))


FILES: dict[str, tuple[str, str, Callable[[Path], object]]] = {  # content, a number of it, reader
    "motion.csv": (MOTION, "\n1.0,10\n", read_motion),
    "pattern.csv": (PATTERN, "elevation,0,-0.00", read_pattern),
    "mesh.obj": (OBJ, "v 10 0 0", mesh),
}
TEXTS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "motion.csv": (MOTION, read_motion),
    "pattern.csv": (PATTERN, read_pattern),
    "header.toml": (HEADER, read_header),
    "header.json": (JSON, read_header),
    "scene.toml": ('name = "x"', load_scene),
}


@pytest.mark.parametrize("number", NO_NUMBERS)
@pytest.mark.parametrize("name", FILES)
def test_no_file_has_a_number_that_only_python_knows(name: str, number: str, tmp_path: Path) -> None:
    content, cell, reader = FILES[name]
    assert cell in content
    ours = cell.replace("10", number) if "10" in cell else cell.replace("-0.00", number)
    (tmp_path / name).write_text(content)
    reader(tmp_path / name)
    (tmp_path / name).write_text(content.replace(cell, ours))
    with pytest.raises(InputError) as refused:
        reader(tmp_path / name)
    assert len(refused.value.problems) == 1


@pytest.mark.parametrize("write", [write_ww3_station, write_datawell, write_triaxys])
def test_no_spectrum_has_one_either(write: Callable[[Path], Path], tmp_path: Path) -> None:
    """Whatever library reads it: the last number of the file, which is small, is replaced."""
    path = write(tmp_path)
    content = path.read_text().rstrip()
    cut = max(content.rfind(each) for each in (" ", ","))
    path.write_text(f"{content[: cut + 1]}0_1\n")
    with pytest.raises(InputError, match=r"0_1 is not a number"):
        read_directional_spectrum(path)


@pytest.mark.parametrize("number", NO_NUMBERS)
def test_no_command_takes_one(number: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words in (
        ["run", "flat", "--turns", number, "--out", str(tmp_path / "a")],
        ["run", "flat", "--seed", number, "--out", str(tmp_path / "b")],
        ["outlook", "flat", "--set", f"radar.height_m={number}"],
        ["outlook", "flat", "--vary", f"radar.height_m={number}"],
        ["outlook", "flat", "--vary", f"radar.height_m={number}:20:1"],
        ["link", "flat", "--ranges", f"50,{number}"],
        ["sea", "flat", "--times", f"0:{number}:1", "--out", str(tmp_path / "c")],
        ["trade", "flat", "--vary", "radar.height_m=5,10", "--seeds", number, "--out", str(tmp_path / "d")],
    ):
        with pytest.raises(SystemExit) as ended:
            main(words)
        assert ended.value.code == 2, words
        line = capsys.readouterr().err
        assert line.count("\n") <= 2, line
    assert not list(tmp_path.iterdir())
    assert read_value("radar.height_m", number) == number  # which the scene refuses
    with pytest.raises(InputError):
        ranges_of(f"50,{number}", load_scene("flat"))


def test_names_with_digits_and_underscores_are_no_numbers() -> None:
    for text in ("varianceDensity_0,f_10", "BUOY_1_2 54.0", "[buoy1_0]", "run_1_0.nc", "1_a"):
        assert not is_underscored(text), text
    for text in ("1_0", "[1, 2_0]", "5,-1_0.5", "1e1_0", "0.0 .1_5"):
        assert is_underscored(text), text


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("name", TEXTS)
def test_text_in_sixteen_bits_is_said(name: str, encoding: str, tmp_path: Path) -> None:
    content, reader = TEXTS[name]
    (tmp_path / name).write_bytes(content.encode(encoding))
    with pytest.raises(InputError, match="is text in UTF-16; save it as UTF-8"):
        reader(tmp_path / name)


@pytest.mark.parametrize("name", TEXTS)
def test_a_mark_is_passed_over_and_another_encoding_is_read_or_said(name: str, tmp_path: Path) -> None:
    content, reader = TEXTS[name]
    (tmp_path / name).write_bytes(content.encode("utf-8-sig"))
    reader(tmp_path / name)
    remark = "" if name.endswith("json") else "# Höhe\n"
    (tmp_path / name).write_bytes((remark + content).encode("cp1252") + (b"" if remark else b" \xf6"))
    try:
        reader(tmp_path / name)
    except InputError as refused:
        told = str(refused)
    else:
        told = "Windows-1252"
    assert "Windows-1252" in told


@pytest.mark.parametrize("name", ["motion.csv", "pattern.csv"])
@pytest.mark.parametrize("remark", ["", "# by hand, in May\n"])
def test_semicolons_and_decimal_commas_are_said(name: str, remark: str, tmp_path: Path) -> None:
    content, reader = TEXTS[name]
    (tmp_path / name).write_text(remark + content.replace(",", ";").replace(".", ","))
    with pytest.raises(InputError, match=r"line \d: has ';' between its columns; save it with commas"):
        reader(tmp_path / name)
