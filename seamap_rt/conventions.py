"""Conventions that hold in every module: axes, signs, angles and constants.

World frame: x east, y north, z up, metres; z = 0 is mean sea level; the origin lies below the antenna at time 0.
Azimuth and heading: degrees clockwise from north. Waves and wind are named by where they come *from*.
Time factor exp(+jωt): a path of length R multiplies a voltage by exp(−jkR); permittivity is ε′ − jε″.
Antenna and receiver 0 are the lower ones, 1 the upper ones. Interferometric phase is arg⟨V_lower V_upper*⟩.
Slopes are ∂z/∂(ground range), outward, and ∂z/∂(cross range), clockwise.
"""

from __future__ import annotations

from typing import SupportsInt, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

SPEED_OF_LIGHT = 299_792_458.0  # m/s, exact (SI)
BOLTZMANN = 1.380649e-23  # J/K, exact (SI)
REFERENCE_TEMPERATURE = 290.0  # K, the temperature at which noise figures are defined (IEEE)
GRAVITY = 9.81  # m/s²
WATER_DENSITY = 1025.0  # kg/m³, sea water at 35 psu
SURFACE_TENSION = 0.074  # N/m, clean sea water
EARTH_RADIUS = 6_371_000.0  # m; the 4/3 Earth of radar propagation uses 4/3 of it

POLARIZATIONS = ("VV", "HH")

Frequency = TypeVar("Frequency", float, NDArray[np.float64])


def turn_name(turn: SupportsInt, of: int | None = None) -> str:
    """A turn as people count, from 1: "turn 3", or "turn 3 of 5". turn: as datasets count, from 0."""
    return f"turn {int(turn) + 1}" + ("" if of is None else f" of {of}")


def ground_range(slant_m: ArrayLike, height_m: float) -> NDArray[np.float64]:
    """Horizontal distance [m] at which a slant range from an antenna meets mean sea level; 0 short of it."""
    return np.sqrt(np.maximum(np.asarray(slant_m, dtype=np.float64) ** 2 - height_m**2, 0.0))


def radar_wavelength(frequency_hz: Frequency) -> Frequency:
    """λ = c/f [m] of a carrier."""
    return SPEED_OF_LIGHT / frequency_hz


def radar_wavenumber(frequency_hz: Frequency) -> Frequency:
    """k = 2π f/c [rad/m] of a carrier."""
    return 2.0 * np.pi * frequency_hz / SPEED_OF_LIGHT


def unit_from_azimuth(azimuth_deg: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """East and north components of the unit vector that points to an azimuth (degrees clockwise from north)."""
    azimuth = np.radians(np.asarray(azimuth_deg, dtype=np.float64))
    return np.sin(azimuth), np.cos(azimuth)


def wrap_degrees(angle_deg: ArrayLike) -> NDArray[np.float64]:
    """An angle in degrees, brought into [−180, 180)."""
    return (np.asarray(angle_deg, dtype=np.float64) + 180.0) % 360.0 - 180.0


def wrap_phase(phase: ArrayLike) -> NDArray[np.float64]:
    """A phase in radians, brought into [−π, π)."""
    phase = np.asarray(phase, dtype=np.float64)
    return phase - 2.0 * np.pi * np.floor(phase / (2.0 * np.pi) + 0.5)  # a third of the time of a remainder


def db(ratio: ArrayLike) -> NDArray[np.float64]:
    """A power ratio in decibels; 0 becomes −inf without a warning."""
    with np.errstate(divide="ignore"):
        return 10.0 * np.log10(np.asarray(ratio, dtype=np.float64))


def from_db(level_db: ArrayLike) -> NDArray[np.float64]:
    """A level in decibels as a power ratio."""
    return 10.0 ** (np.asarray(level_db, dtype=np.float64) / 10.0)


def written(value: float, decimals: int) -> str:
    """A number with so many decimals, or with as many more as its first two digits need: 0.015 is never 0.0. Below a
    millionth by its power of ten. Without minus zero; a dash for what is not finite."""
    if not np.isfinite(value):
        return "—"
    size = abs(float(value))
    if 0.0 < size < 1e-6:
        return f"{value:.1e}"
    more = 1 - int(np.floor(np.log10(size))) if 0.0 < size < 0.95 * 10.0**-decimals else decimals
    return f"{round(float(value), more) + 0.0:.{more}f}"
