"""What a facet that shorter waves tilt returns: Bragg scattering averaged over those slopes, and what they mirror.

Of the wind's waves on a facet those beyond k_d scatter, and those between the mesh's limit and k_d tilt the scatterers.
The tilts are Gaussian, with the spectrum's variances along and across the wind; the average is a sum over a grid of
tilts, made once for each facet's incidence and kept in a table (Valenzuela, Boundary-Layer Meteorol. 13, 61–85, 1978).
Quasi-specular returns of the tilts are alike in HH and VV (Barrick, IEEE Trans. Antennas Propag. 16, 449–454, 1968).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.special import ndtr

from seamap_rt.conventions import radar_wavenumber
from seamap_rt.scattering.bragg import Array, FacetView, bragg_coefficients, facet_view
from seamap_rt.scattering.permittivity import fresnel
from seamap_rt.scattering.short_waves import ShortWaves

NODES = 4096  # steps of the tables in the cosine of incidence

_REACH = 4.5  # standard deviations of tilt that are summed
_STEPS = 13  # grid points of tilt on either side: three to a standard deviation
_INCIDENCES = 400  # at which the average is made; a spline carries it to the table
_WINDS = 8  # directions of the wind in half a turn: 2φ is free of all harmonics below 14φ
_LEAST_TILT = 1e-8  # slope variance that stands in for none


class TiltedBragg(NamedTuple):
    """What depends on cos θi alone, by equal steps of it. φ is the wind's axis against the Bragg vector."""

    low: float  # the smallest cos θi, negative: a facet seen from behind still shows its steepest tilts
    table: NDArray[np.float32]  # (node, 8): means and their cos 2φ of three, then sin 2φ of two
    # ⟨|s_pp|²⟩, to be taken times A⁴; ⟨2 Re s_pp s_qq* + 4 |s_pq|²⟩, times A² B²; ⟨|s_qq|²⟩, times B⁴;
    # ±4 ⟨Re s_pp s_pq*⟩, times A³ B; ±4 ⟨Re s_qq s_pq*⟩, times A B³

    def nrcs(self, view: FacetView, wind_cosine: Array, wind_sine: Array) -> Array:
        """σ0 per unit true area, for a view in float32 and the cos 2φ and sin 2φ of the wind."""
        scale = float(np.float32(NODES / (1.0 - self.low)))
        position = np.fmax(view.cos_local - float(np.float32(self.low)), 0.0) * scale  # of what is no number 0
        index = position.astype(np.intp)
        part = position - index.astype(np.float32)
        rows = self.table.take(index, axis=0)  # (…, column)
        rows += part[..., None] * (self.table.take(index + 1, axis=0) - rows)
        like, mixed, other = (rows[..., n] + rows[..., n + 1] * wind_cosine for n in (0, 2, 4))
        a2 = view.a2
        b2 = 1.0 - a2
        skew = (rows[..., 6] * a2 + rows[..., 7] * b2) * (view.ab * wind_sine)
        return np.maximum(like * (a2 * a2) + mixed * (a2 * b2) + other * (b2 * b2) + skew, 0.0)


