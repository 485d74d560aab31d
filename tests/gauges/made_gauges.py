"""Gauges, maps and seas of known heights, and a small scene with gauges."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from seamap_rt.conventions import GRAVITY, SURFACE_TENSION, WATER_DENSITY
from seamap_rt.dataset import build
from seamap_rt.scene import load_scene
from seamap_rt.sea import Sea, realize
from seamap_rt.settings import GaugeSettings, SeaSettings


def deep_water(wavelength: float) -> float:
    """Angular frequency [rad/s] of gravity–capillary waves."""
    k = 2.0 * np.pi / wavelength
    return float(np.sqrt(GRAVITY * k + SURFACE_TENSION / WATER_DENSITY * k**3))


def gauge(name: str = "wire", **place: float) -> GaugeSettings:
    return GaugeSettings(name=name, **(place or {"east_m": -60.0, "north_m": 4.0}))


def made_maps(height: Any, turns: int = 1, period: float = 1.0, quality: int = 0) -> xr.DataTree:
    """Maps of a full turn whose heights are height(x, y, t), known everywhere; azimuth is time."""
    places = 3.0 * np.arange(-30.0, 31.0)
    x, y = np.meshgrid(places, places)
    number = np.arange(turns)
    time = period * (number[:, None, None] + np.degrees(np.arctan2(x, y)) % 360.0 / 360.0)
    values = np.broadcast_to(height(x, y, time), time.shape)
    ground = {"height": values, "height_std": 0.0 * values + 0.1, "slope_x": values, "slope_y": values, "time": time}
    azimuth, ranges = np.arange(1.0, 360.0, 2.0), np.arange(15.0, 90.0, 1.5)
    shape = (turns, azimuth.size, ranges.size)
    names = (
        "height", "height_std", "slope_range", "slope_azimuth", "coherence", "phase", "phase_unwrapped", "snr_db",
    )  # fmt: skip
    polar: dict[str, Any] = {name: np.zeros(shape) for name in names}
    polar["ground_range"] = np.broadcast_to(np.sqrt(ranges**2 - 25.0), shape)
    polar["time"] = period * (number[:, None] + azimuth / 360.0)
    polar["quality"] = np.full(shape, quality)
    cells = {"cell_range_m": 3.0, "cell_azimuth_deg": 2.0}
    return xr.DataTree.from_dict(
        {
            "/polar": build("maps/polar", polar, {"turn": number, "azimuth": azimuth, "range": ranges}, cells),
            "/ground": build("maps/ground", ground, {"turn": number, "y": places, "x": places}),
        }
    )


def a_sea(model: str = "linear", **waves: Any) -> Sea:
    settings = {"model": model, "waves": [waves or {"spectrum": "flat"}], "extent_m": 64.0, "resolution_m": 1.0}
    return realize(SeaSettings.model_validate(settings), 1)


def plane(x: np.ndarray, y: np.ndarray, t: np.ndarray) -> np.ndarray:
    return 0.02 * x - 0.03 * y + 0.5 + 0.0 * t


SMALL: dict[str, Any] = {
    "radar.sector_deg": [264.0, 276.0],
    "radar.range_m": [15.0, 65.0],
    "radar.height_m": 8.0,
    "radar.prf_hz": 4000.0,
    "sea.extent_m": 256.0,
    "tracing.tracer": "horizon",
}


def with_gauges(folder: Path, turns: int, *tables: str) -> Path:
    """`tiny` made smaller, with gauges, as a scene file."""
    scene = load_scene("tiny", SMALL | {"turns": turns})
    file = folder / "scene.toml"
    text = "\n".join(line for line in scene.to_toml().splitlines() if line != "gauges = []")
    file.write_text("\n".join((text, *(f"[[gauges]]\n{table}" for table in tables))), encoding="utf-8")
    return file
