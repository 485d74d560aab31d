"""One-way antenna patterns, separable in the two direction cosines of the aperture, and the gain that they imply.

`slotted_waveguide` is a line source with Taylor's one-parameter taper (Taylor 1953; Hansen 1964) in either cut: its
pattern is sin(π√(u² − B²)) / (π√(u² − B²)) with u = (aperture/λ) · direction cosine. That family, because aperture and
beam width, all that is known of the antenna, leave one parameter, B; because it is lit by a smooth bell on a pedestal,
which slots can follow, where a design with equal sidelobes may ask for bright ends (Taylor 1955); and because its
sidelobes fall as 1/u, as those of a lit end do. Its nulls lie at u = √(n² + B²); its first sidelobe, at √(1.4303² +
B²), is 13.26 + 20 log₁₀(sinh πB/πB) dB down. Of the study's 1 m × 0.1 m at 10 GHz, 1.8° ask for B = 0.815, and so for a
first sidelobe of −21.3 dB at 2.8°; 18° for B = 0.802, and −21.0 dB at 29°.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import lru_cache, wraps
from pathlib import Path
from typing import Concatenate, ParamSpec, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..compute.quadrature import bisect, gauss_legendre
from ..conventions import from_db, radar_wavelength
from ..io.patternfile import read_pattern
from ..settings import AntennaSettings, RadarSettings

P = ParamSpec("P")
T = TypeVar("T")
OfRadar: TypeAlias = Callable[Concatenate[RadarSettings, P], T]

_PATTERN_ANGLES = 20_001  # of the half circle before the aperture

Cut = Callable[[NDArray[np.float64]], NDArray[np.float64]]  # direction cosine → voltage, 1 at its peak


@dataclass(frozen=True)
class Antenna:
    """A one-way voltage pattern E(l, n) = azimuth(l) · elevation(n), 1 at its peak, and the gain there.

    l is the direction cosine along the aperture's width (clockwise positive), n along its height (up). The peak is at
    boresight, l = n = 0, but for measured cuts, which may have theirs beside it.
    """

    azimuth: Cut
    elevation: Cut
    gain: float  # linear
    tilt: float  # rad, top towards the look: the boresight points down by it
    everywhere: bool = False  # receives behind the aperture too

    @property
    def azimuth_beamwidth_deg(self) -> float:
        """Full one-way −3 dB width of the azimuth cut in degrees, measured on the cut itself; inf if it has none."""
        return _beamwidth_deg(self.azimuth)

    @property
    def elevation_beamwidth_deg(self) -> float:
        """Full one-way −3 dB width of the elevation cut in degrees, measured on the cut itself; inf if it has none."""
        return _beamwidth_deg(self.elevation)

    def share_beyond(self, beams: float) -> float:
        """Share of the two-way azimuth pattern's power from more than so many of its beam widths off the boresight."""
        angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, _PATTERN_ANGLES)
        power = self.azimuth(np.sin(angle)) ** 4
        beyond = np.abs(angle) > np.radians(beams * self.azimuth_beamwidth_deg)
        return float(power[beyond].sum() / power.sum())

    def cosines(self, offset: ArrayLike, elevation: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Direction cosines (l, n) of a direction `offset` rad clockwise of the look and `elevation` rad up."""
        offset, elevation = np.asarray(offset, dtype=np.float64), np.asarray(elevation, dtype=np.float64)
        level = np.cos(elevation)
        height = np.cos(self.tilt) * np.sin(elevation) + np.sin(self.tilt) * level * np.cos(offset)
        return level * np.sin(offset), height

    def voltage(self, offset: ArrayLike, elevation: ArrayLike) -> NDArray[np.float64]:
        """One-way voltage towards a direction (rad, rad), relative to the peak; 0 behind the aperture."""
        across, up = self.cosines(offset, elevation)
        offset, elevation = np.asarray(offset, dtype=np.float64), np.asarray(elevation, dtype=np.float64)
        ahead = np.cos(self.tilt) * np.cos(elevation) * np.cos(offset) - np.sin(self.tilt) * np.sin(elevation)
        return np.where((ahead > 0.0) | self.everywhere, self.azimuth(across) * self.elevation(up), 0.0)


def antenna(radar: RadarSettings) -> Antenna:
    """The antenna of a radar that has one kind of them; repeated calls cost nothing."""
    return antenna_of(radar.antenna, radar.frequency_hz, radar.tilt_deg)


def antenna_of(settings: AntennaSettings, frequency_hz: float, tilt_deg: float) -> Antenna:
    """The antenna of any settings; its gain is the pattern's own directivity less the ohmic loss, or gain_dbi.

    A file's own gain is not used (`pattern_file.read_pattern` returns it), and squint is left out: `squint.squint_deg`
    tells it. Patterns are kept; a file is read again only when it has changed. ValueError for a beam that its aperture
    is too small for, InputError for a bad file.
    """
    if settings.file is not None:
        azimuth, elevation, gain = _measured(settings.file, _stamp(settings.file))
    else:
        azimuth, elevation, gain = _pattern(
            settings.pattern,
            radar_wavelength(frequency_hz),
            (settings.width_m, settings.height_m),
            (settings.azimuth_beamwidth_deg, settings.elevation_beamwidth_deg),
        )
    gain *= float(from_db(-settings.ohmic_loss_db))
    if settings.gain_dbi is not None:
        gain = float(from_db(settings.gain_dbi))
    return Antenna(azimuth, elevation, gain, float(np.radians(tilt_deg)), settings.pattern == "isotropic")


# ------------------------------------------------------------------------------------------------------------- the cuts


@lru_cache(maxsize=64)
def _pattern(
    name: str, wavelength: float, aperture: tuple[float, float], beamwidth_deg: tuple[float, float]
) -> tuple[Cut, Cut, float]:
    """The two cuts and the directivity; (azimuth, elevation) pairs."""
    if name == "isotropic":
        return _isotropic, _isotropic, 1.0
    if name == "gaussian":
        azimuth, elevation = (_gaussian(beam) for beam in beamwidth_deg)
    else:
        azimuth, elevation = (
            _line_source(size, wavelength, beam) for size, beam in zip(aperture, beamwidth_deg, strict=True)
        )
    return azimuth, elevation, directivity(azimuth, elevation)


@lru_cache(maxsize=64)
def _measured(file: str, stamp: tuple[int, int]) -> tuple[Cut, Cut, float]:
    """The two cuts of a file as it was at `stamp`, and their directivity."""
    pattern = read_pattern(file)
    return pattern.azimuth, pattern.elevation, directivity(pattern.azimuth, pattern.elevation)


def cache_by_radar(maxsize: int) -> Callable[[OfRadar[P, T]], OfRadar[P, T]]:
    """Keep the latest results of a function of a radar, and of more that can be hashed, until a pattern's file changes.
    Settings are frozen, and so hashable."""

    def decorate(function: OfRadar[P, T]) -> OfRadar[P, T]:
        @lru_cache(maxsize)
        def cached(_: Hashable, radar: RadarSettings, *rest: P.args, **named: P.kwargs) -> T:
            return function(radar, *rest, **named)

        @wraps(function)
        def wrapper(radar: RadarSettings, *rest: P.args, **named: P.kwargs) -> T:
            files = [each.file for each in (radar.antenna, *radar.antennas) if each.file is not None]
            return cached(tuple(map(_stamp, files)), cast(Hashable, radar), *rest, **named)

        return wrapper

    return decorate


def _stamp(file: str) -> tuple[int, int]:
    try:
        facts = Path(file).stat()
    except (OSError, ValueError):
        return 0, 0  # reading it raises the error
    return facts.st_mtime_ns, facts.st_size


def _isotropic(cosine: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.ones_like(np.asarray(cosine, dtype=np.float64))


def _gaussian(beamwidth_deg: float) -> Cut:
    width = np.radians(beamwidth_deg)
    return lambda cosine: np.exp(
        -2.0 * np.log(2.0) * (np.arcsin(np.clip(np.asarray(cosine, dtype=np.float64), -1.0, 1.0)) / width) ** 2
    )


def _line_source(aperture_m: float, wavelength_m: float, beamwidth_deg: float) -> Cut:
    """The cut of a line source whose taper gives the one-way −3 dB beam width."""
    length = aperture_m / wavelength_m
    half = length * np.sin(0.5 * np.radians(beamwidth_deg))

    def excess(taper: float) -> float:
        return float(_taylor_pattern(np.array([half]), taper)[0] - np.sqrt(0.5))

    if excess(0.0) > 0.0:
        narrowest = 2.0 * np.degrees(np.arcsin(min(1.0, 0.44295 / length)))
        raise ValueError(
            f"beam width {beamwidth_deg:g}° is narrower than a uniform aperture of {aperture_m:g} m gives "
            f"({narrowest:.3g}°); widen the beam or the aperture"
        )
    top = 1.0
    while excess(top) < 0.0:
        top *= 2.0
    taper = bisect(excess, 0.0, top)
    return lambda cosine: _taylor_pattern(length * np.asarray(cosine, dtype=np.float64), taper)


def _taylor_pattern(u: NDArray[np.float64], taper: float) -> NDArray[np.float64]:
    """Taylor's one-parameter voltage pattern, 1 at u = 0: sinh inside |u| < taper, sin beyond.

    Both are divided by sinh(π taper)/(π taper); exponents are subtracted first, so that strong tapers do not overflow.
    """
    inside = taper**2 - u**2
    root = np.maximum(np.pi * np.sqrt(np.abs(inside)), 1e-8)
    whole = max(np.pi * taper, 1e-8)
    scale = 2.0 * whole / -np.expm1(-2.0 * whole)
    wave = np.asarray(np.exp(-whole) * np.sin(root))
    main = inside > 0.0  # seldom
    wave[main] = 0.5 * np.exp(np.minimum(root[main] - whole, 0.0)) * -np.expm1(-2.0 * root[main])
    return scale * wave / root


# ---------------------------------------------------------------------------------------- what is measured on the cuts


@lru_cache(maxsize=256)
def _beamwidth_deg(cut: Cut) -> float:
    """Angle between the half-power points to either side of the peak, by root finding; inf where there are not two."""

    def excess(angle_deg: float) -> float:
        return float(cut(np.sin(np.radians(np.array([angle_deg]))))[0] - np.sqrt(0.5))

    angle, voltage = _sampled(cut)
    peak, low = int(np.argmax(voltage)), np.flatnonzero(voltage < np.sqrt(0.5))
    before, after = low[low < peak], low[low > peak]
    if before.size == 0 or after.size == 0:
        return np.inf
    start, stop = (bisect(excess, float(angle[index]), float(angle[index + 1])) for index in (before[-1], after[0] - 1))
    return stop - start


def _sampled(cut: Cut) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Angles (deg) over the half circle ahead, ten to the narrowest beam that the settings allow, and the voltage."""
    angle = np.linspace(-90.0, 90.0, 36_001)
    return angle, np.abs(cut(np.sin(np.radians(angle))))


def directivity(azimuth: Cut, elevation: Cut) -> float:
    """4π / ∫|E|² dΩ over the front hemisphere, E(l, n) = azimuth(l) elevation(n), 1 at the peak of both.

    With l = cos ε sin α and n = sin ε, dΩ = cos ε dα dε. Nodes crowd about the peak of each cut, wherever it is: 1e-6
    for beams of any width, 1e-4 with the sidelobes of an aperture of a hundred wavelengths, 0.02 dB of any larger one.
    """
    angles = (_sampled(cut) for cut in (azimuth, elevation))
    across_peak, up_peak = (float(np.radians(angle[np.argmax(voltage)])) for angle, voltage in angles)
    up, up_weight = _nodes(np.array(up_peak), panels=30, nodes=6)
    level = np.cos(up)
    # Off the horizontal plane the ridge of the azimuth cut, l = sin(peak), is seen at a larger angle.
    ridge = np.arcsin(np.clip(np.sin(across_peak) / level, -1.0, 1.0))
    across, across_weight = _nodes(ridge[:, None], panels=45, nodes=8)
    cut = np.sum(azimuth(level[:, None] * np.sin(across)) ** 2 * across_weight, axis=1)
    return 4.0 * np.pi / float(np.sum(up_weight * level * elevation(np.sin(up)) ** 2 * cut))


def _nodes(centre: NDArray[np.float64], panels: int, nodes: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Gauss–Legendre nodes and weights (…, node) over −π/2 … π/2, in panels that halve towards a centre (…, 1).

    To either side there are so many equal panels, the one at the centre halved again down to some 1/10000 of the side.
    """
    edges = np.concatenate(([0.0], 2.0 ** np.arange(-13.0, -np.log2(panels)), np.arange(1.0, panels + 1.0) / panels))
    unit, unit_weight = gauss_legendre(nodes)
    half = 0.5 * np.diff(edges)[:, None]
    share, weight = (half * unit + edges[:-1, None] + half).ravel(), (half * unit_weight).ravel()
    right, left = 0.5 * np.pi - centre, -0.5 * np.pi - centre
    return (
        np.concatenate((centre + left * share, centre + right * share), axis=-1),
        np.concatenate((-left * weight, right * weight), axis=-1),
    )
