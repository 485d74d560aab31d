"""The facets of a mesh on the device, each worked out from its corners wherever a kernel needs it.

What crosses is the vertices: 24 bytes each with the strain, 16 without, for two facets. Facets themselves are never
stored: a kernel that asks for a facet's slope gathers its corners' heights. These are the formulas of `facet_kernel`,
for any facets in any order. Differences of heights are formed in float64, of which a facet has few; what is made of
them is float32, as it is there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compute.device import Device, device
from ..conventions import unit_from_azimuth
from .facets import FAR_FRACTION, NEAR_FRACTION, Plane
from .grid import PolarGrid
from .surface import ACROSS, SurfaceMesh


@dataclass(frozen=True)
class MeshOnDevice:
    """A turn's mesh there. Arrays of it are flat; lanes are numbers of columns and of facets in them, UInt32."""

    device: Device
    grid: PolarGrid
    elevation: Any  # (line, rung) m above mean sea level, float64
    velocity_look: Any  # (line, rung) m/s
    velocity_up: Any
    relaxed_shift: tuple[Any, Any] | None  # (line, rung) m, east and north

    @classmethod
    def of(cls, mesh: SurfaceMesh) -> MeshOnDevice:
        """Its vertices are placed there."""
        here, shift = device(), mesh.relaxed_shift
        return cls(
            here,
            mesh.grid,
            here.place(mesh.elevation),
            here.place_single(mesh.velocity_look),
            here.place_single(mesh.velocity_up),
            None if shift is None else (here.place_single(shift[..., 0]), here.place_single(shift[..., 1])),
        )

    @property
    def facets(self) -> int:
        """Of a column."""
        return 2 * (self.grid.ground_range.size - 1)

    @cached_property
    def levelled(self) -> MeshOnDevice:
        """See `SurfaceMesh.levelled`."""
        dr, of, rungs = self.device.dr, self.device, self.grid.ground_range.size
        lines = self.grid.columns + 1
        lane = dr.arange(of.UInt32, lines * rungs)
        line, rung = lane // rungs, lane % rungs

        def bend(values: Any, step: int, inside: Any) -> Any:
            before, after = (dr.gather(of.Float64, values, each, inside) for each in (lane - step, lane + step))
            return dr.select(inside, (after - values) - (values - before), 0.0)

        raised = self.elevation - ACROSS * bend(self.elevation, rungs, (line > 0) & (line < lines - 1))
        dr.eval(raised)
        raised = raised - bend(raised, 1, (rung > 0) & (rung < rungs - 1)) / 12.0
        dr.eval(raised)
        return replace(self, elevation=raised)

    def height(self, column: Any, facet: Any) -> Any:
        """m above mean sea level, float64, of facets' points."""
        dr, of = self.device.dr, self.device
        rung, far = facet // 2, (facet % 2) == 1
        own = rung + dr.select(far, of.UInt32(1), of.UInt32(0))
        fraction = dr.select(far, of.Float64(FAR_FRACTION), of.Float64(NEAR_FRACTION))
        share = dr.gather(of.Float64, self._share, facet)
        diagonal = (1.0 - share) * self._at(self.elevation, column, rung)
        diagonal += share * self._at(self.elevation, column + 1, rung + 1)
        edge = (1.0 - fraction) * self._at(self.elevation, column, own)
        return 0.5 * (edge + fraction * self._at(self.elevation, column + 1, own) + diagonal)

    def slopes(self, column: Any, facet: Any) -> tuple[Any, Any]:
        """Along the look and across it, float32."""
        return self._slopes(self.elevation, column, facet)

    def velocities(self, column: Any, facet: Any) -> tuple[Any, Any]:
        """m/s along the look and up, float32: means of the corners'."""
        of, rung = self.device, facet // 2
        far = of.UInt32(facet % 2)
        made = []
        for values in (self.velocity_look, self.velocity_up):
            shared = self._at(values, column, rung) + self._at(values, column + 1, rung + 1)
            made.append((shared + self._at(values, column + 1 - far, rung + far)) * float(np.float32(1.0 / 3.0)))
        return made[0], made[1]

    def strain(self, column: Any, facet: Any) -> Any:
        """−∂D/∂l of the relaxed shift along the column's look; None where the mesh has none."""
        if self.relaxed_shift is None:
            return None
        dr, of = self.device.dr, self.device
        made: list[Any] = []
        for shift, look in zip(self.relaxed_shift, self._look, strict=True):
            look_slope = self._slopes(shift, column, facet)[0]
            made.append(look_slope * dr.gather(of.Float, look, column))
        return -(made[0] + made[1])

    def _slopes(self, values: Any, column: Any, facet: Any) -> tuple[Any, Any]:
        """A quantity's slopes along the look and across it, by the rung edge and the radial edge of each facet."""
        dr, of = self.device.dr, self.device
        rung, odd = facet // 2, of.UInt32(facet % 2)
        own, line = rung + odd, column + 1 - odd  # of the rung edge; and of the radial edge
        across = self._at(values, column + 1, own) - self._at(values, column, own)
        along = self._at(values, line, rung + 1) - self._at(values, line, rung)
        half = 0.5 * np.radians(self.grid.spacing_deg)
        cross = of.Float(across) * dr.gather(of.Float, self._per_chord, own)
        askew = dr.select(odd == 1, of.Float(float(np.sin(half))), of.Float(float(-np.sin(half))))
        look = of.Float(along) * dr.gather(of.Float, self._per_step, rung)
        return (look + cross * askew) * float(1.0 / np.cos(half)), cross

    def _at(self, values: Any, line: Any, rung: Any) -> Any:
        return self.device.dr.gather(type(values), values, line * self.grid.ground_range.size + rung)

    @cached_property
    def _share(self) -> Any:
        """(facet,) of its diagonal, at its point."""
        shares = [Plane.of(self.grid, fraction).share for fraction in (NEAR_FRACTION, FAR_FRACTION)]
        return self.device.place(np.stack(shares, axis=1))

    @cached_property
    def _per_chord(self) -> Any:
        return self.device.place_single(1.0 / self._chord)

    @property
    def _chord(self) -> NDArray[np.float64]:
        """(rung,) m"""
        return 2.0 * self.grid.ground_range * np.sin(0.5 * np.radians(self.grid.spacing_deg))

    @cached_property
    def _per_step(self) -> Any:
        return self.device.place_single(1.0 / np.diff(self.grid.ground_range))

    @cached_property
    def _look(self) -> tuple[Any, Any]:
        """(column,) east and north"""
        east, north = unit_from_azimuth(self.grid.column_azimuth)
        return self.device.place_single(east), self.device.place_single(north)
