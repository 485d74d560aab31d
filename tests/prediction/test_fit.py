"""The fit against what linear algebra gives: means and errors of a Gaussian sea, seen at some places."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import cast

import numpy as np
import pytest
import xarray as xr
from free_waves import gaussian_system
from numpy.typing import NDArray

from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.physics.dispersion import Water
from seamap_rt.prediction import Observations, Spectrum, reconstruct
from seamap_rt.prediction.assimilation import Batch, Preconditioner, StrongestWaves, solve, weights
from seamap_rt.prediction.field import WaveField
from seamap_rt.prediction.fit import Fit
from seamap_rt.prediction.knowledge import BatchCoverage, Groups, Knowledge
from seamap_rt.prediction.observations import KINDS, turn_observations
from seamap_rt.prediction.spectrum import Lattice
from seamap_rt.prediction.wave_sum import WaveSum
from seamap_rt.settings import PredictionSettings

Field = NDArray[np.float64]


def wind_sea(depth: float = np.inf) -> Spectrum:
    """Pierson and Moskowitz's spectrum of 6 s from the west."""
    omega = np.linspace(0.5, 4.0, 400)
    line = 8.1e-3 * 9.81**2 * omega**-5.0 * np.exp(-1.25 * (1.05 / omega) ** 4)
    return Spectrum.of_frequency(omega, line, 270.0, 5.0, Water(depth=depth))


