"""Truth of seas whose averages are known: a regular wave by quadrature and closed form, and a flat sea."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.conventions import GRAVITY, SURFACE_TENSION, WATER_DENSITY, unit_from_azimuth
from seamap_rt.echoes import expected_look_gates
from seamap_rt.echoes.radar_cross_section import SeaSurface
from seamap_rt.interferometry import retrieve
from seamap_rt.mesh import SurfaceMesh, polar_grid, surface_mesh
from seamap_rt.radar.antenna import antenna
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.waveform import gates as gates_of
from seamap_rt.scene import Scene
from seamap_rt.session import simulate
from seamap_rt.settings import RadarSettings, TracingSettings
from seamap_rt.simulation import Simulator
from seamap_rt.tracing import Illumination
from seamap_rt.tracing.horizon import trace_horizon
from seamap_rt.truth import ground_truth, polar_truth
from seamap_rt.truth import polar as truth
from seamap_rt.truth.kernel import AREA, ECHO, QUANTITIES, Band, Bins, Surface, fill_cells

WAVELENGTH, AMPLITUDE, PHASE_DEG, FROM_DEG = 20.0, 0.4, 35.0, 60.0


def scene_of(waves: dict, **sections) -> Scene:
    return Scene.model_validate(
        {
            "name": "truth",
            "turns": 2,
            "sea": {"waves": [waves]},
            "scattering": {"nrcs": "constant", "nrcs_db": -35.0},
            "tracing": {"diffraction": "none", **sections.pop("tracing", {"tracer": "horizon"})},
            "radar": {
                "noise": False,
                "sector_deg": (30.0, 60.0),
                "range_m": (20.0, 100.0),
                **sections.pop("radar", {}),
            },
            **sections,
        }
    )


def wave_scene(**sections) -> Scene:
    wave = {
        "spectrum": "sinusoid",
        "height_m": 2.0 * AMPLITUDE,
        "wavelength_m": WAVELENGTH,
        "phase_deg": PHASE_DEG,
        "wave_from_deg": FROM_DEG,
    }
    return scene_of(wave, **sections)


def flat_scene(**sections) -> Scene:
    return scene_of({"spectrum": "flat"}, **sections)


class Wave:
    """The regular wave in closed form, written again: it travels to FROM_DEG + 180°, ω² = gk + (T/ρ)k³."""

    k = 2.0 * np.pi / WAVELENGTH
    east, north = (float(f(np.radians(FROM_DEG + 180.0))) for f in (np.sin, np.cos))
    omega = float(np.sqrt(GRAVITY * k + SURFACE_TENSION / WATER_DENSITY * k**3))

    @classmethod
    def angle(cls, x: NDArray, y: NDArray, t: NDArray | float) -> NDArray:
        return cls.k * (cls.east * x + cls.north * y) - cls.omega * t + np.radians(PHASE_DEG)

    @classmethod
    def height(cls, x: NDArray, y: NDArray, t: NDArray | float) -> NDArray:
        return AMPLITUDE * np.cos(cls.angle(x, y, t))

    @classmethod
    def rate(cls, x: NDArray, y: NDArray, t: NDArray | float) -> NDArray:
        return AMPLITUDE * cls.omega * np.sin(cls.angle(x, y, t))

    @classmethod
    def gradient(cls, x: NDArray, y: NDArray, t: NDArray | float) -> tuple[NDArray, NDArray]:
        sine = -AMPLITUDE * cls.k * np.sin(cls.angle(x, y, t))
        return cls.east * sine, cls.north * sine


def lit_facets(scene: Scene, turn: int = 0) -> tuple[Illumination, NDArray[np.float32]]:
    facets, returns, _ = Simulator(scene).light(turn)
    return facets, returns.rcs


def truth_of(scene: Scene, turn: int = 0) -> xr.Dataset:
    return polar_truth(*lit_facets(scene, turn), Installation(scene.radar), scene.retrieval, turn)


def cells_by_quadrature(scene: Scene, turn: int) -> dict[str, NDArray[np.float64]]:
    """Cell means over horizontal area by a fine sum, 2 cm × 0.03°: a cell holds the surface points within ± 0.9° of the
    look whose slant range lies within ± 1.5 m of the gate, each at the time when the beam passes it. The slope across
    is that of the sea as it is scanned: the next line is a moment later, which adds (∂z/∂t)/(Ω ρ), 4 % of this wave's
    slope at 20 m."""
    turning = 2.0 * np.pi / scene.turn_duration_s  # rad/s
    start, stop = scene.radar.sector_deg
    gates = gates_of(scene.radar)
    ground = np.arange(10.0, 105.0, 0.02)
    looks = int((stop - start) / 1.8 + 1e-9)
    fields = {name: np.zeros((looks, gates.size)) for name in ("height", "slope_range", "slope_azimuth")}
    for look in range(looks):
        sweep = 1.8 * (look + (np.arange(60) + 0.5) / 60.0)[:, None]
        bearing, time = np.radians(start + sweep), (turn + sweep / 360.0) * scene.turn_duration_s
        x, y = ground * np.sin(bearing), ground * np.cos(bearing)
        z = Wave.height(x, y, time)
        east, north = Wave.gradient(x, y, time)
        out = east * np.sin(bearing) + north * np.cos(bearing)
        clockwise = east * np.cos(bearing) - north * np.sin(bearing) + Wave.rate(x, y, time) / (turning * ground)
        slant = np.hypot(ground, z - scene.radar.height_m)
        order = np.argsort(slant, axis=None)
        weight = np.broadcast_to(ground, slant.shape).ravel()[order]
        edges = np.searchsorted(slant.ravel()[order], np.stack((gates - 1.5, gates + 1.5)))
        total = np.append(0.0, np.cumsum(weight))
        area = total[edges[1]] - total[edges[0]]
        for name, field in (("height", z), ("slope_range", out), ("slope_azimuth", clockwise)):
            moment = np.append(0.0, np.cumsum(weight * field.ravel()[order]))
            fields[name][look] = (moment[edges[1]] - moment[edges[0]]) / area
    return fields


@pytest.mark.parametrize(("turn", "sampling"), [(0, 1.5), (1, 1.5), (0, 0.75)])
def test_cell_means_of_a_regular_wave(turn: int, sampling: float) -> None:
    # 5 mm is asked. A wave 20 m long between rungs 1 m apart sags by a k² Δ²/12 = 3 mm, which is put back; halves of
    # facets are gathered by their points (0.25 m apart) into bins of 0.5 m, whose softness flattens the wave by
    # (k 0.5 m)²/12 = 0.2 %. Measured: 2.3 mm.
    scene = wave_scene(radar={"range_sampling_m": sampling})
    truth, judge = truth_of(scene, turn), cells_by_quadrature(scene, turn)
    assert judge["height"].shape == truth["height"].shape[1:]
    np.testing.assert_allclose(truth["height"].values[0], judge["height"], rtol=0, atol=5e-3)
    np.testing.assert_allclose(truth["slope_range"].values[0], judge["slope_range"], rtol=0, atol=2e-3)
    np.testing.assert_allclose(truth["slope_azimuth"].values[0], judge["slope_azimuth"], rtol=0, atol=2e-3)
    # There is something to see: the wave's height and slope, hardly averaged, and another sea at another time.
    assert truth["height"].values.max() > 0.9 * AMPLITUDE
    assert np.ptp(truth["slope_range"].values) > 0.2
    other = cells_by_quadrature(scene, 1 - turn)
    assert np.abs(truth["height"].values[0] - other["height"]).max() > 0.1


def test_cell_mean_closed_form() -> None:
    # Long-crested along the look and far out, where slant and ground range are one: the mean over 3 m is sinc(3/λ) of
    # the wave, here at the look's middle. Across a look of 1.8° the look bends off the wave by 1 − cos(0.9°): nothing.
    wave = {
        "spectrum": "sinusoid",
        "height_m": 0.02,
        "wavelength_m": WAVELENGTH,
        "phase_deg": 0.0,
        "wave_from_deg": 45.0,
    }
    scene = scene_of(wave, radar={"sector_deg": (44.1, 46.0), "range_m": (150.0, 250.0)})
    truth = truth_of(scene)
    time = float(truth["time"][0, 0])
    ground = np.sqrt(truth["range"].values ** 2 - 25.0)
    # Towards the radar: the wave comes from 45° and the look is 45°.
    value = 0.01 * np.sinc(3.0 / WAVELENGTH) * np.cos(-Wave.k * ground - Wave.omega * time)
    np.testing.assert_allclose(truth["height"].values[0, 0], value, rtol=0, atol=4e-4)  # 4 % of the amplitude


def test_visible_part_and_weighted_height() -> None:
    mesh = {"tracer": "horizon", "facet_m": 0.5, "columns_per_beam": 4}  # the expectation's facets are flat
    scene = wave_scene(radar={"range_m": (20.0, 150.0)}, tracing=mesh)
    facets, rcs = lit_facets(scene)
    truth = polar_truth(facets, rcs, Installation(scene.radar), scene.retrieval, 0)
    fraction, height = truth["visible_fraction"].values[0], truth["height"].values[0]
    assert 0.0 <= np.nanmin(fraction) < 0.1  # there are shadows
    assert np.nanmax(fraction) <= 1.0 + 1e-6
    seen = truth["height_visible"].values[0]
    np.testing.assert_array_equal(np.isnan(seen), fraction == 0.0)
    whole = fraction > 1.0 - 1e-6
    np.testing.assert_allclose(seen[whole], height[whole], rtol=0, atol=1e-6)
    partly = (fraction > 0.02) & (fraction < 0.98)
    assert np.mean(seen[partly] - height[partly]) > 0.01  # what is seen stands higher
    # Beam and gate weigh the same surface in the expectation: an independent road to the same number.
    whole = replace(facets, lit=np.ones_like(facets.lit))
    slant = np.hypot(facets.distance, facets.rise)
    even = facets.horizontal_area * (slant / antenna(scene.radar).elevation(facets.rise / slant)) ** 4
    raised, level = (
        expected_look_gates(
            whole, each.astype(np.float32), Installation(scene.radar), scene.retrieval.cell_azimuth_deg
        ).power[0, 1]
        for each in (even * (facets.height + 5.0), even)  # above 0 everywhere
    )
    np.testing.assert_allclose(truth["height_weighted"].values[0], raised / level - 5.0, rtol=0, atol=5e-3)
    # The share of all facets' area is the mean of the cells', but for the ends.
    inside = (facets.distance > 30.0) & (facets.distance < 140.0)
    columns = (facets.grid.column_sweep > 0.0) & (facets.grid.column_sweep < 28.8)
    area = facets.horizontal_area[inside]
    share = (facets.visible_to_both[columns][:, inside] * area).sum() / (area.sum() * columns.sum())
    gate = truth["range"].values
    between = (gate > 30.5) & (gate < 139.5)
    mean = np.average(fraction[:, between], weights=np.broadcast_to(gate[between], fraction[:, between].shape))
    assert mean == pytest.approx(share, abs=0.02)


def test_a_flat_sea() -> None:
    # All in sight, level, and of the NRCS that was asked for: bins of 0.25 m cut facets of 0.25 m, ± 4 % of a cell's
    # area, in numerator and denominator alike.
    truth = truth_of(flat_scene(radar={"range_m": (15.0, 400.0), "sector_deg": (0.0, 9.0)}))
    np.testing.assert_array_equal(truth["visible_fraction"].values, 1.0)
    for name in ("height", "height_visible", "height_weighted", "slope_range", "slope_azimuth"):
        np.testing.assert_array_equal(truth[name].values, 0.0)
    np.testing.assert_allclose(truth["nrcs_db"].values, -35.0, atol=1e-4)


def test_cells_nearer_than_the_sea_are_nan() -> None:
    # A gate at 3 m from a mast of 8 m hears no sea.
    truth = truth_of(flat_scene(radar={"range_m": (3.0, 30.0), "height_m": 8.0, "sector_deg": (0.0, 9.0)}))
    near = truth["range"].values + 1.5 < 8.0
    assert near.sum() >= 2
    for name in ("height", "visible_fraction", "nrcs_db", "slope_range"):
        assert np.isnan(truth[name].values[..., near]).all()
        assert np.isfinite(truth[name].values[..., truth["range"].values > 11.0]).all()


def test_ground_cells_of_a_regular_wave() -> None:
    # The mean of a plane wave over a square of side s is sinc(k_x s/2π) sinc(k_y s/2π) of it, and so is that of its
    # slopes. Two-point Gauss per side leaves (k s)⁴/4320 of the amplitude: 2e-4.
    scene = wave_scene()
    simulator = Simulator(scene)
    for turn in (0, 1):
        truth = ground_truth(simulator.sea, Installation(scene.radar), scene.retrieval, turn)
        x, y = np.meshgrid(truth["x"].values, truth["y"].values)
        bearing = np.degrees(np.arctan2(x, y)) % 360.0
        time = (turn + ((bearing - 30.0) % 360.0) / 360.0) * scene.turn_duration_s
        inside = (np.hypot(x, y) <= 99.5) & (((bearing - 30.0) % 360.0) <= 30.0)
        known = np.isfinite(truth["height"].values[0])
        assert known[inside].all()
        assert not known[np.hypot(x, y) > 100.0].any()
        np.testing.assert_array_equal(known, np.isfinite(truth["time"].values[0]))
        np.testing.assert_allclose(truth["time"].values[0][known], time[known], rtol=0, atol=1e-9)
        side = scene.retrieval.ground_m
        blur = np.sinc(Wave.k * Wave.east * side / (2.0 * np.pi)) * np.sinc(Wave.k * Wave.north * side / (2.0 * np.pi))
        np.testing.assert_allclose(
            truth["height"].values[0][known], blur * Wave.height(x, y, time)[known], rtol=0, atol=3e-4 * AMPLITUDE
        )
        for name, exact in zip(("slope_x", "slope_y"), Wave.gradient(x, y, time), strict=True):
            steepest = AMPLITUDE * Wave.k
            np.testing.assert_allclose(
                truth[name].values[0][known], blur * exact[known], rtol=0, atol=1e-3 * steepest, err_msg=name
            )


def test_times_and_grids_are_those_of_the_maps() -> None:
    scene = wave_scene()
    simulation = simulate(scene)
    maps = retrieve(simulation.echoes, scene.retrieval.model_copy(update={"paths": "one_way"}))
    for group, coordinates in (("polar", ("turn", "azimuth", "range")), ("ground", ("turn", "y", "x"))):
        for name in coordinates:
            np.testing.assert_array_equal(simulation.truth[group][name].values, maps[group][name].values, err_msg=name)
        assert simulation.truth[group]["height"].dims == maps[group]["height"].dims
        assert simulation.truth[group]["height"].shape == maps[group]["height"].shape
    truth, polar = simulation.truth["polar"].to_dataset(), maps["polar"].to_dataset()
    # Look i is passed at (turn + (i + ½) 1.8°/360°) of a turn; the mean of its 50 pulses lies half a pulse before.
    number = np.arange(truth.sizes["azimuth"])
    expected = (np.arange(2)[:, None] + (number + 0.5) * 1.8 / 360.0) * scene.turn_duration_s
    np.testing.assert_allclose(truth["time"].values, expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(polar["time"].values, expected, rtol=0, atol=0.51 / scene.radar.prf_hz)
    np.testing.assert_allclose(truth["azimuth"].values, 30.0 + 1.8 * (number + 0.5), rtol=0, atol=1e-9)
    np.testing.assert_array_equal(simulation.truth["ground"]["time"].values, maps["ground"]["time"].values)


def test_a_full_circle_closes() -> None:
    # The first and the last look of a circle lie a turn apart in time; each is the sea at its own.
    scene = wave_scene(radar={"sector_deg": (0.0, 360.0), "range_m": (20.0, 50.0)})
    truth = truth_of(scene)
    assert truth.sizes["azimuth"] == 200
    assert np.isfinite(truth["height"].values).all()
    for look in (0, 199):
        time, bearing = float(truth["time"][0, look]), np.radians(float(truth["azimuth"][look]))
        ground = np.sqrt(truth["range"].values ** 2 - 25.0)
        point = Wave.height(ground * np.sin(bearing), ground * np.cos(bearing), time)
        # The cell's mean against its middle: (k 3 m)²/24 and the slant range's bending, a few per cent of the
        # amplitude.
        np.testing.assert_allclose(truth["height"].values[0, look], point, rtol=0, atol=0.15 * AMPLITUDE)


def test_facet_rcs_follows_the_light() -> None:
    scene = wave_scene()
    facets, rcs = lit_facets(scene)
    np.testing.assert_array_equal(rcs > 0.0, facets.lit[0] | facets.lit[1])
    np.testing.assert_allclose(
        rcs[rcs > 0.0],
        np.broadcast_to(10.0**-3.5 * facets.horizontal_area, rcs.shape)[rcs > 0.0],
        rtol=1e-5,
    )
    np.testing.assert_array_equal(rcs, SeaSurface(scene.scattering, scene.radar, 1.0)(facets, None).rcs)


def test_a_facet_that_one_antenna_sees_gives_a_quarter_of_its_power() -> None:
    # Of the four pairs of transmitter and receiver one is left: 6.02 dB.
    scene = wave_scene()
    facets, rcs = lit_facets(scene)
    both = np.broadcast_to(facets.lit[0] & facets.lit[1], facets.lit.shape)
    one = both.copy()
    one[1] = False
    whole, quarter = (
        polar_truth(replace(facets, lit=light), rcs, Installation(scene.radar), scene.retrieval, 0)["nrcs_db"].values
        for light in (both, one)
    )
    seen = np.isfinite(whole)
    assert seen.any()
    np.testing.assert_allclose((whole - quarter)[seen], 10.0 * np.log10(4.0), atol=1e-3)


# ------------------------------------------------------------------------------------------------ facets and water


def middles_of_edges(triangles: NDArray[np.float64]) -> NDArray[np.float64]:
    """(face, 3, xyz): three points whose mean is a triangle's, of any function of second order."""
    return 0.5 * (triangles + np.roll(triangles, 1, axis=1))


