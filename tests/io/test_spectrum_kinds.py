"""Each kind of spectrum that wavespectra reads is the same sea here, whether its kind is named or found."""

from __future__ import annotations

import gzip
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
import xarray as xr
from declared_sea import DIRECTION, FREQUENCY, FROM_DEG, HS, PEAK_HZ, assert_the_sea, true_density

from seamap_rt.errors import InputError
from seamap_rt.io.spectrumfile import KINDS, read_directional_spectrum
from seamap_rt.settings.sea import FileWaves

WIDTH = 5.0  # degrees
ENERGY = true_density().sum(axis=1) * WIDTH  # m²/Hz
SPREAD = np.full(FREQUENCY.size, 20.0)  # degrees
TIME = "2024-05-01T12:00:00"


def dataset() -> xr.Dataset:
    """As wavespectra has it."""
    times = np.array([TIME], dtype="datetime64[ns]")
    data = xr.Dataset(
        {"efth": (("time", "site", "freq", "dir"), true_density()[None, None])},
        {"time": times, "site": [1], "freq": FREQUENCY, "dir": DIRECTION},
    )
    return data.assign(lat=("site", [54.0]), lon=("site", [8.0]))


def write_era5(folder: Path) -> Path:
    """log10 of m² s/rad by numbers, towards 7.5°, 22.5° …: of ERA5's own grid, whose directions the sea is drawn on."""
    hertz = 0.03453 * 1.1 ** np.arange(30)
    towards = np.arange(7.5, 360.0, 15.0)
    shape = hertz**-5.0 * np.exp(-1.25 * (PEAK_HZ / hertz) ** 4)
    spread = np.cos(np.radians(towards + 180.0 - FROM_DEG) / 2.0) ** 20
    table = shape[:, None] * spread
    table *= (HS / 4.0) ** 2 / np.trapezoid(table.sum(axis=1) * 15.0, hertz) * 180.0 / np.pi
    values = np.log10(np.where(table > 1e-12, table, np.nan))
    data = xr.Dataset(
        {"d2fd": (("time", "frequency", "direction"), values[None], {"units": "m**2 s radian**-1"})},
        {"time": [np.datetime64(TIME, "ns")], "frequency": np.arange(1, 31), "direction": np.arange(1, 25)},
    )
    data.to_netcdf(folder / "era5.nc", engine="h5netcdf")
    return folder / "era5.nc"


def write_ncswan(folder: Path) -> Path:
    data = xr.Dataset(
        {"density": (("time", "points", "frequency", "direction"), true_density()[None, None] * 180.0 / np.pi)},
        {"time": [np.datetime64(TIME, "ns")], "frequency": FREQUENCY, "direction": np.radians(DIRECTION)},
    )
    data["hs"] = (("time", "points"), [[HS]], {"units": "m"})
    data.to_netcdf(folder / "swan.nc", engine="h5netcdf")
    return folder / "swan.nc"


def write_ww3(folder: Path) -> Path:
    data = dataset().rename(freq="frequency", dir="direction", site="station", lat="latitude", lon="longitude")
    data["efth"] = data["efth"] * 180.0 / np.pi
    data["direction"] = (DIRECTION + 180.0) % 360.0
    data.to_netcdf(folder / "ww3.nc", engine="h5netcdf")
    return folder / "ww3.nc"


def write_ww3_station(folder: Path) -> Path:
    """Directions in radians that waves run to, densities by radian, frequencies the faster ones."""
    lines = [f"'WAVEWATCH III SPECTRA'    {FREQUENCY.size}    {DIRECTION.size}    1 'a grid'"]
    lines += [" ".join(f"{each:.6E}" for each in FREQUENCY)]
    lines += [" ".join(f"{each:.7E}" for each in np.radians((DIRECTION + 180.0) % 360.0))]
    lines += ["20240501 120000", "'BUOY      '  54.00   8.00   30.0  10.0  280.0  0.00  0.0"]
    values = true_density().T.ravel() * 180.0 / np.pi
    lines += [" ".join(f"{each:.9E}" for each in row) for row in values.reshape(-1, 8)]
    path = folder / "ww3.spc"
    path.write_text("\n".join(lines) + "\n")
    return path


