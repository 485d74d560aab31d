"""Share of a sea that sees the antenna, and the sea itself, in closed form: random seas by slope, a wave by crests.

Written from the papers. `validation.analytic` holds the same laws once more, written independently, as a check.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..conventions import EARTH_RADIUS

HALF = 0.5  # of the sea visible
SEEN_DB = -6.0  # of two-way power over that of the same water lit, from which on it is visible to a radar
LEVELS_DB = (-3.0, SEEN_DB, -10.0)  # for which shares are stated
_NOTHING = 1e-9  # of the sea shadowed: rounding
_SMOOTHED = 0.25  # of the range, standard deviation
_SAMPLES = 512  # a wavelength: crossings are interpolated between them, to some 1e-5 of a wavelength


def shadowing_smith67(v: ArrayLike) -> NDArray[np.float64]:
    """Visible share S = ½ (1 + erf v)/(1 + Λ) of a Gaussian sea; v = tan ψ/(√2 σ) ≥ 0, dimensionless.

    ψ: grazing angle; σ: rms slope along the look. Smith, IEEE Trans. Antennas Propag. 15(5), 668–671 (1967). 0 at
    v = 0; ValueError for a negative v.
    """
    return 0.5 * (1.0 + scipy.special.erf(_not_negative(v))) * facing_share_smith67(v)


def facing_share_smith67(v: ArrayLike) -> NDArray[np.float64]:
    """Share 1/(1 + Λ) in sight of those parts of a Gaussian sea that face the ray; v as for `shadowing_smith67`.

    Smith takes what hides a point to be independent of its slope, so that it holds for each slope that faces the ray.
    """
    return 1.0 / (1.0 + _smith_lambda(_not_negative(v)))


def shadowing_wagner67(v: ArrayLike) -> NDArray[np.float64]:
    """Visible share S = ½ (1 + erf v)(1 − e^−Λ)/Λ of a Gaussian sea; v as for `shadowing_smith67`.

    Wagner, J. Acoust. Soc. Am. 41(1), 138–147 (1967). ValueError for a negative v.
    """
    v = _not_negative(v)
    hidden = _smith_lambda(v)
    hides = hidden > 0.0
    return 0.5 * (1.0 + scipy.special.erf(v)) * np.where(hides, -np.expm1(-hidden) / np.where(hides, hidden, 1.0), 1.0)


def shadow_kept(height_m: float, slope: float, wavelength_m: float, polarization: str) -> float:
    """Share of its two-way power that water keeps which small waves hide from light: what bends into their shadows.

    height_m, slope: rms of the waves. Such shadows begin h/σ behind an edge that stands h over the ray: in Fresnel's
    measure v = √(2hσ/λ), 1 where the phase 2khσ is π. The water is lit by 2F(v) in VV, as behind an edge and along a
    conducting face that doubles it; |2F|⁴ there and back, which is 1 of waves much smaller than λ and 0 of light. In HH
    the field on the face is less, by the square of that: so say profiles on which wave optics was worked out
    (`python -m validation.light.wave_shadows`), not a theory. F: ITU-R P.526, section 4.1. ValueError if one of the
    numbers is below 0, or λ is 0.
    """
    if min(height_m, slope) < 0.0 or wavelength_m <= 0.0:
        raise ValueError("height_m and slope must be 0 or more, wavelength_m above 0")
    sine, cosine = scipy.special.fresnel(np.sqrt(2.0 * height_m * slope / wavelength_m))
    one_way = 2.0 * ((0.5 - float(cosine)) ** 2 + (0.5 - float(sine)) ** 2)
    return one_way**2 if polarization == "VV" else one_way**4


def regular_wave_visible_share(
    height_m: float, wavelength_m: float, antenna_height_m: float, phase: float, edges_m: ArrayLike
) -> NDArray[np.float64]:
    """Visible share of horizontal area (bin,) of z = (height/2) cos(2π x/wavelength + phase) in ground range bins.

    height_m: crest to trough; antenna_height_m: above mean level, over x = 0, above the water there; phase in rad;
    edges_m (bin + 1,): rising. Area grows as the square of the range. A point is seen while its elevation angle,
    t(x) = (z − H)/x, exceeds that of all points before it; t is sampled, and where it crosses the level of an earlier
    crest or has its own maximum is interpolated.
    """
    edges = np.asarray(edges_m, dtype=np.float64)
    step = wavelength_m / _SAMPLES
    x = step * (1.0 + np.arange(int(np.ceil(edges[-1] / step)) + 1))
    rise = (0.5 * height_m * np.cos(2.0 * np.pi / wavelength_m * x + phase) - antenna_height_m) / x
    horizon = np.maximum.accumulate(rise)
    seen = rise >= horizon
    change = np.flatnonzero(np.diff(seen))
    appears, ends = change[~seen[change]], change[seen[change]]
    level, before, after = horizon[appears], rise[appears], rise[appears + 1]
    starts = x[appears] + step * (level - before) / (after - before)
    left, middle, right = rise[ends - 1], rise[ends], rise[ends + 1]  # a parabola through the highest three
    stops = x[ends] + 0.5 * step * (left - right) / (left - 2.0 * middle + right)
    starts, stops = np.append(0.0, starts), np.append(stops, x[-1])[: starts.size + 1]
    covered = np.clip(edges[:, None] ** 2, starts**2, stops**2) - starts**2
    return np.diff(covered.sum(axis=1)) / np.diff(edges**2)


def second_bounce_share(mean_square_slope: float) -> float:
    """Share of the power sent out evenly (Lambert) by a Gaussian surface that meets the surface again: 1 − A/A′.

    A′/A = ⟨√(1 + s²)⟩ is its area over the plane's, s² of isotropic slopes being exponentially distributed; what leaves
    crosses the plane, and by the reciprocity of view factors that is A/A′ of it (Howell et al. 2010, chapter 4). For
    the resolved waves of `choppy_sea` 0.6 %, where traced paths give 0.5 % of the echo.
    """
    if mean_square_slope <= 0.0:
        return 0.0
    grown = 0.5 * np.sqrt(np.pi * mean_square_slope) * float(scipy.special.erfcx(1.0 / np.sqrt(mean_square_slope)))
    return float(grown / (1.0 + grown))


def _smith_lambda(v: NDArray[np.float64]) -> NDArray[np.float64]:
    """Smith's Λ = ½ [exp(−v²)/(v√π) − erfc v]; exp(−v²) is taken out, so that large v keep their digits."""
    with np.errstate(divide="ignore", over="ignore"):
        return 0.5 * np.exp(-np.square(v)) * np.maximum(1.0 / (v * np.sqrt(np.pi)) - scipy.special.erfcx(v), 0.0)


