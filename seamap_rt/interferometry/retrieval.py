"""The retrieval, step by step: covariance, phase, height, slope, error bar, flags, ground map."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..compute.machine import one_blas_thread
from ..conventions import db, unit_from_azimuth
from ..dataset import QUALITY_FLAGS, build, check
from ..errors import SchemaError, must_be
from ..settings import RetrievalSettings, SensorErrors
from ..wavefield.sea_state import water_of
from .checks import check_maps, check_pulses_compare, checked_echoes, open_echoes, read_turn, settings_of
from .description import RadarDescription
from .error_covariance import sensor_variance
from .estimators import ESTIMATORS, Estimate
from .ground_map import Ground, advance_to_instant, ground_map
from .interferogram import Interferogram
from .looks import Looks, interferogram
from .poses import Heights
from .quality import quality_flags
from .slopes import (
    Shadow,
    Slopes,
    diffraction_error,
    local_planes,
    plane_reach,
    rms_slope,
    shadow,
    visible_slopes,
)
from .speckle import ONE_CELL
from .velocity import Doppler, Lag, doppler, ground_velocity, own_velocity
from .windows import window_weights

Map = NDArray[np.float64]
Changes = RetrievalSettings | Mapping[str, Any] | None

_LEAST_SPREAD = 0.05  # least spread of a plane's cells across their line, over that along it


def retrieve(echoes: xr.Dataset | str | Path, settings: Changes = None) -> xr.DataTree:
    """Maps (`/polar`, `/ground`) from echoes that keep the schema, ray traced, analytic or recorded alike.

    echoes: a dataset, or the path of a store. settings: left out, those that the echoes carry, which are their
    scene's (the defaults, of recordings); a dict of keys replaces these, RetrievalSettings replace all. The polar maps'
    attribute `retrieval` says which were taken.

    Slopes are those of planes fitted to the heights; the polar maps' `slope_planes_m` are the lengths [m] of the
    shortest and of the longest along the look. Their standard errors are against the mean slope of the cell, as the
    truth has it, with the short waves that planes smooth; only `adaptive` knows them.

    Raises SchemaError, in one line, for echoes that do not keep the schema.
    """
    turns = list(retrieve_turns(echoes, settings))
    if not turns:
        raise SchemaError("the echoes hold no complete turn; simulate or record at least one")
    return joined(turns)


def retrieve_turns(echoes: xr.Dataset | str | Path, settings: Changes = None, after: int = -1) -> Iterator[xr.DataTree]:
    """Maps of one complete turn after the other, of those whose number is greater than `after`; as `retrieve`."""
    must_be("echoes", echoes, (xr.Dataset, str, os.PathLike), "a Dataset, as simulate gives, or the path of a store")
    if not isinstance(echoes, xr.Dataset):
        echoes = open_echoes(echoes)
    check("echoes", echoes)
    settings, echoes = settings_of(echoes, settings), checked_echoes(echoes)
    numbers = echoes["turn"].values
    for turn in np.unique(numbers[(numbers > max(after, -1)) & (numbers < float(echoes.attrs["complete_turns"]))]):
        members = np.flatnonzero(numbers == turn)
        one = echoes.isel(pulse=slice(int(members[0]), int(members[-1]) + 1))
        check_maps(one, settings)
        yield _map_turn(read_turn(one), settings)


def joined(turns: Sequence[xr.DataTree]) -> xr.DataTree:
    """Maps of several turns as one tree."""
    return xr.DataTree.from_dict(
        {
            f"/{group}": xr.concat([t[group].to_dataset() for t in turns], "turn", data_vars="minimal")
            for group in ("polar", "ground")
        }
    )


def retrieve_one(echoes: xr.Dataset, settings: Changes = None) -> xr.DataTree:
    """Maps of the single turn that these echoes hold."""
    return _map_turn(checked_echoes(echoes), settings_of(echoes, settings))


@one_blas_thread()
def _map_turn(echoes: xr.Dataset, settings: RetrievalSettings) -> xr.DataTree:
    radar = RadarDescription.of(echoes)
    turn = int(echoes["turn"].values[0])
    cells, points = retrieve_turn(echoes, radar, settings, turn)
    cells.attrs |= {**_water_attributes(settings), "retrieval": settings.carried}
    unambiguous = (cells["quality"].values[0] & QUALITY_FLAGS["ambiguous"]) == 0
    ground = ground_map(cells, points, radar, settings, turn, unambiguous)
    if settings.map_time_s is not None:
        water = water_of(cells.attrs)
        ground = advance_to_instant(ground, cells, turn * radar.period + settings.map_time_s, water)
        ground.attrs["map_time_s"] = settings.map_time_s
    return xr.DataTree.from_dict({"/polar": cells, "/ground": ground})


def _water_attributes(settings: RetrievalSettings) -> dict[str, float | list[float]]:
    """The water as the maps describe it, see `WATER_ATTRIBUTES`."""
    depth, speed = settings.depth_m, settings.current_m_s or 0.0
    current = [speed * float(part) for part in unit_from_azimuth(settings.current_toward_deg or 0.0)]
    return {
        "depth_m": np.inf if depth is None else depth,
        "depth_given": int(depth is not None),
        "current_m_s": current,
    }


def retrieve_turn(
    echoes: xr.Dataset, radar: RadarDescription, settings: RetrievalSettings, turn: int
) -> tuple[xr.Dataset, Ground]:
    """The polar maps of one turn, and where their cells lie on the ground."""
    check_pulses_compare(radar, settings)
    looks = Looks.of(echoes, radar, settings)
    given, lags = interferogram(looks)
    estimate = ESTIMATORS[settings.estimator](given)
    heights, model = estimate.heights, given.model
    echo_power = estimate.echo_power
    echoing = estimate.echoing
    if not radar.compressed:  # a chirp is received in part while it is being sent, a plain pulse is not
        echoing = echoing & ~radar.blind
    heard = echoing & np.isfinite(heights.height)
    height, ground_range, spread = (
        np.where(heard, f, np.nan) for f in (heights.height, heights.ground_range, estimate.std)
    )
    reach = plane_reach(spread, radar.ranges, radar.spacing, given.echo.width, estimate.slope_rms)
    slopes = _slopes(given, estimate, height, spread, reach)
    seen = _shadow(given, slopes, spread, heard, estimate.slope_rms)
    errors = np.full((3, *height.shape), np.nan) if estimate.of_slopes is None else estimate.of_slopes
    along, across, both = np.where(np.isfinite(slopes.outward), errors, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        correlation = np.clip(both / np.sqrt(along * across), -1.0, 1.0)
    outward, outward_std = visible_slopes(slopes.outward, np.sqrt(along), _grazing(given), seen.visible_share)
    sensed = sensor_variance(echoes, radar, looks.width, ground_range, slopes.clockwise)
    common = _transmitter_error(given, heights) ** 2 + sensed
    grid, angle = (looks.width, radar.spacing, radar.closed), 1e-3 * (settings.diffraction_mrad or 0.0)
    bent = diffraction_error(seen.visible_share, height, spread, radar.ranges, grid, angle)
    analysis = spread
    spread = np.sqrt(spread**2 + seen.hidden_std**2 + estimate.edge**2 + bent**2 + common)
    if settings.crest_bias == "remove":
        height = height - seen.crest_bias
    else:  # what is known of it and left is an error as well
        spread = np.hypot(spread, seen.crest_bias)
    flags = quality_flags(
        echoes,
        looks.dwells,
        heights.cells,
        echoing,
        heights.gain,
        height,
        radar,
        estimate.ambiguous,
        seen.visible_share,
        given.dwelt.samples(estimate.window, radar).noise,
    )
    east, north = (_look_means(each, looks.sweeps.size) for each in model.poses.middle)
    fields = {
        "height": height,
        "height_std": spread,
        "analysis_std": analysis,
        "slope_range": outward,
        "slope_range_std": outward_std,
        "slope_azimuth": slopes.clockwise,
        "slope_azimuth_std": np.sqrt(across),
        "slope_correlation": correlation,
        "ground_range": ground_range,
        "coherence": heights.cells.coherence,
        "phase": np.angle(heights.cells.cross),
        "phase_unwrapped": np.where(heard, heights.phase, np.nan),
        "snr_db": _snr_db(echo_power, given.echo.noise),
        **_velocity_fields(looks, given, lags, heights, heard),
        "visible_share": seen.visible_share,
        "crest_bias": seen.crest_bias,
        **_dwell_fields(estimate, heard, common),
        **({"sensor_std": np.where(heard, np.sqrt(sensed), np.nan)} if sensed.any() else {}),
        "antenna_x": east,
        "antenna_y": north,
        "time": _look_times(model.poses.time, (turn + looks.sweeps / 360.0) * radar.period),
        "quality": flags,
    }
    planes = 2.0 * radar.spacing * reach[0]
    return _polar(fields, looks, model.paths, turn, planes), Ground.of(model.poses, heights, looks.sweeps)


def _dwell_fields(estimate: Estimate, heard: NDArray[np.bool_], common: Map) -> dict[str, Map]:
    """Heights of single dwells and gates, where found: errors hardly depend on each other but for the common [m²]."""
    if estimate.dwells is None:
        return {}
    height, std = estimate.dwells
    made = {"dwell_height": height, "dwell_height_std": np.sqrt(std**2 + common) if common.any() else std}
    heard = heard & ~(std > 1e9)  # m: nothing is known, and its square overflows
    return {name: np.where(heard, field, np.nan) for name, field in made.items()}


def _velocity_fields(
    looks: Looks, given: Interferogram, lags: Sequence[Lag], heights: Heights, heard: NDArray[np.bool_]
) -> dict[str, Map]:
    """What moves, and how unevenly: none of a transmitter whose phases mean nothing from pulse to pulse."""
    if not looks.radar.coherent:
        return {}
    moving = _velocities(looks, given, lags, heights)
    made = {"radial_velocity": moving.velocity, "doppler_width": moving.width}
    return {name: np.where(heard, field, np.nan) for name, field in made.items()}


def _transmitter_error(given: Interferogram, heights: Heights) -> Map:
    """Error [m] by the transmitter's phases, where pulses are compared that were sent with unlike ones: of N pulses of
    either receiver √(2/N) of one's. All gates of a look have it in common; 0 where both hear the same pulses."""
    radar = given.model.radar
    error = radar.transmit_phase_error * np.sqrt(2.0 / max(1, given.dwelt.pulses))
    if error == 0.0 or not (radar.alternating or given.model.paths == 2):
        return np.zeros(heights.height.shape)
    return np.nan_to_num(heights.gain) * error


