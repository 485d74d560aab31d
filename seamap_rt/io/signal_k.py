"""Turn messages as Signal K deltas (specification 1.8.2: schemas/delta.json and groups): SI units, angles in radians.

By the specification's own paths: navigation.headingTrue, navigation.attitude, navigation.speedOverGround and
navigation.courseOverGroundTrue, of the boat at the end of the turn; and notifications.* for the quiet window, the
highest crest and the advice, each with method, state and message.

The specification has no path for waves (`environment.water` holds temperature and salinity, `environment.heave` is the
boat's heave now, which this radar does not measure). Names that public plugins use stand in for it, with their units in
`meta`: environment.water.waves.significantHeight [m], .period [s], .directionTrue [rad, from which they come], and,
our own, .significantHeightError, .periodError and .forecast (the message's own forecast, as an object).
"""

from __future__ import annotations

import json
from datetime import UTC, datetime
from math import radians
from typing import Any

from .stream import TurnMessage

_WAVES = "environment.water.waves"
_META = {
    f"{_WAVES}.significantHeight": ("m", "Significant wave height"),
    f"{_WAVES}.significantHeightError": ("m", "Standard error of the significant wave height"),
    f"{_WAVES}.period": ("s", "Period of the spectrum's peak"),
    f"{_WAVES}.periodError": ("s", "Standard error of the peak period"),
    f"{_WAVES}.directionTrue": ("rad", "Direction from which the waves come, from true north"),
}


def delta(message: TurnMessage, now: datetime | None = None) -> dict[str, Any]:
    """A delta of one turn; what is not known is left out. now: when it is sent, in UTC; a simulation has no date."""
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


def line(message: TurnMessage) -> str:
    """One line of JSON, without its end."""
    return json.dumps(delta(message), allow_nan=False, ensure_ascii=False)


def _radians(degrees: float | None) -> float | None:
    return None if degrees is None else radians(degrees % 360.0)


def _notification(message: str) -> dict[str, Any]:
    return {"method": ["visual"], "state": "normal", "message": message}