def _not_negative(v: ArrayLike) -> NDArray[np.float64]:
    array = np.asarray(v, dtype=np.float64)
    if not np.all(array >= 0.0):
        raise ValueError("v must be 0 or more")
    return array


def half_range(middle: NDArray[np.float64], share: ArrayLike) -> NDArray[np.float64]:
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


def _smoothing(middle: NDArray[np.float64]) -> NDArray[np.float64]:
    """(bin, bin) weights of a straight line fitted about each bin in the logarithm of range, each bin by its area."""
    away = np.log(middle) - np.log(middle)[:, None]
    weight = np.exp(-0.5 * (away / _SMOOTHED) ** 2) * middle
    zeroth, first, second = ((weight * away**power).sum(axis=1, keepdims=True) for power in range(3))
    return weight * (second - first * away) / (zeroth * second - first**2)


def half_range_refusal(middle: NDArray[np.float64], share: NDArray[np.float64]) -> str:
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


REFRACTED_RADIUS = 4.0 / 3.0 * EARTH_RADIUS  # m, of standard refraction


def earth_drop_m(ground_range_m: float) -> float:
    """The depth [m] by which the Earth falls away beneath the tangent plane, √(R² + d²) − R with 4/3 of its radius."""
    return ground_range_m**2 / (REFRACTED_RADIUS + float(np.hypot(REFRACTED_RADIUS, ground_range_m)))


_ARRIVAL_MRAD, _AT_M = {"VV": 1.0, "HH": 1.5}, 0.03


def arrival_error_mrad(polarization: str, wavelength_m: float) -> float:
    """Error [mrad] of the angle at which a map's echoes arrive over the crests before them, by diffraction, where all
    water around is hidden (`interferometry.slopes.diffraction_error`).

    Set in VV on maps of three seas traced with knife edges from masts of 3 to 13 m, at 3 cm, seeds 103 and 104. Full
    waves turn single cells half as much again in VV, and in HH as much again as that: hence so much for recordings in
    HH (`validation.light.height_bias`). At other wavelengths by Fresnel's zone, as √λ.
    """
    return _ARRIVAL_MRAD[polarization] * float(np.sqrt(wavelength_m / _AT_M))


def edge_blur_m(wavelength_m: float, to_edge_m: float, beyond_m: float) -> float:
    """Height [m] over which a knife edge's shadow fades, v = 1: √(λ d₁d₂/(2 (d₁ + d₂))) (ITU-R P.526, section 4.1)."""
    return float(np.sqrt(0.5 * wavelength_m * to_edge_m * beyond_m / (to_edge_m + beyond_m)))
