"""The page of a validation: one self-contained HTML file, for screen, paper and phone."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from seamap_rt.io.results_folder import write_whole
from seamap_rt.report.page_elements import templates

from .case import Check
from .environment import Environment
from .result import CaseResult, ValidationResult

CLAIMS = "claims of 2004"
_WORDS = {True: "green", False: "red", None: "record"}


@dataclass(frozen=True)
class Section:
    """The cases of one group."""

    title: str
    done: Sequence[CaseResult]


def write_page(path: Path, result: ValidationResult, environment: Environment, full: bool) -> None:
    """The whole validation as one HTML file, which appears whole or not at all."""
    sections = [Section(group, list(done)) for group, done in groupby(result.done, lambda done: done.case.group)]
    claims = [done for section in sections if section.title == CLAIMS for done in section.done]
    page = (
        templates(__name__.rpartition(".")[0])
        .get_template("validate.html.j2")
        .render(
            title="Validation",
            result=result,
            environment=environment,
            full=full,
            sections=sections,
            claims=claims,
            word=_WORDS,
            worst=worst,
            image=lambda data: base64.b64encode(data).decode("ascii"),
        )
    )
    write_whole(path, page)


def worst(checks: Sequence[Check]) -> Check | None:
    """The most important check: the first that failed, else the first with a requirement, else the first."""
    for passed in (False, True, None):
        for check in checks:
            if check.passed is passed:
                return check
    return None
