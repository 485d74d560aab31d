"""Each facet's radar cross-section: the chosen model, and for a modelled sea the calibration of its mean."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..conventions import from_db, wrap_degrees
from ..mesh import Facets
from ..scattering import (
    calibration_scale,
    nrcs_gregers_hansen12,
    nrcs_two_scale,
    permittivity_meissner_wentz12,
    sea_state_from_wind,
)
from ..settings import RadarSettings, ScatteringSettings


def facet_rcs(
    facets: Facets, scattering: ScatteringSettings, radar: RadarSettings, resolved_below: float
) -> NDArray[np.float32]:
    """Radar cross-section (column, facet) [m²]; 0 for facets that neither antenna lights.

    `constant`: σ0 × horizontal area, shadowing on top. `nrl`: the measured mean, which contains shadowing, so that what
    is lit is raised to make up for what is dark. `two_scale`: tilted Bragg per facet, scaled in the same way to `nrl`;
    its waves begin at the wavenumber `resolved_below` [rad/m], where those of the mesh end.
    """
    if facets.lit is None:
        raise ValueError("these facets have not been traced; call a tracer first")
    lit = facets.lit[0] | facets.lit[1]
    area = facets.horizontal_area
    if scattering.nrcs == "constant":
        return np.where(lit, np.float32(from_db(scattering.nrcs_db)) * area.astype(np.float32), np.float32(0.0))
    wind = np.radians(wrap_degrees(facets.grid.column_azimuth - scattering.wind_from_deg))[:, None]
    grazing = np.arctan2(radar.height_m, facets.distance)  # to mean sea level: the scale must not follow the waves
    target = nrcs_gregers_hansen12(
        np.degrees(grazing),
        sea_state_from_wind(scattering.wind_speed_m_s),
        radar.frequency_hz,
        scattering.polarization,
        clipped=True,
    )
    if scattering.nrcs == "nrl":
        raw = np.where(lit, (target * area).astype(np.float32), np.float32(0.0))
    else:
        water = permittivity_meissner_wentz12(radar.frequency_hz, scattering.temperature_c, scattering.salinity_psu)
        height = radar.height_m - facets.height
        incidence = (0.5 * np.pi - np.arctan(height / facets.distance)).astype(np.float32)
        sigma = nrcs_two_scale(
            incidence,
            facets.slope_look,
            facets.slope_cross,
            wind,
            frequency_hz=radar.frequency_hz,
            wind_speed=scattering.wind_speed_m_s,
            permittivity=complex(water),
            polarization=scattering.polarization,
            resolved_below=resolved_below,
        )
        # A local σ0 multiplies the facet's true area.
        true_area = np.sqrt(1.0 + facets.slope_look**2 + facets.slope_cross**2) * area.astype(np.float32)
        raw = np.where(lit, sigma * true_area, np.float32(0.0))
    scale = calibration_scale(raw, area, target, grazing, wind)
    return (raw * scale).astype(np.float32, copy=False)