@lru_cache(maxsize=32)
def tilted_bragg(frequency_hz: float, permittivity: complex, polarization: str, waves: ShortWaves) -> TiltedBragg:
    """The table of one radar, sea and polarization. In the facet's own plane of incidence a tilt's amplitudes are

    s_hh = A² g_hh + B² g_vv, s_vv = A² g_vv + B² g_hh, s_hv = A B (g_vv − g_hh), with the A and B of that tilt; its
    weight is that of the tilt, its true area, and the spectrum of roughness in its direction. Tilts that turn away
    from the ray count 0. They cast no shadow on each other: their shadows are shorter than a Fresnel
    zone (`tracing.unresolved_shadowing` casts them as light would).
    The wind's harmonics beyond 2φ are left out: 4φ has up to 4 % of the mean.
    """
    divide = waves.divide(radar_wavenumber(frequency_hz))
    tilt = np.sqrt(np.maximum(waves.tilt_variances(divide), _LEAST_TILT))
    steps = np.arange(-_STEPS, _STEPS + 1) * (_REACH * max(tilt) / _STEPS)
    t_range, t_cross = (each.ravel() for each in np.meshgrid(steps, steps, indexing="ij"))
    incidence = np.linspace(0.0, 0.5 * np.pi + np.arctan(_REACH * max(tilt)), _INCIDENCES)
    sine, cosine = np.sin(incidence)[:, None], np.cos(incidence)[:, None]
    view = facet_view(sine, cosine, t_range, t_cross)
    moments, contrast = _moments(view, frequency_hz, permittivity, waves)
    moments = moments * np.sqrt(1.0 + t_range**2 + t_cross**2)
    by_wind = _average(moments, contrast, view, *_weights(t_range, t_cross, tilt))
    mean, cosine2, sine2 = _to_table(incidence, _harmonics(by_wind))
    hh, vv, mixed = zip(mean[:3], cosine2[:3], strict=True)
    low = float(np.cos(incidence[-1]))
    columns = (*hh, *mixed, *vv, sine2[3], sine2[4])
    if polarization == "VV":
        columns = (*vv, *mixed, *hh, -sine2[4], -sine2[3])
    return TiltedBragg(low, np.stack(columns, axis=1))


def _moments(view: FacetView, frequency_hz: float, permittivity: complex, waves: ShortWaves) -> tuple[Array, Array]:
    """(5, incidence, tilt): σ of hh, vv, 2 Re hh vv* + 4|hv|², 4 Re hh hv*, 4 Re vv hv*; and the spreading Δ."""
    k = radar_wavenumber(frequency_hz)
    nodes = np.arange(NODES + 1) / NODES
    k_bragg = 2.0 * k * np.sqrt(np.maximum(1.0 - nodes**2, 1e-12))
    weight = 8.0 * k**4 * nodes**4 * waves.roughness(k_bragg, waves.divide(k)) / k_bragg  # 16π k⁴ cos⁴ S T/(2π k_B)
    g_hh, g_vv = bragg_coefficients(np.arccos(nodes), permittivity)
    products = (np.abs(g_hh) ** 2, np.abs(g_vv) ** 2, (g_hh * g_vv.conj()).real)
    seen = np.clip(view.cos_local, 0.0, 1.0)
    h2, v2, hv = (np.interp(seen, nodes, weight * each) for each in products)
    contrast = np.interp(seen, nodes, waves.contrast(k_bragg))
    a2, ab = view.a2, view.ab
    b2 = 1.0 - a2
    a2b2 = a2 * b2
    moments = np.stack(
        (
            a2 * a2 * h2 + b2 * b2 * v2 + 2.0 * a2b2 * hv,
            b2 * b2 * h2 + a2 * a2 * v2 + 2.0 * a2b2 * hv,
            6.0 * a2b2 * (h2 + v2) + (2.0 - 12.0 * a2b2) * hv,
            4.0 * ab * (b2 * v2 - a2 * h2 + (a2 - b2) * hv),
            4.0 * ab * (a2 * v2 - b2 * h2 + (b2 - a2) * hv),
        )
    )
    return moments, contrast


def _weights(t_range: Array, t_cross: Array, tilt: Array) -> tuple[Array, Array]:
    """The winds' angles φ against the look, and (tilt, wind) the Gaussian weights of the tilts, which sum to 1."""
    wind = np.arange(_WINDS) * (np.pi / _WINDS)
    along = np.outer(t_range, np.cos(wind)) - np.outer(t_cross, np.sin(wind))  # slopes outward and clockwise
    across = np.outer(t_range, np.sin(wind)) + np.outer(t_cross, np.cos(wind))
    weight = np.exp(-0.5 * ((along / tilt[0]) ** 2 + (across / tilt[1]) ** 2))
    return wind, weight / weight.sum(axis=0)


