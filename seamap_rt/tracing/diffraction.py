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
`choppy_sea` two edges give dark facets 0.7 to 1.2 times the power, where one alone gives them several times, and all
facets together 2 % too little at 50–100 m, 27 % at 350–400 m, where straight light gives a third too much
(`validation/light/diffraction.py --columns 80`). Edges are black and straight: neither polarization nor a crest's
roundness is known.

The last leg of a dark facet's ray comes from the edge, steeper than the straight ray would: facets that lean away from
the antenna may face it. Those that lean away from their own ray stay dark.

Edges are those of the profile along the middle of a column, corner by corner of its rungs. Planes of facets, which
cut short waves that run across the look, lie by turns too high and too low, and would be edges that no water has.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.special import wofz

from ..compute.compiled import compiled_strict
from ..compute.machine import pool
from ..mesh.facets import Plane
from .illumination import Illumination

if TYPE_CHECKING:
    from ..mesh.surface import SurfaceMesh  # loads trimesh

_END = 22.5  # |v| from which on the edge has no effect: |F|² is below 1e-4 in shadow, within 2 % of 1 in light
_LEAST = 0.01  # field over that of free space, one way, below which it is taken as 0
_PER_V = 600  # entries of the table per unit of v: linear between them errs by 2e-5
_ALONG = 1e-5  # rad: a ray at less than this to the facet runs along it, as that from the facet's own near corner does
_COLUMNS = 32  # worked on at a time


def diffract(light: Illumination, mesh: SurfaceMesh, wavelength_m: float, least: float = _LEAST) -> Illumination:
    """The mesh's geometric light with `field` (antenna, column, facet) and `ray_slope` (column, facet) added.

    Edges and field are those of the profile along each column's middle, in steps of a rung: both facets between two
    rungs get the field halfway. `field` is 0 where a facet leans away from the ray that arrives, and where it is weaker
    than `least`. wavelength_m: of the radar. ValueError unless it is finite and above 0.
    """
    if not 0.0 < wavelength_m < np.inf:
        raise ValueError(f"wavelength_m = {wavelength_m:g}: must be finite and above 0; give the radar's, c/f")
    positions, middle = mesh.grid.antenna_positions, Plane.of(mesh.grid, 0.5)
    field = np.zeros((positions.shape[1], *light.height.shape), dtype=np.complex64)
    straight = (-light.rise / light.distance).astype(np.float32)
    ray_slope = straight.copy()
    table = _fresnel_table()

    def work(start: int) -> None:
        columns = slice(start, start + _COLUMNS)
        lines = mesh.elevation[start : start + _COLUMNS + 1]
        surface = 0.5 * (lines[:-1] + lines[1:]) - mesh.grid.column_height[columns]
        for antenna in range(positions.shape[1]):
            at = np.ascontiguousarray(positions[columns, antenna, ::2])
            station = at, 4.0 / wavelength_m, 1.0 / len(field), least
            facets = light.slope_look[columns], straight[columns], light.lit[antenna, columns]
            rungs = middle.rung_distance
            _fill_edge_field(rungs, surface, facets, station, table, field[antenna, columns], ray_slope[columns])

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
    slope = (np.diff(height_m, axis=1) / np.diff(distance_m)).astype(np.float32)
    straight = (-(height_m[:, :-1] + height_m[:, 1:]) / (distance_m[:-1] + distance_m[1:])).astype(np.float32)
    field, ray_slope, faces = np.zeros(shape, np.complex64), straight.copy(), slope + straight > 0.0
    antenna = np.zeros((shape[0], 2)) if antenna_m is None else antenna_m
    table = _fresnel_table()

    def work(start: int) -> None:
        rows = slice(start, start + _COLUMNS)
        station = antenna[rows], 4.0 / wavelength_m, 1.0, _LEAST
        facets = slope[rows], straight[rows], faces[rows]
        _fill_edge_field(distance_m, height_m[rows], facets, station, table, field[rows], ray_slope[rows])

    with pool() as workers:
        list(workers.map(work, range(0, shape[0], _COLUMNS)))
    return field, ray_slope


def _fresnel_table() -> NDArray[np.complex128]:
    """F(v) at v = 0 … _END: ½ w(√(π/2) j e^{jπ/4} v) exp(−jπv²/2), by Faddeeva's function w."""
    v = np.arange(int(_END * _PER_V) + 2) / _PER_V
    return 0.5 * wofz(np.sqrt(0.5 * np.pi) * np.exp(0.75j * np.pi) * v) * np.exp(-0.5j * np.pi * v**2)