BOWL = 60.0 * np.sin(np.radians(5.0)), 60.0 * np.cos(np.radians(5.0))


def curved_mesh() -> tuple[SurfaceMesh, Callable[[NDArray, NDArray], NDArray]]:
    """A sea that is a bowl about BOWL, unlike along and across the look and askew, by facets 1 m long."""

    def bowl(east: NDArray, north: NDArray) -> NDArray:
        x, y = east - BOWL[0], north - BOWL[1]
        return 0.02 * x**2 + 0.03 * y**2 - 0.025 * x * y

    radar = RadarSettings(noise=False, sector_deg=(0.0, 10.0), range_m=(50.0, 70.0))
    grid = polar_grid(Installation(radar), TracingSettings(facet_m=1.0, columns_per_beam=3), 0)
    east, north = unit_from_azimuth(grid.azimuth)
    heights = bowl(np.multiply.outer(east, grid.ground_range), np.multiply.outer(north, grid.ground_range))
    return surface_mesh(grid, heights, np.zeros((*heights.shape, 3), np.float32)), bowl


def test_the_water_over_a_facet_lies_below_its_plane() -> None:
    """By the mean over each triangle of the bowl itself, which three points give exactly."""
    mesh, bowl = curved_mesh()
    triangles = mesh.trimesh(mesh.sheets()[0]).triangles
    middles = middles_of_edges(triangles)
    expected = np.mean(bowl(middles[..., 0], middles[..., 1]), axis=1)
    facets = trace_horizon(mesh)
    flat = expected - np.mean(bowl(triangles[..., 0], triangles[..., 1]), axis=1)
    below = (truth._mean_heights(facets, slice(0, facets.grid.columns)) - facets.height).ravel()
    # Near the bowl's middle, where it hardly leans: slopes are differenced in frames that turn by half a degree from
    # column to column, which adds a sixtieth of the slope's rise over a facet.
    middle = triangles.mean(axis=1)
    near = np.hypot(middle[:, 0] - BOWL[0], middle[:, 1] - BOWL[1]) < 2.5
    assert near.sum() > 30
    np.testing.assert_allclose(below[near], flat[near], rtol=0.05)  # three of that


