"""Travelling waves of a periodic lattice at any points and times: a B-spline over the grid and over time.

This is a non-uniform FFT with time as one more axis. The waves' amplitudes are divided by the B-spline's transform in
space and time; one FFT gives the spline's coefficients at each *knot*, a multiple of a fixed time step; a point then
takes the few coefficients around it in x, y and t. A value depends neither on the points evaluated with it nor on
the number of threads.

Slopes, rate, flow and shift are derivatives of the splines of a few functions (see `fields`). Those that follow from
the field's *base* by derivatives in time are taken from its spline.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import cache, cached_property, partial
from itertools import product
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from ..compute.machine import threads
from .fields import DERIVATIVES, Kind, Sums, Term, per_elevation, sums_of
from .knots import Knot, KnotCache, Strip
from .lattice import Lattice
from .spline import (
    TIME_ORDER,
    InterpolationError,
    bspline_polynomials,
    bspline_transform,
    exact_base,
    interpolation_error,
    longest_time_step,
)

Making = dict[Knot, Future[NDArray[np.float32]]]
Run = tuple[int, int, int]  # time interval, first and last + 1 of its points

TAPS = range((1 - TIME_ORDER) // 2, (TIME_ORDER + 3) // 2)  # the knots around an interval that its points take from
CACHE_BYTES = 400_000_000  # forty-eight knots of the default sea's one field; one turn takes eleven
_CHUNK = 1 << 14  # points per task
_ROWS = 64  # transformed at a time: few enough to stay in the cache
_NEARLY_ALL = 0.7  # of the rows: from here on a strip is no longer worth its while


class MovingField:
    """The spline of one lattice of waves, with a bounded cache of knots."""

    taps = TAPS

    def __init__(
        self,
        lattice: Lattice,
        amplitude: NDArray[np.complex128],
        variance: NDArray[np.float64],
        *,
        order: int = 5,
        oversampling: float = 1.5,
        time_step: float | None = None,
        base: Kind | None = None,
    ) -> None:
        """amplitude: of each wave (row, column) m; variance: what was expected of it, which fixes the time step.

        base: the field that others are to follow from, as far as that is exact enough; None: each has its own.
        """
        self.lattice = lattice
        self.order = order
        rows, columns = lattice.reach
        self.shape = (
            1 if lattice.line else grid_size(rows, oversampling, order),
            grid_size(columns, oversampling, order),
        )
        self._variance = lattice.fold(variance)
        self.base: Kind | None = exact_base(lattice, self._variance, base)
        self.time_step = time_step or longest_time_step(lattice, self._variance, self.base)
        self._ahead, self._behind = self._coefficient_amplitudes(amplitude)
        self._clear()

    def _clear(self) -> None:
        """Bring the field to its state before the first call."""
        self._cache = KnotCache()
        self._factors: dict[Kind, NDArray[np.complex64]] = {}

    @cached_property
    def error(self) -> InterpolationError:
        """Expected rms errors against the exact sum of waves."""
        return interpolation_error(self.lattice, self._variance, self.shape, self.order, self.time_step, base=self.base)

    def evaluate(
        self, x: NDArray[np.float64], y: NDArray[np.float64], t: NDArray[np.float64], terms: Sequence[Term]
    ) -> NDArray[np.float64]:
        """The terms at the points, (term, n). x, y in metres (y is ignored on a line), t in seconds, each (n,)."""
        once = list(dict.fromkeys(terms))
        if len(once) < len(terms):
            return self.evaluate(x, y, t, once)[[once.index(term) for term in terms]]
        knot_time = t / self.time_step
        x, y, knot_time = (np.require(value, requirements=("C", "W")) for value in (x, y, knot_time))
        interval = np.floor(knot_time).astype(np.int64)
        order = np.argsort(interval, kind="stable")
        in_order = interval[order]
        starts = np.flatnonzero(np.diff(in_order, prepend=in_order[:1] - 1)).tolist()
        runs: list[Run] = list(zip(in_order[starts].tolist(), starts, [*starts[1:], t.size], strict=True))
        result = np.empty((len(terms), t.size))
        sums = sums_of(terms, self.base, self._time_weights(), self.time_step)
        scale = np.prod(np.power(self._per_metre, DERIVATIVES), axis=1)  # derivatives then are those per metre
        kernel = _kernel(0 if self.lattice.line else self.order, self.order, len(self.taps))
        strip = self._strip_of(y)
        rows = strip.first, self.shape[0]

        def work(first: int, points: NDArray[np.int64], knots: Making, chosen: Sequence[Sums]) -> None:
            for each in chosen:
                grids = tuple(knots[first + tap, each.kind].result() for tap in self.taps)
                of_points = (x, y, knot_time), self._per_metre, rows, points
                kernel(grids, *of_points, each.lane_weights, scale, each.output_row, result)

        pool = _pool()
        # Fields that do not fit into memory together come one after the other.
        together = len(self.taps) * self._field_bytes(strip) * len(sums) <= 2 * CACHE_BYTES
        for chosen in [sums] if together else [[each] for each in sums]:
            for batch in self._batches(runs, len(chosen), strip):
                kinds: tuple[Kind, ...] = tuple(each.kind for each in chosen)
                wanted: list[Knot] = [
                    (number, kind)
                    for number in sorted({first + tap for first, _, _ in batch for tap in self.taps})
                    for kind in kinds
                ]
                making, tasks = self._knots(wanted, strip, pool), []
                for first, start, stop in batch:
                    for tap, kind in product(self.taps, kinds):  # the first points do not wait for the last knots
                        making[first + tap, kind].result()
                    tasks += [
                        pool.submit(work, first, order[at : min(at + _CHUNK, stop)], making, chosen)
                        for at in range(start, stop, _CHUNK)
                    ]
                for task in tasks:
                    task.result()
                self._cache.add({key: (strip, each.result()) for key, each in making.items()})
                del making, tasks  # before the next ones take memory
        return result

    @property
    def _per_metre(self) -> tuple[float, float]:
        """Grid points per metre, along rows and columns."""
        return self.shape[0] / self.lattice.length, self.shape[1] / self.lattice.length

    @cached_property
    def _whole(self) -> Strip:
        """All rows of a field at one knot, with the halo that the kernel asks for."""
        return Strip(0, self.shape[0] + (0 if self.lattice.line else self.order))

    @cached_property
    def _columns(self) -> int:
        """Columns of a field at one knot, with their halo."""
        from .spline_kernel import LANES

        return self.shape[1] + LANES - 1

    def _strip_of(self, y: NDArray[np.float64]) -> Strip:
        """The rows that points at these y (n,) m take from."""
        if self.lattice.line or not y.size:
            return self._whole
        rows, per_metre, order = self.shape[0], self._per_metre[0], self.order
        low = int(np.floor(y.min() * per_metre)) - (order - 1) // 2
        span = int(np.floor(y.max() * per_metre)) + (order + 1) // 2 + 1 - low
        if span > _NEARLY_ALL * rows:
            return self._whole
        first = low % rows // _ROWS * _ROWS
        end = low % rows + span
        over = 0 if end <= rows else rows
        count = over + min(-(-(end - over) // _ROWS) * _ROWS, rows) - first
        return Strip(first, count) if count <= rows else self._whole

    def _field_bytes(self, strip: Strip) -> int:
        """Size of one field at one knot."""
        return 4 * strip.count * self._columns

    def _batches(self, runs: list[Run], kinds: int, strip: Strip) -> Iterator[list[Run]]:
        """Runs of neighbouring intervals whose knots fit into memory together."""
        room = max(len(self.taps), CACHE_BYTES // (self._field_bytes(strip) * kinds))
        batch: list[Run] = []
        needed: set[int] = set()
        for run in runs:
            taken = {run[0] + tap for tap in self.taps}
            if batch and len(needed | taken) > room:
                yield batch
                batch, needed = [], set()
            batch.append(run)
            needed |= taken
        if batch:
            yield batch

    # ------------------------------------------------------------------------------------------------- knots

    def _knots(self, wanted: Sequence[Knot], strip: Strip, pool: ThreadPoolExecutor) -> Making:
        """A strip's coefficients at the given knots, from the cache or being made."""
        known = self._cache.take(wanted, strip, 4 * self._columns, CACHE_BYTES)
        making: Making = {}
        for key, (has, rows) in known.items():
            if (part := self._part(strip, has, rows)) is not None:
                making[key] = Future()
                making[key].set_result(part)
        self._cache.keep({key: known[key] for key in making})
        missing = [key for key in wanted if key not in making]
        states = {number: pool.submit(self._state_at, number) for number in sorted({number for number, _ in missing})}
        for number, kind in missing:
            making[number, kind] = pool.submit(self._coefficients, kind, states[number], strip)
        return making

    def _part(self, strip: Strip, has: Strip, rows: NDArray[np.float32]) -> NDArray[np.float32] | None:
        """A strip's rows from those of another, if they are there."""
        at = strip.place_in(has, self.shape[0])
        if at is not None:
            return rows[at]
        if has == self._whole:  # over the end of the grid
            return np.concatenate(
                (rows[strip.first : self.shape[0]], rows[: strip.first + strip.count - self.shape[0]])
            )
        return None

    _time_weights = staticmethod(partial(bspline_polynomials, TIME_ORDER, 3))  # of the knots around a time

    def _state_at(self, number: int) -> Any:
        """What the fields at a knot are made of: exp(−iωt) on the quadrant."""
        from .spline_kernel import phasor

        return phasor(self.lattice.omega, number * self.time_step)

    def _half_plane(self, kind: Kind, state: Any) -> NDArray[np.complex64]:
        """Fourier coefficients of a field at a knot, those of columns i ≥ 0, over the spline's transform.

        What makes the field of the elevation is the same for all directions, but for the sign of what is odd in time,
        as flow is: under a wave that runs the other way it is reversed. So those waves take the factor's conjugate.
        """
        from .spline_kernel import half_plane

        # A function, not an operator: that would multiply in place where it can, by a loop that rounds otherwise.
        factor = state if kind == "elevation" else np.multiply(state, self._per_elevation(kind))
        half = np.empty((self.shape[0], factor.shape[1]), dtype=np.complex64)
        half_plane(self._ahead, self._behind, factor, half)
        return half

    def _coefficients(self, kind: Kind, state: Future[Any], strip: Strip) -> NDArray[np.float32]:
        """The spline's coefficients of a field at a knot, in a strip, with their halo: by one real FFT."""
        half = self._half_plane(kind, state.result())
        half = np.asarray(scipy.fft.ifft(half, axis=0, norm="forward", overwrite_x=True))
        rows, columns = self.shape
        grid = np.empty((strip.count, self._columns), dtype=np.float32)
        for start in range(0, rows, _ROWS):
            part = slice(start, min(start + _ROWS, rows))
            to = (start - strip.first) % rows
            if to < strip.count:
                made = np.asarray(scipy.fft.irfft(half[part], n=columns, axis=1, norm="forward"))
                grid[to : to + len(made), :columns] = made
        if strip == self._whole:
            grid[rows:, :columns] = grid[: grid.shape[0] - rows, :columns]
        grid[:, columns:] = grid[:, : grid.shape[1] - columns]
        return grid

    @property
    def _rows(self) -> NDArray[np.int64]:
        """j of the rows in the order of an FFT: 0 … m, −m … −1."""
        most = self.lattice.reach[0]
        return np.concatenate((np.arange(most + 1), np.arange(-most, 0)))

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
        sharpen = (0.5 / transform)[np.abs(self._rows)]
        ahead = self._half(amplitude) * sharpen
        behind = self._half(np.conj(amplitude[::-1, ::-1])) * sharpen
        return ahead.astype(np.complex64), behind.astype(np.complex64)

    def _per_elevation(self, kind: Kind) -> NDArray[np.complex64]:
        """The field's amplitude per elevation on the quadrant, of a wave that runs along +k; made once: all threads use
        that of the first."""
        known = self._factors.get(kind)
        if known is None:
            made = per_elevation(kind, self.lattice, self.base).astype(np.complex64)
            known = self._factors.setdefault(kind, made)
        return known


def grid_size(reach: int, oversampling: float, order: int) -> int:
    """A size of small prime factors for the FFT, large enough for the waves and for the spline's support."""
    least = max(int(np.ceil(oversampling * (2 * reach + 2))), 2 * (order + 1))
    return int(scipy.fft.next_fast_len(least, real=True))  # type: ignore[arg-type]


@cache
def _kernel(row_order: int, column_order: int, time_taps: int) -> Callable[..., None]:
    from .spline_kernel import spline_kernel

    rows, columns = (bspline_polynomials(order).astype(np.float32) for order in (row_order, column_order))
    return spline_kernel(rows, columns, time_taps)


@cache
def _pool() -> ThreadPoolExecutor:
    """One for all: each new thread would take memory of its own from the allocator, and leave it there."""
    return ThreadPoolExecutor(threads())
