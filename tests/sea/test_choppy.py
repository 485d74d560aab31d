"""Choppy (first-order Lagrangian) waves: the trochoid, the height that stays, the laws at fixed places, and folds."""

import numpy as np
import pytest

from seamap_rt.sea import Sea, direct_sum, realize
from seamap_rt.sea.choppy import ChoppySurface, Displacement, height_keeping_scale
from seamap_rt.sea.facts import ChoppyFacts
from seamap_rt.settings import JonswapWaves, SeaSettings, SinusoidWaves


def sinusoid(**changes):
    return SinusoidWaves(**{"spectrum": "sinusoid", "height_m": 1.0, "wavelength_m": 20.0, **changes})


def jonswap(**changes):
    return JonswapWaves(**{"spectrum": "jonswap", "significant_wave_height_m": 1.4, "peak_period_s": 5.5, **changes})


def choppy(*waves, **changes):
    return SeaSettings(**{"resolution_m": 1.0, "extent_m": 256.0, "waves": waves, "model": "choppy", **changes})


def choppy_facts(sea: Sea) -> ChoppyFacts:
    facts = sea.resolved.choppy
    assert facts is not None
    return facts


def choppy_surface(sea: Sea) -> ChoppySurface:
    assert isinstance(sea.surface, ChoppySurface)
    return sea.surface


def harmonics(sea, wavelength, count=4):
    """Fourier amplitudes over one wavelength towards the east, from the crest: mean, first, second …"""
    x = wavelength * np.arange(512) / 512
    return np.fft.rfft(sea.elevation(x, 0.0, 0.0)).real[:count] / 256


# --------------------------------------------------------------------------------------------- the regular wave


@pytest.mark.parametrize("depth", [np.inf, 4.0])
@pytest.mark.parametrize("steepness", [0.02, 0.05, 0.1])
def test_a_regular_wave_has_its_second_harmonic_and_no_mean(depth, steepness):
    wave = sinusoid(height_m=2.0 * steepness * 20.0 / (2.0 * np.pi))
    sea = realize(choppy(wave, depth_m=depth), seed=1)
    mean, first, second, third = harmonics(sea, 20.0)
    k, a = 2.0 * np.pi / 20.0, 0.5 * wave.height_m
    stretch = 1.0 / np.tanh(k * depth)
    # x = ξ − a coth sin kξ (Lagrange, Bessel): harmonics aₙ = (2/n) a J′ₙ(n k a coth)…; the next order is (ka)² below.
    order = 2.0 * (stretch * steepness) ** 2
    assert abs(mean) < 1e-6  # of what the search for labels leaves, the part of one sign
    np.testing.assert_allclose(first, a, rtol=order)
    np.testing.assert_allclose(second, 0.5 * k * a**2 * stretch, rtol=order)
    np.testing.assert_allclose(third, 0.375 * k**2 * a**3 * stretch**2, rtol=2.0 * order)
    np.testing.assert_allclose(choppy_facts(sea).set_down, 0.5 * k * a**2 * stretch, rtol=1e-12)


def test_a_regular_wave_is_gerstners_trochoid():
    wave = sinusoid(height_m=2.0, wave_from_deg=200.0, phase_deg=40.0)
    sea = realize(choppy(wave), seed=1)
    k, a, t = 2.0 * np.pi / 20.0, 1.0, 3.7
    omega = float(np.sqrt(k * (9.81 + 0.074 / 1025.0 * k**2)))
    label = np.linspace(0.0, 60.0, 301)
    angle = k * label - omega * t + np.radians(40.0)
    along = label - a * np.sin(angle)
    east, north = -np.sin(np.radians(200.0)), -np.cos(np.radians(200.0))
    x, y = along * east + 5.0 * north, along * north - 5.0 * east  # off the axis: crests are straight
    # Labels are found to 3e-3 rad of the shortest wave, here of 2k: 5 mm of displacement, at most 0.3 of it in height.
    np.testing.assert_allclose(sea.elevation(x, y, t), a * np.cos(angle) + 0.5 * k * a**2, atol=1.5e-3)
    speed = omega * a
    expected = np.stack((speed * np.cos(angle) * east, speed * np.cos(angle) * north, speed * np.sin(angle)), axis=-1)
    np.testing.assert_allclose(sea.velocity(x, y, t), expected, atol=1.5e-3 * omega / k * k)
    assert np.ptp(sea.elevation(x, y, t)) <= 2.0 + 1e-9  # crest to trough it stays as high as asked


