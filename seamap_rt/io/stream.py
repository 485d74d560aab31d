"""A line of JSON for each turn, sent to whoever connects: the schema of its messages, and the sockets.

A message is one JSON object on one line, UTF-8, ended by a newline; `TurnMessage` is its schema, and
`TurnMessage.model_json_schema()` the same as JSON Schema. `version` grows when a field changes its meaning or goes;
fields may join without that, so a reader passes over those that it does not know. What is not known is null.
`signal_k_line` says the same as a delta of Signal K.

Readers connect and only read. Each has a queue of its own: one that is slow loses turns, oldest first, never a part of
one, and the run waits for none.
"""

from __future__ import annotations

import contextlib
import ipaddress
import json
import queue
import socket
import threading
import time
from contextlib import AbstractContextManager
from datetime import UTC, datetime
from math import radians
from typing import Any, Literal, Self
from urllib.parse import urlsplit

from pydantic import BaseModel, ConfigDict

from ..errors import InputError

VERSION = 1
_MOST_READERS = 16
_MOST_TURNS = 4  # that wait for a reader
_LAST_S = 1.0  # at the end, for the readers to take the last turns
_FORM = "as in tcp://127.0.0.1:8765"


class Part(BaseModel):
    """A part of a message: numbers are finite, or null where not known."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Pose(Part):
    """The boat at the end of the turn, as its sensors have it; east and north of the origin, course and speed of the
    antennas' mean way in the turn over ground, angles clockwise from north, roll starboard down, pitch bow up."""

    east_m: float
    north_m: float
    heading_deg: float
    roll_deg: float
    pitch_deg: float
    course_deg: float | None = None
    speed_m_s: float


class SeaState(Part):
    """As `sea_state`, of the turns up to this one; `_std`: standard errors. Direction: from which the waves come."""

    significant_wave_height_m: float | None = None
    significant_wave_height_std_m: float | None = None
    peak_period_s: float | None = None
    peak_period_std_s: float | None = None
    mean_direction_deg: float | None = None
    mean_direction_std_deg: float | None = None
    directional_spread_deg: float | None = None
    directional_spread_std_deg: float | None = None


class Forecast(Part):
    """Of the water, and of the vessel where one is named, along the boat's way; one value for each of `lead_s`, seconds
    after `time_s` of the message; `_std`: standard errors. highest_crest_…: the highest expected elevation."""

    lead_s: list[float]
    elevation_m: list[float]
    elevation_std_m: list[float]
    heave_m: list[float] | None = None
    heave_std_m: list[float] | None = None
    roll_deg: list[float] | None = None
    roll_std_deg: list[float] | None = None
    pitch_deg: list[float] | None = None
    pitch_std_deg: list[float] | None = None
    highest_crest_m: float
    highest_crest_std_m: float
    highest_crest_lead_s: float
    maximum_prediction_time_s: float


class QuietWindows(Part):
    """How likely all limits (by `prediction.quiet`'s quantities) hold for duration_s from each lead on; null where the
    window ends beyond the forecast. next_lead_s: the first that is called, probability ≥ confidence."""

    limits: dict[str, float]
    duration_s: float
    confidence: float
    lead_s: list[float]
    probability: list[float | None]
    next_lead_s: float | None = None


class Advice(Part):
    """What `advise` says is best for a mission, against holding on; probability: that it is better."""

    mission: str
    verdict: str
    held_heading_deg: float
    held_speed_m_s: float
    best_heading_deg: float
    best_speed_m_s: float
    better_probability: float | None = None


class TurnMessage(Part):
    """One turn. turn: from 1; time_s: of its end, as the echoes count time. forecast: null while no sea is known;
    quiet_windows: null where no limit is given; advice: null where no vessel is named."""

    format: Literal["seamap_rt.turn"] = "seamap_rt.turn"
    version: Literal[1] = VERSION
    turn: int
    time_s: float
    pose: Pose
    sea_state: SeaState
    forecast: Forecast | None = None
    quiet_windows: QuietWindows | None = None
    advice: Advice | None = None

    def line(self) -> str:
        """One line of JSON, without its end."""
        return self.model_dump_json()


