"""How a scene's nonlinear sea is worked out: its waves, its time step, its slow beginning, its breaking, its memory;
and the scene's linear waves as its beginning."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...settings import SeaSettings
from ..realisation import resolution
from ..surface import Sea
from ..systems import WaveFacts, wave_facts
from ..wave_trains import LineTrain, PlaneTrain, RegularTrain, WaveTrain
from .evolution import CUT_OFF, PER_PERIOD, Evolution, LowPass, State
from .rates import HIGHEST_ORDER, Band, Rates

_OFF_LATTICE = 1e-6  # of a wavenumber step: so far a regular wave may be from one that repeats on the patch
RELAXING_PERIODS = 5.0  # Ta of the slow beginning, in peak periods of the longest system
BEFORE = 1.6  # of Ta, for which the sea evolves before its record begins: by then 99.9 % of the nonlinear rates act
_STEPS_A_PERIOD = 30.0  # of the steepest system's peak
_MOST_TURN = 0.5  # rad, by which the orbits of the long waves (three standard deviations) carry the shortest in a step
_FEWEST_WAVES = 8  # to either side, of which a patch must carry so many
_ALONG_AN_AXIS = 1e-9


@dataclass(frozen=True)
class LinearStart:
    """Linear waves on the rectangle on which they repeat, which is the scene's patch; of waves that all run along one
    axis, one line of it (of long-crested systems: four sides long).

    Raises InputError for waves that repeat on no such rectangle.
    """

    sea: Sea
    extent: float  # m, side of the patch
    depth: float  # m

    def __post_init__(self) -> None:
        if not self.sea.trains:
            raise InputError("sea.waves: has no waves, and a level sea stays level; give a [[sea.waves]]")
        lines = [train for train in self.sea.trains if isinstance(train, LineTrain)]
        if lines and not any(self.axes):
            raise InputError(
                "sea.waves: long-crested waves repeat on a nonlinear sea's patch only if all waves run along one axis; "
                "set wave_from_deg to 270, 90, 0 or 180, or give every system another spreading"
            )
        for train in self.sea.trains:
            if isinstance(train, RegularTrain):
                _indices(train, self.lengths)

    @property
    def axes(self) -> tuple[bool, bool]:
        """Whether all waves run along x, or all along y."""
        towards = [None if isinstance(train, PlaneTrain) else train.toward for train in self.sea.trains]
        return tuple(
            all(toward is not None and abs(toward[across]) < _ALONG_AN_AXIS for toward in towards) for across in (1, 0)
        )  # type: ignore[return-value]

    @property
    def lengths(self) -> tuple[float, float]:
        """Lengths of the rectangle along x and y, m."""
        longest = max((train.lattice.length for train in self.sea.trains if isinstance(train, LineTrain)), default=0.0)
        length = max(self.extent, longest)
        return length, length

    def band(self, spacing: float) -> Band:
        """All waves that points so far apart [m] can carry."""
        length_x, length_y = self.lengths
        along_x, along_y = self.axes
        most_x, most_y = (int(np.ceil(0.5 * length / spacing - 1e-9)) - 1 for length in self.lengths)
        return Band(length_x, length_y, 0 if along_y else most_x, 0 if along_x else most_y, self.depth)

    def state(self, band: Band, time: float) -> State:
        """The linear waves at a time [s], as far as the band carries them."""
        rows, columns = band.most_y, band.most_x
        amplitude = np.zeros((2 * rows + 1, 2 * columns + 1), dtype=np.complex128)
        for train in self.sea.trains:
            _add(amplitude, train, self.lengths)
        whole = np.concatenate((np.arange(rows + 1), np.arange(-rows, 0))) + rows
        ahead = 0.5 * amplitude[whole][:, columns:]
        behind = 0.5 * np.conj(amplitude[::-1, ::-1])[whole][:, columns:]
        turned = np.exp(-1j * np.remainder(band.omega * time, 2.0 * np.pi))
        ahead, behind = ahead * turned, behind * np.conj(turned)
        speed = band.omega / np.where(band.rise > 0.0, band.rise, np.inf)
        return State(time, ahead + behind, -1j * speed * (ahead - behind))


def _add(amplitude: NDArray[np.complex128], train: WaveTrain, lengths: tuple[float, float]) -> None:
    """Add a train's waves, those that the array carries, to the amplitudes (ky, kx) of −m … m."""
    if isinstance(train, RegularTrain):
        column, row = _indices(train, lengths)
        given, at = np.array([[train.amplitude * np.exp(1j * train.phase)]]), (row, column)
    elif isinstance(train, LineTrain):
        east, north = (round(part) for part in train.toward)
        given, at = train.amplitude[:, :: east or north], (0, 0)
        given = given if east else given.T
    else:
        given, at = train.amplitude, (0, 0)
    here, there = [], []
    for size, number, shift in zip(amplitude.shape, given.shape, at, strict=True):
        most, reach = size // 2, number // 2
        low, high = max(-most, shift - reach), min(most, shift + reach)
        if low > high:
            return
        here.append(slice(low + most, high + most + 1))
        there.append(slice(low - shift + reach, high - shift + reach + 1))
    amplitude[tuple(here)] += given[tuple(there)]


