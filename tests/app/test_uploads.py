"""Uploads: any bytes under any name are a file of their kind or one clear line, and lie where they should."""

from __future__ import annotations

import contextlib
import io
import json
import random
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io
import trimesh
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from seamap_rt.app.draft import Draft, list_sections, parts_of
from seamap_rt.app.folders import Roots
from seamap_rt.app.uploads import KINDS, check, kind_of_field, list_uploads, save_upload
from seamap_rt.errors import InputError
from seamap_rt.io.scenefile import list_shipped

_SPECTRA = Path(__file__).parents[1] / "io" / "spectra"
_SHIPPED = next(iter(list_shipped().values())).parent
_HEADER = """frequency_hz = 10e9
pulse_width_s = 20e-9
bandwidth_hz = 50e6
height_m = 5.0
baseline_m = 0.2
azimuth_beamwidth_deg = 1.8
elevation_beamwidth_deg = 18.0
first_gate_m = 15.0
gate_m = 1.5
"""
_ARRAYS = {
    "lower": np.ones((4, 6), np.complex64), "upper": np.ones((4, 6), np.complex64),
    "time": np.arange(4) * 1e-3, "azimuth": np.arange(4.0),
}  # fmt: skip


def _npz() -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, **_ARRAYS)  # type: ignore[arg-type]
    return file.getvalue()


def _mat() -> bytes:
    file = io.BytesIO()
    scipy.io.savemat(file, _ARRAYS)
    return file.getvalue()


def _h5() -> bytes:
    file = io.BytesIO()
    with h5py.File(file, "w") as opened:
        for name, values in _ARRAYS.items():
            opened[name] = values
    return file.getvalue()


def _sea() -> bytes:
    """A wave of 1 m that runs east."""
    time, y, x = np.arange(16.0)[:, None, None], np.arange(0.0, 64.0, 2.0)[:, None], np.arange(0.0, 64.0, 2.0)
    height = np.cos(2.0 * np.pi / 64.0 * x - 0.6 * time) + 0.0 * y
    named = {"time": np.arange(16.0), "y": y[:, 0], "x": x}
    return bytes(xr.Dataset({"elevation": (("time", "y", "x"), height)}, named).to_netcdf(engine="h5netcdf"))


def _pattern() -> str:
    rows = [f"azimuth,{angle},{-12 * (angle / 2) ** 2}" for angle in np.arange(-8, 8.1, 0.5)]
    rows += [f"elevation,{angle},{-12 * (angle / 24) ** 2}" for angle in np.arange(-90, 91, 3)]
    return "\n".join(["cut,angle_deg,gain_db", *rows])


def _mesh(kind: str) -> bytes:
    made: Any = trimesh.creation.box().export(file_type=kind)
    return made.encode() if isinstance(made, str) else made


_MOTION = "time_s,roll_deg\n" + "".join(f"{0.1 * i:.1f},{i % 3}\n" for i in range(40))
_VALID: dict[str, tuple[str, bytes]] = {  # in plain bytes; what HDF5 reads is below
    "swan.spc": ("spectrum", (_SPECTRA / "swan.spc").read_bytes()),
    "pattern.csv": ("pattern", _pattern().encode()),
    "boat.csv": ("motion", _MOTION.encode()),
    "buoy.stl": ("mesh", (_SHIPPED / "objects" / "buoy.stl").read_bytes()),
    "box.glb": ("mesh", _mesh("glb")),
    "box.obj": ("mesh", _mesh("obj")),
    "box.ply": ("mesh", _mesh("ply")),
    "night.npz": ("recording", _npz()),
    "night.mat": ("recording", _mat()),
    "header.toml": ("header", _HEADER.encode()),
    "header.json": ("header", json.dumps({"frequency_hz": 1e10}).encode()),
}
_HDF5 = {"ww3.nc": "spectrum", "sea.nc": "sea", "boat.nc": "vessel", "night.h5": "recording", "night.nc": "recording"}


