"""What each part of a turn costs, by the run's own stopwatch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

_TURN = ("sea", "mesh", "trace", "objects", "echoes")  # what a simulated turn waits for
_STAGES = {"sea": ("sea", "mesh"), "shadowing": ("trace",), "receiver": ("receive",)}  # others by their own names
_WITHIN = {"scan": "sea", "boat": "sea"}  # of parts that have no stage of their own; else within the echoes
_ONCE = {"scattering": "calibrate"}


def costed(rows: Sequence[Mapping[str, Any]], timing: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The rows with `cost` in words, and `cost_s` [s] and `cost_share` of a turn where they can be told apart.

    timing: {"first": {stage: s}, "warm": {stage: s} or None}, of which the warm turns count if there are any.
    """
    first, warm = timing["first"], timing["warm"]
    turn = warm or first
    whole = sum(turn.get(stage, 0.0) for stage in _TURN)
    return [{**row, **_cost(row["what"], turn, whole, first, "" if warm else ", first turn")} for row in rows]


def _cost(what: str, turn: Mapping[str, float], whole: float, first: Mapping[str, float], which: str) -> dict[str, Any]:
    stages = [stage for stage in _STAGES.get(what, (what,)) if stage in turn]
    if not stages:
        within = _WITHIN.get(what, "echoes")
        if within not in turn:
            return {"cost": "not timed", "cost_s": None, "cost_share": None}
        return {"cost": f"within {within}, {turn[within]:.2g} s{which}", "cost_s": None, "cost_share": None}
    seconds = sum(turn[stage] for stage in stages)
    part = seconds / whole if whole > 0.0 else 0.0
    once = first.get(_ONCE.get(what, ""), 0.0)
    words = f"{seconds:.2g} s, {part:.0%} of a turn{which}" + (f"; {once:.2g} s once a run" if once > 0.005 else "")
    return {"cost": words, "cost_s": seconds, "cost_share": part}