# ------------------------------------------------------------------------------------------------------- Signal K


_WAVES = "environment.water.waves"
_META = {
    f"{_WAVES}.significantHeight": ("m", "Significant wave height"),
    f"{_WAVES}.significantHeightError": ("m", "Standard error of the significant wave height"),
    f"{_WAVES}.period": ("s", "Period of the spectrum's peak"),
    f"{_WAVES}.periodError": ("s", "Standard error of the peak period"),
    f"{_WAVES}.directionTrue": ("rad", "Direction from which the waves come, from true north"),
}


def signal_k_delta(message: TurnMessage, now: datetime | None = None) -> dict[str, Any]:
    """A delta of one turn (specification 1.8.2: schemas/delta.json and groups), in SI units and radians; what is not
    known is left out. now: when it is sent, in UTC; a simulation has no date.

    By the specification's own paths: navigation.headingTrue, .attitude, .speedOverGround and .courseOverGroundTrue, of
    the boat at the end of the turn; and notifications.* for the quiet window, the highest crest and the advice, each
    with method, state and message. It has no path for waves (`environment.water` holds temperature and salinity,
    `environment.heave` is the boat's heave now, which this radar does not measure). Names that public plugins use stand
    in for it, with their units in `meta`: environment.water.waves.significantHeight [m], .period [s], .directionTrue
    [rad, from which they come], and, our own, .significantHeightError, .periodError and .forecast (the message's own
    forecast, as an object).
    """
    pose, state = message.pose, message.sea_state
    values: dict[str, Any] = {
        "navigation.headingTrue": radians(pose.heading_deg % 360.0),
        "navigation.attitude": {"roll": radians(pose.roll_deg), "pitch": radians(pose.pitch_deg)},
        "navigation.speedOverGround": pose.speed_m_s,
        "navigation.courseOverGroundTrue": _radians(pose.course_deg),
        f"{_WAVES}.significantHeight": state.significant_wave_height_m,
        f"{_WAVES}.significantHeightError": state.significant_wave_height_std_m,
        f"{_WAVES}.period": state.peak_period_s,
        f"{_WAVES}.periodError": state.peak_period_std_s,
        f"{_WAVES}.directionTrue": _radians(state.mean_direction_deg),
    }
    if coming := message.forecast:
        values[f"{_WAVES}.forecast"] = coming.model_dump(exclude_none=True)
        values[f"notifications.{_WAVES}.highestCrest"] = _notification(
            f"highest crest {coming.highest_crest_m:.1f} ± {1.96 * coming.highest_crest_std_m:.1f} m "
            f"in {coming.highest_crest_lead_s:.0f} s"
        )
    if quiet := message.quiet_windows:
        opens = quiet.next_lead_s
        words = f"in {opens:.0f} s" if opens is not None else "none is likely enough"
        values[f"notifications.{_WAVES}.quietWindow"] = _notification(
            f"quiet window of {quiet.duration_s:g} s: {words}"
        )
    if message.advice:
        values["notifications.steering.advice"] = _notification(message.advice.verdict)
    stamp = (now or datetime.now(UTC)).strftime("%Y-%m-%dT%H:%M:%S.%fZ")
    known = [{"path": path, "value": value} for path, value in values.items() if value is not None]
    sent = {each["path"] for each in known}
    meta = [
        {"path": path, "value": {"units": unit, "description": words}}
        for path, (unit, words) in _META.items()
        if path in sent
    ]
    update: dict[str, Any] = {"$source": "seamap_rt", "timestamp": stamp, "values": known}
    return {"context": "vessels.self", "updates": [update | ({"meta": meta} if meta else {})]}