@pytest.mark.parametrize("steepness", [0.1, 0.35])
def test_mean_square_slope_over_the_ground_is_the_trochoids(steepness):
    # ∫ (ka)² sin²/(1 − ka cos) dξ over a period, divided by it, is 1 − √(1 − (ka)²).
    wave = sinusoid(height_m=2.0 * steepness * 20.0 / (2.0 * np.pi), wave_from_deg=333.0)
    found = choppy_facts(realize(choppy(wave), seed=1)).mean_square_slope
    np.testing.assert_allclose(found, 1.0 - np.sqrt(1.0 - steepness**2), rtol=1e-3)  # 200,000 labels, evenly strewn


def test_facts_are_those_of_the_sea_that_was_asked_for():
    wave = jonswap(significant_wave_height_m=2.0, peak_period_s=4.0)
    asked = realize(choppy(wave, model="linear"), seed=1).resolved
    enlarged = realize(choppy(wave), seed=1).resolved
    assert enlarged.choppy is not None
    assert enlarged.choppy.amplitude_scale > 1.003
    np.testing.assert_allclose(enlarged.mean_square_slope, asked.mean_square_slope, rtol=1e-9)
    np.testing.assert_allclose(enlarged.slope_std_east, asked.slope_std_east, rtol=1e-9)
    np.testing.assert_allclose(enlarged.variance, asked.variance, rtol=1e-12)


def test_small_waves_are_linear():
    for height, tolerance in ((0.1, 0.04), (0.01, 0.004)):
        wave = jonswap(significant_wave_height_m=height)
        x, y = np.random.default_rng(1).uniform(-200.0, 200.0, (2, 500))
        linear = realize(choppy(wave, model="linear"), seed=2).elevation(x, y, 1.0)
        difference = realize(choppy(wave), seed=2).elevation(x, y, 1.0) - linear
        # −D·∇η: of relative size rms(D) rms(slope)/rms(η) ≈ the rms slope, 0.3 of the height here.
        assert 0.0 < difference.std() / linear.std() < tolerance


# ------------------------------------------------------------------------------------------------- a random sea


def test_variance_over_the_ground_is_the_closed_form_before_it_is_corrected():
    """m₀ − |M|² against samples over the ground, on a sea steep enough for the difference to stand out."""
    wave = jonswap(significant_wave_height_m=2.0, peak_period_s=3.5, spreading_exponent=4.0)
    found, said, levels, put_back = [], [], [], 0.0
    for seed in range(20):
        sea = realize(choppy(wave, resolution_m=2.5), seed=seed)
        facts = choppy_facts(sea)
        drawn = 0.5 * np.sum(np.abs(sea.components().amplitude) ** 2)
        put_back = facts.set_down
        moments = choppy_surface(sea).displacement
        found.append(facts.elevation_std**2 / drawn)
        said.append(1.0 - np.sum(moments.covariance**2) / drawn)
        x, y = (grid.ravel() for grid in np.meshgrid(*2 * [np.arange(0.0, 256.0, 2.0)]))
        levels.append(sea.elevation(x, y, 0.0).mean())
    shortfall = 1.0 - np.mean(said)
    assert shortfall > 0.01
    # Opposite waves of one length beat over the patch, which makes realisations differ: four standard errors.
    assert abs(np.mean(found) - np.mean(said)) < 4.0 * np.std(found) / np.sqrt(19)
    assert 4.0 * np.std(found) / np.sqrt(19) < 0.5 * shortfall
    assert abs(np.mean(levels)) < 4.0 * np.std(levels) / np.sqrt(19) + 1e-3
    assert put_back > 0.05  # a mean level of this size would else be seen


def test_significant_height_stays_what_was_asked_for():
    wave = jonswap(significant_wave_height_m=2.0, peak_period_s=4.0)
    settings = choppy(wave, resolution_m=2.0)
    variances = np.array([choppy_facts(realize(settings, seed=n)).elevation_std ** 2 for n in range(12)])
    asked = realize(settings, seed=0).resolved
    assert asked.choppy is not None
    assert asked.choppy.amplitude_scale > 1.004
    assert abs(variances.mean() - asked.variance) < 4.0 * variances.std() / np.sqrt(11)
    np.testing.assert_allclose(
        asked.elevation_std, realize(settings.model_copy(update={"model": "linear"}), 0).resolved.elevation_std
    )


