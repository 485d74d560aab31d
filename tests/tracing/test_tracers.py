"""Light and shadow: both tracers against a closed form, against each other, and in the corners of the envelope."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt import sea
from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.scattering.permittivity import permittivity_meissner_wentz12
from seamap_rt.scene import Scene, load_scene
from seamap_rt.session import simulate
from seamap_rt.tracing import Illumination, tracer
from seamap_rt.tracing.rays import RayTracer, SeaScene, occluding_surface
from validation.analytic.shadowing import sinusoid_visible_intervals, visible_share
from validation.hard_cases.case import TRACERS, RadialSurface
from validation.hard_cases.light import beside_an_edge

Height = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def scene(name: str = "flat", **keys: Any) -> Scene:
    return load_scene(name, overrides={key.replace("__", "."): value for key, value in keys.items()})


def narrow(**keys: Any) -> Scene:
    """Two degrees of a flat sea out to 100 m."""
    return scene("flat", **{"radar__sector_deg": [90.0, 92.0], "radar__range_m": [15.0, 100.0], **keys})


def trace(name: str, mesh: SurfaceMesh, made: Scene) -> Illumination:
    return tracer(name, made.radar, made.scattering)(mesh)


def lit_rings(name: str, height: Height, made: Scene) -> tuple[Illumination, NDArray[np.bool_]]:
    """Facets of a surface of rings and their light (antenna, column, facet)."""
    facets = trace(name, mesh_turn(RadialSurface(height), made.radar, made.meshing, 0), made)
    return facets, facets.lit


def light(facets: Illumination) -> NDArray[np.bool_]:
    return facets.lit


# ------------------------------------------------------------------------------------------ the exact answer


def along_waves(wavelength: float, azimuth: float, phase_deg: float, **tracing: float) -> Scene:
    return scene(
        "sinusoid",
        sea__waves__0__wavelength_m=wavelength,
        sea__waves__0__height_m=wavelength / 30.0,
        sea__waves__0__phase_deg=phase_deg,
        radar__sector_deg=[azimuth, azimuth + 2.0],
        **{f"tracing__{key}": value for key, value in tracing.items()},
    )


def shares(
    made: Scene, facets: Illumination, antenna: int, column: int, edges: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Visible share of each range bin, traced and exact, at the column's own azimuth and time."""
    (wave,) = made.sea.waves
    assert wave.spectrum == "sinusoid"
    k = 2.0 * np.pi / wave.wavelength_m
    downwave = np.cos(np.radians(facets.grid.column_azimuth[column] - 90.0))  # the waves run east
    omega = float(angular_frequency(k, np.inf))
    intervals, _ = sinusoid_visible_intervals(
        wave.height_m,
        wave.wavelength_m / abs(downwave),
        made.radar.height_m + (antenna - 0.5) * made.radar.baseline_m,
        edges[0],
        edges[-1],
        phase=np.radians(wave.phase_deg) - omega * facets.grid.column_time[column],
        direction=1 if downwave > 0.0 else -1,
    )
    length = facets.horizontal_area / facets.distance  # along the look: the closed form knows no width
    number = np.digitize(facets.distance, edges) - 1
    held = (number >= 0) & (number < edges.size - 1)
    lit = np.bincount(number[held], (length * light(facets)[antenna, column])[held], edges.size - 1)
    return lit / np.bincount(number[held], length[held], edges.size - 1), visible_share(intervals, edges)


