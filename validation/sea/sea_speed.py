"""Error against time of methods to evaluate the moving sea on a mesh that turns with the beam.

    python -m validation.sea.sea_speed [--points 60] [--out validation/figures/sea_speed.png]

One turn of the default scene (JONSWAP, Hs 1.4 m, Tp 5.5 s, 0.8 m, 1024 m) on a polar mesh of 636,000 points, each of
its 825 columns at its own time: elevation, both slopes and the water's velocity. Errors are rms against the exact sum
of waves at points drawn from the mesh. Times are medians in the steady state: a turn makes the knots of one second and
has the others from the turn before. The methods:

  plain        fields by FFT at knots, interpolated as they are: bilinear or cubic (Keys 1981) in space, cubic in time
  spline       this package: elevation and potential by FFT, as B-splines in space and time (the default is marked)
  nufft, knots FINUFFT (Barnett et al. 2019) at all points for each knot, then a B-spline in time
  nufft, times FINUFFT at each column's own time; four columns are timed, the rest extrapolated
  exact        the direct sum in float64; timed at the drawn points, extrapolated
"""

from __future__ import annotations

import importlib.util
import itertools
import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from seamap_rt.physics.dispersion import orbital_ratio
from seamap_rt.report import style
from seamap_rt.sea import direct_sum, realize
from seamap_rt.sea.fields import DERIVATIVES
from seamap_rt.sea.moving_field import TAPS, MovingField
from seamap_rt.sea.spline import TIME_ORDER, bspline_polynomials, bspline_transform
from seamap_rt.sea.spline_kernel import LANES, in_lanes, spline_kernel
from seamap_rt.sea.wave_trains import PlaneTrain, Quantity
from seamap_rt.settings import JonswapWaves, SeaSettings, TracingSettings
from validation import FIGURES
from validation.options import options

finufft: Any = importlib.import_module("finufft") if importlib.util.find_spec("finufft") else None

QUANTITIES: tuple[Quantity, ...] = ("elevation", "slope_east", "slope_north", "flow_east", "flow_north", "rate")
TARGET_SECONDS, TARGETS = 0.25, (1.0, 1.0, 1.0)  # mm, 1e-3, mm/s
PLAIN_STEPS = 8  # knots a second of the plain grids: enough that their errors come from space
TURNS = 5
THREADS = len(os.sched_getaffinity(0))
_KEYS = np.array([[0.0, 1.0, 0.0, 0.0], [-0.5, 0.0, 0.5, 0.0], [1.0, -2.5, 2.0, -0.5], [-0.5, 1.5, -1.5, 0.5]])
"""Cubic convolution with a = −½ (Keys 1981): the weights of four points, (power, tap)."""
_IN_TIME = np.stack((_KEYS, np.zeros_like(_KEYS)))
PLAIN_WEIGHTS = {
    "bilinear": (bspline_polynomials(1, 0), bspline_polynomials(1, 0), _IN_TIME),
    "cubic": (_KEYS[None], _KEYS[None], _IN_TIME),
}
"""Along rows, columns and time, (derivative, power, tap)."""
PLAIN_ROWS = 3  # of halo, as the widest of them takes


@dataclass(frozen=True)
class Method:
    """A method, its time (s) for a turn and its errors: elevation (mm), slopes (1e-3), velocity (mm/s)."""

    family: str
    name: str
    seconds: float
    errors: tuple[float, float, float]
    default: bool = False


@dataclass(frozen=True)
class Mesh:
    """The points of one turn, and those of them where the exact values (quantity, point) are known."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    t: NDArray[np.float64]
    picked: NDArray[np.int64]
    exact: NDArray[np.float64]

    def errors(self, values: NDArray[np.float64], among: slice = slice(None)) -> tuple[float, float, float]:
        """Rms errors of values at the picked points, each group of quantities in thousandths of its unit."""
        square = 1e6 * np.mean((values - self.exact[:, among]) ** 2, axis=1)
        elevation, slope, velocity = np.sqrt((square[0], square[1:3].mean(), square[3:].mean())).tolist()
        return elevation, slope, velocity


def polar_mesh() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y, t of one turn at 60 rpm: a column each 0.45°, three beams beyond both ends, a rung each 0.5 m."""
    sweep = 0.45 * np.arange(-12, 813)
    ground_range = np.linspace(15.0, 400.0, 771)
    x = np.sin(np.radians(sweep))[:, None] * ground_range
    y = np.cos(np.radians(sweep))[:, None] * ground_range
    return x, y, np.broadcast_to((sweep / 360.0)[:, None], x.shape)


