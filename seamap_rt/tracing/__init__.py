"""Which facets each antenna lights. The only users of Sionna and Mitsuba, and they only when rays are asked for."""

from __future__ import annotations

from collections.abc import Callable

from ..mesh import Facets, SurfaceMesh
from ..settings import RadarSettings, ScatteringSettings

Tracer = Callable[[SurfaceMesh], Facets]


def tracer(name: str, radar: RadarSettings, water: ScatteringSettings) -> Tracer:
    """The tracer of that name: `facets` (rays through a Sionna scene) or `horizon` (running maximum, float64)."""
    if name == "facets":
        from .rays import RayTracer

        return RayTracer(radar, water)
    if name == "horizon":
        from .horizon import trace_horizon

        return trace_horizon
    raise ValueError(f"tracer '{name}': must be facets or horizon")


__all__ = ["Tracer", "tracer"]
