"""The shift that short waves remember: dD/dt + μ D = u for every part, at both ends of μ, on linear and choppy seas."""

from typing import Any

import numpy as np
import pytest
from small_seas import PARTS, jonswap, sea_of, sinusoid

from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.sea import realize
from seamap_rt.sea.choppy import ChoppySurface
from seamap_rt.sea.wave_trains import Quantity

HALF_DAY = 12.0 * 3600.0
RELAXED: tuple[Quantity, ...] = ("relaxed_east", "relaxed_north")


def part_of(name) -> Any:
    (part,) = realize(PARTS[name], seed=1).trains
    return part


def scattered(count, seed, duration=3.0):
    rng = np.random.default_rng(seed)
    return rng.uniform(-400.0, 400.0, count), rng.uniform(-400.0, 400.0, count), rng.uniform(0.0, duration, count)


def exact(waves, x, y, t, rate):
    """D (2, n) of û = ω coth(kh) k̂ a e^{i(k·x − ωt)}, D = û/(μ − iω), wave by wave."""
    k = np.hypot(waves.east, waves.north)
    per_elevation = waves.omega * waves.orbital / k / (rate - 1j * waves.omega)
    factors = np.stack((waves.east, waves.north)) * per_elevation * waves.amplitude
    values = np.empty((2, x.size))
    for n in range(x.size):
        phase = waves.east * x[n] + waves.north * y[n] - np.remainder(waves.omega * t[n], 2.0 * np.pi)
        values[:, n] = np.real(factors @ np.exp(1j * phase))
    return values


# ------------------------------------------------------------------------------------------------- the parts


@pytest.mark.parametrize("rate", [0.0, 1.0, 30.0])
@pytest.mark.parametrize("name", PARTS)
def test_relaxed_shift_is_its_exact_sum(name, rate):
    part = part_of(name)
    x, y, t = scattered(80, seed=2)
    t += HALF_DAY
    expected = exact(part.components(), x, y, t, rate)
    error = np.sqrt(np.mean((part.sample(x, y, t, RELAXED, rate) - expected) ** 2, axis=1))
    if name == "regular":
        assert np.all(error < 1e-9)  # 12 h are 1e5 rad of phase, their rounding 1e-11
        return
    # Each wave is no larger than in the shift, nor than in flow/μ, and so is what interpolation misses of it. An rms of
    # 80 points, ±8 %, doubled for the realisation; single precision rounds sums of a few metres by 1e-6.
    said = min(part.field.error.shift, part.field.error.horizontal_velocity / max(rate, 1e-9))
    assert np.all(error < 2.0 * said + 2e-6)
    assert np.all(error < 0.05 * expected.std(axis=1))


def test_two_rates_asked_in_turns_do_not_mix():
    x, y, t = scattered(500, seed=5)
    alone = {rate: part_of("plane").sample(x, y, t, RELAXED, rate) for rate in (0.0, 1.0, 6.0)}
    both = part_of("plane")
    for _ in range(2):
        for rate, expected in alone.items():
            np.testing.assert_array_equal(both.sample(x, y, t, RELAXED, rate), expected)
    assert np.abs(alone[1.0] - alone[6.0]).max() > 0.05


# ------------------------------------------------------------------------------------------------- the sea


@pytest.mark.parametrize("rate", [0.0, 0.4, 1.7, 1e3])
def test_ripples_crowd_at_the_crest_without_relaxation_and_on_the_leading_face_with_it(rate):
    """−∂D/∂x = k a ω (ω cos θ + μ sin θ)/(ω² + μ²): largest at θ = atan(μ/ω) ahead of the crest."""
    sea = realize(sea_of(sinusoid(height_m=0.5)), seed=1)  # from the west: towards positive x
    k, t = 2.0 * np.pi / 20.0, 2.3
    omega = float(angular_frequency(k, np.inf))
    x, step = np.linspace(0.0, 20.0, 2001), 0.05
    after, before = (sea.elevation_velocity_and_relaxed_shift(x + s, 3.0, t, rate)[2][:, 0] for s in (step, -step))
    strain = -(after.astype(np.float64) - before) / (2.0 * step)
    theta = k * x - omega * t
    expected = 0.25 * k * omega * (omega * np.cos(theta) + rate * np.sin(theta)) / (omega**2 + rate**2)
    # Single precision: 1.5e-8 of a shift of 0.25 m, twice, over 0.1 m; the difference itself is (k step)²/6 = 4e-5 off.
    np.testing.assert_allclose(strain, expected, rtol=0.0, atol=4e-7 + 5e-5 * np.abs(expected).max())
    ahead = np.remainder(theta[np.argmax(strain)], 2.0 * np.pi)
    # A flat top hides in rounding: cos(0.06) is 2e-3 below 1, more than both errors together.
    assert abs(np.remainder(ahead - np.arctan2(rate, omega) + np.pi, 2.0 * np.pi) - np.pi) < 0.06


