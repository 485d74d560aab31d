"""What an X-band interferometric radar on a small boat's mast can see of the sea around it.

    scene = load_scene("scenes/choppy_sea.toml")
    simulation = simulate(scene)                 # echoes and truth
    maps = retrieve(simulation.echoes)           # heights and slopes; never sees the truth
    compared = compare(maps, simulation.truth)   # errors of height by range, and over all

Names are loaded when first used, so that a retrieval loads neither Dr.Jit nor Mitsuba.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .lazy import judge, lazy_attributes

__version__ = "0.1.0"

if TYPE_CHECKING:
    from validation import analytic

    from . import echoes, figures, prediction, scattering, sea, studies
    from .design_outlook import outlook
    from .errors import InputError, NoBackendError, ResourceError, SchemaError
    from .gauges import gauge_series
    from .inspection import Finding, inspect
    from .interferometry import echoes_from_recording, open_recording, retrieve
    from .io.exports import export
    from .io.polar_images import read_polar_images
    from .io.process import progress
    from .io.radial_volume import read_radial_volume, write_radial_volume
    from .metrics import compare
    from .prediction import WaveField, advise, forecast, highest_wave, quiet_windows, reconstruct
    from .scene import Scene, load_scene
    from .session import FinishedTurn, RunResult, Simulation, iterate, run, simulate
    from .simulation import expected
    from .wavefield import sea_state

__all__ = [
    "Finding",
    "FinishedTurn",
    "InputError",
    "NoBackendError",
    "ResourceError",
    "RunResult",
    "Scene",
    "SchemaError",
    "Simulation",
    "WaveField",
    "advise",
    "analytic",
    "compare",
    "echoes",
    "echoes_from_recording",
    "expected",
    "export",
    "figures",
    "forecast",
    "gauge_series",
    "highest_wave",
    "inspect",
    "iterate",
    "load_scene",
    "open_recording",
    "outlook",
    "prediction",
    "progress",
    "quiet_windows",
    "read_polar_images",
    "read_radial_volume",
    "reconstruct",
    "retrieve",
    "run",
    "scattering",
    "sea",
    "sea_state",
    "simulate",
    "studies",
    "write_radial_volume",
]


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


_attribute = lazy_attributes(
    __name__,
    {
        ".": "echoes figures prediction scattering sea studies",
        "design_outlook": "outlook",
        "errors": "InputError NoBackendError ResourceError SchemaError",
        "gauges": "gauge_series",
        "inspection": "Finding inspect",
        "interferometry": "echoes_from_recording open_recording retrieve",
        "io.exports": "export",
        "io.process": "progress",
        "io.polar_images": "read_polar_images",
        "io.radial_volume": "read_radial_volume write_radial_volume",
        "metrics": "compare",
        "prediction": "WaveField advise forecast highest_wave quiet_windows reconstruct",
        "scene": "Scene load_scene",
        "session": "FinishedTurn RunResult Simulation iterate run simulate",
        "simulation": "expected",
        "wavefield": "sea_state",
    },
    {"NoBackend": "NoBackendError"},
)


def __getattr__(name: str) -> Any:
    if name == "analytic":  # the judge's closed forms, where it is installed
        return judge("analytic")
    return _attribute(name)
