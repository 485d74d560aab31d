"""PathSolver's light against the exact sinusoid and other tracers; its echo's power, bounce by bounce, against sums."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt import sea
from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.scene import Scene, load_scene
from seamap_rt.tracing import Illumination, tracer
from seamap_rt.tracing.horizon import trace_horizon
from seamap_rt.tracing.paths import antennas_east_north_up
from validation.analytic.shadowing import sinusoid_visible_intervals, visible_share
from validation.hard_cases.case import RadialSurface
from validation.hard_cases.light import beside_an_edge
from validation.light.path_echo import DIFFUSE, MIRRORED, Body, PathEcho, lambertian_power, path_echo

Array = NDArray[np.float64]
Height = Callable[[Array], Array]


def scene(name: str = "flat", **keys: Any) -> Scene:
    """Two degrees, out to 100 m, of a mesh that stays as it is whatever errors are asked for."""
    usual = {
        "radar__sector_deg": [90.0, 92.0],
        "radar__range_m": [15.0, 100.0],
        "tracing__facet_m": 0.5,
        "tracing__columns_per_beam": 4,
    }
    return load_scene(name, overrides={key.replace("__", "."): value for key, value in {**usual, **keys}.items()})


def meshed(made: Scene, height: Height | None = None) -> SurfaceMesh:
    water = sea.realize(made.sea, 3) if height is None else RadialSurface(height)
    return mesh_turn(water, made.radar, made.tracing, 0)


def light(name: str, mesh: SurfaceMesh, made: Scene) -> NDArray[np.bool_]:
    return tracer(name, made.radar, made.scattering)(mesh).lit


# ------------------------------------------------------------------------------------------------------- light


def test_agrees_on_a_choppy_sea() -> None:
    """Float32 decides where a ray grazes an edge: on 0.0003 % of a whole turn's facets (validation.light.paths)."""
    made = scene("choppy_sea", radar__sector_deg=[260.0, 262.0], radar__range_m=[15.0, 400.0])
    mesh = meshed(made)
    seen, known = light("paths", mesh, made), light("horizon", mesh, made)
    assert 0.3 < known.mean() < 0.9
    assert np.mean(seen != known) < 1e-4
    assert not np.any((seen != known) & ~(beside_an_edge(seen) | beside_an_edge(known)))


@pytest.mark.parametrize("azimuth", [90.0, 270.0])
def test_agrees_with_the_exact_sinusoid(azimuth: float) -> None:
    made = scene(
        "sinusoid",
        sea__waves__0__wavelength_m=20.0,
        sea__waves__0__height_m=20.0 / 30.0,
        radar__sector_deg=[azimuth, azimuth + 2.0],
        radar__range_m=[15.0, 250.0],
        tracing__facet_m=0.05,
    )
    mesh, edges = meshed(made), np.arange(40.0, 241.0, 20.0)
    lit, grid, facets = light("paths", mesh, made), mesh.grid, mesh.facets
    column = -grid.first
    wave = made.sea.waves[0]
    assert wave.spectrum == "sinusoid"
    downwave = float(np.cos(np.radians(grid.column_azimuth[column] - 90.0)))  # the waves run east
    phase = np.radians(wave.phase_deg) - float(angular_frequency(np.pi / 10.0, np.inf)) * grid.column_time[column]
    length = facets.horizontal_area / facets.distance
    number = np.digitize(facets.distance, edges) - 1
    held = (number >= 0) & (number < edges.size - 1)
    for antenna, side in ((0, -0.5), (1, 0.5)):
        height = made.radar.height_m + side * made.radar.baseline_m
        direction = 1 if downwave > 0.0 else -1
        intervals, _ = sinusoid_visible_intervals(
            wave.height_m, 20.0 / abs(downwave), height, edges[0], edges[-1], phase=phase, direction=direction
        )
        found = np.bincount(number[held], (length * lit[antenna, column])[held]) / np.bincount(
            number[held], length[held]
        )
        exact = visible_share(intervals, edges)
        assert np.ptp(exact) > 0.1
        # Two edges of a shadow a wavelength, each to half a facet of 20 m a bin: 0.05/20.
        assert_allclose(found, exact, rtol=0.0, atol=0.005)


@pytest.mark.parametrize("tilt", [35.0, -60.0])
def test_antennas_that_lean_are_seen_from_where_they_are(tilt: float) -> None:
    """Each column looks from another place; what lies behind the outer antenna is dark."""
    keys = {"radar__tilt_deg": tilt, "radar__baseline_m": 4.0, "radar__sector_deg": [260.0, 264.0]}
    made = scene("choppy_sea", **keys)
    mesh = meshed(made)
    seen, known = light("paths", mesh, made), light("horizon", mesh, made)
    assert 0.3 < known.mean() < 0.9
    assert np.mean(seen != known) < 1e-4


