"""[[objects]]: things in the scene that hide the sea and echo."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le
from pydantic import BeforeValidator

from .section import Direction, Meaning, Section, as_tuple, compass

_Component = Annotated[
    float, Ge(-30_000.0), Le(30_000.0), Meaning("m", "an object stands in the scene", text="A component.")
]


class ObjectSettings(Section):
    """A thing in the scene: it hides the sea behind it, and echoes with its radar cross-section.

    Its own height counts in the maps' error figures, which are held against the sea.
    """

    mesh: str
    """Path of an STL, GLB, OBJ, PLY or Collada mesh, z up, y ahead; a relative one counts from the scene file's
    folder."""
    position_m: Annotated[tuple[_Component, _Component, _Component], BeforeValidator(as_tuple), Meaning("m")]
    """Position: east, north, up of mean sea level at the origin; of an object fixed to the boat starboard, forward, up
    from the waterline at the foot of the mast."""
    heading_deg: Annotated[Direction, compass("Where its y axis points")] = 0.0
    scale: Annotated[float, Gt(0.0), Le(1e4), Meaning("1", "metres per unit of the file")] = 1.0
    """Factor from the file's unit to metres."""
    rcs_dbsm: Annotated[
        float | None,
        Ge(-100.0),
        Le(80.0),
        Meaning("dBsm", "in sight as a whole", left_out="it hides and echoes nothing"),
    ] = None
    """Radar cross-section, mean over its speckle while it is wholly in sight, over 1 m²."""
    fixed_to: Literal["world", "boat"] = "world"
    """To what it is fixed; with the `boat` it turns."""
