"""Point scatterers through the radar: exact float64 geometry, no speckle, no shadow. The echo chain's reference."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..conventions import radar_wavenumber
from ..errors import InputError
from ..io.text import numbers
from ..radar.installation import Installation
from ..radar.receiver import amplitude_constant
from ..radar.scan import BEAMS_BEYOND, Pulses, pulses
from ..resolved_scene import installation_of
from ..scene import SceneLike, as_scene
from .dataset import echo_dataset
from .receiving import receive
from .response import received_samples


def from_scatterers(scene: SceneLike, xyz: ArrayLike, rcs: ArrayLike, velocity: ArrayLike | None = None) -> xr.Dataset:
    """Echoes (schema `echoes`) of point scatterers at xyz (n, 3) [m] at time 0, of rcs (n,) [m²], that move at
    velocity (n, 3) [m/s]. Thermal noise is added if radar.noise.

    Raises InputError, in one line, for shapes that do not fit or values that are not finite.
    """
    scene = as_scene(scene)
    points, areas = np.atleast_2d(numbers("xyz", xyz)), numbers("rcs", rcs)
    if areas.shape not in ((), points.shape[:1]):
        raise InputError(f"rcs {areas.shape}: must be one number, or one for each of the {len(points)} scatterers")
    areas = np.broadcast_to(areas, points.shape[:1])
    speeds = np.zeros_like(points) if velocity is None else np.atleast_2d(numbers("velocity", velocity))
    if points.ndim != 2 or points.shape[1] != 3 or speeds.shape != points.shape:
        raise InputError(f"xyz {points.shape}, velocity {speeds.shape}: both must be (n, 3)")
    if not (np.isfinite(points).all() and np.isfinite(areas).all() and np.isfinite(speeds).all()):
        raise InputError("xyz, rcs and velocity must be finite; drop the scatterers that are not")
    if (areas < 0.0).any():
        raise InputError(f"rcs = {areas.min():g}: must be at least 0 m²")
    installation = installation_of(scene)
    turns = [pulses(installation, turn) for turn in range(scene.turns)]
    voltages = (scatterer_voltages(installation, turn, points, areas, speeds) for turn in turns)
    received = [receive(each, installation, turn, scene.seed) for each, turn in zip(voltages, turns, strict=True)]
    settings = scene.scattering.polarization, None, 0, scene.resolved_retrieval
    return echo_dataset(installation, turns, received, *settings)


def scatterer_voltages(
    installation: Installation,
    turn: Pulses,
    points: NDArray[np.float64],
    areas: NDArray[np.float64],
    speeds: NDArray[np.float64],
    sight: NDArray[np.bool_] | None = None,
) -> NDArray[np.complex64]:
    """Voltages (pulse, receiver, sample) [√W] of point scatterers at the antennas' ports over one turn; NaN where the
    mode does not sample a receiver.

    points (n, 3) [m] at time 0, of radar cross-sections areas (n,) [m²], that move at speeds (n, 3) [m/s]; sight
    (antenna, n): which of them each antenna sees; left out, all.
    """
    radar, array, pose = installation.radar, installation.array, turn.pose
    samples = received_samples(radar)
    ranges, k = samples.range, radar_wavenumber(radar.frequency_hz)
    within = np.sin(np.radians(min(90.0, BEAMS_BEYOND * array.beam_deg)))
    everywhere = any(element.antenna.everywhere for element in array.elements)
    centres = pose.positions
    voltages = np.zeros((turn.number.size, len(array.receivers), ranges.size), dtype=np.complex128)
    for scatterer, (point, area, speed) in enumerate(zip(points, areas, speeds, strict=True)):
        position = point + speed * turn.time[:, None]
        away = position - pose.origin
        across, ahead, up = np.moveaxis(np.einsum("pij,pj->pi", pose.axes, away), -1, 0)
        chosen = np.flatnonzero(everywhere | ((ahead > 0.0) & (np.abs(across) <= within * np.hypot(across, ahead))))
        if chosen.size == 0:
            continue
        length = np.linalg.norm(position[chosen, None] - centres[chosen], axis=-1)  # (pulse, antenna)
        # Antennas beside the axis look along lines of their own. Stacked ones share the elevation of their middle, as
        # the sea's facets do: beside a null of the pattern they would differ.
        distance = np.linalg.norm(away[chosen], axis=-1)
        rise = up[chosen] / distance
        one_way = [
            element.antenna.azimuth((across[chosen] - element.offset[0]) / distance) * element.antenna.elevation(rise)
            for element in array.elements
        ]
        for number, slot in enumerate(array.cycle):
            mine = np.flatnonzero(turn.slot[chosen] == number)
            for receiver in slot.receivers if mine.size else ():
                sender, hearer = slot.transmitter, array.receivers[receiver]
                if sight is not None and not (sight[sender, scatterer] and sight[hearer, scatterer]):
                    continue
                gain = float(np.sqrt(array.elements[sender].antenna.gain * array.elements[hearer].antenna.gain))
                out, back = length[mine, sender], length[mine, hearer]
                volts = amplitude_constant(radar, gain) * np.sqrt(area) / (out * back)
                volts = volts * one_way[sender][mine] * one_way[hearer][mine]
                volts = volts * np.exp(-1j * np.remainder(k * (out + back), 2.0 * np.pi))
                half, response = 0.5 * (out + back), samples.responses[array.path(sender, receiver)]
                low = int(np.searchsorted(ranges, half.min() - samples.support_m))
                high = int(np.searchsorted(ranges, half.max() + samples.support_m))
                weights = response(ranges[low:high] - half[:, None])
                voltages[chosen[mine], receiver, low:high] += volts[:, None] * weights
    if samples.compress is not None:
        voltages = samples.compress(voltages)
    voltages = voltages.astype(np.complex64)
    for number, slot in enumerate(array.cycle):
        silent = [receiver for receiver in range(len(array.receivers)) if receiver not in slot.receivers]
        voltages[np.ix_(turn.slot == number, silent)] = np.nan
    return voltages
