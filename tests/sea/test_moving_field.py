"""The fast evaluation of the sea: every quantity of every part against its exact sum, and the laws of the spline."""

import subprocess
import sys
import time
from typing import Any

import numpy as np
import pytest
from numba.core import config
from small_seas import PARTS

from seamap_rt.sea import moving_field, realize, spline
from seamap_rt.sea.fields import DERIVATIVES, RelaxedShift, flow_missed
from seamap_rt.sea.lattice import Lattice
from seamap_rt.sea.moving_field import MovingField
from seamap_rt.sea.spline import bspline_polynomials
from seamap_rt.sea.spline_kernel import LANES, pad_to_lanes, spline_kernel
from seamap_rt.sea.wave_trains import PlaneTrain, Quantity
from seamap_rt.settings import JonswapWaves, SeaSettings

HALF_DAY = 12.0 * 3600.0
SAID: dict[Quantity, str] = {  # the error that the field states for each quantity
    "elevation": "elevation",
    "rate": "vertical_velocity",
    "slope_east": "slope",
    "slope_north": "slope",
    "flow_east": "horizontal_velocity",
    "flow_north": "horizontal_velocity",
    "shift_east": "shift",
    "shift_north": "shift",
    "shift_east_east": "shift_gradient",
    "shift_east_north": "shift_gradient",
    "shift_north_north": "shift_gradient",
}
QUANTITIES: tuple[Quantity, ...] = tuple(SAID)


def exact(waves, x, y, t):
    """All quantities of η = Re Σ a e^{i(k·x − ωt)} and of the water's orbits, wave by wave, (quantity, n)."""
    k = np.hypot(waves.east, waves.north)
    shift = waves.orbital / k  # χ per elevation
    factor = {
        "elevation": np.ones_like(k),
        "rate": -1j * waves.omega,
        "slope_east": 1j * waves.east,
        "slope_north": 1j * waves.north,
        "flow_east": waves.omega * shift * waves.east,
        "flow_north": waves.omega * shift * waves.north,
        "shift_east": 1j * shift * waves.east,
        "shift_north": 1j * shift * waves.north,
        "shift_east_east": -shift * waves.east**2,
        "shift_east_north": -shift * waves.east * waves.north,
        "shift_north_north": -shift * waves.north**2,
    }
    factors = np.stack([factor[name] * waves.amplitude for name in QUANTITIES])
    values = np.empty((len(QUANTITIES), x.size))
    for n in range(x.size):
        phase = waves.east * x[n] + waves.north * y[n] - np.remainder(waves.omega * t[n], 2.0 * np.pi)
        values[:, n] = np.real(factors @ np.exp(1j * phase))
    return values


def scattered(count, seed, duration=3.0):
    rng = np.random.default_rng(seed)
    return rng.uniform(-400.0, 400.0, count), rng.uniform(-400.0, 400.0, count), rng.uniform(0.0, duration, count)


def part_of(name) -> Any:
    (part,) = realize(PARTS[name], seed=1).trains
    return part


@pytest.mark.parametrize("name", PARTS)
def test_every_quantity_is_its_exact_sum(name):
    part = part_of(name)
    x, y, t = scattered(80, seed=2)
    t += HALF_DAY
    expected = exact(part.components(), x, y, t)
    found = part.sample(x, y, t, QUANTITIES)
    error = np.sqrt(np.mean((found - expected) ** 2, axis=1))
    if name == "regular":
        assert np.all(error < 1e-9)  # 12 h are 1e5 rad of phase, their rounding 1e-11
        return
    # An rms of 80 points, ±8 %, doubled for the realisation; single precision rounds sums of a few metres by 1e-6.
    said = np.array([getattr(part.field.error, SAID[quantity]) for quantity in QUANTITIES])
    assert np.all(error < 2.0 * said + 2e-6)
    assert np.all(error < 0.05 * expected.std(axis=1))
    for n, quantity in enumerate(QUANTITIES):
        np.testing.assert_allclose(part.sample(x, y, t, [quantity])[0], found[n], rtol=0.0, atol=2e-6)


