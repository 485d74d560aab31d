"""Travelling waves of a periodic lattice at any points and times: a B-spline over the grid and over time.

This is a non-uniform FFT with time as one more axis. The waves' amplitudes are divided by the B-spline's transform in
space and time; one FFT gives the spline's coefficients at each *knot*, a multiple of a fixed time step; a point then
takes the few coefficients around it in x, y and t. A value depends neither on the points evaluated with it nor on
the number of threads.

Three functions hold all of first-order waves (Airy 1845): the elevation η = Re Σ a e^{iθ}, θ = k·x − ωt; χ = Re Σ a
coth(kh)/k e^{iθ}, whose gradient is the horizontal displacement of the water at the surface; and Φ = ∂χ/∂t, the
velocity potential there, whose gradient is the horizontal flow. Slopes, rate, flow and shift are derivatives of their
splines. A fourth, ψ with ∂ψ/∂t + μ ψ = Φ, is the shift that acts on waves which relax at the rate μ (see `Relaxed`).
"""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache, cached_property, partial
from threading import Lock
from typing import Any, Literal

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from ..compute.machine import threads
from ..physics.dispersion import orbital_ratio
from .accuracy import TIME_ORDER, InterpolationError, interpolation_error, longest_time_step
from .lattice import Lattice
from .spline import bspline_polynomials, bspline_transform


@dataclass(frozen=True)
class Relaxed:
    """The field ψ [m²] with ∂ψ/∂t + rate ψ = Φ; its gradient is what short waves that the flow carries along, and that
    relax at the rate [1/s], have been moved by (Alpers & Hasselmann 1978). At rate 0 it is χ."""

    rate: float


Kind = Literal["elevation", "potential", "shift"] | Relaxed  # η [m], Φ [m²/s], χ [m²], ψ [m²]
Knot = tuple[int, Kind]  # number of the time step, field
Coefficients = dict[Knot, NDArray[np.float32]]
Run = tuple[int, int, int]  # time interval, first and last + 1 of its points

