"""The waves that fit what was seen of some turns, and what it takes to fit them again when one more has come."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .assimilation import Batch, Unknowns, solve, weights
from .field import Member, WaveField
from .knowledge import Knowledge, ModelError
from .observations import Observations
from .spectrum import Field, Lattice, Spectrum, lattices
from .wave_sum import WaveSum

_REACH_SHARE = 0.999  # of what the observations tell lies within the reach
_NEW_SEA = 1.3  # ratio of peak periods from which on the lattices are made anew
_SPAN_S = 2.5  # of a batch: in longer ones too many terms follow the time
_LARGEST_DROP = 3.0  # of a wave's standard deviation, before over in a new spectrum, at which its amplitude stays
_BENDS: tuple[Callable[[Lattice], Field], ...] = (
    lambda waves: waves.kx**2,
    lambda waves: 2.0 * waves.kx * waves.ky,
    lambda waves: waves.ky**2,
)
_LEFT = 0.02  # of the sea's variance, that no lattice carries, for a first choice of the reach


class Fit:
    """The lattices, the batches of observations on them, and the waves found."""

    def __init__(self, spectrum: Spectrum, made: list[Lattice], reach: float, centre: tuple[float, float]) -> None:
        self.spectrum, self.lattices, self.reach, self.centre = spectrum, made, reach, centre
        self._first = spectrum
        self.batches: dict[int, list[Batch]] = {}
        self.unknowns: Unknowns | None = None
        self.steps = 0
        self.sharpness = 0.0

    @classmethod
    def of(cls, spectrum: Spectrum, seen: Sequence[Observations], seconds: float, centre: tuple[float, float]) -> Fit:
        """An empty fit for observations like these. seconds: from the first of them to the last forecast."""
        distance = np.concatenate([np.hypot(each.x - centre[0], each.y - centre[1]) for each in seen])
        information = np.concatenate([1.0 / (each.std**2 + _LEFT * spectrum.variance) for each in seen])
        order = np.argsort(distance)
        share = np.cumsum(information[order]) / information.sum()
        reach = float(distance[order][np.searchsorted(share, _REACH_SHARE)]) if distance.size else 100.0
        return cls(spectrum, lattices(spectrum, reach, seconds), reach, centre)

    def shares(self, field: WaveField) -> bool:
        """Whether a field's amplitudes are those of these lattices' waves."""
        pairs = zip(self.lattices, field.lattices, strict=False)
        return len(self.lattices) == len(field.lattices) and all(
            one.spacing == other.spacing and np.array_equal(one.omega, other.omega) for one, other in pairs
        )

    def suits(self, spectrum: Spectrum, centre: tuple[float, float]) -> bool:
        """Whether the lattices are right for a spectrum too, and what was seen is not left behind."""
        mine = self.spectrum
        if (mine.water, mine.amplitude_dispersion) != (spectrum.water, spectrum.amplitude_dispersion):
            return False  # waves run on as they were made to
        near = any(np.any(np.hypot(b.seen.x - centre[0], b.seen.y - centre[1]) <= self.reach) for b in self.all_batches)
        return near and 1.0 / _NEW_SEA < spectrum.peak_period / self.spectrum.peak_period < _NEW_SEA

    def renew(self, spectrum: Spectrum, centre: tuple[float, float]) -> None:
        """A new spectrum and centre. The waves found stay, but those that are hardly expected any more: from their
        amplitudes the next fit would start millions of standard deviations too high, and take tens of times the steps.
        """
        made = [lattice.rescaled(spectrum) for lattice in self.lattices]
        if self.unknowns is not None:
            self.unknowns = [
                np.where(
                    new.scale > 0.0, mine * np.minimum(old.scale / np.maximum(new.scale, 1e-12), _LARGEST_DROP), 0.0
                ).astype(np.complex64)
                for mine, old, new in zip(self.unknowns, self.lattices, made, strict=True)
            ]
        self.spectrum, self.lattices, self.centre = spectrum, made, centre

    @property
    def missing_variance(self) -> float:
        """m², of waves that no lattice carries."""
        return max(self.spectrum.variance - sum(lattice.variance for lattice in self.lattices), 0.0)

    def keep(self, numbers: set[int]) -> None:
        """Drops the batches of all other turns."""
        self.batches = {number: parts for number, parts in self.batches.items() if number in numbers}

    def add(self, seen: Sequence[Observations], numbers: Sequence[int]) -> None:
        """Takes up observations, each of one turn."""
        for each, number in zip(seen, numbers, strict=True):
            inside = each[np.hypot(each.x - self.centre[0], each.y - self.centre[1]) <= self.reach]
            self.batches[number] = [self._batch(part) for part in _split_by_time(inside)]

    def _batch(self, seen: Observations) -> Batch:
        weight, variance = weights(seen, self.lattices, self.missing_variance, self.centre)
        made = WaveSum(seen, self.lattices, self.spectrum.water, weight, self.centre)
        return Batch(seen, made, weight, variance)

    @property
    def turns(self) -> int:
        """Numbers of the turns that gave observations; numbers below 0 are not of turns."""
        return sum(1 for number, parts in self.batches.items() if parts and number >= 0)

    @property
    def all_batches(self) -> list[Batch]:
        """The batches of all turns."""
        return [batch for parts in self.batches.values() for batch in parts]

    def update_weights(self) -> None:
        """Weighs all that was seen by the spectrum of now."""
        for parts in self.batches.values():
            for n, batch in enumerate(parts):
                weight, variance = weights(batch.seen, self.lattices, self.missing_variance, self.centre)
                parts[n] = replace(batch, weight=weight, variance=variance)

    def solve(self, workers: Executor) -> None:
        """Fits the waves to all that was seen and weighed."""
        values = [self.remove_setdown(batch) for batch in self.all_batches]
        self.unknowns, self.steps = solve(self.all_batches, self.lattices, workers, self.unknowns, values)

    def remove_setdown(self, batch: Batch) -> NDArray[np.float32]:
        """Values of areas alike, less what puts the mean level back, by which water is higher than its waves say."""
        seen = batch.seen
        distance = np.hypot(seen.x - self.centre[0], seen.y - self.centre[1])
        level = sum((distance < each.radius) * each.sinking(self.spectrum.water) for each in self.lattices)
        sinking = np.where(seen.kind == "elevation", self.sharpness * level, 0.0)
        return (seen.value + batch.rounding - sinking).astype(np.float32)

    @property
    def amplitudes(self) -> Unknowns:
        """m, of each lattice."""
        assert self.unknowns is not None
        return [
            lattice.scale.astype(np.float32) * part for lattice, part in zip(self.lattices, self.unknowns, strict=True)
        ]

    def _values(self, batch: Batch, kind: str) -> Field:
        """Values of the fitted waves at the places of a batch of elevations."""
        factors = [lattice.factor(kind, self.spectrum.water) for lattice in self.lattices]
        waves = [(f * a).astype(np.complex64) for f, a in zip(factors, self.amplitudes, strict=True)]
        return batch.sum.values(waves).astype(np.float64)

    def shift_evidence(self, number: int | None) -> Field:
        """Σ w r d and Σ w d² of residuals r by the shift d of water that its waves move, of one turn's elevations at
        their own places, or of all."""
        total = np.zeros(2)
        for batch in self.batches[number] if number is not None else self.all_batches:
            if not len(batch.seen) or not np.all(batch.seen.kind == "elevation"):
                continue
            rest = batch.seen.value - self._values(batch, "elevation")
            shift = -sum(
                self._values(batch, f"displacement_{axis}") * self._values(batch, f"slope_{axis}") for axis in "xy"
            )
            shift = shift - np.average(shift, weights=batch.weight)  # the mean level is known, and put back
            total += [np.sum(batch.weight * rest * shift), np.sum(batch.weight * shift**2)]
        return total

    def drift_evidence(self, number: int, amplitudes: bool) -> tuple[Field, Field]:
        """Σ w d dᵀ (3, 3) and Σ w r d (3,) of residuals r of one turn's elevations by d, what they change by for each
        m/s of a current towards east and north, and for the whole of amplitude dispersion (0 where `amplitudes` are not
        asked), that the waves do not have, which were fitted to other turns."""
        others = [batch for key, parts in self.batches.items() if key != number for batch in parts]
        matrix, vector = np.zeros((3, 3)), np.zeros(3)
        if not others:
            return matrix, vector
        middle = _middle(others)
        for batch in self.batches[number]:
            if not len(batch.seen) or not np.all(batch.seen.kind == "elevation"):
                continue
            rest = batch.seen.value - self._values(batch, "elevation")
            rates = [-self._values(batch, f"slope_{axis}") for axis in "xy"]
            rates.append(self._nonlinear_rate(batch) if amplitudes else np.zeros(len(batch.seen)))
            change = (batch.seen.time - middle) * np.stack(rates)
            matrix += (batch.weight * change) @ change.T
            vector += change @ (batch.weight * rest)
        return matrix, vector

    def _nonlinear_rate(self, batch: Batch) -> Field:
        """m/s (n,) by which elevations change at the places of a batch as the waves there get ahead of others of the
        same amplitudes that the amplitudes do not hasten."""
        waves = [(-1j * shift * a).astype(np.complex64) for shift, a in zip(self._shifts, self.amplitudes, strict=True)]
        return batch.sum.values(waves).astype(np.float64)

    @cached_property
    def _shifts(self) -> list[Field]:
        """rad/s of each lattice's waves, of the spectrum that they were made by: of its shifts they run by a share,
        whatever later ones say."""
        return [self._first.amplitude_shift(each.kx, each.ky) for each in self.lattices]

    def relabel(self, sharpness: float, number: int | None = None) -> None:
        """Moves places to where the water there is at home, and rounds areas, of one turn's batches or of all."""
        self.sharpness = sharpness
        for key in [number] if number is not None else list(self.batches):
            self.batches[key] = [self._rounded(each) for each in self.batches[key]]
            if sharpness != 0.0:
                self.batches[key] = [
                    replace(each, sum=each.sum.moved(*self._home(each, sharpness))) for each in self.batches[key]
                ]

    def _rounded(self, batch: Batch) -> Batch:
        """With values as they would be of areas alike, as the sums take them: a pulse and a beam make long ones of
        every direction. For waves longer than the areas, exp(−½ k·(B − B̄)·k) is 1 − ½ k·(B − B̄)·k."""
        more = batch.seen.blur - batch.sum.blur
        if not np.any(more):
            return batch
        values = np.zeros(len(batch.seen))
        for number, part in enumerate(_BENDS):
            bent = [
                (part(each) * a).astype(np.complex64) for each, a in zip(self.lattices, self.amplitudes, strict=True)
            ]
            values += 0.5 * more[:, number] * batch.sum.values(bent)
        return replace(batch, rounding=values.astype(np.float32))

    def _home(self, batch: Batch, sharpness: float) -> tuple[Field, Field]:
        if batch.seen.kind[0] != "elevation":  # the sum holds what its own kind is of the waves
            batch = self._batch(replace(batch.seen, kind=np.array(["elevation"])))
        away = [sharpness * self._values(batch, f"displacement_{axis}") for axis in "xy"]
        return batch.seen.x - away[0], batch.seen.y - away[1]

    @property
    def middle(self) -> float:
        """s, mean time of what was seen, as it counts."""
        return _middle(self.all_batches)

    def field(self, issued: float, sharpness: float, members: tuple[Member, ...], model_error: ModelError) -> WaveField:
        """The waves as they are known now."""
        return WaveField(
            lattices=tuple(self.lattices),
            amplitudes=tuple(self.amplitudes),
            spectrum=self.spectrum,
            knowledge=Knowledge.of(self.spectrum, self.lattices, self.all_batches, self.centre),
            issued=issued,
            sharpness=sharpness,
            turns=self.turns,
            begun=min(float(batch.seen.time.min()) for batch in self.all_batches),
            reach=self.reach,
            members=members,
            model_error=model_error,
        )


def _middle(batches: Sequence[Batch]) -> float:
    """s, mean time of the observations of some batches, as they count."""
    total = sum(float(batch.weight.sum()) for batch in batches)
    return sum(float(np.sum(batch.weight * batch.seen.time)) for batch in batches) / total


def _split_by_time(seen: Observations) -> list[Observations]:
    """Observations in parts, each of a short time and one kind."""
    if not len(seen):
        return []
    number = np.floor((seen.time - seen.time.min()) / _SPAN_S).astype(int)
    parts = [
        seen[(number == each) & (seen.kind == kind)] for each in np.unique(number) for kind in np.unique(seen.kind)
    ]
    return [part for part in parts if len(part)]
