"""Text that people write: its encoding, its numbers, and what parts its columns."""

from __future__ import annotations

import re

from ..errors import InputError

_UNDERSCORED = re.compile(r"(?<![^\s,;\[])[-+]?(?=[^\s,;\]]*\d_\d)[\d.][-+\d._eE]*(?![^\s,;\]])")


def parse_number(text: str | float) -> float:
    """The number that a text holds. Raises ValueError for what only Python takes for one: 1_0, full-width digits."""
    if isinstance(text, str) and ("_" in text or not text.isascii()):
        raise ValueError(f"{text!r} is not a number")
    return float(text)


def refuse_underscores(text: str, called: str) -> None:
    """Raise InputError for a table with a number that only Python takes for one: before a library reads it."""
    for number, line in enumerate(text.splitlines(), start=1):
        if "_" in line and line.lstrip()[:1] not in ("#", "$") and (found := _UNDERSCORED.search(line)):
            raise InputError(f"{called}, line {number}: {found[0]} is not a number; take the _ out")


def is_underscored(text: str) -> bool:
    """Whether a text holds a number such as 1_0."""
    return bool(_UNDERSCORED.search(text))


def is_wide(content: bytes) -> bool:
    """Whether text is in UTF-16, with a mark or by its every other byte."""
    halves = [content[start:200:2] for start in (0, 1)]
    return content[:2] in (b"\xff\xfe", b"\xfe\xff") or any(len(each) > 4 and not each.strip(b"\0") for each in halves)


def decode_text(content: bytes, called: str) -> str:
    """Text of a file in UTF-8, with a byte-order mark or without. Raises InputError for another encoding."""
    if is_wide(content):
        raise InputError(f"{called}: is text in UTF-16; save it as UTF-8")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError(
            f"{called}, line {line}: holds a letter that is not UTF-8 (Windows-1252, perhaps); save it as UTF-8"
        ) from None


def refuse_semicolons(header: str, called: str) -> None:
    """Raise InputError for a table whose columns a semicolon parts, and so perhaps commas the decimals."""
    if ";" in header and "," not in header:
        raise InputError(
            f"{called}: has ';' between its columns; save it with commas between them and points in its numbers"
        )
