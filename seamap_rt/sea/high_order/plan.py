"""How a scene's nonlinear sea is worked out: its waves, its time step, its slow beginning, its breaking, its memory."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...errors import InputError
from ...physics.dispersion import angular_frequency
from ...settings import RandomWaves, SeaSettings, SinusoidWaves
from ..realisation import resolution
from ..surface import Sea
from ..systems import spectral_system
from .basin import Band
from .evolution import CUT_OFF, PER_PERIOD, Evolution, LowPass, State
from .linear_start import LinearStart
from .rates import HIGHEST_ORDER, Rates

RELAXING_PERIODS = 5.0  # Ta of the slow beginning, in peak periods of the longest system
BEFORE = 1.6  # of Ta, for which the sea evolves before its record begins: by then 99.9 % of the nonlinear rates act
_STEPS_A_PERIOD = 30.0  # of the steepest system's peak
_MOST_TURN = 0.5  # rad, by which the orbits of the long waves (three standard deviations) carry the shortest in a step
_FEWEST_WAVES = 8  # to either side, of which a patch must carry so many


@dataclass(frozen=True)
class Peak:
    """One system's peak: wavenumber [rad/m], period [s], standard deviation of the elevation [m]."""

    wavenumber: float
    period: float
    deviation: float


def peaks(settings: SeaSettings) -> list[Peak]:
    """Of every wave system that has waves."""
    found = []
    for waves in settings.waves:
        if isinstance(waves, RandomWaves):
            system = spectral_system(waves, settings.depth_m)
            k, deviation = system.peak_wavenumber, math.sqrt(system.variance)
        elif isinstance(waves, SinusoidWaves):
            k, deviation = 2.0 * math.pi / waves.wavelength_m, waves.height_m / math.sqrt(8.0)
        else:
            continue
        if deviation > 0.0:
            found.append(Peak(k, 2.0 * math.pi / float(angular_frequency(k, settings.depth_m)), deviation))
    return found


@dataclass(frozen=True)
class Plan:
    """A scene's nonlinear sea of an order 1 … 5 on points `asked` metres apart (None: as far as breaking lets waves
    live, 8 wavenumbers of the steepest system's peak, or the scene's own resolution where that is coarser).

    settings: of the sea. sea: its linear waves. Raises InputError for an order, a spacing or waves that cannot be.
    """

    settings: SeaSettings
    sea: Sea
    order: int = 3
    asked: float | None = None

    def __post_init__(self) -> None:
        if not 1 <= self.order <= HIGHEST_ORDER:
            raise InputError(f"--order = {self.order}: must be 1 to {HIGHEST_ORDER}; 3 holds what seas of waves do")
        length = max(self.start.lengths)
        widest = 0.5 * length / _FEWEST_WAVES
        if self.asked is not None and not 0.0 < self.asked <= widest:
            raise InputError(
                f"--spacing = {self.asked:g}: must be above 0 and at most {widest:.4g} (it is half the shortest wave, "
                f"and the patch of {length:g} m must carry {_FEWEST_WAVES} of different length); choose it so"
            )

    @cached_property
    def start(self) -> LinearStart:
        """The linear waves, and where they repeat."""
        return LinearStart(self.sea, self.settings.extent_m, self.settings.depth_m)

    @cached_property
    def steepest(self) -> Peak:
        """The system that breaks first."""
        return max(peaks(self.settings), key=lambda peak: peak.wavenumber * peak.deviation)

    @property
    def relaxing(self) -> float:
        """Ta, s."""
        return RELAXING_PERIODS * max(peak.period for peak in peaks(self.settings))

    @cached_property
    def spacing(self) -> float:
        """Half the shortest wave, m."""
        if self.asked is not None:
            return self.asked
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
        return None if self.order == 1 else LowPass(math.pi / self.spacing, PER_PERIOD / self.steepest.period)

    @property
    def longest_step(self) -> float:
        """The longest time step that follows the waves, s."""
        orbits = 3.0 * math.hypot(*(2.0 * math.pi / peak.period * peak.deviation for peak in peaks(self.settings)))
        carried = _MOST_TURN * self.spacing / (math.pi * orbits)
        return min(self.steepest.period / _STEPS_A_PERIOD, carried)

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
