"""What a record between its frames is worth: `python -m validation.sea.recorded_seas`.

The sea of choppy_sea, on its own patch, is written as frames so many seconds apart and read back as a recorded sea. Rms
differences from the sea that was drawn, at 20,000 places and times of the first seconds, beside what is stated of the
record; and of the maps that the radar of `tiny` makes of both.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
import xarray as xr

from seamap_rt.interferometry import retrieve
from seamap_rt.io.recorded_sea import recorded_sea
from seamap_rt.resolved_scene import run_sea
from seamap_rt.scene import Scene, load_scene
from seamap_rt.sea import Sea, realize
from seamap_rt.sea.recorded import first_frame
from seamap_rt.session import simulate

_BEFORE_S, _SECONDS = 3.0, 2.2
_ALIKE_S = 0.125  # a step of which the time before 0 is a multiple
_STEPS_S = (0.1, 0.2, 0.25, 0.33, 0.5)


def write(sea: Sea, scene: Scene, path: Path, step_s: float) -> float:
    """Frames of a scene's sea on its patch, from `_BEFORE_S` before its time 0 on; seconds of the first frame."""
    spacing = scene.sea.resolution_m
    assert spacing is not None
    axis = spacing * np.arange(round(scene.sea.extent_m / spacing)) - 0.5 * scene.sea.extent_m
    times = np.arange(-_BEFORE_S, _SECONDS + 10.0 * step_s, step_s)
    east, north = np.meshgrid(axis, axis)
    frames = np.stack([sea.elevation(east, north, time).astype(np.float32) for time in times])
    coordinates = {name: (name, axis, {"units": "m"}) for name in ("y", "x")}
    record = xr.Dataset(
        {"elevation": (("time", "y", "x"), frames, {"units": "m"})},
        {**coordinates, "time": ("time", times - times[0], {"units": "s"})},
        {"periodic": 1},
    )
    record.to_netcdf(path, engine="h5netcdf")
    return float(times[0])


def recorded(scene: Scene, path: Path) -> Scene:
    """The scene with the record for its sea."""
    sea = scene.sea.model_copy(update={"model": "recorded", "file": str(path)})
    return scene.model_copy(update={"sea": sea})


def main() -> None:
    """Print a line for each step, and one for the maps."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    scene = load_scene("tiny", {"tracing.tracer": "horizon"})
    sea = run_sea(scene)
    random = np.random.default_rng(1)
    x, y = random.uniform(-200.0, 200.0, (2, 20_000))
    with tempfile.TemporaryDirectory() as folder:
        print("frames, s apart   elevation, m rms (stated)   slope (stated)   flow, m/s")
        for step in _STEPS_S:
            path = Path(folder) / f"{step}.nc"
            first = write(sea, scene, path, step)
            again = realize(recorded(scene, path).sea, 1)
            begin = first + step * first_frame(recorded_sea(str(path)))
            t = random.uniform(0.0, again.ends_s - 1e-6, x.size)
            apart = [
                _rms(getattr(again, name)(x, y, t) - getattr(sea, name)(x, y, t + begin))
                for name in ("elevation", "slopes", "velocity")
            ]
            stated = again.resolved
            print(
                f"{step:15.2f}   {apart[0]:.2g} ({stated.elevation_error:.2g})   {apart[1]:.2g} "
                f"({stated.slope_error:.2g})   {apart[2]:.2g}"
            )
        write(sea, scene, Path(folder) / "longer.nc", _ALIKE_S)
        _maps(scene, Path(folder) / "longer.nc")


def _maps(scene: Scene, path: Path) -> None:
    """Heights of the maps of the drawn and of the recorded sea, whose times 0 are made alike."""
    late = round(_BEFORE_S / _ALIKE_S) - first_frame(recorded_sea(str(path)))
    with xr.open_dataset(path) as opened:
        opened.isel(time=slice(late, None)).to_netcdf(path.with_name("alike.nc"), engine="h5netcdf")
    both = scene, recorded(scene, path.with_name("alike.nc"))
    heights = [retrieve(simulate(each).echoes)["polar"].to_dataset()["height"].values for each in both]
    apart, whole = heights[0] - heights[1], heights[0]
    print(f"maps of tiny: {np.sqrt(np.nanmean(apart**2)):.2g} m rms apart, of {np.nanstd(whole):.2g} m")


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


if __name__ == "__main__":
    main()
