"""Directional spectra of the sea from files of buoys and wave models, read by the library wavespectra.

Whatever is wrong with a file becomes an InputError of one line. wavespectra takes a second to import, so it is imported
only when a file is read.
"""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import GRAVITY, WATER_DENSITY
from ..errors import InputError, Refusal, say_of
from .ndbcfile import convert_moments, density_from_moments, open_ndbc
from .opening import bytes_held, check_declared_size, open_file, read_unpacked
from .process import suppress_close_errors, suppress_complaints
from .spectrum_layouts import (
    NETCDF,
    NO_DIRECTIONS,
    TEXT,
    WANTED,
    DensityUnit,
    convert_density,
    density_unit,
    netcdf_density,
    open_netcdf,
    plain_copy,
    read_text,
    text_kind,
)
from .text import is_wide

KINDS = ("ndbc", "swan", *NETCDF, *TEXT)
"""ndbc: a buoy of the US National Data Buoy Center, five text files or NetCDF; swan, ncswan: SWAN's text, NetCDF; ww3,
ww3_station: WAVEWATCH III's NetCDF, text; era5: ECMWF's 2D spectra; datawell (.spt), spotter (CSV, JSON), triaxys:
buoys; octopus; wavespectra, json: as that library writes them, NetCDF or Zarr, JSON."""

Spectra = xr.DataArray | xr.Dataset
_KINDS_IN_WORDS = f"kinds are {', '.join(KINDS)}"
_COUNTED = ("LONLAT", "LOCATION", "AFREQ", "RFREQ", "CDIR", "NDIR", "QUANT")  # after which SWAN says how many follow
_NEAR = np.timedelta64(3, "h")  # a sea state is as good as the same for so long
_HEIGHT_OFF = 0.05  # by which the spectrum's own height may differ from the one that the file states
_UNDERSHOOT = 0.01  # of the highest density, by which one that was interpolated may fall below 0


@dataclass(frozen=True)
class DirectionalTable:
    """A spectrum E(f, θ) as a table."""

    frequency_hz: NDArray[np.float64]  # (f,), ascending
    from_deg: NDArray[np.float64]  # (d,), ascending in [0, 360): where waves come from
    density: NDArray[np.float64]  # (f, d), m²/(Hz·degree), ≥ 0
    source: str  # file, time and site in one line


def read_directional_spectrum(
    path: str | os.PathLike[str], kind: str = "auto", time: str | None = None, site: int = 0
) -> DirectionalTable:
    """The spectrum of one time and one site of a file.

    kind: one of KINDS, or "auto" to decide by the content. time: ISO text, UTC by default; the nearest time
    of the file is taken, the first one for None. site: index of the station, in the file's order.

    NDBC's text comes in five files, of which `path` names the one of the densities; the others must lie beside it,
    named as NDBC names them: 46042.data_spec with .swdir, .swdir2, .swr1 and .swr2, or 46042w2019.txt with d, i, j and
    k for the w, or any name that contains swden with those words instead. A buoy measures two harmonics of the
    directions (Longuet-Higgins, Cartwright & Smith 1963); of all densities that have them the most even one is taken
    (Kobune & Hashimoto 1986). A frequency without directions is spread evenly. Elsewhere missing values count as no
    waves.

    Raises InputError for a file that is missing, of another kind, damaged, without directions or without any number,
    and for a site or time that it has not.
    """
    path = Path(path)
    with say_of(f"{path}: "):
        result = _kind_of(path) if kind in ("auto", *KINDS) else None
        if result is None or kind not in ("auto", result):
            what = (
                f"is not a directional spectrum of the kind {kind}" if kind != "auto" else "is no spectrum known here"
            )
            stated = f" but {result}" if result else ""
            raise Refusal(f"{what}{stated}; {_KINDS_IN_WORDS}")
        damage = ""
        with suppress_close_errors(), warnings.catch_warnings():
            # The libraries' own messages are not shown: readers that wavespectra cannot offer for want of another
            # package, what they will have to change one day, and files that it leaves open where they are damaged.
            warnings.filterwarnings("ignore", message="Cannot import function")
            warnings.filterwarnings("ignore", message=".*phony_dims", category=UserWarning)  # of HDF5 that is no NetCDF
            for category in (DeprecationWarning, ResourceWarning, RuntimeWarning):  # the last of scales and fill values
                warnings.simplefilter("ignore", category)
            # Of a line that it cannot read, wavespectra warns and takes it as missing: that is damage.
            warnings.filterwarnings("error", category=UserWarning, module=r"wavespectra\.core")
            try:
                return _read(path, result, time, site)
            except InputError:
                raise
            except Exception as error:  # the parsers raise exceptions of many types; other ones speak of the program
                damage = f" ({error})"[:200] if isinstance(error, OSError | ValueError) else ""
        # After the files that the error holds open: closed outside of the above, they complain.
        raise Refusal(f"is damaged, or not quite a spectrum of the kind {result}{damage}; {_KINDS_IN_WORDS}")


