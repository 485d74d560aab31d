"""Layouts of directional spectra: NetCDF and Zarr by their own words, text by the readers of wavespectra.

All is converted here to Hz, degrees clockwise from north where waves come from, and m²/(Hz·degree). In the units of a
spectral density the second stands for 1/Hz: m2 s rad-1 is per Hz and radian, as WAVEWATCH III and ERA5 write it; per
rad/s it is where the unit has radians twice, or radians and degrees.
"""

from __future__ import annotations

import importlib
import math
import re
import tempfile
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import GRAVITY, WATER_DENSITY
from ..errors import Refusal
from .declared import mask_out_of_range, parse_unit, to_unit
from .opening import check_store, open_dataset, read_unpacked
from .text import plain_attribute, refuse_underscores

Sense = Literal["from", "to"]

_TO = re.compile(
    r"to_direction|\b(going|propagat\w+|travel\w*|heading)\b|\btowards?\b|\bto which\b|oceanographic", re.I
)
_FROM = re.compile(r"from_direction|\b(coming )?from\b|nautical|meteorological", re.I)
_ORIGIN = re.compile(r"\bfrom (the |true |geographic )*(north|east|x)\b", re.I)
_CARTESIAN = re.compile(r"counter-?\s?clockwise|anti-?clockwise|cartesian|mathematical|trigonometric", re.I)
_EAST, _NORTH = (re.compile(rf"\bfrom (the |true |geographic )*({each})\b", re.I) for each in ("east|x", "north"))
_DESCRIBING = ("standard_name", "long_name", "description", "comment", "convention", "direction_convention",
               "direction", "reference", "positive")  # fmt: skip
_OF_DIRECTIONS = re.compile(r"[^.;,]*\b(directions?|going to|coming from|oceanographic|nautical)\b[^.;,]*", re.I)
_NO_FREQUENCY = re.compile(r"angular|circular|\brad\b|radian|omega|sigma|period", re.I)
_ANGLE_AND_WORDS = re.compile(r"((?:deg(?:r|rees?)?|rad(?:ians?)?|[°º])(?:_true)?)(?:T$|[\s_,(]+(.+?)\)?$)", re.I)
_FULL_CIRCLE = 2.0 * math.pi + 0.01


@dataclass(frozen=True)
class DensityUnit:
    """What a density is counted in: `factor` makes it m²/(Hz·degree), of an action density times 2πf [rad/s]."""

    factor: float
    action: bool = False


def density_unit(declared: str, called: str, omega: bool = False, action: bool = False) -> DensityUnit:
    """The unit of a density by its words. omega: the file counts frequencies in rad/s; action: the density is called
    one of action.

    Raises Refusal for what is no directional density, and where per Hz and per rad/s cannot be distinguished.
    """
    size, powers = parse_unit(declared) or (0.0, {})
    length, seconds, mass, angles = (powers.get(each, 0) for each in ("length", "time", "mass", "angle"))
    if (mass, length) == (1, 0):  # an energy, kg/s² = J/m²
        size, seconds, length = size / (WATER_DENSITY * GRAVITY), seconds + 2, 2
        mass = 0
    action = action or seconds == 2
    twice = re.search(r"deg\w*\s*\^?\s*\{?-2", declared.replace("**", "^"), re.I)  # no frequency is in degrees
    if not size or mass or length != 2 or seconds != 1 + action or angles not in (-1, -2) or twice:
        raise Refusal(
            f"{called}: is in '{declared}': must be a variance per frequency and direction, such as m2/Hz/degree or "
            "m2 s rad-1; convert it"
        )
    per_omega = angles == -2
    if omega and not per_omega and not re.search(r"h(z|ertz)", declared, re.I):
        raise Refusal(
            f"{called}: is in '{declared}' over frequencies in rad/s: per Hz or per rad/s is not told; write m2/Hz/rad "
            "or m2/(rad/s)/rad, or give frequencies in Hz"
        )
    return DensityUnit(size * math.pi / 180.0 * (2.0 * math.pi if per_omega else 1.0), action)


def words_of(attributes: Mapping[str, Any]) -> str:
    """What attributes say in words of which way directions point."""
    texts = {str(name).lower(): plain_attribute(value) for name, value in attributes.items()}
    return "; ".join(str(texts[name]) for name in _DESCRIBING if name in texts)


