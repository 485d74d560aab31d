"""Writes the small spectrum files beside it: one known sea in the formats of buoys and wave models.

The layouts follow the formats' own documentation, not a library's writer: SWAN's user manual, appendix on spectrum
files; NDBC's "Measurement Descriptions and Units"; and the header that WAVEWATCH III's ww3_ounp gives its NetCDF.
`python tests/io/spectra/make.py` writes them anew; a test compares them with what this writes.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.io import netcdf_file
from scipy.special import gamma

FREQUENCY_HZ: NDArray[np.float64] = np.round(0.05 * 1.12 ** np.arange(20.0), 4)
FROM_DEG = np.arange(0.0, 360.0, 15.0)
PEAK_HZ, EXPONENT = 0.125, 8.0
TIMES = ("2024-05-01T12:00", "2024-05-01T15:00")
SEAS = {  # (time, site): height of the whole spectrum (m) and the azimuth it comes from (deg)
    (0, 0): (2.0, 300.0),
    (1, 0): (3.0, 330.0),
    (0, 1): (1.0, 45.0),
    (1, 1): (0.5, 60.0),
}


def energy(height: float) -> NDArray[np.float64]:
    """Pierson–Moskowitz's shape, m²/Hz, of a significant height."""
    f = FREQUENCY_HZ
    return np.asarray(5.0 * (height / 4.0) ** 2 * PEAK_HZ**4 * f**-5 * np.exp(-1.25 * (PEAK_HZ / f) ** 4))


def density(height: float, from_deg: float) -> NDArray[np.float64]:
    """m²/(Hz·degree), (frequency, direction), spread as cos^2s(θ/2)."""
    half = np.radians(FROM_DEG - from_deg) / 2.0
    peak = gamma(EXPONENT + 1.0) / (2.0 * np.sqrt(np.pi) * gamma(EXPONENT + 0.5))
    return energy(height)[:, None] * peak * np.cos(half) ** (2.0 * EXPONENT) * np.pi / 180.0


def write_all(folder: Path) -> None:
    """All files, into a folder."""
    write_swan(folder / "swan.spc")
    write_swan_stationary(folder / "swan_stationary.spc")
    write_swan_one_dimensional(folder / "swan_1d.spc")
    write_ww3(folder / "ww3.nc")
    write_ndbc_realtime(folder, "46042")
    write_ndbc_archive(folder, "46042")
    write_ndbc_netcdf(folder / "ndbc.nc")


# ------------------------------------------------------------------------------------------------------------- SWAN


def swan_header(locations: str, directions: str, angles: NDArray[np.float64], timed: bool) -> list[str]:
    lines = ["SWAN   1                                Swan standard spectral file, version", "$   a known sea"]
    if timed:
        lines += [f"{'TIME':40}time-dependent data", f"{1:6d}{'':34}time coding option"]
    lines += [locations, f"{2:6d}{'':34}number of locations", "  -122.4000   36.8000", "  -122.2000   36.8000"]
    lines += [f"{'RFREQ':40}relative frequencies in Hz", f"{FREQUENCY_HZ.size:6d}{'':34}number of frequencies"]
    lines += [f"{f:10.4f}" for f in FREQUENCY_HZ]
    lines += [directions, f"{angles.size:6d}{'':34}number of directions"]
    lines += [f"{angle:10.4f}" for angle in angles]
    lines += ["QUANT", f"{1:6d}{'':34}number of quantities in table"]
    lines += [f"{'VaDens':40}variance densities in m2/Hz/degr", f"{'m2/Hz/degr':40}unit"]
    return [*lines, f"{'   -0.9900E+02':40}exception value"]


def swan_block(table: NDArray[np.float64]) -> list[str]:
    factor = table.max() / 99_000.0
    rows = np.rint(table / factor).astype(int)
    return ["FACTOR", f"{factor:18.8E}", *("".join(f"{value:7d}" for value in row) for row in rows)]


def write_swan(path: Path) -> None:
    """Two times and places; nautical directions, descending and some below zero, as SWAN writes them."""
    nautical = np.where(FROM_DEG > 262.5, FROM_DEG - 360.0, FROM_DEG)
    order = np.argsort(nautical)[::-1]
    lines = swan_header(
        f"{'LONLAT':40}locations in spherical coordinates",
        f"{'NDIR':40}spectral nautical directions in degr",
        nautical[order],
        timed=True,
    )
    for t, stamp in enumerate(("20240501.120000", "20240501.150000")):
        lines.append(f"{stamp:40}date and time")
        for site in (0, 1):
            lines += swan_block(density(*SEAS[t, site])[:, order])
    path.write_text("\n".join(lines) + "\n")


