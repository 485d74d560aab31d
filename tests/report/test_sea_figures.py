"""Pictures of the sea: the right way up, named by where waves come from, in real time; its statistics, checked."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from numpy.testing import assert_allclose
from PIL import Image

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.dataset import build
from seamap_rt.products.statistics import (
    Moments,
    expected_kurtosis,
    expected_slope_variance,
    requested_height,
    statistics_table,
)
from seamap_rt.products.writing import directional_spectrum
from seamap_rt.report import sea_figures, spectrum_figures, style
from seamap_rt.scene import Scene, load_scene
from seamap_rt.simulation import Simulator

K, OMEGA, AMPLITUDE = 2.0 * np.pi / 25.0, 1.57, 0.8  # rad/m, rad/s, m


def scene(from_deg: float = 300.0, **keys: Any) -> Scene:
    small: dict[str, Any] = {
        "sea__extent_m": 128.0,
        "sea__resolution_m": 1.6,
        "sea__waves__0__peak_period_s": 4.0,
        "sea__waves__0__significant_wave_height_m": 0.9,
        "sea__waves__0__wave_from_deg": from_deg,
        "radar__range_m": [12.0, 30.0],
        "tracing__tracer": "horizon",
    }
    return load_scene("tiny", overrides={key.replace("__", "."): value for key, value in (small | keys).items()})


def swell(times: Any, from_deg: float, half: float = 40.0) -> xr.Dataset:
    """A made-up regular wave on file; south of the antenna all is dark, beyond 35 m nothing is looked at."""
    places = np.arange(-half, half + 0.5, 1.0)
    t, y, x = np.meshgrid(times, places, places, indexing="ij")
    east, north = (float(part) for part in unit_from_azimuth(from_deg + 180.0))
    phase = K * (east * x + north * y) - OMEGA * t
    height, rise = AMPLITUDE * np.cos(phase), AMPLITUDE * np.sin(phase)
    visible = np.where(np.hypot(x, y) > 35.0, -1, np.where(y < 0.0, 0, 2))
    values = {
        "sea_surface_height": height,
        "slope_x": -K * east * rise,
        "slope_y": -K * north * rise,
        "velocity_x": OMEGA * east * height,
        "velocity_y": OMEGA * north * height,
        "velocity_z": OMEGA * rise,
        "nrcs_db": np.where(visible > 0, -30.0 - 0.1 * x, np.nan),
        "visible": visible,
    }
    return build("sea", values, {"time": times, "y": places, "x": places})


def picture(figure: Figure) -> Image.Image:
    return Image.open(io.BytesIO(style.png(figure)))


# ----------------------------------------------------------------------------------------------------- the spectrum


@pytest.mark.parametrize("from_deg", [300.0, 75.0])
def test_spectrum_is_brightest_where_waves_come_from(from_deg: float) -> None:
    """On the page, clockwise from its upper edge; a cell is 2° wide."""
    made = scene(from_deg)
    sea = Simulator(made).sea
    figure = spectrum_figures.directional_spectrum(made, directional_spectrum(made, sea), sea.resolved)
    rose = figure.axes[0]
    (mesh,) = (each for each in rose.collections if isinstance(each, QuadMesh))
    values = np.asarray(mesh.get_array())
    row, column = np.unravel_index(values.argmax(), values.shape)
    corners = np.asarray(mesh.get_coordinates())[row : row + 2, column : column + 2].mean(axis=(0, 1))
    figure.canvas.draw()
    on_page = rose.transData.transform(corners) - rose.transData.transform((0.0, 0.0))
    assert_allclose(np.degrees(np.arctan2(*on_page)) % 360.0, from_deg, atol=1.5)
    assert_allclose(corners[1], 0.25, rtol=0.03)  # Hz; frequencies step by 1.4 %
    (marked,) = (line for line in rose.lines if np.size(line.get_xdata()) == 1)
    assert_allclose(np.degrees(np.asarray(marked.get_xdata(), dtype=float)), from_deg)
    assert_allclose(np.asarray(marked.get_ydata(), dtype=float), 0.25, rtol=0.01)


def test_spectrum_marks_what_is_resolved() -> None:
    made = scene()
    sea = Simulator(made).sea
    figure = spectrum_figures.directional_spectrum(made, directional_spectrum(made, sea), sea.resolved)
    dashed = [line for axes in figure.axes[1:] for line in axes.lines if line.get_linestyle() == "--"]
    limit = np.sqrt(9.81 * np.pi / 1.6) / (2.0 * np.pi)
    assert_allclose(np.asarray(dashed[0].get_xdata(), dtype=float), limit, rtol=1e-3)  # the surface tension is 3e-5
    said = " ".join(" ".join(text.get_text() for text in figure.texts).split())
    assert f"{sea.resolved.variance_share:.2%} of the variance" in said
    assert f"{sea.resolved.mean_square_slope_share:.0%} of these spectra's mean square slope" in said


def test_every_kind_of_sea_is_drawn() -> None:
    swells = {"spectrum": "jonswap", "significant_wave_height_m": 1.0, "peak_period_s": 5.0}
    regular = {"spectrum": "sinusoid", "height_m": 0.3, "wavelength_m": 20.0, "wave_from_deg": 200.0}
    for waves in ([], [regular], [swells | {"spreading": "long_crested"}], [swells, regular, {"spectrum": "flat"}]):
        made = scene(sea__waves=waves)
        sea = Simulator(made).sea
        spectrum = directional_spectrum(made, sea)
        assert picture(spectrum_figures.directional_spectrum(made, spectrum, sea.resolved)).size[0] == 936
        moment = swell([0.0], 300.0) if waves else 0.0 * swell([0.0], 300.0)
        assert picture(sea_figures.sea_surface(made, moment.isel(time=0))).size[0] == 936


# ------------------------------------------------------------------------------------------------------ the surface


def test_maps_have_north_up_and_shadows_grey() -> None:
    """Read off the picture itself: the wave's crest through the antenna, the dark south, the white corners."""
    figure = sea_figures.sea_surface(scene(0.0), swell([0.0], 0.0).isel(time=0))
    page = np.asarray(picture(figure).convert("RGB")).astype(float)
    high = page.shape[0]

    def colour(number: int, x: float, y: float) -> np.ndarray:
        axes = figure.axes[number]
        assert axes.get_aspect() == 1.0
        column, row = (axes.transData.transform((x, y)) * style.DPI / figure.dpi).astype(int)
        return page[high - row - 2 : high - row + 3, column - 2 : column + 3].mean(axis=(0, 1))

    figure.canvas.draw()
    for y, red in ((25.0, True), (12.5, False), (-12.5, False), (-25.0, True)):
        assert (colour(0, 5.0, y)[0] > colour(0, 5.0, y)[2]) == red
    # The wave comes from the north: of two faces the one that falls to the north is lit.
    assert colour(0, 5.0, 25.0 + 6.25).sum() > colour(0, 5.0, 25.0 - 6.25).sum()
    cross_section = [axes for axes in figure.axes if "cross section" in axes.get_title(loc="left")]
    number = figure.axes.index(cross_section[0])
    dark, bright = colour(number, 5.0, -20.0), colour(number, 5.0, 20.0)
    assert np.ptp(dark) < 3.0
    assert 120.0 < dark.mean() < 170.0
    assert np.ptp(bright) > 30.0
    assert_allclose(colour(number, 38.0, 38.0), 255.0)
    west, east = colour(number, -25.0, 10.0), colour(number, 25.0, 10.0)
    assert west.sum() > east.sum()  # made stronger in the west


