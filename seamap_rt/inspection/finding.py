"""What an inspection finds: a word on one thing, how sure it is that something is wrong, and what to do."""

from __future__ import annotations

from typing import Literal, NamedTuple

Verdict = Literal["good", "doubtful", "wrong", "unknown"]


class Finding(NamedTuple):
    """Of one thing. "wrong" is sure, "doubtful" probable; "unknown" cannot be told from this data."""

    what: str
    verdict: Verdict
    says: str  # with the figure that it rests on
    remedy: str = ""

    @property
    def line(self) -> str:
        return f"{self.what}: {self.says}{f'; {self.remedy}' if self.remedy else ''}"


def judged(what: str, doubtful: bool, says: str, remedy: str) -> Finding:
    """A finding that is good, or doubtful and has a remedy."""
    return Finding(what, "doubtful", says, remedy) if doubtful else Finding(what, "good", says)
