"""Rows of the account: the keys that they have, and the words that several of them share."""

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
