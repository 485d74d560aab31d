"""The drawn sea beside what was asked for: heights and slopes over points and times, and what is expected of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..conventions import unit_from_azimuth
from ..report.reduce import main_waves
from ..scene import Scene
from ..sea import Sea

Array = NDArray[np.float64]


@dataclass
class Moments:
    """Sums over points and times, for the moments of heights and slopes."""

    count: int = 0
    powers: Array = field(default_factory=lambda: np.zeros(4))  # Σ η, η², η³, η⁴
    slopes: Array = field(default_factory=lambda: np.zeros((2, 2)))  # Σ ∇η ∇ηᵀ, east north

    def add(self, height: NDArray[np.float32], slope_x: NDArray[np.float32], slope_y: NDArray[np.float32]) -> None:
        eta = height.astype(np.float64).ravel()
        gradient = np.stack((slope_x.ravel(), slope_y.ravel())).astype(np.float64)
        self.count += eta.size
        self.powers += [float(np.sum(eta**power)) for power in (1, 2, 3, 4)]
        self.slopes += gradient @ gradient.T

    @property
    def mean(self) -> float:
        """Mean level, m."""
        return float(self.powers[0] / self.count)

    @property
    def variance(self) -> float:
        """Variance of the elevation about its mean, m²."""
        return max(0.0, float(self.powers[1] / self.count) - self.mean**2)

    @property
    def significant_height(self) -> float:
        """Four standard deviations, m."""
        return 4.0 * math.sqrt(self.variance)

    @property
    def skewness(self) -> float:
        """NaN where there is no wave."""
        first, second, third, _ = self.powers / self.count
        return _ratio(third - 3.0 * first * second + 2.0 * first**3, self.variance**1.5)

    @property
    def kurtosis(self) -> float:
        """3 of a Gaussian sea."""
        first, second, third, fourth = self.powers / self.count
        central = fourth - 4.0 * first * third + 6.0 * first**2 * second - 3.0 * first**4
        return _ratio(central, self.variance**2)

    def slope_variance(self, azimuth_deg: float) -> float:
        """Mean square of the slope along an azimuth."""
        along = np.array(unit_from_azimuth(azimuth_deg))
        return float(along @ self.slopes @ along) / self.count


def _ratio(value: float, over: float) -> float:
    return float(value) / over if over > 1e-30 else float("nan")


def requested_height(sea: Sea) -> float:
    """Significant height of all waves of the scene, the short ones that are not resolved too; m."""
    return 4.0 * math.sqrt(sea.resolved.total_variance)


def chance_of_height(sea: Sea) -> float:
    """Standard deviation of a whole patch's significant height over its realisations, m.

    A random wave's variance is exponentially distributed about what is expected of it.
    """
    random = np.concatenate((_plane(sea).ravel(), _lines(sea).ravel()))
    variance = float(np.sum(random)) + float(np.sum(0.5 * sea.spectrum["sinusoid_amplitude"].values ** 2))
    return 2.0 * math.sqrt(float(np.sum(random**2)) / variance) if variance > 0.0 else 0.0


def expected_kurtosis(sea: Sea) -> float:
    """3 of a Gaussian sea, less of one with regular waves, whose fourth cumulant is −3a⁴/8; NaN without waves."""
    fourth = float(np.sum(sea.spectrum["sinusoid_amplitude"].values ** 4))
    return 3.0 - _ratio(0.375 * fourth, sea.resolved.variance**2)


def expected_slope_variance(sea: Sea, azimuth_deg: float) -> float:
    """Mean square slope along an azimuth that linear waves of the resolved spectrum have."""
    spectrum = sea.spectrum
    east, north = (float(part) for part in unit_from_azimuth(azimuth_deg))
    along = spectrum["kx"].values * east + spectrum["ky"].values[:, None] * north
    random = float(np.sum(_plane(sea) * along**2))
    toward = np.radians(spectrum["line_toward"].values - azimuth_deg)
    random += float(np.sum(_lines(sea) * spectrum["k"].values ** 2 * np.cos(toward)[:, None] ** 2))
    steepness = spectrum["sinusoid_amplitude"].values * spectrum["sinusoid_wavenumber"].values
    regular = 0.5 * (steepness * np.cos(np.radians(spectrum["sinusoid_toward"].values - azimuth_deg))) ** 2
    return random + float(np.sum(regular))


def _plane(sea: Sea) -> Array:
    """(ky, kx) m² of the short-crested waves."""
    return sea.spectrum["variance_density"].values * _step(sea, "kx") ** 2


def _lines(sea: Sea) -> Array:
    """(line, k) m² of the long-crested waves."""
    return sea.spectrum["line_density"].values * _step(sea, "k")


def _step(sea: Sea, name: str) -> float:
    return float(np.diff(sea.spectrum[name].values[:2]).sum())  # 0 of none


def statistics_table(scene: Scene, sea: Sea, drawn: Moments, side_m: float) -> str:
    """The table as plain text."""
    resolved = sea.resolved
    waves, chance, kurtosis = main_waves(scene), chance_of_height(sea), expected_kurtosis(sea)
    from_deg = waves.from_deg if waves is not None else 0.0
    rows = [
        ("significant height, m", requested_height(sea), 4.0 * resolved.elevation_std, drawn.significant_height),
        ("mean level, m", 0.0, 0.0, drawn.mean),
        ("skewness", resolved.skewness_stokes, 0.0, drawn.skewness),
        ("kurtosis", kurtosis, kurtosis, drawn.kurtosis),
    ]
    for name, azimuth in (("along", from_deg), ("across", from_deg + 90.0)):
        expected = expected_slope_variance(sea, azimuth)
        rows.append((f"mean square slope {name} the waves", math.nan, expected, drawn.slope_variance(azimuth)))
    total = drawn.slope_variance(0.0) + drawn.slope_variance(90.0)
    rows.append(("mean square slope", resolved.total_mean_square_slope, resolved.mean_square_slope, total))
    lines = [f"{'':34}{'asked for':>12}{'resolved':>12}{'this sea':>12}"]
    lines += [f"{name:34}" + "".join(f"{_figure(value):>12}" for value in values) for name, *values in rows]
    notes = [
        "asked for: all waves of the scene; its skewness is 3 k σ of a narrow-banded second-order sea "
        "(Longuet-Higgins 1963).",
        f"resolved: expected of linear waves longer than {2.0 * resolved.resolution_m:.3g} m.",
        f"this sea: over {side_m:.4g} m × {side_m:.4g} m and all times; over the whole patch chance moves its "
        f"significant height by {_figure(chance)} m (one standard deviation), over a part of it by more.",
        f"Waves come from {from_deg:.4g}°.",
    ]
    if resolved.choppy is not None:
        notes.append(
            f"Choppy waves: {resolved.choppy.folded_share:.2%} of the water folds over; sharp crests raise the mean "
            "square slope above that of linear waves."
        )
    return "\n".join((f"{scene.name}, seed {scene.seed}", "", *lines, "", *notes, ""))


def _figure(value: float) -> str:
    return "—" if math.isnan(value) else f"{value:.4g}" if abs(value) > 1e-12 else "0"
