"""Sea state from maps: significant height, periods, direction and spread of the waves, each with a standard error.

Heights are about mean sea level, which is known: their mean square needs no mean of its own, and hardly depends on
which half of the sea is in sight, since what crests have too much, the troughs that they hide have too little.
Periods follow from wavelengths by the linear dispersion of the depth that travels with the maps.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import written
from ..dataset import WATER_ATTRIBUTES, group_of
from ..physics.dispersion import Water
from .hindrance import hindrance
from .range_bins import PolarMap, RangeBins
from .resolution import Resolution
from .wave_direction import Travel, travel
from .wave_spectrum import Field, Transforms, WaveSpectrum, wave_spectrum

_UNSEEN = 0.16  # relative error of the variance by what is not in sight, of its share
_NOISE_KNOWN = 0.2  # relative standard error of the stated error variances
_TRANSFER_KNOWN = 0.2  # of what is added for the waves that a cell averages away
_LEAST_TRANSFER = 0.25  # of the variance: shorter waves are not in the map, but follow from the longer ones
_TAIL_FROM = 2.0  # times the peak's wavenumber: shorter waves hold at least what a wind sea's do
_CORE_OVER_TAIL = 2.76  # what it holds between half that and that over what is beyond (Hasselmann et al. 1973)
_STEP = 1.3  # from one wavenumber to the next, of waves too short to be seen
_SURE_DEG = 60.0  # between the heights' axis and the way that the water moves: farther off the way is called unknown
_PEAK_WIDTH = 0.3  # relative, of a wind sea's spectrum: how far the peak of a single draw of few waves strays
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
    "significant_wave_height_std": ("m", "standard error of the height of the sea that was seen", None),
    "significant_wave_height_sampling": ("m", "standard deviation by which a sea of this size differs", None),
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
    """Significant wave height, peak period, mean direction and spread of each turn, with standard errors, dims (turn,).

    maps: as from `retrieve`, of an antenna that moves slowly beside the waves. Their attributes `depth_m` and
    `current_m_s` (east, north) say what the waves run on; where no depth is given deep water is assumed, and the
    attribute `depth_given` of the result is 0. Periods are those met by one who drifts with the current.

    The standard error
    `significant_wave_height_std` is against the sea that was seen; how far that may differ from the sea at large, by
    chance, is `significant_wave_height_sampling`, and part of the other errors. Where too little is seen, or too noisy,
    all is NaN, and the attribute `unknown` says why and what would mend it; of a calm sea, and of looks that span less
    than 80°, the period and directions are NaN. Mean direction and spread are NaN as well where no radial velocity
    gives which way the waves run; `mean_axis` needs none.

    Raises SchemaError for maps without one of the fields it reads, or with one of another kind.

    Method: mean square about mean sea level, less that of the errors (of heights that are the mean of what may be,
    given the echoes, plus that of what they leave open), over the share that cells keep of the spectrum; peak by S⁴
    (Young 1995), mean direction and spread by the first moment (Kuik, van Vledder & Holthuijsen 1988).
    """
    polar = group_of(maps, "maps/polar", _NEEDED)
    water = water_of(polar.attrs)
    rows = [_one_turn(polar.isel(turn=turn), water) for turn in range(polar.sizes["turn"])]
    known = {name: polar.attrs.get(name, missing) for name, (missing, _) in WATER_ATTRIBUTES.items()}

    def variable(name: str) -> tuple[str, Field, dict[str, str]]:
        units, long_name, standard_name = _VARIABLES[name]
        attributes = {"long_name": long_name, "units": units}
        if standard_name:
            attributes["standard_name"] = standard_name
        return "turn", np.array([row.get(name, np.nan) for row in rows]), attributes

    unknown = [turn for turn, row in enumerate(rows) if not np.isfinite(row.get("significant_wave_height", np.nan))]
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
    kept: Field  # (bin,) share of the waves' variance that cells at that distance hold

    @classmethod
    def of(cls, polar: xr.Dataset, water: Water) -> TurnSpectrum | None:
        """Of the polar map of one turn; None where too little is in sight."""
        polar_map = PolarMap.of(polar)
        bins = RangeBins.of(polar_map)
        if bins is None or not bins.used.any():
            return None
        inside = polar_map.known & bins.within(bins.glimpsed, polar_map.distance)
        direction = _travel(polar, polar_map, inside)
        spectrum = wave_spectrum(Transforms.of(polar_map.cells(inside)), direction, water)
        resolution = Resolution.of(polar.attrs, np.degrees(polar_map.width))
        overall = bins.weight(bins.glimpsed) @ resolution.transfer(spectrum.ring_wavenumber, bins.middle)
        spectrum = spectrum.corrected(overall, _LEAST_TRANSFER)
        return cls(spectrum, direction, polar_map, bins, overall, _kept(spectrum, overall, resolution, bins.middle))

    @property
    def height(self) -> float:
        """m, four standard deviations of the sea."""
        return _height(self.polar_map, self.bins, self.kept)["significant_wave_height"]

    @property
    def way_known(self) -> bool:
        """Whether the water's velocity says which way the waves run."""
        return bool(np.isfinite(self.direction.wave_from_deg))


