"""[radar.antenna] and [[radar.antennas]]: patterns, offsets and channels."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Le
from pydantic import BeforeValidator, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from .section import Meaning, Section, as_tuple

WIDEST_DEG = 25.0  # azimuth beam: three beams to either side must look ahead


class AntennaSettings(Section):
    """An antenna's pattern and gain, as of each of the two stacked antennas.

    A waveguide that is fed at its end looks square to its aperture at `design_frequency_hz` alone. The beam widths of a
    `slotted_waveguide` and its aperture fix the taper (Taylor's one-parameter); a taper only widens a beam.
    """

    pattern: Literal["slotted_waveguide", "gaussian", "isotropic", "file"] = "slotted_waveguide"
    """Shape of the beam; `file` is a measured pattern. The gain follows from the pattern itself."""
    file: Annotated[str | None, Meaning(left_out='no file; needed with pattern = "file"')] = None
    """Path of a measured pattern, CSV (`cut,angle_deg,gain_db`; cut azimuth or elevation) or MSI/Planet, whose vertical
    angles count downwards; a relative one counts from the scene file's folder."""
    azimuth_beamwidth_deg: Annotated[
        float, Gt(0.05), Le(WIDEST_DEG), Meaning("°", "one-way, −3 dB; three beams to either side must look ahead")
    ] = 1.8
    """Beam width in azimuth, one-way at −3 dB."""
    elevation_beamwidth_deg: Annotated[float, Gt(0.5), Le(120.0), Meaning("°", "one-way, −3 dB")] = 18.0
    """Beam width in elevation, one-way at −3 dB."""
    width_m: Annotated[float, Gt(0.0), Le(20.0), Meaning("m", "aperture width")] = 1.0
    """Width of the aperture."""
    height_m: Annotated[float, Gt(0.0), Le(5.0), Meaning("m", "aperture height")] = 0.1
    """Height of the aperture."""
    ohmic_loss_db: Annotated[float, Ge(0.0), Le(20.0), Meaning("dB", "a loss is not negative")] = 0.0
    """Ohmic loss of the antenna."""
    gain_dbi: Annotated[
        float | None,
        Ge(-20.0),
        Le(60.0),
        Meaning("dBi", "overrides directivity − ohmic loss", left_out="directivity of the pattern less ohmic_loss_db"),
    ] = None
    """Gain of the antenna."""
    feed: Literal["centre", "end"] = "centre"
    """Where the waveguide is fed; from its `end`, the beam squints off its design frequency."""
    design_frequency_hz: Annotated[
        float | None, Ge(1e9), Le(1e11), Meaning("Hz", "of an end-fed guide", left_out="radar.frequency_hz")
    ] = None
    """Frequency at which an end-fed waveguide looks square to its aperture."""
    guide_width_m: Annotated[float, Gt(1e-3), Le(0.2), Meaning("m", "inner width of the waveguide; WR-90")] = 0.02286
    """Inner width of the waveguide."""

    @model_validator(mode="after")
    def _file_goes_with_its_pattern(self) -> Self:
        if (self.pattern == "file") != bool(self.file):
            raise ValueError("give pattern = 'file' and file = '…' together: one says what the other is for")
        return self


_Component = Annotated[
    float, Ge(-100.0), Le(100.0), Meaning("m", "antennas and boat lie within ±100 m", text="A component.")
]
Offset = Annotated[tuple[_Component, _Component, _Component], BeforeValidator(as_tuple)]


class PlacedAntenna(AntennaSettings):
    """One of any number of antennas; pattern keys that are left out are those of [radar.antenna].

    The short form, `radar.baseline_m` and what belongs to it, is two stacked antennas without this list.
    """

    offset_m: Annotated[Offset, Meaning("m")]
    """Offset of its phase centre from the point that stands radar.height_m above the sea: along the aperture to the
    right, along the boresight ahead, up."""
    offset_error_m: Annotated[Offset, Meaning("m")] = (0.0, 0.0, 0.0)
    """What the true offset has more than offset_m, which the retrieval knows."""
    role: Literal["tx", "rx", "both"] = "both"
    """Whether it transmits, receives or both."""
    bandwidth_hz: Annotated[
        float | None, Ge(1e6), Le(1e11), Meaning("Hz", "of the antenna itself", left_out="no limit")
    ] = None
    """Bandwidth of the antenna itself."""
    channel_gain_db: Annotated[float, Ge(-20.0), Le(20.0), Meaning("dB", "of its receiver over the others'")] = 0.0
    """Gain of its receiver over the others', unknown to the retrieval."""
    channel_phase_deg: Annotated[float, Ge(-360.0), Le(360.0), Meaning("°", "of its receiver over the others'")] = 0.0
    """Phase of its receiver over the others', unknown to the retrieval."""

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """A pattern key has no default of its own here."""
        stated = super().__get_pydantic_json_schema__(schema, handler)
        properties = handler.resolve_ref_schema(stated)["properties"]
        for name in AntennaSettings.model_fields:
            properties[name].pop("default", None)
            properties[name]["left_out"] = f"that of radar.antenna.{name}"
        return stated
