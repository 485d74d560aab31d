"""When a sweep has seeds enough: as sure of its choice as was asked for, or out of time; how many a band asks for.

A sweep that stops as soon as it is sure stops a little too often when it is sure by chance: of the confidence that was
asked for, a few per cent less is reached (Wald 1947, Sequential Analysis).
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from ..errors import InputError

MOST_SEEDS = 64
_UNITS_S = {"s": 1.0, "min": 60.0, "h": 3600.0}


@dataclass(frozen=True)
class Goal:
    """until: confidence of every choice that is asked for, 0 to 1; budget_s: seconds in which no further seeds begin
    that would not end in them. None: not asked for; with neither, the seeds that a sweep begins with are enough.
    at_most: of the key that is chosen, the greatest value that may be. Raises InputError for what cannot be reached."""

    until: float | None = None
    budget_s: float | None = None
    at_most: float | None = None

    def __post_init__(self) -> None:
        if self.until is not None and not 0.5 <= self.until < 1.0:
            raise InputError(f"--until = {self.until:g}: must be from 0.5 to less than 1; 0.95 is usual")
        if self.budget_s is not None and not 0.0 < self.budget_s < float("inf"):
            raise InputError(f"--budget = {self.budget_s:g}: must be greater than 0; as in --budget 10min")

    def seeds(self, have: int, computed: float, confidence: float, spent_s: float) -> int:
        """How many seeds to have next; `have` where these are enough.

        computed: of `have`, how many were computed in spent_s seconds; 0 where all were there already. confidence:
        least of all choices; NaN of too few seeds.
        """
        if (self.until is None and self.budget_s is None) or (self.until is not None and confidence >= self.until):
            return have
        step = max(1, have // 2)
        if self.budget_s is not None:
            left = self.budget_s - spent_s
            step = min(step, int(left * computed / spent_s)) if computed and spent_s > 0.0 else int(left > 0.0)
        return min(have + max(step, 0), max(have, MOST_SEEDS))

    def told(self, have: int, confidence: float) -> str | None:
        """How it ended, in a line; None where nothing was asked for."""
        if self.until is None:
            return None if self.budget_s is None else f"{have} seeds within the time given"
        if confidence >= self.until:
            return f"{have} seeds, after which every choice is as sure as asked for ({self.until:.0%})"
        why = f"{have} seeds are the most" if have >= MOST_SEEDS else "the time given is over"
        sure = "a choice is less sure" + (f" ({confidence:.0%})" if confidence >= 0.0 else ", of too few seeds,")
        return f"flag: {sure} than asked for ({self.until:.0%}), and {why}"


def seconds(text: str) -> float:
    """Of a time as it is written: 90, 90s, 10min, 2h. Raises InputError for anything else."""
    found = re.fullmatch(r"\s*([0-9]*\.?[0-9]+)\s*(s|min|h)?\s*", text)
    if not found:
        raise InputError(f"--budget {text}: must be a time, as 90s, 10min or 2h")
    return float(found[1]) * _UNITS_S[found[2] or "s"]


ASKED_M = 10.0  # half width of a band that tells masts a few metres apart
_MOST = 10_000


def seeds_for(have: int, half_m: float) -> str:
    """How many seeds narrow a band of `have` seeds, which is `half_m` to either side, to ASKED_M."""
    scatter = half_m * np.sqrt(have) / stdtrit(have - 1, 0.975)
    many = np.arange(2, _MOST)
    enough = many[stdtrit(many - 1, 0.975) * scatter / np.sqrt(many) <= ASKED_M]
    number = f"about {enough[0]}" if enough.size else f"more than {_MOST}"
    return f"Bands of ± {ASKED_M:.0f} m ask for {number} seeds"
