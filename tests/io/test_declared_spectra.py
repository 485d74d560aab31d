"""A spectrum file means what it declares: whatever units and directions it has, the sea is the same, or the file is
refused by the words that it declares."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from declared_sea import DIRECTION, FREQUENCY, HS, assert_the_sea, true_density
from numpy.typing import NDArray

from seamap_rt.errors import InputError
from seamap_rt.io.spectrum_layouts import density_unit
from seamap_rt.io.spectrumfile import read_directional_spectrum
from seamap_rt.io.text import parse_number

ENERGY = {"m2": 1.0, "m^{2}": 1.0, "cm2": 1e4, "J m-2": 1025.0 * 9.81}
FREQUENCIES = {None: 1.0, "Hz": 1.0, "s-1": 1.0, "rad/s": 2.0 * np.pi, "rad s-1": 2.0 * np.pi}
ANGLES = {"degree": 1.0, "degrees_true": 1.0, "radian": np.pi / 180.0, "rad": np.pi / 180.0}
SENSES: list[tuple[dict[str, str], float]] = [
    ({}, 0.0),
    ({"standard_name": "sea_surface_wave_from_direction"}, 0.0),
    ({"standard_name": "sea_surface_wave_to_direction"}, 180.0),
    ({"long_name": "direction towards which waves travel, clockwise from north"}, 180.0),
    ({"comment": "nautical convention: coming from"}, 0.0),
    ({"convention": "oceanographic"}, 180.0),
]


@pytest.mark.parametrize(
    ("number", "frequency", "angle", "energy"),
    [(number, *each) for number, each in enumerate(product(FREQUENCIES, ANGLES, ENERGY))],
)
def test_what_is_declared_is_obeyed(
    number: int, frequency: str | None, angle: str, energy: str, tmp_path: Path
) -> None:
    attributes, turn = SENSES[(number + number // len(SENSES)) % len(SENSES)]  # each sense meets each unit
    per_angle = "rad" if angle.startswith("rad") else "degree"
    per_frequency = "(rad/s)" if frequency is not None and "rad" in frequency else "Hz"
    values = true_density() * ENERGY[energy] / ANGLES[angle] / FREQUENCIES[frequency]
    data = xr.Dataset(
        {"efth": (("freq", "dir"), values, {"units": f"{energy}/{per_frequency}/{per_angle}"})},
        {
            "freq": ("freq", FREQUENCY * FREQUENCIES[frequency], {} if frequency is None else {"units": frequency}),
            "dir": ("dir", (DIRECTION + turn) % 360.0 * ANGLES[angle], {"units": angle, **attributes}),
        },
    )
    data.to_netcdf(tmp_path / "sea.nc", engine="h5netcdf")
    assert_the_sea(read_directional_spectrum(tmp_path / "sea.nc"))


def written(path: Path, *, density: dict[str, Any], direction: dict[str, Any], frequency: dict[str, Any]) -> Path:
    data = xr.Dataset(
        {"efth": (("freq", "dir"), true_density(), density)},
        {"freq": ("freq", FREQUENCY, frequency), "dir": ("dir", DIRECTION, direction)},
    )
    data.to_netcdf(path, engine="h5netcdf")
    return path


@pytest.mark.parametrize(
    ("density", "direction", "frequency", "named"),
    [
        ({"units": "m2/Hz"}, {}, {}, "m2/Hz"),
        ({"units": "dB"}, {}, {}, "dB"),
        ({"units": "m2 s2 degree-2"}, {}, {}, "degree-2"),
        ({"units": "m2 s rad-1"}, {}, {"units": "rad/s"}, "rad/s"),
        ({}, {}, {"units": "rad/s"}, "rad/s"),
        ({}, {}, {"units": "s"}, "'s'"),
        ({}, {"units": "gon"}, {}, "gon"),
        ({}, {"long_name": "from which waves come, toward the buoy"}, {}, "both"),
        ({"long_name": "wave action density"}, {}, {}, "no unit"),
        ({}, {"units": "degrees magnetic"}, {}, "magnetic"),
        ({}, {"long_name": "direction from magnetic north"}, {}, "magnetic north"),
        ({}, {}, {"long_name": "angular frequency"}, "angular frequency"),
        ({}, {}, {"standard_name": "wave_period"}, "wave_period"),
        ({"units": "log10(m2/Hz/degree)"}, {}, {}, "log10"),
        ({"units": "m2/Hz/degree ?"}, {}, {}, "degree ?"),
    ],
)
def test_what_cannot_be_obeyed_is_refused_by_its_words(
    density: dict[str, Any], direction: dict[str, Any], frequency: dict[str, Any], named: str, tmp_path: Path
) -> None:
    path = written(tmp_path / "sea.nc", density=density, direction=direction, frequency=frequency)
    with pytest.raises(InputError, match=r"sea\.nc") as refused:
        read_directional_spectrum(path)
    assert named in str(refused.value)
    assert len(refused.value.problems) == 1


CLOCKWISE, TOWARDS = DIRECTION, (DIRECTION + 180.0) % 360.0
WORDS: dict[str, tuple[dict[str, dict[str, Any]], NDArray[np.float64]]] = {  # attributes, and directions so described
    "unit, from north": ({"dir": {"units": "degrees clockwise from true north"}}, CLOCKWISE),
    "unit, anticlockwise": ({"dir": {"units": "degrees counterclockwise from east"}}, (270.0 - DIRECTION) % 360.0),
    "unit, T": ({"dir": {"units": "degT"}}, CLOCKWISE),
    "positive": ({"dir": {"positive": "counterclockwise", "long_name": "going to"}}, (270.0 - DIRECTION) % 360.0),
    "anticlockwise from north": (
        {"dir": {"comment": "waves come from it, anticlockwise from north"}}, (360.0 - DIRECTION) % 360.0),
    "clockwise from east": ({"dir": {"comment": "coming from, clockwise from east"}}, (DIRECTION - 90.0) % 360.0),
    "density": ({"efth": {"long_name": "spectrum, directions waves travel to"}}, TOWARDS),
    "file": ({"": {"direction_convention": "going to"}}, TOWARDS),
    "file, of wind": ({"": {"comment": "wind direction: going to; winds and currents"}}, CLOCKWISE),
    "file, though the axis says": (
        {"": {"convention": "going to"}, "dir": {"standard_name": "sea_surface_wave_from_direction"}}, CLOCKWISE),
}  # fmt: skip


@pytest.mark.parametrize("name", WORDS)
def test_directions_are_as_words_describe_them(name: str, tmp_path: Path) -> None:
    told, directions = WORDS[name]
    data = xr.Dataset(
        {"efth": (("freq", "dir"), true_density(), told.get("efth", {}))},
        {"freq": FREQUENCY, "dir": ("dir", directions, told.get("dir", {}))},
        told.get("", {}),
    )
    data.to_netcdf(tmp_path / "sea.nc", engine="h5netcdf")
    assert_the_sea(read_directional_spectrum(tmp_path / "sea.nc"))


@pytest.mark.parametrize("name", ["valid_max", "valid_range", "packed valid_range", "valid_min"])
def test_what_lies_beyond_its_valid_range_is_missing(name: str, tmp_path: Path) -> None:
    values, top = true_density(), true_density().max()
    values[3, 4] = -2.0 * top if name == "valid_min" else 30.0 * top
    scale = top / 1000.0
    told: dict[str, Any] = {"valid_min": 0.0} if name == "valid_min" else {name: [0.0, 2.0 * top][-1:]}
    if name.endswith("valid_range"):
        told = {"valid_range": [0.0, 2.0 * top]}
    if name.startswith("packed"):
        values = np.rint(values / scale).astype(np.int32)
        told = {"valid_range": np.array([0, 2000], dtype=np.int32), "scale_factor": scale}
    data = xr.Dataset({"efth": (("freq", "dir"), values, told)}, {"freq": FREQUENCY, "dir": DIRECTION})
    data.to_netcdf(tmp_path / "sea.nc", engine="h5netcdf")
    assert_the_sea(read_directional_spectrum(tmp_path / "sea.nc"), 5e-3)


@pytest.mark.parametrize(
    ("name", "attributes", "value", "right"),
    [
        ("hs", {"units": "cm"}, 100.0 * HS, True),
        ("height", {"standard_name": "sea_surface_wave_significant_height"}, HS, True),
        ("height", {"standard_name": "sea_surface_wave_significant_height"}, 2.0 * HS, False),
        ("wave_height", {"standard_name": "sea_surface_wave_maximum_height"}, 2.0 * HS, True),
        ("hs", {"units": "ft"}, HS, False),
    ],
)
def test_a_stated_height_is_one_by_its_words(
    name: str, attributes: dict[str, str], value: float, right: bool, tmp_path: Path
) -> None:
    path = written(tmp_path / "sea.nc", density={}, direction={}, frequency={})
    with xr.open_dataset(path) as data:
        data.assign({name: ((), value, attributes)}).to_netcdf(tmp_path / "both.nc", engine="h5netcdf")
    if right:
        assert_the_sea(read_directional_spectrum(tmp_path / "both.nc"))
    else:
        with pytest.raises(InputError, match="and it states a height"):
            read_directional_spectrum(tmp_path / "both.nc")


def test_radians_that_nobody_declares_are_asked_for(tmp_path: Path) -> None:
    data = xr.Dataset({"efth": (("freq", "dir"), true_density())}, {"freq": FREQUENCY, "dir": np.radians(DIRECTION)})
    data.to_netcdf(tmp_path / "sea.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="declare degree or radian"):
        read_directional_spectrum(tmp_path / "sea.nc")


def test_an_action_density_is_times_its_frequency(tmp_path: Path) -> None:
    """E = 2πf N."""
    values = true_density() / (2.0 * np.pi * FREQUENCY[:, None])
    data = xr.Dataset(
        {"efth": (("freq", "dir"), values, {"units": "m2 s/Hz/degree", "long_name": "action density"})},
        {"freq": FREQUENCY, "dir": DIRECTION},
    )
    data.to_netcdf(tmp_path / "sea.nc", engine="h5netcdf")
    assert_the_sea(read_directional_spectrum(tmp_path / "sea.nc"))


@pytest.mark.parametrize("stated", [HS, 1.04 * HS, 1.2 * HS, np.pi * HS])
def test_a_height_that_the_file_states_is_held_to_its_spectrum(stated: float, tmp_path: Path) -> None:
    path = written(tmp_path / "sea.nc", density={}, direction={}, frequency={})
    with xr.open_dataset(path) as data:
        data.assign(hs=stated).to_netcdf(tmp_path / "both.nc", engine="h5netcdf")
    if stated < 1.05 * HS:
        assert_the_sea(read_directional_spectrum(tmp_path / "both.nc"))
    else:
        with pytest.raises(InputError, match=r"make waves of 1\.7 m, and it states a height"):
            read_directional_spectrum(tmp_path / "both.nc")


SWAN_UNITS = {
    ("VaDens", "m2/Hz/degr"): 1.0,
    ("VaDens", "m2/Hz/rad"): 180.0 / np.pi,
    ("EnDens", "J/m2/Hz/degr"): 1025.0 * 9.81,
    ("EnDens", "J/m2/Hz/rad"): 1025.0 * 9.81 * 180.0 / np.pi,
}


@pytest.mark.parametrize("encoding", ["ascii", "utf-8-sig", "cp1252"])
@pytest.mark.parametrize(("quantity", "unit"), SWAN_UNITS)
@pytest.mark.parametrize("directions", ["NDIR", "CDIR"])
def test_swans_words_are_obeyed(quantity: str, unit: str, directions: str, encoding: str, tmp_path: Path) -> None:
    angles = DIRECTION if directions == "NDIR" else 270.0 - DIRECTION  # Cartesian: towards, anticlockwise from east
    values = np.rint(1e8 * true_density() / true_density().max()).astype(int)
    factor = true_density().max() / 1e8 * SWAN_UNITS[quantity, unit]
    remark = "$  Höhe bei Süd" if encoding != "ascii" else "$  a sea"
    lines = ["SWAN   1        Swan standard spectral file", remark, "LOCATIONS", "1", "0.0 0.0", "AFREQ"]
    lines += [str(FREQUENCY.size), *(f"{each:.6f}" for each in FREQUENCY), directions, str(angles.size)]
    lines += [*(f"{each:.2f}" for each in angles), "QUANT", "1", f"{quantity}   density", f"{unit}   unit"]
    lines += ["-0.9900E+02    exception value", "FACTOR", f"{factor:.12e}"]
    lines += [" ".join(str(each) for each in row) for row in values]
    path = tmp_path / "sea.spc"
    path.write_bytes(("\n".join(lines) + "\n").encode(encoding))
    assert_the_sea(read_directional_spectrum(path))


def test_text_in_sixteen_bits_is_said(tmp_path: Path) -> None:
    path = tmp_path / "sea.spc"
    path.write_bytes("SWAN   1\n".encode("utf-16"))
    with pytest.raises(InputError, match="UTF-16; save it as UTF-8"):
        read_directional_spectrum(path)


def test_no_date_is_nearest_to_nothing(tmp_path: Path) -> None:
    times = np.array(["NaT", "2024-05-01T12:00", "2024-05-01T15:00"], dtype="datetime64[ns]")
    values = np.stack([0.1 * true_density(), true_density(), 4.0 * true_density()])
    data = xr.Dataset({"efth": (("time", "freq", "dir"), values)}, {"time": times, "freq": FREQUENCY, "dir": DIRECTION})
    data.to_netcdf(tmp_path / "sea.nc", engine="h5netcdf")
    for wanted in (None, "2024-05-01T12:40"):
        assert_the_sea(read_directional_spectrum(tmp_path / "sea.nc", time=wanted))


@pytest.mark.parametrize("unit", ["m2/Hz/deg", "m**2 s radian**-1", "m^{2}.s.degree^{-1}", "m2 s rad-1", "m2/(Hz deg)"])
def test_units_of_densities_are_known_however_they_are_written(unit: str) -> None:
    assert density_unit(unit, "x").factor == pytest.approx(np.pi / 180.0 if "rad" in unit else 1.0)


@pytest.mark.parametrize("text", ["1_0", "１０", "1_0.5e3", "٣"])
def test_a_number_is_what_other_programs_take_for_one(text: str) -> None:
    with pytest.raises(ValueError, match="is not a number"):
        parse_number(text)
