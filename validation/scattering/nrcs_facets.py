"""The facets' own mean echo, summed over a simulated sea: what theory gives, by term, and the calibrated result.

A sea for each sea state (Elfouhaily's, of its wind, from its peak to the ripples) is meshed from a 10 m mast, in groups
of columns all around it, and lit by the horizon method: out to 6.3 km, where it is seen under 0.09°, and once more, in
more columns, out to 420 m. Each grazing angle is a band of ranges, ±20 % about its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import POLARIZATIONS, SPEED_OF_LIGHT
from seamap_rt.echoes.radar_cross_section import SeaSurface, two_way_power
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.mesh.grid import circle_grid
from seamap_rt.mesh.surface import sea_on_grid, surface_mesh
from seamap_rt.scattering import nrcs_bragg, sea_state_from_wind, wind_from_sea_state
from seamap_rt.scattering.calibration import fit_scale
from seamap_rt.sea import Sea, realize
from seamap_rt.settings import ElfouhailyWaves, RadarSettings, ScatteringSettings, SeaSettings, TracingSettings
from seamap_rt.tracing import Illumination, tracer

FREQUENCY_HZ = 9.3e9
FAR = RadarSettings(frequency_hz=FREQUENCY_HZ, height_m=10.0, range_m=(280.0, 6300.0))
NEAR = RadarSettings(frequency_hz=FREQUENCY_HZ, height_m=10.0, range_m=(45.0, 420.0))
BANDS_DEG = ((FAR, (0.1, 0.2, 0.3, 0.6, 1.0)), (NEAR, (1.7, 3.0, 5.0, 10.0)))
GRAZING_DEG = np.array([angle for _, bands in BANDS_DEG for angle in bands])
SEEDS = (1, 2, 3, 4, 5, 6)
EXTENT_M, RESOLUTION_M = 1024.0, 0.8


@dataclass(frozen=True)
class Levels:
    """Mean σ0 [linear, per horizontal area] in the bands of GRAZING_DEG, over all directions and seeds."""

    flat: NDArray[np.float64]  # first-order Bragg of the wind's ripples on a plane
    terms: dict[str, NDArray[np.float64]]  # of the facets, shadows included: bragg, specular, breaking
    calibrated: NDArray[np.float64]
    target: NDArray[np.float64]  # what it is calibrated to

    @property
    def raw(self) -> NDArray[np.float64]:
        """All terms of the theory."""
        return np.sum(list(self.terms.values()), axis=0)


def levels(sea_state: float, polarization: str, diffraction: str = "none") -> Levels:
    """Levels of one sea state. Seas share nothing between seeds, and each is calibrated to NRL 2012 as a run's is."""
    return _all_levels(sea_state)[polarization, diffraction]


@cache
def _all_levels(sea_state: float) -> dict[tuple[str, str], Levels]:
    """By polarization and diffraction: the seas are made once for all."""
    cases = {(p, d): _scattering(sea_state, p) for p in POLARIZATIONS for d in ("none", "knife_edge")}
    sums: dict[tuple[str, str], list[NDArray[np.float64]]] = {case: [] for case in cases}
    for seed in SEEDS:
        sea = _sea(sea_state, seed)
        bands: dict[tuple[str, str], list[NDArray[np.float64]]] = {case: [] for case in cases}
        for radar, bands_deg in BANDS_DEG:
            limit = sea.resolved.wavenumber_limit
            mesh, columns = _mesh(sea, radar, SeaSurface(_scattering(sea_state, "VV"), radar, limit).memory_rate)
            for diffraction in ("none", "knife_edge"):
                facets = tracer("horizon", radar, ScatteringSettings(), diffraction=diffraction)(mesh)
                for polarization in POLARIZATIONS:
                    case = polarization, diffraction
                    surface = SeaSurface(cases[case], radar, limit)
                    bands[case].append(_in_bands(facets, mesh.strain, columns, surface, bands_deg))
        for case, pieces in bands.items():
            sums[case].append(np.concatenate(pieces, axis=1))
    return {case: _levels(cases[case], np.sum(each, axis=0)) for case, each in sums.items()}


def _levels(scattering: ScatteringSettings, sums: NDArray[np.float64]) -> Levels:
    bragg, specular, breaking, calibrated, target = sums[1:] / sums[0]
    terms = {"bragg": bragg, "specular": specular, "breaking": breaking}
    return Levels(_flat(scattering), terms, calibrated, target)


def _scattering(sea_state: float, polarization: str) -> ScatteringSettings:
    return _of_wind(float(wind_from_sea_state(sea_state)), polarization)


def _of_wind(wind_speed: float, polarization: str, **keys: str) -> ScatteringSettings:
    return ScatteringSettings.model_validate({"polarization": polarization, "wind_speed_m_s": wind_speed, **keys})


