"""The wave systems of a sea by maximum likelihood from some turns' heights, waves longer than the circle included.

A sea is taken as the sum of a few systems, each a JONSWAP spectrum (Hasselmann et al. 1973) spread as cos^2s(θ/2). Two
kinds of data tell them. Waves longer than a fourth of the circle or so are few in it, and no periodogram resolves them:
there heights, averaged over blocks, are compared as they are, each at its place and time, with a Gaussian sea of the
systems' covariance, so that the record in time counts as the record in space does. Shorter waves are many: their
periodogram is that of the systems, with exponential chance (Whittle 1953). The sum of both log-likelihoods is climbed
by Fisher's scoring; its information matrix gives the errors, with the chance of so few waves included.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from ..compute.machine import one_blas_thread
from ..physics.dispersion import Water
from ..physics.wave_spectra import cos2s
from .periodogram import Periodogram
from .wave_direction import Travel
from .wave_spectrum import Field
from .wave_systems import (
    ENHANCEMENT,
    EXPONENT,
    LONGEST,
    SYSTEM_VALUES,
    SYSTEM_WORTH,
    Heights,
    WaveSystem,
    WaveSystems,
    jonswap,
    plane_waves,
    system_of,
    values_of,
)

_SPLIT = 9.0  # of kR: waves up to here are compared as they are, shorter ones by their periodogram
_LEAK = 3.0  # times that: of waves which blocks still hold a part of
_BLOCKS = 7.0  # in a circle's radius
_FULL = 0.4  # of a block, that is in sight: of emptier ones the crests alone are seen
_LONGEST_S, _STEP = 26.0, 0.07  # periods that are looked for; relative, between frequencies
_DIRECTIONS = 36
_BASIS = 3.0  # /R, between wavevectors that the data are reduced to
_GAIN_KNOWN = 0.4  # of the periodogram's level, its logarithm: gaps scatter what they hide
_MODEL_KNOWN = 0.4  # of a ring's power, relative: no sea is a sum of such systems
_LEAST_NOISE = 0.02  # of the variance: blocks' heights err by more than their cells' noise
_HIDDEN = 0.3  # of the variance, by the square of the share of a block that is not in sight
_UNLIKE = 1.2  # of the errors' variances, over the square of the share in sight: crests are, and troughs are not
_VELOCITY_WEIGHT = 8.0  # of log-likelihood, against systems that run against the water's velocity
_LEAST_TRANSFER = 0.5  # share that cells keep, of waves that are looked at
_LEVEL_KNOWN = 0.3  # of σ: heights in sight are those of crests rather, all around alike, and with the distance
_MOST = 3
_ITERATIONS = 10
_LEAST_SEEN = 0.3
_BROAD = 8.0  # exponent of systems that are tried
_VARIANCES = np.geomspace(0.01, 3.0, 10)  # of a further system, over what was found
_LEAST_CHANCE = 1e-4  # of what is looked at
_SHIFTS = 0.1 * np.array([-8.0, -6.0, -4.5, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.5])  # of ln frequency
_SMALL = 0.02  # change of a value, for a slope


@one_blas_thread()
def find_systems(
    turns: Sequence[Heights],
    periodogram: Periodogram,
    direction: Travel,
    water: Water,
    start: WaveSystems | None = None,
    seen: float = 1.0,
) -> WaveSystems | None:
    """The systems of which the sea of some turns most likely is the sum; None of too few heights.

    start: systems from before, to begin with. seen: share of the sea that is in sight.
    """
    if sum(turn.x.size for turn in turns) < 100:
        return None
    long = _GaussianLikelihood(turns, water)
    if long.data.size < 4 or not long.variance > 0.0:
        return None
    short = _WhittleLikelihood(periodogram, long.split, water)
    posterior = _Posterior(long, short, direction, water, _UNLIKE / max(seen, _LEAST_SEEN) ** 2)
    found = posterior.maximize(start.systems, start.gain, start.nugget) if start is not None else None
    while found is None or len(found.systems) < _MOST:
        more = posterior.add_system(found)
        if found is not None and more.likelihood < found.likelihood + SYSTEM_WORTH:
            break
        found = more
    return posterior.with_errors(found)


class _Posterior:
    """unlike: of errors' variances, for what is seen is no random part of a sea, nor a sea a sum of such systems."""

    def __init__(
        self, long: _GaussianLikelihood, short: _WhittleLikelihood, direction: Travel, water: Water, unlike: float
    ) -> None:
        self.long, self.short, self.direction, self.water, self.unlike = long, short, direction, water, unlike
        least, most = np.log(1.0 / _LONGEST_S), np.log(short.frequency[-1, 1] if short.frequency.size else 0.3)
        self.peaks = np.exp(np.arange(least + 0.3, most, 0.22))
        self.bounds = least, max(most, least + 1.0)

    def add_system(self, found: WaveSystems | None) -> WaveSystems:
        """With the further system that the data ask for most."""
        if found is None:
            return self._first()
        further = self._further(found)
        variance = np.clip(further.slope / further.bend, 0.0, further.total)
        worth = further.slope * variance - 0.5 * further.bend * variance**2 - further.penalty
        best = int(np.argmax(np.where(variance > 0.0, worth, -np.inf)))
        return self._climbed(further.systems(best, float(variance[best])), found.gain, found.nugget)

    def _first(self) -> WaveSystems:
        """One system: a broad one of all the variance, the likeliest, and from there uphill."""
        gain, nugget = 1.0, 0.05 * self.long.variance
        of_long = self.long.covariance(np.zeros((self.long.frequency.size, _DIRECTIONS)), nugget)
        tried: list[WaveSystem] = []
        likelihood: list[float] = []
        for toward in self.long.toward[::3]:
            covariances = self.long.ring_covariances(float(toward), _BROAD)
            for peak in self.peaks:
                one = WaveSystem(self.long.variance, float(peak), float(toward), _BROAD)
                value = self.long.likelihood(of_long + np.tensordot(self.long.rings(one), covariances, 1))[0]
                likelihood.append(value + self.short.evaluate(self.short.power(one), gain)[0])
                tried.append(one)
        best = int(np.argmax(np.array(likelihood) - self._velocity_penalties(tried)))
        return self._climbed((tried[best],), gain, nugget)

    def _climbed(self, systems: tuple[WaveSystem, ...], gain: float, nugget: float) -> WaveSystems:
        """From some systems uphill, each the other way round too: a climb does not turn a system round."""
        found = self.maximize(systems, gain, nugget)
        for n, system in enumerate(found.systems):
            turned = list(found.systems)
            turned[n] = replace(system, toward=system.toward + np.pi)
            if self._likelihood(turned, found.gain, found.nugget) > found.likelihood:
                found = self.maximize(tuple(turned), found.gain, found.nugget)
        return found

    @cached_property
    def _tried(self) -> list[WaveSystem]:
        """Broad systems of 1 m² of all directions and peaks."""
        k = self.water.wavenumber(2.0 * np.pi * self.peaks)
        peaks = self.peaks[k >= LONGEST * self.long.split]
        return [WaveSystem(1.0, float(f), float(to), _BROAD) for to in self.long.toward[::3] for f in peaks]

    def _further(self, found: WaveSystems) -> _Further:
        """What one system more would add to what was found."""
        values = _values(found)
        _, gradient, information = self._evaluate(values, further=self._tried)
        count = values.size
        cross = information[:count, count:]
        given_way = np.linalg.solve(information[:count, :count], cross)
        slope = gradient[count:] - given_way.T @ gradient[:count]
        bend = np.diag(information)[count:] - np.sum(cross * given_way, axis=0)
        bend = np.maximum(bend, 1e-6 * np.diag(information)[count:])
        return _Further(
            values, self._tried, np.asarray(given_way, np.float64), slope, bend, self._velocity_penalties(self._tried)
        )

    def with_errors(self, found: WaveSystems) -> WaveSystems:
        """With what the maximum and its curvature do not tell: frequencies of long waves by their whole likelihood, and
        the alternatives."""
        if len(found.systems) < _MOST:
            found = replace(found, alternatives=self._alternatives(found))
        for n, system in enumerate(found.systems):
            if self.water.wavenumber(2.0 * np.pi * system.frequency) < self.long.split:
                found = self._with_frequency_error(found, n)
        return found

    def _with_frequency_error(self, found: WaveSystems, n: int) -> WaveSystems:
        """With the mean square error of the logarithm of a system's frequency over its profile likelihood, which falls
        off more slowly towards waves longer than the circle."""
        values, at = _values(found), SYSTEM_VALUES * n + 1
        count = found.covariance.shape[0]
        others = np.append(np.arange(at), np.arange(at + 1, values.size))
        moves = np.zeros((_SHIFTS.size, values.size))
        moves[:, :count] = np.multiply.outer(_SHIFTS, found.covariance[:, at] / found.covariance[at, at])
        profile = np.full(_SHIFTS.size, -np.inf)
        for row, shift in enumerate(_SHIFTS):
            if self.bounds[0] <= values[at] + shift <= self.bounds[1]:
                value, gradient, information = self._evaluate(values + moves[row])
                own = information[np.ix_(others, others)]
                profile[row] = value + min(0.5 * float(gradient[others] @ np.linalg.solve(own, gradient[others])), 5.0)
        profile[_SHIFTS == 0.0] = found.likelihood
        weight = np.exp((profile - profile.max()) / self.unlike) * np.gradient(_SHIFTS)
        variance = float(weight @ _SHIFTS**2) / float(weight.sum())
        scale = np.ones(count)
        scale[at] = max(np.sqrt(variance / found.covariance[at, at]), 1.0)
        return replace(found, covariance=found.covariance * np.outer(scale, scale))

    def _alternatives(self, found: WaveSystems) -> tuple[tuple[float, WaveSystems], ...]:
        """Seas of one system more, of any variance, each with its chance: a further system is as likely as none
        beforehand, of any variance up to about the sea's."""
        further = self._further(found)
        variance = further.total * _VARIANCES
        worth = np.outer(further.slope, variance) - 0.5 * np.outer(further.bend, variance**2)
        worth = np.minimum(worth / self.unlike - further.penalty[:, None], 50.0) - _VARIANCES
        evidence = np.exp(worth) * np.gradient(_VARIANCES) / len(further.tried)
        chance = evidence / (1.0 + evidence.sum())
        return tuple(
            (float(chance[n, node]), replace(found, systems=further.systems(n, float(variance[node]))))
            for n, node in zip(*np.nonzero(chance > _LEAST_CHANCE), strict=True)
        )

    def _likelihood(self, systems: Sequence[WaveSystem], gain: float, nugget: float) -> float:
        values = np.array([values_of(each) for each in systems]).ravel()
        return self._evaluate(np.append(values, (np.log(gain), np.log(nugget))), value_alone=True)[0]

    def maximize(self, systems: tuple[WaveSystem, ...], gain: float, nugget: float) -> WaveSystems:
        """Fisher's scoring from some systems."""
        values = np.array([values_of(each) for each in systems])
        shape = values.shape
        values = np.append(values.ravel(), (np.log(gain), np.log(nugget)))
        best, gradient, information = self._evaluate(values)
        damping = 1e-2
        for _ in range(_ITERATIONS):
            step = np.linalg.solve(information + damping * np.diag(np.diag(information)), gradient)
            tried = values + np.clip(step, -0.7, 0.7)
            rows = tried[:-2].reshape(shape)
            rows[:, 1] = np.clip(rows[:, 1], *self.bounds)
            rows[:, 3] = np.clip(rows[:, 3], np.log(1.0), np.log(200.0))
            rows[:, 4] = np.clip(rows[:, 4], np.log(0.7), np.log(20.0))
            value, grad, info = self._evaluate(tried)
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
        covariance = self.unlike * np.linalg.inv(information)[:-2, :-2]
        made = [system_of(row) for row in values[:-2].reshape(shape)]
        order = np.argsort([-each.variance for each in made])
        index = (SYSTEM_VALUES * order[:, None] + np.arange(SYSTEM_VALUES)).ravel()
        gain, nugget = (float(each) for each in np.exp(values[-2:]))
        values[2:-2:SYSTEM_VALUES] += np.pi
        behind = best - self._evaluate(values, value_alone=True)[0]
        turned = [replace(each, toward=each.toward + np.pi) for each in made]
        of_velocity = float(np.sum(self._velocity_penalties(turned) - self._velocity_penalties(made)))
        behind = (behind - of_velocity) / self.unlike + of_velocity
        reversal = float(1.0 / (1.0 + np.exp(np.clip(behind, 0.0, 50.0))))
        systems = tuple(made[n] for n in order)
        errors = np.asarray(covariance[np.ix_(index, index)], np.float64)
        return WaveSystems(systems, errors, best, gain, nugget, reversal, self.water, self.long.split)

    def _velocity_penalties(self, systems: Sequence[WaveSystem]) -> Field:
        """What is taken off for systems that run against the water's velocity (system,); half of it where nothing
        tells."""
        frequency, toward = np.array([(each.frequency, each.toward) for each in systems]).T
        k = self.water.wavenumber(2.0 * np.pi * frequency)
        return 0.5 * _VELOCITY_WEIGHT * (1.0 - self.direction.forth(k * np.sin(toward), k * np.cos(toward)))

    def _evaluate(
        self, values: NDArray[Any], value_alone: bool = False, further: Sequence[WaveSystem] = ()
    ) -> tuple[float, Field, Field]:
        """Log of the likelihood and of what is known beforehand, its gradient, and the information; or the first.

        further: systems of 1 m² that are not there, of whose variances both are as well, behind the values.
        """
        gain, nugget = (float(each) for each in np.exp(values[-2:]))
        rows = values[:-2].reshape(-1, SYSTEM_VALUES)
        total: list[Field | float] = [0.0, 0.0]
        changes: tuple[list[Field], list[Field]] = ([], [])
        for row in rows:
            for n, part in enumerate((self.long, self.short)):
                power = part.power(system_of(row))
                total[n] = total[n] + power
                if value_alone:
                    continue
                changes[n].append(power)
                for column in range(1, SYSTEM_VALUES):
                    up, down = row.copy(), row.copy()
                    up[column], down[column] = row[column] + _SMALL, row[column] - _SMALL
                    difference = part.power(system_of(up)) - part.power(system_of(down))
                    changes[n].append(difference / (2.0 * _SMALL))
        for n, part in enumerate((self.long, self.short)):
            changes[n].extend(part.power(each) for each in further)
        size, shape = values.size + len(further), values.size - 2
        value, first, information_long = self.long.evaluate(np.asarray(total[0]), nugget, changes[0])
        if not np.isfinite(value):
            return -np.inf, np.zeros(size), np.eye(size)
        other, second, information_short = self.short.evaluate(np.asarray(total[1]), gain, changes[1])
        value += other - float(self._velocity_penalties([system_of(row) for row in rows]).sum())
        gradient, information = np.zeros(size), np.zeros((size, size))
        if not value_alone:
            own = np.append(np.arange(shape), np.arange(values.size, size))
            for last, slopes, part in ((shape + 1, first, information_long), (shape, second, information_short)):
                at = np.append(own, last)  # of nugget or gain
                gradient[at] += slopes
                information[np.ix_(at, at)] += part
        for column, (middle, known) in zip((3, 4), (EXPONENT, ENHANCEMENT), strict=True):
            at = np.arange(column, shape, SYSTEM_VALUES)
            apart = (values[at] - np.log(middle)) / known
            value -= 0.5 * float(apart @ apart)
            gradient[at] -= apart / known
            information[at, at] += known**-2
        value -= 0.5 * (values[-2] / _GAIN_KNOWN) ** 2
        gradient[shape] -= values[-2] / _GAIN_KNOWN**2
        information[shape, shape] += _GAIN_KNOWN**-2
        information[np.diag_indices(values.size)] += 1e-3
        return value, gradient, information


