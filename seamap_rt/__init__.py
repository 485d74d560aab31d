"""What an X-band interferometric radar on a small boat's mast can see of the sea around it.

    scene = load_scene("scenes/choppy_sea.toml")
    simulation = simulate(scene)                 # echoes and truth
    maps = retrieve(simulation.echoes)           # heights and slopes; never sees the truth
    compared = compare(maps, simulation.truth)   # errors of height by range, and over all

Names are loaded when first used, so that a retrieval loads neither Dr.Jit nor Mitsuba.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from . import analytic, echoes, prediction, scattering, sea, studies
    from .design_outlook import outlook
    from .errors import InputError, NoBackend
    from .gauges import gauge_series
    from .inspection import inspect
    from .interferometry import echoes_from_recording, open_recording, retrieve
    from .io.exports import export
    from .metrics import compare
    from .prediction import forecast, highest_wave, quiet_windows, reconstruct
    from .scene import Scene, load_scene
    from .session import Simulation, iterate, run, simulate
    from .simulation import expected
    from .wavefield import sea_state

_HOMES = {
    "InputError": "errors",
    "NoBackend": "errors",
    "Scene": "scene",
    "Simulation": "session",
    "compare": "metrics",
    "echoes_from_recording": "interferometry",
    "expected": "simulation",
    "export": "io.exports",
    "forecast": "prediction",
    "gauge_series": "gauges",
    "highest_wave": "prediction",
    "inspect": "inspection",
    "iterate": "session",
    "load_scene": "scene",
    "open_recording": "interferometry",
    "outlook": "design_outlook",
    "quiet_windows": "prediction",
    "reconstruct": "prediction",
    "retrieve": "interferometry",
    "run": "session",
    "sea_state": "interferometry",
    "simulate": "session",
}
_PACKAGES = ("analytic", "echoes", "prediction", "scattering", "sea", "studies")

__all__ = [
    "InputError",
    "NoBackend",
    "Scene",
    "Simulation",
    "analytic",
    "compare",
    "echoes",
    "echoes_from_recording",
    "expected",
    "export",
    "forecast",
    "gauge_series",
    "highest_wave",
    "inspect",
    "iterate",
    "load_scene",
    "open_recording",
    "outlook",
    "prediction",
    "quiet_windows",
    "reconstruct",
    "retrieve",
    "run",
    "scattering",
    "sea",
    "sea_state",
    "simulate",
    "studies",
]


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


def __getattr__(name: str) -> Any:
    if name in _PACKAGES:
        return importlib.import_module(f".{name}", __name__)
    if name in _HOMES:
        return getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
