"""A case of the validation report: question, reason, expectation, and outcome."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from matplotlib.figure import Figure

Group = Literal[
    "closed forms",
    "outside tables",
    "claims of 2004",
    "accuracy",
    "light and shadow",
    "numerical stability",
    "speed",
    "cases that cannot be loaded",
]


@dataclass(frozen=True)
class Check:
    """One line of a case's result, in words: "height of a flat sea at 100 m", "0.4 mm", "0 ± 1 mm".

    `passed` is None where nothing is required: the figure is only recorded.
    """

    what: str
    found: str
    expected: str
    passed: bool | None

    def __post_init__(self) -> None:
        if self.passed is not None:  # JSON does not take numpy's bool
            object.__setattr__(self, "passed", bool(self.passed))


@dataclass(frozen=True)
class Outcome:
    """The outcome of a case; the verdict of a claim is one of: reproduced, only if …, not reproduced, open."""

    checks: tuple[Check, ...]
    figure: Figure | None = None  # drawn with report.style
    caption: str = ""
    verdict: str = ""  # claims only
    assumption: str = ""  # claims only: what the verdict rests on


@dataclass(frozen=True)
class Case:
    """One question that the report answers."""

    name: str  # snake_case, unique, written out: `--only` reads it without running the module
    group: Group
    title: str
    rationale: str  # why it matters
    setup: str
    expectation: str  # what must come out, and where the tolerance comes from
    run: Callable[[bool], Outcome]  # called with full: bool
    full_only: bool = False
