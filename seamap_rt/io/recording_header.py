"""The header of a recording: what its arrays do not say of the radar, checked for slips of the unit."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from annotated_types import Ge, Gt, Le
from pydantic import BeforeValidator, model_validator

from ..errors import InputError, say_of
from ..settings import Meaning, Section, SensorErrors, as_tuple
from .opening import read_json
from .scenefile import read_toml
from .text import plain_attribute, shown, to_builtin
from .validation import validate

Header = Mapping[str, Any] | str | os.PathLike[str]

PRF_HZ = (5.0, 1e7)  # a rate outside is in another unit


class RecordingHeader(Section):
    """What the arrays of a recording do not say; limits are those of the SI, so that another unit is found."""

    frequency_hz: Annotated[float, Ge(1e8), Le(1e12), Meaning("Hz", "a carrier")]
    """Carrier frequency."""
    pulse_width_s: Annotated[float, Gt(0.0), Le(1e-2), Meaning("s", "as long as the transmitter is on")]
    """Length of the transmitted pulse."""
    bandwidth_hz: Annotated[float, Ge(1e4), Le(1e11), Meaning("Hz", "noise bandwidth of the receiver")]
    """Noise bandwidth of the receiver."""
    height_m: Annotated[float, Gt(0.0), Le(1e4), Meaning("m", "of the antennas' middle over the sea")]
    """Mean height of the antennas over mean sea level."""
    baseline_m: Annotated[float, Gt(0.0), Le(100.0), Meaning("m", "distance between the phase centres")]
    """Distance between the phase centres."""
    azimuth_beamwidth_deg: Annotated[float, Gt(0.0), Le(180.0), Meaning("°", "one-way, −3 dB")]
    """Beam width in azimuth, one-way at −3 dB."""
    elevation_beamwidth_deg: Annotated[float, Gt(0.0), Le(180.0), Meaning("°", "one-way, −3 dB")]
    """Beam width in elevation, one-way at −3 dB."""
    first_gate_m: Annotated[
        float | None, Ge(-1e6), Le(1e6), Meaning("m", "range of the first gate, c t/2", left_out="the array `ranges`")
    ] = None
    """Range of the first gate."""
    gate_m: Annotated[
        float | None, Gt(0.0), Le(1e4), Meaning("m", "spacing of the gates", left_out="the array `ranges`")
    ] = None
    """Spacing of the gates."""
    range_offset_m: Annotated[float, Ge(-1e6), Le(1e6), Meaning("m", "what is taken off every range")] = 0.0
    """What cables and trigger add to every range."""
    tilt_deg: Annotated[float, Ge(-60.0), Le(60.0), Meaning("°", "top towards the look")] = 0.0
    """Tilt of the antennas, top towards the look."""
    lever_arm_m: Annotated[tuple[float, float, float], BeforeValidator(as_tuple)] | None = None
    """From the point whose motion the sensors measure to the middle of the antennas: starboard, forward, up."""
    heading_deg: Annotated[float, Ge(-360.0), Le(360.0), Meaning("°", "if no attitude is given")] = 0.0
    """Heading of the boat, where the recording has no attitude."""
    polarization: Literal["VV", "HH"] = "VV"
    transmit: Literal["single", "switched"] = "single"
    interferogram: Literal["single_pulse", "alternating_pulse"] = "single_pulse"
    transmitter: Literal["coherent", "magnetron"] = "coherent"
    """A magnetron starts each pulse with a random phase: phases are then compared between the receivers of one pulse
    alone, and maps have no velocities, unless coherent_on_receive."""
    coherent_on_receive: bool = False
    """The recorder has taken the phase of each pulse off."""
    transmit_phase_error_deg: Annotated[float, Ge(0.0), Le(180.0), Meaning("°", "of the phase that is taken off")] = 0.0
    """Error of the phase that is taken off each pulse, rms."""
    waveform: Literal["pulse", "chirp"] = "pulse"
    chirp_bandwidth_hz: Annotated[float, Ge(0.0), Le(1e11), Meaning("Hz", "swept by a chirp")] = 0.0
    """Bandwidth that a chirp sweeps."""
    compression_weighting: Literal["none", "hann", "hamming", "taylor"] = "none"
    prf_hz: Annotated[
        float | None, Ge(PRF_HZ[0]), Le(PRF_HZ[1]), Meaning("Hz", "pulses per second", left_out="by the times")
    ] = None
    """Pulse repetition frequency."""
    rotation_rpm: Annotated[
        float | None, Gt(0.0), Le(1e4), Meaning("1/min", "the antenna turns clockwise", left_out="by the azimuths")
    ] = None
    """Rotation of the antenna."""
    sector_deg: Annotated[tuple[float, float], BeforeValidator(as_tuple)] | None = None
    """Left out, the full circle from where the recording begins."""
    noise_power_w: Annotated[
        float | None,
        Ge(0.0),
        Meaning("W", "of a gate and receiver", left_out="by pulses without transmission or the farthest gates"),
    ] = None
    """Noise power of a gate and receiver."""
    conjugate: bool = False
    """The recorder's time factor is exp(−jωt): its phases grow with distance."""
    phase_offset_deg: Annotated[
        float, Ge(-360.0), Le(360.0), Meaning("°", "what is taken off the phase between the receivers")
    ] = 0.0
    """Phase of the lower receiver over the upper one's that cables and amplifiers add, after `conjugate`."""
    voltage_scale: Annotated[float, Gt(0.0), Meaning("√W", "√W of one unit of the recording")] = 1.0
    """√W of one unit of the recording."""
    dc_offset: Literal["keep", "remove"] = "keep"
    full_scale: Annotated[
        float | None,
        Gt(0.0),
        Meaning("1", "of I and Q, in the recording's units", left_out="no pulse is flagged as saturated"),
    ] = None
    """Full scale of I and Q, in the recording's units."""
    encoder_counts: Annotated[int | None, Ge(2), Meaning("1", "of a turn", left_out="the azimuths are in degrees")] = (
        None
    )
    """Counts of the encoder in a turn, where `azimuth` is in counts."""
    encoder_zero_deg: Annotated[float, Ge(-360.0), Le(360.0), Meaning("°", "where the encoder reads 0")] = 0.0
    """Azimuth at which the encoder reads 0."""
    encoder_clockwise: bool = True
    """Its counts grow clockwise."""
    azimuth_from: Literal["north", "bow"] = "north"
    """Where the azimuths count from."""
    partial_turns: Literal["drop", "keep"] = "drop"
    """A first and a last turn that are not whole."""
    sensors: SensorErrors = SensorErrors()
    """What is known of the motion sensors' errors, which error bars then hold."""

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        if (self.first_gate_m is None) != (self.gate_m is None):
            raise ValueError("give first_gate_m and gate_m together, or neither and the array ranges")
        if self.chirp_bandwidth_hz < 1e4 and (self.chirp_bandwidth_hz or self.waveform == "chirp"):
            raise ValueError(
                f"chirp_bandwidth_hz = {self.chirp_bandwidth_hz:g}: must be at least 10000 with waveform = 'chirp'; "
                "give the sweep in hertz"
            )
        for name in ("sector_deg", "lever_arm_m"):
            if not all(math.isfinite(each) for each in getattr(self, name) or ()):
                raise ValueError(f"{name} = {shown(getattr(self, name))}: must be finite; correct it")
        if self.sector_deg is not None and not 0.0 < self.sector_deg[1] - self.sector_deg[0] <= 360.0:
            raise ValueError(
                f"sector_deg = {shown(self.sector_deg)}: must run clockwise by at most 360; give start, stop with "
                "start < stop, as [350, 370]"
            )
        return self


