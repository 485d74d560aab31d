"""Drawing a sea: from the scene's wave systems to the waves of one realisation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from ..conventions import unit_from_azimuth
from ..errors import must_be
from ..settings import RandomWaves, SeaSettings, SinusoidWaves, check_grid
from .choppy import ChoppySurface, Displacement, check_folding, height_keeping_scale
from .facts import choppy_facts, resolved_facts
from .fields import Kind, RelaxedShift
from .lattice import LINE_REPEATS, Lattice, draw_amplitudes, line_variance, plane_variance
from .moving_field import MovingField
from .surface import Sea
from .systems import SpectralSystem, spectral_system, travel_direction
from .wave_trains import LinearSurface, LineTrain, PlaneTrain, RegularTrain, WaveTrain

SPLINE_ORDER, OVERSAMPLING = 7, 1.25  # chosen from validation/sea/sea_speed.py
FASTER = 5, 1.125  # a fifth less time, six times the error
_WITHIN = 0.05, 0.05  # what that may be, of the height error allowed and of the rms slope
LINE_ORDER, LINE_OVERSAMPLING = 5, 2.0  # a line takes little time
_KEPT_REACH = 700  # waves to either side of the middle, 16 MB in all
_NEGLIGIBLE = 1e-12  # of a system's variance: so little resolved is nothing


def realize(
    settings: SeaSettings,
    seed: int | np.random.SeedSequence,
    height_error_m: float = 0.0,
    relaxation_rate: float | None = None,
) -> Sea:
    """Draw one sea. The same settings and seed give the same bits; systems draw independently of each other.

    height_error_m: what a run's heights may err by. Where a coarser grid of short-crested waves adds no more than a
    twentieth of that, and of the slopes, the sea is interpolated from it, in a fifth less time; `Sea.resolved` has the
    errors. relaxation_rate: 1/s of the relaxed shift that a run will ask for: heights and flow then follow from that
    same field, which changes them by less than their errors.

    Raises ValueError where extent_m is too small for a system's waves, where energy_fraction asks for a grid beyond
    memory, and where choppy waves would break over too much of the surface.
    """
    must_be("settings", settings, SeaSettings, "SeaSettings, as scene.sea")
    systems = {
        number: spectral_system(waves, settings.depth_m)
        for number, waves in enumerate(settings.waves)
        if isinstance(waves, RandomWaves)
    }
    regular = [
        _sinusoid(waves, settings.depth_m)
        for waves in settings.waves
        if isinstance(waves, SinusoidWaves) and waves.height_m > 0.0
    ]
    spacing = resolution(settings)
    if settings.model == "recorded":
        return _record_sea(settings, spacing, next(iter(systems.values())))
    random = _draw(settings, systems, spacing, seed)
    scale = 1.0
    base: Kind = "shift" if settings.model == "choppy" else "potential"
    if relaxation_rate is not None:
        base = RelaxedShift(relaxation_rate)
    if settings.model == "choppy":
        random, scale = _restore_variance(random, regular)
    trains: list[WaveTrain] = [*(waves.train(height_error_m, base) for waves in random), *regular]
    resolved = resolved_facts(
        trains,
        list(systems.values()),
        spacing,
        scale=scale,
        carried=min((waves.carried for waves in random), default=1.0),
    )
    east, north = unit_from_azimuth(settings.current_toward_deg)
    current = (settings.current_m_s * float(east), settings.current_m_s * float(north))
    linear = LinearSurface(tuple(trains))
    if settings.model == "linear" or not trains:
        return Sea(trains, linear, resolved, current)

    drawn = sum((waves.displacement(expected=False) for waves in random), Displacement.none())
    drawn = sum((Displacement.of_regular(wave) for wave in regular), drawn)
    surface = ChoppySurface(linear, drawn, max([np.pi / spacing, *(2.0 * wave.wavenumber for wave in regular)]))
    facts = choppy_facts(surface, settings.extent_m, scale)
    check_folding(facts.folded_share)
    return Sea(trains, surface, replace(resolved, choppy=facts), current)


def _record_sea(settings: SeaSettings, spacing: float, system: SpectralSystem) -> Sea:
    """The sea of a file. spacing [m]: of the waves that are kept; system: their spectrum. Raises InputError."""
    from ..io.recorded_sea import recorded_sea  # loads what reads files
    from .continued import ContinuedPatch
    from .recorded import check_frames, duration_s, gap_error, recorded_train, start_of

    file = recorded_sea(settings.file)
    source = ContinuedPatch(file, settings.beyond)
    start = start_of(file, settings.start_s)
    begin = file.begin_s + start[0] * file.step_s + start[1]
    train, variance, gap = recorded_train(source, spacing, settings.depth_m, *start)
    resolved = resolved_facts([train], [system], spacing)
    deviation = float(np.sqrt(variance))
    check_frames(file, resolved.elevation_error, deviation)
    resolved = replace(
        resolved,
        variance=variance,
        elevation_std=deviation,
        mean_square_slope_share=min(1.0, resolved.mean_square_slope_share),
        variance_share=min(1.0, variance / resolved.total_variance) if resolved.total_variance > 0.0 else 1.0,
        significant_steepness=resolved.significant_steepness * deviation / max(resolved.elevation_std, 1e-12),
        filled_m=2.0 * gap,
        filled_error=gap_error(train.lattice, train.variance, gap),
        record_start_s=begin,
        record_start=file.time_in_words(begin),
    )
    ends_s = duration_s(file, settings.start_s)
    return Sea([train], LinearSurface((train,)), resolved, ends_s=ends_s, patch=None if file.periodic else file)


def resolution(settings: SeaSettings) -> float:
    """Spacing of the resolved waves' grid [m]: as given, or such that the share `energy_fraction` of all waves'
    variance is resolved. Raises ValueError where that grid would not fit memory."""
    if settings.resolution_m is not None:
        return settings.resolution_m
    fraction = settings.energy_fraction
    assert fraction is not None
    systems = [spectral_system(waves, settings.depth_m) for waves in settings.waves if isinstance(waves, RandomWaves)]
    regular = sum(waves.height_m**2 / 8.0 for waves in settings.waves if isinstance(waves, SinusoidWaves))
    log_k = np.linspace(np.log(1e-5), np.log(1e5), 200_001)
    k = np.exp(log_k)
    density = k * np.sum([system.radial(k) for system in systems] or [np.zeros(k.size)], axis=0)
    below = scipy.integrate.cumulative_trapezoid(density, log_k, initial=0.0)
    wanted = fraction * (regular + below[-1]) - regular
    if wanted <= 0.0:  # regular waves, which are resolved whatever the grid, are enough
        return settings.extent_m / 64.0
    last = max(1, int(np.searchsorted(below, wanted)))
    share = (wanted - below[last - 1]) / (below[last] - below[last - 1])
    spacing = float(np.pi / np.exp(log_k[last - 1] + share * (log_k[last] - log_k[last - 1])))
    check_grid(settings.extent_m, spacing, fraction)
    return spacing


@dataclass(frozen=True)
class _Random:
    """The waves of a lattice, drawn: the plane of all short-crested systems, or the line of a long-crested one."""

    lattice: Lattice
    variance: NDArray[np.float64]  # (row, column) m², expected of each wave
    amplitude: NDArray[np.complex128]  # (row, column) m
    toward: tuple[float, float]  # unit vector along which the lattice's columns run
    carried: float  # share of the variance that the lattice found of the spectrum, before it was scaled

    def train(self, height_error_m: float, base: Kind) -> WaveTrain:
        """The waves, ready to be evaluated."""
        if self.lattice.line:
            field = self._field(base, LINE_ORDER, LINE_OVERSAMPLING)
            return LineTrain(self.lattice, self.variance, self.amplitude, field, self.toward)
        field = self._field(base, *FASTER) if height_error_m > 0.0 else None
        if field is None or not self._is_within(field, height_error_m):
            field = self._field(base, SPLINE_ORDER, OVERSAMPLING)
        return PlaneTrain(self.lattice, self.variance, self.amplitude, field)

    def _field(self, base: Kind, order: int, oversampling: float) -> MovingField:
        return MovingField(
            self.lattice, self.amplitude, self.variance, order=order, oversampling=oversampling, base=base
        )

    def _is_within(self, field: MovingField, height_error_m: float) -> bool:
        """Whether heights and slopes err by no more than is allowed."""
        east, north = self.lattice.east[None, :], self.lattice.north[:, None]
        slopes = np.sqrt([np.sum(self.variance * axis**2) for axis in (east, north)])
        heights = field.error.elevation <= _WITHIN[0] * height_error_m
        return bool(heights and field.error.slope <= _WITHIN[1] * slopes.max())

    def scaled(self, factor: float) -> _Random:
        """The same waves with `factor` times the variance."""
        return replace(self, variance=factor * self.variance, amplitude=np.sqrt(factor) * self.amplitude)

    def displacement(self, *, expected: bool) -> Displacement:
        """Moments of the waves as expected, or as realised."""
        variance = self.variance if expected else 0.5 * np.abs(self.amplitude) ** 2
        along, across = self.lattice.east[None, :], self.lattice.north[:, None]
        east = along * self.toward[0] - across * self.toward[1]
        north = along * self.toward[1] + across * self.toward[0]
        return Displacement.of(east, north, variance, self.lattice.depth)


def _draw(
    settings: SeaSettings, systems: Mapping[int, SpectralSystem], spacing: float, seed: int | np.random.SeedSequence
) -> list[_Random]:
    """The random waves: the plane of all short-crested systems first, then a line for each long-crested one."""
    root = seed if isinstance(seed, np.random.SeedSequence) else np.random.SeedSequence(seed)
    limit = np.pi / spacing
    plane = Lattice(settings.extent_m, limit, settings.depth_m)
    line = Lattice(LINE_REPEATS * settings.extent_m, limit, settings.depth_m, line=True)
    lines: list[_Random] = []
    plane_waves: list[tuple[NDArray[np.float64], NDArray[np.complex128]]] = []
    carried = 1.0
    for number, system in systems.items():
        # As root.spawn would, but without counting in the caller's object: a second call gives the same sea.
        child = np.random.SeedSequence(root.entropy, spawn_key=(*root.spawn_key, number), pool_size=root.pool_size)
        resolved = system.moment(0, limit)
        if resolved <= _NEGLIGIBLE * system.variance:
            continue
        if system.spreading is None:
            variance, share = line_variance(line, system.radial, resolved)
            lines.append(_Random(line, variance, draw_amplitudes(line, variance, child), system.toward, share))
        else:
            of_system = system.radial, system.spreading, system.toward, resolved
            small = plane.reach[0] <= _KEPT_REACH
            variance, share = (_kept_plane_variance if small else plane_variance)(plane, *of_system)
            plane_waves.append((variance, draw_amplitudes(plane, variance, child)))
            carried = min(carried, share)
    if not plane_waves:
        return lines
    variance = np.sum([expected for expected, _ in plane_waves], axis=0)
    amplitude = np.sum([drawn for _, drawn in plane_waves], axis=0)
    return [_Random(plane, variance, amplitude, (1.0, 0.0), carried), *lines]


_kept_plane_variance = lru_cache(maxsize=4)(plane_variance)  # for the next seed of a sea that does not fill the memory


def _restore_variance(random: list[_Random], regular: list[RegularTrain]) -> tuple[list[_Random], float]:
    """Random waves made larger, so that displaced sideways they still have the variance over the ground."""
    expected = sum((waves.displacement(expected=True) for waves in random), Displacement.none())
    beside = sum((Displacement.of_regular(wave) for wave in regular), Displacement.none())
    variance = sum(float(waves.variance.sum()) for waves in random)
    scale = height_keeping_scale(variance, expected.covariance, beside.covariance)
    return [waves.scaled(scale) for waves in random], scale


def _sinusoid(waves: SinusoidWaves, depth: float) -> RegularTrain:
    return RegularTrain(
        amplitude=0.5 * waves.height_m,
        wavenumber=2.0 * np.pi / waves.wavelength_m,
        phase=float(np.radians(waves.phase_deg)),
        toward=travel_direction(waves),
        depth=depth,
    )