def _indices(train: RegularTrain, lengths: tuple[float, float]) -> tuple[int, int]:
    """How often a regular wave repeats along x and y."""
    turns = train.wavenumber / (2.0 * np.pi)
    exact = [turns * part * length for part, length in zip(train.toward, lengths, strict=True)]
    whole = tuple(round(number) for number in exact)
    if any(abs(number - near) > _OFF_LATTICE * max(1, abs(near)) for number, near in zip(exact, whole, strict=True)):
        raise InputError(
            f"sea.waves: a regular wave of {1.0 / turns:.6g} m repeats {exact[0]:.4g} × {exact[1]:.4g} times on a "
            f"nonlinear sea's patch of {lengths[0]:.6g} m, must do so a whole number of times; set extent_m, "
            "wavelength_m and wave_from_deg so"
        )
    return whole[0], whole[1]


def peaks(settings: SeaSettings) -> list[WaveFacts]:
    """Peaks of every wave system that has waves."""
    return [facts for waves in settings.waves if (facts := wave_facts(waves, settings.depth_m)) is not None]


@dataclass(frozen=True)
class Plan:
    """A scene's nonlinear sea of an order 1 … 5 on points `requested` metres apart (None: as far as breaking lets waves
    live, 8 wavenumbers of the steepest system's peak, or the scene's own resolution where that is coarser).

    settings: of the sea. sea: its linear waves. Raises InputError for an order, a spacing or waves that cannot be.
    """

    settings: SeaSettings
    sea: Sea
    order: int = 3
    requested: float | None = None

    def __post_init__(self) -> None:
        if not 1 <= self.order <= HIGHEST_ORDER:
            raise InputError(f"--order = {self.order}: must be 1 to {HIGHEST_ORDER}; 3 holds what seas of waves do")
        length = max(self.start.lengths)
        widest = 0.5 * length / _FEWEST_WAVES
        if self.requested is not None and not 0.0 < self.requested <= widest:
            raise InputError(
                f"--spacing = {self.requested:g}: must be above 0 and at most {widest:.4g} (it is half the shortest "
                f"wave, and the patch of {length:g} m must carry {_FEWEST_WAVES} of different length); choose it so"
            )

    @cached_property
    def start(self) -> LinearStart:
        """The linear waves, and where they repeat."""
        return LinearStart(self.sea, self.settings.extent_m, self.settings.depth_m)

    @cached_property
    def steepest(self) -> WaveFacts:
        """The system that breaks first."""
        return max(peaks(self.settings), key=lambda peak: peak.wavenumber * peak.deviation)

    @property
    def relaxing(self) -> float:
        """Ta, s."""
        return RELAXING_PERIODS * max(peak.peak_period for peak in peaks(self.settings))

    @cached_property
    def spacing(self) -> float:
        """Half the shortest wave, m."""
        if self.requested is not None:
            return self.requested
        widest = 0.5 * max(self.start.lengths) / _FEWEST_WAVES
        return min(widest, max(resolution(self.settings), math.pi / (CUT_OFF * self.steepest.wavenumber)))

    @cached_property
    def band(self) -> Band:
        """The waves that there are."""
        return self.start.band(self.spacing)

    @property
    def breaking(self) -> LowPass | None:
        """The filter cuts where the waves end: at 8 wavenumbers of the peak, if the spacing is the default. None for
        linear waves."""
        return None if self.order == 1 else LowPass(math.pi / self.spacing, PER_PERIOD / self.steepest.peak_period)

    @property
    def longest_step(self) -> float:
        """The longest time step that follows the waves, s."""
        orbits = 3.0 * math.hypot(*(2.0 * math.pi / peak.peak_period * peak.deviation for peak in peaks(self.settings)))
        carried = _MOST_TURN * self.spacing / (math.pi * orbits)
        return min(self.steepest.peak_period / _STEPS_A_PERIOD, carried)

    @property
    def memory(self) -> int:
        """Bytes that one step takes, about: fields on the points of the products, and some of the waves."""
        rows, columns = Rates(self.band, self.order).points
        fields = 3 * self.order + 7 if self.order > 1 else 2
        return 8 * rows * columns * fields + 16 * 30 * int(np.prod(self.band.shape))

    def evolution(self, first: float, interval: float) -> Evolution:
        """What carries the sea to its record's first time [s] and from there on, whole steps an interval [s]."""
        step = interval / math.ceil(interval / self.longest_step)
        before = self.steps_before(step)
        relaxed_from = first - before * step
        return Evolution(self.band, self.order, step, self.breaking, relaxed_from, self.relaxing)

    def steps_before(self, step: float) -> int:
        """How many steps the sea evolves before its record begins; none at order 1, which has nothing to relax."""
        return 0 if self.order == 1 else math.ceil(BEFORE * self.relaxing / step)

    def beginning(self, evolution: Evolution) -> State:
        """The linear waves where the nonlinear rates set in."""
        return self.start.state(self.band, evolution.relaxed_from)