def median_seconds(work: Callable[[], object], times: int = 3) -> float:
    """Median time of several calls."""
    taken = []
    for _ in range(times):
        start = time.perf_counter()
        work()
        taken.append(time.perf_counter() - start)
    return float(np.median(taken))


# ------------------------------------------------------------------------------------------------- this package


def spline_methods(plane: PlaneTrain, mesh: Mesh) -> Iterator[Method]:
    """The package's own method: orders × oversampling × knots a second, and the sea's own choice."""
    choices = [(order, over, steps) for order in (3, 5, 7) for over in (1.125, 1.25, 1.5) for steps in (3, 4, 5, 6)]
    chosen = plane.field
    for order, oversampling, steps in choices:
        field = MovingField(
            plane.lattice,
            plane.amplitude,
            plane.variance,
            order=order,
            oversampling=oversampling,
            time_step=1.0 / steps,
            base=chosen.base,
        )
        default = (field.order, field.shape, field.time_step) == (chosen.order, chosen.shape, chosen.time_step)
        yield _spline_method(plane, field, mesh, f"order {order}, {oversampling:.2f} ×, {steps} knots/s", default)


def _spline_method(plane: PlaneTrain, field: MovingField, mesh: Mesh, name: str, default: bool) -> Method:
    tried = PlaneTrain(plane.lattice, plane.variance, plane.amplitude, field)
    values = tried.sample(mesh.x, mesh.y, mesh.t, QUANTITIES)[:, mesh.picked]
    turn = itertools.count(1.0)
    taken = median_seconds(lambda: tried.sample(mesh.x, mesh.y, mesh.t + next(turn), QUANTITIES), TURNS)
    return Method("spline", name, taken, mesh.errors(values), default)


# ------------------------------------------------------------------------------------------------- plain grids


