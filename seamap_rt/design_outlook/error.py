"""The error that a height of a cell is expected to have by a radar's dwell, and what the cell then scores.

A dwell's height has the variance of the noise and of speckle, which is large where the echo has faded. Dwells and
gates around a cell are averaged as far as they help, which is Wiener's filter of a sea of known spectrum S: with n the
noise's density, T what the pulse and the beam leave of a wave and C the cell's mean, ∫ C² S n/(S T² + n) d²k is left.
The retrieval averages over a few metres at most: of perfect agreement among all dwells there, 1/(1/σ² + their inverse
variances) is left, and the larger of both is taken.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf, erfc, gammaincinv, j0

from ..conventions import ground_range, radar_wavelength
from ..interferometry.ambiguity import BEYOND, LEAST_ODDS, neighbourhood
from ..interferometry.interferogram import AROUND, BLURRED_GATES, LASTING
from ..interferometry.optimal import ACROSS_M, MOST_LOOKS
from ..interferometry.speckle import estimation_doubt, wrapped_variance
from ..interferometry.windows import independent_looks, window_weights
from ..radar import link
from ..radar.array import antenna_array
from ..radar.precision import looks
from ..radar.receiver import pulse_coherence
from ..radar.waveform import RangeResponse, gates
from ..settings import RadarSettings, RetrievalSettings
from .strips import LOOKS, Waves, azimuths, directions

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Design:
    """A radar with a retrieval.

    ranges (gate,) slant [m], beyond the mast's foot; height, baseline [m]; wavelength [m]; pulse, beam: standard
    deviations of the area that a dwell's echo comes from, along [m] and across [rad]; width: of a look [rad];
    spacing: of gates [m]; paths: p of the phases that become heights; coarse: p of those that resolve their cycle;
    pulses: of a dwell, over which noise averages; speckle: independent samples of it in a dwell; gates: independent
    dwells along a cell; doubt: by which a variance that was found from few samples is larger; window: independent
    samples in the window whose power decides whether a cell has an echo; window_m, window_rad: its sides; cell_m,
    cell_rad: the cell's.
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
    speckle: float
    gates: float
    doubt: float
    window: float
    window_m: float
    window_rad: float
    cell_m: float
    cell_rad: float

    @classmethod
    def of(cls, radar: RadarSettings, settings: RetrievalSettings, decorrelation_time_s: float) -> Design:
        """radar: as it looks (`radar.array.with_scanned_sector`)."""
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
            wavelength=radar_wavelength(radar.frequency_hz),
            pulse=response.spread_m,
            beam=float(np.hypot(beam, width / np.sqrt(12.0))),
            width=float(width),
            spacing=spacing,
            paths=paths,
            coarse=coarse,
            pulses=pulses,
            speckle=speckle,
            gates=_independent(response, spacing, window_weights(settings.cell_range_m, spacing)),
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
        return ground_range(self.ranges, self.height)

    def step(self, paths: int) -> Array:
        """Height that a cycle of a phase is worth (gate,), m."""
        return self.wavelength * self.ranges / (paths * self.baseline)

    def noise(self, snr: Array, paths: int) -> Array:
        """Variance [m²] (…, gate) of a dwell's height by noise, whose beat with itself is half where receivers or
        transmitters take turns."""
        ratio, beat = 1.0 / np.maximum(snr, 1e-6), 0.5 if paths == 2 else 1.0
        gain = self.step(paths) / (2.0 * np.pi)
        return gain**2 * (2.0 * ratio + beat * ratio**2) / (2.0 * self.pulses)

    @property
    def depth(self) -> float:
        """Length along the range of what has independent speckle, m: √(4π) standard deviations of the pulse."""
        return max(self.spacing, float(np.sqrt(4.0 * np.pi)) * self.pulse)

    def turn(self, paths: int) -> Array:
        """The angle [rad] by which the phase of mean sea level turns within the pulse's spread, (gate,)."""
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
    """p of the phases that become heights, p of those that resolve their cycles, and pulses that are compared."""
    pulses = settings.cell_azimuth_deg / (6.0 * radar.rotation_rpm) * radar.prf_hz
    if radar.scan != "turning":
        pulses = radar.stare_s * radar.prf_hz
    switched = radar.transmit == "switched"
    if radar.interferogram == "alternating_pulse":
        paths = 2 if switched else 1
        return paths, paths, 0.5 * pulses
    if switched and settings.paths == "best" and pulse_coherence(radar) >= LASTING:
        array = antenna_array(radar)
        both = _turn(2, radar_wavelength(radar.frequency_hz), array.baseline_m, radar.height_m, pulse, ranges)
        if np.mean(both > 1.0) < BLURRED_GATES:
            return 2, 1, 0.5 * pulses
    return 1, 1, pulses


