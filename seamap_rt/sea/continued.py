"""A recorded patch made to repeat, as waves of a lattice must, and what stands for the sea beyond it.

A patch that repeats is left alone. One that ends is brought to its mean level in a rim at its edges and beyond them the
sea is level; or it is mirrored there: η(2e − x) beyond an edge e, so that the elevation goes on without a step, the
slope across the edge changes its sign, and all repeats after two sides.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..io.recorded_sea import RecordedSea

Beyond = Literal["refused", "level", "mirrored"]


@dataclass(frozen=True)
class ContinuedPatch:
    """Frames of a file's patch, made to repeat."""

    file: RecordedSea
    beyond: Beyond

    @property
    def _is_mirrored(self) -> bool:
        return self.beyond == "mirrored" and not self.file.periodic

    @property
    def points(self) -> int:
        """Number of points a side."""
        return (2 if self._is_mirrored else 1) * self.file.points

    @property
    def side_m(self) -> float:
        """The length after which it repeats."""
        return self.points * self.file.spacing_m

    @cached_property
    def _fading(self) -> NDArray[np.float64]:
        """Weight of a point along one axis (points,): from 0 at the edge to 1 behind the rim."""
        weight = np.ones(self.file.points)
        rim = self.file.rim
        weight[:rim] = 0.5 - 0.5 * np.cos(np.pi * np.arange(rim) / rim)
        weight[-rim:] = weight[:rim][::-1]
        return weight

    @property
    def kept_share(self) -> float:
        """Share of an even sea's variance that is left where its rim fades."""
        if self.file.periodic or self._is_mirrored:
            return 1.0
        return float(np.mean(self._fading**2)) ** 2

    def elevation_and_gap(self, frame: int) -> tuple[NDArray[np.float64], float]:
        """(row, column) m, and the half-width [m] of the widest gap that was filled. InputError as the file raises
        it."""
        values, gap = self.file.elevation_and_gap(frame)
        return self._whole(values), gap

    def surface_potential(self, frame: int) -> NDArray[np.float64]:
        """(row, column) m²/s."""
        return self._whole(self.file.surface_potential(frame))

    def surface_flow(self, frame: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Velocity to east and north, each (row, column) m/s; in the mirror that across the edge changes its sign."""
        east, north = (self._whole(each) for each in self.file.surface_flow(frame))
        if self._is_mirrored:
            east[:, self.file.points :] *= -1.0
            north[self.file.points :] *= -1.0
        return east, north

    def _whole(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        if self.file.periodic:
            return values
        if self._is_mirrored:
            return np.pad(values, ((0, values.shape[0]), (0, values.shape[1])), mode="symmetric")
        return values * self._fading[:, None] * self._fading

    def is_level(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which places, m from the antenna, lie beyond the patch where the sea is level there."""
        if self.file.periodic or self.beyond != "level":
            return np.zeros(np.broadcast(x, y).shape, dtype=bool)
        west, east, south, north = self.file.edges_m
        return (x < west) | (x > east) | (y < south) | (y > north)