def _error_terms(sensors: SensorErrors | None, bent: bool) -> str:
    """What error bars of heights hold, in words. bent: also that light bends."""
    holds = f"speckle, noise, hidden parts{', diffraction' if bent else ''}"
    if sensors is None:
        return f"{holds}; not the motion sensors' errors, of which the echoes do not tell"
    stays = any(value > 0.0 for name, value in sensors.attributes.items() if "accuracy" in name)
    return f"{holds}, motion sensors' noise and latency{' and' if stays else ', not'} their biases"


def _polar(fields: dict[str, NDArray], looks: Looks, paths: int, turn: int, planes: Map) -> xr.Dataset:
    """The polar map of fields (look, gate), and how it was made."""
    radar, settings = looks.radar, looks.settings
    return build(
        "maps/polar",
        {name: field[None] for name, field in fields.items()},
        {"turn": [turn], "azimuth": (radar.sector[0] + looks.sweeps) % 360.0, "range": radar.ranges},
        {
            "cell_range_m": settings.cell_range_m,
            "cell_azimuth_deg": settings.cell_azimuth_deg,
            "estimator": settings.estimator,
            "window_range_m": settings.window_range_m,
            "window_azimuth_deg": settings.window_azimuth_deg,
            "paths": paths,
            "pulse_m": 2.0 * np.sqrt(2.0 * np.log(2.0)) * radar.response.spread_m,
            "azimuth_beamwidth_deg": radar.azimuth_beamwidth,
            "elevation_beamwidth_deg": radar.elevation_beamwidth,
            "height_m": radar.height,
            "tilt_deg": radar.tilt,
            "crest_bias": settings.crest_bias,
            "height_std_holds": _error_terms(radar.sensors, bool(settings.diffraction_mrad)),
            "slope_planes_m": [float(planes.min()), float(planes.max())],
        },
    )


