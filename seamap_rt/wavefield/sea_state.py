"""Sea state from maps: significant height, periods, direction and spread of the waves, each with a standard error.

Heights are about mean sea level, which is known: their mean square needs no mean of its own, and hardly depends on
which half of the sea is in sight, since what crests have too much, the troughs that they hide have too little.
Periods follow from wavelengths by the linear dispersion of the depth that travels with the maps.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.special import chdtri, gammaln

from ..conventions import written
from ..dataset import WATER_ATTRIBUTES, group_of
from ..physics.dispersion import Water
from .map_limits import Resolution, hindrance
from .periodogram import Periodogram, mean_periodogram
from .range_bins import PolarMap, RangeBins
from .system_likelihood import find_systems
from .wave_direction import Travel, travel
from .wave_spectrum import Field, Transforms, WaveSpectrum, wave_spectrum
from .wave_systems import Heights, WaveSystems

_UNSEEN = 0.16  # relative error of the variance by what is not in sight, of its share
_NOISE_KNOWN = 0.2  # relative standard error of the stated error variances
_TRANSFER_KNOWN = 0.2  # of what is added for the waves that a cell averages away
_LEAST_TRANSFER = 0.25  # of the variance: shorter waves are not in the map, but follow from the longer ones
_TAIL_FROM = 2.0  # times the peak's wavenumber: shorter waves hold at least what a wind sea's do
_CORE_OVER_TAIL = 2.76  # what it holds between half that and that over what is beyond (Hasselmann et al. 1973)
_STEP = 1.3  # from one wavenumber to the next, of waves too short to be seen
_MEMORY_S = 120.0  # of which a sea is the same
_BACK = (1, 2, 3, 5, 9, 17)  # turns that are compared as they are: now, and longer and longer ago
_AVERAGED = 10  # of which periodograms are averaged
_FADED, _FADED_LINE = 1.02, 1.75  # of the reach, where heights have faded; a line's standard deviation, times the reach
_FEW, _RESOLVED = 6.0, 11.0  # modes of a regular wave, and kR from which on a circle tells it from a short swell
_FEWEST = 3.0  # independent heights, with which a mean square tells a variance
_SIDE_M = 3.0  # of squares on which waves are sorted by the way they run
_NEEDED = ("turn", "azimuth", "range", "height", "height_std", "ground_range", "quality", "time")
_LEAST_SPAN = 80.0  # deg of looks: fewer do not tell waves of all directions apart

_VARIABLES = {
    "significant_wave_height": ("m", "four standard deviations of the sea", "sea_surface_wave_significant_height"),
    "peak_period": (
        "s",
        "period of the spectrum's peak",
        "sea_surface_wave_period_at_variance_spectral_density_maximum",
    ),
    "mean_direction": ("degree", "mean azimuth the waves come from", "sea_surface_wave_from_direction"),
    "directional_spread": ("degree", "circular spread of the directions", "sea_surface_wave_directional_spread"),
    "significant_wave_height_std": ("m", "standard error of the height, of the sea at large", None),
    "significant_wave_height_sampling": ("m", "part of that: what so much sea in so long differs by", None),
    "significant_wave_height_measurement": ("m", "part of that: of the height of the sea that was seen", None),
    "significant_wave_height_least": ("m", "what the height is at least, where no error can be told", None),
    "independent": ("1", "independent heights that the sea that was seen is worth", None),
    "peak_period_std": ("s", "standard error of the peak period", None),
    "mean_direction_std": ("degree", "standard error of the mean direction", None),
    "directional_spread_std": ("degree", "standard error of the spread", None),
    "mean_axis": ("degree", "azimuth or its opposite the waves come from, 0 to 180", None),
    "raw_height": ("m", "four standard deviations of all heights of the map", None),
    "noise_height": ("m", "what errors of the heights alone would give, over the range used", None),
    "transfer": ("1", "share of the sea's variance that the map's cells keep", None),
    "seen_share": ("1", "share of the sea in sight, over the range used", None),
    "range_first": ("m", "begin of the range used", None),
    "range_last": ("m", "end of the range used", None),
    "cells": ("1", "cells used", None),
}


def sea_state(maps: xr.DataTree) -> xr.Dataset:
    """Significant wave height, peak period, mean direction and spread after each turn, with standard errors, dims
    (turn,).

    maps: as from `retrieve`, of an antenna that moves slowly beside the waves. Their attributes `depth_m` and
    `current_m_s` (east, north) say what the waves run on; where no depth is given deep water is assumed, and the
    attribute `depth_given` of the result is 0. Periods are those met by one who drifts with the current.

    Each turn's numbers are of the turns up to it, for two minutes at most: a cell's record in time tells waves longer
    than the circle in sight, of which one turn holds a part. Standard errors are against the sea at large, of which so
    much in so long is a sample; `significant_wave_height_sampling` is that part of the height's. Where a sample is too
    small for that (fewer than three independent heights), the height is NaN and `significant_wave_height_least` says
    what it is at least, at 97.5 % confidence.
    Where too little is seen, or too noisy, all is NaN, and the attribute `unknown` says why and what would mend it; of
    a calm sea, and of looks that span less than 80°, the period and directions are NaN. Mean direction and spread are
    NaN as well where nothing tells which way the waves run; `mean_axis` needs none.

    Raises SchemaError for maps without one of the fields it reads, or with one of another kind.

    Method: mean square about mean sea level, less that of the errors (of heights that are the mean of what may be,
    given the echoes, plus that of what they leave open), over the share that cells keep of the spectrum; period and
    directions by the wave systems of which the sea most likely is the sum (`wave_systems`).
    """
    polar = group_of(maps, "maps/polar", _NEEDED)
    water = water_of(polar.attrs)
    record = SeaStateRecord(water, polar.sizes["turn"])
    rows = [record.row(polar.isel(turn=turn)) for turn in range(polar.sizes["turn"])]
    known = {name: polar.attrs.get(name, missing) for name, (missing, _) in WATER_ATTRIBUTES.items()}

    def variable(name: str) -> tuple[str, Field, dict[str, str]]:
        units, long_name, standard_name = _VARIABLES[name]
        attributes = {"long_name": long_name, "units": units}
        if standard_name:
            attributes["standard_name"] = standard_name
        return "turn", np.array([row.get(name, np.nan) for row in rows]), attributes

    unknown = [turn for turn, row in enumerate(rows) if not np.isfinite(row.get("noise_height", np.nan))]
    why = {"unknown": hindrance(polar.isel(turn=unknown[-1]))} if unknown else {}
    return xr.Dataset(
        {name: variable(name) for name in _VARIABLES}, {"turn": polar["turn"]}, {"Conventions": "CF-1.11"} | known | why
    )


def water_of(attributes: Mapping[Hashable, Any]) -> Water:
    """The water that a map's attributes name; deep and at rest where they name none."""
    depth, current = (attributes.get(name, WATER_ATTRIBUTES[name][0]) for name in ("depth_m", "current_m_s"))
    east, north = (float(part) for part in current)
    return Water(float(depth), (east, north))