def lattice(spectrum: Spectrum, side: int = 21, radius: float = np.inf) -> Lattice:
    """So coarse that it can be summed plainly."""
    return Lattice.of(spectrum, side, 0.02, (0.0, 0.02 * (side // 2)), radius)


def places(count: int, seed: int = 1, wide: float = 40.0, long: float = 2.0, kind: str = "elevation") -> Observations:
    """Random values at random places and times."""
    stream = np.random.default_rng(seed)
    x, y = wide * stream.uniform(-1.0, 1.0, (2, count))
    return Observations(
        x, y, 50.0 + long * stream.random(count), stream.normal(0.0, 0.5, count), np.array([0.1]), np.array([kind])
    )


def blurred(seen: Observations, along: float, across: float, look: Field) -> Observations:
    """Means over areas [m] along and across looks [deg]."""
    return replace(seen, blur_along=np.array([along]), blur_across=np.array([across]), look=look)


def plain(of: Lattice, seen: Observations, factor: NDArray[np.complex128], amplitudes: NDArray[np.complex128]) -> Field:
    """Re Σ f a e^j(k·x − ωt), with the blur."""
    phase = np.multiply.outer(seen.x, of.kx) + np.multiply.outer(seen.y, of.ky) - np.multiply.outer(seen.time, of.omega)
    look = np.radians(seen.look)[:, None, None]
    along = (of.kx * np.sin(look) + of.ky * np.cos(look)) * seen.blur_along[:, None, None]
    across = (of.kx * np.cos(look) - of.ky * np.sin(look)) * seen.blur_across[:, None, None]
    blur = np.exp(-0.5 * (along**2 + across**2))
    return np.real(np.sum(blur * factor * amplitudes * np.exp(1j * phase), axis=(1, 2)))


def covariance(of: Lattice, one: Field, other: Field) -> Field:
    """Of the elevation between events (n, 3) of x, y, t."""
    carried = of.scale > 0.0
    waves = np.stack([of.kx[carried], of.ky[carried], -of.omega[carried]])
    mine, theirs = (of.scale[carried] * np.exp(1j * (each @ waves)) for each in (one, other))
    return np.real(mine @ theirs.conj().T)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("blur", [(0.0, 0.0), (2.0, 2.0), (3.0, 1.0)])
@pytest.mark.parametrize("count", [50, 150])
def test_sums_are_those_of_the_waves(kind: str, blur: tuple[float, float], count: int) -> None:
    # A few places are summed plainly, many are transformed to.
    spectrum = wind_sea(depth=20.0)
    of, seen = lattice(spectrum), blurred(places(count, kind=kind), *blur, look=np.array([30.0]))
    made = WaveSum(seen, [of], spectrum.water, np.ones(count), (0.0, 0.0))
    stream = np.random.default_rng(3)
    amplitudes = of.scale * (stream.normal(size=of.k.shape) + 1j * stream.normal(size=of.k.shape))
    expected = plain(of, seen, of.factor(kind, spectrum.water), amplitudes)
    # 1e-3 of the transforms and a hundredth by the last term in time.
    got = made.values([amplitudes.astype(np.complex64)])
    assert np.sqrt(np.mean((got - expected) ** 2)) < 0.012 * np.std(expected)


@pytest.mark.parametrize("count", [80, 400])
def test_the_adjoint_is_one(count: int) -> None:
    # ⟨H a, y⟩ = Re ⟨a, Hᴴ y⟩ to the transforms' own error.
    spectrum = wind_sea()
    both = [lattice(spectrum), lattice(spectrum, 31, 25.0)]
    seen = places(count)
    made = WaveSum(seen, both, spectrum.water, np.ones(count), (0.0, 0.0))
    stream = np.random.default_rng(4)
    amplitudes = [
        (stream.normal(size=each.k.shape) + 1j * stream.normal(size=each.k.shape)).astype(np.complex64) for each in both
    ]
    values = stream.normal(size=count).astype(np.float32)
    there = float(np.dot(made.values(amplitudes), values))
    back = sum(np.vdot(a, b).real for a, b in zip(amplitudes, made.amplitudes(values), strict=True))
    size = float(np.linalg.norm(made.values(amplitudes)) * np.linalg.norm(values))
    assert abs(there - back) < 5e-3 * size


def test_places_wider_apart_than_the_waves_period_are_refused() -> None:
    spectrum = wind_sea()
    of = lattice(spectrum)
    period = 2.0 * np.pi / of.spacing
    with pytest.raises(ValueError, match="farther apart than the waves' period"):
        WaveSum(places(150, wide=0.51 * period), [of], spectrum.water, np.ones(150), (0.0, 0.0))


@pytest.mark.parametrize("count", [80, 400])
def test_sums_at_moved_places_are_those_there(count: int) -> None:
    spectrum = wind_sea()
    of, seen = lattice(spectrum), places(count)
    x, y = seen.x + 3.0, seen.y - 2.0
    moved = WaveSum(seen, [of], spectrum.water, np.ones(count), (0.0, 0.0)).moved(x, y)
    there = WaveSum(replace(seen, x=x, y=y), [of], spectrum.water, np.ones(count), (0.0, 0.0))
    amplitudes = [of.scale.astype(np.complex64)]
    np.testing.assert_allclose(moved.values(amplitudes), there.values(amplitudes), atol=2e-3 * np.sqrt(of.variance))


def test_few_areas_are_each_their_own() -> None:
    spectrum = wind_sea()
    of, seen = lattice(spectrum), blurred(places(60), 3.0, 0.5, look=np.linspace(0.0, 354.0, 60))
    made = WaveSum(seen, [of], spectrum.water, np.ones(60), (0.0, 0.0))
    amplitudes = (of.scale * random_unknowns(of, 3)[0]).astype(np.complex64)
    expected = plain(of, seen, np.ones(of.k.shape, np.complex128), amplitudes.astype(np.complex128))
    assert np.sqrt(np.mean((made.values([amplitudes]) - expected) ** 2)) < 0.012 * np.std(expected)


def test_values_of_long_areas_become_those_of_round_ones() -> None:
    # Exact means over areas of 1.3 m by 0.5 m, each along its own look, of known waves of 16 m and longer:
    # ½ k·(B − B̄)·k is up to 0.06 there, and half of it is the next order's share of the first: most waves are longer,
    # so a tenth.
    spectrum = wind_sea()
    fit = Fit(spectrum, [lattice(spectrum, 41)], 100.0, (0.0, 0.0))
    of, seen = fit.lattices[0], blurred(places(300), 1.3, 0.5, look=np.linspace(0.0, 2093.0, 300))
    fit.unknowns = random_unknowns(of, 3)
    exact = plain(of, seen, np.ones(of.k.shape, np.complex128), fit.amplitudes[0].astype(np.complex128))
    fit.add([replace(seen, value=exact)], [0])
    fit.relabel(0.0)
    for batch in fit.all_batches:
        alike = batch.sum.values(fit.amplitudes)
        shape = np.std(batch.seen.value - alike)
        assert np.std(fit.remove_setdown(batch) - alike) < 0.1 * shape


def random_unknowns(of: Lattice, seed: int) -> list[NDArray[np.complex64]]:
    stream = np.random.default_rng(seed)
    return [(stream.normal(size=of.k.shape) + 1j * stream.normal(size=of.k.shape)).astype(np.complex64)]


def one_batch(of: Lattice, seen: Observations, spectrum: Spectrum) -> Batch:
    """Observations that count by their own errors alone, however many tell the same waves."""
    _, variance = weights(seen, [of], 0.0, (0.0, 0.0))
    weight = 1.0 / variance
    return Batch(seen, WaveSum(seen, [of], spectrum.water, weight, (0.0, 0.0)), weight, variance)


def test_what_is_told_alike_everywhere_is_turned_back_by_each_wave() -> None:
    # Places as dense everywhere, at one moment: waves do not meet, and 1 + Σ w S / 2 is each one's own. The strongest,
    # which are not turned back by zones, take places by squares.
    spectrum = wind_sea()
    of = lattice(spectrum)
    step = 2.0 * np.pi / of.spacing / of.k.shape[0] * np.arange(of.k.shape[0])
    x, y = (each.ravel() for each in np.meshgrid(step, step, indexing="ij"))
    seen = Observations(x, y, np.full(x.size, 50.0), np.zeros(x.size), np.array([0.1]), np.array(["elevation"]))
    unknowns = random_unknowns(of, 5)
    batch = one_batch(of, seen, spectrum)
    with ThreadPoolExecutor(1) as workers:
        (got,) = Preconditioner([batch], [of], workers)(unknowns)
    expected = unknowns[0] / (1.0 + 0.5 * seen.x.size / 0.1**2 * of.scale**2)
    by_zones = np.ones(got.shape, bool)
    by_zones.ravel()[StrongestWaves(of, [batch]).chosen] = False
    assert by_zones.any()
    np.testing.assert_allclose(got[by_zones], expected[by_zones], atol=1e-5 * np.abs(expected).max())


def test_the_strongest_waves_are_turned_back_exactly() -> None:
    # Of places that lie each in a square of its own: the operator of what is turned back, of these waves alone, is what
    # it was turned back from, to single precision of numbers that lie a million apart.
    spectrum, stream = wind_sea(), np.random.default_rng(1)
    of, step = lattice(spectrum), 80.0 / 9.0
    x, y = (each.ravel() + stream.uniform(-1.0, 1.0, 81) for each in np.meshgrid(*(step * np.arange(9.0),) * 2))
    seen = replace(places(81), x=x - 40.0, y=y - 40.0)
    batch = one_batch(of, seen, spectrum)
    strongest = StrongestWaves(of, [batch])
    assert strongest.chosen.size > 50
    unknowns = random_unknowns(of, 5)[0].ravel()[strongest.chosen]
    got = np.zeros(of.k.size, np.complex64)
    got[strongest.chosen] = strongest.apply_inverse(unknowns)
    got, root = got.reshape(of.k.shape), of.scale.astype(np.float32)
    values = batch.weight.astype(np.float32) * batch.sum.values([(root * got).astype(np.complex64)])
    again = got + root * batch.sum.amplitudes(values)[0]
    np.testing.assert_allclose(again.ravel()[strongest.chosen], unknowns, atol=0.02)


def test_the_preconditioner_is_its_own_adjoint_and_positive() -> None:
    spectrum = wind_sea()
    of = lattice(spectrum)
    one, other = random_unknowns(of, 6), random_unknowns(of, 7)
    with ThreadPoolExecutor(1) as workers:
        precondition = Preconditioner([one_batch(of, places(150, wide=60.0), spectrum)], [of], workers)
        from_one, from_other = precondition(one)[0], precondition(other)[0]
    there, back = np.vdot(from_one, other[0]), np.vdot(one[0], from_other)
    # Real and imaginary parts are unknowns of their own: waves that run against each other meet in a sum's real part.
    assert abs((there - back).real) < 1e-4 * abs(np.vdot(one[0], from_one))
    assert np.vdot(one[0], from_one).real > 0.0


def test_the_fit_is_the_conditional_mean() -> None:
    # Of a Gaussian sea: C(p, x) (C(x, x) + σ²)⁻¹ y, to the hundredth that the first term in time left out is worth.
    spectrum = wind_sea()
    of, seen = lattice(spectrum), places(60)
    batch = one_batch(of, seen, spectrum)
    with ThreadPoolExecutor(1) as workers:
        found, _ = solve([batch], [of], workers)
        for _ in range(30):  # each goes on by some steps
            found, _ = solve([batch], [of], workers, found)
    at = np.array([[5.0, 3.0, 54.0], [0.0, 0.0, 50.0], [30.0, -20.0, 51.0], [80.0, 0.0, 60.0]])
    events = np.stack([seen.x, seen.y, seen.time], axis=1)
    inverse = np.linalg.inv(covariance(of, events, events) + np.diag(seen.std**2))
    expected = covariance(of, at, events) @ inverse @ seen.value
    there = Observations(at[:, 0], at[:, 1], at[:, 2], np.zeros(4), np.ones(1), np.array(["elevation"]))
    got = plain(of, there, np.ones(of.k.shape, np.complex128), (of.scale * found[0]).astype(np.complex128))
    np.testing.assert_allclose(got, expected, atol=0.02 * np.sqrt(of.variance))


def test_a_fit_goes_on_where_a_wave_system_is_no_longer_expected() -> None:
    # Its waves' standard deviations fall to 1e-8 and below. A fit that goes on from there takes no more steps than one
    # from nothing, and sees the same sea where it was observed, to a tenth: solvers stop at some hundredths.
    swell, wind = gaussian_system(0.2, 9.0, 200.0, 40.0), gaussian_system(0.3, 5.0, 270.0, 20.0)
    both = replace(wind, table=wind.table + swell.table)
    seen = [replace(places(1000, seed=n, wide=80.0), time=np.full(1000, 50.0 + n)) for n in range(4)]
    fit, drawn = Fit.of(both, seen, 20.0, (0.0, 0.0)), []
    for each in seen:
        sea = WaveSum(each, fit.lattices, wind.water, np.ones(len(each)), (0.0, 0.0))
        waves = [of.rescaled(wind).scale * random_unknowns(of, 8)[0] for of in fit.lattices]
        drawn.append(replace(each, value=sea.values([part.astype(np.complex64) for part in waves]) + 0.2 * each.value))
    fit.add(drawn[:3], range(3))
    with ThreadPoolExecutor(1) as workers:
        fit.solve(workers)
        fit.renew(wind, (0.0, 0.0))
        fit.add(drawn[3:], [3])
        fit.update_weights()
        fit.solve(workers)
        going_on, steps = [batch.sum.values(fit.amplitudes) for batch in fit.all_batches], fit.steps
        fit.unknowns = None
        fit.solve(workers)
    assert steps <= fit.steps
    for batch, values in zip(fit.all_batches, going_on, strict=True):
        from_nothing = batch.sum.values(fit.amplitudes)
        assert np.std(values - from_nothing) < 0.1 * np.std(from_nothing)


def test_few_observations_weigh_by_their_errors_and_many_of_one_place_no_more_than_some() -> None:
    # Each at most 1 over its variance, and of some that lie apart nearly so. Of thousands in one place, whose waves are
    # told by far better than anybody asks, ten times as many weigh as much together to a few per cent.
    of = lattice(wind_sea())
    asked = (20, 400.0), (4000, 0.5), (40_000, 0.5)
    found = [weights(places(count, wide=wide), [of], 0.0, (0.0, 0.0)) for count, wide in asked]
    for weight, variance in found:
        np.testing.assert_allclose(variance, 0.1**2, rtol=1e-12)
        assert np.all((weight > 0.0) & (weight * variance <= 1.0))
    assert np.all(found[0][0] * found[0][1] > 0.8)
    assert found[2][0].sum() == pytest.approx(found[1][0].sum(), rel=0.05)


@pytest.fixture(scope="module")
def seen_by_few() -> tuple[WaveField, Observations]:
    """A sea seen at 400 places of a square, by a tenth of its height, over three seconds."""
    seen = places(400, wide=60.0, long=3.0)
    narrow = wind_sea()
    settings = PredictionSettings(sharpness=0.0, lead_s=15.0)
    return reconstruct(settings=settings, observations=seen, spectrum=narrow), seen


def test_errors_are_those_of_the_conditional_sea(seen_by_few: tuple[WaveField, Observations]) -> None:
    # C(p, p) − C(p, x) (C(x, x) + σ²)⁻¹ C(x, p), of all waves that are carried, and the rest as noise. Twelve samples,
    # each of two phases, at five places around, tell a standard error to 10 to 15 %; crowding and thinning cost little.
    field, seen = seen_by_few
    at = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 5.0], [40.0, 0.0, 3.0], [0.0, 60.0, 0.0], [90.0, 0.0, 8.0]])
    at[:, 2] += field.issued
    events = np.stack([seen.x, seen.y, seen.time], axis=1)
    left = field.spectrum.variance - sum(each.variance for each in field.lattices)
    of = field.lattices
    inner = sum(covariance(each, events, events) for each in of) + np.diag(seen.std**2 + left)
    across = sum(covariance(each, at, events) for each in of)
    variance = field.spectrum.variance - np.sum(across * (across @ np.linalg.inv(inner)), axis=1)
    _, std = field.elevation(*at.T)
    np.testing.assert_allclose(std, np.sqrt(variance), rtol=0.25)
    assert np.mean(np.log(std / np.sqrt(variance))) == pytest.approx(0.0, abs=0.12)


