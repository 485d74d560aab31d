"""The sea on file: laws that its fields keep, whose sea it is, and what the radar sees of it."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sea_products
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from sea_products import SIDE, SPACING, STEP, scene, written

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.dataset import check
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.mesh.surface import sea_on_grid
from seamap_rt.products.camera import Camera, locate_facets
from seamap_rt.products.sampling import square_points
from seamap_rt.products.statistics import chance_of_height, requested_height
from seamap_rt.products.writing import ROUNDING, SeaProducts, write_sea
from seamap_rt.radar.installation import Installation
from seamap_rt.scene import Scene
from seamap_rt.sea import Sea, realize
from seamap_rt.simulation import Simulator
from seamap_rt.tracing import tracer

without_pictures = sea_products.without_pictures  # a fixture of every test

# Name, units and CF standard name (table 85) of what is on file, typed from the conventions and not from the schema.
CF = {
    "time": ("seconds since 2000-01-01 00:00:00", "time"),
    "x": ("m", "projection_x_coordinate"),
    "y": ("m", "projection_y_coordinate"),
    "sea_surface_height": ("m", "sea_surface_height_above_mean_sea_level"),
    "slope_x": ("1", None),
    "slope_y": ("1", None),
    "velocity_x": ("m s-1", "sea_water_x_velocity"),
    "velocity_y": ("m s-1", "sea_water_y_velocity"),
    "velocity_z": ("m s-1", "upward_sea_water_velocity"),
    "nrcs_db": ("dB", None),
    "visible": ("1", None),
}
CF_SPECTRUM = {
    "frequency": ("Hz", "wave_frequency"),
    "direction": ("degree", "sea_surface_wave_from_direction"),
    "system": ("1", None),
    "directional_spectrum": ("m2 s degree-1", "sea_surface_wave_directional_variance_spectral_density"),
    "frequency_spectrum": ("m2 s", "sea_surface_wave_variance_spectral_density"),
    "system_spectrum": ("m2 s", "sea_surface_wave_variance_spectral_density"),
    "system_kind": ("1", None),
    "system_height": ("m", None),
    "system_period": ("s", "sea_surface_wave_period_at_variance_spectral_density_maximum"),
    "system_direction": ("degree", "sea_surface_wave_from_direction"),
}


Filed = tuple[xr.Dataset, SeaProducts, Scene]


@pytest.fixture(scope="module", params=["linear", "choppy"])
def moving(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Filed:
    """Three times, close enough to see the sea move."""
    made = scene(sea__model=request.param)
    folder = tmp_path_factory.mktemp(request.param)
    return *written(folder, made, times=f"1:{1 + 2 * STEP}:{STEP}", side=SIDE, spacing=SPACING), made


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values, dtype=np.float64))))


# ------------------------------------------------------------------------------------------------ laws of the fields


def test_slopes_are_differences_of_the_height(moving: Filed) -> None:
    """Fourth-order differences over 0.25 m. Shortest waves, k = 1.96 rad/m: wrong by (k dx)⁴/30 = 0.2 % of their slope,
    which sharpened crests make somewhat more; rounding of the height adds 0.29 × 2⁻¹³ m × 0.95/dx = 1.3e-4.
    """
    fields, _, _ = moving
    height = fields["sea_surface_height"].values.astype(np.float64)
    for name, axis in (("slope_x", 2), ("slope_y", 1)):
        step = [np.roll(height, -shift, axis) for shift in (-2, -1, 1, 2)]
        slope = (step[0] - 8.0 * step[1] + 8.0 * step[2] - step[3]) / (12.0 * SPACING)
        inside = (slice(None), slice(2, -2), slice(2, -2))
        error = rms((slope - fields[name].values)[inside])
        assert rms(fields[name].values) > 0.03
        assert error < 4e-4


def test_water_stays_at_the_surface(moving: Filed) -> None:
    """∂η/∂t = w − u·∇η: u is the water's velocity of choppy waves, the current alone of linear ones.

    Central differences over ±0.05 s: the fastest waves, 4.4 rad/s plus 1.6 of the current, are wrong by (ω dt)²/6 =
    1.5 %, most by far less; rounding of the height adds 0.29 × 2⁻¹³ m × √2/0.1 s = 5e-4 m/s.
    """
    fields, _, made = moving
    height = fields["sea_surface_height"].values.astype(np.float64)
    rate = (height[2] - height[0]) / (2.0 * STEP)
    now = {name: fields[name].values[1].astype(np.float64) for name in fields.data_vars}
    flow = (now["velocity_x"], now["velocity_y"])
    if made.sea.model == "linear":
        flow = tuple(float(made.sea.current_m_s * part) for part in unit_from_azimuth(made.sea.current_toward_deg))
    expected = now["velocity_z"] - flow[0] * now["slope_x"] - flow[1] * now["slope_y"]
    assert rms(rate) > 0.3
    assert rms(rate - expected) < 0.015 * rms(rate)


def test_whole_patch_has_the_height_that_was_asked_for(tmp_path: Path) -> None:
    """Within 3.5 standard deviations of chance, which is itself measured in the next test."""
    for number in range(3):
        made = scene(seed=number)
        fields, result = written(tmp_path / str(number), made, times="0", side=128.0, spacing=0.8)
        height = 4.0 * float(fields["sea_surface_height"].values.std())
        chance = chance_of_height(result.sea)
        assert 0.0 < chance < 0.1
        assert abs(height - 4.0 * result.sea.resolved.elevation_std) < 3.5 * chance
        assert_allclose(height, result.drawn.significant_height, rtol=1e-4)  # rounding to 0.12 mm
        # Waves of a periodic patch have no mean; a thousandth of 0.1 mm is what rounding leaves.
        assert abs(float(fields["sea_surface_height"].values.mean(dtype=np.float64))) < 1e-5


def test_chance_of_the_height_is_that_of_many_realisations() -> None:
    """50 realisations tell a standard deviation to 10 %, three of which are 30 %."""
    made = scene(sea__resolution_m=4.0)
    places = square_points(made, 128.0, 4.0)
    heights = [4.0 * realize(made.sea, seed).elevation(places, places[:, None], 0.0).std() for seed in range(50)]
    assert_allclose(np.std(heights), chance_of_height(realize(made.sea, 0)), rtol=0.3)


@pytest.mark.parametrize("from_deg", [300.0, 40.0])
def test_long_crested_waves_go_where_they_should(tmp_path: Path, from_deg: float) -> None:
    """−⟨∂η/∂t ∇η⟩ points where waves go, and the slopes lie along it: a mirrored or turned map would show.

    All waves of the system are parallel; the tolerance is rounding (1e-4 of the slopes, 3e-3 of ∂η/∂t).
    """
    made = scene(sea__waves__0__spreading="long_crested", sea__waves__0__wave_from_deg=from_deg, sea__current_m_s=0.0)
    fields, _ = written(tmp_path, made, times="0,0.05", side=80.0, spacing=0.5)
    height = fields["sea_surface_height"].values.astype(np.float64)
    rate = (height[1] - height[0]) / 0.05
    east, north = (-float(np.mean(rate * fields[name].values.mean(axis=0))) for name in ("slope_x", "slope_y"))
    toward = np.degrees(np.arctan2(east, north)) % 360.0
    assert_allclose(toward, (from_deg + 180.0) % 360.0, atol=0.2)
    # The strongest wave of the map itself, to the FFT's step: 2π/80 m beside 0.25 rad/m is 18°, its half 9°.
    power = np.abs(np.fft.fft2(height[0]))
    row, column = np.unravel_index(np.argmax(power), power.shape)
    k = 2.0 * np.pi * np.fft.fftfreq(height.shape[1], 0.5)
    along = np.degrees(np.arctan2(k[column], k[row]))
    assert abs((along - toward + 90.0) % 180.0 - 90.0) < 15.0


def test_moments_are_those_of_the_runs_own_sea(moving: Filed) -> None:
    """The branch of the seed that `run` draws from; heights are rounded by half of 2⁻¹³ m at most."""
    fields, result, made = moving
    run = Simulator(made).sea
    other = realize(made.sea, made.seed)
    x, y = fields["x"].values[::7], fields["y"].values[::7, None]
    for number, t in enumerate(fields["time"].values):
        found = fields["sea_surface_height"].values[number, ::7, ::7]
        assert_allclose(found, run.elevation(x, y, float(t)), atol=0.51 * ROUNDING["m"])
        assert rms(found - other.elevation(x, y, float(t))) > 0.1
    assert requested_height(result.sea) == pytest.approx(0.9, rel=1e-6)


# ------------------------------------------------------------------------------------------------------- the file


def test_opens_without_warnings_and_says_what_it_is(moving: Filed) -> None:
    fields, result, made = moving
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with xr.open_dataset(result.folder / "sea.nc") as dataset:
            dated = dataset["time"].values
        with xr.open_dataset(result.folder / "sea.nc", group="spectrum") as dataset:
            spectrum = dataset.load()
        with xr.open_datatree(result.folder / "sea.nc") as tree:
            assert tree.groups == ("/", "/spectrum")
    assert_allclose((dated - np.datetime64("2000-01-01")) / np.timedelta64(1, "s"), fields["time"].values, atol=1e-8)
    check("sea", fields)
    check("sea/spectrum", spectrum)
    for dataset, table in ((fields, CF), (spectrum, CF_SPECTRUM)):
        assert set(dataset.variables) == set(table)
        assert dataset.attrs["Conventions"] == "CF-1.11"
        for name, (units, standard_name) in table.items():
            assert dataset[name].attrs["units"] == units
            assert dataset[name].attrs.get("standard_name") == standard_name
    for dataset, name in ((fields, "visible"), (spectrum, "system_kind")):
        attributes = dataset[name].attrs
        assert attributes["flag_values"].dtype == dataset[name].dtype  # CF: the type of the variable
        assert len(attributes["flag_meanings"].split()) == attributes["flag_values"].size
        assert set(np.unique(dataset[name].values)) <= set(attributes["flag_values"])
    for name, value in result.sea.spectrum.attrs.items():
        assert fields.attrs[f"sea_{name}"] == value
    assert fields.attrs["scene"] == made.to_toml()


def camera_of(made: Scene, places: np.ndarray, sea: Sea | None = None) -> Camera:
    """The camera of a scene, by the horizon tracer, on the run's own sea unless given another."""
    simulator = Simulator(made)
    return Camera(
        made,
        sea or simulator.sea,
        tracer("horizon", made.radar, made.scattering, made.tracing.diffraction),
        places,
        simulator.surface,
    )