@dataclass(frozen=True)
class TurnSpectrum:
    """What one turn's polar map shows of the waves."""

    spectrum: WaveSpectrum  # what the map's cells keep of it is taken back
    direction: Travel
    polar_map: PolarMap
    bins: RangeBins
    transfer: Field  # (ring,) share of waves' variance that the map's cells hold
    held_share: Field  # (bin,) share of the waves' variance that cells at that distance hold
    water: Water
    inside: NDArray[np.bool_]  # (look, gate) of cells that waves are sorted by

    @classmethod
    def of(cls, polar: xr.Dataset, water: Water) -> TurnSpectrum | None:
        """The spectrum of the polar map of one turn; None where too little is in sight."""
        polar_map = PolarMap.of(polar)
        bins = RangeBins.of(polar_map)
        if bins is None or not bins.used.any():
            return None
        inside = polar_map.known & bins.covers(bins.glimpsed, polar_map.distance)
        direction = _travel(polar, polar_map, inside)
        spectrum = wave_spectrum(Transforms.of(polar_map.cells(inside)), direction, water)
        resolution = Resolution.of(polar.attrs, np.degrees(polar_map.width))
        overall = bins.weight(bins.glimpsed) @ resolution.transfer(spectrum.ring_wavenumber, bins.middle)
        spectrum = spectrum.corrected(overall, _LEAST_TRANSFER)
        held_share = _kept_variance_share(spectrum, overall, resolution, bins.middle)
        return cls(spectrum, direction, polar_map, bins, overall, held_share, water, inside)

    @property
    def height(self) -> float:
        """m, four standard deviations of the sea."""
        return _height(self.polar_map, self.bins, self.held_share)["significant_wave_height"]

    @property
    def visible_share(self) -> float:
        """Share of the sea in sight, over the range used."""
        return float(self.bins.weight(self.bins.used) @ self.bins.seen)

    @property
    def has_waves(self) -> bool:
        """Whether the waves stand out of the heights' errors."""
        weight = self.bins.weight(self.bins.used)
        # Heights that are a conditional mean hold nothing of a sea that noise hides.
        least = 2.0 if self.polar_map.conditional else 2.0 * _NOISE_KNOWN
        return bool(weight @ self.bins.waves > least * (weight @ self.bins.noise))

    def _heights(self, chosen: NDArray[np.bool_]) -> Heights:
        cells, place = self.polar_map.cells(chosen), self.polar_map.place
        x, y = cells.x + place[cells.look, 0], cells.y + place[cells.look, 1]
        return Heights(x, y, cells.time, cells.height, self.polar_map.noise[chosen], cells.weight)

    @cached_property
    def heights(self) -> Heights:
        """Heights of the cells that waves are sorted by."""
        return self._heights(self.inside)

    @cached_property
    def heights_used(self) -> Heights:
        """Heights of the cells that the waves' height is taken from."""
        return self._heights(self.polar_map.known & self.bins.covers(self.bins.used, self.polar_map.distance))

    @cached_property
    def periodogram(self) -> Periodogram:
        """The periodogram by rings and directions, of heights that fade towards the edge, lest long waves leak."""
        cells = self.polar_map.cells(self.inside)
        faded = cells.weight * (1.0 - (np.hypot(cells.x, cells.y) / (_FADED * cells.reach)) ** 2)
        area = float(faded.sum() ** 2 / np.sum(faded**2 / cells.weight))
        modes = wave_spectrum(Transforms.of(replace(cells, weight=faded)), self.direction, self.water)
        return Periodogram.of(modes, self._transfer_at, area, _FADED_LINE / cells.reach)

    @property
    def regular(self) -> bool:
        """Whether its waves are one line, which the circle resolves: no spectrum of a sea."""
        peak = 2.0 * np.pi * self.spectrum.peak_frequency
        if not np.isfinite(peak) or self.spectrum.independent > _FEW:
            return False
        cycles = float(self.water.wavenumber(peak)) * float(np.hypot(self.heights.x, self.heights.y).max())
        return cycles > _RESOLVED

    def line(self) -> dict[str, float]:
        """Period and direction of regular waves, by the line's centre and to its width."""
        peak = self.spectrum.peak_frequency
        moment = self.spectrum.direction(1)
        error = self.spectrum.peak_line_width
        figures = {"peak_period": 1.0 / peak, "peak_period_std": error / peak**2}
        if not self.direction_known:
            return figures
        return figures | {
            "mean_direction": float(np.degrees(np.angle(moment)) + 180.0) % 360.0,
            "mean_direction_std": float(np.degrees(error / peak)),
        }

    def _transfer_at(self, wavenumber: Field) -> Field:
        return np.interp(wavenumber, self.spectrum.ring_wavenumber, self.transfer)

    @property
    def direction_known(self) -> bool:
        """Whether the water's velocity says which way the waves run."""
        return bool(np.isfinite(self.direction.wave_from_deg))


