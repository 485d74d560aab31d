"""A wave system of the scene as functions: its wavenumber spectrum, its spreading, where it travels to."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..conventions import GRAVITY, SURFACE_TENSION, WATER_DENSITY, unit_from_azimuth
from ..errors import InputError
from ..physics.dispersion import angular_frequency, group_speed, wavenumber
from ..settings import (
    HIGHEST_SEA_M,
    PERIODS_S,
    ElfouhailyWaves,
    FileWaves,
    JonswapWaves,
    PiersonMoskowitzWaves,
    RandomWaves,
    SeaSettings,
    SinusoidWaves,
    SpectralWaves,
    SpreadWaves,
    TmaWaves,
    WaveSystem,
)
from . import spectra, spreading
from .lattice import Radial, Spreading
from .tabulated import TabulatedSpectrum

GRAVITY_CAPILLARY_WAVENUMBER = float(np.sqrt(GRAVITY * WATER_DENSITY / SURFACE_TENSION))  # rad/m, 368.6
_LONGEST, _SHORTEST = 1e-7, 1e5  # rad/m, beyond every sea wave
_EAST = (1.0, 0.0)


@dataclass(frozen=True)
class SpectralSystem:
    """One random wave system, ready to be realised."""

    radial: Radial  # S(k) [m³]
    spreading: Spreading | None  # None: long-crested
    toward: tuple[float, float]  # unit vector of travel, east north; the spreading's angles count from it
    depth: float  # m
    shortest: float = GRAVITY_CAPILLARY_WAVENUMBER  # rad/m, up to which the spectrum is valid

    def moment(self, power: int, limit: float = _SHORTEST) -> float:
        """∫ k^power S(k) dk up to `limit` rad/m: variance [m²] for 0, mean square slope for 2. To about 1e-7."""
        return _moment(self, power, limit)

    @cached_property
    def variance(self) -> float:
        """Variance of all its waves, m²."""
        return self.moment(0)

    @cached_property
    def peak_wavenumber(self) -> float:
        """Wavenumber [rad/m] at which the frequency spectrum is highest."""
        k = np.geomspace(1e-5, 1e3, 20_001)
        # Per frequency, not per wavenumber: that is what a peak period means.
        return float(k[np.argmax(self.radial(k) / group_speed(k, self.depth))])


@lru_cache(maxsize=256)
def _moment(system: SpectralSystem, power: int, limit: float) -> float:
    log_k = np.linspace(np.log(_LONGEST), np.log(limit), 30_001)
    k = np.exp(log_k)
    return float(np.trapezoid(k ** (power + 1) * system.radial(k), log_k))


def spectral_system(waves: RandomWaves, depth: float) -> SpectralSystem:
    """The functions of one random system of the scene. Raises ValueError where they are not defined."""
    if isinstance(waves, FileWaves):  # a file may be written anew
        return _system(waves, depth)
    return _kept_system(cast(Hashable, waves), depth)


def _system(waves: RandomWaves, depth: float) -> SpectralSystem:
    match waves:
        case FileWaves():
            table = _table(waves, depth)
            return SpectralSystem(table.radial, table.spreading, _EAST, depth)
        case ElfouhailyWaves():
            wind, age = waves.wind_speed_m_s, _elfouhaily_age(waves)
            radial = partial(spectra.elfouhaily97, wind_speed=wind, inverse_wave_age=age)
            peak = spectra.elfouhaily97_peak_wavenumber(wind, age)
            spread = _spreading(waves, _Peak(peak, depth, age, wind))
            return SpectralSystem(radial, spread, travel_direction(waves), depth, _SHORTEST)
        case SpectralWaves():
            radial = partial(spectra.wavenumber_spectrum, _frequency_spectrum(waves, depth), depth=depth)
            return SpectralSystem(radial, _spreading(waves, _peak(waves, depth)), travel_direction(waves), depth)
    raise TypeError(f"spectrum of {type(waves).__name__}: not known to the sea")


_kept_system = lru_cache(maxsize=64)(_system)


def travel_direction(waves: SpreadWaves | SinusoidWaves) -> tuple[float, float]:
    """Unit vector, east north, of where the waves go: opposite to where they come from."""
    # Rounded, so that north is exactly north: waves exactly across count half, to either side.
    east, north = np.round(unit_from_azimuth(waves.wave_from_deg + 180.0), 15)
    return float(east) + 0.0, float(north) + 0.0


def azimuth_toward(direction: tuple[float, float]) -> float:
    """Azimuth (deg) of a direction of travel."""
    return float(np.degrees(np.arctan2(direction[0], direction[1])) % 360.0)


def directional_density(
    system: SpectralSystem, frequency_hz: ArrayLike, from_deg: ArrayLike, depth: float
) -> NDArray[np.float64]:
    """E(f, θ) [m²/(Hz·degree)] of a short-crested system; frequencies (f,) and directions it comes from (d,).

    Raises ValueError for a long-crested system, whose density over directions is not finite.
    """
    if system.spreading is None:
        raise ValueError("spreading = 'long_crested': has no density over directions; choose another spreading")
    omega = 2.0 * np.pi * np.asarray(frequency_hz, dtype=np.float64)[:, None]
    k = wavenumber(omega, depth)
    east, north = unit_from_azimuth(np.asarray(from_deg, dtype=np.float64)[None, :] + 180.0)
    along = system.toward[0] * east + system.toward[1] * north
    across = system.toward[0] * north - system.toward[1] * east
    per_radian = system.radial(k) * (2.0 * np.pi / group_speed(k, depth)) * system.spreading(k, along, across)
    return np.asarray(per_radian * np.pi / 180.0)


@dataclass(frozen=True)
class WaveFacts:
    """One wave system in oceanographic parameters."""

    height: float  # m: significant, of a regular wave crest to trough
    peak_period: float  # s
    from_deg: float  # mean direction, clockwise from north
    wavenumber: float  # rad/m, of the peak
    deviation: float  # m, of the elevation


def wave_facts(waves: WaveSystem, depth: float) -> WaveFacts | None:
    """Height, period and direction of a wave system, all its waves counted; None for no waves."""
    match waves:
        case SinusoidWaves() if waves.height_m > 0.0:
            k = 2.0 * np.pi / waves.wavelength_m
            period = 2.0 * np.pi / float(angular_frequency(k, depth))
            return WaveFacts(waves.height_m, period, waves.wave_from_deg % 360.0, k, waves.height_m / math.sqrt(8.0))
        case RandomWaves():
            system = spectral_system(waves, depth)
            if system.variance <= 0.0:
                return None
            k, deviation = system.peak_wavenumber, math.sqrt(system.variance)
            period = 2.0 * np.pi / float(angular_frequency(k, depth))
            toward = travel_direction(waves) if isinstance(waves, SpreadWaves) else _mean_direction(system)
            return WaveFacts(4.0 * deviation, period, (azimuth_toward(toward) + 180.0) % 360.0, k, deviation)
    return None


def _mean_direction(system: SpectralSystem) -> tuple[float, float]:
    """East and north components of the mean vector of travel, for a system in the frame of the east."""
    assert system.spreading is not None
    k = np.geomspace(1e-4, 1e2, 2001)[:, None]
    angle = 2.0 * np.pi * np.arange(720) / 720
    along, across = np.cos(angle), np.sin(angle)
    weight = k * system.radial(k) * system.spreading(k, along, across)
    return float(np.sum(weight * along)), float(np.sum(weight * across))


# ------------------------------------------------------------------------------------------------------ spectra


def _frequency_spectrum(waves: SpectralWaves, depth: float) -> Callable[..., NDArray[np.float64]]:
    """S(ω) of a system, by its height and period or by the wind."""
    hs, tp, wind = waves.significant_wave_height_m, waves.peak_period_s, waves.wind_speed_m_s
    match waves:
        case PiersonMoskowitzWaves() if wind is not None:
            return partial(spectra.pierson_moskowitz, wind_speed=wind)
        case PiersonMoskowitzWaves() if hs is not None and tp is not None:
            return partial(spectra.pierson_moskowitz_scaled, hs=hs, tp=tp)
        case JonswapWaves() if wind is not None and waves.fetch_m is not None:
            return partial(spectra.jonswap_fetch, wind_speed=wind, fetch=waves.fetch_m, gamma=waves.peak_enhancement)
        case JonswapWaves() if hs is not None and tp is not None:
            return partial(spectra.jonswap, hs=hs, tp=tp, gamma=waves.peak_enhancement)
        case TmaWaves() if wind is not None and waves.fetch_m is not None:
            parent = partial(spectra.jonswap_fetch, wind_speed=wind, fetch=waves.fetch_m, gamma=waves.peak_enhancement)
            return lambda omega: parent(omega) * spectra.tma_depth_factor(omega, depth)
        case TmaWaves() if hs is not None and tp is not None:
            parent_height = hs / spectra.tma_height_ratio(tp, waves.peak_enhancement, depth)
            return partial(spectra.tma, hs=parent_height, tp=tp, gamma=waves.peak_enhancement, depth=depth)
    raise TypeError(f"spectrum of {type(waves).__name__}: not known to the sea")


def _elfouhaily_age(waves: ElfouhailyWaves) -> float:
    if waves.fetch_m is None:
        return waves.inverse_wave_age or spectra.DEVELOPED_INVERSE_WAVE_AGE
    age = spectra.elfouhaily97_inverse_wave_age(waves.wind_speed_m_s, waves.fetch_m)
    if age > 5.0:
        raise InputError(
            f"fetch_m = {waves.fetch_m:g}: gives U10/cp = {age:.3g}, must be at most 5 (Elfouhaily et al. 1997); "
            "raise fetch_m or lower wind_speed_m_s"
        )
    return age


def _table(waves: FileWaves, depth: float) -> TabulatedSpectrum:
    if waves.kind == "recorded":
        from .recorded import recorded_spectrum

        return recorded_spectrum(waves.file, depth)
    frequency, direction, density = _read_content(
        waves.file, waves.kind, waves.time, waves.site, _version(Path(waves.file))
    )
    table = TabulatedSpectrum(frequency, direction, density, depth, waves.tail_exponent)
    with np.errstate(over="ignore"):
        height = table.hs
    if not height <= HIGHEST_SEA_M:
        raise InputError(
            f"'{waves.file}': its significant wave height is {height:.4g} m: must be at most {HIGHEST_SEA_M:g} (no sea "
            "above 30 m); check that the densities are in the units of its kind, and that what is missing is declared"
        )
    period = 1.0 / table.peak_frequency_hz if height > 0.0 else PERIODS_S[1]
    if not PERIODS_S[0] <= period <= PERIODS_S[1]:
        raise InputError(
            f"'{waves.file}': its peak period is {period:.4g} s: must be {PERIODS_S[0]:g} to {PERIODS_S[1]:g} (wind "
            "waves and swell lie there); check that the frequencies are in Hz"
        )
    return table


def file_versions(settings: SeaSettings) -> tuple[object, ...]:
    """What tells the files that a sea is made of from those of the same names that are written later."""
    files = [waves.file for waves in settings.waves if isinstance(waves, FileWaves)]
    return tuple(_version(Path(file)) for file in (*files, settings.file) if file)


def _version(path: Path) -> tuple[object, ...]:
    """The version of a file, or of all that a folder holds."""
    try:
        members = sorted(path.rglob("*")) if path.is_dir() else [path]
        states = [(member, member.stat()) for member in members]
    except (OSError, ValueError):  # the reader says what is wrong
        return (path,)
    return path, *((str(member), state.st_mtime_ns, state.st_size) for member, state in states)


@lru_cache(maxsize=8)
def _read_content(
    file: str, kind: str, time: str | None, site: int, _: tuple[object, ...]
) -> tuple[NDArray[np.float64], ...]:
    """Content of a file of one version: a file that is written anew is read anew."""
    from ..io.spectrumfile import read_directional_spectrum  # loads xarray

    table = read_directional_spectrum(file, kind, time, site)
    return table.frequency_hz, table.from_deg, table.density


# ---------------------------------------------------------------------------------------------------- spreading


@dataclass(frozen=True)
class _Peak:
    """What a spreading takes from the peak."""

    wavenumber: float
    depth: float
    inverse_wave_age: float
    wind_speed: float

    def frequency_ratio(self, k: NDArray[np.float64]) -> NDArray[np.float64]:
        """f/fp of wavenumbers."""
        peak = angular_frequency(self.wavenumber, self.depth)
        return angular_frequency(k, self.depth) / peak


def _peak(waves: SpectralWaves, depth: float) -> _Peak:
    """Peak and wave age of a system: U10/cp as given, else by the wind, else that of a fully developed sea."""
    omega = _peak_frequency(waves)
    k = float(wavenumber(omega, depth))
    speed, wind = omega / k, waves.wind_speed_m_s
    age = waves.inverse_wave_age or (wind / speed if wind else spectra.DEVELOPED_INVERSE_WAVE_AGE)
    return _Peak(k, depth, age, wind or age * speed)


def _peak_frequency(waves: SpectralWaves) -> float:
    """ω of the peak [rad/s]; of TMA, that of its parent."""
    if waves.peak_period_s is not None:
        return 2.0 * np.pi / waves.peak_period_s
    wind = waves.wind_speed_m_s
    assert wind is not None
    fetch = getattr(waves, "fetch_m", None)
    return (
        spectra.peak_frequency_pierson_moskowitz(wind) if fetch is None else spectra.peak_frequency_jonswap(wind, fetch)
    )


def _spreading(waves: SpreadWaves, peak: _Peak) -> Spreading | None:
    """Density over the angle [1/rad] as the lattice asks for it: of k, cos θ, sin θ."""
    age = peak.inverse_wave_age
    match waves.spreading:
        case "long_crested":
            return None
        case "cos2s":
            return lambda k, along, across: spreading.cos2s_of_cosine(along, waves.spreading_exponent)
        case "mitsuyasu":
            return lambda k, along, across: spreading.cos2s_of_cosine(
                along, spreading.mitsuyasu_exponent(peak.frequency_ratio(k), age)
            )
        case "hasselmann":
            return lambda k, along, across: spreading.cos2s_of_cosine(
                along, spreading.hasselmann_exponent(peak.frequency_ratio(k), age)
            )
        case "donelan_banner":
            return lambda k, along, across: spreading.donelan_banner(
                np.arctan2(across, along), spreading.donelan_banner_beta(peak.frequency_ratio(k))
            )
        case "elfouhaily":
            return lambda k, along, across: spreading.half_plane_elfouhaily(
                along, spectra.elfouhaily97_contrast(k, peak.wind_speed, peak.wavenumber)
            )
