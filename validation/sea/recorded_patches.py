"""What a record that ends within the radar's circle is worth: `python -m validation.sea.recorded_patches [--large
FRAMES]`.

The sea of `tiny` is written as frames of a square of 250 m, which ends, and of its whole patch, which repeats. Told
are: how far flow and slopes are from those of the whole record, by the distance to what is judged; and the height
errors of the maps there, of the whole record and of the square continued either way. --large: memory and time of a
record of so many frames of 1024 × 1024 points (6000: 25 GB), of which those that a run reads are written.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from itertools import pairwise
from pathlib import Path

import h5py
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.compute.machine import peak_memory
from seamap_rt.interferometry import retrieve
from seamap_rt.resolved_scene import run_sea
from seamap_rt.scene import Scene, load_scene
from seamap_rt.scene.model import scene_of
from seamap_rt.sea import Sea, realize
from seamap_rt.session import simulate
from seamap_rt.simulation import Simulator

_SIDE_M, _STEP_S, _FRAMES = 250.0, 0.125, 40
_EDGES_M = (0.0, 5.0, 10.0, 20.0, 40.0, 80.0)
_SEEDS = range(1, 6)
_POINTS = 1024  # a side, of a large record


def written(sea: Sea, axis: NDArray, path: Path, periodic: bool) -> str:
    """Frames of a sea from its time 0 on."""
    east, north = np.meshgrid(axis, axis)
    times = _STEP_S * np.arange(_FRAMES)
    frames = np.stack([sea.elevation(east, north, moment).astype(np.float32) for moment in times])
    along = {name: (name, axis, {"units": "m"}) for name in ("y", "x")}
    xr.Dataset(
        {"elevation": (("time", "y", "x"), frames, {"units": "m"})},
        {**along, "time": ("time", times, {"units": "s"})},
        {"periodic": int(periodic)},
    ).to_netcdf(path, engine="h5netcdf")
    return str(path)


def scenes(seed: int, folder: Path) -> dict[str, Scene]:
    """The whole record, and the square continued."""
    drawn = load_scene("tiny", {"seed": seed, "tracing.tracer": "horizon"})
    sea, spacing, extent = run_sea(drawn), drawn.sea.resolution_m or 1.0, drawn.sea.extent_m
    spacing = extent / round(extent / spacing)
    whole = spacing * (np.arange(round(extent / spacing)) - round(extent / spacing) // 2)
    files = {
        "whole": written(sea, whole, folder / f"whole{seed}.nc", True),
        "square": written(sea, whole[np.abs(whole) < 0.5 * _SIDE_M], folder / f"square{seed}.nc", False),
    }
    tree = drawn.model_dump(mode="json", exclude={"sea"}, exclude_unset=True)
    record = {"model": "recorded", "depth_m": drawn.sea.depth_m}
    return {
        "whole": scene_of(tree | {"sea": record | {"file": files["whole"]}}),
        **{
            beyond: scene_of(tree | {"sea": record | {"file": files["square"], "beyond": beyond}})
            for beyond in ("level", "mirrored")
        },
    }


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--large", type=int, metavar="FRAMES", help="6000: 25 GB")
    frames = parser.parse_args().large
    if frames:
        _large(frames)
        return
    with tempfile.TemporaryDirectory() as folder:
        errors: dict[str, list[list[NDArray]]] = {}
        for seed in _SEEDS:
            made = scenes(seed, Path(folder))
            if seed == _SEEDS[0]:
                _flow(made)
            _judged(made, errors)
    print("height errors of the maps, m rms, by metres to what is not judged")
    print("sea       ", *(f"{low:g}-{high:g}" for low, high in pairwise(_EDGES_M)))
    for name, rows in errors.items():
        print(
            f"{name:10}", *(f"{np.sqrt(np.nanmean(np.concatenate(each) ** 2)):.4f}" for each in zip(*rows, strict=True))
        )


def _flow(made: dict[str, Scene]) -> None:
    seas = {name: realize(scene.sea, 1) for name, scene in made.items()}
    random = np.random.default_rng(1)
    x, y = random.uniform(-0.5 * _SIDE_M, 0.5 * _SIDE_M, (2, 60_000))
    t = random.uniform(0.0, 1.5, x.size)
    true = seas["whole"].elevation_slopes_and_velocity(x, y, t)
    for name in ("level", "mirrored"):
        away, made_ = _inside(seas[name], x, y), seas[name].elevation_slopes_and_velocity(x, y, t)
        print(f"{name}: errors of elevation, slope and flow, rms over their own, by metres to what is not judged")
        for low, high in pairwise(_EDGES_M):
            here = (away >= low) & (away < high)
            parts = [(m[here], w[here]) for m, w in ((made_[0], true[0]), (made_[1], true[1]))]
            parts.append((made_[2][here, :2], true[2][here, :2]))
            print(f"  {low:g}-{high:g} m", *(f"{np.sqrt(np.mean((m - w) ** 2) / np.mean(w**2)):.2g}" for m, w in parts))


def _inside(sea: Sea, x: NDArray, y: NDArray) -> NDArray:
    """m from places to what is not judged; below 0 there."""
    west, east, south, north = sea.patch.judged_m  # type: ignore[union-attr]
    return np.minimum.reduce([x - west, east - x, y - south, north - y])


def _judged(made: dict[str, Scene], errors: dict[str, list[list[NDArray]]]) -> None:
    """Errors of each map in the cells that the square judges, by their distance from what it does not."""
    patch = realize(made["level"].sea, 1)
    known = None
    for name in ("level", "mirrored", "whole"):
        run = simulate(made[name])
        maps, truth = (each["polar"].to_dataset().isel(turn=0) for each in (retrieve(run.echoes), run.truth))
        azimuth, slant = np.meshgrid(np.radians(truth["azimuth"].values), truth["range"].values, indexing="ij")
        away = _inside(patch, slant * np.sin(azimuth), slant * np.cos(azimuth))
        error = (maps["height"] - truth["height"]).values
        if known is None:
            known = np.isfinite(truth["height"].values)
        counts = known & (truth["visible_fraction"].values > 0.5) & (slant > 25.0)
        rows = [error[counts & (away >= low) & (away < high)] for low, high in pairwise(_EDGES_M)]
        errors.setdefault(name, []).append(rows)


def _large(frames: int) -> None:
    """A turn on a long record."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "large.nc"
        _sparse(path, frames)
        began = time.process_time()
        tree = {
            "name": "large",
            "sea": {"model": "recorded", "file": str(path), "beyond": "level"},
            "radar": {"range_m": [15.0, 200.0], "height_m": 4.0},
            "tracing": {"tracer": "horizon"},
        }
        simulator = Simulator(scene_of(tree))
        ready = time.process_time() - began
        simulator.turn(0)
        size = 4e-9 * frames * _POINTS**2
        print(f"{size:.3g} GB: ready after {ready:.2g} s, peak of memory {peak_memory() / 1e9:.3g} GB")


