"""The sea on file: laws that its fields keep, whose sea it is, what the radar sees of it, and what is refused."""

from __future__ import annotations

import signal
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal

from seamap_rt.cli import main
from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.dataset import check
from seamap_rt.errors import InputError, NoBackend
from seamap_rt.io.seafile import ROUNDING
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.mesh.surface import sea_on_grid
from seamap_rt.products import PRODUCTS, SeaProducts, write_sea, writing
from seamap_rt.products.asked import square, times_of
from seamap_rt.products.camera import Camera, facets_under
from seamap_rt.products.spectrum import directional_spectrum
from seamap_rt.report.sea_statistics import asked_height, chance_of_height
from seamap_rt.scene import Scene, load_scene
from seamap_rt.sea import Sea, realize
from seamap_rt.simulation import Simulator
from seamap_rt.tracing import tracer

SIDE, SPACING, STEP = 60.0, 0.25, 0.05  # m, m, s
DRAW, DRAW_FROM_MAST = writing._draw, writing._draw_from_mast

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


def scene(**keys: Any) -> Scene:
    """A small wind sea on a current; the radar looks at a sector of it that spans north."""
    small: dict[str, Any] = {
        "sea__extent_m": 128.0,
        "sea__resolution_m": 1.6,
        "sea__current_m_s": 0.8,
        "sea__current_toward_deg": 20.0,
        "sea__waves__0__significant_wave_height_m": 0.9,
        "sea__waves__0__peak_period_s": 4.0,
        "sea__waves__0__wave_from_deg": 300.0,
        "radar__range_m": [12.0, 30.0],
        "radar__sector_deg": [250.0, 400.0],
        "radar__height_m": 3.0,
        "tracing__tracer": "horizon",
    }
    return load_scene("tiny", overrides={key.replace("__", "."): value for key, value in (small | keys).items()})


