"""Bands from independent realisations, the range at which half is shadowed, quantiles of counted lengths; closed forms.

Neighbouring azimuths and range bins share crests: they are not independent, and no band here counts them as if they
were. One seed is one draw, whatever it holds; bands are Student's, with one degree of freedom less than seeds.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import stdtrit

from ..conventions import unit_from_azimuth
from ..mesh import PolarGrid
from ..physics.dispersion import angular_frequency
from ..physics.shadowing import regular_wave_visible_share, shadowing_smith67, shadowing_wagner67
from ..scene import Scene
from ..sea import Sea
from ..sea.systems import travel_direction
from ..settings import SinusoidWaves
from .paired import FEWEST_SEEDS

CONFIDENCE = 0.95
HALF = 0.5
_SMOOTHED = 0.25  # of the range, standard deviation
_NOTHING = 1e-9  # of the sea shadowed: rounding

Array = NDArray[np.float64]


def jackknife(
    statistic: Callable[[Array], Array], draws: Array, within: tuple[float, float] = (-np.inf, np.inf)
) -> tuple[Array, Array, Array]:
    """A statistic of the mean over draws (draw, …), and its 95 % band: estimate, low, high; within: what it can be.

    Quenouille's and Tukey's pseudo-values: for a statistic that is linear in the mean, the mean's own t band. NaN bands
    of fewer draws than FEWEST_SEEDS, and where the statistic is not defined without one of the draws.
    """
    number = len(draws)
    whole = statistic(draws.mean(axis=0))
    if number < FEWEST_SEEDS:
        unknown = np.full(np.shape(whole), np.nan)
        return whole, unknown, unknown
    total = draws.sum(axis=0)
    without = np.stack([statistic((total - draw) / (number - 1)) for draw in draws])
    spread = np.std((number - 1) * without, axis=0, ddof=1) / np.sqrt(number)
    reach = stdtrit(number - 1, 0.5 + 0.5 * CONFIDENCE) * spread
    low, high = (np.clip(each, *within) for each in (whole - reach, whole + reach))
    return whole, low, high


def half_range(middle: Array, share: Array) -> Array:
    """Range [m] (…) at which the visible share (…, bin) falls through one half; NaN where it does not.

    Of the curve smoothed over about a quarter of the range to either side: in any one sea crests stand where they
    stand, and the first of the many crossings of the ragged curve would lie too near. Linear between the bins' middles
    (bin,).
    """
    smooth = np.asarray(share, dtype=np.float64) @ _smoothing(middle).T
    falling = np.minimum.accumulate(smooth, axis=-1)
    after = np.argmax(falling < HALF, axis=-1)
    crosses = np.isfinite(falling[..., -1]) & (after > 0)  # 0: all above, or the first below
    after = np.maximum(after, 1)
    above, below = (np.take_along_axis(falling, (after - n)[..., None], -1)[..., 0] for n in (1, 0))
    part = (above - HALF) / np.where(crosses, above - below, 1.0)
    return np.where(crosses, middle[after - 1] + part * (middle[after] - middle[after - 1]), np.nan)


def why_no_half(middle: Array, share: Array) -> str:
    """Why a curve of shares (bin,) has no `half_range`; empty if it has one."""
    if np.isnan(share).any():
        return "not known"
    if share.min() > 1.0 - _NOTHING:
        return f"nothing is shadowed within {middle[-1]:.0f} m"
    if np.isfinite(half_range(middle, share)):
        return ""
    if float(_smoothing(middle)[0] @ share) < HALF:
        return f"less than half is visible from {middle[0]:.0f} m on"
    return f"half or more is visible to {middle[-1]:.0f} m"


def _smoothing(middle: Array) -> Array:
    """(bin, bin) weights of a straight line fitted about each bin in the logarithm of range, each bin by its area."""
    away = np.log(middle) - np.log(middle)[:, None]
    weight = np.exp(-0.5 * (away / _SMOOTHED) ** 2) * middle
    zeroth, first, second = ((weight * away**power).sum(axis=1, keepdims=True) for power in range(3))
    return weight * (second - first * away) / (zeroth * second - first**2)


def neighbour_correlation(draws: Array, axis: int) -> float:
    """Correlation of neighbours along an axis, of what draws (draw, …) differ by from their mean: 0 if independent.

    NaN for a single draw, or where draws do not differ."""
    moved = np.moveaxis(draws - draws.mean(axis=0), axis, 0)
    one, other = moved[:-1], moved[1:]
    square = np.sum(one**2) * np.sum(other**2)
    return float(np.sum(one * other) / np.sqrt(square)) if square > 1e-24 else np.nan


def count_quantile(counts: NDArray[np.int64], share: float, room: NDArray[np.int64]) -> Array:
    """Quantile (…, bin) in steps of how often each length (…, bin, length) was counted; NaN without any.

    The last length counts runs cut short at the end of the mesh, none of them shorter than `room` (bin,): quantiles up
    to there are right all the same, and those beyond are NaN.
    """
    reached = np.cumsum(counts, axis=-1)
    number = reached[..., -1]
    length = np.argmax(reached >= share * number[..., None], axis=-1)
    return np.where((number > 0) & (length <= room), length, np.nan)


FUNCTIONS = {"smith": shadowing_smith67, "wagner": shadowing_wagner67}
_FAR_AND_NEAR = np.geomspace(1e6, 0.1, 5000)  # m, where half ranges are looked for
_LONG = 1e5  # wavelengths: a wave met so nearly abeam is flat along the look


def shadowing_share(name: str, height_m: float, slope_rms: Array, weight: Array, range_m: Array) -> Array:
    """Visible share (group, range) by one of `FUNCTIONS`, for groups of sectors with slopes (sector,) along the look.

    weight (group, sector): of the sectors in each group, each row adding up to 1. A flat sea is all seen.
    """
    with np.errstate(divide="ignore"):
        v = height_m / (np.sqrt(2.0) * slope_rms[:, None] * range_m)
    unknown = np.isnan(v)  # nothing was seen, or nothing was looked at
    return weight @ np.where(unknown, np.nan, FUNCTIONS[name](np.where(unknown, 0.0, v)))


def shadowing_half(name: str, height_m: float, slope_rms: Array, weight: Array) -> Array:
    """Ground range [m] (group,) at which `shadowing_share` is one half; infinite over a flat sea, else to 1e-5."""
    share = shadowing_share(name, height_m, slope_rms, weight, _FAR_AND_NEAR)
    half = [np.exp(np.interp(0.5, each, np.log(_FAR_AND_NEAR), left=np.nan)) for each in share]
    return np.where(share[:, 0] > 0.5, np.inf, half)


def resolved_slope(sea: Sea, azimuth_deg: ArrayLike) -> Array:
    """rms slope (n,) along azimuths (n,) of the resolved waves: the expectation, of no single realisation or mesh."""
    spectrum = sea.spectrum
    tensor = np.zeros((2, 2))
    density = spectrum["variance_density"].values
    if density.size:
        east, north = spectrum["kx"].values, spectrum["ky"].values
        variance = density * abs(east[1] - east[0]) * abs(north[1] - north[0])
        mixed = float(north @ variance @ east)
        tensor += [[float((variance @ east**2).sum()), mixed], [mixed, float(north**2 @ variance.sum(axis=1))]]
    k = spectrum["k"].values
    for line, toward in zip(spectrum["line_density"].values, spectrum["line_toward"].values, strict=True):
        tensor += float(line @ k**2) * abs(k[1] - k[0]) * _along(toward)
    sinusoids = (spectrum[f"sinusoid_{name}"].values for name in ("amplitude", "wavenumber", "toward"))
    for amplitude, wavenumber, toward in zip(*sinusoids, strict=True):
        tensor += 0.5 * (amplitude * wavenumber) ** 2 * _along(toward)
    look = np.stack(unit_from_azimuth(azimuth_deg))
    return np.sqrt(np.einsum("in,ij,jn->n", look, tensor, look))


def _along(azimuth_deg: float) -> Array:
    unit = np.array(unit_from_azimuth(azimuth_deg))
    return np.outer(unit, unit)


def exact_wave(scene: Scene) -> SinusoidWaves | None:
    """The scene's only wave, if it is a regular one whose light has a closed form; else None."""
    if scene.sea.model != "linear" or len(scene.sea.waves) != 1 or scene.platform.motion != "fixed":
        return None
    (wave,) = scene.sea.waves
    return wave if isinstance(wave, SinusoidWaves) and wave.height_m > 0.0 else None