def write_swan_stationary(path: Path) -> None:
    """No time; Cartesian directions that waves go to, anticlockwise from east; one value missing, one place on land."""
    cartesian = np.arange(0.0, 360.0, 15.0)  # 270° − nautical
    columns = [int(np.flatnonzero((270.0 - angle) % 360.0 == FROM_DEG)[0]) for angle in cartesian]
    lines = swan_header(
        f"{'LOCATIONS':40}locations in x-y-space",
        f"{'CDIR':40}spectral Cartesian directions in degr",
        cartesian,
        timed=False,
    )
    block = swan_block(density(*SEAS[0, 0])[:, columns])
    block[2] = f"{-99:7d}" + block[2][7:]  # the exception value
    path.write_text("\n".join([*lines, *block, "NODATA"]) + "\n")


def write_swan_one_dimensional(path: Path) -> None:
    """SWAN's other table: mean direction and spread of each frequency, no directions."""
    lines = swan_header("LOCATIONS", "", np.zeros(0), timed=False)
    at = lines.index("")
    lines[at : at + 2] = []
    at = lines.index("QUANT")
    lines[at:] = ["QUANT", "     3", "VaDens", "m2/Hz", "   -0.9900E+02", "NDIR", "degr", "   -0.9990E+03"]
    lines += ["DSPRDEGR", "degr", "   -0.9000E+01"]
    for site in (1, 2):
        lines += [f"LOCATION {site:6d}", *(f"{e:12.4E}{300.0:8.1f}{26.0:8.1f}" for e in energy(2.0))]
    path.write_text("\n".join(lines) + "\n")


# ---------------------------------------------------------------------------------------------------- WAVEWATCH III


def write_ww3(path: Path) -> None:
    """m² s/rad by the direction waves go to, clockwise from north, starting at 90° and descending."""
    toward = (90.0 - FROM_DEG) % 360.0
    columns = [int(np.flatnonzero((angle + 180.0) % 360.0 == FROM_DEG)[0]) for angle in toward]
    days = [(np.datetime64(t) - np.datetime64("1990-01-01T00:00")) / np.timedelta64(1, "D") for t in TIMES]
    table = np.array([[density(*SEAS[t, s])[:, columns] * 180.0 / np.pi for s in (0, 1)] for t in (0, 1)])
    names = np.array([list(name.ljust(16)) for name in ("46042", "46240")], dtype="S1")
    with netcdf_file(path, "w") as file:
        for name, size in (("time", 2), ("station", 2), ("string16", 16), ("frequency", 20), ("direction", 24)):
            file.createDimension(name, size)
        variables = (
            ("time", "d", ("time",), days, "julian day (UT)", "days since 1990-01-01 00:00:00"),
            ("station", "i", ("station",), [1, 2], "station id", None),
            ("string16", "i", ("string16",), np.zeros(16), "station_name number of characters", None),
            ("station_name", "c", ("station", "string16"), names, "station name", None),
            ("longitude", "f", ("time", "station"), [[-122.4, -122.2]] * 2, "longitude", "degree_east"),
            ("latitude", "f", ("time", "station"), [[36.8, 36.8]] * 2, "latitude", "degree_north"),
            ("frequency", "f", ("frequency",), FREQUENCY_HZ, "frequency of center band", "s-1"),
            ("frequency1", "f", ("frequency",), FREQUENCY_HZ / 1.06, "frequency of lower band", "s-1"),
            ("frequency2", "f", ("frequency",), FREQUENCY_HZ * 1.06, "frequency of upper band", "s-1"),
            ("direction", "f", ("direction",), toward, "sea surface wave to direction", "degree"),
            (
                "efth",
                "f",
                ("time", "station", "frequency", "direction"),
                table,
                "sea surface wave directional variance spectral density",
                "m2 s rad-1",
            ),
            ("dpt", "f", ("time", "station"), [[1600.0, 60.0]] * 2, "depth", "m"),
            ("wnd", "f", ("time", "station"), [[9.0, 5.0]] * 2, "wind speed at 10m", "m s-1"),
            ("wnddir", "f", ("time", "station"), [[300.0, 45.0]] * 2, "wind direction", "degree"),
        )
        for name, kind, dimensions, values, long_name, units in variables:
            variable = file.createVariable(name, kind, dimensions)
            variable[:] = np.asarray(values)
            variable.long_name = long_name
            if units:
                variable.units = units
        file.variables["direction"].standard_name = "sea_surface_wave_to_direction"
        file.variables["efth"].scale_factor = np.float32(1.0)
        file.variables["efth"]._FillValue = np.float32(9.96921e36)
        file.product_name = "ww3.202405_spec.nc"


