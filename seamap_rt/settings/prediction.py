"""[prediction]: how a wave field is fitted to the maps, how far ahead it is asked, and what a crew asks of it."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Le, Lt
from pydantic import model_validator

from .section import Direction, Meaning, Section, compass


def _size(text: str, shapes: str) -> Meaning:
    return Meaning("m", "sizes of boats", left_out="none: the shape needs no such", text=f"{text}; of {shapes}.")


Size = Annotated[float, Gt(0.0), Le(300.0)]


class VesselSettings(Section):
    """The vessel whose heave, roll and pitch are forecast.

    `raft` follows the surface; `disc` is a buoy; `box` a box-shaped boat; `file` a NetCDF file of Capytaine.
    """

    shape: Literal["none", "raft", "disc", "box", "file"] = "none"
    """Which vessel: none forecasts the water alone."""
    length_m: Annotated[Size | None, _size("Length", "`box`")] = None
    beam_m: Annotated[Size | None, _size("Beam", "`box`; diameter of `disc`")] = None
    draught_m: Annotated[Size | None, _size("Draught", "`box` and `disc`")] = None
    roll_period_s: Annotated[
        float | None, Gt(0.0), Le(60.0), Meaning("s", "periods of boats", left_out="by the box's stability")
    ] = None
    """Natural period of roll, of `box`."""
    file: Annotated[str | None, Meaning(left_out="none: only the shape file needs one")] = None
    """Path of a NetCDF file of Capytaine, of `file`; a relative one counts from the scene file's folder."""
    body: Annotated[str | None, Meaning(left_out="the only one there")] = None
    """Which body of `file`: the name before `__Heave`. Others are there, and held fast."""
    symmetry: Annotated[
        Literal["sides", "sides_and_ends", "round"] | None, Meaning(left_out="none: the file has all directions")
    ] = None
    """What gives the directions of waves that `file` leaves out: with `sides` port is like starboard, with
    `sides_and_ends` bow like stern too, with `round` all directions are alike, and one is enough."""

    @model_validator(mode="after")
    def _sizes_are_those_of_the_shape(self) -> Self:
        needed = {"disc": ("beam_m", "draught_m"), "box": ("length_m", "beam_m", "draught_m"), "file": ("file",)}
        also = {"box": ("roll_period_s",), "file": ("body", "symmetry")}
        mine = needed.get(self.shape, ())
        for name in ("length_m", "beam_m", "draught_m", "roll_period_s", "file", "body", "symmetry"):
            given = getattr(self, name) is not None
            if name in mine and not given:
                raise ValueError(f'{name} is missing; shape = "{self.shape}" needs it')
            if given and name not in (*mine, *also.get(self.shape, ())):
                raise ValueError(f'{name} is given, but shape = "{self.shape}" has none; leave it out')
        return self


def _limit(text: str, unit: str) -> Meaning:
    return Meaning(unit, "a limit", left_out="it is not limited", text=f"{text} stays below, in magnitude.")


class QuietSettings(Section):
    """What a quiet window is: limits that all hold for a time. None is looked for where no limit is given."""

    elevation_m: Annotated[float | None, Gt(0.0), Le(30.0), _limit("What the water's height", "m")] = None
    velocity_z_m_s: Annotated[float | None, Gt(0.0), Le(30.0), _limit("What the water's speed upwards", "m/s")] = None
    heave_m: Annotated[float | None, Gt(0.0), Le(30.0), _limit("What the vessel's heave", "m")] = None
    roll_deg: Annotated[float | None, Gt(0.0), Le(90.0), _limit("What the vessel's roll", "°")] = None
    pitch_deg: Annotated[float | None, Gt(0.0), Le(90.0), _limit("What the vessel's pitch", "°")] = None
    duration_s: Annotated[float, Gt(0.0), Le(30.0), Meaning("s", "what is predictable")] = 5.0
    """How long a window lasts."""
    confidence: Annotated[float, Gt(0.0), Lt(1.0), Meaning("1", "a probability")] = 0.9
    """Probability from which on a window is called."""

    @property
    def limits(self) -> dict[str, float]:
        """By the names of what is forecast."""
        given = {
            "elevation": self.elevation_m,
            "velocity_z": self.velocity_z_m_s,
            "heave": self.heave_m,
            "roll": self.roll_deg,
            "pitch": self.pitch_deg,
        }
        return {name: limit for name, limit in given.items() if limit is not None}


class PredictionSettings(Section):
    """From maps to a forecast: of the sea, of a vessel in it, and of quiet windows."""

    turns: Annotated[int, Ge(1), Le(40), Meaning("1", "turns that the fit holds")] = 10
    """How many turns' maps a wave field rests on."""
    lead_s: Annotated[float, Ge(0.0), Le(60.0), Meaning("s", "beyond it the sea is not predictable")] = 30.0
    """How far ahead forecasts are made."""
    sharpness: Annotated[
        float | None,
        Ge(0.0),
        Le(1.0),
        Meaning("1", "from linear to first-order Lagrangian waves", left_out="as the maps show it"),
    ] = None
    """How far the water is moved by its own waves: 0 for waves of Airy, 1 for first-order Lagrangian ones."""
    amplitude_dispersion: Annotated[
        float | None, Ge(0.0), Le(1.0), Meaning("1", "from linear to third-order waves", left_out="as the maps show it")
    ] = None
    """How far waves run faster by the sea's own height: 0 for waves of Airy, 1 for the whole of what the third order in
    steepness adds on deep water."""
    heading_deg: Annotated[
        Direction | None,
        compass("Heading of the vessel while it runs on", left_out="the heading of the boat; north for maps alone"),
    ] = None
    speed_m_s: Annotated[
        float | None, Ge(0.0), Le(30.0), Meaning("m/s", "of boats", left_out="the speed of the boat; 0 for maps alone")
    ] = None
    """Speed over ground along that heading."""
    vessel: VesselSettings = VesselSettings()
    """What floats there."""
    quiet: QuietSettings = QuietSettings()
    """What counts as quiet."""

    @model_validator(mode="after")
    def _motions_are_of_a_vessel(self) -> Self:
        motions = sorted(set(self.quiet.limits) & {"heave", "roll", "pitch"})
        if motions and self.vessel.shape == "none":
            raise ValueError(f"quiet limits {motions[0]}, but there is no vessel; give vessel.shape")
        if self.quiet.limits and self.quiet.duration_s > self.lead_s:
            raise ValueError(
                f"quiet.duration_s = {self.quiet.duration_s:g}: is longer than lead_s = {self.lead_s:g}; shorten it"
            )
        return self
