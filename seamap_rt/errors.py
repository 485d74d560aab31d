"""What can be refused: every error that a user of the package may meet, each said in one line."""

from __future__ import annotations

import re

_LONGEST_WORD = 200  # characters: a path that one reads
_LONGEST_LINE = 1000
_LONG_WORD = re.compile(rf"\S{{{_LONGEST_WORD + 1},}}")


def one_line(message: str) -> str:
    """A message as one line that a terminal can show: what does not print is escaped, as \\x1b, and a word or a line
    that is too long keeps its two ends. A line that is right stays as it is."""
    text = "".join(each if each.isprintable() else _escaped(each) for each in " ".join(message.split()))
    return _shortened(_LONG_WORD.sub(lambda word: _shortened(word[0], _LONGEST_WORD), text), _LONGEST_LINE)


def _escaped(letter: str) -> str:
    return letter.encode("unicode_escape", "backslashreplace").decode("ascii")


def _shortened(text: str, longest: int) -> str:
    """A path ends in the file's name, and a refusal in what to do: both ends are kept."""
    if len(text) <= longest:
        return text
    first = (longest - 1) // 2
    return f"{text[:first]}…{text[first + 1 - longest :]}"


class InputError(ValueError):
    """Bad input, said in exactly one line."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class SchemaError(ValueError):
    """A dataset that does not keep the schema; the message is one line."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class NoBackend(RuntimeError):
    """Nothing here can run Dr.Jit. The message is one line and names the command that mends it."""
