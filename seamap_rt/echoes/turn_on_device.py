"""A turn's echoes from facets and light that are on the device: `turn_echoes`, whose voltages stay there.

A batch of columns is listed, ranged and summed there. What goes up with it is what a column has, not its facets: the
modes of its speckle and where the beam looks, at each node of its window. The sums come back where a turn has objects,
or receivers that are the host's alone (see `receiving_on_device`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compute.device import ONE_AT_A_TIME
from ..mesh import Facets
from ..mesh.on_device import MeshOnDevice
from ..radar.array import antenna_array
from ..radar.receiver import amplitude_constant
from ..radar.scan import Pulses
from ..settings import RadarSettings
from ..tracing.light_on_device import LightOnDevice
from .paths import elevation_tables
from .receiving import Received
from .receiving_on_device import SumsThere, can_receive, received_on_device
from .returns_on_device import ReturnsOnDevice
from .summation import COLUMNS_ON_DEVICE, ColumnBatch, ListedFacets
from .summation.device import Heard, OnPath, alike, fetched, gate_middles, middle_s, on_path, sum_heard, support_m
from .turn import Hearing, received


def turn_echoes_on_device(
    facets: Facets,
    mesh: MeshOnDevice,
    light: LightOnDevice,
    returns: ReturnsOnDevice,
    radar: RadarSettings,
    pulses: Pulses,
    seed: int,
    decorrelation_time_s: float,
    objects: NDArray[np.complex64] | None = None,
    unheard: float = 0.0,
) -> Received:
    """See `turn_echoes`. facets: the mesh's, of which only where columns and antennas are is asked."""
    with ONE_AT_A_TIME:
        fastest = returns.fastest(mesh)
    hearing = Hearing.of(facets, radar, pulses, seed, decorrelation_time_s, returns.motion, unheard, fastest)
    sums = SumsOnDevice(hearing, mesh, light, returns, (float(facets.height.min()), float(facets.height.max())))
    if objects is None and can_receive(radar):
        return received_on_device(sums.total(), hearing.nodes, radar, pulses, seed)
    return received(hearing.total(sums, COLUMNS_ON_DEVICE), hearing, pulses, seed, objects)