def test_facets_seen_from_under_water_are_dark() -> None:
    """An antenna in a well of which the rim is 1.5 m higher: it sees the falling sea beyond from beneath."""
    made = scene(radar__height_m=0.5, radar__baseline_m=0.2)
    mesh = meshed(made, lambda r: 2.0 - 0.02 * r)
    assert (mesh.facets.height[:, 0] > 1.5).all()
    assert not light("horizon", mesh, made).any()
    assert not light("paths", mesh, made).any()


def test_a_year_of_paths_is_refused() -> None:
    """A leaning mast on a full turn of narrow columns: a call for each."""
    made = scene(
        "tiny",
        radar__tilt_deg=10.0,
        radar__sector_deg=[0.0, 360.0],
        tracing__columns_per_beam=64,
        radar__antenna__azimuth_beamwidth_deg=0.4,
        radar__antenna__width_m=4.5,
        radar__range_m=[15.0, 20.0],
        tracing__facet_m=5.0,
    )
    with pytest.raises(ValueError, match=r"tracer = paths: must end within 1 h.*; narrow radar.sector_deg"):
        light("paths", meshed(made), made)


# ---------------------------------------------------------------------------------------------- power, one bounce

FREQUENCY = 10e9
WAVELENGTH = SPEED_OF_LIGHT / FREQUENCY