@pytest.fixture
def roots(tmp_path: Path) -> Roots:
    (tmp_path / "runs").mkdir()
    return Roots(tmp_path / "runs", (_SHIPPED,))


def _keep(roots: Roots, kind: str, name: str, content: bytes) -> Path | None:
    """Where it is kept; None where it is refused, in one line."""
    try:
        return save_upload(roots, kind, name, content, check=check)
    except InputError as error:
        refusal = error
    assert "Traceback" not in str(refusal)
    assert all(line and "\n" not in line for line in refusal.problems)
    return None


@pytest.mark.parametrize("name", [name for name in _VALID if name != "header.json"])
def test_what_is_right_is_kept_under_its_name(roots: Roots, name: str) -> None:
    kind, content = _VALID[name]
    path = save_upload(roots, kind, name, content, check=check)
    assert path == roots.uploads / name
    assert path.read_bytes() == content
    assert roots.holds(path)
    assert path in list_uploads(roots, kind)


def test_a_header_that_lacks_keys_is_refused_by_them(roots: Roots) -> None:
    with pytest.raises(InputError, match="pulse_width_s: is missing"):
        save_upload(roots, *(_VALID["header.json"][0], "header.json", _VALID["header.json"][1]), check=check)
    assert list(roots.uploads.iterdir()) == []


_EDITS = st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=6)


@settings(max_examples=150)
@given(st.sampled_from(sorted(set(_VALID) - {"night.mat"})), _EDITS, st.integers(0, 10**6), st.booleans())
def test_a_damaged_file_is_a_file_or_a_line(
    tmp_path_factory: pytest.TempPathFactory, name: str, edits: list[tuple[int, int]], cut: int, short: bool
) -> None:
    kind, content = _VALID[name]
    damaged = bytearray(content[: cut % len(content)] if short else content)
    for place, value in edits if damaged else ():
        damaged[place % len(damaged)] = value
    _one(tmp_path_factory, kind, name, bytes(damaged))


@settings(max_examples=80)
@given(st.sampled_from(sorted(KINDS)), st.binary(max_size=200), st.data())
def test_any_bytes_are_a_file_or_a_line(
    tmp_path_factory: pytest.TempPathFactory, kind: str, content: bytes, data: st.DataObject
) -> None:
    ending = data.draw(st.sampled_from(KINDS[kind].endings))
    _one(tmp_path_factory, kind, f"x{ending}", content)


def _one(factory: pytest.TempPathFactory, kind: str, name: str, content: bytes) -> None:
    folder = factory.mktemp("fuzz")
    roots = Roots(folder / "runs")
    roots.runs.mkdir()
    path = _keep(roots, kind, name, content)
    there = [each for each in folder.rglob("*") if each.is_file()]
    assert there == ([] if path is None else [path])


@given(st.text(max_size=60), st.sampled_from(sorted(KINDS)))
def test_whatever_it_is_called_it_lies_among_the_uploads(
    tmp_path_factory: pytest.TempPathFactory, name: str, kind: str
) -> None:
    roots = Roots(tmp_path_factory.mktemp("names"))
    for given_name in (name, f"../{name}{KINDS[kind].endings[0]}", f"/etc/{name}\\..\\x{KINDS[kind].endings[0]}"):
        with contextlib.suppress(InputError):
            path = save_upload(roots, kind, given_name, b"x", check=lambda *_: None)
            assert path.resolve().parent == roots.uploads.resolve()
            assert path.suffix.lower() in KINDS[kind].endings


_BATCH = """
import sys
import zipfile
from pathlib import Path
from seamap_rt.app.uploads import check
from seamap_rt.errors import InputError
for line in Path(sys.argv[1]).read_text().splitlines():
    kind, path = line.split(" ", 1)
    try:
        check(kind, Path(path))
        print("kept", path)
    except InputError as refusal:
        assert "Traceback" not in str(refusal)
        print("refused", path)
"""