def wave_from_degrees(
    direction: NDArray[np.float64],
    attributes: Mapping[str, Any],
    called: str,
    otherwise: Sense = "from",
    more: str = "",
) -> NDArray[np.float64]:
    """Directions (d,) as degrees clockwise from north where waves come from, by their coordinate's attributes;
    more: what else the file says of directions, where these say nothing; otherwise: what a file of this kind means
    where nothing does. Raises Refusal for what is ambiguous."""
    unit = plain_attribute(attributes.get("units"))
    if unit is None and direction.size > 2 and np.ptp(direction) > 4.0 and np.abs(direction).max() <= _FULL_CIRCLE:
        raise Refusal(f"{called}: has no unit and ends at {direction.max():.3g}; declare degree or radian as its units")
    words, written = words_of(attributes), _ANGLE_AND_WORDS.fullmatch(str(unit).strip())
    if written and written[2] and written[0].lower() not in ("degrees_north", "degrees_east"):
        unit, words = written[1], "; ".join(filter(None, (words, written[2].replace("_", " "))))
    elif written:
        unit = written[1] if written[0].endswith("T") else unit
    degrees = to_unit(direction, unit, "degree", called)
    sense = _sense_of(words, str(plain_attribute(attributes.get("standard_name", ""))), called)
    words = words if _is_turned(words) or sense else "; ".join(filter(None, (words, more)))
    if "magnetic" in words.lower():
        raise Refusal(f"{called}: is described as '{words}': must count from true north; turn it by the variation")
    turned, east = _is_turned(words), bool(_EAST.search(words))
    if turned or east:
        degrees = (90.0 if east or not _NORTH.search(words) else 0.0) + (-degrees if turned else degrees)
    sense = sense or _sense_of(words, "", called) or ("to" if turned else otherwise)
    return degrees + (180.0 if sense == "to" else 0.0)


def _is_turned(words: str) -> bool:
    return bool(_CARTESIAN.search(words))


def _sense_of(words: str, name: str, called: str) -> Sense | None:
    apart = _ORIGIN.sub("", words)  # "clockwise from north" tells no sense
    to, coming = _TO.search(apart), _FROM.search(apart)
    if to and coming and not re.search(r"(to|from)_direction", name):
        raise Refusal(f"{called}: is described as '{words}', both where waves come from and go to; keep one of them")
    if not (to or coming):
        return None
    return "to" if to and not name.endswith("from_direction") else "from"


def convert_spectrum(density: xr.DataArray, sense: Sense, unit: str | None, notes: Iterable[str]) -> xr.DataArray:
    """A density (…, freq, dir) in Hz, degrees where waves come from, and m²/(Hz·degree), by its attributes, those of
    its coordinates. What lies beyond its valid range is missing. sense, unit: of a file of this kind that says nothing;
    notes: what the file says beside it. Raises Refusal."""
    density = density.copy(data=mask_out_of_range(density.to_numpy(), density.attrs, density.encoding))
    if not {"freq", "dir"} <= set(density.dims):
        return density  # whoever asks for directions says that there are none
    hertz, axis_unit = frequencies_hz(density["freq"])
    omega = "rad" in axis_unit.lower()
    direction = density["dir"]
    more = "; ".join(
        chunk[0]
        for text in (*notes, words_of(density.attrs))
        for chunk in _OF_DIRECTIONS.finditer(text)
        if not re.search("wind|current", chunk[0])
    )
    degrees = wave_from_degrees(direction.to_numpy().astype(np.float64), direction.attrs, "direction", sense, more)
    declared = plain_attribute(density.attrs.get("units", unit))
    if "significant_height" in str(plain_attribute(density.attrs.get("standard_name", ""))):
        declared = unit  # wavespectra 4.9 leaves the words of a height on spectra that it constructs
    factor, action = 1.0, "action" in words_of(density.attrs).lower()
    if declared is not None and str(declared).strip():
        found = density_unit(str(declared), "density", omega, action)
        factor, action = found.factor, found.action
    elif omega or action:
        raise Refusal(f"density: has no unit, with frequencies in '{axis_unit}'; declare one, such as m2/Hz/degree")
    result = density.assign_coords(freq=hertz, dir=degrees) * factor
    if action:  # E = 2πf N
        result = result * (2.0 * np.pi * result["freq"])
    return result


