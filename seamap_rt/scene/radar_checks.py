"""The radar: beams against apertures, receivers that are compared, pulses in each look, range window, gates, patch of
sea and ground map, memory, files of motion and of meshes, and that nothing is asked of phases that are not kept."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence

from ..conventions import radar_wavelength
from ..io.text import rounded_down, rounded_up
from ..radar.array import antenna_array
from ..radar.checks import pulses_of_a_look, pulses_of_a_turn
from ..radar.grid import BYTES_PER_VOLTAGE, MOST_ECHO_BYTES, MOST_GROUND_CELLS, ground_cells, least_ground_side
from ..radar.platform import boat_motion
from ..radar.receiver import comparing_pulses, pulse_coherence
from ..radar.scan import BEAMS_BEYOND, sector_width, turn_duration
from ..radar.waveform import RangeResponse, gate_spacing_m, range_cell, sample_spacing_m
from ..settings import (
    AntennaSettings,
    ObjectSettings,
    PlatformSettings,
    RadarSettings,
    RandomWaves,
    RetrievalSettings,
    SeaSettings,
)

HALF_POWER = 0.442947  # sinc² is ½ there: half a uniform aperture's beam, as (aperture/λ) · direction cosine


def check_apertures(radar: RadarSettings) -> Iterator[str]:
    """A slotted waveguide's beam is not narrower than its aperture allows."""
    placed = ((f"radar.antennas.{number}", antenna) for number, antenna in enumerate(radar.antennas))
    for key, antenna in (("radar.antenna", radar.antenna), *placed):
        if antenna.pattern == "slotted_waveguide":
            yield from _too_narrow(key, antenna, radar_wavelength(radar.frequency_hz))


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
    digital = radar.receiver.chain == "digital"
    spacing = sample_spacing_m(radar.receiver.adc_rate_hz) if digital else radar.range_sampling_m
    gates = (far - near) / spacing + 1.0
    needed = BYTES_PER_VOLTAGE * len(antenna_array(radar).receivers) * pulses * gates
    if needed > MOST_ECHO_BYTES:
        raise ValueError(
            f"radar.prf_hz = {radar.prf_hz:.10g}: a turn would hold {pulses:.3g} pulses of {gates:.3g} gates "
            f"and take {needed / 1e9:.3g} GB, and may take {MOST_ECHO_BYTES / 1e9:.3g}; lower radar.prf_hz, raise "
            "radar.rotation_rpm or radar.range_sampling_m, narrow radar.sector_deg or shorten radar.range_m"
        )


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


def check_meshes(objects: Sequence[ObjectSettings]) -> Iterator[str]:
    """The objects' mesh files are there."""
    for number, thing in enumerate(objects):
        if not os.path.isfile(thing.mesh):  # no name is too long for it
            yield f"objects.{number}.mesh = '{thing.mesh}': no such file; give the path of a mesh"


def check_pulses_compare(radar: RadarSettings, retrieval: RetrievalSettings) -> None:
    """A magnetron whose phases are not measured serves what compares the receivers of one pulse alone."""
    comparison = comparing_pulses(radar.interferogram, retrieval)
    if comparison is None or pulse_coherence(radar) > 0.0:
        return
    key, why, instead = comparison
    key = key if key.startswith("retrieval.") else f"radar.{key}"
    raise ValueError(
        f"{key}: cannot be with radar.transmitter = 'magnetron', which starts each pulse with a random phase ({why}); "
        f"{instead}, or set radar.coherent_on_receive = true, which takes that phase off"
    )


_LONG = 0.05  # share of waves too long for a record's patch, from which on it is reported
LEAST_MARGIN_M = 30.0  # beyond the far gate; the mesh itself runs on by the range response's reach


def check_height(radar: RadarSettings) -> None:
    """The far end of the range window reaches the sea."""
    (near, far), height = radar.range_m, radar.height_m
    if far <= height:
        raise ValueError(
            f"radar.range_m = [{near:.10g},{far:.10g}]: its far end must be greater than radar.height_m "
            f"= {height:.10g} (the sea lies farther below the antenna, so nothing is seen); raise the "
            "far end or lower radar.height_m"
        )


def check_patch(radar: RadarSettings, sea: SeaSettings) -> None:
    """The range circle fits in the periodic patch, if the waves repeat."""
    margin = max(LEAST_MARGIN_M, RangeResponse.of(radar).support_m)
    needed, extent = 2.0 * (radar.range_m[1] + margin), sea.extent_m
    if sea.model == "recorded":
        check_reach(sea, radar, margin)
        return
    repeats = any(
        isinstance(waves, RandomWaves) and getattr(waves, "spreading", None) != "long_crested" for waves in sea.waves
    )
    if repeats and extent < needed:
        room = 0.5 * extent - margin
        nearer = f" or lower the far end of radar.range_m to {rounded_down(room)}" if room > 0.0 else ""
        raise ValueError(
            f"sea.extent_m = {extent:.10g}: must be at least {rounded_up(needed)} (the range circle, 2 × (far "
            f"end of radar.range_m + {margin:.10g} m), must fit in the periodic patch, or the same "
            f"waves are seen twice); raise sea.extent_m{nearer}"
        )


