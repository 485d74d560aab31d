"""From turn to turn: maps come in, the wave field that fits the last of them goes out."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..compute.machine import pool
from ..wavefield.sea_state import TurnSpectrum, water_of
from .assimilation import Batch, Unknowns, solve, weights
from .field import WaveField
from .innovations import compared, pairs_of_looks
from .knowledge import Knowledge
from .lattice import Field, Lattice, lattices
from .observations import Observations, of_turn
from .spectrum import Spectrum, spectrum_of_turns
from .wave_sum import WaveSum

_TOLD = 0.999  # of what the observations tell lies within the reach
_NEW_SEA = 1.3  # ratio of peak periods from which on the lattices are made anew
_SPAN_S = 2.5  # of a batch: in longer ones too many terms follow the time
_LEFT = 0.02  # of the sea's variance, that no lattice carries, for a first choice of the reach
_SHARP, _SURE = 1.0, 0.5  # of a real sea, and how far seas may be from it
_AGO = 5  # turns since the forecast that a turn is compared with: about as far ahead as forecasts are for
_NEARBY_M = 80.0  # within which looks are compared: farther out they lie too far apart
_FEWEST = 200  # pairs of looks, for their covariance to be told from its chance
_ASTRAY, _TRUSTED = 0.015, 0.2  # of what is known, wrong on seas of waves of Airy; and for how many turns that counts
_OTHERS = -1  # in place of a turn's number, of observations by other instruments
_FORGOTTEN = 0.9  # of the evidence, from turn to turn


@dataclass
class _Turn:
    """What is kept of a turn."""

    number: int
    seen: Observations
    spectrum: TurnSpectrum | None


class Predictor:
    """Keeps what was seen in the last turns, and the waves that fit it.

    turns: how many; lead_s: how far ahead [s] forecasts are wanted. sharpness: see WaveField; None: as the maps show.
    """

    def __init__(self, turns: int = 10, lead_s: float = 30.0, sharpness: float | None = None) -> None:
        self._most, self._lead = turns, lead_s
        self._turns: list[_Turn] = []
        self._fit: Fit | None = None
        self._sharpness, self._issued = sharpness, 0.0
        self._before: deque[WaveField] = deque(maxlen=_AGO)
        self._errors = _TRUSTED * np.array([_ASTRAY, 0.0, 1.0])
        self._stream = np.random.default_rng(0)
        self._evidence = _SURE**-2 * np.array([_SHARP, 1.0])

    def turn(self, polar: xr.Dataset) -> WaveField | None:
        """The field after one more turn's polar map; None while no turn of the last ones shows a sea."""
        water = water_of(polar.attrs)
        number = int(polar["turn"])
        shown = TurnSpectrum.of(polar, water)
        self._turns = [turn for turn in self._turns if number - self._most < turn.number < number]
        known = [turn.spectrum for turn in self._turns if turn.spectrum] + ([shown] if shown else [])
        spectrum = spectrum_of_turns(known, water)
        if spectrum is None:
            self._fit, self._turns = None, []
            return None
        seen = of_turn(polar, np.sqrt(spectrum.variance))
        self._turns.append(_Turn(number, seen, shown))
        centre = _centre(polar)
        with pool() as workers:
            if self._fit is None or not self._fit.suits(spectrum):
                seconds = self._lead + self._most * float(np.ptp(polar["time"].values))
                self._fit = Fit.anew(spectrum, [t.seen for t in self._turns], seconds, centre)
                self._fit.add([t.seen for t in self._turns], [t.number for t in self._turns])
                self._fit.settle(workers)
                self._learn(self._fit, None)
                self._fit.relabel(self.sharpness)
            else:
                self._fit.renew(spectrum, centre)
                self._fit.keep({t.number for t in self._turns})
                self._fit.add([seen], [number])
                self._learn(self._fit, number)
                self._fit.relabel(self.sharpness, number)
                self._errors = _FORGOTTEN * self._errors + self._compared(self._fit, number)
            self._fit.settle(workers)
        self._issued = float(polar["time"].max())
        made = replace(self._fit.field(self._issued, self.sharpness), astray=self.astray)
        self._before.append(made)
        return made

    @property
    def astray(self) -> float:
        """Share of what the fit knows that is wrong nevertheless, by what came after earlier forecasts."""
        found, stated, known = self._errors
        return float(np.clip((found - stated) / known, 0.0, 1.0))

    def _compared(self, fit: Fit, number: int) -> Field:
        """Found and stated covariance of the errors of the oldest forecast kept, and that of the waves it knows, over
        the sea's variance."""
        total = np.zeros(3)
        if not self._before or not fit.shares(self._before[0]):
            return total
        earlier = self._before[0]
        for batch in fit.batches[number]:
            pairs = pairs_of_looks(batch.seen, fit.centre, min(fit.lattices[-1].radius, _NEARBY_M))
            if len(pairs) < _FEWEST or batch.seen.kind[0] != "elevation":
                continue
            difference = fit.above_home(batch) - batch.sum.values(earlier.amplitudes)
            total += compared(batch.seen, difference.astype(np.float64), earlier, pairs, self._stream)
        return total / fit.spectrum.variance

    def also(self, seen: Observations) -> WaveField:
        """The field with observations of other instruments taken up too; the last turn's end stays its time.

        Raises ValueError before the first turn that shows a sea.
        """
        if self._fit is None:
            raise ValueError("no turn has shown a sea yet")
        self._fit.add([seen], [_OTHERS])
        with pool() as workers:
            self._fit.settle(workers)
            self._fit.relabel(self.sharpness, _OTHERS)
            self._fit.settle(workers)
        return replace(self._fit.field(self._issued, self.sharpness), astray=self.astray)

    @property
    def sharpness(self) -> float:
        """How far water is moved by its own waves, see WaveField."""
        if self._sharpness is not None:
            return self._sharpness
        return float(np.clip(self._evidence[0] / self._evidence[1], 0.0, 1.0))

    def _learn(self, fit: Fit, number: int | None) -> None:
        """Takes up what the observations of one turn, or of all, say of the sharpness."""
        self._evidence = _FORGOTTEN * self._evidence + (1.0 - _FORGOTTEN) * _SURE**-2 * np.array([_SHARP, 1.0])
        self._evidence = self._evidence + fit.shift_evidence(number)


