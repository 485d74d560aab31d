"""Exported ground maps lie where they belong: read back by other libraries, against the geodesic."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
import xarray as xr
from pyproj import CRS, Geod, Transformer

import seamap_rt as sr
from seamap_rt.dataset import build
from seamap_rt.io.exports import FIELDS, Origin, headings

AT = (54.32, -7.5)
SIDE, CELL = 41, 25.0
NORTH_EAST = 3.25  # m: the height of the one cell that is marked


def maps(turns: int = 2) -> xr.DataTree:
    """Heights that grow towards east and, less, towards north; nothing is known in the west; the boat goes north."""
    axis = CELL * (np.arange(SIDE) - SIDE // 2)
    y, x = np.meshgrid(axis, axis, indexing="ij")
    height = np.where(x < -300.0, np.nan, 1e-3 * x + 1e-4 * y)
    height[-1, -1] = NORTH_EAST
    each = np.broadcast_to(height, (turns, SIDE, SIDE))
    ground = build(
        "maps/ground",
        {name: each * (1.0 + place) for place, name in enumerate(FIELDS)}
        | {"time": np.where(np.isnan(each), each, 7.0)},
        {"turn": np.arange(turns), "y": axis, "x": axis},
        {"cell_m": CELL},
    )
    looks = {"turn": np.arange(turns), "azimuth": [0.0, 180.0], "range": [10.0]}
    empty = np.full((turns, 2, 1), np.nan)
    fields = ("height", "height_std", "slope_range", "slope_azimuth", "ground_range", "coherence", "phase", "snr_db")
    place = np.zeros((turns, 2))
    polar = build(
        "maps/polar",
        dict.fromkeys((*fields, "phase_unwrapped"), empty)
        | {"quality": np.zeros(empty.shape), "time": place}
        | {"antenna_x": place, "antenna_y": place + 100.0 * np.arange(turns)[:, None]},
        looks,
    )
    return xr.DataTree.from_dict({"/polar": polar, "/ground": ground})


@pytest.mark.parametrize("at", [AT, (-33.9, 18.4), (0.0, 180.0), (78.0, -15.0)])
def test_latitude_and_longitude_are_those_of_the_geodesic(at: tuple[float, float]) -> None:
    """Distance and azimuth from the origin by Karney's geodesic, another algorithm: 1 mm at 500 m and 10 km."""
    for distance in (500.0, 10e3):
        azimuth = np.arange(0.0, 360.0, 30.0)
        x, y = distance * np.sin(np.radians(azimuth)), distance * np.cos(np.radians(azimuth))
        latitude, longitude = Origin(*at).places(x, y)
        start = np.full(azimuth.size, at[1]), np.full(azimuth.size, at[0])
        there, _, off = Geod(ellps="WGS84").inv(*start, longitude, latitude)
        np.testing.assert_allclose(off, distance, atol=1e-3, rtol=0.0)
        across = distance * np.radians((np.asarray(there) - azimuth + 180.0) % 360.0 - 180.0)
        np.testing.assert_allclose(across, 0.0, atol=1e-3)


def test_cfradial_holds_the_polar_maps_of_the_turns_that_are_asked_for(tmp_path: Path) -> None:
    """And the place of the maps' origin; the ending alone means the ground maps."""
    (file,) = sr.export(maps(3), tmp_path / "polar.nc", AT, kind="cfradial", turns=[1, 2])
    read, given = sr.read_radial_volume(file), maps(3)["polar"].to_dataset()
    np.testing.assert_array_equal(read["turn"].values, [1, 2])
    np.testing.assert_array_equal(read["antenna_y"].values, given["antenna_y"].values[1:])
    with xr.open_dataset(file) as volume:
        assert (float(volume["latitude"]), float(volume["longitude"])) == AT


def test_netcdf_is_cf_and_holds_the_place(tmp_path: Path) -> None:
    (file,) = sr.export(maps(), tmp_path / "ground.nc", AT, heading_deg=[10.0, 370.0])
    with xr.open_dataset(file, decode_coords="all") as read:
        assert read["height"].encoding["grid_mapping"] == "crs"
        crs = CRS.from_cf(read["crs"].attrs)
        back = Transformer.from_crs("EPSG:4326", crs, always_xy=True).transform(read["lon"].values, read["lat"].values)
        x, y = np.meshgrid(read["x"].values, read["y"].values)
        np.testing.assert_allclose(back, [x, y], atol=1e-3)
        np.testing.assert_array_equal(read["height"].values, maps()["ground"].to_dataset()["height"].values)
        *_, north = Geod(ellps="WGS84").inv(AT[1], AT[0], read["antenna_longitude"][1], read["antenna_latitude"][1])
        assert north == pytest.approx(100.0, abs=1e-3)
        np.testing.assert_allclose(read["heading"].values, 10.0)
        for name, standard in (("lat", "latitude"), ("lon", "longitude"), ("heading", "platform_orientation")):
            assert read[name].attrs["standard_name"] == standard


