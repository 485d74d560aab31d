"""The sea around the boat as it is known: elevation, slopes and velocity anywhere, at any time, with their errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import finufft
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .ensemble import Member
from .knowledge import Knowledge
from .lattice import Field, Lattice, fastest
from .spectrum import Spectrum
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


@dataclass(frozen=True)
class WaveField:
    """Free waves that fit what was seen, and how well.

    issued, begun: s, the last and first moments of what was seen; reach: m, how far out it was seen. sharpness: how far
    water is where its own waves move it, 0 (waves of Airy, each at its place) to 1 (first-order Lagrangian: sharp
    crests). turns: how many the fit rests on. members: samples of what it leaves open.
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
    model_error: float = 0.0  # share of what is known that is wrong nevertheless, as what came after forecasts shows it

    @property
    def sea_std(self) -> float:
        """m, standard deviation of the sea's elevation."""
        return float(np.sqrt(self.spectrum.variance))

    def elevation(self, x: ArrayLike, y: ArrayLike, time: ArrayLike) -> tuple[Field, Field]:
        """Expected elevation [m] and its standard error [m] at places [m] and times [s], of their broadcast shape."""
        return self.values("elevation", x, y, time)

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
        """Mean and standard error of one kind (of KINDS) at places [m] and times [s], of their broadcast shape."""
        x, y, time = np.broadcast_arrays(*(np.asarray(each, dtype=np.float64) for each in (x, y, time)))
        points = x.ravel(), y.ravel(), time.ravel()
        mean = self._means(self._of([kind]), *points, self.home(*points))[0]
        power = self.knowledge.groups.variance * self._squared(kind)
        still_open = self._open(points, power, self._sample_factor(kind))
        if kind == "elevation":
            mean = mean + (1.0 - still_open / power.sum()) * self._sinking
        std = np.sqrt(self._erring(still_open, power))
        return np.where(self._met(*points), mean, 0.0).reshape(x.shape), std.reshape(x.shape)

    def _met(self, x: Field, y: Field, time: Field) -> NDArray[np.bool_]:
        """Where (point,) no wave comes that the periodic lattice brings in a second time."""
        away = np.hypot(x - self.knowledge.centre[0], y - self.knowledge.centre[1])
        lapse = np.maximum(time - self.begun, self.issued - time)
        return away + fastest(self.spectrum) * lapse <= 2.0 * np.pi / self.lattices[0].spacing - self.reach

    def _open(self, points: Points, power: Field, factor: NDArray[np.complex128]) -> Field:
        """Variance (point,) that the fit leaves open: of long waves as samples show it, of short ones by what was seen.

        power: variance of each group of waves; factor: what is meant, of the samples' amplitudes."""
        samples = self.samples(factor, *points)
        short = self._short
        by_seen = self.knowledge.open_share(*points, short) @ power[short]
        still_open = np.minimum(0.5 * np.mean(np.abs(samples) ** 2, axis=0) + by_seen, power.sum())
        return np.where(self._met(*points), still_open, power.sum())

    def _erring(self, still_open: Field, power: Field) -> Field:
        """Variance (point,) of errors: what is open, and what is wrong of the rest."""
        return still_open + self.model_error * (power.sum() - still_open)

    @property
    def _short(self) -> NDArray[np.bool_]:
        """Groups (group,) that the samples do not hold."""
        return self.knowledge.groups.k > self.members[0].lattice.band[1]

    def _sample_factor(self, kind: str) -> NDArray[np.complex128]:
        return self.members[0].lattice.factor(kind, self.spectrum.water)

    def samples(self, factor: NDArray[np.complex128], x: Field, y: Field, time: Field) -> NDArray[np.complex64]:
        """Waves (sample, point) that a fit missed, of the last turns and of places around, whose real parts are errors
        alike, and whose phases are free."""
        lattice = self.members[0].lattice
        power = lattice.scale.ravel() ** 2
        order = np.argsort(power)[::-1]
        kept = order[: int(np.searchsorted(np.cumsum(power[order]), _SAMPLED * power.sum())) + 1]
        kx, ky, omega = (each.ravel()[kept] for each in (lattice.kx, lattice.ky, lattice.omega))
        waves = np.stack([(factor * member.amplitudes).ravel()[kept] for member in self.members])
        away = _AROUND * 2.0 * np.pi / float(np.sqrt(np.average(lattice.k**2, weights=lattice.scale**2)))
        steps = [np.exp(1j * (kx * east + ky * north)) for east, north in away * _SIDES]
        waves = np.concatenate([waves * step for step in steps]).astype(np.complex64)
        made = np.empty((waves.shape[0], x.size), np.complex64)
        east, north = x - self.knowledge.centre[0], y - self.knowledge.centre[1]
        block = max(1, int(_BLOCK / kept.size))
        for first in range(0, x.size, block):
            part = slice(first, first + block)
            turns = kx[:, None] * east[part] + ky[:, None] * north[part] - omega[:, None] * (time[part] - self.issued)
            made[:, part] = waves @ np.exp(1j * turns).astype(np.complex64)
        return made

    @property
    def _sinking(self) -> float:
        """m, see `Lattice.sinking`: what puts the mean level back."""
        groups = self.knowledge.groups
        depth = np.minimum(groups.k * self.spectrum.water.depth, 300.0)
        return self.sharpness * float(np.sum(groups.variance * groups.k / np.tanh(depth)))

    def motions(
        self, vessel: Vessel, x: Field, y: Field, time: Field, heading_deg: float, speed_m_s: float = 0.0
    ) -> dict[str, tuple[Field, Field]]:
        """Expected heave [m], roll and pitch [rad] of a vessel along its way (point,), and their standard errors.

        x, y [m] and time [s]: of its way, which the heading [deg] and speed over ground [m/s] must agree with.
        """
        depth, groups = self.spectrum.water.depth, self.knowledge.groups
        way = (heading_deg, speed_m_s, depth)
        responses = [vessel.response(each.kx, each.ky, each.omega, *way) for each in self.lattices]
        names = ("heave", "roll", "pitch")
        means = self._means([[getattr(each, name) for name in names] for each in responses], x, y, time, (x, y))
        kx, ky = groups.k * np.sin(groups.toward), groups.k * np.cos(groups.toward)
        of_groups = vessel.response(kx, ky, groups.omega, *way)
        sampled = self.members[0].lattice
        of_samples = vessel.response(sampled.kx, sampled.ky, sampled.omega, *way)
        made = {}
        met = self._met(x, y, time)
        for name, mean in zip(names, means, strict=True):
            power = groups.variance * np.abs(getattr(of_groups, name)) ** 2
            still_open = self._open((x, y, time), power, getattr(of_samples, name))
            made[name] = np.where(met, mean, 0.0), np.sqrt(self._erring(still_open, power))
        return made

    def draws(self, kind: str, x: float, y: float, time: Field, count: int, seed: int = 0) -> Field:
        """What may come (draw, moment) at one place [m] at times (moment,) [s], of one kind: the expected, and what is
        open drawn from its own spectrum, so that neighbouring moments hang together as waves do."""
        groups, stream = self.knowledge.groups, np.random.default_rng(seed)
        points = np.full(time.size, x), np.full(time.size, y), time
        mean, _ = self.values(kind, *points)
        samples = self.samples(self._sample_factor(kind), *points)
        parts = stream.standard_normal((2, count, samples.shape[0])) / np.sqrt(2.0 * samples.shape[0])
        met = self._met(*points)
        share = np.zeros((time.size, groups.k.size))
        share[:, self._short] = self.knowledge.open_share(*points, self._short)
        power = groups.variance * self._squared(kind)
        most = np.maximum(power.sum() - share @ power, 0.0)  # few samples may say more than there are waves
        said = 0.5 * np.mean(np.abs(samples) ** 2, axis=0)
        size = np.where(met, np.sqrt(np.minimum(most / np.maximum(said, 1e-12), 1.0)), 0.0)
        missed = size * np.real((parts[0] + 1j * parts[1]) @ samples)
        share[~met] = 1.0
        size = np.sqrt((share + self.model_error * (1.0 - share)) * power)
        # A group holds waves of some width of frequencies: each draw takes one of them.
        near = 1.0 + _WIDTH * stream.uniform(-1.0, 1.0, (count, 1, groups.k.size))
        turns = groups.omega * near * (time - time[0])[:, None]
        cosine, sine = stream.standard_normal((2, count, 1, groups.k.size))
        return mean + missed + np.sum(size * (cosine * np.cos(turns) + sine * np.sin(turns)), axis=-1)

    def home(self, x: Field, y: Field, time: Field) -> tuple[Field, Field]:
        """Where the water (point,) is at home that is at a place now, m."""
        if self.sharpness == 0.0:
            return x, y
        home = x, y
        for _ in range(_PASSES):
            away = self._means(self._of(["displacement_x", "displacement_y"]), x, y, time, home)
            home = x - self.sharpness * away[0], y - self.sharpness * away[1]
        return home

    def _squared(self, kind: str) -> Field:
        """|f|² (group,) of what a kind is of a wave's elevation."""
        groups = self.knowledge.groups
        name, _, axis = kind.partition("_")
        along = {"": 1.0, "z": 1.0, "x": np.sin(groups.toward), "y": np.cos(groups.toward)}[axis]
        if name == "elevation":
            return np.ones(groups.k.size)
        if name == "slope":
            return (groups.k * along) ** 2
        orbit = 1.0 if axis == "z" else 1.0 / np.tanh(np.minimum(groups.k * self.spectrum.water.depth, 300.0))
        return (groups.frequency * along * orbit) ** 2

    def _of(self, kinds: Sequence[str]) -> list[list[NDArray[np.complex128]]]:
        """What kinds are of each wave's amplitude, for each lattice."""
        return [[lattice.factor(kind, self.spectrum.water) for kind in kinds] for lattice in self.lattices]

    def _means(
        self,
        kinds: Sequence[Sequence[NDArray[np.complex128]]],
        x: Field,
        y: Field,
        time: Field,
        home: tuple[Field, Field],
    ) -> list[Field]:
        """Each kind's sum of waves (point,) at the home of the water that is at (x, y); without short waves far out.

        kinds: what each is of the amplitudes, for each lattice.
        """
        total = [np.zeros(x.size) for _ in kinds[0]]
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


