"""What can be refused: every error that a user of the package may meet, each said in one line."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

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
    """Bad input. `problems` says each thing that is wrong in exactly one line, and the message has no other lines.

    One message is one problem, whatever it holds; several are raised together, once each.
    """

    def __init__(self, message: str, *more: str) -> None:
        self.problems = tuple(dict.fromkeys(one_line(each) for each in (message, *more)))
        super().__init__("\n".join(self.problems))

    def __reduce__(self) -> tuple[type[InputError], tuple[str, ...]]:
        """Across processes it stays as many problems as it was."""
        return type(self), self.problems


class Refusal(InputError):
    """Bad input, said without the file that it is in: `say_of` puts that before it."""


@contextmanager
def say_of(subject: str, kind: type[InputError] = Refusal) -> Iterator[None]:
    """Put a subject, such as "file 'a.csv', ", before the problems of errors of this kind that are raised within."""
    try:
        yield
    except kind as refusal:
        raised = MachineLimitError if isinstance(refusal, MachineLimitError) else InputError
        raise raised(*(f"{subject}{problem}" for problem in refusal.problems)) from None


def must_be(name: str, value: object, kinds: type | tuple[type, ...], wanted: str) -> None:
    """Raise InputError unless a value is of one of these types. wanted: in words, and where to get one."""
    if not isinstance(value, kinds):
        given = "None" if value is None else f"a {type(value).__name__}"
        raise InputError(f"{name}: is {given}, must be {wanted}")


def refuse(problems: Iterable[str]) -> None:
    """Raise InputError with all of the problems, if there are any."""
    if messages := tuple(problems):
        raise InputError(*messages)


class SchemaError(ValueError):
    """A dataset that does not keep the schema; the message is one line."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class NoBackendError(RuntimeError):
    """Nothing here can run Dr.Jit. The message is one line and names the command that mends it."""


class ResourceError(RuntimeError):
    """The machine (memory, threads, disk) does not suffice. The message is one line: what is needed, and what to do."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class MachineLimitError(InputError, ResourceError):
    """An input that the memory or the disk of this machine does not hold; on a larger one it may be right."""


_SHORTAGES = ("can't start new thread", "failed to map segment", "Cannot allocate memory", "Allocation failed")


def shortage(error: BaseException) -> BaseException | None:
    """The lack of memory, threads or disk that an exception is, or that a library or a reader has made it of."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, MemoryError | ResourceError) or any(words in str(cause) for words in _SHORTAGES):
            return cause
        cause = cause.__cause__ or cause.__context__
    return None


def is_interruption(error: BaseException) -> bool:
    """Whether an exception is Ctrl-C, or what compiled code has made of it: Python calls that a SystemError."""
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, KeyboardInterrupt):
        cause = cause.__cause__ or cause.__context__
    return cause is not None


@contextmanager
def report_partial_results(words: Callable[[], str]) -> Iterator[None]:
    """An interruption's message says what is left. words: called then."""
    try:
        yield
    except BaseException as error:
        if not is_interruption(error):
            raise
        raise KeyboardInterrupt(words()) from None
