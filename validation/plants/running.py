"""Plants errors one at a time in a copy of the tree and asks their judges."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import NamedTuple

from .plant import CASE, Plant, copy_tree, fault_of

_THREADS = "NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"  # one each: the workers share the cores
_UNSAID = "-W", "ignore::pytest.PytestAssertRewriteWarning"  # of libraries that are loaded before pytest
_FAILED = 1  # exit code of pytest and of `seamap-rt validate` when a check failed; others are errors before it


class Verdict(NamedTuple):
    """What became of a row: `right` if it is as it must be, `word` says what was seen."""

    right: bool
    word: str
    seconds: float
    output: str  # of the judge, for rows that are not right


class Tree:
    """A copy of the tree, and a process that asks judges in it (`asking`); libraries: it loads them beforehand."""

    def __init__(self, folder: Path, libraries: bool = True) -> None:
        self.root, self._said = copy_tree(folder), folder / "said"
        script = Path(__file__).with_name("asking.py")
        self._process = subprocess.Popen(
            [sys.executable, str(script), *(() if libraries else ("bare",))],
            env={**os.environ, **dict.fromkeys(_THREADS, "1")},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def ask(self, judges: Sequence[str]) -> tuple[int, str]:
        """Exit code and output of one case, or of several tests in one process; a negative code is a signal's."""
        command = ["pytest", "-n0", "-x", "-q", "-p", "no:cacheprovider", *_UNSAID]
        command += [part for judge in judges for part in shlex.split(judge)]
        with tempfile.TemporaryDirectory(prefix="judge-") as out:
            if judges[0].startswith(CASE):
                command = ["validate", "--only", judges[0].removeprefix(CASE), "--out", f"{out}/report"]
            assert self._process.stdin is not None
            assert self._process.stdout is not None
            self._process.stdin.write(json.dumps([str(self.root), str(self._said.parent), *command]) + "\n")
            self._process.stdin.flush()
            answer = self._process.stdout.readline()
        if not answer:
            raise RuntimeError(f"{judges[0]}: the process that asks judges has ended; its message stands above")
        return int(answer), self._said.read_text(encoding="utf-8", errors="replace")

    def close(self) -> None:
        """Ends the process."""
        self._process.communicate()


def without(judges: Sequence[str], tree: Tree) -> Verdict:
    """Judges without an error must be green."""
    begun = time.perf_counter()
    code, output = tree.ask(judges)
    return Verdict(code == 0, "green" if code == 0 else f"RED (code {code})", time.perf_counter() - begun, output)


def planted(plant: Plant, tree: Tree) -> Verdict:
    """The judge with the error must fail, by a check and not by an error before it. The file is restored."""
    fault = fault_of(plant, tree.root)
    if fault:
        return Verdict(False, fault, 0.0, "")
    path, begun = tree.root / plant.file, time.perf_counter()
    text = path.read_text(encoding="utf-8")
    _write(path, text.replace(plant.old, plant.new))
    try:
        code, output = tree.ask([plant.judge])
    finally:
        _write(path, text)
    word = {0: "GREEN", _FAILED: "red"}.get(code, f"ERROR (code {code})")
    return Verdict(code == _FAILED, word, time.perf_counter() - begun, output)


def batches(judges: Sequence[str], count: int) -> list[list[str]]:
    """Judges that one process can ask: tests dealt to `count` processes, each case by itself."""
    tests = [judge for judge in judges if not judge.startswith(CASE)]
    dealt = [tests[first::count] for first in range(count)]
    return [batch for batch in dealt if batch] + [[judge] for judge in judges if judge.startswith(CASE)]


def run(plants: Sequence[Plant], workers: int, say: Callable[[str], None]) -> list[str]:
    """Asks each judge without an error, then each plant's judge with it; names of what was not as it must be."""
    wrong: list[str] = []
    with tempfile.TemporaryDirectory(prefix="plants-") as folder, ThreadPoolExecutor(workers) as pool:
        copies = [Tree(Path(folder) / str(number)) for number in range(workers)]
        trees: SimpleQueue[Tree] = SimpleQueue()
        for tree in copies:
            trees.put(tree)

        def report(name: str, judge: str, work: Callable[[Tree], Verdict]) -> None:
            tree = trees.get()
            try:
                verdict = work(tree)
            finally:
                trees.put(tree)
            say(f"{name:34s} {judge:100s} {verdict.seconds:6.1f} s  {verdict.word}")
            if not verdict.right:
                wrong.append(name)
                say("    " + "\n    ".join(verdict.output.strip().splitlines()[-12:]))

        def unharmed(judges: list[str]) -> None:
            words = judges[0] if len(judges) == 1 else f"{len(judges)} tests"
            report("nothing planted", words, lambda tree: without(judges, tree))

        list(pool.map(unharmed, batches(list(dict.fromkeys(plant.judge for plant in plants)), workers)))
        list(pool.map(lambda row: report(row.name, row.judge, lambda tree: planted(row, tree)), plants))
        for tree in copies:
            tree.close()
    return wrong


def _write(path: Path, text: str) -> None:
    """With a later second as its time of change: byte code and compiled loops are kept beside the source by that."""
    second = max(int(path.stat().st_mtime) + 1, int(time.time()))
    path.write_text(text, encoding="utf-8")
    os.utime(path, (second, second))
