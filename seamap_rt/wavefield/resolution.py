"""What a map's heights are the mean over, and what that leaves of the waves."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import SchemaError
from .wave_spectrum import Field

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
