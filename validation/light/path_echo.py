"""The sea's echo by Sionna's PathSolver: paths of one bounce and of several, from an antenna back to itself.

The sea is a Lambertian scatterer, with or without a mirror's share. In Sionna's normalisation a facet re-radiates the
share S² |Γ|² of the power that falls on it, Γ being Fresnel's factor for its polarization, into cos θ / π per
steradian (Degli-Esposti et al. 2007; the reflected ray keeps 1 − S²). In the radar equation that is, per true area,

    σ/A = 4π · S² |Γ|² cos θ · cos θ / π = 4 S² |Γ|² cos²θ,

and over a flat sea σ⁰ = 4 S² |Γ|² sin²ψ per horizontal area at grazing angle ψ. A perfect conductor has |Γ| = 1.

PathSolver launches its rays over the whole sphere, as a Fibonacci lattice, of which a radar at sea would use 0.5 %
beyond 300 m. Here the lattice is mapped onto the requested columns and onto the elevations at which lit facets lie, as
many rays for each. A ray stands for the solid angle that the map gives it: that over 4π/N is its paths' weight, which
only those without any diffuse bounce do without. The lattice is shifted anew for each launch, so that the launches'
spread is the error of their mean; PathSolver's own seed turns only what a bounce scatters.

Of the paths by a mirror and a scatterer PathSolver finds those that meet the mirror first. For the others its ray would
have to leave the scatterer for just the facet that mirrors the antenna, and it finds one in a few hundred: by
reciprocity they are as strong as those. A path of two bounces and the one that runs it backwards are moreover equally
long: at one antenna their fields add, and give twice the sum of their powers. Here powers stand path by path.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.tracing.horizon import trace_horizon
from seamap_rt.tracing.illumination import Illumination
from seamap_rt.tracing.paths import antennas_east_north_up, sea_scene
from seamap_rt.tracing.rays import VACUUM_PERMITTIVITY

Array = NDArray[np.float64]
Lattice = Callable[[int], Any]
_GOLDEN = 0.5 * (1.0 + np.sqrt(5.0))
_BANDS = 256  # of elevation, with as many rays each
_PERFECT = 1e14  # S/m: 1 − |Γ| is 1e-7 over the grazing angle; beyond 1e15 Sionna's slab overflows
MIRRORED, DIFFUSE = 1, 2  # Sionna's InteractionType


@dataclass(frozen=True)
class Body:
    """What the sea is made of: S, the diffuse part's amplitude, and ε′ − jε″, or a perfect conductor."""

    scattering_coefficient: float = 1.0
    permittivity: complex | None = None

    def properties(self, frequency_hz: float) -> dict[str, float]:
        """Of Sionna's RadioMaterial."""
        epsilon = self.permittivity
        conductivity = _PERFECT if epsilon is None else -epsilon.imag * 2.0 * np.pi * frequency_hz * VACUUM_PERMITTIVITY
        return {
            "relative_permittivity": 1.0 if epsilon is None else float(epsilon.real),
            "conductivity": float(conductivity),
            "scattering_coefficient": self.scattering_coefficient,
        }


@dataclass(frozen=True)
class PathEcho:
    """Paths from an isotropic antenna back to itself, of several launches."""

    launches: int
    launch: NDArray[np.int64]  # (path,)
    power: Array  # (path,) received over transmitted
    range: Array  # (path,) m, c/2 times the delay
    facet: NDArray[np.int64]  # (path,) column × facets + facet of the first bounce
    first: Array  # (3, path) m east, north, up of the antenna: where the first bounce is
    kind: NDArray[np.int64]  # (bounce, path) MIRRORED or DIFFUSE; 0 after the last

    @property
    def bounces(self) -> NDArray[np.int64]:
        """(path,)"""
        return np.count_nonzero(self.kind, axis=0)

    def in_gates(self, edges_m: Array, chosen: NDArray[np.bool_], range_m: Array | None = None) -> tuple[Array, Array]:
        """Power (gate,) of the chosen paths between edges of range (m), and its standard error from launch to launch.

        range_m: (path,) other ranges than the paths' own. ValueError if there is only one launch.
        """
        if self.launches < 2:
            raise ValueError(f"launches = {self.launches}: must be at least 2 for an error; launch 4")
        gate = np.searchsorted(edges_m, self.range if range_m is None else range_m, side="right") - 1
        held = chosen & (gate >= 0) & (gate < edges_m.size - 1)
        shape = self.launches, edges_m.size - 1
        number = self.launch[held] * shape[1] + gate[held]
        power = np.bincount(number, self.power[held], shape[0] * shape[1]).reshape(shape)
        return power.mean(axis=0), power.std(axis=0, ddof=1) / np.sqrt(self.launches)


