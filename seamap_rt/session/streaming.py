"""What is sent of each turn to readers of a stream: pose, sea state, forecast, quiet windows, advice."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, Protocol

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..compute.machine import pool
from ..io.stream import Advice, Broadcast, Forecast, Pose, QuietWindows, SeaState, TurnMessage, signal_k_line
from ..prediction import Predictor, WaveField, advise, issue, predictor_of
from ..prediction.vessel import Vessel
from ..settings import PredictionSettings
from ..wavefield.sea_state import SeaStateRecord, water_of
from .driver import FinishedTurn, Sink
from .retrieving import Turn

Format = Literal["json", "signalk"]
LINES: dict[Format, Callable[[TurnMessage], str]] = {"json": TurnMessage.line, "signalk": signal_k_line}
_ROUND, _SPEEDS, _DRAWS = 12, 3, 20  # courses that are compared each turn, and draws of each
_STILL_M_S = 0.2  # slower, a course is none
_MOTIONS = ("heave", "roll", "pitch")


class Composer:
    """Makes the message of each turn from its echoes and maps, in their order. It never sees the truth."""

    def __init__(self, vessel: Vessel | None) -> None:
        self._vessel = vessel
        self._record: SeaStateRecord | None = None

    def compose(
        self, echoes: xr.Dataset, polar: xr.Dataset, forecast: tuple[WaveField, xr.Dataset] | None
    ) -> TurnMessage:
        """The message of one turn. echoes: schema `echoes`, the turn's own or more; polar: its `maps/polar`, without
        the dimension turn; forecast: the field and what was issued of it, None where no sea is known."""
        if self._record is None:
            self._record = SeaStateRecord(water_of(polar.attrs))
        number, time = int(polar["turn"]), float(polar["time"].max())
        pose = pose_of(echoes, number)
        made = None if forecast is None else forecast[1].isel(issue=0, place=0)
        with pool() as workers:
            row = workers.submit(self._record.row, polar)
            advice = None if forecast is None or self._vessel is None else _advice(forecast[0], self._vessel, pose)
            return TurnMessage(
                turn=number + 1,
                time_s=time,
                pose=pose,
                sea_state=_state(row.result()),
                forecast=None if made is None else _forecast(made),
                quiet_windows=None if made is None else _windows(made),
                advice=advice,
            )


def pose_of(echoes: xr.Dataset, number: int) -> Pose:
    """The boat at the end of a turn by its number from 0."""
    rows = np.flatnonzero(echoes["turn"].values == number)
    places = echoes["position"].isel(pulse=rows[[0, -1]]).values.mean(axis=1)
    seconds = float(np.diff(echoes["time"].values[rows[[0, -1]]])[0])
    roll, pitch, yaw = (float(each) for each in echoes["attitude"].isel(pulse=int(rows[-1])).values)
    east, north = (places[1] - places[0])[:2] / max(seconds, 1e-9)
    speed = float(np.hypot(east, north))
    course = float(np.degrees(np.arctan2(east, north)) % 360.0) if speed > _STILL_M_S else None
    return Pose(
        east_m=float(places[1, 0]),
        north_m=float(places[1, 1]),
        heading_deg=yaw % 360.0,
        roll_deg=roll,
        pitch_deg=pitch,
        course_deg=course,
        speed_m_s=speed,
    )


def _state(row: dict[str, float]) -> SeaState:
    units = {"significant_wave_height": "m", "peak_period": "s", "mean_direction": "deg", "directional_spread": "deg"}
    known: dict[str, float | None] = {}
    for name, unit in units.items():
        known[f"{name}_{unit}"] = _finite(row.get(name, np.nan))
        known[f"{name}_std_{unit}"] = _finite(row.get(f"{name}_std", np.nan))
    return SeaState(**known)


def _forecast(made: xr.Dataset) -> Forecast:
    height = made["elevation"].values.astype(np.float64)
    top = int(np.argmax(height))
    motions = {
        f"{name}{part}_{'m' if name == 'heave' else 'deg'}": _list(made[f"{name}{part}"].values)
        for name in _MOTIONS
        if name in made
        for part in ("", "_std")
    }
    return Forecast(
        lead_s=_list(made["lead"].values),
        elevation_m=_list(height),
        elevation_std_m=_list(made["elevation_std"].values),
        highest_crest_m=round(float(height[top]), 4),
        highest_crest_std_m=round(float(made["elevation_std"][top]), 4),
        highest_crest_lead_s=float(made["lead"][top]),
        maximum_prediction_time_s=float(made["maximum_prediction_time"]),
        **motions,
    )


def _windows(made: xr.Dataset) -> QuietWindows | None:
    if "quiet" not in made:
        return None
    lead, chance = made["lead"].values, made["quiet"].values.astype(np.float64)
    called = np.flatnonzero(np.nan_to_num(chance) >= made.attrs["confidence"])
    return QuietWindows(
        limits={name[6:]: float(made.attrs[name]) for name in map(str, made.attrs) if name.startswith("limit_")},
        duration_s=float(made.attrs["duration_s"]),
        confidence=float(made.attrs["confidence"]),
        lead_s=_list(lead),
        probability=[_finite(each) for each in chance],
        next_lead_s=float(lead[called[0]]) if called.size else None,
    )


def _advice(field: WaveField, vessel: Vessel, pose: Pose) -> Advice:
    heading = pose.heading_deg if pose.course_deg is None else pose.course_deg
    speeds = np.linspace(0.0, max(2.0 * pose.speed_m_s, 4.0), _SPEEDS)
    around = heading + 360.0 / _ROUND * np.arange(_ROUND)
    made = advise(field, vessel, around % 360.0, speeds, hold=(heading, pose.speed_m_s), draws=_DRAWS).attrs
    return Advice(
        mission=made["mission"],
        verdict=made["verdict"],
        held_heading_deg=float(made["heading_deg"]),
        held_speed_m_s=float(made["speed_m_s"]),
        best_heading_deg=float(made["best_heading_deg"]),
        best_speed_m_s=float(made["best_speed_m_s"]),
        better_probability=_finite(made["better_probability"]),
    )


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _list(values: NDArray[np.floating]) -> list[float]:
    return [round(float(each), 4) for each in values]


class ForecastSource(Protocol):
    """Who holds the forecast of the turn that came last: None where no sea is known."""

    latest: tuple[WaveField, xr.Dataset] | None


class StreamSink(Sink):
    """Sends each turn's message; a turn that a later sink cannot take has been sent all the same."""

    stage = "stream"

    def __init__(self, broadcast: Broadcast, source: ForecastSource, vessel: Vessel | None, form: Format) -> None:
        self._broadcast, self._source, self._line = broadcast, source, LINES[form]
        self._composer = Composer(vessel)

    def turn(self, turn: FinishedTurn) -> None:
        assert turn.maps is not None
        polar = turn.maps["polar"].to_dataset().isel(turn=0)
        self._broadcast.send(self._line(self._composer.compose(turn.echoes, polar, self._source.latest)))


class RetrievalStream:
    """Forecasts maps as they are retrieved, on the boat's own course, and sends each turn's message."""

    def __init__(self, broadcast: Broadcast, form: Format) -> None:
        self._broadcast, self._line = broadcast, LINES[form]
        self._settings = PredictionSettings()
        self._predictor: Predictor = predictor_of(self._settings)
        self._composer = Composer(None)

    def turn(self, turn: Turn) -> None:
        """Send the message of one turn's maps, and of the echoes that hold the turn."""
        echoes, polar = turn.echoes, turn.maps["polar"].to_dataset().isel(turn=-1)
        field, pose = self._predictor.turn(polar), pose_of(echoes, int(polar["turn"]))
        course = {"heading_deg": pose.course_deg or 0.0, "speed_m_s": pose.speed_m_s if pose.course_deg else 0.0}
        settings = self._settings.model_copy(update=course)
        forecast = None if field is None else (field, issue(field, int(polar["turn"]), settings))
        self._broadcast.send(self._line(self._composer.compose(echoes, polar, forecast)))
