"""Travelling waves of a periodic lattice at any points and times: a B-spline over the grid and over time.

This is a non-uniform FFT with time as one more axis. The waves' amplitudes are divided by the B-spline's transform in
space and time; one FFT gives the spline's coefficients at each *knot*, a multiple of a fixed time step; a point then
takes the few coefficients around it in x, y and t. Elevation, slopes and rate are derivatives of one and the same
function, and its value depends neither on the points that are asked with it nor on the number of threads.
"""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from threading import Lock
from typing import Literal

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from .accuracy import TIME_ORDER, InterpolationError, interpolation_error, longest_time_step
from .dispersion import orbital_ratio
from .lattice import Lattice
from .spline import bspline_transform, bspline_weights, interpolation_matrix

Kind = Literal["elevation", "east", "north"]  # elevation [m], the water's horizontal velocity [m/s]
Knot = tuple[int, Kind]  # number of the time step, field
Run = tuple[int, int, int]  # time interval, first and last + 1 of its points

TAPS = (-1, 0, 1, 2)  # the knots around an interval that its points take from
CACHE_BYTES = 190_000_000  # six knots of the default sea
_CHUNK = 1 << 14  # points per task: their interpolation matrix stays in the processor's cache


@dataclass(frozen=True)
class Term:
    """What to evaluate: a field, and how often it is differentiated along rows (y), columns (x) and time."""

    kind: Kind
    row: int = 0
    column: int = 0
    time: int = 0


