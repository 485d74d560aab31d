"""What can be refused: every error that a user of the package may meet, each said in one line."""

from __future__ import annotations

_LONGEST = 240  # characters of a word, such as a path or a value that is quoted
_ENDS = 100  # of which as many are kept at either end


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


def one_line(message: str) -> str:
    """The message on one line that a terminal can print: what users' files bring may be long, or hold control codes.

    Spaces of any kind become one, characters that cannot be printed their escape sequences, and of a word longer than
    240 characters the middle goes.
    """
    words = []
    for word in message.split():
        if not word.isprintable():
            word = "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in word)
        words.append(word if len(word) <= _LONGEST else f"{word[:_ENDS]}…{word[-_ENDS:]}")
    return " ".join(words)