def test_section_runs_along_the_waves_and_says_how_tall_it_is_drawn() -> None:
    figure = sea_figures.sea_surface(scene(300.0), swell([0.0], 300.0).isel(time=0))
    (section,) = (axes for axes in figure.axes if "Section" in axes.get_title(loc="left"))
    along = np.asarray(section.lines[0].get_xdata(), dtype=float)
    height = np.asarray(section.lines[0].get_ydata(), dtype=float)
    # Linear interpolation over 1 m: wrong by (K dx)²/8 = 0.8 % of the amplitude along each axis.
    assert_allclose(height, AMPLITUDE * np.cos(K * along), atol=0.02 * AMPLITUDE)
    box = section.get_window_extent()
    (left, right), (low, top) = section.get_xlim(), section.get_ylim()
    times = (box.height / (top - low)) / (box.width / (right - left))
    assert f"{times:.2g} times too high" in section.get_title(loc="left")
    assert "120°" in section.get_xlabel()


# -------------------------------------------------------------------------------------------------------- animation


@pytest.mark.parametrize("times", [np.arange(4) * 0.5, np.array([0.0, 0.2, 1.0])])
def test_animation_plays_in_real_time_and_waves_go_where_they_should(times: np.ndarray) -> None:
    """The crest that starts at the antenna is followed on its way to the east, pixel by pixel."""
    moments = swell(times, 270.0)
    film = Image.open(io.BytesIO(sea_figures.animation(scene(270.0), moments)))
    assert film.info["loop"] == 0
    found, waits = [], []
    for number in range(getattr(film, "n_frames", 1)):
        film.seek(number)
        waits.append(film.info["duration"] / 1e3)
        page = np.asarray(film.convert("RGB")).astype(float)
        line = page[int(0.65 * page.shape[0])]  # south of the middle, where no symbol is
        redness = line[:, 0] - line[:, 2]
        found.append(np.angle(np.sum(_inside(redness) * np.exp(1j * _places(redness.size, 40.5) * K))))
    assert_allclose(waits[:-1], np.diff(times), atol=0.005)  # GIF counts in hundredths
    assert len(waits) == times.size
    # The phase of the first harmonic of the colours is that of the wave; pixels are 0.2 m, or 0.05 rad.
    assert_allclose(np.unwrap(found) - found[0], OMEGA * times, atol=0.15)


