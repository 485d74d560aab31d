"""A made-up run of known heights, and what its figures show."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from seamap_rt import dataset
from seamap_rt.conventions import ground_range, unit_from_azimuth
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import look_sweeps, pulses
from seamap_rt.report import style
from seamap_rt.scene import Scene, load_scene

PICTURES = (
    "height_maps",
    "slope_maps",
    "error_against_range",
    "height_scatter",
    "visible_share",
    "echo_power",
    "timing",
)
NOISE_W = 8e-13


class Run:
    """A made-up run: a long-crested wave from the west, noise that grows with range, shadow behind its crests."""

    def __init__(self, scene: Scene, seed: int = 0, waves: float = 1.0, lit: bool = True, noise: float = 1.0) -> None:
        self.scene = scene
        self.random = np.random.default_rng(seed)
        self.amplitude, self.noise, self.lit = 0.5 * waves, 0.08 * noise, lit
        self.turn = np.arange(scene.turns)
        radar = scene.radar
        self.azimuth = (radar.sector_deg[0] + look_sweeps(radar.sector_deg, scene.retrieval.cell_azimuth_deg)) % 360.0
        self.range = np.arange(radar.range_m[0], radar.range_m[1] + 1e-9, radar.range_sampling_m)
        side = scene.retrieval.ground_m
        half = side * np.ceil(scene.far_ground_range / side)
        self.x = self.y = np.arange(-half + 0.5 * side, half, side)
        polar_east, polar_north = (part[:, None] for part in unit_from_azimuth(self.azimuth))
        ground = ground_range(self.range, radar.height_m)
        self.polar_shape = (scene.turns, self.azimuth.size, self.range.size)
        polar = self._surface(polar_east * ground, polar_north * ground, ground, self.polar_shape)
        x, y = np.meshgrid(self.x, self.y)
        distance = np.hypot(x, y)
        self.ground_shape = (scene.turns, *x.shape)
        flat = self._surface(x, y, distance, self.ground_shape)
        start, stop = radar.sector_deg
        sweep = (np.degrees(np.arctan2(x, y)) - start) % 360.0
        outside = (distance > scene.far_ground_range) | (distance < radar.range_m[0]) | (sweep > stop - start)
        for name in ("height", "slope_x", "seen", "retrieved", "spread"):
            flat[name] = np.where(outside, np.nan, flat[name])
        self.truth = self._truth(polar, flat, polar_east)
        self.maps = self._maps(polar, flat, polar_east)
        self.echoes = self._echoes()
        self.metrics = self._metrics()

    def _surface(self, x: Any, y: Any, distance: Any, shape: tuple[int, ...]) -> dict[str, np.ndarray]:
        phase = np.broadcast_to(2.0 * np.pi * x / 47.0 + 0.0 * y, shape)
        height = self.amplitude * np.cos(phase)
        slope_x = -self.amplitude * 2.0 * np.pi / 47.0 * np.sin(phase)
        reach = np.clip((distance - 70.0) / 150.0, 0.0, 0.9)
        hidden = self.random.random(shape) * np.clip(self.amplitude / 0.5, 0.0, 1.0) * (0.6 - 0.5 * np.cos(phase + 0.8))
        seen = np.where(hidden < 1.0 - reach, 1.0, 0.1) if self.lit else np.zeros(shape)
        spread = np.broadcast_to(self.noise * (0.3 + distance / 120.0), shape)
        error = self.random.normal(size=shape) * spread
        retrieved = np.where(seen > 0.5, height + error, np.nan)
        return {"height": height, "slope_x": slope_x, "seen": seen, "retrieved": retrieved,
                "spread": np.where(seen > 0.5, spread, np.nan)}  # fmt: skip

    def _truth(self, polar: dict[str, Any], flat: dict[str, Any], east: np.ndarray) -> xr.DataTree:
        values = {
            "height": polar["height"],
            "height_weighted": polar["height"],
            "height_visible": np.where(polar["seen"] > 0.0, polar["height"], np.nan),
            "visible_fraction": polar["seen"],
            "slope_range": polar["slope_x"] * east,
            "slope_azimuth": polar["slope_x"] * 0.0,
            "nrcs_db": np.full(self.polar_shape, -40.0),
            "time": np.zeros(self.polar_shape[:2]),
        }
        ground = {
            "height": flat["height"],
            "slope_x": flat["slope_x"],
            "slope_y": flat["slope_x"] * 0.0,
            "time": np.zeros(self.ground_shape),
        }
        return self._tree("truth", values, ground)

    def _maps(self, polar: dict[str, Any], flat: dict[str, Any], east: np.ndarray) -> xr.DataTree:
        like = np.full(self.polar_shape, 1.0)
        values = {
            "height": polar["retrieved"],
            "height_std": polar["spread"],
            "slope_range": polar["slope_x"] * east,
            "slope_azimuth": polar["slope_x"] * 0.0,
            "ground_range": like * ground_range(self.range, self.scene.radar.height_m),
            "coherence": like,
            "phase": like,
            "phase_unwrapped": like,
            "snr_db": like,
            "time": np.zeros(self.polar_shape[:2]),
            "quality": np.zeros(self.polar_shape, dtype=np.int16),
        }
        noisy = flat["slope_x"] + 0.03 * self.random.normal(size=self.ground_shape)
        ground = {
            "height": flat["retrieved"],
            "height_std": flat["spread"],
            "slope_x": np.where(np.isfinite(flat["retrieved"]), noisy, np.nan),
            "slope_y": np.where(np.isfinite(flat["retrieved"]), noisy - flat["slope_x"], np.nan),
            "time": np.zeros(self.ground_shape),
        }
        return self._tree("maps", values, ground)

    def _tree(self, product: str, polar: dict[str, Any], ground: dict[str, Any]) -> xr.DataTree:
        return xr.DataTree.from_dict(
            {
                "/polar": dataset.build(
                    f"{product}/polar", polar, {"turn": self.turn, "azimuth": self.azimuth, "range": self.range}
                ),
                "/ground": dataset.build(f"{product}/ground", ground, {"turn": self.turn, "y": self.y, "x": self.x}),
            }
        )

    def _echoes(self) -> xr.Dataset:
        scene, fired = self.scene, [pulses(Installation(self.scene.radar), turn) for turn in range(self.scene.turns)]
        azimuth = np.concatenate([one.azimuth for one in fired])
        east, _ = unit_from_azimuth(azimuth)
        count = azimuth.size
        power = 1e-9 * (self.range / 30.0) ** -4 * np.exp(0.8 * np.cos(0.13 * self.range * east[:, None])) * self.lit
        voltage = self.random.normal(size=(count, 2, self.range.size, 2)).astype(np.float32)
        voltage = voltage.view(np.complex64)[..., 0] * np.sqrt(0.5 * (power + NOISE_W))[:, None, :].astype(np.float32)
        attrs: dict[str, Any] = dict.fromkeys(dataset.ECHO_ATTRIBUTES, 0.0)
        attrs |= {"noise_power_w": NOISE_W, "complete_turns": scene.turns, "height_m": scene.radar.height_m}
        return dataset.build(
            "echoes",
            {
                "time": np.concatenate([one.time for one in fired]),
                "azimuth": azimuth,
                "transmitter": np.concatenate([one.transmitter for one in fired]),
                "turn": np.repeat(self.turn, [one.azimuth.size for one in fired]),
                "voltage": voltage,
                "position": np.zeros((count, 2, 3)),
                "attitude": np.zeros((count, 3)),
            },
            {"pulse": np.concatenate([one.number for one in fired]), "range": self.range},
            attrs,
        )

    def _metrics(self) -> dict[str, Any]:
        centres = np.arange(25.0, self.scene.radar.range_m[1], 20.0)
        error = self.noise * (0.3 + centres / 120.0)
        return {
            "range_m": centres.tolist(),
            "height_rmse_m": (1.1 * error).tolist(),
            "height_robust_m": error.tolist(),
            "height_bias_m": [None, *(0.1 * error[1:]).tolist()],
            "slope_rmse": (0.3 * error).tolist(),
            "visible_fraction": np.linspace(1.0, 0.7, centres.size).tolist(),
            "overall": {
                "height_rmse_m": 0.1234,
                "height_robust_m": 0.0987,
                "height_bias_m": -0.0123,
                "height_correlation": 0.9511,
                "hs_true_m": 1.414,
                "hs_retrieved_m": 1.466,
                "range_m": (50.0, 200.0),
            },
            "hs_scene_m": 1.412,
            "measured": {
                "fully_measured_radius_m": 101.4,
                "reach_m": 142.6,
                "reach_to_the_end": 0.0,
                "gross_share": 0.001,
                "missed_share": 0.31,
            },
            "sea_state": {
                "significant_wave_height": [1.50, 1.54],
                "significant_wave_height_std": [0.06, 0.06],
            },
            "timing_s": {
                "first": {
                    "sea": 1.2,
                    "mesh": 0.4,
                    "trace": 3.1,
                    "echoes": 2.2,
                    "retrieve": 0.6,
                    "write": 0.2,
                    "total": 7.7,
                },
                "warm": {
                    "sea": 0.1,
                    "mesh": 0.3,
                    "trace": 0.5,
                    "echoes": 1.1,
                    "retrieve": 0.5,
                    "write": 0.2,
                    "total": 2.7,
                },
            },
            "real_time_factor": 0.5,
            "facets": 1_234_567,
            "rays": 2_469_134,
            "peak_memory_bytes": 1.9e9,
            "modelled": [{"what": "Shadowing", "why": "at 1° grazing it decides what is seen"}],
            "left_out": [{"what": "Breaking <waves>", "why": "no model is trusted at X band & low grazing"}],
        }


TINY = {"retrieval.cell_azimuth_deg": 6.0, "radar.prf_hz": 600.0, "radar.range_sampling_m": 2.5, "sea.extent_m": 512.0}


def small(**overrides: Any) -> Scene:
    """choppy_sea with coarse cells out to 200 m: quick, and still a full circle."""
    keys = {key.replace("__", "."): value for key, value in overrides.items()}
    return load_scene("choppy_sea", {**TINY, "radar.range_m": [15.0, 200.0], "retrieval.ground_m": 6.0, **keys})


def values(tree: xr.DataTree, path: str) -> np.ndarray:
    """The array of group/name, to be read or written."""
    group, name = path.split("/")
    return tree[group].dataset[name].values


def along(line: Line2D, axis: str) -> np.ndarray:
    return np.asarray(line.get_xdata() if axis == "x" else line.get_ydata())


def shown(axes: Axes) -> np.ma.MaskedArray[Any, Any]:
    """The values of the map that axes show."""
    return np.ma.asarray(axes.images[0].get_array())


def images_of(figure: Figure) -> list[Axes]:
    """Axes of the figure that hold a map, in the order in which they were drawn."""
    return [axes for axes in figure.axes if axes.images and axes.get_aspect() == 1.0]


@pytest.fixture(autouse=True)
def coarse_pictures(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fewer pixels, except where the page's size is tested: nothing else here looks at pixels."""
    if "page_is_whole" not in request.node.name:
        monkeypatch.setattr(style, "DPI", 40)


@pytest.fixture(scope="module")
def run() -> Run:
    return Run(small())
