"""Each facet's radar cross-section and how its scatterers move: the chosen model, its mean brought to the measured one.

The scale between theory and measurement is a property of the run, not of a turn: `calibrated` finds it once, on a patch
of sea as wide as a full circle, and every turn and sector then uses the same. What a narrow sector or a single turn
returns may differ from the mean, as at sea.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compute.machine import run_blocks
from ..conventions import from_db, wrap_degrees
from ..mesh import Facets
from ..scattering import MEAN_MODELS, ShortWaves, mean_level
from ..scattering.bragg import bragg_speed
from ..scattering.breaking import approaching_share, breaker_motion, memory_rate
from ..scattering.calibration import Scale, fit_scale
from ..scattering.composite import CompositeSea
from ..scattering.permittivity import permittivity_of
from ..settings import RadarSettings, ScatteringSettings
from ..tracing import Illumination
from .speckle import Motion
from .spike_field import SpikeField
from .texture_field import TextureField

_NEAREST = 0.8  # of the near gate's range, from which on facets count for the calibration
_DEGREE = 5  # of the scale in log grazing: within 0.3 dB of the mean over two decades (`validation/scattering/nrcs.py`)
_DARK = np.float32(1e-30)  # m², of which there is no share


class Returns(NamedTuple):
    """What the facets of a turn return."""

    rcs: NDArray[np.float32]  # (column, facet) m², of facets that some ray reaches, else 0
    motion: Motion | None  # of the scatterers relative to the water; None where they move with it
    running: NDArray[np.float32] | None = None  # (column, facet or 1) m/s outward, of all scatterers, beside `motion`


class Terms(NamedTuple):
    """Radar cross-sections (column, facet) m² before calibration, by what scatters; 0 where no ray arrives."""

    bragg: NDArray[np.float32]
    specular: NDArray[np.float32]
    breaking: NDArray[np.float32]


@dataclass(frozen=True)
class SeaSurface:
    """How the sea of a run scatters: made once, called every turn."""

    scattering: ScatteringSettings
    radar: RadarSettings
    resolved_below: float  # rad/m, where the waves of the mesh end and those on its facets begin
    scale: Scale | None = None
    strain_variance: float = 0.0
    spikes: SpikeField | None = None  # None: breakers are a share of each facet
    texture: TextureField | None = None  # None: they gather on the resolved waves alone

    def __call__(self, facets: Illumination, strain: NDArray[np.float32] | None) -> Returns:
        """Radar cross-sections and motion of traced facets. strain (column, facet): of their mesh."""
        if self.scattering.nrcs == "constant":
            power = np.where(_reached(facets), _visible_power(facets, self.even_power(facets)), np.float32(0.0))
            return Returns(np.ascontiguousarray(power), self.motion_of(facets, None), self.drift(facets))
        if self.scattering.nrcs != "two_scale":
            power = self._scaled(facets, self._mean_power(facets))
            return Returns(power, self.motion_of(facets, None), self.drift(facets))
        lit = None if self.spikes is None else self.spikes.evaluate(facets)
        bright = None if lit is None else lit.factor
        if self.texture is not None:
            patches = self.texture.evaluate(facets, self.grazing(facets))
            bright = patches if bright is None else patches * bright
        rcs, breaking = (np.zeros(facets.height.shape, dtype=np.float32) for _ in range(2))
        scale, parts = self.scale, None
        if scale is not None:
            given = scale.terms(self.grazing(facets), self.wind(facets)[:, 0])
            parts = tuple(each.astype(np.float32) for each in given)

        def fill(reached: ReachedFacets, terms: Terms) -> None:
            broken = terms.breaking if bright is None else terms.breaking * reached.select(bright)
            total = terms.bragg + terms.specular + broken
            reached.put(breaking, broken / np.maximum(total, _DARK))
            if scale is not None and parts is not None:
                level, depth, flat, lean = parts
                column, facet = reached.column, reached.facet
                total = total * scale.factor(level[facet], depth[facet], flat[column], lean[column])
            reached.put(rcs, total)

        self._visit_blocks(facets, strain, fill)
        motion = self.motion_of(facets, breaking if self.scattering.breaking else None)
        running = self.drift(facets)
        if lit is not None and motion is not None:
            # A spike runs at its own speed. The facet as a whole is given what its mean speed then differs by.
            beyond = lit.speed - motion.breaker_speed[:, None].astype(np.float32)
            running = np.asarray(breaking * beyond + (0.0 if running is None else running), dtype=np.float32)
        return Returns(rcs, motion, running)

    @property
    def needs_calibration(self) -> bool:
        """Something is estimated over a wide area: the scale to the measured mean, or the strain's variance."""
        return self.scattering.nrcs != "constant"

    def calibrated(
        self,
        facets: Illumination,
        strain: NDArray[np.float32] | None,
        columns: NDArray[np.bool_] | slice = slice(None),
    ) -> SeaSurface:
        """The same surface with the scale that brings the mean echo of these facets to the empirical model; by
        direction too, if the model knows it.

        facets, strain: of an area so wide that its mean is the sea's; columns: of these alone.
        """
        variance = 0.0 if strain is None else float(np.mean(np.square(strain[columns], dtype=np.float64)))
        known = replace(self, strain_variance=variance)
        model = self.scattering.mean_model
        if model is None:
            return known
        two_scale = self.scattering.nrcs == "two_scale"
        power = np.sum(known.terms(facets, strain), axis=0) if two_scale else self._mean_power(facets)
        received = power * two_way_power(facets)
        target = np.broadcast_to(self.mean(facets), power.shape)
        # What lies nearer than the gates gives no echo, and would bias the fit.
        in_window = np.hypot(facets.distance, self.radar.height_m) >= _NEAREST * self.radar.range_m[0]
        grazing, area = self.grazing(facets)[in_window], facets.horizontal_area[in_window]
        received, target = (each[columns][:, in_window] for each in (received, target))
        wind = self.wind(facets)[columns] if MEAN_MODELS[model].knows_wind_direction else None
        scale = fit_scale(received, area, target, grazing, wind, degree=_DEGREE)
        return replace(known, scale=scale)

    @property
    def memory_rate(self) -> float | None:
        """Rate [1/s] at which the short waves relax from the long ones' strain; None where it does not matter."""
        return memory_rate(self.scattering, self.radar.frequency_hz)

    def terms(self, facets: Illumination, strain: NDArray[np.float32] | None) -> Terms:
        """What theory gives, by what scatters. strain (column, facet): of the facets' mesh; None for none."""
        terms = Terms(*(np.zeros(facets.height.shape, dtype=np.float32) for _ in Terms._fields))

        def fill(reached: ReachedFacets, found: Terms) -> None:
            for term, values in zip(terms, found, strict=True):
                reached.put(term, values)

        self._visit_blocks(facets, strain, fill)
        return terms

    def _visit_blocks(
        self,
        facets: Illumination,
        strain: NDArray[np.float32] | None,
        take: Callable[[ReachedFacets, Terms], None],
    ) -> None:
        """Give away the terms of the facets that some ray reaches, block by block of columns."""
        sea, reached, wind = self.composite, _reached(facets), self.wind(facets)[:, 0]
        level = facets.grid.column_height[:, 0]
        along, across = np.cos(wind).astype(np.float32), np.sin(wind).astype(np.float32)
        distance, area = facets.distance.astype(np.float32), facets.horizontal_area.astype(np.float32)

        def work(begin: int, end: int) -> None:
            found = ReachedFacets.of_block(reached, begin, end)
            column, facet = found.column, found.facet
            if facets.ray_slope is None:
                fall = (level[column] - found.select(facets.height)).astype(np.float32) / distance[facet]
            else:
                fall = found.select(facets.ray_slope).astype(np.float32)
            look, cross = (found.select(each).astype(np.float32) for each in (facets.slope_look, facets.slope_cross))
            sine = 1.0 / np.sqrt(1.0 + fall * fall)  # of the incidence
            squeezed = np.zeros(1, dtype=np.float32) if strain is None else found.select(strain)
            levels = sea.nrcs(sine, fall * sine, look, cross, along[column], across[column], squeezed)
            true_area = area[facet] * np.sqrt(1.0 + look * look + cross * cross)
            if facets.facing_in_sight is not None:  # tilts that turn away are among those that σ0 is the mean of
                true_area *= found.select(facets.facing_in_sight)
            take(found, Terms(*(each * true_area for each in levels)))

        run_blocks(work, len(reached))

    def mean(self, facets: Facets) -> NDArray[np.float64]:
        """The empirical model's mean σ0 (column or 1, facet), linear, at the grazing of mean sea level.

        Raises ValueError where the settings name no empirical model.
        """
        if self.scattering.mean_model is None:
            raise ValueError(f"scattering.nrcs = '{self.scattering.nrcs}': no empirical model sets its mean")
        grazing, wind = np.degrees(self.grazing(facets))[None, :], self.wind(facets)
        return mean_level(self.scattering, grazing, self.radar.frequency_hz, wind_angle=wind)

    def _mean_power(self, facets: Illumination) -> NDArray[np.float32]:
        return np.where(_reached(facets), _visible_power(facets, self.even_power(facets)), 0.0)

    def even_power(self, facets: Facets) -> NDArray[np.float32]:
        """Radar cross-sections [m²] of whole facets, lit or not, where they do not depend on the waves: (column or 1,
        facet), or (facet,)."""
        if self.scattering.nrcs == "constant":
            return np.float32(from_db(self.scattering.nrcs_db)) * facets.horizontal_area.astype(np.float32)
        return (self.mean(facets) * facets.horizontal_area).astype(np.float32)

    def _scaled(self, facets: Facets, power: NDArray[np.float32]) -> NDArray[np.float32]:
        if self.scale is None:
            return power
        return power * self.scale(self.grazing(facets), self.wind(facets)).astype(np.float32)

    @property
    def composite(self) -> CompositeSea:
        """What the two-scale model takes of the sea as a whole."""
        return CompositeSea.of(
            self.radar.frequency_hz,
            self.permittivity,
            self.scattering.polarization,
            self.short_waves,
            self.strain_variance,
            self.scattering.breaking,
        )

    def grazing(self, facets: Facets) -> NDArray[np.float64]:
        """(facet,) rad, to mean sea level: the scale must not follow the waves."""
        return np.arctan2(self.radar.height_m, facets.distance)

    def wind(self, facets: Facets) -> NDArray[np.float64]:
        """(column, 1) rad: 0 looks into the wind."""
        return np.radians(wrap_degrees(facets.grid.column_azimuth - self.scattering.wind_from_deg))[:, None]

    @cached_property
    def permittivity(self) -> complex:
        """ε′ − jε″ of the water at the radar's frequency, relative to vacuum."""
        return permittivity_of(self.scattering, self.radar.frequency_hz)

    @cached_property
    def short_waves(self) -> ShortWaves:
        """The spectrum of the waves that the mesh does not resolve."""
        return ShortWaves.of(self.scattering, self.resolved_below)

    def drift(self, facets: Facets) -> NDArray[np.float32] | None:
        """(column, 1) m/s outward, of the water's skin before the wind; None where scatterers only ride on the waves.

        The resolved waves carry none of it: to the first order water runs round closed orbits, at a place (linear) or
        with a particle (choppy). So it is the whole of friction and Stokes' drift that is added.
        """
        if self.scattering.doppler == "orbital" or self.scattering.wind_drift == 0.0:
            return None
        speed = self.scattering.wind_drift * self.scattering.wind_speed_m_s
        return (-speed * np.cos(self.wind(facets))).astype(np.float32)

    def motion_of(self, facets: Facets, breaking: NDArray[np.float32] | None) -> Motion | None:
        """Of the scatterers relative to the water. breaking (column, facet): share of a facet's power from breakers."""
        if self.scattering.doppler == "orbital":
            return None
        wind = self.wind(facets)[:, 0]
        speed, spread = breaker_motion(
            self.scattering.wind_speed_m_s, self.scattering.inverse_wave_age, self.radar.frequency_hz
        )
        if self.spikes is not None:
            speed, spread = self.spikes.spikes.left_speed, self.spikes.spikes.left_spread
        return Motion(
            bragg_speed=bragg_speed(self.radar.frequency_hz),
            approaching=approaching_share(wind),
            breaking=breaking,
            breaker_speed=-speed * np.cos(wind),  # they run down-wind
            breaker_spread=spread,
        )