def frequencies_hz(frequency: xr.DataArray) -> tuple[NDArray[np.float64], str]:
    """Frequencies (f,) in Hz, and the unit that the file declares. Raises Refusal."""
    unit, words = plain_attribute(frequency.attrs.get("units")), words_of(frequency.attrs)
    if unit is None and _NO_FREQUENCY.search(words):
        raise Refusal(f"frequency: is described as '{words}' and has no unit; declare Hz or rad/s")
    return to_unit(frequency.to_numpy(), unit, "Hz", "frequency"), str(unit)


WANTED = "a directional spectrum"
NO_DIRECTIONS = "has no directions in it, only frequencies; give a directional spectrum"
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


def netcdf_density(file: xr.Dataset, kind: str) -> xr.DataArray:
    """The densities of a file, not yet read, under their names here; the wave height that the file states beside them,
    and what it says of directions in its own attributes, go with them. Raises Refusal for a file without any.
    """
    layout = NETCDF[kind]
    names = {old: new for old, new in layout.names.items() if old in file.variables or old in file.dims}
    file = file.rename({old: new for old, new in names.items() if old != new})
    if "efth" not in file or "dir" not in file["efth"].dims or "dir" not in file.variables:
        raise Refusal(NO_DIRECTIONS)
    density = file["efth"].assign_attrs(of_the_file=[plain_attribute(each) for each in file.attrs.values()])
    for name, held in file.data_vars.items():
        called = str(plain_attribute(held.attrs.get("standard_name", "")))
        is_height = called == _HEIGHT if called else name in _HEIGHTS
        if is_height and held.dtype.kind in "iuf" and set(held.dims) <= set(density.dims) - {"freq", "dir"}:
            return density.assign_coords(stated_height=held)
    return density


def convert_density(density: xr.DataArray, kind: str) -> xr.DataArray:
    """A density of one time and site in Hz, degrees where waves come from, and m²/(Hz·degree). Raises Refusal."""
    layout = NETCDF[kind]
    if "stated_height" in density.coords:
        height = density["stated_height"]
        unit = plain_attribute(height.attrs.get("units"))
        density = density.assign_coords(stated_height=to_unit(height.to_numpy(), unit, "m", "height"))
    if kind == "era5":
        density, done = _undo_logarithms(density)
        if done:
            return density
    if layout.angle and "units" not in density["dir"].attrs:
        density["dir"].attrs["units"] = layout.angle
    description = [str(each) for each in density.attrs.pop("of_the_file", ())]
    return convert_spectrum(density, layout.sense, layout.unit, description).assign_attrs(density.attrs)


def _undo_logarithms(density: xr.DataArray) -> tuple[xr.DataArray, bool]:
    """ERA5's d2fd is log10, and its frequencies and directions may be numbers 1 to n: whether they were comes too."""
    from wavespectra.input.era5 import from_era5

    if not float(density.min()) < 0.0:
        raise Refusal("d2fd holds no logarithms, as ERA5's does; name the variable efth")
    axes = [density[name].to_numpy() if name in density.coords else np.arange(1, density.sizes[name] + 1)
            for name in ("freq", "dir")]  # fmt: skip
    if all(np.array_equal(axis, np.arange(1, axis.size + 1)) for axis in axes):
        return from_era5(density.to_dataset(name="efth"))["efth"].assign_attrs(density.attrs), True
    if any(np.array_equal(axis, axis.astype(int)) and np.ptp(axis) == axis.size - 1 for axis in axes):
        raise Refusal("has a part of ERA5's numbered frequencies or directions; give all of them")
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
            raise Refusal("speaks of radians, and TRIAXYS counts in degrees; convert it")
        reader = getattr(importlib.import_module(f"wavespectra.input.{kind}"), f"read_{kind}")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            data = reader(str(plain)).load()
    density = data["efth"] if "time" not in data or "}" not in name else data["efth"].isel(time=0, drop=True)
    if "hs" in data and set(data["hs"].dims) <= set(data["efth"].dims):
        height = data["hs"] if density.ndim == data["efth"].ndim else data["hs"].isel(time=0, drop=True)
        density = density.assign_coords(stated_height=height)
    return density
