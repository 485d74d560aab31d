"""What the retrieval knows of the radar: the echoes' attributes, and the antennas' places that the sensors measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import SPEED_OF_LIGHT, unit_from_azimuth, wrap_degrees
from ..dataset import SchemaError
from ..radar.waveform import RangeResponse


@dataclass(frozen=True)
class RadarDescription:
    """What the echoes' attributes say of the radar."""

    wavelength: float
    noise_power: float
    transmit: str
    sector: tuple[float, float]
    period: float
    height: float
    response: RangeResponse
    ranges: NDArray[np.float64]

    @classmethod
    def of(cls, echoes: xr.Dataset) -> RadarDescription:
        attrs = echoes.attrs
        if attrs["interferogram"] != "single_pulse":
            raise SchemaError(
                f"interferogram = '{attrs['interferogram']}': only single_pulse echoes can be retrieved so far"
            )
        start, stop = (float(a) for a in attrs["sector_deg"])
        return cls(
            wavelength=SPEED_OF_LIGHT / float(attrs["frequency_hz"]),
            noise_power=float(attrs["noise_power_w"]),
            transmit=str(attrs["transmit"]),
            sector=(start, stop),
            period=60.0 / float(attrs["rotation_rpm"]),
            height=float(attrs["height_m"]),
            response=RangeResponse(float(attrs["pulse_width_s"]), float(attrs["bandwidth_hz"])),
            ranges=np.asarray(echoes["range"].values, dtype=np.float64),
        )

    @property
    def spacing(self) -> float:
        return float(self.ranges[1] - self.ranges[0]) if self.ranges.size > 1 else 1.0

    @property
    def closed(self) -> bool:
        return bool(np.isclose(self.sector[1] - self.sector[0], 360.0))


@dataclass(frozen=True)
class LookGeometry:
    """Each look's antennas, from the boat's sensors; arrays (look, 1)."""

    baseline: NDArray[np.float64]
    lower_height: NDArray[np.float64]
    tilt: NDArray[np.float64]  # rad, of the baseline in the plane of the look, top outward
    offset: NDArray[np.float64]  # m, of the lower antenna along the look from the origin's vertical


def look_of_pulses(
    echoes: xr.Dataset, radar: RadarDescription, sweeps: NDArray[np.float64], width: float
) -> NDArray[np.intp]:
    """The look in whose dwell each pulse lies, or −1."""
    # Relative to the sector's middle, so that a pulse at its very edge cannot wrap to the other side.
    middle = 0.5 * (radar.sector[0] + radar.sector[1])
    sweep = wrap_degrees(np.asarray(echoes["azimuth"].values) - middle) + 0.5 * (radar.sector[1] - radar.sector[0])
    number = np.floor((sweep - sweeps[0]) / width + 0.5 + 1e-9).astype(np.intp)
    return np.where((number >= 0) & (number < sweeps.size), number, -1)


def look_geometry(echoes: xr.Dataset, look: NDArray[np.intp], azimuth: NDArray[np.float64]) -> LookGeometry:
    """Mean antenna positions over each look's pulses, as the sensors measured them."""
    position = np.asarray(echoes["position"].values, dtype=np.float64)
    east, north = unit_from_azimuth(np.asarray(echoes["azimuth"].values))
    lower = position[:, 0]
    base = position[:, 1] - position[:, 0]
    along = base[:, 0] * east + base[:, 1] * north
    values = np.stack(
        (np.linalg.norm(base, axis=1), lower[:, 2], along, base[:, 2], lower[:, 0] * east + lower[:, 1] * north)
    )
    good = (look >= 0) & np.isfinite(values).all(axis=0)
    count = np.bincount(look[good], minlength=azimuth.size)
    with np.errstate(invalid="ignore"):
        mean = [np.bincount(look[good], weights=v[good], minlength=azimuth.size) / np.maximum(count, 1) for v in values]
    mean = [np.where(count > 0, m, np.nan)[:, None] for m in mean]
    return LookGeometry(mean[0], mean[1], np.arctan2(mean[2], mean[3]), mean[4])
