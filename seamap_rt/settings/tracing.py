"""[tracing]: light and shadow on the sea, and how finely the sea is meshed."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le

from .section import Meaning, Section


class TracingSettings(Section):
    """What of the sea each antenna sees, and how finely the sea is meshed.

    The mesh is as fine as the maps need: a model predicts what it costs them and takes the fewest facets that meet the
    errors allowed here, never coarser than the sea's own grid, a third of the radar's range cell or three columns a
    beam. `facet_m` and `columns_per_beam`, if given, are taken as they are.
    """

    tracer: Literal["facets", "horizon", "paths"] = "facets"
    """`facets`: a shadow ray to every facet that faces the antenna, by Sionna RT/Mitsuba, on any triangulated sea;
    `horizon`: running maximum of the elevation angle along the mesh's own profiles, for a sea that stands once over
    each place, without a ray tracing backend; `paths`: a line of sight to every facet by Sionna RT's PathSolver, an
    independent and slower reference."""
    diffraction: Literal["none", "knife_edge"] = "none"
    """`none`: geometric shadows; `knife_edge`: the field over up to two crests, with its phase, at each facet and
    antenna."""
    unresolved_shadowing: Literal["none", "fresnel", "smith"] = "none"
    """Shadows of waves that the mesh does not carry. `none`: they cast none; `smith`: they hide what they would hide
    from light. Of each lit facet that share is in sight and echoes which Smith (1967) gives for the slopes of the
    wind's short waves and the facet's own grazing angle; `fresnel`: what they hide keeps the share of its echo that
    bends into shadows of their size, a third to a half in VV. Wave optics lies between `none` and `smith`; cells more
    than half visible change by 0.03 dB."""
    height_error_m: Annotated[float, Ge(1e-4), Le(10.0), Meaning("m", "an error is more than nothing")] = 0.02
    """What the mesh may cost the maps' heights: rms over cells more than half visible, in the expectation over
    speckle."""
    visible_error: Annotated[
        float | None, Ge(1e-3), Le(1.0), Meaning("1", "a share of a cell", left_out="no target")
    ] = None
    """What the mesh may cost a cell's visible share, rms."""
    facet_m: Annotated[
        float | None,
        Ge(0.02),
        Le(20.0),
        Meaning("m", "spacing of the mesh along the look", left_out="by the errors allowed"),
    ] = None
    """Spacing of the mesh along the look."""
    columns_per_beam: Annotated[
        int | None,
        Ge(3),
        Le(64),
        Meaning(
            "1", "fewer than 3 alias the two-way pattern, more than 64 gain nothing", left_out="by the errors allowed"
        ),
    ] = None
    """Columns of the mesh within a beam width."""
