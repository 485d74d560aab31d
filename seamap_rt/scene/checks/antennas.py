"""Antennas: beams against apertures, which receivers are compared, and that all are above the water."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ...conventions import SPEED_OF_LIGHT
from ...errors import refuse
from ...io.numbers import rounded_up
from ...radar.array import antenna_array
from ...settings import AntennaSettings, RadarSettings, RetrievalSettings

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