def test_the_scale_solves_its_equation_and_refuses_what_has_no_solution():
    covariance, regular = np.array([[-0.05, 0.01], [0.01, -0.02]]), np.array([[-0.03, 0.0], [0.0, 0.0]])
    scale = height_keeping_scale(0.2, covariance, regular)
    left = scale * 0.2 - np.sum((scale * covariance + regular) ** 2)
    np.testing.assert_allclose(left, 0.2 - np.sum(regular**2), rtol=1e-12)
    assert scale > 1.0
    with pytest.raises(ValueError, match="too steep"):
        height_keeping_scale(0.01, np.diag([-0.2, -0.2]), np.zeros((2, 2)))


def test_moments_of_the_displacement_are_those_of_the_waves():
    sea = realize(choppy(jonswap(spreading_exponent=2.0)), seed=4)
    x, y = (grid.ravel() for grid in np.meshgrid(*2 * [np.arange(0.0, 256.0, 1.0)]))
    names = ("elevation", "shift_east", "shift_north", "shift_east_east", "shift_east_north", "shift_north_north")
    times = np.linspace(0.0, 120.0, 7)
    covariance, spread = np.zeros((2, 2)), 0.0
    for time in times:
        height, d_east, d_north, ee, en, nn = choppy_surface(sea).waves.sample(x, y, np.full(x.size, time), names)
        covariance += np.array(
            [[np.mean(height * ee), np.mean(height * en)], [np.mean(height * en), np.mean(height * nn)]]
        )
        spread += np.mean(d_east**2 + d_north**2)
    moments = choppy_surface(sea).displacement
    # The means over the patch are exact but for beats of opposite waves, which seven times do not quite average out.
    np.testing.assert_allclose(covariance / 7, moments.covariance, atol=0.02 * abs(moments.covariance[0, 0]))
    np.testing.assert_allclose(spread / 7, moments.variance, rtol=0.02)
    assert Displacement.none().variance == 0.0


# ------------------------------------------------------------------------------------------- laws at fixed places


@pytest.mark.parametrize("current", [0.0, 1.5])
def test_slopes_and_rate_are_the_elevations_derivatives_and_the_kinematic_condition_holds(current):
    settings = choppy(jonswap(), sinusoid(wave_from_deg=20.0), current_m_s=current, current_toward_deg=130.0)
    sea = realize(settings, seed=2)
    rng = np.random.default_rng(3)
    x, y, t = rng.uniform(-100.0, 100.0, 400), rng.uniform(-100.0, 100.0, 400), rng.uniform(0.0, 2.0, 400)

    def misfit(step):
        east = (sea.elevation(x + step, y, t) - sea.elevation(x - step, y, t)) / (2.0 * step)
        north = (sea.elevation(x, y + step, t) - sea.elevation(x, y - step, t)) / (2.0 * step)
        pause = step / 4.0
        rate = (sea.elevation(x, y, t + pause) - sea.elevation(x, y, t - pause)) / (2.0 * pause)
        slopes = sea.slopes(x, y, t)
        found = (east - slopes[..., 0], north - slopes[..., 1], rate - sea.elevation_rate(x, y, t))
        return np.array([np.sqrt(np.mean(difference**2)) for difference in found])

    coarse, fine = misfit(0.4), misfit(0.2)
    # Central differences: a quarter for half the step; what the search for labels leaves (0.1 mm) blurs the 4.
    assert np.all(coarse / fine > 3.0)
    assert np.all(coarse / fine < 5.0)
    assert np.all(fine < 0.02)
    flow = sea.velocity(x, y, t)
    expected = sea.elevation_rate(x, y, t) + np.sum(flow[..., :2] * sea.slopes(x, y, t), axis=-1)
    np.testing.assert_allclose(flow[..., 2], expected, atol=1e-9)