class Spectra:
    """Complex amplitudes of the quantities' real fields on the whole lattice, at any time."""

    def __init__(self, plane: PlaneTrain) -> None:
        self.lattice = lattice = plane.lattice
        k = lattice.quadrant(lambda k: np.where(k > 0.0, k, np.inf))
        self.amplitude = plane.amplitude.astype(np.complex64)
        self.omega = lattice.unfold(lattice.omega)
        flow = lattice.unfold((lattice.omega * orbital_ratio(k, lattice.depth) / k).astype(np.float32))
        east, north = lattice.east.astype(np.float32), lattice.north[:, None].astype(np.float32)
        self.factor = {
            "elevation": np.float32(1.0),
            "slope_east": 1j * east,
            "slope_north": 1j * north,
            "flow_east": flow * east,
            "flow_north": flow * north,
            "rate": (-1j * self.omega).astype(np.complex64),
        }

    def moved(self, t: float) -> NDArray[np.complex64]:
        """The waves' amplitudes at time t."""
        return self.amplitude * np.exp(-1j * np.remainder(self.omega * t, 2.0 * np.pi)).astype(np.complex64)

    def real(self, quantity: Quantity, moved: NDArray[np.complex64]) -> NDArray[np.complex64]:
        """Hermitian amplitudes: their sum over both halves of the lattice is the quantity's real field."""
        waves = moved * self.factor[quantity]
        return np.complex64(0.5) * (waves + np.conj(waves[::-1, ::-1]))

    def grid(self, quantity: Quantity, t: float, size: int, halo: tuple[int, int]) -> NDArray[np.float32]:
        """The quantity on a grid of size × size points, its first rows and columns once more behind the last."""
        whole = self.real(quantity, self.moved(t))
        most = self.lattice.reach[0]
        half = np.zeros((size, size // 2 + 1), dtype=np.complex64)
        half[: most + 1, : most + 1] = whole[most:, most:]
        half[size - most :, : most + 1] = whole[:most, most:]
        plain = np.asarray(scipy.fft.irfft2(half, s=(size, size), norm="forward", workers=THREADS))
        return np.pad(plain, ((0, halo[0]), (0, halo[1])), mode="wrap")

    def at_points(self, t: float, x: NDArray, y: NDArray, eps: float, sharpen: NDArray | float = 1.0) -> NDArray:
        """All quantities at points by FINUFFT in single precision; two real fields share one complex transform."""
        moved = self.moved(t) * np.asarray(sharpen, dtype=np.float32)
        real = [self.real(quantity, moved) for quantity in QUANTITIES]
        pairs = np.stack([real[n] + np.complex64(1j) * real[n + 1] for n in range(0, len(real), 2)])
        across, along = ((self.lattice.step * position).astype(np.float32) for position in (y, x))
        transforms = finufft.nufft2d2(across, along, pairs, eps=eps, isign=1, nthreads=THREADS)
        return np.stack([part for pair in transforms for part in (pair.real, pair.imag)])


def plain_methods(plane: PlaneTrain, mesh: Mesh) -> Iterator[Method]:
    """FFT grids at knots, without a spline's deconvolution, on grids 1, 2 and 4 times as fine as the waves need."""
    spectra = Spectra(plane)
    knot_time = mesh.t * PLAIN_STEPS
    intervals = np.unique(np.floor(knot_time).astype(int))
    kernels = {
        name: spline_kernel(rows.astype(np.float32), columns.astype(np.float32), times.shape[2])
        for name, (rows, columns, times) in PLAIN_WEIGHTS.items()
    }
    for padding in (1, 2, 4):
        size = padding * 2 * (plane.lattice.reach[0] + 1)
        scale = (size / plane.lattice.length,) * 2
        values = {name: np.empty((len(QUANTITIES), mesh.t.size)) for name in kernels}
        gathering, transforms = dict.fromkeys(kernels, 0.0), []
        for row, quantity in enumerate(QUANTITIES):
            output_row = np.where(np.arange(len(DERIVATIVES)) == 0, row, -1)[None]
            grids: dict[int, NDArray[np.float32]] = {}
            for first in intervals.tolist():
                points = np.flatnonzero(np.floor(knot_time) == first)
                knots = range(first - 1, first + 3)
                for number in (number for number in knots if number not in grids):
                    start = time.perf_counter()
                    grids[number] = spectra.grid(quantity, number / PLAIN_STEPS, size, (PLAIN_ROWS, LANES - 1))
                    transforms.append(time.perf_counter() - start)
                grids = {number: grids[number] for number in knots}  # a fine grid has 100 MB
                for name, kernel in kernels.items():
                    spare = PLAIN_ROWS + 1 - PLAIN_WEIGHTS[name][0].shape[2]  # rows of halo that it does not take
                    taken = tuple(grid[: grid.shape[0] - spare] for grid in grids.values())
                    known = (taken, (mesh.x, mesh.y, knot_time), scale, (0, size))
                    unit, in_time = np.ones(len(DERIVATIVES)), in_lanes(PLAIN_WEIGHTS[name][2][:1])
                    gathering[name] += median_seconds(
                        lambda: on_all_cores(kernel, *known, points, in_time, unit, output_row, values[name])  # noqa: B023
                    )
        made = PLAIN_STEPS * len(QUANTITIES) * float(np.median(transforms))
        for name, sampled in values.items():
            yield Method(
                f"plain, {name}", f"padding {padding}", made + gathering[name], mesh.errors(sampled[:, mesh.picked])
            )


def on_all_cores(kernel: Callable[..., None], *arguments) -> None:
    """Run the kernel with its points shared out among threads."""
    *before, points, in_time, scale, output_row, result = arguments
    with ThreadPoolExecutor(THREADS) as pool:
        for task in [
            pool.submit(kernel, *before, part, in_time, scale, output_row, result) for part in np.array_split(points, 8)
        ]:
            task.result()


# ------------------------------------------------------------------------------------------------- other libraries


def nufft_knot_methods(plane: PlaneTrain, mesh: Mesh) -> Iterator[Method]:
    """A non-uniform FFT of all quantities at each knot for the points around it, then a B-spline in time."""
    spectra = Spectra(plane)
    for steps, eps in ((4, 1e-3), (5, 1e-4), (8, 1e-5)):
        sharpen = 1.0 / bspline_transform(TIME_ORDER, spectra.omega / (2.0 * np.pi * steps))
        knot_time = mesh.t * steps
        interval = np.floor(knot_time).astype(int)
        weights = np.polynomial.polynomial.polyval(knot_time - interval, bspline_polynomials(TIME_ORDER, 0)[0])
        sampled = np.zeros((len(QUANTITIES), mesh.t.size))
        taken = []
        for knot in range(int(interval.min()) + TAPS[0], int(interval.max()) + TAPS[-1] + 1):
            start = time.perf_counter()
            points = np.flatnonzero((interval >= knot - TAPS[-1]) & (interval <= knot - TAPS[0]))
            values = spectra.at_points(knot / steps, mesh.x[points], mesh.y[points], eps, sharpen)
            sampled[:, points] += weights[knot - interval[points] - TAPS[0], points] * values
            taken.append(time.perf_counter() - start)
        yield Method(
            "nufft, knots", f"{steps} knots/s, ε = {eps:.0e}", sum(taken), mesh.errors(sampled[:, mesh.picked])
        )


def nufft_time_methods(plane: PlaneTrain, mesh: Mesh) -> Iterator[Method]:
    """A non-uniform FFT at each column's own time: exact in time. Four columns are timed."""
    spectra = Spectra(plane)
    few = slice(0, 4)
    for eps in (1e-3, 1e-5):
        sampled, taken = np.empty((len(QUANTITIES), 4)), []
        for n, point in enumerate(mesh.picked[few]):
            start = time.perf_counter()
            column = np.flatnonzero(mesh.t == mesh.t[point])
            values = spectra.at_points(float(mesh.t[point]), mesh.x[column], mesh.y[column], eps)
            taken.append(time.perf_counter() - start)
            sampled[:, n] = values[:, column == point][:, 0]
        columns = np.unique(mesh.t).size
        yield Method("nufft, times", f"ε = {eps:.0e}", columns * float(np.median(taken)), mesh.errors(sampled, few))


# ------------------------------------------------------------------------------------------------- table and figure


def print_table(methods: list[Method]) -> None:
    print(f"{'method':<16} {'':<30} {'s/turn':>10} {'elevation mm':>13} {'slope 1e-3':>11} {'velocity mm/s':>14}")
    for method in methods:
        elevation, slope, velocity = method.errors
        print(
            f"{method.family:<16} {method.name:<30} {method.seconds:10.3g} "
            f"{elevation:13.4f} {slope:11.4f} {velocity:14.4f}"
            f"{' <- default' if method.default else ''}"
        )


@style.styled
def draw(methods: list[Method], out: Path) -> None:
    """Error against time, one panel for each kind of quantity; the target is the box in the lower left."""
    figure = style.new_figure(3.55)
    looks = {
        "spline": (style.BLUE, "o"),
        "plain, bilinear": (style.ORANGE, "s"),
        "plain, cubic": (style.VERMILION, "D"),
        "nufft, knots": (style.GREEN, "^"),
        "nufft, times": (style.PURPLE, "v"),
    }
    titles = ("elevation, mm rms", "slopes, 10⁻³ rms", "velocity, mm/s rms")
    panels = [style.place(figure, 0.45 + 2.3 * n, 0.35, 1.95, 2.2) for n in range(3)]
    for n, (axes, title) in enumerate(zip(panels, titles, strict=True)):
        style.graph(axes, "time of a turn, s", "", title)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlim(0.06, 2e5)
        axes.set_ylim(2e-3, 1e2)
        axes.fill_between(
            [0.06, TARGET_SECONDS], 2e-3, TARGETS[n], color=style.SKY, alpha=0.35, linewidth=0.0, label="target"
        )
        for family, (colour, marker) in looks.items():
            points = [method for method in methods if method.family == family]
            size = 12 if family == "spline" else 22
            at = [method.seconds for method in points], [method.errors[n] for method in points]
            axes.scatter(*at, size, colour, marker=marker, linewidths=0.0, alpha=0.8, label=family)
        for method in (method for method in methods if method.default):
            at = method.seconds, method.errors[n]
            axes.scatter(*at, 90, "none", marker="o", edgecolors=style.BLACK, linewidths=1.2, label="spline, default")
        for method in (method for method in methods if method.family == "exact"):
            axes.axvline(method.seconds, color=style.GREY, linestyle=":", linewidth=1.2, label="exact sum (no error)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=4, columnspacing=1.6, handletextpad=0.5)
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_bytes(style.png(figure))


def main() -> None:
    chosen = options(__doc__, points=60, out=FIGURES / "sea_speed.png")

    waves = JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.4, peak_period_s=5.5)
    sea = realize(SeaSettings(waves=(waves,)), seed=1, height_error_m=TracingSettings().height_error_m)
    (plane,) = (part for part in sea.trains if isinstance(part, PlaneTrain))
    x, y, t = (np.ravel(value) for value in polar_mesh())
    picked = np.random.default_rng(1).choice(x.size, chosen.points, replace=False)
    start = time.perf_counter()
    state = direct_sum(sea.components(), x[picked], y[picked], t[picked])
    exact_seconds = (time.perf_counter() - start) / chosen.points * x.size
    mesh = Mesh(x, y, t, picked, np.vstack((state.elevation, state.slopes.T, state.velocity.T)))
    print(f"{x.size} points, {THREADS} cores; the sea expects of its default {plane.field.error}", flush=True)

    methods = list(spline_methods(plane, mesh))
    methods += plain_methods(plane, mesh)
    if finufft is None:
        print("finufft: not installed, left out")
    else:
        methods += [*nufft_knot_methods(plane, mesh), *nufft_time_methods(plane, mesh)]
    methods.append(Method("exact", "float64, extrapolated", exact_seconds, (0.0, 0.0, 0.0)))
    print_table(methods)
    draw(methods, chosen.out)
    print(f"figure: {chosen.out}")


if __name__ == "__main__":
    main()
