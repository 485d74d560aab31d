"""Text as people write it and files hold it: encodings, numbers, TOML, CSV, JSON; and values as a refusal shows them.

A limit that a refusal names must satisfy its check when it is typed in.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Callable, Iterable, Mapping
from decimal import Decimal, InvalidOperation
from html import escape
from typing import TYPE_CHECKING, Any

from ..errors import InputError, Refusal

if TYPE_CHECKING:  # loaded where it is used: the command line does without
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

_UNDERSCORED = re.compile(r"(?<![^\s,;\[])[-+]?(?=[^\s,;\]]*\d_\d)[\d.][-+\d._eE]*(?![^\s,;\]])")


def parse_number(text: str | float) -> float:
    """The number that a text holds. Raises ValueError for what only Python takes for one: 1_0, full-width digits."""
    if isinstance(text, str) and ("_" in text or not text.isascii()):
        raise ValueError(f"{text!r} is not a number")
    return float(text)


def bad_line(line: int, what: str) -> Refusal:
    """The refusal of a line of a table, to be raised."""
    return Refusal(f"line {line}: {what}")


def finite_number(line: int, name: str, cell: str) -> float:
    """The number in a cell of the column of that name. Raises Refusal for what is none, or not finite."""
    try:
        value = parse_number(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise bad_line(line, f"{name} = '{cell}': must be a finite number; correct it or take the line out")
    return value


def number_list(text: str, about: str, form: str, most: int = 10_000) -> list[Decimal]:
    """Finite numbers of A,B,… or START:STOP:STEP, STOP too where a step meets it, at most so many of these.

    The steps are taken in decimals, so that 0.1:0.4:0.1 holds 0.3 and 0.4. Raises InputError for anything else; about:
    the option and its value; form: what to write.
    """
    stepped = ":" in text
    try:
        numbers = [
            Decimal(part.strip()) for part in text.split(":" if stepped else ",") if parse_number(part) is not None
        ]
    except (InvalidOperation, ValueError):
        raise InputError(f"{about}: must be {'three ' if stepped else ''}numbers; {form}") from None
    if not all(math.isfinite(number) for number in numbers):
        raise InputError(f"{about}: must be finite; {form}")
    if not stepped:
        return numbers
    if len(numbers) != 3:
        raise InputError(f"{about}: must be three numbers; {form}")
    start, stop, step = numbers
    if step <= 0 or stop < start:
        raise InputError(f"{about}: STEP must be greater than 0 and STOP at least START; {form}")
    count = (stop - start) / step
    if count >= most:
        raise InputError(f"{about}: {float(count):.3g} values, and at most {most} are taken; widen STEP")
    return [start + number * step for number in range(int(count) + 1)]


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


def refuse_semicolons(line: int, header: str) -> None:
    """Raise Refusal for a table whose columns a semicolon parts, and so perhaps commas the decimals."""
    if ";" in header and "," not in header:
        raise bad_line(line, "has ';' between its columns; save it with commas between them and points in its numbers")


_FORMULA = re.compile(r"\s*[=+\-@\t＝＋－＠]")  # that spreadsheets begin one with, some of them in full width


def csv_text(rows: Iterable[Iterable[Any]], digits: int = 10) -> str:
    """Rows of cells, each on one line: floats with so many digits, empty for NaN, all else as `str` has it.

    A text that a spreadsheet would take for a formula gets an apostrophe before it; a number, also a negative one as
    text, stays as it is.
    """
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([_cell(cell, digits) for cell in row] for row in rows)
    return text.getvalue()


def _cell(value: Any, digits: int) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.{digits}g}"
    text = " ".join(str(value).splitlines())
    if not _FORMULA.match(text):
        return text
    try:
        float(text)
    except ValueError:
        return f"'{text}"
    return text


LONGEST_VALUE = 60  # characters of a refused value that are shown


def key_text(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else toml_string(name)


def toml_value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return int.__repr__(value)
    if isinstance(value, float):
        return float.__repr__(value)  # the shortest digits that read back to the same bits; inf is TOML's too
    if isinstance(value, str):
        return toml_string(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(toml_value(entry) for entry in value) + "]"
    raise TypeError(f"{type(value).__name__} has no form in a scene file")


def toml_string(text: str) -> str:
    """A TOML basic string; characters that would break the line or not print are escaped."""
    return '"' + "".join(_escape(letter) for letter in text) + '"'


def _escape(letter: str) -> str:
    if letter in '"\\':
        return f"\\{letter}"
    if letter.isprintable():
        return letter
    return f"\\u{ord(letter):04x}" if ord(letter) <= 0xFFFF else f"\\U{ord(letter):08x}"


def shown(value: Any) -> str:
    """A value as a refusal shows it: a list as one types it for --set, where a shell takes a space for its end."""
    try:
        text = _compact_list(value) if isinstance(value, list | tuple) else toml_value(value)
    except TypeError:
        text = str(value)
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 1] + "…"


def number_text(value: float) -> str:
    """A number as one types it: 9.4e9, 2e-8, 15."""
    mantissa, exponent, power = f"{value:.6g}".partition("e")
    return f"{mantissa}e{int(power)}" if exponent else mantissa


def _compact_list(values: list[Any] | tuple[Any, ...]) -> str:
    entries = (_compact_list(each) if isinstance(each, list | tuple) else toml_value(each) for each in values)
    return f"[{','.join(entries)}]"


def rounded_up(value: float) -> str:
    """Four digits of a finite number, rounded up: the least that may be typed in where `value` is the least allowed."""
    return _four_digits(value, math.ceil)


def rounded_down(value: float) -> str:
    """Four digits of a finite number, rounded down: the most that may be typed in where `value` is the most allowed."""
    return _four_digits(value, math.floor)


def _four_digits(value: float, towards: Callable[[float], int]) -> str:
    if value == 0.0:
        return "0"
    scale = 10.0 ** (3 - math.floor(math.log10(abs(value))))
    return f"{towards(value * scale) / scale:.6g}"


def numbers(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """The array of a caller's numbers; InputError for anything else."""
    import numpy as np

    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name}: is a {type(values).__name__}, must be numbers; give a list or an array") from None


