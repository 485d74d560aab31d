"""Echo power by PathSolver, by many points a facet, and by the tracers' lit facets: see `peers.py`."""

from __future__ import annotations

import importlib
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.report.style import BLACK, BLUE, ORANGE, VERMILION
from seamap_rt.tracing import Illumination, tracer
from seamap_rt.tracing.horizon import trace_horizon
from seamap_rt.tracing.paths import antennas_east_north_up, sea_scene

from ..light.path_echo import Body, lambertian_power
from .peers_rays import numpy_march
from .peers_turn import Array, Case, Floor, OneSheet, interleaved

CELL_M, CELL_DEG = 3.0, 1.8
RANGES_M = {50: BLACK, 100: BLUE, 200: VERMILION, 300: ORANGE}  # middles of range bins, ± 15 m, and their colours
RANGE_M, HALF_BIN_M = 200, 15.0
STOP_SHORT_M = 0.02  # of the ground before a point within a facet: float32 errs by far less
ONCE_FROM = 2_000_000  # rays of PathSolver, whose seconds are then long enough


class Cells:
    """Cells of the turn, 3 m × 1.8°, by the slant range of a facet's point and by its column."""

    def __init__(self, case: Case) -> None:
        facets, columns, grid = case.facets, case.columns, case.mesh.grid
        lit = np.ones((1, *facets.height.shape), dtype=bool)
        slant, _ = lambertian_power(Illumination.of(facets, lit), columns, 0, case.frequency_hz)
        self.ranges = int(case.simulator.installation.radar.range_m[1] / CELL_M)
        sweep = np.floor((grid.column_sweep[columns] - grid.column_sweep[columns.start]) / CELL_DEG + 1e-6)
        gate = np.minimum(slant / CELL_M, self.ranges).astype(np.int64)  # the last one takes what lies beyond
        self.of_facet = sweep.astype(np.int64)[:, None] * (self.ranges + 1) + gate
        self.count = (int(sweep[-1]) + 1) * (self.ranges + 1)
        self.middle = CELL_M * (np.arange(self.count) % (self.ranges + 1) + 0.5)
        self.area = self.sum(np.broadcast_to(facets.horizontal_area, slant.shape))

    def sum(self, values: Array) -> Array:
        """(cell,) of values (column, facet)."""
        return np.bincount(self.of_facet.ravel(), values.ravel(), self.count).astype(np.float64, copy=False)

    def range_bin(self, middle: float) -> NDArray[np.bool_]:
        """(cell,)"""
        return np.abs(self.middle - middle) < HALF_BIN_M


@dataclass(frozen=True)
class Sample:
    """PathSolver's result with so many rays."""

    rays: int
    seconds: float
    power: Array  # (cell,)
    paths: Array  # (cell,)


def path_solver(case: Case, cells: Cells, samples: list[int], repeat: int) -> list[Sample]:
    """PathSolver as shipped, from one antenna back to itself, one diffuse bounce off the whole turn's mesh."""
    scene = sea_scene(case.mesh, case.sheet, case.frequency_hz, **Body().properties(case.frequency_hz))
    rt: Any = importlib.import_module("sionna.rt")
    antenna = antennas_east_north_up(case.mesh.grid)[case.columns.start, 0].tolist()
    scene.add(rt.Transmitter("transmitter", position=antenna))
    scene.add(rt.Receiver("receiver", position=antenna))
    solver, of_facet = rt.PathSolver(), cells.of_facet.ravel()

    def solve(rays: int) -> Sample:
        start = time.perf_counter()
        solved = solver(
            scene,
            max_depth=1,
            max_num_paths_per_src=int(0.6 * rays),  # those that leave upward meet nothing
            samples_per_src=rays,
            los=False,
            specular_reflection=False,
            diffuse_reflection=True,
            refraction=False,
        )
        real, imaginary = (np.array(part).ravel() for part in solved.a)
        spent = time.perf_counter() - start
        valid = np.array(solved.valid, dtype=bool).ravel()
        cell = of_facet[np.array(solved.primitives).ravel()[valid]]
        power = np.square(real[valid], dtype=np.float64) + np.square(imaginary[valid], dtype=np.float64)
        paths = np.bincount(cell, minlength=cells.count).astype(np.float64)
        total = np.bincount(cell, power, cells.count).astype(np.float64, copy=False)
        return Sample(rays, spent, total, paths)

    solve(samples[0])  # compiles
    every = []
    for rays in samples:
        again = [solve(rays) for _ in range(repeat if rays < ONCE_FROM else 1)]
        every.append(replace(again[0], seconds=statistics.median(each.seconds for each in again)))
    return every


def finely(case: Case, cells: Cells, range_bin: NDArray[np.bool_], cut: int) -> Array:
    """Power (cell,) in a range bin by cut² points a facet, each with a ray of its own through all triangles."""
    antenna = antennas_east_north_up(case.mesh.grid)[case.columns.start, 0]
    surface = case.mesh.trimesh(case.sheet)
    chosen = np.flatnonzero(range_bin[cells.of_facet.ravel()])
    corners = surface.vertices[surface.faces[chosen]] - antenna
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    front = np.einsum("fi,fi->f", normal, corners[:, 0]) < 0.0
    chosen, corners, normal = chosen[front], corners[front], normal[front]
    floor, total = Floor(surface), np.zeros(len(chosen))
    area = 0.5 * np.linalg.norm(normal, axis=1)
    wavelength = SPEED_OF_LIGHT / case.frequency_hz
    for weights in _middles(cut):
        points = np.einsum("c,fci->fi", weights, corners)
        slant = np.linalg.norm(points, axis=1)
        stop = slant * (1.0 - STOP_SHORT_M / np.hypot(points[:, 0], points[:, 1]))
        lit = ~np.array(floor.test(floor.rays(antenna, (points / slant[:, None]).T, stop)))
        cosine = -np.einsum("fi,fi->f", normal, points) / (2.0 * area * slant)
        total += lit * 4.0 * cosine**2 / slant**4
    power = wavelength**2 * area * total / ((4.0 * np.pi) ** 3 * cut**2)
    return np.bincount(cells.of_facet.ravel()[chosen], power, cells.count).astype(np.float64, copy=False)


