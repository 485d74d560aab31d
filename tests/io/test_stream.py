"""The stream: its schema, and readers that read, do not read, or go away."""

from __future__ import annotations

import json
import re
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seamap_rt.errors import InputError
from seamap_rt.io.stream import (
    Advice,
    Broadcast,
    Forecast,
    Pose,
    QuietWindows,
    SeaState,
    TurnMessage,
    address_of,
    signal_k_delta,
)

ANYWHERE = "tcp://127.0.0.1:0"
BIG = "x" * 1_000_000  # more than the sockets of both sides hold


def message(**changed: Any) -> TurnMessage:
    parts: dict[str, Any] = {
        "turn": 3,
        "time_s": 2.99,
        "pose": Pose(
            east_m=1.0,
            north_m=2.0,
            heading_deg=350.0,
            roll_deg=2.0,
            pitch_deg=-1.0,
            course_deg=90.0,
            speed_m_s=3.0,
        ),
        "sea_state": SeaState(
            significant_wave_height_m=1.2, significant_wave_height_std_m=0.2, mean_direction_deg=270.0
        ),
        "forecast": Forecast(
            lead_s=[0.0, 0.5],
            elevation_m=[0.1, 0.4],
            elevation_std_m=[0.05, 0.1],
            highest_crest_m=0.4,
            highest_crest_std_m=0.1,
            highest_crest_lead_s=0.5,
            maximum_prediction_time_s=20.0,
        ),
        "quiet_windows": QuietWindows(
            limits={"roll": 5.0}, duration_s=5.0, confidence=0.9, lead_s=[0.0, 0.5], probability=[0.2, None]
        ),
        "advice": Advice(
            mission="least_roll",
            verdict="no difference that can be told",
            held_heading_deg=90.0,
            held_speed_m_s=3.0,
            best_heading_deg=60.0,
            best_speed_m_s=2.0,
        ),
    }
    return TurnMessage(**parts | changed)


def connected(broadcast: Broadcast, count: int = 1) -> list[socket.socket]:
    """So many readers, which the broadcast knows of."""
    place = address_of(broadcast.address)
    made = [socket.create_connection(place, timeout=20.0) for _ in range(count)]
    until(lambda: broadcast.readers == count)
    return made


def until(true: Callable[[], bool]) -> None:
    end = time.monotonic() + 20.0
    while not true():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_message_is_one_line_and_comes_back_as_it_was() -> None:
    line = message().line()
    assert "\n" not in line
    assert TurnMessage.model_validate_json(line) == message()
    assert json.loads(line)["format"] == "seamap_rt.turn"
    assert json.loads(line)["version"] == 1


def test_no_message_holds_what_json_has_no_number_for() -> None:
    with pytest.raises(ValueError, match="finite"):
        message(time_s=np.nan)


def test_the_schema_names_every_field() -> None:
    schema = TurnMessage.model_json_schema()
    assert set(schema["properties"]) == set(json.loads(message().line()))
    assert set(schema["required"]) == {"turn", "time_s", "pose", "sea_state"}


def test_two_readers_get_every_line_in_order_and_then_the_end() -> None:
    with Broadcast(ANYWHERE) as broadcast:
        readers = connected(broadcast, 2)
        for number in range(3):
            broadcast.send(str(number))
    for reader in readers:
        with reader, reader.makefile() as lines:
            assert list(lines) == ["0\n", "1\n", "2\n"]


def test_a_reader_that_never_reads_delays_nobody_and_loses_whole_turns() -> None:
    """Sending is an offer to a queue: without a reader's reading, 200 MB are offered in less time than one of them
    would take to go through a socket that is full, which is for ever."""
    with Broadcast(ANYWHERE) as broadcast:
        (idle,) = connected(broadcast)
        begun = time.process_time()
        for number in range(200):
            broadcast.send(f"{number} {BIG}")
        assert time.process_time() - begun < 5.0
        broadcast.send("last")
        with idle, idle.makefile() as lines:
            got = [lines.readline()]
            while got[-1] != "last\n":
                got.append(lines.readline())
    assert all(line.endswith(f" {BIG}\n") for line in got[:-1])  # none in part
    numbers = [int(line.split()[0]) for line in got[:-1]]
    assert numbers == sorted(set(numbers))
    assert numbers[-3:] == [197, 198, 199]  # beside "last", the newest wait
    assert len(numbers) < 50  # Linux lets a socket hold some megabytes on each side


def test_the_end_waits_a_second_at_most_for_a_reader_that_never_reads() -> None:
    with Broadcast(ANYWHERE) as broadcast:
        (idle,) = connected(broadcast)
        for _ in range(20):
            broadcast.send(BIG)
        begun = time.monotonic()
    assert time.monotonic() - begun < 5.0  # of a machine that is busy
    idle.close()


