"""What a run says of itself in metrics.json: what was modelled and left out, the mesh, and which waves are resolved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from ..conventions import db
from ..echoes.radar_cross_section import SeaSurface
from ..io.text import plain
from ..scattering import ShortWaves
from ..scene import Scene
from ..sea import Sea, spectral_system
from ..settings import RandomWaves
from .limits import costed, left_out, modelled


def run_facts(scene: Scene, sea: Sea, surface: SeaSurface, timing: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """The keys `modelled`, `left_out`, `mesh`, `sea`, `short_waves` and `calibration` of metrics.json.

    sea, surface: the run's own, of its Simulator. timing: `timing_s` of metrics.json; adds to the rows of `modelled`
    what each took.
    """
    rows = modelled(scene, sea.resolved)
    return {
        "modelled": rows if timing is None else costed(rows, timing),
        "left_out": left_out(scene, sea.resolved),
        "mesh": scene.detail.facts(),
        "sea": {name: plain(value) for name, value in asdict(sea.resolved).items()},
        "short_waves": _short_waves(scene, sea),
        "calibration": _calibration(scene, surface),
    }


def _calibration(scene: Scene, surface: SeaSurface) -> dict[str, list[float]] | None:
    """How many dB the calibration adds to what theory gives, by grazing angle and direction; None without one."""
    scale = surface.scale
    if scale is None:
        return None
    (near, far), height = scene.radar.range_m, scene.radar.height_m
    grazing = np.geomspace(np.arcsin(height / far), np.arcsin(min(1.0, height / near)), 5)
    looks = {"up_wind_db": 0.0, "cross_wind_db": 0.5 * np.pi, "down_wind_db": np.pi}
    added = {name: db(scale(grazing, angle)).tolist() for name, angle in looks.items()}
    return {"grazing_deg": np.degrees(grazing).tolist(), **added}


def _short_waves(scene: Scene, sea: Sea) -> dict[str, float] | None:
    """What the scattering takes over from the mesh; None where its level is a given."""
    scattering, limit = scene.scattering, sea.resolved.wavenumber_limit
    if scattering.nrcs != "two_scale":
        return None
    waves = ShortWaves.of(scattering, limit)
    systems = [spectral_system(each, scene.sea.depth_m) for each in scene.sea.waves if isinstance(each, RandomWaves)]
    step = waves.level_step_db(lambda k: np.asarray(sum((system.radial(k) for system in systems), np.zeros(k.size))))
    slope = sea.resolved.mean_square_slope
    return {
        "wavenumber_from": limit,
        "variance": waves.variance,
        "mean_square_slope": waves.mean_square_slope,
        "resolved_slope_share": slope / (slope + waves.mean_square_slope),
        "level_step_db": step,
    }
