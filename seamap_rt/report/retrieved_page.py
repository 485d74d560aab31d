"""The page of a retrieval: what the maps show, and what is wrong or doubtful about the echoes they were made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import xarray as xr

from ..inspection import Finding
from . import style
from .page_elements import Cell, answer_page
from .retrieved_figures import by_range, map_of_turn

RETRIEVED = "retrieval.html"
_VERDICTS = {"wrong": "1 surely wrong", "doubtful": "2 doubtful", "good": "3 good", "unknown": "4 cannot be told"}
_MAPS = "The last turn. Grey: no echo, shadow, or not looked at."
_RANGES = (
    "The sea's mean level is 0 at every range: a staircase of metres is a wrong sign of the phase, a shift a wrong "
    "mast height, a straight trend a phase offset between the receivers."
)


def retrieved_page(
    maps: xr.DataTree, findings: Sequence[Finding], said: Sequence[str], radar: Mapping[Any, Any], source: str
) -> str:
    """One HTML file that needs no other. said: sentences on top; radar: the echoes' attributes; source: their file."""
    grave = [finding.line for finding in findings if finding.verdict in ("wrong", "doubtful")]
    return answer_page(
        title=f"Heights retrieved from {source}",
        said=[_sentence(line) for line in said],
        notes=[f"{_sentence(line)}." for line in grave] or ["Nothing about the echoes was found to be doubtful."],
        figures=[
            ("Map", style.png(map_of_turn(maps)), _MAPS),
            ("By range", style.png(by_range(maps)), _RANGES),
        ],
        table_title="What the echoes say of themselves",
        table_note="Nothing here knows the sea.",
        files=["maps.nc"],
        heads=["Verdict", "What", "Found", "What to do"],
        rows=[[Cell(text) for text in _row(finding)] for finding in findings],
        small_print=[],
        scene="\n".join(f"{name} = {value}" for name, value in sorted(radar.items())),
        folded="The radar as it is described",
    )


def _row(finding: Finding) -> tuple[str, str, str, str]:
    return _VERDICTS[finding.verdict], finding.what, finding.says, finding.remedy


def _sentence(line: str) -> str:
    return line[0].upper() + line[1:]
