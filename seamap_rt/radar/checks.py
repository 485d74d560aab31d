"""What a radar cannot be: each refusal names key, value, limit and remedy in one line."""

from __future__ import annotations

import math
import os
from itertools import combinations

from ..conventions import SPEED_OF_LIGHT
from ..io.text import rounded_down, rounded_up
from ..settings import WIDEST_DEG, RadarSettings
from .array import antenna_array
from .chirp import Chirp
from .digital import DigitalReceiver
from .receiver import MOST_STRAY, phase_drift_in_pulse
from .scan import scanned_share, turn_duration
from .waveform import blind_range_m, unambiguous_range_m

PICTURE_BITS, LEAST_PICTURE_GATES, LEAST_PICTURE_DEG = 12, 21, 5.0  # of `io.polar_images`


def pulses_of_a_look(radar: RadarSettings, cell_azimuth_deg: float) -> float:
    """Mean number of pulses in a look cell_azimuth_deg [deg] wide."""
    share = 1.0 if radar.scan == "staring" else cell_azimuth_deg / 360.0
    return radar.prf_hz * turn_duration(radar) * share


def pulses_of_a_turn(radar: RadarSettings) -> float:
    """Mean number of pulses sent in a turn, over the scanned sector."""
    return radar.prf_hz * turn_duration(radar) * scanned_share(radar)


def check_antennas(radar: RadarSettings) -> None:
    """Patterns are there, beams narrow enough, no two receivers at one place."""
    for number, placed in enumerate(radar.antennas):
        if placed.pattern == "file" and placed.file is not None and not os.path.isfile(placed.file):
            raise ValueError(f"radar.antennas.{number}.file = '{placed.file}': no such file; give a pattern's path")
    if radar.antenna.pattern == "file" and radar.antenna.file is not None and not os.path.isfile(radar.antenna.file):
        raise ValueError(f"radar.antenna.file = '{radar.antenna.file}': no such file; give a pattern's path")
    if radar.antennas:
        for key in ("baseline_error_m", "channel_gain_db", "channel_phase_deg"):
            if getattr(radar, key):
                raise ValueError(
                    f"radar.{key} = {getattr(radar, key):g}: must be 0 beside radar.antennas (it is the short form for "
                    "two antennas, one above the other); say it of the antenna itself"
                )
    array = antenna_array(radar)
    if not array.beam_deg <= WIDEST_DEG and not any(element.antenna.everywhere for element in array.elements):
        raise ValueError(
            f"radar.antenna.file: its azimuth beam is {array.beam_deg:.4g}° wide, and may be {WIDEST_DEG:g} (three "
            "beams to either side must look ahead); choose an antenna with a narrower beam"
        )
    for first, second in combinations(array.receivers, 2):
        apart = math.dist(array.known_offsets[first], array.known_offsets[second])
        if apart < 1e-6 and (radar.antennas or apart > 0.0):  # m: no phase tells them apart
            raise ValueError(
                f"radar.antennas: numbers {first} and {second} receive at the same place; move one by its offset_m"
                if radar.antennas
                else f"radar.baseline_m = {radar.baseline_m:g}: must be 0 or at least 1e-06; lengthen it"
            )


def check_mode(radar: RadarSettings) -> None:
    """Receivers that take turns are two."""
    array = antenna_array(radar)
    if not array.whole and len(array.receivers) > 2:
        raise ValueError(
            f"radar.interferogram = 'alternating_pulse': takes two receivers in turn, and here are "
            f"{len(array.receivers)}; choose single_pulse, or leave two antennas that receive"
        )