_FADES, _WEIGHTS = np.polynomial.laguerre.laggauss(8)  # powers of one sample of speckle, of mean 1
_BANDS = 24  # of wavenumber, in the filter's integral
_NODES, _LEVELS = 12, 10  # ranges and noise densities at which it is taken, and interpolated
_BRIGHT_SPOTS = 0.21  # of the variance along a pulse, what is left when its bright spots are known (Gaussian pulse)
_GATES = 4  # to either side of a cell: the neighbours that it is found from, in the middle of a block
_QUANTILES = 32  # of a cell's fading
_RINGS = 16  # of a cell's neighbours


@dataclass(frozen=True)
class Spectrum:
    """Of the sea as it lies, S(k) = S(−k), seen along half of the looks: the other half sees the same.

    wavenumber (k, 1) [rad/m]; along, across (sector,): of a wave against the look; variance (look, k, sector) [m²] of
    each part; density [m⁴] there.
    """

    wavenumber: Array
    along: Array
    across: Array
    variance: Array
    density: Array

    @classmethod
    def of(cls, waves: Waves) -> Spectrum:
        edges = np.arange(0, waves.wavenumber.size, waves.wavenumber.size // _BANDS)
        power = np.add.reduceat(waves.variance, edges, axis=0)
        half = directions().size // 2
        both = np.tile(power[:, :half] + power[:, half:], 2)
        side = np.sqrt(waves.wavenumber[1] / waves.wavenumber[0])
        low = waves.wavenumber[edges] / side
        high = np.append(low[1:], waves.wavenumber[-1] * side)
        area = 2.0 * np.pi / directions().size * 0.5 * (high**2 - low**2)
        looks = azimuths()[: LOOKS // 2]
        turned = np.radians(directions()[:half] - looks[0])
        step = directions().size // LOOKS
        variance = np.stack([both[:, step * n : step * n + half] for n in range(looks.size)])
        density = 0.5 * variance / area[:, None]
        return cls(np.sqrt(low * high)[:, None], np.cos(turned), np.sin(turned), variance, density)

    def amplitude_share(self, along: float, across: float) -> Array:
        """Share (k, sector) of each wave's amplitude in means over an area of these standard deviations [m]."""
        return np.exp(
            -0.5 * ((self.wavenumber * self.along * along) ** 2 + (self.wavenumber * self.across * across) ** 2)
        )

    def wiener_error(self, design: Design, distance: float, noise: Array) -> Array:
        """Error variance [m²] (look, noise) of cells at that distance [m], for noise densities [m⁴]."""
        transfer = self.amplitude_share(design.pulse, design.beam * distance) ** 2
        sides = self.wavenumber * self.along * design.cell_m, self.wavenumber * self.across * design.cell_rad * distance
        mean = (np.sinc(sides[0] / (2.0 * np.pi)) * np.sinc(sides[1] / (2.0 * np.pi))) ** 2 * self.variance
        level = noise[:, None, None, None]
        return np.sum(mean * level / (self.density * transfer + level), axis=(2, 3)).T

    def dwell_variance(self, design: Design, distance: float) -> tuple[float, float]:
        """Variance [m²] of heights within a dwell's area: what varies across it, and along it."""
        variance = self.variance.mean(axis=0)
        along = self.amplitude_share(design.pulse, 0.0) ** 2
        both = along * self.amplitude_share(0.0, design.beam * distance) ** 2
        return float(np.sum(variance * (along - both))), float(np.sum(variance * (1.0 - along)))


def information(design: Design, spectrum: Spectrum, snr: Array) -> Array:
    """Inverse variance per ground [1/m⁴] of the heights of dwells, the mean over their fading; snr (…, gate) of one
    pulse."""
    rough, tilted = _within_dwells(design, spectrum)
    speckle = design.doubt * (rough + _BRIGHT_SPOTS * tilted) / design.speckle
    total = np.zeros(snr.shape)
    for fade, weight in zip(_FADES, _WEIGHTS, strict=True):
        total += weight / (design.noise(fade * snr, design.paths) + speckle / fade)
    return total / (design.depth * design.width * design.ground)


def _within_dwells(design: Design, spectrum: Spectrum) -> tuple[Array, Array]:
    """Variance [m²] (gate,) of heights within a dwell's area: what varies across it, and along it."""
    ground = design.ground
    nodes = _nodes(ground.size)
    across, along = np.array([spectrum.dwell_variance(design, float(each)) for each in ground[nodes]]).T
    rough = np.interp(ground, ground[nodes], across)
    # Even a flat sea's phase turns within a pulse: by its length along the range, height differs by its tangent.
    tilted = np.interp(ground, ground[nodes], along) + (design.pulse * design.height / ground) ** 2
    return rough, tilted


def error_variance(design: Design, spectrum: Spectrum, known: Array, sea: float) -> Array:
    """Error variance [m²] (look, gate) of cells of which `known` is what is known around them, by `information`.

    sea: variance of the sea, m². Looks that follow one another by LOOKS/2 see the same spectrum.
    """
    ground = design.ground
    most = 100.0 * float(spectrum.density.max(initial=0.0)) + 1e-12
    noise = np.minimum(1.0 / np.maximum(4.0 * np.pi**2 * known, 1e-30), most)
    nodes = _nodes(ground.size)
    levels = np.geomspace(0.99 * noise.min(), 1.01 * noise.max(), _LEVELS)
    tables = np.stack([spectrum.wiener_error(design, float(ground[n]), levels) for n in nodes])  # (node, look, level)
    tables = np.log(np.maximum(tables, 1e-12))
    place = np.interp(np.arange(ground.size), nodes, np.arange(nodes.size))
    node = np.minimum(place.astype(int), max(nodes.size - 2, 0))
    by_range = place - node
    at = np.interp(np.log(noise), np.log(levels), np.arange(_LEVELS))
    level = np.minimum(at.astype(int), _LEVELS - 2)
    by_noise = at - level
    look = (np.arange(noise.shape[0]) % tables.shape[1])[:, None]
    beyond = np.minimum(node + 1, nodes.size - 1)

    def interpolate_noise(n: NDArray[np.intp]) -> Array:
        return tables[n, look, level] * (1.0 - by_noise) + tables[n, look, level + 1] * by_noise

    filtered = np.exp(interpolate_noise(node) * (1.0 - by_range) + interpolate_noise(beyond) * by_range)
    looks = np.clip(np.round(ACROSS_M / (ground * design.width)), 1, MOST_LOOKS)
    area = 2.0 * _GATES * design.spacing * (2.0 * looks + 1.0) * ground * design.width
    return np.maximum(filtered, 1.0 / (1.0 / max(sea, 1e-12) + known * area))


def ambiguous_share(design: Design, spectrum: Spectrum, snr: Array, sea: float) -> Array:
    """Share (gate,) of cells with an echo whose phase may lie on another cycle, as the retrieval judges that.

    snr (gate,): of one pulse, where there is an echo; sea: variance [m²]. A cell is expected at the mean of its
    neighbours, from which waves curve away; its own phase fades with its speckle. Left out: heights of one way's
    phases beside those of both ways, which change the share by a hundredth.
    """
    step = design.step(design.paths)
    blurred = design.turn(design.coarse) > 1.0
    if design.coarse == design.paths:
        blurred |= 0.5 * step < np.sqrt(sea)
    rough, tilted = _within_dwells(design, spectrum)
    within = rough + tilted  # bright spots are not known yet
    samples = design.speckle * design.gates
    fades = gammaincinv(samples, (np.arange(_QUANTILES) + 0.5) / _QUANTILES)[:, None] / samples

    radian = (step / (2.0 * np.pi)) ** 2
    # Phases that spread by s leave a coherence γ = exp(−s²/2), and von Mises' (1 − γ²)/2γ to a sample.
    speckle = radian * np.sinh(np.minimum(0.5 * within / radian, 50.0)) / design.speckle / fades
    noise = design.noise(fades * snr, design.paths)
    variance = (noise + speckle) / design.gates
    usual = 1.0 / np.mean(1.0 / variance, axis=0)
    nodes = _nodes(step.size)
    found = [_expectation(design, spectrum, float(design.ground[n]), float(usual[n]), sea) for n in nodes]
    stray, doubt = (np.interp(np.arange(step.size), nodes, each) for each in np.array(found).T)
    phase = wrapped_variance((noise + design.doubt * speckle) / design.gates / radian)
    apparent = radian * phase / np.maximum(1.0 - phase / (np.pi**2 / 3.0), 1e-4)  # of a uniform phase without end
    allowed = 0.5 - np.log(LEAST_ODDS) * (doubt + apparent) / step**2
    off = np.sqrt(2.0 * (stray + doubt + variance)) / step
    share = np.where(allowed > 0.0, erfc(np.maximum(allowed, 0.0) / off), 1.0).mean(axis=0)
    near = 0.5 * step < BEYOND * np.sqrt(sea)
    return np.where(blurred & near.any(), 1.0, np.where(near, share, 0.0))


def _expectation(design: Design, spectrum: Spectrum, distance: float, noise: float, sea: float) -> tuple[float, float]:
    """Variance [m²] by which waves stray from what a cell's neighbours let expect, and of the neighbours' errors.

    noise: variance of neighbours [m²]; sea: of heights about mean sea level, to which the retrieval holds them. All
    around a cell, the plane that it fits is the mean of neighbours, each by its own weight.
    """
    around, across = neighbourhood(design.spacing), distance * design.width
    radius = np.sqrt(around.radius * min(around.radius, around.most_looks * across))
    apart = (np.arange(_RINGS) + 0.5) / _RINGS * radius
    weight = 2.0 * np.pi * apart * radius / _RINGS / (design.spacing * across) / (noise + around.stray * apart**2)
    total = weight.sum() + 1.0 / max(sea, 1e-12)
    followed = j0(spectrum.wavenumber * apart) @ weight / total
    shown = spectrum.amplitude_share(design.cell_m / np.sqrt(12.0), design.beam * distance)
    stray = np.sum(spectrum.variance.mean(axis=0) * (shown * (1.0 - followed[:, None])) ** 2)
    return float(stray), float(1.0 / total)


def score(variance: Array, sea: float) -> Array:
    """Mean of 1 − min(e², σ²)/σ² over Gaussian errors e of that variance [m²]; sea: σ² [m²]."""
    ratio = np.maximum(np.sqrt(sea / np.maximum(variance, 1e-12 * sea)), 1e-6)
    inside = erf(ratio / np.sqrt(2.0)) * (1.0 - ratio**-2.0)
    return np.clip(inside + np.sqrt(2.0 / np.pi) * np.exp(-0.5 * ratio**2) / ratio, 0.0, 1.0)


def _nodes(count: int) -> NDArray[np.intp]:
    return np.unique(np.linspace(0, count - 1, _NODES).round().astype(np.intp))