def systems_of(turns: Sequence[TurnSpectrum], water: Water, before: WaveSystems | None = None) -> WaveSystems | None:
    """The wave systems that some turns show, the last of which is now; before: those of the turns before it. None of
    looks that span less than 80°, which do not tell waves of all directions apart."""
    if not turns[-1].polar_map.span > _LEAST_SPAN:
        return None
    chosen = [turns[-n] for n in _BACK if n <= len(turns)]
    periodogram = mean_periodogram([each.periodogram for each in turns[-_AVERAGED:]])
    seen = float(np.mean([each.visible_share for each in chosen]))
    return find_systems([each.heights for each in chosen], periodogram, turns[-1].direction, water, before, seen)


class SeaStateRecord:
    """The turns up to one, and the wave systems found in them. turns: how many come, where that is known: the last
    one's systems are looked for again."""

    def __init__(self, water: Water, turns: int = 0) -> None:
        self._water, self._last = water, turns
        self._count = 0
        self._turns: list[tuple[TurnSpectrum, dict[str, float]]] = []
        self._systems: WaveSystems | None = None

    def row(self, polar: xr.Dataset) -> dict[str, float]:
        """The numbers after one more turn; those that cannot be had are left out."""
        self._count += 1
        heights = polar["height"].values
        values = {"cells": 0.0, "raw_height": 4.0 * float(np.nanstd(heights)) if np.isfinite(heights).any() else np.nan}
        turn = TurnSpectrum.of(polar, self._water)
        if turn is None:
            return values
        found = _height(turn.polar_map, turn.bins, turn.held_share)
        now = float(turn.polar_map.time.max())
        self._turns = [each for each in self._turns if now - each[0].polar_map.time.max() < _MEMORY_S]
        self._turns.append((turn, found))
        shown = [each for each, _ in self._turns if each.has_waves]
        if not shown:
            return values | found
        due = self._count == self._last or len(shown) & (len(shown) - 1) == 0
        if due or self._systems is None:
            self._systems = systems_of(shown, self._water, self._systems)
        if self._systems is None:  # too little is seen to tell what the sea at large may differ by
            return values | found | {"significant_wave_height_std": np.nan}
        values |= self._combined(found, self._systems, turn.regular)
        if not turn.polar_map.span > _LEAST_SPAN:
            return values
        return values | self._systems.figures(values["independent"]) | (turn.line() if turn.regular else {})

    def _combined(self, found: dict[str, float], systems: WaveSystems, regular: bool) -> dict[str, float]:
        """The height by all turns, and by how much the sea at large may differ from it; regular waves are the same
        everywhere, so that their height is no sample of another."""
        square = float(np.mean([each["significant_wave_height"] ** 2 for _, each in self._turns]))
        error = float(np.mean([each["significant_wave_height_std"] for _, each in self._turns]))
        samples = systems.samples([each.heights_used for each, _ in self._turns])
        height = np.sqrt(square)
        values = {**found, "significant_wave_height_measurement": error, "independent": samples}
        if samples < _FEWEST:
            least = height * np.sqrt(samples / chdtri(samples, 0.025))
            return values | {
                "significant_wave_height": np.nan,
                "significant_wave_height_std": np.nan,
                "significant_wave_height_least": float(least),
            }
        unbiased, spread = height_of_samples(samples)
        chance = spread * height
        return values | {
            "significant_wave_height": float(height if regular else unbiased * height),
            "significant_wave_height_std": float(np.hypot(chance, error)),
            "significant_wave_height_sampling": float(chance),
            "significant_wave_height_least": np.nan,
        }