def test_a_reader_that_dies_is_forgotten_and_the_others_read_on() -> None:
    with Broadcast(ANYWHERE) as broadcast:
        dead, living = connected(broadcast, 2)
        dead.close()

        def gone() -> bool:
            broadcast.send("again")
            return broadcast.readers == 1

        until(gone)
        broadcast.send("last")
    with living, living.makefile() as lines:
        assert list(lines)[-1] == "last\n"


def test_a_port_in_use_is_refused_in_one_line() -> None:
    with Broadcast(ANYWHERE) as broadcast, pytest.raises(InputError, match="cannot be listened on") as refusal:
        Broadcast(broadcast.address)
    assert len(refusal.value.problems) == 1


@pytest.mark.parametrize(
    "text", ["127.0.0.1:80", "udp://127.0.0.1:80", "tcp://127.0.0.1", "tcp://:80", "tcp://a:99999", "tcp://a:80/x", ""]
)
def test_an_address_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="--stream"):
        address_of(text)


@pytest.mark.parametrize(("host", "loopback"), [("127.0.0.1", True), ("localhost", True), ("0.0.0.0", False)])
def test_who_can_read_is_known(host: str, loopback: bool) -> None:
    with Broadcast(f"tcp://{host}:0") as broadcast:
        assert broadcast.loopback is loopback


def test_the_client_of_the_readme_reads_what_is_sent() -> None:
    readme = (Path(__file__).parents[2] / "seamap_rt" / "README.md").read_text(encoding="utf-8")
    (client,) = re.findall(r"^```python3\n(.*?)^```$", readme, flags=re.MULTILINE | re.DOTALL)
    with Broadcast(ANYWHERE) as broadcast:
        port = str(address_of(broadcast.address)[1])
        reader = subprocess.Popen(
            [sys.executable, "-c", client.replace("8765", port)], stdout=subprocess.PIPE, text=True
        )
        until(lambda: broadcast.readers == 1)
        for each in (message(turn=1, forecast=None), message(turn=2)):
            broadcast.send(each.line())
    said, _ = reader.communicate(timeout=60.0)
    assert said == "turn 2: 0.40 ± 0.20 m in 0 s\n"


# --------------------------------------------------------------------------- Signal K, facts of specification 1.8.2
# schemas/delta.json: an update holds only these keys, and one of source and $source; values and meta are lists of path
# and value. schemas/definitions.json: patterns of $source and timestamp, alarmState, alarmMethodEnum; a notification
# needs method, state and message. schemas/groups/navigation.json: units.
UPDATE = {"$source", "source", "timestamp", "values", "meta"}
STATES = {"nominal", "normal", "alert", "warn", "alarm", "emergency"}


def delta() -> dict[str, Any]:
    return json.loads(json.dumps(signal_k_delta(message(), datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC))))


def test_a_delta_keeps_the_schema() -> None:
    made = delta()
    assert set(made) == {"context", "updates"}
    (update,) = made["updates"]
    assert set(update) <= UPDATE
    assert ("source" in update) != ("$source" in update)
    assert update["timestamp"] == "2026-01-02T03:04:05.000000Z"
    for part in ("values", "meta"):
        for each in update[part]:
            assert set(each) == {"path", "value"}
            assert isinstance(each["value"], (str, float, int, dict, bool))


def test_a_delta_is_in_its_own_units() -> None:
    values = {each["path"]: each["value"] for each in delta()["updates"][0]["values"]}
    assert values["navigation.headingTrue"] == pytest.approx(np.radians(350.0))
    assert values["navigation.attitude"] == pytest.approx({"roll": np.radians(2.0), "pitch": np.radians(-1.0)})
    assert values["navigation.courseOverGroundTrue"] == pytest.approx(np.pi / 2.0)
    assert values["navigation.speedOverGround"] == 3.0
    assert values["environment.water.waves.significantHeight"] == 1.2
    assert "environment.water.waves.period" not in values  # not known


def test_notifications_have_method_state_and_message() -> None:
    told = [each for each in delta()["updates"][0]["values"] if each["path"].startswith("notifications.")]
    assert len(told) == 3
    for each in told:
        assert set(each["value"]) == {"method", "state", "message"}
        assert set(each["value"]["method"]) <= {"visual", "sound"}
        assert each["value"]["state"] in STATES


def test_without_a_sea_a_delta_tells_of_the_boat_alone() -> None:
    bare = message(sea_state=SeaState(), forecast=None, quiet_windows=None, advice=None)
    (update,) = signal_k_delta(bare)["updates"]
    assert "meta" not in update
    assert all(each["path"].startswith("navigation.") for each in update["values"])
