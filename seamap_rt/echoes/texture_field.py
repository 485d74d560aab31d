"""The patches of a run, on the facets of a turn: lattices of Gaussian numbers by counting, an octave of size each.

A node's number changes with time, each by its own clock. Between nodes it is interpolated, so weighted that its
variance is 1 everywhere. A patch is the same in whichever turn, sector or order it is met.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import random_streams
from ..compute.compiled import compiled, compiled_step
from ..compute.machine import run_blocks
from ..conventions import unit_from_azimuth
from ..mesh import Facets
from ..random_streams import Stream
from ..scattering.texture import Texture
from .spike_field import cell_number, uniform
from .summation.gaussian import key_of


@compiled_step
def node_value(key, i, j, cycles):
    """A unit Gaussian of a node of the lattice at a time in cycles of its own clock."""
    member = key_of(key, cell_number(i, j, 0))
    cycles += uniform(member, 0)
    slot = math.floor(cycles)
    angle, value = 0.5 * math.pi * (cycles - slot), 0.0
    for weight, number in ((math.cos(angle), slot), (math.sin(angle), slot + 1)):
        own = key_of(member, 1 + (number & 0x3FFFFF))
        radius = math.sqrt(-2.0 * math.log(uniform(own, 0)))
        value += weight * radius * math.cos(2.0 * math.pi * uniform(own, 1))
    return value


class Columns(NamedTuple):
    """Of the mesh, each (column,)."""

    cycles: NDArray[np.float64]  # of the nodes' clocks
    east: NDArray[np.float64]  # of the look
    north: NDArray[np.float64]
    middle_east: NDArray[np.float64]  # m, of the antennas, as the patches see them
    middle_north: NDArray[np.float64]


@compiled
def add_octave(begin, end, key, size, share, columns, distance, total):
    """Add √share times an octave of patches to total (column, facet) of the columns from begin to end: nodes size [m]
    apart."""
    cycles, east, north, middle_east, middle_north = columns
    root, per_metre = math.sqrt(share), 1.0 / size
    corner = np.empty(4)
    for column in range(begin, end):
        held_i = held_j = np.int64(-(2**40))
        for facet in range(distance.size):
            x = (middle_east[column] + distance[facet] * east[column]) * per_metre
            y = (middle_north[column] + distance[facet] * north[column]) * per_metre
            i, j = np.int64(math.floor(x)), np.int64(math.floor(y))
            if i != held_i or j != held_j:
                held_i, held_j = i, j
                for n in range(4):
                    corner[n] = node_value(key, i + n % 2, j + n // 2, cycles[column])
            u, v = x - i, y - j
            near, far = corner[0] + u * (corner[1] - corner[0]), corner[2] + u * (corner[3] - corner[2])
            squares = (1.0 - 2.0 * u * (1.0 - u)) * (1.0 - 2.0 * v * (1.0 - v))  # sum of the weights'
            value = (near + v * (far - near)) / math.sqrt(squares)
            total[column, facet] += np.float32(root * value)


@dataclass(frozen=True)
class TextureField:
    """All patches of a run, everywhere and at all times."""

    texture: Texture
    seed: int
    wind_from_deg: float
    current: tuple[float, float] = (0.0, 0.0)  # m/s east, north, with which they drift

    def evaluate(self, facets: Facets, grazing: NDArray[np.float64]) -> NDArray[np.float32]:
        """T (column, facet) of the breakers' echo, mean 1, when the beam passes. grazing (facet,): rad."""
        pose = facets.grid.column_pose
        east, north = unit_from_azimuth(facets.grid.column_azimuth)
        way = [float(each) for each in unit_from_azimuth(self.wind_from_deg + 180.0)]
        total = np.zeros(facets.height.shape, dtype=np.float32)
        for number, (size, share, life, speed) in enumerate(zip(*self.texture, strict=True)):
            key = np.uint64(key_of(random_streams.key(self.seed, Stream.TEXTURE), number))
            run = [speed * along + drift for along, drift in zip(way, self.current, strict=True)]
            middle = [np.ascontiguousarray(pose.origin[:, n] - run[n] * pose.time) for n in (0, 1)]
            columns = Columns(pose.time / life, east, north, *middle)
            at = key, float(size), float(share), columns, facets.distance, total
            run_blocks(lambda begin, end, at=at: add_octave(begin, end, *at), len(total))
        variance = self.texture.variance(grazing)
        return np.exp(total * np.sqrt(variance).astype(np.float32) - (0.5 * variance).astype(np.float32))
