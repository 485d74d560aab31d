"""Records of stereo cameras in the layouts of those who publish them: small files made so, whose waves are known."""

from __future__ import annotations

from pathlib import Path

import h5netcdf
import h5py
import numpy as np
import pytest
import scipy.io
import xarray as xr

from seamap_rt.errors import InputError
from seamap_rt.io.recorded_sea import RecordedSea, recorded_sea

A, KX, KY, OMEGA = 0.4, 0.5, -0.3, 2.0


def wave(x: np.ndarray, y: np.ndarray, t: float | np.ndarray) -> np.ndarray:
    return A * np.cos(KX * x + KY * y - OMEGA * t)


def expected(file: RecordedSea, frame: int, at: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """The wave on the points of a file's patch; at: where its antenna stands."""
    axis = file.spacing_m * np.arange(file.points)
    x, y = np.meshgrid(file.west_m + at[0] + axis, file.south_m + at[1] + axis)
    return wave(x, y, frame * file.step_s)


# ---------------------------------------------------------------------------------------------------- WASS


def wass(
    path: Path, fps: float = 12.0, frames: int = 20, begin: float = 0.0, mask: bool = True, turned: bool = False
) -> Path:
    """As its gridding program lays it out: Z over count, X, Y in mm, chunks of 8 frames; places of all points; time in
    single precision; a trapezoid of the cameras' view, the rest missing; images, and a group with the cameras'
    facts."""
    axis_x, axis_y = 1000.0 * (0.5 * np.arange(60) - 14.0), 1000.0 * (0.5 * np.arange(70) - 60.0)
    x, y = np.meshgrid(axis_x, axis_y)
    seconds = begin + np.arange(frames) / fps
    z = 1000.0 * wave(x / 1000.0, y / 1000.0, (np.arange(frames) / fps)[:, None, None])
    seen = np.abs(x) < 8000.0 + 0.2 * (y - axis_y[0])
    if mask:
        z = np.where(seen, z, np.nan)
    if turned:
        x, y = 0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y
    with h5py.File(path, "w") as file:
        for name, size in (("X", 70), ("Y", 60), ("count", frames)):
            scale = file.create_dataset(name, data=np.arange(size, dtype="u4" if name == "count" else "f4"))
            scale.make_scale(
                name if name == "count" else f"This is a netCDF dimension but not a netCDF variable. {size:9d}"
            )
        for name, values, units in (
            ("X_grid", x, "millimeter"),
            ("Y_grid", y, "millimeter"),
            ("maskZ", seen * 1.0, ""),
        ):
            made = file.create_dataset(name, data=values)
            made.attrs["units"] = units
            made.dims[0].attach_scale(file["X"])
            made.dims[1].attach_scale(file["Y"])
        made = file.create_dataset("Z", data=z.astype("f4"), chunks=(8, 70, 60))
        made.attrs["units"] = "millimeter"
        for number, name in enumerate(("count", "X", "Y")):
            made.dims[number].attach_scale(file[name])
        made = file.create_dataset("time", data=seconds.astype("f4"))
        made.attrs["units"] = "seconds"
        made.dims[0].attach_scale(file["count"])
        file.create_dataset("scale", data=2.5)
        images = file.create_dataset("cam0images", (frames,), dtype=h5py.vlen_dtype(np.uint8))
        images.dims[0].attach_scale(file["count"])
        file.create_group("meta").attrs["fps"] = fps
    return path


def test_wass_is_read_where_its_cameras_see(tmp_path: Path) -> None:
    """The largest square that lies in their view, its antenna in its middle, as the cameras stand outside."""
    file = recorded_sea(str(wass(tmp_path / "wass.nc")))
    assert (file.frames, file.spacing_m, file.periodic, file.cut) == (20, pytest.approx(0.5), False, True)
    assert file.step_s == pytest.approx(1.0 / 12.0, rel=1e-6)
    side = file.points * 0.5
    # The view is 16 m wide near and 29.8 m far, 34.5 m on: a square that touches the far end has 29.8 − 0.4 s = s.
    assert side == pytest.approx(29.8 / 1.4, abs=0.5)
    assert file.west_m == pytest.approx(-0.5 * (side - 0.5))
    values, gap = file.elevation_and_gap(7)
    assert gap == 0.0
    # By symmetry its middle lies at x = 0, its far side at y = −25.5 or as little nearer as the points leave free.
    around = [
        (east, north - 0.5 * side) for east in (-0.5, -0.25, 0.0, 0.25, 0.5) for north in (-25.25, -25.75, -26.25)
    ]
    assert min(np.abs(values + file.level_m - expected(file, 7, each)).max() for each in around) < 1e-3 * A


def test_times_of_single_precision_are_even(tmp_path: Path) -> None:
    """Half an hour in, they are rounded to 1e-4 s, a thousandth of a step and more."""
    file = recorded_sea(str(wass(tmp_path / "late.nc", begin=1800.0)))
    assert file.step_s == pytest.approx(1.0 / 12.0, rel=1e-4)


def test_a_grid_that_is_turned_is_refused(tmp_path: Path) -> None:
    path = wass(tmp_path / "turned.nc", mask=False, turned=True)
    with pytest.raises(InputError, match=r"do not lie in rows and columns along x and y"):
        recorded_sea(str(path))


# ---------------------------------------------------------------------------------------------------- Schwendeman


def bursts(folder: Path, frames: int = 30, minutes: int = 2, hdf5: bool = False, points: int = 41) -> Path:
    """XYGrid_01.mat and ZGrid_01.mat …: metres, the frames last, radiances beside; Matlab's own files or HDF5."""
    folder.mkdir()
    axis = np.linspace(-5.0, 5.0, points)
    x, y = np.meshgrid(axis, axis)
    for minute in range(minutes):
        t = 60.0 / frames * (minute * frames + np.arange(frames))
        z = wave(x[..., None], y[..., None], t)
        for name, held in (
            (f"XYGrid_{minute + 1:02d}.mat", {"xgrid": x, "ygrid": y}),
            (f"ZGrid_{minute + 1:02d}.mat", {"zgrid": z, "imgrid": np.zeros(z.shape, np.uint8)}),
        ):
            if not hdf5:
                scipy.io.savemat(folder / name, held)
                continue
            with h5py.File(folder / name, "w", userblock_size=512) as file:
                for key, values in held.items():
                    file.create_dataset(key, data=values.T)
            with (folder / name).open("r+b") as file:
                file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64")
    return folder


@pytest.mark.parametrize("hdf5", [False, True])
@pytest.mark.parametrize("named", ["folder", "first minute"])
def test_minutes_of_a_stereo_video_follow_each_other(named: str, hdf5: bool, tmp_path: Path) -> None:
    folder = bursts(tmp_path / "XYZResults", hdf5=hdf5)
    file = recorded_sea(str(folder if named == "folder" else folder / "ZGrid_01.mat"))
    assert (file.frames, file.points, file.step_s) == (60, 41, pytest.approx(2.0))
    assert (file.spacing_m, file.west_m) == (pytest.approx(0.25), pytest.approx(-5.0))
    for frame in (0, 29, 30, 59):
        np.testing.assert_allclose(file.elevation(frame) + file.level_m, expected(file, frame), atol=1e-9)


def test_its_minutes_must_be_whole_and_have_their_places(tmp_path: Path) -> None:
    folder = bursts(tmp_path / "hole", minutes=3)
    (folder / "ZGrid_02.mat").unlink()
    with pytest.raises(InputError, match=r"minutes \[1, 3\] do not follow each other"):
        recorded_sea(str(folder))
    assert recorded_sea(str(folder / "ZGrid_03.mat")).frames == 30
    alone = bursts(tmp_path / "alone")
    (alone / "XYGrid_02.mat").unlink()
    with pytest.raises(InputError, match=r"XYGrid_02\.mat is not beside ZGrid_02\.mat"):
        recorded_sea(str(alone / "ZGrid_02.mat"))


# ---------------------------------------------------------------------------------------------------- CF


def projected(path: Path, unit: str = "m", scale: float = 1.0, kind: str = "f8") -> Path:
    """1 m, 2 Hz, a map projection's coordinates, by CF's names and axes: as a published NetCDF file may have it."""
    x, y, t = 512_000.0 + np.arange(40.0), 4_190_000.0 + np.arange(40.0), 0.5 * np.arange(30)
    z = wave(x - 512_000.0, (y - 4_190_000.0)[:, None], t[:, None, None])
    of_x = {"units": unit, "standard_name": "projection_x_coordinate"}
    of_y = {"units": unit, "standard_name": "projection_y_coordinate"}
    xr.Dataset(
        {"wave": (("frame", "row", "col"), z, {"units": "m", "standard_name": "sea_surface_height_above_geoid"})},
        {
            "frame": ("frame", t, {"units": "seconds since 2017-07-04 12:00:00", "axis": "T"}),
            "row": ("row", (scale * y).astype(kind), of_y),
            "col": ("col", (scale * x).astype(kind), of_x),
        },
    ).to_netcdf(path, engine="h5netcdf")
    return path


@pytest.mark.parametrize(("unit", "scale"), [("m", 1.0), ("km", 1e-3)])
def test_a_map_projections_metres_are_brought_to_the_antenna(unit: str, scale: float, tmp_path: Path) -> None:
    file = recorded_sea(str(projected(tmp_path / "utm.nc", unit, scale)))
    assert (file.step_s, file.spacing_m) == (pytest.approx(0.5), pytest.approx(1.0))
    assert file.west_m == pytest.approx(-19.5, abs=1e-6)
    np.testing.assert_allclose(file.elevation(3) + file.level_m, expected(file, 3, (19.5, 19.5)), atol=1e-9)


def test_northings_of_too_few_digits_are_no_grid(tmp_path: Path) -> None:
    """In km and single precision they are rounded to a quarter of a metre at 4190 km."""
    with pytest.raises(InputError, match=r"row: is not evenly spaced"):
        recorded_sea(str(projected(tmp_path / "single.nc", "km", 1e-3, "f4")))


# ---------------------------------------------------------------------------------------------------- gaps


def with_gaps(path: Path, gaps: dict[int, tuple[slice, slice]], points: int = 100) -> Path:
    axis, t = np.arange(points) - 0.5 * points, 0.1 * np.arange(30)
    z = 0.3 * np.cos(0.25 * axis + 0.1 * axis[:, None] - 1.6 * t[:, None, None])
    for frame, where in gaps.items():
        z[frame][where] = np.nan
    xr.Dataset(
        {"eta": (("time", "y", "x"), z.astype("f4"), {"units": "m"})},
        {name: (name, values, {"units": "s" if name == "time" else "m"}) for name, values in
         (("time", t), ("y", axis), ("x", axis))},
    ).to_netcdf(path, engine="h5netcdf")  # fmt: skip
    return path


def test_a_hole_is_filled_and_its_width_told(tmp_path: Path) -> None:
    whole = recorded_sea(str(with_gaps(tmp_path / "whole.nc", {})))
    holed = recorded_sea(str(with_gaps(tmp_path / "holed.nc", {9: (slice(40, 45), slice(60, 70))})))
    (values, wide), truth = holed.elevation_and_gap(9), whole.elevation(9) + whole.level_m - holed.level_m
    assert wide == pytest.approx(3.5)  # five rows of a metre: 3 m to known water, and half a point
    gap = np.zeros(truth.shape, dtype=bool)
    gap[40:45, 60:70] = True
    np.testing.assert_allclose(values[~gap], truth[~gap], atol=1e-12)
    # k = 0.269 rad/m across 3.5 m: (0.94)⁴/24 = 0.033 of 0.3 m
    assert 1e-4 < np.abs((values - truth)[gap]).max() < 0.035 * 0.3
    assert holed.elevation_and_gap(8)[1] == 0.0


def test_what_the_cameras_never_see_at_the_edges_is_cut_off(tmp_path: Path) -> None:
    east = (slice(None), slice(80, None))
    file = recorded_sea(str(with_gaps(tmp_path / "east.nc", dict.fromkeys(range(30), east))))
    assert (file.points, file.cut) == (80, True)
    assert (file.west_m, file.elevation_and_gap(4)[1]) == (-50.0, 0.0)


@pytest.mark.parametrize(
    ("gaps", "line"),
    [
        ({9: (slice(None), slice(0, 60))}, r"frame 9 has gaps \(60\.0%\), and at most 50% may be"),
        ({9: (slice(30, 60), slice(80, None))}, r"frame 9 has gaps from the edge of the patch inwards"),
        (dict.fromkeys(range(30), (slice(None), slice(None))), "eta is missing everywhere in the frames"),
        (
            dict.fromkeys(range(30), (slice(None), slice(9, None))),
            "largest square without gaps at its edges has 9 points",
        ),
    ],
)
def test_gaps_that_cannot_be_filled_are_refused_in_a_line(
    gaps: dict[int, tuple[slice, slice]], line: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=line) as refused:
        recorded_sea(str(with_gaps(tmp_path / "gaps.nc", gaps))).elevation_and_gap(9)
    assert "\n" not in str(refused.value)


# ---------------------------------------------------------------------------------------------------- memory


def test_of_a_file_of_any_length_a_frame_is_read_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Counted: no reading is of more than one frame, and opening reads as many, however many there are."""
    counts, read = [], h5netcdf.Variable.__getitem__

    def counted(variable: h5netcdf.Variable, key: object) -> np.ndarray:
        values = read(variable, key)
        counts.extend([values.size] if np.ndim(values) > 1 else [])
        return values

    monkeypatch.setattr(h5netcdf.Variable, "__getitem__", counted)
    opened = []
    for frames in (30, 300):
        file = tmp_path / f"{frames}.nc"
        with xr.open_dataset(with_gaps(tmp_path / f"short{frames}.nc", {}, points=20)) as short:
            short.isel(time=np.arange(frames) % 30).assign_coords(time=0.1 * np.arange(frames)).to_netcdf(
                file, engine="h5netcdf"
            )
        counts.clear()
        recorded_sea(str(file)).elevation(frames - 1)
        opened.append(len(counts))
        assert max(counts) == 400
    assert opened[0] == opened[1]
