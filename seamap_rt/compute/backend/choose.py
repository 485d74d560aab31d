"""Chooses the backend that Dr.Jit will use: call `prepare()` before drjit, mitsuba or sionna is imported.

Dr.Jit loads its LLVM while it is being imported and keeps it, and on x86 an LLVM before 17 does not raise
an error: compiling a maximum ends the whole process. So the choice is made here, in a file that imports none of
them, and each candidate is first tested in a process of its own. The first that passes is used:

    CUDA  →  the library that DRJIT_LIBLLVM_PATH names  →  the system's libLLVM, newest first
          →  one linked once into the user's cache from the static archives of the wheel `mlc-llvm-static`

A library named by the user is binding: where it fails its test the search ends with an error.
Going on would compute with another LLVM than the one that was asked for.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from ...errors import NoBackend
from . import link, memory, probe, search
from .kinds import OLDEST_LLVM, REMEDY, REMEDY_ATOMIC, VARIABLE, VARIANTS, Backend, Candidate, Verdict


@cache
def prepare() -> Backend:
    """Settle on a backend, once per process, and point Dr.Jit at it. Raises NoBackend where there is none."""
    notes: list[str] = []
    news: list[tuple[Path | None, Verdict]] = []
    for candidate in _candidates(notes):
        file = memory.verdict_file(candidate)  # named before the trial: the library may be replaced after it
        verdict = memory.recall(file)
        if verdict is None:
            verdict = probe.try_out(candidate)
            news.append((file, verdict))
        if verdict.works:
            # Failures are remembered only where something else works, so that mending is noticed at once.
            for item in news:
                memory.remember(*item)
            return _adopt(candidate, verdict, notes)
        notes.append(f"{candidate.source} {candidate.library}: {verdict.detail}")
    raise NoBackend(_explain(notes))


def _candidates(notes: list[str]) -> Iterator[Candidate]:
    """What may serve, best first. Lazy, because the last resort takes seconds and disk space to make."""
    for driver in search.find(r"libcuda\.so\.1"):
        yield Candidate("cuda", driver, "cuda")
    if named := os.environ.get(VARIABLE):
        yield Candidate("llvm", Path(named), VARIABLE)
    elif "drjit" in sys.modules:  # too late to choose: judge what it has loaded
        for library in search.loaded_llvm():
            yield Candidate("llvm", library, "already loaded")
        notes.append(f"Dr.Jit was imported before an LLVM was chosen for it: set {VARIABLE}, or prepare() first")
    else:
        system = search.system_llvm()
        for library in system:
            yield Candidate("llvm", library, "system")
        if not system:
            notes.append(f"no libLLVM {OLDEST_LLVM} or newer in the system's library folders")
        yield from link.own_llvm(notes)


def _adopt(candidate: Candidate, verdict: Verdict, notes: list[str]) -> Backend:
    """Tell Dr.Jit, and the processes started from here, where to look."""
    version = None
    if candidate.kind == "llvm":
        os.environ[VARIABLE] = str(candidate.library)
        version = verdict.detail
    return Backend(candidate.kind, candidate.library, version, candidate.source, VARIANTS[candidate.kind], tuple(notes))


def _explain(notes: list[str]) -> str:
    """One line: what was tried, why it failed, what to run."""
    reasons = "; ".join(notes)
    if "libatomic" in reasons:  # nothing works without it, and nothing else is missing as far as can be seen
        return f"no usable Dr.Jit backend ({reasons}): {REMEDY_ATOMIC}"
    if os.environ.get(VARIABLE):
        return f"no usable Dr.Jit backend ({reasons}): unset {VARIABLE} or name another file; else {REMEDY}"
    return f"no usable Dr.Jit backend ({reasons}): {REMEDY}"