def _read(path: Path, kind: str, time: str | None, site: int) -> DirectionalTable:
    with _open_spectra(path, kind) as spectra:
        chosen = _select_spectrum(spectra, path, time, site)
        check_declared_size(str(path), chosen.nbytes, bytes_held(path))
        spectrum = convert_moments(chosen) if isinstance(chosen, xr.Dataset) else chosen
        if kind in NETCDF:
            spectrum = convert_density(spectrum, kind)
        if "moment" in spectrum.dims:
            return _table(density_from_moments(spectrum))
        least, most = float(spectrum.min()), float(spectrum.max())
        if least < -_UNDERSHOOT * abs(most) and kind != "swan":  # whose exception value is -99
            # A fill value that the file does not declare would be a calm where none was measured.
            raise Refusal(
                f"holds a density of {least:g}: must be at least 0; declare the value of what is missing as "
                "_FillValue, or leave it out"
            )
        return _table(spectrum)


# ---------------------------------------------------------------------------------------------------- the file's kind


def _kind_of(path: Path) -> str | None:
    """The kind of a file by its content; None for a file that is no spectrum."""
    try:
        if path.is_dir() and any((path / each).exists() for each in ("zarr.json", ".zgroup", ".zmetadata")):
            return _netcdf_kind(path)
        with open_file(path, WANTED) as file:
            start = file.read(200)
        if is_wide(start) and not path.suffix == ".gz":
            raise Refusal("is text in UTF-16; save it as UTF-8")
        if start[:3] == b"CDF" or start[:8] == b"\x89HDF\r\n\x1a\n":
            return _netcdf_kind(path)
        begin = _read_text(path)[:4_000_000]
    except OSError as error:
        raise Refusal(f"cannot be read ({error}); give a readable file") from None
    if begin.startswith("SWAN"):
        return "swan"
    return "ndbc" if re.match(r"#?(YY|YYYY)\s+MM\s+DD\s+hh\b", begin) else text_kind(begin)


def _netcdf_kind(path: Path) -> str | None:
    with suppress_complaints():
        try:
            with open_netcdf(path, decode_times=False) as file:
                names = {str(name) for name in (*file.variables, *file.dims)}
        except InputError:
            raise
        except Exception:  # a NetCDF file cut short, or of another make: each library below has its own errors
            return None
    if "spectral_wave_density" in names:
        return "ndbc"
    return next((kind for kind, each in NETCDF.items() if any(mark <= names for mark in each.marks)), None)


def _read_text(path: Path) -> str:
    """A text file, packed or not, without a byte-order mark; letters of another encoding are marked as such."""
    return read_unpacked(path, WANTED).decode("utf-8-sig", "replace").replace("\r\n", "\n").replace("\r", "\n")


# -------------------------------------------------------------------------------------------------- one time, one site


