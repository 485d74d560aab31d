"""How many small errors in the code do the tests find? One operator, comparison or number is changed at a time.

python -m validation.mutants [--count 120] [--seed 1] [--limit 60] [--tree DIR] [--again survived]

Mutants are drawn from a seed, a package after the other, so that a longer run goes on where a shorter one ended: each
outcome is written to `validation/results/mutants.json` as soon as it is known, and `mutants.md` is made of it. Each is
run in a copy of the tree (--tree: kept there, with its compiled code) against the tests that import its module, then
against the others of its package's folder.

    killed     a test fails that passes without it
    passed     the tests that import it pass, others are to come
    survived   all pass: the mutant is equivalent, or a law is missing; --again survived judges these anew
    slow       the tests that import it took longer than the limit [s], and none had failed: not counted

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
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from .evidence import git, page
from .report.environment import Environment

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


@cache
def users() -> dict[str, set[str]]:
    """Files whose modules import from a file's, by that file; imports from a package lead to none."""
    made: dict[str, set[str]] = {}
    for path in sorted((ROOT / "seamap_rt").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_bytes())):
            if isinstance(node, ast.ImportFrom):
                base = path.parents[node.level - 1] if node.level else ROOT
                home = base.joinpath(*(node.module or "").split("."))
                for used in (home.with_suffix(".py"), *(home / f"{each.name}.py" for each in node.names)):
                    made.setdefault(used.relative_to(ROOT).as_posix(), set()).add(path.relative_to(ROOT).as_posix())
    return made


def dependents(file: str) -> list[str]:
    """A file and those that use it, or one that does: what is compiled of them may hold it."""
    found, waiting = {file}, [file]
    while waiting:
        new = users().get(waiting.pop(), set()) - found
        found |= new
        waiting += new
    return sorted(found)


def tests_of(mutant: Mutant) -> list[list[str]]:
    """Test files that import the mutant's module, else those of its name or its package's, nearest first; then, where
    its package has other modules that use it, the others of the package's folder."""
    module = mutant.file.removesuffix("/__init__.py").removesuffix(".py").replace("/", ".")
    home, _, last = module.rpartition(".")
    wanted = re.compile(rf"(from {re.escape(home)} import .*\b{last}\b|{re.escape(module)}\b)")
    folder, package = f"tests/{mutant.package}/", f"seamap_rt/{mutant.package}/"
    texts = {
        path.relative_to(ROOT).as_posix(): path.read_text("utf-8")
        for path in sorted((ROOT / "tests").rglob("test_*.py"))
    }
    near = [name for name, text in texts.items() if wanted.search(text)]
    words = {last.partition("_")[0], *home.split(".")[2:]}
    near = near or [name for name in texts if any(word in name.rpartition("/")[2] for word in words)]
    near.sort(key=lambda name: (not name.startswith(folder), last not in name))
    inside = [
        each for each in users().get(mutant.file, ()) if each.startswith(package) and each != f"{package}__init__.py"
    ]
    others = [name for name in texts if name.startswith(folder) and name not in near]
    return [near, others if inside or not near else []]


@dataclass
class Bench:
    """A copy of the tree in which mutants are tried. broken: tests that fail there without one, and are left out."""

    tree: Path
    limit_s: float
    broken: set[str] = field(default_factory=set)

    def failed(self, mutant: Mutant, tests: list[str]) -> str:
        """The first test that fails with the mutant; "slow", or "" where all pass."""
        with self.mutated(mutant):
            left_out = [f"--deselect={each}" for each in sorted(self.broken)]
            return next(iter(self.run(self.limit_s, "-x", *tests, *left_out)), "") if tests else ""

    def run(self, limit_s: float | None, *words: str) -> list[str]:
        """The tests, or their files, that fail; ["slow"], or none where all pass or none is there."""
        command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", "-rfE", *words]
        environment = {**os.environ, "PYTHONPATH": str(self.tree)}
        with subprocess.Popen(
            command, cwd=self.tree, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            start_new_session=True,
        ) as ran:  # fmt: skip
            try:
                text, _ = ran.communicate(timeout=limit_s)
            except BaseException as error:
                os.killpg(ran.pid, signal.SIGKILL)  # and what its tests started
                if isinstance(error, subprocess.TimeoutExpired):
                    return ["slow"]
                raise
        if ran.returncode in (0, 5):
            return []
        found = re.findall(r"^(?:FAILED|ERROR) (\S.*?)(?: - .*)?$", text, re.MULTILINE)
        return found or [next(each for each in words if each.startswith("tests"))]  # the process broke down

    @contextmanager
    def mutated(self, mutant: Mutant) -> Iterator[None]:
        """Meanwhile the file has the mutant, and what Numba keeps of those that may hold it lies aside."""
        path, source = self.tree / mutant.file, (ROOT / mutant.file).read_bytes()
        before = path.stat()
        aside = Path(tempfile.mkdtemp())
        kept = self.kept(mutant)
        for number, each in enumerate(kept):
            shutil.move(each, aside / str(number))
        path.write_bytes(mutant.apply(source))
        try:
            yield
        finally:
            path.write_bytes(source)
            os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
            for each in self.kept(mutant):
                each.unlink()
            for number, each in enumerate(kept):
                shutil.move(aside / str(number), each)
            aside.rmdir()

    def kept(self, mutant: Mutant) -> list[Path]:
        files = [self.tree / each for each in dependents(mutant.file)]
        return [each for file in files for each in (file.parent / "__pycache__").glob(f"{file.stem}.*.nb[ci]")]


