"""Results of cases and of a whole validation."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from .case import Case, Check

PAGE, METRICS = "validation.html", "metrics.json"


@dataclass(frozen=True)
class CaseResult:
    """A case that has run, its figure drawn."""

    case: Case
    checks: tuple[Check, ...]
    seconds: float
    verdict: str = ""
    assumption: str = ""
    caption: str = ""
    png: bytes | None = None
    trace: str = ""  # last lines of the traceback, if it raised

    @property
    def passed(self) -> bool | None:
        """False if any check failed, None if no check has a requirement."""
        judged = [check.passed for check in self.checks if check.passed is not None]
        return all(judged) if judged else None


@dataclass(frozen=True)
class ValidationResult:
    """A validation: the folder of its page, and the cases that have run."""

    folder: Path
    done: tuple[CaseResult, ...]
    planned: int
    seconds: float

    @property
    def page(self) -> Path:
        return self.folder / PAGE

    @property
    def failed(self) -> int:
        return sum(done.passed is False for done in self.done)

    @property
    def passed(self) -> int:
        return sum(done.passed is True for done in self.done)

    @property
    def recorded(self) -> int:
        return sum(done.passed is None for done in self.done)

    @property
    def summary(self) -> str:
        """One line: how many passed (green), failed (red) and are only recorded."""
        counts = f"{self.passed} green, {self.failed} red, {self.recorded} for the record"
        whole = "" if len(self.done) == self.planned else f" of {self.planned}; the others were not run"
        return f"{len(self.done)} cases{whole}: {counts}; {self.seconds:.0f} s"