def _middles(cut: int) -> Array:
    """Barycentric weights (cut², 3) of the middles of a triangle's equal pieces."""
    first, second = np.meshgrid(np.arange(cut), np.arange(cut), indexing="ij")
    upright = np.stack((first, second), axis=-1)[first + second < cut] + 1.0 / 3.0
    inverted = np.stack((first, second), axis=-1)[first + second < cut - 1] + 2.0 / 3.0
    both = np.concatenate((upright, inverted)) / cut
    return np.column_stack((1.0 - both.sum(axis=1), both))


@dataclass(frozen=True)
class Power:
    """Errors of a range bin's cells, more than half lit, and who needs how many seconds for the whole turn."""

    samples: list[Sample]
    error: dict[int, Array]  # by range bin, (sample,)
    loose: dict[int, Array]  # by range bin, (sample,): of as many independent rays as there were paths in the cells
    against_sum: Array  # (sample,) in the range bin, against the sum over lit facets instead of the fine one
    bias: float  # of the largest sample's power in all the range bin, over the fine one
    tracers: dict[str, tuple[float, float]]  # error in the range bin, and seconds
    kept: tuple[int, int]  # cells that count in the range bin, and all


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def tracers_of(case: Case, cells: Cells) -> dict[str, Callable[[], Array]]:
    """The package's methods for the power of every cell."""
    radar, water = case.simulator.installation.radar, case.simulator.scene.scattering
    sheet, facets, horizon = OneSheet(case), tracer("facets", radar, water), tracer("horizon", radar, water)

    def power(lit: NDArray[np.bool_]) -> Array:
        return cells.sum(lambertian_power(Illumination.of(case.facets, lit), case.columns, 0, case.frequency_hz)[1])

    def stage() -> Array:
        lit = np.zeros((1, *case.facets.height.shape), dtype=bool)
        lit[:, case.columns] = sheet.stage()
        return power(lit)

    return {
        "facets' ray stage": stage,
        "facets, tree and rays": lambda: power(facets(case.mesh).lit),
        "horizon": lambda: power(horizon(case.mesh).lit),
        "NumPy march": lambda: power(numpy_march(case)),
    }


def compare_power(case: Case, samples: list[int], repeat: int, cut: int) -> Power:
    cells = Cells(case)
    works = tracers_of(case, cells)
    taken, sums = interleaved(works, repeat), {name: work() for name, work in works.items()}
    traced = path_solver(case, cells, samples, min(repeat, 3))
    lit = trace_horizon(case.mesh).lit
    share = cells.sum(lit[0, case.columns] * case.facets.horizontal_area) / np.maximum(cells.area, 1e-9)
    fine = finely(case, cells, np.any([cells.range_bin(middle) for middle in RANGES_M], axis=0), cut)
    range_bins = {middle: cells.range_bin(middle) & (share > 0.5) for middle in RANGES_M}

    def error(power: Array, middle: int = RANGE_M) -> float:
        return rms(power[range_bins[middle]] / fine[range_bins[middle]] - 1.0)

    def loose(each: Sample, middle: int) -> float:
        return float(1.0 / np.sqrt(traced[-1].paths[range_bins[middle]].mean() / traced[-1].rays * each.rays))

    at, range_bin = range_bins[RANGE_M], cells.range_bin(RANGE_M)
    return Power(
        traced,
        {middle: np.array([error(each.power, middle) for each in traced]) for middle in RANGES_M},
        {middle: np.array([loose(each, middle) for each in traced]) for middle in RANGES_M},
        np.array([rms(each.power[at] / sums["horizon"][at] - 1.0) for each in traced]),
        float(traced[-1].power[range_bin].sum() / fine[range_bin].sum() - 1.0),
        {name: (error(sums[name]), statistics.median(taken[name])) for name in works},
        (int(at.sum()), int(range_bin.sum())),
    )


def slope_of(power: Power) -> float:
    """By which power of the number of rays PathSolver's error falls, over its last three samples."""
    rays, error = [each.rays for each in power.samples[-3:]], power.error[RANGE_M][-3:]
    return float(np.polyfit(np.log(rays), np.log(error), 1)[0])


def rays_needed(power: Power, error: float, slope: float | None = None) -> float:
    """PathSolver's rays for an error in the range bin, between its samples; beyond the last, by the slope."""
    rays, errors = np.log([each.rays for each in power.samples]), np.log(power.error[RANGE_M])
    if slope is None and np.log(error) >= errors[-1]:
        return float(np.exp(np.interp(-np.log(error), -errors, rays)))
    return float(np.exp(rays[-1] + (np.log(error) - errors[-1]) / (slope or slope_of(power))))


def seconds_of(power: Power, rays: float) -> float:
    """Of PathSolver: between its samples, and beyond the last one in proportion."""
    last = power.samples[-1]
    if rays > last.rays:
        return last.seconds * rays / last.rays
    return float(np.interp(rays, [each.rays for each in power.samples], [each.seconds for each in power.samples]))
