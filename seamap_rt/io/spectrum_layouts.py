"""Layouts of directional spectra: NetCDF and Zarr by their own words, text by the readers of wavespectra."""

from __future__ import annotations

import importlib
import re
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import xarray as xr

from ..errors import InputError
from .declared_spectrum import Sense, convert_spectrum
from .opening import check_store, open_dataset, read_unpacked
from .plain_json import plain_attribute
from .text import refuse_underscores
from .units import to_unit

WANTED = "a directional spectrum"
_HEIGHT = "sea_surface_wave_significant_height"
_HEIGHTS = ("hs", "Hs", "hm0", "Hm0", "swh", "VHM0", "hsig", "Hsig", "significant_wave_height", "wave_height")
_F, _D = {"frequency": "freq"}, {"direction": "dir"}


@dataclass(frozen=True)
class NetcdfLayout:
    """How a kind names efth, freq, dir and time, and what its numbers are where its file says nothing."""

    marks: tuple[set[str], ...]  # a file that has all names of one of these is of the kind
    names: dict[str, str] = field(default_factory=dict)
    sense: Sense = "from"
    unit: str | None = None
    angle: str | None = None


NETCDF = {
    "wavespectra": NetcdfLayout(({"efth", "freq"},)),
    "ww3": NetcdfLayout(({"efth", "frequency"}, {"ef", "frequency", "station"}), _F | _D, "to", "m2 s rad-1"),
    "ncswan": NetcdfLayout(({"density", "frequency"},), _F | _D | {"density": "efth"}, "from", "m2 s rad-1", "radian"),
    "era5": NetcdfLayout(
        ({"d2fd"},),
        _F | _D | {"frequencyNumber": "freq", "directionNumber": "dir", "valid_time": "time", "d2fd": "efth"},
        "to",
        "m2 s rad-1",
    ),
}
TEXT = {  # what the begin of a file has, and a name by which the reader knows the format
    "ww3_station": (r"\s*'WAVEWATCH III SPECTRA'", "spectrum.txt"),
    "triaxys": (r".*TRIAXYS BUOY", "spectrum.txt"),
    "spotter": (r"(?=\s*\{).*\"frequencyData\"|(?!\s*\{).*varianceDensity_\d", "spectrum.csv"),
    "datawell": (r"(?:[ \t]*[-+\d.eE]+[ \t]*\n){12}(?:[ \t]*[-+\d.eE]+[ \t]*,){5}", "spectrum}2000-01-01.spt"),
    "octopus": (r"[^\n]*\n\s*nfreqs\s*,", "spectrum.txt"),
    "json": (r"\s*\{.*\"efth\"", "spectrum.json"),
}


# ------------------------------------------------------------------------------------------------- NetCDF and Zarr


def open_netcdf(path: Path, **options: object) -> xr.Dataset:
    """A NetCDF file or a Zarr store, not yet read."""
    if path.is_dir():
        check_store(path, WANTED)
        return xr.open_zarr(path, chunks=None, consolidated=False, **options)  # type: ignore[arg-type]
    return open_dataset(path, WANTED, **options)


def netcdf_density(file: xr.Dataset, kind: str, path: Path) -> xr.DataArray:
    """The densities of a file, not yet read, under their names here; the wave height that the file states beside them,
    and what it says of directions in its own attributes, go with them. Raises InputError for a file without directions.
    """
    layout = NETCDF[kind]
    names = {old: new for old, new in layout.names.items() if old in file.variables or old in file.dims}
    file = file.rename({old: new for old, new in names.items() if old != new})
    if "efth" not in file or "dir" not in file["efth"].dims or "dir" not in file.variables:
        raise InputError(f"{path}: has no directions in it, only frequencies; give a directional spectrum")
    density = file["efth"].assign_attrs(of_the_file=[plain_attribute(each) for each in file.attrs.values()])
    for name, held in file.data_vars.items():
        called = str(plain_attribute(held.attrs.get("standard_name", "")))
        is_height = called == _HEIGHT if called else name in _HEIGHTS
        if is_height and held.dtype.kind in "iuf" and set(held.dims) <= set(density.dims) - {"freq", "dir"}:
            return density.assign_coords(stated_height=held)
    return density


