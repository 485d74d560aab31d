"""The field over shadow edges against hand-computed knife edges, its limits, and a direct search over all edges."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt import sea
from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.mesh.facets import chord_point
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.scene import Scene, load_scene
from seamap_rt.tracing import Illumination, tracer
from seamap_rt.tracing.diffraction import diffract
from seamap_rt.tracing.horizon import trace_horizon
from validation.analytic.diffraction import knife_edge
from validation.analytic.shadowing import sinusoid_visible_intervals
from validation.hard_cases.case import RadialSurface
from validation.light.profile import profile

WAVELENGTH = 0.03
TABLE = 3e-5  # F from the table (2e-5) and as complex64
Height = Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True)
class Seen:
    """Traced facets whose field and slopes are there."""

    facets: Illumination
    mesh: SurfaceMesh
    lit: NDArray[np.bool_]
    field: NDArray[np.complex64]
    ray_slope: NDArray[np.float32]


def scene(name: str = "flat", **keys: Any) -> Scene:
    return load_scene(name, overrides={key.replace("__", "."): value for key, value in keys.items()})


def narrow(**keys: Any) -> Scene:
    """Two degrees of a flat sea out to 100 m."""
    return scene("flat", **{"radar__sector_deg": [90.0, 92.0], "radar__range_m": [15.0, 100.0], **keys})


def over_edges(mesh: SurfaceMesh, wavelength: float = WAVELENGTH) -> Seen:
    facets = diffract(trace_horizon(mesh), mesh, wavelength)
    assert facets.field is not None
    assert facets.ray_slope is not None
    return Seen(facets, mesh, facets.lit, facets.field, facets.ray_slope)


def rings(height: Height, made: Scene, wavelength: float = WAVELENGTH) -> Seen:
    return over_edges(mesh_turn(RadialSurface(height), made.radar, made.tracing, 0), wavelength)


def walls(*places: tuple[float, float]) -> Height:
    """Ridges one rung wide at (range, height), in an otherwise flat sea."""
    return lambda r: np.sum([np.where(np.abs(r - place) < 0.25, height, 0.0) for place, height in places], axis=0)


def fresnel_height(antenna: tuple[float, float], edge: tuple[Any, Any], x: Any, z: Any, wavelength: float) -> Any:
    """v of an edge from the detour over it: πv²/2 = k δ, positive where the edge stands above the straight ray."""
    (x0, z0), (xe, ze) = antenna, edge
    detour = np.hypot(xe - x0, ze - z0) + np.hypot(x - xe, z - ze) - np.hypot(x - x0, z - z0)
    above = (ze - z0) * (x - x0) - (z - z0) * (xe - x0)
    return np.sign(above) * 2.0 * np.sqrt(np.maximum(detour, 0.0) / wavelength)


def factor(antenna: tuple[float, float], edge: tuple[float, float], x: Any, z: Any, wavelength: float) -> Any:
    """F of one edge."""
    return knife_edge(fresnel_height(antenna, edge, x, z, wavelength))


def middles(seen: Seen) -> NDArray[np.float64]:
    """Where the field of each facet is that of: halfway between its rungs, on the middle of its column."""
    rungs = seen.mesh.grid.ground_range * chord_point(0.5, seen.mesh.grid.spacing_deg)[0]
    return np.repeat(0.5 * (rungs[1:] + rungs[:-1]), 2)


def antennas(seen: Seen) -> list[tuple[float, float]]:
    mast = float(seen.mesh.grid.column_height[0, 0])
    return [(float(along), mast + float(above)) for along, _, above in seen.mesh.grid.antenna_positions[0]]


# ------------------------------------------------------------------------------------------------ without edges


@pytest.mark.parametrize("slope", [0.0, 0.03, -0.02])
def test_a_plane_has_no_edges(slope: float) -> None:
    """Level, or a cone that rises or falls slower than the rays do: each facet has the field of free space, exactly."""
    made = narrow(radar__tilt_deg=5.0)
    seen = rings(lambda r: slope * r, made)
    assert seen.lit.all()
    assert_array_equal(seen.field, 1.0)
    straight = -seen.facets.rise / seen.facets.distance
    assert_allclose(seen.ray_slope, straight, rtol=2e-7)  # float32


def test_a_dome_is_dark_beyond_its_horizon() -> None:
    """Convex: rays over the horizon's edge pass inside the water, and no facet faces them."""
    seen = rings(lambda r: -(r**2) / 200.0, narrow())
    assert 0.2 < seen.lit.mean() < 0.5
    assert_array_equal(seen.field[seen.lit], 1.0)
    assert_array_equal(seen.field[~seen.lit], 0.0)


