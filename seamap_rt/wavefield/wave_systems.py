"""Wave systems of a sea by maximum likelihood, from the heights of some turns: also of waves longer than the circle.

A sea is taken as the sum of a few systems, each a JONSWAP spectrum (Hasselmann et al. 1973) spread as cos^2s(θ/2). Two
kinds of data tell them. Waves longer than a fourth of the circle or so are few in it, and no periodogram resolves them:
there heights, averaged over blocks, are compared as they are, each at its place and time, with a Gaussian sea of the
systems' covariance, so that the record in time counts as the record in space does. Shorter waves are many: their
periodogram is that of the systems, with exponential chance (Whittle 1953). The sum of both log-likelihoods is climbed
by Fisher's scoring; its information matrix gives the errors, with the chance of so few waves included.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve_triangular
from scipy.special import gammaln, ndtr

from ..compute.machine import one_blas_thread
from ..physics.dispersion import Water
from .wave_direction import Travel
from .wave_spectrum import WaveSpectrum

Field = NDArray[np.float64]

_SPLIT = 9.0  # of kR: waves up to here are compared as they are, shorter ones by their periodogram
_LEAK = 3.0  # times that: of waves which blocks still hold a part of
_BLOCKS = 7.0  # in a circle's radius
_FULL = 0.4  # of a block, that is in sight: of emptier ones the crests alone are seen
_LONGEST_S, _STEP = 26.0, 0.07  # periods that are looked for; relative, between frequencies
_DIRECTIONS = 36
_BASIS = 3.0  # /R, between wavevectors that the data are reduced to
_BEFORE = (
    (15.0, 0.8),
    (2.5, 0.6),
)  # exponent s of cos^2s and peak enhancement, and how well their logarithms are known
_GAIN_KNOWN = 0.4  # of the periodogram's level, its logarithm: gaps scatter what they hide
_MODEL_KNOWN = 0.4  # of a ring's power, relative: no sea is a sum of such systems
_LEAST_NOISE = 0.02  # of the variance: blocks' heights err by more than their cells' noise
_HIDDEN = 0.3  # of the variance, by the square of the share of a block that is not in sight
_UNLIKE, _UNEVEN = 1.2, 0.4  # of the variances, and of chance: real seas are no sums of such systems
_AGAINST = 8.0  # of log-likelihood, against systems that run against the water's velocity
_TOLD = 0.5  # share that cells keep, of waves that are looked at
_LEVEL_KNOWN = 0.1  # of σ: heights in sight are those of crests rather, all around alike, and with the distance
_WORTH = 8.0  # of log-likelihood, for a further system
_MOST = 3
_RINGS, _WAYS = np.geomspace(0.02, 0.9, 48), 36  # rad/m, of a periodogram; and its directions
_NEW_WAVES = 0.05  # of the waves of a turn that those of the one before were not
_ITERATIONS = 10
_POINTS, _MODES = 400, 600  # that a sea's covariance is worked out of and with
_SURE = 1.5  # of log-likelihood, by which waves run one way rather than the other
_BROAD = 8.0  # exponent of systems that are tried
_OWN, _SMALL = 5, 0.02  # values that a system has, and their change for a slope


@dataclass(frozen=True)
class WaveSystem:
    """variance [m²]; frequency [Hz], intrinsic, of the peak; toward [rad]; exponent s of cos^2s(θ/2)."""

    variance: float
    frequency: float
    toward: float
    exponent: float = _BEFORE[0][0]
    enhancement: float = _BEFORE[1][0]


@dataclass(frozen=True)
class Heights:
    """Of one turn; arrays (cell,): x, y [m], time [s], height [m], noise [m²], weight [m²]."""

    x: Field
    y: Field
    time: Field
    height: Field
    noise: Field
    weight: Field


@dataclass(frozen=True)
class Periodogram:
    """Mean power [m²] by ring of wavenumber [rad/m] and direction [rad]; arrays (ring, direction)."""

    wavenumber: Field  # (ring,)
    toward: Field  # (direction,)
    power: Field
    floor: Field
    count: Field  # waves of the sea that each mean is of
    transfer: Field  # (ring,) share of the variance that cells keep
    area: float  # m²
    line_width: float  # rad/m, standard deviation of a single wave's line

    @classmethod
    def of(cls, modes: WaveSpectrum, transfer: Callable[[Field], Field], area: float, line_width: float) -> Periodogram:
        """Of the modes of one turn's map. transfer: share of waves' variance that its cells keep, by wavenumber."""
        step = float(np.log(_RINGS[1] / _RINGS[0]))
        ring = np.rint(np.log(modes.wavenumber / _RINGS[0]) / step).astype(np.intp)
        inside = (ring >= 0) & (ring < _RINGS.size)
        way = np.rint(modes.toward / (2.0 * np.pi) * _WAYS).astype(np.intp) % _WAYS
        entry, ring = (ring * _WAYS + way)[inside], ring[inside]
        shape, size = (_RINGS.size, _WAYS), _RINGS.size * _WAYS
        count = np.bincount(entry, minlength=size).reshape(shape)
        power = np.bincount(entry, (modes.power + modes.floor)[inside], size).reshape(shape)
        members = np.maximum(np.bincount(ring, minlength=_RINGS.size), 1)
        floor = np.bincount(ring, modes.floor[inside], _RINGS.size) / members
        lattice = (2.0 * np.pi / float(np.median(np.diff(modes.ring_wavenumber)))) ** 2 / area
        return cls(
            _RINGS,
            2.0 * np.pi * np.arange(_WAYS) / _WAYS,
            power / np.maximum(count, 1),
            np.broadcast_to(floor[:, None], shape),
            count / lattice,
            transfer(_RINGS),
            area,
            line_width,
        )


def mean_periodogram(each: Sequence[Periodogram]) -> Periodogram:
    """Of some turns on end, whose waves are mostly the same ones."""
    count = np.sum([one.count for one in each], axis=0)
    power = np.sum([one.count * one.power for one in each], axis=0) / np.maximum(count, 1e-12)
    means = {
        name: np.mean([getattr(one, name) for one in each], axis=0)
        for name in ("floor", "transfer", "area", "line_width")
    }
    worth = 1.0 + _NEW_WAVES * (len(each) - 1)
    return replace(each[-1], power=power, count=worth * count / len(each), **means)


@dataclass(frozen=True)
class WaveSystems:
    """What was found: systems, strongest first, and the covariance of (ln variance, ln frequency, toward, ln s) of each
    in turn, (4 n, 4 n)."""

    systems: tuple[WaveSystem, ...]
    covariance: Field
    likelihood: float
    gain: float
    nugget: float
    way_known: bool
    water: Water
    split: float  # rad/m, up to which waves were compared as they are

    def density(self, frequency: ArrayLike) -> Field:
        """m²/Hz of all systems."""
        at = np.asarray(frequency, np.float64)
        return np.sum([each.variance * jonswap(at, each.frequency, each.enhancement) for each in self.systems], axis=0)

    def table(self, wavenumber: Field, toward: Field) -> Field:
        """Variance density by wavevector [m⁴], (wavenumber, direction)."""
        frequency = self.water.frequency(wavenumber) / (2.0 * np.pi)
        per_wavevector = self.water.group_speed(wavenumber) / (2.0 * np.pi * wavenumber)
        return np.sum(
            [
                (each.variance * jonswap(frequency, each.frequency, each.enhancement) * per_wavevector)[:, None]
                * spread(toward - each.toward, each.exponent)
                for each in self.systems
            ],
            axis=0,
        )

    def figures(self, samples: float) -> dict[str, float]:
        """Peak period, mean direction and spread, with standard errors, from so many independent heights."""
        period, error = self._peak()
        figures = {"peak_period": period, "peak_period_std": error}
        values = np.array([_values_of(each) for each in self.systems])

        def moment(of: Field) -> complex:
            weight = np.exp(of[:, 0] - of[:, 0].max())
            exponent = np.exp(of[:, 3])
            return complex(np.sum(weight * np.exp(1j * of[:, 2]) * exponent / (exponent + 1.0)) / weight.sum())

        mean = moment(values)
        slopes = np.zeros((2, values.size))
        for n in range(values.size):
            moved = values.copy()
            moved.flat[n] += 1e-4
            change = moment(moved) / mean
            slopes[:, n] = np.angle(change) / 1e-4, (abs(change) - 1.0) * abs(mean) / 1e-4
        turned, shrunk = np.sqrt(np.einsum("in,nm,im->i", slopes, self.covariance, slopes))
        wide = np.sqrt(2.0 * max(1.0 - abs(mean), 1e-6))
        chance = _UNEVEN * wide / np.sqrt(0.5 * samples)
        toward = float(np.degrees(np.angle(mean)))
        figures |= {"mean_axis": toward % 180.0}
        if not self.way_known:
            return figures
        return figures | {
            "mean_direction": (toward + 180.0) % 360.0,
            "mean_direction_std": float(np.degrees(np.hypot(turned, chance))),
            "directional_spread": float(np.degrees(wide)),
            "directional_spread_std": float(np.degrees(shrunk / wide)),
        }

    def _peak(self) -> tuple[float, float]:
        """Period of the highest peak [s] and its standard error: by its own frequency's, and by the chance that another
        system's peak is the higher one."""
        level = np.log([float(self.density(each.frequency)) for each in self.systems])
        first = int(np.argmax(level))
        period = 1.0 / self.systems[first].frequency
        variance = self.covariance[_OWN * first + 1, _OWN * first + 1] * period**2
        for n, other in enumerate(self.systems):
            if n != first:
                at = [_OWN * first, _OWN * n]
                own = self.covariance[np.ix_(at, at)]
                unsure = np.sqrt(max(own[0, 0] + own[1, 1] - 2.0 * own[0, 1], 1e-12))
                chance = float(ndtr((level[n] - level[first]) / unsure))
                variance += chance * (1.0 / other.frequency - period) ** 2
        return period, float(np.sqrt(variance))

    def samples(self, turns: Sequence[Heights]) -> float:
        """Independent normal heights that the mean square of some turns' heights is worth: V² over the mean of C² over
        pairs of places and times, C the systems' covariance."""
        stream = np.random.default_rng(0)
        each = max(_POINTS // len(turns), 20)
        rows = []
        for turn in turns[-_POINTS // 20 :]:
            at = stream.choice(turn.x.size, each, p=turn.weight / turn.weight.sum())
            rows.append(np.stack((turn.x[at], turn.y[at], turn.time[at])))
        x, y, time = np.concatenate(rows, axis=1)
        total = sum(system.variance for system in self.systems)
        frequency, toward = [], []
        for system in self.systems:
            count = int(np.ceil(_MODES * system.variance / total))
            grid = system.frequency * np.geomspace(0.4, 12.0, 800)
            cumulative = np.cumsum(jonswap(grid, system.frequency, system.enhancement) * np.gradient(grid))
            quantile = (np.arange(count) + 0.5) / count
            frequency.append(np.interp(quantile, cumulative / cumulative[-1], grid))
            angle = np.linspace(-np.pi, np.pi, 721)
            fan = np.cumsum(spread(angle, system.exponent))
            toward.append(system.toward + np.interp(stream.permutation(quantile), fan / fan[-1], angle))
        way, k = np.concatenate(toward), self.water.wavenumber(2.0 * np.pi * np.concatenate(frequency))
        waves = _waves(k * np.sin(way), k * np.cos(way), self.water, x - x.mean(), y - y.mean(), time - time.mean())
        covariance = np.real(waves @ waves.conj().T) / k.size
        pairs = ~np.eye(x.size, dtype=bool)
        # As few waves as stand for the sea raise the mean by half of one over their number.
        return float(1.0 / max(np.mean(covariance[pairs] ** 2) - 0.5 / k.size, 1e-5))


def jonswap(frequency: Field, peak: float, gamma: float) -> Field:
    """Density [1/Hz] of a spectrum of variance 1; its level by DNV-RP-C205 (2010), to 3e-3."""
    ratio = np.asarray(frequency, np.float64) / peak
    width = np.where(ratio < 1.0, 0.07, 0.09)
    with np.errstate(over="ignore", under="ignore"):
        shape = ratio**-5.0 * np.exp(-1.25 * ratio**-4.0) * gamma ** np.exp(-0.5 * ((ratio - 1.0) / width) ** 2)
    return shape / (peak * (0.065 * gamma**0.803 + 0.135))


def spread(angle: Field, exponent: Field | float) -> Field:
    """Density [1/rad] of cos^2s(angle/2) over the circle."""
    s = np.asarray(exponent, np.float64)
    level = gammaln(s + 1.0) - gammaln(s + 0.5) - np.log(2.0 * np.sqrt(np.pi))
    return np.exp(level + 2.0 * s * np.log(np.maximum(np.abs(np.cos(0.5 * angle)), 1e-30)))


class _LongWaves:
    """The likelihood of blocks' heights, reduced to what the longest waves make of them."""

    def __init__(self, turns: Sequence[Heights], water: Water) -> None:
        reach = max(float(np.hypot(t.x - t.x.mean(), t.y - t.y.mean()).max()) for t in turns)
        self.reach = reach
        blocks = [_blocks(turn, reach / _BLOCKS) for turn in turns]
        x, y, time, value, noise = (np.concatenate(each) for each in zip(*blocks, strict=True))
        x, y, time = x - x.mean(), y - y.mean(), time - time.max()
        self.split = _SPLIT / reach
        most = float(water.frequency(np.array(_LEAK * self.split))) / (2.0 * np.pi)
        count = max(int(np.log(most * _LONGEST_S) / _STEP), 8)
        self.frequency = np.exp(np.linspace(-np.log(_LONGEST_S), np.log(most), count))
        self.step = np.gradient(self.frequency)
        self.toward = 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
        self.wavenumber = water.wavenumber(2.0 * np.pi * self.frequency)
        # Data reduced to waves of a coarse lattice, both ways in time.
        side = int(1.1 * _SPLIT / _BASIS) + 1
        grid: Field = np.arange(-side, side + 1, dtype=np.float64) * (_BASIS / reach)
        kx, ky = (np.asarray(each.ravel(), np.float64) for each in np.meshgrid(grid, grid, indexing="ij"))
        kept = np.hypot(kx, ky) < 1.1 * self.split
        basis = _waves(kx[kept], ky[kept], water, x, y, time)
        basis = np.concatenate((basis.real, basis.imag), axis=1) / np.sqrt(x.size)
        k = np.repeat(self.wavenumber, _DIRECTIONS)
        toward = np.tile(self.toward, count)
        modes = _waves(k * np.sin(toward), k * np.cos(toward), water, x, y, time)
        made = basis.T @ modes
        self.modes = np.concatenate((made.real, made.imag), axis=1)
        self.data = basis.T @ value
        self.noise = basis.T @ (noise[:, None] * basis)
        variance = float(np.mean(value**2))
        odd = basis.T @ np.stack((np.ones_like(x), np.hypot(x, y) / reach - 0.6), axis=1)
        self.noise += _LEVEL_KNOWN**2 * variance * (odd @ odd.T)
        self.white = basis.T @ basis
        self.noise += 1e-6 * max(variance, 1e-12) * np.eye(self.data.size) + _LEAST_NOISE * variance * self.white
        self.variance = variance

    def power(self, system: WaveSystem) -> Field:
        """m² of each mode, (frequency, direction)."""
        rings = system.variance * jonswap(self.frequency, system.frequency, system.enhancement) * self.step
        fan = spread(self.toward - system.toward, system.exponent)
        return rings[:, None] * (fan / fan.sum())

    def evaluate(self, power: Field, nugget: float, changes: Sequence[Field] = ()) -> tuple[float, Field, Field]:
        """Log-likelihood, its gradient and Fisher's information by some changes of the power; the last of them is of
        the nugget's logarithm."""
        both = np.concatenate((power.ravel(), power.ravel()))
        total = self.noise + nugget * self.white + (self.modes * both) @ self.modes.T
        try:
            root = np.linalg.cholesky(total)
        except np.linalg.LinAlgError:
            return -np.inf, np.zeros(0), np.zeros((0, 0))
        data = solve_triangular(root, self.data, lower=True, check_finite=False)
        value = -float(np.log(np.diag(root)).sum()) - 0.5 * float(data @ data)
        if not len(changes):
            return value, np.zeros(0), np.zeros((0, 0))
        modes = solve_triangular(root, self.modes, lower=True, check_finite=False)
        white = solve_triangular(root, solve_triangular(root, self.white, lower=True).T, lower=True)
        products = [(modes * np.concatenate((c.ravel(), c.ravel()))) @ modes.T for c in changes] + [nugget * white]
        gradient = np.array([0.5 * (data @ p @ data - np.trace(p)) for p in products])
        flat = np.array([p.ravel() for p in products])
        return value, gradient, 0.5 * flat @ flat.T


class _ShortWaves:
    """The likelihood of a periodogram of waves shorter than the split."""

    def __init__(self, given: Periodogram, split: float, water: Water) -> None:
        used = (given.wavenumber > split) & (given.transfer > _TOLD)
        self.given = replace(
            given,
            wavenumber=given.wavenumber[used],
            power=given.power[used],
            floor=given.floor[used],
            count=given.count[used] / (1.0 + _MODEL_KNOWN**2 * given.count[used].sum(axis=1, keepdims=True)),
            transfer=given.transfer[used],
        )
        k = self.given.wavenumber
        self.blur = given.line_width / k
        nodes = k[:, None] * (1.0 + self.blur[:, None] * np.sqrt(3.0) * np.array([-1.0, 0.0, 1.0]))
        nodes = np.maximum(nodes, 0.3 * k[:, None])
        self.frequency = water.frequency(nodes) / (2.0 * np.pi)
        # F(k) [m⁴] is S(f) D(θ) df/dk / k; of a sea of area A a mode holds F (2π)²/A.
        weight = np.array([1.0, 4.0, 1.0]) / 6.0 * water.group_speed(nodes) / (2.0 * np.pi * nodes)
        self.weight = weight * self.given.transfer[:, None] * (2.0 * np.pi) ** 2 / given.area

    def power(self, system: WaveSystem) -> Field:
        """m² that a mode is expected to hold, (ring, direction), of waves either way."""
        rings = (
            np.sum(self.weight * jonswap(self.frequency, system.frequency, system.enhancement), axis=1)
            * system.variance
        )
        wide = 2.0 / (2.0 / (system.exponent + 1.0) + self.blur**2) - 1.0
        angle = self.given.toward[None, :] - system.toward
        wide = np.maximum(wide, 0.5)[:, None]
        return rings[:, None] * (spread(angle, wide) + spread(angle + np.pi, wide))

    def evaluate(self, power: Field, gain: float, changes: Sequence[Field] = ()) -> tuple[float, Field, Field]:
        """As of long waves, but for the gain's logarithm as the last of what changes."""
        power, changes = gain * power, [gain * each for each in changes]
        changes = [*changes, power] if changes else changes
        total = power + self.given.floor
        held = self.given.count > 0.0
        count = np.where(held, self.given.count, 0.0)
        total = np.maximum(total, 1e-30)
        value = -float(np.sum(count * (np.log(total) + self.given.power / total)))
        if not len(changes):
            return value, np.zeros(0), np.zeros((0, 0))
        first = count * (self.given.power / total - 1.0) / total
        gradient = np.array([float(np.sum(first * c)) for c in changes])
        flat = np.array([(np.sqrt(count) * c / total).ravel() for c in changes])
        return value, gradient, flat @ flat.T


@one_blas_thread()
def find_systems(
    turns: Sequence[Heights],
    periodogram: Periodogram,
    direction: Travel,
    water: Water,
    start: WaveSystems | None = None,
) -> WaveSystems | None:
    """The systems of which the sea of some turns most likely is the sum; None of too few heights.

    start: systems from before, to begin with.
    """
    if sum(turn.x.size for turn in turns) < 100:
        return None
    long = _LongWaves(turns, water)
    if long.data.size < 4 or not long.variance > 0.0:
        return None
    short = _ShortWaves(periodogram, long.split, water)
    problem = _Problem(long, short, direction, water)
    found = problem.climb(start.systems, start.gain, start.nugget) if start is not None else None
    while found is None or len(found.systems) < _MOST:
        more = problem.with_one_more(found)
        if found is not None and more.likelihood < found.likelihood + _WORTH:
            break
        found = more
    return found


class _Problem:
    def __init__(self, long: _LongWaves, short: _ShortWaves, direction: Travel, water: Water) -> None:
        self.long, self.short, self.direction, self.water = long, short, direction, water
        least, most = np.log(1.0 / _LONGEST_S), np.log(short.frequency[-1, 1] if short.frequency.size else 0.3)
        self.peaks = np.exp(np.arange(least + 0.3, most, 0.22))
        self.bounds = least, max(most, least + 1.0)

    def with_one_more(self, found: WaveSystems | None) -> WaveSystems:
        """With the further system that the data ask for most."""
        before = found.systems if found is not None else ()
        gain, nugget = (found.gain, found.nugget) if found is not None else (1.0, 0.05 * self.long.variance)
        rest = self.long.variance * (1.0 if found is None else 0.25)
        base_long = sum((self.long.power(each) for each in before), np.zeros((self.long.frequency.size, _DIRECTIONS)))
        base_short = sum((self.short.power(each) for each in before), np.zeros(self.short.given.power.shape))
        tried: list[tuple[float, WaveSystem]] = []
        for peak in self.peaks:
            for toward in self.long.toward[::3]:
                one = WaveSystem(rest, float(peak), float(toward), _BROAD)
                value = self.long.evaluate(base_long + self.long.power(one), nugget)[0]
                value += self.short.evaluate(base_short + self.short.power(one), gain)[0] - self._against(one)
                tried.append((value, one))
        best = max(tried, key=lambda each: each[0])[1]
        found = self.climb((*before, best), gain, nugget)
        for n, system in enumerate(found.systems):  # a climb does not turn a system round
            turned = list(found.systems)
            turned[n] = replace(system, toward=system.toward + np.pi)
            if self._likelihood(turned, found.gain, found.nugget) > found.likelihood:
                found = self.climb(tuple(turned), found.gain, found.nugget)
        return found

    def _likelihood(self, systems: Sequence[WaveSystem], gain: float, nugget: float) -> float:
        values = np.array([_values_of(each) for each in systems]).ravel()
        return self._at(np.append(values, (np.log(gain), np.log(nugget))))[0]

    def climb(self, systems: tuple[WaveSystem, ...], gain: float, nugget: float) -> WaveSystems:
        """Fisher's scoring from some systems."""
        values = np.array([_values_of(each) for each in systems])
        shape = values.shape
        values = np.append(values.ravel(), (np.log(gain), np.log(nugget)))
        best, gradient, information = self._at(values)
        damping = 1e-2
        for _ in range(_ITERATIONS):
            step = np.linalg.solve(information + damping * np.diag(np.diag(information)), gradient)
            tried = values + np.clip(step, -0.7, 0.7)
            rows = tried[:-2].reshape(shape)
            rows[:, 1] = np.clip(rows[:, 1], *self.bounds)
            rows[:, 3] = np.clip(rows[:, 3], np.log(1.0), np.log(200.0))
            rows[:, 4] = np.clip(rows[:, 4], np.log(0.7), np.log(20.0))
            value, grad, info = self._at(tried)
            if value > best - 1e-9:
                done = value - best < 0.1
                values, best, gradient, information = tried, value, grad, info
                damping = max(0.3 * damping, 1e-4)
                if done:
                    break
            else:
                damping *= 8.0
                if damping > 1e3:
                    break
        covariance = _UNLIKE * np.linalg.inv(information)[:-2, :-2]
        made = [_system_of(row) for row in values[:-2].reshape(shape)]
        order = np.argsort([-each.variance for each in made])
        index = (_OWN * order[:, None] + np.arange(_OWN)).ravel()
        gain, nugget = (float(each) for each in np.exp(values[-2:]))
        values[2:-2:_OWN] += np.pi
        sure = self._at(values)[0] < best - _SURE
        systems = tuple(made[n] for n in order)
        errors = np.asarray(covariance[np.ix_(index, index)], np.float64)
        return WaveSystems(systems, errors, best, gain, nugget, bool(sure), self.water, self.long.split)

    def _against(self, system: WaveSystem) -> float:
        """What is taken off for a system that runs against the water's velocity; half of it where nothing tells."""
        k = np.interp([system.frequency], self.long.frequency, self.long.wavenumber)
        forth = float(self.direction.forth(k * np.sin(system.toward), k * np.cos(system.toward))[0])
        return 0.5 * _AGAINST * (1.0 - forth)

    def _at(self, values: NDArray[Any]) -> tuple[float, Field, Field]:
        """Log of the likelihood and of what is known beforehand, its gradient, and the information."""
        gain, nugget = (float(each) for each in np.exp(values[-2:]))
        rows = values[:-2].reshape(-1, _OWN)
        total: list[Field | float] = [0.0, 0.0]
        changes: tuple[list[Field], list[Field]] = ([], [])
        for row in rows:
            for n, part in enumerate((self.long, self.short)):
                power = part.power(_system_of(row))
                total[n] = total[n] + power
                changes[n].append(power)
                for column in range(1, _OWN):
                    up, down = row.copy(), row.copy()
                    up[column], down[column] = row[column] + _SMALL, row[column] - _SMALL
                    difference = part.power(_system_of(up)) - part.power(_system_of(down))
                    changes[n].append(difference / (2.0 * _SMALL))
        value, first, information_long = self.long.evaluate(np.asarray(total[0]), nugget, changes[0])
        if not np.isfinite(value):
            return -np.inf, np.zeros(values.size), np.eye(values.size)
        other, second, information_short = self.short.evaluate(np.asarray(total[1]), gain, changes[1])
        value += other - sum(self._against(_system_of(row)) for row in rows)
        gradient, information = np.zeros(values.size), np.zeros((values.size, values.size))
        long = np.append(np.arange(values.size - 2), values.size - 1)
        gradient[long] += first
        information[np.ix_(long, long)] += information_long
        gradient[:-1] += second
        information[:-1, :-1] += information_short
        for column, (middle, known) in zip((3, 4), _BEFORE, strict=True):
            at = np.arange(column, values.size - 2, _OWN)
            apart = (values[at] - np.log(middle)) / known
            value -= 0.5 * float(apart @ apart)
            gradient[at] -= apart / known
            information[at, at] += known**-2
        value -= 0.5 * (values[-2] / _GAIN_KNOWN) ** 2
        gradient[-2] -= values[-2] / _GAIN_KNOWN**2
        information[-2, -2] += _GAIN_KNOWN**-2
        return value, gradient, information + 1e-3 * np.eye(values.size)


def _values_of(system: WaveSystem) -> list[float]:
    """ln variance, ln frequency, toward, ln exponent, ln enhancement."""
    logs = (system.variance, system.frequency, 1.0, system.exponent, system.enhancement)
    values = [float(np.log(each)) for each in logs]
    values[2] = system.toward
    return values


def _system_of(values: NDArray[Any]) -> WaveSystem:
    variance, frequency, _, exponent, enhancement = (float(each) for each in np.exp(np.minimum(values, 50.0)))
    return WaveSystem(variance, frequency, float(values[2]), exponent, enhancement)


def _waves(kx: Field, ky: Field, water: Water, x: Field, y: Field, time: Field) -> NDArray[np.complex128]:
    """e^(j(k·x − ω t)), (place, wave)."""
    omega = water.frequency(np.hypot(kx, ky)) + water.doppler_shift(kx, ky)
    return np.exp(1j * (np.multiply.outer(x, kx) + np.multiply.outer(y, ky) - np.multiply.outer(time, omega)))


def _blocks(turn: Heights, side: float) -> tuple[Field, Field, Field, Field, Field]:
    """x, y, time, height, noise of squares that are in sight."""
    i, j = (np.floor(each / side).astype(np.intp) for each in (turn.x, turn.y))
    i, j = i - i.min(), j - j.min()
    block = i * (int(j.max()) + 1) + j
    weight = np.bincount(block, turn.weight)
    full = weight > _FULL * side**2
    safe = np.maximum(weight, 1e-12)
    x, y, time, height = (
        np.bincount(block, turn.weight * each)[full] / safe[full] for each in (turn.x, turn.y, turn.time, turn.height)
    )
    noise = np.bincount(block, turn.weight**2 * turn.noise)[full] / safe[full] ** 2
    dark = np.maximum(1.0 - weight[full] / side**2, 0.0)
    return x, y, time, height, noise + _HIDDEN * dark**2 * float(np.mean(height**2))
