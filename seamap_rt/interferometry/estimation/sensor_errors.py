"""What the errors of the motion sensors add to those of heights, by their stated sizes and by how the boat moves.

A tilt δα along the look, a height δz and a bearing δψ that are measured wrong make r² ⟨δα²⟩ + ⟨δz²⟩ + r² s² ⟨δψ²⟩ at a
ground range r, s² the mean square slope across the look. Each mean square is that of the readings' noise, as far as a
height keeps it, of what stays for a turn, as the sensors' maker states it, and of what latency τ and straight lines
between readings T apart make of a course α: α″T²/12 − τα′ in the mean, and α″²T⁴/720 about it. Biases are not looked
for: on a sea of long waves a tilt of the whole map is as likely the sea's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from ...radar.pose import boat_axes
from ...settings import SensorErrors
from ..input.description import RadarDescription

if TYPE_CHECKING:
    import xarray as xr

Map = NDArray[np.float64]

_LOOKS = 2.0  # that a height is found from, where the echo is strong: by runs with noisy sensors of 20 to 1000 Hz
_SHARES = (np.arange(64) + 0.5) / 64.0  # of the time that they last
_DEGREE = 4  # of a course through a turn, which is shorter than the boat's periods


def sensor_variance(echoes: xr.Dataset, radar: RadarDescription, width: float, ground_range: Map, slope: Map) -> Map:
    """Mean square errors [m²] (look, gate) of a turn's heights by the sensors; 0 where the echoes do not tell of them.

    width: degrees between looks; ground_range [m] and slope across the look (look, gate), NaN where unknown.
    """
    errors, known = radar.sensors, np.isfinite(slope)
    if errors is None or errors == SensorErrors():
        return np.zeros(ground_range.shape)
    lasting = radar.period * (1.0 if radar.staring else width / 360.0)
    kept = variance_kept(min(errors.rate_hz, 1.0 / radar.interval) * lasting)
    east, north, heading, height = _by_motion(echoes, errors, radar.interval)
    tilt = kept * errors.attitude_noise_deg**2 + errors.attitude_accuracy_deg**2 + 0.5 * (east + north)
    turn = kept * errors.heading_noise_deg**2 + errors.heading_accuracy_deg**2 + heading
    up = kept * errors.position_noise_m**2 + errors.height_accuracy_m**2 + height
    steep = float(np.sum(slope[known] ** 2)) / max(1, np.count_nonzero(known))
    return np.radians(np.nan_to_num(ground_range)) ** 2 * (tilt + turn * steep) + up


def variance_kept(readings: float) -> float:
    """Of independent readings, `readings` to a look: A(x) = 2 ∫₀¹ (1 − u) B(x u) du of one's, over a height's looks.

    Straight lines between readings have the cubic B-spline B for their correlation, B(0) = 2/3.
    """
    apart = readings * _LOOKS * _SHARES
    beside = np.where(apart < 1.0, 2.0 / 3.0 - apart**2 + 0.5 * apart**3, np.clip(2.0 - apart, 0.0, 1.0) ** 3 / 6.0)
    return 2.0 * float(np.mean((1.0 - _SHARES) * beside))


def _by_motion(echoes: xr.Dataset, errors: SensorErrors, interval: float) -> Map:
    """Mean squares over the turn of what latency and straight lines make of the lean towards east and north, of the
    heading [deg²] and of the height [m²]. interval: between pulses [s]."""
    when, attitude = echoes["time"].values, echoes["attitude"].values
    up, heading = boat_axes(attitude)[:, 2], np.unwrap(attitude[:, 2], period=360.0)
    lean = np.degrees(np.arctan(up[:, :2] / up[:, 2:]))
    course = np.column_stack((lean, heading, echoes["position"].values[:, :, 2].mean(axis=1)))
    half = max(0.5 * float(np.ptp(when)), 1e-9)
    at = (when - when.mean()) / half
    fit = polynomial.polyfit(at, course, min(_DEGREE, when.size - 1))
    speed, bent = (polynomial.polyval(at, polynomial.polyder(fit, n)) / half**n for n in (1, 2))
    bent *= 0.0 if errors.rate_hz * interval >= 1.0 else errors.rate_hz**-2.0
    return np.mean((bent / 12.0 - errors.latency_s * speed) ** 2 + bent**2 / 720.0, axis=1)
