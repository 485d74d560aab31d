"""The resolved part of a sea, and the spectrum that was realised: expectations over realisations.

`ResolvedWaves` are a scene's resolved waves by wavenumber, and what follows from their spectrum without drawing a sea;
means over looks and headings count all directions alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..physics.dispersion import angular_frequency, orbital_ratio
from ..settings import RandomWaves, SeaSettings, SinusoidWaves
from .choppy import ChoppySurface
from .systems import SpectralSystem, azimuth_toward, spectral_system, wave_facts
from .wave_trains import LineTrain, PlaneTrain, RegularTrain, WaveTrain

if TYPE_CHECKING:
    import xarray as xr


_ABOUT_TO_FOLD = 0.1
_SAMPLES = 200_000  # labels, over the whole patch
_EVEN_STEPS = 0.7548776662466927, 0.5698402909980532  # 1/p, 1/p², p³ = p + 1: fill a square evenly, seen from any side


@dataclass(frozen=True)
class ChoppyFacts:
    """What the choppy model did to this realisation, from a grid over the periodic patch at time 0."""

    amplitude_scale: float  # by which the waves were made larger, so that the significant height stays
    set_down: float  # m, by which the mean level would have sunk, put back
    folded_share: float  # of the water, det(I + ∇D) ≤ 0: crests that break over; a fifth or so of it in ground covered
    elevation_std: float  # m, over the ground
    skewness: (
        float  # of the elevation over the ground; 0 in expectation at this order, see `ResolvedSea.skewness_stokes`
    )
    mean_square_slope: float  # over the ground, but for what is about to fold (det < 0.1), where it has no bound


@dataclass(frozen=True)
class ResolvedSea:
    """The resolved part of the sea: expectations over realisations. Shorter waves belong to the scattering model."""

    resolution_m: float  # spacing of the resolved waves' grid
    wavenumber_limit: float  # rad/m, π/resolution_m
    variance: float  # m², resolved
    total_variance: float  # m², of all systems' waves, resolved or not
    variance_share: float  # resolved of that
    carried_share: float  # least share of a system's resolved variance that the patch's wavenumbers sample; 1 is best
    mean_square_slope: float  # resolved, of linear waves
    total_mean_square_slope: float  # of the same spectra, up to 369 rad/m or what is resolved (elfouhaily: all)
    mean_square_slope_share: float  # resolved of that
    elevation_std: float  # m
    slope_std_east: float
    slope_std_north: float
    elevation_error: float  # m rms, of the interpolation against the exact sum of waves
    velocity_error: float  # m/s rms, of its vertical velocity
    slope_error: float  # rms, of a slope
    time_step: float  # s, between the knots of the interpolation (the shortest of all systems)
    significant_steepness: float  # Hs over the length of the highest system's peak; above 0.06 or so a sea breaks
    skewness_stokes: (
        float  # 3kσ, of a narrow-banded second-order sea with that peak (Longuet-Higgins 1963); regular: half
    )
    choppy: ChoppyFacts | None = None
    filled_m: float = 0.0  # width of the widest gap of a record that was filled, of the frames that were looked at
    filled_error: float = 0.0  # m rms, in the middle of that gap
    record_start_s: float | None = None  # time of a record's file, of dates from its first, that is the scene's time 0
    record_start: str | None = None  # the same in the file's own words: s, or a date

    @property
    def look_slope_variance(self) -> float:
        """Variance of the slope along a look, the mean over all looks."""
        return 0.5 * self.mean_square_slope

    @property
    def peak_length(self) -> float:
        """Length [m] of the waves at the highest system's peak; 0 without waves."""
        return 4.0 * self.elevation_std / self.significant_steepness if self.significant_steepness > 0.0 else 0.0

    @property
    def second_order_std(self) -> float:
        """Rms height [m] of the bound waves that sharpen a narrow-banded sea's crests: kσ² (Longuet-Higgins 1963).

        k is the peak's, 4σk/2π the significant steepness. The second order is ½ k (η² − η̂²), whose terms vary by 2σ²
        together.
        """
        return 0.5 * np.pi * self.significant_steepness * self.elevation_std


