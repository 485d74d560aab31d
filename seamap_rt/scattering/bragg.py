"""What a facet covered with short wind waves returns: first-order Bragg scattering, upright and tilted.

θ is the ray's incidence against the vertical, θi its incidence against the facet's own normal. Rice, Commun.
Pure Appl. Math. 4, 351–378 (1951) and Valenzuela, Boundary-Layer Meteorol. 13, 61–85 (1978) give the
coefficients and the two-scale law. σ0 here is per unit of the facet's TRUE area.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import POLARIZATIONS, radar_wavenumber
from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.scattering.permittivity import fresnel
from seamap_rt.scattering.short_waves import ShortWaves
from seamap_rt.sea.spectra import DEVELOPED_INVERSE_WAVE_AGE

Array = NDArray[np.floating]


class FacetView(NamedTuple):
    """Arrays of one shape; θi is the incidence against the plane's own normal, χ the turn of the Bragg vector."""

    cos_local: Array  # cos θi, negative from behind
    inverse_sine2: Array  # 1/sin² θi; 0 for a plane seen squarely
    along_range: Array  # the ray's projection on the plane, of length sin θi: down the plane's own range axis …
    along_cross: Array  # … and anticlockwise
    a2: Array  # A², the share of the polarization that stays: A = sin(θ − s_in) cos s_cross/sin θi
    ab: Array  # A B, B = sin s_cross/sin θi, A² + B² = 1

    def wind_double(self, along: Array, across: Array) -> tuple[Array, Array]:
        """cos and sin of 2 (w − χ), from cos w and sin w: the wind's axis against the Bragg vector."""
        square = self.inverse_sine2 == 0.0
        cosine = np.where(square, 1.0, (self.along_range**2 - self.along_cross**2) * self.inverse_sine2)
        sine = 2.0 * self.along_range * self.along_cross * self.inverse_sine2
        wind_cosine, wind_sine = along * along - across * across, 2.0 * along * across
        return wind_cosine * cosine + wind_sine * sine, wind_sine * cosine - wind_cosine * sine

    def upwind(self, along: Array, across: Array) -> Array:
        """sin θi cos(w − χ): what a tilt towards the wind's origin adds to cos θi, per slope and with its sign."""
        return along * self.along_range + across * self.along_cross


def facet_view(sine: Array, cosine: Array, slope_range: Array, slope_cross: Array) -> FacetView:
    """The view along a ray with sin θ and cos θ against the vertical, for slopes outward and clockwise; they broadcast.

    With s_in and s_cross the tilts, cos θi = cos(θ − s_in) cos s_cross; the Bragg vector is the ray's projection on the
    plane, of length sin θi, and turns anticlockwise from the look by χ, tan χ = cos(θ − s_in) sin s_cross/sin(θ − s_in)
    (Valenzuela, Boundary-Layer Meteorol. 13, 61–85, 1978). A plane seen squarely counts as A = 1, χ = 0.
    """
    p, q = slope_range, slope_cross
    in_plane = 1.0 / (1.0 + p * p)  # cos² s_in
    normal_up = 1.0 / (1.0 + p * p + q * q)  # (cos s_in cos s_cross)²
    towards, away = cosine + p * sine, sine - p * cosine  # cos(θ − s_in), sin(θ − s_in), both over cos s_in
    up = np.sqrt(normal_up)
    root = np.sqrt(in_plane)
    along_range, along_cross = away * root, towards * root * (q * up)
    sine2 = along_range * along_range + along_cross * along_cross
    square = sine2 < 1e-12
    inverse = np.where(square, 0.0, 1.0 / np.where(square, 1.0, sine2))
    b = q * normal_up * inverse
    return FacetView(
        cos_local=np.minimum(towards * up, 1.0),
        inverse_sine2=inverse,
        along_range=along_range,
        along_cross=along_cross,
        a2=1.0 - np.minimum(q * b, 1.0),
        ab=away * b,
    )