@pytest.mark.parametrize("name", TRACERS)
@pytest.mark.parametrize("azimuth", [90.0, 270.0])
@pytest.mark.parametrize("wavelength", [20.0, 40.0])
class TestAgainstTheExactSinusoid:
    """Height λ/30 from 5 m, 40–400 m, along and against the waves; the tolerances are those asked for.

    A facet is lit or dark as a whole. Near and far facets alternate, so a shadow's edge errs by up to facet_m/4, and a
    bin cuts as much off a facet at each end: at 0.2 m a bin of 20 m with two edges cannot be wrong by more than
    4 × 0.05/20 = 0.01. Over the whole window the errors nearly cancel, the less the more rungs fit evenly into a wave:
    of 192 phases, looks and antennas at 20 m and 0.5 m the worst is 0.0047, the rms 0.0018.
    """

    @pytest.mark.parametrize("phase", [0.0, 40.0, 200.0])
    def test_whole_window_by_a_target(self, name: str, azimuth: float, wavelength: float, phase: float) -> None:
        made = along_waves(wavelength, azimuth, phase, visible_error=0.0125)  # of a cell of 3 m
        assert 0.3 < made.detail.facet_m <= 0.5  # the model's answer: no number that is set here
        facets = trace(name, mesh_turn(sea.realize(made.sea, 1), made.radar, made.meshing, 0), made)
        window = np.array([40.0, 400.0])
        for antenna in (0, 1):
            columns = range(-facets.grid.first, -facets.grid.first + 4)  # the sector's
            found, exact = np.mean([shares(made, facets, antenna, column, window) for column in columns], axis=0)
            assert 0.3 < exact[0] < 0.4
            assert_allclose(found, exact, rtol=0.0, atol=0.005)

    @pytest.mark.parametrize("phase", [0.0, 130.0])
    def test_each_wavelength_at_a_fine_mesh(self, name: str, azimuth: float, wavelength: float, phase: float) -> None:
        made = along_waves(wavelength, azimuth, phase, facet_m=0.2)
        facets = trace(name, mesh_turn(sea.realize(made.sea, 1), made.radar, made.meshing, 0), made)
        edges = np.arange(40.0, 400.1, wavelength)
        for antenna in (0, 1):
            for column in (-facets.grid.first, -facets.grid.first + 2):
                found, exact = shares(made, facets, antenna, column, edges)
                assert np.ptp(exact) > 0.1  # from mostly lit to mostly dark
                assert_allclose(found, exact, rtol=0.0, atol=0.01)


# ------------------------------------------------------------------------------------ two tracers, one answer


@pytest.fixture(scope="module")
def choppy() -> tuple[Scene, SurfaceMesh, dict[str, Illumination]]:
    """A whole turn of choppy_sea, by both tracers."""
    made = scene("choppy_sea")
    mesh = mesh_turn(sea.realize(made.sea, 3), made.radar, made.meshing, 0)
    return made, mesh, {name: trace(name, mesh, made) for name in TRACERS}


def test_tracers_agree_on_a_choppy_sea(choppy: tuple[Scene, SurfaceMesh, dict[str, Illumination]]) -> None:
    """Rays are float32: they may differ where a ray grazes an edge, on 0.001–0.01 % of the facets."""
    rays, horizon = (light(choppy[2][name]) for name in TRACERS)
    differ = rays != horizon
    assert 0.3 < horizon.mean() < 0.9  # there are shadows to differ about
    assert differ.mean() < 1e-4
    assert not np.any(differ & ~(beside_an_edge(rays) | beside_an_edge(horizon)))


def test_facets_seen_from_behind_are_dark(choppy: tuple[Scene, SurfaceMesh, dict[str, Illumination]]) -> None:
    """By trimesh's normals and the antennas' places, for both tracers; float32 slopes blur the grazing ones."""
    _, mesh, traced = choppy
    (columns,) = mesh.sheets()[0]
    body, grid = mesh.world_trimesh, mesh.grid
    shape = traced["horizon"].height[columns].shape
    east, north = (part[columns, None] for part in unit_from_azimuth(grid.column_azimuth))
    for antenna in (0, 1):
        along, _, above = (part[columns, None] for part in grid.antenna_positions[:, antenna].T)
        height = grid.column_height[columns] + above
        place = np.stack(np.broadcast_arrays(along * east, along * north, height), axis=-1)
        to_antenna = place - body.triangles_center.reshape(*shape, 3)
        to_antenna /= np.linalg.norm(to_antenna, axis=-1, keepdims=True)
        cosine = np.sum(body.face_normals.reshape(*shape, 3) * to_antenna, axis=-1)
        behind = cosine < -1e-6
        assert behind.mean() > 0.1
        for name in TRACERS:
            assert not np.any(light(traced[name])[antenna, columns] & behind)


def test_light_is_higher_than_the_sea(choppy: tuple[Scene, SurfaceMesh, dict[str, Illumination]]) -> None:
    """Crests are seen, troughs are not; and the upper antenna sees what the lower one sees, and a little more."""
    for facets in choppy[2].values():
        lit = light(facets)
        assert facets.height[lit[0]].mean() > facets.height.mean() + 0.05
        far = facets.distance > 50.0
        assert lit[1][:, far].mean() > lit[0][:, far].mean()
        assert np.mean(lit[0] & ~lit[1]) < 1e-3


# -------------------------------------------------------------------------------------- corners of the envelope