# ------------------------------------------------------------------------------------------------- errors

BASES = [None, "potential", "shift", RelaxedShift(2.0)]


def one_wave(column, row, time_step, oversampling, order=5, depth=np.inf, length=64.0, base=None):
    """A field of one wave of 1 m, its lattice, and its exact values as a function of x, y and t."""
    lattice = Lattice(length, 16.5 * 2.0 * np.pi / length, depth)
    amplitude = np.zeros((33, 33), dtype=complex)
    amplitude[16 + row, 16 + column] = np.exp(0.3j)
    variance = 0.5 * np.abs(amplitude) ** 2
    field = MovingField(
        lattice, amplitude, variance, order=order, oversampling=oversampling, time_step=time_step, base=base
    )
    assert field.base == base
    part = PlaneTrain(lattice, variance, amplitude, field)
    return part, lambda x, y, t: exact(part.components(), x, y, t)


def rms_errors(part, truth):
    points = scattered(4000, seed=3, duration=40.0)
    error = np.sqrt(np.mean((part.sample(*points, QUANTITIES) - truth(*points)) ** 2, axis=1))
    return dict(zip(QUANTITIES, error.tolist(), strict=True))


@pytest.mark.parametrize(
    ("time_step", "oversampling", "depth"),
    [(0.5, 4.0, 2.0), (0.1, 1.25, 2.0), (0.4, 1.25, np.inf)],
    ids=["time", "space", "both"],
)
@pytest.mark.parametrize("base", BASES)
def test_the_stated_errors_are_those_of_one_wave(time_step, oversampling, depth, base):
    part, truth = one_wave(14, 0, time_step, oversampling, depth=depth, base=base)
    found, said = rms_errors(part, truth), part.field.error
    # 4000 points sample the images at random: ±2 %. The bands of frequency are 1/4096 wide, their 8th power 0.2 %.
    for quantity in ("elevation", "rate", "slope_east", "flow_east", "shift_east", "shift_east_east"):
        np.testing.assert_allclose(found[quantity], getattr(said, SAID[quantity]), rtol=0.04, atol=1e-5)


@pytest.mark.parametrize(("base", "derived"), [(None, 0), ("potential", 1), ("shift", 2)])
def test_errors_fall_with_the_time_step_as_the_order_says(base, derived):
    errors = [rms_errors(*one_wave(7, 5, step, 4.0, base=base)) for step in (0.6, 0.4)]
    # A spline's error is one order above its own, and each derivative's one below that. The rule holds for κ ≪ 2π; at
    # κ/2π = 0.27 the first image, (κ/(2π − κ))ⁿ, falls a little faster, by (0.82/0.73)ⁿ.
    in_time: dict[Quantity, int] = {"elevation": derived, "slope_east": derived, "rate": derived + 1}
    in_time["flow_north"] = max(derived - 1, 0)
    for quantity, derivatives in in_time.items():
        order = spline.TIME_ORDER + 1 - derivatives
        assert 1.5**order < errors[0][quantity] / errors[1][quantity] < (1.14 * 1.5) ** order


@pytest.mark.slow
def test_errors_fall_with_the_grid_as_the_order_says():
    errors = [rms_errors(*one_wave(7, 0, 0.02, over, order=3)) for over in (1.5, 3.0)]
    in_space: dict[Quantity, int] = {"elevation": 4, "slope_east": 3, "flow_east": 3, "shift_east_east": 2}
    for quantity, order in in_space.items():
        assert 2.0**order < errors[0][quantity] / errors[1][quantity] < (1.12 * 2.0) ** order


