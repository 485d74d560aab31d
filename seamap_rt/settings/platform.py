"""[platform] and [platform.sensors]: the boat, how it moves, and how it measures that; and what else is in the scene:
[[objects]], which hide the sea and echo, and [[gauges]], virtual wave gauges."""

from __future__ import annotations

import math
import re
from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Le
from pydantic import AfterValidator, BeforeValidator, model_validator

from ..conventions import unit_from_azimuth
from .radar import Offset
from .section import Direction, Meaning, Phase, Section, When, as_tuple, compass

_UNRECORDED = When("motion", "fixed sinusoidal wave_following")
_SINUSOIDAL = When("motion", "sinusoidal")
_FOLLOWING = When("motion", "wave_following")

Period = Annotated[float, Ge(0.5), Le(300.0)]
Angle = Annotated[float, Ge(0.0), Le(45.0)]
Bias = Annotated[float, Ge(-45.0), Le(45.0)]
Noise = Annotated[float, Ge(0.0), Le(45.0)]
HeightBias = Annotated[float, Ge(-20.0), Le(20.0)]
PositionNoise = Annotated[float, Ge(0.0), Le(20.0)]


_SAID = {  # of keys that are alike: the reason of their limits, and what they are
    "amplitude": ("an amplitude", 'Amplitude of {}; 0 unless motion = "sinusoidal".'),
    "period": ("a boat answers waves of 0.5 s and more", "Period of {}."),
    "phase": ("a phase", "Phase of {} at time 0."),
    "bias": ("a sensor that errs by more is broken", "Constant error of the measured {}."),
    "noise": ("rms of one reading", "Random error of each reading of {}, rms."),
    "accuracy": ("rms", "Constant error of {} as its maker states it, rms."),
}


def _meaning(what: str, of: str, unit: str) -> Meaning:
    reason, text = _SAID[what]
    return Meaning(unit, reason, text=text.format(of))


class SensorErrors(Section):
    """What is known of the errors of motion sensors: sizes, of which error bars are made; none unless given."""

    attitude_noise_deg: Annotated[Noise, _meaning("noise", "roll and pitch", "°")] = 0.0
    heading_noise_deg: Annotated[Noise, _meaning("noise", "heading", "°")] = 0.0
    position_noise_m: Annotated[PositionNoise, _meaning("noise", "position", "m")] = 0.0
    attitude_accuracy_deg: Annotated[Noise, _meaning("accuracy", "roll and pitch", "°")] = 0.0
    heading_accuracy_deg: Annotated[Noise, _meaning("accuracy", "heading", "°")] = 0.0
    height_accuracy_m: Annotated[PositionNoise, _meaning("accuracy", "height", "m")] = 0.0
    rate_hz: Annotated[float, Ge(0.1), Meaning("Hz", "readings a second", infinite=True)] = math.inf
    """Readings a second; inf is one at every pulse."""
    latency_s: Annotated[float, Ge(0.0), Le(10.0), Meaning("s", "age of a reading")] = 0.0
    """Age of a reading: it reports the motion of that long before."""

    @property
    def attributes(self) -> dict[str, float]:
        """As echoes carry them: sizes of errors, never an error itself."""
        sizes = {f"sensors_{key}": float(getattr(self, key)) for key in SensorErrors.model_fields}
        return {name: value for name, value in sizes.items() if math.isfinite(value)}


class SensorSettings(SensorErrors):
    """How the boat measures its own motion: without error unless given.

    The true motion moves the antennas; the measured one goes to the retrieval, interpolated between readings, without
    the biases: of these it knows what the accuracies state.
    """

    roll_bias_deg: Annotated[Bias, _meaning("bias", "roll", "°")] = 0.0
    pitch_bias_deg: Annotated[Bias, _meaning("bias", "pitch", "°")] = 0.0
    heading_bias_deg: Annotated[Bias, _meaning("bias", "heading", "°")] = 0.0
    height_bias_m: Annotated[HeightBias, _meaning("bias", "height", "m")] = 0.0


