"""The likelihoods of a sea's wave systems: of heights where waves are long, of a periodogram where they are short."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import solve_triangular

from ..physics.dispersion import Water
from ..physics.wave_spectra import cos2s
from .periodogram import Periodogram
from .wave_spectrum import Field
from .wave_systems import (
    Heights,
    WaveSystem,
    jonswap,
    plane_waves,
)

_SPLIT = 9.0  # of kR: waves up to here are compared as they are, shorter ones by their periodogram
_LEAK = 3.0  # times that: of waves which blocks still hold a part of
_BLOCKS = 7.0  # in a circle's radius
_FULL = 0.4  # of a block, that is in sight: of emptier ones the crests alone are seen


LONGEST_PERIOD_S, _STEP = 26.0, 0.07  # periods that are looked for; relative, between frequencies


DIRECTIONS = 36
_BASIS = 3.0  # /R, between wavevectors that the data are reduced to
_MODEL_KNOWN = 0.4  # of a ring's power, relative: no sea is a sum of such systems
_LEAST_NOISE = 0.02  # of the variance: blocks' heights err by more than their cells' noise
_HIDDEN = 0.3  # of the variance, by the square of the share of a block that is not in sight
_LEAST_TRANSFER = 0.5  # share that cells keep, of waves that are looked at
_LEVEL_KNOWN = 0.3  # of σ: heights in sight are those of crests rather, all around alike, and with the distance


class GaussianLikelihood:
    """The likelihood of blocks' heights, reduced to what the longest waves make of them."""

    def __init__(self, turns: Sequence[Heights], water: Water) -> None:
        reach = max(float(np.hypot(t.x - t.x.mean(), t.y - t.y.mean()).max()) for t in turns)
        self.reach = reach
        blocks = [_blocks(turn, reach / _BLOCKS) for turn in turns]
        x, y, time, value, noise = (np.concatenate(each) for each in zip(*blocks, strict=True))
        x, y, time = x - x.mean(), y - y.mean(), time - time.max()
        self.split = _SPLIT / reach
        most = float(water.frequency(np.array(_LEAK * self.split))) / (2.0 * np.pi)
        count = max(int(np.log(most * LONGEST_PERIOD_S) / _STEP), 8)
        self.frequency = np.exp(np.linspace(-np.log(LONGEST_PERIOD_S), np.log(most), count))
        self.step = np.gradient(self.frequency)
        self.toward = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
        self.wavenumber = water.wavenumber(2.0 * np.pi * self.frequency)
        # Data reduced to waves of a coarse lattice, both ways in time.
        side = int(1.1 * _SPLIT / _BASIS) + 1
        grid: Field = np.arange(-side, side + 1, dtype=np.float64) * (_BASIS / reach)
        kx, ky = (np.asarray(each.ravel(), np.float64) for each in np.meshgrid(grid, grid, indexing="ij"))
        kept = np.hypot(kx, ky) < 1.1 * self.split
        basis = plane_waves(kx[kept], ky[kept], water, x, y, time)
        basis = np.concatenate((basis.real, basis.imag), axis=1) / np.sqrt(x.size)
        k = np.repeat(self.wavenumber, DIRECTIONS)
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
        modes = self.modes.reshape(self.data.size, 2, self.frequency.size, DIRECTIONS)
        modes = (
            (modes * np.sqrt(self._fan(toward, exponent)))
            .transpose(2, 0, 1, 3)
            .reshape(self.frequency.size, self.data.size, -1)
        )
        return modes @ modes.transpose(0, 2, 1)

    def covariance(self, power: Field, nugget: float) -> Field:
        """Covariance of the data, (datum, datum)."""
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


class WhittleLikelihood:
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