@pytest.mark.parametrize("base", BASES)
def test_a_finer_budget_is_kept_by_a_shorter_step(base, monkeypatch):
    plane = part_of("plane")
    lattice, folded = plane.lattice, plane.field._variance
    for elevation, velocity in ((3e-4, 5e-3), (3e-4, 1e-3), (1e-5, 5e-3)):
        monkeypatch.setattr(spline, "ELEVATION_BUDGET", elevation)
        monkeypatch.setattr(spline, "VELOCITY_BUDGET", velocity)
        step = spline.longest_time_step(lattice, folded, base)
        in_time = spline.interpolation_error(lattice, folded, (4096, 4096), 7, step, base=base)
        assert in_time.elevation < elevation
        assert in_time.vertical_velocity < velocity
        longer = spline.interpolation_error(lattice, folded, (4096, 4096), 7, 1.0 / (1.0 / step - 1.0), base=base)
        assert longer.elevation > elevation or longer.vertical_velocity > velocity


def test_a_run_takes_heights_flow_and_relaxed_shift_from_one_field():
    """And they are those of fields of their own, to the errors that either states."""
    waves = JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.4, peak_period_s=5.5)
    settings, rate = SeaSettings(waves=(waves,), extent_m=256.0, resolution_m=0.8), 6.1
    sea = realize(settings, seed=1, relaxation_rate=rate)
    (part,) = sea.trains
    assert isinstance(part, PlaneTrain)
    own = MovingField(part.lattice, part.amplitude, part.variance, order=7, oversampling=1.25, base=None)
    x, y, t = scattered(2000, seed=5)
    wanted: list[Quantity] = ["elevation", "rate", "slope_east", "flow_east", "flow_north", "relaxed_east"]
    found = part.sample(x, y, t, wanted, rate)
    assert {kind for _, kind in part.field._cache} == {RelaxedShift(rate)}
    expected = PlaneTrain(part.lattice, part.variance, part.amplitude, own).sample(x, y, t, wanted, rate)
    assert {kind for _, kind in own._cache} == {"elevation", "potential", RelaxedShift(rate)}
    rms = np.sqrt(np.mean((found - expected) ** 2, axis=1))
    # Both have the same grid in space. In time the rise is the worst: its budget is 1.2 mm/s, the heights' 0.3 mm.
    budget = np.array([spline.ELEVATION_BUDGET, *4 * [spline.VELOCITY_BUDGET]])
    assert np.all(rms[:5] < budget)
    # A base is scaled by the heights: its shift is as much too small as the flow of waves without tension.
    assert rms[5] < flow_missed(part.lattice.limit) * expected[5].std() + 1e-6
    # At another rate the shift has knots of its own.
    part.sample(x, y, t, wanted, 2.0 * rate)
    assert {kind for _, kind in part.field._cache} == {RelaxedShift(rate), RelaxedShift(2.0 * rate)}


def test_a_base_is_kept_where_what_follows_from_it_is_as_exact():
    def kept(length, most, variance_at, base):
        lattice = Lattice(length, (most + 0.5) * 2.0 * np.pi / length, np.inf)
        folded = np.zeros((most + 1, most + 1))
        for (row, column), variance in variance_at.items():
            folded[row, column] = variance
        return spline.exact_base(lattice, folded, base)

    for base in BASES[1:]:
        assert kept(500.0, 60, {(0, 10): 0.1, (0, 50): 1e-4}, base) == base
        # Ripples of 3 cm: a sixth of what brings them back is tension, which the flow would not know.
        assert kept(3.0, 100, {(0, 100): 1e-6}, base) is None
    # A swell of 6 m and 20 s under waves of 0.6 m, for which knots lie 0.2 s apart: of χ, 200 m² rms, ∂²χ/∂t² would
    # lose digits, ∂Φ/∂t of Φ, 65 m²/s, does not.
    both = {(0, 1): 2.2, (0, 1000): 1e-8}
    assert kept(625.0, 1000, both, "shift") is None
    assert kept(625.0, 1000, both, "potential") == "potential"


# ------------------------------------------------------------------------------------------------- the same bits