def _select_spectrum(spectra: Spectra, path: Path, time: str | None, site: int) -> Spectra:
    """The spectrum (freq, dir) or (freq, moment) of one time and one site, and the words for both in its attributes."""
    if isinstance(spectra, xr.DataArray) and not {"dir", "moment"} & set(spectra.dims):
        raise Refusal(NO_DIRECTIONS)
    when = ""
    if "time" in spectra.dims:
        index = _time_index(spectra["time"].to_numpy(), path, time)
        when = f", {np.datetime_as_string(spectra['time'].to_numpy()[index], unit='s')}"
        spectra = spectra.isel(time=index)
    elif time is not None:
        raise InputError(f"time = {time}: {path.name} has one spectrum without a time; leave time out")
    points = [name for name in spectra.dims if name not in ("freq", "dir", "moment")]
    stations = int(np.prod([spectra.sizes[name] for name in points]))
    if not 0 <= site < stations:
        held = f"sites 0 to {stations - 1}" if stations > 1 else "one site, 0"
        raise InputError(f"site = {site}: {path.name} has {held}; choose one of them")
    spectra = spectra.isel(
        dict(zip(points, np.unravel_index(site, [spectra.sizes[name] for name in points]), strict=True))
    )
    return spectra.transpose("freq", ...).assign_attrs(source=f"{path.name}{when}, site {site}")


def _time_index(times: NDArray[np.datetime64], path: Path, wanted: str | None) -> int:
    """The nearest time, within a step of the file or three hours, whichever is longer."""
    times = np.asarray(times)
    known = np.flatnonzero(~np.isnat(times)) if times.dtype.kind == "M" else np.arange(0)
    if not known.size:
        raise Refusal("has no time that is a date; correct the file's times")
    if known.size < times.size:
        return int(known[_time_index(times[known], path, wanted)])
    if wanted is None:
        return int(np.argmin(times))
    try:
        moment = datetime.fromisoformat(wanted)
    except ValueError:
        raise InputError(f"time = {wanted}: is not a time; write it as 2024-05-01T12:00") from None
    if moment.tzinfo is not None:
        moment = moment.astimezone(UTC).replace(tzinfo=None)
    away = np.abs(times - np.datetime64(moment))
    index = int(np.argmin(away))
    step = np.median(np.diff(np.sort(times))) if times.size > 1 else _NEAR
    if away[index] > max(step, _NEAR):
        first, last = (np.datetime_as_string(end, unit="m") for end in (times.min(), times.max()))
        raise InputError(f"time = {wanted}: {path.name} runs from {first} to {last}; choose a time of it")
    return index


def _table(spectrum: xr.DataArray) -> DirectionalTable:
    """Ascending frequencies and directions, each once; numbers only, none negative."""
    density = np.asarray(spectrum.to_numpy(), dtype=np.float64)
    if not np.any(np.isfinite(density)):
        raise Refusal(f"holds no number at {spectrum.attrs['source']}; choose another time or site")
    density = np.maximum(np.where(np.isfinite(density), density, 0.0), 0.0)  # negative: SWAN's exception value
    # Rounded, since float32 makes 0.1 Hz 0.10000000149 and 360° may be 359.99997°.
    frequency, rows = np.unique(np.round(spectrum["freq"].to_numpy().astype(np.float64), 7), return_index=True)
    direction = np.round(spectrum["dir"].to_numpy().astype(np.float64), 3) % 360.0
    direction, columns = np.unique(direction, return_index=True)
    waves = frequency > 0.0
    if np.count_nonzero(waves) < 2:
        raise Refusal("has fewer than two frequencies; give a spectrum")
    if direction.size < 3:
        raise Refusal(NO_DIRECTIONS)
    frequency, density = frequency[waves], density[np.ix_(rows[waves], columns)]
    around = np.column_stack((density, density[:, 0]))
    of_frequency = np.trapezoid(around, np.append(direction, direction[0] + 360.0), axis=1)
    height = 4.0 * float(np.sqrt(np.trapezoid(of_frequency, frequency)))
    held = spectrum.coords.get("stated_height")  # a file that states its wave height states its units once more
    stated = float(held) if held is not None and held.size == 1 else np.nan
    if 0.0 < stated < np.inf and abs(height / stated - 1.0) > _HEIGHT_OFF:
        raise Refusal(
            f"its densities make waves of {height:.3g} m, and it states a height of {stated:.3g} m; "
            "correct the units of the density, the frequencies or the directions"
        )
    return DirectionalTable(frequency, direction, density, str(spectrum.attrs["source"]))


