"""Echoes of a boat that moves at will, in exact float64 geometry: the retrieval's own yardstick, not the simulator's.

Antennas stand on an array of any attitude; what echoes is either points of the world, heard through a beam, or an ideal
sea: in each gate of each pulse the one point of mean sea level in the middle of the fan, which has no speckle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.dataset import build
from seamap_rt.radar.pose import antenna_axes, bearing
from seamap_rt.radar.waveform import RangeResponse

Array = NDArray[np.float64]
FREQUENCY = 10e9
K = 2.0 * np.pi * FREQUENCY / SPEED_OF_LIGHT
# transmit, interferogram → of each pulse of the cycle the transmitter and the receivers, antennas 0 lower, 1 upper
MODES = {
    ("single", "single_pulse"): [(0, (0, 1))],
    ("switched", "single_pulse"): [(0, (0, 1)), (1, (0, 1))],
    ("single", "alternating_pulse"): [(0, (0,)), (0, (1,))],
    ("switched", "alternating_pulse"): [(0, (0,)), (1, (1,))],
}


def still(time: Array) -> Array:
    return np.zeros((time.size, 3))


@dataclass(frozen=True)
class Boat:
    """One turn of a radar on a boat. attitude: roll, pitch, yaw [deg], and place: of the array's middle [m] from where
    it is at rest, both (pulse, 3) of times (pulse,); bias: what the sensors add to the attitude."""

    mode: tuple[str, str] = ("switched", "single_pulse")
    height: float = 5.0
    offsets: tuple[tuple[float, float, float], ...] = ((0.0, 0.0, -0.1), (0.0, 0.0, 0.1))
    tilt: float = 0.0
    sector: tuple[float, float] = (0.0, 36.0)
    prf: float = 2000.0
    ranges: Array = field(default_factory=lambda: np.arange(15.0, 120.0, 1.5))
    attitude: Callable[[Array], Array] = still
    place: Callable[[Array], Array] = still
    bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    cycle: tuple[tuple[int, tuple[int, ...]], ...] | None = None

    @property
    def time(self) -> Array:
        return np.arange(int((self.sector[1] - self.sector[0]) / 360.0 * self.prf)) / self.prf

    def pose(self, bias: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> tuple[Array, Array]:
        """Axes (pulse, 3, 3) and antennas (pulse, antenna, 3). The turntable keeps its pace against the boat, whose
        yaw swings the boresight."""
        time = self.time
        axes = antenna_axes(self.attitude(time) + bias, self.sector[0] + 360.0 * time, self.tilt)
        middle = self.place(time) + np.array((0.0, 0.0, self.height))
        return axes, middle[:, None] + np.asarray(self.offsets) @ axes

    def echoes(self, voltage_of: Callable[[Boat], NDArray[np.complex128]]) -> xr.Dataset:
        """Schema `echoes`; voltage_of gives (pulse, receiver, gate) as if every receiver were always sampled."""
        time, (axes, _), (_, measured) = self.time, self.pose(), self.pose(self.bias)
        voltage = voltage_of(self).astype(np.complex64)
        for slot, (_, receivers) in enumerate(self.slots):
            unheard = [r for r in range(voltage.shape[1]) if r not in receivers]
            voltage[slot :: len(self.slots), unheard] = np.nan
        echoes = build(
            "echoes",
            {"voltage": voltage, "position": measured[:, :2], "attitude": self.attitude(time) + self.bias},
            {
                "pulse": np.arange(time.size),
                "range": self.ranges,
                "time": time,
                "azimuth": bearing(axes),
                "transmitter": self.sender,
                "turn": np.zeros(time.size, dtype=np.int32),
            },
            {
                "frequency_hz": FREQUENCY,
                "pulse_width_s": 20e-9,
                "bandwidth_hz": 50e6,
                "prf_hz": self.prf,
                "rotation_rpm": 60.0,
                "sector_deg": list(self.sector),
                "height_m": self.height,
                "baseline_m": 0.2,
                "tilt_deg": self.tilt,
                "azimuth_beamwidth_deg": 1.8,
                "elevation_beamwidth_deg": 18.0,
                "polarization": "VV",
                "transmit": self.mode[0],
                "interferogram": self.mode[1],
                "noise_power_w": 0.0,
                "complete_turns": 1,
            },
        )
        return echoes.drop_vars("position").assign(position=(("pulse", "antenna", "xyz"), measured))

    @property
    def slots(self) -> list[tuple[int, tuple[int, ...]]]:
        return MODES[self.mode] if self.cycle is None else list(self.cycle)

    @property
    def sender(self) -> NDArray[np.int8]:
        slots = np.array([sender for sender, _ in self.slots], dtype=np.int8)
        return slots[np.arange(self.time.size) % slots.size]

    def where_the_fan_meets_the_sea(self) -> Array:
        """(pulse, gate, 3): at z = 0 in the plane of the beam, so far off that the mean half path of the mode's
        interferograms over the two receivers and their senders is the gate's range."""
        axes, antennas = self.pose()
        middle = antennas[:, :2].mean(axis=1)
        senders = sorted({sender for sender, _ in self.slots})
        distance = np.broadcast_to(self.ranges, (axes.shape[0], self.ranges.size))
        level = np.cross(axes[:, 0], (0.0, 0.0, 1.0))  # of the plane, horizontal
        level /= np.linalg.norm(level, axis=1)[:, None]
        level *= np.sign(np.sum(level * axes[:, 1], axis=1))[:, None]
        down = np.cross(level, axes[:, 0])
        down *= -np.sign(down[:, 2])[:, None]
        below = (middle[:, 2] / -down[:, 2])[:, None]
        foot = middle[:, None] + down[:, None] * below[..., None]
        points = foot
        for _ in range(60):
            points = foot + level[:, None] * np.sqrt(np.maximum(distance**2 - below**2, 0.0))[..., None]
            away = np.linalg.norm(points[:, None] - antennas[:, :, None], axis=-1)
            half = 0.5 * away[:, senders].mean(axis=1) + 0.25 * (away[:, 0] + away[:, 1])
            distance = distance + self.ranges - half
            if np.abs(self.ranges - half).max() < 1e-12:
                break
        return points