def read_header(header: Header | RecordingHeader) -> RecordingHeader:
    """A header from a dict, a TOML or a JSON file. Raises InputError."""
    if isinstance(header, RecordingHeader):
        return header
    if isinstance(header, Mapping):
        return validate(RecordingHeader, {str(key): toml_counterpart(value) for key, value in header.items()})
    if not isinstance(header, str | os.PathLike):
        raise InputError(f"header = {header!r}: must be a dict, or the path of a TOML or JSON file; give one of these")
    is_json = Path(header).suffix == ".json"
    tree = header_object(read_json(header, "a header"), str(header)) if is_json else read_toml(header, "a header")
    return validate_header(str(header), tree)


def validate_header(source: str, tree: Mapping[str, Any]) -> RecordingHeader:
    with say_of(f"{source}: header: ", InputError):
        return validate(RecordingHeader, tree)


def header_object(tree: Any, what: str) -> dict[str, Any]:
    if not isinstance(tree, dict):
        kind = {list: "a list", str: "a text", bool: "true or false", int: "a number", float: "a number"}
        raise InputError(
            f"{what}: is {kind.get(type(tree), 'null')}: must be an object of keys and values; write it so"
        )
    return tree


def toml_counterpart(value: Any) -> Any:
    """An attribute of a recording, numpy's or bytes, as TOML would give it; HDF5 may make an array of a number."""
    return to_builtin(plain_attribute(value) if isinstance(value, np.ndarray | np.generic | bytes) else value)
