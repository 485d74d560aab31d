"""Diffraction at the edges of shadows: the field over the crest that hides a facet, or that its ray just clears.

A crest's silhouette, where the surface turns away from the antenna, is taken as a knife edge (Fresnel and Kirchhoff;
Born & Wolf 1999, section 8.7.3; ITU-R P.526). The field at a facet, relative to that of the straight ray in free space,
is F(v) = (1 + j)/2 ∫_v^∞ exp(−jπt²/2) dt, in which v² π/2 is the phase of the detour over the edge; v is positive in
shadow. Far in the shadow it is a ray from the edge: the phase says where from, and two antennas one above the other see
the edge, not the facet.

Of several edges that of the largest v dominates: for a dark facet the last silhouette before it, which is both the
highest in angle and the nearest; for a lit one that which reaches furthest into its ray's Fresnel zone. What passes
over it has passed others before. Of those the dominating one is found in the same way, on the path up to there, and the
two factors multiply (Epstein & Peterson 1953, Deygout 1966). Against a march of the field over all silhouettes of
`choppy_sea` two edges give dark facets 1.0 to 1.5 times the power, where one alone gives them several times, and all
facets together 4 % too little at 50–100 m, 30 % at 350–400 m, where straight light gives twice too much
(`validation/light/diffraction.py --columns 80`). Edges are black and straight: neither polarization nor a crest's
roundness is known.

The last leg of a dark facet's ray comes from the edge, steeper than the straight ray would: facets that lean away from
the antenna may face it. Those that lean away from their own ray stay dark.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.special import wofz

from ..compute.compiled import compiled_strict
from ..compute.machine import pool
from ..mesh.facets import FAR_FRACTION, NEAR_FRACTION, Profile, profile
from .illumination import Illumination

if TYPE_CHECKING:
    from ..mesh.surface import SurfaceMesh  # loads trimesh

_END = 22.5  # |v| from which on the edge has no effect: |F|² is below 1e-4 in shadow, within 2 % of 1 in light
_PER_V = 200  # entries of the table per unit of v: linear between them errs by 1e-5
_ALONG = 1e-6  # rad: a ray at less than this to the facet runs along it, as that from the facet's own near corner does
_COLUMNS = 32  # worked on at a time


def diffract(light: Illumination, mesh: SurfaceMesh, wavelength_m: float) -> Illumination:
    """The mesh's geometric light with `field` (antenna, column, facet) and `ray_slope` (column, facet) added.

    `field` is 0 where the facet leans away from the ray that arrives, and where less than 1e-4 of the power does.
    wavelength_m: of the radar. ValueError unless it is finite and above 0.
    """
    if not 0.0 < wavelength_m < np.inf:
        raise ValueError(f"wavelength_m = {wavelength_m:g}: must be finite and above 0; give the radar's, c/f")
    positions = mesh.grid.antenna_positions
    field = np.zeros((positions.shape[1], *light.height.shape), dtype=np.complex64)
    ray_slope = np.zeros(light.height.shape, dtype=np.float32)
    table = _fresnel_table()
    planes = [_chain(profile(mesh.elevation, mesh.grid, fraction)) for fraction in (NEAR_FRACTION, FAR_FRACTION)]

    def work(start: int) -> None:
        columns = slice(start, start + _COLUMNS)
        for first, (distance, height) in enumerate(planes):
            surface = height[columns] - mesh.grid.column_height[columns]
            for antenna in range(positions.shape[1]):
                antenna_at = np.ascontiguousarray(positions[columns, antenna, ::2])
                station = antenna_at, 4.0 / wavelength_m, 1.0 / len(field)
                _fill_edge_field(distance, surface, first, station, table, field[antenna, columns], ray_slope[columns])

    with pool() as workers:
        list(workers.map(work, range(0, light.grid.columns, _COLUMNS)))
    return replace(light, field=field, ray_slope=ray_slope)


def field_over_profiles(
    distance_m: NDArray[np.float64],
    height_m: NDArray[np.float64],
    wavelength_m: float,
    antenna_m: NDArray[np.float64] | None = None,
) -> tuple[NDArray[np.complex64], NDArray[np.float32]]:
    """`field` and `ray_slope` (profile, facet) of the facets between corners of profiles, for one antenna.

    distance_m: of the corners from the antenna, all in front of it (corner,); height_m: above it (profile, corner);
    antenna_m: where it is (profile, 2), along the profile and above its zero; there by default.
    """
    shape = height_m.shape[0], distance_m.size - 1
    field, ray_slope = np.zeros(shape, np.complex64), np.zeros(shape, np.float32)
    antenna = np.zeros((shape[0], 2)) if antenna_m is None else antenna_m
    table = _fresnel_table()

    def work(start: int) -> None:
        rows = slice(start, start + _COLUMNS)
        station = antenna[rows], 4.0 / wavelength_m, 1.0
        for first in (0, 1):
            _fill_edge_field(distance_m, height_m[rows], first, station, table, field[rows], ray_slope[rows])

    with pool() as workers:
        list(workers.map(work, range(0, shape[0], _COLUMNS)))
    return field, ray_slope


def _chain(plane: Profile) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Distances (corner,) and heights (column, corner) of a profile's corners, outward.

    Between corners n and n + 1 lies facet n, on the near facets' plane if n is even, on the far facets' if odd.
    """
    distance = np.empty(2 * plane.rung_distance.size - 1)
    height = np.empty((plane.rung_height.shape[0], distance.size))
    distance[0::2], distance[1::2] = plane.rung_distance, plane.diagonal_distance
    height[:, 0::2], height[:, 1::2] = plane.rung_height, plane.diagonal_height
    return distance, height