@dataclass(frozen=True)
class SumsOnDevice:
    """`ColumnSums` of facets that are there."""

    hearing: Hearing
    mesh: MeshOnDevice
    light: LightOnDevice
    returns: ReturnsOnDevice
    heights: tuple[float, float]  # m above mean sea level, of the lowest facet and of the highest

    def __call__(self, columns: slice) -> tuple[int, NDArray[np.float32]]:
        """First node's number and the columns' sum (component, path, gate, node), real and imaginary."""
        low, batch, sums = self._summed(columns)
        if sums is None:
            paths, gates = len(batch.geometry.antennas), batch.beam.level.size
            return low, np.zeros((2, paths, gates, batch.nodes), dtype=np.float32)
        with ONE_AT_A_TIME:
            return low, fetched(batch, sums)

    def total(self) -> SumsThere:
        """The sum over all columns; see `Hearing.total`."""
        of, hearing = self.mesh.device, self.hearing
        dr, paths, gates = of.dr, len(self._constants), hearing.tabulated.samples.range.size
        lane = dr.arange(of.UInt32, gates * hearing.nodes.count)
        gate, node = lane // hearing.nodes.count, of.Int32(lane % hearing.nodes.count)
        parts = [[dr.zeros(of.Float, dr.width(lane)) for _ in range(2)] for _ in range(paths)]
        for low, batch, sums in hearing.in_order(self._summed, COLUMNS_ON_DEVICE):
            if sums is None:
                continue
            with ONE_AT_A_TIME:
                within = node - low
                held = (within >= 0) & (within < batch.nodes)
                place = gate * batch.nodes + of.UInt32(dr.maximum(within, 0))
                for part, more in zip(parts, sums, strict=True):
                    part[:] = (p + dr.gather(of.Float, m, place, held) for p, m in zip(part, more, strict=True))
                dr.eval(parts)
        with ONE_AT_A_TIME:
            real, imag = (dr.concat(tuple(each)) for each in zip(*parts, strict=True))
        return SumsThere(real, imag, gates)

    def _summed(self, columns: slice) -> tuple[int, ColumnBatch, list[tuple[Any, Any]] | None]:
        """First node's number, the batch, and its sum on the device; None where nothing echoes."""
        nowhere = np.zeros(columns.stop - columns.start + 1, dtype=np.intp)
        low, batch = self.hearing.batch(columns, nowhere, _NO_FACETS, np.empty((0, 1), dtype=np.float32))
        with ONE_AT_A_TIME:
            heard = self._listed(columns, batch)
            return low, batch, None if heard is None else sum_heard(batch, heard)

    def _listed(self, columns: slice, batch: ColumnBatch) -> Heard | None:
        """The facets of the columns that echo; None where none does."""
        of, dr, count = self.mesh.device, self.mesh.device.dr, self.mesh.facets
        cells = (columns.stop - columns.start) * count
        lane = dr.arange(of.UInt32, cells + 1)  # one more: where a column would begin that follows the last
        rcs = dr.gather(of.Float, self.returns.rcs, lane + columns.start * count, lane < cells)  # 0 elsewhere
        echoes = rcs > 0.0
        before = dr.prefix_reduce(dr.ReduceOp.Add, dr.select(echoes, of.UInt32(1), of.UInt32(0)), exclusive=True)
        index = dr.compress(echoes)
        if dr.width(index) == 0:
            return None
        within, facet = index // count, index % count
        place, column = index + columns.start * count, index // count + columns.start
        begin, end = (of.dr.gather(of.UInt32, before, edge) for edge in self._edges(batch))
        strength = [of.Float(1.0)]
        if batch.speckle.streams.size > 1:
            share = dr.gather(of.Float, self.returns.breaking, place)
            strength = [dr.sqrt(1.0 - share), dr.sqrt(share)]
        made = Heard(within, facet, strength, self._paths(batch, within, column, facet, place, begin, end))
        dr.eval(
            [made.column, made.number, *made.strength, *(each for path in made.path for each in path)]
        )  # in one kernel
        return made

    def _edges(self, batch: ColumnBatch) -> list[Any]:
        """(column, gate): before which facet of the batch all lie, lit or dark, that a gate cannot hear of a column
        because they are too near; and from which on because they are too far."""
        of, grid, facets = self.mesh.device, self.mesh.grid, self.hearing.facets
        low, high = (edge - level for edge, level in zip(self.heights, _range(grid.column_height)[::-1], strict=True))
        deepest, flattest = max(abs(low), abs(high)), 0.0 if low <= 0.0 <= high else min(abs(low), abs(high))
        margin = support_m(batch) + float(np.linalg.norm(grid.antenna_positions, axis=-1).max())
        middle = batch.response.first_gate_m + gate_middles(batch)
        nearest = np.sqrt(np.maximum(np.maximum(middle - margin, 0.0) ** 2 - deepest**2, 0.0))
        farthest = np.sqrt(np.maximum((middle + margin) ** 2 - flattest**2, 0.0))
        begin = of.place(np.searchsorted(facets.distance, nearest).astype(np.uint32))
        end = of.place(np.searchsorted(facets.distance, farthest, side="right").astype(np.uint32))
        cell = of.dr.arange(of.UInt32, batch.columns.number.size * middle.size)
        start, gate = (cell // middle.size) * self.mesh.facets, cell % middle.size
        return [start + of.dr.gather(of.UInt32, each, gate) for each in (begin, end)]

    def _paths(
        self, batch: ColumnBatch, within: Any, column: Any, facet: Any, place: Any, begin: Any, end: Any
    ) -> list[OnPath]:
        """See `paths.facet_paths`, whose float64 this is: a facet's ranges are few numbers."""
        of, dr, grid = self.mesh.device, self.mesh.device.dr, self.mesh.grid

        def along(values: Any) -> Any:
            return dr.gather(of.Float64, values, facet)

        distance, ahead, aside = (along(each) for each in self._points)
        rise = self.mesh.height(column, facet) - dr.gather(of.Float64, self._levels, column)
        look, lift = self.mesh.velocities(column, facet)
        if self.returns.running is not None:
            look = look + dr.gather(of.Float, self.returns.running, place)
        look, lift = of.Float64(look), of.Float64(lift)
        square = distance * distance + rise * rise
        flow = look * distance + lift * rise

        def of_column(values: Any, row: int, number: int) -> Any:
            return dr.gather(of.Float64, values, column * row + number)

        ranges, longer, coming = list[Any](), list[Any](), list[Any]()
        antennas, first = grid.antenna_positions.shape[1], (of.Float64(0.0), of.Float64(0.0))
        for antenna in range(antennas):
            x, y, z = (of_column(self._antennas, 3 * antennas, 3 * antenna + axis) for axis in range(3))
            u, v, w = (of_column(self._drift, 3 * antennas, 3 * antenna + axis) for axis in range(3))
            towards, its_square = x * ahead + y * aside + z * rise, x * x + y * y + z * z
            ranges.append(dr.sqrt(square - 2.0 * towards + its_square))
            first = (its_square, towards) if antenna == 0 else first
            longer.append(((its_square - first[0]) - 2.0 * (towards - first[1])) / (ranges[antenna] + ranges[0]))
            against = u * ahead + v * aside + w * rise - (u * x + v * y + w * z)
            coming.append((flow - look * x - lift * z - against) / ranges[antenna])
        up = [of_column(self._up, 3, axis) for axis in range(3)]
        sine = (up[0] * ahead + up[1] * aside + up[2] * rise) / dr.sqrt(square)
        middle = dr.gather(of.Float64, of.place(middle_s(batch)), within)
        root = dr.sqrt(dr.gather(of.Float, self.returns.rcs, place))
        one_way = self._one_way(sine, ranges)
        bent = [self.light.bent(antenna, place) for antenna in range(antennas)]
        lit = [self.light.lights(antenna, place) for antenna in range(antennas)]
        made = []
        for (i, j), constant in zip(batch.geometry.antennas.tolist(), self._constants, strict=True):
            real, imag = dr.select(lit[i] & lit[j], root * one_way[i] * one_way[j] * constant, 0.0), None
            out, back = bent[i], bent[j]
            if out is not None and back is not None:
                bends = out[0] * back[0] - out[1] * back[1], out[0] * back[1] + out[1] * back[0]
                real, imag = real * bends[0], real * bends[1]
            rate = coming[i] + coming[j]
            made.append(on_path(batch, ranges[0], longer[i] + longer[j], rate, middle, real, imag, begin, end))
        return alike(batch, made)

    def _one_way(self, sine: Any, ranges: list[Any]) -> list[Any]:
        """Of each antenna: its cut in elevation over the range, float32, for direction cosines up the array."""
        of, dr = self.mesh.device, self.mesh.device.dr
        tables, which = elevation_tables(self.hearing.radar)
        steps = tables.shape[1] - 1
        position = (sine + 1.0) * (0.5 * steps)
        entry = of.UInt32(dr.clip(position, 0.0, steps - 1.0))
        beyond = of.Float(position - of.Float64(entry))
        cuts = []
        for table in self._cuts:
            low = dr.gather(of.Float, table, entry)
            cuts.append(low + beyond * (dr.gather(of.Float, table, entry + 1) - low))
        return [cuts[cut] / of.Float(away) for cut, away in zip(which, ranges, strict=True)]

    @cached_property
    def _cuts(self) -> list[Any]:
        return [self.mesh.device.place_single(table) for table in elevation_tables(self.hearing.radar)[0]]

    @cached_property
    def _constants(self) -> list[float]:
        """Of each path; see `receiver.amplitude_constant`."""
        radar = self.hearing.radar
        array = antenna_array(radar)
        gains = [np.sqrt(array.elements[i].antenna.gain * array.elements[j].antenna.gain) for i, j in array.paths]
        return [amplitude_constant(radar, float(gain)) for gain in gains]

    @cached_property
    def _points(self) -> tuple[Any, Any, Any]:
        """(facet,) m, distance, and how far ahead along the column and aside."""
        facets = self.hearing.facets
        parts = facets.distance, *(facets.distance * part(facets.angle) for part in (np.cos, np.sin))
        distance, ahead, aside = (self.mesh.device.place(each) for each in parts)
        return distance, ahead, aside

    @cached_property
    def _levels(self) -> Any:
        return self.mesh.device.place(self.mesh.grid.column_height[:, 0])

    @cached_property
    def _antennas(self) -> Any:
        return self.mesh.device.place(self.mesh.grid.antenna_positions)

    @cached_property
    def _drift(self) -> Any:
        return self.mesh.device.place(self.mesh.grid.drift)

    @cached_property
    def _up(self) -> Any:
        return self.mesh.device.place(self.mesh.grid.array_up)


def _range(values: NDArray[np.float64]) -> tuple[float, float]:
    return float(values.min()), float(values.max())


_NO_FACETS = ListedFacets(
    number=np.empty(0, dtype=np.intp),
    range_m=np.empty(0),
    difference_m=np.empty((1, 0)),
    radial_velocity=np.empty((1, 0)),
    amplitude=np.empty((1, 0), dtype=np.complex64),
)
