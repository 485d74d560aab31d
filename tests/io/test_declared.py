"""What attributes say of numbers is obeyed by every reader of recordings and recorded seas: packed, masked, in another
unit, or with attributes as arrays of one, a file is the plain one."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.errors import InputError
from seamap_rt.interferometry import retrieve
from seamap_rt.interferometry.recorded import echoes_from_recording, open_recording
from seamap_rt.io.recorded_sea import recorded_sea
from seamap_rt.io.recording_header import RecordingHeader, read_header
from seamap_rt.settings import RetrievalSettings

Array = NDArray[Any]
PULSES, GATES, PRF = 200, 16, 400.0
SLIM = RetrievalSettings(estimator="single_cell", cell_range_m=3.0, cell_azimuth_deg=7.2, ground_m=20.0)
HEADER: dict[str, Any] = {
    "frequency_hz": 10e9, "pulse_width_s": 20e-9, "bandwidth_hz": 50e6, "height_m": 5.0, "baseline_m": 0.2,
    "azimuth_beamwidth_deg": 1.8, "elevation_beamwidth_deg": 18.0, "noise_power_w": 0.0,
}  # fmt: skip
STEP = 2.0**-10  # of what is packed: exact in either form
ZERO = np.datetime64("2022-03-04T05:06:07", "ns")


def plain_arrays() -> dict[str, Array]:
    """A recording whose numbers are whole numbers of steps, and therefore exact when packed."""
    random = np.random.default_rng(4)
    voltage = random.integers(-9000, 9000, (2, PULSES, GATES, 2)) * STEP
    moments = np.arange(-0.125, 0.7501, 0.125)
    slow = random.integers(-300, 300, (moments.size, 3)) * STEP
    return {
        "lower": voltage[0],
        "upper": voltage[1],
        "time": np.arange(PULSES) / PRF,
        "azimuth": (np.arange(PULSES) * (360.0 / PULSES) + 0.25) % 360.0,
        "ranges": 30.0 + 1.5 * np.arange(GATES),
        "attitude": slow,
        "attitude_time": moments,
        "position": slow[::-1].copy(),
        "position_time": moments,
    }


PLAIN = plain_arrays()
Attributes = dict[str, dict[str, Any]]


def packed(name: str) -> tuple[dict[str, Array], Attributes]:
    """An array as 16 or 32 bits, with a scale and an offset."""
    offset, scale = (0.0 if name in ("lower", "upper") else 3.0), STEP if name not in ("time", "azimuth") else 1e-6
    wide = np.int16 if name in ("lower", "upper", "attitude", "position") else np.int32
    counts = np.rint((PLAIN[name] - offset) / scale).astype(wide)
    return {name: counts}, {name: {"scale_factor": scale, "add_offset": offset}}


def one_entry(arrays: dict[str, Array], told: Attributes) -> tuple[dict[str, Array], Attributes]:
    return arrays, {name: {key: np.array([value]) for key, value in own.items()} for name, own in told.items()}


def as_hdf5(path: Path, arrays: Mapping[str, Any], told: Attributes) -> None:
    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            file.create_dataset(name, data=values).attrs.update(told.get(name, {}))


def as_records(path: Path, arrays: dict[str, Array], told: Attributes) -> None:
    """Pairs as records of two numbers."""
    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            if name in ("lower", "upper"):
                record = np.empty(values.shape[:-1], [("real", values.dtype), ("imag", values.dtype)])
                record["real"], record["imag"] = values[..., 0], values[..., 1]
                values = record
            file.create_dataset(name, data=values).attrs.update(told.get(name, {}))


def in_netcdf(engine: str) -> Callable[[Path, dict[str, Array], Attributes], None]:
    def write(path: Path, arrays: dict[str, Array], told: Attributes) -> None:
        data = {}
        for name, values in arrays.items():
            values = values.astype(np.int32) if engine == "scipy" and values.dtype == np.int64 else values
            data[name] = ([f"{name}_{axis}" for axis in range(values.ndim)], values, told.get(name, {}))
        xr.Dataset(data).to_netcdf(path, engine=engine)  # type: ignore[call-overload]

    return write


WRITERS = {
    "h5": as_hdf5, "records.h5": as_records, "nc4.nc": in_netcdf("h5netcdf"), "nc3.nc": in_netcdf("scipy"),
}  # fmt: skip


def opened(
    folder: Path, ending: str, arrays: dict[str, Array] | None = None, told: Attributes | None = None
) -> xr.Dataset:
    path = folder / f"night.{ending}"
    path.unlink(missing_ok=True)
    WRITERS[ending](path, PLAIN | (arrays or {}), told or {})
    return open_recording(path, HEADER)


def alike(one: xr.Dataset, other: xr.Dataset) -> None:
    """The same echoes, and the same maps, to rounding."""
    for name in ("voltage", "time", "azimuth", "range", "attitude", "position"):
        np.testing.assert_allclose(one[name].values, other[name].values, rtol=1e-6, atol=1e-6, err_msg=name)
    np.testing.assert_allclose(height_of(one), height_of(other), atol=2e-3)


_HEIGHTS: dict[int, tuple[xr.Dataset, Array]] = {}  # of echoes that are compared with again and again


def height_of(echoes: xr.Dataset) -> Array:
    if id(echoes) not in _HEIGHTS:
        _HEIGHTS[id(echoes)] = echoes, retrieve(echoes, SLIM)["polar"].to_dataset()["height"].values
    return _HEIGHTS[id(echoes)][1]


@pytest.fixture(scope="module")
def right(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    return opened(tmp_path_factory.mktemp("plain"), "h5")


@pytest.mark.parametrize("ending", WRITERS)
def test_every_reader_reads_the_plain_file(ending: str, right: xr.Dataset, tmp_path: Path) -> None:
    alike(opened(tmp_path, ending), right)


@pytest.mark.parametrize("wrapped", [False, True])
@pytest.mark.parametrize("ending", WRITERS)
def test_packed_numbers_are_unpacked(ending: str, wrapped: bool, right: xr.Dataset, tmp_path: Path) -> None:
    """All arrays at once, each by a scale and an offset of its own."""
    arrays: dict[str, Array] = {}
    told: Attributes = {}
    for name in PLAIN:
        of_one = packed(name)
        arrays |= of_one[0]
        told |= of_one[1]
    alike(opened(tmp_path, ending, *(one_entry(arrays, told) if wrapped else (arrays, told))), right)


@pytest.mark.parametrize("attribute", ["_FillValue", "missing_value"])
@pytest.mark.parametrize("scaled", [False, True])
@pytest.mark.parametrize("ending", WRITERS)
def test_missing_numbers_are_missing(ending: str, scaled: bool, attribute: str, tmp_path: Path) -> None:
    """As NaN in the plain file, in each form in which a file says it; each array misses others."""
    gone: dict[str, Any] = {"lower": (slice(7, 9), slice(3, 5)), "upper": (slice(60, 63), slice(1, 4))}
    gone |= {"attitude": 2, "position": 4}
    counts = {name: np.rint(PLAIN[name] / STEP).astype(np.int16) for name in gone}
    numbers = {name: each * (STEP if scaled else 1.0) for name, each in counts.items()}
    for name, where in gone.items():
        numbers[name][where], counts[name][where] = np.nan, -32768
    told = {attribute: np.int16(-32768)} | ({"scale_factor": STEP} if scaled else {})
    found, plain = opened(tmp_path, ending, counts, dict.fromkeys(gone, told)), opened(tmp_path, ending, numbers)
    assert np.isnan(plain["voltage"].values).sum() == 4 + 9
    alike(found, plain)


def test_masked_arrays_and_dates_of_a_program_are_taken_as_a_files(right: xr.Dataset) -> None:
    given = dict(PLAIN)
    sensed: dict[str, Any] = {name: (given.pop(f"{name}_time"), given.pop(name)) for name in ("attitude", "position")}
    lower = np.ma.masked_array(given.pop("lower").copy(), np.zeros((PULSES, GATES, 2), bool))
    lower[3, 5], lower.data[3, 5] = np.ma.masked, 1e20
    plain = PLAIN["lower"].copy()
    plain[3, 5] = np.nan
    readings = np.ma.masked_array(sensed["attitude"][1].copy(), np.zeros(sensed["attitude"][1].shape, bool))
    readings[4], readings.data[4] = np.ma.masked, 77.0
    gaps = sensed["attitude"][1].copy()
    gaps[4] = np.nan
    upper = given.pop("upper")
    masked = echoes_from_recording(
        lower, upper, HEADER, **given, **sensed | {"attitude": (sensed["attitude"][0], readings)}
    )
    holed = echoes_from_recording(plain, upper, HEADER, **given, **sensed | {"attitude": (sensed["attitude"][0], gaps)})
    xr.testing.assert_identical(masked, holed)
    assert np.isnan(holed["voltage"].values).sum() == 1

    def date(seconds: Array) -> Array:
        return ZERO + np.rint(seconds * 1e9).astype("timedelta64[ns]")

    dated = {name: (date(moments), values) for name, (moments, values) in sensed.items()}
    found = echoes_from_recording(PLAIN["lower"], upper, HEADER, **given | {"time": date(given["time"])}, **dated)
    alike(found, right)
    assert found.attrs["time_zero"].startswith("2022-03-04T05:06:0")
    with pytest.raises(InputError, match=r"attitude_time: holds no dates, unlike time; give all on one clock"):
        echoes_from_recording(PLAIN["lower"], upper, HEADER, **given | {"time": date(given["time"])}, **sensed)


UNITS = {  # of an array: units that may be declared, and how many of each one of the plain file's is
    "time": {"ms": 1e3, "µs": 1e6, "us": 1e6, "ns": 1e9, "s": 1.0, "seconds": 1.0, "min": 1.0 / 60.0},
    "ranges": {"km": 1e-3, "cm": 100.0, "mm": 1e3, "m": 1.0, "metres": 1.0},
    "azimuth": {"rad": np.pi / 180.0, "radians": np.pi / 180.0, "degrees": 1.0, "deg": 1.0, "degree": 1.0},
    "attitude": {"rad": np.pi / 180.0, "degrees": 1.0},
    "attitude_time": {"ms": 1e3, "s": 1.0},
    "position": {"cm": 100.0, "km": 1e-3},
    "position_time": {"ns": 1e9, "s": 1.0},
}


@pytest.mark.parametrize(
    ("ending", "wrapped"), [*((ending, False) for ending in WRITERS), ("h5", True), ("records.h5", True)]
)
@pytest.mark.parametrize("number", range(max(map(len, UNITS.values()))))
def test_declared_units_are_converted(
    ending: str, wrapped: bool, number: int, right: xr.Dataset, tmp_path: Path
) -> None:
    """Each array in a unit of its own, until each has had all of its units."""
    units = {name: list(known)[number % len(known)] for name, known in UNITS.items()}
    told: Attributes = {name: {"units": np.array([unit.encode()]) if wrapped else unit} for name, unit in units.items()}
    arrays = {name: PLAIN[name] * UNITS[name][unit] for name, unit in units.items()}
    alike(opened(tmp_path, ending, arrays, told), right)


@pytest.mark.parametrize("name", UNITS)
@pytest.mark.parametrize("ending", WRITERS)
def test_units_of_another_kind_are_refused_by_name(ending: str, name: str, tmp_path: Path) -> None:
    for unit in ("kg", "furlongs per fortnight", "Hz"):
        with pytest.raises(InputError) as refusal:
            opened(tmp_path, ending, told={name: {"units": unit}})
        (line,) = refusal.value.problems
        assert name in line
        assert unit in line


@pytest.mark.parametrize("unit", ["seconds", "milliseconds", "microseconds", "nanoseconds"])
@pytest.mark.parametrize("ending", WRITERS)
def test_times_since_a_date_are_on_one_clock(ending: str, unit: str, right: xr.Dataset, tmp_path: Path) -> None:
    """Each with a date of its own; to the nanosecond of dates, a millionth of the step."""
    count = {"seconds": 1.0, "milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}[unit]
    arrays = {name: PLAIN[name] * count for name in ("time", "attitude_time", "position_time")}
    arrays["attitude_time"] = (PLAIN["attitude_time"] + 60.0) * count
    told = {name: {"units": f"{unit} since 2022-03-04 05:06:07"} for name in arrays}
    told["attitude_time"]["units"] = f"{unit} since 2022-03-04 05:05:07"
    alike(opened(tmp_path, ending, arrays, told), right)


@pytest.mark.parametrize("ending", WRITERS)
@pytest.mark.parametrize(
    ("name", "factor", "words"),
    [
        ("time", 1e3, r"time: pulses are 2\.5 s apart, a PRF of 0\.4 Hz: must be 5 to 1e\+07; give times in seconds"),
        ("time", 1e-6, r"time: pulses are 2\.5e-09 s apart, a PRF of 4e\+08 Hz: must be 5 to 1e\+07"),
        ("ranges", 1e-3, r"ranges: end at 0\.0525 m: must go beyond height_m = 5, .*; give metres"),
        ("ranges", 1e3, r"ranges: gates are 1500 m apart, and resolve 3 m: must be at most 20 times that; give metres"),
        ("azimuth", np.pi / 180.0, r"give degrees, if these are radians"),
    ],
)
def test_numbers_without_units_that_can_be_none_are_refused(
    ending: str, name: str, factor: float, words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        opened(tmp_path, ending, {name: PLAIN[name] * factor})


@pytest.mark.parametrize("attribute", ["scale_factor", "add_offset", "_FillValue", "missing_value"])
@pytest.mark.parametrize("value", ["text", [1.0, 2.0, 3.0]])
def test_attributes_that_cannot_be_obeyed_are_refused_by_name(attribute: str, value: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=rf"ranges: {attribute} = .*: must be a number; correct the attribute"):
        opened(tmp_path, "h5", told={"ranges": {attribute: value}})


def test_a_header_of_attributes_of_one_entry_is_a_header(right: xr.Dataset, tmp_path: Path) -> None:
    """As h5netcdf writes them, with 0 and 1 for true and false; texts too; of either version of NetCDF as JSON."""
    path = tmp_path / "own.h5"
    more = {"conjugate": 0, "polarization": "VV", "sector_deg": [0.25, 360.25], "encoder_clockwise": 1}
    as_hdf5(path, PLAIN, {})
    with h5py.File(path, "a") as file:
        header = file.create_group("header")
        for key, value in (HEADER | more).items():
            header.attrs[key] = np.array([value], dtype=object if isinstance(value, str) else None).ravel()
    alike(open_recording(path), right)
    for engine in ("scipy", "h5netcdf"):
        in_netcdf(engine)(tmp_path / "json.nc", PLAIN, {})
        with xr.open_dataset(tmp_path / "json.nc", engine=engine, decode_cf=False) as data:  # type: ignore[arg-type]
            data.load().assign_attrs(header=json.dumps(HEADER)).to_netcdf(tmp_path / "own.nc", engine=engine)  # type: ignore[call-overload]
        alike(open_recording(tmp_path / "own.nc"), right)


def test_echoes_whose_attributes_are_arrays_of_one_entry_are_retrieved_alike(right: xr.Dataset) -> None:
    wrapped = {name: value if np.ndim(value) else np.array([value]) for name, value in right.attrs.items()}
    alike(right.assign_attrs(wrapped), right)


def test_whole_numbers_at_the_converters_limit_are_still_known_beside_a_fill_value(tmp_path: Path) -> None:
    counts = np.rint(PLAIN["lower"] / STEP).astype(np.int16)
    counts[5, 5], counts[6, 6] = 32767, -32768
    told = {"_FillValue": np.int16(-32768)}
    both = {"lower": counts, "upper": np.rint(PLAIN["upper"] / STEP).astype(np.int16)}
    found = opened(tmp_path, "h5", both, {"lower": told})
    saturated = found["saturated"].values
    assert saturated.sum() == 1
    assert np.isnan(found["voltage"].values).sum() == 1


# ------------------------------------------------------------------------------------------------ recorded seas


def sea(folder: Path, change: Callable[[xr.Dataset], xr.Dataset], kind: str = "h5netcdf") -> tuple[Any, Array]:
    """What a file of a changed sea holds, and a frame of it."""
    axis, times = np.arange(-32.0, 32.0), 0.25 * np.arange(40)
    height = np.rint(np.cos(0.3 * axis - 1.7 * times[:, None])[:, None, :] * np.ones((1, 64, 1)) / STEP) * STEP
    data = xr.Dataset(
        {"elevation": (("time", "y", "x"), height, {"units": "m"})}, {"time": times, "y": axis, "x": axis}
    )
    path = folder / f"sea-{np.random.default_rng().integers(10**9)}.{'zarr' if kind == 'zarr' else 'nc'}"
    changed = change(data)
    if kind == "zarr":
        changed.to_zarr(path, consolidated=False)
    else:
        changed.to_netcdf(path, engine=kind)  # type: ignore[call-overload]
    found = recorded_sea(str(path))
    return found, found.elevation(20)


def packed_sea(data: xr.Dataset) -> xr.Dataset:
    counts = np.rint((data["elevation"].values - 2.0) / STEP).astype(np.int16)
    told = {"units": "m", "scale_factor": STEP, "add_offset": 2.0, "_FillValue": np.int16(-32768)}
    return data.assign(elevation=(("time", "y", "x"), counts, told))


def sea_in(unit: str, of: str, factor: float) -> Callable[[xr.Dataset], xr.Dataset]:
    def change(data: xr.Dataset) -> xr.Dataset:
        there = data[of]
        return data.assign({of: (there.dims, there.values * factor, {"units": unit})})

    return change


SEAS: dict[str, Callable[[xr.Dataset], xr.Dataset]] = {
    "packed": packed_sea,
    "mm": sea_in("mm", "elevation", 1e3),
    "cm": sea_in("cm", "elevation", 100.0),
    "ft": sea_in("ft", "elevation", 1.0 / 0.3048),
    "ms": sea_in("ms", "time", 1e3),
    "ns": sea_in("ns", "time", 1e9),
    "minutes": sea_in("minutes", "time", 1.0 / 60.0),
    "dates": sea_in("seconds since 2020-01-01 12:00", "time", 1.0),
    "x in km": lambda data: sea_in("km", "x", 1e-3)(sea_in("km", "y", 1e-3)(data)),
    "one entry": lambda data: data.assign_attrs(depth_m=np.array([12.0]), periodic=np.array([0])),
    "lists": lambda data: data.assign_attrs(depth_m=[12.0], periodic=[0]),
}


@pytest.mark.parametrize("kind", ["h5netcdf", "scipy", "zarr"])
@pytest.mark.parametrize("name", SEAS)
def test_a_sea_is_what_its_attributes_say(name: str, kind: str, tmp_path: Path) -> None:
    if (kind, name) in {("zarr", "one entry"), ("h5netcdf", "lists"), ("scipy", "lists")}:
        pytest.skip("this kind of file has no such attribute")
    (plain, frame), (found, same) = sea(tmp_path, lambda data: data, kind), sea(tmp_path, SEAS[name], kind)
    np.testing.assert_allclose(same, frame, atol=1e-6)
    for fact in ("frames", "step_s", "points", "spacing_m", "west_m", "south_m", "periodic"):
        assert getattr(found, fact) == pytest.approx(getattr(plain, fact), rel=1e-6), fact
    assert found.depth_m == (12.0 if name in ("one entry", "lists") else None)


# ------------------------------------------------------------------------------------------------ headers


TOML = {
    "true": True, "whole": 3, "negative": -7, "large": 10**20, "real": 2.5, "nan": float("nan"), "inf": float("inf"),
    "text": "text", "no text": "", "number as text": "9.4", "list": [1, 2], "no list": [], "list of true": [True],
    "list of lists": [[1.0]], "list of texts": ["a"], "table": {"a": 1}, "no table": {}, "list of tables": [{"a": 1}],
}  # fmt: skip
MADE_OF = {"date": "2020-01-01", "time": "07:32:00", "moment": "1979-05-27T07:32:00Z"}  # TOML's alone
PYTHON = re.compile(r"Error|Traceback|\bobject is\b|\bNoneType\b|\bbool\b|\bfloat\b|\bdict\b|\btuple\b|\bstr\b|\bint\b")


def toml_of(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml_of(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_of, value)) + "]"
    return str(value) if isinstance(value, float) and not np.isfinite(value) else json.dumps(value)


def said(call: Callable[[], object]) -> list[str]:
    try:
        call()
    except InputError as refusal:
        return list(refusal.problems)
    return []


_KEYS = {str(field.annotation): key for key, field in RecordingHeader.model_fields.items()}
OF_EACH_TYPE = {*_KEYS.values(), "ITER", "header"}


@pytest.mark.parametrize("key", [*RecordingHeader.model_fields, "ITER", "header"])
def test_a_header_of_any_type_is_taken_or_refused_in_plain_words(key: str, tmp_path: Path) -> None:
    """Every key × every type that TOML and JSON have: a line, and no word of Python's; as attributes one key of each
    type, for what is read of them is held alike."""
    as_toml, as_json, as_attributes = tmp_path / "a.toml", tmp_path / "a.json", tmp_path / "a.h5"
    as_hdf5(as_attributes, PLAIN, {})
    for name, value in (TOML | MADE_OF).items():
        tree = HEADER | {key: value}
        written = value if name in MADE_OF else toml_of(value)
        lines = [f"{each} = {toml_of(own)}" for each, own in HEADER.items() if each != key] + [f"{key} = {written}"]
        as_toml.write_text("\n".join(lines))
        as_json.write_text(json.dumps(tree))
        told = [
            said(lambda: read_header(as_toml)),
            said(lambda: read_header(as_json)),
            said(partial(read_header, tree)),
        ]
        if (
            not isinstance(value, dict)
            and value != 10**20
            and not (isinstance(value, list) and value[:1] in ([{"a": 1}],))
            and key in OF_EACH_TYPE
        ):
            with h5py.File(as_attributes, "a") as file:
                file.pop("header", None)
                file.create_group("header").attrs.update(tree)
            told.append(said(lambda: open_recording(as_attributes)))
        for problems in told:
            for line in problems:
                assert not PYTHON.search(line), line
                assert line.isprintable()
        if key in ("ITER", "header"):
            assert all(any(f"{key}" in line for line in problems) for problems in told)


@pytest.mark.parametrize("text", ["true", "3", "null", '"text"', "[1]", "{", ""])
@pytest.mark.parametrize("where", ["a.json", "header of a.h5", "header of a.npz", "header of a.nc"])
def test_a_header_that_is_no_table_is_refused_in_plain_words(where: str, text: str, tmp_path: Path) -> None:
    path = tmp_path / where.split()[-1]
    if where == "a.json":
        path.write_text(text)
        problems = said(lambda: read_header(path))
    else:
        if where.endswith("h5"):
            as_hdf5(path, PLAIN | {"header": np.bytes_(text)}, {})
        elif where.endswith("npz"):
            np.savez(path, allow_pickle=False, header=np.array(text), **PLAIN)
        else:
            in_netcdf("scipy")(path, PLAIN, {})
            with xr.open_dataset(path, engine="scipy", decode_cf=False) as data:
                whole = data.load().assign_attrs(header=text or " ")
            whole.to_netcdf(path, engine="scipy")
        problems = said(lambda: open_recording(path))
    (line,) = problems
    assert not PYTHON.search(line), line


def test_a_recording_of_matlab_is_as_plain(right: xr.Dataset, tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "a.mat", PLAIN)
    alike(open_recording(tmp_path / "a.mat", HEADER), right)