def _slopes(given: Interferogram, estimate: Estimate, height: Map, spread: Map, reach: tuple[Map, Map]) -> Slopes:
    """Slopes of planes; cells count by their own errors."""
    model = given.model
    ground = model.ground(estimate.heights.points)
    sure = np.where(estimate.ambiguous, np.nan, height)
    with np.errstate(divide="ignore", invalid="ignore"):
        usual = np.nanmedian(spread) if np.isfinite(spread).any() else 1.0
        weight = 1.0 / (spread**2 + (0.5 * usual) ** 2 + 1e-12)
    return local_planes(sure, np.nan_to_num(weight), ground, model.outward(*ground), reach, _LEAST_SPREAD)


def _grazing(given: Interferogram) -> Map:
    """tan ψ of the rays to mean sea level, (look or 1, gate)."""
    height = given.model.poses.fan.height
    return height / np.sqrt(np.maximum(given.model.radar.ranges**2 - height**2, 1e-6))


def _shadow(
    given: Interferogram, slopes: Slopes, spread: Map, heard: NDArray[np.bool_], slope_rms: float | None
) -> Shadow:
    """The share of each cell in sight, by the echo of each dwell and gate and the slopes.

    slope_rms: of the sea, where the estimator knows it; else as the planes have it.
    """
    radar, settings = given.model.radar, given.settings
    return shadow(
        given.echo.dwells,
        given.echo.lit_cell_power,
        slopes.outward,
        rms_slope(slopes.outward, spread) if slope_rms is None else slope_rms,
        _grazing(given),
        (settings.cell_range_m, np.radians(settings.cell_azimuth_deg) * radar.ranges),
        heard,
        given.echo.noise / np.sqrt(given.dwelt.samples(ONE_CELL, radar).noise),
    )


