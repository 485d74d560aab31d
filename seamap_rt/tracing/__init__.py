"""Which facets each antenna lights. The only users of Sionna and Mitsuba, and they only when rays are requested.

Three tracers, which must agree where all apply (`tracing.tracer`):

    facets    a shadow ray to every facet that faces the antenna, by Sionna RT/Mitsuba; float32, watertight at edges,
              through the facets that can be hit. The default: any triangulated sea.
    horizon   running maximum of the elevation angle along the mesh's own profiles, float64. For a surface with one
              height at each place; needs no backend.
    paths     a line of sight to every facet by Sionna RT's PathSolver, made deterministic. An independent reference,
              for boats at rest: a leaning mast costs a call a column.

Each facet and antenna has the field over up to two crests, taken for black straight edges, with its phase
(`diffraction`): with `tracing.diffraction = "none"` shadows are geometric.

Whichever tracer lit it, with `tracing.unresolved_shadowing = "smith"` the waves that the mesh does not carry hide a
share of each lit facet (`unresolved_waves`).

`validation.light.path_echo` asks the PathSolver for diffuse and mirror paths of one, two and three bounces, with rays
only towards the sector. It shows what a second bounce would add; the simulated echoes have one.

Objects (`[[objects]]`) hide the sea and, with `rcs_dbsm`, echo; they are fixed to the world or to the boat.

How fine the mesh is: `seamap_rt.mesh.sizing`. Evidence: validation/models/tracing.md.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..conventions import radar_wavelength
from ..settings import RadarSettings, ScatteringSettings
from .illumination import Illumination
from .unresolved_waves import UnresolvedWaves

if TYPE_CHECKING:
    from ..mesh import SurfaceMesh

Tracer = Callable[["SurfaceMesh"], Illumination]
RayScenes = dict[Any, Any]  # the scenes of `facets`, kept from mesh to mesh


def tracer(
    name: str,
    radar: RadarSettings,
    water: ScatteringSettings,
    diffraction: str = "none",
    scenes: RayScenes | None = None,
) -> Tracer:
    """The tracer of that name: `facets` (rays through a Sionna scene), `horizon` (running maximum, float64) or `paths`
    (Sionna's PathSolver, the slow reference).

    diffraction: `none`, or `knife_edge` for the field over the shadows' edges on top. scenes: those of a
    tracer `facets` that is not used any more; this one goes on with them. Raises ValueError for an unknown
    name or diffraction.
    """
    if diffraction not in ("none", "knife_edge"):
        raise ValueError(f"diffraction = '{diffraction}': must be none or knife_edge; none leaves shadows geometric")
    if name == "facets":
        from .rays import RayTracer

        trace: Tracer = RayTracer(radar, water, scenes)
    elif name == "horizon":
        from .horizon import trace_horizon

        trace = trace_horizon
    elif name == "paths":
        from .paths import PathsTracer

        trace = PathsTracer(radar)
    else:
        raise ValueError(f"tracer '{name}': must be facets, horizon or paths")
    return trace if diffraction == "none" else _add_diffraction(trace, radar_wavelength(radar.frequency_hz))


_LEAST_FIELD = 0.25  # one way, over that of free space: less returns −24 dB, to which half as many facets would add


def _add_diffraction(trace: Tracer, wavelength_m: float) -> Tracer:
    from .diffraction import diffract  # numba takes half a second to import: only where it is used

    return lambda mesh: diffract(trace(mesh), mesh, wavelength_m, _LEAST_FIELD)


__all__ = ["Illumination", "RayScenes", "Tracer", "UnresolvedWaves", "tracer"]
