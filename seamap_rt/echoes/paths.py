"""Each facet's paths to the antennas: their lengths, their differences, and the voltage that it returns.

The antennas are where they stand when the beam passes the facet's column, and move on from there at a constant
velocity while it does. What goes from one antenna to another goes back the same way: a path serves both. Phases of
further paths are reckoned from the first by differences of ranges, formed from differences of squares, which keeps
every digit (3e-7 m even in float32; here float64).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..conventions import SPEED_OF_LIGHT
from ..mesh import Facets
from ..radar.antenna import Antenna, Cut
from ..radar.array import antenna_array
from ..radar.receiver import amplitude_constant
from ..settings import RadarSettings

Path = tuple[int, int]  # the two antennas
Chosen = tuple[NDArray[np.intp], NDArray[np.intp]]  # numbers of columns and of facets, which broadcast


@dataclass(frozen=True)
class FacetPaths:
    """Paths of the facets of some columns; arrays (column, facet) unless said otherwise."""

    paths: tuple[Path, ...]
    length: NDArray[np.float64]  # (path, column, facet) half the path transmitter → facet → receiver [m]
    range: NDArray[np.float64]  # (antenna, column, facet) m
    difference: NDArray[np.float64]  # (antenna, column, facet) R − R₀ [m]
    coming: NDArray[np.float64]  # (antenna, column, facet) m/s, radial velocity seen from each antenna, positive away
    # (path, column, facet) voltage at boresight azimuth, before the range response [√W]; complex where light bends
    amplitude: NDArray[np.float32] | NDArray[np.complex64]


def facet_paths(
    facets: Facets,
    rcs: NDArray[np.float32],
    radar: RadarSettings,
    columns: slice,
    paths: tuple[Path, ...] | None = None,
    chosen: Chosen | None = None,
) -> FacetPaths:
    """The facets of `columns` on paths between antennas; left out, on those that the radar's mode uses.

    rcs (column, facet) [m²] is that of all columns; a facet echoes on a path only if it is lit for both of its
    antennas. With a diffracted field it echoes as far as that reaches it, lit or not, out and back alike.
    chosen: numbers (n,) of columns and facets: these alone, and (n,) stands for (column, facet) in what is returned.
    """
    if facets.lit is None:
        raise ValueError("these facets have not been traced; call a tracer first")
    array, grid = antenna_array(radar), facets.grid
    paths = array.paths if paths is None else paths
    if chosen is None:
        number = np.arange(facets.height.shape[0])[columns]
        chosen = number[:, None], np.arange(facets.distance.size)[None, :]
    column, facet = chosen
    distance = facets.distance[facet]
    rise = facets.height[chosen] - grid.column_height[column, 0]
    ahead, aside = ((facets.distance * part(facets.angle))[facet] for part in (np.cos, np.sin))
    square = distance**2 + rise**2
    middle = np.sqrt(square)
    places = grid.places

    def towards(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """(column, facet): products of the facets' places with a vector (column, 3) each."""
        product = vectors[column, 2] * rise
        for axis, along in ((0, ahead), (1, aside)):
            if vectors[:, axis].any():  # an upright array stands on its own axis
                product += vectors[column, axis] * along
        return product

    ranges = np.empty((places.shape[1], *middle.shape))
    difference = np.zeros_like(ranges)
    for antenna in range(places.shape[1]):
        place = places[:, antenna]
        ranges[antenna] = np.sqrt(square - 2.0 * towards(place) + np.sum(place**2, axis=1)[column])
    for antenna in range(1, places.shape[1]):
        place, first = places[:, antenna], places[:, 0]
        squares = np.sum(place**2 - first**2, axis=1)[column] - 2.0 * towards(place - first)
        difference[antenna] = squares / (ranges[antenna] + ranges[0])

    look, up = facets.velocity_look[chosen].astype(np.float64), facets.velocity_up[chosen].astype(np.float64)
    flow = look * distance + up * rise
    coming = np.empty_like(ranges)
    for antenna in range(places.shape[1]):
        # (u − d)·(r − a), with the facet's velocity u and place r, and the antenna's d and a.
        place, drift = places[:, antenna], grid.drift[:, antenna]
        product = flow - look * place[column, 0] - up * place[column, 2]
        if drift.any():
            product -= towards(drift) - np.sum(drift * place, axis=1)[column]
        coming[antenna] = product / ranges[antenna]

    sine = towards(grid.array_up) / middle
    return FacetPaths(
        paths=paths,
        length=np.stack([ranges[i] if i == j else 0.5 * (ranges[i] + ranges[j]) for i, j in paths]),
        range=ranges,
        difference=difference,
        coming=coming,
        amplitude=_amplitudes(facets, np.sqrt(rcs[chosen]), radar, chosen, paths, ranges, sine),
    )


def _amplitudes(
    facets: Facets,
    root: NDArray[np.float32],
    radar: RadarSettings,
    chosen: Chosen,
    paths: tuple[Path, ...],
    ranges: NDArray[np.float64],
    sine: NDArray[np.float64],
) -> NDArray[np.float32] | NDArray[np.complex64]:
    """(path, column, facet) √W; root: of the cross-sections; sine: direction cosine of each facet up the array."""
    elements = antenna_array(radar).elements
    cuts: dict[Cut, NDArray[np.float64]] = {}

    def cut(antenna: Antenna) -> NDArray[np.float64]:
        if antenna.elevation not in cuts:
            cuts[antenna.elevation] = _tabulated(antenna.elevation, sine)
        return cuts[antenna.elevation]

    amplitudes = []
    for i, j in paths:
        one, other = elements[i].antenna, elements[j].antenna
        gain = float(np.sqrt(one.gain * other.gain))
        voltage = amplitude_constant(radar, gain) * cut(one) * cut(other) * root / (ranges[i] * ranges[j])
        if facets.field is None:
            assert facets.lit is not None
            seen = facets.lit[i][chosen] if i == j else facets.lit[i][chosen] & facets.lit[j][chosen]
            amplitudes.append(np.where(seen, voltage, 0.0).astype(np.float32))
        else:
            amplitudes.append((voltage * facets.field[i][chosen] * facets.field[j][chosen]).astype(np.complex64))
    return np.stack(amplitudes)


def wavenumber(radar: RadarSettings) -> float:
    """k = 2πf/c [rad/m]."""
    return 2.0 * np.pi * radar.frequency_hz / SPEED_OF_LIGHT


_TABLE = np.linspace(-1.0, 1.0, 20_001)


def _tabulated(cut, sine: NDArray[np.float64]) -> NDArray[np.float64]:
    """A pattern cut by linear interpolation in its direction cosine (1e-4 apart: 1e-6 of the peak for beams ≥ 1°)."""
    return np.interp(sine, _TABLE, _table(cut))


@lru_cache(maxsize=16)
def _table(cut: Cut) -> NDArray[np.float64]:
    return cut(_TABLE)
