"""Seas of closed form, which stand still: z(x, y) and its slopes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import unit_from_azimuth

Field = NDArray[np.float64]


class Surface(Protocol):
    """Height z and slopes ∂z/∂x (east) and ∂z/∂y (north) of places x, y [m], any shape."""

    def height(self, x: Field, y: Field) -> Field: ...

    def slopes(self, x: Field, y: Field) -> tuple[Field, Field]: ...


@dataclass(frozen=True)
class TiltedSea:
    """A plane, z = height_m + slope_x x + slope_y y."""

    slope_x: float = 0.0
    slope_y: float = 0.0
    height_m: float = 0.0

    def height(self, x: Field, y: Field) -> Field:
        return self.height_m + self.slope_x * x + self.slope_y * y

    def slopes(self, x: Field, y: Field) -> tuple[Field, Field]:
        one = np.ones(np.broadcast_shapes(np.shape(x), np.shape(y)))
        return self.slope_x * one, self.slope_y * one


@dataclass(frozen=True)
class FlatSea(TiltedSea):
    """Mean sea level."""


@dataclass(frozen=True)
class SinusoidSea:
    """One regular wave that does not move, z = (height_m/2) cos(k·r + phase), its crests across `wave_from_deg`.

    ValueError for a wavelength that is not positive.
    """

    height_m: float
    wavelength_m: float
    wave_from_deg: float = 270.0
    phase_deg: float = 0.0

    def __post_init__(self) -> None:
        if not self.wavelength_m > 0.0:
            raise ValueError(f"wavelength_m = {self.wavelength_m}: must be above 0; give the crests' distance")

    @property
    def _wave_vector(self) -> tuple[float, float]:
        east, north = unit_from_azimuth(self.wave_from_deg + 180.0)
        k = 2.0 * np.pi / self.wavelength_m
        return float(k * east), float(k * north)

    def _angle(self, x: Field, y: Field) -> Field:
        kx, ky = self._wave_vector
        return kx * x + ky * y + np.radians(self.phase_deg)

    def height(self, x: Field, y: Field) -> Field:
        return 0.5 * self.height_m * np.cos(self._angle(x, y))

    def slopes(self, x: Field, y: Field) -> tuple[Field, Field]:
        kx, ky = self._wave_vector
        steep = -0.5 * self.height_m * np.sin(self._angle(x, y))
        return kx * steep, ky * steep
