"""The retrieval, step by step: covariance, phase, height, slope, error bar, flags, ground map."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import db, wrap_phase
from ..dataset import SchemaError, build, check
from ..radar.grid import look_sweeps
from ..settings import RetrievalSettings
from .covariance import dwell_covariance
from .description import RadarDescription, compared_receivers, transmitters
from .dwells import Dwells
from .ground_map import Ground, ground_map
from .heights import ESTIMATORS, PhaseModel
from .pairs import PulsePairs, neighbouring_pulses, sampled
from .quality import has_echo, quality_flags
from .stance import LookStances, PulseStances
from .uncertainty import height_std


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
    cells, places = retrieve_turn(echoes, radar, settings, turn)
    return xr.DataTree.from_dict({"/polar": cells, "/ground": ground_map(cells, places, radar, settings, turn)})


def open_echoes(path: str | Path) -> xr.Dataset:
    """Echoes from a Zarr store, complete turns only; raises SchemaError if the store does not keep the schema."""
    dataset = xr.open_zarr(path, consolidated=False, zarr_format=3)
    dataset = dataset.set_coords([n for n in ("time", "azimuth", "transmitter", "turn") if n in dataset])
    check("echoes", dataset)
    whole = int(np.count_nonzero(dataset["turn"].values < dataset.attrs["complete_turns"]))
    return dataset.isel(pulse=slice(0, whole))


def retrieve_turn(
    echoes: xr.Dataset, radar: RadarDescription, settings: RetrievalSettings, turn: int
) -> tuple[xr.Dataset, Ground]:
    """The polar maps of one turn, and where their cells lie on the ground."""
    sweeps = look_sweeps(radar.sector, settings.cell_azimuth_deg, radar.staring)
    width = float(sweeps[1] - sweeps[0]) if sweeps.size > 1 else settings.cell_azimuth_deg
    antennas = compared_receivers(echoes, radar, settings.receivers)
    voltage = _voltages(echoes, settings.receivers)
    pulses = PulseStances.of(echoes, radar)
    pairs = None
    if radar.alternating:
        pairs = neighbouring_pulses(sampled(voltage), pulses.time, radar.interval, settings.pulse_pairs)
    dwells = pulses.dwells(radar, antennas[0], sweeps, width)
    stances, senders = _stances(echoes, pulses, dwells, pairs, antennas, radar)
    model = PhaseModel(radar, stances)

    if stances.at_rest:
        dwell = dwell_covariance(voltage, dwells, pairs)
    else:
        each = LookStances.of(pulses, Dwells.of_single_pulses(pulses.time.size), antennas, senders, radar.sector[0])
        level = np.nan_to_num(PhaseModel(radar, each).flat)
        dwell = dwell_covariance(voltage, dwells, pairs, level).turned(np.nan_to_num(model.flat))
    found = ESTIMATORS[settings.estimator](dwell, model, settings, width)
    cells = found.cells
    echo_power = 0.5 * (cells.lower + cells.upper) - radar.noise_power
    echoing = has_echo(cells, echo_power, radar, settings)
    if not radar.compressed:  # of a chirp something is heard before it is out, of a plain pulse nothing
        echoing &= ~radar.blind
    heard = echoing & np.isfinite(found.height)
    own = pulses.looks(sweeps, width)
    if pairs is None:
        spread = height_std(voltage, own, dwell, echo_power, found, radar)
    else:
        spread = height_std(voltage[pairs.lower], own[pairs.lower], dwell, echo_power, found, radar, pairs.noise_square)
    height, ground_range, spread = (np.where(heard, f, np.nan) for f in (found.height, found.ground_range, spread))
    outward, clockwise = model.slopes(found, height, settings, width)
    fields = {
        "height": height,
        "height_std": spread,
        "slope_range": outward,
        "slope_azimuth": clockwise,
        "ground_range": ground_range,
        "coherence": cells.coherence,
        "phase": wrap_phase(found.phase),
        "phase_unwrapped": np.where(heard, found.phase, np.nan),
        "snr_db": _snr_db(echo_power, radar.noise_power),
        "time": _look_times(stances.time, (turn + sweeps / 360.0) * radar.period),
        "quality": quality_flags(echoes, dwells, cells, echoing, echo_power, found.gain, height, radar),
    }
    polar = build(
        "maps/polar",
        {name: field[None] for name, field in fields.items()},
        {"turn": [turn], "azimuth": (radar.sector[0] + sweeps) % 360.0, "range": radar.ranges},
        {
            "cell_range_m": settings.cell_range_m,
            "cell_azimuth_deg": settings.cell_azimuth_deg,
            "estimator": settings.estimator,
            "window_range_m": settings.window_range_m,
            "window_azimuth_deg": settings.window_azimuth_deg,
        },
    )
    return polar, Ground.of(stances, found, sweeps)


def _voltages(echoes: xr.Dataset, receivers: tuple[int, int]) -> NDArray[np.complex64]:
    """Voltages (pulse, 2, gate) of the two receivers that are compared."""
    voltage = np.asarray(echoes["voltage"].values)
    return voltage if receivers == (0, 1) and voltage.shape[1] == 2 else voltage[:, list(receivers)]


def _stances(
    echoes: xr.Dataset,
    pulses: PulseStances,
    dwells: Dwells,
    pairs: PulsePairs | None,
    antennas: tuple[int, int],
    radar: RadarDescription,
) -> tuple[LookStances, Sequence[int]]:
    """How the antennas stood in each cell's dwell, on the very pulses that are compared; and which of them sent."""
    sender = np.asarray(echoes["transmitter"].values)
    if pairs is None:
        senders = transmitters(sender, antennas, None, radar.paths)
        return LookStances.of(pulses, dwells, antennas, senders, radar.sector[0]), senders
    senders = transmitters(sender, antennas, (pairs.lower, pairs.upper), radar.paths)
    rows, owners = pairs.members
    return LookStances.of(pulses[rows], dwells[owners], antennas, senders, radar.sector[0]), senders


def _snr_db(echo_power: NDArray[np.float64], noise_power: float) -> NDArray[np.float64]:
    """Signal to noise ratio of one pulse; NaN without an echo, or without noise."""
    if not noise_power:
        return np.full(echo_power.shape, np.nan)
    with np.errstate(invalid="ignore"):
        return db(np.where(echo_power > 0.0, echo_power, np.nan) / noise_power)


def _look_times(time: NDArray[np.float64], nominal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean time of each look's pulses, of all gates; the nominal one where it has none. time (look, 1 or gate)."""
    known = np.isfinite(time)
    total = np.where(known, time, 0.0).sum(axis=1)
    return np.where(known.any(axis=1), total / np.maximum(known.sum(axis=1), 1), nominal)


__all__ = ["RadarDescription", "ground_map", "open_echoes", "retrieve", "retrieve_one", "retrieve_turn"]
