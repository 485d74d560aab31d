"""The page of a validation: one self-contained HTML file, for screen, paper and phone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from seamap_rt.io.results_folder import write_whole
from seamap_rt.report.page_elements import NOTHING, Cell, Fold, Image, Table, html_page

from .case import Check
from .environment import Environment
from .result import METRICS, CaseResult, ValidationResult

CLAIMS = "claims of 2004"
_WORDS = {True: "✓ green", False: "✗ red", None: "record"}
_HOW = (
    "Each case states what must come out before it is run, and why its tolerance is what it is. Green: all that was "
    "asked came out. Red: something did not. For the record: figures of which nothing was asked."
)


def write_page(path: Path, result: ValidationResult, environment: Environment, full: bool) -> None:
    """The whole validation as one HTML file, which appears whole or not at all."""
    versions = ", ".join(f"{name} {version}" for name, version in environment.versions.items())
    commit = f"; commit {environment.commit}" if environment.commit else ""
    done = result.done
    heads = ("Case", "Group", "The most important check", "Result", "Seconds")
    page = html_page(
        "Validation",
        [result.summary],
        [Image(each.case.name, each.case.title, each.case.title, each.caption, each.png) for each in done if each.png],
        [*_claims(done), *(_fold(each, full) for each in done)],
        run=f"{environment.when}, {'full' if full else 'short'} version; {environment.machine}; {versions}{commit}",
        warnings=list(_warnings(result)),
        notes=[_HOW],
        table=Table("All cases", heads, [_row(each) for each in done], words=True, files=[METRICS]),
    )
    write_whole(path, page)


def _warnings(result: ValidationResult) -> Iterator[str]:
    if len(result.done) < result.planned:
        yield f"Interrupted: {len(result.done)} of {result.planned} cases were run."
    for each in result.done:
        if each.passed is False:
            yield f"{_WORDS[False]}: {each.case.title}: {_worst(each.checks)}"


def _row(done: CaseResult) -> list[Cell]:
    result = f"{_WORDS[done.passed]}{f'; {done.verdict}' if done.verdict else ''}"
    words = (done.case.title, done.case.group, _worst(done.checks), result)
    return [*map(Cell, words), Cell(f"{done.seconds:.1f}", done.seconds)]


def _worst(checks: Sequence[Check]) -> str:
    """The most important check: the first that failed, else the first with a requirement, else the first."""
    for passed in (False, True, None):
        for check in checks:
            if check.passed is passed:
                return f"{check.what}: {check.found}" + (f" ({check.expected})" if passed is not None else "")
    return NOTHING


def _claims(done: Sequence[CaseResult]) -> Iterator[Fold]:
    claims = [each for each in done if each.case.group == CLAIMS]
    rows = [
        [*(each or NOTHING for each in (claim.case.title, claim.verdict, claim.assumption)), _figures(claim)]
        for claim in claims
    ]
    if rows:
        heads = ("Claim", "Verdict", "On what it rests", "Figures")
        yield Fold("The claims of 2004, judged", [Table("", heads, rows, words=True)])


def _figures(claim: CaseResult, shown: int = 4) -> str:
    more = len(claim.checks) - shown
    listed = [f"{each.what}: {each.found}" for each in claim.checks[:shown]]
    return "; ".join([*listed, f"and {more} more"] if more > 0 else listed)


def _fold(done: CaseResult, full: bool) -> Fold:
    """A case with all that it says of itself."""
    rows = [(each.what, each.found, each.expected, _WORDS[each.passed]) for each in done.checks]
    said = {"Why": done.case.rationale, "Set-up": done.case.setup, "Expected": done.case.expectation}
    if done.verdict:
        said["Verdict"] = " – ".join(filter(None, (done.verdict, done.assumption)))
    notes = [(f"{name}: {words}", "") for name, words in said.items()]
    notes.append(("By itself:", f"seamap-rt validate{' --full' if full else ''} --only {done.case.name}"))
    title = f"{done.case.title}: {_WORDS[done.passed]}, {done.seconds:.1f} s"
    return Fold(title, [Table("", ("What", "Found", "Expected", "Result"), rows, words=True)], notes, done.trace)
