"""First-order Lagrangian ("choppy") waves, seen at fixed places on the ground.

Water that rests at the *label* ξ moves to ξ + D(ξ, t) and stands η(ξ, t) + c high: linear waves' own displacement,
whose horizontal part sharpens crests and flattens troughs (Gerstner 1802 for one wave; Nouguier, Guérin & Chapron 2009
for a random sea). A place x shows the label with ξ + D(ξ, t) = x. With J = I + ∇D the slope there is J⁻¹ ∇η, the
water's velocity (∂D/∂t, ∂η/∂t), and a crest breaks over (the surface folds) where det J ≤ 0.

For Gaussian waves, with M = ⟨η ∇D⟩ = −∫ k̂ k̂ᵀ k coth(kh) Ψ d²k, the mean level over the ground is tr M (it sinks,
which the constant c puts back) and the variance m₀ − |M|², exactly. So the waves are made larger by √s,
s m₀ − s²|M|² = m₀, and the significant height stays as set.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..physics.dispersion import orbital_ratio
from .wave_trains import LinearSurface, Points, Quantity, RegularTrain

MOST_FOLDED = 0.02  # of the water, at time 0: beyond it first-order Lagrangian waves do not hold
_PHASE_ERROR = 3e-3  # rad of the shortest wave, to which labels are found
_PASSES = 12  # of Newton's method; two do nearly everywhere
_NEAR_A_FOLD = 0.4  # det J below which other labels are looked for,
_BESIDE_A_FOLD = 0.95, 0.1  # or below the first of these if it falls below the second at a label nearby
_FOLDING = 5.0  # standard deviations of the strain within which det J = 0 counts as possible at all
_STARTS = 9  # a side of the square of labels from which others are looked for
_SEARCH_CHUNK = 4096  # places searched at a time


class Labels(NamedTuple):
    """Where the water over each of n places rests."""

    x: NDArray[np.float64]  # (n,) m
    y: NDArray[np.float64]  # (n,) m
    folded: NDArray[np.bool_]  # (n,) the surface stands there more than once: the highest upright sheet is taken


class _Step(NamedTuple):
    """One step of Newton's method."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    missed: NDArray[np.float64]  # m, how far the label's water was from its place before the step
    determinant: NDArray[np.float64]


@dataclass(frozen=True)
class Displacement:
    """Second moments of the horizontal displacement D; those of independent waves add."""

    covariance: NDArray[np.float64]  # (2, 2) m, ⟨η ∇D⟩
    variance: float  # m², ⟨|D|²⟩
    strain: float  # ⟨(∇·D)²⟩
    curvature: float  # 1/m², ⟨|∇∇·D|²⟩

    @staticmethod
    def none() -> Displacement:
        return Displacement(np.zeros((2, 2)), 0.0, 0.0, 0.0)

    @staticmethod
    def of(east: NDArray, north: NDArray, variance: NDArray, depth: float) -> Displacement:
        """Facts of waves with wave vectors (east, north) [rad/m] and variances [m²], which broadcast."""
        k = np.hypot(east, north)
        safe = np.where(k > 0.0, k, 1.0)
        orbital = np.where(k > 0.0, orbital_ratio(safe, depth), 0.0)
        pull = variance * orbital / safe
        mixed = -float(np.sum(pull * east * north))
        covariance = np.array([[-float(np.sum(pull * east**2)), mixed], [mixed, -float(np.sum(pull * north**2))]])
        spread = variance * orbital**2
        return Displacement(covariance, *(float(np.sum(spread * k**power)) for power in (0, 2, 4)))

    @staticmethod
    def of_regular(wave: RegularTrain) -> Displacement:
        """Facts of one regular wave."""
        east, north = (wave.wavenumber * np.array([part]) for part in wave.toward)
        return Displacement.of(east, north, np.array([0.5 * wave.amplitude**2]), wave.depth)

    def __add__(self, other: Displacement) -> Displacement:
        return Displacement(
            self.covariance + other.covariance,
            self.variance + other.variance,
            self.strain + other.strain,
            self.curvature + other.curvature,
        )


