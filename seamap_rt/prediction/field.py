"""The sea around the boat as it is known: elevation, slopes and velocity anywhere, at any time, with their errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import finufft
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..io.text import TableMixin
from .knowledge import Knowledge, ModelError, height_of
from .phasors import phasors
from .quantity import AT_REST, Course, Quantity, power, quantities
from .spectrum import Field, Lattice, Spectrum, fastest
from .vessel import Vessel

_MANY = 64  # places at one moment, from which on a transform is faster than a sum
_BLOCK = 2e6  # products at once
_HELD = 0.99995  # of the sea's variance, in the waves that sums are made of
_WIDTH = 0.07  # of a group's frequency, to either side
_SAMPLED = 0.99  # of the variance, of samples
_AROUND = 0.35  # of the waves' length: samples are taken from so far around a place
_SIDES = np.array([(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
_PASSES = 2  # from a place to the water that is there: the second changes it by a hundredth of the first

Points = tuple[Field, Field, Field]  # x, y [m], time [s]
Envelope = NDArray[np.complex128]


@dataclass(frozen=True)
class Member:
    """Amplitudes [m] (n, n) of one drawn sea less what was fitted to it, and of what was fitted, by place from the
    antennas and time from the forecast's issue; turns: that it rests on."""

    lattice: Lattice
    amplitudes: NDArray[np.complex64]
    fitted: NDArray[np.complex64]
    turns: int