class ReachedFacets(NamedTuple):
    """The facets of some columns that a ray reaches."""

    columns: slice
    column: NDArray[np.int32]  # (n,) of each
    facet: NDArray[np.int32]
    place: NDArray[np.intp]  # among all of these columns, one after the other

    @classmethod
    def of_block(cls, reached: NDArray[np.bool_], begin: int, end: int) -> ReachedFacets:
        """The reached facets of the columns from `begin` to `end`. reached: (column, facet)."""
        part = reached[begin:end]
        place = np.flatnonzero(part)
        column = np.repeat(np.arange(len(part), dtype=np.int32), np.count_nonzero(part, axis=1))
        facet = (place - column * np.intp(part.shape[1])).astype(np.int32)
        return cls(slice(begin, end), column + np.int32(begin), facet, place)

    def select(self, field: NDArray[Any]) -> NDArray[Any]:
        """A field (column, facet) on them (n,)."""
        return field[self.columns].reshape(-1).take(self.place)

    def put(self, field: NDArray[Any], values: NDArray[Any]) -> None:
        """Write values (n,) into a field (column, facet)."""
        field[self.columns].reshape(-1)[self.place] = values


def two_way_power(facets: Illumination) -> NDArray[np.float32]:
    """Share (column, facet) of the power that reaches a facet and comes back, the mean over the pairs of antennas."""
    light = facets.lit.astype(np.float32) if facets.field is None else np.square(np.abs(facets.field))
    return np.square(light.mean(axis=0, dtype=np.float32))


