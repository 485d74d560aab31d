"""The voltages of every pulse of one turn, as its receivers give them.

    V(p, rx, g) = Σ_columns Σ_facets E(beam − facet) a h(r_g − R) s(t) exp(−jk(R_tx + R_rx)(t))

While the beam passes a column (30 ms) a facet moves by centimetres: its range response stays, its phase turns at the
rate of its radial velocity, its speckle s(t) decorrelates, or turns by itself where its scatterers move relative to the
water. The echo is band-limited in slow time: rotation of the aperture, Doppler and speckle together span some ±500 Hz,
far less than the PRF. So the sum is formed at *knots* a few pulses apart, and the pulses between are interpolated by a
windowed sinc.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from ..compute.lanes import LANES
from ..conventions import unit_from_azimuth
from ..mesh import Facets
from ..radar.array import antenna_array
from ..radar.mast import column_frame
from ..radar.scan import Pulses
from ..settings import RadarSettings
from ..tracing import Illumination
from .beams import TwoWayBeams, two_way_beams
from .column_kernel import add_columns
from .gating import Tabulated, tabulated
from .knots import Knots, choose_knots, knots_first, pulses_from_knots
from .motion import Motion, MovingSpeckle
from .paths import FacetPaths, facet_paths, wavenumber
from .receiving import Received, receive
from .speckle import StillSpeckle, speckle_basis

_CHUNK = 16  # columns worked on at a time: their sums stay near the cache

Beam = tuple[Any, ...]


def turn_voltages(
    facets: Illumination,
    rcs: NDArray[np.float32],
    radar: RadarSettings,
    pulses: Pulses,
    seed: int,
    decorrelation_time_s: float,
    workers: int = 2,
    motion: Motion | None = None,
) -> NDArray[np.complex64]:
    """Voltages (pulse, receiver, gate) [√W] of one turn; see `turn_echoes`."""
    return turn_echoes(facets, rcs, radar, pulses, seed, decorrelation_time_s, workers, motion).voltage


def turn_echoes(
    facets: Illumination,
    rcs: NDArray[np.float32],
    radar: RadarSettings,
    pulses: Pulses,
    seed: int,
    decorrelation_time_s: float,
    workers: int = 2,
    motion: Motion | None = None,
    further: NDArray[np.complex64] | None = None,
) -> Received:
    """What the receivers give in one turn, speckle and (if radar.noise) thermal noise included.

    rcs (column, facet) [m²]. motion: of the scatterers relative to the water; without it they go where the water goes.
    further: voltages (pulse, receiver, sample) of other scatterers, to be added before the receiver. Receivers that the
    mode does not sample on a pulse are NaN. The same seed gives the same bits for any number of workers.
    Raises ValueError if motion is not of these facets.
    """
    if motion is not None:
        motion.check(facets)
    heard = tabulated(radar)
    knots = choose_knots(facets, radar, pulses, decorrelation_time_s, motion)
    reach = _reach_s(facets, pulses)
    window = int(np.floor(2.0 * reach / knots.spacing_s)) + 1 if np.isfinite(reach) else knots.count
    if motion is None:
        speckle = StillSpeckle(speckle_basis(window, knots.spacing_s, decorrelation_time_s), seed)
    else:
        k = wavenumber(radar)
        speckle = MovingSpeckle.over(window, knots.spacing_s, k, decorrelation_time_s, motion, seed)
    across = pulses.mast.pose(knots.time).axes[:, 0]
    sums = ColumnSums(facets, rcs, radar, heard, knots, window, reach, speckle, two_way_beams(radar), across)

    total = np.zeros((2, len(antenna_array(radar).paths), heard.samples.range.size, knots.count), dtype=np.float32)
    edges = [*range(0, facets.grid.columns, _CHUNK), facets.grid.columns]
    chunks = [slice(a, b) for a, b in pairwise(edges)]
    # BLAS's own threads would fight with ours over small products, and could change the bits.
    with threadpool_limits(1, user_api="blas"), ThreadPoolExecutor(workers) as pool:
        # Chunks are added in their own order, whoever finishes first: the sum keeps its bits.
        for start, part in pool.map(sums, chunks):
            low, high = max(start, 0), min(start + part.shape[-1], knots.count)
            if high > low:
                total[..., low:high] += part[..., low - start : high - start]
    echo = knots_first(total, workers)
    if heard.samples.compress is not None:
        echo = np.ascontiguousarray(heard.samples.compress(echo), dtype=np.complex64)
    voltages = pulses_from_knots(echo, knots, radar, pulses, workers)
    return receive(voltages, radar, pulses, seed, workers, further)


def _reach_s(facets: Facets, pulses: Pulses) -> float:
    """Seconds to either side of the time when the boresight passes a column, within which the beam hears of it; all of
    them for a staring antenna."""
    rate, grid = pulses.mast.rate, facets.grid
    if rate == 0.0:
        return np.inf
    slowest = grid.spacing_deg / float(
        np.diff(grid.time).max()
    )  # a boat that yaws against the turntable slows the beam
    return grid.reach_deg / (slowest if slowest < rate * (1.0 - 1e-6) else rate)


@dataclass(frozen=True)
class ColumnSums:
    """Sums the facets of some columns into gates, at the knots at which the beam passes them."""

    facets: Illumination
    rcs: NDArray[np.float32]
    radar: RadarSettings
    tabulated: Tabulated
    knots: Knots
    window: int
    reach_s: float
    speckle: StillSpeckle | MovingSpeckle
    beams: TwoWayBeams
    across: NDArray[np.float64]  # (knot, 3) the aperture's axis in the world

    def __call__(self, columns: slice) -> tuple[int, NDArray[np.float32]]:
        """First knot's number and the columns' sum (part, path, gate, knot), part being real and imaginary."""
        passing = self.facets.grid.column_pose.time[columns]
        first = np.zeros(passing.size, dtype=int)
        if np.isfinite(self.reach_s):
            first = np.ceil((passing - self.reach_s - self.knots.time[0]) / self.knots.spacing_s).astype(int)
        heard = first[:, None] + np.arange(self.window)  # may lie before the first knot, or after the last
        seconds = self.knots.time[0] + heard * self.knots.spacing_s - passing[:, None]
        low = int(first.min())
        column, facet = np.nonzero(self.rcs[columns])
        chosen = column + columns.start, facet
        paths = facet_paths(self.facets, self.rcs, self.radar, columns, chosen=chosen)
        modes, of_first = self._modes(columns, seconds[:, 0])
        gates = self.tabulated.samples.range
        # Behind the last knot there is room for a group of lanes.
        knots = int(first.max()) - low + modes.shape[-1]
        out = np.zeros((2, len(paths.paths), gates.size, knots), np.float32)
        apart = float(gates[1] - gates[0]) if gates.size > 1 else 1.0
        add_columns(
            np.searchsorted(column, np.arange(passing.size + 1)),
            first - low,
            self.window,
            facet,
            self.speckle.streams,
            self.facets.grid.column_number[columns],
            (modes, of_first, self.speckle.strengths(chosen)),
            self._geometry(paths, seconds[:, 0]),
            paths.amplitude.astype(np.complex64, copy=False),
            (self.tabulated.response, 1.0 / self.tabulated.step, float(gates[0]), apart),
            self._beam(columns, np.clip(heard, 0, self.knots.count - 1)),  # what lies outside is dropped later
            out,
        )
        return low, out

    def _modes(self, columns: slice, begin: NDArray[np.float64]) -> tuple[NDArray[np.float32], int]:
        """Modes (column, part, mode, knot), the knots padded to whole groups of lanes, and how many are of the first
        kind."""
        kinds = self.speckle.modes(columns, begin)
        modes = np.concatenate(kinds, axis=1)
        whole = -(-self.window // LANES) * LANES
        padded = np.zeros((columns.stop - columns.start, 2, modes.shape[1], whole), dtype=np.float32)
        padded[:, 0, :, : self.window], padded[:, 1, :, : self.window] = modes.real, modes.imag
        return padded, kinds[0].shape[1]

    def _geometry(self, paths: FacetPaths, begin: NDArray[np.float64]) -> tuple[Any, ...]:
        """Pairs of antennas and how far and fast their paths grow, as `add_columns` takes it."""
        pairs, moving = np.array(paths.paths), (paths.range[0], paths.difference, paths.coming)
        return pairs, begin, *moving, wavenumber(self.radar), self.knots.spacing_s

    def _beam(self, columns: slice, knots: NDArray[np.intp]) -> Beam:
        """The beam towards each column's mean sea at the range of each gate, as `add_columns` takes it."""
        grid = self.facets.grid
        east, north = unit_from_azimuth(grid.column_azimuth[columns])
        across = self.across[knots]
        along = across[..., 0] * east[:, None] + across[..., 1] * north[:, None]
        # Where the fan leans, what lies deeper below is heard off the bearing.
        height = grid.column_height[columns] / self.radar.height_m
        # A boat that runs past what it looks at sees it for shorter, or longer, than one at rest.
        drift = np.einsum("ci,cij->cj", grid.drift[columns].mean(axis=1), column_frame(grid.column_azimuth[columns]))
        seconds = self.knots.time[knots] - grid.column_pose.time[columns, None]
        past = np.einsum("cki,ci->ck", across, drift) * seconds
        inverse_range = 1.0 / np.maximum(self.tabulated.samples.range, self.radar.height_m)
        beams, drop = self.beams, self.radar.height_m * inverse_range
        level = np.sqrt(1.0 - drop**2)
        return beams.tables, beams.scale, beams.aside, level, drop, inverse_range, along, across[..., 2] * height, past
