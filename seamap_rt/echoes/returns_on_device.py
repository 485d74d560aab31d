"""What the facets of a turn return, on the device: `SeaSurface` for light that is there.

The formulas are those of `scattering`, the very functions: only where their arrays lie differs. One kernel makes all of
a facet from its corners; 4 bytes stay of its radar cross-section and 4 of its breakers' share.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..compute.device import Device
from ..mesh import Facets
from ..mesh.on_device import MeshOnDevice
from ..tracing.light_on_device import LightOnDevice
from .motion import Fastest, Motion
from .radar_cross_section import SeaSurface

_RIGHT_ANGLE = float(np.float32(0.5 * np.pi))


@dataclass(frozen=True)
class ReturnsOnDevice:
    """`Returns`, flat arrays (column, facet) there."""

    device: Device
    rcs: Any  # m²
    motion: Motion | None  # of the scatterers relative to the water, without the facets' shares of breakers
    breaking: Any = None  # share of the rcs that comes from breakers; None for none
    running: Any = None  # m/s outward, of a facet's scatterers beside `motion`

    def fastest(self, mesh: MeshOnDevice) -> Fastest:
        """Greatest speeds of the facets of a mesh: two numbers come back."""
        of, dr, lane, column, facet = self.device, self.device.dr, *_lanes(mesh)
        look, up = mesh.velocities(column, facet)
        if self.running is not None:
            look = look + self.running
        water = dr.max(look * look + up * up)
        if self.motion is None or self.breaking is None:
            return Fastest(float(np.sqrt(of.number(water))), None)
        speed = of.place_single(self.motion.breaker_speed)
        outward = look + dr.gather(of.Float, speed, column)
        runs = dr.select(dr.gather(of.Float, self.breaking, lane) > 0.0, outward * outward + up * up, -1.0)
        breakers = of.number(dr.max(runs))
        return Fastest(float(np.sqrt(of.number(water))), float(np.sqrt(breakers)) if breakers >= 0.0 else None)


def returns_on_device(surface: SeaSurface, facets: Facets, mesh: MeshOnDevice, light: LightOnDevice) -> ReturnsOnDevice:
    """The returns of lit facets of a levelled mesh. facets: that mesh's, of which the plain grid is asked alone."""
    of, dr, lane, column, facet = mesh.device, mesh.device.dr, *_lanes(mesh)
    reached = light.reached(lane)
    if surface.scattering.nrcs != "two_scale":
        even = np.atleast_2d(surface.even_power(facets))
        power = dr.gather(of.Float, of.place(even), facet if len(even) == 1 else lane)
        power = power if light.in_sight is None else power * light.in_sight
        rcs = dr.select(reached, _scaled(of, surface, facets, power, column, facet), 0.0)
        dr.eval(rcs)
        return ReturnsOnDevice(of, rcs, surface.motion_of(facets, None))

    look, cross = mesh.slopes(column, facet)
    strain = mesh.strain(column, facet)
    sigma = surface.composite.nrcs(
        _RIGHT_ANGLE - dr.atan(_ray_slope(of, facets, mesh, light, column, facet)),
        look,
        cross,
        dr.gather(of.Float, of.place_single(surface.wind(facets)), column),
        of.Float(0.0) if strain is None else strain,
    )
    area = dr.sqrt(1.0 + look * look + cross * cross)
    area *= dr.gather(of.Float, of.place_single(facets.horizontal_area), facet)
    if light.facing_in_sight is not None:
        area *= light.facing_in_sight
    bragg, specular, breaking = (dr.select(reached, each * area, 0.0) for each in sigma)
    spikes = None if surface.spikes is None else surface.spikes.on(facets)
    if spikes is not None:
        breaking *= of.place(spikes.factor)
    total = bragg + specular + breaking
    rcs = _scaled(of, surface, facets, total, column, facet)
    motion = surface.motion_of(facets, None)
    if motion is None or not surface.scattering.breaking:
        dr.eval(rcs)
        return ReturnsOnDevice(of, rcs, motion)
    share, running = breaking / dr.maximum(total, 1e-30), None
    if spikes is not None:
        running = share * (of.place(spikes.speed) - dr.gather(of.Float, of.place_single(motion.breaker_speed), column))
    dr.eval(rcs, share, running)
    return ReturnsOnDevice(of, rcs, motion, share, running)


def _lanes(mesh: MeshOnDevice) -> tuple[Any, Any, Any]:
    """Of all facets: their flat place, their column, their number in it."""
    lane = mesh.device.dr.arange(mesh.device.UInt32, mesh.grid.columns * mesh.facets)
    return lane, lane // mesh.facets, lane % mesh.facets


def _ray_slope(of: Device, facets: Facets, mesh: MeshOnDevice, light: LightOnDevice, column: Any, facet: Any) -> Any:
    """tan of the angle by which the ray to a facet falls."""
    if light.ray_slope is not None:
        return light.ray_slope
    level = of.dr.gather(of.Float64, of.place(facets.grid.column_height[:, 0]), column)
    distance = of.dr.gather(of.Float, of.place_single(facets.distance), facet)
    return of.Float(level - mesh.height(column, facet)) / distance


def _scaled(of: Device, surface: SeaSurface, facets: Facets, power: Any, column: Any, facet: Any) -> Any:
    """Brought to the measured mean."""
    if surface.scale is None:
        return power
    dr = of.dr
    level, depth, flat, lean = (
        of.place_single(each) for each in surface.scale.terms(surface.grazing(facets), surface.wind(facets))
    )
    level, depth = dr.gather(of.Float, level, facet), dr.gather(of.Float, depth, facet)
    flat, lean = dr.gather(of.Float, flat, column), dr.gather(of.Float, lean, column)
    return power * dr.exp(dr.clip((level + flat) + depth * lean, *surface.scale.limits))
