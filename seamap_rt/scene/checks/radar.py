"""The radar: beams against apertures, receivers that are compared, pulses in each look, memory, files of motion and of
objects' meshes, and that nothing is asked of phases which the transmitter does not keep.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence

from ...conventions import SPEED_OF_LIGHT
from ...errors import refuse
from ...io.numbers import rounded_down, rounded_up
from ...radar.array import antenna_array
from ...radar.checks import pulses_of_a_look, pulses_of_a_turn
from ...radar.grid import BYTES_PER_VOLTAGE, MOST_ECHO_BYTES
from ...radar.platform import boat_motion
from ...radar.receiver import comparing_pulses, pulse_coherence
from ...radar.scan import BEAMS_BEYOND, sector_width, turn_duration
from ...settings import AntennaSettings, ObjectSettings, PlatformSettings, RadarSettings, RetrievalSettings

HALF_POWER = 0.442947  # sinc² is ½ there: half a uniform aperture's beam, as (aperture/λ) · direction cosine


def check_apertures(radar: RadarSettings) -> None:
    """A slotted waveguide's beam is not narrower than its aperture allows."""
    placed = ((f"radar.antennas.{number}", antenna) for number, antenna in enumerate(radar.antennas))
    refuse(
        problem
        for key, antenna in (("radar.antenna", radar.antenna), *placed)
        if antenna.pattern == "slotted_waveguide"
        for problem in _too_narrow(key, antenna, SPEED_OF_LIGHT / radar.frequency_hz)
    )


def _too_narrow(key: str, antenna: AntennaSettings, wavelength: float) -> Iterator[str]:
    for beam_key, beam_deg, aperture_key, aperture in (
        ("azimuth_beamwidth_deg", antenna.azimuth_beamwidth_deg, "width_m", antenna.width_m),
        ("elevation_beamwidth_deg", antenna.elevation_beamwidth_deg, "height_m", antenna.height_m),
    ):
        # 0.886 λ/aperture in its exact form, which holds for small apertures too.
        needed = HALF_POWER * wavelength / math.sin(math.radians(0.5 * beam_deg))
        if aperture < needed:
            cosine = HALF_POWER * wavelength / aperture
            narrowest = 2.0 * math.degrees(math.asin(min(1.0, cosine)))
            yield (
                f"{key}.{beam_key} = {beam_deg:.10g}: must be at least {rounded_up(narrowest)} (the "
                f"beam of a uniform aperture of {key}.{aperture_key} = {aperture:.10g}, and a "
                f"taper only widens it); widen the beam, or raise {key}.{aperture_key} to "
                f"{rounded_up(needed)}"
            )


def check_receivers(radar: RadarSettings, retrieval: RetrievalSettings) -> None:
    """The retrieval compares two receivers that there are."""
    receivers = len(antenna_array(radar).receivers)
    first, second = chosen = retrieval.receivers
    if first == second or not all(0 <= number < receivers for number in chosen):
        raise ValueError(
            f"retrieval.receivers = [{first}, {second}]: must be two different ones of the {receivers} receivers, "
            f"which are numbered from 0 to {receivers - 1}"
        )


def check_above_water(radar: RadarSettings) -> None:
    """The lowest phase centre is above mean sea level."""
    height, baseline = radar.height_m, radar.baseline_m
    tilt = math.radians(radar.tilt_deg)
    offsets = antenna_array(radar).known_offsets
    reach = -min(up * math.cos(tilt) - ahead * math.sin(tilt) for _, ahead, up in offsets)
    if height <= reach:
        lowest = "the lowest of radar.antennas" if radar.antennas else "the lower phase centre"
        far = f"half of radar.baseline_m = {baseline:.10g} further down" if not radar.antennas else "by its offset"
        raise ValueError(
            f"radar.height_m = {height:.10g}: must be greater than {rounded_up(reach)} ({lowest}, {far}, would be "
            "under water); raise radar.height_m or " + ("move it up" if radar.antennas else "shorten radar.baseline_m")
        )


