"""Wave trains, whose sum is the sea: a regular wave, a plane of short-crested waves, a line of long-crested ones.

`LinearSurface` adds trains up. `Components` are the sea as a list of waves, and `direct_sum` their exact sum: slow, and
the reference of all that is fast.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..physics.dispersion import angular_frequency, orbital_ratio
from .fields import Kind, RelaxedShift, Term
from .lattice import Lattice
from .moving_field import MovingField


@dataclass(frozen=True)
class Components:
    """Waves η = Re Σ a exp(i(k·x − ωt)), each array (wave,)."""

    east: NDArray[np.float64]  # kx, rad/m
    north: NDArray[np.float64]  # ky, rad/m
    omega: NDArray[np.float64]  # rad/s
    orbital: NDArray[np.float64]  # horizontal over vertical amplitude of the water's orbit, coth kh
    amplitude: NDArray[np.complex128]  # m

    @staticmethod
    def joined(pieces: list[Components]) -> Components:
        """All waves of several lists."""

        def join(name: str) -> NDArray:
            return np.concatenate([getattr(part, name) for part in pieces] or [np.zeros(0)])

        return Components(join("east"), join("north"), join("omega"), join("orbital"), join("amplitude"))


@dataclass(frozen=True)
class SurfaceState:
    """Elevation (…) m, its rate (…) m/s, slopes (…, 2) east north, the water's velocity (…, 3) m/s east north up."""

    elevation: NDArray[np.float64]
    elevation_rate: NDArray[np.float64]
    slopes: NDArray[np.float64]
    velocity: NDArray[np.float64]


def direct_sum(waves: Components, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> SurfaceState:
    """Linear (Airy 1845) surface and surface velocity, wave by wave in float64. Time grows as points × waves."""
    x, y, t = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in (x, y, t)))
    k = np.hypot(waves.east, waves.north)
    horizontal = waves.omega * waves.orbital / np.where(k > 0.0, k, 1.0)
    in_phase = np.stack((np.ones_like(k), horizontal * waves.east, horizontal * waves.north))
    in_quadrature = np.stack((waves.omega, -waves.east, -waves.north))
    # A lattice has few distinct kx and ky: one exponential for each, not for every wave.
    east, east_index = np.unique(waves.east, return_inverse=True)
    north, north_index = np.unique(waves.north, return_inverse=True)

    result = np.empty((x.size, 6))
    for time in np.unique(t):
        moved = waves.amplitude * np.exp(-1j * np.remainder(waves.omega * time, 2.0 * np.pi))
        for point in np.flatnonzero(t.ravel() == time):
            across = np.exp(1j * east * x.flat[point])[east_index]
            along = np.exp(1j * north * y.flat[point])[north_index]
            wave = moved * across * along
            result[point, :3] = in_phase @ wave.real
            result[point, 3:] = in_quadrature @ wave.imag
    elevation, flow_east, flow_north, rate, slope_east, slope_north = (column.reshape(x.shape) for column in result.T)
    return SurfaceState(
        elevation,
        rate,
        np.stack((slope_east, slope_north), axis=-1),
        np.stack((flow_east, flow_north, rate), axis=-1),
    )


Quantity = Literal[
    "elevation",  # m
    "rate",  # ∂η/∂t, m/s
    "slope_east",
    "slope_north",
    "flow_east",  # the water's velocity at the surface, m/s
    "flow_north",
    "shift_east",  # horizontal displacement D of the water at the surface, m
    "shift_north",
    "shift_east_east",  # ∂D_east/∂x
    "shift_east_north",  # ∂D_east/∂y = ∂D_north/∂x
    "shift_north_north",  # ∂D_north/∂y
    "relaxed_east",  # the shift that acts on waves which relax at a rate μ: ∂D/∂t + μ D = flow, m
    "relaxed_north",
]
Points = NDArray[np.float64]


_FIELDS: dict[Quantity, tuple[Kind | None, int, int, int]] = {
    "elevation": ("elevation", 0, 0, 0),
    "rate": ("elevation", 0, 0, 1),
    "slope_east": ("elevation", 1, 0, 0),
    "slope_north": ("elevation", 0, 1, 0),
    "flow_east": ("potential", 1, 0, 0),
    "flow_north": ("potential", 0, 1, 0),
    "shift_east": ("shift", 1, 0, 0),
    "shift_north": ("shift", 0, 1, 0),
    "shift_east_east": ("shift", 2, 0, 0),
    "shift_east_north": ("shift", 1, 1, 0),
    "shift_north_north": ("shift", 0, 2, 0),
    "relaxed_east": (None, 1, 0, 0),
    "relaxed_north": (None, 0, 1, 0),
}
"""Of which field a quantity is (None: the relaxed one), how often differentiated to the east, to the north, in time."""


