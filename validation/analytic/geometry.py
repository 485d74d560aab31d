"""The interferometer's triangle: two antennas, one point of the sea, and the vertical plane through them.

Antenna 1 is the lower one, at `antenna_height` above mean sea level; antenna 2 lies a `baseline` B from it,
straight up, or leaning its top towards the point by `tilt`. R1 and R2 are their distances to the point, and
ΔR = R2 − R1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

_ROUNDING = 8.0 * np.finfo(np.float64).eps  # |cos θ′| may pass 1 by it, for a point in line with the baseline


def range_difference(
    ground_range: ArrayLike,
    height: ArrayLike,
    baseline: ArrayLike,
    antenna_height: ArrayLike,
    tilt: ArrayLike = 0.0,
) -> NDArray[np.float64]:
    """ΔR = R2 − R1 [m] of a point by its ground range from antenna 1 and its height [m]; tilt in rad.

    Taken as (R2² − R1²)/(R1 + R2), in which the long ranges cancel by algebra, so that it is good to a few
    ulp of B.
    """
    x = np.asarray(ground_range, dtype=np.float64)
    b = np.asarray(baseline, dtype=np.float64)
    lean = np.asarray(tilt, dtype=np.float64)
    drop = np.asarray(antenna_height, dtype=np.float64) - np.asarray(height, dtype=np.float64)
    lower = np.hypot(x, drop)
    upper = np.hypot(x - b * np.sin(lean), drop + b * np.cos(lean))
    return np.asarray(b * (b + 2.0 * (drop * np.cos(lean) - x * np.sin(lean))) / (lower + upper))


def height_from_range_difference(
    range_lower: ArrayLike,
    delta_range: ArrayLike,
    baseline: ArrayLike,
    antenna_height: ArrayLike,
    tilt: ArrayLike = 0.0,
) -> NDArray[np.float64]:
    """Height z [m] of the point at R1 [m] with ΔR [m], by exact triangle; they broadcast, tilt in rad.

    NaN where there is no triangle (|ΔR| > B, a range that is not positive) and for a baseline of 0. Of the
    two points that mirror each other in the baseline's line, the one in the look is meant. The formula adds
    about R1 · 1e-15 of its own; an error of ΔR grows by R1/B. ΔR kept as one float64 number (as
    `range_difference` gives it) costs R1 · 1e-16; formed by subtracting two float64 ranges of 3 km it costs
    1e-6 m at B = 1 mm, 1e-9 m at 1 m.
    """
    return ground_position_from_range_difference(range_lower, delta_range, baseline, antenna_height, tilt)[1]


def ground_position_from_range_difference(
    range_lower: ArrayLike,
    delta_range: ArrayLike,
    baseline: ArrayLike,
    antenna_height: ArrayLike,
    tilt: ArrayLike = 0.0,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Ground range from antenna 1 and height [m]; arguments and NaN as for the height alone."""
    r, d, b, h, lean = (
        np.asarray(each, dtype=np.float64) for each in (range_lower, delta_range, baseline, antenna_height, tilt)
    )
    possible = (r > 0.0) & (b > 0.0) & (r + d >= 0.0)
    b, r = np.where(possible, b, np.nan), np.where(possible, r, np.nan)
    cosine = d / b + (d - b) * (d + b) / (2.0 * b * r)  # of θ′, from the baseline's downward direction
    cosine = np.where(np.abs(cosine) <= 1.0 + _ROUNDING, np.clip(cosine, -1.0, 1.0), np.nan)
    sine = np.sqrt((1.0 - cosine) * (1.0 + cosine))
    across = r * (sine * np.cos(lean) - cosine * np.sin(lean))  # θ = θ′ − α, by the addition theorems
    return across, h - r * (cosine * np.cos(lean) + sine * np.sin(lean))
