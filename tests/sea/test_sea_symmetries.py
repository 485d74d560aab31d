"""What turning, adding and carrying along do to a sea, for every kind of spectrum; and its exact sum."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.sea import direct_sum, realize
from seamap_rt.sea.wave_trains import LinearSurface
from seamap_rt.settings import (
    ElfouhailyWaves,
    FileWaves,
    FlatWaves,
    JonswapWaves,
    PiersonMoskowitzWaves,
    SeaSettings,
    SinusoidWaves,
    TmaWaves,
)

HALF_DAY = 12.0 * 3600.0
SPREADINGS = ("cos2s", "mitsuyasu", "hasselmann", "donelan_banner", "elfouhaily")
SWAN = str(Path(__file__).parents[1] / "io" / "spectra" / "swan.spc")


def jonswap(**changes):
    return JonswapWaves(**{"spectrum": "jonswap", "significant_wave_height_m": 1.4, "peak_period_s": 5.5, **changes})


def elfouhaily(**changes):
    return ElfouhailyWaves(**{"spectrum": "elfouhaily", "wind_speed_m_s": 7.0, **changes})


def sea_of(*waves, **changes):
    return SeaSettings(**{"resolution_m": 2.0, "extent_m": 256.0, "waves": waves, **changes})


KINDS = {
    **{spreading: jonswap(spreading=spreading) for spreading in SPREADINGS},
    "tma": TmaWaves(spectrum="tma", significant_wave_height_m=1.0, peak_period_s=5.5, spreading="mitsuyasu"),
    "pierson_moskowitz": PiersonMoskowitzWaves(spectrum="pierson_moskowitz", wind_speed_m_s=7.0),
    "elfouhaily sea": elfouhaily(),
    "elfouhaily, young": elfouhaily(inverse_wave_age=2.0, spreading="hasselmann"),
}
SEAS = {
    "mixed": sea_of(jonswap(), SinusoidWaves(spectrum="sinusoid", height_m=1.0, wavelength_m=20.0, wave_from_deg=10.0)),
    "elfouhaily": sea_of(elfouhaily(wave_from_deg=240.0)),
    "file": sea_of(FileWaves(spectrum="file", file=SWAN)),
    "current": sea_of(jonswap(), current_m_s=1.7, current_toward_deg=35.0),
    "file, shallow, current": sea_of(
        FileWaves(spectrum="file", file=SWAN), depth_m=4.0, current_m_s=0.8, current_toward_deg=300.0
    ),
    "elfouhaily, shallow": sea_of(elfouhaily(wind_speed_m_s=5.0, wave_from_deg=20.0), depth_m=2.0),
    "line, current": sea_of(
        jonswap(spreading="long_crested", wave_from_deg=200.0), current_m_s=1.0, current_toward_deg=90.0, depth_m=8.0
    ),
}


@cache
def realised(name):
    return realize(SEAS[name], 1)


def turned_waves(waves, degrees):
    return waves.model_copy(update={"wave_from_deg": waves.wave_from_deg + degrees})


def scattered(count, seed, extent=300.0, duration=2.0):
    rng = np.random.default_rng(seed)
    return rng.uniform(-extent, extent, count), rng.uniform(-extent, extent, count), rng.uniform(0.0, duration, count)


# --------------------------------------------------------------------------------------------------------- turning


@pytest.mark.parametrize("name", KINDS)
def test_waves_turned_by_90_degrees_have_the_spectrum_turned(name):
    depth = 6.0 if name == "tma" else np.inf
    before, after = (
        realize(sea_of(turned_waves(KINDS[name], angle), depth_m=depth), 1).spectrum.variance_density
        for angle in (27.0, 117.0)
    )
    # A quarter turn clockwise takes (east, north) to (north, −east); the lattice has that symmetry. Rounding is left,
    # and across the waves, where the half plane of Elfouhaily's spreading ends, no wave lies at this angle.
    expected = before.to_numpy().T[::-1, :]
    np.testing.assert_allclose(after.to_numpy(), expected, rtol=1e-9, atol=1e-12 * expected.max())


# ------------------------------------------------------------------------------------------------------- repeating


@pytest.mark.parametrize("name", ["cos2s", "tma", "pierson_moskowitz", "elfouhaily sea"])  # a spectrum each
def test_a_patch_of_twice_the_size_has_the_same_statistics(name):
    depth = 6.0 if name == "tma" else np.inf
    small, large = (realize(sea_of(KINDS[name], depth_m=depth, extent_m=extent), 1) for extent in (256.0, 512.0))
    # Variance is an integral, the same on both; slopes are sums over waves whose rim is ragged.
    np.testing.assert_allclose(small.resolved.variance, large.resolved.variance, rtol=1e-12)
    np.testing.assert_allclose(small.spectrum.variance_density.sum() / 4.0, large.spectrum.variance_density.sum() / 16.0
                               , rtol=1e-9)  # fmt: skip
    for moment in ("slope_std_east", "slope_std_north"):
        np.testing.assert_allclose(getattr(small.resolved, moment), getattr(large.resolved, moment), rtol=1e-2)
    drawn = 0.5 * np.abs(large.components().amplitude) ** 2
    each = large.spectrum.variance_density.to_numpy() * (2.0 * np.pi / 512.0) ** 2
    # |a|²/2 is exponential: the sum over the patch has variance Σ v².
    assert abs(drawn.sum() - small.resolved.variance) < 4.0 * np.sqrt(np.sum(each**2))


# ---------------------------------------------------------------------------------------------- derivatives and laws


@pytest.mark.parametrize("name", SEAS)
def test_slopes_and_rate_are_derivatives_of_the_elevation(name):
    sea = realised(name)
    x, y, t = scattered(300, seed=8)

    def misfit(step):
        east = (sea.elevation(x + step, y, t) - sea.elevation(x - step, y, t)) / (2.0 * step)
        north = (sea.elevation(x, y + step, t) - sea.elevation(x, y - step, t)) / (2.0 * step)
        rate = (sea.elevation(x, y, t + step / 4.0) - sea.elevation(x, y, t - step / 4.0)) / (0.5 * step)
        slopes = sea.slopes(x, y, t)
        found = (east - slopes[..., 0], north - slopes[..., 1], rate - sea.elevation_rate(x, y, t))
        return np.array([np.sqrt(np.mean(difference**2)) for difference in found])

    coarse, fine = misfit(0.4), misfit(0.2)
    # Central differences: half the step leaves a quarter. The next order, the spline's own errors and single
    # precision (1e-7 m over 0.1 s) blur that.
    assert np.all(coarse / fine > 3.2)
    assert np.all(coarse / fine < 4.8)
    assert np.all(fine < 0.02)


@pytest.mark.parametrize("name", SEAS)
def test_the_surface_moves_with_its_water(name):
    """Kinematic condition to first order, on a uniform current exactly: w = ∂η/∂t + U·∇η."""
    sea = realised(name)
    x, y, t = scattered(300, seed=9)
    carried = sea.slopes(x, y, t) @ np.array(sea.current)
    np.testing.assert_allclose(sea.velocity(x, y, t)[:, 2], sea.elevation_rate(x, y, t) + carried, atol=1e-9)


@pytest.mark.parametrize("start", [HALF_DAY, -3600.0])
@pytest.mark.parametrize("name", SEAS)
def test_surface_and_water_are_the_exact_sum_even_after_12_hours(name, start):
    """The reference: each wave by itself in float64, carried along by the current; orbits as wide as coth kh."""
    sea, waves = realised(name), realised(name).components()
    x, y, t = scattered(120, seed=4)
    t = start + np.round(t, 1)
    k = np.hypot(waves.east, waves.north)
    depth = SEAS[name].depth_m
    np.testing.assert_allclose(waves.omega**2, k * (9.81 + 0.074 / 1025.0 * k**2) * np.tanh(k * depth), rtol=1e-12)
    np.testing.assert_allclose(waves.orbital, 1.0 / np.tanh(k * depth), rtol=1e-12)
    exact = direct_sum(waves, x - sea.current[0] * t, y - sea.current[1] * t, t)
    wave = [
        waves.amplitude * np.exp(1j * (waves.east * (a - sea.current[0] * c) + waves.north * (b - sea.current[1] * c)
                                       - np.remainder(waves.omega * c, 2.0 * np.pi)))
        for a, b, c in zip(x[:20], y[:20], t[:20], strict=True)
    ]  # fmt: skip
    # The package's own sum against the same by hand.
    np.testing.assert_allclose(exact.elevation[:20], [each.sum().real for each in wave], atol=1e-9)
    flow = [(each.real * waves.omega * waves.orbital * waves.east / k).sum() for each in wave]
    np.testing.assert_allclose(exact.velocity[:20, 0], flow, atol=1e-9)
    rms = [
        np.sqrt(np.mean((sea.elevation(x, y, t) - exact.elevation) ** 2)),
        np.sqrt(np.mean((sea.velocity(x, y, t) - exact.velocity - (*sea.current, 0.0)) ** 2)),
        np.sqrt(np.mean((sea.slopes(x, y, t) - exact.slopes) ** 2)),
    ]
    told = sea.resolved
    # An rms of 120 points, which is 7 % uncertain, doubled for what a seed may do.
    assert rms[0] < 2.0 * told.elevation_error + 1e-6
    assert rms[1] < 2.0 * max(told.velocity_error, 2e-3)
    assert rms[2] < 2.0 * told.slope_error + 1e-6
    assert np.all(np.array(rms) < [1e-3, 1e-2, 5e-3])


# ---------------------------------------------------------------------------------------------------------- travel


@pytest.mark.parametrize("name", [*KINDS, "line"])
def test_every_sea_travels_away_from_where_it_comes_from(name):
    wave_from = 30.0
    waves = {**KINDS, "line": jonswap(spreading="long_crested")}[name].model_copy(update={"wave_from_deg": wave_from})
    depth = 6.0 if name == "tma" else np.inf
    sea = realize(sea_of(waves, depth_m=depth, resolution_m=4.0), 2)
    k = sea.components()
    weight = np.abs(k.amplitude) ** 2
    length = 2.0 * np.pi * weight.sum() / np.sum(weight * np.hypot(k.east, k.north))
    pause = 0.25 * 2.0 * np.pi / float(angular_frequency(2.0 * np.pi / length, depth))
    east, north = -np.sin(np.radians(wave_from)), -np.cos(np.radians(wave_from))
    x, y = np.meshgrid(4.0 * np.arange(64), 4.0 * np.arange(64))
    before = sea.elevation(x, y, 0.0).ravel()

    def correlation(along, across=0.0):
        moved = x + along * east - across * north, y + along * north + across * east
        return np.corrcoef(before, sea.elevation(*moved, pause).ravel())[0, 1]

    # A quarter period later crests are a quarter length on: there they meet, as far behind they are in antiphase.
    # Broad seas keep less of it, but no less than a third; to the left and to the right nothing tells.
    ahead, behind = correlation(0.25 * length), correlation(-0.25 * length)
    assert ahead > 0.35
    assert behind < 0.0
    sides = [correlation(0.0, side * 0.25 * length) for side in (-1.0, 1.0)]
    assert ahead > max(sides) + 0.2
    assert min(sides) > behind + 0.2


# ------------------------------------------------------------------------------------------------------------- sums


@pytest.mark.parametrize("model", ["linear", "choppy"])
def test_systems_add(model):
    swell = jonswap(significant_wave_height_m=0.6, peak_period_s=7.0, wave_from_deg=180.0, spreading="long_crested")
    chop, regular = elfouhaily(wind_speed_m_s=5.0), SinusoidWaves(spectrum="sinusoid", height_m=0.4, wavelength_m=30.0)
    nothing = FlatWaves(spectrum="flat")
    together = realize(sea_of(chop, swell, regular, model=model), 7)
    # Each system draws by its own place in the list; flat waves keep a place free. Choppy waves add as displacements of
    # linear ones, all made larger by what keeps the height.
    alone = [
        realize(sea_of(*(each if number == place else nothing for number in range(3))), 7)
        for place, each in enumerate((chop, swell, regular))
    ]
    x, y, t = scattered(200, seed=5)
    choppy = together.resolved.choppy
    scale = choppy.amplitude_scale if choppy else 1.0
    found, *parts = (
        LinearSurface(sea.trains).sample(x, y, t, ("elevation", "slope_east", "flow_north"))
        for sea in (together, *alone)
    )
    # Interpolation: the same grid, perhaps another step in time.
    np.testing.assert_allclose(found, scale * (parts[0] + parts[1]) + parts[2], atol=3e-3)


# ---------------------------------------------------------------------------------------------------------- current


@pytest.mark.parametrize("model", ["linear", "choppy"])
@given(st.floats(0.0, 3.0), st.floats(-360.0, 360.0), st.floats(-100.0, 100.0))
@settings(max_examples=6)
def test_a_current_carries_the_whole_surface_along(model, speed, toward, t):
    waves = (
        jonswap(significant_wave_height_m=0.8),
        SinusoidWaves(spectrum="sinusoid", height_m=0.3, wavelength_m=25.0),
    )
    shared = {"model": model, "resolution_m": 4.0, "extent_m": 128.0}
    still = realize(sea_of(*waves, **shared), 3)
    sea = realize(sea_of(*waves, **shared, current_m_s=speed, current_toward_deg=toward), 3)
    east, north = speed * np.sin(np.radians(toward)), speed * np.cos(np.radians(toward))
    x, y, _ = scattered(40, seed=6)
    there = x + east * t, y + north * t
    # 300 m and more of shift round to 1e-13 m.
    np.testing.assert_allclose(sea.elevation(*there, t), still.elevation(x, y, t), atol=1e-6)
    np.testing.assert_allclose(sea.slopes(*there, t), still.slopes(x, y, t), atol=1e-6)
    flow = still.velocity(x, y, t) + np.array([east, north, 0.0])
    np.testing.assert_allclose(sea.velocity(*there, t), flow, atol=1e-6)
    rate = still.elevation_rate(x, y, t) - still.slopes(x, y, t) @ np.array([east, north])
    np.testing.assert_allclose(sea.elevation_rate(*there, t), rate, atol=1e-6)
    np.testing.assert_array_equal(sea.folded(*there, t), still.folded(x, y, t))
    assert sea.resolved == still.resolved  # statistics at a time know no current
