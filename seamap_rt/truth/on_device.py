"""The truth from facets that are on the device: `kernel`'s sums, by kernels that gather, of which only cells come back.

Nothing is added atomically. Four kernels, each with a lane for every number it makes:

    facets  (facet)                  slopes; then the water's mean height, and where it lies among the bins
    bins    (column, bin)            the facets near a bin, divided between the two bins whose middles are nearest
    cells   (column, gate)           bins by their overlap with the cell, or by the gate's response
    looks   (look, gate)             columns by their overlap with the look, or by the beam

A facet's place among the bins is reckoned in float64 and kept as a bin and a share; all sums are float32, of tens of
numbers of one size: heights are the processor's to 1e-6 m.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compute.device import ONE_AT_A_TIME, Device
from ..echoes.returns_on_device import ReturnsOnDevice
from ..mesh import Facets
from ..mesh.on_device import MeshOnDevice
from ..tracing.light_on_device import LightOnDevice
from .kernel import AREA, ECHO, HEIGHT, HEIGHT_SEEN, LIGHT, QUANTITIES, SEEN, SLOPE_CROSS, SLOPE_LOOK, Band, Bins

_Edges = tuple[NDArray[np.uint32], NDArray[np.uint32]]


class FacetsOnDevice(NamedTuple):
    """What the truth of a turn is made of."""

    grid: Facets  # of which only what all columns have alike is asked
    mesh: MeshOnDevice
    light: LightOnDevice
    returns: ReturnsOnDevice


class _Parts(NamedTuple):
    """Flat arrays (column, facet), or (column, facet, part)."""

    height: Any  # m, of a part
    bin: Any  # UInt32, the first of the two that share it, or beyond all
    share: Any  # of the second
    slope_look: Any
    slope_cross: Any
    lit: Any
    arriving: Any
    rcs: Any


def summed_on_device(
    facets: FacetsOnDevice,
    apart: NDArray[np.float64],
    bins: Bins,
    box: Band,
    response: Band,
    looks: NDArray[np.float64],
    beam: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sums (look, gate, quantity) over cells and (look, gate, 2) of area and height by response and beam.

    apart (facet, part) m, see `Surface`; looks, beam (look, column): weights.
    """
    of = facets.mesh.device
    with ONE_AT_A_TIME:
        parts = _parts(of, facets, apart, bins)
        heights = of.number(of.dr.min(parts.height)), of.number(of.dr.max(parts.height))
        columns = _binned(of, facets, parts, _edges(facets, heights, apart, bins), apart, bins)
        cells = _banded(of, columns, bins, box)
        heard = _banded(of, [columns[AREA], columns[HEIGHT]], bins, response)
        return _looks(of, cells, looks, box), _looks(of, heard, beam, response)


