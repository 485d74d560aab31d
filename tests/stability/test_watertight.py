"""No ray gets below the sea: a million rays towards its facets, edges and vertices, and what becomes of them."""

from __future__ import annotations

import numpy as np
import pytest
from hard_surfaces import scene
from numpy.typing import NDArray

from seamap_rt import sea
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.mesh.facets import FAR_FRACTION, NEAR_FRACTION, chord_point
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.tracing.rays import SeaScene
from validation.hard_cases.light import KINDS, Targets, leaks

RAYS = 100_000  # for each antenna and kind of target
LATE = 0.5  # m beyond its target at which a ray has gone through: a facet


@pytest.fixture(scope="module")
def choppy() -> tuple[SurfaceMesh, SeaScene]:
    """A piece of choppy_sea out to 400 m, one of whose lines runs due east: there north is exactly 0."""
    made = scene("choppy_sea", radar__sector_deg=[81.0, 99.0], tracing__facet_m=0.5, tracing__columns_per_beam=4)
    mesh = mesh_turn(sea.realize(made.sea, 3), made.radar, made.meshing, 0)
    (sheet,) = mesh.sheets()
    return mesh, SeaScene(
        mesh.trimesh(sheet), mesh.grid.antenna_positions[sheet[0].start], made.radar.frequency_hz, 55.0 - 37.5j
    )


def place_of(mesh: SurfaceMesh, antenna: int) -> NDArray[np.float64]:
    along, across, up = mesh.grid.antenna_positions[0, antenna]
    assert along == across == 0.0
    return np.array([0.0, 0.0, float(np.float32(up))])


@pytest.mark.parametrize("antenna", [0, 1])
def test_rays_at_random_do_not_leak(choppy: tuple[SurfaceMesh, SeaScene], antenna: int) -> None:
    """Nor would many, were their tests for hits not watertight: what passes an edge within float32's rounding, 1e-5."""
    mesh, traced = choppy
    targets = Targets(mesh, place_of(mesh, antenna))
    points = targets.points("facet", 3 * RAYS, np.random.default_rng(antenna))
    assert leaks(traced.mi_scene, targets.position, points, LATE) == 0


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "vertex"])
@pytest.mark.parametrize("antenna", [0, 1])
def test_the_sheet_itself_is_closed(choppy: tuple[SurfaceMesh, SeaScene], kind: str, antenna: int) -> None:
    """Neighbouring facets share their corners to the bit, and hits are tested robustly: no ray passes between.

    Without that a tenth of the rays at rungs and radial edges slip through.
    """
    mesh, traced = choppy
    targets = Targets(mesh, place_of(mesh, antenna))
    points = targets.points(kind, RAYS, np.random.default_rng(antenna + 2))
    assert leaks(traced.mi_scene, targets.position, points, LATE) == 0


@pytest.mark.parametrize("antenna", [0, 1])
def test_rays_in_the_plane_of_a_radial_edge_do_not_leak(choppy: tuple[SurfaceMesh, SeaScene], antenna: int) -> None:
    """Every edge of that line, all the way from the mast, lies in the ray's own plane, exactly: north is 0."""
    mesh, traced = choppy
    targets = Targets(mesh, place_of(mesh, antenna))
    (line,) = np.flatnonzero(np.abs(mesh.grid.azimuth - 90.0) < 1e-9)
    points = targets.points("radial", RAYS, np.random.default_rng(antenna + 4), int(line))
    points[:, 1] = 0.0
    assert leaks(traced.mi_scene, targets.position, points, LATE) == 0


def test_a_vertex_lets_through_what_rounding_makes_of_it(choppy: tuple[SurfaceMesh, SeaScene]) -> None:
    """Six edges meet in it, and the side of each on which a ray passes is rounded for itself: all six may say outside.

    Of random signs two in 64 are such; nearly all rays at a vertex are clear of one of its edges at least.
    """
    mesh, traced = choppy
    targets = Targets(mesh, place_of(mesh, 0))
    points = targets.points("vertex", RAYS, np.random.default_rng(6))
    assert leaks(traced.mi_scene, targets.position, points, LATE) < RAYS * 2.0 / 64.0


def test_no_facets_point_lies_on_a_radial_edge_or_a_vertex(choppy: tuple[SurfaceMesh, SeaScene]) -> None:
    """What is asked of the rays in the end: their planes cut a column at a third of its width, across every edge."""
    mesh, _ = choppy
    grid = mesh.grid
    beside = np.radians(0.5 * grid.spacing_deg) - np.abs(mesh.facets.angle)
    assert beside.min() > 0.3 * np.radians(grid.spacing_deg)
    for fraction in (NEAR_FRACTION, FAR_FRACTION):
        assert 0.3 < chord_point(fraction, grid.spacing_deg)[1] / np.radians(grid.spacing_deg) < 0.7
