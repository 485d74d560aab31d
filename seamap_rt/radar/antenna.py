"""One-way antenna patterns, separable in the two direction cosines of the aperture, and the gain that they imply.

`slotted_waveguide` is a line source with Taylor's one-parameter taper (Taylor 1953; Hansen 1964): its pattern is
sin(π√(u² − b²)) / (π√(u² − b²)) with u = (aperture/λ) · direction cosine, and b is found from the asked-for beam width.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from ..conventions import SPEED_OF_LIGHT, from_db
from ..settings import RadarSettings

Cut = Callable[[NDArray[np.float64]], NDArray[np.float64]]  # direction cosine → voltage, 1 at boresight


def _one_parameter(u: NDArray[np.float64], taper: float) -> NDArray[np.float64]:
    """Taylor's one-parameter voltage pattern, 1 at u = 0: sinh inside |u| < taper, sin beyond.

    Both are divided by sinh(π taper)/(π taper); exponents are subtracted first, so that strong tapers do not overflow.
    """
    inside = taper**2 - u**2
    root = np.maximum(np.pi * np.sqrt(np.abs(inside)), 1e-8)
    whole = max(np.pi * taper, 1e-8)
    scale = 2.0 * whole / -np.expm1(-2.0 * whole)
    wave = np.where(
        inside > 0.0,
        0.5 * np.exp(np.minimum(root - whole, 0.0)) * -np.expm1(-2.0 * root),
        np.exp(-whole) * np.sin(root),
    )
    return scale * wave / root


def _line_source(aperture_m: float, wavelength_m: float, beamwidth_deg: float) -> Cut:
    """The cut of a line source whose taper gives the one-way −3 dB beam width."""
    length = aperture_m / wavelength_m
    half = length * np.sin(0.5 * np.radians(beamwidth_deg))

    def excess(taper: float) -> float:
        return float(_one_parameter(np.array([half]), taper)[0] - np.sqrt(0.5))

    if excess(0.0) > 0.0:
        narrowest = 2.0 * np.degrees(np.arcsin(min(1.0, 0.44295 / length)))
        raise ValueError(
            f"beam width {beamwidth_deg:g}° is narrower than a uniform aperture of {aperture_m:g} m gives "
            f"({narrowest:.3g}°); widen the beam or the aperture"
        )
    top = 1.0
    while excess(top) < 0.0:
        top *= 2.0
    taper = float(brentq(excess, 0.0, top, xtol=1e-12))  # type: ignore[arg-type]
    return lambda cosine: _one_parameter(length * np.asarray(cosine, dtype=np.float64), taper)


def _gaussian(beamwidth_deg: float) -> Cut:
    width = np.radians(beamwidth_deg)
    return lambda cosine: np.exp(
        -2.0 * np.log(2.0) * (np.arcsin(np.clip(np.asarray(cosine, dtype=np.float64), -1.0, 1.0)) / width) ** 2
    )


def _everywhere(cosine: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.ones_like(np.asarray(cosine, dtype=np.float64))


@dataclass(frozen=True)
class Antenna:
    """A one-way voltage pattern E(l, n) = azimuth(l) · elevation(n), 1 at boresight, and the gain at boresight.

    l is the direction cosine along the aperture's width (clockwise positive), n along its height (up).
    """

    azimuth: Cut
    elevation: Cut
    gain: float  # linear
    tilt: float  # rad, top towards the look: the boresight points down by it
    everywhere: bool = False  # hears behind the aperture too

    def cosines(self, offset: ArrayLike, elevation: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Direction cosines (l, n) of a direction `offset` rad clockwise of the look and `elevation` rad up."""
        offset, elevation = np.asarray(offset, dtype=np.float64), np.asarray(elevation, dtype=np.float64)
        level = np.cos(elevation)
        height = np.cos(self.tilt) * np.sin(elevation) + np.sin(self.tilt) * level * np.cos(offset)
        return level * np.sin(offset), height

    def voltage(self, offset: ArrayLike, elevation: ArrayLike) -> NDArray[np.float64]:
        """One-way voltage towards a direction (rad, rad), relative to boresight; 0 behind the aperture."""
        across, up = self.cosines(offset, elevation)
        front = np.cos(np.asarray(offset, dtype=np.float64)) > 0.0
        return np.where(front | self.everywhere, self.azimuth(across) * self.elevation(up), 0.0)


def antenna(radar: RadarSettings) -> Antenna:
    """The antenna of a radar; its gain is the pattern's own directivity less the ohmic loss, or gain_dbi."""
    settings = radar.antenna
    azimuth, elevation, gain = _pattern(
        settings.pattern,
        SPEED_OF_LIGHT / radar.frequency_hz,
        (settings.width_m, settings.height_m),
        (settings.azimuth_beamwidth_deg, settings.elevation_beamwidth_deg),
    )
    gain *= float(from_db(-settings.ohmic_loss_db))
    if settings.gain_dbi is not None:
        gain = float(from_db(settings.gain_dbi))
    everywhere = settings.pattern == "isotropic"
    return Antenna(azimuth, elevation, gain, float(np.radians(radar.tilt_deg)), everywhere)


@lru_cache(maxsize=16)
def _pattern(
    name: str, wavelength: float, aperture: tuple[float, float], beamwidth_deg: tuple[float, float]
) -> tuple[Cut, Cut, float]:
    """The two cuts and the directivity; (azimuth, elevation) pairs."""
    if name == "isotropic":
        return _everywhere, _everywhere, 1.0
    if name == "gaussian":
        azimuth, elevation = (_gaussian(beam) for beam in beamwidth_deg)
    else:
        azimuth, elevation = (
            _line_source(size, wavelength, beam) for size, beam in zip(aperture, beamwidth_deg, strict=True)
        )
    return azimuth, elevation, directivity(azimuth, elevation)


def directivity(azimuth: Cut, elevation: Cut) -> float:
    """4π / ∫|E|² dΩ over the front hemisphere, E(l, n) = azimuth(l) elevation(n).

    With l = cos ε sin α and n = sin ε, dΩ = cos ε dα dε. Gauss–Legendre nodes in both, 1e-6 for beams down to 0.1°.
    """
    nodes, weights = np.polynomial.legendre.leggauss(160)
    up = 0.5 * np.pi * nodes
    # The azimuth beam can be very narrow: nodes are crowded at its centre by the map α = (π/2) s³.
    fine, fine_weights = np.polynomial.legendre.leggauss(800)
    across = 0.5 * np.pi * fine**3
    jacobian = 1.5 * np.pi * fine**2 * fine_weights
    total = 0.0
    for angle, weight in zip(up, weights, strict=True):
        level = np.cos(angle)
        cut = azimuth(level * np.sin(across)) ** 2 @ jacobian
        total += 0.5 * np.pi * weight * level * float(elevation(np.array([np.sin(angle)]))[0]) ** 2 * float(cut)
    return 4.0 * np.pi / total
