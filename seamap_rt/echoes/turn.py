"""The voltages of every pulse of one turn, as its receivers give them.

    V(p, rx, g) = Σ_columns Σ_facets E(beam − facet) a h(r_g − R) s(t) exp(−jk(R_tx + R_rx)(t))

While the beam passes a column (30 ms) a facet moves by centimetres: its range response stays, its phase advances at
the rate of its radial velocity, and its speckle s(t) decorrelates, with a Doppler shift of its own where its scatterers
move relative to the water. The echo is band-limited in slow time: rotation of the aperture, Doppler and speckle
together span some ±500 Hz, far less than the PRF. So the sum is formed at *nodes* a few pulses apart, and the pulses
between follow from them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled
from ..compute.machine import one_blas_thread, pool
from ..conventions import radar_wavenumber, unit_from_azimuth
from ..mesh import Facets
from ..radar.installation import Installation, column_frame
from ..radar.scan import BEAMS_BEYOND, Pulses
from ..tracing import Illumination
from .paths import facet_paths
from .receiving import ReceivedTurn, receive
from .response import ResponseTable, TwoWayBeams, beam_truncation, tabulated, two_way_beams
from .slow_time import Nodes, choose_nodes, nodes_first, pulses_from_nodes
from .speckle import BeamWindow, Motion, MovingSpeckle, SpeedBounds, StillSpeckle, speckle_basis, speckle_truncation
from .summation import (
    BATCH_COLUMNS,
    Beam,
    ColumnBatch,
    Columns,
    Geometry,
    ListedFacets,
    RangeTable,
    Speckle,
    sum_columns,
)

T = TypeVar("T")
Sums = Callable[[slice], tuple[int, NDArray[np.float32]]]  # of columns: first node's number and their sum


def turn_voltages(
    facets: Illumination,
    rcs: NDArray[np.float32],
    installation: Installation,
    pulses: Pulses,
    seed: int,
    decorrelation_time_s: float,
    motion: Motion | None = None,
) -> NDArray[np.complex64]:
    """Voltages (pulse, receiver, gate) [√W] of one turn; see `turn_echoes`."""
    return turn_echoes(facets, rcs, installation, pulses, seed, decorrelation_time_s, motion).voltage


def turn_echoes(
    facets: Illumination,
    rcs: NDArray[np.float32],
    installation: Installation,
    pulses: Pulses,
    seed: int,
    decorrelation_time_s: float,
    motion: Motion | None = None,
    objects: NDArray[np.complex64] | None = None,
    neglected: float = 0.0,
) -> ReceivedTurn:
    """What the receivers record in one turn, with speckle and (if radar.noise) thermal noise.

    rcs (column, facet) [m²]; decorrelation_time_s: τc of the speckle, may be infinite; motion: of the scatterers
    relative to the water, none if left out; objects: voltages (pulse, receiver, sample) [√W] of the scene's objects,
    added before the receiver; neglected: share of the power that may be left out aside, as much in range and as much
    between slow-time nodes (`truncation_share`). Receivers that the mode does not sample on a pulse are NaN.
    The same seed gives the same bits for any number of threads. Raises ValueError if motion does not fit the facets.
    """
    if motion is not None:
        motion.check(facets)
    hearing = ReceiveGeometry.of(facets, installation, pulses, seed, decorrelation_time_s, motion, neglected)
    total = hearing.total(ColumnSums(hearing, facets, rcs), BATCH_COLUMNS)
    return received(total, hearing, pulses, seed, objects)


def received(
    total: NDArray[np.float32],
    hearing: ReceiveGeometry,
    pulses: Pulses,
    seed: int,
    objects: NDArray[np.complex64] | None = None,
) -> ReceivedTurn:
    """What the receivers record, from the sums (component, path, sample, node) of a turn; see `turn_echoes`."""
    echo, compress = nodes_first(total), hearing.tabulated.samples.compress
    if compress is not None:
        echo = np.ascontiguousarray(compress(echo), dtype=np.complex64)
    voltages = pulses_from_nodes(echo, hearing.nodes, hearing.installation.array, pulses)
    return receive(voltages, hearing.installation, pulses, seed, objects)


def _reach_s(facets: Facets, pulses: Pulses, reach_deg: float) -> float:
    """Seconds to either side of the time when the boresight passes a column, within which the beam, so far to either
    side, hears of it; all of them for a staring antenna."""
    rate, grid = pulses.installation.rate, facets.grid
    if rate == 0.0:
        return np.inf
    # A boat that yaws against the turntable slows the beam.
    slowest = grid.spacing_deg / float(np.diff(grid.time).max())
    return reach_deg / (slowest if slowest < rate * (1.0 - 1e-6) else rate)


def peak_gate_voltage(
    beams: TwoWayBeams, turned_deg: NDArray[np.float64], across: NDArray[np.float64], height_m: float, nearest_m: float
) -> NDArray[np.float64]:
    """Voltage (node,) of the beam, over its peak's, towards the gate of a column that hears best when the boresight has
    turned so far past it: a fan that leans, and antennas aside, hear near gates off the bearing."""
    drop = height_m / nearest_m
    off = drop * float(np.abs(across[:, 2]).max()) + float(np.abs(beams.aside).max()) / nearest_m
    level = np.sqrt(1.0 - drop**2)
    cosine = level * np.sin(np.radians(np.minimum(np.abs(turned_deg), 90.0)))
    return beams.voltage_bound(np.maximum(cosine - off, 0.0))


@dataclass(frozen=True)
class ReceiveGeometry:
    """How the radar hears the columns of a turn: at which nodes, through which gates and beams, with what speckle."""

    facets: Facets  # of which only where columns and antennas are is asked
    installation: Installation
    tabulated: ResponseTable
    nodes: Nodes
    window: int
    reach_s: float
    beam_window: BeamWindow
    speckle: StillSpeckle | MovingSpeckle
    beams: TwoWayBeams
    across: NDArray[np.float64]  # (node, 3) the aperture's axis in the world

    @classmethod
    def of(
        cls,
        facets: Facets,
        installation: Installation,
        pulses: Pulses,
        seed: int,
        decorrelation_time_s: float,
        motion: Motion | None,
        neglected: float = 0.0,
        fastest: SpeedBounds | None = None,
    ) -> ReceiveGeometry:
        """See `turn_echoes`. fastest: how fast the facets are, where that is known already, and whether any break."""
        radar = installation.radar
        nodes = choose_nodes(facets, radar, pulses, decorrelation_time_s, motion, fastest, neglected)
        beams = beam_truncation(radar, neglected)
        reach_deg = facets.grid.reach_deg - (BEAMS_BEYOND - beams) * installation.array.beam_deg
        reach = _reach_s(facets, pulses, reach_deg)
        window = int(np.floor(2.0 * reach / nodes.spacing_s)) + 1 if np.isfinite(reach) else nodes.count
        across = pulses.installation.pose(nodes.time).axes[:, 0]
        tables, samples = two_way_beams(radar), tabulated(radar, neglected)
        beam_window = BeamWindow(None, speckle_truncation(neglected))
        if np.isfinite(reach):
            turned = reach_deg / reach * nodes.spacing_s * (np.arange(window, dtype=np.float64) - 0.5 * (window - 1))
            nearest = max(float(samples.samples.range[0]), radar.height_m)
            beam_window = beam_window.with_beam(peak_gate_voltage(tables, turned, across, radar.height_m, nearest))
        if motion is None:
            speckle = StillSpeckle(speckle_basis(window, nodes.spacing_s, decorrelation_time_s, beam_window), seed)
        else:
            breaks = None if fastest is None else fastest.breakers is not None
            k = radar_wavenumber(radar.frequency_hz)
            speckle = MovingSpeckle.of(
                window, nodes.spacing_s, k, decorrelation_time_s, motion, seed, breaks, beam_window
            )
        return cls(facets, installation, samples, nodes, window, reach, beam_window, speckle, tables, across)

    def total(self, sums: Sums, columns: int) -> NDArray[np.float32]:
        """The sum (component, path, sample, node) over all columns, so many at a time."""
        paths, samples = len(self.installation.array.paths), self.tabulated.samples.range.size
        total = np.zeros((2, paths, samples, self.nodes.count), dtype=np.float32)
        for start, chunk in self.map_in_order(sums, columns):
            low, high = max(start, 0), min(start + chunk.shape[-1], self.nodes.count)
            if high > low:
                total[..., low:high] += chunk[..., low - start : high - start]
        return total

    def map_in_order(self, work: Callable[[slice], T], columns: int) -> Iterator[T]:
        """Results of `work` on all columns, so many at a time by several threads, in the columns' order: sums of them
        keep their bits."""
        edges = [*range(0, self.facets.grid.columns, columns), self.facets.grid.columns]
        chunks = [slice(a, b) for a, b in pairwise(edges)]
        with one_blas_thread(), pool() as workers:
            yield from workers.map(work, chunks)

    def batch(
        self,
        columns: slice,
        first_facet: NDArray[np.intp],
        facets: ListedFacets,
        strength: NDArray[np.float32],
    ) -> tuple[int, ColumnBatch]:
        """Some columns to be summed, with the facets that echo and their (facet, kind) strengths; and the number of the
        node from which the batch's are counted."""
        passing = self.facets.grid.column_pose.time[columns]
        first = np.zeros(passing.size, dtype=int)
        if np.isfinite(self.reach_s):
            first = np.ceil((passing - self.reach_s - self.nodes.time[0]) / self.nodes.spacing_s).astype(int)
        node = first[:, None] + np.arange(self.window)  # may lie before the first node, or after the last
        seconds = self.nodes.time[0] + node * self.nodes.spacing_s - passing[:, None]
        low = int(first.min())
        paths = np.array(self.installation.array.paths)
        kinds = self.speckle.modes(columns, seconds[:, 0])
        return low, ColumnBatch(
            window=self.window,
            nodes=int(first.max()) - low + self.window,
            columns=Columns(
                number=self.facets.grid.column_number[columns],
                first_facet=first_facet,
                first_node=first - low,
                begin_s=np.ascontiguousarray(seconds[:, 0]),
            ),
            facets=facets,
            speckle=Speckle(
                streams=self.speckle.streams,
                modes=np.ascontiguousarray(np.concatenate(kinds, axis=1)),
                first_kind_modes=kinds[0].shape[1],
                strength=strength,
            ),
            geometry=Geometry(paths, radar_wavenumber(self.installation.radar.frequency_hz), self.nodes.spacing_s),
            response=self._response,
            beam=self._beam(columns, np.clip(node, 0, self.nodes.count - 1)),  # what lies outside is dropped later
        )

    @cached_property
    def _response(self) -> RangeTable:
        gates = self.tabulated.samples.range
        spacing = float(gates[1] - gates[0]) if gates.size > 1 else 1.0
        return RangeTable(self.tabulated.response, 1.0 / self.tabulated.step, float(gates[0]), spacing)

    def _beam(self, columns: slice, nodes: NDArray[np.intp]) -> Beam:
        """The beam towards each column's mean sea at the range of each gate, at nodes (column, node)."""
        grid = self.facets.grid
        east, north = unit_from_azimuth(grid.column_azimuth[columns])
        across = self.across[nodes]
        # Where the fan leans, what lies deeper below is heard off the bearing.
        height = grid.column_height[columns] / self.installation.radar.height_m
        # A boat that runs past what it looks at sees it for shorter, or longer, than one at rest.
        drift = np.einsum("ci,cij->cj", grid.drift[columns].mean(axis=1), column_frame(grid.column_azimuth[columns]))
        seconds = self.nodes.time[nodes] - grid.column_pose.time[columns, None]
        level, drop, inverse_range = self._depression
        return Beam(
            table=self.beams.tables,
            entries_per_cosine=self.beams.scale,
            aside_m=self.beams.aside,
            level=level,
            drop=drop,
            inverse_range=inverse_range,
            along=across[..., 0] * east[:, None] + across[..., 1] * north[:, None],
            up=across[..., 2] * height,
            past_m=np.einsum("cki,ci->ck", across, drift) * seconds,
        )

    @cached_property
    def _depression(self) -> tuple[NDArray[np.float64], ...]:
        """(gate,) cosine and sine of the depression of the mean sea, and 1/m of its range."""
        inverse_range = 1.0 / np.maximum(self.tabulated.samples.range, self.installation.radar.height_m)
        drop = self.installation.radar.height_m * inverse_range
        return np.sqrt(1.0 - drop**2), drop, inverse_range