# -------------------------------------------------------------------------------------------------------------- NDBC


def ndbc_moments(sea: tuple[float, float]) -> dict[str, NDArray[np.float64]]:
    """What a buoy reports of a sea spread as cos^2s(θ/2): energy, two directions, two lengths."""
    height, from_deg = sea
    s = EXPONENT
    r1, r2 = s / (s + 1.0), s * (s - 1.0) / ((s + 1.0) * (s + 2.0))
    ones = np.ones(FREQUENCY_HZ.size)
    return {"w": energy(height), "d": from_deg * ones, "i": from_deg * ones, "j": r1 * ones, "k": r2 * ones}


def write_ndbc_realtime(folder: Path, station: str) -> None:
    """The last 45 days: newest first, each value followed by its frequency; 999 where no direction was found."""
    suffixes = {"w": "data_spec", "d": "swdir", "i": "swdir2", "j": "swr1", "k": "swr2"}
    heads = {"w": "spec", "d": "alpha1", "i": "alpha2", "j": "r1", "k": "r2"}
    for letter, suffix in suffixes.items():
        head = heads[letter]
        lines = [
            f"#YY  MM DD hh mm {'Sep_Freq  < ' if letter == 'w' else ''}"
            f"{head}_1 (freq_1) {head}_2 (freq_2) {head}_3 (freq_3) ... >"
        ]
        for t, stamp in ((1, "2024 05 01 15 00"), (0, "2024 05 01 12 00")):
            values = ndbc_moments(SEAS[t, 0])[letter].copy()
            if letter != "w":
                values[-1] = 999.0
            form = "{:.6f}" if letter in "wjk" else "{:.1f}"
            cells = " ".join(f"{form.format(v)} ({f:.4f})" for v, f in zip(values, FREQUENCY_HZ, strict=True))
            lines.append(f"{stamp} {'9.999 ' if letter == 'w' else ''}{cells} ")
        (folder / f"{station}.{suffix}").write_text("\n".join(lines) + "\n")


def write_ndbc_archive(folder: Path, station: str) -> None:
    """A year's archive: oldest first, frequencies in the head, r1 and r2 in hundredths, nines for what is missing."""
    for letter in "wdijk":
        head = "#YY  MM DD hh mm " + " ".join(f"{f:7.4f}".replace("0.", " .") for f in FREQUENCY_HZ)
        lines = [head]
        for t, stamp in ((0, "2024 05 01 12 00"), (1, "2024 05 01 15 00")):
            values = ndbc_moments(SEAS[t, 0])[letter] * (100.0 if letter in "jk" else 1.0)
            lines.append(stamp + "".join(f"{value:9.4f}" for value in values))
        lines.append("2024 05 01 16 00" + "".join(f"{999.0:9.4f}" for _ in FREQUENCY_HZ))
        (folder / f"{station}{letter}2024.txt").write_text("\n".join(lines) + "\n")


def write_ndbc_netcdf(path: Path) -> None:
    """As on NDBC's THREDDS server."""
    seconds = [(np.datetime64(t) - np.datetime64("1970-01-01T00:00")) / np.timedelta64(1, "s") for t in TIMES]
    names = {
        "w": ("spectral_wave_density", "(meter * meter)/Hz"),
        "d": ("mean_wave_dir", "degrees_true"),
        "i": ("principal_wave_dir", "degrees_true"),
        "j": ("wave_spectrum_r1", "1"),
        "k": ("wave_spectrum_r2", "1"),
    }
    with netcdf_file(path, "w") as file:
        for name, size in (("time", 2), ("frequency", 20), ("latitude", 1), ("longitude", 1)):
            file.createDimension(name, size)
        axes = (
            ("time", seconds, "seconds since 1970-01-01 00:00:00 UTC"),
            ("frequency", FREQUENCY_HZ, "Hz"),
            ("latitude", [36.8], "degrees_north"),
            ("longitude", [-122.4], "degrees_east"),
        )
        for name, values, units in axes:
            variable = file.createVariable(name, "i" if name == "time" else "f", (name,))
            variable[:] = np.asarray(values)
            variable.units = units
        for letter, (name, units) in names.items():
            variable = file.createVariable(name, "f", ("time", "frequency", "latitude", "longitude"))
            variable[:] = np.array([ndbc_moments(SEAS[t, 0])[letter] for t in (0, 1)])[:, :, None, None]
            variable.units = units
            variable._FillValue = np.float32(999.0)


if __name__ == "__main__":
    write_all(Path(__file__).parent)