def as_declared(density: xr.DataArray, kind: str, path: Path) -> xr.DataArray:
    """A density of one time and site in Hz, degrees where waves come from, and m²/(Hz·degree). Raises InputError."""
    layout, called = NETCDF[kind], str(path)
    if "stated_height" in density.coords:
        height = density["stated_height"]
        unit = plain_attribute(height.attrs.get("units"))
        density = density.assign_coords(stated_height=to_unit(height.to_numpy(), unit, "m", f"{called}: height"))
    if kind == "era5":
        density, done = _of_logarithms(density, called)
        if done:
            return density
    if layout.angle and "units" not in density["dir"].attrs:
        density["dir"].attrs["units"] = layout.angle
    told = [str(each) for each in density.attrs.pop("of_the_file", ())]
    return convert_spectrum(density, called, layout.sense, layout.unit, told).assign_attrs(density.attrs)


def _of_logarithms(density: xr.DataArray, called: str) -> tuple[xr.DataArray, bool]:
    """ERA5's d2fd is log10, and its frequencies and directions may be numbers 1 to n: whether they were is told too."""
    from wavespectra.input.era5 import from_era5

    if not float(density.min()) < 0.0:
        raise InputError(f"{called}: d2fd holds no logarithms, as ERA5's does; name the variable efth")
    axes = [density[name].to_numpy() if name in density.coords else np.arange(1, density.sizes[name] + 1)
            for name in ("freq", "dir")]  # fmt: skip
    if all(np.array_equal(axis, np.arange(1, axis.size + 1)) for axis in axes):
        return from_era5(density.to_dataset(name="efth"))["efth"].assign_attrs(density.attrs), True
    if any(np.array_equal(axis, axis.astype(int)) and np.ptp(axis) == axis.size - 1 for axis in axes):
        raise InputError(f"{called}: has a part of ERA5's numbered frequencies or directions; give all of them")
    powers = (10.0**density).assign_attrs(density.attrs)
    powers.attrs["units"] = re.sub(r"log_?10|[\[\]]", "", str(plain_attribute(density.attrs.get("units", "")))).strip()
    return powers, False


# ------------------------------------------------------------------------------------------------------------- text


def text_kind(begin: str) -> str | None:
    """The kind of a text by its begin; None for what wavespectra does not know."""
    return next((kind for kind, (mark, _) in TEXT.items() if re.match(mark, begin, re.S)), None)


@contextmanager
def plain_copy(path: Path, name: str) -> Iterator[Path]:
    """A copy of a text, unpacked, without what is not ASCII, which only comments hold."""
    content = read_unpacked(path, WANTED).removeprefix(b"\xef\xbb\xbf")
    with tempfile.TemporaryDirectory() as folder:
        refuse_underscores(content.decode("ascii", "replace"), str(path))
        copy = Path(folder, name)
        copy.write_bytes(content.decode("ascii", "replace").encode("ascii", "replace"))
        yield copy


def read_text(path: Path, kind: str) -> xr.DataArray:
    """The densities of a text, as wavespectra reads them: by Hz, degrees where waves come from, and m²/(Hz·degree)."""
    name = TEXT[kind][1]
    with plain_copy(path, name) as plain:
        if plain.read_text(encoding="ascii").lstrip().startswith("{"):
            plain = plain.rename(plain.with_suffix(".json"))
        if kind == "triaxys" and re.search(r"\brad(ian)?s?\b", plain.read_text(encoding="ascii"), re.I):
            raise InputError(f"{path}: speaks of radians, and TRIAXYS counts in degrees; convert it")
        reader = getattr(importlib.import_module(f"wavespectra.input.{kind}"), f"read_{kind}")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            data = reader(str(plain)).load()
    density = data["efth"] if "time" not in data or "}" not in name else data["efth"].isel(time=0, drop=True)
    if "hs" in data and set(data["hs"].dims) <= set(data["efth"].dims):
        height = data["hs"] if density.ndim == data["efth"].ndim else data["hs"].isel(time=0, drop=True)
        density = density.assign_coords(stated_height=height)
    return density