def test_what_lies_behind_a_tilted_antenna_has_no_field() -> None:
    made = narrow(radar__tilt_deg=60.0, radar__baseline_m=4.0)
    seen = rings(lambda r: 0.0 * r, made)
    behind = middles(seen) < seen.mesh.grid.antenna_positions[0, 1, 0]
    assert behind.any()
    assert_array_equal(seen.field[1][:, behind], 0.0)
    assert_array_equal(seen.field[1][:, ~behind], 1.0)
    assert np.isfinite(seen.ray_slope).all()


# ----------------------------------------------------------------------------------------------- one edge and two


def on_the_chord(seen: Seen, ring: float) -> float:
    """Where the middle of a column's chord lies: some 0.1 mm within the ring at 20 m."""
    return ring * chord_point(0.5, seen.mesh.grid.spacing_deg)[0]


@pytest.mark.parametrize("tilt", [0.0, 20.0])
def test_one_ridge(tilt: float) -> None:
    """2 m high at 20 m. In front all is 1; its back is dark; behind, every facet has the hand-computed F."""
    seen = rings(walls((20.0, 2.0)), narrow(radar__tilt_deg=tilt, radar__baseline_m=1.0))
    distance = middles(seen)
    edge, behind = on_the_chord(seen, 20.0), distance > 20.5
    for number, antenna in enumerate(antennas(seen)):
        field, lit = seen.field[number], seen.lit[number]
        assert_array_equal(field[:, distance < 20.0], 1.0)
        assert_array_equal(field[:, (distance > 20.0) & (distance < 20.5)], 0.0)
        assert 0.1 < np.mean(~lit[:, behind]) < 0.5
        exact = factor(antenna, (edge, 2.0), distance[behind], 0.0, WAVELENGTH)
        assert_allclose(field[:, behind], np.broadcast_to(exact, field[:, behind].shape), rtol=0.0, atol=TABLE)
        # Far behind it the height over the ray says the same by the textbook: (h/d)² of it, and phase the most.
        far = distance > 30.0
        d1, d2 = np.hypot(edge - antenna[0], 2.0 - antenna[1]), np.hypot(distance[far] - edge, 2.0)
        ray = antenna[1] * (distance[far] - edge) / (distance[far] - antenna[0])
        height = (2.0 - ray) * np.cos(np.arctan2(antenna[1], distance[far] - antenna[0]))
        textbook = knife_edge(height * np.sqrt(2.0 * (d1 + d2) / (WAVELENGTH * d1 * d2)))
        assert_allclose(field[0, far], textbook, rtol=0.0, atol=0.02)


def test_the_last_leg_comes_from_the_edge() -> None:
    seen = rings(walls((20.0, 2.0)), narrow())
    distance, behind = middles(seen), middles(seen) > 20.5
    straight = float(seen.mesh.grid.column_height[0, 0]) / seen.facets.distance
    steep = 2.0 / (distance - on_the_chord(seen, 20.0))  # to where the field of both facets of a step is that of
    dark = np.abs(seen.field[:, :, behind]) < 0.5
    both, none = np.all(dark, axis=0), ~np.any(dark, axis=0)
    slope = seen.ray_slope[:, behind]
    assert both.any()
    assert none.any()
    assert_allclose(slope[both], np.broadcast_to(steep[behind], slope.shape)[both], rtol=1e-6)
    assert_allclose(slope[none], np.broadcast_to(straight[behind], slope.shape)[none], rtol=1e-6)
    # Where one antenna sees the facet and the other does not, ray and edge are nearly in line.
    mixed = ~both & ~none
    assert mixed.any()
    assert_allclose(slope[mixed], np.broadcast_to(straight[behind], slope.shape)[mixed], rtol=0.03)


