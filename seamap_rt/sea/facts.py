"""What of a sea is resolved, and the spectrum that was realised: expectations, before the dice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
import xarray as xr

from .parts import LinePart, PlanePart, SinusoidPart, Waves
from .systems import GRAVITY_CAPILLARY_WAVENUMBER, SpectralSystem, azimuth_toward


@dataclass(frozen=True)
class Resolved:
    """What of the sea is resolved: expectations, before the dice. Short waves left out live in the scattering model."""

    wavenumber_limit: float  # rad/m, π/resolution_m
    variance: float  # m², resolved
    variance_share: float  # of all systems' variance
    mean_square_slope: float  # resolved
    mean_square_slope_share: float  # of the slope of the same spectra up to 369 rad/m, where ripples begin
    elevation_std: float  # m
    slope_std_east: float
    slope_std_north: float
    elevation_error: float  # m rms, of the interpolation against the exact sum of waves
    velocity_error: float  # m/s rms, of its vertical velocity
    slope_error: float  # rms, of a slope
    time_step: float  # s, between the knots of the interpolation (the shortest of all systems)


def resolved_facts(parts: Sequence[Waves], systems: Sequence[SpectralSystem], limit: float) -> Resolved:
    """Expectations of the whole sea. A regular wave is resolved whatever its length: it is a closed form."""
    regular = sum(0.5 * part.amplitude**2 for part in parts if isinstance(part, SinusoidPart))
    regular_slope = sum(sum(part.slope_variance()) for part in parts if isinstance(part, SinusoidPart))
    variance = regular + sum(system.moment(0, limit) for system in systems)
    all_variance = regular + sum(system.moment(0) for system in systems)
    all_slope = regular_slope + sum(system.moment(2, GRAVITY_CAPILLARY_WAVENUMBER) for system in systems)
    slopes = np.sum([part.slope_variance() for part in parts], axis=0) if parts else np.zeros(2)
    fields = [part.field for part in parts if isinstance(part, PlanePart | LinePart)]
    errors = [field.error for field in fields]
    return Resolved(
        wavenumber_limit=limit,
        variance=variance,
        variance_share=variance / all_variance if all_variance > 0.0 else 1.0,
        mean_square_slope=float(slopes.sum()),
        mean_square_slope_share=float(slopes.sum()) / all_slope if all_slope > 0.0 else 1.0,
        elevation_std=float(np.sqrt(variance)),
        slope_std_east=float(np.sqrt(slopes[0])),
        slope_std_north=float(np.sqrt(slopes[1])),
        elevation_error=float(np.sqrt(sum(error.elevation**2 for error in errors))),
        velocity_error=float(np.sqrt(sum(error.vertical_velocity**2 for error in errors))),
        slope_error=float(np.sqrt(sum(error.slope**2 for error in errors))),
        time_step=min((field.time_step for field in fields), default=np.inf),
    )


def spectrum_dataset(parts: Sequence[Waves], resolved: Resolved) -> xr.Dataset:
    """The expected spectrum of every part, labelled; waves travel along +k. attrs: the resolved facts.

    `variance_density(ky, kx)` m⁴ of the short-crested systems together, `line_density(line, k)` m³ of the long-crested
    ones with `line_toward`, and amplitude, wavenumber and `sinusoid_toward` of the regular waves.
    """
    planes = [part for part in parts if isinstance(part, PlanePart)]
    lines = [part for part in parts if isinstance(part, LinePart)]
    regular = [part for part in parts if isinstance(part, SinusoidPart)]
    kx = planes[0].lattice.east if planes else np.zeros(0)
    ky = planes[0].lattice.north if planes else np.zeros(0)
    plane = planes[0].variance / planes[0].lattice.step ** 2 if planes else np.zeros((0, 0))
    forward = [line.lattice.east > 0.0 for line in lines]
    k = lines[0].lattice.east[forward[0]] if lines else np.zeros(0)
    density = [line.variance[0, ahead] / line.lattice.step for line, ahead in zip(lines, forward, strict=True)]
    toward = {"units": "degree", "long_name": "azimuth of travel, clockwise from north"}
    return xr.Dataset(
        {
            "variance_density": (
                ("ky", "kx"),
                plane,
                {"units": "m4", "long_name": "expected elevation variance per wavenumber area"},
            ),
            "line_density": (
                ("line", "k"),
                np.array(density).reshape(len(lines), k.size),
                {"units": "m3", "long_name": "expected elevation variance per wavenumber"},
            ),
            "line_toward": ("line", [azimuth_toward(line.toward) for line in lines], toward),
            "sinusoid_amplitude": (
                "sinusoid",
                [part.amplitude for part in regular],
                {"units": "m", "long_name": "amplitude of a regular wave"},
            ),
            "sinusoid_wavenumber": (
                "sinusoid",
                [part.wavenumber for part in regular],
                {"units": "rad m-1", "long_name": "wavenumber of a regular wave"},
            ),
            "sinusoid_toward": ("sinusoid", [azimuth_toward(part.toward) for part in regular], toward),
        },
        coords={
            "kx": ("kx", kx, {"units": "rad m-1", "long_name": "wavenumber east"}),
            "ky": ("ky", ky, {"units": "rad m-1", "long_name": "wavenumber north"}),
            "k": ("k", k, {"units": "rad m-1", "long_name": "wavenumber along a line"}),
        },
        attrs=asdict(resolved),
    )