def _transformed(lattice: Lattice, waves: NDArray[np.complex128], x: Field, y: Field) -> Field:
    east, north = ((each * lattice.spacing + np.pi) % (2.0 * np.pi) - np.pi for each in (x, y))
    made: Any = finufft.nufft2d2(east, north, np.ascontiguousarray(waves), eps=1e-6, isign=1, nthreads=1)
    return np.real(np.asarray(made, np.complex128))


def _summed(
    lattice: Lattice,
    amplitudes: NDArray[np.complex64],
    factors: Sequence[NDArray[np.complex128]],
    x: Field,
    y: Field,
    time: Field,
) -> list[Field]:
    """Sums over the waves that hold nearly all of the lattice's variance."""
    power = lattice.scale.ravel() ** 2
    order = np.argsort(power)[::-1]
    kept = order[: int(np.searchsorted(np.cumsum(power[order]), _HELD * power.sum())) + 1]
    kx, ky, omega, a = (each.ravel()[kept] for each in (lattice.kx, lattice.ky, lattice.omega, amplitudes))
    waves = np.stack([factor.ravel()[kept] * a for factor in factors])
    sums = np.empty((len(factors), x.size))
    step = max(1, int(_BLOCK / max(kept.size, 1)))
    for first in range(0, x.size, step):
        part = slice(first, first + step)
        turns = kx[:, None] * x[part] + ky[:, None] * y[part] - omega[:, None] * time[part]
        sums[:, part] = waves.real @ np.cos(turns) - waves.imag @ np.sin(turns)
    return list(sums)
