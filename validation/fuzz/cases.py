"""One case: its damage, its reader, and the laws; in a process of its own, which a hang or a crash may end."""

from __future__ import annotations

import os
import random
import resource
import signal
import sys
import tempfile
import tomllib
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from seamap_rt.cli import main as command_line
from seamap_rt.compute.machine import forget_peak_memory, peak_memory
from seamap_rt.errors import InputError
from seamap_rt.scene import load_scene

from .damage import damaged_bytes, damaged_tree, toml_of
from .damaged_files import damaged
from .readers import READERS, REFUSALS, NotOurs, consequences, whole_run

MOST_RESIDENT = 1e9  # bytes
_USUAL_RESIDENT = 4e8  # bytes of a process that has imported everything
MOST_SECONDS = 20
_MOST_ALLOCATED = 4 << 30  # bytes: what asks for more gets a MemoryError, and leaves the machine alone
_LONGEST_LINE = 1000
_AT_THE_COMMAND_LINE = 25  # every so manyth file, where a command reads it
_WHOLE = 400  # every so manyth scene that is accepted


@dataclass(frozen=True)
class Case:
    """A case is known by these: the same ones give the same damage."""

    seed: int
    kind: str
    number: int

    @property
    def dice(self) -> random.Random:
        return random.Random(f"{self.seed}/{self.kind}/{self.number}")


@dataclass(frozen=True)
class Result:
    """What came of a case; `wrong` is empty where it kept the laws."""

    case: Case
    what: str  # accepted, refused, not ours, or failed
    wrong: str = ""


def limit_memory() -> None:
    """Of this process, from here on; and its random damage names what is no array without a word."""
    resource.setrlimit(resource.RLIMIT_DATA, (_MOST_ALLOCATED, _MOST_ALLOCATED))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.simplefilter("always")
    for kind in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
        warnings.simplefilter("ignore", kind)  # as Python itself does


def judge(case: Case, originals: list[Path], folder: Path) -> Result:
    """Do a case and hold it against the laws. What it read stays in the folder."""
    dice = case.dice
    original = dice.choice(originals)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = _damaged_scene(original, folder, dice) if case.kind == "scene" else damaged(original, folder, dice)
    forget_peak_memory()  # what the damage took; what earlier cases left is not this one's either
    held = max(0.0, peak_memory() - _USUAL_RESIDENT)
    with _captured() as said, _deadline():
        what, wrong = _answer(case, path, dice)
    if not wrong and said.text:
        wrong = f"printed: {said.text[:300]!r}"
    if not wrong and peak_memory() - held > MOST_RESIDENT:
        wrong = f"held {(peak_memory() - held) / 1e9:.2f} GB"
    return Result(case, "failed" if wrong else what, wrong)


def _answer(case: Case, path: Path, dice: random.Random) -> tuple[str, str]:
    """What happened, and what law it broke."""
    try:
        if case.kind != "scene" and case.number % _AT_THE_COMMAND_LINE == 0 and _command(case.kind, path):
            return _at_the_command_line(_command(case.kind, path))
        if case.kind == "scene" and case.number % 4 == 0:
            consequences(load_scene(path, overrides=_overrides(path, dice)))
        else:
            READERS[case.kind](path)
        if case.kind == "scene" and case.number % _WHOLE == 1:
            whole_run(load_scene(path))
    except NotOurs:
        return "not ours", ""
    except InputError as refusal:
        return "refused", _wrong_lines(refusal)
    except REFUSALS as refusal:
        return "refused", _wrong_line(str(refusal))
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        return "failed", f"{type(error).__name__}: {error}"[:300] + _place(error)
    return "accepted", ""


def _wrong_lines(refusal: InputError) -> str:
    """A line a problem, each as it should be, and no other line."""
    if str(refusal) != "\n".join(refusal.problems):
        return f"other lines than its problems: {str(refusal)[:300]!r}"
    return next(filter(None, map(_wrong_line, refusal.problems)), "")


def _wrong_line(line: str) -> str:
    if not line.isprintable() or len(line) > _LONGEST_LINE or not line:
        return f"not one printable line: {line[:300]!r}"
    return f"memory, not a limit: {line[:300]}" if "nable to allocate" in line or "MemoryError" in line else ""


def _place(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    return "".join(f" < {Path(each.filename).name}:{each.lineno}" for each in frames[:-5:-1])


def _command(kind: str, path: Path) -> list[str]:
    """The command that reads a kind of file."""
    out = ["--out", str(path.parent / "maps"), "--overwrite", "--set", "retrieval.estimator=single_cell"]
    return {"echo store": ["retrieve", str(path), *out], "recording": ["retrieve", str(path), *out]}.get(kind, [])


def _at_the_command_line(arguments: list[str]) -> tuple[str, str]:
    code = None
    with _captured() as said:
        try:
            command_line(arguments)
        except SystemExit as end:
            code = end.code
    lines = said.text.splitlines()
    if code == 0:
        return "accepted", "" if said.errors == "" else f"printed: {said.errors[:300]!r}"
    if code != 2 or not lines or not all(line.startswith("seamap-rt: ") for line in lines):
        return "failed", f"exit {code}: {said.text[-300:]!r}"
    return "refused", next(filter(None, (_wrong_line(line.removeprefix("seamap-rt: ")) for line in lines)), "")


def _damaged_scene(original: Path, folder: Path, dice: random.Random) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path, content = folder / original.name, original.read_bytes()
    if dice.random() < 0.4:
        path.write_bytes(damaged_bytes(content, dice))
    else:
        path.write_text(toml_of(damaged_tree(tomllib.loads(content.decode()), dice)), encoding="utf-8")
    return path


def _overrides(path: Path, dice: random.Random) -> dict[str, object]:
    """A key of the resolved default scene, with a value from nowhere."""
    from .damage import EXTREMES

    tree = tomllib.loads(load_scene("flat").to_toml())
    keys = [key for key in _dotted(tree) if key != "name"]
    return {key: dice.choice(EXTREMES) for key in dice.sample(keys, dice.choice((1, 1, 2)))}


def _dotted(tree: dict[str, object], prefix: str = "") -> Iterator[str]:
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from _dotted(value, f"{prefix}{key}.")
        else:
            yield prefix + key


class _Said:
    text, errors = "", ""


def _flush() -> None:
    sys.stdout.flush()
    sys.stderr.flush()


@contextmanager
def _captured() -> Iterator[_Said]:
    """What is written to both streams, by C libraries too."""
    said = _Said()
    kept = [os.dup(number) for number in (1, 2)]
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as errors:
        _flush()
        os.dup2(out.fileno(), 1)
        os.dup2(errors.fileno(), 2)
        try:
            yield said
        finally:
            _flush()
            for number, handle in zip((1, 2), kept, strict=True):
                os.dup2(handle, number)
                os.close(handle)
            out.seek(0)
            errors.seek(0)
            said.errors = errors.read().decode("utf-8", "replace")
            said.text = out.read().decode("utf-8", "replace") + said.errors


@contextmanager
def _deadline() -> Iterator[None]:
    def late(*_: object) -> None:
        raise TimeoutError(f"took more than {MOST_SECONDS} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(MOST_SECONDS)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