def ideal_sea(boat: Boat, speed: float = 0.0) -> NDArray[np.complex128]:
    """Of unit strength in each gate; it recedes at `speed` [m/s] in every direction."""
    _, antennas = boat.pose()
    away = np.linalg.norm(boat.where_the_fan_meets_the_sea()[:, None] - antennas[:, :, None], axis=-1)
    away = away + speed * boat.time[:, None, None]
    out = away[np.arange(boat.time.size), boat.sender][:, None]
    return np.exp(-1j * np.remainder(K * (out + away[:, :2]), 2.0 * np.pi))


def reflectors(boat: Boat, points: Array) -> NDArray[np.complex128]:
    """Of points (n, 3) through a Gaussian beam of 1.8° about the fan's plane, as strong near as far."""
    axes, antennas = boat.pose()
    response = RangeResponse(20e-9, 50e6)
    voltage = np.zeros((boat.time.size, 2, boat.ranges.size), dtype=np.complex128)
    for point in points:
        away = point - antennas
        length = np.linalg.norm(away, axis=-1)
        aside = np.degrees(np.arcsin(np.sum(away.mean(axis=1) * axes[:, 0], axis=1) / length.mean(axis=1)))
        ahead = np.sum(away.mean(axis=1) * axes[:, 1], axis=1) > 0.0
        heard = np.flatnonzero((np.abs(aside) < 4.0) & ahead)
        gain = np.exp(-4.0 * np.log(2.0) * (aside[heard] / 1.8) ** 2)  # two ways
        path = length[heard, boat.sender[heard]][:, None] + length[heard, :2]
        volts = gain[:, None] * np.exp(-1j * np.remainder(K * path, 2.0 * np.pi))
        voltage[heard] += volts[..., None] * response(boat.ranges - 0.5 * path[..., None])
    return voltage
