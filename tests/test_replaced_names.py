"""Tests replace what the package shows, never what begins with an underscore."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).parent


def replaced(source: str) -> Iterator[tuple[int, str]]:
    """Lines of calls of `setattr`, `delattr` and `patch`, and the parts of the names that they replace."""
    for call in (node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call)):
        if getattr(call.func, "attr", getattr(call.func, "id", "")) in ("setattr", "delattr", "patch", "object"):
            names = [each.value for each in call.args[:2] if isinstance(each, ast.Constant)]
            yield from ((call.lineno, part) for name in names for part in str(name).split("."))


def test_no_test_replaces_what_is_private() -> None:
    """But zarr's write of a chunk, in whose middle a disk fails."""
    sources = {path: path.read_text(encoding="utf-8") for path in HERE.rglob("*.py")}
    every = [(path, *each) for path, source in sources.items() for each in replaced(source)]
    assert len(every) > 100
    private = [each for each in every if each[2].startswith("_") and not each[2].startswith("__")]
    zarrs = {("test_growing_store.py", name) for name in ("_local", "_put")}
    assert {(path.name, part) for path, _, part in private} == zarrs