def test_a_north_east_cell_lies_north_east_in_the_picture(tmp_path: Path) -> None:
    """By the tags: pixel (0, 0) is the north-west corner, and scale and tie point lead to the cell's middle."""
    first, second = sr.export(maps(), tmp_path / "ground.tif", AT, heading_deg=45.0)
    assert [first.name, second.name] == ["ground-0.tif", "ground-1.tif"]
    with tifffile.TiffFile(first) as file:
        tags: dict[int, Any] = {code: file.pages.first.tags[code].value for code in (33550, 33922, 42112, 42113)}
        bands, geo = file.asarray(), file.geotiff_metadata or {}
    assert bands.shape == (len(FIELDS), SIDE, SIDE)
    row, column = np.argwhere(bands[0] == np.float32(NORTH_EAST))[0]
    (scale_x, scale_y, _), (_, _, _, west, north, _) = (tags[code] for code in (33550, 33922))
    assert (row, column) == (0, SIDE - 1)
    assert west + (column + 0.5) * scale_x == pytest.approx(CELL * (SIDE // 2))
    assert north - (row + 0.5) * scale_y == pytest.approx(CELL * (SIDE // 2))
    np.testing.assert_array_equal(bands[0, ::-1], maps()["ground"].to_dataset()["height"].values[0])
    assert np.isnan(bands[0, :, 0]).all()
    assert tags[42113] == "nan"
    assert (int(geo["ProjectedCSTypeGeoKey"]), int(geo["ProjCoordTransGeoKey"])) == (32767, 12)
    assert (geo["ProjCenterLatGeoKey"], geo["ProjCenterLongGeoKey"]) == AT
    assert '<Item name="heading_deg">45.0</Item>' in tags[42112]
    assert 'sample="1" role="description">height_std' in tags[42112]


def test_csv_holds_the_known_cells_alone(tmp_path: Path) -> None:
    (file,) = sr.export(maps(), tmp_path / "ground.csv", "54.32,-7.5", turns=[1])
    with file.open(newline="") as opened:
        rows = list(csv.DictReader(opened))
    known = np.isfinite(maps()["ground"].to_dataset()["height"].values[1])
    assert len(rows) == np.count_nonzero(known)
    assert {row["turn"] for row in rows} == {"1"}
    corner = next(row for row in rows if float(row["height_m"]) == NORTH_EAST)
    x, y = float(corner["x_m"]), float(corner["y_m"])
    assert x == y == CELL * (SIDE // 2)
    azimuth, _, distance = Geod(ellps="WGS84").inv(
        AT[1], AT[0], float(corner["longitude_deg"]), float(corner["latitude_deg"])
    )
    assert (azimuth, distance) == (pytest.approx(45.0, abs=1e-3), pytest.approx(np.hypot(x, y), abs=2e-3))
    assert float(corner["slope_y"]) == pytest.approx(4.0 * NORTH_EAST)
    assert corner["heading_deg"] == "nan"  # not known


def test_headings_are_circular_means_of_each_turn() -> None:
    yaw = np.array([350.0, 10.0, 90.0, 90.0, np.nan])
    echoes = xr.Dataset(
        {"attitude": (("pulse", "rpy"), np.stack((0 * yaw, 0 * yaw, yaw), 1)), "turn": ("pulse", [0, 0, 1, 1, 1])}
    )
    found = headings(echoes, [0, 1])
    np.testing.assert_allclose((found + 180.0) % 360.0, [180.0, 270.0])


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"at": (91.0, 0.0)}, "latitude = 91"),
        ({"at": (0.0, float("nan"))}, "longitude = nan"),
        ({"at": "54"}, "must be LAT,LON"),
        ({"at": "north,7"}, "must be LAT,LON"),
        ({"path": "ground.shp"}, "kind = '.shp'"),
        ({"path": "nowhere/ground.nc"}, "does not exist"),
        ({"turns": [5]}, "the maps' `turn` is 0 to 1"),
        ({"heading_deg": [1.0, 2.0, 3.0]}, "each of 2 turns"),
        ({"heading_deg": float("inf")}, "finite"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_line(tmp_path: Path, given: dict[str, Any], words: str) -> None:
    arguments = {"path": "ground.nc", "at": AT} | given
    arguments["path"] = tmp_path / arguments["path"]
    with pytest.raises(sr.InputError, match=words) as refused:
        sr.export(maps(), **arguments)
    assert "\n" not in str(refused.value)
    assert not list(tmp_path.iterdir())