def _visible_power(facets: Illumination, whole: NDArray[np.float32]) -> NDArray[np.float32]:
    """Echo of whole facets, less the part that waves on them hide."""
    return whole if facets.in_sight is None else whole * facets.in_sight


def _reached(facets: Illumination) -> NDArray[np.bool_]:
    """(column, facet): a ray arrives from either antenna, straight or over an edge."""
    return np.asarray(facets.reached.any(axis=0))


@dataclass
class TurnAccumulator:
    """The light and the returns of a turn of so many columns, gathered from its parts into arrays that are made once; a
    turn in one part is handed through.

    Arrays that each part brings, kept to be joined after the last, would lie among those that are made and dropped for
    every part. The holes between them are too small for what a whole turn needs next, and count as memory that is held:
    0.1 to 0.2 GB of a turn of ten million facets.
    """

    columns: int
    _arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    _last: tuple[Illumination, Returns] | None = None
    _rays: int = 0

    def add(self, columns: slice, light: Illumination, returns: Returns) -> None:
        """Take in neighbouring columns, the next ones."""
        self._last, self._rays = (light, returns), self._rays + light.rays
        if columns == slice(0, self.columns):
            return
        motion = returns.motion
        by_facet = {**light.light, "rcs": returns.rcs, "running": returns.running}
        by_column = {}
        if motion is not None:
            by_facet["breaking"] = motion.breaking
            by_column = {"approaching": motion.approaching, "breaker_speed": motion.breaker_speed}
        for name, values in by_facet.items():
            if values is not None:
                self._whole(name, values, -2)[..., columns, :] = values
        for name, values in by_column.items():
            self._whole(name, values, -1)[columns] = values

    def _whole(self, name: str, part: NDArray[Any], axis: int) -> NDArray[Any]:
        if name not in self._arrays:
            shape = list(part.shape)
            shape[axis] = self.columns
            self._arrays[name] = np.empty(shape, part.dtype)
        return self._arrays[name]

    def collect(self, facets: Facets) -> tuple[Illumination, Returns]:
        """The light of the turn on its facets, and what they return. RuntimeError where nothing was gathered."""
        if self._last is None:
            raise RuntimeError("no part of the turn was added")
        (light, returns), of = self._last, self._arrays.get
        light = light.with_facets(facets)
        if not self._arrays:
            return light, returns
        found = {name: of(name) for name in light.light}
        motion = returns.motion
        if motion is not None:
            same = {name: of(name) for name in ("approaching", "breaking", "breaker_speed")}
            motion = replace(motion, **same)
        return replace(light, **found, rays=self._rays), Returns(self._arrays["rcs"], motion, of("running"))
