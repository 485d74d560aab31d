"""Why a polar map does not give the sea state, and what would mend that: shadow, weak echo or low coherence.

Only gates farther than STEEPEST mast heights count, as in `range_bins`. Dark cells beside cells far above the noise lie
in shadow; where even the strongest cells are hardly above the noise, the echo is too weak.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..dataset import QUALITY_FLAGS
from .range_bins import BIN_M, STEEPEST

_CLEAR_DB = 8.0  # over the noise, of the strongest range bin's heard cells: shadows leave 16 to 25, weak echoes up to 4
_ENOUGH_DB = 6.0
_UNHEARD_DB = 15.0  # that an echo may lack which is not heard at all: at least
_MOST = 0.5  # of the cells
_FLAGGED = {
    "submerged": "an antenna is under water: raise radar.height_m",
    "saturated": "the receiver saturates: raise radar.receiver.full_scale_dbm, or set radar.receiver.gain = 'agc'",
    "blind": "the pulse is still sent when the echo comes: shorten radar.pulse_width_s",
}


def hindrance(polar: xr.Dataset) -> str:
    """Of one turn's polar map, whose sea state is not known: the cause and its remedy, in words."""
    ranges, flags, height = polar["range"].values, polar["quality"].values, float(polar.attrs.get("height_m", np.nan))
    near = STEEPEST * height
    for name, words in _FLAGGED.items():
        if np.mean((flags & QUALITY_FLAGS[name]) != 0) > _MOST:
            return words
    if ranges[-1] < near + BIN_M:
        return (
            f"the map ends at {ranges[-1]:.0f} m, and nearer than {STEEPEST:g} mast heights ({near:.0f} m) heights are "
            f"not judged: widen radar.range_m to {near + 5.0 * BIN_M:.0f} m and more, or lower radar.height_m"
        )
    judged = ranges >= near if np.isfinite(near) else np.ones(ranges.size, dtype=bool)
    heard = ((flags & QUALITY_FLAGS["no_echo"]) == 0) & judged
    snr = polar["snr_db"].values if "snr_db" in polar else np.full(flags.shape, np.inf)
    heard &= ~np.isnan(snr)
    strongest = -np.inf
    for start in np.arange(near if np.isfinite(near) else ranges[0], ranges[-1], BIN_M):
        inside = heard & (ranges >= start) & (ranges < start + BIN_M)
        if inside.any():
            strongest = max(strongest, float(np.median(snr[inside])))
    unlike = (flags & (QUALITY_FLAGS["low_coherence"] | QUALITY_FLAGS["ambiguous"])) != 0
    if heard.any() and np.mean(unlike[heard]) > _MOST:
        return "the antennas' echoes are too little alike (low coherence or unsure cycles): shorten radar.baseline_m"
    if strongest > _CLEAR_DB:
        return f"too little of the sea in sight, shadow: raise radar.height_m, as to {2.0 * height:g} m"
    middle = float(np.sqrt(ranges[judged][0] * ranges[-1]))
    return f"the echo lacks, not the light: {_stronger(polar, middle, strongest)}"


def _stronger(polar: xr.Dataset, middle: float, strongest: float) -> str:
    """What would make the echo stronger; middle: of the ranges that are judged, m."""
    height, width, tilt = (
        float(polar.attrs.get(name, np.nan)) for name in ("height_m", "elevation_beamwidth_deg", "tilt_deg")
    )
    down = float(np.degrees(np.arcsin(min(height / middle, 1.0))))
    if abs(down - tilt) > 0.5 * width:
        way = "over" if tilt < down else "short of"
        return (
            f"the beam ({width:.0f}° wide, {tilt:.0f}° down) passes {way} the sea at {middle:.0f} m, {down:.0f}° down: "
            f"set radar.tilt_deg = {down:.0f}"
        )
    lacks = max(_ENOUGH_DB - strongest, 3.0) if np.isfinite(strongest) else _UNHEARD_DB
    return (
        f"too little power for so calm a sea so far away: raise radar.transmit_power_w by {lacks:.0f} dB or more "
        f"({10.0 ** (0.1 * lacks):.0f}-fold), or the antennas' gain"
    )