@dataclass(frozen=True, repr=False)
class WaveField(TableMixin):
    """Free waves that fit what was seen, and how well.

    issued, begun: s, the last and first moments of what was seen; reach: m, how far out it was seen. sharpness: how far
    water is where its own waves move it, 0 (waves of Airy, each at its place) to 1 (first-order Lagrangian: sharp
    crests). turns: how many the fit rests on. members: samples of what it leaves open. model_error: what is wrong of
    what it knows.
    """

    lattices: tuple[Lattice, ...]
    amplitudes: tuple[NDArray[np.complex64], ...]  # m, (n, n) of each lattice
    spectrum: Spectrum
    knowledge: Knowledge
    issued: float
    sharpness: float
    turns: int
    begun: float
    reach: float
    members: tuple[Member, ...]
    model_error: ModelError = field(default_factory=ModelError)

    def rows(self) -> list[tuple[str, str]]:
        """What it rests on, and the sea that it shows."""
        east, north = self.centre
        return [
            ("seen", f"{self.turns} turns, {self.begun:.4g}–{self.issued:.4g} s, up to {self.reach:.4g} m away"),
            ("antennas", f"{east:.4g} m east and {north:.4g} m north at {self.issued:.4g} s"),
            ("sea", f"significant wave height {4.0 * self.sea_std:.3g} m, sharpness {self.sharpness:.2g}"),
            ("waves", f"{sum(each.size for each in self.amplitudes)} free ones, {len(self.members)} samples of them"),
        ]

    @property
    def sea_std(self) -> float:
        """m, standard deviation of the sea's elevation."""
        return float(np.sqrt(self.spectrum.variance))

    @property
    def centre(self) -> tuple[float, float]:
        """m east and north, where the antennas were at the end of the last turn."""
        return self.knowledge.centre

    def elevation(self, x: ArrayLike, y: ArrayLike, time: ArrayLike) -> tuple[Field, Field]:
        """Expected elevation [m] and its standard error [m] at places [m] and times [s], of their broadcast shape."""
        return self.values("elevation", x, y, time)

    def elevation_alone(self, x: Field, y: Field, time: Field) -> Field:
        """Expected elevation [m] without its error, which takes longer, at many places [m] and times [s], (point,)."""
        mean = self._expected(self.quantities(["elevation"]), (x, y, time))[0].real
        return np.where(self.is_within_period(x, y, time), mean, 0.0)

    def slopes(self, x: ArrayLike, y: ArrayLike, time: ArrayLike) -> tuple[Field, Field]:
        """Expected slopes (…, 2) towards east and north, and their standard errors."""
        each = [self.values(kind, x, y, time) for kind in ("slope_x", "slope_y")]
        return np.stack([mean for mean, _ in each], -1), np.stack([std for _, std in each], -1)

    def velocity(self, x: ArrayLike, y: ArrayLike, time: ArrayLike) -> tuple[Field, Field]:
        """Expected velocity (…, 3) of the water at the surface [m/s], east, north, up, without the current, and its
        standard errors."""
        each = [self.values(kind, x, y, time) for kind in ("velocity_x", "velocity_y", "velocity_z")]
        return np.stack([mean for mean, _ in each], -1), np.stack([std for _, std in each], -1)

    def predictable(self, x: ArrayLike, y: ArrayLike, time: ArrayLike) -> Field:
        """Share of the sea's variance that is known at places [m] and times [s], 0 to 1."""
        _, std = self.elevation(x, y, time)
        return np.clip(1.0 - std**2 / self.spectrum.variance, 0.0, 1.0)

    def values(self, kind: str, x: ArrayLike, y: ArrayLike, time: ArrayLike) -> tuple[Field, Field]:
        """Mean and standard error of one kind (of WATER) at places [m] and times [s], of their broadcast shape."""
        x, y, time = np.broadcast_arrays(*(np.asarray(each, dtype=np.float64) for each in (x, y, time)))
        ((mean, std),) = self.predict(self.quantities([kind]), x.ravel(), y.ravel(), time.ravel())
        return mean.reshape(x.shape), std.reshape(x.shape)

    def quantities(
        self, names: Sequence[str], vessel: Vessel | None = None, course: Course = AT_REST
    ) -> list[Quantity]:
        """Quantities of the water, or of a vessel on a course. Raises ValueError for names that are not known."""
        groups, water = self.knowledge.groups, self.spectrum.water
        return quantities(names, self.lattices, self.members[0].lattice, groups, water, vessel, course)

    def predict(self, wanted: Sequence[Quantity], x: Field, y: Field, time: Field) -> list[tuple[Field, Field]]:
        """Mean and standard error (point,) of each quantity at places [m] and times [s], (point,) each."""
        return [(mean, np.sqrt(still_open + wrong)) for mean, still_open, wrong in self._predict(wanted, (x, y, time))]

    def _predict(self, wanted: Sequence[Quantity], points: Points) -> list[tuple[Field, Field, Field]]:
        """Mean of each quantity at points, its variance that is open, and that of the rest that is wrong."""
        means, met = self._expected(wanted, points), self.is_within_period(*points)
        share, made = self.short_share(points), []
        for quantity, waves, kept, samples in zip(wanted, means, *self._residual_waves(wanted, points), strict=True):
            of_groups = power(quantity, self.knowledge.groups)
            # Few samples may say more than there are waves.
            variance = np.minimum(0.5 * np.mean(np.abs(samples) ** 2, axis=0) + share @ of_groups, of_groups.sum())
            still_open = np.where(met, variance, of_groups.sum())
            known = of_groups.sum() - still_open
            right = self.model_error.kept_share(points[2], height_of(waves, known))
            wrong, mean = known * (1.0 - right**2), right * kept * waves.real
            if quantity.name == "elevation":
                mean = mean + known / of_groups.sum() * self._sinking
            made.append((np.where(met, mean, 0.0), still_open, wrong))
        return made

    def draws(
        self, wanted: Sequence[Quantity], x: Field, y: Field, time: Field, count: int, seed: int = 0
    ) -> NDArray[np.float64]:
        """What may come (quantity, draw, moment) along a way of places [m] at times [s], (moment,) each: the expected,
        and what is open drawn from its own spectrum, so that neighbouring moments, and quantities, hang together."""
        groups, stream = self.knowledge.groups, np.random.default_rng(seed)
        points = x, y, time
        met, share = self.is_within_period(*points), self.short_share(points)
        _, missed = self._residual_waves(wanted, points)
        parts = stream.standard_normal((2, count, missed.shape[1])) / np.sqrt(2.0 * missed.shape[1])
        # A group holds waves of some width of frequencies: each draw takes one of them.
        near = 1.0 + _WIDTH * stream.uniform(-1.0, 1.0, (count, 1, groups.k.size))
        turns = np.multiply.outer(time - time[0], groups.omega) * near
        turns -= np.multiply.outer(x - x[0], groups.k * np.sin(groups.toward))
        turns -= np.multiply.outer(y - y[0], groups.k * np.cos(groups.toward))
        cosine, sine = stream.standard_normal((2, count, 1, groups.k.size))
        waves = np.sqrt(groups.variance) * (cosine + 1j * sine) * np.exp(-1j * turns)
        made = []
        whole = np.where(met[:, None], share, 1.0)
        for quantity, (mean, _, wrong), samples in zip(wanted, self._predict(wanted, points), missed, strict=True):
            of_groups = power(quantity, groups)
            most = np.maximum(of_groups.sum() - share @ of_groups, 0.0)
            variance = 0.5 * np.mean(np.abs(samples) ** 2, axis=0)
            kept = np.where(met, np.sqrt(np.minimum(most / np.maximum(variance, 1e-12), 1.0)), 0.0)
            of_samples = kept * np.real((parts[0] + 1j * parts[1]) @ samples)
            held = np.maximum((1.0 - whole) @ of_groups, 1e-300)  # waves that are wrong are of these groups
            size = np.sqrt(whole + (wrong / held)[:, None] * (1.0 - whole))
            made.append(mean + of_samples + np.real((size * waves) @ quantity.groups))
        return np.stack(made)

    def is_within_period(self, x: Field, y: Field, time: Field) -> NDArray[np.bool_]:
        """Where (point,) no wave comes that the periodic lattice brings in a second time."""
        away = np.hypot(x - self.knowledge.centre[0], y - self.knowledge.centre[1])
        lapse = np.maximum(time - self.begun, self.issued - time)
        return away + fastest(self.spectrum) * lapse <= 2.0 * np.pi / self.lattices[0].spacing - self.reach

    @property
    def _short_groups(self) -> NDArray[np.bool_]:
        """Groups (group,) that the samples do not hold."""
        return self.knowledge.groups.k > self.members[0].lattice.band[1]

    def short_share(self, points: Points) -> Field:
        """What is open (point, group) of groups that the samples do not hold, as a share; 0 of others."""
        share = np.zeros((points[0].size, self.knowledge.groups.k.size))
        share[:, self._short_groups] = self.knowledge.open_share(*points, self._short_groups)
        return share

    def _residual_waves(self, wanted: Sequence[Quantity], points: Points) -> tuple[Field, NDArray[np.complex64]]:
        """Share (quantity, point) of the fitted waves to keep, by how well fits to samples agree with these, and the
        waves (quantity, sample, point) that it leaves open: a fit may be too high where nothing was seen."""
        both = self.samples([each.samples for each in wanted], *points, fitted=True)
        missed, fitted = np.split(both, 2, axis=1)
        alike = np.mean(np.real(np.conj(fitted) * missed), axis=1)
        kept = np.clip(1.0 + alike / np.maximum(np.mean(np.abs(fitted) ** 2, axis=1), 1e-12), 0.0, 1.0)
        return kept, (missed + (1.0 - kept[:, None]) * fitted).astype(np.complex64)

    def residual_elevation(self, x: Field, y: Field, time: Field) -> tuple[Field, NDArray[np.complex64]]:
        """Share (point,) of the fitted elevation to keep, and the waves (sample, point) [m] that it leaves open."""
        kept, missed = self._residual_waves(self.quantities(["elevation"]), (x, y, time))
        return kept[0], missed[0]

    def samples(
        self, factors: Sequence[NDArray[np.complex128]], x: Field, y: Field, time: Field, *, fitted: bool = False
    ) -> NDArray[np.complex64]:
        """Waves (factor, sample, point) that a fit missed, of the last turns and of places around, whose real parts are
        errors alike, and whose phases are free; factors: what is meant, of the samples' amplitudes. fitted: after them
        as many that it found."""
        lattice = self.members[0].lattice
        held = lattice.scale.ravel() ** 2
        order = np.argsort(held)[::-1]
        kept = order[: int(np.searchsorted(np.cumsum(held[order]), _SAMPLED * held.sum())) + 1]
        kx, ky, omega = (each.ravel()[kept] for each in (lattice.kx, lattice.ky, lattice.omega))
        fields = [each.amplitudes for each in self.members] + [each.fitted for each in self.members if fitted]
        missed = np.stack([each.ravel()[kept] for each in fields])
        away = _AROUND * 2.0 * np.pi / float(np.sqrt(np.average(lattice.k**2, weights=lattice.scale**2)))
        steps = [np.exp(1j * (kx * east + ky * north)) for east, north in away * _SIDES]
        missed = np.stack([missed * step for step in steps], axis=1).reshape(-1, kept.size).astype(np.complex64)
        waves = np.concatenate([missed * each.ravel()[kept].astype(np.complex64) for each in factors])
        made = np.empty((waves.shape[0], x.size), np.complex64)
        east, north = x - self.knowledge.centre[0], y - self.knowledge.centre[1]
        block = max(1, int(_BLOCK / kept.size))
        for first in range(0, x.size, block):
            part = slice(first, first + block)
            lead = time[part] - self.issued
            made[:, part] = waves @ phasors(kx, ky, omega, east[part], north[part], lead, np.complex64).T
        return made.reshape(len(factors), -1, x.size)

    @property
    def _sinking(self) -> float:
        """m, see `Lattice.sinking`: what puts the mean level back."""
        groups = self.knowledge.groups
        depth = np.minimum(groups.k * self.spectrum.water.depth, 300.0)
        return self.sharpness * float(np.sum(groups.variance * groups.k / np.tanh(depth)))

    def _expected(self, wanted: Sequence[Quantity], points: Points) -> list[Envelope]:
        """Each quantity's sum of waves (point,), the water's where it is at home."""
        made: dict[str, Envelope] = {}
        for of_water in (True, False):
            alike = [each for each in wanted if each.is_of_water == of_water]
            if alike:
                shares = [[each.lattices[n] for each in alike] for n in range(len(self.lattices))]
                home = self.home(*points) if of_water else points[:2]
                sums = self._means(shares, *points, home)
                made |= {each.name: total for each, total in zip(alike, sums, strict=True)}
        return [made[each.name] for each in wanted]

    def home(self, x: Field, y: Field, time: Field) -> tuple[Field, Field]:
        """Where the water (point,) is at home that is at a place now, m."""
        if self.sharpness == 0.0:
            return x, y
        home = x, y
        for _ in range(_PASSES):
            away = self._means(self._factors(["displacement_x", "displacement_y"]), x, y, time, home)
            home = x - self.sharpness * away[0].real, y - self.sharpness * away[1].real
        return home

    def _factors(self, kinds: Sequence[str]) -> list[list[NDArray[np.complex128]]]:
        """Factors of kinds of quantities on each wave's amplitude, for each lattice."""
        return [[lattice.factor(kind, self.spectrum.water) for kind in kinds] for lattice in self.lattices]

    def _means(
        self,
        kinds: Sequence[Sequence[NDArray[np.complex128]]],
        x: Field,
        y: Field,
        time: Field,
        home: tuple[Field, Field],
    ) -> list[Envelope]:
        """Each kind's sum of waves (point,) at the home of the water that is at (x, y); without short waves far out.

        kinds: what each is of the amplitudes, for each lattice. The real part of the sum is meant; its size is that of
        the group of waves there.
        """
        total = [np.zeros(x.size, np.complex128) for _ in kinds[0]]
        moments, number, count = np.unique(time, return_inverse=True, return_counts=True)
        crowded = count[number] >= _MANY
        for lattice, amplitudes, factors in zip(self.lattices, self.amplitudes, kinds, strict=True):
            near = np.hypot(x - self.knowledge.centre[0], y - self.knowledge.centre[1]) < lattice.radius
            for moment in np.flatnonzero(count >= _MANY):
                places = np.flatnonzero(near & (number == moment))
                waves = amplitudes * np.exp(-1j * lattice.omega * moments[moment])
                for each, factor in zip(total, factors, strict=True):
                    each[places] += _transformed(lattice, factor * waves, home[0][places], home[1][places])
            places = np.flatnonzero(near & ~crowded)
            sums = _summed(lattice, amplitudes, factors, home[0][places], home[1][places], time[places])
            for each, part in zip(total, sums, strict=True):
                each[places] += part
        return total


