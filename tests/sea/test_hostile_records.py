"""Files that are no recorded sea, or one in wrong units: `seamap-rt run` refuses each in a line, before anything runs,
and leaves nothing behind. What can be read all the same is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from known_waves import FRAMES, dataset_of, write

from seamap_rt.cli import main

Change = Callable[[xr.Dataset], xr.Dataset]


@pytest.fixture(scope="module")
def data() -> xr.Dataset:
    return dataset_of(points=60, west_m=-30.0)


def with_axis(name: str, factor: float = 1.0, units: str | None = None) -> Change:
    def changed(data: xr.Dataset) -> xr.Dataset:
        units_now = data[name].attrs if units is None else {"units": units}
        return data.assign_coords({name: (name, factor * data[name].values, units_now)})

    return changed


def in_metres_that_are_degrees(data: xr.Dataset) -> xr.Dataset:
    """Places in degrees whose units are left out."""
    return with_axis("x", 9e-6, "")(with_axis("y", 9e-6, "")(data)).drop_attrs()


def by_latitude(data: xr.Dataset) -> xr.Dataset:
    """Places in degrees that say so."""
    moved = with_axis("x", 9e-6, "degrees_east")(with_axis("y", 9e-6, "degrees_north")(data))
    return moved.rename(x="longitude", y="latitude")


def with_gaps(frames: slice, where: slice) -> Change:
    def changed(data: xr.Dataset) -> xr.Dataset:
        values = data["elevation"].values.copy()
        values[frames, where, where] = np.nan
        return data.assign(elevation=(("time", "y", "x"), values, {"units": "m"}))

    return changed


def scaled(factor: float) -> Change:
    return lambda data: data.assign(elevation=data["elevation"] * factor)


def with_a_late_frame(data: xr.Dataset) -> xr.Dataset:
    times = data["time"].values + np.where(np.arange(FRAMES) > 30, 0.05, 0.0)
    return data.assign_coords(time=("time", times, {"units": "s"}))


HOSTILE: dict[str, tuple[Change, str]] = {
    "wrong axes": (lambda data: data.rename(x="east_index"), "holds no elevation over time, y and x"),
    "axes without places": (lambda data: data.drop_vars(["x", "y"]), "holds no elevation over time, y and x"),
    "no time": (lambda data: data.isel(time=0, drop=True), "holds no elevation over time, y and x"),
    "one time step": (lambda data: data.isel(time=slice(1)), "time: has 1 points: must have at least 14"),
    "uneven time": (with_a_late_frame, "time: is not evenly spaced"),
    "time that runs backwards": (lambda data: data.isel(time=slice(None, None, -1)), "time runs backwards"),
    "time in hours": (with_axis("time", 1.0, "hours"), "time: frames are 360 s apart: must be 0.001 to 10"),
    "time in microseconds": (with_axis("time", 1e6), "frames are 1e+05 s apart: must be 0.001 to 10"),
    "uneven places": (lambda data: data.isel(x=[*range(40), *range(41, 60)]), "x: is not evenly spaced"),
    "places that are none": (with_axis("x", np.nan), "x: is not evenly spaced"),
    "few places": (lambda data: data.isel(x=slice(9)), "x: has 9 points: must have at least 16"),
    "degrees": (by_latitude, "longitude: is in 'degrees_east': must be in m"),
    "degrees without a word": (in_metres_that_are_degrees, "points are 9e-06 m apart: must be 0.001 to 100"),
    "places in micrometres": (
        lambda data: with_axis("x", 1e6)(with_axis("y", 1e6)(data)),
        "points are 1e+06 m apart: must be 0.001 to 100",
    ),
    "oblong cells": (with_axis("y", 1.5), "x and y are 1 and 1.5 m apart: must be alike"),
    "heights in micrometres": (scaled(1e6), "holds 3e+05 m: must be at most 30"),
    "heights in megametres": (scaled(1e-6), "waves of 2.1e-07 m rms: must be at least 0.001; check the units"),
    "heights in degrees": (
        lambda data: data.assign(elevation=data["elevation"].assign_attrs(units="degree")),
        "elevation: is in 'degree': must be in m",
    ),
    "a flat sea": (scaled(0.0), "is flat at all frames"),
    "nothing but gaps": (with_gaps(slice(None), slice(None)), "elevation is missing everywhere"),
    "a patch of gaps": (with_gaps(slice(12, 14), slice(20, 45)), "has a gap 27 m wide"),
    "gaps of most of a frame": (with_gaps(slice(12, 13), slice(0, 50)), "frame 12 has gaps (69.4%), and at most 50%"),
    "gaps from the edge": (with_gaps(slice(12, 13), slice(40, None)), "frame 12 has gaps from the edge of the patch"),
    "frames too far apart": (
        with_axis("time", 12.0),
        "frames 1.2 s and points 1 m apart leave an error",
    ),
}


def run(capsys: pytest.CaptureFixture[str], path: str, *more: str) -> tuple[int, str]:
    folder = Path(path).parent
    scene = folder / "mine.toml"
    scene.write_text(
        f'name = "mine"\n[sea]\nmodel = "recorded"\nfile = "{path}"\nbeyond = "level"\n[radar]\n'
        'range_m = [15.0, 30.0]\nheight_m = 4.0\nsector_deg = [60.0, 70.0]\n[tracing]\ntracer = "horizon"\n'
    )
    with pytest.raises(SystemExit) as end:
        main(["simulate", str(scene), "--out", str(folder / "results"), *more])
    said = capsys.readouterr()
    code = end.value.code
    assert isinstance(code, int)
    return code, said.err if code else said.out


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_refused_in_a_line(
    name: str, data: xr.Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change, words = HOSTILE[name]
    code, said = run(capsys, write(change(data.copy(deep=True)), tmp_path / "sea.nc"))
    assert code == 2
    assert words in said
    assert len(said.strip().splitlines()) == 1, said
    assert not (tmp_path / "results").exists()


def test_small_gaps_are_filled_and_the_run_goes_on(
    data: xr.Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(with_gaps(slice(12, 14), slice(30, 33))(data), tmp_path / "sea.nc")
    code, said = run(capsys, path)
    assert code == 0
    assert "reaches 24.5 m from the antenna, radar.range_m to 30 m: beyond the sea is level" in " ".join(said.split())
