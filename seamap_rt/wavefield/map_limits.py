"""What a polar map's heights are the mean over, and why it may not give the sea state: shadow, weak echo, coherence.

Only gates farther than STEEPEST mast heights count, as in `range_bins`. Dark cells beside cells far above the noise lie
in shadow; where even the strongest cells are hardly above the noise, the echo is too weak.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from ..dataset import QUALITY_FLAGS
from ..errors import SchemaError
from .range_bins import BIN_M, STEEPEST
from .wave_spectrum import Field

_CLEAR_DB = 8.0  # over the noise, of the strongest range bin's heard cells: shadows leave 16 to 25, weak echoes up to 4
_ENOUGH_DB = 6.0
_BELOW_NOISE_DB = 15.0  # that an echo may lack which is not heard at all: at least
_MOST = 0.5  # of the cells
_FLAGGED = {
    "submerged": "an antenna is under water: raise radar.height_m",
    "saturated": "the receiver saturates: raise radar.receiver.full_scale_dbm, or set radar.receiver.gain = 'agc'",
    "blind": "the pulse is still sent when the echo comes: shorten radar.pulse_width_s",
}


def hindrance(polar: xr.Dataset) -> str:
    """Why the sea state of one turn's polar map is not known, and the remedy, in words."""
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
    received = ((flags & QUALITY_FLAGS["no_echo"]) == 0) & judged
    snr = polar["snr_db"].values if "snr_db" in polar else np.full(flags.shape, np.inf)
    received &= ~np.isnan(snr)
    strongest = -np.inf
    for start in np.arange(near if np.isfinite(near) else ranges[0], ranges[-1], BIN_M):
        inside = received & (ranges >= start) & (ranges < start + BIN_M)
        if inside.any():
            strongest = max(strongest, float(np.median(snr[inside])))
    unlike = (flags & (QUALITY_FLAGS["low_coherence"] | QUALITY_FLAGS["ambiguous"])) != 0
    if received.any() and np.mean(unlike[received]) > _MOST:
        return "the antennas' echoes are too little alike (low coherence or unsure cycles): shorten radar.baseline_m"
    if strongest > _CLEAR_DB:
        return f"too little of the sea in sight, shadow: raise radar.height_m, as to {2.0 * height:.2g} m"
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
    lacks = max(_ENOUGH_DB - strongest, 3.0) if np.isfinite(strongest) else _BELOW_NOISE_DB
    return (
        f"too little power for so calm a sea so far away: raise radar.transmit_power_w by {lacks:.0f} dB or more "
        f"({10.0 ** (0.1 * lacks):.0f}-fold), or the antennas' gain"
    )


_PULSE_SIGMA = 0.4  # of the −3 dB width of its power: 0.39 of a plain pulse, 0.42 of a Gaussian one
_BEAM_SIGMA = 1.0 / np.sqrt(16.0 * np.log(2.0))  # of a two-way Gaussian beam by its one-way −3 dB width
_PULSE_M, _BEAM_DEG = 2.3, 1.8  # of maps that do not say


def _length(attrs: dict[Hashable, Any], name: str, missing: float) -> float:
    """An attribute of a polar map, or what it is if it is missing. SchemaError for what is no length."""
    value = attrs.get(name, missing)
    try:
        length = float(value)
    except (TypeError, ValueError):
        length = np.nan
    if not 0.0 <= length < np.inf:
        raise SchemaError(f"maps/polar: attribute {name} = {value}: must be a number, 0 or more; correct it")
    return length


@dataclass(frozen=True)
class Resolution:
    """What a height is the mean over: boxes along and across the look, the pulse and the beam, two-way."""

    along_m: float
    across_deg: tuple[float, ...]
    pulse_m: float  # −3 dB of its power
    beam_deg: float  # −3 dB, one-way

    @classmethod
    def of(cls, attrs: dict[Hashable, Any], looks_deg: float) -> Resolution:
        """From a polar map's attributes and the angle [deg] between its looks."""
        cell, width = _length(attrs, "cell_range_m", 3.0), _length(attrs, "cell_azimuth_deg", looks_deg)
        window = _length(attrs, "window_range_m", cell), (_length(attrs, "window_azimuth_deg", width),)
        estimator = attrs.get("estimator")
        along, across = window if estimator == "sliding_plane" else (cell, (width,))
        if estimator == "adaptive":  # a cell's mean of what single dwells are the means of
            across = (*across, looks_deg)
        pulse, beam = _length(attrs, "pulse_m", _PULSE_M), _length(attrs, "azimuth_beamwidth_deg", _BEAM_DEG)
        return cls(along, across, pulse, beam)

    def transfer(self, wavenumber: Field, ground_range: Field) -> Field:
        """Share of the variance of waves from all sides that a map holds, (range, wavenumber)."""
        angle = (np.arange(16) + 0.5) * np.pi / 32.0  # a circle's quarter; the other three are its mirror images
        k = wavenumber[:, None]
        along, across = k * np.cos(angle), np.radians(k * np.sin(angle) * ground_range[:, None, None])
        # np.sinc is sin πx/πx
        left = np.sinc(along * self.along_m / (2.0 * np.pi)) * np.exp(-0.5 * (along * self.pulse_m * _PULSE_SIGMA) ** 2)
        for width in self.across_deg:
            left = left * np.sinc(across * width / (2.0 * np.pi))
        left = left * np.exp(-0.5 * (across * self.beam_deg * _BEAM_SIGMA) ** 2)
        return np.mean(left**2, axis=-1)
