"""Gaussian seas of known covariance, and what a radar on a mast at rest hears of them: covariance maps drawn at once.

A sea is a sum of plane waves of set amplitudes and drawn phases: ⟨z(x) z(x + d)⟩ = Σ ½a² cos(k·d).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.interferogram import EchoPower, Interferogram
from seamap_rt.interferometry.inversion import Fan, Points, locate
from seamap_rt.interferometry.poses import LookPoses, PhaseModel
from seamap_rt.interferometry.speckle import DwellPulses
from seamap_rt.interferometry.windows import Covariance
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.settings import RetrievalSettings

Array = NDArray[np.float64]
Surface = Callable[[Array, Array], Array]
WAVELENGTH, MAST = 0.03, 5.0
_FINE = 6  # scatterers a gate


@dataclass(frozen=True)
class Waves:
    """number (n, 2) [rad/m], amplitude (n,) [m], phase (n,)."""

    number: Array
    amplitude: Array
    phase: Array

    @classmethod
    def drawn(cls, seed: int, rms: float, longest: float = 60.0, shortest: float = 18.0, count: int = 40) -> Waves:
        """About the west; the energy falls with the wavenumber. Numbers are one and the same, phases are drawn."""
        golden = np.modf(0.618 * np.arange(count))[0]
        size = 2.0 * np.pi / np.geomspace(longest, shortest, count)
        toward = np.radians(90.0 + 120.0 * (golden - 0.5))
        amplitude = size**-1.0
        amplitude *= rms * np.sqrt(2.0 / np.sum(amplitude**2))
        phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, count)
        return cls(size[:, None] * np.stack((np.sin(toward), np.cos(toward)), axis=1), amplitude, phase)

    def __call__(self, x: Array, y: Array) -> Array:
        height = np.zeros(np.broadcast_shapes(x.shape, y.shape))
        for (east, north), amplitude, phase in zip(self.number, self.amplitude, self.phase, strict=True):
            height += amplitude * np.cos(east * x + north * y + phase)
        return height

    def covariance(self, dx: Array, dy: Array, side: float = 0.0) -> Array:
        """At lags [m]; of places that are known to squares of that side alone."""
        total = np.zeros(np.broadcast_shapes(dx.shape, dy.shape))
        for (east, north), amplitude in zip(self.number, self.amplitude, strict=True):
            blur = np.sinc(0.5 * east * side / np.pi) * np.sinc(0.5 * north * side / np.pi)
            total += 0.5 * (amplitude * blur) ** 2 * np.cos(east * dx + north * dy)
        return total


def evenly(first: float, step: float, count: int) -> Array:
    return np.asarray(first + step * np.arange(count), dtype=np.float64)


def polar(ranges: Array, looks: int = 200, first: float = 0.0, width: float = 1.8) -> tuple[Array, ...]:
    """x, y, and east and north of the looks' directions, of cells at these ground ranges."""
    east, north = (part[:, None] for part in unit_from_azimuth(first + width * (np.arange(looks) + 0.5)))
    return ranges * east, ranges * north, east, north


@dataclass(frozen=True)
class Heard:
    """An interferogram, and the heights (look, gate) that it was made of: means over a cell's length."""

    given: Interferogram
    height: Array


def heard(
    surface: Surface,
    seed: int,
    coherence: float | None = 0.999,
    samples: int = 2,
    noise: float = 0.0,
    paths: int = 2,
    looks: int = 60,
    gates: int = 120,
    baseline: float = 0.2,
    **chosen: object,
) -> Heard:
    """Scatterers on the surface, six a gate, through the pulse of each gate; a dwell has so many samples.

    noise: of each sample, over the echo's mean power; without `coherence` there is one point in each gate, not speckle.
    """
    rng = np.random.default_rng(seed)
    ranges = evenly(30.0, 1.5, gates)
    radar = RadarDescription(
        WAVELENGTH, noise, "switched", (0.0, 1.8 * looks), 1.0, MAST, RangeResponse(20e-9, 50e6), ranges
    )
    azimuth = evenly(0.9, 1.8, looks)[:, None]
    zero = np.zeros((1, 1))
    fan = Fan.upright(np.full((1, 1), baseline), np.full((1, 1), MAST))
    poses = LookPoses(fan, azimuth, (zero, zero), (zero, zero), np.zeros((looks, 1)), True)
    model = PhaseModel(radar, poses, paths)
    fine = evenly(24.0, 1.5 / _FINE, (gates + 8) * _FINE)
    height, phase = _on_the_surface(surface, PhaseModel(_with(radar, fine), poses, paths))
    middle = np.s_[:, 4 * _FINE : -4 * _FINE : _FINE]
    if coherence is None:
        one = np.ones((looks, gates))
        dwell, powers = Covariance(np.exp(1j * phase[middle]), one, one), height[middle]
    else:
        pulse = radar.response(fine[:, None] - ranges)
        pulse /= np.sqrt(np.sum(pulse**2, axis=0))
        shape = (samples, looks, fine.size)
        common, other = (rng.normal(size=shape) + 1j * rng.normal(size=shape) for _ in range(2))
        other = coherence * common + np.sqrt(1.0 - coherence**2) * other
        lower, upper = (
            np.sqrt(0.5) * each @ pulse
            + np.sqrt(0.5 * noise) * (rng.normal(size=(samples, looks, gates, 2)) @ np.array([1.0, 1.0j]))
            for each in (common * np.exp(0.5j * phase), other * np.exp(-0.5j * phase))
        )
        dwell = Covariance(
            (lower * upper.conj()).mean(axis=0), (np.abs(lower) ** 2).mean(axis=0), (np.abs(upper) ** 2).mean(axis=0)
        )
        powers = np.stack([height[:, 3 * _FINE + n : (gates + 3) * _FINE + n : _FINE] for n in range(3, 10)]).mean(
            axis=0
        )
    settings = RetrievalSettings.model_validate(chosen)
    correlation = np.eye(1, samples).ravel()
    given = Interferogram(
        dwell=dwell,
        echo=EchoPower(dwell, noise, model.radar, 1.8),
        model=model,
        dwelt=DwellPulses(samples, correlation),
        noise_square=1.0,
        settings=settings,
    )
    return Heard(given, powers)


def _with(radar: RadarDescription, ranges: Array) -> RadarDescription:
    return RadarDescription(
        radar.wavelength, radar.noise_power, radar.transmit, radar.sector, 1.0, MAST, radar.response, ranges
    )


def _on_the_surface(surface: Surface, model: PhaseModel) -> tuple[Array, Array]:
    """Heights (look, range) of the surface at those ranges, and their phases: the fixed point of both."""
    height = np.zeros((model.poses.azimuth.shape[0], model.radar.ranges.size))
    wavenumber = 2.0 * np.pi * model.paths / model.radar.wavelength
    phase = height
    for _ in range(12):
        phase = model.phase_at_height(height)
        points: Points = locate(model.radar.ranges, phase / wavenumber, model.poses.fan)
        height = surface(*model.ground(points))
    return height, phase