def check_reach(sea: SeaSettings, radar: RadarSettings, margin: float) -> None:
    """A recorded patch holds the range circle and a margin [m], or is to be continued beyond; one that repeats is
    not."""
    from ..io.recorded_sea import recorded_sea  # loads what reads files

    file = recorded_sea(sea.file)
    if file.periodic and sea.beyond != "refused":
        raise ValueError(
            f"sea.beyond = '{sea.beyond}': must be 'refused', for the patch of sea.file repeats; leave it out"
        )
    near, far = radar.range_m
    if sea.beyond == "refused" and file.reach_m < far + margin:
        room = file.reach_m - margin
        nearer = f", or lower the far end of radar.range_m to {rounded_down(room)}" if room > near else ""
        more = "" if file.periodic else ", or have it continued beyond (sea.beyond = 'level' or 'mirrored')"
        raise ValueError(
            f"sea.file reaches {file.reach_m:.10g} m from the antenna: must reach {rounded_up(far + margin)} (the far "
            f"end of radar.range_m + {margin:.10g} m); give a larger record{nearer}{more}"
        )


def check_start(sea: SeaSettings) -> None:
    """A recorded sea's time 0 lies in its record, with what is taken from before and after it."""
    if sea.model == "recorded" and sea.start_s is not None:
        from ..io.recorded_sea import recorded_sea  # loads what reads files
        from ..sea.recorded import start_of

        start_of(recorded_sea(sea.file), sea.start_s)


def record_notes(sea: SeaSettings, radar: RadarSettings) -> list[str]:
    """Notes on a recorded sea before it is run, one line each: how far it reaches, and what comes beyond."""
    if sea.model != "recorded":
        return []
    from ..io.recorded_sea import recorded_sea  # loads what reads files
    from ..sea.recorded import start_of

    file = recorded_sea(sea.file)
    frame, late = start_of(file, sea.start_s)
    begin, end = file.begin_s, file.begin_s + (file.frames - 1) * file.step_s
    problems = [
        f"sea.file = '{sea.file}' runs from {file.time_in_words(begin)} to {file.time_in_words(end)}; time 0 of the "
        f"run is its {file.time_in_words(begin + frame * file.step_s + late)} (sea.start_s)"
    ]
    if file.cut:
        problems.append(
            f"sea.file = '{sea.file}': {file.points} × {file.points} points of it are used, {file.side_m:.4g} m a "
            "side: the largest square without gaps at its edges"
        )
    if file.long_share > _LONG:
        problems.append(
            f"sea.file = '{sea.file}': {file.long_share:.0%} of the variance are waves longer than its patch of "
            f"{file.side_m:.4g} m: their heights are kept, how the water flows to and fro in them is not known"
        )
    if not file.periodic and file.reach_m < radar.range_m[1]:
        how = {"level": "the sea is level", "mirrored": "the patch is mirrored"}.get(sea.beyond, "it ends")
        reach = f"{file.reach_m:.4g} m from the antenna" if file.reach_m > 0.0 else "not to the antenna"
        problems.append(
            f"sea.file = '{sea.file}' reaches {reach}, radar.range_m to {radar.range_m[1]:g} m: beyond {how}, and "
            "nothing there is judged"
        )
    return problems


def check_gates(radar: RadarSettings, retrieval: RetrievalSettings) -> None:
    """Gates lie no further apart than cells are long and than the range resolution."""
    sampling, cell = radar.range_sampling_m, retrieval.cell_range_m
    if sampling > cell:
        raise ValueError(
            f"radar.range_sampling_m = {sampling:.10g}: must be at most retrieval.cell_range_m = "
            f"{cell:.10g} (else cells hold no gate); lower radar.range_sampling_m or lengthen "
            "retrieval.cell_range_m"
        )
    chirp, resolution = radar.waveform == "chirp", range_cell(radar)
    if gate_spacing_m(radar) > resolution:
        raise ValueError(
            f"radar.range_sampling_m = {sampling:.10g}: must be at most the range resolution of "
            f"{rounded_down(resolution)} m (c/2 over the lesser of radar.bandwidth_hz and "
            f"{'radar.chirp_bandwidth_hz' if chirp else '1/radar.pulse_width_s'}; the sea between the gates "
            f"would be missed); lower radar.range_sampling_m to {rounded_down(resolution)}"
        )


def check_window(radar: RadarSettings, retrieval: RetrievalSettings) -> None:
    """The range window holds a cell."""
    (near, far), cell = radar.range_m, retrieval.cell_range_m
    length = max(cell, 2.0 * gate_spacing_m(radar))
    if far - near < length:
        raise ValueError(
            f"radar.range_m = [{near:.10g},{far:.10g}]: must be at least {length:.4g} long (a cell of "
            "retrieval.cell_range_m, or three gates); raise its far end"
        )


def check_ground_map(radar: RadarSettings, retrieval: RetrievalSettings) -> None:
    """The ground map fits memory."""
    far, side = radar.range_m[1], retrieval.ground_m
    cells = ground_cells(far, side)
    if cells > MOST_GROUND_CELLS:
        raise ValueError(
            f"retrieval.ground_m = {side:.10g}: must be at least {rounded_up(least_ground_side(far))} (the ground map "
            f"would have {cells:.3g} cells, and may have {MOST_GROUND_CELLS:.3g}); raise retrieval.ground_m"
        )
