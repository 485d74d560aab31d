"""What a facet of the mesh returns, term by term: tilted Bragg waves, mirrors and breakers.

The mesh carries the waves up to a wavenumber k_m; those beyond are statistics of the facet. Up to k_d, a quarter of the
radar's wavenumber, they tilt it, beyond they scatter (`short_waves`, `tilted_bragg`); some of all
lengths break, and the mesh's own waves gather them (`breaking`). σ0 is per unit of a facet's TRUE area.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.compute.machine import pool
from seamap_rt.conventions import POLARIZATIONS, db
from seamap_rt.scattering.bragg import Array, facet_view
from seamap_rt.scattering.breaking import (
    Breakers,
    action_modulation,
    breakers,
    breaking_level,
    breaking_share,
    mean_action_modulation,
    nrcs_breaker,
)
from seamap_rt.scattering.permittivity import permittivity_of
from seamap_rt.scattering.short_waves import ShortWaves
from seamap_rt.scattering.tilted_bragg import Mirror, TiltedBragg, mirror, tilted_bragg
from seamap_rt.sea import ResolvedSea
from seamap_rt.settings import ScatteringSettings

_SLOPES = np.linspace(-4.0, 4.0, 41)  # standard deviations
_GAUSS = np.exp(-0.5 * _SLOPES**2) / np.exp(-0.5 * _SLOPES**2).sum()
_WINDS = 2.0 * np.pi * (np.arange(8) + 0.5) / 8.0  # rad, of the look against the wind
_BLOCK = 1 << 15  # facets handled at once, so that the temporaries stay in the processor's cache


class FacetNrcs(NamedTuple):
    """σ0 [linear] per unit true area of each facet, by term; float32. Their sum is the facet's."""

    bragg: NDArray[np.float32]
    specular: NDArray[np.float32]
    breaking: NDArray[np.float32]


def nrcs_composite(
    incidence: ArrayLike,
    slope_range: ArrayLike,
    slope_cross: ArrayLike,
    wind_angle: ArrayLike,
    *,
    frequency_hz: float,
    permittivity: complex,
    polarization: str,
    waves: ShortWaves,
    strain: ArrayLike | None = None,
    strain_variance: float = 0.0,
    breaking: bool = True,
) -> FacetNrcs:
    """σ0 [linear] of facets that carry the short waves given, by term.

    incidence: rad between the ray and the vertical (90° − grazing), at the facet.
    slope_range: ∂z/∂(outward ground range); positive leans towards the radar.
    slope_cross: ∂z/∂(clockwise cross range).
    wind_angle: look azimuth − azimuth where the wind comes from [rad], both clockwise; 0 looks into the wind.
    strain: how the mesh's waves squeeze the water at the facet (`breaking`), None for not at all.

    These broadcast. The rest are scalars: frequency [Hz], ε′ − jε″, "HH" or "VV", the waves on the facets, the variance
    of the strain over the sea, so that the mean of the short waves and of the breaking share stays what it is without
    strain, and whether waves break at all. ValueError for another polarization, a wind that Elfouhaily's spectrum
    refuses or a negative variance.

    With q the breaking share of a facet, σ = (1 − q)(bragg + specular) + q σ_wb (Kudryavtsev et al. 2003). The tilts
    are turned into the facet's own plane and average Bragg amplitudes before the facet's slope mixes them. Facets seen
    from behind fade out over the tilts' slopes; whether a ray reaches them is the tracer's matter.
    """
    sea = CompositeSea.of(frequency_hz, permittivity, polarization, waves, strain_variance, breaking)
    fields = (incidence, slope_range, slope_cross, wind_angle, 0.0 if strain is None else strain)
    inputs = [np.asarray(each) for each in fields]
    _check(*inputs)
    shape = np.broadcast_shapes(*(each.shape for each in inputs))
    flat = [each if each.ndim == 0 else np.broadcast_to(each, shape).reshape(-1) for each in inputs]
    sigma = np.empty((len(FacetNrcs._fields), int(np.prod(shape))), dtype=np.float32)

    def work(start: int) -> None:
        block = slice(start, start + _BLOCK)
        single = (np.asarray(each if each.ndim == 0 else each[block], dtype=np.float32) for each in flat)
        theta, outward, clockwise, wind, squeezed = single
        sigma[0, block], sigma[1, block], sigma[2, block] = sea.nrcs(
            np.sin(theta), np.cos(theta), outward, clockwise, np.cos(wind), np.sin(wind), squeezed
        )

    with pool() as workers:
        list(workers.map(work, range(0, sigma.shape[1], _BLOCK)))
    return FacetNrcs(*(each.reshape(shape) for each in sigma))


class FrontFacets(NamedTuple):
    """What facets that face the radar return at one grazing angle, by slope and wind; all arrays (case,)."""

    weight: NDArray[np.float64]  # their sum is 1
    level: NDArray[np.float64]  # σ0 [linear] per horizontal area
    breaking: NDArray[np.float64]  # of it

    @property
    def modulation_db(self) -> float:
        """Rms of the level about its mean, dB."""
        level = db(self.level)
        return float(np.sqrt(np.sum(self.weight * (level - np.sum(self.weight * level)) ** 2)))

    @property
    def breaking_db(self) -> float:
        """What breakers add to the mean, dB."""
        return -float(db(1.0 - np.sum(self.weight * self.breaking) / np.sum(self.weight * self.level)))