@pytest.fixture(scope="module", autouse=True)
def without_pictures() -> Iterator[None]:
    """Pictures are tested on their own: most of the time would go into them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(writing, "_draw", lambda *_: ())
        patch.setattr(writing, "_draw_from_mast", lambda *_: ())
        yield


def written(folder: Path, made: Scene, **options: Any) -> tuple[xr.Dataset, SeaProducts]:
    """The fields on file, in memory, time in seconds."""
    result = write_sea(made, folder, **options)
    with xr.open_dataset(folder / "sea.nc", decode_times=False) as fields:
        return fields.load(), result


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
    places = square(made, 128.0, 4.0)
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
    assert asked_height(result.sea) == pytest.approx(0.9, rel=1e-6)


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
    return Camera(made, sea or simulator.sea, tracer("horizon", made.radar, made.scattering), places, simulator.surface)


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
        made = scene(radar__rotation_rpm=rpm)
        seen.append(camera_of(made, square(made)).moment(3.0))
    xr.testing.assert_equal(seen[0], seen[1])


def test_constant_cross_section_is_read_back_where_it_is_lit(tmp_path: Path) -> None:
    """Per horizontal area, every lit facet has the given level, whatever its slope; rounding is 2⁻⁶ dB."""
    made = scene(scattering__nrcs="constant", scattering__nrcs_db=-31.0)
    fields, _ = written(tmp_path, made, times="0", side=SIDE, spacing=0.5)
    nrcs = fields["nrcs_db"].values
    assert_allclose(nrcs[np.isfinite(nrcs)], -31.0, atol=0.51 * ROUNDING["dB"])


def test_places_find_their_facets() -> None:
    """The triangle that a place lies in, found among all triangles of the mesh by the signs of three areas."""
    made = scene(radar__sector_deg=[350.0, 370.0], radar__range_m=[5.0, 20.0])
    sea = realize(made.sea, 1)
    grid = polar_grid(made.radar, made.tracing, 0)
    mesh = surface_mesh(grid, *sea_on_grid(sea, grid))
    (sheet,) = mesh.sheets()
    surface = mesh.trimesh(sheet)
    vertices, faces = surface.vertices, surface.faces
    corners = vertices[faces][..., :2]
    random = np.random.default_rng(4)
    azimuth, ground = random.uniform(350.5, 369.5, 300), random.uniform(5.0, 19.0, 300)
    east, north = unit_from_azimuth(azimuth)
    x, y = ground * east, ground * north
    inside, column, facet = facets_under(grid, made.radar, x, y)
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

    places = square(made, 50.0, 1.0)
    dry = camera_of(made, places).moment(0.0)["visible"].values
    wet = camera_of(made, places, Spiked(flat.trains, flat.surface, flat.resolved)).moment(0.0)["visible"].values
    assert_array_equal(np.unique(dry), [-1, 2])
    assert_array_equal(np.unique(wet), [-1, 0])


# ---------------------------------------------------------------------------------------------------- the spectrum


def mixed() -> Scene:
    waves = [
        {"spectrum": "jonswap", "significant_wave_height_m": 0.9, "peak_period_s": 4.0, "wave_from_deg": 300.0},
        {"spectrum": "flat"},
        {
            "spectrum": "jonswap",
            "significant_wave_height_m": 0.5,
            "peak_period_s": 3.0,
            "wave_from_deg": 30.0,
            "spreading": "long_crested",
        },
        {"spectrum": "sinusoid", "height_m": 0.3, "wavelength_m": 20.0, "wave_from_deg": 200.0},
    ]
    return scene(sea__waves=waves, sea__depth_m=15.0)


def test_spectrum_holds_each_systems_height_and_direction() -> None:
    made = mixed()
    spectrum = directional_spectrum(made, Simulator(made).sea)
    assert_array_equal(spectrum["system"].values, [0, 2, 3])
    assert_array_equal(spectrum["system_kind"].values, [0, 1, 2])
    assert_allclose(spectrum["system_direction"].values, [300.0, 30.0, 200.0], atol=1e-9)
    assert_allclose(spectrum["system_height"].values, [0.9, 0.5, 0.3], rtol=1e-6)
    frequency = spectrum["frequency"].values
    of_systems = spectrum["system_spectrum"].values
    # 240 points by the trapezoid rule, and up to six times the peak: 1 − 0.1 % of the height.
    heights = 4.0 * np.sqrt(np.trapezoid(of_systems, frequency, axis=1))
    assert_allclose(heights, [0.9, 0.5, 0.0], rtol=3e-3)
    assert_allclose(1.0 / frequency[of_systems[:2].argmax(axis=1)], [4.0, 3.0], rtol=0.01)  # half a step
    assert_allclose(spectrum["frequency_spectrum"].values, of_systems.sum(axis=0))
    plane = spectrum["directional_spectrum"].values
    # Over the circle the sum is exact but for the spreading's harmonics beyond 90: none of cos^20(θ/2) has any.
    assert_allclose(2.0 * plane.sum(axis=1), of_systems[0], rtol=1e-9)
    assert spectrum["direction"].values[plane.sum(axis=0).argmax()] == 300.0


def test_file_of_a_mixed_and_of_no_sea_can_be_written(tmp_path: Path) -> None:
    for name, made in (("mixed", mixed()), ("none", scene(sea__waves=[]))):
        fields, result = written(tmp_path / name, made, times="0", side=40.0, spacing=1.0)
        assert np.isfinite(fields["sea_surface_height"].values).all()
        assert "significant height" in (tmp_path / name / "statistics.txt").read_text()
        assert "nan" not in (tmp_path / name / "statistics.txt").read_text()
        with xr.open_dataset(tmp_path / name / "sea.nc", group="spectrum") as spectrum:
            assert spectrum.sizes["system"] == len([1 for each in made.sea.waves if each.spectrum != "flat"])
        assert result.headline().startswith("Hs ")


# ------------------------------------------------------------------------------------------------ what is refused


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0:5:0.5", np.arange(11) * 0.5),
        ("0:1:0.3", [0.0, 0.3, 0.6, 0.9]),
        ("0:0.3:0.1", [0.0, 0.1, 0.2, 0.3]),
        ("2:2:1", [2.0]),
        ("1,2.5,4", [1.0, 2.5, 4.0]),
        ("3", [3.0]),
    ],
)
def test_times_are_read(text: str, expected: Any) -> None:
    assert_allclose(times_of(text), expected, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is not times"),
        ("now", "is not times"),
        ("1,,2", "is not times"),
        ("0:5", "three numbers"),
        ("0:1:2:3", "three numbers"),
        ("0,1:2", "three numbers"),
        ("5:0:1", "STOP at least START"),
        ("0:5:0", "STEP must be greater than 0"),
        ("0:5:-1", "STEP must be greater than 0"),
        ("0:1e9:0.1", "1e[+]10 times"),
        ("1,0", "later than the one before"),
        ("1,1", "later than the one before"),
        ("nan", "finite"),
        ("0:inf:1", "finite"),
    ],
)
def test_times_that_are_none_are_refused(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        times_of(text)


def test_default_square_is_the_range_circle_at_what_is_resolved() -> None:
    places = square(scene())
    assert_allclose(places[1] - places[0], 1.6, rtol=0.02)  # a whole number of points fills the side
    assert_allclose(places[-1] - places[0] + places[1] - places[0], 60.0)
    assert_allclose(places, -places[::-1], atol=1e-12)
    wide = load_scene("choppy_sea")
    assert_allclose(np.diff(square(wide)), 800.0 / 512.0)
    assert square(load_scene("long_crested_swell", overrides={"sea.extent_m": 200.0}))[-1] < 100.0


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """`seamap-rt sea` in this process, in an empty folder; SIGTERM is given back as it was."""
    monkeypatch.chdir(tmp_path)
    before = signal.getsignal(signal.SIGTERM)
    Path("small.toml").write_text(scene().to_toml())

    def run(*arguments: Any) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as end:
            main(["sea", "small.toml", *(str(argument) for argument in arguments)])
        said = capsys.readouterr()
        assert isinstance(end.value.code, int)
        return end.value.code, said.out, said.err

    yield run
    signal.signal(signal.SIGTERM, before)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--times", "3:1:1"), "--times = '3:1:1'"),
        (("--times", "0:5:0"), "STEP must be greater than 0"),
        (("--side", "0"), "--side = 0"),
        (("--side", "nan"), "--side = nan"),
        (("--side", "129"), "at most 128, sea.extent_m"),
        (("--spacing", "61"), "half of --side"),
        (("--spacing", "-1"), "--spacing = -1"),
        (("--spacing", "0.01"), "GB of memory"),
        (("--spacing", "0.02", "--times", "0:500:0.1"), "GB"),
        (("--side", "wide"), "wide"),
        (("--set", "sea.wavs=1"), "sea.wavs"),
        (("--set", "sea.extent_m"), "KEY=VALUE"),
    ],
)
def test_bad_input_is_one_line(call: Any, options: tuple[str, ...], words: str) -> None:
    code, out, err = call("--out", "results", *options)
    assert (code, out) == (2, "")
    assert err.startswith("seamap-rt: ")
    assert err.count("\n") == 1
    assert words in err
    assert not list(Path("results").glob("*"))


def test_command_writes_everything_and_says_so(call: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the pictures, but for the one from the mast, which here finds no backend: that is a line, not an end."""

    def refused(*_: Any, **__: Any) -> None:
        raise NoBackend("no LLVM was found; install one")

    monkeypatch.setattr(writing, "_draw", DRAW)
    monkeypatch.setattr(writing, "_draw_from_mast", DRAW_FROM_MAST)
    monkeypatch.setattr("seamap_rt.tracing.picture.render_from_mast", refused)
    options = ("--out", "results", "--times", "0,0.4,1.2", "--spacing", "1", "--seed", "5")
    code, out, err = call(*options)
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == "from_mast.png is left out: no LLVM was found; install one"
    assert lines[1].startswith("Hs 0.")
    assert "0.90 m asked for" in lines[1]
    assert lines[2].startswith("results/sea.nc (with statistics.txt, ")
    left = {path.name for path in Path("results").iterdir()}
    assert left == set(PRODUCTS) - {"from_mast.png"}
    with xr.open_dataset("results/sea.nc", decode_times=False) as fields:
        assert_allclose(fields["time"].values, [0.0, 0.4, 1.2])
        assert fields.attrs["seed"] == 5
    assert call(*options)[0] == 2  # another run's results
    code, out, err = call("--out", "results", "--times", "0", "--spacing", "2", "--overwrite")
    assert code == 0
    assert "sea.gif is left out: it needs two times" in out
    assert not Path("results/sea.gif").exists()


def test_a_sea_of_which_nothing_is_resolved_can_be_written(tmp_path: Path) -> None:
    ripples = {"spectrum": "jonswap", "significant_wave_height_m": 0.1, "peak_period_s": 0.5}
    file, made = written(tmp_path, scene(sea__waves=[ripples], sea__resolution_m=15.0))
    assert not file["sea_surface_height"].values.any()
    assert_allclose(file.attrs["sea_significant_wave_height"], 0.1, rtol=1e-3)
    assert "0.10 m asked for" in made.headline()
