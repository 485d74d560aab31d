"""Point scatterers through the radar: exact float64 geometry, no speckle, no shadow. The echo chain's yardstick."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..conventions import wrap_degrees
from ..radar.antenna import antenna
from ..radar.receiver import amplitude_constant
from ..radar.scan import BEAMS_BEYOND, Pulses, phase_centres, pulses
from ..radar.waveform import RangeResponse, gates
from ..scene import Scene
from ..settings import RadarSettings
from .files import echo_dataset
from .paths import wavenumber
from .turn import add_noise


def from_scatterers(scene: Scene, xyz: ArrayLike, rcs: ArrayLike, velocity: ArrayLike | None = None) -> xr.Dataset:
    """Echoes (schema `echoes`) of point scatterers at xyz (n, 3) [m] at time 0, of rcs (n,) [m²], that move at
    velocity (n, 3) [m/s]. Thermal noise is added if radar.noise.

    Raises ValueError, in one line, for shapes that do not fit or values that are not finite.
    """
    places = np.atleast_2d(np.asarray(xyz, dtype=np.float64))
    areas = np.asarray(rcs, dtype=np.float64)
    if areas.shape not in ((), places.shape[:1]):
        raise ValueError(f"rcs {areas.shape}: must be one number, or one for each of the {len(places)} scatterers")
    areas = np.broadcast_to(areas, places.shape[:1])
    speeds = np.zeros_like(places) if velocity is None else np.atleast_2d(np.asarray(velocity, dtype=np.float64))
    if places.ndim != 2 or places.shape[1] != 3 or speeds.shape != places.shape:
        raise ValueError(f"xyz {places.shape}, velocity {speeds.shape}: both must be (n, 3)")
    if not (np.isfinite(places).all() and np.isfinite(areas).all() and np.isfinite(speeds).all()):
        raise ValueError("xyz, rcs and velocity must be finite; drop the scatterers that are not")
    if (areas < 0.0).any():
        raise ValueError(f"rcs = {areas.min():g}: must be at least 0 m²")
    turns = [pulses(scene.radar, turn) for turn in range(scene.turns)]
    voltages = [scatterer_voltages(scene.radar, turn, places, areas, speeds) for turn in turns]
    if scene.radar.noise:
        for voltage, turn in zip(voltages, turns, strict=True):
            add_noise(voltage, scene.radar, turn, scene.seed, workers=1)
    return echo_dataset(scene.radar, turns, voltages, scene.scattering.polarization)


def scatterer_voltages(
    radar: RadarSettings,
    turn: Pulses,
    places: NDArray[np.float64],
    areas: NDArray[np.float64],
    speeds: NDArray[np.float64],
) -> NDArray[np.complex64]:
    """Voltages (pulse, receiver, gate) of point scatterers over one turn, without noise."""
    ranges, response, pattern = gates(radar), RangeResponse.of(radar), antenna(radar)
    k, constant = wavenumber(radar), amplitude_constant(radar)
    reach = BEAMS_BEYOND * radar.antenna.azimuth_beamwidth_deg
    everywhere = radar.antenna.pattern == "isotropic"
    centres = phase_centres(radar, turn.azimuth)
    voltages = np.zeros((turn.number.size, 2, ranges.size), dtype=np.complex128)
    for place, area, speed in zip(places, areas, speeds, strict=True):
        position = place + speed * turn.time[:, None]
        azimuth = np.degrees(np.arctan2(position[:, 0], position[:, 1]))
        offset = wrap_degrees(azimuth - turn.azimuth)
        chosen = np.arange(turn.number.size) if everywhere else np.flatnonzero(np.abs(offset) <= reach)
        if chosen.size == 0:
            continue
        away = position[chosen, None, :] - centres[chosen]
        length = np.linalg.norm(away, axis=-1)  # (pulse, antenna)
        elevation = np.arcsin((position[chosen, 2] - radar.height_m) / length.mean(axis=1))
        one_way = pattern.voltage(np.radians(offset[chosen]), elevation)
        sender = turn.transmitter[chosen].astype(int)
        out = np.take_along_axis(length, sender[:, None], axis=1)
        path = out + length  # (pulse, receiver)
        volts = constant * np.sqrt(area) * (one_way**2)[:, None] / (out * length)
        volts = volts * np.exp(-1j * np.remainder(k * path, 2.0 * np.pi))
        low = np.searchsorted(ranges, 0.5 * path.min() - response.support_m)
        high = np.searchsorted(ranges, 0.5 * path.max() + response.support_m)
        heard = response(ranges[low:high] - 0.5 * path[..., None])
        voltages[chosen, :, low:high] += volts[..., None] * heard
    return voltages.astype(np.complex64)
