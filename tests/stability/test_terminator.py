"""Where light ends and where it begins again, under 1° to 0.1° of grazing: a sinusoid's own edges, to the facet."""

from __future__ import annotations

import numpy as np
import pytest
from hard_surfaces import TRACERS, light, rings, scene
from numpy.testing import assert_array_equal
from numpy.typing import NDArray

from seamap_rt.scene import Scene
from validation.analytic.shadowing import sinusoid_visible_intervals

GRAZING_DEG = (1.0, 0.5, 0.2, 0.1)
MAST, BASELINE = 5.0, 0.2  # m
FACET = 0.5  # m


def seen_from(grazing_deg: float) -> tuple[Scene, float, float]:
    """A narrow look at the sea, and the window of ground ranges under that grazing angle, three waves long."""
    middle = MAST / np.tan(np.radians(grazing_deg))
    near, far = middle - 60.0, middle + 60.0
    made = scene(
        radar__height_m=MAST,
        radar__baseline_m=BASELINE,
        radar__sector_deg=[90.0, 91.8],
        radar__range_m=[near, far],
        scattering__extrapolate=True,
        tracing__facet_m=FACET,
        tracing__columns_per_beam=3,
    )
    return made, near, far


def edges_of(antenna: int, height: float, length: float, near: float, far: float, phase: float) -> NDArray[np.float64]:
    """Intervals (n, 2) that the antenna sees, a wave beyond the window too: an edge just outside counts as well."""
    mast = MAST + (antenna - 0.5) * BASELINE
    return sinusoid_visible_intervals(height, length, mast, near - length, far + length, phase)[0]


@pytest.mark.parametrize("grazing", GRAZING_DEG)
@pytest.mark.parametrize(("height", "length"), [(40.0 / 30.0, 40.0), (0.2, 20.0)], ids=["steep", "low"])
@pytest.mark.parametrize("phase", [0.0, 2.0])
def test_every_edge_lies_where_the_sinusoid_has_it(grazing: float, height: float, length: float, phase: float) -> None:
    """A facet is lit or dark as a whole, and the mesh is a chain of chords: an edge errs by one facet, 0.5 m.

    Half of that is the facet's own length. The rest: a chord's crest is lower than the wave's by ak²d²/8 (0.5 mm), and
    at 0.1° a ray that lands on the next crest's shoulder does so under 0.05: 1 cm.
    """
    made, near, far = seen_from(grazing)
    k = 2.0 * np.pi / length
    mesh = rings(lambda r: 0.5 * height * np.cos(k * r + phase), made)
    distance = mesh.facets.distance
    for name in TRACERS:
        lit = light(name, mesh, made)
        for antenna in (0, 1):
            intervals = edges_of(antenna, height, length, near, far, phase)
            inside = np.any((distance > intervals[:, :1]) & (distance < intervals[:, 1:]), axis=0)
            away = np.abs(distance - intervals.reshape(-1, 1)).min(axis=0)
            sure = (distance > near) & (distance < far) & (away > FACET)
            assert 0.0 < inside[sure].mean() < 0.6  # the slopes of both waves are above 1.7°: something hides
            assert_array_equal(lit[antenna][:, sure], np.broadcast_to(inside[sure], lit[antenna][:, sure].shape))


@pytest.mark.parametrize("grazing", GRAZING_DEG)
def test_rays_see_what_the_horizon_sees_under_grazing(grazing: float) -> None:
    """float32 rays against the float64 horizon on every facet out to 3 km.

    In the antenna's frame 3 km is good to 0.1 mm and 5 m of height to 0.2 µm: over 0.1 of slope an edge moves by a
    hundredth of a millimetre, and one facet in some 10⁵ lies so near to it.
    """
    made, near, far = seen_from(grazing)
    mesh = rings(lambda r: 0.5 * np.cos(2.0 * np.pi * r / 31.0 + 0.2), made)
    rays, horizon = (light(name, mesh, made) for name in TRACERS)
    window = (mesh.facets.distance > near) & (mesh.facets.distance < far)
    assert 0.0 < horizon[..., window].mean() < 0.5
    assert np.mean(rays != horizon) < 1e-5