def table(made: dict[str, Any]) -> dict[str, Any]:
    """Of `results`: a row a package."""
    rows = []
    for package in (*PACKAGES, "all"):
        of = {name: how for name, how in made["outcomes"].items() if package in ("all", name.split("/")[1])}
        killed, slow = (sum(how == each for how in of.values()) for each in ("killed", "slow"))
        survived = len(of) - killed - slow
        same = sum(of.get(name) in ("passed", "survived") for name in made["equivalent"])
        score = f"{killed / (killed + survived - same):.0%}" if killed + survived > same else "—"
        rows.append([package, *map(str, (killed, survived, same, slow)), score])
    return {"title": "", "columns": ["package", "killed", "survived", "equivalent", "slow", "score"][1:], "rows": rows}


def write(made: dict[str, Any]) -> None:
    """With when, where and of which code it was judged, as every result states."""
    here = Environment.here()
    made |= {
        "command": f"python -m validation.mutants --count {len(made['outcomes'])} --seed {made['seed']}",
        "kind": "debug",
        "subject": [f"seamap_rt/{package}" for package in PACKAGES],
        "draw": None,
        "version": here.versions["seamap_rt"],
        "commit": git("log", "-1", "--format=%h", "--", "seamap_rt"),
        "date": here.when,
        "machine": here.machine,
        "tables": [table(made)],
    }
    rows = "\n".join(f"| {' | '.join(row)} |" for row in made["tables"][0]["rows"])
    columns = " | ".join(["package", *made["tables"][0]["columns"]])
    lines = [
        f"- `{name}`: {made['equivalent'].get(name, how)}" for name, how in made["outcomes"].items() if how != "killed"
    ]
    text = f"| {columns} |\n|{6 * '---|'}\n{rows}\n"
    RESULT.with_suffix(".md").write_text(f"{page('mutants', made, text)}\n" + "\n".join(lines) + "\n", "utf-8")
    RESULT.write_text(json.dumps(made, ensure_ascii=False, indent=1) + "\n", "utf-8")


def judge(bench: Bench, mutants: list[Mutant], made: dict[str, Any], again: list[str]) -> bool:
    """Whether all are judged, by tests that pass without a mutant: else those that others killed are forgotten."""
    outcomes, by = made["outcomes"], made["by"]
    for step in range(2):
        for mutant in mutants:
            known, name, begin = outcomes.get(mutant.name, ""), mutant.name, time.perf_counter()
            if name in made["equivalent"] and known:
                continue
            if step == 0 and (not known or known in again):
                how = bench.failed(mutant, tests_of(mutant)[0])
                outcomes[name] = "passed" if not how else "slow" if how == "slow" else "killed"
            elif step == 1 and known == "passed":  # what these leave, others may find; they need not end in time
                how = bench.failed(mutant, tests_of(mutant)[1]).replace("slow", "")
                outcomes[name] = "killed" if how else "survived"
            else:
                continue
            by |= {name: how} if outcomes[name] == "killed" else {}
            print(f"{outcomes[name]}  {name}  {how}", flush=True)
            made["seconds"] = round(made["seconds"] + time.perf_counter() - begin, 1)
            write(made)
    killers = sorted({by[each.name].partition("[")[0] for each in mutants if each.name in by})
    fails = set(bench.run(None, *killers)) if killers else set()
    bench.broken |= fails
    wrong = [name for name, test in by.items() if any(each.startswith(test) for each in fails)]
    for name in wrong:
        print(f"{by[name]} fails without {name}", flush=True)
        del outcomes[name], by[name]
    return not wrong


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=60.0)
    parser.add_argument("--tree", type=Path)
    parser.add_argument("--again", choices=("passed", "survived", "slow"), action="append", default=[])
    given = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # the copy is left without a mutant
    empty = {"seed": given.seed, "seconds": 0.0, "outcomes": {}, "by": {}, "equivalent": {}}
    made = json.loads(RESULT.read_text("utf-8")) if RESULT.exists() else empty
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench((given.tree or Path(folder) / "tree").resolve(), given.limit)
        left_out = shutil.ignore_patterns(".git", ".venv", "__pycache__")
        shutil.copytree(ROOT, bench.tree, ignore=left_out, dirs_exist_ok=True)
        mutants = drawn(given.count, given.seed)
        again = given.again
        while not judge(bench, mutants, made, again):
            again = []
    write(made)


if __name__ == "__main__":
    main()