@dataclass(frozen=True)
class RegularTrain:
    """One regular wave in closed form, η = a cos(k·x − ωt + phase)."""

    amplitude: float  # m
    wavenumber: float  # rad/m
    phase: float  # rad
    toward: tuple[float, float]
    depth: float

    def sample(
        self, x: Points, y: Points, t: Points, quantities: Sequence[Quantity], rate: float = 0.0
    ) -> NDArray[np.float64]:
        east, north = self.toward
        omega = float(angular_frequency(self.wavenumber, self.depth))
        angle = self.wavenumber * (east * x + north * y) - np.remainder(omega * t, 2.0 * np.pi) + self.phase
        cosine, sine = self.amplitude * np.cos(angle), self.amplitude * np.sin(angle)
        orbital = float(orbital_ratio(self.wavenumber, self.depth))
        flow, strain = omega * orbital, -self.wavenumber * orbital
        memory = flow / (rate**2 + omega**2)
        values = {
            "elevation": (1.0, cosine),
            "rate": (omega, sine),
            "slope_east": (-self.wavenumber * east, sine),
            "slope_north": (-self.wavenumber * north, sine),
            "flow_east": (flow * east, cosine),
            "flow_north": (flow * north, cosine),
            "shift_east": (-orbital * east, sine),
            "shift_north": (-orbital * north, sine),
            "shift_east_east": (strain * east * east, cosine),
            "shift_east_north": (strain * east * north, cosine),
            "shift_north_north": (strain * north * north, cosine),
            "relaxed_east": (memory * east, rate * cosine - omega * sine),
            "relaxed_north": (memory * north, rate * cosine - omega * sine),
        }
        return np.stack([values[name][0] * values[name][1] for name in quantities])

    def components(self) -> Components:
        k = np.array([self.wavenumber])
        return Components(
            k * self.toward[0],
            k * self.toward[1],
            angular_frequency(k, self.depth),
            orbital_ratio(k, self.depth),
            np.array([self.amplitude * np.exp(1j * self.phase)]),
        )

    def slope_variance(self) -> tuple[float, float]:
        mean_square = 0.5 * (self.amplitude * self.wavenumber) ** 2
        return mean_square * self.toward[0] ** 2, mean_square * self.toward[1] ** 2


@dataclass(frozen=True)
class _LatticeTrain:
    """Random waves of a lattice, whose columns run along `toward`."""

    lattice: Lattice
    variance: NDArray[np.float64]  # (row, column) m², expected of each wave
    amplitude: NDArray[np.complex128]  # (row, column) m
    field: MovingField
    toward: tuple[float, float] = (1.0, 0.0)

    def components(self) -> Components:
        rows, columns = np.nonzero(self.amplitude)
        along, across = self.lattice.east[columns], self.lattice.north[rows]
        k = np.hypot(along, across)
        return Components(
            along * self.toward[0] - across * self.toward[1],
            along * self.toward[1] + across * self.toward[0],
            angular_frequency(k, self.lattice.depth),
            orbital_ratio(k, self.lattice.depth),
            self.amplitude[rows, columns],
        )


@dataclass(frozen=True)
class PlaneTrain(_LatticeTrain):
    """All short-crested systems together, on the periodic plane."""

    def sample(
        self, x: Points, y: Points, t: Points, quantities: Sequence[Quantity], rate: float = 0.0
    ) -> NDArray[np.float64]:
        fields = [_FIELDS[name] for name in quantities]
        terms = [Term(kind or RelaxedShift(rate), north, east, time) for kind, east, north, time in fields]
        return self.field.evaluate(x, y, t, terms)

    def slope_variance(self) -> tuple[float, float]:
        return (
            float(np.sum(self.variance * self.lattice.east**2)),
            float(np.sum(self.variance * self.lattice.north[:, None] ** 2)),
        )


@dataclass(frozen=True)
class LineTrain(_LatticeTrain):
    """One long-crested system: a function of time and of the distance along its direction."""

    def sample(
        self, x: Points, y: Points, t: Points, quantities: Sequence[Quantity], rate: float = 0.0
    ) -> NDArray[np.float64]:
        fields = [_FIELDS[name] for name in quantities]
        terms = [Term(kind or RelaxedShift(rate), column=east + north, time=time) for kind, east, north, time in fields]
        shares = [math.prod((self.toward[0],) * east + (self.toward[1],) * north) for _, east, north, _ in fields]
        along = self.field.evaluate(self.toward[0] * x + self.toward[1] * y, y, t, terms)
        return np.array(shares)[:, None] * along

    def slope_variance(self) -> tuple[float, float]:
        mean_square = float(np.sum(self.variance * self.lattice.east**2))
        return mean_square * self.toward[0] ** 2, mean_square * self.toward[1] ** 2


WaveTrain: TypeAlias = RegularTrain | PlaneTrain | LineTrain
"""One train of waves; trains add up to the sea. `sample` gives quantities (quantity, n) at n points, rate [1/s] being
that at which the relaxed ones relax; `slope_variance` the expected ⟨(∂η/∂x)²⟩ and ⟨(∂η/∂y)²⟩."""


@dataclass(frozen=True)
class LinearSurface:
    """First-order (Airy 1845) waves."""

    trains: Sequence[WaveTrain]

    def sample(
        self, x: Points, y: Points, t: Points, quantities: Sequence[Quantity], rate: float = 0.0
    ) -> NDArray[np.float64]:
        """Quantities (quantity, n); "rate" is ∂η/∂t, and to first order the rise of the water particle."""
        if not self.trains or x.size == 0:
            return np.zeros((len(quantities), x.size))
        total = self.trains[0].sample(x, y, t, quantities, rate)
        for train in self.trains[1:]:
            total += train.sample(x, y, t, quantities, rate)
        return total

    def elevation_rate(self, x: Points, y: Points, t: Points, current: tuple[float, float]) -> NDArray[np.float64]:
        """∂η/∂t (n,) m/s, w − U·∇η."""
        if current == (0.0, 0.0):
            return self.sample(x, y, t, ("rate",))[0]
        rise, slope_east, slope_north = self.sample(x, y, t, ("rate", "slope_east", "slope_north"))
        return rise - current[0] * slope_east - current[1] * slope_north

    def folded(self, x: Points, y: Points, t: Points) -> NDArray[np.bool_]:
        """(n,): never."""
        return np.zeros(x.size, dtype=bool)