def write_datawell(folder: Path) -> Path:
    top = ENERGY.max()
    lines = ["1", f"{100.0 * HS:.4f}", "5.5", f"{top:.8f}", "15", "12", "7", "0", "0", "0", "0", "68"]
    rows = zip(FREQUENCY, ENERGY / top, SPREAD, strict=True)
    lines += [f"{hertz:.6f},{share:.9f},{FROM_DEG:.1f},{spread:.1f},0.0,3.0" for hertz, share, spread in rows]
    path = folder / "haven.spt"
    path.write_text("\n".join(lines) + "\n")
    return path


def write_spotter(folder: Path) -> Path:
    numbers = range(FREQUENCY.size)
    columns: dict[str, float] = {"Epoch Time": 1714564800, "Significant Wave Height (m)": HS}
    for name, values in (("f", FREQUENCY), ("varianceDensity", ENERGY), ("direction", FROM_DEG), ("a1", 0.0)):
        columns |= {f"{name}_{n}": float(np.broadcast_to(values, FREQUENCY.size)[n]) for n in numbers}
    for name, value in (("directionalSpread", 20.0), ("b1", 0.0), ("a2", 0.0), ("b2", 0.0)):
        columns |= {f"{name}_{n}": value for n in numbers}
    path = folder / "spotter.csv"
    path.write_text(",".join(columns) + "\n" + ",".join(repr(each) for each in columns.values()) + "\n")
    return path


def write_spotter_json(folder: Path) -> Path:
    zeros = [0.0] * FREQUENCY.size
    spectrum: dict[str, Any] = {"frequency": FREQUENCY.tolist(), "varianceDensity": ENERGY.tolist(), "a1": zeros}
    spectrum |= {"direction": [FROM_DEG] * FREQUENCY.size, "directionalSpread": SPREAD.tolist()}
    spectrum |= dict.fromkeys(("b1", "a2", "b2"), zeros) | {"timestamp": f"{TIME}.000Z"}
    waves = [{"significantWaveHeight": HS, "timestamp": f"{TIME}.000Z", "latitude": 54.0, "longitude": 8.0}]
    path = folder / "spotter.json"
    path.write_text(json.dumps({"data": {"waves": waves, "frequencyData": [spectrum]}}))
    return path


def write_triaxys(folder: Path) -> Path:
    """Its columns are 0 to 360 degrees, of which the last is the first."""
    lines = ["TRIAXYS BUOY DATA REPORT", "VERSION = 5a.02.08", "TYPE    = DIRECTIONAL SPECTRUM"]
    lines += ["DATE    = 2024 May 01 12:00(UTC)", f"NUMBER OF FREQUENCIES = {FREQUENCY.size}"]
    lines += [f"INITIAL FREQUENCY (Hz) = {FREQUENCY[0]}", "FREQUENCY SPACING (Hz) = 0.01"]
    lines += ["RESOLVABLE FREQUENCY RANGE (Hz) = 0.04 TO 0.50", "NUMBER OF DIRECTIONS = 73"]
    lines += [f"DIRECTION SPACING (DEG) = {WIDTH}", "ROWS    = FREQUENCIES, COLUMNS = DIRECTIONS"]
    values = np.column_stack((true_density(), true_density()[:, 0]))
    lines += [" ".join(f"{each:.9E}" for each in row) for row in values]
    path = folder / "buoy.dirspec"
    path.write_text("\n".join(lines) + "\n")
    return path


def by_wavespectra(method: str, name: str, **how: Any) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        import wavespectra  # noqa: F401  # gives xarray its accessor

        getattr(dataset().spec, method)(str(folder / name), **how)
        return folder / name

    return write


def write_zarr(folder: Path) -> Path:
    dataset().to_zarr(folder / "sea.zarr", consolidated=False, zarr_format=2)
    return folder / "sea.zarr"


