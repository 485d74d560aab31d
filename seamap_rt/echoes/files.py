"""Echoes as a dataset that keeps the schema, and the Zarr store into which a run streams them turn by turn."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import xarray as xr
import zarr
from numpy.typing import NDArray

from ..dataset import build
from ..radar.array import antenna_array
from ..radar.mast import Mast
from ..radar.scan import Pulses
from ..radar.waveform import gates
from ..settings import RadarSettings
from .receiving import Received, gate_noise_power

_PULSES_A_CHUNK = 2000


def echo_attributes(radar: RadarSettings, complete_turns: int, full_scale_w: float | None = None) -> dict[str, Any]:
    """What a retrieval may know of the radar; nothing of the sea."""
    array = antenna_array(radar)
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
        "noise_power_w": gate_noise_power(radar, full_scale_w),
        "complete_turns": complete_turns,
        "waveform": radar.waveform,
        "chirp_bandwidth_hz": radar.chirp_bandwidth_hz if radar.waveform == "chirp" else 0.0,
        "compression_weighting": radar.compression_window if radar.waveform == "chirp" else "none",
        "scan": radar.scan,
        "stare_s": radar.stare_s,
        "receiver_antennas": list(array.receivers),
    }


def echo_dataset(
    radar: RadarSettings,
    turns: Sequence[Pulses],
    voltages: Sequence[NDArray[np.complex64] | Received],
    polarization: str = "VV",
    submerged: Sequence[NDArray[np.bool_]] | None = None,
    first_turn: int = 0,
    sensed: Mast | None = None,
) -> xr.Dataset:
    """The schema's `echoes` from the pulses and voltages of whole turns.

    sensed: the mast as the boat's sensors have it; left out, as it is.
    """
    received = [Received(each, None) if isinstance(each, np.ndarray) else each for each in voltages]
    numbers = np.concatenate([turn.number for turn in turns])
    flags = np.zeros(numbers.size, dtype=np.int16)
    if submerged is not None:
        flags[np.concatenate(list(submerged))] = 64
    poses = [(turn.mast if sensed is None else sensed).pose(turn.time) for turn in turns]
    moving = sensed is not None or any(turn.mast.swing(turn.time).any() for turn in turns)
    bearings = [pose.bearing for pose in poses] if moving else [turn.azimuth for turn in turns]
    values = {
        "voltage": received[0].voltage if len(received) == 1 else np.concatenate([each.voltage for each in received]),
        "position": np.concatenate([pose.positions for pose in poses]),
        "attitude": np.concatenate([pose.attitude for pose in poses]),
        "flag": flags,
    }
    if any(each.saturated is not None for each in received):
        values["saturated"] = np.concatenate([each.saturated for each in received if each.saturated is not None])
    return build(
        "echoes",
        values,
        {
            "pulse": numbers,
            "range": gates(radar),
            "time": np.concatenate([turn.time for turn in turns]),
            "azimuth": np.concatenate(bearings),
            "transmitter": np.concatenate([turn.transmitter for turn in turns]),
            "turn": np.concatenate(
                [np.full(turn.number.size, first_turn + i, dtype=np.int32) for i, turn in enumerate(turns)]
            ),
        },
        {**echo_attributes(radar, first_turn + len(turns), received[0].full_scale_w), "polarization": polarization},
    )


class EchoStore:
    """A Zarr group that grows by whole turns; its attribute `complete_turns` counts those that are all there.

    Left as a context without a single one, it leaves nothing behind.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._group: zarr.Group | None = None
        self._begun = self._complete = False

    def append(self, turn: xr.Dataset) -> None:
        """Append one turn's echoes."""
        if self._group is None:
            self._group = self._create(turn)
            start = 0
        else:
            start = int(self._group["time"].shape[0])  # type: ignore[union-attr]
        rolling = {str(n): v.values for n, v in turn.variables.items() if v.dims[0] == "pulse"}
        try:
            for name, values in rolling.items():
                array = self._group[name]
                array.resize((start + values.shape[0], *array.shape[1:]))  # type: ignore[union-attr]
                array[start:] = values  # type: ignore[index]
        except BaseException:  # interrupted, or no space left: arrays of unlike length could not be read any more
            for name in rolling:
                array = self._group[name]
                array.resize((start, *array.shape[1:]))  # type: ignore[union-attr]
            raise
        self._group.attrs["complete_turns"] = turn.attrs["complete_turns"]
        self._complete = True

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._begun and not self._complete:
            shutil.rmtree(self.path, ignore_errors=True)

    def _create(self, turn: xr.Dataset) -> zarr.Group:
        if self.path.exists():
            shutil.rmtree(self.path)
        self._begun = True
        group = zarr.open_group(self.path, mode="w", zarr_format=3)
        for name, variable in turn.variables.items():
            rolling = variable.dims[0] == "pulse"
            shape = (0, *variable.shape[1:]) if rolling else variable.shape
            chunks = (_PULSES_A_CHUNK, *variable.shape[1:]) if rolling else variable.shape
            array = group.create_array(
                str(name),
                shape=shape,
                dtype=variable.dtype,
                chunks=chunks,
                compressors=None,  # noise does not compress, and a turn must be written in a fraction of a second
                dimension_names=[str(d) for d in variable.dims],
                attributes={k: (v.tolist() if isinstance(v, np.ndarray) else v) for k, v in variable.attrs.items()},
            )
            if not rolling:
                array[...] = variable.values
        group.attrs.update({**turn.attrs, "complete_turns": 0, "coordinates": _coordinate_names()})
        return group


def _coordinate_names() -> str:
    return "time azimuth transmitter turn"