@pytest.mark.parametrize("model", ["linear", "choppy"])
def test_asking_for_it_changes_no_bit_of_the_rest(model):
    sea = realize(sea_of(jonswap(), sinusoid(), jonswap(spreading="long_crested"), model=model), seed=1)
    x, y, t = (value.reshape(10, 30) for value in scattered(300, seed=6))
    elevation, velocity, relaxed = sea.elevation_velocity_and_relaxed_shift(x, y, t, 1.0)
    assert (elevation.dtype, velocity.dtype, relaxed.dtype) == (np.float64, np.float32, np.float32)
    assert (elevation.shape, velocity.shape, relaxed.shape) == ((10, 30), (10, 30, 3), (10, 30, 2))
    for found, alone in zip((elevation, velocity), sea.elevation_and_velocity(x, y, t), strict=True):
        np.testing.assert_array_equal(found, alone)


@pytest.mark.parametrize("model", ["linear", "choppy"])
def test_a_current_carries_the_shift_and_adds_nothing(model):
    waves = (jonswap(), sinusoid())
    still, carried = (
        realize(sea_of(*waves, model=model, **current), seed=1)
        for current in ({}, {"current_m_s": 1.5, "current_toward_deg": 90.0})
    )
    x, y, t = scattered(300, seed=7)
    *_, here = carried.elevation_velocity_and_relaxed_shift(x + 1.5 * t, y, t, 1.0)
    *_, there = still.elevation_velocity_and_relaxed_shift(x, y, t, 1.0)
    # The same places to 1e-13 m; on the choppy sea labels are found from there, to the same bits or nearly.
    np.testing.assert_allclose(here, there, rtol=0.0, atol=1e-5)


def test_no_waves_strain_nothing_and_no_rate_is_negative():
    calm = realize(sea_of(), seed=1)
    *_, relaxed = calm.elevation_velocity_and_relaxed_shift(np.zeros((3, 1)), np.zeros(4), 0.0, 1.0)
    assert relaxed.shape == (3, 4, 2)
    assert not relaxed.any()
    for rate in (-1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="rate = "):
            calm.elevation_velocity_and_relaxed_shift(0.0, 0.0, 0.0, rate)


# ------------------------------------------------------------------------------------------------- choppy waves


def test_choppy_water_takes_its_shift_along():
    """At the place where the water of a label is, D is that label's; and dD/dt + μ D = u along its way."""
    sea = realize(sea_of(jonswap(), sinusoid(wave_from_deg=300.0), model="choppy"), seed=1)
    assert isinstance(sea.surface, ChoppySurface)
    waves, rate, step = sea.surface.waves, 1.5, 0.02
    label_x, label_y, t = scattered(400, seed=8)

    def on_the_way(time):
        shift = waves.sample(label_x, label_y, time, ("shift_east", "shift_north"))
        x, y = label_x + shift[0], label_y + shift[1]
        _, velocity, relaxed = sea.elevation_velocity_and_relaxed_shift(x, y, time, rate)
        upright = ~sea.folded(x, y, time)
        return velocity[:, :2].T.astype(np.float64), relaxed.T.astype(np.float64), upright

    (flow, here, upright), (_, after, _), (_, before, _) = (on_the_way(t + late) for late in (0.0, step, -step))
    assert upright.mean() > 0.95
    expected = waves.sample(label_x, label_y, t, RELAXED, rate)
    # Labels are found to 3e-3 rad of the shortest wave, 1 mm; the strain is below 1 nearly everywhere.
    assert np.sqrt(np.mean((here - expected)[:, upright] ** 2)) < 1e-3
    # Step²/6 ω² of the flow at the peak is 1e-4 of it, at 5 rad/s 2e-3; interpolation misses 1e-3 of it.
    misfit = ((after - before) / (2.0 * step) + rate * here - flow)[:, upright]
    assert np.sqrt(np.mean(misfit**2)) < 3e-3 * flow.std()


def test_on_small_waves_choppy_and_linear_agree():
    found = []
    for height in (0.2, 0.1):
        x, y, t = scattered(500, seed=9)
        linear, choppy = (
            realize(sea_of(jonswap(significant_wave_height_m=height), model=model), seed=2)
            .elevation_velocity_and_relaxed_shift(x, y, t, 1.0)[2]
            .astype(np.float64)
            for model in ("linear", "choppy")
        )
        found.append((choppy - linear).std() / linear.std())
    # −(D·∇)D: of the order of the rms strain, and of first order in the height.
    assert found[0] < 0.05
    assert 1.8 < found[0] / found[1] < 2.2