@dataclass(frozen=True)
class ColumnSums:
    """Sums the facets of some columns into gates, at the nodes at which the beam passes them."""

    hearing: ReceiveGeometry
    facets: Illumination
    rcs: NDArray[np.float32]

    def __call__(self, columns: slice) -> tuple[int, NDArray[np.float32]]:
        """First node's number and the columns' sum (component, path, gate, node), real and imaginary."""
        first, column, facet = _echoing(self.rcs, columns.start, columns.stop)
        paths = facet_paths(self.facets, self.rcs, self.hearing.installation, columns, chosen=(column, facet))
        listed = ListedFacets(
            number=facet,
            range_m=paths.range[0],
            difference_m=paths.difference,
            radial_velocity=paths.coming,
            amplitude=paths.amplitude.astype(np.complex64, copy=False),
        )
        strengths = self.hearing.speckle.strengths((column, facet))
        low, batch = self.hearing.batch(columns, first, listed, strengths)
        return low, sum_columns(batch)


@compiled
def _echoing(rcs, start, stop):
    """Of the columns from `start` to `stop`: where each one's facets begin that echo (column + 1,), and the numbers
    (n,) of their columns and their own. rcs (column, facet) m²."""
    first, facets = np.zeros(stop - start + 1, np.intp), rcs.shape[1]
    column, facet = np.empty((stop - start) * facets + 1, np.intp), np.empty((stop - start) * facets + 1, np.intp)
    count = 0
    for c in range(start, stop):
        for f in range(facets):  # without a branch, which would be guessed wrong at every edge of a shadow
            column[count], facet[count] = c, f
            count += np.intp(rcs[c, f] != 0.0)
        first[c - start + 1] = count
    return first, column[:count].copy(), facet[:count].copy()
