"""[radar], [radar.antenna], [[radar.antennas]] and [radar.receiver]: waveform, scan, patterns and channels, and the way
from the mixer to complex gates."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Le
from pydantic import AfterValidator, BeforeValidator, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from .section import Meaning, Section, When, as_tuple

WIDEST_DEG = 25.0  # azimuth beam: three beams to either side must look ahead
_COMPUTED = When("pattern", "slotted_waveguide gaussian isotropic")
_SLOTTED = When("pattern", "slotted_waveguide")
_DIGITAL = When("chain", "digital")
_VIDEO = When("chain", "video")
_CONVERTED = When("chain", "digital video")
_CHIRP = When("waveform", "chirp")


class AntennaSettings(Section):
    """An antenna's pattern and gain, as of each of the two stacked antennas.

    A waveguide that is fed at its end looks square to its aperture at `design_frequency_hz` alone. The beam widths of a
    `slotted_waveguide` and its aperture fix the taper (Taylor's one-parameter); a taper only widens a beam.
    """

    pattern: Literal["slotted_waveguide", "gaussian", "isotropic", "file"] = "slotted_waveguide"
    """Shape of the beam; `file` is a measured pattern. The gain follows from the pattern itself."""
    file: Annotated[str | None, Meaning(left_out='no file; needed with pattern = "file"'), When("pattern", "file")] = (
        None
    )
    """Path of a measured pattern, CSV (`cut,angle_deg,gain_db`; cut azimuth or elevation) or MSI/Planet, whose vertical
    angles count downwards; a relative one counts from the scene file's folder."""
    azimuth_beamwidth_deg: Annotated[
        float,
        Gt(0.05),
        Le(WIDEST_DEG),
        Meaning("°", "one-way, −3 dB; three beams to either side must look ahead"),
        _COMPUTED,
    ] = 1.8
    """Beam width, azimuth | Beam width in azimuth, one-way at −3 dB."""
    elevation_beamwidth_deg: Annotated[float, Gt(0.5), Le(120.0), Meaning("°", "one-way, −3 dB"), _COMPUTED] = 18.0
    """Beam width, elevation | Beam width in elevation, one-way at −3 dB."""
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
    """Antenna gain | Gain of the antenna."""
    feed: Annotated[Literal["centre", "end"], _SLOTTED] = "centre"
    """Where the waveguide is fed; from its `end`, the beam squints off its design frequency."""
    design_frequency_hz: Annotated[
        float | None,
        Ge(1e9),
        Le(1e11),
        Meaning("Hz", "of an end-fed guide", left_out="radar.frequency_hz"),
        _SLOTTED,
        When("feed", "end"),
    ] = None
    """[GHz] | Frequency at which an end-fed waveguide looks square to its aperture."""
    guide_width_m: Annotated[
        float, Gt(1e-3), Le(0.2), Meaning("m", "inner width of the waveguide; WR-90"), _SLOTTED, When("feed", "end")
    ] = 0.02286
    """[mm] | Inner width of the waveguide."""

    @model_validator(mode="after")
    def _check_pattern_file(self) -> Self:
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
    """Bandwidth [MHz] | Bandwidth of the antenna itself."""
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


class ReceiverSettings(Section):
    """From the mixer to complex range gates, or to the counts of a marine radar's picture. Keys of another chain are
    ignored."""

    chain: Literal["baseband", "digital", "video"] = "baseband"
    """`baseband`: ideal complex gates; `digital`: the intermediate frequency undersampled, quantised and saturating,
    mixed down, filtered and decimated; `video`: baseband up to the detector of an ordinary marine radar, whose picture
    of each turn is written beside the echoes, `polar_images/*.pol`."""
    knee_db: Annotated[float, Ge(-60.0), Le(120.0), Meaning("dB", "over the noise, of a lin-log detector"), _VIDEO] = (
        0.0
    )
    """Knee of the video's detector: below it is linear in voltage, above it a logarithm. Assumed: at the noise."""
    video_bandwidth_hz: Annotated[
        float | None, Ge(1e5), Le(1e9), Meaning("Hz", "at −3 dB, behind the detector", left_out="no filter"), _VIDEO
    ] = None
    """Bandwidth of the video behind the detector."""
    video_pulses: Annotated[int, Ge(1), Le(1000), Meaning("1", "pulses to a radial of the picture"), _VIDEO] = 1
    """Pulses whose video is averaged to a radial of the picture."""
    if_hz: Annotated[float, Gt(0.0), Le(1e10), Meaning("Hz", "intermediate frequency"), _DIGITAL] = 160e6
    """Intermediate frequency [MHz] | Intermediate frequency."""
    adc_rate_hz: Annotated[float, Ge(1e6), Le(1e10), Meaning("Hz", "samples per second"), _DIGITAL] = 200e6
    """Converter rate [MHz] | Sampling rate of the analogue-to-digital converter."""
    adc_bits: Annotated[
        int, Ge(1), Le(24), Meaning("1", "a converter has bits; beyond 24 it would be none"), _CONVERTED
    ] = 12
    """Converter bits | Bits of the converter; the picture's words hold 12."""
    full_scale_dbm: Annotated[
        float, Ge(-120.0), Le(30.0), Meaning("dBm", "of a sine at the antenna's port"), _CONVERTED
    ] = -30.0
    """Converter full scale | Full scale of the converter, as the power of a sine at the antenna's port."""
    gain: Annotated[Literal["fixed", "agc"], _DIGITAL] = "fixed"
    """`agc`: automatic gain, which sets the full scale from the echoes of the dwell before."""
    agc_headroom_db: Annotated[
        float,
        Ge(0.0),
        Le(60.0),
        Meaning("dB", "of the full scale over the strongest echo"),
        _DIGITAL,
        When("gain", "agc"),
    ] = 6.0
    """Automatic gain headroom | Headroom that automatic gain keeps between the strongest echo and full scale."""
    stc_exponent: Annotated[float, Ge(0.0), Le(8.0), Meaning("1", "0 is none; clutter falls as 3 to 7"), _CONVERTED] = (
        0.0
    )
    """Sensitivity-time exponent | Sensitivity-time control: what comes from nearer than stc_range_m is weakened by
    (range/stc_range_m) to this, in power: before the detector of a picture; a digital chain gives it back after the
    converter."""
    stc_range_m: Annotated[
        float, Ge(1e-3), Le(20_000.0), Meaning("m", "from which on nothing is weakened"), _CONVERTED
    ] = 100.0
    """Sensitivity-time range | Range at which the sensitivity-time control ends."""


FARTHEST_M = 20_000.0


def _sector(value: tuple[float, float]) -> tuple[float, float]:
    start, stop = value
    if not (math.isfinite(start) and math.isfinite(stop)) or abs(start) > 360.0:
        raise ValueError("must be two finite angles, the first within ±360")
    if not 0.0 < stop - start <= 360.0:
        raise ValueError("must be [start, stop] with stop above start by at most 360")
    return value


def _range_window(value: tuple[float, float]) -> tuple[float, float]:
    near, far = value
    if not (math.isfinite(near) and math.isfinite(far)) or near <= 0.0 or far <= near or far > FARTHEST_M:
        raise ValueError("must be [near, far] with 0 < near < far ≤ 20000")
    return value


class RadarSettings(Section):
    """Waveform, scan, the antennas and the receiver.

    `transmit` and `interferogram` give four modes from one signal path; `seamap_rt/radar/array.py` has the table of who
    sends and who hears. A turn is not a snapshot: beside its start the map is a turn younger than on the other side.
    """

    frequency_hz: Annotated[float, Ge(3e9), Le(35e9), Meaning("Hz", "range of the scattering models")] = 10e9
    """Frequency [GHz] | Carrier frequency."""
    waveform: Literal["pulse", "chirp"] = "pulse"
    """`pulse`: rectangular, through a Gaussian filter; `chirp`: linear FM that sweeps chirp_bandwidth_hz, matched
    filter and compression_window, its near range eclipsed sample by sample."""
    pulse_width_s: Annotated[float, Ge(1e-9), Le(1e-4), Meaning("s", "as long as the transmitter is on")] = 20e-9
    """[ns] | Length of the transmitted pulse."""
    chirp_bandwidth_hz: Annotated[float, Ge(1e5), Le(1e9), Meaning("Hz", "swept by a chirp"), _CHIRP] = 50e6
    """[MHz] | Bandwidth that a chirp sweeps."""
    compression_window: Annotated[Literal["none", "hann", "hamming", "taylor"], _CHIRP] = "hamming"
    """Window of a chirp's compression: lower range sidelobes for a wider pulse."""
    bandwidth_hz: Annotated[float, Ge(1e5), Le(1e9), Meaning("Hz", "noise bandwidth of the receiver")] = 50e6
    """Bandwidth [MHz] | Noise bandwidth of the receiver."""
    prf_hz: Annotated[float, Ge(10.0), Le(1e5), Meaning("Hz", "pulses per second")] = 10e3
    """Pulse repetition [kHz] | Pulse repetition frequency."""
    transmit_power_w: Annotated[float, Ge(1e-9), Le(1e6), Meaning("W", "peak power")] = 1.0
    """Transmit power | Peak transmit power."""
    transmitter: Literal["coherent", "magnetron"] = "coherent"
    """`coherent`: all pulses start with one phase; `magnetron`: each starts with a random one, and its carrier strays
    by frequency_jitter_hz. Phases from pulse to pulse, and velocities with them, then mean something only with
    coherent_on_receive; those between the receivers of one pulse always do."""
    frequency_jitter_hz: Annotated[float, Ge(0.0), Le(1e7), Meaning("Hz", "of a magnetron, about its carrier")] = 0.0
    """Carrier of a magnetron's pulses, rms from pulse to pulse."""
    coherent_on_receive: bool = False
    """Whether the receiver measures the phase of each pulse that a magnetron sends, and takes it off."""
    transmit_phase_error_deg: Annotated[
        float, Ge(0.0), Le(90.0), Meaning("°", "beyond a quarter of a turn nothing is measured")
    ] = 3.0
    """Error of that measured phase, rms, new at each pulse."""
    noise_figure_db: Annotated[float, Ge(0.0), Le(40.0), Meaning("dB", "a receiver adds noise")] = 3.0
    """Noise figure of the receiver."""
    losses_db: Annotated[float, Ge(0.0), Le(60.0), Meaning("dB", "a loss is not negative")] = 2.0
    """System losses | System losses, there and back."""
    noise: bool = True
    """Receiver noise | Whether the receivers add noise."""
    scan: Literal["turning", "staring"] = "turning"
    """`turning`: the antenna rotates; `staring`: it stands still at the middle of the sector."""
    rotation_rpm: Annotated[
        float, Ge(1.0), Le(120.0), Meaning("1/min", "the antenna turns"), When("scan", "turning")
    ] = 60.0
    """Rotation of the antenna."""
    stare_s: Annotated[
        float,
        Ge(1e-3),
        Le(0.1),
        Meaning("s", "how long a map of a staring antenna lasts; the sea is the same all along"),
        When("scan", "staring"),
    ] = 0.05
    """[ms] | Duration of a map of a staring antenna."""
    sector_deg: Annotated[
        tuple[float, float],
        BeforeValidator(as_tuple),
        AfterValidator(_sector),
        Meaning("°", "stop lies above start by at most 360", items=({"minimum": -360.0, "maximum": 360.0},)),
    ] = (0.0, 360.0)
    """Sector that is mapped, [start, stop], clockwise from true north; yaw and squint move it."""
    range_m: Annotated[
        tuple[float, float],
        BeforeValidator(as_tuple),
        AfterValidator(_range_window),
        Meaning("m", "0 < near < far", items=({"exclusiveMinimum": 0.0, "maximum": FARTHEST_M},) * 2),
    ] = (15.0, 400.0)
    """Range window | Range window, [near, far], along the line of sight."""
    range_sampling_m: Annotated[float, Ge(0.05), Le(100.0), Meaning("m", "spacing of the range gates")] = 1.5
    """Gate spacing | Spacing of the range gates."""
    height_m: Annotated[float, Gt(0.0), Le(1000.0), Meaning("m", "mean height of the phase centres over the sea")] = 5.0
    """Antenna height (above the sea) | Mean height of the phase centres over mean sea level."""
    baseline_m: Annotated[float, Ge(0.0), Le(20.0), Meaning("m", "distance between the phase centres")] = 0.2
    """Baseline (between the antennas) | Baseline: distance between the phase centres of two stacked antennas."""
    tilt_deg: Annotated[float, Ge(-60.0), Le(60.0), Meaning("°", "beyond it the antennas lie on their backs")] = 0.0
    """Tilt of the antennas, top towards the look."""
    transmit: Literal["single", "switched"] = "switched"
    """Transmitters | `single`: one antenna alone transmits, of two stacked ones the lower; `switched`: each in turn."""
    interferogram: Literal["single_pulse", "alternating_pulse"] = "single_pulse"
    """`single_pulse`: all receivers hear each pulse; `alternating_pulse`: one receiver, which hears one antenna a pulse
    (switched: each antenna itself, whose phase is twice as steep)."""
    baseline_error_m: Annotated[float, Ge(-1.0), Le(1.0), Meaning("m", "the true baseline's excess")] = 0.0
    """What the true baseline has more than baseline_m, which the retrieval knows."""
    channel_gain_db: Annotated[float, Ge(-20.0), Le(20.0), Meaning("dB", "upper receiver over the lower")] = 0.0
    """Gain of the upper antenna's receiver over the lower's, unknown to the retrieval."""
    channel_phase_deg: Annotated[float, Ge(-360.0), Le(360.0), Meaning("°", "upper receiver over the lower")] = 0.0
    """Phase of the upper antenna's receiver over the lower's, unknown to the retrieval."""
    antenna: AntennaSettings = AntennaSettings()
    """Antenna pattern | Pattern of the antennas, `[radar.antenna]`."""
    antennas: Annotated[tuple[PlacedAntenna, ...], BeforeValidator(as_tuple)] = ()
    """Placed antennas | Any number of antennas, `[[radar.antennas]]`, each with its offset and channel; with none there
    are two, one above the other, baseline_m apart."""
    receiver: ReceiverSettings = ReceiverSettings()
    """The receiver, `[radar.receiver]`."""

    @model_validator(mode="before")
    @classmethod
    def _apply_common_antenna(cls, tree: object) -> object:
        if not isinstance(tree, dict) or not isinstance(tree.get("antennas"), list | tuple):
            return tree
        common, placed = _as_table(tree.get("antenna", {})), [_as_table(entry) for entry in tree["antennas"]]
        if common is None or any(entry is None for entry in placed):
            return tree
        merged = [common | entry for entry in placed if entry is not None]
        for whole, entry in zip(merged, placed, strict=True):
            if whole.get("pattern") != "file" and "file" not in (entry or {}):
                whole.pop("file", None)  # another pattern than the common one needs no file
        return {**tree, "antennas": merged}


def _as_table(value: object) -> dict[str, object] | None:
    """The keys that are given of an antenna, by a file or in Python; None if it is no table."""
    if isinstance(value, AntennaSettings):
        return {key: each for key, each in value.model_dump(exclude_unset=True).items() if each is not None}
    return value if isinstance(value, dict) else None