def test_values_round_alike_whoever_made_their_factor(monkeypatch):
    # Two threads may make the same factor at once, and one of them keeps what nobody else holds: an operator would
    # then multiply in place, by a loop that rounds otherwise where both parts of a factor count. Arrays must be larger
    # than 256 KiB for that.
    waves = JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.0, peak_period_s=5.0)
    settings, (x, y, t) = SeaSettings(waves=(waves,), extent_m=200.0, resolution_m=0.5), scattered(500, seed=9)
    part, make = realize(settings, 1).trains[0], moving_field.per_elevation
    part.sample(x, y, t + 100.0, ("relaxed_east",), 0.3)  # now the factor is there
    found = part.sample(x, y, t, ("relaxed_east",), 0.3)

    def slowly(*asked):
        made = make(*asked)
        assert made.size * 8 > 2**18
        time.sleep(0.1)  # until another thread has begun
        return made

    monkeypatch.setattr(moving_field, "per_elevation", slowly)
    np.testing.assert_array_equal(realize(settings, 1).trains[0].sample(x, y, t, ("relaxed_east",), 0.3), found)


@pytest.mark.parametrize("name", ["plane", "line"])
def test_values_know_nothing_of_other_points_threads_or_memory(name, monkeypatch):
    x, y, t = scattered(40_000, seed=4, duration=20.0)
    part = part_of(name)
    found = part.sample(x, y, t, QUANTITIES)
    monkeypatch.setattr(moving_field, "CACHE_BYTES", 20 * part.field._field_bytes(part.field._whole))
    again = part_of(name)
    np.testing.assert_array_equal(again.sample(x, y, t, QUANTITIES), found)
    assert sum(rows.nbytes for _, rows in again.field._cache.values()) <= moving_field.CACHE_BYTES
    some = np.random.default_rng(5).permutation(x.size)
    for few in (some[:9000], some[:50], some[:1]):
        np.testing.assert_array_equal(again.sample(x[few], y[few], t[few], QUANTITIES), found[:, few])
    # Of other quantities only the rounding may know: they are summed by differently compiled code.
    few = again.sample(x, y, t, ["rate", "shift_north", "rate"])
    np.testing.assert_allclose(few, found[[1, 7, 1]], rtol=0.0, atol=2e-6)


