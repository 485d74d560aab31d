"""Run the cases one after another, time each, and write a page and its figures."""

from __future__ import annotations

import dataclasses
import json
import time
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from seamap_rt.errors import is_interruption
from seamap_rt.io.process import Progress, hold_interruptions, ignore_progress
from seamap_rt.io.results_folder import clear_folder, results_folder, write_whole
from seamap_rt.report import style

from .case import Case, Check
from .discovery import cases_folder, load_cases, select_cases
from .environment import Environment
from .page import write_page
from .result import METRICS, PAGE, CaseResult, ValidationResult

PRODUCTS = (PAGE, METRICS)
_TRACE_LINES = 12


def validate(
    out: str | Path = Path("runs/validation"),
    full: bool = False,
    only: Sequence[str] | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
    cases: Path | None = None,
) -> ValidationResult:
    """Run the validation cases and write validation.html and metrics.json into `out`.

    full: the long version of each case, and the cases that have no short one. only: names of cases. cases: another
    folder of case modules than the package's own. A case that raises fails, and the others run.
    Interrupted, the page of the finished cases is written before KeyboardInterrupt is raised. Raises InputError for a
    folder that cannot be written or holds another run's results, and for unknown names.
    """
    folder, say, start = Path(out), progress or ignore_progress, time.perf_counter()
    home = cases or cases_folder()
    selected = select_cases(load_cases(home, only), full, only)
    with results_folder(folder, overwrite, PRODUCTS):
        clear_folder(folder, PRODUCTS)
        environment, done = Environment.here(), list[CaseResult]()
        result = ValidationResult(folder, (), len(selected), 0.0)
        try:
            for number, case in enumerate(selected):
                say(f"case {number + 1} of {len(selected)}: {case.title}")
                ended = _run(case, full)
                with hold_interruptions():  # so that the page and the list of finished cases agree
                    done.append(ended)
                    result = ValidationResult(folder, tuple(done), len(selected), time.perf_counter() - start)
                    _write(result, environment, full)  # after each case, so that nothing is lost if the process ends
        except KeyboardInterrupt:
            shown = f"; {folder / PAGE} shows them" if done else ""
            raise KeyboardInterrupt(f"{len(done)} of {len(selected)} cases are done{shown}") from None
    return result


def _run(case: Case, full: bool) -> CaseResult:
    """The result of a case; if it raises, failed, with the reason in one line."""
    start = time.perf_counter()
    try:
        outcome = case.run(full)
        drawn = None if outcome.figure is None else style.png(outcome.figure)
        seconds, words = time.perf_counter() - start, (outcome.verdict, outcome.assumption, outcome.caption)
        return CaseResult(case, tuple(outcome.checks), seconds, *words, drawn)
    except (Exception, SystemExit) as error:
        if is_interruption(error):
            raise KeyboardInterrupt from None
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        trace = "\n".join("".join(traceback.format_exception(error)).splitlines()[-_TRACE_LINES:])
        stopped = Check("the case runs to its end", reason, "no exception", False)
        return CaseResult(case, (stopped,), time.perf_counter() - start, trace=trace)


def _write(result: ValidationResult, environment: Environment, full: bool) -> None:
    """The page and the figures, each whole or not at all."""
    write_page(result.page, result, environment, full)
    write_whole(result.folder / METRICS, json.dumps(_metrics(result, environment, full), indent=1, ensure_ascii=False))


def _metrics(result: ValidationResult, environment: Environment, full: bool) -> dict[str, Any]:
    return {
        **dataclasses.asdict(environment),
        "full": full,
        "planned": result.planned,
        "green": result.passed,
        "red": result.failed,
        "recorded": result.recorded,
        "seconds": result.seconds,
        "cases": {
            done.case.name: {
                "group": done.case.group,
                "title": done.case.title,
                "passed": done.passed,
                "verdict": done.verdict,
                "assumption": done.assumption,
                "seconds": done.seconds,
                "checks": [dataclasses.asdict(check) for check in done.checks],
            }
            for done in result.done
        },
    }