def test_two_ridges() -> None:
    """1 m at 20 m, which the ray to the second clears, and 2 m at 40 m: the two factors multiply."""
    seen = rings(walls((20.0, 1.0), (40.0, 2.0)), narrow())
    distance = middles(seen)
    first, second = (on_the_chord(seen, 20.0), 1.0), (on_the_chord(seen, 40.0), 2.0)
    deep = (distance > 41.0) & (distance < 60.0)
    clear = distance > 70.0  # lit again; the ray passes the second edge nearest
    for number, antenna in enumerate(antennas(seen)):
        assert not seen.lit[number][:, deep].any()
        assert seen.lit[number][:, clear].all()
        before = factor(antenna, first, *second, WAVELENGTH)
        assert abs(before - 1.0) > 0.02
        exact = before * factor(antenna, second, distance[deep], 0.0, WAVELENGTH)
        assert_allclose(seen.field[number][0, deep], exact, rtol=0.0, atol=TABLE)
        over = antenna[1] - antenna[1] * second[0] / distance[clear]
        exact = factor(antenna, first, second[0], over, WAVELENGTH)
        exact *= factor(antenna, second, distance[clear], 0.0, WAVELENGTH)
        assert_allclose(seen.field[number][0, clear], exact, rtol=0.0, atol=TABLE)


def test_two_antennas_see_the_edge_and_not_the_facet() -> None:
    """Deep in the shadow the phase between them is that of the paths to the edge, whatever facet echoes."""
    made = narrow(radar__baseline_m=0.2)
    seen = rings(walls((20.0, 2.0)), made)
    edge, k = on_the_chord(seen, 20.0), 2.0 * np.pi / WAVELENGTH
    distance = middles(seen)
    deep = (distance > 20.6) & (distance < 24.0)
    lower, upper = antennas(seen)
    to_facet, to_edge = (
        np.hypot(x, upper[1] - z) - np.hypot(x, lower[1] - z)
        for x, z in ((distance[deep], 0.0), (np.full(deep.sum(), edge), 2.0))
    )
    found = np.angle(seen.field[0] * seen.field[1].conj())[:, deep] + k * to_facet
    error = np.angle(np.exp(1j * (found - k * to_edge)))
    # F's next term turns it by 1/(πv²): the antennas' v (6 and more) differ by some 4 %.
    assert np.abs(error).max() < 1e-3
    assert np.abs(k * (to_facet - to_edge)).max() > 1.0


# -------------------------------------------------------------------------------------------------- its limits


@pytest.mark.parametrize("wavelength", [0.03, 0.0075])
def test_a_shadow_blurs_by_the_fresnel_scale(wavelength: float) -> None:
    """Half the field where the shadow ends; its first maximum 1.217 √(λ d₁ d₂/(2 (d₁ + d₂))) above the edge's ray."""
    made = narrow(tracing__facet_m=0.05, radar__baseline_m=0.0, radar__range_m=[15.0, 60.0])
    seen = rings(lambda r: np.where(np.abs(r - 20.0) < 0.025, 2.0, 0.0), made, wavelength)
    distance, size = middles(seen)[::2], np.abs(seen.field[0, 3, ::2])
    ends = 20.0 * 5.0 / 3.0
    beyond = distance > 22.0
    half = np.interp(0.5, size[beyond & (distance < ends + 0.3)], distance[beyond & (distance < ends + 0.3)])
    assert half == pytest.approx(ends, abs=0.003)  # between two points 0.025 m apart, over which F is nearly straight
    lit = np.flatnonzero(distance > ends)
    brightest = distance[lit[size[lit].argmax()]]
    d1, d2 = np.hypot(20.0, 3.0), np.hypot(brightest - 20.0, 2.0)
    clearance = (5.0 - 5.0 * 20.0 / brightest - 2.0) * brightest / np.hypot(brightest, 5.0)
    scale = np.sqrt(wavelength * d1 * d2 / (2.0 * (d1 + d2)))
    assert clearance / scale == pytest.approx(1.2172, rel=0.01)
    assert size.max() ** 2 == pytest.approx(1.3704, abs=2e-3)