def _velocities(looks: Looks, given: Interferogram, lags: Sequence[Lag], heights: Heights) -> Doppler:
    """Velocities of what echoes over ground, of cells."""
    shape = heights.height.shape
    if not lags:
        return Doppler(*(np.full(shape, np.nan) for _ in range(3)))
    radar, settings = looks.radar, looks.settings
    window = (
        window_weights(settings.cell_range_m, radar.spacing),
        window_weights(settings.cell_azimuth_deg, looks.width),
    )
    samples = given.dwelt.samples(window, radar)
    seen = doppler(
        lags, radar.wavelength, radar.noise_power, window, 2.0 * samples.noise, samples.speckle, looks.passage
    )
    own = own_velocity(looks.pulses.antennas, looks.pulses.time, looks.dwells)
    height = given.model.poses.fan.height - heights.height
    return replace(
        seen, velocity=ground_velocity(seen.velocity, own, given.model.poses.azimuth, heights.ground_range, height)
    )


def _snr_db(echo_power: NDArray[np.float64], noise_power: float) -> NDArray[np.float64]:
    """Signal to noise ratio of one pulse; NaN without an echo, or without noise."""
    if not noise_power:
        return np.full(echo_power.shape, np.nan)
    with np.errstate(invalid="ignore"):
        return db(np.where(echo_power > 0.0, echo_power, np.nan) / noise_power)


def _look_means(field: Map, looks: int) -> Map:
    """(look,) means over the gates of a field (look or 1, gate or 1); NaN where a look has none."""
    known = np.isfinite(field)
    with np.errstate(invalid="ignore"):
        mean = np.where(known, field, 0.0).sum(axis=1) / known.sum(axis=1)
    return np.broadcast_to(mean, looks)


def _look_times(time: NDArray[np.float64], nominal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean time of each look's pulses, of all gates; the nominal one where it has none. time (look, 1 or gate)."""
    known = np.isfinite(time)
    total = np.where(known, time, 0.0).sum(axis=1)
    return np.where(known.any(axis=1), total / np.maximum(known.sum(axis=1), 1), nominal)


__all__ = [
    "RadarDescription",
    "ground_map",
    "joined",
    "open_echoes",
    "retrieve",
    "retrieve_one",
    "retrieve_turn",
    "retrieve_turns",
]
