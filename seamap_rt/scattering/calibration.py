"""The facets' share keeps the modulation, a measured model sets the mean: one smooth scale between them.

A mean over all directions sets the scale by grazing angle alone, so that the sum of power around each ring is the
model's and how it changes with direction is theory's. A model that knows the wind sets both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

_RIDGE = 1e-4  # regularisation towards a constant scale, as a share of the data's weight: fixes what they do not
_MARGIN = np.log(2.0)  # the factor stays within 3 dB of what some bin asks for, however few are lit
_NEWTON_STEPS = 50
_HARMONICS = 4  # coefficients of the wind's direction
_LEAST_GRAZING = 1e-4  # rad; a ray that meets the sea from below the horizon counts as this one


@dataclass(frozen=True)
class Scale:
    """The smooth factor exp(P + a cos φ + b cos 2φ) of `fit_scale`; beyond the grazing of the fit, its edge value."""

    log_grazing: tuple[float, float]  # fitted to
    coefficients: NDArray[np.floating]  # of `_basis`
    exponents: tuple[float, float]  # that some bin asks for

    def __call__(self, grazing: ArrayLike, wind_angle: ArrayLike) -> NDArray[np.floating]:
        """Factor at a grazing [rad, against mean sea level] and angle to the wind [rad]; they broadcast."""
        return self.factor(*self.terms(grazing, wind_angle))

    def factor(
        self,
        level: NDArray[np.floating],
        depth: NDArray[np.floating],
        flat: NDArray[np.floating],
        lean: NDArray[np.floating],
    ) -> NDArray[np.floating]:
        """The factor of parts of `terms`; they broadcast."""
        low, high = self.exponents
        return np.exp(np.clip((level + flat) + depth * lean, low - _MARGIN, high + _MARGIN))

    def terms(self, grazing: ArrayLike, wind_angle: ArrayLike) -> tuple[NDArray[np.floating], ...]:
        """The exponent in parts that are separate, level + flat + depth · lean: level and depth are the grazing's
        (its shape), the others the wind's."""
        depth = np.clip(_scaled(_log(np.asarray(grazing)), self.log_grazing), -1.0, 1.0)
        return _exponent(self.coefficients, depth, np.cos(np.asarray(wind_angle)))


def fit_scale(
    raw_power: ArrayLike,
    horizontal_area: ArrayLike,
    target_nrcs: ArrayLike,
    grazing: ArrayLike,
    wind_angle: ArrayLike | None,
    *,
    degree: int = 3,
    bins: tuple[int, int] = (24, 24),
) -> Scale:
    """The smooth scale with which Σ raw_power · scale = Σ target_nrcs · horizontal_area over any broad patch.

    raw_power: m², a facet's radar cross-section before calibration, 0 where dark: dark facets count in the
    area, since a measured σ0 contains shadowing. horizontal_area: m². target_nrcs: linear, per horizontal
    area. grazing: rad, of the ray against mean sea level. wind_angle: rad between the look and the wind's
    axis; None for a target that is a mean over all directions: then a and b are 0, and each ring of grazing keeps its
    sum of power and the facets' own shape over azimuth. They broadcast. ValueError for a negative or non-finite power,
    area or target. Where nothing at all is lit or wanted, the factor is 1.

    The factor is exp(P + a cos φ + b cos 2φ), P a polynomial of `degree` in log grazing, a and b straight lines in it
    (theory's contrast of up- and down-wind grows towards grazing): as smooth as the measured model and far too smooth
    to take out a wave, which a factor gate by gate would do. The facets are summed in broad bins of grazing and wind
    angle. With r = Σ raw/Σ target of a bin and w = √area · (the bin's target over its grazing angle's mean), the fit of
    η = log factor starts from the weighted least squares of −log r and minimises Σ w (r e^η − η), which is convex: at
    its minimum Σ w r e^η = Σ w, so that a bin in shadow (log r = −∞) counts as well. Grazing angles and sectors in
    which nothing is lit do not count. What a narrow sector does not determine, a ridge sets to 0.
    """
    power, area, target = (np.asarray(each) for each in (raw_power, horizontal_area, target_nrcs))
    for name, values in (("raw_power", power), ("horizontal_area", area), ("target_nrcs", target)):
        if values.size and not (values.min() >= 0.0 and np.isfinite(values.max())):
            raise ValueError(f"{name}: must be finite and not negative; give 0 for a facet without echo")
    log_grazing = _log(np.asarray(grazing))
    if log_grazing.size == 0:
        return _unity((0.0, 0.0), degree)
    limits = (float(log_grazing.min()), float(log_grazing.max()))
    depth = _scaled(log_grazing, limits)
    # The factor is even in the angle, so ±φ share a bin.
    cosine = np.cos(np.asarray(0.0 if wind_angle is None else wind_angle))
    wanted, power, area, depth, cosine = np.broadcast_arrays(target * area, power, area, depth, cosine)

    cell = (_bin(depth, bins[0]) * bins[1] + _bin(cosine, bins[1])).ravel()
    members = np.bincount(cell, minlength=bins[0] * bins[1])
    raw_sum, wanted_sum, area_sum, depth_sum, cosine_sum = (
        np.bincount(cell, weights=each.ravel(), minlength=members.size) for each in (power, wanted, area, depth, cosine)
    )
    used = (wanted_sum > 0.0) & _neighbours_of_lit(np.reshape(raw_sum > 0.0, bins))
    if not np.any(raw_sum[used]):
        return _unity(limits, degree)
    ratio = raw_sum[used] / wanted_sum[used]
    basis = _basis(depth_sum[used] / members[used], cosine_sum[used] / members[used], degree)
    if wind_angle is None:
        basis[:, -_HARMONICS:] = 0.0  # which the ridge then leaves at 0
    corrections = -np.log(ratio[ratio > 0.0])
    # Bins of one grazing angle count by their target power, so that its sum over the wind angles comes out right.
    per_area = np.reshape(np.divide(wanted_sum, area_sum, out=np.zeros(area_sum.size), where=area_sum > 0.0), bins)
    grazing_area = np.maximum(np.sum(np.reshape(area_sum, bins), axis=1), 1e-300)
    grazing_mean = (np.sum(np.reshape(wanted_sum, bins), axis=1) / grazing_area)[:, None]
    share = np.divide(per_area, grazing_mean, out=np.zeros(bins), where=grazing_mean > 0.0).ravel()
    weight = (np.sqrt(area_sum) * share)[used]
    return Scale(limits, _fit(basis, ratio, weight), (float(corrections.min()), float(corrections.max())))


