"""Wave systems: a sea as the sum of a few JONSWAP spectra, each spread as cos^2s(θ/2), and what follows from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr

from ..conventions import wrap_degrees
from ..physics.dispersion import Water
from ..physics.wave_spectra import cos2s, jonswap_integral, jonswap_shape
from .wave_spectrum import Field

EXPONENT, ENHANCEMENT = (15.0, 0.8), (2.5, 0.6)  # of a system: what is usual, and how well its logarithm is known
SYSTEM_VALUES = 5  # ln variance, ln frequency, toward, ln exponent, ln enhancement
SYSTEM_WORTH = 8.0  # of log-likelihood, for a further system
LONGEST = 1.0 / 18.0  # of the split, that is kR = ½: a circle of so small a part of a wave shows a level, not a wave
_UNSURE = 0.2  # chance that waves run the other way, above which no way is given
_UNEVEN = 0.4  # of the chance by few waves: real seas are no sums of such systems
_DRAWS = 32  # of the systems' values, whose mean is the expected spectrum
_POINTS, _MODES = 400, 600  # that a sea's covariance is worked out of and with


@dataclass(frozen=True)
class WaveSystem:
    """variance [m²]; frequency [Hz], intrinsic, of the peak; toward [rad]; exponent s of cos^2s(θ/2)."""

    variance: float
    frequency: float
    toward: float
    exponent: float = EXPONENT[0]
    enhancement: float = ENHANCEMENT[0]


@dataclass(frozen=True)
class Heights:
    """Heights of one turn; arrays (cell,): x, y [m], time [s], height [m], noise [m²], weight [m²]."""

    x: Field
    y: Field
    time: Field
    height: Field
    noise: Field
    weight: Field


@dataclass(frozen=True)
class WaveSystems:
    """Systems of a sea, strongest first, and the covariance of their values (`values_of`), one after the other."""

    systems: tuple[WaveSystem, ...]
    covariance: Field
    likelihood: float
    gain: float
    nugget: float
    reversal: float  # chance that all of them run the other way
    water: Water
    split: float  # rad/m, up to which waves were compared as they are
    alternatives: tuple[tuple[float, WaveSystems], ...] = ()  # seas of one system more, and the chance of each

    def density(self, frequency: ArrayLike) -> Field:
        """m²/Hz of all systems."""
        at = np.asarray(frequency, np.float64)
        return np.sum([each.variance * jonswap(at, each.frequency, each.enhancement) for each in self.systems], axis=0)

    def table(self, wavenumber: Field, toward: Field) -> Field:
        """Variance density by wavevector [m⁴], (wavenumber, direction), as it is expected: the mean over what the
        systems' peaks, directions and widths may be, and over the alternatives."""
        shapes = np.arange(self.covariance.shape[0]) % SYSTEM_VALUES > 0
        covariance = np.where(np.outer(shapes, shapes), self.covariance, 0.0)
        values = np.array([values_of(each) for each in self.systems])
        drawn = np.random.default_rng(0).multivariate_normal(values.ravel(), covariance, _DRAWS, check_valid="ignore")
        chance = (1.0 - sum(chance for chance, _ in self.alternatives)) / _DRAWS
        seas = [(chance, [system_of(row) for row in moved.reshape(values.shape)]) for moved in drawn]
        seas += [(chance, list(other.systems)) for chance, other in self.alternatives]
        expected = np.zeros((wavenumber.size, toward.size))
        for chance, systems in seas:
            expected += chance * self._table(systems, wavenumber, toward)
        return expected

    def _table(self, systems: Sequence[WaveSystem], wavenumber: Field, toward: Field) -> Field:
        frequency = self.water.frequency(wavenumber) / (2.0 * np.pi)
        per_wavevector = self.water.group_speed(wavenumber) / (2.0 * np.pi * wavenumber)
        return np.sum(
            [
                (each.variance * jonswap(frequency, each.frequency, each.enhancement) * per_wavevector)[:, None]
                * cos2s(toward - each.toward, each.exponent)
                for each in systems
            ],
            axis=0,
        )

    def figures(self, samples: float) -> dict[str, float]:
        """Peak period, mean direction and spread, with standard errors, from so many independent heights: those of the
        systems that were found, and the mean square of what the alternatives say otherwise."""
        figures = self._waves()._figures(samples)
        apart = {"peak_period": 0.0, "mean_direction": 0.0}
        for chance, other in self.alternatives:
            period, toward = (
                other._highest_peak()[0],
                np.degrees(np.angle(_moment(np.array([values_of(each) for each in other.systems])))),
            )
            apart["peak_period"] += chance * (period - figures["peak_period"]) ** 2
            if "mean_direction" in figures:
                turned = wrap_degrees(toward + 180.0 - figures["mean_direction"])
                apart["mean_direction"] += chance * float(turned) ** 2
        for name, square in apart.items():
            if name in figures:
                figures[f"{name}_std"] = float(np.hypot(figures[f"{name}_std"], np.sqrt(square)))
        return figures

    def _waves(self) -> WaveSystems:
        """Without systems too long for the circle to tell from a level; all of them where there are no others."""
        k = self.water.wavenumber(2.0 * np.pi * np.array([each.frequency for each in self.systems]))
        kept = np.flatnonzero(k >= LONGEST * self.split)
        if kept.size in (0, k.size):
            return self
        values = (SYSTEM_VALUES * kept[:, None] + np.arange(SYSTEM_VALUES)).ravel()
        covariance = self.covariance[np.ix_(values, values)]
        return replace(self, systems=tuple(self.systems[n] for n in kept), covariance=covariance)

    def _figures(self, samples: float) -> dict[str, float]:
        """Figures of these systems alone."""
        period, error = self._peak()
        figures = {"peak_period": period, "peak_period_std": error}
        values = np.array([values_of(each) for each in self.systems])

        mean = _moment(values)
        slopes = np.zeros((2, values.size))
        for n in range(values.size):
            moved = values.copy()
            moved.flat[n] += 1e-4
            change = _moment(moved) / mean
            slopes[:, n] = np.angle(change) / 1e-4, (abs(change) - 1.0) * abs(mean) / 1e-4
        turned, shrunk = np.sqrt(np.einsum("in,nm,im->i", slopes, self.covariance, slopes))
        wide = np.sqrt(2.0 * max(1.0 - abs(mean), 1e-6))
        chance = _UNEVEN * wide / np.sqrt(0.5 * samples)
        toward = float(np.degrees(np.angle(mean)))
        figures |= {"mean_axis": toward % 180.0}
        if self.reversal > _UNSURE:
            return figures
        reversed_ = np.pi * np.sqrt(self.reversal)
        return figures | {
            "mean_direction": (toward + 180.0) % 360.0,
            "mean_direction_std": float(np.degrees(np.linalg.norm((turned, chance, reversed_)))),
            "directional_spread": float(np.degrees(wide)),
            "directional_spread_std": float(np.degrees(shrunk / wide)),
        }

    def _peak(self) -> tuple[float, float]:
        """Period of the highest peak [s] and its standard error: by its own frequency's, and by the chance that another
        system's peak is the higher one."""
        period, first, level = self._highest_peak()
        variance = self.covariance[SYSTEM_VALUES * first + 1, SYSTEM_VALUES * first + 1] * period**2
        for n, other in enumerate(self.systems):
            if n != first:
                at = [SYSTEM_VALUES * first, SYSTEM_VALUES * n]
                own = self.covariance[np.ix_(at, at)]
                unsure = np.sqrt(max(own[0, 0] + own[1, 1] - 2.0 * own[0, 1], 1e-12))
                chance = float(ndtr((level[n] - level[first]) / unsure))
                variance += chance * (1.0 / other.frequency - period) ** 2
        return period, float(np.sqrt(variance))

    def _highest_peak(self) -> tuple[float, int, Field]:
        """Its period [s], its system's number, and the logarithms of the density at the systems' peaks."""
        level = np.log(self.density([each.frequency for each in self.systems]))
        first = int(np.argmax(level))
        return 1.0 / self.systems[first].frequency, first, level

    def samples(self, turns: Sequence[Heights]) -> float:
        """Independent normal heights that the mean square of some turns' heights is worth: V² over the mean of C² over
        pairs of places and times, C the systems' covariance."""
        stream = np.random.default_rng(0)
        each = max(_POINTS // len(turns), 20)
        rows = []
        for turn in turns[-_POINTS // 20 :]:
            at = stream.choice(turn.x.size, each, p=turn.weight / turn.weight.sum())
            rows.append(np.stack((turn.x[at], turn.y[at], turn.time[at])))
        x, y, time = np.concatenate(rows, axis=1)
        total = sum(system.variance for system in self.systems)
        frequency, toward = [], []
        for system in self.systems:
            count = int(np.ceil(_MODES * system.variance / total))
            grid = system.frequency * np.geomspace(0.4, 12.0, 800)
            cumulative = np.cumsum(jonswap(grid, system.frequency, system.enhancement) * np.gradient(grid))
            quantile = (np.arange(count) + 0.5) / count
            frequency.append(np.interp(quantile, cumulative / cumulative[-1], grid))
            angle = np.linspace(-np.pi, np.pi, 721)
            fan = np.cumsum(cos2s(angle, system.exponent))
            toward.append(system.toward + np.interp(stream.permutation(quantile), fan / fan[-1], angle))
        way, k = np.concatenate(toward), self.water.wavenumber(2.0 * np.pi * np.concatenate(frequency))
        waves = plane_waves(
            k * np.sin(way), k * np.cos(way), self.water, x - x.mean(), y - y.mean(), time - time.mean()
        )
        covariance = np.real(waves @ waves.conj().T) / k.size
        pairs = ~np.eye(x.size, dtype=bool)
        # As few waves as stand for the sea raise the mean by half of one over their number.
        return float(1.0 / max(np.mean(covariance[pairs] ** 2) - 0.5 / k.size, 1e-5))


def _moment(values: Field) -> complex:
    """First moment of the directions of systems of such values (system, value)."""
    weight, exponent = np.exp(values[:, 0] - values[:, 0].max()), np.exp(values[:, 3])
    return complex(np.sum(weight * np.exp(1j * values[:, 2]) * exponent / (exponent + 1.0)) / weight.sum())


def jonswap(frequency: Field, peak: float, gamma: float) -> Field:
    """Density [1/Hz] of a JONSWAP spectrum of variance 1 at frequencies [Hz] above 0."""
    return jonswap_shape(frequency / peak, gamma) / (peak * jonswap_integral(gamma))


def values_of(system: WaveSystem) -> list[float]:
    """ln variance, ln frequency, toward, ln exponent, ln enhancement."""
    logs = (system.variance, system.frequency, 1.0, system.exponent, system.enhancement)
    values = [float(np.log(each)) for each in logs]
    values[2] = system.toward
    return values


def system_of(values: NDArray[Any]) -> WaveSystem:
    """The system of such values."""
    variance, frequency, _, exponent, enhancement = (float(each) for each in np.exp(np.minimum(values, 50.0)))
    return WaveSystem(variance, frequency, float(values[2]), exponent, enhancement)


def plane_waves(kx: Field, ky: Field, water: Water, x: Field, y: Field, time: Field) -> NDArray[np.complex128]:
    """e^(j(k·x − ω t)), (place, wave)."""
    omega = water.frequency(np.hypot(kx, ky)) + water.doppler_shift(kx, ky)
    return np.exp(1j * (np.multiply.outer(x, kx) + np.multiply.outer(y, ky) - np.multiply.outer(time, omega)))
