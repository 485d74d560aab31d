"""Rows of the account: the keys that they have, the words that several of them share, and what each costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Row = dict[str, Any]  # in the keys of metrics.json: what, why, error, value, unit, source
Rows = Sequence[Mapping[str, Any]]

HEIGHT, CYCLES = "m rms of height", "cycles of phase in a dwell"  # units and errors
MEAN_ECHO, OWN_ECHO = "dB of the mean echo", "dB of facets' own echo"
STILL = "√2 σ √(1 − ρ), against the sea half-way through (Longuet-Higgins 1957)"  # sources
BURSTS = "1 is the shape of measured bursts' K-distribution"
PATTERN = "integral of the two-way azimuth pattern"
TWO_SCALE = "two-scale theory over slopes that face the antenna and over winds"
TILT = "range × tilt along the look, {:.2g}° rms"
UNRESOLVED, TILTS = "shadowing by waves that are not resolved", "Smith (1967), their slopes"
BENT = "Smith (1967), less the knife-edge field in a mean shadow"


def row(name: str, value: float, error: str, source: str, says: str) -> Row:
    """error: the value's unit, "1" where there is none, and words that follow; says: how it is modelled, or why not."""
    unit, words = error.split(" ", 1)
    amount = f"{float(f'{value:.2g}'):g}" + ("" if unit == "1" else f" {unit}")
    told = "nothing" if unit == "m" and value == 0.0 else f"{amount} {words}"
    return {"what": name, "why": says, "error": told, "value": value, "unit": unit, "source": source}


_TURN = ("sea", "mesh", "trace", "objects", "echoes")  # what a simulated turn waits for
_STAGES = {  # others by their own names
    "sea": ("sea", "mesh"),
    "shadowing": ("trace",),
    UNRESOLVED: ("shade",),
    "receiver": ("receive",),
}
_WITHIN = {  # others: within the echoes
    "scan": "sea",
    "boat": "sea",
    "sea spikes": "scattering",
    "analogue-to-digital conversion": "receive",
}
_ONCE = {"scattering": "calibrate"}


def costed(rows: Rows, timing: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The rows with `cost` in words, and `cost_s` [s] and `cost_share` of a turn where they can be told apart.

    timing: {"first": {stage: s}, "warm": {stage: s} or None}, of which the warm turns count if there are any.
    """
    first, warm = timing["first"], timing["warm"]
    turn = warm or first
    whole = sum(turn.get(stage, 0.0) for stage in _TURN)
    return [{**row, **_cost(row["what"], turn, whole, first, "" if warm else ", first turn")} for row in rows]


def _cost(name: str, turn: Mapping[str, float], whole: float, first: Mapping[str, float], which: str) -> dict[str, Any]:
    stages = [stage for stage in _STAGES.get(name, (name,)) if stage in turn]
    if not stages:
        within = _WITHIN.get(name, "echoes")
        words = f"within {within}, {turn[within]:.2g} s{which}" if within in turn else "not timed"
        return {"cost": words, "cost_s": None, "cost_share": None}
    seconds = sum(turn[stage] for stage in stages)
    share = seconds / whole if whole > 0.0 else 0.0
    once = first.get(_ONCE.get(name, ""), 0.0)
    words = f"{seconds:.2g} s, {share:.0%} of a turn{which}" + (f"; {once:.2g} s once a run" if once > 0.005 else "")
    return {"cost": words, "cost_s": seconds, "cost_share": share}


def account_lines(modelled: Rows, left_out: Rows, most: int = 20) -> list[str]:
    """What is modelled with its cost, what is left out with its error; beyond `most` lines the last one only names."""
    lines = [
        f"modelled: {row['what']} ({row.get('cost', 'not timed')}; without it {row.get('error') or 'not known'})"
        for row in modelled
    ]
    lines += [f"left out: {row['what']} ({row.get('error') or 'not known'})" for row in left_out]
    if len(lines) <= most:
        return lines
    others = "; ".join(row["what"] for row in [*modelled, *left_out][most - 1 :])
    return [*lines[: most - 1], f"left out: {others} (errors in the report)"]