def one_group(spectrum: Spectrum, density: float, against: float) -> Groups:
    """Waves of 30 m to the east."""
    k = 2.0 * np.pi / 30.0
    omega, speed = (
        float(spectrum.water.frequency(np.array([k]))[0]),
        float(spectrum.water.group_speed(np.array([k]))[0]),
    )
    values = (k, 0.5 * np.pi, omega, omega, speed, 0.0, 0.01, density, against)
    return Groups(*(np.array([each]) for each in values))


@pytest.mark.parametrize("apart", [0.0, 0.25, 0.125])
@pytest.mark.parametrize("blur", [0.0, 2.0])
def test_what_stays_open_of_a_group_is_what_stays_open_of_its_wave(apart: float, blur: float) -> None:
    """A regression of one wave and of the one that runs against it on many places of a square that either repeats on,
    seen at two moments so many periods apart: the variances of amplitudes that the square's own lattice gives them."""
    spectrum, square, noise, count = wind_sea(), 300.0, 0.3, 4000
    group = one_group(spectrum, 0.6, 0.25)
    k, omega, lapse = group.k[0], group.omega[0], apart * 2.0 * np.pi / group.omega[0]
    x = np.random.default_rng(1).uniform(0.0, square, count)
    rows = [(np.cos(turn), -np.sin(turn)) for t in (0.0, lapse) for turn in (k * x - omega * t, -k * x - omega * t)]
    part = np.exp(-0.5 * (k * blur) ** 2)
    seen = part * np.concatenate(
        [np.stack((*rows[0], *rows[1]), axis=1), np.stack((*rows[2], *rows[3]), axis=1)]
    )  # (place, cosine and sine of each wave)
    prior = np.repeat((0.6, 0.25), 2) * (2.0 * np.pi / square) ** 2
    open_of = np.linalg.inv(np.diag(1.0 / prior) + seen.T @ seen / noise**2).diagonal()[:2].mean() / prior[0]

    information = np.full((80, 80), count / square**2 / noise**2, np.float32)
    area = np.array([blur**2, 0.0, blur**2], np.float32)
    coverages = tuple(
        BatchCoverage(t, information, np.broadcast_to(area[:, None, None], (3, 80, 80))) for t in (0.0, lapse)
    )
    known = Knowledge(group, (lattice(spectrum, 41),), coverages, (-400.0, -400.0), 10.0, (0.0, 0.0))
    found = known.open_share(np.zeros(1), np.zeros(1), np.array([lapse]), np.ones(1, bool))
    assert 0.02 < open_of < 0.98
    assert found[0, 0] == pytest.approx(open_of, rel=0.06)  # the places are random: 1/√4000, of both waves' sums


