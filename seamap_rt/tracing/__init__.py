"""Which facets each antenna lights. The only users of Sionna and Mitsuba, and they only when rays are asked for."""

from __future__ import annotations

from collections.abc import Callable

from ..conventions import SPEED_OF_LIGHT
from ..mesh import SurfaceMesh
from ..settings import RadarSettings, ScatteringSettings
from .illumination import Illumination

Tracer = Callable[[SurfaceMesh], Illumination]


def tracer(name: str, radar: RadarSettings, water: ScatteringSettings, diffraction: str = "none") -> Tracer:
    """The tracer of that name: `facets` (rays through a Sionna scene), `horizon` (running maximum, float64) or `paths`
    (Sionna's PathSolver, the slow reference).

    diffraction: `none`, or `knife_edge` for the field over the shadows' edges on top.
    """
    if diffraction not in ("none", "knife_edge"):
        raise ValueError(f"diffraction = '{diffraction}': must be none or knife_edge; none leaves shadows geometric")
    if name == "facets":
        from .rays import RayTracer

        trace: Tracer = RayTracer(radar, water)
    elif name == "horizon":
        from .horizon import trace_horizon

        trace = trace_horizon
    elif name == "paths":
        from .paths import PathsTracer

        trace = PathsTracer(radar)
    else:
        raise ValueError(f"tracer '{name}': must be facets, horizon or paths")
    return trace if diffraction == "none" else _over_edges(trace, SPEED_OF_LIGHT / radar.frequency_hz)


def _over_edges(trace: Tracer, wavelength_m: float) -> Tracer:
    from .diffraction import diffract  # numba takes half a second to import: only where it is used

    return lambda mesh: diffract(trace(mesh), mesh, wavelength_m)


__all__ = ["Illumination", "Tracer", "tracer"]
