"""What the account of one scene is made from, each worked out once and only if a row asks for it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..radar.array import antenna_array
from ..scattering.modulation import relaxation_rate
from ..scene import Scene
from ..sea import Resolved
from . import light_errors, radar_errors, sea_errors


@dataclass(frozen=True)
class Basis:
    """A scene, its resolved sea, and what follows from both."""

    scene: Scene
    resolved: Resolved

    @cached_property
    def waves(self) -> sea_errors.ResolvedWaves:
        return sea_errors.resolved_waves(self.scene.sea, self.resolved.wavenumber_limit)

    @cached_property
    def facing(self) -> light_errors.Facing:
        return light_errors.facing(self.scene, self.resolved)

    @cached_property
    def middle_m(self) -> float:
        """Slant range [m] at which errors are stated."""
        return light_errors.middle_m(self.scene.radar)

    @cached_property
    def far_column_m(self) -> float:
        """Width of the mesh's columns at the far gate."""
        beam = antenna_array(self.scene.radar).narrowest_beam_deg
        return float(self.scene.radar.range_m[1] * np.radians(beam) / self.scene.detail.columns_per_beam)

    @cached_property
    def boat_tilt(self) -> float:
        """Rms tilt [rad] along the look, of a boat that goes with the waves if its motion does not say otherwise."""
        platform = self.scene.platform
        if platform.motion == "wave_following" or platform == type(platform)():
            return sea_errors.boat_tilt(self.waves, platform.length_m, platform.beam_m)
        return radar_errors.boat_tilt_at_rest(self.scene)

    @cached_property
    def strain_db(self) -> float:
        """Rms hydrodynamic modulation."""
        rate = relaxation_rate(self.scene.radar.frequency_hz, self.scene.scattering.wind_speed_m_s)
        return light_errors.hydrodynamic_db(sea_errors.strain_std(self.waves, rate))