@compiled_strict
def _fill_edge_field(distance, surface, facets, station, table, field, ray_slope):
    """Fill field (column, facet) with F at the middles of the steps between corners, and add to ray_slope, that of
    straight rays, this antenna's share of how much steeper they come over the edges.

    distance (corner,) and surface (column, corner) are in the antennas' frame. facets: their slopes outward, those of
    straight rays to them, and which light reaches, as many for each step. station: the antenna's position for each
    column, along and above; 4/λ; that share; and the least |F|, below which it is 0.
    """
    position, per_wavelength, share, least = station
    deep = 2.0 * (0.5 / least) ** 2  # of v²: |F| is below 0.23/v, and rays fall by less than 45°
    slope_look, straight, lit = facets
    corners = distance.size
    repeat = slope_look.shape[1] // (corners - 1)
    edges = np.empty((3, corners))  # reach, rise and tangent of each
    coming = np.empty(corners, np.complex128)  # to each edge
    for column in range(surface.shape[0]):
        along, above = position[column, 0], position[column, 1]
        count, highest = 0, -np.inf
        reach, rise = distance[0] - along, surface[column, 0] - above
        tangent = rise / reach if reach > 0.0 else -np.inf
        for n in range(corners - 1):
            reach_out, rise_out = distance[n + 1] - along, surface[column, n + 1] - above
            tangent_out = rise_out / reach_out if reach_out > 0.0 else -np.inf
            if tangent >= highest:
                highest = tangent
                if tangent_out < highest:
                    coming[count] = _dominant_field(edges, count, reach, rise, per_wavelength, table)
                    edges[0, count], edges[1, count], edges[2, count] = reach, rise, highest
                    count += 1
            x, z = 0.5 * (reach + reach_out), 0.5 * (rise + rise_out)
            reach, rise, tangent = reach_out, rise_out, tangent_out
            if x <= 0.0:
                continue
            slope, inner, outer = z / x, repeat * n, repeat * (n + 1)
            last = _dominant(edges, count, x, slope)
            if last < 0 or edges[2, last] <= slope:
                found = _fresnel_factor(edges, last, x, z, per_wavelength, table)
                if last > 0:
                    over = edges[0, last]
                    found *= _dominant_field(edges, last, over, over * slope, per_wavelength, table)
                for facet in range(inner, outer):
                    if lit[column, facet] or slope_look[column, facet] + straight[column, facet] > _ALONG:
                        field[column, facet] = found
                continue
            beyond = x - edges[0, last]
            falls = (edges[1, last] - z) / beyond
            for facet in range(inner, outer):
                ray_slope[column, facet] += share * (falls - straight[column, facet])
            if (
                per_wavelength * (edges[2, last] - slope) ** 2 * edges[0, last] * x > deep * beyond
            ):  # 2v² of small slopes
                continue
            found = coming[last] * _fresnel_factor(edges, last, x, z, per_wavelength, table)
            if abs(found) >= least:
                for facet in range(inner, outer):
                    if slope_look[column, facet] + falls > _ALONG:  # else it leans away
                        field[column, facet] = found


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
    least, lowest = np.inf, edges[0, 0] / (x - edges[0, 0])
    for number in range(count - 1, -1, -1):
        square = (slope - edges[2, number]) ** 2
        if square * lowest > least:  # so it is for all before
            break
        clearance = square * edges[0, number] / (x - edges[0, number])  # v², to a factor
        if clearance < least:
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
        shadow = table[n] + (entry - n) * (table[n + 1] - table[n])
    return shadow if v > 0.0 else 1.0 - shadow


@compiled_strict
def _fresnel_height(edge_x, edge_z, x, z, per_wavelength):
    """v of an edge for the ray from the origin to (x, z), so that πv²/2 is exactly the phase of the detour over it."""
    path = np.sqrt(x * x + z * z)
    height = (edge_z * x - edge_x * z) / path
    before = (edge_x * x + edge_z * z) / path  # the foot of the edge's height on the ray
    first, last = np.sqrt(edge_x**2 + edge_z**2), np.sqrt((x - edge_x) ** 2 + (z - edge_z) ** 2)
    return height * np.sqrt(per_wavelength * (1.0 / (first + before) + 1.0 / (last + path - before)))
