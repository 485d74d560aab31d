"""Echoes as a dataset that keeps the schema."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..dataset import build
from ..radar.installation import Installation
from ..radar.platform import Sensors
from ..radar.receiver import measures_phase, transmit_phase_error
from ..radar.scan import Pulses
from ..radar.waveform import gates
from ..settings import RetrievalSettings, SensorErrors
from .receiving import ReceivedTurn, gate_noise_power


def echo_attributes(
    installation: Installation, complete_turns: int, full_scale_w: float | None = None
) -> dict[str, Any]:
    """The attributes of the echoes that a retrieval may read: the radar's settings, nothing of the sea.

    Units are in the names. full_scale_w [W]: of the converter, as automatic gain has set it; left out, the scene's.
    """
    radar, array = installation.radar, installation.array
    first = array.elements[array.receivers[0]].antenna
    return {
        "frequency_hz": radar.frequency_hz,
        "pulse_width_s": radar.pulse_width_s,
        "bandwidth_hz": radar.bandwidth_hz,
        "prf_hz": radar.prf_hz,
        "rotation_rpm": radar.rotation_rpm,
        "sector_deg": list(radar.sector_deg),
        "height_m": radar.height_m,
        "baseline_m": array.baseline_m,
        "tilt_deg": radar.tilt_deg,
        "azimuth_beamwidth_deg": first.azimuth_beamwidth_deg,
        "elevation_beamwidth_deg": first.elevation_beamwidth_deg,
        "transmit": radar.transmit,
        "interferogram": radar.interferogram,
        "noise_power_w": gate_noise_power(installation, full_scale_w),
        "complete_turns": complete_turns,
        "waveform": radar.waveform,
        "chirp_bandwidth_hz": radar.chirp_bandwidth_hz if radar.waveform == "chirp" else 0.0,
        "compression_weighting": radar.compression_window if radar.waveform == "chirp" else "none",
        "scan": radar.scan,
        "stare_s": radar.stare_s,
        "receiver_antennas": list(array.receivers),
        "transmitter": radar.transmitter,
        "coherent_on_receive": int(measures_phase(radar)),
        "transmit_phase_error_deg": float(np.degrees(transmit_phase_error(radar))),
    }


def echo_dataset(
    installation: Installation,
    turns: Sequence[Pulses],
    voltages: Sequence[NDArray[np.complex64] | ReceivedTurn],
    polarization: str = "VV",
    submerged: Sequence[NDArray[np.bool_]] | None = None,
    first_turn: int = 0,
    retrieval: RetrievalSettings | None = None,
) -> xr.Dataset:
    """The schema's `echoes` from the pulses and voltages of whole turns; antennas where the sensors have them.

    retrieval: by which `retrieve` is to go.
    """
    received = [ReceivedTurn(each, None) if isinstance(each, np.ndarray) else each for each in voltages]
    numbers = np.concatenate([turn.number for turn in turns])
    flags = np.zeros(numbers.size, dtype=np.int16)
    if submerged is not None:
        flags[np.concatenate(list(submerged))] = 64
    poses = [installation.sensed.pose(turn.time) for turn in turns]
    moving = installation.sensors is not None or any(installation.swing(turn.time).any() for turn in turns)
    bearings = [pose.bearing for pose in poses] if moving else [turn.azimuth for turn in turns]
    values = {
        "voltage": received[0].voltage if len(received) == 1 else np.concatenate([each.voltage for each in received]),
        "position": np.concatenate([pose.positions for pose in poses]),
        "attitude": np.concatenate([pose.attitude for pose in poses]),
        "flag": flags,
    }
    if any(each.saturated is not None for each in received):
        values["saturated"] = np.concatenate([each.saturated for each in received if each.saturated is not None])
    sensors = installation.sensors
    errors = sensors.settings if isinstance(sensors, Sensors) else SensorErrors()
    attributes = echo_attributes(installation, first_turn + len(turns), received[0].full_scale_w) | errors.attributes
    return build(
        "echoes",
        values,
        {
            "pulse": numbers,
            "range": gates(installation.radar),
            "time": np.concatenate([turn.time for turn in turns]),
            "azimuth": np.concatenate(bearings),
            "transmitter": np.concatenate([turn.transmitter for turn in turns]),
            "turn": np.concatenate(
                [np.full(turn.number.size, first_turn + i, dtype=np.int32) for i, turn in enumerate(turns)]
            ),
        },
        {**attributes, "polarization": polarization, "retrieval": (retrieval or RetrievalSettings()).carried},
    )
