"""Names and docstrings keep to the glossary of `seamap_rt/README.md`: words that mean two things stay out."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

import seamap_rt

ROOT = Path(seamap_rt.__file__).parent
BANNED = re.compile(r"(?<![a-z])(told|unheard|settles?d?|astray)(?![a-z])", re.IGNORECASE)  # parts of a name, too
KEYS = {"told"}  # of the state of a nonlinear sea on file, which --resume reads: `products/recorded_sea.py`


def ambiguous(source: str) -> Iterator[str]:
    """Names and comments with a banned word, and docstrings that hold one or begin a sentence with "What of"."""
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type in (tokenize.NAME, tokenize.COMMENT) and BANNED.search(token.string):
            yield f"{token.start[0]}: {token.string}"
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            words = ast.get_docstring(node) or ""
            found = BANNED.search(words) or re.search(r"(?:^|[.:] )What of\b", words)
            if found:
                yield f"docstring of {getattr(node, 'name', 'the module')}: {found[0]}"


@pytest.mark.parametrize(
    "package", sorted(path.name for path in ROOT.iterdir() if path.suffix == ".py" or any(path.rglob("*.py")))
)
def test_a_package_keeps_to_the_glossary(package: str) -> None:
    files = ROOT / package
    found = [
        f"{path.relative_to(ROOT)}:{each}"
        for path in (sorted(files.rglob("*.py")) if files.is_dir() else [files])
        for each in ambiguous(path.read_text(encoding="utf-8"))
        if not (path == ROOT / "products/recorded_sea.py" and each.split(": ")[1] in KEYS)
    ]
    assert found == []


@pytest.mark.parametrize(
    "source",
    [
        "told = 1\n",
        "def f(is_told): ...\n",
        "class Told: ...\n",
        "x = 1  # what is told\n",
        '"""What of a sea is seen."""\n',
    ],
)
def test_a_banned_word_is_found(source: str) -> None:
    assert list(ambiguous(source))