def resolved_facts(
    trains: Sequence[WaveTrain],
    systems: Sequence[SpectralSystem],
    resolution: float,
    *,
    scale: float = 1.0,
    carried: float = 1.0,
) -> ResolvedSea:
    """Expectations of the whole sea. A regular wave is resolved whatever its length: it is a closed form.

    scale: by which a choppy sea's random waves were enlarged; the facts are those of the sea as set.
    carried: see `ResolvedSea.carried_share`.
    """
    limit = np.pi / resolution
    waves = [train for train in trains if isinstance(train, RegularTrain)]
    regular = sum(0.5 * train.amplitude**2 for train in waves)
    regular_slope = np.sum([train.slope_variance() for train in waves], axis=0) if waves else np.zeros(2)
    variance = regular + sum(system.moment(0, limit) for system in systems)
    all_variance = regular + sum(system.variance for system in systems)
    all_slope = float(regular_slope.sum()) + sum(system.moment(2, max(system.shortest, limit)) for system in systems)
    random = [train.slope_variance() for train in trains if not isinstance(train, RegularTrain)]
    slopes = regular_slope + (np.sum(random, axis=0) / scale if random else 0.0)
    errors = [train.field.error for train in trains if isinstance(train, PlaneTrain | LineTrain)]
    steps = [train.field.time_step for train in trains if isinstance(train, PlaneTrain | LineTrain)]
    peak, is_regular = _main_peak(waves, systems)
    deviation = float(np.sqrt(variance))
    return ResolvedSea(
        resolution_m=resolution,
        wavenumber_limit=limit,
        variance=variance,
        total_variance=all_variance,
        carried_share=carried,
        variance_share=variance / all_variance if all_variance > 0.0 else 1.0,
        mean_square_slope=float(slopes.sum()),
        total_mean_square_slope=all_slope,
        mean_square_slope_share=float(slopes.sum()) / all_slope if all_slope > 0.0 else 1.0,
        elevation_std=deviation,
        slope_std_east=float(np.sqrt(slopes[0])),
        slope_std_north=float(np.sqrt(slopes[1])),
        elevation_error=float(np.sqrt(sum(error.elevation**2 for error in errors))),
        velocity_error=float(np.sqrt(sum(error.vertical_velocity**2 for error in errors))),
        slope_error=float(np.sqrt(sum(error.slope**2 for error in errors))),
        time_step=min(steps, default=np.inf),
        significant_steepness=4.0 * deviation * peak / (2.0 * np.pi),
        skewness_stokes=(1.5 if is_regular else 3.0) * peak * deviation,
    )


def choppy_facts(surface: ChoppySurface, extent: float, scale: float) -> ChoppyFacts:
    """Statistics over the ground, from labels: a label's water covers det(I + ∇D) of the ground."""
    number = np.arange(_SAMPLES, dtype=np.float64)
    x, y = (extent * np.remainder(number * step, 1.0) for step in _EVEN_STEPS)
    elevation, east, north, east_east, east_north, north_north = surface.waves.sample(
        x,
        y,
        np.zeros(x.size),
        ("elevation", "slope_east", "slope_north", "shift_east_east", "shift_east_north", "shift_north_north"),
    )
    area = (1.0 + east_east) * (1.0 + north_north) - east_north**2
    upright, steady = area > 0.0, area > _ABOUT_TO_FOLD
    # |J⁻¹ ∇η|² = |adj J ∇η|²/det²
    steep = ((1.0 + north_north) * east - east_north * north) ** 2 + (
        (1.0 + east_east) * north - east_north * east
    ) ** 2
    ground = area[upright]
    elevation = elevation[upright]
    elevation = elevation - np.average(elevation, weights=ground)
    variance = float(np.average(elevation**2, weights=ground))
    return ChoppyFacts(
        amplitude_scale=float(np.sqrt(scale)),
        set_down=surface.set_down,
        folded_share=float(np.mean(~upright)),
        elevation_std=float(np.sqrt(variance)),
        skewness=float(np.average(elevation**3, weights=ground)) / variance**1.5 if variance > 0.0 else 0.0,
        mean_square_slope=float(np.sum(steep[steady] / area[steady]) / np.sum(area[steady])),
    )


def _main_peak(regular: Sequence[RegularTrain], systems: Sequence[SpectralSystem]) -> tuple[float, bool]:
    """Wavenumber of the peak of the highest system, rad/m, and whether it is a regular wave; 0 without waves."""
    candidates = [(0.5 * train.amplitude**2, train.wavenumber, True) for train in regular]
    candidates += [(system.variance, system.peak_wavenumber, False) for system in systems if system.variance > 0.0]
    return max(candidates, default=(0.0, 0.0, False))[1:]


def spectrum_dataset(trains: Sequence[WaveTrain], resolved: ResolvedSea) -> xr.Dataset:
    """The expected spectrum of every train, labelled; waves travel along +k. attrs: the resolved facts. A choppy sea's
    is the one that was asked for, before its waves were enlarged.

    `variance_density(ky, kx)` m⁴ of the short-crested systems together, `line_density(line, k)` m³ of the long-crested
    ones with `line_toward`, and amplitude, wavenumber and `sinusoid_toward` of the regular waves.
    """
    import xarray as xr  # takes half a second

    scale = 1.0 if resolved.choppy is None else resolved.choppy.amplitude_scale**2
    planes = [train for train in trains if isinstance(train, PlaneTrain)]
    lines = [train for train in trains if isinstance(train, LineTrain)]
    regular = [train for train in trains if isinstance(train, RegularTrain)]
    kx = planes[0].lattice.east if planes else np.zeros(0)
    ky = planes[0].lattice.north if planes else np.zeros(0)
    plane = planes[0].variance / (scale * planes[0].lattice.step ** 2) if planes else np.zeros((0, 0))
    forward = [line.lattice.east > 0.0 for line in lines]
    k = lines[0].lattice.east[forward[0]] if lines else np.zeros(0)
    density = [
        line.variance[0, ahead] / (scale * line.lattice.step) for line, ahead in zip(lines, forward, strict=True)
    ]
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
                [train.amplitude for train in regular],
                {"units": "m", "long_name": "amplitude of a regular wave"},
            ),
            "sinusoid_wavenumber": (
                "sinusoid",
                [train.wavenumber for train in regular],
                {"units": "rad m-1", "long_name": "wavenumber of a regular wave"},
            ),
            "sinusoid_toward": ("sinusoid", [azimuth_toward(train.toward) for train in regular], toward),
        },
        coords={
            "kx": ("kx", kx, {"units": "rad m-1", "long_name": "wavenumber east"}),
            "ky": ("ky", ky, {"units": "rad m-1", "long_name": "wavenumber north"}),
            "k": ("k", k, {"units": "rad m-1", "long_name": "wavenumber along a line"}),
        },
        attrs=_flat(asdict(resolved)),
    )


