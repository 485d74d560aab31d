"""What pages are put together from: pictures, tables, numbers written out; and the page itself, in one file."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..conventions import written
from . import reduce

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOTHING = "—"
Column = tuple[str, Callable[[Any], str]]  # head, and how a value is written


@dataclass(frozen=True)
class Picture:
    """A figure of the page."""

    name: str  # the PNG is name.png, an animation name.gif
    title: str
    alt: str
    caption: str
    draw: Callable[[], Figure | bytes]  # bytes are a GIF already

    def image(self, dark: bool = False) -> Image:
        """Drawn, for a light or a dark page; some tenths of a second."""
        from . import style  # loads matplotlib

        figure = self.draw()
        data, kind = (figure, "gif") if isinstance(figure, bytes) else (style.png(figure, dark), "png")
        return Image(self.name, self.title, self.alt, self.caption, data, kind)


class Image(NamedTuple):
    """A picture that is drawn; kind: png or gif."""

    name: str
    title: str
    alt: str
    caption: str
    data: bytes
    kind: str = "png"

    @property
    def source(self) -> str:
        """The image as an address."""
        return f"data:image/{self.kind};base64,{base64.b64encode(self.data).decode('ascii')}"

    @classmethod
    def of(cls, title: str, png: bytes, caption: str) -> Image:
        """The image of a figure that needs no further words."""
        return cls(title.lower().replace(" ", "_"), title, f"{title}: {caption}", caption, png)


def draw_images(pictures: Iterable[Picture], dark: bool = False) -> list[Image]:
    """Draw, for a light or a dark page; some tenths of a second each."""
    return [each.image(dark) for each in pictures]


class Cell(NamedTuple):
    """A cell of a table: its text, and the number by which it is sorted; None: by the text."""

    text: str
    by: float | None = None


def cell(value: Any) -> Cell:
    return Cell(f"{value:g}", float(value)) if isinstance(value, float) else Cell(str(value))


@dataclass(frozen=True)
class Table:
    """A table of the page, its cells already written out. words: no column is of numbers; nothing: if it has no row;
    files: where more stands, beside the page."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str | Cell]]
    note: str = ""
    words: bool = False
    nothing: str = "No cells."
    files: Sequence[str] = ()


def columns_table(
    title: str, columns: Mapping[str, Column], values: Callable[[str], Iterable[Any]], note: str = ""
) -> Table:
    """A table of columns by name: heads, how a value is written, and the values of each."""
    texts = [[write(value) for value in values(name)] for name, (_, write) in columns.items()]
    return Table(title, [head for head, _ in columns.values()], list(zip(*texts, strict=True)), note)


class Fold(NamedTuple):
    """What opens under a title: tables, words each with a key or none, and plain text."""

    title: str
    tables: Sequence[Table] = ()
    notes: Sequence[tuple[str, str]] = ()
    text: str = ""


def digits(value: Any, decimals: int, signed: bool = False) -> str:
    """A number as `written`, with a true minus sign; a dash for what is missing."""
    plain = reduce.number(value)
    return ("+" if signed and plain > 0.0 else "") + written(plain, decimals).replace("-", "−")


def decimals(number: int, signed: bool = False) -> Callable[[Any], str]:
    """How a column writes its values: `digits` with so many."""
    return partial(digits, decimals=number, signed=signed)


def metres(value: Any, decimals: int = 3, signed: bool = False) -> str:
    text = digits(value, decimals, signed)
    return text if text == NOTHING else f"{text} m"


def percent(share: Any) -> str:
    value = reduce.number(share)
    return f"{written(100.0 * value, 0)} %" if np.isfinite(value) else NOTHING


def count(value: Any) -> str:
    number = reduce.number(value)
    return f"{number:,.0f}".replace(",", " ") if np.isfinite(number) else NOTHING


def html_page(
    title: str,
    verdicts: Sequence[str],
    figures: Sequence[Image],
    folds: Sequence[Fold],
    *,
    run: str = "",
    warnings: Sequence[str] = (),
    notes: Sequence[str] = (),
    headline: Sequence[tuple[str, str]] = (),
    words: str = "",
    table: Table | None = None,
) -> str:
    """One HTML file that needs no other: what it comes to, figures, and what stands behind them.

    run: what ran; headline: label and value of the main figures; words: how it was made; table: sorted by a click.
    """
    import jinja2  # a sweep that is refused does without

    templates = jinja2.Environment(
        loader=jinja2.PackageLoader("seamap_rt.report", "."), autoescape=True, undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    return templates.get_template("page.html.j2").render(
        title=title, verdicts=verdicts, figures=figures, folds=folds, run=run, warnings=warnings, notes=notes,
        headline=headline, words=words, table=table, heading=table.title if table else "How it was made",
    )  # fmt: skip