def _sparse(path: Path, frames: int) -> None:
    """Six waves; frames that no run reads are left out, and take no disk."""
    points = _POINTS
    axis, random = 0.5 * (np.arange(points) - points // 2), np.random.default_rng(1)
    waves = [(*random.normal(0.0, 0.12, 2), *random.uniform(0.0, [0.1, 6.28])) for _ in range(6)]
    read = {*np.linspace(0, frames - 1, 12).astype(int), *range(min(45, frames))}
    read |= {at + n for at in np.linspace(11, frames - 4, 12).astype(int) for n in range(-4, 5)}
    with h5py.File(path, "w") as file:
        for name, values, units in (("time", 0.1 * np.arange(frames), "s"), ("y", axis, "m"), ("x", axis, "m")):
            file.create_dataset(name, data=values).make_scale(name)
            file[name].attrs["units"] = units
        held = file.create_dataset("elevation", (frames, points, points), "f4", chunks=(1, points, points))
        for number, name in enumerate(("time", "y", "x")):
            held.dims[number].attach_scale(file[name])
        for frame in sorted(each for each in read if 0 <= each < frames):
            total = np.zeros((points, points), dtype=np.float32)
            for east, north, height, phase in waves:
                turn = phase - 0.1 * frame * np.sqrt(9.81 * np.hypot(east, north))
                along, across = height * np.exp(1j * (east * axis + turn)), np.exp(1j * north * axis)
                total += (across.real[:, None] * along.real - across.imag[:, None] * along.imag).astype(np.float32)
            held[frame] = total


if __name__ == "__main__":
    main()