class MovingField:
    """The spline of one lattice of waves, with a bounded cache of knots."""

    def __init__(
        self,
        lattice: Lattice,
        amplitude: NDArray[np.complex128],
        variance: NDArray[np.float64],
        *,
        order: int = 3,
        oversampling: float = 1.5,
        time_step: float | None = None,
    ) -> None:
        """amplitude: of each wave (row, column) m; variance: what was expected of it, which fixes the time step."""
        self.lattice = lattice
        self.order = order
        rows, columns = lattice.reach
        self.shape = (
            1 if lattice.line else _grid_size(rows, oversampling, order),
            _grid_size(columns, oversampling, order),
        )
        self._variance = lattice.fold(variance)
        self.time_step = time_step or longest_time_step(lattice, self._variance)
        self._ahead, self._behind = self._coefficient_amplitudes(amplitude)
        self._cache: OrderedDict[Knot, NDArray[np.float32]] = OrderedDict()
        self._lock = Lock()

    @cached_property
    def error(self) -> InterpolationError:
        """Expected rms errors against the exact sum of waves."""
        return interpolation_error(self.lattice, self._variance, self.shape, self.order, self.time_step)

    def evaluate(
        self, x: NDArray[np.float64], y: NDArray[np.float64], t: NDArray[np.float64], terms: Sequence[Term]
    ) -> NDArray[np.float64]:
        """The terms at the points, (term, n). x, y in metres (y is ignored on a line), t in seconds, each (n,)."""
        result = np.empty((len(terms), t.size))
        knot_time = t / self.time_step
        interval = np.floor(knot_time).astype(np.int64)
        order = None if np.all(interval[1:] >= interval[:-1]) else np.argsort(interval, kind="stable")
        in_order = interval if order is None else interval[order]
        starts = np.flatnonzero(np.diff(in_order, prepend=in_order[:1] - 1))
        ends = [*starts[1:].tolist(), t.size]
        runs = [(int(in_order[a]), a, b) for a, b in zip(starts.tolist(), ends, strict=True)]
        kinds: tuple[Kind, ...] = tuple(dict.fromkeys(term.kind for term in terms))

        def work(first: int, start: int, stop: int, knots: dict[Knot, NDArray[np.float32]]) -> None:
            points = slice(start, stop) if order is None else order[start:stop]
            result[:, points] = self._at(x[points], y[points], knot_time[points] - first, first, terms, knots)

        def work_batch(batch: list[Run], pool: ThreadPoolExecutor) -> None:
            knots = self._knots(sorted({first + tap for first, _, _ in batch for tap in TAPS}), kinds, pool)
            tasks = [
                pool.submit(work, first, at, min(at + _CHUNK, stop), knots)
                for first, start, stop in batch
                for at in range(start, stop, _CHUNK)
            ]
            for task in tasks:
                task.result()

        with ThreadPoolExecutor(_threads()) as pool:
            for batch in self._batches(runs, len(kinds)):
                work_batch(batch, pool)
        return result

    @property
    def _field_bytes(self) -> int:
        """Size of one field at one knot."""
        return 4 * self.shape[0] * self.shape[1]

    def _batches(self, runs: list[Run], kinds: int) -> Iterator[list[Run]]:
        """Runs of neighbouring intervals whose knots fit into memory together."""
        room = max(4, CACHE_BYTES // (self._field_bytes * kinds))
        batch: list[Run] = []
        for run in runs:
            intervals = {first for first, _, _ in [*batch, run]}
            if len({first + tap for first in intervals for tap in TAPS}) > room and batch:
                yield batch
                batch = []
            batch.append(run)
        if batch:
            yield batch

    def _at(
        self,
        x: NDArray[np.float64],
        y: NDArray[np.float64],
        fraction: NDArray[np.float64],
        first: int,
        terms: Sequence[Term],
        knots: dict[Knot, NDArray[np.float32]],
    ) -> NDArray[np.float64]:
        """The terms at points of one time interval, from the four knots around it."""
        per_metre = tuple(count / self.lattice.length for count in self.shape)
        kinds: tuple[Kind, ...] = tuple(dict.fromkeys(term.kind for term in terms))
        in_time = {d: bspline_weights(TIME_ORDER, fraction, d) for d in {term.time for term in terms}}
        result = np.empty((len(terms), x.size))
        # Terms of one spatial derivative share a matrix; of these, terms of one field differ only in weights.
        for derivative in dict.fromkeys((term.row, term.column) for term in terms):
            matrix = interpolation_matrix(self.order, y * per_metre[0], x * per_metre[1], self.shape, derivative)
            for kind in kinds:
                alike = [
                    (i, term)
                    for i, term in enumerate(terms)
                    if (term.kind, term.row, term.column) == (kind, *derivative)
                ]
                values = [matrix @ knots[first + tap, kind] for tap in TAPS if alike]
                for index, term in alike:
                    scale = per_metre[0] ** term.row * per_metre[1] ** term.column / self.time_step**term.time
                    result[index] = scale * sum(w * v for w, v in zip(in_time[term.time], values, strict=True))
        return result

    # ------------------------------------------------------------------------------------------------- knots

    def _knots(
        self, numbers: Sequence[int], kinds: tuple[Kind, ...], pool: ThreadPoolExecutor
    ) -> dict[Knot, NDArray[np.float32]]:
        """Coefficients of the given knots, from the cache or made now; the cache then keeps the latest used."""
        wanted: list[Knot] = [(number, kind) for number in numbers for kind in kinds]
        with self._lock:
            found = {key: self._cache.pop(key) for key in wanted if key in self._cache}
            room = max(CACHE_BYTES // self._field_bytes, len(wanted))
            while len(self._cache) + len(wanted) > room:  # before the new ones take memory, not after
                self._cache.popitem(last=False)
        tasks = []
        for number in numbers:
            missing: tuple[Kind, ...] = tuple(kind for kind in kinds if (number, kind) not in found)
            if missing:
                tasks.append(pool.submit(self._make_knot, number, missing))
        for task in tasks:
            found.update(task.result())
        with self._lock:
            for key in wanted:
                self._cache[key] = found[key]
        return found

    def _make_knot(self, number: int, kinds: tuple[Kind, ...]) -> dict[Knot, NDArray[np.float32]]:
        """The spline's coefficients at one knot, by one real FFT for each field."""
        turned = self._turn(number * self.time_step)
        forward, backward = self._ahead * turned, self._behind * np.conj(turned)
        made: dict[Knot, NDArray[np.float32]] = {}
        if "elevation" in kinds:
            made[number, "elevation"] = self._to_grid(forward + backward)
        forward -= backward  # the flow under a wave that runs the other way is reversed
        for kind in kinds:
            if kind != "elevation":
                made[number, kind] = self._to_grid(forward * self._flow[kind])
        return made

    def _turn(self, time: float) -> NDArray[np.complex64]:
        """exp(−iωt) on the half-plane, the phase reduced in float64: 12 hours lose nothing."""
        turns = self.lattice.omega * (time / (2.0 * np.pi))
        turns -= np.rint(turns)
        phase = (turns * (-2.0 * np.pi)).astype(np.float32)
        quadrant = np.empty(phase.shape, dtype=np.complex64)
        np.cos(phase, out=quadrant.real)
        np.sin(phase, out=quadrant.imag)
        return quadrant[self._row_order()]

    def _row_order(self) -> NDArray[np.int64]:
        """|j| of the rows in the order of an FFT: 0 … m, −m … −1."""
        most = self.lattice.reach[0]
        return np.concatenate((np.arange(most + 1), np.arange(most, 0, -1)))

    def _half(self, whole: NDArray) -> NDArray:
        """The columns i ≥ 0 of a lattice array, its rows in the order of an FFT."""
        rows, columns = self.lattice.reach
        return np.concatenate((whole[rows:, columns:], whole[:rows, columns:]))

    def _coefficient_amplitudes(
        self, amplitude: NDArray[np.complex128]
    ) -> tuple[NDArray[np.complex64], NDArray[np.complex64]]:
        """½ a(k) and ½ a*(−k) on the half-plane, divided by the B-spline's transform in x, y and t."""
        rows, columns = self.lattice.reach
        transform = (
            bspline_transform(TIME_ORDER, self.lattice.omega * self.time_step / (2.0 * np.pi))
            * bspline_transform(self.order, np.arange(columns + 1) / self.shape[1])
            * bspline_transform(self.order, np.arange(rows + 1) / self.shape[0])[:, None]
        )
        sharpen = (0.5 / transform)[self._row_order()]
        ahead = self._half(amplitude) * sharpen
        behind = self._half(np.conj(amplitude[::-1, ::-1])) * sharpen
        return ahead.astype(np.complex64), behind.astype(np.complex64)

    @cached_property
    def _flow(self) -> dict[Kind, NDArray[np.float32]]:
        """ω coth(kh) k/|k| on the half-plane: horizontal velocity per elevation, east and north."""
        lattice = self.lattice
        k = lattice.quadrant(lambda k: np.where(k > 0.0, k, np.inf))
        speed = (lattice.omega * orbital_ratio(k, lattice.depth) / k)[self._row_order()]
        rows, columns = lattice.reach
        north = np.concatenate((lattice.north[rows:], lattice.north[:rows]))
        return {
            "east": (speed * lattice.east[columns:]).astype(np.float32),
            "north": (speed * north[:, None]).astype(np.float32),
        }

    def _to_grid(self, half: NDArray[np.complex64]) -> NDArray[np.float32]:
        """Real field of half-plane amplitudes on the oversampled grid, flattened."""
        most = self.lattice.reach[0]
        padded = np.zeros((self.shape[0], half.shape[1]), dtype=np.complex64)
        padded[: most + 1] = half[: most + 1]
        padded[self.shape[0] - most :] = half[most + 1 :]
        columns = scipy.fft.ifft(padded, axis=0, norm="forward", overwrite_x=True)
        return np.asarray(scipy.fft.irfft(columns, n=self.shape[1], axis=1, norm="forward")).ravel()


def _grid_size(reach: int, oversampling: float, order: int) -> int:
    """A size that FFTs like, large enough for the waves and for the spline's support."""
    least = max(int(np.ceil(oversampling * (2 * reach + 2))), 2 * (order + 1))
    return int(scipy.fft.next_fast_len(least, real=True))  # type: ignore[arg-type]


def _threads() -> int:
    return min(16, len(os.sched_getaffinity(0)))