def _fresnel_table() -> NDArray[np.complex128]:
    """F(v) exp(jπv²/2) = ½ w(√(π/2) j e^{jπ/4} v) at v = 0 … _END, by Faddeeva's function w: it does not oscillate."""
    v = np.arange(int(_END * _PER_V) + 2) / _PER_V
    return 0.5 * wofz(np.sqrt(0.5 * np.pi) * np.exp(0.75j * np.pi) * v)


@compiled_strict
def _fill_edge_field(distance, surface, first, station, table, field, ray_slope):
    """Fill field (column, facet) with F of the facets first, first + 2 …, and add this antenna's share of their rays'
    slope to ray_slope.

    distance (corner,) and surface (column, corner) are in the antennas' frame; station: the antenna's position in it
    for each column, along and above; 4/λ; and that share.
    """
    position, per_wavelength, share = station
    corners = distance.size
    rise, tangent = np.empty(corners), np.empty(corners)
    edges = np.empty((3, corners))  # reach, rise and tangent of each
    coming = np.empty(corners, np.complex128)  # to each edge
    for column in range(surface.shape[0]):
        along, above = position[column, 0], position[column, 1]
        reach = distance - along
        for n in range(corners):
            rise[n] = surface[column, n] - above
            tangent[n] = rise[n] / reach[n] if reach[n] > 0.0 else -np.inf
        count, highest = 0, -np.inf
        for n in range(corners - 1):
            if tangent[n] >= highest:
                highest = tangent[n]
                if tangent[n + 1] < highest:
                    coming[count] = _dominant_field(edges, count, reach[n], rise[n], per_wavelength, table)
                    edges[0, count], edges[1, count], edges[2, count] = reach[n], rise[n], highest
                    count += 1
            if n % 2 != first:
                continue
            x, z = 0.5 * (reach[n] + reach[n + 1]), 0.5 * (rise[n] + rise[n + 1])
            straight = -(z + above) / (x + along)  # from the middle between the antennas
            if x <= 0.0:
                ray_slope[column, n] += share * straight
                continue
            last = _dominant(edges, count, x, z / x)
            if last >= 0 and edges[2, last] > z / x:
                falls = (edges[1, last] - z) / (x - edges[0, last])
                ray_slope[column, n] += share * falls
                if rise[n + 1] - rise[n] > (_ALONG - falls) * (reach[n + 1] - reach[n]):  # else it leans away
                    field[column, n] = coming[last] * _fresnel_factor(edges, last, x, z, per_wavelength, table)
                continue
            ray_slope[column, n] += share * straight
            over = edges[0, last] if last > 0 else x
            before = _dominant_field(edges, last, over, over * z / x, per_wavelength, table)
            field[column, n] = before * _fresnel_factor(edges, last, x, z, per_wavelength, table)


@compiled_strict
def _dominant_field(edges, count, x, z, per_wavelength, table):
    """The field at (x, z), or on the path over it, after the dominating one of the first `count` edges."""
    return _fresnel_factor(edges, _dominant(edges, count, x, z / x), x, z, per_wavelength, table)


@compiled_strict
def _dominant(edges, count, x, slope):
    """Which of the first `count` edges has the largest v for a point at distance x, elevation `slope`; −1 for none."""
    best = count - 1
    if best < 0 or edges[2, best] >= slope:
        return best
    least = np.inf
    for number in range(count):
        clearance = (slope - edges[2, number]) ** 2 * edges[0, number] / (x - edges[0, number])  # v², to a factor
        if clearance <= least:
            best, least = number, clearance
    return best


@compiled_strict
def _fresnel_factor(edges, number, x, z, per_wavelength, table):
    """F(v) of one edge for the ray to (x, z), F(−v) being 1 − F(v); 1 for the edge −1, which is none."""
    if number < 0:
        return 1.0 + 0.0j
    v = _fresnel_height(edges[0, number], edges[1, number], x, z, per_wavelength)
    size = abs(v)
    shadow = 0.0j
    if size < _END:
        entry = size * _PER_V
        n = int(entry)
        phase = 0.5 * np.pi * size * size
        shadow = (table[n] + (entry - n) * (table[n + 1] - table[n])) * complex(np.cos(phase), -np.sin(phase))
    return shadow if v > 0.0 else 1.0 - shadow


@compiled_strict
def _fresnel_height(edge_x, edge_z, x, z, per_wavelength):
    """v of an edge for the ray from the origin to (x, z), so that πv²/2 is exactly the phase of the detour over it."""
    path = np.sqrt(x * x + z * z)
    height = (edge_z * x - edge_x * z) / path
    before = (edge_x * x + edge_z * z) / path  # the foot of the edge's height on the ray
    first, last = np.sqrt(edge_x**2 + edge_z**2), np.sqrt((x - edge_x) ** 2 + (z - edge_z) ** 2)
    return height * np.sqrt(per_wavelength * (1.0 / (first + before) + 1.0 / (last + path - before)))
