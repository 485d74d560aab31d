"""How a sample of the echo hears the sea: its response in range, the beam, and how much of either may be left out.

Facets are summed into samples. With a plain pulse and an ideal receiver these are the gates themselves; a converter's
samples lie closer, and those of a chirp are not compressed yet. Both responses are tables so fine that the nearest
entry does.

What is left out of the beam's sides and of the pulse's flanks, a share p of the power, comes from other water, which
stands σ higher or lower. It turns the interferometric phase of a sample as √p σ of height does, and of N samples as
√(p/N) σ. So far aside, or in range, that √p σ is a tenth of the error that the mesh may make, a facet need not be
summed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..radar.antenna import cache_by_radar
from ..radar.array import Array, antenna_array
from ..radar.chirp import Chirp
from ..radar.digital import DigitalReceiver
from ..radar.scan import BEAMS_BEYOND
from ..radar.waveform import RangeResponse, gates
from ..settings import RadarSettings

RESPONSE_STEP = 1e-3  # m between the entries of the response's table: 2e-4 of its peak at its steepest

Response = Callable[[ArrayLike], NDArray[np.float64]]


@dataclass(frozen=True)
class Samples:
    """Where facets are summed: ranges (sample,) [m], and the response of each path's samples to a reflector."""

    range: NDArray[np.float64]
    responses: tuple[Response, ...]  # of each path; the same object where they are alike
    support_m: float
    compress: Chirp | None = None  # from samples to gates, at any pulse or node


def gate_samples(radar: RadarSettings, paths: tuple[tuple[int, int], ...] | None = None) -> Samples:
    """The gates themselves, of a plain pulse, on the mode's paths or on others."""
    return _plain(radar, gates(radar), paths)


@cache_by_radar(maxsize=8)
def received_samples(radar: RadarSettings) -> Samples:
    """What the radar's receiver is given: samples of its converter, of a chirp before compression, or the gates."""
    if radar.waveform == "chirp":
        chirp = Chirp(radar)
        kernels = (chirp.kernel,) * len(antenna_array(radar).paths)
        return Samples(chirp.raw_range, kernels, chirp.kernel_support_m, chirp)
    if radar.receiver.chain == "digital":
        return _plain(radar, np.asarray(DigitalReceiver(radar).sample_range, dtype=np.float64))
    return gate_samples(radar)


@dataclass(frozen=True)
class ResponseTable:
    """Samples, and what each path's give to a reflector at so many steps off their middles."""

    samples: Samples
    response: NDArray[np.float32]  # (path or 1, entry), that at (n + ½) steps; 0 from the last entry on
    left_out: float = 0.0  # share of the power, of the path that loses most
    step: float = RESPONSE_STEP  # m


@cache_by_radar(maxsize=8)
def tabulated(radar: RadarSettings, neglected: float = 0.0) -> ResponseTable:
    """The samples that the radar's receiver is given, and their response, but for that share of the power that comes
    from farthest off their middles; of a chirp's, which are still to be compressed, all."""
    samples = received_samples(radar)
    tables = response_tables(samples)
    table = np.array(tables[:1] if all(table is tables[0] for table in tables) else tables)
    if samples.compress is not None or neglected == 0.0:
        return ResponseTable(samples, table)
    power = np.square(table.astype(np.float64))
    beyond = 1.0 - np.cumsum(power, axis=1) / power.sum(axis=1, keepdims=True)
    last = int(np.argmax((beyond <= neglected).all(axis=0)))
    cut = np.array(table[:, : last + 2])
    cut[:, -1] = 0.0
    return ResponseTable(samples, cut, max(0.0, float(beyond[:, last].max())))


def _plain(
    radar: RadarSettings, ranges: NDArray[np.float64], paths: tuple[tuple[int, int], ...] | None = None
) -> Samples:
    array, made = antenna_array(radar), dict[float, RangeResponse]()
    responses = []
    for i, j in array.paths if paths is None else paths:
        width = _cascade_bandwidth(radar.bandwidth_hz, array.elements[i].bandwidth_hz, array.elements[j].bandwidth_hz)
        responses.append(made.setdefault(width, replace(RangeResponse.of(radar), bandwidth_hz=width)))
    return Samples(ranges, tuple(responses), max(response.support_m for response in responses))


def response_tables(samples: Samples) -> list[NDArray[np.float32]]:
    """Response of each path's samples at (n + ½) steps off their middles; the same object where paths are alike."""
    first, end = 0.5 * RESPONSE_STEP, samples.support_m + 2.0 * RESPONSE_STEP
    offsets = np.arange(first, end, RESPONSE_STEP)  # middles: an index is cut, not rounded
    tables = {response: np.append(response(offsets), 0.0).astype(np.float32) for response in set(samples.responses)}
    return [tables[response] for response in samples.responses]


def _cascade_bandwidth(*bandwidths: float) -> float:
    """Bandwidth of Gaussian filters in cascade: the receiver's and the antennas' own."""
    if all(np.isinf(width) for width in bandwidths[1:]):
        return bandwidths[0]
    return float(1.0 / np.sqrt(sum(1.0 / width**2 for width in bandwidths)))