def _one_turn(polar: xr.Dataset, water: Water) -> dict[str, float]:
    """The numbers of one turn; those that cannot be had are left out."""
    heights = polar["height"].values
    values = {"cells": 0.0, "raw_height": 4.0 * float(np.nanstd(heights)) if np.isfinite(heights).any() else np.nan}
    turn = TurnSpectrum.of(polar, water)
    if turn is None:
        return values
    polar_map, bins, spectrum, direction = turn.polar_map, turn.bins, turn.spectrum, turn.direction
    values |= _height(polar_map, bins, turn.kept)
    part = bins.area[bins.used].sum() / bins.area[bins.glimpsed].sum()
    chance = 0.5 / np.sqrt(max(1.0, spectrum.independent * part))
    values["significant_wave_height_sampling"] = chance * values["significant_wave_height"]
    weight = bins.weight(bins.used)
    # Heights that are a conditional mean hold nothing of a sea that noise hides.
    least = 2.0 if polar_map.conditional else 2.0 * _NOISE_KNOWN
    shown = weight @ bins.waves > least * (weight @ bins.noise)
    return values | (_direction(spectrum, direction) if shown and polar_map.span > _LEAST_SPAN else {})


def _height(polar_map: PolarMap, bins: RangeBins, keep: Field) -> dict[str, float]:
    """The waves' height and what it was found by. keep: share of the waves' variance that each ring's cells hold."""
    weight, (first, last) = bins.weight(bins.used), bins.edges(bins.used)
    count = int(np.count_nonzero(polar_map.known & bins.within(bins.used, polar_map.distance)))
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


def _kept(spectrum: WaveSpectrum, overall: Field, resolution: Resolution, distance: Field) -> Field:
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


def _direction(spectrum: WaveSpectrum, direction: Travel) -> dict[str, float]:
    """Periods and directions, with what chance makes of as few waves as were seen."""
    peak, moment, doubled = spectrum.peak_frequency, spectrum.direction(1), spectrum.direction(2)
    if not (np.isfinite(peak) and np.isfinite(moment)):
        return {}
    chance = 1.0 / np.sqrt(spectrum.independent)
    axis = np.degrees(0.5 * np.angle(doubled)) % 180.0
    # By chance, and by the width of a single wave's line in the map, which draws the peak of a lopsided spectrum along.
    error = np.hypot(_PEAK_WIDTH * chance * peak, spectrum.peak_line_width)
    values = {"peak_period": 1.0 / peak, "peak_period_std": error / peak**2, "mean_axis": axis}
    if not abs(np.cos(np.radians(direction.wave_from_deg - axis))) > np.cos(np.radians(_SURE_DEG)):
        return values
    spread = float(np.degrees(np.sqrt(2.0 * max(1.0 - abs(moment), 0.0))))
    return values | {
        "mean_direction": (np.degrees(np.angle(moment)) + 180.0) % 360.0,
        "mean_direction_std": spread * chance,
        "directional_spread": spread,
        "directional_spread_std": spread * chance / np.sqrt(2.0),
    }


def in_words(state: xr.Dataset) -> str:
    """One line: height, peak period, direction and spread, as far as they are known; of several turns their means."""
    height = state["significant_wave_height"].values
    known = np.isfinite(height)
    if not known.any():
        return f"sea state unknown: {state.attrs.get('unknown', 'no heights')}"
    text = f"Hs {written(height[known].mean(), 2)}"
    if known.sum() == 1:
        text += f" ± {written(state['significant_wave_height_std'].values[known][0], 2)} m"
    else:  # what a turn's own bar leaves out: a patch of sea is one draw of many
        least, most = written(height[known].min(), 2), written(height[known].max(), 2)
        text += f" m in the mean of {known.sum()} turns ({least} to {most} m)"
    period, direction = (state[name].values for name in ("peak_period", "mean_direction"))
    if np.isfinite(period).any():
        text += f", Tp {np.nanmean(period):.1f} s{_assumed(state, float(np.nanmean(period)))}"
    known = np.isfinite(direction)
    if known.any():
        mean = np.degrees(np.angle(np.mean(np.exp(1j * np.radians(direction[known]))))) % 360.0
        text += f", from {mean:.0f}°, spread {np.nanmean(state['directional_spread'].values):.0f}°"
    elif np.isfinite(axis := state["mean_axis"].values).any():
        mean = 0.5 * np.degrees(np.angle(np.nanmean(np.exp(2j * np.radians(axis))))) % 180.0
        text += f", from {mean:.0f}° or {mean + 180.0:.0f}°"
    return text


def _assumed(state: xr.Dataset, period: float) -> str:
    """What a period [s] rests on where no depth was given: in water shallower than half a wavelength it is longer."""
    if state.attrs.get("depth_given", 0):
        return ""
    half = np.pi / float(water_of(state.attrs).wavenumber(2.0 * np.pi / period))
    return f" (no depth given: deep water assumed; longer in less than {half:.0f} m of water, set retrieval.depth_m)"
