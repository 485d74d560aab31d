"""The state of a record of a nonlinear sea on file, from which work goes on that was interrupted."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..io.opening import read_npz
from ..sea.high_order import Evolution, State

_NUMBERS = ("frames", "variance", "skewness", "energy_first", "broken_first")


@dataclass(frozen=True)
class RecordState:
    """The state from which the next frame follows, and sums over the frames that are on file."""

    state: State
    frames: int = 0
    variance: float = 0.0  # m², of the elevation, added up
    skewness: float = 0.0
    energy_first: float = np.nan  # m³/s², at the first frame
    broken_first: float = 0.0  # taken out by then

    def with_frame(self, state: State, elevation: NDArray[np.float32], evolution: Evolution) -> RecordState:
        """With one more frame."""
        heights = elevation.astype(np.float64)
        heights -= heights.mean()
        variance = float(np.mean(heights**2))
        first = {} if self.frames else {"energy_first": evolution.energy(state), "broken_first": state.broken}
        return replace(
            self,
            state=state,
            frames=self.frames + 1,
            variance=self.variance + variance,
            skewness=self.skewness + float(np.mean(heights**3)) / variance**1.5,
            **first,
        )


def state_file(folder: Path) -> Path:
    """Where the state is kept while the record is not finished."""
    return folder / ".recorded_sea.state.npz"


def save_state(folder: Path, attributes: Mapping[str, Any], at: RecordState) -> None:
    """Write the state, whole or not at all. attributes: what the record says of itself."""
    path = state_file(folder)
    part = path.with_name(f"{path.name}.part")
    state = at.state
    with part.open("wb") as file:
        np.savez(
            file,
            told=np.array(_plain(attributes)),
            elevation=state.elevation,
            potential=state.potential,
            of_state=np.array([state.time, state.energy, state.broken]),
            numbers=np.array([getattr(at, name) for name in _NUMBERS], dtype=np.float64),
        )
    os.replace(part, path)


def load_state(folder: Path, attributes: Mapping[str, Any]) -> RecordState:
    """What was kept. InputError where it is damaged, or of another record than the one that is asked for."""
    path = state_file(folder)
    try:
        _, stored = read_npz(path, ("told", "of_state", "numbers", "elevation", "potential"))
        before = json.loads(str(stored["told"]))
        time, energy, broken = map(float, stored["of_state"])
        numbers = dict(zip(_NUMBERS, map(float, stored["numbers"]), strict=True))
        state = State(time, stored["elevation"], stored["potential"], energy, broken)
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise InputError(f"{path}: cannot be read ({error}); run it again with --overwrite") from None
    now = json.loads(_plain(attributes))
    other = [name for name in now if before.get(name) != now[name]]
    if other:
        raise InputError(
            f"--resume: '{folder}' was begun with another {other[0]}; give the command as it was, or --overwrite"
        )
    return RecordState(state, **{**numbers, "frames": int(numbers["frames"])})


def _plain(attributes: Mapping[str, Any]) -> str:
    return json.dumps(dict(attributes), allow_nan=True, sort_keys=True)