@pytest.mark.parametrize("name", TRACERS)
@pytest.mark.parametrize("mast", [3.0, 20.0])
@pytest.mark.parametrize("baseline", [0.0, 0.05, 0.9])
def test_flat_sea_is_fully_lit_to_400_m(name: str, mast: float, baseline: float) -> None:
    made = scene(
        radar__height_m=mast,
        radar__baseline_m=baseline,
        radar__sector_deg=[0.0, 30.0],
        radar__range_m=[15.0, 400.0],
    )
    facets = trace(name, mesh_turn(sea.realize(made.sea, 1), made.radar, made.meshing, 0), made)
    assert facets.distance[-1] > 400.0
    assert light(facets).all()
    assert facets.visible_to_both.all()


@pytest.mark.parametrize("name", TRACERS)
def test_calm_is_lit_but_for_the_backs_of_its_ripples(name: str) -> None:
    """Slopes of a few hundredths: within 50 m of a 5 m mast (grazing above 5.7°) nothing hides."""
    made = load_scene("calm", overrides={"radar.sector_deg": [240.0, 300.0]})
    facets = trace(name, mesh_turn(sea.realize(made.sea, 1), made.radar, made.meshing, 0), made)
    assert light(facets)[..., facets.distance < 50.0].mean() > 0.999


@pytest.mark.parametrize("name", TRACERS)
def test_total_shadow(name: str) -> None:
    """A dome that falls away faster than any ray from 2 cm above its top can follow."""
    made = narrow(radar__height_m=0.02, radar__baseline_m=0.0)
    _, lit = lit_rings(name, lambda r: -(r**2) / 20.0, made)  # rays touch it at √(20 × 0.02) = 0.63 m: before the mesh
    assert not lit.any()


@pytest.mark.parametrize("name", TRACERS)
def test_dome_is_lit_to_its_horizon(name: str) -> None:
    """z = −r²/2R from H above the top: the tangent touches at √(2RH) = 31.62 m."""
    made = narrow(radar__height_m=5.0, radar__baseline_m=0.2)
    facets, lit = lit_rings(name, lambda r: -(r**2) / 200.0, made)
    for antenna, height in ((0, 4.9), (1, 5.1)):
        horizon = np.sqrt(200.0 * height)
        facet = 0.5  # its chord is seen from above up to half a facet beyond the tangent point
        assert lit[antenna][:, facets.distance < horizon - facet].all()
        assert not lit[antenna][:, facets.distance > horizon + facet].any()