@pytest.fixture(scope="module")
def random_sea() -> SurfaceMesh:
    made = scene("choppy_sea", radar__sector_deg=[260.0, 264.0])
    return mesh_turn(sea.realize(made.sea, 3), made.radar, made.tracing, 0)


def test_short_waves_make_shadows_black_and_white(random_sea: SurfaceMesh) -> None:
    """As geometric light does it: as much of it, though on the columns' middles, not on the facets' own planes."""
    seen = over_edges(random_sea, 1e-12)
    assert 0.2 < seen.lit.mean() < 0.8
    size = np.abs(seen.field)
    assert np.mean(np.minimum(size, np.abs(size - 1.0)) > 0.02) < 2e-4  # within 16 Fresnel zones, 40 µm, of an edge
    assert np.mean(size) == pytest.approx(seen.lit.mean(), abs=0.01)  # 0.002 on the whole turn
    assert np.mean((size > 0.5) != seen.lit) < 0.05
    in_x_band = over_edges(random_sea, WAVELENGTH)
    assert np.mean(np.abs(in_x_band.field - in_x_band.lit) > 0.02) > 0.5
    assert_array_equal(in_x_band.lit, seen.lit)


def test_random_sea_against_a_search_over_all_edges(random_sea: SurfaceMesh) -> None:
    """Facet by facet: which silhouettes stand before it, which v is the largest, and what came over that."""
    seen = over_edges(random_sea)
    for number, antenna in enumerate(antennas(seen)):
        column = 5
        exact, faces = searched(seen, antenna, column)
        found = seen.field[number, column]
        assert_array_equal(found[~faces], 0.0)
        assert_allclose(found[faces], exact[faces], rtol=0.0, atol=TABLE)
        assert 0.05 < np.mean(~seen.lit[number, column][faces]) < 0.6
        assert np.mean(np.abs(exact - seen.lit[number, column])[faces] > 0.1) > 0.2


def searched(seen: Seen, antenna: tuple[float, float], column: int) -> tuple[NDArray[np.complex128], NDArray[np.bool_]]:
    """F of a column's facets, and which of them face their ray."""
    exact = np.ones(seen.facets.distance.size, dtype=np.complex128)
    faces = np.zeros(exact.size, dtype=bool)
    plane = profile(seen.mesh.elevation, seen.mesh.grid, 0.5)
    x, z = plane.rung_distance, plane.rung_height[column]
    tangent = (z - antenna[1]) / (x - antenna[0])
    top = tangent >= np.maximum.accumulate(tangent)
    edges = np.flatnonzero(top[:-1] & (np.diff(tangent) < 0.0))
    for n in range(x.size - 1):
        point = (0.5 * (x[n] + x[n + 1]), 0.5 * (z[n] + z[n + 1]))
        source, place, both = antenna, point, slice(2 * n, 2 * n + 2)
        before = edges[edges <= n]
        for _ in range(2):
            if before.size == 0:
                break
            v = fresnel_height(antenna, (x[before], z[before]), *place, WAVELENGTH)
            most = int(np.argmax(v))
            exact[both] *= knife_edge(v[most]) if abs(v[most]) < 22.5 else float(v[most] < 0.0)
            edge = (x[before[most]], z[before[most]])
            if v[most] > 0.0 and place is point:
                source = edge
            over = antenna[1] + (place[1] - antenna[1]) * (edge[0] - antenna[0]) / (place[0] - antenna[0])
            place, before = (edge[0], max(edge[1], over)), before[:most]
        falls = (source[1] - point[1]) / (point[0] - source[0])
        if source is antenna:
            falls = -seen.facets.rise[column, both] / seen.facets.distance[both]
        faces[both] = seen.facets.slope_look[column, both] + falls > 1e-5  # along it is not onto it
        if source is antenna:
            faces[both] |= seen.lit[antennas(seen).index(antenna), column, both]
    return exact, faces