# ------------------------------------------------------------------------------------------------------- the formats


@contextmanager
def _open_spectra(path: Path, kind: str) -> Iterator[Spectra]:
    """All spectra of a file, those of NetCDF not yet read."""
    if kind in NETCDF:
        with open_netcdf(path) as file:
            yield netcdf_density(file, kind)
    elif kind in TEXT:
        yield read_text(path, kind)
    else:
        with {"ndbc": open_ndbc, "swan": _open_swan}[kind](path) as spectra:
            yield spectra


@contextmanager
def _open_swan(path: Path) -> Iterator[xr.DataArray]:
    lines = _read_text(path).split("\n")
    begins = [(line.split(maxsplit=1) or [""])[0] for line in lines[:100_000]]
    header = [word[:8] for word in begins]
    for word, count in zip(header, begins[1:], strict=False):
        # wavespectra would read on for ever
        if word in _COUNTED and count.isdecimal() and int(count[:18]) > len(lines):
            raise Refusal(f"declares {count} of {word} in {len(lines)} lines; give a whole file")
    if "ITER" in header:
        raise Refusal(
            "holds the iterations of a test point (ITER), none of which is the sea; give the file that SWAN's "
            "SPECOUT writes"
        )
    words = set(header[: header.index("QUANT") if "QUANT" in header else None])
    if not {"NDIR", "CDIR"} & words:
        raise Refusal(NO_DIRECTIONS)
    for one, other in (("LONLAT", "LOCATIONS"), ("AFREQ", "RFREQ")):
        if not {one, other[:8]} & words:
            raise Refusal(f"has neither {one} nor {other} in its header; give the file as SWAN writes it")
    from wavespectra.core.swan import SwanSpecFile

    scale = _swan_unit(header, lines)
    with plain_copy(path, "spectrum.spc") as plain:
        swan = SwanSpecFile(plain)
        try:
            density = np.array(list(swan.readall()))
        finally:
            swan.close()
    factor = scale.factor * (2.0 * np.pi * np.asarray(swan.freqs)[:, None] if scale.action else 1.0)
    density = np.where(density > 0.0, density * factor, density)  # SWAN's exception value stays
    coordinates = {"freq": swan.freqs, "dir": swan.dirs}
    if not isinstance(swan.times, list):  # a stationary run
        yield xr.DataArray(density[0], dims=("site", "freq", "dir"), coords=coordinates)
    else:
        times = np.array(swan.times, dtype="datetime64[ns]")
        yield xr.DataArray(density, dims=("time", "site", "freq", "dir"), coords={"time": times, **coordinates})


def _swan_unit(header: list[str], lines: list[str]) -> DensityUnit:
    """The unit of the density, by the two lines that QUANT has for it: its name, and its unit. wavespectra has divided
    energy by ρg already."""
    if "QUANT" not in header:
        return DensityUnit(1.0)
    begin = header.index("QUANT") + 2  # past how many quantities there are
    name, unit = ([*re.split(r"\s{2,}|\t", line.strip()), ""][0] for line in lines[begin : begin + 2])
    name, unit = name.split()[0] if name else "", unit.removesuffix(" unit")
    if name.lower() not in ("vadens", "endens", "acdens"):
        raise Refusal(f"holds '{name}', not VaDens, EnDens or AcDens; give a directional spectrum")
    found = density_unit(unit, name, action=name.lower() == "acdens")
    return replace(found, factor=found.factor * WATER_DENSITY * GRAVITY) if unit[:1] in "Jj" else found
