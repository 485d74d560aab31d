"""What a mesh costs where the sea is flat: a gate's echo is a sum over facets, and ought to be an integral.

The sum errs where the range response, the antenna's pattern in elevation or the interferogram's phase change from one
rung to the next: under steep looks, of long pulses with steep edges, through the sidelobes below a high mast. All three
are known beforehand, and so is the error: along one look of a level sea both are summed up here.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..conventions import db, ground_range, radar_wavenumber
from ..radar.array import Array, antenna_array
from ..radar.waveform import RangeResponse
from ..settings import RadarSettings

Field = NDArray[np.float64]

_PLACES = 8  # of the rungs against the gate, over which errors are averaged
_REFERENCE, _FINE = 1024, 60.0  # points of the integral, and of the main lobe's half, at least
# σ0 of a light wind: the mirrors' below the mast, of slopes of that variance, and about that of the ripples elsewhere.
_GLITTER, _SLOPES, _BRAGG = 0.6, 0.03, 0.01
_LEAST_HEIGHTS = 1.2  # of the mast
_LEAST = 1e-3  # of a power: errors of 30 dB are as large as any
_LEAST_COHERENCE = 0.1  # below it phases are noise, and so are heights


class SamplingErrors(NamedTuple):
    """Rms errors (range, facet size) of gates over where the rungs happen to lie."""

    power_db: Field
    height_m: Field  # 0 where the gate's own extent leaves no coherence
    coherence: Field


def sampling_errors(radar: RadarSettings, ranges: Field, facet: Field) -> SamplingErrors:
    """Errors of gates at slant ranges (range,) [m] on meshes with rungs `facet` (facet size,) [m] apart.

    0 for gates nearer than 1.2 heights of the mast: the sea there is seen from above, and nobody maps it.
    """
    look = _Look(radar)
    errors = np.zeros((3, ranges.size, facet.size))
    for number, middle in enumerate(ranges):
        if middle < _LEAST_HEIGHTS * radar.height_m:
            continue
        exact, rest = look.exact(float(middle))
        if exact.power[0] <= 0.0:  # in the pattern's null
            continue
        coherence = np.abs(exact.covariance) / exact.power
        metres = look.metres_per_radian(float(middle)) if coherence[0] > _LEAST_COHERENCE else 0.0
        for size, step in enumerate(facet):
            found = look.facet_sums(float(middle), float(step)) + rest
            each = (
                db(np.maximum(found.power / exact.power, _LEAST)),
                metres * np.angle(found.covariance * exact.covariance.conj()),
                np.abs(found.covariance) / np.maximum(found.power, _LEAST * exact.power) - coherence,
            )
            errors[:, number, size] = [float(np.sqrt(np.mean(values**2))) for values in each]
    return SamplingErrors(*errors)


class _Sums(NamedTuple):
    """The sums of a gate, (place,)."""

    power: Field
    covariance: NDArray[np.complex128]

    def __add__(self, other: tuple) -> _Sums:
        """The sums over two parts of the sea together."""
        return _Sums(self.power + other[0], self.covariance + other[1])


class _Look:
    """One look of a radar over a level sea, in the plane of its boresight."""

    def __init__(self, radar: RadarSettings) -> None:
        array = antenna_array(radar)
        self.response = RangeResponse.of(radar)
        self.height = radar.height_m
        self.tilt = np.radians(radar.tilt_deg)
        self.cuts = [element.antenna.elevation for element in array.elements]
        self.transmitter, self.receivers = array.transmitters[0], array.receivers[:2]
        self.places = [self._place(array, number) for number in self.receivers]
        self.turn = array.phase_paths * radar_wavenumber(radar.frequency_hz)  # rad a metre

    def _place(self, array: Array, number: int) -> tuple[float, float]:
        """Ahead and up [m] from the water below the array; the array's axis leans forward by the tilt."""
        _, ahead, up = array.offsets[number]
        cosine, sine = np.cos(self.tilt), np.sin(self.tilt)
        return ahead * cosine + up * sine, self.height - ahead * sine + up * cosine

    def _bounds(self, middle: float, reach: float) -> tuple[float, float]:
        """Ground ranges [m] between which the sea is within a reach of a gate, in slant range."""
        near, far = ground_range([max(middle - reach, self.height), middle + reach], self.height)
        return float(near), float(far)

    def exact(self, middle: float) -> tuple[_Sums, _Sums]:
        """What a gate hears, by fine sums; and what of it comes by the sidelobes of a compressed chirp, which are as
        long as the chirp: no mesh samples them badly that samples the main lobe well."""
        reach = self.response.support_m, self.response.reach_m
        near, far = self._bounds(middle, reach[1])
        step = min((far - near) / _REFERENCE, reach[0] / _FINE)
        ground = near + step * (np.arange(int((far - near) / step) + 1.0) + 0.5)
        lobe = np.abs(middle - np.hypot(ground, self.height)) <= reach[0]
        main, rest = (self._sums(middle, ground[None], np.where(part, step * ground, 0.0)) for part in (lobe, ~lobe))
        return main + rest, rest

    def facet_sums(self, middle: float, step: float) -> _Sums:
        """The main lobe by facets between rungs `step` apart, wherever these lie against the gate: (place,).

        Between two rungs one facet has its base on the nearer rung and one on the farther: their areas are as the
        rungs' ranges, their centroids a third and two thirds of the way.
        """
        near, far = self._bounds(middle, self.response.support_m)
        shift = step * np.arange(_PLACES)[:, None] / _PLACES
        rung = near + step * np.arange(-2.0, np.ceil((far - near) / step) + 1.0) + shift
        rung = np.maximum(rung, 0.0)
        width = np.diff(rung, axis=1)
        ground = np.concatenate((rung[:, :-1] + width / 3.0, rung[:, 1:] - width / 3.0), axis=1)
        area = 0.5 * np.concatenate((rung[:, :-1] * width, rung[:, 1:] * width), axis=1)
        lobe = np.abs(middle - np.hypot(ground, self.height)) <= self.response.support_m
        return self._sums(middle, ground, np.where(lobe, area, 0.0))

    def _sums(self, middle: float, ground: Field, area: Field) -> _Sums:
        """Over points (place, point) of the sea that stand for an area each, per radian of azimuth."""
        range_m = np.hypot(ground, self.height)
        sine = (np.sin(self.tilt) * ground - np.cos(self.tilt) * self.height) / range_m
        sent = self.cuts[self.transmitter](sine)
        first, second = (self.cuts[number](sine) for number in self.receivers)
        square = (ground / self.height) ** 2  # of the tangent of the angle from the vertical
        nrcs = _GLITTER * np.exp(-square / _SLOPES) / _SLOPES * (1.0 + square) ** 2 + _BRAGG
        weight = nrcs * area / range_m**4 * self.response(middle - range_m) ** 2 * sent**2
        phase = self.turn * self._difference(ground, 0.0)
        power = np.sum(weight * first**2, axis=-1)
        return _Sums(power, np.sum(weight * first * second * np.exp(1j * phase), axis=-1))

    def _difference(self, ground: Field | float, level: float) -> Field:
        """Range to the second receiver less that to the first [m]."""
        (ahead, up), (other_ahead, other_up) = self.places
        return np.hypot(ground - other_ahead, level - other_up) - np.hypot(ground - ahead, level - up)

    def metres_per_radian(self, middle: float) -> float:
        """Metres of height for each radian of phase, where the range stays."""
        step = 0.01
        ground = [float(np.sqrt(max(middle**2 - (self.height - level) ** 2, 0.0))) for level in (-step, step)]
        turned = float(self.turn * (self._difference(ground[1], step) - self._difference(ground[0], -step)))
        return abs(2.0 * step / turned) if turned != 0.0 else 0.0