WRITERS: dict[tuple[str, str], Callable[[Path], Path]] = {
    ("era5", "NetCDF"): write_era5,
    ("ncswan", "NetCDF"): write_ncswan,
    ("ww3", "NetCDF"): write_ww3,
    ("ww3_station", "text"): write_ww3_station,
    ("datawell", "text"): write_datawell,
    ("spotter", "CSV"): write_spotter,
    ("spotter", "JSON"): write_spotter_json,
    ("triaxys", "text"): write_triaxys,
    ("octopus", "text"): by_wavespectra("to_octopus", "sea.oct"),
    ("json", "JSON"): by_wavespectra("to_json", "sea.json"),
    ("swan", "text"): by_wavespectra("to_swan", "sea.spc"),
    ("wavespectra", "NetCDF"): by_wavespectra("to_netcdf", "sea.nc", compress=False, packed=False),
    ("wavespectra", "Zarr"): write_zarr,
}
COARSE = {"octopus": 2e-3, "swan": 2e-3, "era5": 1e-6, "wavespectra": 1e-6}  # of the height: as they round numbers


@pytest.mark.parametrize(("kind", "form"), WRITERS)
def test_every_kind_is_the_same_sea(kind: str, form: str, tmp_path: Path) -> None:
    path = WRITERS[kind, form](tmp_path)
    for named in ("auto", kind):
        assert_the_sea(read_directional_spectrum(path, named), COARSE.get(kind, 1e-6))


@pytest.mark.parametrize(("kind", "form"), [each for each in WRITERS if each[1] in ("text", "CSV", "JSON")])
def test_every_text_may_be_packed_and_have_a_mark_or_comments(kind: str, form: str, tmp_path: Path) -> None:
    path = WRITERS[kind, form](tmp_path)
    content = b"\xef\xbb\xbf" + path.read_bytes()
    path.write_bytes(content)
    assert_the_sea(read_directional_spectrum(path), 2e-3)
    packed = path.with_name(path.name + ".gz")
    packed.write_bytes(gzip.compress(content))
    assert_the_sea(read_directional_spectrum(packed), 2e-3)
    path.write_bytes(content.removeprefix(b"\xef\xbb\xbf").decode().encode("utf-16"))
    with pytest.raises(InputError, match="UTF-16; save it as UTF-8"):
        read_directional_spectrum(path)


@pytest.mark.parametrize(("kind", "form"), [each for each in WRITERS if each[1] != "Zarr"])
def test_what_is_cut_short_is_refused_in_one_line(kind: str, form: str, tmp_path: Path) -> None:
    path = WRITERS[kind, form](tmp_path)
    content = path.read_bytes()
    share = 0.3 if kind == "datawell" else 0.7  # a buoy states its height, to which the tail gives little
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(InputError, match=re.escape(path.name)) as refused:
        read_directional_spectrum(path, kind)
    assert len(refused.value.problems) == 1


def test_a_buoy_that_states_another_height_is_refused(tmp_path: Path) -> None:
    path = write_datawell(tmp_path)
    path.write_text(path.read_text().replace(f"{100.0 * HS:.4f}", f"{120.0 * HS:.4f}"))
    with pytest.raises(InputError, match=r"make waves of 1\.7 m, and it states a height of 2\.04 m"):
        read_directional_spectrum(path)


@pytest.mark.parametrize("change", ["part", "no logarithms"])
def test_what_is_not_as_era5_has_it_is_refused(change: str, tmp_path: Path) -> None:
    with xr.open_dataset(write_era5(tmp_path)) as opened:
        data = opened.load()
    data = data.isel(direction=slice(3, 20)) if change == "part" else data.assign(d2fd=10.0 ** data["d2fd"])
    data.to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="a part of ERA5's" if change == "part" else "no logarithms"):
        read_directional_spectrum(tmp_path / "other.nc")


def test_a_scene_may_name_each_kind() -> None:
    assert {*KINDS, "auto", "recorded"} == set(get_args(FileWaves.model_fields["kind"].annotation))