def path_echo(
    mesh: SurfaceMesh,
    columns: slice,
    frequency_hz: float,
    body: Body,
    *,
    bounces: int = 1,
    samples: int = 200_000,
    launches: int = 4,
    antenna: int = 0,
    seed: int = 0,
) -> PathEcho:
    """The echo of those columns of a mesh by PathSolver, diffuse and, with S < 1, specular: power by path.

    The first bounce lies in the columns; further ones may lie in any column of their sheet. samples: rays of a launch,
    of which each may make as many paths as bounces. Raises ValueError if the columns are in no sheet, or for a count
    below 1.
    """
    for name, value in (("bounces", bounces), ("samples", samples), ("launches", launches)):
        if value < 1:
            raise ValueError(f"{name} = {value}: must be at least 1; 2 bounces, 200000 samples, 4 launches are usual")
    sheet = next((s for s in mesh.sheets() if any(e.start <= columns.start < columns.stop <= e.stop for e in s)), None)
    if sheet is None:
        raise ValueError(f"columns = {columns}: must lie in one sheet of the mesh; give first and last of one of them")
    position = antennas_east_north_up(mesh.grid)[(columns.start + columns.stop) // 2, antenna]
    scene = sea_scene(mesh, sheet, frequency_hz, **body.properties(frequency_hz))
    rt: Any = importlib.import_module("sionna.rt")
    scene.add(rt.Transmitter("transmitter", position=position.tolist()))
    scene.add(rt.Receiver("receiver", position=position.tolist()))
    window = _window(mesh, columns, antenna)
    count = mesh.facets.distance.size
    faces = np.concatenate([np.arange(each.start * count, each.stop * count) for each in sheet])
    specular = bool(body.scattering_coefficient < 1.0)
    random = np.random.default_rng(seed)
    launched = []
    for _ in range(launches):
        with _launching(window.lattice(random.random(2))):
            solved = rt.PathSolver(deterministic=True)(
                scene,
                max_depth=bounces,
                max_num_paths_per_src=samples * bounces,
                samples_per_src=samples,
                los=False,
                specular_reflection=specular,
                diffuse_reflection=True,
                refraction=False,
                seed=int(random.integers(2**31)),
            )
        launched.append(_paths(solved, position, window, faces, bounces))
    launch = np.repeat(np.arange(launches), [each[0].size for each in launched])
    return PathEcho(launches, launch, *(np.concatenate(each, axis=-1) for each in zip(*launched, strict=True)))


def lambertian_power(facets: Illumination, columns: slice, antenna: int, frequency_hz: float) -> tuple[Array, Array]:
    """Slant range (m) and received over transmitted power of each lit facet of the columns, both (column, facet).

    Of a perfectly conducting Lambertian sea, S = 1, seen by an isotropic antenna: λ² σ / ((4π)³ R⁴).
    """
    along, across, up = (part[:, None] for part in facets.grid.antenna_positions[columns, antenna].T)
    x = facets.distance * np.cos(facets.angle) - along
    y = facets.distance * np.sin(facets.angle) - across
    z = facets.rise[columns] - up
    slant = np.sqrt(x**2 + y**2 + z**2)
    # Area times cos θ: the true area's stretch and the normal's length are the same.
    projected = facets.horizontal_area * (facets.slope_look[columns] * x + facets.slope_cross[columns] * y - z) / slant
    stretch = np.sqrt(1.0 + facets.slope_look[columns] ** 2 + facets.slope_cross[columns] ** 2)
    cross_section = 4.0 * projected**2 / (facets.horizontal_area * stretch)
    wavelength = SPEED_OF_LIGHT / frequency_hz
    power = wavelength**2 * cross_section / ((4.0 * np.pi) ** 3 * slant**4)
    return slant, np.where(facets.lit[antenna, columns], power, 0.0)


@dataclass(frozen=True)
class _Window:
    """Directions of launch: azimuths from `start` (rad from east to north) on, and bands of elevation."""

    start: float
    width: float
    edges: Array  # (band + 1,) sines of elevation, rising

    def lattice(self, shift: Array) -> Lattice:
        """What stands in for Sionna's lattice on the unit square, (azimuth, z) of which it makes directions."""

        def square(samples: int) -> Any:
            mi: Any = importlib.import_module("mitsuba")
            number = np.arange(samples)
            azimuth = self.start + self.width * ((number / _GOLDEN + shift[0]) % 1.0)
            share = (number + shift[1]) / samples
            sine = np.interp(share, np.linspace(0.0, 1.0, self.edges.size), self.edges)
            return mi.Point2f((azimuth / (2.0 * np.pi) % 1.0).astype(np.float32), (0.5 - 0.5 * sine).astype(np.float32))

        return square

    def weight(self, sine: Array) -> Array:
        """Solid angle of a ray at that sine of elevation over that of a ray of Sionna's own lattice."""
        band = np.clip(np.searchsorted(self.edges, sine) - 1, 0, self.edges.size - 2)
        return self.width * np.diff(self.edges)[band] * (self.edges.size - 1) / (4.0 * np.pi)


def _window(mesh: SurfaceMesh, columns: slice, antenna: int) -> _Window:
    """All elevations at which facets of the columns lie, finely where the lit ones are."""
    lit = trace_horizon(mesh).lit
    grid, facets = mesh.grid, mesh.facets
    north_of_east = np.radians(90.0 - grid.azimuth[[columns.stop, columns.start]])
    lines = slice(columns.start, columns.stop + 1)
    up = mesh.elevation[lines] - grid.pose.origin[lines, 2:] - grid.antenna_positions[columns.start, antenna, 2]
    sine = up / np.hypot(up, grid.ground_range)
    up = facets.rise[columns] - grid.antenna_positions[columns, antenna, 2:]
    seen = (up / np.hypot(up, facets.distance))[lit[antenna, columns]]
    inner = np.quantile(seen, np.linspace(0.0, 1.0, _BANDS + 1)[1:-1]) if seen.size else []
    edges = np.unique(np.concatenate([[sine.min()], inner, [sine.max()]]))
    return _Window(float(north_of_east[0]), float(np.ptp(north_of_east)), edges)


@contextmanager
def _launching(lattice: Lattice) -> Iterator[None]:
    """PathSolver has no setting for its lattice: its own name for it stands for another while it runs."""
    solver: Any = importlib.import_module("sionna.rt.path_solvers.sb_deterministic")
    usual = solver.fibonacci_lattice
    solver.fibonacci_lattice = lattice
    try:
        yield
    finally:
        solver.fibonacci_lattice = usual


def _paths(
    solved: Any, position: Array, window: _Window, faces: NDArray[np.int64], bounces: int
) -> tuple[NDArray, ...]:
    """The fields of PathEcho from `power` on, of one launch."""
    valid = np.array(solved.valid, dtype=bool).ravel()
    kind = np.array(solved.interactions).astype(np.int64).reshape(bounces, valid.size)[:, valid]
    first = np.array(solved.vertices, dtype=np.float64).reshape(bounces, valid.size, 3)[0, valid] - position
    face = np.array(solved.primitives).astype(np.int64).reshape(bounces, valid.size)[0, valid]
    real, imaginary = (np.array(part, dtype=np.float64).ravel()[valid] for part in solved.a)
    sine = first[:, 2] / np.linalg.norm(first, axis=-1)
    weight = np.where((kind == DIFFUSE).any(axis=0), window.weight(sine), 1.0)
    delay = np.array(solved.tau, dtype=np.float64).ravel()[valid]
    # In an order of their own: the solver's may follow its threads.
    order = np.lexsort((*first.T, delay, *kind, face))
    power = weight * (real**2 + imaginary**2)
    reach = 0.5 * SPEED_OF_LIGHT * delay
    return power[order], reach[order], faces[face][order], first.T[:, order], kind[:, order]
