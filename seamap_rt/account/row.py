"""A row of the account: a part of the simulation, how or why, and what leaving it out costs."""

from __future__ import annotations

from typing import NamedTuple

NOTHING = "nothing"


class Row(NamedTuple):
    """What is, or is not, modelled."""

    what: str
    why: str
    error: str  # of leaving it out: a number with its unit
    source: str = ""  # of that number: a formula with its paper, or a measurement of this project


def metres_of_height(error: float, at_m: float | None = None) -> str:
    """An error of height in words, at a range [m] where it depends on that."""
    if error == 0.0:
        return NOTHING
    return f"{error:.2g} m rms of height" + ("" if at_m is None else f" at {at_m:.0f} m")


def decibels(error: float, of: str) -> str:
    return f"{error:.2g} dB of {of}"


def share(part: float) -> str:
    """A share in per cent, with two digits where it is small."""
    return f"{100.0 * part:.2g} %"
