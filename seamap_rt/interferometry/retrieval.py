"""The retrieval, step by step: covariance, phase, height, slope, error bar, flags, ground map."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import db, unit_from_azimuth, wrap_degrees, wrap_phase
from ..dataset import SchemaError, build, check
from ..radar.grid import LookFan, ground_grid
from ..radar.scan import look_sweeps
from ..settings import RetrievalSettings
from .covariance import dwell_covariance
from .description import RadarDescription, look_geometry, look_of_pulses
from .ground import resample_looks, sample_fan
from .heights import ESTIMATORS, PhaseModel, slopes
from .quality import has_echo, quality_flags
from .uncertainty import height_std

_GROUND_SAMPLES = 3  # per side of a ground cell


def retrieve(echoes: xr.Dataset | str | Path, settings: RetrievalSettings | None = None) -> xr.DataTree:
    """Maps (`/polar`, `/ground`) from echoes that keep the schema, ray traced, analytic or recorded alike.

    Raises SchemaError, in one line, for echoes that do not keep the schema.
    """
    settings = settings or RetrievalSettings()
    if not isinstance(echoes, xr.Dataset):
        echoes = open_echoes(echoes)
    check("echoes", echoes)
    turns = []
    for turn in range(int(echoes.attrs["complete_turns"])):
        members = np.flatnonzero(echoes["turn"].values == turn)
        if members.size:
            turns.append(retrieve_one(echoes.isel(pulse=slice(int(members[0]), int(members[-1]) + 1)), settings))
    if not turns:
        raise SchemaError("the echoes hold no complete turn; simulate or record at least one")
    return xr.DataTree.from_dict(
        {
            f"/{group}": xr.concat([t[group].to_dataset() for t in turns], "turn", data_vars="minimal")
            for group in ("polar", "ground")
        }
    )


def retrieve_one(echoes: xr.Dataset, settings: RetrievalSettings | None = None) -> xr.DataTree:
    """Maps of the single turn that these echoes hold."""
    settings = settings or RetrievalSettings()
    radar = RadarDescription.of(echoes)
    turn = int(echoes["turn"].values[0])
    cells = retrieve_turn(echoes, radar, settings, turn)
    return xr.DataTree.from_dict({"/polar": cells, "/ground": ground_map(cells, radar, settings, turn)})


def open_echoes(path: str | Path) -> xr.Dataset:
    """Echoes from a Zarr store, complete turns only; raises SchemaError if the store does not keep the schema."""
    dataset = xr.open_zarr(path, consolidated=False, zarr_format=3)
    dataset = dataset.set_coords([n for n in ("time", "azimuth", "transmitter", "turn") if n in dataset])
    check("echoes", dataset)
    whole = int(np.count_nonzero(dataset["turn"].values < dataset.attrs["complete_turns"]))
    return dataset.isel(pulse=slice(0, whole))


def retrieve_turn(echoes: xr.Dataset, radar: RadarDescription, settings: RetrievalSettings, turn: int) -> xr.Dataset:
    """The polar maps of one turn."""
    sweeps = look_sweeps(radar.sector, settings.cell_azimuth_deg)
    width = float(sweeps[1] - sweeps[0]) if sweeps.size > 1 else settings.cell_azimuth_deg
    azimuth = (radar.sector[0] + sweeps) % 360.0
    look = look_of_pulses(echoes, radar, sweeps, width)
    voltage = np.asarray(echoes["voltage"].values)
    geometry = look_geometry(echoes, look, azimuth)
    model = PhaseModel(radar, geometry)

    dwell = dwell_covariance(voltage, look, sweeps.size)
    found = ESTIMATORS[settings.estimator](dwell, model, settings, width)
    cells = found.cells
    echo_power = 0.5 * (cells.lower + cells.upper) - radar.noise_power
    echoing = has_echo(cells, echo_power, radar, settings)
    heard = echoing & np.isfinite(found.height)
    spread = height_std(voltage, look, dwell, echo_power, found, radar)
    height, ground_range, spread = (np.where(heard, f, np.nan) for f in (found.height, found.ground_range, spread))
    outward, clockwise = slopes(height, ground_range, cells.lower, radar, settings, width)
    fields = {
        "height": height,
        "height_std": spread,
        "slope_range": outward,
        "slope_azimuth": clockwise,
        "ground_range": ground_range + geometry.offset,
        "coherence": cells.coherence,
        "phase": wrap_phase(found.phase),
        "phase_unwrapped": np.where(heard, found.phase, np.nan),
        "snr_db": _snr_db(echo_power, radar.noise_power),
        "time": _look_times(echoes, look, (turn + sweeps / 360.0) * radar.period),
        "quality": quality_flags(echoes, look, cells, echoing, echo_power, found.gain, height, radar),
    }
    return build(
        "maps/polar",
        {name: field[None] for name, field in fields.items()},
        {"turn": [turn], "azimuth": azimuth, "range": radar.ranges},
        {
            "cell_range_m": settings.cell_range_m,
            "cell_azimuth_deg": settings.cell_azimuth_deg,
            "estimator": settings.estimator,
            "window_range_m": settings.window_range_m,
            "window_azimuth_deg": settings.window_azimuth_deg,
        },
    )


def _snr_db(echo_power: NDArray[np.float64], noise_power: float) -> NDArray[np.float64]:
    """Signal to noise ratio of one pulse; NaN without an echo, or without noise."""
    if not noise_power:
        return np.full(echo_power.shape, np.nan)
    with np.errstate(invalid="ignore"):
        return db(np.where(echo_power > 0.0, echo_power, np.nan) / noise_power)


def _look_times(echoes: xr.Dataset, look: NDArray[np.intp], nominal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean time of each look's pulses; the nominal one where it has none."""
    inside = look >= 0
    time = np.asarray(echoes["time"].values, dtype=np.float64)[inside]
    pulses = np.bincount(look[inside], minlength=nominal.size)
    total = np.bincount(look[inside], weights=time, minlength=nominal.size)
    return np.where(pulses > 0, total / np.maximum(pulses, 1), nominal)