def height_of_samples(samples: float) -> tuple[float, float]:
    """Of the root s of a mean square over n independent normal heights of standard deviation σ: the factor of s that is
    σ in the mean, and that error over s by which (found − σ)/error has a mean square of 1, over all s (n > 2)."""
    half = 0.5 * samples
    mean = np.exp(gammaln(half + 0.5) - gammaln(half)) / np.sqrt(half)
    inverse = np.exp(gammaln(half - 0.5) - gammaln(half)) * np.sqrt(half)
    unbiased = 1.0 / mean
    return float(unbiased), float(np.sqrt(unbiased**2 - 2.0 * unbiased * inverse + samples / (samples - 2.0)))


def _height(polar_map: PolarMap, bins: RangeBins, keep: Field) -> dict[str, float]:
    """The waves' height and what it was found by. keep: share of the waves' variance that each ring's cells hold."""
    weight, (first, last) = bins.weight(bins.used), bins.edges(bins.used)
    count = int(np.count_nonzero(polar_map.known & bins.covers(bins.used, polar_map.distance)))
    signal, noise, transfer, seen = (float(weight @ each) for each in (bins.waves, bins.noise, keep, bins.seen))
    variance = max(float(weight @ (bins.waves / keep)), 0.0)
    errors = (
        _NOISE_KNOWN * noise / transfer,
        np.sqrt(2.0 / count) * (noise + 0.1 * max(signal, 0.0)) / transfer,
        _TRANSFER_KNOWN * (1.0 - transfer) * variance,
        _UNSEEN * (1.0 - seen) * variance,
        # What such heights leave open is the variance that the retrieval expected: it is no finding where it is all.
        noise * noise / max(signal, noise) / transfer if polar_map.conditional and noise > 0.0 else 0.0,
    )
    tilts = float(weight @ bins.sensed) / transfer  # few in a turn: their mean square scatters by as much as it is
    return {
        "significant_wave_height": 4.0 * np.sqrt(variance),
        "significant_wave_height_std": _height_error(
            4.0 * np.sqrt(variance), float(np.hypot(np.linalg.norm(errors), tilts))
        ),
        "noise_height": 4.0 * np.sqrt(noise),
        "transfer": transfer,
        "seen_share": seen,
        "range_first": first,
        "range_last": last,
        "cells": float(count),
    }


def _height_error(height: float, error: float) -> float:
    """Of 4 √variance, whose variance has the standard error `error`: 8 error/height, but for a sea that may be calm."""
    return 8.0 * error / max(height, 2.0 * np.sqrt(error)) if error > 0.0 else 0.0


