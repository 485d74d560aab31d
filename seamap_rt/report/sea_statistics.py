"""What the sea of a run was, in words, and the drawn sea beside the settings: heights, slopes, folds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..conventions import unit_from_azimuth
from ..scene import Scene
from ..sea import Sea
from . import reduce

Row = tuple[str, str]
NO_WAVES_DB = -60.0  # a spectrum that begins so far below the resolved waves' has none there
_LEAST_COVERED = 0.9  # of the ground cells of the first turn


def sea_rows(metrics: Mapping[str, Any]) -> list[Row]:
    """Label and value of each fact that the metrics hold of the sea; none if they hold none."""
    sea = _group(metrics, "sea")
    if not sea:
        return []
    rows = [
        ("Resolved", f"waves longer than {_number(sea, 'resolution_m', 3, 2.0)} m"),
        ("Share of the variance resolved", _share(sea, "variance_share")),
        ("Share of the same spectra's mean square slope resolved", _share(sea, "mean_square_slope_share")),
        ("Significant height, resolved (4σ)", f"{_number(sea, 'elevation_std', 3, 4.0)} m"),
        ("Mean square slope, resolved", _number(sea, "mean_square_slope", 3)),
        ("Rms slope towards east, north", f"{_number(sea, 'slope_std_east', 3)}, {_number(sea, 'slope_std_north', 3)}"),
        ("Significant height over the peak's length", _number(sea, "significant_steepness", 2)),
    ]
    short = _group(metrics, "short_waves")
    if short:
        rows += [
            ("Left to the scattering: waves shorter than", f"{_length(short)} m"),
            ("Their mean square slope", _number(short, "mean_square_slope", 3)),
            ("Share of the whole mean square slope on the mesh", _share(short, "resolved_slope_share")),
            ("Step of the spectrum where they take over", _step(short)),
        ]
    choppy = _group(sea, "choppy")
    if choppy:
        rows += [
            ("Choppy: mean level put back", f"{_number(choppy, 'set_down', 2, 100.0)} cm"),
            ("Choppy: waves enlarged to keep the height", f"× {_number(choppy, 'amplitude_scale', 4)}"),
            ("Choppy: skewness of the elevation", _number(choppy, "skewness", 2)),
            ("Choppy: share of the water that folds over at time 0", _share(choppy, "folded_share", 3)),
            ("Choppy: most of a turn's mesh under a fold", _share(metrics, "folded_share", 3)),
        ]
    rows.append(("Skewness of a narrow-banded second-order sea (3kσ)", _number(sea, "skewness_stokes", 2)))
    return rows


def warnings(metrics: Mapping[str, Any]) -> list[str]:
    """What a reader must know before any figure, a line each."""
    notes = (fold_warning(metrics), ground_warning(metrics), objects_warning(metrics))
    return [*(each for each in notes if each), *(metrics.get("vessel_notes") or ())]


def fold_warning(metrics: Mapping[str, Any]) -> str | None:
    """One line if choppy waves folded over anywhere, else None."""
    water = reduce.number(_group(_group(metrics, "sea"), "choppy").get("folded_share"))
    mesh = reduce.number(metrics.get("folded_share"))
    worst = np.nanmax([water, mesh, 0.0])
    if worst <= 0.0:
        return None
    return (
        f"sea.model = 'choppy': crests fold over on {water:.2g} of the water and {mesh:.2g} of the mesh; the highest "
        "sheet is meshed there"
    )


def ground_warning(metrics: Mapping[str, Any]) -> str | None:
    """One line if the boat ran off the ground maps, else None."""
    covered = reduce.number(metrics.get("ground_covered"))
    if not covered < _LEAST_COVERED:
        return None
    return (
        f"the boat runs off the ground maps, which lie around its start: of the last turn they hold {covered:.0%}; the "
        "polar maps hold all of it"
    )


def objects_warning(metrics: Mapping[str, Any]) -> str | None:
    """One line if objects echo more than the sea around them, else None."""
    rows = [row for row in metrics.get("modelled") or () if row.get("what") == "objects"]
    over = reduce.number(rows[0].get("value")) if rows and str(rows[0].get("unit", "")).startswith("dB") else np.nan
    if not over > 0.0:
        return None
    return (
        f"objects echo up to {over:.0f} dB over the sea in their cells: there, and in their sidelobes, heights are "
        "theirs and not the sea's"
    )


def _group(metrics: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    result = metrics.get(name)
    return result if isinstance(result, Mapping) else {}


def _number(facts: Mapping[str, Any], name: str, digits: int, factor: float = 1.0) -> str:
    value = factor * reduce.number(facts.get(name))
    return f"{value:.{digits}g}" if np.isfinite(value) else "—"


def _share(facts: Mapping[str, Any], name: str, digits: int = 4) -> str:
    value = 100.0 * reduce.number(facts.get(name))
    return f"{value:.{digits}g} %" if np.isfinite(value) else "—"


def _step(short: Mapping[str, Any]) -> str:
    if reduce.number(short.get("level_step_db")) < NO_WAVES_DB:
        return "the wind raises no waves of that length"
    return f"{_number(short, 'level_step_db', 2)} dB"


def _length(short: Mapping[str, Any]) -> str:
    limit = reduce.number(short.get("wavenumber_from"))
    return f"{2.0 * np.pi / limit:.3g}" if limit > 0.0 else "—"


@dataclass
class Moments:
    """Sums over points and times, for the moments of heights and slopes."""

    count: int = 0
    powers: NDArray[np.float64] = field(default_factory=lambda: np.zeros(4))  # Σ η, η², η³, η⁴
    slopes: NDArray[np.float64] = field(default_factory=lambda: np.zeros((2, 2)))  # Σ ∇η ∇ηᵀ, east north

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
        """Of the elevation about its mean, m²."""
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
    variance, square = _variances(sea)
    return 4.0 * 0.5 * math.sqrt(square / variance) if variance > 0.0 else 0.0


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


def _plane(sea: Sea) -> NDArray[np.float64]:
    """(ky, kx) m² of the short-crested waves."""
    spectrum = sea.spectrum
    step = float(spectrum["kx"].values[1] - spectrum["kx"].values[0]) if spectrum.sizes["kx"] else 0.0
    return spectrum["variance_density"].values * step**2


def _lines(sea: Sea) -> NDArray[np.float64]:
    """(line, k) m² of the long-crested waves."""
    spectrum = sea.spectrum
    step = float(spectrum["k"].values[1] - spectrum["k"].values[0]) if spectrum.sizes["k"] else 0.0
    return spectrum["line_density"].values * step


def _variances(sea: Sea) -> tuple[float, float]:
    """Σ v of all waves and Σ v² of the random ones, of the sea that was asked for."""
    random = np.concatenate((_plane(sea).ravel(), _lines(sea).ravel()))
    regular = float(np.sum(0.5 * sea.spectrum["sinusoid_amplitude"].values ** 2))
    return float(random.sum()) + regular, float(np.sum(random**2))


def statistics_table(scene: Scene, sea: Sea, drawn: Moments, side_m: float) -> str:
    """The table as plain text."""
    resolved = sea.resolved
    waves = reduce.main_waves(scene)
    from_deg = waves.from_deg if waves is not None else 0.0
    chance, kurtosis = chance_of_height(sea), expected_kurtosis(sea)
    rows = [
        ("significant height, m", requested_height(sea), 4.0 * resolved.elevation_std, drawn.significant_height),
        ("mean level, m", 0.0, 0.0, drawn.mean),
        ("skewness", resolved.skewness_stokes, 0.0, drawn.skewness),
        ("kurtosis", kurtosis, kurtosis, drawn.kurtosis),
    ]
    for name, azimuth in (("along", from_deg), ("across", from_deg + 90.0)):
        expected = expected_slope_variance(sea, azimuth)
        rows.append((f"mean square slope {name} the waves", math.nan, expected, drawn.slope_variance(azimuth)))
    whole = resolved.total_mean_square_slope
    total = drawn.slope_variance(0.0) + drawn.slope_variance(90.0)
    rows.append(("mean square slope", whole, resolved.mean_square_slope, total))
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