def signal_k_line(message: TurnMessage) -> str:
    """One line of JSON of its delta, without its end."""
    return json.dumps(signal_k_delta(message), allow_nan=False, ensure_ascii=False)


def _radians(degrees: float | None) -> float | None:
    return None if degrees is None else radians(degrees % 360.0)


def _notification(message: str) -> dict[str, Any]:
    return {"method": ["visual"], "state": "normal", "message": message}


# ----------------------------------------------------------------------------------------------------- the sockets


def address_of(text: str) -> tuple[str, int]:
    """Host and port of tcp://HOST:PORT; port 0 is a free one. Raises InputError for what is none."""
    about = f"--stream {text}"
    try:
        parts = urlsplit(text)
        host, port = parts.hostname, parts.port
    except ValueError:
        raise InputError(f"{about}: the port must be 0 to 65535, {_FORM}") from None
    if parts.scheme != "tcp" or not host or port is None or parts.path or parts.query or parts.username:
        raise InputError(f"{about}: must be tcp://HOST:PORT, {_FORM}")
    return host, port


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches it."""
    with contextlib.suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return host == "localhost"


class Broadcast(AbstractContextManager):
    """Listens from the moment it is made, and sends lines to all that are connected, until it is left.

    Raises InputError where the address cannot be listened on.
    """

    def __init__(self, address: str) -> None:
        host, port = address_of(address)
        self.loopback = is_loopback(host)
        try:
            family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
            self._listening = socket.create_server((host, port), family=family)
        except OSError as error:
            raise InputError(
                f"--stream {address}: cannot be listened on ({error.strerror or error}); give an "
                "address of this machine and a port that is free, or 0 for any"
            ) from None
        self.address = f"tcp://{f'[{host}]' if ':' in host else host}:{self._listening.getsockname()[1]}"
        self._readers: list[_Reader] = []
        self._lock = threading.Lock()
        threading.Thread(target=self._accept, name="stream", daemon=True).start()

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._listening.accept()
            except OSError:  # closed: the end
                return
            with self._lock:
                self._readers = [each for each in self._readers if each.alive]
                if len(self._readers) < _MOST_READERS:
                    self._readers.append(_Reader(connection))
                else:
                    connection.close()

    @property
    def readers(self) -> int:
        """How many are connected, as far as is known."""
        with self._lock:
            return sum(each.alive for each in self._readers)

    def send(self, line: str) -> None:
        """Send a line to all readers; returns at once."""
        whole = f"{line}\n".encode()
        with self._lock:
            self._readers = [each for each in self._readers if each.alive]
            for reader in self._readers:
                reader.offer(whole)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: Any) -> None:
        with contextlib.suppress(OSError):
            self._listening.shutdown(socket.SHUT_RDWR)  # wakes the thread that accepts
        self._listening.close()
        until = time.monotonic() + _LAST_S
        with self._lock:
            for reader in self._readers:
                reader.offer(None)
            for reader in self._readers:
                reader.close(max(0.0, until - time.monotonic()))


class _Reader:
    """One that is connected, and the thread that sends to it."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._waiting: queue.Queue[bytes | None] = queue.Queue(_MOST_TURNS)
        self._thread = threading.Thread(target=self._send, name="stream reader", daemon=True)
        self._thread.start()

    @property
    def alive(self) -> bool:
        return self._thread.is_alive()

    def offer(self, line: bytes | None) -> None:
        """A line, in place of the oldest one where too many wait; None: the last has been offered."""
        while True:
            try:
                return self._waiting.put_nowait(line)
            except queue.Full:
                with contextlib.suppress(queue.Empty):
                    self._waiting.get_nowait()

    def _send(self) -> None:
        with contextlib.suppress(OSError), self._connection:
            while (line := self._waiting.get()) is not None:
                self._connection.sendall(line)

    def close(self, wait_s: float) -> None:
        self._thread.join(wait_s)
        with contextlib.suppress(OSError):
            self._connection.shutdown(socket.SHUT_RDWR)