def test_sinusoid_by_its_own_tangent_points() -> None:
    """Dark troughs behind round crests: the edges are where the closed form says that rays touch."""
    made = scene(
        "sinusoid",
        sea__waves__0__wavelength_m=20.0,
        sea__waves__0__height_m=20.0 / 30.0,
        radar__sector_deg=[90.0, 92.0],
        radar__range_m=[15.0, 250.0],
        radar__baseline_m=0.0,
        tracing__facet_m=0.1,
    )
    seen = over_edges(mesh_turn(sea.realize(made.sea, 1), made.radar, made.tracing, 0))
    column = -seen.facets.grid.first
    (wave,) = made.sea.waves
    assert wave.spectrum == "sinusoid"
    length = 20.0 / float(np.cos(np.radians(seen.facets.grid.column_azimuth[column] - 90.0)))
    k, a = 2.0 * np.pi / length, 10.0 / 30.0
    phase = np.radians(wave.phase_deg) - float(angular_frequency(2.0 * np.pi / 20.0, np.inf)) * float(
        seen.facets.grid.column_time[column]
    )
    intervals, _ = sinusoid_visible_intervals(2.0 * a, length, 5.0, 0.0, 250.0, phase=phase)
    touches = intervals[:-1, 1]
    crests = a * np.cos(k * touches + phase)
    checked = 0
    for n in range(3, touches.size - 1):
        # The middle half of each shadow, where the first edge before is the crest that makes it.
        shadow = intervals[n + 1, 0] - touches[n]
        facets = np.abs(seen.facets.distance - touches[n] - 0.6 * shadow) < 0.25 * shadow
        assert not seen.lit[0, column, facets].any()
        x, z = seen.facets.distance[facets], seen.facets.height[column, facets]
        before = max(fresnel_height((0.0, 5.0), (touches[:n], crests[:n]), touches[n], crests[n], WAVELENGTH))
        v = fresnel_height((0.0, 5.0), (touches[n], crests[n]), x, z, WAVELENGTH)
        facing = seen.field[0, column, facets] != 0.0
        assert facing.any()
        assert_allclose(seen.field[0, column, facets][facing], (knife_edge(before) * knife_edge(v))[facing], atol=0.02)
        checked += facing.sum()
    assert checked > 100


# ------------------------------------------------------------------------------------------------ as an option


def test_tracer_composes_it() -> None:
    made = narrow(radar__frequency_hz=9.4e9)
    mesh = mesh_turn(RadialSurface(walls((20.0, 2.0))), made.radar, made.tracing, 0)
    plain = tracer("horizon", made.radar, made.scattering)(mesh)
    assert plain.field is None
    assert plain.ray_slope is None
    bent = tracer("horizon", made.radar, made.scattering, "knife_edge")(mesh)
    direct = diffract(trace_horizon(mesh), mesh, SPEED_OF_LIGHT / 9.4e9, least=0.25)  # −24 dB both ways
    assert bent.field is not None
    assert direct.field is not None
    assert_array_equal(bent.field, direct.field)
    assert_array_equal(bent.lit, plain.lit)
    rays = tracer("facets", made.radar, made.scattering, diffraction="knife_edge")(mesh)
    assert rays.rays > 0
    assert rays.field is not None
    assert_array_equal(rays.field, direct.field)


def test_what_is_asked_amiss_is_refused() -> None:
    made = narrow()
    with pytest.raises(ValueError, match="diffraction = 'rounded': must be none or knife_edge"):
        tracer("horizon", made.radar, made.scattering, "rounded")
    mesh = mesh_turn(RadialSurface(lambda r: 0.0 * r), made.radar, made.tracing, 0)
    for wavelength in (0.0, -0.03, np.nan, np.inf):
        with pytest.raises(ValueError, match=r"wavelength_m = .*: must be finite and above 0"):
            diffract(trace_horizon(mesh), mesh, wavelength)
