"""A scene, its resolved sea, and what several rows of the account need of both."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...physics.shadowing import shadow_kept
from ...radar import link
from ...radar.platform import tilt_std
from ...scattering import ShortWaves, clutter_shape_watts_wicks90, mean_level
from ...scattering.bragg import radar_wavenumber
from ...scattering.composite import FacingFacets, facing_facets
from ...scattering.modulation import modulation_db, relaxation_rate
from ...scene import Scene
from ...sea import Resolved, ResolvedWaves
from ...settings import PlatformSettings


@dataclass(frozen=True)
class Case:
    """A scene, its resolved sea, and what several rows need of both. Errors are stated in the window's middle."""

    scene: Scene
    resolved: Resolved

    def level(self, range_m: float) -> float:
        """Mean σ0, a ratio."""
        grazing_deg = np.degrees(link.grazing_angle(self.scene.radar, range_m))
        return float(mean_level(self.scene.scattering, grazing_deg, self.scene.radar.frequency_hz))

    def signal_to_noise(self, range_m: float) -> float:
        return link.signal_to_noise(self.scene.radar, self.level(range_m), range_m)

    @cached_property
    def middle_m(self) -> float:
        return link.middle_m(self.scene.radar)

    @property
    def at(self) -> str:
        return f"at {self.middle_m:.0f} m"

    @cached_property
    def grazing(self) -> float:
        """rad, there."""
        return float(link.grazing_angle(self.scene.radar, self.middle_m))

    @cached_property
    def cell_m2(self) -> float:
        """Area of a cell there."""
        return float(link.cell_area(self.scene.radar, self.middle_m))

    @property
    def clutter_shape(self) -> float:
        """Shape that measured seas' echoes have there; NaN beyond the law."""
        return clutter_shape_watts_wicks90(math.degrees(self.grazing), self.cell_m2, self.scene.scattering.polarization)

    @cached_property
    def waves(self) -> ResolvedWaves:
        return ResolvedWaves.of(self.scene.sea, self.resolved.wavenumber_limit)

    @cached_property
    def facing(self) -> FacingFacets:
        return facing_facets(self.scene.scattering, self.scene.radar.frequency_hz, self.grazing, self.resolved)

    @cached_property
    def strain_db(self) -> float:
        """Rms hydrodynamic modulation."""
        rate = relaxation_rate(self.scene.radar.frequency_hz, self.scene.scattering.wind_speed_m_s)
        return modulation_db(self.waves.strain_std(rate))

    @cached_property
    def tilting(self) -> tuple[float, float]:
        """Rms height [m] and slope along the look of the waves that tilt the facets, over all looks."""
        short = ShortWaves.of(self.scene.scattering, self.resolved.wavenumber_limit)
        divide = short.divide(radar_wavenumber(self.scene.radar.frequency_hz))
        return short.tilt_height(divide), math.sqrt(0.5 * sum(short.tilt_variances(divide)))

    @cached_property
    def kept_by_shadows(self) -> float:
        """Share of its two-way power that water keeps which these waves hide from light."""
        return shadow_kept(*self.tilting, self.scene.wavelength_m, self.scene.scattering.polarization)

    @cached_property
    def hidden_by_tilts(self) -> float:
        """% of the window that these waves hide from light on top of the resolved ones."""
        radar, slopes = self.scene.radar, self.resolved.look_slope_variance
        both = link.shadowed_share(radar, slopes + self.tilting[1] ** 2)
        return 100.0 * (both - link.shadowed_share(radar, slopes))

    @cached_property
    def boat_tilt(self) -> float:
        """Rms tilt [rad] along the look; of a boat that has no motion, that which the waves would give it."""
        boat = self.scene.platform
        moving = boat.model_copy(update={"motion": "wave_following"}) if boat == PlatformSettings() else boat
        return tilt_std(moving, self.scene.turns * self.scene.turn_duration_s, self.waves)
