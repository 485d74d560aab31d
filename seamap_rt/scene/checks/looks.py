"""Looks: that each holds pulses, and that a turn of echoes fits memory."""

from __future__ import annotations

from ...conventions import SPEED_OF_LIGHT
from ...io.numbers import rounded_down, rounded_up
from ...radar.array import antenna_array
from ...radar.checks import pulses_of_a_look, pulses_of_a_turn
from ...radar.grid import BYTES_PER_VOLTAGE, MOST_ECHO_BYTES
from ...radar.scan import sector_width
from ...settings import RadarSettings, RetrievalSettings


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