@pytest.fixture(scope="module")
def flat() -> tuple[SurfaceMesh, slice, float, float]:
    """A flat sea, four of its columns, their width (rad), and how high the lower antenna stands."""
    made = scene()
    mesh = meshed(made)
    columns = slice(mesh.grid.columns // 2 - 2, mesh.grid.columns // 2 + 2)
    height = made.radar.height_m - 0.5 * made.radar.baseline_m
    return mesh, columns, 4 * float(np.radians(mesh.grid.spacing_deg)), height


EDGES = np.arange(20.0, 101.0, 10.0)


def first(echo: PathEcho) -> NDArray[np.bool_]:
    return echo.bounces == 1


def test_a_flat_sea_by_the_radar_equation(flat: tuple[SurfaceMesh, slice, float, float]) -> None:
    """σ⁰ = 4 sin²ψ: ∫ λ² 4 (H/R)² / ((4π)³ R⁴) r dr, and r dr = R dR."""
    mesh, columns, width, height = flat
    echo = path_echo(mesh, columns, FREQUENCY, Body(), samples=50_000)
    power, error = echo.in_gates(EDGES, first(echo))
    integral = height**2 * width * (EDGES[:-1] ** -4 - EDGES[1:] ** -4)
    closed = WAVELENGTH**2 / (4.0 * np.pi) ** 3 * integral
    assert (error / closed).max() < 1e-3
    # Lattices of 5,000 points a gate: 1e-4; chords of columns 0.45° wide: 1e-5.
    assert_allclose(power, closed, rtol=5e-4)


def test_a_delay_is_twice_the_way(flat: tuple[SurfaceMesh, slice, float, float]) -> None:
    mesh, columns, _, height = flat
    echo = path_echo(mesh, columns, FREQUENCY, Body(), samples=20_000, launches=2)
    assert np.ptp(echo.range) > 50.0
    assert_allclose(echo.range, np.linalg.norm(echo.first, axis=0), rtol=5e-7)  # four ulps of float32
    assert_allclose(echo.first[2], -height, rtol=0.0, atol=1e-5)
    ground = np.hypot(echo.first[0], echo.first[1])
    point = mesh.facets.distance[echo.facet % mesh.facets.distance.size]
    assert np.abs(ground - point).max() < 0.5  # on its own facet, half a metre long
    assert_array_equal(np.unique(echo.facet // mesh.facets.distance.size), np.arange(columns.start, columns.stop))


def test_no_echo_is_an_empty_one(flat: tuple[SurfaceMesh, slice, float, float]) -> None:
    """Of a plane no second bounce comes; of a level mirror not even a first one."""
    mesh, columns, _, _ = flat
    twice = path_echo(mesh, columns, FREQUENCY, Body(), bounces=2, samples=2_000, launches=2)
    assert twice.kind.shape == (2, twice.power.size)
    assert (twice.bounces == 1).all()
    silent = path_echo(mesh, columns, FREQUENCY, Body(0.0), samples=2_000, launches=2)
    assert silent.power.size == 0
    assert_array_equal(silent.in_gates(EDGES, first(silent))[0], 0.0)


def test_sea_water_reflects_by_fresnel(flat: tuple[SurfaceMesh, slice, float, float]) -> None:
    """S²|Γ|² of a perfect Lambertian sea's power, Γ that of vertical polarization: 0.1 near Brewster's angle."""
    mesh, columns, _, height = flat
    epsilon, coefficient = 55.0 - 37.5j, 0.6
    edges = np.arange(20.0, 101.0, 2.0)
    echo = path_echo(mesh, columns, FREQUENCY, Body(coefficient, epsilon), samples=100_000)
    perfect = path_echo(mesh, columns, FREQUENCY, Body(), samples=100_000)
    power, error = echo.in_gates(edges, first(echo))
    whole, _ = perfect.in_gates(edges, first(perfect))
    sine = height / (0.5 * (edges[1:] + edges[:-1]))
    root = np.sqrt(epsilon - 1.0 + sine**2)
    gamma = np.abs((epsilon * sine - root) / (epsilon * sine + root))
    ratio = power / whole
    assert gamma.min() ** 2 < 0.25
    # A bounce is diffuse or a mirror's by chance: 1 to 2 % of a gate; Γ² changes by 1 % across the nearest one.
    assert np.abs(ratio / (coefficient * gamma) ** 2 - 1.0).max() < 0.1
    misfit = (ratio / (coefficient * gamma) ** 2 - 1.0) / (error / power)
    assert np.sqrt(np.mean(misfit**2)) < 3.0
    assert abs(np.mean(ratio / (coefficient * gamma) ** 2) - 1.0) < 0.01


def gates_of_lit(
    mesh: SurfaceMesh, columns: slice, lit: Illumination, echo: PathEcho, edges: Array
) -> tuple[Array, ...]:
    """Facets' own power a gate, the paths', and its error: over facets that no edge of a shadow comes near."""
    slant, power = lambertian_power(lit, columns, 0, FREQUENCY)
    clear = lit.lit[0] & ~beside_an_edge(lit.lit[0])
    everywhere = np.zeros(clear.shape)
    everywhere[columns] = slant
    own = np.histogram(slant, edges, weights=power * clear[columns])[0]
    chosen = first(echo) & clear.ravel()[echo.facet]
    return own, *echo.in_gates(edges, chosen, everywhere.ravel()[echo.facet])


def test_a_choppy_sea_facet_by_facet() -> None:
    """Power of lit facets a gate, by paths and by the radar equation, within the launches' spread.

    Beside the edges of shadows a facet is lit in part, which its point does not tell: 1 % of the power with four
    columns a beam, 0.1 % with sixteen (`validation/light/paths.py`).
    """
    keys = {"radar__sector_deg": [268.0, 272.0], "tracing__columns_per_beam": 16}
    mesh = meshed(scene("choppy_sea", **keys))
    columns = slice(mesh.grid.columns // 2 - 16, mesh.grid.columns // 2 + 16)
    lit = trace_horizon(mesh)
    echo = path_echo(mesh, columns, FREQUENCY, Body(), samples=100_000)
    own, power, error = gates_of_lit(mesh, columns, lit, echo, np.linspace(20.0, 100.0, 9))
    assert (error / own).max() < 2e-3
    assert np.abs((power - own) / np.hypot(error, 5e-4 * own)).max() < 5.0
    slant, whole = lambertian_power(lit, columns, 0, FREQUENCY)
    chosen = first(echo) & (echo.range > 20.0) & (echo.range < 100.0)
    total = echo.power[chosen].sum() / echo.launches
    assert total == pytest.approx(whole[(slant > 20.0) & (slant < 100.0)].sum(), rel=5e-3)


# -------------------------------------------------------------------------------------------- power, two bounces


def ramp(r: Array) -> Array:
    """A flat sea and, from 16 m to 20 m, a slope of 45°."""
    return np.clip(r - 16.0, 0.0, 4.0)


def corner() -> tuple[SurfaceMesh, slice]:
    keys = {"radar__sector_deg": [70.0, 110.0], "radar__range_m": [15.0, 18.0], "tracing__facet_m": 0.2}
    mesh = meshed(scene(**keys), ramp)
    return mesh, slice(mesh.grid.columns // 2 - 2, mesh.grid.columns // 2 + 2)


def second_bounce(mesh: SurfaceMesh, columns: slice) -> float:
    """λ²/(4π)² ΣΣ (A₁ c₁/r₁²)(c₁₂/π)(A₂ c₂₁/r₁₂²)(c₂/π)/r₂², over all pairs of triangles."""
    (sheet,) = mesh.sheets()
    surface = mesh.trimesh(sheet)
    vertices, faces = surface.vertices, surface.faces
    corners = vertices[faces]
    middle = corners.mean(axis=1)
    normal = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])  # as long as the area
    place = antennas_east_north_up(mesh.grid)[0, 0]
    way = place - middle
    distance = np.linalg.norm(way, axis=1)
    seen = np.sum(normal * way, axis=1) / distance  # area × cosine
    area = np.linalg.norm(normal, axis=1)
    count = mesh.facets.distance.size
    total = 0.0
    lit = (seen > 0.0) & (np.hypot(middle[:, 0], middle[:, 1]) < 20.0)
    for one in np.flatnonzero(lit[columns.start * count : columns.stop * count]) + columns.start * count:
        between = middle - middle[one]
        length = np.maximum(np.linalg.norm(between, axis=1), 1e-9)
        leaves = np.maximum(between @ normal[one], 0.0) / length / area[one]
        arrives = np.maximum(-np.sum(between * normal, axis=1), 0.0) / length
        back = seen / area / distance**2
        total += seen[one] / distance[one] ** 2 * np.sum((leaves * arrives / length**2 * back)[lit])
    return WAVELENGTH**2 / (4.0 * np.pi) ** 2 / np.pi**2 * total


def test_a_corner_by_the_sum_over_all_pairs() -> None:
    """Between the flat and the slope: 1 % of the one bounce."""
    mesh, columns = corner()
    echo = path_echo(mesh, columns, FREQUENCY, Body(), bounces=2, samples=200_000)
    near = np.array([1.0, 40.0])
    power, error = (float(part[0]) for part in echo.in_gates(near, echo.bounces == 2))
    once = float(echo.in_gates(near, first(echo))[0][0])
    assert power / once > 0.005
    assert error / power < 0.02
    # The sum takes facets as points: where the two planes meet, they are as far apart as they are large.
    assert power == pytest.approx(second_bounce(mesh, columns), rel=0.05)


def test_a_mirror_first_then_the_slope() -> None:
    """A mirror before it shows the slope's image as far below as it is above: twice the slope, seen from below.

    A path by the mirror is one to the slope from the antenna's image, and back from the slope straight.
    """
    mesh, columns = corner()
    echo = path_echo(mesh, columns, FREQUENCY, Body(np.sqrt(0.5)), bounces=2, samples=400_000)
    kinds = (echo.kind[0] == MIRRORED) & (echo.kind[1] == DIFFUSE)
    power, error = (float(part[0]) for part in echo.in_gates(np.array([1.0, 40.0]), kinds))
    facets = mesh.facets
    height = float(mesh.grid.column_height[0, 0]) + float(mesh.grid.antenna_positions[0, 0, 2])
    inside = (facets.distance > 16.0) & (facets.distance < 20.0)
    x, z = facets.distance[inside], facets.height[columns][:, inside]
    straight, bent = np.hypot(x, height - z), np.hypot(x, height + z)
    # The slope's normal is (−1, 1)/√2: cosines to the antenna and to its image, each to be above 0.
    back = (x + height - z) / straight / np.sqrt(2.0)
    there = np.maximum(x - height - z, 0.0) / bent / np.sqrt(2.0)
    area = facets.horizontal_area[inside] * np.sqrt(2.0)
    summed = np.sum(area * there / bent**2 * back / np.pi / straight**2)
    exact = WAVELENGTH**2 / (4.0 * np.pi) ** 2 * 0.25 * summed  # the mirror's half, and the diffuse half
    assert error / power < 0.03
    assert power == pytest.approx(exact, rel=0.06)  # the image hangs on chords 0.2 m long and on 2 % of chance


# ------------------------------------------------------------------------------------------------- to the bit


def test_the_same_bits_twice_and_others_from_another_seed() -> None:
    mesh, columns = corner()
    same = [path_echo(mesh, columns, FREQUENCY, Body(0.7), bounces=2, samples=20_000, launches=2) for _ in range(2)]
    other = path_echo(mesh, columns, FREQUENCY, Body(0.7), bounces=2, samples=20_000, launches=2, seed=1)
    for name in ("launch", "power", "range", "facet", "kind"):
        assert_array_equal(getattr(same[0], name), getattr(same[1], name))
    assert same[0].power.size != other.power.size or np.any(same[0].power != other.power)


def test_what_is_asked_amiss_is_refused() -> None:
    mesh, columns = corner()
    for name in ("bounces", "samples", "launches"):
        with pytest.raises(ValueError, match=rf"{name} = 0: must be at least 1"):
            path_echo(mesh, columns, FREQUENCY, Body(), **{name: 0})
    with pytest.raises(ValueError, match=r"columns = .*: must lie in one sheet"):
        path_echo(mesh, slice(0, mesh.grid.columns + 1), FREQUENCY, Body())
    echo = path_echo(mesh, columns, FREQUENCY, Body(), samples=1000, launches=1)
    with pytest.raises(ValueError, match="launches = 1: must be at least 2"):
        echo.in_gates(EDGES, first(echo))