def test_water_seen_at_each_metre_is_known_evenly() -> None:
    """The information is the weight of what was seen per square metre, wherever that lies by the squares of the peak's
    length that it is summed on: of 30 places a square a row or two more or less are a seventh."""
    east, north = (each.ravel() for each in np.meshgrid(np.arange(-60.0, 60.5), np.arange(-60.0, 60.5)))
    seen = Observations(
        east, north, np.full(east.size, 3.0), np.zeros(east.size), np.array([0.1]), np.array(["elevation"])
    )
    batch = Batch(seen, cast(WaveSum, None), np.full(east.size, 0.7), np.ones(east.size))
    known = Knowledge.of(wind_sea(), (), [batch], (0.0, 0.0))
    (coverage,) = known.coverages
    shape = coverage.information.shape
    axes = [first + known.side * np.arange(size) for first, size in zip(known.corner, shape, strict=True)]
    inside = coverage.information[np.ix_(*(np.abs(each) < 40.0 for each in axes))]
    assert inside.mean() == pytest.approx(0.7, rel=0.05)
    assert inside.std() < 0.2 * inside.mean()


def test_a_map_s_cells_are_means_over_its_pulse_beam_and_look() -> None:
    """Second moments of the two-way Gaussian beam and of the look's own width, at each cell's distance; cells count
    that have no flag but the one of half hidden ones, an error that tells something, and lie beyond four antenna
    heights."""
    ranges, azimuth = np.array([15.0, 30.0, 60.0, 90.0]), np.array([10.0, 11.8, 13.6])
    shape, height = (3, 4), 5.0
    quality = np.zeros(shape, np.int16)
    quality[0, 1], quality[1, 1] = QUALITY_FLAGS["partly_shadowed"], QUALITY_FLAGS["ambiguous"]
    std = np.full(shape, 0.1)
    std[2, 2], std[1, 2] = 0.81, 0.79  # of a sea of 0.4 m
    dims = ("azimuth", "range")
    polar = xr.Dataset(
        {
            "height": (dims, np.zeros(shape)), "height_std": (dims, std), "quality": (dims, quality),
            "ground_range": (dims, np.broadcast_to(np.sqrt(ranges**2 - height**2), shape)),
            "time": ("azimuth", [1.0, 2.0, 3.0]), "dwell_height": (dims, 0.0 * std), "dwell_height_std": (dims, std),
        },
        {"azimuth": azimuth, "range": ranges},
        {"azimuth_beamwidth_deg": 1.8, "cell_range_m": 3.0, "pulse_m": 2.3},
    )  # fmt: skip
    seen = turn_observations(polar, 0.4)
    away = np.hypot(seen.x, seen.y)
    assert np.unique(np.round(np.hypot(away, height))).tolist() == [30.0, 60.0, 90.0]
    assert len(seen) == 9 - 2  # an ambiguous one and one in doubt
    angle = np.linspace(-6.0, 6.0, 4001)
    two_way = 0.5 ** (2.0 * (angle / 0.9) ** 2)  # a half, one way, at ±0.9°
    square = np.sum(two_way * angle**2) / two_way.sum() + 1.8**2 / 12.0
    np.testing.assert_allclose(seen.blur_across, np.radians(np.sqrt(square)) * away, rtol=1e-3)
    cells = turn_observations(polar.drop_vars(("dwell_height", "dwell_height_std")), 0.4)
    # Of means over cells of 3 m the variance is that much more, twice, as backs of waves are filled.
    np.testing.assert_allclose(cells.blur_along**2 - seen.blur_along**2, 2.0 * 3.0**2 / 12.0, rtol=1e-6)


