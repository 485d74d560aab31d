"""What water returns to a radar of what it would return if it were lit: shadows as VV and HH see them.

Lit water of tangent plane, met under a grazing angle ψ, has on it the field 2 sin ψ (HH: the normal derivative over
that of the wave) or 2 sin ψ/(sin ψ + α) (VV), with α the water's impedance along the surface over that of free space;
what is small on it returns the fourth power. In and beside shadows the field is F times that, by the edges of crests
(`diffraction`). And a crest is round: within (2/ka)^(1/3) of grazing, for a radius a of curvature along the look, no
plane stands for it. At the horizon of a smooth crest HH has f(0) (2/ka)^(1/3) in place of 0, f(0) = 0.776 (Fock 1965,
Electromagnetic Diffraction and Propagation Problems, chapter 2), as a plane of sin ψ = 0.388 (2/ka)^(1/3) would. With s
for that, sin ψ is taken as (sin^1.5 ψ + s^1.5)^(2/3), which up to the last facet before the horizon is right to 1.5 dB
of two-way power in HH and 3.5 dB in VV, where a plane is 30 dB off (`tests/tracing/test_visibility.py`).

Against wave optics on seas of 1/60 to 1/20, of all waves down to 12 mm, half of the water returns −6 dB or more within
a few metres of where this says (`validation/light/half_visible.py`); by light alone half is visible a tenth farther.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..conventions import POLARIZATIONS
from .diffraction import field_over_profiles
from .illumination import Illumination

_HORIZON = 0.388  # f(0)/2
_LEAST = 1e-4  # of sin ψ: what faces the ray less is taken as facing it by so much


def two_way_power(light: Illumination, polarization: str, permittivity: complex, wavelength_m: float) -> NDArray:
    """(column, facet) power over that of the same water lit, for the antenna that has least; 0 where no ray arrives.

    light: with the field over edges. polarization: VV or HH. permittivity: of the water, relative. ValueError for light
    without that field.
    """
    if light.field is None or light.ray_slope is None:
        raise ValueError("light: has no field over the edges of shadows; trace it with diffraction = 'knife_edge'")
    over_edges = np.abs(light.field).min(axis=0)
    plane = np.sin(np.arctan(light.slope_look) + np.arctan(light.ray_slope))
    return _power(over_edges, plane, _bend(light), polarization, permittivity, wavelength_m)


def profile_powers(
    distance_m: NDArray, height_m: NDArray, permittivity: complex, wavelength_m: float
) -> list[NDArray[np.float64]]:
    """(profile, facet) of the same in each of `POLARIZATIONS`, of facets between the corners of profiles of water.

    distance_m: of the corners from the antenna, evenly spaced (corner,); height_m: above it (profile, corner).
    """
    field, ray_slope = field_over_profiles(distance_m, height_m, wavelength_m)
    step = distance_m[1] - distance_m[0]
    slope = np.diff(height_m, axis=1) / step
    plane = np.sin(np.arctan(slope) + np.arctan(ray_slope))
    known = np.abs(field), plane, np.gradient(slope, step, axis=1)
    return [_power(*known, each, permittivity, wavelength_m) for each in POLARIZATIONS]


def _power(
    over_edges: NDArray, sine: NDArray, bend: NDArray, polarization: str, permittivity: complex, wavelength_m: float
) -> NDArray:
    """over_edges: field that arrives; sine: of the angle under which it meets the facet; bend: its curvature, 1/m."""
    plane = np.maximum(sine, _LEAST)
    horizon = _HORIZON * np.cbrt(np.maximum(-bend, 0.0) * wavelength_m / np.pi)
    round_crest = np.cbrt(plane**1.5 + horizon**1.5) ** 2
    gain = round_crest / plane
    if polarization == "VV":
        impedance = np.sqrt(permittivity - 1.0) / permittivity
        gain = gain * np.abs((plane + impedance) / (round_crest + impedance))
    return (over_edges * gain) ** 4


def _bend(light: Illumination) -> NDArray[np.float64]:
    """(column, facet) curvature along the look [1/m], of near and of far facets each by themselves."""
    bend = np.zeros(light.slope_look.shape)
    for kind in (0, 1):
        slope, distance = light.slope_look[:, kind::2], light.distance[kind::2]
        if distance.size > 1:
            bend[:, kind::2] = np.gradient(slope, distance, axis=1)
    return bend