def _transformed(lattice: Lattice, waves: NDArray[np.complex128], x: Field, y: Field) -> Envelope:
    east, north = ((each * lattice.spacing + np.pi) % (2.0 * np.pi) - np.pi for each in (x, y))
    made: Any = finufft.nufft2d2(east, north, np.ascontiguousarray(waves), eps=1e-6, isign=1, nthreads=1)
    return np.asarray(made, np.complex128)


def _summed(
    lattice: Lattice,
    amplitudes: NDArray[np.complex64],
    factors: Sequence[NDArray[np.complex128]],
    x: Field,
    y: Field,
    time: Field,
) -> list[Envelope]:
    """Sums over the waves that hold nearly all of the lattice's variance."""
    power = lattice.scale.ravel() ** 2
    order = np.argsort(power)[::-1]
    kept = order[: int(np.searchsorted(np.cumsum(power[order]), _HELD * power.sum())) + 1]
    kx, ky, omega = (each.ravel()[kept] for each in (lattice.kx, lattice.ky, lattice.omega))
    waves = np.stack([factor.ravel()[kept] for factor in factors]) * amplitudes.ravel()[kept]
    sums = np.empty((len(factors), x.size), np.complex128)
    step = max(1, int(_BLOCK / max(kept.size, 1)))
    for first in range(0, x.size, step):
        part = slice(first, first + step)
        sums[:, part] = waves @ phasors(kx, ky, omega, x[part], y[part], time[part]).T
    return list(sums)