def _places(pixels: int, half: float) -> np.ndarray:
    """East [m] of a line of pixels across the map, which fills 16 to 97 % of the width."""
    share = (np.arange(pixels) + 0.5) / pixels
    return half * (2.0 * (share - 0.16) / 0.81 - 1.0)


def _inside(line: np.ndarray) -> np.ndarray:
    """Colours of three whole wavelengths of the map alone."""
    return np.where(np.abs(_places(line.size, 40.5)) < 37.5, line, 0.0)


def test_long_animation_stays_small() -> None:
    moments = swell(np.arange(90) * 0.1, 270.0, half=20.0)
    film = Image.open(io.BytesIO(data := sea_figures.animation(scene(270.0), moments)))
    assert getattr(film, "n_frames", 1) <= 80
    assert film.info["duration"] == 200  # every second
    assert len(data) < 6e6


# ------------------------------------------------------------------------------------------------------- statistics


def test_moments_are_those_of_all_samples() -> None:
    """Sums over parts against numpy's own over the whole."""
    random = np.random.default_rng(2)
    height = random.gamma(3.0, 0.4, size=(3, 40, 50)).astype(np.float32)
    slopes = random.normal(size=(2, 3, 40, 50)).astype(np.float32)
    drawn = Moments()
    for number in range(3):
        drawn.add(height[number], slopes[0, number], slopes[1, number])
    eta = height.astype(np.float64) - height.mean(dtype=np.float64)
    assert_allclose(drawn.mean, height.mean(dtype=np.float64), rtol=1e-12)
    assert_allclose(drawn.significant_height, 4.0 * eta.std(), rtol=1e-12)
    assert_allclose(drawn.skewness, np.mean(eta**3) / eta.std() ** 3, rtol=1e-10)
    assert_allclose(drawn.kurtosis, np.mean(eta**4) / eta.std() ** 4, rtol=1e-10)
    east, north = unit_from_azimuth(30.0)
    along = east * slopes[0].astype(np.float64) + north * slopes[1]
    assert_allclose(drawn.slope_variance(30.0), np.mean(along**2), rtol=1e-10)


@pytest.mark.parametrize("model", ["linear", "choppy"])
def test_expected_slopes_are_those_of_the_resolved_waves(model: str) -> None:
    """Two perpendicular directions make up the mean square slope; east and north are the facts' own."""
    swells = {"spectrum": "jonswap", "significant_wave_height_m": 0.7, "peak_period_s": 4.0, "wave_from_deg": 310.0}
    regular = {"spectrum": "sinusoid", "height_m": 0.3, "wavelength_m": 20.0, "wave_from_deg": 200.0}
    made = scene(sea__waves=[swells, swells | {"spreading": "long_crested"}, regular], sea__model=model)
    sea = Simulator(made).sea
    for azimuth in (0.0, 37.0):
        both = expected_slope_variance(sea, azimuth) + expected_slope_variance(sea, azimuth + 90.0)
        assert_allclose(both, sea.resolved.mean_square_slope, rtol=1e-9)
    assert_allclose(expected_slope_variance(sea, 90.0), sea.resolved.slope_std_east**2, rtol=1e-9)
    assert expected_slope_variance(sea, 310.0) > 2.0 * expected_slope_variance(sea, 40.0)
    assert_allclose(requested_height(sea), 4.0 * np.sqrt(2 * 0.7**2 / 16 + 0.15**2 / 2), rtol=1e-6)


def test_regular_waves_have_their_own_kurtosis() -> None:
    """1.5 of one regular wave alone, 3 of a random sea; drawn over whole wavelengths it is found to rounding."""
    regular = {"spectrum": "sinusoid", "height_m": 0.3, "wavelength_m": 20.0, "wave_from_deg": 270.0}
    sea = Simulator(scene(sea__waves=[regular])).sea
    assert_allclose(expected_kurtosis(sea), 1.5, rtol=1e-12)
    assert_allclose(expected_kurtosis(Simulator(scene()).sea), 3.0)
    drawn, places = Moments(), np.arange(160) * 0.25
    height = sea.elevation(places, places[:, None], 0.0).astype(np.float32)
    drawn.add(height, height, height)
    assert_allclose(drawn.kurtosis, 1.5, rtol=1e-5)


def test_table_tells_the_drawn_sea_from_the_asked_one() -> None:
    made = scene()
    sea, drawn = Simulator(made).sea, Moments()
    height = 0.25 * np.random.default_rng(1).normal(size=(50, 50)).astype(np.float32)
    drawn.add(height, height, 0.0 * height)
    lines = statistics_table(made, sea, drawn, 50.0).splitlines()
    (row,) = (line.split() for line in lines if line.startswith("significant height"))
    assert row[3:] == ["0.9", f"{4.0 * sea.resolved.elevation_std:.4g}", f"{drawn.significant_height:.4g}"]
    assert any("300°" in line for line in lines)
