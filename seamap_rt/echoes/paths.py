"""Each facet's paths to the two antennas: their lengths, their difference, and the voltage that it returns.

A leaning baseline is taken to lean towards each column as the beam passes it; an upright one makes every length exact.

Three paths serve every pair of transmitter and receiver: m = tx + rx = 0 (lower, lower), 1 (mixed), 2 (upper, upper).
The phase of pair m is −2kR₀ − m k(R₁ − R₀); the difference is formed from the difference of squares, which keeps every
digit (3e-7 m even in float32; here float64).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..conventions import SPEED_OF_LIGHT
from ..mesh import Facets
from ..radar.antenna import antenna
from ..radar.receiver import amplitude_constant
from ..settings import RadarSettings


@dataclass(frozen=True)
class FacetPaths:
    """Paths of the facets of some columns; arrays (column, facet) unless said otherwise."""

    length: NDArray[np.float64]  # (pair, column, facet) half the path transmitter → facet → receiver [m]
    difference: NDArray[np.float64]  # R₁ − R₀ [m]
    radial_velocity: NDArray[np.float64]  # m/s, positive away
    # (pair, column, facet) voltage at boresight azimuth, before the range response [√W]; complex where light bends
    amplitude: NDArray[np.float32] | NDArray[np.complex64]

    @property
    def lower(self) -> NDArray[np.float64]:
        """R₀ [m]."""
        return self.length[0]


def facet_paths(
    facets: Facets, rcs: NDArray[np.float32], radar: RadarSettings, columns: slice, pairs: int
) -> FacetPaths:
    """Paths of the facets of `columns` for the pairs m < `pairs` (2 for a single transmitter, 3 for switched).

    rcs (column, facet) [m²] is that of all columns; a facet echoes in pair m only if it is lit for both of its
    antennas. With a diffracted field it echoes as far as that reaches it, lit or not, out and back alike.
    """
    if facets.lit is None:
        raise ValueError("these facets have not been traced; call a tracer first")
    tilt = np.radians(radar.tilt_deg)
    lean, rise = radar.baseline_m * np.sin(tilt), radar.baseline_m * np.cos(tilt)
    height = facets.height[columns] - radar.height_m
    distance = facets.distance
    lower = np.hypot(distance + 0.5 * lean, height + 0.5 * rise)
    upper = np.hypot(distance - 0.5 * lean, height - 0.5 * rise)
    difference = -2.0 * (distance * lean + height * rise) / (lower + upper)
    middle = 0.5 * (lower + upper)
    velocity = (facets.velocity_look[columns] * distance + facets.velocity_up[columns] * height) / middle

    pattern = antenna(radar)
    sine = np.cos(tilt) * height / middle + np.sin(tilt) * distance / middle
    elevation = _tabulated(pattern.elevation, sine) ** 2
    reach = amplitude_constant(radar) * elevation * np.sqrt(rcs[columns])
    voltage = [reach / spreading for spreading in (lower * lower, lower * upper, upper * upper)[:pairs]]
    if facets.field is None:
        lit = facets.lit[:, columns]
        seen = (lit[0], lit[0] & lit[1], lit[1])
        amplitude = np.stack([np.where(seen[m], v, 0.0).astype(np.float32) for m, v in enumerate(voltage)])
    else:
        field = facets.field[:, columns]
        ways = (field[0] * field[0], field[0] * field[1], field[1] * field[1])
        amplitude = np.stack([(v * ways[m]).astype(np.complex64) for m, v in enumerate(voltage)])
    return FacetPaths(
        length=np.stack((lower, middle, upper)[:pairs]),
        difference=difference,
        radial_velocity=velocity,
        amplitude=amplitude,
    )


def pair_count(radar: RadarSettings) -> int:
    """How many of the three pairs the radar's pulses use."""
    return 3 if radar.transmit == "switched" else 2


def wavenumber(radar: RadarSettings) -> float:
    """k = 2πf/c [rad/m]."""
    return 2.0 * np.pi * radar.frequency_hz / SPEED_OF_LIGHT


_TABLE = np.linspace(-1.0, 1.0, 20_001)


def _tabulated(cut, sine: NDArray[np.float64]) -> NDArray[np.float64]:
    """A pattern cut by linear interpolation in its direction cosine (1e-4 apart: 1e-6 of the peak for beams ≥ 1°)."""
    return np.interp(sine, _TABLE, cut(_TABLE))