class Fit:
    """The lattices, the batches of observations on them, and the waves found."""

    def __init__(self, spectrum: Spectrum, made: list[Lattice], reach: float, centre: tuple[float, float]) -> None:
        self.spectrum, self.lattices, self.reach, self.centre = spectrum, made, reach, centre
        self.batches: dict[int, list[Batch]] = {}
        self.unknowns: Unknowns | None = None
        self.steps = 0
        self.sharpness = 0.0

    @classmethod
    def anew(cls, spectrum: Spectrum, seen: Sequence[Observations], seconds: float, centre: tuple[float, float]) -> Fit:
        """For observations like these. seconds: from the first of them to the last forecast."""
        distance = np.concatenate([np.hypot(each.x - centre[0], each.y - centre[1]) for each in seen])
        told = np.concatenate([1.0 / (each.std**2 + _LEFT * spectrum.variance) for each in seen])
        order = np.argsort(distance)
        share = np.cumsum(told[order]) / told.sum()
        reach = float(distance[order][np.searchsorted(share, _TOLD)]) if distance.size else 100.0
        return cls(spectrum, lattices(spectrum, reach, seconds), reach, centre)

    def shares(self, field: WaveField) -> bool:
        """Whether a field's amplitudes are those of these lattices' waves."""
        sides = [(each.k.shape, each.spacing) for each in self.lattices]
        return sides == [(each.k.shape, each.spacing) for each in field.lattices]

    def suits(self, spectrum: Spectrum) -> bool:
        """Whether the lattices are right for a spectrum too."""
        return 1.0 / _NEW_SEA < spectrum.peak_period / self.spectrum.peak_period < _NEW_SEA

    def renew(self, spectrum: Spectrum, centre: tuple[float, float]) -> None:
        """A new spectrum and centre; the waves found stay."""
        made = [lattice.rescaled(spectrum) for lattice in self.lattices]
        if self.unknowns is not None:
            self.unknowns = [
                np.where(new.scale > 0.0, mine * (old.scale / np.maximum(new.scale, 1e-12)), 0.0).astype(np.complex64)
                for mine, old, new in zip(self.unknowns, self.lattices, made, strict=True)
            ]
        self.spectrum, self.lattices, self.centre = spectrum, made, centre

    @property
    def left(self) -> float:
        """m², of waves that no lattice carries."""
        return max(self.spectrum.variance - sum(lattice.variance for lattice in self.lattices), 0.0)

    def keep(self, numbers: set[int]) -> None:
        """Drops the batches of all other turns."""
        self.batches = {number: parts for number, parts in self.batches.items() if number in numbers}

    def add(self, seen: Sequence[Observations], numbers: Sequence[int]) -> None:
        """Takes up observations, each of one turn."""
        for each, number in zip(seen, numbers, strict=True):
            inside = each[np.hypot(each.x - self.centre[0], each.y - self.centre[1]) <= self.reach]
            self.batches[number] = [self._batch(part) for part in _in_time(inside)]

    def _batch(self, seen: Observations, place: tuple[Field, Field] | None = None) -> Batch:
        weight, load = weights(seen, self.lattices, self.left, self.centre)
        made = WaveSum(seen, self.lattices, self.spectrum.water, weight, self.centre, place)
        return Batch(seen, made, weight, load)

    @property
    def _all(self) -> list[Batch]:
        return [batch for parts in self.batches.values() for batch in parts]

    def settle(self, workers: Executor) -> None:
        """Fits the waves to all that was seen."""
        for parts in self.batches.values():
            for n, batch in enumerate(parts):
                parts[n] = replace(batch, **_weighed(batch, self))
        values = [self.above_home(batch) for batch in self._all]
        self.unknowns, self.steps = solve(self._all, self.lattices, workers, self.unknowns, values)

    def above_home(self, batch: Batch) -> NDArray[np.float32]:
        """Values less what puts the mean level back, by which water is higher than its waves say."""
        seen = batch.seen
        distance = np.hypot(seen.x - self.centre[0], seen.y - self.centre[1])
        level = sum((distance < each.radius) * each.sinking(self.spectrum.water) for each in self.lattices)
        return (seen.value - np.where(seen.kind == "elevation", self.sharpness * level, 0.0)).astype(np.float32)

    @property
    def amplitudes(self) -> Unknowns:
        """m, of each lattice."""
        assert self.unknowns is not None
        return [
            lattice.scale.astype(np.float32) * part for lattice, part in zip(self.lattices, self.unknowns, strict=True)
        ]

    def _values(self, batch: Batch, kind: str) -> Field:
        """Of the fitted waves at the places of a batch of elevations."""
        factors = [lattice.factor(kind, self.spectrum.water) for lattice in self.lattices]
        waves = [(f * a).astype(np.complex64) for f, a in zip(factors, self.amplitudes, strict=True)]
        return batch.sum.values(waves).astype(np.float64)

    def shift_evidence(self, number: int | None) -> Field:
        """Σ w r d and Σ w d² of residuals r by the shift d of water that its waves move, of one turn's elevations at
        their own places, or of all."""
        total = np.zeros(2)
        for batch in self.batches[number] if number is not None else self._all:
            if not len(batch.seen) or not np.all(batch.seen.kind == "elevation"):
                continue
            rest = batch.seen.value - self._values(batch, "elevation")
            shift = -sum(
                self._values(batch, f"displacement_{axis}") * self._values(batch, f"slope_{axis}") for axis in "xy"
            )
            shift = shift - np.average(shift, weights=batch.weight)  # the mean level is known, and put back
            total += [np.sum(batch.weight * rest * shift), np.sum(batch.weight * shift**2)]
        return total

    def relabel(self, sharpness: float, number: int | None = None) -> None:
        """Moves places to where the water there is at home, of one turn's batches or of all."""
        self.sharpness = sharpness
        if sharpness == 0.0:
            return
        for key in [number] if number is not None else list(self.batches):
            self.batches[key] = [self._batch(each.seen, self._home(each, sharpness)) for each in self.batches[key]]

    def _home(self, batch: Batch, sharpness: float) -> tuple[Field, Field]:
        if batch.seen.kind[0] != "elevation":  # the sum holds what its own kind is of the waves
            batch = self._batch(replace(batch.seen, kind=np.array(["elevation"])))
        away = [sharpness * self._values(batch, f"displacement_{axis}") for axis in "xy"]
        return batch.seen.x - away[0], batch.seen.y - away[1]

    def field(self, issued: float, sharpness: float) -> WaveField:
        """The waves as they are known now."""
        knowledge = Knowledge.of(self.spectrum, self.lattices, self._all, self.centre)
        return WaveField(
            tuple(self.lattices),
            tuple(self.amplitudes),
            self.spectrum,
            knowledge,
            issued,
            sharpness,
            len(self.batches),
        )


def _weighed(batch: Batch, fit: Fit) -> dict[str, Field]:
    weight, load = weights(batch.seen, fit.lattices, fit.left, fit.centre)
    return {"weight": weight, "load": load}


def _in_time(seen: Observations) -> list[Observations]:
    """Observations in parts, each of a short time and one kind."""
    if not len(seen):
        return []
    number = np.floor((seen.time - seen.time.min()) / _SPAN_S).astype(int)
    parts = [
        seen[(number == each) & (seen.kind == kind)] for each in np.unique(number) for kind in np.unique(seen.kind)
    ]
    return [part for part in parts if len(part)]


def _centre(polar: xr.Dataset) -> tuple[float, float]:
    """Where the antennas were at the end of a turn, m."""
    if "antenna_x" not in polar:
        return 0.0, 0.0
    last = int(np.argmax(polar["time"].values))
    x, y = (float(np.nan_to_num(polar[name].values[last])) for name in ("antenna_x", "antenna_y"))
    return x, y