def check_pulses(radar: RadarSettings, retrieval: RetrievalSettings) -> None:
    """The sector holds a look, and a look two pulses of each receiver."""
    prf, rpm, least = radar.prf_hz, radar.rotation_rpm, 2.0
    array = antenna_array(radar)
    if not array.whole:
        least = 2.0 * len(array.cycle)  # each receiver twice
    cell, sector = retrieval.cell_azimuth_deg, sector_width(radar)
    if cell > sector + 1e-9:
        raise ValueError(
            f"retrieval.cell_azimuth_deg = {cell:.10g}: must be at most {rounded_down(sector)} "
            "(radar.sector_deg holds not one whole look); narrow retrieval.cell_azimuth_deg or widen "
            "radar.sector_deg"
        )
    pulses = pulses_of_a_look(radar, cell)
    if pulses < least - 1e-9 and radar.scan == "staring":
        raise ValueError(
            f"radar.stare_s = {radar.stare_s:.10g}: must be at least {rounded_up(least / prf)} (it holds "
            f"{pulses:.3g} pulses and needs {least:g}); lengthen it or raise radar.prf_hz to "
            f"{rounded_up(least * prf / pulses)}"
        )
    if pulses < least - 1e-9:
        raise ValueError(
            f"retrieval.cell_azimuth_deg = {cell:.10g}: must be at least {rounded_up(least * cell / pulses)} (a "
            f"look holds {pulses:.3g} pulses and needs {least:g}); widen retrieval.cell_azimuth_deg, raise "
            f"radar.prf_hz to {rounded_up(least * prf / pulses)} or slow radar.rotation_rpm to "
            f"{rounded_down(rpm * pulses / least)}"
        )


def check_echo_memory(radar: RadarSettings) -> None:
    """A turn of echoes fits memory."""
    near, far = radar.range_m
    pulses = pulses_of_a_turn(radar)
    gates = (far - near) / _sample_spacing(radar) + 1.0
    needed = BYTES_PER_VOLTAGE * len(antenna_array(radar).receivers) * pulses * gates
    if needed > MOST_ECHO_BYTES:
        raise ValueError(
            f"radar.prf_hz = {radar.prf_hz:.10g}: a turn would hold {pulses:.3g} pulses of {gates:.3g} gates "
            f"and take {needed / 1e9:.3g} GB, and may take {MOST_ECHO_BYTES / 1e9:.3g}; lower radar.prf_hz, raise "
            "radar.rotation_rpm or radar.range_sampling_m, narrow radar.sector_deg or shorten radar.range_m"
        )


def _sample_spacing(radar: RadarSettings) -> float:
    """Spacing in range [m] of the receiver's samples."""
    if radar.receiver.chain == "digital":
        return SPEED_OF_LIGHT / (2.0 * radar.receiver.adc_rate_hz)
    return radar.range_sampling_m


def check_motion(platform: PlatformSettings, radar: RadarSettings, turns: int) -> None:
    """A recorded motion can be read, and is as long as the run.

    The run takes in what a turn hears before and after itself, and the earlier motion that late sensors report.
    """
    if platform.motion != "file":
        return
    sensors, beam = platform.sensors, antenna_array(radar).beam_deg
    beside = min(360.0, (BEAMS_BEYOND + 1.0) * beam + 5.0) / (6.0 * radar.rotation_rpm)
    reading = 0.0 if math.isinf(sensors.rate_hz) else 1.0 / sensors.rate_hz
    early, late = min(-beside, -sensors.latency_s - reading), max(beside, reading)
    boat_motion(platform)([0.0, early, turns * turn_duration(radar) + late])


def check_meshes(objects: Sequence[ObjectSettings]) -> None:
    """The objects' mesh files are there."""
    refuse(
        f"objects.{number}.mesh = '{thing.mesh}': no such file; give the path of a mesh"
        for number, thing in enumerate(objects)
        if not os.path.isfile(thing.mesh)  # no name is too long for it
    )


def check_pulses_compare(radar: RadarSettings, retrieval: RetrievalSettings) -> None:
    """A magnetron whose phases are not measured serves what compares the receivers of one pulse alone."""
    asked = comparing_pulses(radar.interferogram, retrieval)
    if asked is None or pulse_coherence(radar) > 0.0:
        return
    key, why, instead = asked
    key = key if key.startswith("retrieval.") else f"radar.{key}"
    raise ValueError(
        f"{key}: cannot be with radar.transmitter = 'magnetron', which starts each pulse with a random phase ({why}); "
        f"{instead}, or set radar.coherent_on_receive = true, which takes that phase off"
    )
