"""The directional spectra of buoys as NDBC has them, by the moments of its five files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..errors import Refusal
from .declared import mask_out_of_range, to_unit
from .opening import open_dataset, open_file, read_unpacked
from .spectrum_layouts import NO_DIRECTIONS, WANTED, frequencies_hz, wave_from_degrees
from .text import plain_attribute, refuse_underscores

_NDBC_STEP = 5.0  # degrees; a buoy's density is smooth
_NDBC_NAMES = ("spectral_wave_density", "mean_wave_dir", "principal_wave_dir", "wave_spectrum_r1", "wave_spectrum_r2")


@contextmanager
def open_ndbc(path: Path) -> Iterator[xr.DataArray | xr.Dataset]:
    with open_file(path, WANTED) as file:
        start = file.read(3)
    if start not in (b"CDF", b"\x89HD"):
        yield _open_ndbc_text(path)
        return
    with open_dataset(path, WANTED) as file:
        if not set(_NDBC_NAMES) <= set(file.data_vars):
            raise Refusal(NO_DIRECTIONS)
        yield file[list(_NDBC_NAMES)].rename(frequency="freq")


def convert_moments(spectrum: xr.Dataset) -> xr.DataArray:
    """A buoy's energy in m²/Hz, directions in degrees where waves come from, and shares, by what the file declares."""
    moments = {}
    for name, moment in spectrum.data_vars.items():
        called, values = str(name), mask_out_of_range(moment.to_numpy(), moment.attrs, moment.encoding)
        if "dir" in str(name):
            values = wave_from_degrees(values.astype(np.float64), moment.attrs, called) % 360.0
        elif name == _NDBC_NAMES[0]:
            values = to_unit(values, plain_attribute(moment.attrs.get("units")), "m2/Hz", called)
        moments[name] = moment.copy(data=values)
    hertz, _ = frequencies_hz(spectrum["freq"])
    return xr.Dataset(moments, attrs=spectrum.attrs).to_dataarray("moment").assign_coords(freq=hertz)


def density_from_moments(spectrum: xr.DataArray) -> xr.DataArray:
    """(freq, dir) of a buoy's (freq, moment): energy [m²/Hz], mean and principal direction [deg], lengths r1 and r2."""
    energy, mean, principal, r1, r2 = spectrum.transpose("moment", "freq").to_numpy().astype(np.float64)
    known = (mean <= 360.0) & (principal <= 360.0) & (r1 <= 1.0) & (r2 <= 1.0)  # not so: nan, or nines
    if np.any(np.isfinite(energy)) and not np.any(known):
        raise Refusal(f"has no directions at {spectrum.attrs['source']}, only frequencies; choose another time")
    first, second = r1 * np.exp(1j * np.radians(mean)), r2 * np.exp(2j * np.radians(principal))
    harmonics = np.stack((first.real, first.imag, second.real, second.imag), axis=1)
    directions = np.arange(0.0, 360.0, _NDBC_STEP)
    shares = _maximum_entropy_shares(np.where(known[:, None], harmonics, 0.0), np.radians(directions))
    coordinates = {"freq": spectrum["freq"].to_numpy(), "dir": directions}
    return xr.DataArray(energy[:, None] * shares / _NDBC_STEP, coordinates, ("freq", "dir"), attrs=spectrum.attrs)


def _maximum_entropy_shares(harmonics: NDArray[np.float64], angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Shares p (f, d) ≥ 0 of sum 1 with means (f, 4) of cos θ, sin θ, cos 2θ, sin 2θ, and the greatest entropy.

    That is p ∝ exp(λ · (cos θ, …)), of which λ maximises a concave function: Newton's steps, shortened where they are
    long. The penalty ½ ε λ² keeps λ finite where noise left harmonics that no density has.
    """
    waves = np.stack((np.cos(angle), np.sin(angle), np.cos(2.0 * angle), np.sin(2.0 * angle)))
    penalty = 1e-6
    multipliers = np.zeros_like(harmonics)
    shares = np.full((harmonics.shape[0], angle.size), 1.0 / angle.size)
    for _ in range(200):  # ten for a real sea
        mean = shares @ waves.T
        uphill = harmonics - mean - penalty * multipliers
        spread = np.einsum("fd,id,jd->fij", shares, waves, waves) - mean[:, :, None] * mean[:, None, :]
        step = np.linalg.solve(spread + penalty * np.eye(4), uphill[:, :, None])[:, :, 0]
        gain = np.sum(uphill * step, axis=1, keepdims=True)
        multipliers = multipliers + step / (1.0 + np.sqrt(np.maximum(gain, 0.0)))
        exponent = multipliers @ waves
        shares = np.exp(exponent - exponent.max(axis=1, keepdims=True))
        shares /= shares.sum(axis=1, keepdims=True)
        if np.max(gain) < 1e-16:
            break
    return shares


def _open_ndbc_text(path: Path) -> xr.DataArray:
    """The five text files of a buoy, (time, freq, moment)."""
    from wavespectra.input.ndbc_ascii import read_file

    tables = []
    for file in (path, *_companion_files(path)):
        refuse_underscores(read_unpacked(file, WANTED).decode("utf-8", "replace"), str(file))
        table = read_file(str(file)).drop(columns="Sep_Freq", errors="ignore").astype(np.float64)
        table.columns = [round(float(name), 7) for name in table.columns]
        tables.append(table[~table.index.duplicated()])
    density, mean, principal, *lengths = tables
    density = density.mask(density >= 999.0)  # what is missing is filled with nines
    # NDBC archives r1 and r2 in hundredths, and gives them as they are in its files of the last 45 days.
    lengths = [table.mask(table > 100.0) for table in lengths]
    hundredths = np.nanmedian(lengths[0].to_numpy()) > 1.0 if lengths[0].notna().to_numpy().any() else False
    lengths = [table * (0.01 if hundredths else 1.0) for table in lengths]
    same = [table.reindex_like(density).to_numpy() for table in (density, mean, principal, *lengths)]
    coordinates = {"time": density.index.to_numpy(), "freq": density.columns.to_numpy(dtype=np.float64)}
    return xr.DataArray(np.stack(same, axis=-1), coordinates, ("time", "freq", "moment"))


def _companion_files(path: Path) -> list[Path]:
    """The files of mean direction, principal direction, r1 and r2 that belong to one of densities."""
    words = ("swdir", "swdir2", "swr1", "swr2")
    if re.search(r"data_spec|swden", path.name):
        names = [re.sub(r"data_spec|swden", word, path.name, count=1) for word in words]
    elif archived := re.fullmatch(r"(\w{5})w(\d{4}\..+)", path.name):
        names = [f"{archived[1]}{letter}{archived[2]}" for letter in "dijk"]
    else:
        raise Refusal(
            "is not named as NDBC names its densities, so the files of directions beside it are not found; "
            "name it 46042.data_spec, 46042w2019.txt or with swden in it"
        )
    beside = [path.with_name(name) for name in names]
    absent = [file.name for file in beside if not file.is_file()]
    if absent:
        raise Refusal(f"has no directions in it, nor {', '.join(absent)} beside it; put NDBC's directional files there")
    return beside
