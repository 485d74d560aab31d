"""Two knife edges against the wave equation: a march of the field over every crest of some profiles of `choppy_sea`.

    python -m validation.light.diffraction [--columns 6]

The paraxial wave equation, stepped outward by FFTs over height (Hardin & Tappert 1973), with each silhouette a black
screen, takes any number of edges into account. Printed by range: the two-way power Σ|F|⁴ r⁻³ of the facets that face
their ray, the share of it that comes from facets in geometric shadow, and the rms difference of the field, of geometric
shadows and of `tracing.diffraction = "knife_edge"`, from the march's.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.simulation import Simulator
from seamap_rt.tracing.diffraction import diffract
from seamap_rt.tracing.horizon import trace_horizon

from ..options import options
from .profile import profile

HEIGHTS, STEP_M = 8192, 0.015  # of the march's grid: 123 m, absorbed beyond ±35 m
START_M = 40.0  # the field of a point source is handed over there
BANDS_M = (50.0, 100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0)


def march(reach: NDArray, rise: NDArray, wavelength: float) -> NDArray[np.complex128]:
    """Field over that of free space at the middles between corners (reach, rise) [m] from the antenna."""
    k = 2.0 * np.pi / wavelength
    z = STEP_M * (np.arange(HEIGHTS) - HEIGHTS // 2)
    kz = 2.0 * np.pi * np.fft.fftfreq(HEIGHTS, STEP_M)
    absorb = np.exp(-((np.maximum(np.abs(z) - 35.0, 0.0) / 8.0) ** 4))
    steep = np.exp(-((np.abs(kz) / (0.6 * k)) ** 16))

    def free(at: float, height: NDArray) -> NDArray[np.complex128]:
        return np.exp(-0.5j * k * height**2 / at) / np.sqrt(at)

    def step(field: NDArray, distance: float) -> NDArray[np.complex128]:
        return np.fft.ifft(np.fft.fft(field) * np.exp(0.5j * kz**2 * distance / k) * steep) * absorb

    slope = rise / reach
    silhouette = np.zeros(reach.size, dtype=bool)
    silhouette[1:-1] = (slope[1:-1] >= slope[:-2]) & (slope[2:] < slope[1:-1])
    middle, level = 0.5 * (reach[1:] + reach[:-1]), 0.5 * (rise[1:] + rise[:-1])
    field, at = free(START_M, z) * np.exp(-((z / 20.0) ** 8)), START_M
    found = np.ones(middle.size, dtype=np.complex128)
    for n in range(int(np.searchsorted(reach, START_M)), middle.size):
        if silhouette[n]:
            field, at = step(field, reach[n] - at), reach[n]
            field = field * np.clip((z - rise[n]) / STEP_M + 0.5, 0.0, 1.0)
        field, at = step(field, middle[n] - at), middle[n]
        low = int((level[n] - z[0]) / STEP_M)
        ratio = field[low : low + 2] / free(at, z[low : low + 2])  # slow: the free phase is out
        found[n] = ratio[0] + (level[n] - z[low]) / STEP_M * (ratio[1] - ratio[0])
    return found


def main() -> None:
    arguments = options(__doc__, columns=6)
    scene = sr.load_scene("choppy_sea", {"tracing.tracer": "horizon"})
    mesh = Simulator(scene).mesh(0)
    facets = diffract(trace_horizon(mesh), mesh, scene.wavelength_m)
    assert facets.field is not None
    plane, (along, _, above) = profile(mesh.elevation, mesh.grid, 0.5), mesh.grid.antenna_positions[0, 0]
    sums = np.zeros((2, 3, len(BANDS_M) - 1))  # all and dark; straight, two edges, march; band
    misses = np.zeros((2, 2, len(BANDS_M) - 1))  # square and count; lit and dark
    for column in np.linspace(0, facets.grid.columns, arguments.columns, endpoint=False).astype(int):
        rise = plane.rung_height[column] - mesh.grid.column_height[column] - above
        waves = march(plane.rung_distance - along, rise, scene.wavelength_m)
        edges, lit = facets.field[0, column, 0::2], facets.lit[0, column, 0::2]
        facing, distance = edges != 0.0, facets.distance[0::2]
        band = np.digitize(distance, BANDS_M) - 1
        for number in range(sums.shape[2]):
            chosen = (band == number) & facing
            weight = distance[chosen] ** -3
            powers = np.stack([weight * np.abs(each[chosen]) ** 4 for each in (lit.astype(float), edges, waves)])
            sums[0, :, number] += powers.sum(axis=1)
            sums[1, :, number] += powers[:, ~lit[chosen]].sum(axis=1)
            for row, part in enumerate((lit, ~lit)):
                miss = np.abs(edges - waves)[chosen & part] ** 2
                misses[0, row, number] += miss.sum()
                misses[1, row, number] += miss.size
    print("**power over that of a march of the field; share of it out of shadows; rms of the two-way field**\n")
    print(
        "| m | straight rays | two edges | out of shadows, march | two edges | rms, lit | dark |\n" + "|---" * 7 + "|"
    )
    rms = np.sqrt(misses[0] / np.maximum(misses[1], 1.0))
    for number, near in enumerate(BANDS_M[:-1]):
        straight, two, whole = sums[0, :, number]
        shares = 100.0 * sums[1, 1:, number] / sums[0, 1:, number]
        print(
            f"| {near:.0f}–{BANDS_M[number + 1]:.0f} | {straight / whole:.2f} | {two / whole:.2f} "
            f"| {shares[1]:.2f} % | {shares[0]:.2f} % | {rms[0, number]:.2f} | {rms[1, number]:.2f} |"
        )


if __name__ == "__main__":
    main()
