"""The evolving sea surface: wave systems realised once, then evaluated at any place and time.

First-order (linear, Airy 1845) waves. Heights in metres above mean sea level, x east, y north, t in seconds;
η, its slopes, its rate and the water's velocity at the surface belong to one sum of waves, w = ∂η/∂t.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..settings import FlatWaves, SeaSettings, SinusoidWaves, SpectralWaves
from .components import Components
from .facts import Resolved, resolved_facts, spectrum_dataset
from .lattice import Lattice, draw_amplitudes, line_variance, plane_variance
from .moving_field import MovingField
from .parts import LinePart, PlanePart, Quantity, SinusoidPart, Waves
from .systems import SpectralSystem, spectral_system, travel_direction

SPLINE_ORDER, OVERSAMPLING = 5, 1.25  # chosen from validation/sea_speed.py
LINE_ORDER, LINE_OVERSAMPLING = 5, 2.0  # a line costs next to nothing
LINE_REPEATS = 4.0  # repeat length of a long-crested system, in sides of the plane


class Sea:
    """A realised sea. x, y, t broadcast; results carry the broadcast shape first. Asking changes nothing."""

    def __init__(self, parts: Sequence[Waves], resolved: Resolved) -> None:
        self.parts = tuple(parts)
        self.resolved = resolved

    def elevation(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> NDArray[np.float64]:
        """Height above mean sea level, (…) m."""
        return self._sample(x, y, t, ("elevation",))[0]

    def elevation_rate(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> NDArray[np.float64]:
        """∂η/∂t at a fixed place, (…) m/s."""
        return self._sample(x, y, t, ("rate",))[0]

    def slopes(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> NDArray[np.float64]:
        """∂η/∂x and ∂η/∂y, (…, 2) east north."""
        return np.moveaxis(self._sample(x, y, t, ("slope_east", "slope_north")), 0, -1)

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> NDArray[np.float64]:
        """The water particle's velocity at the surface, (…, 3) m/s east north up."""
        return np.moveaxis(self._sample(x, y, t, ("flow_east", "flow_north", "rate")), 0, -1)

    def elevation_and_velocity(
        self, x: ArrayLike, y: ArrayLike, t: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
        """Elevation (…) m and water velocity (…, 3) m/s in one pass: what a mesh of the moving surface needs."""
        values = self._sample(x, y, t, ("elevation", "flow_east", "flow_north", "rate"))
        velocity = np.empty((*values.shape[1:], 3), dtype=np.float32)
        for axis in range(3):
            velocity[..., axis] = values[1 + axis]
        return values[0], velocity

    def components(self) -> Components:
        """Every wave of this realisation, for `direct_sum`."""
        return Components.joined([part.components() for part in self.parts])

    @cached_property
    def spectrum(self) -> xr.Dataset:
        """The directional spectrum that was realised, as expected before the dice; see `facts.spectrum_dataset`."""
        return spectrum_dataset(self.parts, self.resolved)

    def _sample(self, x: ArrayLike, y: ArrayLike, t: ArrayLike, quantities: Sequence[Quantity]) -> NDArray[np.float64]:
        """Sum of all parts, (quantity, …)."""
        points = np.broadcast_arrays(*(np.asarray(value, dtype=np.float64) for value in (x, y, t)))
        shape = (len(quantities), *points[0].shape)
        if not self.parts or points[0].size == 0:
            return np.zeros(shape)
        east, north, time = (point.ravel() for point in points)
        if not (np.isfinite(east).all() and np.isfinite(north).all() and np.isfinite(time).all()):
            raise ValueError("x, y, t: must be finite")
        total = self.parts[0].sample(east, north, time, quantities)
        for part in self.parts[1:]:
            total += part.sample(east, north, time, quantities)
        return total.reshape(shape)


def realize(settings: SeaSettings, seed: int | np.random.SeedSequence) -> Sea:
    """Draw one sea. The same settings and seed give the same bits; systems draw independently of each other.

    Raises ValueError where extent_m is too small for a system's waves.
    """
    limit = np.pi / settings.resolution_m
    root = seed if isinstance(seed, np.random.SeedSequence) else np.random.SeedSequence(seed)
    parts: list[Waves] = []
    systems: list[SpectralSystem] = []
    plane = Lattice(settings.extent_m, limit, settings.depth_m)
    plane_waves: list[tuple[NDArray[np.float64], NDArray[np.complex128]]] = []

    for number, waves in enumerate(settings.waves):
        # As root.spawn would, but without counting in the caller's object: a second call gives the same sea.
        child = np.random.SeedSequence(root.entropy, spawn_key=(*root.spawn_key, number), pool_size=root.pool_size)
        match waves:
            case FlatWaves():
                continue
            case SinusoidWaves():
                if waves.height_m > 0.0:
                    parts.append(_sinusoid(waves, settings.depth_m))
            case SpectralWaves():
                system = spectral_system(waves, settings.depth_m)
                resolved = system.moment(0, limit)
                if resolved <= 0.0:
                    continue
                systems.append(system)
                if system.spreading is None:
                    parts.append(_line_part(system, settings, resolved, child))
                else:
                    variance = plane_variance(plane, system.radial, system.spreading, system.toward, resolved)
                    plane_waves.append((variance, draw_amplitudes(plane, variance, child)))

    if plane_waves:
        variance = np.sum([expected for expected, _ in plane_waves], axis=0)
        amplitude = np.sum([drawn for _, drawn in plane_waves], axis=0)
        field = MovingField(plane, amplitude, variance, order=SPLINE_ORDER, oversampling=OVERSAMPLING)
        parts.insert(0, PlanePart(plane, variance, amplitude, field))
    return Sea(parts, resolved_facts(parts, systems, limit))


def _sinusoid(waves: SinusoidWaves, depth: float) -> SinusoidPart:
    return SinusoidPart(
        amplitude=0.5 * waves.height_m,
        wavenumber=2.0 * np.pi / waves.wavelength_m,
        phase=float(np.radians(waves.phase_deg)),
        toward=travel_direction(waves),
        depth=depth,
    )


def _line_part(
    system: SpectralSystem, settings: SeaSettings, resolved: float, seed: np.random.SeedSequence
) -> LinePart:
    lattice = Lattice(LINE_REPEATS * settings.extent_m, np.pi / settings.resolution_m, settings.depth_m, line=True)
    variance = line_variance(lattice, system.radial, resolved)
    amplitude = draw_amplitudes(lattice, variance, seed)
    field = MovingField(lattice, amplitude, variance, order=LINE_ORDER, oversampling=LINE_OVERSAMPLING)
    return LinePart(lattice, variance, amplitude, field, system.toward)
