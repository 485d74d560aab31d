"""The page of a study: an answer, notes, figures, a table to sort, and in small print what the words mean. One file."""

from __future__ import annotations

import base64
import importlib.resources
from collections.abc import Sequence
from typing import Any, NamedTuple

import jinja2
import numpy as np
from scipy.special import stdtrit

ASKED_M = 10.0  # half width of a band that tells masts a few metres apart
_MOST = 10_000


class Cell(NamedTuple):
    """Of the table: text, and the number by which it is sorted; None: by the text."""

    text: str
    by: float | None = None


def cell(value: Any) -> Cell:
    return Cell(f"{value:g}", float(value)) if isinstance(value, float) else Cell(str(value))


def seeds_for(have: int, half_m: float) -> str:
    """How many seeds narrow a band of `have` seeds, which is `half_m` to either side, to ASKED_M."""
    scatter = half_m * np.sqrt(have) / stdtrit(have - 1, 0.975)
    many = np.arange(2, _MOST)
    enough = many[stdtrit(many - 1, 0.975) * scatter / np.sqrt(many) <= ASKED_M]
    number = f"about {enough[0]}" if enough.size else f"more than {_MOST}"
    return f"Bands of ± {ASKED_M:.0f} m ask for {number} seeds"


def study_page(
    *,
    title: str,
    said: Sequence[str],
    notes: Sequence[str],
    figures: Sequence[tuple[str, bytes, str]],
    table_title: str,
    table_note: str,
    files: Sequence[str],
    heads: Sequence[str],
    rows: Sequence[Sequence[Cell]],
    small_print: Sequence[tuple[str, str]],
    scene: str,
) -> str:
    """One HTML file that needs no other. figures: title, PNG and caption; files: beside the page, with all figures;
    small_print: words, and the key that they stand for or nothing; scene: as TOML."""
    source = importlib.resources.files("seamap_rt.studies").joinpath("study.html.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.from_string(source).render(
        title=title,
        said=said,
        notes=notes,
        figures=[
            {"title": name, "data": base64.b64encode(data).decode("ascii"), "words": words}
            for name, data, words in figures
        ],
        table_title=table_title,
        table_note=table_note,
        files=files,
        heads=heads,
        rows=[[{"text": each.text, "by": "" if each.by is None else each.by} for each in row] for row in rows],
        small_print=small_print,
        scene=scene,
    )
