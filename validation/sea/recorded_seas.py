"""What a record between its frames is worth: `python -m validation.sea.recorded_seas`.

The sea of `tiny`, drawn on the finest grid, is written as frames so many seconds apart and read back as a recorded sea.
Rms differences from the sea that was drawn, at 20,000 places and times of the first seconds, beside what is stated of
the record; those of the same waves on the coarser grid that a run takes, beside what is stated of that grid; and of the
maps that the radar makes of all three, over seeds.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from seamap_rt.interferometry import retrieve
from seamap_rt.io.recorded_sea import recorded_sea
from seamap_rt.random_streams import Stream, branch
from seamap_rt.resolved_scene import run_sea
from seamap_rt.scattering.breaking import memory_rate
from seamap_rt.scene import Scene, load_scene
from seamap_rt.sea import Sea, realize
from seamap_rt.sea.recorded import first_frame
from seamap_rt.simulation import Simulator

_BEFORE_S, _SECONDS = 3.0, 2.2
_ALIKE_S = 0.125  # a step of which the time before 0 is a multiple
_STEPS_S = (0.1, 0.2, 0.25, 0.33, 0.5)
_SEEDS = range(1, 9)  # one seed's maps may hang on a single facet at the edge of a shadow
_SEEN = 0.5  # of a cell, from which on its height is judged


def drawn(scene: Scene) -> Sea:
    """A run's waves on the finest grid: `run_sea` may take a coarser one, whose error is no record's."""
    rate = memory_rate(scene.scattering, scene.radar.frequency_hz)
    return realize(scene.sea, branch(scene.seed, Stream.SEA), relaxation_rate=rate)


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
    """Print a line for each step and for a run's grid, and one for each sea's maps."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    scene = _tiny(1)
    sea = drawn(scene)
    random = np.random.default_rng(1)
    x, y = random.uniform(-200.0, 200.0, (2, 20_000))
    with tempfile.TemporaryDirectory() as folder:
        print("frames, s apart   elevation, m rms (stated)   slope (stated)   flow, m/s")
        for step in _STEPS_S:
            path = Path(folder) / f"{step}.nc"
            first = write(sea, scene, path, step)
            again = realize(recorded(scene, path).sea, 1)
            begin = first + step * first_frame(recorded_sea(str(path)))
            _print_apart(f"{step:.2f}", sea, again, (x, y, random.uniform(0.0, again.ends_s - 1e-6, x.size)), begin)
        _print_apart("none: own grid", sea, run_sea(scene), (x, y, random.uniform(0.0, _SECONDS, x.size)))
    _print_maps()


def _tiny(seed: int) -> Scene:
    return load_scene("tiny", {"tracing.tracer": "horizon", "seed": seed})


def _print_apart(name: str, sea: Sea, again: Sea, points: Sequence[np.ndarray], begin: float = 0.0) -> None:
    """begin: s of the drawn sea at time 0 of the other."""
    x, y, t = points
    elevation, slope, flow = (
        _rms(getattr(again, quantity)(x, y, t) - getattr(sea, quantity)(x, y, t + begin))
        for quantity in ("elevation", "slopes", "velocity")
    )
    stated = again.resolved
    heights, slopes = f"{elevation:.2g} ({stated.elevation_error:.2g})", f"{slope:.2g} ({stated.slope_error:.2g})"
    print(f"{name:>15}   {heights}   {slopes}   {flow:.2g}")


def _print_maps() -> None:
    errors: dict[str, list[float]] = {}
    apart: dict[str, list[float]] = {}
    for seed in _SEEDS:
        first: np.ndarray | None = None
        for name, (height, error) in _maps(_tiny(seed)).items():
            first = height if first is None else first
            errors.setdefault(name, []).append(error)
            apart.setdefault(name, []).append(_rms(height - first))
    print(f"\nmaps of tiny, {len(_SEEDS)} seeds   error, mm rms   from those of the drawn sea, mm rms   least   most")
    for name, each in errors.items():
        of = 1e3 * np.array(apart[name])
        print(f"{name:>22}   {1e3 * _rms(np.array(each)):.1f}   {_rms(of):.1f}   {of.min():.1f}   {of.max():.1f}")


def _maps(scene: Scene) -> dict[str, tuple[np.ndarray, float]]:
    """Heights of maps and their rms errors, m, in cells that are seen: of the drawn sea, of its record, whose times 0
    are made alike, and of a run's own sea."""
    sea = drawn(scene)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "longer.nc"
        write(sea, scene, path, _ALIKE_S)
        late = round(_BEFORE_S / _ALIKE_S) - first_frame(recorded_sea(str(path)))
        with xr.open_dataset(path) as opened:
            opened.isel(time=slice(late, None)).to_netcdf(path.with_name("alike.nc"), engine="h5netcdf")
        simulators = {
            "drawn": Simulator(scene, sea),
            "recorded": Simulator(recorded(scene, path.with_name("alike.nc"))),
            "own grid": Simulator(scene),
        }
        found = {}
        for name, simulator in simulators.items():
            turn = simulator.turn(0)
            height = retrieve(turn.echoes)["polar"].to_dataset()["height"].values
            truth = turn.truth["polar"].to_dataset()
            seen = truth["visible_fraction"].values > _SEEN
            found[name] = height, _rms((height - truth["height"].values)[seen])
        return found


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))


if __name__ == "__main__":
    main()
