"""Waves in time: linear waves exactly, the rest by Runge and Kutta's fourth order.

The state is turned forward by its linear waves' own rotation, and only the nonlinear rates are stepped (an integrating
factor: Lawson 1967). A step is then as long as the nonlinear rates allow, and of order 1 it is exact, however long.

A sea that begins as linear waves lacks the waves that they bind, and would shed them as spurious free ones. So the
nonlinear rates set in slowly, by 1 − exp(−(t/Ta)⁴) (Dommermuth 2000).

Breaking is the energy that steepening waves drive into waves too short for the model.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .rates import Band, Rates, Waves

CUT_OFF = 8.0  # of the filter, in wave numbers of the peak
SHARPNESS = 30.0
PER_PERIOD = 64.0  # how often in a peak period the filter of the paper acts in full


@dataclass(frozen=True)
class LowPass:
    """The low-pass filter exp(−(k/k_c)³⁰) of Xiao et al. (2013, J. Fluid Mech. 720, 357–392).

    Theirs acts after each of their time steps, with k_c = 8 wave numbers of the peak, tuned to the energy that breaking
    waves lost in a tank. Here it acts at a rate, so that a shorter step does not damp more.
    """

    cut_off: float  # k_c, rad/m
    rate: float  # 1/s, how often it acts in full

    def share_left(self, band: Band, step: float) -> NDArray[np.float64]:
        """Share of each wave's amplitude that is left after a step of so many seconds."""
        with np.errstate(over="ignore", under="ignore"):
            steep = (np.sqrt(band.square) / self.cut_off) ** SHARPNESS
            return np.exp(-self.rate * step * np.minimum(steep, 1e3))


RELAXING_POWER = 4
_MOST_GROWTH = 2.0  # of the energy in a step: it is kept, so more is the end of a sea that was too steep


@dataclass(frozen=True)
class State:
    """The sea at a time: all that its future depends on. Equal states have equal futures, bit by bit."""

    time: float  # s
    elevation: Waves  # m
    potential: Waves  # m²/s, at the surface
    energy: float = np.nan  # m³/s², at the beginning of the last step; see `Evolution.energy`
    broken: float = 0.0  # m³/s², taken out by breaking so far

    @property
    def significant_height(self) -> float:
        """4 × the standard deviation of the elevation, m."""
        square = np.abs(self.elevation) ** 2
        return 4.0 * float(np.sqrt(2.0 * square.sum() - square[:, 0].sum()))


@dataclass(frozen=True)
class Evolution:
    """What carries a state from step to step of a fixed length.

    step: s. relaxed_from, relaxing: when the nonlinear rates set in, and Ta [s]; 0 for at once.
    """

    band: Band
    order: int
    step: float
    breaking: LowPass | None = None
    relaxed_from: float = -np.inf
    relaxing: float = 0.0

    @cached_property
    def rates(self) -> Rates:
        """The nonlinear rates."""
        return Rates(self.band, self.order)

    @cached_property
    def _half(self) -> _Rotation:
        return _Rotation.of(self.band, 0.5 * self.step)

    @cached_property
    def _unbroken_share(self) -> NDArray[np.float64] | None:
        return None if self.breaking is None else self.breaking.share_left(self.band, self.step)

    def advanced(self, state: State, steps: int = 1) -> State:
        """The state so many steps later. Raises FloatingPointError where the sea has no future."""
        with np.errstate(over="ignore", invalid="ignore"):  # the energy shows a sea without a future
            for _ in range(steps):
                state = self._step(state)
        return state

    def energy(self, state: State) -> float:
        """½ ⟨r η² + φs ∂η/∂t⟩ of all waves [m³/s²]: energy over the area and the water's density."""
        return self._energy(state, self.rates(state.elevation, state.potential)[0])

    def _energy(self, state: State, rate: Waves) -> float:
        band = self.band
        rising = band.rise * state.potential + rate
        potential = band.mean_product(band.restoring * state.elevation, state.elevation)
        return 0.5 * (potential + band.mean_product(state.potential, rising))

    def _share(self, time: float) -> float:
        """Share of the nonlinear rates that act."""
        if self.relaxing <= 0.0:
            return 1.0
        return -float(np.expm1(-(max(0.0, (time - self.relaxed_from) / self.relaxing) ** RELAXING_POWER)))

    def _step(self, state: State) -> State:
        h, turn, time = self.step, self._half, state.time
        start = self.rates(state.elevation, state.potential)
        energy = self._energy(state, start[0])
        if not (np.isfinite(energy) and (np.isnan(state.energy) or energy < _MOST_GROWTH * state.energy)):
            raise FloatingPointError(f"at {time:.4g} s its energy has no bounds")
        first = _scaled(start, self._share(time))
        middle = turn(state.elevation, state.potential)
        turned = turn(*first)
        half_share = self._share(time + 0.5 * h)
        second = _scaled(self.rates(*_sum(middle, turned, 0.5 * h)), half_share)
        third = _scaled(self.rates(*_sum(middle, second, 0.5 * h)), half_share)
        end = self.rates(*turn(*_sum(middle, third, h)))
        inner = tuple(
            m + h / 6.0 * (a + 2.0 * (b + c)) for m, a, b, c in zip(middle, turned, second, third, strict=True)
        )
        elevation, potential = _sum(turn(*inner), _scaled(end, self._share(time + h)), h / 6.0)
        stepped = replace(state, time=time + h, elevation=elevation, potential=potential, energy=energy)
        return stepped if self._unbroken_share is None else self._break_waves(stepped, self._unbroken_share, end)

    def _break_waves(self, state: State, left: NDArray[np.float64], rates: tuple[Waves, Waves]) -> State:
        """What breaking leaves of a state with these nonlinear rates, and the energy that goes with the rest.

        The rates are the energy's derivatives, ∂η/∂t by φs and −∂φs/∂t by η; its second derivative is taken as that of
        linear waves.
        """
        band = self.band
        elevation, potential = left * state.elevation, left * state.potential
        gone = state.elevation - elevation, state.potential - potential
        pressure = band.restoring * (state.elevation - 0.5 * gone[0]) - rates[1]
        rising = band.rise * (state.potential - 0.5 * gone[1]) + rates[0]
        lost = band.mean_product(pressure, gone[0]) + band.mean_product(rising, gone[1])
        return replace(state, elevation=elevation, potential=potential, broken=state.broken + lost)


@dataclass(frozen=True)
class _Rotation:
    """Linear waves some time later: η cos ωt + φ (k tanh kh/ω) sin ωt, φ cos ωt − η (r/ω) sin ωt."""

    cosine: NDArray[np.float64]
    rise: NDArray[np.float64]
    fall: NDArray[np.float64]

    @staticmethod
    def of(band: Band, time: float) -> _Rotation:
        moving = np.where(band.omega > 0.0, band.omega, 1.0)
        over = np.where(band.omega > 0.0, np.sin(band.omega * time) / moving, time)
        return _Rotation(np.cos(band.omega * time), band.rise * over, band.restoring * over)

    def __call__(self, elevation: Waves, potential: Waves) -> tuple[Waves, Waves]:
        return self.cosine * elevation + self.rise * potential, self.cosine * potential - self.fall * elevation


def _scaled(waves: tuple[Waves, Waves], factor: float) -> tuple[Waves, Waves]:
    return (waves[0] * factor, waves[1] * factor) if factor != 1.0 else waves


def _sum(waves: tuple[Waves, Waves], added: tuple[Waves, Waves], factor: float) -> tuple[Waves, Waves]:
    return waves[0] + factor * added[0], waves[1] + factor * added[1]
