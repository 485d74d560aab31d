"""Folders as commands write them, made without a simulation: small, and known through and through."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import xarray as xr

from seamap_rt.dataset import build
from seamap_rt.forecast_errors import true_elevation
from seamap_rt.io.appendable import AppendableNetCDF
from seamap_rt.resolved_scene import run_sea
from seamap_rt.scene import load_scene
from seamap_rt.studies.sweep import Sweep

OFFSET_M, STATED_M = 0.1, 0.2


def forecasts(quiet: bool = False) -> xr.Dataset:
    """Of `tiny`, at rest: the sea itself and 0.1 m above it, stated as ± 0.2 m."""
    scene = load_scene("tiny")
    lead, issue = np.arange(0.0, 11.0), np.arange(12)
    shape = issue.size, lead.size, 1
    names = ("elevation", "slope_x", "slope_y", "velocity_z")
    values = {name: np.zeros(shape) for name in names} | {f"{name}_std": np.full(shape, STATED_M) for name in names}
    values |= {"predictable": np.ones(shape), "issued": 1.0 + issue, "turns": np.minimum(issue + 1, 10)}
    values |= {"significant_wave_height": np.full(issue.size, 1.4), "peak_period": np.full(issue.size, 5.5)}
    attributes = {"heading_deg": 0.0, "speed_m_s": 0.0}
    if quiet:
        values["quiet"] = np.where(lead[None, :, None] <= 8.0, 0.5, np.nan) * np.ones(shape)
        attributes |= {"limit_elevation": 0.3, "duration_s": 2.0, "confidence": 0.9}
    places = {"east": np.zeros((issue.size, 1)), "north": np.zeros((issue.size, 1))}
    made = build("prediction", values, {"issue": issue, "lead": lead, "place": [0], **places}, attributes)
    made["elevation"] = made["elevation"] + true_elevation(run_sea(scene), made) + OFFSET_M
    return made


TURNS, _RATE = 64, 8


def gauge_series(turn: int, turns: int = 1) -> xr.Dataset:
    """Some turns of a gauge in a wave of 0.5 m and 6.4 s, which the map follows to 0.9."""
    seen = turn + np.arange(turns) + 0.5
    time = turn + np.arange(turns * _RATE) / _RATE

    def wave(t: np.ndarray) -> np.ndarray:
        return 0.5 * np.sin(2.0 * np.pi * t / 6.4)

    of_turn = {"height": 0.9 * wave(seen), "height_std": np.full(turns, 0.05), "seen_time": seen}
    of_turn |= {"quality": np.zeros(turns, np.int16), "seen_true_height": wave(seen), "seen_cell_height": wave(seen)}
    values = {name: (("gauge", "turn"), each[None]) for name, each in of_turn.items()}
    values |= {"true_height": (("gauge", "sample"), wave(time)[None])}
    values |= {name: (("gauge",), np.array([each])) for name, each in (("east", -60.0), ("north", 0.0))}
    coordinates = {"gauge": ["west"], "turn": turn + np.arange(turns), "time": ("sample", time)}
    return xr.Dataset(values, coordinates)


def maps_tree(retrieved: bool, turns: int = 1) -> xr.DataTree:
    """Turns of a sector of 60°: a slope to the east, to 0.1 m; what lies beyond 60 m is in shadow."""
    looks, slant = np.arange(240.5, 300.0, 1.0), np.arange(15.0, 90.0, 1.5)
    angle, ground = np.radians(looks)[:, None], np.sqrt(slant**2 - 36.0)
    height = 0.01 * ground * np.sin(angle)
    lit = np.broadcast_to(ground < 60.0, height.shape)
    x = y = np.arange(-90.0, 91.0, 3.0)
    east, north = np.meshgrid(x, y)
    bearing = np.degrees(np.arctan2(east, north)) % 360.0
    passed = (bearing > 240.0) & (bearing < 300.0) & (np.hypot(east, north) < 90.0)
    time = np.where(passed, 0.5, np.nan)
    polar = {"height": height, "ground_range": np.broadcast_to(ground, height.shape)}
    grounds = {"height": np.where(passed, 0.01 * east, np.nan), "slope_x": np.full(east.shape, 0.01)}
    grounds |= {"slope_y": np.zeros(east.shape), "time": time, "height_std": np.full(east.shape, 0.1)}
    polar |= {"height_std": np.full(height.shape, 0.1), "phase": 0.1 * height, "coherence": 0.9 * np.ones(height.shape)}
    polar |= {"snr_db": 20.0 * np.ones(height.shape), "quality": np.zeros(height.shape, np.int16)}
    if retrieved:
        polar["height"] = np.where(lit, height + 0.1, np.nan)
    else:
        polar["visible_fraction"] = lit.astype(float)

    def again(values: np.ndarray) -> np.ndarray:
        return np.repeat(values[None], turns, axis=0)

    groups = {
        "/polar": xr.Dataset(
            {n: (("turn", "azimuth", "range"), again(v)) for n, v in polar.items()}
            | {"time": (("turn", "azimuth"), again(np.linspace(0.0, 1.0, looks.size)) + np.arange(turns)[:, None])},
            {"turn": np.arange(turns), "azimuth": looks, "range": slant},
        ),
        "/ground": xr.Dataset(
            {n: (("turn", "y", "x"), again(v)) for n, v in grounds.items()}, {"turn": np.arange(turns), "x": x, "y": y}
        ),
    }
    return xr.DataTree.from_dict(groups)


def write_maps(folder: Path, *products: str, turns: int = 1) -> None:
    """maps.nc and truth.nc, or one of them."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in products:
        maps_tree(name == "maps", turns).to_netcdf(folder / f"{name}.nc", engine="h5netcdf")