def test_what_is_read_is_what_was_seen(moving: Filed) -> None:
    """To the rounding that the file states; the fields are packed and stored as single precision."""
    fields, _, made = moving
    camera = camera_of(made, fields["x"].values)
    seen = camera.moment(float(fields["time"].values[1]))
    for name in fields.data_vars:
        found, expected = fields[name].values[1], seen[name].values[0]
        assert found.dtype == expected.dtype
        if found.dtype.kind != "f":
            assert_array_equal(found, expected)
            continue
        step = ROUNDING[fields[name].attrs["units"]]
        assert f"{step:.3g}" in fields[name].attrs["comment"]
        assert_allclose(found, expected, atol=0.51 * step, rtol=1e-6)
        lit = np.isfinite(found)
        assert_allclose(found[lit] / step, np.round(found[lit] / step), atol=1e-3)


def test_interrupted_it_leaves_whole_times(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    taken = Camera.moment

    def interrupted(camera: Camera, t: float) -> xr.Dataset:
        if t > 1.5:
            raise KeyboardInterrupt
        return taken(camera, t)

    monkeypatch.setattr(Camera, "moment", interrupted)
    with pytest.raises(KeyboardInterrupt, match="2 of 4 times are complete"):
        write_sea(scene(), tmp_path / "cut", times="0:3:1", side=30.0, spacing=1.0)
    assert [path.name for path in (tmp_path / "cut").iterdir()] == ["sea.nc"]
    with xr.open_dataset(tmp_path / "cut" / "sea.nc", decode_times=False) as left:
        assert_array_equal(left["time"].values, [0.0, 1.0])
        assert np.isfinite(left["sea_surface_height"].values).all()
    with pytest.raises(KeyboardInterrupt, match="no results"):
        write_sea(scene(), tmp_path / "none", times="2,3", side=30.0, spacing=1.0)
    assert not list((tmp_path / "none").iterdir())


# --------------------------------------------------------------------------------------------- what the radar sees


def test_dark_and_outside_have_no_cross_section_and_lit_has_one(moving: Filed) -> None:
    fields, _, made = moving
    visible, nrcs = fields["visible"].values, fields["nrcs_db"].values
    assert_array_equal(np.isfinite(nrcs), visible > 0)
    x, y = np.meshgrid(fields["x"].values, fields["y"].values)
    slant, azimuth = np.hypot(np.hypot(x, y), made.radar.height_m), np.degrees(np.arctan2(x, y))
    looked = (slant >= 12.0) & (slant <= 30.0) & ((azimuth >= -110.0) & (azimuth <= 40.0))
    assert_array_equal(visible >= 0, np.broadcast_to(looked, visible.shape))
    for state in (-1, 0, 2):
        assert np.mean(visible == state) > 0.01


def test_snapshot_does_not_know_how_fast_the_antenna_turns() -> None:
    """The mesh of a run rolls with the beam; that of a moment has one time."""
    seen = []
    for rpm in (60.0, 24.0):
        made = scene(radar__rotation_rpm=rpm, scattering__sea_spikes=False)
        seen.append(camera_of(made, square_points(made)).moment(3.0))
    xr.testing.assert_equal(seen[0], seen[1])


def test_constant_cross_section_is_read_back_where_it_is_lit(tmp_path: Path) -> None:
    """Per horizontal area, every lit facet has the given level, whatever its slope; rounding is 2⁻⁶ dB."""
    made = scene(scattering__nrcs="constant", scattering__nrcs_db=-31.0, tracing__diffraction="none")
    fields, _ = written(tmp_path, made, times="0", side=SIDE, spacing=0.5)
    nrcs = fields["nrcs_db"].values
    assert_allclose(nrcs[np.isfinite(nrcs)], -31.0, atol=0.51 * ROUNDING["dB"])


def test_places_find_their_facets() -> None:
    """The triangle that a place lies in, found among all triangles of the mesh by the signs of three areas."""
    made = scene(radar__sector_deg=[350.0, 370.0], radar__range_m=[5.0, 20.0])
    sea = realize(made.sea, 1)
    grid = polar_grid(Installation(made.radar), made.tracing, 0)
    mesh = surface_mesh(grid, *sea_on_grid(sea, grid))
    (sheet,) = mesh.sheets()
    surface = mesh.trimesh(sheet)
    vertices, faces = surface.vertices, surface.faces
    corners = vertices[faces][..., :2]
    random = np.random.default_rng(4)
    azimuth, ground = random.uniform(350.5, 369.5, 300), random.uniform(5.0, 19.0, 300)
    east, north = unit_from_azimuth(azimuth)
    x, y = ground * east, ground * north
    inside, column, facet = locate_facets(grid, made.radar, x, y)
    assert inside.all()
    number = column * 2 * (grid.ground_range.size - 1) + facet
    for place, found in zip(np.stack((x, y), axis=1), number, strict=True):
        edge = np.roll(corners, -1, axis=1) - corners
        away = place - corners
        turns = edge[..., 0] * away[..., 1] - edge[..., 1] * away[..., 0]
        assert found in np.flatnonzero((turns >= -1e-9).all(axis=1))


def test_drowned_antennas_see_nothing() -> None:
    """A spike of water, too narrow to throw a shadow, covers both antennas: the simulator would refuse it at time 0."""
    made = scene(sea__waves=[], radar__height_m=1.0)
    flat = realize(made.sea, 1)

    class Spiked(Sea):
        def elevation_and_velocity(self, x: Any, y: Any, t: Any) -> tuple[np.ndarray, np.ndarray]:
            elevation, velocity = super().elevation_and_velocity(x, y, t)
            return elevation + 2.0 * np.exp(-((x**2 + y**2) / 0.6**2)), velocity

    places = square_points(made, 50.0, 1.0)
    dry = camera_of(made, places).moment(0.0)["visible"].values
    wet = camera_of(made, places, Spiked(flat.trains, flat.surface, flat.resolved)).moment(0.0)["visible"].values
    assert_array_equal(np.unique(dry), [-1, 2])
    assert_array_equal(np.unique(wet), [-1, 0])
