"""Turns are counted from 1 wherever people read, by one function; datasets count them from 0."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import seamap_rt
from seamap_rt.conventions import turn_name

_ROOT = Path(seamap_rt.__file__).parent
_FILES = sorted(path.relative_to(_ROOT).as_posix() for kind in ("*.py", "*.j2") for path in _ROOT.rglob(kind))
_BEFORE = re.compile(r"(?:\bturn[ _#]|_turn)$", re.IGNORECASE)  # what a number follows
_TEMPLATE = re.compile(r"\bturn[ _#]?\{\{", re.IGNORECASE)
_FORMAT = re.compile(r"\bturn[ _#]?(?:%[0-9]*[dsi]|\{[^}]*\})", re.IGNORECASE)


def _numbered(source: str) -> Iterator[int]:
    """Lines where a value follows the word turn."""
    tree = ast.parse(source)
    parts = {id(part) for each in ast.walk(tree) if isinstance(each, ast.JoinedStr) for part in each.values}
    for each in ast.walk(tree):
        if isinstance(each, ast.JoinedStr):
            for words, value in zip(each.values, each.values[1:], strict=False):
                text = str(words.value) if isinstance(words, ast.Constant) else ""
                if isinstance(value, ast.FormattedValue) and _BEFORE.search(text):
                    yield each.lineno
        elif isinstance(each, ast.BinOp) and isinstance(each.op, ast.Add) and isinstance(each.left, ast.Constant):
            if isinstance(each.left.value, str) and _BEFORE.search(each.left.value):
                yield each.lineno
        elif isinstance(each, ast.Constant) and id(each) not in parts and _FORMAT.search(str(each.value)):
            yield each.lineno


@pytest.mark.parametrize("file", _FILES)
def test_no_text_numbers_a_turn_but_by_turn_name(file: str) -> None:
    source = (_ROOT / file).read_text(encoding="utf-8")
    if file.endswith(".j2"):
        assert not _TEMPLATE.search(source)
    elif file != "conventions.py":
        assert list(_numbered(source)) == []


@pytest.mark.parametrize(
    "source", ["f'turn {index}'", "f'{a}: Turn {index + 1} of {n}'", "f'{a}_turn{i}.png'", "'turn ' + str(i)",
               "'turn {}'.format(i)", "'turn %d' % i"],
)  # fmt: skip
def test_the_law_finds_what_it_looks_for(source: str) -> None:
    assert list(_numbered(source)) == [1]


@pytest.mark.parametrize(
    "source", ["f'return {index}'", "f'{n} turns'", "f'{turn_name(3)} is shown'", "r'turn (\\d+)'"]
)
def test_the_law_finds_nothing_else(source: str) -> None:
    assert list(_numbered(source)) == []


def test_a_turn_is_named_from_its_coordinate() -> None:
    assert (turn_name(0), turn_name(2, 3)) == ("turn 1", "turn 3 of 3")