def _travel(polar: xr.Dataset, polar_map: PolarMap, inside: NDArray[np.bool_]) -> Travel:
    """Which way the waves run by the water's velocity; no way without one."""
    if "radial_velocity" not in polar:
        return Travel(np.ones(1), np.zeros(1), np.zeros(1))
    velocity = np.where(inside, polar["radial_velocity"].values.astype(np.float64), np.nan)
    return travel(polar_map.height, np.sqrt(polar_map.noise), velocity, polar_map.azimuth, polar_map.distance, _SIDE_M)


def _kept_variance_share(spectrum: WaveSpectrum, overall: Field, resolution: Resolution, distance: Field) -> Field:
    """Share of the waves' variance that the cells of each distance [m] keep; 1 where no waves are found.

    Waves are as found where the map as a whole keeps enough (`overall`, (ring,)), but beyond the peak no less than a
    tail that falls with the third power of the wavenumber, of which noise and cells leave little: in deep water the
    fifth power of frequency (Phillips 1958), and the same in any depth (Bouws et al. 1985).
    """
    wavenumber, peak = spectrum.ring_wavenumber, 2.0 * np.pi * spectrum.peak_frequency
    peak = float(spectrum.water.wavenumber(peak)) if np.isfinite(peak) else np.nan
    stated = overall > _LEAST_TRANSFER
    core = stated & (wavenumber < _TAIL_FROM * peak)
    if not spectrum.ring_power[core].any():
        return np.ones(distance.size)
    edge = wavenumber[core].max()
    tail = spectrum.ring_power[core & (wavenumber > 0.5 * edge)].sum() / _CORE_OVER_TAIL
    # ∫ k⁻³ dk ∝ k⁻²
    least = np.where(wavenumber > edge, 2.0 * tail * edge**2 * wavenumber**-3 * np.gradient(wavenumber), 0.0)
    shorter = wavenumber[-1] * _STEP ** np.arange(8)  # than all bins
    power = np.append(
        np.maximum(np.where(stated, spectrum.ring_power, 0.0), least), tail * (edge / shorter) ** 2 * (1.0 - _STEP**-2)
    )
    return resolution.transfer(np.append(wavenumber, shorter * np.sqrt(_STEP)), distance) @ power / power.sum()


def in_words(state: xr.Dataset) -> str:
    """One line: height, peak period, direction and spread with their errors, as far as they are known, by all turns."""

    def last(name: str) -> float:
        values = state[name].values
        known = values[np.isfinite(values)]
        return float(known[-1]) if known.size else np.nan

    def value_with_error(name: str, decimals: int, unit: str) -> str:
        value, error = last(name), last(f"{name}_std")
        if np.isfinite(error) and unit == "°":
            return f"{value:.0f}° ± {max(error, 1.0):.0f}°"
        return (
            f"{written(value, decimals)} ± {written(error, decimals)} {unit}"
            if np.isfinite(error)
            else (f"{written(value, decimals)} {unit}")
        )

    if not np.isfinite(state["noise_height"].values).any():
        return f"sea state unknown: {state.attrs.get('unknown', 'no heights')}"
    if np.isfinite(state["significant_wave_height"].values[-1]) or not np.isfinite(
        last("significant_wave_height_least")
    ):
        text = f"Hs {value_with_error('significant_wave_height', 2, 'm')}"
    else:
        least = written(last("significant_wave_height_least"), 2)
        text = f"Hs at least {least} m (the waves are too long for the sea in sight: more turns, or a higher mast)"
    period = last("peak_period")
    if np.isfinite(period):
        text += f", Tp {value_with_error('peak_period', 1, 's')}{_assumed(state, period)}"
    if np.isfinite(last("mean_direction")):
        text += f", from {value_with_error('mean_direction', 0, '°')}, spread {last('directional_spread'):.0f}°"
    elif np.isfinite(axis := last("mean_axis")):
        text += f", from {axis:.0f}° or {axis + 180.0:.0f}°"
    return text


def _assumed(state: xr.Dataset, period: float) -> str:
    """What a period [s] rests on where no depth was given: in water shallower than half a wavelength it is longer."""
    if state.attrs.get("depth_given", 0):
        return ""
    half = np.pi / float(water_of(state.attrs).wavenumber(2.0 * np.pi / period))
    return f" (no depth given: deep water assumed; longer in less than {half:.0f} m of water, set retrieval.depth_m)"