_REACH = 3.5  # beams to either side
_ENTRIES = 2**16  # over ±3.5 beams: the nearest entry errs by at most 1e-4 of the peak


@dataclass(frozen=True)
class TwoWayBeams:
    """Two-way voltages of the paths, or of a single one where all antennas are alike and stand on one axis.

    Antennas beside the array's axis look along lines of their own: the legs out and back then have a table each.
    """

    tables: NDArray[np.float32]  # (path or 1, leg, entry) voltage; 0 at both ends, and beyond
    aside: NDArray[np.float64]  # (path or 1, leg) m that the leg's antenna stands off the array's axis
    scale: float  # entries per unit of direction cosine; 0 lies half an entry beyond the middle

    def voltage_bound(self, cosine: NDArray[np.float64]) -> NDArray[np.float64]:
        """Voltage over the peak's, of the path that has most, at such direction cosines or further to either side."""
        voltage = np.abs(self.tables.astype(np.float64).prod(axis=1)).max(axis=0)
        half = voltage.size // 2
        aside = np.maximum(voltage[half:], voltage[:half][::-1])
        beyond = np.maximum.accumulate(aside[::-1])[::-1]
        return np.asarray(beyond[np.minimum(np.abs(cosine) * self.scale, half - 1).astype(int)] / beyond[0])

    def share_beyond(self, cosine: ArrayLike) -> NDArray[np.float64]:
        """Share of the two-way power from beyond such direction cosines to either side, of the path with the most."""
        power = np.square(self.tables.astype(np.float64).prod(axis=1))
        aside = np.abs(np.arange(power.shape[1]) - 0.5 * (power.shape[1] - 1)) / self.scale
        order = np.argsort(aside)
        summed = np.cumsum(power[:, order], axis=1)
        within = summed[:, np.clip(np.searchsorted(aside[order], cosine) - 1, 0, None)]
        return np.max(1.0 - within / summed[:, -1:], axis=0)


@cache_by_radar(maxsize=8)
def two_way_beams(radar: RadarSettings) -> TwoWayBeams:
    """The two-way beams of the radar's mode."""
    array = antenna_array(radar)
    reach = float(np.sin(np.radians(min(90.0, _REACH * array.beam_deg))))
    alike = len({element.antenna.azimuth for element in array.elements}) == 1
    on_axis = np.ptp(array.offsets[:, 0]) == 0.0 and array.offsets[0, 0] == 0.0
    paths = array.paths[:1] if alike and on_axis else array.paths
    legs = [((i, j),) if on_axis else ((i,), (j,)) for i, j in paths]
    return TwoWayBeams(
        tables=np.array([[_table(array, leg, reach) for leg in each] for each in legs]),
        aside=np.array([[float(array.offsets[leg[0], 0]) for leg in each] for each in legs]),
        scale=(_ENTRIES - 1) / (2.0 * reach),
    )


def _table(array: Array, antennas: tuple[int, ...], reach: float) -> NDArray[np.float32]:
    """Product of the antennas' azimuth cuts."""
    cosine = np.linspace(-reach, reach, _ENTRIES)
    table = np.prod([array.elements[antenna].antenna.azimuth(cosine) for antenna in antennas], axis=0)
    table[[0, -1]] = 0.0
    return table.astype(np.float32)


_WITHIN = 0.1  # of the height error allowed, for a single sample: cells have tens
_MOST = 1e-4  # of the power, however flat the sea: in deep shadow nothing else may be heard
_BEAMS = np.arange(20, round(20 * BEAMS_BEYOND) + 1) / 20.0


def truncation_share(elevation_std_m: float, height_error_m: float) -> float:
    """The share p of the power that may be left out, of a sea that stands σ = elevation_std_m high, rms."""
    return float(min(_MOST, (_WITHIN * height_error_m / max(elevation_std_m, 1e-9)) ** 2))


@cache_by_radar(maxsize=8)
def beam_truncation(radar: RadarSettings, share: float) -> float:
    """Beam widths to either side of the boresight, 1 to 3, beyond which no more than that share of the power lies."""
    enough = np.flatnonzero(share_aside(radar, _BEAMS) <= share)
    return float(_BEAMS[enough[0]]) if share > 0.0 and enough.size else BEAMS_BEYOND


def share_aside(radar: RadarSettings, beams: ArrayLike) -> NDArray[np.float64]:
    """Share of the two-way power from more than so many beam widths to either side, of the path that has most."""
    aside = np.radians(np.minimum(np.asarray(beams) * antenna_array(radar).beam_deg, 90.0))
    return np.maximum(two_way_beams(radar).share_beyond(np.sin(aside)), 0.0)


def truncation_error_m(radar: RadarSettings, elevation_std_m: float, share: float) -> float:
    """√p σ [m] of what is left out aside and in range; a staring antenna hears all that is aside."""
    aside = 0.0 if radar.scan == "staring" else float(share_aside(radar, [beam_truncation(radar, share)])[0])
    return float(np.sqrt(aside + tabulated(radar, share).left_out)) * elevation_std_m