def test_a_spectrum_by_frequency_keeps_its_variance_and_its_way() -> None:
    """∫ S dω, on deep and on shallow water; and the mean way of cos^2s(θ/2), whose first moment is s/(s + 1)."""
    omega = np.linspace(0.5, 4.0, 4000)
    line = 8.1e-3 * 9.81**2 * omega**-5.0 * np.exp(-1.25 * (1.05 / omega) ** 4)
    for depth in (np.inf, 8.0):
        made = Spectrum.of_frequency(omega, line, 250.0, 5.0, Water(depth=depth))
        assert made.variance == pytest.approx(np.trapezoid(line, omega), rel=0.01)  # of rings 7 % apart
        mean = np.sum(made.variances * np.exp(1j * made.toward)) / made.variance
        assert abs(mean) == pytest.approx(5.0 / 6.0, rel=1e-3)
        assert np.degrees(np.angle(mean)) % 360.0 == pytest.approx(70.0, abs=1e-6)
        assert made.peak_period == pytest.approx(2.0 * np.pi / 1.05, rel=0.06)


@pytest.mark.parametrize(("std", "ring"), [(50.0, (20.0, 150.0)), (0.05, (300.0, 400.0))])
def test_a_fit_reaches_as_far_as_what_was_seen_tells(std: float, ring: tuple[float, float]) -> None:
    """Heights of 300–400 m that err by 50 m tell nothing: they make no square wider, and cost no waves."""
    stream = np.random.default_rng(2)
    seen = []
    for first, last, error in ((20.0, 150.0, 0.05), (300.0, 400.0, std)):
        out, azimuth = stream.uniform(first, last, 400), stream.uniform(0.0, 2.0 * np.pi, 400)
        x, y, none = out * np.sin(azimuth), out * np.cos(azimuth), np.zeros(400)
        seen.append(Observations(x, y, none, none, np.full(400, error), np.array(["elevation"])))
    assert ring[0] < Fit.of(wind_sea(), seen, 20.0, (0.0, 0.0)).reach <= ring[1]
