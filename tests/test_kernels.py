"""Laws of the compiled loops, over all of them."""

from __future__ import annotations

import ast
from pathlib import Path

import seamap_rt

ROOT = Path(seamap_rt.__file__).parent
MOST_ARGUMENTS = 10
WITH_LANES = {"sea/spline_kernel.py"}  # `compute.lanes` says what it would lose


def compiled_functions() -> dict[str, int]:
    """Each compiled function of the package and the number of its arguments."""
    found = {}
    for path in sorted(ROOT.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef):
                names = [ast.unparse(each).split("(")[0] for each in node.decorator_list]
                if any(name.startswith("compiled") or name in ("njit", "vectorize") for name in names):
                    found[f"{path.relative_to(ROOT)}:{node.name}"] = len(node.args.args)
    return found


def test_arguments_of_compiled_loops_can_be_told_apart() -> None:
    functions = compiled_functions()
    assert len(functions) > 60  # else they are looked for by other names than they have
    assert {name: count for name, count in functions.items() if count > MOST_ARGUMENTS} == {}


def test_lanes_are_written_by_hand_only_where_plain_loops_were_measured_to_lose() -> None:
    users = {
        str(path.relative_to(ROOT))
        for path in ROOT.rglob("*.py")
        if any(
            isinstance(node, ast.ImportFrom) and (node.module or "").endswith("compute.lanes")
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        )
    }
    assert users == WITH_LANES