@pytest.mark.parametrize("name", ["plane", "line"])
def test_values_know_nothing_of_points_at_the_same_time(name):
    """Points of a mesh's column share sums over the knots."""
    part = part_of(name)
    angle, reach = np.radians([0.0, 3.0, 20.0, 45.0, 90.0, 200.0])[:, None], np.arange(0.0, 300.0, 1.3)
    x, y = (np.sin(angle) * reach).ravel(), (np.cos(angle) * reach).ravel()
    t = np.repeat(np.linspace(0.0, 2.0, angle.size), reach.size)
    found = part.sample(x, y, t, QUANTITIES)
    mixed = np.random.default_rng(7).permutation(x.size)
    np.testing.assert_array_equal(part.sample(x[mixed], y[mixed], t[mixed], QUANTITIES), found[:, mixed])
    for n in (0, 5, reach.size, x.size // 2, x.size - 1):
        np.testing.assert_array_equal(part.sample(x[[n]], y[[n]], t[[n]], QUANTITIES)[:, 0], found[:, n])


def test_the_plane_repeats_and_its_seam_is_smooth():
    part = part_of("plane")
    x, y, t = scattered(200, seed=6)
    x[:100] = np.linspace(-2.0, 2.0, 100)  # across the seam of the grid
    here = part.sample(x, y, t, QUANTITIES)
    there = part.sample(x + 256.0, y - 512.0, t, QUANTITIES)
    # The place between grid points is rounded to single precision: 6e-8 of a step of 0.8 m, with slopes of order 1.
    np.testing.assert_allclose(there, here, rtol=0.0, atol=3e-6)


@pytest.mark.parametrize(  # the grid's rows begin anew at multiples of 256 m
    ("first", "middle"),
    [*zip(("none", "wide", "beside", "over") * 2, (0.0, 0.0, 0.0, 0.0, -1000.0, 128.0, 100.0, -1000.0), strict=True)],
)
def test_a_strip_of_the_grid_gives_the_bits_of_the_whole(middle, first):
    """Whatever strip was asked for at the same times before."""
    part, whole = part_of("plane"), part_of("plane")
    rng = np.random.default_rng(3)
    x, y, t = rng.uniform(-200.0, 200.0, 300), middle + rng.uniform(-9.0, 9.0, 300), rng.uniform(0.0, 1.0, 300)
    before = {"none": (0.0, 0.0), "wide": (-128.0, 128.0), "beside": (middle + 60.0, middle + 70.0)}
    low, high = before.get(first, (middle - 30.0, middle + 30.0))
    if first != "none":
        part.sample(x, np.linspace(low, high, 300), t, QUANTITIES)
    found = part.sample(x, y, t, QUANTITIES)
    strip = part.field._strip_of(y)
    assert strip.count < 0.5 * part.field.shape[0]
    far = np.concatenate((y, y + 200.0))  # these need all rows
    assert whole.field._strip_of(far) == whole.field._whole
    twice = whole.sample(np.tile(x, 2), far, np.tile(t, 2), QUANTITIES)[:, :300]
    np.testing.assert_array_equal(found, twice)


@pytest.mark.parametrize(
    "resolution", [1.5, 2.5, 5.0, 12.0, 30.0]
)  # grids of 216 to 24 rows: some blocks of 64, or less
def test_strips_of_a_small_grid_hold_what_its_points_take(resolution):
    """Wherever points lie, over the end of the grid too, and however wide a strip they are in."""
    rng = np.random.default_rng(4)
    swell = JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.0, peak_period_s=9.0)
    part = realize(SeaSettings(waves=(swell,), resolution_m=resolution, extent_m=256.0), seed=1).trains[0]
    assert isinstance(part, PlaneTrain)
    still = np.zeros(400)
    x, y = rng.uniform(-256.0, 512.0, (2, 400))
    expected = part.sample(x, y, still, QUANTITIES)
    for _ in range(40):
        low, width = rng.uniform(-256.0, 512.0), rng.uniform(0.0, 200.0)
        few = (y >= low) & (y <= low + width)
        part.field._cache.clear()
        found = part.sample(x[few], y[few], still[few], QUANTITIES)
        np.testing.assert_array_equal(found, expected[:, few])


# ------------------------------------------------------------------------------------------------- the spline


