"""The light of a turn on the device: where rays were traced there it has never left, else it is placed there once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compute.device import Device, device
from ..mesh.grid import PolarGrid
from .illumination import Illumination


@dataclass(frozen=True)
class LightOnDevice:
    """What `Illumination` says of light, in flat arrays there: (antenna, column, facet), or (column, facet)."""

    device: Device
    grid: PolarGrid
    lit: Any  # (antenna, column, facet) truth values
    rays: int = 0
    field: tuple[Any, Any] | None = None  # (antenna, column, facet) real and imaginary part
    ray_slope: Any = None  # (column, facet)
    in_sight: Any = None
    facing_in_sight: Any = None

    @classmethod
    def of(cls, facets: Illumination) -> LightOnDevice:
        """Light that was found on the host."""
        here = device()
        field = None if facets.field is None else tuple(here.place(part(facets.field)) for part in (np.real, np.imag))
        parts = facets.ray_slope, facets.in_sight, facets.facing_in_sight
        placed = (None if each is None else here.place_single(each) for each in parts)
        return cls(here, facets.grid, here.place(facets.lit), facets.rays, field, *placed)

    @property
    def antennas(self) -> int:
        return self.grid.antenna_positions.shape[1]

    @property
    def cells(self) -> int:
        """Columns times facets."""
        return self.device.dr.width(self.lit) // self.antennas

    def lights(self, antenna: int, place: Any) -> Any:
        """Whether an antenna's light gets to facets (n,), by their flat place; over an edge, all of them."""
        if self.field is not None:
            return self.device.Bool(True)
        return self.device.dr.gather(self.device.Bool, self.lit, place + antenna * self.cells)

    def bent(self, antenna: int, place: Any) -> tuple[Any, Any] | None:
        """The field there, real and imaginary part, over that of free space; None where light does not bend."""
        if self.field is None:
            return None
        real, imag = (self.device.dr.gather(self.device.Float, f, place + antenna * self.cells) for f in self.field)
        return real, imag

    def reached(self, place: Any) -> Any:
        """Whether a ray arrives from any antenna, straight or over an edge."""
        any_antenna = self.device.Bool(False)
        for antenna in range(self.antennas):
            bent = self.bent(antenna, place)
            arrives = self.lights(antenna, place) if bent is None else (bent[0] != 0.0) | (bent[1] != 0.0)
            any_antenna |= arrives
        return any_antenna

    def fetch_lit(self) -> NDArray[np.bool_]:
        """(antenna, column, facet), back on the host: for whoever wants to look; no turn asks."""
        return self.device.fetch(self.lit, (self.antennas, self.grid.columns, -1))
