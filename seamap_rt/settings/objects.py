"""[[objects]], which hide the sea and echo, and [[gauges]], virtual wave gauges."""

from __future__ import annotations

import re
from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Le
from pydantic import AfterValidator, BeforeValidator, model_validator

from ..conventions import unit_from_azimuth
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


_NAME = r"[A-Za-z0-9][A-Za-z0-9 ._+-]{0,39}"


def _gauge_name(name: str) -> str:
    if not re.fullmatch(_NAME, name):
        raise ValueError("must be 1 to 40 letters, digits, blanks and . _ + -, the first a letter or digit")
    return name


Coordinate = Annotated[float, Ge(-20_000.0), Le(20_000.0)]


class GaugeSettings(Section):
    """A virtual wave gauge: a wire, fixed to the ground, that reads the surface where it stands.

    The radar's map is read beside it once a turn. It stands where `east_m` and `north_m` say or where `ground_range_m`
    and `azimuth_deg` say, counted from the origin, the foot of the mast at time 0.
    """

    name: Annotated[str, AfterValidator(_gauge_name), Meaning(pattern=f"^{_NAME}$")]
    """Name of the gauge, its own."""
    east_m: Annotated[
        Coordinate | None, Meaning("m", "a position in the scene", left_out="by `ground_range_m` and `azimuth_deg`")
    ] = None
    """Distance east of the origin; together with `north_m`."""
    north_m: Annotated[
        Coordinate | None, Meaning("m", "a position in the scene", left_out="by `ground_range_m` and `azimuth_deg`")
    ] = None
    """Distance north of the origin; together with `east_m`."""
    ground_range_m: Annotated[
        float | None, Ge(0.0), Le(20_000.0), Meaning("m", "a distance", left_out="by `east_m` and `north_m`")
    ] = None
    """Horizontal distance from the origin; together with `azimuth_deg`."""
    azimuth_deg: Annotated[
        Direction | None,
        compass("Azimuth from the origin, together with `ground_range_m`", left_out="by `east_m` and `north_m`"),
    ] = None
    sample_hz: Annotated[float, Ge(0.1), Le(1000.0), Meaning("Hz", "readings a second of the wire")] = 4.0
    """Readings a second of the wire; one rate for all gauges."""

    @model_validator(mode="after")
    def _position_is_given_once(self) -> Self:
        square = (self.east_m is not None, self.north_m is not None)
        polar = (self.ground_range_m is not None, self.azimuth_deg is not None)
        if (all(square), any(polar)) != (True, False) and (any(square), all(polar)) != (False, True):
            raise ValueError(
                "give its position either by east_m and north_m or by ground_range_m and azimuth_deg, not by "
                + ("a mixture" if any(square + polar) else "nothing")
            )
        return self

    @property
    def position(self) -> tuple[float, float]:
        """East and north of the origin [m]."""
        if self.east_m is not None and self.north_m is not None:
            return self.east_m, self.north_m
        assert self.ground_range_m is not None
        assert self.azimuth_deg is not None
        east, north = unit_from_azimuth(self.azimuth_deg)
        return self.ground_range_m * float(east), self.ground_range_m * float(north)