def _parts(of: Device, facets: FacetsOnDevice, apart: NDArray[np.float64], bins: Bins) -> _Parts:
    dr, mesh, grid = of.dr, facets.mesh, facets.mesh.grid
    count, columns = mesh.facets, grid.columns
    lane = dr.arange(of.UInt32, columns * count)
    column, facet = lane // count, lane % count
    look, cross = mesh.slopes(column, facet)
    dr.eval(look, cross)

    before, after = dr.select(column > 0, lane - count, lane), dr.select(column < columns - 1, lane + count, lane)
    near, far = dr.select(facet >= 2, lane - 2, lane), dr.select(facet + 2 < count, lane + 2, lane)

    def differ(values: Any, first: Any, last: Any, step: int) -> Any:
        each = dr.gather(of.Float, values, last) - dr.gather(of.Float, values, first)
        return each * (float(step) / of.Float(dr.maximum(last - first, 1)))

    step = np.repeat(np.diff(grid.ground_range), 2)
    width = facets.grid.distance * np.radians(grid.spacing_deg)
    bend = differ(look, near, far, 2) + differ(look, before, after, count)
    bend *= dr.gather(of.Float, of.place_single(step / 12.0), facet)
    bend += differ(cross, before, after, count) * dr.gather(of.Float, of.place_single(width / 12.0), facet)
    height = mesh.height(column, facet) - of.Float64(bend)
    lit, arriving = _light(of, facets.light, lane)
    dr.eval(height, lit, arriving)

    several = apart.shape[1]
    part = dr.arange(of.UInt32, columns * count * several)
    own = part // several
    off = dr.gather(of.Float64, of.place(apart), part % (count * several))
    raised = dr.gather(of.Float64, height, own) + of.Float64(dr.gather(of.Float, look, own)) * off
    level = dr.gather(of.Float64, of.place(grid.column_height[:, 0]), own // count)
    distance = dr.gather(of.Float64, of.place(facets.grid.distance), own % count) + off
    rise = raised - level
    position = (dr.sqrt(distance * distance + rise * rise) - bins.start) / bins.width - 0.5
    inside = (position >= 0.0) & (position < bins.size - 1)
    number = of.UInt32(dr.select(inside, position, 0.0))
    share = of.Float(position - of.Float64(number))
    number = dr.select(inside, number, of.UInt32(2 * bins.size))
    raised = of.Float(raised)
    dr.eval(number, share, raised)
    return _Parts(raised, number, share, look, cross, lit, arriving, facets.returns.rcs)


def _light(of: Device, light: LightOnDevice, lane: Any) -> tuple[Any, Any]:
    """Share of a facet's water that all antennas see, and of the power that gets to it and comes back."""
    dr, antennas = of.dr, range(light.antennas)
    lit = [dr.gather(of.Bool, light.lit, lane + antenna * light.cells) for antenna in antennas]
    fields = [light.bent(antenna, lane) for antenna in antennas]
    everyone, one_way = of.Bool(True), of.Float(0.0)
    for shines, field in zip(lit, fields, strict=True):
        everyone &= shines
        power = dr.select(shines, 1.0, 0.0) if field is None else field[0] * field[0] + field[1] * field[1]
        one_way += power * (1.0 / len(lit))
    seen = dr.select(everyone, of.Float(1.0), of.Float(0.0))
    return seen if light.in_sight is None else seen * light.in_sight, one_way * one_way


def _binned(
    of: Device, facets: FacetsOnDevice, parts: _Parts, edges: _Edges, apart: NDArray[np.float64], bins: Bins
) -> list[Any]:
    """(column, bin) sums of each quantity."""
    dr, count, several, columns = of.dr, facets.mesh.facets, apart.shape[1], facets.mesh.grid.columns
    lane = dr.arange(of.UInt32, columns * bins.size)
    column, own = lane // bins.size, lane % bins.size
    begin, end = (dr.gather(of.UInt32, of.place(each), own) for each in edges)
    area = of.place_single(facets.grid.horizontal_area / several)

    def add(part: Any, stop: Any, *sums: Any) -> tuple[Any, ...]:
        first = dr.gather(of.UInt32, parts.bin, part)
        share = dr.gather(of.Float, parts.share, part)
        weight = dr.select(first == own, 1.0 - share, dr.select(first + 1 == own, share, 0.0))
        facet = part // several
        look, cross, lit, arriving, rcs = (
            dr.gather(of.Float, each, facet)
            for each in (parts.slope_look, parts.slope_cross, parts.lit, parts.arriving, parts.rcs)
        )
        covered = weight * dr.gather(of.Float, area, facet % count)
        height = covered * dr.gather(of.Float, parts.height, part)
        value: dict[int, Any] = {
            AREA: covered,
            SEEN: covered * lit,
            HEIGHT: height,
            HEIGHT_SEEN: height * lit,
            SLOPE_LOOK: covered * look,
            SLOPE_CROSS: covered * cross,
            ECHO: weight * rcs * arriving * (1.0 / several),
            LIGHT: covered * arriving,
        }
        return part + 1, stop, *(each + value[quantity] for quantity, each in enumerate(sums))

    at = column * (count * several)
    state = at + begin, at + end, *(dr.zeros(of.Float, dr.width(lane)) for _ in range(QUANTITIES))
    sums = list(dr.while_loop(state, lambda part, stop, *sums: part < stop, add)[2:])
    dr.eval(sums)
    return sums


def _edges(facets: FacetsOnDevice, heights: tuple[float, float], apart: NDArray[np.float64], bins: Bins) -> _Edges:
    """(bin,) between which parts of a column all lie that a bin may have, between those heights [m]."""
    level, beyond = facets.mesh.grid.column_height, 2.0 * bins.width + float(np.abs(apart).max())
    low, high = heights[0] - float(level.max()) - bins.width, heights[1] - float(level.min()) + bins.width
    deepest, flattest = max(abs(low), abs(high)), 0.0 if low <= 0.0 <= high else min(abs(low), abs(high))
    middle = bins.start + bins.width * (np.arange(bins.size) + 0.5)
    nearest = np.sqrt(np.maximum(np.maximum(middle - beyond, 0.0) ** 2 - deepest**2, 0.0))
    farthest = np.sqrt(np.maximum((middle + beyond) ** 2 - flattest**2, 0.0))
    begin = np.searchsorted(facets.grid.distance, nearest - beyond) * apart.shape[1]
    end = np.searchsorted(facets.grid.distance, farthest + beyond, side="right") * apart.shape[1]
    return begin.astype(np.uint32), end.astype(np.uint32)


def _banded(of: Device, columns: list[Any], bins: Bins, band: Band) -> list[Any]:
    """(column, gate) of each quantity's (column, bin)."""
    dr, (gates, width) = of.dr, band.weight.shape
    lane = dr.arange(of.UInt32, dr.width(columns[0]) // bins.size * gates)
    column, gate = lane // gates, lane % gates
    weights, start = of.place_single(band.weight), dr.gather(of.UInt32, of.place(band.first.astype(np.uint32)), gate)

    def add(n: Any, *sums: Any) -> tuple[Any, ...]:
        weight = dr.gather(of.Float, weights, gate * width + n)
        place = column * bins.size + start + n
        return n + 1, *(s + weight * dr.gather(of.Float, each, place) for s, each in zip(sums, columns, strict=True))

    return _looped(of, add, of.UInt32(0), lambda n, *_: n < width, len(columns), dr.width(lane))


def _looks(of: Device, columns: list[Any], weight: NDArray[np.float64], band: Band) -> NDArray[np.float64]:
    """(look, gate, quantity) sums of the columns' (column, gate) by weight (look, column), back here."""
    dr, gates, (looks, count) = of.dr, len(band.weight), weight.shape
    lane = dr.arange(of.UInt32, looks * gates)
    look, gate = lane // gates, lane % gates
    counts = weight != 0.0
    begin = of.place(np.where(counts.any(axis=1), counts.argmax(axis=1), 0).astype(np.uint32))
    end = of.place(np.where(counts.any(axis=1), count - counts[:, ::-1].argmax(axis=1), 0).astype(np.uint32))
    stop, weights = dr.gather(of.UInt32, end, look), of.place_single(weight)

    def add(column: Any, *sums: Any) -> tuple[Any, ...]:
        share, place = dr.gather(of.Float, weights, look * count + column), column * gates + gate
        made = (s + share * dr.gather(of.Float, each, place) for s, each in zip(sums, columns, strict=True))
        return column + 1, *made

    first = dr.gather(of.UInt32, begin, look)
    sums = _looped(of, add, first, lambda column, *_: column < stop, len(columns), dr.width(lane))
    return np.stack([of.fetch(each, (looks, gates)) for each in sums], axis=-1).astype(np.float64)


def _looped(
    of: Device, add: Callable[..., Any], first: Any, goes_on: Callable[..., Any], sums: int, lanes: int
) -> list[Any]:
    """Sums that start from 0, over numbers from `first` on."""
    dr = of.dr
    state = first + dr.zeros(of.UInt32, lanes), *(dr.zeros(of.Float, lanes) for _ in range(sums))
    made = list(dr.while_loop(state, goes_on, add)[1:])
    dr.eval(made)
    return made