def _average(
    moments: Array,
    contrast: Array,
    view: FacetView,
    wind: Array,
    weight: Array,
) -> Array:
    """(5, incidence, wind): Σ over the tilts of moment · weight · (1 + Δ cos 2(φ − χ)), χ that of the tilt."""
    cosine, minus_sine = view.wind_double(np.ones(()), np.zeros(()))  # of 2χ
    even, odd = moments * (contrast * cosine), moments * (contrast * -minus_sine)
    return moments @ weight + even @ (weight * np.cos(2.0 * wind)) + odd @ (weight * np.sin(2.0 * wind))


def _harmonics(by_wind: Array) -> Array:
    """(3, 5, incidence): amplitudes of 1, cos 2φ, sin 2φ."""
    wave = np.fft.rfft(by_wind, axis=-1) / _WINDS
    return np.stack((wave[..., 0].real, 2.0 * wave[..., 1].real, -2.0 * wave[..., 1].imag))


def _to_table(incidence: Array, values: Array) -> NDArray[np.float32]:
    """(3, 5, node), by equal steps of the cosine and one node more, for values on the last."""
    low = np.cos(incidence[-1])
    cosine = np.minimum(low + (1.0 - low) / NODES * np.arange(NODES + 2), 1.0)
    table = scipy.interpolate.CubicSpline(incidence, values, axis=-1)(np.arccos(cosine))
    table[..., 0] = 0.0  # no tilt faces the ray there
    return table.astype(np.float32)


LEAST_COSINE = 0.05  # beyond, exp(−½ tan² θi/variance) is nothing


class Mirror(NamedTuple):
    """σ = reflection/(2 √(along · across)) · sec⁴θi exp(−½ tan²θi (cos²φ/along + sin²φ/across))."""

    reflection: float  # |R(0)|² of the roughened surface
    along: float  # variances of the slopes along and across the wind
    across: float

    @property
    def peak(self) -> float:
        """σ0 seen squarely."""
        return float(np.float32(0.5 * self.reflection / np.sqrt(self.along * self.across)))

    @property
    def steepness(self) -> float:
        """One over the tilts' slope, rms of the directions."""
        return float(np.float32(1.0 / np.sqrt(0.5 * (self.along + self.across))))

    def nrcs(self, cos_local: Array, wind_cosine: Array) -> Array:
        """σ0 per unit true area of the facet, for cos θi and cos 2φ in float32; 0 from behind."""
        secant2 = 1.0 / np.square(np.maximum(cos_local, LEAST_COSINE))
        mean = float(np.float32(0.25 / self.along + 0.25 / self.across))
        split = float(np.float32(0.25 / self.along - 0.25 / self.across))
        return self.peak * secant2 * secant2 * np.exp((1.0 - secant2) * (mean + split * wind_cosine))

    def facing(self, cos_local: Array) -> Array:
        """Share of the tilts that face the ray, 1 seen squarely and ½ at a facet's own grazing."""
        return ndtr(cos_local * self.steepness / np.sqrt(np.maximum(1.0 - cos_local * cos_local, 1e-6)))


@lru_cache(maxsize=32)
def mirror(frequency_hz: float, permittivity: complex, waves: ShortWaves) -> Mirror:
    """The mirror that the waves between the mesh's limit and the roughness make of a facet.

    That is π |R|² sec⁴θi p, p the Gaussian density of the tilt that turns the facet towards the ray. Roughness of
    variance h² takes exp(−4 k² h²) of the coherent power away (Kudryavtsev et al., J. Geophys. Res. 110, C07016, 2005);
    Bragg scattering has it. To the tilts comes the lobe that a flat square of the mesh's shortest half wave L = π/k_m
    diffracts, a peak of 4π L²/λ² or slope variance λ²/(8π L²) [1.8e-4 of slope² at 3 cm and k_m = 7 rad/m]: it counts
    where the mesh leaves no tilts, and keeps σ finite there.
    """
    k = radar_wavenumber(frequency_hz)
    divide = waves.divide(k)
    lobe = waves.above**2 / (2.0 * np.pi * k**2)
    along, across = (each + lobe for each in waves.tilt_variances(divide))
    smooth = abs(complex(fresnel(0.0, permittivity)[0])) ** 2
    return Mirror(smooth * float(np.exp(-4.0 * k**2 * waves.roughness_variance(divide))), along, across)
