"""What the errors of the motion sensors add to those of heights, by their stated sizes and by how the boat moves.

At a ground range r a tilt δα along the look, a height δz and a bearing δψ that are measured wrong make

    ⟨δheight²⟩ = r² ⟨δα²⟩ + ⟨δz²⟩ + D(r √⟨δψ²⟩),

D(d) the mean square of what the sea differs by between places d apart. Each mean square is that of the readings' noise,
as far as a height's looks keep it, of what stays for a turn, as the sensors' maker states it, and of what latency τ and
straight lines between readings T apart make of a course α: α″T²/12 − τα′ in the mean, and α″²T⁴/720 about it. Biases
are not looked for: on a sea of long waves a tilt of the whole map is as likely the sea's.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from ...conventions import unit_from_azimuth
from ...physics.readings import variance_kept
from ...radar.pose import boat_axes
from ...settings import SensorErrors
from ..input.description import RadarDescription
from .sea_covariance import SeaCovariance

Map = NDArray[np.float64]

_LOOKS = 2.0  # that a height is found from, where the echo is strong, as `design_outlook.motion` has it
_DEGREE = 4  # of a course through a turn, which is shorter than the boat's periods
_CELL = 2.0  # m², variance a side of two means over cells of 3 m and some more
_PULSES = 500  # that a course is laid through


def sensor_variance(
    echoes: xr.Dataset, radar: RadarDescription, sweeps: Map, time: Map, ground_range: Map, sea: SeaCovariance | float
) -> Map:
    """Mean square errors [m²] (look, gate) of heights by the sensors; 0 where the echoes say nothing of them.

    echoes: of one turn; sweeps (look,) deg from the sector's start; time (look,) s; ground_range (look, gate) m;
    sea: its covariance, of means over cells, or its mean square slope.
    """
    errors = radar.sensors
    if errors is None or errors == SensorErrors():
        return np.zeros(ground_range.shape)
    lasting = radar.period if radar.staring else radar.period * float(np.abs(np.diff(sweeps[:2])).sum()) / 360.0
    kept = variance_kept(min(errors.rate_hz, 1.0 / radar.interval) * _LOOKS * lasting)
    moved = _moved(echoes, errors, radar, time)
    tilt, turn, up = (
        kept * noise**2 + stays**2 + np.sum(by_motion**2, axis=0)
        for noise, stays, by_motion in (
            (
                np.radians(errors.attitude_noise_deg),
                np.radians(errors.attitude_accuracy_deg),
                np.einsum("cl,mcl->ml", unit_from_azimuth(radar.sector[0] + sweeps), moved[:, :2]),
            ),
            (np.radians(errors.heading_noise_deg), np.radians(errors.heading_accuracy_deg), moved[:, 2]),
            (errors.position_noise_m, errors.height_accuracy_m, moved[:, 3]),
        )
    )
    return ground_range**2 * tilt[:, None] + up[:, None] + _difference(sea, ground_range * np.sqrt(turn)[:, None])


def _moved(echoes: xr.Dataset, errors: SensorErrors, radar: RadarDescription, time: Map) -> Map:
    """What latency and straight lines make of the lean [rad] towards east and north, the heading [rad] and the height
    [m] at times (look,) [s]: (mean and rms about it, course, look)."""
    some = echoes.isel(pulse=slice(None, None, max(1, echoes.sizes["pulse"] // _PULSES)))
    when, attitude = some["time"].values, some["attitude"].values
    up, heading = boat_axes(attitude)[:, 2], np.unwrap(np.radians(attitude[:, 2]))
    height = some["position"].values[:, :, 2].mean(axis=1)
    course = np.stack((-up[:, 0] / up[:, 2], -up[:, 1] / up[:, 2], heading, height), axis=1)
    middle, half = when.mean(), max(0.5 * float(np.ptp(when)), 1e-9)
    fit = polynomial.polyfit((when - middle) / half, course, min(_DEGREE, when.size - 1))
    speed, bent = (polynomial.polyval((time - middle) / half, polynomial.polyder(fit, n)) / half**n for n in (1, 2))
    square = 0.0 if errors.rate_hz * radar.interval >= 1.0 else errors.rate_hz**-2.0
    return np.stack((bent * square / 12.0 - errors.latency_s * speed, bent * square / np.sqrt(720.0)))


def _difference(sea: SeaCovariance | float, apart: Map) -> Map:
    """D [m²] at distances `apart` [m], of all directions alike."""
    if not isinstance(sea, SeaCovariance):
        return sea * apart**2
    lag = np.arange(sea.table.shape[0]) - sea.table.shape[0] // 2
    ring = np.hypot(lag[:, None], lag).round().astype(int).ravel()
    mean = np.bincount(ring, sea.blurred(_CELL).ravel()) / np.bincount(ring)
    return 2.0 * (mean[0] - np.interp(apart, sea.spacing * np.arange(mean.size), mean))
