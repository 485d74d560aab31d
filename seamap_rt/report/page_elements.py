"""What pages are put together from: pictures, tables, numbers written out; and a page that answers, in one file."""

from __future__ import annotations

import base64
import importlib.resources
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import jinja2
import numpy as np

from ..conventions import written
from . import reduce

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOTHING = "—"


@dataclass(frozen=True)
class Picture:
    """A figure of the page."""

    name: str  # the PNG is name.png, an animation name.gif
    title: str
    alt: str
    caption: str
    draw: Callable[[], Figure | bytes]  # bytes are a GIF already


@dataclass(frozen=True)
class Table:
    """A table of the page, its cells already written out."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


def digits(value: Any, decimals: int, signed: bool = False) -> str:
    """A number as `written`, with a true minus sign; a dash for what is missing."""
    plain = reduce.number(value)
    return ("+" if signed and plain > 0.0 else "") + written(plain, decimals).replace("-", "−")


def metres(value: Any, decimals: int = 3, signed: bool = False) -> str:
    text = digits(value, decimals, signed)
    return text if text == NOTHING else f"{text} m"


def percent(share: Any) -> str:
    value = reduce.number(share)
    return f"{written(100.0 * value, 0)} %" if np.isfinite(value) else NOTHING


def count(value: Any) -> str:
    number = reduce.number(value)
    return f"{number:,.0f}".replace(",", " ") if np.isfinite(number) else NOTHING


class Cell(NamedTuple):
    """Of the table: text, and the number by which it is sorted; None: by the text."""

    text: str
    by: float | None = None


def cell(value: Any) -> Cell:
    return Cell(f"{value:g}", float(value)) if isinstance(value, float) else Cell(str(value))


def answer_page(
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
    folded: str = "Words, keys and the scene",
) -> str:
    """One HTML file that needs no other. figures: title, PNG and caption; files: beside the page, with all figures;
    small_print: words, and the key that they stand for or nothing; scene: as TOML, or
    another description; folded: what it is called together with the small print."""
    source = importlib.resources.files("seamap_rt.report").joinpath("answer.html.j2").read_text(encoding="utf-8")
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
        folded=folded,
    )
