"""Spectrum files in the formats of buoys and models give back the sea they were made from, or one line of error."""

from __future__ import annotations

import gzip
import importlib.util
import re
import shutil
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray
from scipy.io import netcdf_file

from seamap_rt.errors import InputError
from seamap_rt.io.spectrumfile import DirectionalTable, read_directional_spectrum

FOLDER = Path(__file__).parent / "spectra"
DIRECTIONAL = ("swan.spc", "swan_stationary.spc", "ww3.nc", "46042.data_spec", "46042w2024.txt", "ndbc.nc")
TIMED = tuple(name for name in DIRECTIONAL if name != "swan_stationary.spc")
KIND = {"swan.spc": "swan", "ww3.nc": "ww3", "46042.data_spec": "ndbc", "46042w2024.txt": "ndbc", "ndbc.nc": "ndbc"}


def load_maker() -> ModuleType:
    specification = importlib.util.spec_from_file_location("make_spectra", FOLDER / "make.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


MAKER = load_maker()


def bin_width(table: DirectionalTable) -> float:
    return 360.0 / table.from_deg.size


def energy(table: DirectionalTable) -> NDArray[np.float64]:
    return table.density.sum(axis=1) * bin_width(table)


def mean_from_deg(table: DirectionalTable) -> float:
    mean = np.sum(table.density * np.exp(1j * np.radians(table.from_deg)))
    return float(np.degrees(np.angle(mean)) % 360.0)


def refusal(path: Path, **how: object) -> str:
    with pytest.raises(InputError) as caught:
        read_directional_spectrum(path, **how)  # type: ignore[arg-type]
    line = str(caught.value)
    assert "\n" not in line
    assert ";" in line  # what to do about it
    return line


def test_the_files_are_what_the_script_writes(tmp_path: Path) -> None:
    MAKER.write_all(tmp_path)
    for file in tmp_path.iterdir():
        assert file.read_bytes() == (FOLDER / file.name).read_bytes(), file.name


# ------------------------------------------------------------------------------------------------ the sea recovered


@pytest.mark.parametrize("name", DIRECTIONAL)
def test_height_period_and_direction_are_recovered(name: str) -> None:
    table = read_directional_spectrum(FOLDER / name)
    # The archive prints energies to 5e-5 m²/Hz, of up to 3; SWAN's whole numbers are 1e-5 of the largest apart.
    np.testing.assert_allclose(table.frequency_hz, MAKER.FREQUENCY_HZ, rtol=1e-6)
    np.testing.assert_allclose(energy(table), MAKER.energy(2.0), rtol=1e-4, atol=1e-4)
    hs = 4.0 * np.sqrt(np.trapezoid(energy(table), table.frequency_hz))
    # The trapezoid on 20 frequencies, up to 0.43 Hz, and the tail that is not there.
    np.testing.assert_allclose(hs, 2.0, rtol=0.01)
    assert np.argmax(energy(table)) == np.argmin(np.abs(MAKER.FREQUENCY_HZ - MAKER.PEAK_HZ))
    # Nothing else is at 300°: not the mirror image (60°), not where they go to (120°), not the other's (240°, 150°).
    np.testing.assert_allclose(mean_from_deg(table), 300.0, atol=1e-3)


@pytest.mark.parametrize("name", ["swan.spc", "swan_stationary.spc", "ww3.nc"])
def test_a_model_gives_back_every_value(name: str) -> None:
    table = read_directional_spectrum(FOLDER / name)
    expected = MAKER.density(*MAKER.SEAS[0, 0])
    np.testing.assert_array_equal(table.from_deg, MAKER.FROM_DEG)
    # SWAN: half of 1/99000 of the largest value, and one small value that its file calls missing.
    np.testing.assert_allclose(table.density, expected, rtol=1e-6, atol=6e-6 * expected.max())


@pytest.mark.parametrize("name", ["46042.data_spec", "46042w2024.txt", "ndbc.nc"])
def test_a_buoy_keeps_its_two_harmonics(name: str) -> None:
    table = read_directional_spectrum(FOLDER / name)
    peak = int(np.argmax(energy(table)))
    share = table.density[peak] / energy(table)[peak] * bin_width(table)
    angle = np.radians(table.from_deg - 300.0)
    r1, r2 = (MAKER.ndbc_moments(MAKER.SEAS[0, 0])[letter][0] for letter in "jk")
    # The penalty takes 1e-6 of multipliers of order ten.
    np.testing.assert_allclose(
        [np.sum(share * np.cos(angle)), np.sum(share * np.cos(2.0 * angle))], [r1, r2], atol=5e-5
    )
    np.testing.assert_allclose([np.sum(share * np.sin(angle)), np.sum(share * np.sin(2.0 * angle))], 0.0, atol=5e-5)
    # Of all with these harmonics the most even one is near the cos^16(θ/2) that they come from, with one peak as well.
    true = np.cos(angle / 2.0) ** (2.0 * MAKER.EXPONENT)
    np.testing.assert_allclose(share / share.max(), true / true.max(), atol=0.03)
    assert np.count_nonzero((share > np.roll(share, 1)) & (share >= np.roll(share, -1))) == 1


def test_harmonics_that_no_density_has_still_give_one(tmp_path: Path) -> None:
    for name in ("46042.data_spec", "46042.swdir", "46042.swdir2"):
        shutil.copy(FOLDER / name, tmp_path)
    for name, value in (("46042.swr1", "1.0000"), ("46042.swr2", "0.0000")):
        text = (FOLDER / name).read_text().splitlines()
        words = [[word if word[0] == "(" or i < 5 else value for i, word in enumerate(line.split())] for line in text]
        (tmp_path / name).write_text("\n".join([text[0], *(" ".join(line) for line in words[1:])]) + "\n")
    table = read_directional_spectrum(tmp_path / "46042.data_spec")
    np.testing.assert_allclose(energy(table)[:-1], MAKER.energy(2.0)[:-1], rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(mean_from_deg(table), 300.0, atol=0.1)


@pytest.mark.parametrize("name", TIMED)
def test_the_nearest_time_is_taken(name: str) -> None:
    for wanted, height, direction in (
        ("2024-05-01T13:29", 2.0, 300.0),
        ("2024-05-01T14:29:00Z", 3.0, 330.0),
        ("2024-05-01T16:29+02:00", 3.0, 330.0),
    ):
        table = read_directional_spectrum(FOLDER / name, time=wanted)
        np.testing.assert_allclose(energy(table), MAKER.energy(height), rtol=1e-4, atol=1e-4)
        np.testing.assert_allclose(mean_from_deg(table), direction, atol=1e-3)
        assert f"2024-05-01T{'12' if height == 2.0 else '15'}:00:00" in table.source
        assert name in table.source


@pytest.mark.parametrize("name", ["swan.spc", "ww3.nc"])
def test_the_second_station_is_another_sea(name: str) -> None:
    for t, wanted in enumerate(MAKER.TIMES):
        table = read_directional_spectrum(FOLDER / name, time=wanted, site=1)
        expected = MAKER.density(*MAKER.SEAS[t, 1])
        np.testing.assert_allclose(table.density, expected, rtol=1e-6, atol=6e-6 * expected.max())
        assert "site 1" in table.source


def test_a_kind_may_be_named_and_a_file_packed(tmp_path: Path) -> None:
    for name, kind in KIND.items():
        named, told = (read_directional_spectrum(FOLDER / name, kind=how) for how in ("auto", kind))
        np.testing.assert_array_equal(named.density, told.density)
    for file in FOLDER.glob("*.???"):
        (tmp_path / f"{file.name}.gz").write_bytes(gzip.compress(file.read_bytes()))
    for name in ("swan.spc", "46042w2024.txt"):  # NDBC's archive comes packed
        plain, packed = (read_directional_spectrum(file) for file in (FOLDER / name, tmp_path / f"{name}.gz"))
        np.testing.assert_array_equal(packed.density, plain.density)


def test_lengths_are_hundredths_only_where_most_are(tmp_path: Path) -> None:
    for file in FOLDER.glob("46042.*"):
        shutil.copy(file, tmp_path)
    text = (FOLDER / "46042.swr1").read_text()
    right = read_directional_spectrum(FOLDER / "46042.data_spec").density
    row = int(np.argmax(right.sum(axis=1)))
    at = f"({MAKER.FREQUENCY_HZ[row]:.4f})"
    (tmp_path / "46042.swr1").write_text(text.replace(f"0.888889 {at}", f"9.990000 {at}"))
    wrong = read_directional_spectrum(tmp_path / "46042.data_spec").density
    np.testing.assert_allclose(wrong[row], right[row].mean(), rtol=1e-12)  # no length: no direction
    np.testing.assert_allclose(np.delete(wrong, row, 0), np.delete(right, row, 0), rtol=1e-12)
    (tmp_path / "46042.swr1").write_text(text.replace("0.888889", "999.0").replace(f"999.0 {at}", f"0.888889 {at}"))
    np.testing.assert_allclose(
        read_directional_spectrum(tmp_path / "46042.data_spec").density[row], right[row], rtol=1e-9
    )


def test_frequencies_without_directions_are_spread_evenly() -> None:
    # In the realtime files the last frequency has no directions: nines.
    last = read_directional_spectrum(FOLDER / "46042.data_spec").density[-1]
    np.testing.assert_allclose(last, MAKER.energy(2.0)[-1] / 360.0, rtol=1e-4)


def test_wavespectra_own_netcdf(tmp_path: Path) -> None:
    values = MAKER.density(2.0, 300.0)
    values[3, 5] = np.nan
    # 0 and 360 are one direction; the order is not the file's business.
    around = np.append(MAKER.FROM_DEG, 360.0)[::-1]
    dataset = xr.Dataset(
        {"efth": (("freq", "dir"), np.append(values, values[:, :1], axis=1)[::-1, ::-1])},
        {"freq": MAKER.FREQUENCY_HZ[::-1], "dir": around},
    )
    dataset.to_netcdf(tmp_path / "own.nc", engine="h5netcdf")
    table = read_directional_spectrum(tmp_path / "own.nc", kind="wavespectra")
    values[3, 5] = 0.0
    np.testing.assert_array_equal(table.from_deg, MAKER.FROM_DEG)
    np.testing.assert_array_equal(table.frequency_hz, MAKER.FREQUENCY_HZ)
    np.testing.assert_array_equal(table.density, values)


# ------------------------------------------------------------------------------------------------------ one line


def test_what_is_no_spectrum_is_said_in_one_line(tmp_path: Path) -> None:
    assert "no such file" in refusal(tmp_path / "absent.spc")
    assert "folder" in refusal(tmp_path)
    (tmp_path / "scene.toml").write_text("[sea]\n")
    line = refusal(tmp_path / "scene.toml")
    assert all(kind in line for kind in ("ndbc", "swan", "ww3", "wavespectra"))
    (tmp_path / "empty").write_bytes(b"")
    assert "no spectrum" in refusal(tmp_path / "empty")
    (tmp_path / "cut.nc").write_bytes((FOLDER / "ww3.nc").read_bytes()[:100])
    assert "no spectrum" in refusal(tmp_path / "cut.nc")
    xr.Dataset({"sst": ("x", [1.0, 2.0])}).to_netcdf(tmp_path / "sst.nc", engine="h5netcdf")
    assert "no spectrum" in refusal(tmp_path / "sst.nc")
    assert "of the kind swan but ww3" in refusal(FOLDER / "ww3.nc", kind="swan")
    assert "of the kind sawn" in refusal(FOLDER / "swan.spc", kind="sawn")


def test_no_directions_is_said_in_one_line(tmp_path: Path) -> None:
    assert "no directions" in refusal(FOLDER / "swan_1d.spc")
    shutil.copy(FOLDER / "46042.data_spec", tmp_path)
    assert "46042.swdir" in refusal(tmp_path / "46042.data_spec")
    for name in ("swdir", "swdir2", "swr1", "swr2"):
        text = (FOLDER / f"46042.{name}").read_text().splitlines()
        words = [[word if word[0] == "(" or i < 5 else "999.0" for i, word in enumerate(line.split())] for line in text]
        (tmp_path / f"46042.{name}").write_text("\n".join([text[0], *(" ".join(line) for line in words[1:])]) + "\n")
    assert "no directions" in refusal(tmp_path / "46042.data_spec")
    shutil.copy(FOLDER / "46042.data_spec", tmp_path / "buoy.txt")
    assert "named" in refusal(tmp_path / "buoy.txt")
    with xr.open_dataset(FOLDER / "ndbc.nc") as file:
        file.drop_vars("wave_spectrum_r1").to_netcdf(tmp_path / "ndbc_1d.nc", engine="h5netcdf")
    assert "no directions" in refusal(tmp_path / "ndbc_1d.nc")
    one = xr.Dataset({"efth": ("freq", MAKER.energy(1.0))}, {"freq": MAKER.FREQUENCY_HZ})
    one.to_netcdf(tmp_path / "own_1d.nc", engine="h5netcdf")
    assert "no directions" in refusal(tmp_path / "own_1d.nc")


def test_times_and_sites_that_are_not_there() -> None:
    for name in TIMED:
        line = refusal(FOLDER / name, time="2024-06-01T00:00")
        assert "2024-05-01T12:00" in line
        assert "site = 2" in refusal(FOLDER / name, site=2)
        assert "site = -1" in refusal(FOLDER / name, site=-1)
    assert "is not a time" in refusal(FOLDER / "ww3.nc", time="noon")
    assert "leave time out" in refusal(FOLDER / "swan_stationary.spc", time="2024-05-01")


def test_nothing_but_missing_values(tmp_path: Path) -> None:
    assert "no number" in refusal(FOLDER / "swan_stationary.spc", site=1)  # SWAN's NODATA: a place on land
    assert "no number" in refusal(FOLDER / "46042w2024.txt", time="2024-05-01T16:00")  # nines
    shutil.copy(FOLDER / "ww3.nc", tmp_path)
    with netcdf_file(tmp_path / "ww3.nc", "a", mmap=False) as file:
        file.variables["efth"][0, 0] = 9.96921e36
    assert "no number" in refusal(tmp_path / "ww3.nc")


def test_a_damaged_file_is_said_in_one_line(tmp_path: Path) -> None:
    lines = (FOLDER / "swan.spc").read_text().splitlines()
    for count in (20, 60, len(lines) - 30):
        (tmp_path / "cut.spc").write_text("\n".join(lines[:count]) + "\n")
        assert "cut.spc" in refusal(tmp_path / "cut.spc")
    at = lines.index("FACTOR") + 9
    (tmp_path / "torn.spc").write_text("\n".join([*lines[:at], lines[at][:50], *lines[at + 1 :]]) + "\n")
    assert "damaged" in refusal(tmp_path / "torn.spc")
    text = (FOLDER / "46042w2024.txt").read_text()
    for letter in "dijk":
        shutil.copy(FOLDER / f"46042{letter}2024.txt", tmp_path)
    (tmp_path / "46042w2024.txt").write_text(text.replace(" 0.0000 ", " O.OOOO ", 1))
    assert "damaged" in refusal(tmp_path / "46042w2024.txt")


def test_a_fill_value_that_no_one_declared_is_no_calm(tmp_path: Path) -> None:
    values = MAKER.density(2.0, 300.0)
    values[0, 0] = -0.009 * values.max()  # an interpolation's undershoot is none

    def written() -> Path:
        dataset = xr.Dataset({"efth": (("freq", "dir"), values)}, {"freq": MAKER.FREQUENCY_HZ, "dir": MAKER.FROM_DEG})
        dataset.to_netcdf(tmp_path / "spectrum.nc", engine="h5netcdf")
        return tmp_path / "spectrum.nc"

    assert read_directional_spectrum(written()).density.min() == 0.0
    values[0, 0] = -999.0
    assert "holds a density of -999: must be at least 0" in refusal(written())


@pytest.mark.parametrize("word", ["SWAN", "TIME", "LONLAT", "RFREQ", "NDIR", "QUANT", "FACTOR"])
@pytest.mark.parametrize("instead", ["ITER", "", "OTHER"])
def test_a_swan_file_with_another_word_in_its_header_is_refused_in_plain_words(
    word: str, instead: str, tmp_path: Path
) -> None:
    """ITER is what SWAN writes in place of TIME at test points: the iterations of one sea."""
    lines = (FOLDER / "swan.spc").read_text().splitlines()
    first = next(number for number, line in enumerate(lines) if line.startswith(word))
    lines[first] = instead.ljust(len(word)) + lines[first][len(word) :] if instead else ""
    path = tmp_path / "swan.spc"
    path.write_text("\n".join([line for line in lines if line]) + "\n")
    line = refusal(path)
    assert not re.search(r"Error|object is|NoneType|\bbool\b|index out|subscript", line), line
    assert ("iterations" in line) == (instead == "ITER" and word != "SWAN")