def exact_share(scene: Scene, wave: SinusoidWaves, grid: PolarGrid, height_m: float, edges: Array) -> Array:
    """Visible share of horizontal area (column, bin), crest by crest, each column at its own time and place."""
    east, north = travel_direction(wave)
    k = 2.0 * np.pi / wave.wavelength_m
    look_east, look_north = unit_from_azimuth(grid.column_azimuth)
    along = look_east * east + look_north * north
    current_east, current_north = unit_from_azimuth(scene.sea.current_toward_deg)
    drift = k * scene.sea.current_m_s * float(current_east * east + current_north * north)
    origin = grid.column_pose.origin[:, :2] @ (east, north)
    turning = float(angular_frequency(k, scene.sea.depth_m)) + drift
    phase = np.radians(wave.phase_deg) + k * origin - turning * grid.column_time
    below = 0.5 * wave.height_m * np.cos(phase)  # the water at the foot of the mast
    share = np.where((below < height_m)[:, None], 1.0, np.zeros(edges.size - 1))
    for column, cosine in enumerate(along):
        if abs(cosine) * _LONG < 1.0 or below[column] >= height_m:
            continue
        met = wave.wavelength_m / abs(cosine)
        ahead = phase[column] if cosine > 0.0 else -phase[column]
        share[column] = regular_wave_visible_share(wave.height_m, met, height_m, ahead, edges)
    return share
