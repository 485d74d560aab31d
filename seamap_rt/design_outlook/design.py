"""A scene's radar as the outlook takes it: what a dwell is, and which phases are compared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..interferometry.covariance.windows import independent_looks, window_weights
from ..interferometry.phase.interferogram import AROUND, BLURRED_GATES, LASTING
from ..interferometry.phase.speckle import estimation_doubt
from ..radar import link
from ..radar.array import antenna_array
from ..radar.precision import looks
from ..radar.receiver import pulse_coherence
from ..radar.waveform import RangeResponse, gates
from ..settings import RadarSettings, RetrievalSettings

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Design:
    """A radar with a retrieval.

    ranges (gate,) slant [m], beyond the mast's foot; height, baseline [m]; wavelength [m]; pulse, beam: standard
    deviations of the area that a dwell's echo comes from, along [m] and across [rad]; width: of a look [rad];
    spacing: of gates [m]; paths: p of the phases that become heights; coarse: p of those that settle their cycle;
    pulses: of a dwell, over which noise averages; beat: of the noise with itself, against its beat with the echo;
    speckle: independent samples of it in a dwell; doubt: by which a variance that was found from few samples is larger;
    window: independent samples in the window whose power decides whether a cell has an echo; window_m, window_rad: its
    sides; cell_m, cell_rad: the cell's.
    """

    ranges: Array
    height: float
    baseline: float
    wavelength: float
    pulse: float
    beam: float
    width: float
    spacing: float
    paths: int
    coarse: int
    pulses: float
    beat: float
    speckle: float
    doubt: float
    window: float
    window_m: float
    window_rad: float
    cell_m: float
    cell_rad: float

    @classmethod
    def of(cls, radar: RadarSettings, settings: RetrievalSettings, decorrelation_time_s: float) -> Design:
        """radar: as it looks (`radar.array.as_it_looks`)."""
        response, array = RangeResponse.of(radar), antenna_array(radar)
        ranges = gates(radar)
        spacing = float(ranges[1] - ranges[0]) if ranges.size > 1 else radar.range_sampling_m
        ranges = ranges[ranges > radar.height_m + spacing]
        width = np.radians(settings.cell_azimuth_deg)
        beam = np.radians(link.beam_widths_deg(radar)[0]) / (4.0 * np.sqrt(np.log(2.0)))
        along = window_weights(settings.window_range_m, spacing)
        across = window_weights(settings.window_azimuth_deg, settings.cell_azimuth_deg)
        speckle = looks(radar, decorrelation_time_s)
        around = speckle * _independent(response, spacing, AROUND[0]) * AROUND[1].size
        window = independent_looks(across, np.eye(1, across.size).ravel())
        paths, coarse, pulses = _compared(radar, settings, ranges, response.spread_m)
        return cls(
            ranges=ranges,
            height=radar.height_m,
            baseline=array.baseline_m,
            wavelength=link.wavelength(radar),
            pulse=response.spread_m,
            beam=float(np.hypot(beam, width / np.sqrt(12.0))),
            width=float(width),
            spacing=spacing,
            paths=paths,
            coarse=coarse,
            pulses=pulses,
            beat=0.5 if paths == 2 else 1.0,
            speckle=speckle,
            doubt=estimation_doubt(around),
            window=speckle * _independent(response, spacing, along) * window,
            window_m=settings.window_range_m,
            window_rad=float(np.radians(settings.window_azimuth_deg)),
            cell_m=settings.cell_range_m,
            cell_rad=float(width),
        )

    @property
    def ground(self) -> Array:
        """Ground range (gate,) of mean sea level, m."""
        return np.sqrt(self.ranges**2 - self.height**2)

    @property
    def gain(self) -> Array:
        """Height that a radian of phase is worth (gate,), m."""
        return self.wavelength * self.ranges / (2.0 * np.pi * self.paths * self.baseline)

    @property
    def depth(self) -> float:
        """Length along the range of what has independent speckle, m: √(4π) standard deviations of the pulse."""
        return max(self.spacing, float(np.sqrt(4.0 * np.pi)) * self.pulse)

    def turn(self, paths: int) -> Array:
        """By how much [rad] the phase of mean sea level turns within the pulse's spread, (gate,)."""
        return _turn(paths, self.wavelength, self.baseline, self.height, self.pulse, self.ranges)


def _independent(response: RangeResponse, spacing: float, weights: Array) -> float:
    """Independent samples of speckle in a weighted mean over gates."""
    fine = np.linspace(-2.0 * response.support_m, 2.0 * response.support_m, 801)
    pulse = response(fine)
    alike = np.array([pulse @ response(fine + spacing * lag) for lag in range(weights.size)]) / (pulse @ pulse)
    return independent_looks(weights, alike)


def _turn(paths: int, wavelength: float, baseline: float, height: float, pulse: float, ranges: Array) -> Array:
    return paths * 2.0 * np.pi / wavelength * baseline * height / ranges**2 * pulse


def _compared(radar: RadarSettings, settings: RetrievalSettings, ranges: Array, pulse: float) -> tuple[int, int, float]:
    """p of the phases that become heights, p of those that settle their cycles, and pulses that are compared."""
    pulses = settings.cell_azimuth_deg / (6.0 * radar.rotation_rpm) * radar.prf_hz
    if radar.scan != "turning":
        pulses = radar.stare_s * radar.prf_hz
    switched = radar.transmit == "switched"
    if radar.interferogram == "alternating_pulse":
        paths = 2 if switched else 1
        return paths, paths, 0.5 * pulses
    if switched and settings.paths == "best" and pulse_coherence(radar) >= LASTING:
        array = antenna_array(radar)
        both = _turn(2, link.wavelength(radar), array.baseline_m, radar.height_m, pulse, ranges)
        if np.mean(both > 1.0) < BLURRED_GATES:
            return 2, 1, 0.5 * pulses
    return 1, 1, pulses