def ground_map(cells: xr.Dataset, radar: RadarDescription, settings: RetrievalSettings, turn: int) -> xr.Dataset:
    """The ground maps of one turn: each square cell the mean of a few samples of the polar map at its places."""
    grid = ground_grid(float(radar.ranges[-1]), settings.ground_m)
    fan = LookFan(
        look_sweeps(radar.sector, settings.cell_azimuth_deg), radar.sector[0], radar.closed, radar.period, turn
    )
    outward, clockwise = cells["slope_range"].values[0], cells["slope_azimuth"].values[0]
    east, north = unit_from_azimuth(cells["azimuth"].values)
    fields = {
        "height": cells["height"].values[0],
        "height_std": cells["height_std"].values[0],
        # Outward is (east, north); clockwise of it is (north, −east).
        "slope_x": outward * east[:, None] + clockwise * north[:, None],
        "slope_y": outward * north[:, None] - clockwise * east[:, None],
    }
    fields = {name: np.asarray(field, dtype=np.float64) for name, field in fields.items()}
    distance = np.arange(0.5 * settings.ground_m, radar.ranges[-1] + settings.ground_m, 0.25 * settings.ground_m)
    resampled = resample_looks(
        cells["ground_range"].values[0].astype(np.float64),
        fields,
        distance,
        1.5 * settings.cell_range_m + radar.spacing,
    )
    centre_x, centre_y = np.meshgrid(grid.x, grid.y)
    sweep = fan.sweep_of(centre_x, centre_y)
    inside = np.hypot(centre_x, centre_y) <= radar.ranges[-1]
    x, y = grid.points(_GROUND_SAMPLES)
    # A cell that straddles the start of the turn stays on its centre's side: the other is a turn older or younger.
    beside = wrap_degrees(fan.sweep_of(x, y) - sweep[..., None])
    sampled = sample_fan(fan, resampled, distance, sweep[..., None] + beside, np.hypot(x, y))
    if not radar.closed:
        inside &= sweep <= radar.sector[1] - radar.sector[0]

    def mean(field: NDArray[np.float64]) -> NDArray[np.float64]:
        known = np.isfinite(field)
        count = known.sum(axis=2)
        total = np.where(known, field, 0.0).sum(axis=2)
        return np.where(2 * count > field.shape[2], total / np.maximum(count, 1), np.nan)[None]

    values = {name: mean(field) for name, field in sampled.items()}
    values["time"] = np.where(inside, fan.time(sweep), np.nan)[None]
    return build("maps/ground", values, {"turn": [turn], "y": grid.y, "x": grid.x}, {"cell_m": settings.ground_m})


__all__ = ["RadarDescription", "ground_map", "open_echoes", "retrieve", "retrieve_one", "retrieve_turn"]