def test_two_halves_of_a_facet_have_its_second_moment() -> None:
    """About its middle, along the look."""
    mesh, _ = curved_mesh()
    facets = trace_horizon(mesh)
    halves = truth._halves(mesh.grid)
    away = np.hypot(*np.moveaxis(mesh.trimesh(mesh.sheets()[0]).triangles[..., :2], -1, 0)).reshape(-1, 3)
    middles = 0.5 * (away + np.roll(away, 1, axis=1))
    moment = np.var(middles, axis=1).reshape(facets.height.shape)[0]
    # Away from the antenna, not along the column's middle: the cosine of a third of a degree, and a far corner.
    np.testing.assert_allclose(np.mean(halves**2, axis=1), moment, rtol=1e-2)
    np.testing.assert_allclose(halves.sum(axis=1), 0.0, atol=1e-12)
    # Together they have the facets' whole area and echo: in one cell that holds all bins.
    count, far = facets.height.shape, float(facets.distance.max())
    one, bins = np.ones(count, np.float32), Bins(400, 0.0, 2.0 * far / 400)
    everywhere = Band(np.zeros(1, np.int64), np.ones((1, bins.size)))
    flat = np.zeros(count, np.float32)
    area, lit = facets.horizontal_area / 2.0, np.ones(count, bool)
    parts, level = np.ascontiguousarray(halves.T), np.zeros(count[0])
    surface = Surface(facets.distance, parts, area, level, flat.astype(float), flat, flat, lit, one, one)
    cells, heard = np.empty((count[0], 1, QUANTITIES)), np.empty((count[0], 1, 2))
    fill_cells(0, count[0], surface, bins, everywhere, everywhere, cells, heard)
    assert cells[..., AREA].sum() == pytest.approx(count[0] * facets.horizontal_area.sum(), rel=1e-12)
    assert cells[..., ECHO].sum() == pytest.approx(facets.height.size)