def check_overlap(radar: RadarSettings) -> None:
    """A pulse and its echoes have come before the next one."""
    far, unambiguous = radar.range_m[1], unambiguous_range_m(radar)
    room = 1.0 / radar.prf_hz - radar.pulse_width_s
    if room <= 0.0:
        raise ValueError(
            f"radar.pulse_width_s = {radar.pulse_width_s:g}: must be less than 1/radar.prf_hz = {1.0 / radar.prf_hz:g} "
            "(the next pulse would begin before it ends); shorten it or lower radar.prf_hz"
        )
    if far > unambiguous:
        raise ValueError(
            f"radar.prf_hz = {radar.prf_hz:g}: must be at most {rounded_down(SPEED_OF_LIGHT / (2.0 * far))} (c/2 over "
            f"the far end of radar.range_m = {far:g}: an echo from there would come after the next pulse); lower it, "
            "or the far end"
        )


def check_waveform(radar: RadarSettings) -> None:
    """A chirp that can be compressed; a pulse that ends while the sea is still heard."""
    near, far = radar.range_m
    chirp = radar.waveform == "chirp"
    if chirp and radar.receiver.chain == "digital":
        raise ValueError(
            "radar.receiver.chain = 'digital': takes a plain pulse, and radar.waveform = 'chirp'; choose 'baseband'"
        )
    if chirp:
        Chirp(radar)
    if far <= blind_range_m(radar):
        raise ValueError(
            f"radar.range_m = [{near:g},{far:g}]: lies wholly nearer than {rounded_up(blind_range_m(radar))} m (half "
            "the length of the pulse: the transmitter is on while the echo begins); raise its far end or shorten "
            "radar.pulse_width_s"
        )


def check_transmitter(radar: RadarSettings) -> None:
    """A magnetron sends plain pulses, and its carrier hardly turns their phase while they last."""
    if radar.transmitter == "coherent":
        return
    if radar.waveform == "chirp":
        raise ValueError(
            "radar.transmitter = 'magnetron': sends plain pulses, and radar.waveform = 'chirp'; choose 'pulse', or a "
            "coherent transmitter"
        )
    stray = phase_drift_in_pulse(radar)
    if stray > MOST_STRAY:
        most = radar.frequency_jitter_hz * MOST_STRAY / stray
        raise ValueError(
            f"radar.frequency_jitter_hz = {radar.frequency_jitter_hz:g}: must be at most {rounded_down(most)} (what it "
            f"turns within a pulse is left out, and may be {MOST_STRAY:g} rad rms); lower it or shorten "
            "radar.pulse_width_s"
        )


def check_receiver(radar: RadarSettings) -> None:
    """The digital receiver, where there is one, can be built; a picture is such that its file can hold it."""
    if radar.receiver.chain == "digital":
        DigitalReceiver(radar)
    if radar.receiver.chain != "video":
        return
    if radar.scan == "staring":
        raise ValueError("radar.receiver.chain = 'video': shows turns, and radar.scan = 'staring'; choose 'baseband'")
    if radar.receiver.adc_bits > PICTURE_BITS:
        raise ValueError(
            f"radar.receiver.adc_bits = {radar.receiver.adc_bits}: must be at most {PICTURE_BITS} with chain = 'video' "
            "(a picture's words hold no more); lower it"
        )
    (near, far), width = radar.range_m, radar.sector_deg[1] - radar.sector_deg[0]
    if width < LEAST_PICTURE_DEG:
        raise ValueError(
            f"radar.sector_deg = [{radar.sector_deg[0]:g},{radar.sector_deg[1]:g}]: must be at least "
            f"{LEAST_PICTURE_DEG:g}° wide with radar.receiver.chain = 'video' (a picture counts degrees); widen it"
        )
    if (far - near) / radar.range_sampling_m < LEAST_PICTURE_GATES:
        raise ValueError(
            f"radar.range_sampling_m = {radar.range_sampling_m:g}: must be at most "
            f"{rounded_down((far - near) / LEAST_PICTURE_GATES)} with radar.receiver.chain = 'video' (a picture has "
            f"{LEAST_PICTURE_GATES} gates or more); lower it or widen radar.range_m"
        )