def test_what_a_library_in_c_reads_damaged_is_a_file_or_a_line(tmp_path: Path) -> None:
    """In a process of its own, as the page reads it: a library in C may end it."""
    dice, lines, whole = random.Random(1), [], []
    contents = {
        "ww3.nc": (_SPECTRA / "ww3.nc").read_bytes(),
        "sea.nc": _sea(),
        "boat.nc": _h5(),
        "night.h5": _h5(),
        "night.nc": _h5(),
        "night.mat": _mat(),
    }
    for name, kind in {**_HDF5, "night.mat": "recording"}.items():
        for number in range(12):
            damaged = bytearray(contents[name])
            for _ in range(min(number, 6)):
                damaged[dice.randrange(len(damaged))] = dice.randrange(256)
            if number > 8:
                damaged = damaged[: dice.randrange(len(damaged))]
            path = tmp_path / f"{number}-{name}"
            path.write_bytes(damaged)
            lines.append(f"{kind} {path}")
            if number == 0 and kind != "vessel":
                whole.append(f"kept {path}")
    (tmp_path / "list").write_text("\n".join(lines))
    done = subprocess.run(
        [sys.executable, "-c", _BATCH, str(tmp_path / "list")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    said = done.stdout.splitlines()
    assert len(said) == len(lines)
    assert set(whole) <= set(said)
    assert sum(line.startswith("refused") for line in said) >= 12


def test_what_is_too_large_or_of_another_kind_is_not_even_written(roots: Roots) -> None:
    with pytest.raises(InputError, match=r"must have at most 1"):
        save_upload(roots, "header", "h.toml", b" " * (2**20 + 1), check=check)
    with pytest.raises(InputError, match=r"must end in \.npz"):
        save_upload(roots, "recording", "night.exe", b"x", check=check)
    assert not roots.uploads.exists()


def test_a_file_of_the_same_name_is_never_written_over(roots: Roots) -> None:
    """A run that was queued may read it yet."""
    first = save_upload(roots, "motion", "boat.csv", _MOTION.encode(), check=check)
    other = _MOTION.replace(",1", ",1.5").encode()
    second = save_upload(roots, "motion", "boat.csv", other, check=check)
    assert (first.name, second.name) == ("boat.csv", "boat-2.csv")
    assert first.read_bytes() == _MOTION.encode()
    assert save_upload(roots, "motion", "boat.csv", other, check=check) == second
    assert _keep(roots, "motion", "boat.csv", b"damaged") is None
    assert sorted(each.name for each in roots.uploads.iterdir()) == ["boat-2.csv", "boat.csv"]


def test_the_process_that_checks_has_bounded_memory_and_says_a_line(roots: Roots) -> None:
    """A few hundred bytes whose array is told to have 16 GB: more than that process may take."""
    head, file = io.BytesIO(), io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<c8", "fortran_order": False, "shape": (2_000_000, 1_000)})
    with zipfile.ZipFile(file, "w") as packed:
        packed.writestr("lower.npy", head.getvalue())
    with pytest.raises(InputError, match=r"^night\.npz: declares 16 GB") as refused:
        save_upload(roots, "recording", "night.npz", file.getvalue())
    assert len(refused.value.problems) == 1
    assert list(roots.uploads.iterdir()) == []


def test_every_field_that_names_a_file_can_be_given_one(roots: Roots) -> None:
    draft = Draft.shipped("choppy_sea", roots)
    for each in list_sections():
        for kind in each.kinds or ("",):
            draft.add(each.path, each.tag, kind)
    files = [field.key for part in parts_of(draft.tree) for field in part.fields if field.kind == "file"]
    assert len(files) >= 5
    assert {key: kind_of_field(key) for key in files if kind_of_field(key) is None} == {}
    assert kind_of_field("radar.height_m") is None