@pytest.mark.parametrize("name", TRACERS)
def test_distant_crest_above_the_antenna(name: str) -> None:
    """A ring wall higher than the mast: its near face is lit up to the top, and nothing behind it."""

    def wall(r: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.maximum(8.0 - np.abs(r - 60.0), 0.0)

    made = narrow()
    facets, lit = lit_rings(name, wall, made)
    facet = made.detail.facet_m
    assert lit[..., facets.distance < 60.0 - facet].all()
    assert not lit[..., facets.distance > 60.0 + facet].any()


@pytest.mark.parametrize("name", TRACERS)
def test_shadow_of_a_low_wall_ends_where_the_ray_lands(name: str) -> None:
    """A wall of 2 m at 20 m, 5 m mast: the ray over its top lands at 20 × H/(H − 2), for each antenna."""

    def wall(r: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.where(np.abs(r - 20.0) < 0.3, 2.0, 0.0)  # the mesh has a rung at 20 m

    made = narrow()
    facets, lit = lit_rings(name, wall, made)
    for antenna, height in ((0, 4.9), (1, 5.1)):
        lands = 20.0 * height / (height - 2.0)
        dark = ~lit[antenna]
        between = (facets.distance > 21.0) & (facets.distance < lands - made.detail.facet_m)
        beyond = facets.distance > lands + made.detail.facet_m
        assert dark[:, between].all()
        assert not dark[:, beyond].any()


@pytest.mark.parametrize("name", TRACERS)
def test_zero_baseline_lights_the_same_for_both(name: str) -> None:
    made = scene("tiny", radar__baseline_m=0.0, radar__sector_deg=[260.0, 270.0])
    lit = light(trace(name, mesh_turn(sea.realize(made.sea, 3), made.radar, made.meshing, 0), made))
    assert_array_equal(lit[0], lit[1])
    assert 0.2 < lit.mean() < 0.95


@pytest.mark.parametrize("name", TRACERS)
@pytest.mark.parametrize("tilt", [-60.0, -20.0, 20.0, 60.0])
def test_tilt_moves_the_antennas_along_the_look(name: str, tilt: float) -> None:
    """The low wall's shadow again, from where the tilted phase centres are."""

    def wall(r: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.where(np.abs(r - 20.0) < 0.3, 2.0, 0.0)

    made = narrow(radar__tilt_deg=tilt, radar__baseline_m=4.0, tracing__facet_m=0.99)
    facets, lit = lit_rings(name, wall, made)
    for antenna, side in ((0, -1.0), (1, 1.0)):
        along = side * 2.0 * np.sin(np.radians(tilt))
        height = 5.0 + side * 2.0 * np.cos(np.radians(tilt))
        lands = along + (20.0 - along) * height / (height - 2.0)
        dark = ~lit[antenna]
        reach = made.detail.facet_m
        assert lit[antenna][:, (facets.distance > 3.0) & (facets.distance < 19.0)].all()
        assert dark[:, (facets.distance > 21.0) & (facets.distance < lands - reach)].all()
        assert not dark[:, facets.distance > lands + reach].any()


@pytest.mark.parametrize("tilt", [-60.0, 35.0, 60.0])
def test_tracers_agree_on_what_lies_behind_a_tilted_antenna(tilt: float) -> None:
    """The upper phase centre leans out over the first rungs: those are not in front of it, for either tracer."""
    keys = {"radar__tilt_deg": tilt, "radar__baseline_m": 4.0, "radar__sector_deg": [260.0, 270.0]}
    made = scene("tiny", **keys, tracing__facet_m=0.5)  # so that facets lie under the leaning antenna
    mesh = mesh_turn(sea.realize(made.sea, 3), made.radar, made.meshing, 0)
    rays, horizon = (light(trace(name, mesh, made)) for name in TRACERS)
    outer = int(tilt > 0.0)
    behind = mesh.facets.distance < abs(mesh.grid.antenna_positions[0, outer, 0])
    assert behind.any()
    assert not horizon[outer][:, behind].any()
    assert_array_equal(rays[..., behind], horizon[..., behind])
    assert np.mean(rays != horizon) < 1e-4


def test_sector_just_short_of_the_circle() -> None:
    """Its run-on overlaps its own beginning by a few columns: both tracers must still agree."""
    for sector in ([0.0, 350.0], [10.0, 364.0]):
        made = scene("tiny", radar__sector_deg=sector, radar__range_m=[15.0, 60.0])
        mesh = mesh_turn(sea.realize(made.sea, 3), made.radar, made.meshing, 0)
        assert len(mesh.sheets()) == 2
        rays, horizon = (light(trace(name, mesh, made)) for name in TRACERS)
        assert np.mean(rays != horizon) < 1e-4


def test_unknown_tracer_is_refused() -> None:
    made = scene()
    with pytest.raises(ValueError, match="facets, horizon or paths"):
        tracer("photons", made.radar, made.scattering)


# --------------------------------------------------------------------------------------------- Sionna's scene


def test_traced_scene_is_a_sionna_scene_of_sea_water_and_two_antennas() -> None:
    made = narrow(radar__tilt_deg=10.0, radar__baseline_m=1.0, radar__frequency_hz=9.4e9)
    mesh = mesh_turn(sea.realize(made.sea, 1), made.radar, made.meshing, 0)
    epsilon = complex(permittivity_meissner_wentz12(9.4e9, 20.0, 35.0))
    (sheet,) = mesh.sheets()
    held = SeaScene(
        mesh.trimesh(sheet), mesh.grid.antenna_positions[sheet[0].start], made.radar.frequency_hz, epsilon
    ).scene

    import sionna.rt as rt  # late: the backend is chosen before it is imported

    assert isinstance(held, rt.Scene)
    assert list(held.objects) == ["sea"]
    water_body = held.objects["sea"]
    assert isinstance(water_body, rt.SceneObject)
    water: Any = water_body.radio_material
    assert isinstance(water, rt.RadioMaterial)
    # float32: half an ulp. conductivity = ε″ω ε₀, with CODATA's ε₀
    assert_allclose(np.array(held.frequency).item(), 9.4e9, rtol=6e-8)
    assert_allclose(np.array(water.relative_permittivity).item(), epsilon.real, rtol=6e-8)
    conductivity = -epsilon.imag * 2.0 * np.pi * 9.4e9 * 8.8541878128e-12
    assert_allclose(np.array(water.conductivity).item(), conductivity, rtol=6e-8)
    assert 15.0 < conductivity < 25.0  # S/m at X band, relaxation included
    assert_allclose(np.array(water.scattering_coefficient).item(), 0.0)

    assert sorted(held.transmitters) == ["lower-transmitter"]
    assert sorted(held.receivers) == ["lower", "upper"]
    lean = 0.5 * np.array([np.sin(np.radians(10.0)), np.cos(np.radians(10.0))])
    for device, side in (
        (held.transmitters["lower-transmitter"], -1.0),
        (held.receivers["lower"], -1.0),
        (held.receivers["upper"], 1.0),
    ):
        assert_allclose(np.array(device.position).ravel(), [0.0, *(side * lean)], rtol=0.0, atol=1e-7)


def stored_vertices(parameters: Any) -> NDArray[np.float32]:
    """(n, 3) of the traced sea; Mitsuba 3.10 calls them positions."""
    name = "sea.positions" if "sea.positions" in parameters else "sea.vertex_positions"
    return np.array(parameters[name]).reshape(-1, 3)


@pytest.mark.parametrize("sector", [[0.0, 360.0], [260.0, 270.0]])
def test_what_is_traced_each_turn_is_a_trimesh(sector: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    """The scenes hold its triangles and no others, in its order, made anew or updated; the kept faces are the sheet's.

    Vertices are rounded to float32 and faces are numbers, so that both are equal to the bit.
    """
    made = scene("tiny", radar__sector_deg=sector, radar__range_m=[15.0, 80.0])
    water, kept = sea.realize(made.sea, 3), RayTracer(made.radar, made.scattering)
    surfaces: list[trimesh.Trimesh] = []

    def recorded(*arguments: Any) -> trimesh.Trimesh:
        surfaces.append(occluding_surface(*arguments))
        return surfaces[-1]

    monkeypatch.setattr("seamap_rt.tracing.rays.occluding_surface", recorded)
    for turn in range(2):
        mesh = mesh_turn(water, made.radar, made.meshing, turn)
        surfaces.clear()
        kept(mesh)
        scenes = list(kept.scenes.values())
        for surface, held, sheet in zip(surfaces, scenes, mesh.sheets(), strict=True):
            assert isinstance(surface, trimesh.Trimesh)
            parameters = held.parameters
            stored = stored_vertices(parameters)
            assert_array_equal(stored, surface.vertices.astype(np.float32))
            assert_array_equal(np.array(parameters["sea.faces"]).reshape(-1, 3), surface.faces)
            whole = mesh.trimesh(sheet)
            assert_array_equal(surface.vertices[: len(whole.vertices)], whole.vertices)
            of_sheet = surface.faces[(surface.faces < len(whole.vertices)).all(axis=1)]
            assert 0 < len(of_sheet) <= len(whole.faces)
            assert np.isin(_numbers(of_sheet), _numbers(whole.faces)).all()


def _numbers(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """One number for each face: those of its first and its second corner."""
    return faces[:, 0] * 2**31 + faces[:, 1]


@pytest.mark.parametrize("sector", [[0.0, 360.0], [260.0, 270.0]])
def test_moved_vertices_give_the_light_of_a_fresh_scene(sector: list[float]) -> None:
    """Turn after turn through one tracer, against a tracer made for that turn alone: not one facet differs."""
    made = scene("tiny", radar__sector_deg=sector, radar__range_m=[15.0, 80.0])
    water = sea.realize(made.sea, 3)
    kept = RayTracer(made.radar, made.scattering)
    seen = []
    for turn in range(3):
        mesh = mesh_turn(water, made.radar, made.tracing, turn)
        moved = light(kept(mesh))
        assert_array_equal(moved, light(RayTracer(made.radar, made.scattering)(mesh)))
        seen.append(moved)
    assert np.any(seen[0] != seen[1])
    assert np.any(seen[1] != seen[2])


def test_other_topology_gets_its_own_scene() -> None:
    """A mesh of other size through the same tracer is not forced into the vertices of the first."""
    coarse = scene("tiny", radar__sector_deg=[260.0, 270.0])
    fine = scene("tiny", radar__sector_deg=[260.0, 270.0], tracing__facet_m=0.3)
    kept = RayTracer(coarse.radar, coarse.scattering)
    for made in (coarse, fine, coarse):
        mesh = mesh_turn(sea.realize(made.sea, 3), made.radar, made.meshing, 0)
        assert_array_equal(light(kept(mesh)), light(RayTracer(made.radar, made.scattering)(mesh)))


def test_ray_traced_run_repeats_to_the_bit() -> None:
    made = scene("tiny", radar__sector_deg=[260.0, 272.0], radar__range_m=[15.0, 80.0])
    assert made.tracing.tracer == "facets"
    first, second = (simulate(made) for _ in range(2))
    assert_array_equal(first.echoes["voltage"].values.view(np.uint64), second.echoes["voltage"].values.view(np.uint64))
    assert first.truth.identical(second.truth)
    assert np.isfinite(first.echoes["voltage"].values).all()