def to_builtin(value: Any) -> Any:
    """Numpy's scalars and arrays, tuples and mappings as Python's own numbers, lists and dictionaries, at any depth;
    all else as it is."""
    if hasattr(value, "tolist"):
        return to_builtin(value.tolist())
    if isinstance(value, Mapping):
        return {key: to_builtin(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [to_builtin(entry) for entry in value]
    return value


def plain_attribute(value: Any) -> Any:
    """A value of an attribute as it was meant: HDF5 and JSON may make an array or list of one entry of it, or bytes."""
    import numpy as np

    while isinstance(value, np.ndarray | list | tuple) and np.size(value) == 1 and np.ndim(value) > 0:
        value = value[0]
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist() if value.dtype.kind != "V" else value
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def to_json(value: Any) -> str:
    """Strict JSON of plain or numpy values; what is not finite becomes null."""
    return json.dumps(_finite(to_builtin(value)), indent=1, allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _finite(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


class TableMixin:
    """Shown as a short table of its `rows`: in lines, and in a notebook as HTML."""

    def rows(self) -> list[tuple[str, str]]:
        """Names, and values in words with their units."""
        raise NotImplementedError

    def __repr__(self) -> str:
        rows = self.rows()
        wide = max(10, *(len(name) for name, _ in rows))
        return "\n".join(f"{name:<{wide}} {words}" for name, words in rows)

    __str__ = __repr__

    def _repr_html_(self) -> str:
        cells = (f"<tr><th>{escape(name)}</th><td>{escape(words)}</td></tr>" for name, words in self.rows())
        return f"<table>{''.join(cells)}</table>"