def _in_bands(
    facets: Illumination,
    strain: NDArray[np.float32] | None,
    columns: NDArray[np.bool_],
    surface: SeaSurface,
    bands_deg: tuple[float, ...],
) -> NDArray[np.float64]:
    """Sums over the facets of a band, (6, band): area, power by term, calibrated, wanted."""
    calibrated = surface.calibrated(facets, strain, columns)
    arriving = two_way_power(facets)
    area = np.broadcast_to(facets.horizontal_area, facets.height.shape)
    terms = [term * arriving for term in calibrated.terms(facets, strain)]
    echo, wanted = calibrated(facets, strain).rcs * arriving, np.broadcast_to(surface.mean(facets), area.shape) * area
    chosen = [(columns, power) for power in (area, *terms, echo, wanted)]
    return _summed(chosen, facets, surface.radar, bands_deg)


def _summed(
    chosen: list[tuple[NDArray[np.bool_], NDArray[Any]]],
    facets: Illumination,
    radar: RadarSettings,
    bands_deg: tuple[float, ...],
) -> NDArray[np.float64]:
    """Sums (chosen, band) of a field's columns over the facets of each band."""
    grazing = np.degrees(np.arctan(radar.height_m / facets.distance))
    bands = [np.abs(np.log(grazing / angle)) < np.log(1.2) for angle in bands_deg]
    return np.array([[power[rows][:, band].sum(dtype=np.float64) for band in bands] for rows, power in chosen])


# ---------------------------------------------------------------------------------------------------- by direction


class Looks(NamedTuple):
    """Mean σ0 (seed; up, cross, down; band of GRAZING_DEG) in 60° about each look against the wind."""

    theory: NDArray[np.float64]  # calibrated to nothing
    model: NDArray[np.float64]  # GIT by itself
    by_grazing: NDArray[np.float64]  # calibrated to NRL 2012, as a run is
    by_both: NDArray[np.float64]  # the same with a scale by grazing angle and direction
    to_git: NDArray[np.float64]  # calibrated to GIT, as a run is


def looks_by_wind(wind_speed: float, polarization: str, seeds: tuple[int, ...]) -> Looks:
    """The echo by direction of seas of a wind [m/s], with geometric shadows."""
    nrl, git, none = (_of_wind(wind_speed, polarization, calibrated_to=name) for name in ("nrl", "git", "none"))
    made = []
    for seed in seeds:
        sea, bands = _sea(float(sea_state_from_wind(wind_speed)), seed), []
        limit = sea.resolved.wavenumber_limit
        for radar, bands_deg in BANDS_DEG:
            surfaces = [SeaSurface(each, radar, limit) for each in (none, git, nrl)]
            mesh, columns = _mesh(sea, radar, surfaces[0].memory_rate)
            facets = tracer("horizon", radar, ScatteringSettings(), diffraction="none")(mesh)
            theory, to_git, by_grazing = (each.calibrated(facets, mesh.strain, columns) for each in surfaces)
            arriving, wind = two_way_power(facets), theory.wind(facets)
            raw, area = theory(facets, mesh.strain).rcs * arriving, facets.horizontal_area
            target = np.broadcast_to(by_grazing.mean(facets), raw.shape)
            fit = fit_scale(raw[columns], area, target[columns], theory.grazing(facets), wind[columns], degree=5)
            fields = [raw, np.broadcast_to(to_git.mean(facets) * area, raw.shape)]
            fields += [by_grazing(facets, mesh.strain).rcs * arriving, raw * fit(theory.grazing(facets), wind)]
            fields += [to_git(facets, mesh.strain).rcs * arriving]
            angle = np.abs(np.degrees(wind[:, 0]))
            sectors = [columns & (np.abs(angle - middle) <= 30.0) for middle in (0.0, 90.0, 180.0)]
            chosen = [(sector, field) for field in (np.broadcast_to(area, raw.shape), *fields) for sector in sectors]
            bands.append(_summed(chosen, facets, radar, bands_deg))
        sums = np.concatenate(bands, axis=1).reshape(len(Looks._fields) + 1, 3, -1)
        made.append(sums[1:] / sums[0])
    return Looks(*np.moveaxis(np.array(made), 1, 0))


def _mesh(sea: Sea, radar: RadarSettings, rate: float | None) -> tuple[SurfaceMesh, NDArray[np.bool_]]:
    """The meshed sea around the mast, and those of its columns that count."""
    grid, columns = circle_grid(radar, TracingSettings())
    return surface_mesh(grid, *sea_on_grid(sea, grid, rate)), columns


def _sea(sea_state: float, seed: int) -> Sea:
    wind = float(wind_from_sea_state(sea_state))
    waves = ElfouhailyWaves(spectrum="elfouhaily", wind_speed_m_s=wind, spreading="elfouhaily")
    return realize(SeaSettings(extent_m=EXTENT_M, resolution_m=RESOLUTION_M, waves=(waves,)), seed)


def _flat(scattering: ScatteringSettings) -> NDArray[np.float64]:
    surface = SeaSurface(scattering, NEAR, 0.0)
    incidence = np.radians(90.0 - GRAZING_DEG)
    k = 4.0 * np.pi * FREQUENCY_HZ / SPEED_OF_LIGHT * np.sin(incidence)
    isotropic = surface.short_waves.spectrum(k) / (2.0 * np.pi * k)  # the mean over directions
    return nrcs_bragg(incidence, FREQUENCY_HZ, surface.permittivity, isotropic, scattering.polarization)
