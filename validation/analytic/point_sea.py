"""A sea of random point scatterers, whose echoes are sums over all points that the beam hears: real speckle, smeared
over gates and looks by the waveform and the beam themselves."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.radar.waveform import RangeResponse

from .seas import Field, FlatSea, Surface
from .sight import Array, phasor

_BEAMS = 1.6  # beam widths to either side of which a point counts: a two-way Gaussian beam is 62 dB down there


@dataclass(frozen=True)
class PointSea:
    """Points on a surface, as strong near as far: of each `per_cell` lie in a gate's spacing by a beam width.

    Each has a complex Gaussian amplitude of its own, which keeps; a gate's mean power is 1 W. ValueError for a density
    that is not positive.
    """

    surface: Surface = field(default_factory=FlatSea)
    per_cell: float = 4.0

    def __post_init__(self) -> None:
        if not self.per_cell > 0.0:
            raise ValueError(f"per_cell = {self.per_cell}: must be above 0; 4 make a speckle like that of many")


@dataclass(frozen=True)
class Points:
    """Where m points are, (m, 3) east, north, up [m], and their amplitudes (m,) [W^0.5]."""

    position: Field
    amplitude: NDArray[np.complex128]
    response: RangeResponse
    beam_deg: float

    @classmethod
    def strewn(
        cls,
        sea: PointSea,
        ranges: Field,
        response: RangeResponse,
        beam_deg: float,
        azimuths_deg: tuple[float, float],
        centre: Field,
        rng: np.random.Generator,
    ) -> Points:
        """Evenly over slant range from the array's middle `centre` (3,) [m] and azimuth (from, to)."""
        spacing = float(ranges[1] - ranges[0]) if ranges.size > 1 else response.support_m
        near, far = float(ranges[0]) - response.reach_m, float(ranges[-1]) + response.reach_m
        start, stop = azimuths_deg[0] - _BEAMS * beam_deg, azimuths_deg[1] + _BEAMS * beam_deg
        stop = min(stop, start + 360.0)
        density = sea.per_cell / (spacing * beam_deg)  # per metre and degree
        count = round(density * (far - near) * (stop - start))
        slant, (east, north) = rng.uniform(near, far, count), unit_from_azimuth(rng.uniform(start, stop, count))
        below = float(centre[2] - sea.surface.height(centre[0], centre[1]))
        ground = np.sqrt(np.maximum(slant**2 - below**2, 0.0))
        x, y = centre[0] + ground * east, centre[1] + ground * north
        position = np.stack((x, y, sea.surface.height(x, y)), axis=1)
        fine = np.linspace(-response.reach_m, response.reach_m, 4001)
        along = float(np.sum(response(fine) ** 2) * (fine[1] - fine[0]))
        across = beam_deg * float(np.sqrt(np.pi / (8.0 * np.log(2.0))))  # ∫ of the beam's four-fold power
        drawn = rng.standard_normal((2, count)) / np.sqrt(2.0 * density * along * across)
        seen = slant > max(below, 0.0)
        return cls(position[seen], (drawn[0] + 1j * drawn[1])[seen], response, beam_deg)

    def voltages(
        self, array: Array, transmitter: NDArray[np.intp], receivers: tuple[int, ...], ranges: Field, wavelength: float
    ) -> NDArray[np.complex128]:
        """(n, receiver, gate) of n pulses; transmitter (n,)."""
        size = (array.across.shape[0], ranges.size)
        pulse, point, aside = self._heard(array, receivers)
        volts = self.amplitude[point] * np.exp(-4.0 * np.log(2.0) * (aside / self.beam_deg) ** 2)  # two ways
        out = self._distance(array, pulse, transmitter[pulse], point)
        heard = []
        for antenna in receivers:
            path = out + self._distance(array, pulse, np.full(pulse.shape, antenna), point)
            heard.append(self._gated(volts * phasor(path, wavelength), 0.5 * path, pulse, ranges, size))
        return np.stack(heard, axis=1)

    def _heard(self, array: Array, receivers: tuple[int, ...]) -> tuple[NDArray[np.intp], NDArray[np.intp], Field]:
        """Pulses and the points in their beams, and how far [deg] off the fan's plane these are."""
        middle = array.antennas[:, list(receivers[:2])].mean(axis=1)
        edge, some = np.sin(np.radians(_BEAMS * self.beam_deg)), middle.shape[0] // 2
        # Not all points are evaluated for every pulse: from one pulse to another a sine changes by no more than this.
        away = self.position - middle[some]
        distance = np.linalg.norm(away, axis=-1)
        turn = np.linalg.norm(array.across - array.across[some], axis=-1).max()
        shift = 2.0 * np.linalg.norm(middle - middle[some], axis=-1).max() / distance
        near = np.flatnonzero(np.abs(away @ array.across[some]) < (edge + turn + shift) * distance)

        away = self.position[near] - middle[:, None]
        sine = np.einsum("nmj,nj->nm", away, array.across) / np.linalg.norm(away, axis=-1)
        ahead = np.einsum("nmj,nj->nm", away, array.boresight) > 0.0
        pulse, number = np.nonzero(ahead & (np.abs(sine) < edge))
        return pulse, near[number], np.degrees(np.arcsin(sine[pulse, number]))

    def _distance(
        self, array: Array, pulse: NDArray[np.intp], antenna: NDArray[np.intp], point: NDArray[np.intp]
    ) -> Field:
        return np.sqrt(np.sum((self.position[point] - array.antennas[pulse, antenna]) ** 2, axis=1))

    def _gated(
        self,
        volts: NDArray[np.complex128],
        half_path: Field,
        pulse: NDArray[np.intp],
        ranges: Field,
        size: tuple[int, int],
    ) -> NDArray[np.complex128]:
        """Each echo in the gates that its response reaches, (n, gate)."""
        spacing = float(ranges[1] - ranges[0]) if ranges.size > 1 else np.inf
        reach = self.response.reach_m
        first = np.ceil((half_path - reach - ranges[0]) / spacing).astype(np.intp)
        total = np.zeros(size[0] * size[1], dtype=np.complex128)
        for gate in (first + step for step in range(int(2.0 * reach / spacing) + 1)):
            inside = (gate >= 0) & (gate < size[1])
            cell = pulse[inside] * size[1] + gate[inside]
            part = volts[inside] * self.response(ranges[gate[inside]] - half_path[inside])
            for real, unit in ((part.real, 1.0), (part.imag, 1.0j)):
                total += unit * np.bincount(cell, weights=real, minlength=total.size)
        return total.reshape(size)