@pytest.mark.parametrize("order", [1, 3, 5, 7])
def test_spline_polynomials_reproduce_powers(order):
    fraction = np.linspace(0.0, 1.0, 11)
    points = (np.arange(order + 1) - (order - 1) // 2)[:, None]
    value, slope, curvature = np.polynomial.polynomial.polyval(fraction, bspline_polynomials(order).transpose(1, 0, 2))
    np.testing.assert_allclose(value.sum(axis=0), 1.0, rtol=1e-13)
    np.testing.assert_allclose((points * value).sum(axis=0), fraction, atol=1e-13)
    np.testing.assert_allclose(slope.sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose((points * slope).sum(axis=0), 1.0, rtol=1e-12)
    if order > 1:
        np.testing.assert_allclose((points**2 * curvature).sum(axis=0), 2.0, rtol=1e-12)
        # Neighbouring pieces join: the weight of a point at the end of one interval is its weight in the next.
        np.testing.assert_allclose(slope[1:, -1], slope[:-1, 0], atol=1e-13)


def test_the_kernel_is_the_sum_of_weights_times_grid_points_across_every_seam():
    rows, columns = (bspline_polynomials(order).astype(np.float32) for order in (3, 7))
    in_time = bspline_polynomials(5, 3)[[3, 0, 1]]
    kernel = spline_kernel(rows, columns, 6)
    rng = np.random.default_rng(7)
    plain = rng.standard_normal((6, 9, 12)).astype(np.float32)
    grids = tuple(np.pad(grid, ((0, 3), (0, LANES - 1)), mode="wrap") for grid in plain)
    x, y, t = rng.uniform(-30.0, 30.0, 200), rng.uniform(-30.0, 30.0, 200), rng.uniform(2.0, 3.0, 200)
    t[50:150] = t[50]  # these share what they can
    x[100:150] = np.linspace(-3.0, 20.0, 50)
    y[100:150] = np.linspace(17.0, 3.0, 50)
    scale, place = np.arange(1.0, 1.0 + len(DERIVATIVES)), np.arange(3 * len(DERIVATIVES)).reshape(3, -1)
    found = np.empty((place.size, 200))
    known = (x, y, t), (1.0, 1.0), (0, 9)
    kernel(grids, *known, np.arange(200), pad_to_lanes(in_time), scale, place, found)

    def weights(order, position):
        """(derivative, tap) of one axis, and the grid points."""
        powers = (position - np.floor(position)) ** np.arange(order + 1)
        taps = int(np.floor(position)) - (order - 1) // 2 + np.arange(order + 1)
        return np.einsum("dpt,p->dt", bspline_polynomials(order, 3), powers), taps

    for n in range(200):
        (north, row), (east, column), (late, _) = weights(3, y[n]), weights(7, x[n]), weights(5, t[n])
        near = plain[:, (row % 9)[:, None], column % 12].astype(np.float64)
        expected = [
            scale[m] * np.einsum("kij,i,j,k", near, north[i], east[j], late[k])
            for k in (3, 0, 1)
            for m, (i, j) in enumerate(DERIVATIVES)
        ]
        # Sums of some 100 products of order 1, each rounded by 6e-8; a place within ±30 steps by 2e-7 of one.
        np.testing.assert_allclose(found[:, n] / np.tile(scale, 3), np.array(expected) / np.tile(scale, 3), atol=1e-5)
    for n in (60, 99, 100, 120, 149):
        alone = np.full_like(found, np.nan)
        kernel(grids, *known, np.array([n]), pad_to_lanes(in_time), scale, place, alone)
        np.testing.assert_array_equal(alone[:, n], found[:, n])
    few = np.full_like(found, np.nan)  # an even number of sums, and one of them alone
    kernel(grids, *known, np.arange(200), pad_to_lanes(in_time[1:]), scale, place[1:], few)
    np.testing.assert_array_equal(few[6:], found[6:])
    kernel(grids, *known, np.arange(0), pad_to_lanes(in_time), scale, place, few)


def test_a_kernel_takes_no_more_points_than_a_register_holds():
    fine, wide = (bspline_polynomials(order).astype(np.float32) for order in (3, 9))
    for weights in ((wide, fine, 4), (fine, wide, 4), (fine, fine, 10)):
        with pytest.raises(ValueError, match="at most 8"):
            spline_kernel(*weights)


class Nowhere:
    """A folder of compiled code that is never there; numba's own interface."""

    @staticmethod
    def from_function(function, file):
        return None


def test_the_kernel_runs_where_compiled_code_cannot_be_kept(monkeypatch):
    monkeypatch.setattr(config, "CACHE_LOCATOR_CLASSES", f"{__name__}.Nowhere")
    linear = bspline_polynomials(1).astype(np.float32)
    kernel = spline_kernel(linear, linear, 2)
    grid = np.pad(np.arange(12.0, dtype=np.float32).reshape(3, 4), ((0, 1), (0, LANES - 1)), mode="wrap")
    result = np.zeros((1, 2))
    place, scale = np.where(np.arange(len(DERIVATIVES)) == 0, 0, -1)[None], np.ones(len(DERIVATIVES))
    x, y, t = np.array([0.5, 3.5]), np.array([1.0, 2.5]), np.array([0.25, 0.0])
    known = (x, y, t), (1.0, 1.0), (0, 3), np.arange(2)
    kernel((grid, grid + 1.0), *known, pad_to_lanes(linear[:1]), scale, place, result)
    np.testing.assert_allclose(result[0], [4.75, (8.0 + 11.0 + 0.0 + 3.0) / 4.0], rtol=1e-6)


def test_importing_the_sea_does_not_import_the_compiler():
    code = "import sys, seamap_rt.sea; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
