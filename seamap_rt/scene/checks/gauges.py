"""Gauges: that each has its own name, all one rate, and that they stand where the radar looks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ...errors import refuse
from ...io.text import rounded_down, rounded_up
from ...settings import GaugeSettings, PlatformSettings, RadarSettings, RetrievalSettings, SeaSettings


def check_names_and_rates(gauges: Sequence[GaugeSettings]) -> None:
    """Names differ, rates do not."""
    refuse(_unlike(gauges))


def _unlike(gauges: Sequence[GaugeSettings]) -> Iterator[str]:
    names = [gauge.name for gauge in gauges]
    for number, gauge in enumerate(gauges):
        first = names.index(gauge.name)
        if first < number:
            yield (f"gauges.{number}.name = '{gauge.name}': is the name of gauges.{first}; give each gauge its own")
        rate = gauges[0].sample_hz
        if gauge.sample_hz != rate:
            yield (
                f"gauges.{number}.sample_hz = {gauge.sample_hz:.10g}: must be {rate:.10g}, that of gauges.0 (all "
                "gauges are read together); give them one rate"
            )


def check_known(gauges: Sequence[GaugeSettings], sea: SeaSettings) -> None:
    """Gauges stand where a recorded sea is known."""
    if sea.model == "recorded" and gauges:
        refuse(_unknown(gauges, sea))


def _unknown(gauges: Sequence[GaugeSettings], sea: SeaSettings) -> Iterator[str]:
    from ...io.recorded_sea import recorded_sea  # loads what reads files

    file = recorded_sea(sea.file)
    for number, gauge in enumerate(gauges):
        if not file.holds(*np.array(gauge.position)[:, None]).all():
            west, east, south, north = file.judged_m
            yield (
                f"gauges.{number}: '{gauge.name}' stands where sea.file is not known, and is not judged there: it must "
                f"stand {west:.4g} to {east:.4g} m east and {south:.4g} to {north:.4g} m north; move it"
            )


def check_positions(
    gauges: Sequence[GaugeSettings], radar: RadarSettings, platform: PlatformSettings, retrieval: RetrievalSettings
) -> None:
    """Gauges stand within the range window and, of a boat at rest, within the sector."""
    refuse(_misplaced(gauges, radar, platform, retrieval))


def _misplaced(
    gauges: Sequence[GaugeSettings], radar: RadarSettings, platform: PlatformSettings, retrieval: RetrievalSettings
) -> Iterator[str]:
    moves = platform.speed_m_s > 0.0 or platform.motion == "file"
    near, far = (math.sqrt(max(0.0, end**2 - radar.height_m**2)) for end in radar.range_m)
    if moves:
        near = 0.0
    start, stop = radar.sector_deg
    if radar.scan == "staring":
        middle, half = 0.5 * (start + stop), 0.5 * retrieval.cell_azimuth_deg
        start, stop = middle - half, middle + half
    for number, gauge in enumerate(gauges):
        about, (east, north) = f"gauges.{number}: '{gauge.name}' stands", gauge.position
        away, azimuth = math.hypot(east, north), math.degrees(math.atan2(east, north)) % 360.0
        if not near * (1.0 - 1e-9) <= away <= far:
            yield (
                f"{about} {away:.4g} m from the antenna, and must stand {rounded_up(near)} to {rounded_down(far)} m "
                "from it (radar.range_m over the water); move it or change radar.range_m"
            )
        elif not moves and (azimuth - start + 1e-9) % 360.0 > stop - start + 2e-9:
            looks = "the one look of radar.sector_deg" if radar.scan == "staring" else "radar.sector_deg"
            yield (
                f"{about} at azimuth {azimuth:.4g}°, outside of {looks} ({start:.10g}° to {stop:.10g}°); move it "
                "or change radar.sector_deg"
            )
