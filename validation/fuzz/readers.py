"""What the program does with a file of each kind first: read it, check it, and compute what a run computes from it."""

from __future__ import annotations

import gc
import math
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import xarray as xr

import seamap_rt as sr
from seamap_rt.compute.machine import forget_peak_memory
from seamap_rt.dataset import SCHEMA, check
from seamap_rt.errors import InputError, SchemaError
from seamap_rt.interferometry import open_recording
from seamap_rt.io.meshfile import load_mesh
from seamap_rt.io.polar_images import read_polar_images
from seamap_rt.io.recording_header import read_header
from seamap_rt.mesh.sizing import triangles
from seamap_rt.resolved_scene import installation_of, run_sea
from seamap_rt.scene import Scene, load_scene
from seamap_rt.session import simulate
from seamap_rt.settings import ObjectSettings, RetrievalSettings
from seamap_rt.studies.cluster import _address
from seamap_rt.studies.point import load_outcome
from seamap_rt.studies.sweep import Sweep
from seamap_rt.studies.trade_table import Criterion, trade_table

from .originals import HEADER, SMALL

THEIRS = "theirs"  # a file that stands beside the case while the user's own library reads it
_LARGEST_MAPS = 2e8  # bytes; nobody's turn is so large
COARSE = RetrievalSettings(estimator="single_cell", cell_azimuth_deg=3.6, ground_m=10.0)
_POINTS, _TRIANGLES, _VOLTAGES = 128, 3e4, 2e6  # of scenes that are simulated: a second each at most


class NotOurs(Exception):
    """The file is refused by the library with which a user opens it, before the program sees it."""


def read_scene(path: Path) -> None:
    """Read, write and read again; what a run computes before it draws the sea."""
    consequences(load_scene(path))


def consequences(scene: Scene) -> None:
    """What follows from an accepted scene at once."""
    again = sr.load_scene("flat").model_validate(_tree(scene.to_toml()))
    if again != scene:
        raise AssertionError("the resolved scene reads back to another")
    detail = scene.detail
    triangles(scene.radar, detail.facet_m, detail.columns_per_beam)
    _ = scene.wavelength_m, scene.turn_duration_s, scene.far_ground_range, scene.resolved_retrieval
    if scene.platform.motion != "wave_following":
        installation_of(scene)


def _tree(text: str) -> dict[str, Any]:
    import tomllib

    return tomllib.loads(text)


def whole_run(scene: Scene) -> bool:
    """Simulate and retrieve a scene that is small enough; False for another."""
    detail, radar = scene.detail, scene.radar
    spacing = scene.sea.resolution_m or (math.inf if scene.sea.energy_fraction is None else 0.0)
    gates = (radar.range_m[1] - radar.range_m[0]) / radar.range_sampling_m
    if (
        scene.turns > 1
        or spacing == 0.0
        or scene.sea.extent_m / min(spacing, 0.8) > _POINTS * 6
        or triangles(radar, detail.facet_m, detail.columns_per_beam) > _TRIANGLES
        or gates * radar.prf_hz * scene.turn_duration_s > _VOLTAGES
    ):
        return False
    sr.retrieve(simulate(scene).echoes)
    return True


def read_spectrum(path: Path) -> None:
    waves = {"spectrum": "file", "file": str(path)}
    run_sea(load_scene("tiny", overrides={**SMALL, "sea.waves": [waves]}))


def read_pattern(path: Path) -> None:
    load_scene("tiny", overrides={**SMALL, "radar.antenna": {"pattern": "file", "file": str(path)}})


def read_motion(path: Path) -> None:
    installation_of(load_scene("tiny", overrides={**SMALL, "platform.motion": "file", "platform.file": str(path)}))


def read_mesh(path: Path) -> None:
    load_mesh(ObjectSettings(mesh=str(path), position_m=(0.0, 0.0, 0.0)))


def read_recording(path: Path) -> None:
    sr.retrieve(open_recording(path), COARSE)


def read_images(path: Path) -> None:
    check("polar_images", read_polar_images(path))


def read_a_header(path: Path) -> None:
    read_header(path)


def read_store(path: Path) -> None:
    sr.retrieve(path, COARSE)


def read_maps(path: Path) -> None:
    """Maps and truth are opened by the user's own xarray; what the program is given then, it checks."""
    original, damage, tree = path.with_name("original.nc"), "", xr.DataTree()
    path.with_name(THEIRS).touch()
    with xr.open_datatree(original, engine="h5netcdf") as other:
        other.load()
    with _silent():
        try:
            with xr.open_datatree(path, engine="h5netcdf") as tree:
                tree.load()
        except Exception as error:
            damage = f"{type(error).__name__}: {error}"
        if damage:
            gc.collect()  # of files that could not be opened
    if not damage and sum(node.nbytes for node in tree.subtree) > _LARGEST_MAPS:
        damage = "they would fill the memory that is allowed here by themselves"
    if damage:
        tree = xr.DataTree()
        gc.collect()
    forget_peak_memory()  # what xarray took to read them
    path.with_name(THEIRS).unlink()
    if damage:
        raise NotOurs(damage)
    if path.name.startswith("maps"):
        sr.sea_state(tree)
        sr.compare(tree, other)
    else:
        sr.compare(other, tree)


@contextmanager
def _silent() -> Iterator[None]:
    """What others' libraries print of a file that they open for the user is theirs."""
    hook, sys.unraisablehook = sys.unraisablehook, lambda _: None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        sys.unraisablehook = hook


def read_sweep(path: Path) -> None:
    if path.name == "scheduler.json":
        _address(str(path))
    elif path.name == "trade.json":
        path = path.rename(path.with_name("trade.json"))
        with Sweep.of(load_scene("flat"), {"radar.height_m": [5.0]}, 1, path.parent).prepared(
            resume=True, overwrite=False
        ):
            pass
    else:
        outcome = load_outcome(path)
        if outcome is None:
            raise InputError("computed anew")
        trade_table({"radar.height_m": [5.0]}, [1], {(0, 0): outcome}, Criterion(), {})


READERS: dict[str, Callable[[Path], None]] = {
    "scene": read_scene,
    "spectrum": read_spectrum,
    "pattern": read_pattern,
    "motion": read_motion,
    "mesh": read_mesh,
    "recording": read_recording,
    "polar images": read_images,
    "header": read_a_header,
    "echo store": read_store,
    "maps and truth": read_maps,
    "sweep": read_sweep,
}
REFUSALS = (InputError, SchemaError)
__all__ = ["HEADER", "READERS", "REFUSALS", "SCHEMA", "NotOurs", "consequences", "whole_run"]
