"""CfRadial 2: what is written comes back, and xradar opens it by itself."""

from __future__ import annotations

import errno
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from seamap_rt.dataset import SCHEMA, build
from seamap_rt.errors import InputError
from seamap_rt.io.radial_volume import read_radial_volume, write_radial_volume


def images() -> xr.Dataset:
    random, rays = np.random.default_rng(1), 40
    pulse = np.arange(2 * rays)
    return build(
        "polar_images",
        {
            "video": random.integers(0, 4096, (2 * rays, 30)).astype(np.uint16),
            "heading": np.full(2 * rays, 12.5),
            "latitude": 54.0 + 1e-5 * pulse,
            "longitude": -7.0 + 1e-5 * pulse,
        },
        {
            "pulse": pulse,
            "range": 15.0 + 7.5 * np.arange(30),
            "time": 0.05 * pulse,
            "azimuth": (9.0 * pulse + 100.0) % 360.0,
            "turn": np.repeat([3, 4], rays),
        },
        {"radar": "drawn", "turn_s": 2.0, "start": "2026-01-02T03:04:05+00:00", "ship_speed_m_s": 3.0},
    )


def test_images_come_back_as_they_were(tmp_path: Path) -> None:
    """Times to a nanosecond, which is how they are written; all else exactly."""
    given = images()
    write_radial_volume(tmp_path / "a.nc", given)
    read = read_radial_volume(tmp_path / "a.nc")
    xr.testing.assert_allclose(read, given, rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(read["video"].values, given["video"].values)
    assert read.attrs == given.attrs


def maps() -> xr.Dataset:
    random, shape = np.random.default_rng(2), (2, 24, 10)
    fields = {
        name: random.normal(size=shape).astype(np.float32)
        for name, variable in SCHEMA["maps/polar"].items()
        if variable.required and variable.dims == ("turn", "azimuth", "range") and variable.dtype == "float32"
    }
    looks = np.roll(np.arange(24) / 24.0, 5)  # the turn begins on another look than the first
    return build(
        "maps/polar",
        fields | {"quality": np.zeros(shape, np.int16), "time": np.arange(2)[:, None] + looks},
        {"turn": [0, 1], "azimuth": 15.0 * np.arange(24), "range": 50.0 + 3.0 * np.arange(10)},
        {"height_m": 5.0, "current_m_s": np.array([0.1, 0.2])},
    )


def test_maps_come_back_as_they_were(tmp_path: Path) -> None:
    """Looks in the order of their azimuths again, though rays are written in that of their times."""
    given = maps()
    write_radial_volume(tmp_path / "m.nc", given)
    read = read_radial_volume(tmp_path / "m.nc")
    xr.testing.assert_allclose(read, given, rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(read.attrs["current_m_s"], given.attrs["current_m_s"])


@pytest.mark.filterwarnings("ignore")  # of xradar and what it loads
def test_xradar_opens_what_we_write(tmp_path: Path) -> None:
    xradar_io = pytest.importorskip("xradar.io")
    given = images()
    write_radial_volume(tmp_path / "a.nc", given)
    with xradar_io.open_cfradial2_datatree(tmp_path / "a.nc", engine="h5netcdf") as tree:
        assert sorted(tree.children) == ["sweep_0", "sweep_1"]
        sweep = tree["sweep_1"].to_dataset()
        np.testing.assert_array_equal(sweep["video"].values, given["video"].values[40:])
        assert sweep["time"].values[0] == np.datetime64("2026-01-02T03:04:07")


def test_a_disk_that_is_full_leaves_the_file_that_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.nc"
    path.write_bytes(b"earlier")

    def full(_: xr.DataTree, part: str, **__: object) -> None:
        Path(part).write_bytes(b"half")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(xr.DataTree, "to_netcdf", full)
    with pytest.raises(InputError, match=r"a\.nc': cannot be written \(No space left on device\)"):
        write_radial_volume(path, images())
    assert path.read_bytes() == b"earlier"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_of_others_is_refused_in_one_line(tmp_path: Path) -> None:
    xr.Dataset({"a": 1}).to_netcdf(tmp_path / "b.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="CfRadial 2"):
        read_radial_volume(tmp_path / "b.nc")
