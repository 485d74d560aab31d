"""How many small errors in the code do the tests find? One operator, comparison or number is changed at a time.

python -m validation.mutants [--count 120] [--seed 1] [--limit 60]

Mutants are drawn from a seed, a package after the other, so that a longer run goes on where a shorter one ended: each
outcome is written to `validation/results/mutants.json` as soon as it is known, and `mutants.md` is made of it. Each is
run in a copy of the tree against the tests that import its module, else those of its package's folder.

    killed     a test fails
    survived   all pass: the mutant is equivalent, or a law is missing
    slow       the tests took longer than the limit [s], and none had failed: not counted

A survivor that changes no result gets its reason in the file's "equivalent" by hand: name of the mutant → reason.
The score is killed / (killed + survived − equivalent).
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
RESULT = Path(__file__).parent / "results" / "mutants.json"
PACKAGES = ("sea", "scattering", "tracing", "echoes", "interferometry", "prediction")
OPERATORS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.And: ast.Or, ast.Or: ast.And,
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One changed expression. start, end: of its bytes in the file."""

    file: str
    line: int
    start: int
    end: int
    text: str

    @property
    def name(self) -> str:
        return f"{self.file}:{self.start}: {self.text}"

    @property
    def package(self) -> str:
        return self.file.split("/")[1]

    def apply(self, source: bytes) -> bytes:
        return source[: self.start] + self.text.encode() + source[self.end :]


def changed(node: ast.AST) -> ast.AST | None:
    """A node with another operator or number; None where it has neither."""
    copy = deepcopy(node)
    if isinstance(copy, (ast.BinOp, ast.BoolOp)) and type(copy.op) in OPERATORS:
        copy.op = OPERATORS[type(copy.op)]()  # type: ignore[assignment]
    elif isinstance(copy, ast.Compare) and type(copy.ops[0]) in OPERATORS:
        copy.ops[0] = OPERATORS[type(copy.ops[0])]()  # type: ignore[call-overload]
    elif isinstance(copy, ast.Constant) and isinstance(copy.value, int | float) and not isinstance(copy.value, bool):
        copy.value = copy.value + 1 if isinstance(copy.value, int) else 1.3 * copy.value + (copy.value == 0.0)
    else:
        return None
    return copy


def mutants_of(path: Path) -> Iterator[Mutant]:
    """All of a file, in the order of its syntax tree; none in annotations and f-strings."""
    source = path.read_bytes()
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    waiting: list[ast.AST] = [ast.parse(source)]
    while waiting:
        node = waiting.pop()
        for name, value in ast.iter_fields(node):
            if name not in ("annotation", "returns") and not isinstance(node, ast.JoinedStr):
                waiting += [
                    each for each in (value if isinstance(value, list) else [value]) if isinstance(each, ast.AST)
                ]
        if (other := changed(node)) is not None and isinstance(node, ast.expr) and node.end_lineno is not None:
            start, end = (
                starts[node.lineno - 1] + node.col_offset,
                starts[node.end_lineno - 1] + (node.end_col_offset or 0),
            )
            yield Mutant(path.relative_to(ROOT).as_posix(), node.lineno, start, end, f"({ast.unparse(other)})")


def drawn(count: int, seed: int) -> list[Mutant]:
    """The first of an order without end that the seed sets: a package after the other, files by their mutants."""
    every = {
        package: [each for path in sorted((ROOT / "seamap_rt" / package).rglob("*.py")) for each in mutants_of(path)]
        for package in PACKAGES
    }
    for number, package in enumerate(PACKAGES):
        random.Random(100 * seed + number).shuffle(every[package])
    return [every[PACKAGES[n % len(PACKAGES)]][n // len(PACKAGES)] for n in range(count)]


def tests_of(mutant: Mutant) -> list[str]:
    """Test files that import the mutant's module; else the folder of its package."""
    module = mutant.file.removesuffix("/__init__.py").removesuffix(".py").replace("/", ".")
    home, _, last = module.rpartition(".")
    wanted = re.compile(
        rf"(from {re.escape(module)} import|from {re.escape(home)} import .*\b{last}\b|{re.escape(module)}\b)"
    )
    found = [
        str(path.relative_to(ROOT))
        for path in sorted((ROOT / "tests").rglob("test_*.py"))
        if wanted.search(path.read_text("utf-8"))
    ]
    return found or [f"tests/{mutant.package}"]


def judge(mutant: Mutant, tree: Path, limit_s: float) -> str:
    path, source = tree / mutant.file, (ROOT / mutant.file).read_bytes()
    path.write_bytes(mutant.apply(source))
    environment = {**os.environ, "PYTHONPATH": str(tree), "NUMBA_CACHE_DIR": str(tree / ".numba")}
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider", *tests_of(mutant)]
    try:
        ran = subprocess.run(command, cwd=tree, env=environment, capture_output=True, timeout=limit_s, check=False)
    except subprocess.TimeoutExpired:
        return "slow"
    finally:
        path.write_bytes(source)
    return "survived" if ran.returncode == 0 else "killed"


def page(made: dict[str, Any]) -> str:
    rows = [
        "# mutants",
        "`python -m validation.mutants`",
        "| package | killed | survived | equivalent | slow | score |\n|---|---|---|---|---|---|",
    ]
    for package in (*PACKAGES, "all"):
        of = {name: how for name, how in made["outcomes"].items() if package in ("all", name.split("/")[1])}
        killed, survived, slow = (sum(how == each for how in of.values()) for each in ("killed", "survived", "slow"))
        same = sum(name in of for name in made["equivalent"])
        score = f"{killed / (killed + survived - same):.0%}" if killed + survived > same else "—"
        rows[-1] += f"\n| {package} | {killed} | {survived} | {same} | {slow} | {score} |"
    rows += [
        f"- `{name}`: {made['equivalent'].get(name, how)}" for name, how in made["outcomes"].items() if how != "killed"
    ]
    return "\n\n".join(rows[:3]) + "\n\n" + "\n".join(rows[3:]) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=60.0)
    given = parser.parse_args()
    made = (
        json.loads(RESULT.read_text("utf-8"))
        if RESULT.exists()
        else {"seed": given.seed, "outcomes": {}, "equivalent": {}}
    )
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        shutil.copytree(ROOT, tree, ignore=shutil.ignore_patterns(".git", ".venv", "__pycache__"))
        for mutant in drawn(given.count, given.seed):
            if mutant.name not in made["outcomes"]:
                made["outcomes"][mutant.name] = judge(mutant, tree, given.limit)
                print(f"{made['outcomes'][mutant.name]}  {mutant.name}", flush=True)
                RESULT.write_text(json.dumps(made, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
                RESULT.with_suffix(".md").write_text(page(made), encoding="utf-8")


if __name__ == "__main__":
    main()
