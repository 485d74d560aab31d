"""[radar]: waveform, scan, the antennas and the receiver."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le
from pydantic import AfterValidator, BeforeValidator, model_validator

from .antenna import AntennaSettings, PlacedAntenna
from .receiver import ReceiverSettings
from .section import Meaning, Section, as_tuple

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
    """Carrier frequency."""
    waveform: Literal["pulse", "chirp"] = "pulse"
    """`pulse`: rectangular, through a Gaussian filter; `chirp`: linear FM that sweeps chirp_bandwidth_hz, matched
    filter and compression_window, its near range eclipsed sample by sample."""
    pulse_width_s: Annotated[float, Ge(1e-9), Le(1e-4), Meaning("s", "as long as the transmitter is on")] = 20e-9
    """Length of the transmitted pulse."""
    chirp_bandwidth_hz: Annotated[float, Ge(1e5), Le(1e9), Meaning("Hz", "swept by a chirp")] = 50e6
    """Bandwidth that a chirp sweeps."""
    compression_window: Literal["none", "hann", "hamming", "taylor"] = "hamming"
    """Window of a chirp's compression: lower range sidelobes for a wider pulse."""
    bandwidth_hz: Annotated[float, Ge(1e5), Le(1e9), Meaning("Hz", "noise bandwidth of the receiver")] = 50e6
    """Noise bandwidth of the receiver."""
    prf_hz: Annotated[float, Ge(10.0), Le(1e5), Meaning("Hz", "pulses per second")] = 10e3
    """Pulse repetition frequency."""
    transmit_power_w: Annotated[float, Ge(1e-9), Le(1e6), Meaning("W", "peak power")] = 1.0
    """Peak transmit power."""
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
    """System losses, there and back."""
    noise: bool = True
    """Whether the receivers add noise."""
    scan: Literal["turning", "staring"] = "turning"
    """`turning`: the antenna rotates; `staring`: it stands still at the middle of the sector."""
    rotation_rpm: Annotated[float, Ge(1.0), Le(120.0), Meaning("1/min", "the antenna turns")] = 60.0
    """Rotation of the antenna."""
    stare_s: Annotated[
        float,
        Ge(1e-3),
        Le(0.1),
        Meaning("s", "how long a map of a staring antenna lasts; the sea is the same all along"),
    ] = 0.05
    """Duration of a map of a staring antenna."""
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
    """Range window, [near, far], along the line of sight."""
    range_sampling_m: Annotated[float, Ge(0.05), Le(100.0), Meaning("m", "spacing of the range gates")] = 1.5
    """Spacing of the range gates."""
    height_m: Annotated[float, Gt(0.0), Le(1000.0), Meaning("m", "mean height of the phase centres over the sea")] = 5.0
    """Mean height of the phase centres over mean sea level."""
    baseline_m: Annotated[float, Ge(0.0), Le(20.0), Meaning("m", "distance between the phase centres")] = 0.2
    """Baseline: distance between the phase centres of two stacked antennas."""
    tilt_deg: Annotated[float, Ge(-60.0), Le(60.0), Meaning("°", "beyond it the antennas lie on their backs")] = 0.0
    """Tilt of the antennas, top towards the look."""
    transmit: Literal["single", "switched"] = "switched"
    """`single`: one antenna alone transmits, of two stacked ones the lower; `switched`: each in turn."""
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
    """Pattern of the antennas, `[radar.antenna]`."""
    antennas: Annotated[tuple[PlacedAntenna, ...], BeforeValidator(as_tuple)] = ()
    """Any number of antennas, `[[radar.antennas]]`, each with its offset and channel; with none there are two, one
    above the other, baseline_m apart."""
    receiver: ReceiverSettings = ReceiverSettings()
    """The receiver, `[radar.receiver]`."""

    @model_validator(mode="before")
    @classmethod
    def _antennas_are_like_the_common_one(cls, tree: object) -> object:
        if not isinstance(tree, dict) or not isinstance(tree.get("antennas"), list | tuple):
            return tree
        common, placed = _as_table(tree.get("antenna", {})), [_as_table(entry) for entry in tree["antennas"]]
        if common is None or any(entry is None for entry in placed):
            return tree
        return {**tree, "antennas": [_like(common, entry) for entry in placed if entry is not None]}


def _as_table(value: object) -> dict[str, object] | None:
    """The keys that are given of an antenna, by a file or in Python; None if it is no table."""
    if isinstance(value, AntennaSettings):
        return {key: each for key, each in value.model_dump(exclude_unset=True).items() if each is not None}
    return value if isinstance(value, dict) else None


def _like(common: dict[str, object], entry: dict[str, object]) -> dict[str, object]:
    """An antenna's keys, those that it leaves out taken from the common ones; another pattern needs no file."""
    merged = {**common, **entry}
    if merged.get("pattern") != "file" and "file" not in entry:
        merged.pop("file", None)
    return merged