def test_the_surface_passes_through_its_own_water():
    sea = realize(choppy(jonswap(), jonswap(spreading="long_crested", wave_from_deg=200.0)), seed=5)
    rng = np.random.default_rng(6)
    x, y, t = rng.uniform(-100.0, 100.0, 60), rng.uniform(-100.0, 100.0, 60), np.full(60, 2.3)
    waves = sea.components()
    state = direct_sum(waves, x, y, t)
    k = np.hypot(waves.east, waves.north)
    moved: np.ndarray = np.array([
        waves.amplitude * np.exp(1j * (waves.east * a + waves.north * b - waves.omega * 2.3))
        for a, b in zip(x, y, strict=True)
    ])  # fmt: skip
    shift_east = -(np.imag(moved) * waves.orbital * waves.east / k).sum(axis=1)
    shift_north = -(np.imag(moved) * waves.orbital * waves.north / k).sum(axis=1)
    height = state.elevation + choppy_facts(sea).set_down
    # 1 mm rms of interpolation, and what the label search leaves.
    seen = sea.elevation(x + shift_east, y + shift_north, t)
    assert np.sqrt(np.mean((seen - height) ** 2)) < 1.5e-3
    assert np.abs(seen - height).max() < 6e-3


def test_answers_do_not_depend_on_what_else_is_asked():
    sea = realize(choppy(jonswap()), seed=1)
    x, y = np.random.default_rng(1).uniform(-100.0, 100.0, (2, 3000))
    elevation, slopes, velocity = sea.elevation_slopes_and_velocity(x, y, 0.3)
    np.testing.assert_array_equal(sea.elevation(x[::-3], y[::-3], 0.3), elevation[::-3])
    np.testing.assert_array_equal(sea.slopes(x[5], y[5], 0.3), slopes[5])
    np.testing.assert_array_equal(sea.velocity(x[7:9], y[7:9], 0.3), velocity[7:9])


# --------------------------------------------------------------------------------------------------------- folds


@pytest.fixture(scope="module")
def breaking():
    wave = jonswap(significant_wave_height_m=2.8, peak_period_s=4.0, spreading="long_crested")
    return realize(choppy(wave, resolution_m=0.4, extent_m=256.0), seed=3)


def test_folds_are_found_and_the_highest_upright_sheet_is_taken(breaking):
    label = np.arange(-20.0, 1000.0, 0.002)
    zero = np.zeros(label.size)
    height, shift, strain = choppy_surface(breaking).waves.sample(
        label, zero, zero, ("elevation", "shift_east", "shift_east_east")
    )
    along, height = label + shift, height + choppy_facts(breaking).set_down
    assert (strain <= -1.0).any()  # the water turns over somewhere
    # The exact answer: every piece of the dense curve that crosses a place.
    x = np.arange(0.0, 980.0, 0.02)
    highest, sheets = np.full(x.size, -np.inf), np.zeros(x.size, dtype=int)
    first_of = np.searchsorted(x, along)
    for piece in np.flatnonzero(first_of[1:] != first_of[:-1]):
        start, stop, low, high = along[piece], along[piece + 1], height[piece], height[piece + 1]
        first, last = sorted((first_of[piece], first_of[piece + 1]))
        if last > first:
            share = (x[first:last] - start) / (stop - start)
            if stop > start:  # upright: of the sheets under the loop that a fold makes, one lies upside down
                highest[first:last] = np.maximum(highest[first:last], low + share * (high - low))
            sheets[first:last] += 1
    folded = breaking.folded(x, 0.0, 0.0)
    found = breaking.elevation(x, 0.0, 0.0)
    assert 10 < np.sum(sheets > 1) < 0.05 * x.size
    single = sheets == 1
    assert np.abs(found - highest)[single & ~folded].max() < 0.02
    # Under a fold: all are flagged but its very edges, and the highest upright sheet is what is seen.
    assert np.mean(folded[sheets > 1]) > 0.9
    assert np.mean(folded[single]) < 0.002
    assert np.quantile(np.abs(found - highest)[sheets > 1], 0.95) < 0.05


def test_folding_is_reported_and_too_much_of_it_refused(breaking):
    assert 0.0 < choppy_facts(breaking).folded_share < 0.02
    with pytest.raises(ValueError, match="fold over"):
        realize(choppy(jonswap(significant_wave_height_m=4.0, peak_period_s=4.0), resolution_m=0.4), seed=1)


@pytest.mark.parametrize("waves", [(), (sinusoid(height_m=0.0),), (jonswap(significant_wave_height_m=0.0),)])
def test_no_waves_are_flat(waves):
    sea = realize(choppy(*waves, current_m_s=1.0, current_toward_deg=90.0), seed=1)
    assert not sea.elevation(np.arange(3.0), 0.0, 1.0).any()
    np.testing.assert_allclose(sea.velocity(0.0, 0.0, 0.0), [1.0, 0.0, 0.0], atol=1e-15)
    assert not sea.folded(np.arange(3.0), 0.0, 1.0).any()
