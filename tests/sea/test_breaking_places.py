"""The kinematic criterion, by which the study of breakers' places judges, on a wave whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from small_seas import sea_of, sinusoid

from seamap_rt.mesh.grid import polar_grid
from seamap_rt.mesh.surface import surface_mesh
from seamap_rt.radar.installation import Installation
from seamap_rt.scene import load_scene
from seamap_rt.sea import realize
from validation.scattering.breaking_places import speed_ratio


@pytest.mark.parametrize("toward", [90.0, 60.0])
def test_on_one_wave_the_water_runs_at_ka_of_the_crest(toward: float) -> None:
    """u = aω cos θ and c = ω/k, so B = ka cos θ: 0.2 at crests, nothing in troughs. Seen along another line the water's
    part of its speed is a cosine smaller, and the crest, cut aslant, a cosine faster. 1e-3 is the sea's splines."""
    length, height = 32.0, 2.04
    sea = realize(sea_of(sinusoid(height_m=height, wavelength_m=length, wave_from_deg=270.0), extent_m=256.0), 1)
    scene = load_scene("choppy_sea", {"radar.range_m": [15.0, 60.0], "radar.sector_deg": [200.0, 340.0]})
    grid = polar_grid(Installation(scene.radar), scene.meshing, 0)
    still = np.zeros((grid.sweep.size, grid.ground_range.size))
    facets = surface_mesh(grid, still, np.zeros((*still.shape, 3), dtype=np.float32)).facets
    found = speed_ratio(sea, facets, toward)
    azimuth = np.radians(grid.column_azimuth[:, None] + np.degrees(facets.angle))
    x, y = facets.distance * np.sin(azimuth), facets.distance * np.cos(azimuth)
    wave = sea.elevation(x, y, np.broadcast_to(grid.column_pose.time[:, None], x.shape))
    wanted = 2.0 * np.pi / length * np.maximum(wave, 0.0) * np.cos(np.radians(toward - 90.0)) ** 2
    assert_allclose(found, wanted, atol=1e-3)
