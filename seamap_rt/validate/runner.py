"""Run the cases one after another, time each, and leave a page and its figures behind."""

from __future__ import annotations

import dataclasses
import json
import time
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ..io.interrupts import uninterrupted
from ..report import style
from ..session import clear_folder, prepare_folder, write_whole
from .case import Case, Check
from .found import cases_folder, chosen, load_cases
from .page import write_page
from .result import METRICS, PAGE, Done, Result
from .surroundings import Surroundings

_PRODUCTS = (PAGE, METRICS)
_TRACE_LINES = 12
Progress = Callable[[str], None]


def validate(
    out: str | Path = Path("runs/validation"),
    full: bool = False,
    only: Sequence[str] | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
    cases: Path | None = None,
) -> Result:
    """Run the validation cases and write validation.html and metrics.json into `out`.

    full: the long version of each case, and the cases that have no short one. only: names of cases. cases: another
    folder of case modules than the package's own. An exception in a case is a red case, and the others go on.
    Interrupted, the page of what is done is written before KeyboardInterrupt goes on its way. Raises InputError for a
    folder that cannot be written or holds another run's results, and for unknown names.
    """
    folder, say, start = Path(out), progress or (lambda _: None), time.perf_counter()
    home = cases or cases_folder()
    asked = chosen(load_cases(home), full, only)
    prepare_folder(folder, overwrite, _PRODUCTS)
    clear_folder(folder, _PRODUCTS)
    around, done = Surroundings.here(), list[Done]()
    result = Result(folder, (), len(asked), 0.0)
    try:
        for number, case in enumerate(asked):
            say(f"case {number + 1} of {len(asked)}: {case.title}")
            ended = _run(case, full)
            with uninterrupted():  # so that what is said to be on the page is
                done.append(ended)
                result = Result(folder, tuple(done), len(asked), time.perf_counter() - start)
                _write(result, around, full)  # after each: whatever ends the process later leaves what is done
    except KeyboardInterrupt:
        shown = f"; {folder / PAGE} shows them" if done else ""
        raise KeyboardInterrupt(f"{len(done)} of {len(asked)} cases are done{shown}") from None
    return result


def _run(case: Case, full: bool) -> Done:
    """The case's outcome; red with its reason in one line if it raises."""
    start = time.perf_counter()
    try:
        found = case.run(full)
        drawn = None if found.figure is None else style.png(found.figure)
        seconds, words = time.perf_counter() - start, (found.verdict, found.assumption, found.caption)
        return Done(case, tuple(found.checks), seconds, *words, drawn)
    except (Exception, SystemExit) as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        trace = "\n".join("".join(traceback.format_exception(error)).splitlines()[-_TRACE_LINES:])
        stopped = Check("the case runs to its end", reason, "no exception", False)
        return Done(case, (stopped,), time.perf_counter() - start, trace=trace)


def _write(result: Result, around: Surroundings, full: bool) -> None:
    """The page and the figures, each whole or not at all."""
    write_page(result.page, result, around, full)
    write_whole(result.folder / METRICS, json.dumps(_metrics(result, around, full), indent=1, ensure_ascii=False))


def _metrics(result: Result, around: Surroundings, full: bool) -> dict[str, Any]:
    return {
        **dataclasses.asdict(around),
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
