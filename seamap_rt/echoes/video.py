"""What an ordinary marine radar shows of its echoes: the power of each gate by its detector, in counts.

    voltage → sensitivity-time control → lin-log detector → video filter → mean of pulses → converter

The detector's output is |V|/V_k up to the knee V_k and 1 + ln(|V|/V_k) beyond (a lin-log receiver): a knee well below
the noise makes it a logarithm, one at full scale an envelope. The filter is Gaussian along the range. Full scale of the
converter is a sine's of `full_scale_dbm`. No maker states these numbers of a set; the defaults are assumptions.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..conventions import SPEED_OF_LIGHT, from_db
from ..dataset import build
from ..radar.digital import sensitivity_time_control
from ..radar.receiver import noise_power
from ..radar.waveform import gate_spacing_m
from ..settings import RadarSettings

_METRES_A_DEGREE = 111_320.0


def detected(radar: RadarSettings, amplitude: ArrayLike) -> NDArray[np.float64]:
    """Output of the detector for amplitudes [√W at the antenna], any shape; 1 at the knee."""
    knee = np.sqrt(noise_power(radar) * float(from_db(radar.receiver.knee_db)))
    over = np.asarray(amplitude, dtype=np.float64) / knee
    return np.where(over > 1.0, 1.0 + np.log(np.maximum(over, 1.0)), over)


def video(radar: RadarSettings, voltage: NDArray[np.complexfloating], range_m: NDArray[np.float64]) -> NDArray:
    """Counts (radial, gate) uint16 of voltages (pulse, gate) [√W] of one receiver at ranges (gate,) [m].

    Pulses that were not received (NaN) count as silent; what is left after the last whole radial goes.
    """
    receiver = radar.receiver
    controlled = np.abs(np.nan_to_num(voltage)) * sensitivity_time_control(radar, range_m)
    level = detected(radar, controlled)
    if receiver.video_bandwidth_hz is not None:
        level = _filtered(level, receiver.video_bandwidth_hz * 2.0 * gate_spacing_m(radar) / SPEED_OF_LIGHT)
    radials = len(level) // receiver.video_pulses
    level = level[: radials * receiver.video_pulses].reshape(radials, receiver.video_pulses, -1).mean(axis=1)
    full_scale = detected(radar, np.sqrt(1e-3 * float(from_db(receiver.full_scale_dbm))))
    top = 2**receiver.adc_bits
    return np.clip(level / full_scale * top, 0, top - 1).astype(np.uint16)


def _filtered(level: NDArray[np.float64], bandwidth: float) -> NDArray[np.float64]:
    """Levels (pulse, gate) through a Gaussian filter, bandwidth in cycles a gate; beyond its ends a pulse mirrors."""
    from scipy.fft import dct, idct

    cycles = np.arange(level.shape[1]) / (2.0 * level.shape[1])
    return np.asarray(idct(dct(level, axis=1) * 0.5 ** (0.5 * (cycles / bandwidth) ** 2), axis=1))


def polar_image(echoes: xr.Dataset, radar: RadarSettings, attributes: dict[str, Any]) -> xr.Dataset:
    """`polar_images` of one turn's echoes, of the first receiver that hears each pulse. Places count from 0° N, 0° E.

    attributes: what the ship says of its speed and the wind.
    """
    voltage = echoes["voltage"].values
    received = voltage[:, 0]
    for other in range(1, voltage.shape[1]):
        received = np.where(np.isnan(received), voltage[:, other], received)
    counts = video(radar, received, echoes["range"].values)
    pulses = radar.receiver.video_pulses
    middle = np.arange(len(counts)) * pulses + pulses // 2
    east, north = echoes["position"].values[middle].mean(axis=1)[:, :2].T
    time = echoes["time"].values[middle]
    return build(
        "polar_images",
        {
            "video": counts,
            "heading": np.zeros(middle.size),
            "latitude": north / _METRES_A_DEGREE,
            "longitude": east / _METRES_A_DEGREE,
        },
        {
            "pulse": echoes["pulse"].values[middle],
            "range": echoes["range"].values,
            "time": time,
            "azimuth": echoes["azimuth"].values[middle] % 360.0,
            "turn": echoes["turn"].values[middle],
        },
        {"radar": "", "turn_s": 60.0 / radar.rotation_rpm, "wind_is_true": 1, **attributes},
    )
