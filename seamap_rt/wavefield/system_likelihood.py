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

from ..compute.machine import one_blas_thread
from ..physics.dispersion import Water
from .periodogram import Periodogram
from .wave_direction import Travel
from .wave_likelihoods import DIRECTIONS, LONGEST_PERIOD_S, GaussianLikelihood, WhittleLikelihood
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
    system_of,
    values_of,
)

_GAIN_KNOWN = 0.4  # of the periodogram's level, its logarithm: gaps scatter what they hide
_UNLIKE = 1.2  # of the errors' variances, over the square of the share in sight: crests are, and troughs are not
_VELOCITY_WEIGHT = 8.0  # of log-likelihood, against systems that run against the water's velocity
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
    long = GaussianLikelihood(turns, water)
    if long.data.size < 4 or not long.variance > 0.0:
        return None
    short = WhittleLikelihood(periodogram, long.split, water)
    posterior = _Posterior(long, short, direction, water, _UNLIKE / max(seen, _LEAST_SEEN) ** 2)
    found = posterior.maximize(start.systems, start.gain, start.nugget) if start is not None else None
    while found is None or len(found.systems) < _MOST:
        more = posterior.add_system(found)
        if found is not None and more.likelihood < found.likelihood + SYSTEM_WORTH:
            break
        found = more
    return posterior.add_errors(found)


class _Posterior:
    """unlike: of errors' variances, for what is seen is no random part of a sea, nor a sea a sum of such systems."""

    def __init__(
        self, long: GaussianLikelihood, short: WhittleLikelihood, direction: Travel, water: Water, unlike: float
    ) -> None:
        self.long, self.short, self.direction, self.water, self.unlike = long, short, direction, water, unlike
        least, most = np.log(1.0 / LONGEST_PERIOD_S), np.log(short.frequency[-1, 1] if short.frequency.size else 0.3)
        self.peaks = np.exp(np.arange(least + 0.3, most, 0.22))
        self.bounds = least, max(most, least + 1.0)

    def add_system(self, found: WaveSystems | None) -> WaveSystems:
        """The systems with the further one that the data ask for most."""
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
        of_long = self.long.covariance(np.zeros((self.long.frequency.size, DIRECTIONS)), nugget)
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

    def _further(self, found: WaveSystems) -> _AddedSystems:
        """What one system more would add to what was found."""
        values = _values(found)
        _, gradient, information = self._evaluate(values, further=self._tried)
        count = values.size
        cross = information[:count, count:]
        given_way = np.linalg.solve(information[:count, :count], cross)
        slope = gradient[count:] - given_way.T @ gradient[:count]
        bend = np.diag(information)[count:] - np.sum(cross * given_way, axis=0)
        bend = np.maximum(bend, 1e-6 * np.diag(information)[count:])
        return _AddedSystems(
            values, self._tried, np.asarray(given_way, np.float64), slope, bend, self._velocity_penalties(self._tried)
        )

    def add_errors(self, found: WaveSystems) -> WaveSystems:
        """Adds what the maximum and its curvature do not state: frequencies of long waves by the whole likelihood, and
        the alternatives."""
        if len(found.systems) < _MOST:
            found = replace(found, alternatives=self._alternatives(found))
        for n, system in enumerate(found.systems):
            if self.water.wavenumber(2.0 * np.pi * system.frequency) < self.long.split:
                found = self._add_frequency_error(found, n)
        return found

    def _add_frequency_error(self, found: WaveSystems, n: int) -> WaveSystems:
        """Adds the mean square error of the logarithm of a system's frequency over its profile likelihood, which falls
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
        return 0.5 * _VELOCITY_WEIGHT * (1.0 - self.direction.travel_sign(k * np.sin(toward), k * np.cos(toward)))

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
class _AddedSystems:
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
        """The systems with one of those tried, of that variance [m²]."""
        moved = self.values - np.clip(self.given_way[:, n] * variance, -1.5, 1.5)
        rows = moved[:-2].reshape(-1, SYSTEM_VALUES)
        return (*(system_of(row) for row in rows), replace(self.tried[n], variance=variance))


def _values(found: WaveSystems) -> Field:
    """Those of its systems, one after the other, and the logarithms of gain and nugget."""
    return np.append([values_of(each) for each in found.systems], np.log((found.gain, found.nugget)))
