"""A sea that is read, not drawn: the surface of a file between its frames and points, as a train of waves.

In space each frame becomes a B-spline by one FFT, as a drawn sea's knots do. In time six frames are interpolated by
their polynomial (Lagrange), and a frame's rate of change is that of the polynomial through seven. The water's flow is
from the surface potential or the velocities where the file has them, else from linear theory: of a wave that runs along
k with ω(k) the elevation η and its rate η̇ tell its amplitude apart from that of the wave that runs against it, ½(η +
iη̇/ω).

What is made up, between frames and across gaps, has an expected error, and a record of which it is more than a tenth of
the waves is refused. Beyond a patch that ends the sea is continued (`continued`), and not known.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from threading import Lock
from typing import NamedTuple

import numpy as np
import scipy.fft
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..io.recorded_sea import RecordedSea, recorded_sea
from ..io.sea_grid import fill_error
from ..physics.dispersion import angular_frequency
from ..settings.sea import MOST_POINTS_A_SIDE
from .continued import ContinuedPatch
from .fields import Kind, Term
from .lattice import Lattice
from .moving_field import MovingField, grid_size
from .spline import InterpolationError, bspline_transform, interpolation_error
from .tabulated import TabulatedSpectrum
from .wave_trains import PlaneTrain, Points, Quantity, WaveTrain

TAPS = range(-2, 4)  # the frames around an interval that its points take from
_ORDER, _OVERSAMPLING = 7, 1.25  # of the spline in space, as of a drawn sea
_SLOPE_TAPS = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0  # of frames −3 … 3, per step
_BESIDE = len(_SLOPE_TAPS) // 2
_BEFORE_S = 0.5  # of the record before time 0: what a beam hears before it points at a place
_ROUNDED = 1e-6  # of a step, by which a time may stray from a frame's
_AVERAGED = 12  # frames from which the spectrum is taken
_DIRECTIONS = 24
_FINE_RINGS, _WIDER = 10, 1.08  # rings of wavenumbers one step wide, and by how much the next ones grow
_HALVINGS = 40
_PHASES = 16  # places between two frames at which the interpolation in time is judged
_MOST_MADE_UP = 0.1  # of the waves' rms height: the error of what is made up, between frames or across a gap
_LOWEST_M = 1e-3  # rms, below which a sea is none, or in other units


class Frame(NamedTuple):
    """Fourier coefficients of a frame (row j in an FFT's order, column i ≥ 0): elevation [m], its rate [m/s], and the
    surface potential [m²/s] where there is one."""

    elevation: NDArray[np.complex64]
    rate: NDArray[np.complex64]
    potential: NDArray[np.complex64] | None


class RecordedField(MovingField):
    """The spline of a recorded sea. Knot n is the frame at n steps of the file, counted from the scene's time 0."""

    taps = TAPS
    base: Kind | None = None  # the frames are the elevation's, and what else the file has

    def __init__(
        self,
        source: ContinuedPatch,
        lattice: Lattice,
        variance: NDArray[np.float64],
        widest_gap: float = np.inf,
        first: int | None = None,
    ) -> None:
        """variance: of each wave of the lattice, as the frames have it: what the errors are taken from. widest_gap: m,
        the half-width above which one is refused. first: the frame of time 0; None: `first_frame`."""
        file = source.file
        self.source, self.file, self.lattice, self.order = source, file, lattice, _ORDER
        self._widest_gap = widest_gap
        rows, columns = lattice.reach
        self.shape = grid_size(rows, _OVERSAMPLING, _ORDER), grid_size(columns, _OVERSAMPLING, _ORDER)
        self._variance = lattice.fold(variance)
        self.time_step = file.step_s
        transform = (
            bspline_transform(_ORDER, np.arange(columns + 1) / self.shape[1])
            * (bspline_transform(_ORDER, np.arange(rows + 1) / self.shape[0])[:, None])
        )
        # The patch's first point lies where it lies: waves are shifted there.
        turn = np.exp(
            -1j * self.lattice.step * (file.west_m * np.arange(columns + 1) + file.south_m * self._rows[:, None])
        )
        self._sharpen = (turn / transform[np.abs(self._rows)]).astype(np.complex64)
        self._clear()
        self._lock = Lock()
        self._spectra: OrderedDict[tuple[str, int], NDArray[np.complex64]] = OrderedDict()
        self._first = first_frame(file) if first is None else first

    @cached_property
    def error(self) -> InterpolationError:
        """Expected rms errors against the band-limited sea of which the frames are samples."""
        return interpolation_error(
            self.lattice, self._variance, self.shape, self.order, self.time_step, in_time=lagrange_error
        )

    def evaluate(
        self, x: NDArray[np.float64], y: NDArray[np.float64], t: NDArray[np.float64], terms: Sequence[Term]
    ) -> NDArray[np.float64]:
        """As of a drawn sea; NaN before the record, and beyond its end. Beyond the patch as it is continued."""
        level, number = self.source.is_level(x, y), np.floor(t / self.time_step)
        first, last = TAPS[0] - _BESIDE, TAPS[-1] + _BESIDE
        known = (number + self._first + first >= 0) & (number + self._first + last < self.file.frames)
        inside = known & ~level
        if inside.all():
            return super().evaluate(x, y, t, terms)
        found = np.tile(np.where(level, 0.0, np.nan), (len(terms), 1))
        if inside.any():
            found[:, inside] = super().evaluate(x[inside], y[inside], t[inside], terms)
        return found

    def _state_at(self, number: int) -> Frame:
        frame = number + self._first
        around = [self._spectrum("elevation", frame + n) for n in range(-_BESIDE, _BESIDE + 1)]
        rate = sum((weight / self.time_step) * each for weight, each in zip(_SLOPE_TAPS, around, strict=True) if weight)
        given = self.file.potential or self.file.flow is not None
        potential = self._spectrum("potential", frame) if given else None
        return Frame(around[_BESIDE], np.asarray(rate, dtype=np.complex64), potential)

    def _spectrum(self, name: str, frame: int) -> NDArray[np.complex64]:
        with self._lock:
            spectrum = self._spectra.get((name, frame))
        if spectrum is None:
            if name == "potential" and not self.file.potential:
                spectrum = self._potential_of_flow(frame)
            else:
                spectrum = half_plane_of(self._points(name, frame), self.lattice)
            with self._lock:
                self._spectra[name, frame] = spectrum
                while len(self._spectra) > 4 * len(_SLOPE_TAPS):
                    self._spectra.popitem(last=False)
        return spectrum

    def _potential_of_flow(self, frame: int) -> NDArray[np.complex64]:
        """Φ with ∇Φ nearest to the velocities given: −i k·û/k². A mean flow and eddies are left out."""
        east, north = (half_plane_of(each, self.lattice) for each in self.source.surface_flow(frame))
        k_east = self.lattice.step * np.arange(self.lattice.reach[1] + 1)
        k_north = self.lattice.step * self._rows[:, None]
        square = k_east**2 + k_north**2
        square[0, 0] = np.inf
        return (-1j * (k_east * east + k_north * north) / square).astype(np.complex64)

    def _points(self, name: str, frame: int) -> NDArray[np.float64]:
        if name == "potential":
            return self.source.surface_potential(frame)
        values, gap = self.source.elevation_and_gap(frame)
        if gap > self._widest_gap:
            raise InputError(
                f"sea.file = '{self.file.path}': frame {frame} has a gap {2.0 * gap:.3g} m wide, and what is filled in "
                f"errs by more than {_MOST_MADE_UP:.0%} of these waves above {2.0 * self._widest_gap:.3g} m; cut it "
                "off, or take frames without"
            )
        return values

    def check_gaps(self, until_s: float) -> None:
        """Read all frames that are needed up to a time. Raises InputError for a gap too wide to be filled."""
        last = self._first + int(np.ceil(until_s / self.time_step)) + TAPS[-1] + _BESIDE
        for frame in range(self._first + TAPS[0] - _BESIDE, min(last, self.file.frames - 1) + 1):
            self._points("elevation", frame)

    def _half_plane(self, kind: Kind, state: Frame) -> NDArray[np.complex64]:
        rows, columns = self.lattice.reach
        half = np.zeros((self.shape[0], columns + 1), dtype=np.complex64)
        made = self._field_of(kind, state) * self._sharpen
        half[: rows + 1], half[-rows:] = made[: rows + 1], made[rows + 1 :]
        return half

    def _field_of(self, kind: Kind, state: Frame) -> NDArray[np.complex64]:
        if kind == "elevation":
            return state.elevation
        if kind == "potential" and state.potential is not None:
            return state.potential
        # Waves along k take the factor, those against it its conjugate.
        factor = self._per_elevation(kind)[np.abs(self._rows)]
        omega = self.lattice.omega[np.abs(self._rows)]
        omega = np.where(omega > 0.0, omega, np.inf).astype(np.float32)
        made = factor.real * state.elevation - (factor.imag / omega) * state.rate
        return np.asarray(made, dtype=np.complex64)

    _time_weights = staticmethod(lambda: lagrange_polynomials())
    _library = staticmethod(lambda: None)  # frames are read, filled and transformed here


def first_frame(file: RecordedSea) -> int:
    """The frame of the scene's time 0: those before it are what is interpolated from, and heard, before."""
    return -TAPS[0] + _BESIDE + int(np.ceil(_BEFORE_S / file.step_s))


def start_of(file: RecordedSea, start_s: float | None) -> tuple[int, float]:
    """The frame at or before the scene's time 0, and how long before [s]. start_s: the file's time that is to be the
    scene's time 0; None: of `first_frame`. Raises InputError for one outside of the record, less its margins."""
    if start_s is None:
        return first_frame(file), 0.0
    low = file.begin_s + (-TAPS[0] + _BESIDE) * file.step_s + _BEFORE_S
    high = file.begin_s + (file.frames - 1 - TAPS[-1] - _BESIDE) * file.step_s
    if not low - _ROUNDED * file.step_s <= start_s <= high + _ROUNDED * file.step_s:
        dates = "" if file.began is None else f", counted from {file.time_in_words(0.0)}"
        raise InputError(
            f"sea.start_s = {start_s:.10g}: must lie within {low:.10g} and {high:.10g} s of sea.file"
            f"{dates} (what is interpolated, and heard before time 0, takes frames beside it); choose one between"
        )
    steps = (start_s - file.begin_s) / file.step_s
    frame = int(np.floor(steps + _ROUNDED))
    return frame, max(0.0, (steps - frame) * file.step_s)


def duration_s(file: RecordedSea, start_s: float | None = None) -> float:
    """Seconds from the scene's time 0 to the last that is known."""
    first, late = start_of(file, start_s)
    return (file.frames - 1 - first - TAPS[-1] - _BESIDE + 1) * file.step_s - late


def half_plane_of(values: NDArray[np.float64], lattice: Lattice) -> NDArray[np.complex64]:
    """Fourier coefficients (row in an FFT's order, column ≥ 0) of a patch, those of the lattice."""
    most = lattice.reach[0]
    whole = np.asarray(scipy.fft.rfft2(values, norm="forward"))[:, : most + 1]
    return np.concatenate((whole[: most + 1], whole[-most:])).astype(np.complex64)


@lru_cache(maxsize=1)
def lagrange_polynomials() -> NDArray[np.float64]:
    """Weights of the frames TAPS around an interval as polynomials of the place in it: (derivative, power, tap)."""
    taps = np.array(TAPS, dtype=np.float64)
    value = np.zeros((taps.size, taps.size))
    for tap, node in enumerate(taps):
        others = np.delete(taps, tap)
        value[:, tap] = polynomial.polyfromroots(others) / np.prod(node - others)
    result = np.zeros((3, taps.size, taps.size))
    for derivative in range(3):
        result[derivative, : taps.size - derivative] = polynomial.polyder(value, derivative)
    return result


def lagrange_error(cycles: ArrayLike, derivative: int = 0) -> NDArray[np.float64]:
    """Rms error of the interpolation between frames, of a unit wave of so many cycles a step, or of its derivative to
    the wave's own: by the polynomials themselves, over places between two frames."""
    turn = 2.0 * np.pi * np.asarray(cycles, dtype=np.float64)[..., None]
    place = (np.arange(_PHASES) + 0.5) / _PHASES
    weights = polynomial.polyval(place, lagrange_polynomials()[min(derivative, 2)])  # (tap, place)
    made = np.exp(1j * turn * np.array(TAPS)) @ weights
    own = (1j * turn) ** derivative * np.exp(1j * turn * place)
    size = np.where(turn > 0.0, turn, 1.0)[..., 0] ** derivative
    return np.sqrt(np.mean(np.abs(made - own) ** 2, axis=-1)) / size


# ------------------------------------------------------------------------------------------------- the whole sea


@dataclass(frozen=True)
class RecordedTrain(PlaneTrain):
    """The waves of a record, whose frames are `late_s` before whole steps of the scene's time."""

    late_s: float = 0.0

    def sample(
        self, x: Points, y: Points, t: Points, quantities: Sequence[Quantity], rate: float = 0.0
    ) -> NDArray[np.float64]:
        return super().sample(x, y, t + self.late_s, quantities, rate)


def check_gaps(trains: Sequence[WaveTrain], until_s: float) -> None:
    """Read the frames of a recorded sea up to a time. Raises InputError for a gap too wide to be filled."""
    for train in trains:
        if isinstance(train, RecordedTrain) and isinstance(train.field, RecordedField):
            train.field.check_gaps(until_s + train.late_s)


def check_frames(file: RecordedSea, error: float, deviation: float) -> None:
    if error > _MOST_MADE_UP * deviation:
        raise InputError(
            f"sea.file = '{file.path}': frames {file.step_s:.3g} s and points {file.spacing_m:.3g} m apart leave an "
            f"error of {error:.2g} m rms between them, {error / deviation:.0%} of these waves: must be at most "
            f"{_MOST_MADE_UP:.0%}; give denser frames, or raise sea.resolution_m, which leaves short waves out"
        )


def recorded_train(
    source: ContinuedPatch, spacing: float, depth: float, first: int, late_s: float
) -> tuple[RecordedTrain, float, float]:
    """The waves, their variance, and the half-width [m] of the widest gap in the frames that were looked at."""
    file = source.file
    if source.points > MOST_POINTS_A_SIDE:
        raise InputError(
            f"sea.file = '{file.path}': {file.points} points a side, mirrored {source.points}: must be at most "
            f"{MOST_POINTS_A_SIDE}; set sea.beyond = 'level', or give fewer points"
        )
    lattice = Lattice(source.side_m, np.pi / max(spacing, file.spacing_m), depth)
    amplitude, variance, level, gap = _waves(source, lattice, first)
    if np.sqrt(variance.sum()) < _LOWEST_M:
        raise InputError(
            f"sea.file = '{file.path}': waves of {np.sqrt(variance.sum()):.2g} m rms: must be at least {_LOWEST_M:g}; "
            f"check the units of {file.name}"
        )
    widest = widest_gap(lattice, variance)
    field = RecordedField(source, lattice, variance, widest, first)
    amplitude = amplitude * np.exp(-1j * lattice.unfold(lattice.omega) * late_s)
    return RecordedTrain(lattice, variance, amplitude, field, late_s=late_s), float(variance.sum()) + level, gap


def gap_error(lattice: Lattice, variance: NDArray[np.float64], half_width: float) -> float:
    """Expected rms error [m] in the middle of a gap of a half-width [m] that was filled, of waves of a lattice."""
    if half_width == 0.0:
        return 0.0
    k = np.hypot(lattice.east, lattice.north[:, None])
    return float(np.sqrt(np.sum(variance * fill_error(k, half_width) ** 2)))


def widest_gap(lattice: Lattice, variance: NDArray[np.float64]) -> float:
    """Half-width [m] at which what is filled in errs by a tenth of the waves' rms height."""
    allowed, low, high = _MOST_MADE_UP * np.sqrt(variance.sum()), 0.0, lattice.length
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if gap_error(lattice, variance, middle) < allowed else (low, middle)
    return low


def _waves(
    source: ContinuedPatch, lattice: Lattice, start: int
) -> tuple[NDArray[np.complex128], NDArray[np.float64], float, float]:
    """Amplitudes of the lattice's waves at the frame `start`; the variance of each over the record, in all the
    surface's; that of the mean level of a patch that ends, which longer waves move; the half-width [m] of the widest
    gap filled."""
    file = source.file
    rows, columns = lattice.reach
    omega = lattice.unfold(np.where(lattice.omega > 0.0, lattice.omega, np.inf))
    first, last = first_frame(file), file.frames - 1 - _BESIDE
    chosen = np.unique(np.linspace(first, last, _AVERAGED).astype(int))
    shift = np.exp(-1j * (lattice.east * file.west_m + lattice.north[:, None] * file.south_m))
    power, whole, amplitude, widest, level = np.zeros(omega.shape), 0.0, np.zeros(omega.shape, complex), 0.0, 0.0
    for frame in np.union1d(chosen, start):
        read = [source.elevation_and_gap(int(frame) + n) for n in range(-_BESIDE, _BESIDE + 1)]
        widest = max(widest, *(gap for _, gap in read))
        made = [_whole_plane(values, lattice) for values, _ in read]
        middle = made[_BESIDE]
        rate = sum(weight / file.step_s * each for weight, each in zip(_SLOPE_TAPS, made, strict=True))
        ahead = middle + 1j * np.asarray(rate) / omega
        ahead[rows, columns] = 0.0
        if frame == start:
            amplitude = ahead * shift
        if frame not in chosen:
            continue
        if not file.periodic:
            level += float(np.abs(middle[rows, columns]) ** 2) / chosen.size / source.kept_share
        middle[rows, columns] = 0.0
        power += 0.5 * np.abs(ahead) ** 2 / chosen.size
        whole += float(np.sum(np.abs(middle) ** 2)) / chosen.size
    total = float(power.sum())
    if total <= 0.0:
        raise InputError(f"sea.file = '{file.path}': is flat at all frames; there is nothing to see")
    return amplitude, power * (whole / total / source.kept_share), level, widest


def _whole_plane(values: NDArray[np.float64], lattice: Lattice) -> NDArray[np.complex128]:
    """Fourier coefficients (row, column), from −m to m."""
    most = lattice.reach[0]
    whole = np.fft.fftshift(np.asarray(scipy.fft.fft2(values, norm="forward")))
    middle = np.array(values.shape) // 2
    return whole[middle[0] - most : middle[0] + most + 1, middle[1] - most : middle[1] + most + 1]


def recorded_spectrum(path: str, depth: float) -> TabulatedSpectrum:
    """E(f, θ) of a recorded sea, by linear dispersion of its wavenumbers: rings of the plane, in directions; nothing
    is beyond the shortest wave that its points tell."""
    file = recorded_sea(path)
    return _spectrum(file, depth if file.depth_m is None else file.depth_m)


@lru_cache(maxsize=4)
def _spectrum(file: RecordedSea, depth: float) -> TabulatedSpectrum:
    lattice = Lattice(file.side_m, np.pi / file.spacing_m, depth)
    _, variance, *_ = _waves(
        ContinuedPatch(file, "level"), lattice, first_frame(file)
    )  # a mirrored sea's waves also come from elsewhere
    east, north = lattice.east[None, :], lattice.north[:, None]
    k = np.hypot(east, north)
    edges = [0.5, *(0.5 + np.arange(1, _FINE_RINGS + 1))]
    while edges[-1] * lattice.step < lattice.limit:
        edges.append(edges[-1] * _WIDER)
    rings = lattice.step * np.array([*edges, edges[-1] * _WIDER])  # the last holds nothing, and so no tail follows
    ring = np.searchsorted(rings, k) - 1
    from_deg = np.degrees(np.arctan2(-east, -north)) % 360.0
    sector = np.rint(from_deg * (_DIRECTIONS / 360.0)).astype(int) % _DIRECTIONS
    inside = (ring >= 0) & (ring < rings.size - 1)
    number = (ring * _DIRECTIONS + sector)[inside]
    energy = np.bincount(number, variance[inside], minlength=(rings.size - 1) * _DIRECTIONS)
    middle = 0.5 * (rings[1:] + rings[:-1])
    frequency = np.asarray(angular_frequency(middle, depth)) / (2.0 * np.pi)
    nodes = [max(0.0, 2.0 * frequency[0] - frequency[1]), *frequency, frequency[-1]]
    width_hz = 0.5 * (np.array(nodes[2:]) - nodes[:-2])  # each ring's share of the trapezia between the rings
    density = energy.reshape(-1, _DIRECTIONS) / (width_hz[:, None] * 360.0 / _DIRECTIONS)
    from_deg = 360.0 / _DIRECTIONS * np.arange(_DIRECTIONS, dtype=np.float64)
    return TabulatedSpectrum(frequency, from_deg, density, depth)