@dataclass(frozen=True)
class _Further:
    """Systems that were tried beside others of such values. Near the maximum the likelihood is a parabola in the
    further variance, of that slope and bend, along which the values give way (value, system) per m²; arrays (system,).
    penalty: of log-likelihood, whatever the variance."""

    values: Field
    tried: list[WaveSystem]
    given_way: Field
    slope: Field
    bend: Field
    penalty: Field

    @property
    def total(self) -> float:
        """m², of the systems that there are."""
        return float(np.exp(self.values[:-2:SYSTEM_VALUES]).sum())

    def systems(self, n: int, variance: float) -> tuple[WaveSystem, ...]:
        """With one of those tried, of that variance [m²]."""
        moved = self.values - np.clip(self.given_way[:, n] * variance, -1.5, 1.5)
        rows = moved[:-2].reshape(-1, SYSTEM_VALUES)
        return (*(system_of(row) for row in rows), replace(self.tried[n], variance=variance))


def _values(found: WaveSystems) -> Field:
    """Those of its systems, one after the other, and the logarithms of gain and nugget."""
    return np.append([values_of(each) for each in found.systems], np.log((found.gain, found.nugget)))


class _GaussianLikelihood:
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
        basis = plane_waves(kx[kept], ky[kept], water, x, y, time)
        basis = np.concatenate((basis.real, basis.imag), axis=1) / np.sqrt(x.size)
        k = np.repeat(self.wavenumber, _DIRECTIONS)
        toward = np.tile(self.toward, count)
        modes = plane_waves(k * np.sin(toward), k * np.cos(toward), water, x, y, time)
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
        return self.rings(system)[:, None] * self._fan(system.toward, system.exponent)

    def rings(self, system: WaveSystem) -> Field:
        """m² of each frequency."""
        return system.variance * jonswap(self.frequency, system.frequency, system.enhancement) * self.step

    def _fan(self, toward: float, exponent: float) -> Field:
        fan = cos2s(self.toward - toward, exponent)
        return fan / fan.sum()

    def ring_covariances(self, toward: float, exponent: float) -> Field:
        """Covariances (frequency, datum, datum) of the data, of waves of 1 m² so spread about a direction."""
        modes = self.modes.reshape(self.data.size, 2, self.frequency.size, _DIRECTIONS)
        modes = (
            (modes * np.sqrt(self._fan(toward, exponent)))
            .transpose(2, 0, 1, 3)
            .reshape(self.frequency.size, self.data.size, -1)
        )
        return modes @ modes.transpose(0, 2, 1)

    def covariance(self, power: Field, nugget: float) -> Field:
        """Of the data, (datum, datum)."""
        both = np.concatenate((power.ravel(), power.ravel()))
        return self.noise + nugget * self.white + (self.modes * both) @ self.modes.T

    def likelihood(self, covariance: Field) -> tuple[float, Field, Field]:
        """Its logarithm, the covariance's Cholesky factor, and the data divided by it."""
        try:
            root = np.asarray(np.linalg.cholesky(covariance), np.float64)
        except np.linalg.LinAlgError:
            return -np.inf, np.zeros((0, 0)), np.zeros(0)
        data = solve_triangular(root, self.data, lower=True, check_finite=False)
        return -float(np.log(np.diag(root)).sum()) - 0.5 * float(data @ data), root, data

    def evaluate(self, power: Field, nugget: float, changes: Sequence[Field] = ()) -> tuple[float, Field, Field]:
        """Log-likelihood, its gradient and Fisher's information by some changes of the power; the last of them is of
        the nugget's logarithm. The information is worked out in float32: it needs no more."""
        value, root, data = self.likelihood(self.covariance(power, nugget))
        if not len(changes) or not np.isfinite(value):
            return value, np.zeros(0), np.zeros((0, 0))
        modes = solve_triangular(root, self.modes, lower=True, check_finite=False)
        white = solve_triangular(root, solve_triangular(root, self.white, lower=True).T, lower=True)
        by_mode = ((data @ modes) ** 2 - np.sum(modes**2, axis=0)).reshape(2, -1).sum(axis=0)
        gradient = [0.5 * float(change.ravel() @ by_mode) for change in changes]
        gradient.append(0.5 * nugget * float(data @ white @ data - np.trace(white)))
        single = modes.astype(np.float32)
        products = [(single * np.tile(change.ravel().astype(np.float32), 2)) @ single.T for change in changes]
        flat = np.array([*(each.ravel() for each in products), nugget * white.ravel()])
        return value, np.asarray(gradient, np.float64), np.asarray(0.5 * flat @ flat.T, np.float64)


class _WhittleLikelihood:
    """The likelihood of a periodogram of waves shorter than the split."""

    def __init__(self, given: Periodogram, split: float, water: Water) -> None:
        used = (given.wavenumber > split) & (given.transfer > _LEAST_TRANSFER)
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
        return rings[:, None] * (cos2s(angle, wide) + cos2s(angle + np.pi, wide))

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