def _unity(limits: tuple[float, float], degree: int) -> Scale:
    return Scale(limits, np.zeros(degree + 1 + _HARMONICS), (0.0, 0.0))


def _log(grazing: NDArray[np.floating]) -> NDArray[np.floating]:
    return np.log(np.maximum(grazing, np.float32(_LEAST_GRAZING)))


def _scaled(value: NDArray[np.floating], limits: tuple[float, float]) -> NDArray[np.floating]:
    """A quantity brought linearly from its limits to [−1, 1]; all −1 if it does not vary."""
    low, high = limits
    return (value - low) * (2.0 / max(high - low, 1e-6)) - 1.0


def _bin(value: NDArray[np.floating], count: int) -> NDArray[np.int32]:
    """The bin, 0 to count − 1, of each value in [−1, 1]."""
    return np.clip(((value + 1.0) * (0.5 * count)).astype(np.int32), 0, count - 1)


def _neighbours_of_lit(lit: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which bins, flattened, share their grazing with some lit bin and their wind angle with some lit bin."""
    return np.logical_and.outer(lit.any(axis=1), lit.any(axis=0)).ravel()


def _basis(depth: NDArray[np.floating], cosine: NDArray[np.floating], degree: int) -> NDArray[np.floating]:
    """Columns: Legendre polynomials of the scaled log grazing x, cos φ, cos 2φ, x cos φ, x cos 2φ."""
    legendre = np.polynomial.legendre.legvander(depth, degree)
    double = 2.0 * cosine**2 - 1.0
    return np.column_stack((legendre, cosine, double, depth * cosine, depth * double))


def _exponent(
    coefficients: NDArray[np.floating], depth: NDArray[np.floating], cosine: NDArray[np.floating]
) -> tuple[NDArray[np.floating], ...]:
    """`_basis` times the coefficients, without the matrix, in the facets' own precision; see `Scale.terms`."""
    legendre, harmonics = coefficients[:-_HARMONICS], coefficients[-_HARMONICS:].astype(depth.dtype)
    polynomial = np.polynomial.legendre.leg2poly(legendre).astype(depth.dtype)
    first, second, first_slope, second_slope = harmonics
    double = 2.0 * cosine**2 - 1.0
    level = np.polynomial.polynomial.polyval(depth, polynomial)
    return level, depth, first * cosine + second * double, first_slope * cosine + second_slope * double


def _fit(basis: NDArray[np.floating], ratio: NDArray[np.float64], weight: NDArray[np.float64]) -> NDArray[np.floating]:
    """Coefficients β that minimise Σ w (ratio e^{Xβ} − Xβ) plus the ridge, by damped Newton steps."""
    weight = weight / weight.sum()
    level = np.log(weight @ ratio)  # taken out first, so that units and absolute levels do not matter
    ratio = ratio / np.exp(level)
    ridge = np.diag([0.0] + [_RIDGE] * (basis.shape[1] - 1))

    lit = ratio > 0.0  # a dark bin stays dark at any scale: it enters only by the regularisation
    bright, power, pull = basis[lit], weight[lit] * ratio[lit], basis.T @ weight

    def cost(beta: NDArray[np.floating]) -> float:
        with np.errstate(over="ignore"):
            return float(power @ np.exp(bright @ beta) - pull @ beta + 0.5 * beta @ ridge @ beta)

    weighted = bright * weight[lit, None]
    start = np.linalg.solve(weighted.T @ bright + ridge, -weighted.T @ np.log(ratio[lit]))
    beta = min((start, np.zeros_like(start)), key=cost)
    for _ in range(_NEWTON_STEPS):
        model = power * np.exp(bright @ beta)
        step = np.linalg.solve(bright.T @ (model[:, None] * bright) + ridge, pull - bright.T @ model - ridge @ beta)
        length, here = 1.0, cost(beta)
        while not cost(beta + length * step) <= here and length > 1e-9:
            length *= 0.5
        beta = beta + length * step
        if np.max(np.abs(step)) < 1e-10:
            break
    beta[0] -= level
    return beta
