"""Forecasts beside a run, and the sea that came."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..forecast_errors import VerifiedForecasts, true_elevation
from ..prediction import WaveField, issue, predictor_of, vessel_notes, vessel_of
from ..simulation import Simulator
from ..window_errors import Windows, observed_windows
from .driver import FinishedTurn, Sink

_EACH = 4  # cells between those at which the error is stated: it changes over wavelengths


class ForecastSink(Sink):
    """Makes a forecast of each turn after which a sea is known (schema `prediction`). The turns must hold maps.

    Keeps the forecasts and the sea that came, for the run's own comparison; the predictor sees maps alone.
    Raises InputError for a vessel that is none.
    """

    stage = "predict"

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator
        self._settings = simulator.scene.resolved_prediction
        self.vessel = vessel_of(self._settings.vessel)
        self.vessel_notes = vessel_notes(self.vessel)
        self._predictor = predictor_of(self._settings)
        self._issued: list[xr.Dataset] = []
        self._last: tuple[WaveField, xr.Dataset] | None = None
        self.latest: tuple[WaveField, xr.Dataset] | None = None  # the field after the last turn, and its forecast

    def turn(self, turn: FinishedTurn) -> None:
        assert turn.maps is not None
        self.latest, field = None, self._predictor.turn(turn.maps["polar"].to_dataset().isel(turn=0))
        if field is None:
            return
        made = issue(field, turn.number, self._settings, self.vessel)
        self._issued.append(made)
        self.latest = field, made
        self._last = field, turn.maps["ground"].to_dataset()[["x", "y"]]

    def verified_forecasts(self) -> VerifiedForecasts | None:
        """The forecasts beside the sea that came; None where no turn showed a sea."""
        judged = self._judged_forecasts()
        if self._last is None or not judged:
            return None
        truth = np.concatenate([true_elevation(self._simulator.sea.judge, made) for made in judged])
        return VerifiedForecasts(_join_issues(judged), truth, self._field_map(*self._last))

    def windows(self) -> Windows | None:
        """Quiet windows beside the sea that came; None where none were forecast, or not of the water's height alone."""
        judged = self._judged_forecasts()
        return observed_windows(self._simulator.sea.judge, _join_issues(judged)) if judged else None

    def _judged_forecasts(self) -> list[xr.Dataset]:
        """Forecasts of times at which the sea is known: a recorded one ends."""
        ends = self._simulator.sea.ends_s
        return [made for made in self._issued if float(made["issued"].max() + made["lead"].max()) <= ends]

    def _field_map(self, field: WaveField, ground: xr.Dataset) -> xr.Dataset:
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
            "true": self._simulator.sea.judge.elevation(east, north, moment).reshape(shape),
        }
        return xr.Dataset({name: (("y", "x"), each) for name, each in values.items()}, {"x": x, "y": y})


def _join_issues(forecasts: list[xr.Dataset]) -> xr.Dataset:
    return xr.concat(forecasts, "issue", data_vars="minimal", coords="minimal")