def front_facets(
    settings: ScatteringSettings, frequency_hz: float, grazing: float, resolved: ResolvedSea
) -> FrontFacets:
    """Facets under a grazing angle [rad] by `nrcs_composite`, over Gaussian slopes and all directions of the wind.

    resolved: the sea that the mesh carries; its slopes lean the facets, its strain gathers no waves.
    """
    deviation = np.sqrt(resolved.look_slope_variance)
    along, across, wind = np.meshgrid(deviation * _SLOPES, deviation * _SLOPES, _WINDS, indexing="ij")
    weight = np.broadcast_to((_GAUSS[:, None] * _GAUSS)[..., None], along.shape)
    faces = along > -np.tan(grazing)
    terms = nrcs_composite(
        0.5 * np.pi - grazing,
        along[faces],
        across[faces],
        wind[faces],
        frequency_hz=frequency_hz,
        permittivity=permittivity_of(settings, frequency_hz),
        polarization=settings.polarization,
        waves=ShortWaves.of(settings, resolved.wavenumber_limit),
    )
    area = np.sqrt(1.0 + along**2 + across**2)[faces]
    level = area * (terms.bragg + terms.specular + terms.breaking)
    return FrontFacets(weight[faces] / weight[faces].sum(), level, area * terms.breaking)


def nrcs_level_sea(settings: ScatteringSettings, frequency_hz: float, grazing: ArrayLike) -> NDArray[np.float64]:
    """Theory's mean σ0 [linear] over all directions at grazing angles [rad], any shape: of a level mesh, on which all
    of the wind's waves are statistics, without shadows."""
    terms = nrcs_composite(
        0.5 * np.pi - np.asarray(grazing)[..., None],
        0.0,
        0.0,
        _WINDS,
        frequency_hz=frequency_hz,
        permittivity=permittivity_of(settings, frequency_hz),
        polarization=settings.polarization,
        waves=ShortWaves.of(settings, 0.0),
        breaking=settings.breaking,
    )
    return np.mean(np.sum(terms, axis=0, dtype=np.float64), axis=-1)


def _check(*inputs: NDArray) -> None:
    for name, values in zip(("incidence", "slope_range", "slope_cross", "wind_angle", "strain"), inputs, strict=True):
        if not np.isfinite(values).all():
            raise ValueError(f"{name}: must be finite; leave out what is not known")
    steepest = np.abs(inputs[0]).max(initial=0.0)
    if steepest > np.pi:
        raise ValueError(f"incidence = {steepest:g}: must be at most π; give radians")


class CompositeSea(NamedTuple):
    """What all facets have in common."""

    bragg: TiltedBragg
    mirror: Mirror
    breakers: Breakers
    mean_action_modulation: float
    breaking_level: float

    @classmethod
    def of(
        cls,
        frequency_hz: float,
        permittivity: complex,
        polarization: str,
        waves: ShortWaves,
        strain_variance: float = 0.0,
        breaking: bool = True,
    ) -> CompositeSea:
        """See `nrcs_composite`, whose arguments and errors these are."""
        if polarization not in POLARIZATIONS:
            raise ValueError(f"polarization = {polarization!r}: must be one of {', '.join(POLARIZATIONS)}")
        radar = (float(frequency_hz), complex(permittivity))
        broken = breakers(waves.wind_speed, waves.inverse_wave_age, radar[0])
        return cls(
            bragg=tilted_bragg(*radar, polarization, waves),
            mirror=mirror(*radar, waves),
            breakers=broken,
            mean_action_modulation=mean_action_modulation(float(strain_variance)),
            breaking_level=breaking_level(broken.fraction if breaking else 0.0, float(strain_variance)),
        )

    def nrcs(
        self,
        sine: Array,
        cosine: Array,
        slope_range: Array,
        slope_cross: Array,
        along: Array,
        across: Array,
        strain: Array,
    ) -> tuple[Array, Array, Array]:
        """The terms of some facets, in float32. sine, cosine: of the incidence; along, across: cosine and sine of the
        look against the wind."""
        view = facet_view(sine, cosine, slope_range, slope_cross)
        wind_cosine, wind_sine = view.wind_double(along, across)
        crowded = action_modulation(strain)
        bragg = self.bragg.nrcs(view, wind_cosine, wind_sine) * (crowded * (1.0 / self.mean_action_modulation))
        specular = self.mirror.nrcs(view.cos_local, wind_cosine)
        if self.breaking_level == 0.0:
            return bragg, specular, 0.0 * bragg
        share = breaking_share(crowded, self.breaking_level)
        zone = nrcs_breaker(view.cos_local, view.upwind(along, across), self.breakers.direction)
        left = 1.0 - share
        return bragg * left, specular * left, share * zone * self.mirror.facing(view.cos_local)