def bragg_coefficients(
    incidence: ArrayLike, permittivity: ArrayLike
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """First-order coefficients (g_hh, g_vv) of a slightly rough half-space at an incidence [rad]."""
    theta = np.asarray(incidence, dtype=np.float64)
    eps = np.asarray(permittivity, dtype=np.complex128)
    cosine, sine2 = np.cos(theta), np.sin(theta) ** 2
    below = np.sqrt(eps - sine2)
    g_hh = (eps - 1.0) / (cosine + below) ** 2
    g_vv = (eps - 1.0) * (eps * (1.0 + sine2) - sine2) / (eps * cosine + below) ** 2
    return g_hh, g_vv


def nrcs_bragg(
    incidence: ArrayLike,
    frequency_hz: float,
    permittivity: ArrayLike,
    spectrum_at_bragg: ArrayLike,
    polarization: str,
) -> NDArray[np.float64]:
    """First-order σ0 [linear] = 16π k⁴ cos⁴θ |g|² Ψ of an untilted rough plane, HH or VV.

    incidence: rad. spectrum_at_bragg: the symmetric plane spectrum Ψ [m⁴] at the Bragg wave vector, of length
    2k sin θ, with ∫Ψ d²k the height variance over the whole plane. They broadcast. No ceiling: it grows
    without bound towards the vertical, where first-order theory ends.
    """
    g_hh, g_vv = bragg_coefficients(incidence, permittivity)
    g = g_hh if _check_polarization(polarization) == "HH" else g_vv
    cosine = np.cos(np.asarray(incidence, dtype=np.float64))
    k = radar_wavenumber(frequency_hz)
    return 16.0 * np.pi * k**4 * cosine**4 * np.abs(g) ** 2 * np.asarray(spectrum_at_bragg, dtype=np.float64)


def nrcs_two_scale(
    incidence: ArrayLike,
    slope_range: ArrayLike,
    slope_cross: ArrayLike,
    wind_angle: ArrayLike,
    *,
    frequency_hz: float,
    wind_speed: float,
    permittivity: complex,
    polarization: str,
    inverse_wave_age: float = DEVELOPED_INVERSE_WAVE_AGE,
    resolved_below: float = 0.0,
) -> NDArray[np.float32]:
    """σ0 [linear] per unit TRUE area of tilted facets that carry Elfouhaily's short waves; 0 from behind.

    The law of a bare facet, in one formula; a run takes `nrcs_composite`, which adds the tilts that the mesh does not
    carry, mirrors and breakers.

    incidence: rad between the ray and the vertical (90° − grazing), at the facet.
    slope_range: ∂z/∂(outward ground range); positive leans towards the radar, and θi shrinks.
    slope_cross: ∂z/∂(clockwise cross range).
    wind_angle: look azimuth − azimuth where the wind comes from [rad], both clockwise; 0 looks into the wind.

    These broadcast, and may be float32. The rest are scalars: frequency [Hz], wind at 10 m [m/s], ε′ − jε″,
    "HH" or "VV", and the wavenumber [rad/m] up to which waves are slopes of the facets already and not roughness
    on them. ValueError for another polarization or a wind that Elfouhaily's spectrum refuses.

    With s_in and s_cross the facet's tilts, cos θi = cos(θ − s_in) cos s_cross, and (Valenzuela 1978)
      HH: |A² g_hh + B² g_vv|², VV: |A² g_vv + B² g_hh|²,
      A = sin(θ − s_in) cos s_cross/sin θi, B = sin s_cross/sin θi,
    so that A² + B² = 1; seen squarely, g_hh = g_vv and A counts as 1. The Bragg vector is the
    ray's projection on the facet: it has length 2k sin θi and, in the facet's own axes, turns anticlockwise
    from the look by χ, tan χ = cos(θ − s_in) sin s_cross/sin(θ − s_in). The short waves keep their directions
    relative to those axes, so the spreading is taken at wind_angle − χ. Not included: the waves' own
    modulation by the long ones, and breakers.

    Towards θi = 0 the Bragg waves grow as long as the facet is and first-order theory diverges. What a rough
    facet seen squarely does return is specular, at most |R(0)|²/mss (Barrick 1968; Cox & Munk's mean square
    slope of the wind), so σ0 = σ_B/(1 + σ_B/σ_max): 1 % below Bragg where that is 20 dB below σ_max, and
    never above σ_max. Waves longer than the spectrum's peak count as the peak.
    """
    waves = ShortWaves(float(wind_speed), float(resolved_below), float(inverse_wave_age))
    inputs = (incidence, slope_range, slope_cross, wind_angle)
    theta, along, across, wind = (np.asarray(each, dtype=np.float64) for each in inputs)
    view = facet_view(np.sin(theta), np.cos(theta), along, across)
    wind_axis, _ = view.wind_double(np.cos(wind), np.sin(wind))
    local = np.arccos(np.maximum(view.cos_local, 0.0))
    g_hh, g_vv = bragg_coefficients(local, permittivity)
    like, other = (g_hh, g_vv) if _check_polarization(polarization) == "HH" else (g_vv, g_hh)
    k = radar_wavenumber(frequency_hz)
    k_bragg = np.maximum(2.0 * k * np.sin(local), waves.longest)
    plane_spectrum = waves.spectrum(k_bragg) / (2.0 * np.pi * k_bragg) * (1.0 + waves.contrast(k_bragg) * wind_axis)
    mixed = view.a2 * like + (1.0 - view.a2) * other
    sigma = 16.0 * np.pi * k**4 * np.cos(local) ** 4 * np.abs(mixed) ** 2 * plane_spectrum
    ceiling = abs(complex(fresnel(0.0, permittivity)[0])) ** 2 / waves.mean_square_slope
    return np.asarray(sigma / (1.0 + sigma / ceiling), dtype=np.float32)


def bragg_speed(frequency_hz: float) -> float:
    """Phase speed [m/s] in deep water of the waves of half the radar's length, which scatter at grazing."""
    k = 2.0 * radar_wavenumber(frequency_hz)
    return float(angular_frequency(k)) / k


def _check_polarization(polarization: str) -> str:
    if polarization not in POLARIZATIONS:
        raise ValueError(f"polarization = {polarization!r}: must be one of {', '.join(POLARIZATIONS)}")
    return polarization