def write_run(folder: Path, turns: int = 12) -> None:
    """All that a run of `tiny` leaves that the views read: maps, truth, forecasts with quiet windows, a gauge."""
    write_maps(folder, "maps", "truth", turns=turns)
    (folder / "scene.toml").write_text(load_scene("tiny", {"turns": turns}).to_toml())
    forecasts(quiet=True).to_netcdf(folder / "prediction.nc", engine="h5netcdf")
    with AppendableNetCDF(folder / "gauges.nc", ("turn", "sample")) as file:
        file.append(gauge_series(0, TURNS))


def write_shadowing(folder: Path) -> None:
    """A study of two masts: half is hidden beyond 50 and beyond 100 m, whatever the look."""
    folder.mkdir(parents=True, exist_ok=True)
    height, distance = np.array([4.0, 8.0]), np.arange(25.0, 200.0, 10.0)
    looks, angles = ["along", "at 45°", "across", "all looks"], np.array([-30.0, 0.0, 30.0])
    share = np.clip(1.0 - distance / (25.0 * height[:, None]), 0.0, 1.0)
    by_look = np.repeat(share[:, None, :], len(looks), axis=1)
    dims = ("height", "look", "range")
    values = {f"look_{name}": (dims, by_look) for name in ("visible_fraction", "smith", "wagner")}
    values |= {"visible_fraction": (("height", "azimuth", "range"), by_look[:, :3])}
    values |= {f"look_visible_fraction_{end}": (dims, by_look + by) for end, by in (("low", -0.05), ("high", 0.05))}
    half = np.repeat(12.5 * height[:, None], 4, axis=1)
    values |= dict.fromkeys(("look_r50", "look_r50_smith"), (dims[:2], half))
    names = ("r50", "r50_low", "r50_high", "r50_smith")
    values |= dict.fromkeys(names, (("height", "azimuth"), half[:, :3]))
    coordinates = {"height": height, "look": looks, "range": distance, "from_waves": ("azimuth", angles)}
    attributes = {"bands": "95 % of what other seas of the same waves would give"}
    xr.Dataset(values, coordinates, attributes).to_netcdf(folder / "shadowing.nc", engine="h5netcdf")


def write_trade(folder: Path) -> None:
    """A trade of two masts and one seed."""
    (folder / "points").mkdir(parents=True)
    scene = load_scene("tiny", {"tracing.tracer": "horizon"})
    sweep = Sweep.of(scene, {"radar.height_m": [4, 8]}, 1, folder)
    (folder / "trade.json").write_text(json.dumps(sweep.manifest))
    for point in sweep.points:
        radius = 20.0 * float(point.keys["radar.height_m"])
        told = {"keys": point.keys, "seed": point.seed, "status": "done", "reason": ""}
        told["metrics"] = {"fully_measured_radius_m": radius}
        (folder / "points" / f"{point.name}.json").write_text(json.dumps(told))