def _flat(facts: dict) -> dict:
    """Facts as attributes of a file: those of a group with its name before them, what is not defined left out."""
    plain = {name: value for name, value in facts.items() if value is not None and not isinstance(value, dict)}
    groups = {name: value for name, value in facts.items() if isinstance(value, dict)}
    return plain | {f"{group}_{name}": value for group, inside in groups.items() for name, value in inside.items()}


_LONGEST = 1e-5  # rad/m, beyond every sea wave
_STEPS = 4001  # in ln k: moments are good to 1e-4


class ResolvedWaves(NamedTuple):
    """Waves of the mesh by wavenumber; all arrays (wave,)."""

    wavenumber: NDArray[np.float64]  # rad/m
    frequency: NDArray[np.float64]  # rad/s, for an observer who drifts with the current
    encounter: NDArray[np.float64]  # rad/s, at a fixed point: a current carries the waves past
    variance: NDArray[np.float64]  # m²
    depth: float  # m

    @classmethod
    def of(cls, sea: SeaSettings, limit: float) -> ResolvedWaves:
        """The waves of a sea below a wavenumber `limit` [rad/m], and its regular waves of any length."""
        log_k = np.linspace(np.log(_LONGEST), np.log(limit), _STEPS)
        weight = np.full(_STEPS, log_k[1] - log_k[0])
        weight[[0, -1]] *= 0.5
        systems = [np.empty((3, 0))]  # of wavenumber, variance and current along the waves
        for waves in sea.waves:
            facts = wave_facts(waves, sea.depth_m)
            if facts is None:
                continue
            if isinstance(waves, SinusoidWaves):
                k, power = np.array([2.0 * np.pi / waves.wavelength_m]), np.array([0.125 * waves.height_m**2])
            elif isinstance(waves, RandomWaves):
                k = np.exp(log_k)
                power = k * spectral_system(waves, sea.depth_m).radial(k) * weight
            else:
                continue
            current = sea.current_m_s * np.cos(np.radians(facts.from_deg + 180.0 - sea.current_toward_deg))
            systems.append(np.stack((k, power, np.full(k.size, current))))
        k, variance, current = np.concatenate(systems, axis=1)
        frequency = angular_frequency(k, sea.depth_m)
        return cls(k, frequency, frequency + k * current, variance, sea.depth_m)

    @property
    def elevation_std(self) -> float:
        """Rms elevation, m."""
        return float(np.sqrt(self.variance.sum()))

    def still_sea_error(self, duration_s: float) -> float:
        """Rms height [m] between the sea as a beam meets it within `duration_s` and the sea as it is half-way.

        √2 σ √(1 − ρ(τ)) at the time τ from half-way, with the elevation's correlation ρ(τ) = Σ S cos ωτ/σ² (Longuet-
        Higgins 1957); its mean square over the time is 2 Σ S (1 − sinc ωT/2). 0 for no time, √2 σ for a long one.
        """
        averaging = np.sinc(self.encounter * duration_s / (2.0 * np.pi))
        return float(np.sqrt(2.0 * np.sum(self.variance * (1.0 - averaging))))

    def orbital_speed(self) -> float:
        """Rms speed [m/s] of the water along the look at grazing, ½ Σ ω² S coth² kh (Airy 1845), over all looks."""
        ratio = orbital_ratio(self.wavenumber, self.depth)
        return float(np.sqrt(0.5 * np.sum(self.variance * (self.frequency * ratio) ** 2)))

    def strain_std(self, relaxation_rate: float) -> float:
        """Rms strain of the short waves by these at a relaxation rate μ [1/s]: Σ S k²ω²/(μ² + ω²) ⟨cos⁴⟩.

        Alpers & Hasselmann (1978), see `scattering.breaking`; over all looks cos⁴ is 3/8 in the mean.
        """
        omega2 = self.frequency**2
        transfer = self.wavenumber**2 * omega2 / (relaxation_rate**2 + omega2)
        return float(np.sqrt(0.375 * np.sum(self.variance * transfer)))

    def slopes_lost(self, spacing_m: float) -> float:
        """Rms slope along the look of the waves shorter than twice `spacing_m`; half their mean square slope."""
        lost = self.wavenumber > np.pi / spacing_m
        return float(np.sqrt(0.5 * np.sum(self.variance[lost] * self.wavenumber[lost] ** 2)))
