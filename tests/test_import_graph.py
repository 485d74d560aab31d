"""No module of the package needs, by whatever way round, one that needs it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import seamap_rt

ROOT = Path(seamap_rt.__file__).parent


def modules() -> dict[str, Path]:
    """Files by the modules' names; of packages those of `__init__`, which gather names and are no module's need."""
    files = (path for path in sorted(ROOT.rglob("*.py")) if path.name != "__init__.py")
    return {".".join(("seamap_rt", *path.relative_to(ROOT).with_suffix("").parts)): path for path in files}


def imported(name: str, tree: ast.AST) -> Iterator[str]:
    """Dotted names that a module imports, in functions too, but for types alone."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        if isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom):
            home = ".".join(name.split(".")[: -node.level]) if node.level else ""
            base = ".".join(filter(None, (home, node.module)))
            yield from (f"{base}.{each.name}" for each in node.names)
            yield base
        yield from imported(name, node)


def test_modules_need_each_other_in_no_circle() -> None:
    files = modules()
    graph = {name: {*imported(name, ast.parse(path.read_text("utf-8")))} & files.keys() for name, path in files.items()}
    assert sum(map(len, graph.values())) > len(graph)  # which found what they import
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" needs ".join(reversed(error.args[1])))