class PlatformSettings(Section):
    """The boat: its course, how it moves about it, and what its sensors measure of that.

    Signs: roll + starboard down, pitch + bow up, heading clockwise from north.
    """

    motion: Literal["fixed", "sinusoidal", "wave_following", "file"] = "fixed"
    """`fixed` keeps its attitude; `sinusoidal` rolls, pitches, yaws and heaves by the amplitudes below;
    `wave_following` rides the very waves that the radar sees, as far as length and beam let it; `file` is a recorded
    motion."""
    speed_m_s: Annotated[
        float, Ge(0.0), Le(30.0), Meaning("m/s", "through the scene, along the heading"), _UNRECORDED
    ] = 0.0
    """Speed along the heading."""
    heading_deg: Annotated[Direction, compass("Heading of the bow")] = 0.0
    list_deg: Annotated[float, Ge(-45.0), Le(45.0), Meaning("°", "beyond it the boat capsizes"), _UNRECORDED] = 0.0
    """List to starboard | Roll at rest, starboard down."""
    trim_deg: Annotated[float, Ge(-45.0), Le(45.0), Meaning("°", "beyond it the boat founders"), _UNRECORDED] = 0.0
    """Trim, bow up | Pitch at rest, bow up."""
    roll_deg: Annotated[Angle, _meaning("amplitude", "roll", "°"), _SINUSOIDAL] = 0.0
    roll_period_s: Annotated[Period, _meaning("period", "roll", "s"), _SINUSOIDAL] = 4.0
    roll_phase_deg: Annotated[Phase, _meaning("phase", "roll", "°"), _SINUSOIDAL] = 0.0
    pitch_deg: Annotated[Angle, _meaning("amplitude", "pitch", "°"), _SINUSOIDAL] = 0.0
    pitch_period_s: Annotated[Period, _meaning("period", "pitch", "s"), _SINUSOIDAL] = 5.0
    pitch_phase_deg: Annotated[Phase, _meaning("phase", "pitch", "°"), _SINUSOIDAL] = 0.0
    yaw_deg: Annotated[Angle, _meaning("amplitude", "yaw", "°"), _SINUSOIDAL] = 0.0
    yaw_period_s: Annotated[Period, _meaning("period", "yaw", "s"), _SINUSOIDAL] = 8.0
    yaw_phase_deg: Annotated[Phase, _meaning("phase", "yaw", "°"), _SINUSOIDAL] = 0.0
    heave_m: Annotated[float, Ge(0.0), Le(20.0), Meaning("m", "an amplitude"), _SINUSOIDAL] = 0.0
    """Amplitude of heave; 0 unless motion = "sinusoidal"."""
    heave_period_s: Annotated[Period, _meaning("period", "heave", "s"), _SINUSOIDAL] = 5.0
    heave_phase_deg: Annotated[Phase, _meaning("phase", "heave", "°"), _SINUSOIDAL] = 0.0
    file: Annotated[str | None, Meaning(left_out='no file; needed with motion = "file"'), When("motion", "file")] = None
    """Path of a recorded motion: CSV with `time_s` and any of `roll_deg`, `pitch_deg`, `heading_deg`, `heave_m`, `x_m`,
    `y_m`; a relative one counts from the scene file's folder."""
    length_m: Annotated[float, Gt(0.1), Le(300.0), Meaning("m", "of the boat's waterline"), _FOLLOWING] = 7.0
    """Length of the boat, where it follows the waves."""
    beam_m: Annotated[float, Gt(0.1), Le(60.0), Meaning("m", "of the boat's waterline"), _FOLLOWING] = 2.5
    """Beam of the boat, where it follows the waves."""
    lever_arm_m: Annotated[
        Offset | None, Meaning("m", left_out="that point lies at the waterline straight below the antennas")
    ] = None
    """Vector from the point about which the boat turns to the middle of the antennas: starboard, forward, up."""
    sensors: SensorSettings = SensorSettings()
    """Motion sensors | The motion sensors, `[platform.sensors]`."""

    @model_validator(mode="after")
    def _check_motion_keys(self) -> Self:
        if (self.motion == "file") != bool(self.file):
            raise ValueError("give motion = 'file' and file = '…' together: one says what the other is for")
        if self.motion == "file" and (self.speed_m_s or self.list_deg or self.trim_deg):
            raise ValueError("speed_m_s, list_deg and trim_deg: must be 0 with motion = 'file'; the file holds them")
        if self.motion != "sinusoidal":
            for key in ("roll_deg", "pitch_deg", "yaw_deg", "heave_m"):
                if getattr(self, key):
                    raise ValueError(
                        f"{key} = {getattr(self, key):g}: is an amplitude, and must be 0 unless motion = 'sinusoidal'; "
                        "set that, or give a steady attitude by list_deg and trim_deg"
                    )
        return self


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
    """Radar cross-section | Radar cross-section, mean over its speckle while it is wholly in sight, over 1 m²."""
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
    def _check_position(self) -> Self:
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
