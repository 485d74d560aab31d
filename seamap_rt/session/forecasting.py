"""A sink that forecasts beside a run: each turn's map goes to a predictor, each forecast to prediction.nc."""

from __future__ import annotations

from types import TracebackType
from typing import Self

import numpy as np
import xarray as xr

from ..forecast_errors import Verified, came
from ..io.appendable import AppendableNetCDF
from ..prediction import WaveField, issue, predictor_of, vessel_notes, vessel_of
from ..simulation import Simulator
from ..window_errors import Windows, observed_windows
from .driver import FinishedTurn

_EACH = 4  # cells from one that the stated error is told at to the next: it changes over wavelengths


class ForecastSink:
    """Appends a forecast of each turn after which a sea is known (schema `prediction`). The turns must hold maps.

    Keeps the forecasts and the sea that came, for the run's own comparison; the predictor sees maps alone.
    Raises InputError for a vessel that is none.
    """

    stage = "predict"

    def __init__(self, file: AppendableNetCDF, simulator: Simulator) -> None:
        self._file, self._simulator = file, simulator
        self._settings = simulator.scene.resolved_prediction
        self._vessel = vessel_of(self._settings.vessel)
        self.vessel_notes = vessel_notes(self._vessel)
        self._predictor = predictor_of(self._settings)
        self._issued: list[tuple[int, xr.Dataset]] = []
        self._last: tuple[WaveField, xr.Dataset] | None = None
        self._number = -1

    def turn(self, turn: FinishedTurn) -> None:
        assert turn.maps is not None
        self._number = turn.number
        field = self._predictor.turn(turn.maps["polar"].to_dataset().isel(turn=0))
        if field is None:
            return
        made = issue(field, turn.number, self._settings, self._vessel)
        self._file.append(made)
        self._issued.append((turn.number, made))
        self._last = field, turn.maps["ground"].to_dataset()[["x", "y"]]

    def take_back(self) -> None:
        """Forget the last turn's forecast. The predictor goes no further: the run ends where a turn is taken back."""
        if self._issued and self._issued[-1][0] == self._number:
            self._issued.pop()
            self._file.take_back()

    def verified(self) -> Verified | None:
        """The forecasts beside the sea that came; None where no turn showed a sea."""
        judged = self._judged()
        if self._last is None or not judged:
            return None
        truth = np.concatenate([came(self._simulator.sea.judge, made) for made in judged])
        return Verified(_together(judged), truth, self._field(*self._last))

    def windows(self) -> Windows | None:
        """Quiet windows beside the sea that came; None where none were forecast, or not of the water's height alone."""
        judged = self._judged()
        return observed_windows(self._simulator.sea.judge, _together(judged)) if judged else None

    def _judged(self) -> list[xr.Dataset]:
        """Forecasts of times at which the sea is known: a recorded one ends."""
        ends = self._simulator.sea.ends_s
        return [made for _, made in self._issued if float(made["issued"].max() + made["lead"].max()) <= ends]

    def _field(self, field: WaveField, ground: xr.Dataset) -> xr.Dataset:
        x, y = ground["x"].values.astype(np.float64), ground["y"].values.astype(np.float64)
        east, north = (each.ravel() for each in np.meshgrid(x, y))
        moment = np.full(east.size, field.issued)
        few = np.meshgrid(x[::_EACH], y[::_EACH])
        _, std = field.elevation(few[0], few[1], field.issued)
        shape = y.size, x.size
        stated = np.repeat(np.repeat(std, _EACH, axis=0), _EACH, axis=1)[: shape[0], : shape[1]]
        values = {
            "reconstructed": field.elevation_alone(east, north, moment).reshape(shape),
            "stated": stated,
            "true": self._simulator.sea.known_elevation(east, north, moment).reshape(shape),
        }
        return xr.Dataset({name: (("y", "x"), each) for name, each in values.items()}, {"x": x, "y": y})

    def __enter__(self) -> Self:
        self._file.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool | None:
        return self._file.__exit__(kind, error, trace)


def _together(forecasts: list[xr.Dataset]) -> xr.Dataset:
    return xr.concat(forecasts, "issue", data_vars="minimal", coords="minimal")