@dataclass(frozen=True)
class ChoppySurface:
    """Linear waves as labels' displacements; the same questions as `LinearSurface` answers, at fixed places."""

    waves: LinearSurface
    displacement: Displacement  # of the waves as drawn
    shortest: float  # rad/m, the largest wavenumber

    @property
    def set_down(self) -> float:
        """How far the mean level would sink, m: put back, so that heights refer to mean sea level."""
        return -float(np.trace(self.displacement.covariance))

    def sample(
        self, x: Points, y: Points, t: Points, quantities: Sequence[Quantity], rate: float = 0.0
    ) -> NDArray[np.float64]:
        """Quantities (quantity, n); "rate" is the rise of the water particle, w; rate: μ of the relaxed ones, 1/s."""
        labels = self.labels(x, y, t)
        sloping = "slope_east" in quantities or "slope_north" in quantities
        wanted = tuple(dict.fromkeys((*quantities, *(_SLOPES + _GRADIENT if sloping else ()))))
        result = dict(zip(wanted, self.waves.sample(labels.x, labels.y, t, wanted, rate), strict=True))
        if "elevation" in result:
            result["elevation"] += self.set_down
        if sloping:
            east_east, east_north, north_north = (result[name] for name in _GRADIENT)
            determinant = (1.0 + east_east) * (1.0 + north_north) - east_north**2
            east, north = result["slope_east"], result["slope_north"]
            result["slope_east"] = ((1.0 + north_north) * east - east_north * north) / determinant
            result["slope_north"] = ((1.0 + east_east) * north - east_north * east) / determinant
        return np.stack([result[name] for name in quantities])

    def folded(self, x: Points, y: Points, t: Points) -> NDArray[np.bool_]:
        """(n,): the surface stands there more than once."""
        return self.labels(x, y, t).folded

    def elevation_rate(self, x: Points, y: Points, t: Points, current: tuple[float, float]) -> NDArray[np.float64]:
        """∂η/∂t (n,) m/s, by the kinematic condition w − (u + U)·∇η."""
        rise, flow_east, flow_north, slope_east, slope_north = self.sample(
            x, y, t, ("rate", "flow_east", "flow_north", "slope_east", "slope_north")
        )
        return rise - (flow_east + current[0]) * slope_east - (flow_north + current[1]) * slope_north

    def labels(self, x: Points, y: Points, t: Points) -> Labels:
        """The labels over the places (n,), by Newton's method. Where the surface folds there are several: then that of
        the highest sheet, those that lie upside down in the fold's loop left out."""
        shift = self.waves.sample(x, y, t, ("shift_east", "shift_north"))
        label_x, label_y = x - shift[0], y - shift[1]
        bend = np.sqrt(self.displacement.curvature)
        determinant = np.zeros(x.size)
        open_ = np.arange(x.size)
        for _ in range(_PASSES):
            step = self._newton(label_x[open_], label_y[open_], x[open_], y[open_], t[open_])
            label_x[open_], label_y[open_], determinant[open_] = step.x, step.y, step.determinant
            # What Newton's step leaves is quadratic in it; near a fold only a small step is trusted.
            left = 3.0 * bend * step.missed**2 / np.maximum(step.determinant, 0.1)
            open_ = open_[left * self.shortest > _PHASE_ERROR]
            if open_.size == 0:
                break
        determinant[open_] = 0.0  # no label found yet: a fold is why
        folded = np.zeros(x.size, dtype=bool)
        suspects = np.flatnonzero(self._is_near_fold(label_x, label_y, t, determinant))
        for start in range(0, suspects.size, _SEARCH_CHUNK):
            at = suspects[start : start + _SEARCH_CHUNK]
            label_x[at], label_y[at], folded[at] = self._highest(x[at], y[at], t[at], label_x[at], label_y[at])
        return Labels(label_x, label_y, folded)

    def _is_near_fold(
        self, label_x: Points, label_y: Points, t: Points, determinant: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """(n,): the surface turns over at the label, or at one of sixteen around it, out to the rms displacement."""
        near = determinant < _NEAR_A_FOLD
        if np.sqrt(self.displacement.strain) * _FOLDING < 1.0:
            return near
        beside, folded = _BESIDE_A_FOLD
        unsure = np.flatnonzero(~near & (determinant < beside))
        reach = np.sqrt(0.5 * self.displacement.variance)
        angle = np.pi * np.arange(8) / 4.0
        away_x = np.outer((0.5 * reach, reach), np.cos(angle)).reshape(-1, 1)
        away_y = np.outer((0.5 * reach, reach), np.sin(angle)).reshape(-1, 1)
        for start in range(0, unsure.size, _SEARCH_CHUNK):
            at = unsure[start : start + _SEARCH_CHUNK]
            around_x, around_y = (label_x[at] + away_x).ravel(), (label_y[at] + away_y).ravel()
            east_east, east_north, north_north = self.waves.sample(
                around_x, around_y, np.tile(t[at], away_x.size), _GRADIENT
            )
            around = (1.0 + east_east) * (1.0 + north_north) - east_north**2
            near[at] = around.reshape(away_x.size, -1).min(axis=0) < folded
        return near

    def _newton(self, label_x: Points, label_y: Points, x: Points, y: Points, t: Points) -> _Step:
        """A step towards ξ + D(ξ) = x; where the surface turns over, a plain step of the fixed point."""
        shift_east, shift_north, east_east, east_north, north_north = self.waves.sample(
            label_x, label_y, t, ("shift_east", "shift_north", *_GRADIENT)
        )
        miss_x, miss_y = label_x + shift_east - x, label_y + shift_north - y
        determinant = (1.0 + east_east) * (1.0 + north_north) - east_north**2
        steep = determinant < 0.1
        inverse = 1.0 / np.where(steep, 1.0, determinant)
        step_x = np.where(steep, miss_x, inverse * ((1.0 + north_north) * miss_x - east_north * miss_y))
        step_y = np.where(steep, miss_y, inverse * ((1.0 + east_east) * miss_y - east_north * miss_x))
        missed = np.hypot(miss_x, miss_y)
        # No step beyond the displacement itself: close to a fold Newton's step diverges.
        most = 2.0 * np.sqrt(self.displacement.variance)
        shrink = np.minimum(1.0, most / np.maximum(np.hypot(step_x, step_y), 1e-300))
        return _Step(label_x - shrink * step_x, label_y - shrink * step_y, missed, determinant)

    def _highest(
        self, x: Points, y: Points, t: Points, label_x: Points, label_y: Points
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
        """The highest of all labels over places near a fold, and whether there are several."""
        reach = 3.0 * np.sqrt(self.displacement.variance) * np.linspace(-1.0, 1.0, _STARTS)
        away_x, away_y = (grid.reshape(-1, 1) for grid in np.meshgrid(reach, reach))
        # Around the place, and from the label that was found before.
        start_x, start_y = np.vstack((x + away_x, label_x)).ravel(), np.vstack((y + away_y, label_y)).ravel()
        starts = away_x.size + 1
        target_x, target_y, time = (np.tile(each, starts) for each in (x, y, t))
        missed = np.full(start_x.size, np.inf)
        open_ = np.arange(start_x.size)
        for _ in range(2 * _PASSES):
            step = self._newton(start_x[open_], start_y[open_], target_x[open_], target_y[open_], time[open_])
            missed[open_] = np.where(step.determinant > 0.0, step.missed, np.inf)
            arrived = missed[open_] * self.shortest < _PHASE_ERROR
            moving = open_[~arrived]
            start_x[moving], start_y[moving] = step.x[~arrived], step.y[~arrived]
            open_ = moving
            if open_.size == 0:
                break
        height = self.waves.sample(start_x, start_y, time, ("elevation",))[0]
        shape = (starts, x.size)
        arrived = (missed * self.shortest < _PHASE_ERROR).reshape(shape)
        best = np.argmax(np.where(arrived, height.reshape(shape), -np.inf), axis=0), np.arange(x.size)
        start_x, start_y = start_x.reshape(shape), start_y.reshape(shape)
        # Two sheets' labels lie apart by more than what is left of the search; no label at all is a fold too.
        away = np.where(arrived, np.hypot(start_x - start_x[best], start_y - start_y[best]), 0.0).max(axis=0)
        apart = away > 10.0 * _PHASE_ERROR / self.shortest
        result = arrived.any(axis=0)
        return (
            np.where(result, start_x[best], label_x),
            np.where(result, start_y[best], label_y),
            apart | ~result,
        )


_SLOPES: tuple[Quantity, ...] = ("slope_east", "slope_north")
_GRADIENT: tuple[Quantity, ...] = ("shift_east_east", "shift_east_north", "shift_north_north")


def height_keeping_scale(random: float, covariance: NDArray[np.float64], regular: NDArray[np.float64]) -> float:
    """Factor s on the random waves' variance with which the sea's variance over the ground stays as set.

    random: variance m₀ [m²] of the random waves; covariance: their M = ⟨η ∇D⟩ (2, 2) m; regular: that of the regular
    waves, which keep their height. Raises ValueError for waves so steep that no factor does.
    """
    # s m₀ − |s M + R|² = m₀ − |R|²
    square, cross = float(np.sum(covariance**2)), float(np.sum(covariance * regular))
    if random <= 0.0 or square == 0.0:
        return 1.0
    half = 0.5 * (random - 2.0 * cross)
    root = half**2 - square * random
    if root < 0.0:
        raise ValueError(
            f"model = 'choppy': the waves are too steep for it (⟨η ∇·D⟩ = {np.trace(covariance):.3g} m at "
            f"{np.sqrt(random):.3g} m rms); lower the waves, coarsen resolution_m or use model = 'linear'"
        )
    return (half - float(np.sqrt(root))) / square


def check_folding(share: float) -> None:
    """Raise ValueError where too much of the surface breaks over."""
    if share > MOST_FOLDED:
        raise ValueError(
            f"model = 'choppy': {share:.1%} of the water would fold over, may be at most {MOST_FOLDED:.0%} "
            "(first-order Lagrangian waves do not break); lower the waves, coarsen resolution_m or use model = 'linear'"
        )