TAPS = range((1 - TIME_ORDER) // 2, (TIME_ORDER + 3) // 2)  # the knots around an interval that its points take from
CACHE_BYTES = 400_000_000  # twelve knots of three fields of the default sea; one turn takes ten
_REMEMBERED = 8  # calls, some two turns of them: a knot that none of them used is of a past time
_CHUNK = 1 << 14  # points per task
_ROWS = 64  # transformed at a time: few enough to stay in the cache


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
        order: int = 5,
        oversampling: float = 1.5,
        time_step: float | None = None,
    ) -> None:
        """amplitude: of each wave (row, column) m; variance: what was expected of it, which fixes the time step."""
        self.lattice = lattice
        self.order = order
        rows, columns = lattice.reach
        self.shape = (
            1 if lattice.line else grid_size(rows, oversampling, order),
            grid_size(columns, oversampling, order),
        )
        self._variance = lattice.fold(variance)
        self.time_step = time_step or longest_time_step(lattice, self._variance)
        self._ahead, self._behind = self._coefficient_amplitudes(amplitude)
        self._cache: OrderedDict[Knot, NDArray[np.float32]] = OrderedDict()
        self._recent: deque[frozenset[Knot]] = deque(maxlen=_REMEMBERED)
        self._lock = Lock()
        self._factors: dict[Kind, NDArray[np.complex64]] = {}

    @cached_property
    def error(self) -> InterpolationError:
        """Expected rms errors against the exact sum of waves."""
        return interpolation_error(self.lattice, self._variance, self.shape, self.order, self.time_step)

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
        sums = self._sums(terms)

        def work(first: int, points: NDArray[np.int64], knots: Coefficients) -> None:
            for kind, kernel, scale, output_row in sums:
                grids = tuple(knots[first + tap, kind] for tap in TAPS)
                kernel(grids, x, y, knot_time, self._per_metre, points, scale, output_row, result)

        pool = _pool()
        for batch in self._batches(runs, len(sums)):
            numbers = sorted({first + tap for first, _, _ in batch for tap in TAPS})
            knots = self._knots(numbers, tuple(kind for kind, *_ in sums), pool)
            tasks = [
                pool.submit(work, first, order[at : min(at + _CHUNK, stop)], knots)
                for first, start, stop in batch
                for at in range(start, stop, _CHUNK)
            ]
            for task in tasks:
                task.result()
        return result

    def _sums(self, terms: Sequence[Term]) -> list[tuple[Kind, Callable, NDArray[np.float64], NDArray[np.int64]]]:
        """For each field: its kernel, and the scale and output row of each of its derivatives."""
        from .spline_kernel import DERIVATIVES  # numba takes half a second to import: only where it is used

        sums = []
        for kind in dict.fromkeys(term.kind for term in terms):
            output_row = np.full(len(DERIVATIVES), -1)
            for index, term in enumerate(terms):
                if term.kind == kind:
                    output_row[DERIVATIVES.index((term.row, term.column, term.time))] = index
            most = max(term.row + term.column for term in terms if term.kind == kind)
            steps = (*self._per_metre, 1.0 / self.time_step)
            scale = np.prod(np.power(steps, DERIVATIVES), axis=1)
            kernel = _kernel(0 if self.lattice.line else self.order, self.order, most, self._time_weights)
            sums.append((kind, kernel, scale, output_row))
        return sums

    @property
    def _per_metre(self) -> tuple[float, float]:
        """Grid points per metre, along rows and columns."""
        return self.shape[0] / self.lattice.length, self.shape[1] / self.lattice.length

    @cached_property
    def _grid_shape(self) -> tuple[int, int]:
        """Rows and columns of a field at one knot, with the halo that the kernel asks for."""
        from ..compute.lanes import LANES

        return self.shape[0] + (0 if self.lattice.line else self.order), self.shape[1] + LANES - 1

    @property
    def _field_bytes(self) -> int:
        """Size of one field at one knot."""
        return 4 * self._grid_shape[0] * self._grid_shape[1]

    def _batches(self, runs: list[Run], kinds: int) -> Iterator[list[Run]]:
        """Runs of neighbouring intervals whose knots fit into memory together."""
        room = max(len(TAPS), CACHE_BYTES // (self._field_bytes * kinds))
        batch: list[Run] = []
        needed: set[int] = set()
        for run in runs:
            taken = {run[0] + tap for tap in TAPS}
            if batch and len(needed | taken) > room:
                yield batch
                batch, needed = [], set()
            batch.append(run)
            needed |= taken
        if batch:
            yield batch

    # ------------------------------------------------------------------------------------------------- knots

    def _knots(self, numbers: Sequence[int], kinds: tuple[Kind, ...], pool: ThreadPoolExecutor) -> Coefficients:
        """Coefficients of the given knots, from the cache or made now; the cache then keeps the latest used."""
        wanted: list[Knot] = [(number, kind) for number in numbers for kind in kinds]
        with self._lock:
            coefficients = {key: self._cache.pop(key) for key in wanted if key in self._cache}
            self._recent.append(frozenset(wanted))
            for key in self._cache.keys() - set().union(*self._recent):
                del self._cache[key]
            room = max(CACHE_BYTES // self._field_bytes, len(wanted))
            while len(self._cache) + len(wanted) > room:  # before the new ones take memory, not after
                self._cache.popitem(last=False)
        missing = [key for key in wanted if key not in coefficients]
        new = sorted({number for number, _ in missing})
        states = dict(zip(new, pool.map(self._state_at, new), strict=True))
        made = pool.map(lambda key: self._coefficients(key[1], states[key[0]]), missing)
        coefficients.update(zip(missing, made, strict=True))
        with self._lock:
            for key in wanted:
                self._cache[key] = coefficients[key]
        return coefficients

    _time_weights = staticmethod(partial(bspline_polynomials, TIME_ORDER))  # of the knots around a time

    def _state_at(self, number: int) -> Any:
        """What the fields at a knot are made of: exp(−iωt) on the quadrant, the phase reduced in float64: 12 hours lose
        nothing."""
        turns = self.lattice.omega * (number * self.time_step / (2.0 * np.pi))
        turns -= np.rint(turns)
        phase = (turns * (-2.0 * np.pi)).astype(np.float32)
        phasor = np.empty(phase.shape, dtype=np.complex64)
        np.cos(phase, out=phasor.real)
        np.sin(phase, out=phasor.imag)
        return phasor

    def _half_plane(self, kind: Kind, state: Any) -> NDArray[np.complex64]:
        """Fourier coefficients of a field at a knot, those of columns i ≥ 0, over the spline's transform.

        What makes the field of the elevation is the same for all directions, but for the sign of what is odd in time,
        as flow is: under a wave that runs the other way it is reversed. So those waves take the factor's conjugate.
        """
        from .half_plane import half_plane

        # A function, not an operator: that would multiply in place where it can, by a loop that rounds otherwise.
        factor = state if kind == "elevation" else np.multiply(state, self._per_elevation(kind))
        half = np.empty((self.shape[0], factor.shape[1]), dtype=np.complex64)
        half_plane(self._ahead, self._behind, factor, half)
        return half

    def _coefficients(self, kind: Kind, state: Any) -> NDArray[np.float32]:
        """The spline's coefficients of a field at a knot, with their halo: by one real FFT."""
        half = self._half_plane(kind, state)
        half = np.asarray(scipy.fft.ifft(half, axis=0, norm="forward", overwrite_x=True))
        rows, columns = self.shape
        grid = np.empty(self._grid_shape, dtype=np.float32)
        for start in range(0, rows, _ROWS):
            part = slice(start, min(start + _ROWS, rows))
            grid[part, :columns] = np.asarray(scipy.fft.irfft(half[part], n=columns, axis=1, norm="forward"))
        grid[:rows, columns:] = grid[:rows, : grid.shape[1] - columns]
        grid[rows:] = grid[: grid.shape[0] - rows]
        return grid

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

    def _per_elevation(self, kind: Kind) -> NDArray[np.complex64]:
        """What `_make_per_elevation` makes, once: whichever thread comes first, all use the same."""
        known = self._factors.get(kind)
        return self._factors.setdefault(kind, self._make_per_elevation(kind)) if known is None else known

    def _make_per_elevation(self, kind: Kind) -> NDArray[np.complex64]:
        """The field's amplitude per elevation on the quadrant, of a wave that runs along +k."""
        k = self.lattice.quadrant(lambda k: np.where(k > 0.0, k, np.inf))
        shift = orbital_ratio(k, self.lattice.depth) / k
        if kind == "shift":
            return shift.astype(np.complex64)
        if kind == "potential":  # ∂χ/∂t
            return (-1j * self.lattice.omega * shift).astype(np.complex64)
        assert isinstance(kind, Relaxed)
        omega = np.where(self.lattice.omega > 0.0, self.lattice.omega, 1.0)  # no wave, and no shift, at k = 0
        return (omega / (omega + 1j * kind.rate) * shift).astype(np.complex64)


def grid_size(reach: int, oversampling: float, order: int) -> int:
    """A size of small prime factors for the FFT, large enough for the waves and for the spline's support."""
    least = max(int(np.ceil(oversampling * (2 * reach + 2))), 2 * (order + 1))
    return int(scipy.fft.next_fast_len(least, real=True))  # type: ignore[arg-type]


@cache
def _kernel(
    row_order: int, column_order: int, most: int, time_weights: Callable[[], NDArray[np.float64]]
) -> Callable[..., None]:
    from .spline_kernel import spline_kernel

    rows, columns = (bspline_polynomials(order).astype(np.float32) for order in (row_order, column_order))
    return spline_kernel(rows, columns, time_weights().astype(np.float32), most)


@cache
def _pool() -> ThreadPoolExecutor:
    """One for all: each new thread would take memory of its own from the allocator, and leave it there."""
    return ThreadPoolExecutor(threads())
