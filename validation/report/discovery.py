"""Finds the modules of cases, loads them, and selects the cases to run."""

from __future__ import annotations

import difflib
import importlib.util
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import get_args

from seamap_rt.errors import InputError

from .. import cases
from .case import Case, Group, Outcome

HOME = Path(__file__).resolve().parents[1]  # the package `validation`
_NAME = re.compile(r'\b[Cc]ase(?:_of)?\(\s*(?:name=)?"(\w+)"')
_NOT_LOADED: Group = "cases that cannot be loaded"
_ORDER = {group: rank for rank, group in enumerate(get_args(Group))}


def cases_folder(home: Path = HOME) -> Path:
    """The folder of the case modules of a package. InputError where they are missing."""
    if not (home / "cases").is_dir():
        raise InputError(f"validation cases: none in {home / 'cases'}; install the package whole")
    return home / "cases"


def load_cases(folder: Path, only: Sequence[str] | None = None) -> list[Case]:
    """All cases of the modules in a folder, in the order of the page; a module that does not load is a failed case.

    only: of the modules that hold cases of these names, written out as the first argument. InputError for others.
    """
    found: list[Case] = []
    paths = sorted(folder.glob("[!_.]*.py"))
    if only:  # to load all takes seconds
        names = {path: names_in(path) for path in paths}
        known = sorted(set().union(*names.values()))
        for name in only:
            if name not in known:
                near = difflib.get_close_matches(name, known, 3, 0.4) or known
                raise InputError(f"--only {name}: no such case; there is {', '.join(near)}")
        paths = [path for path in paths if not names[path].isdisjoint(only)]
    for path in paths:
        try:
            loaded = list(_load(path).CASES)
            _refuse_duplicates(found, loaded)
        except (Exception, SystemExit) as error:
            loaded = [_unloaded(path, error)]
        found += loaded
    return sorted(found, key=lambda case: _ORDER.get(case.group, len(_ORDER)))


def names_in(path: Path) -> set[str]:
    """Names of the cases of a module, by its text."""
    return set(_NAME.findall(path.read_text(encoding="utf-8")))


def select_cases(cases: Sequence[Case], full: bool, only: Sequence[str] | None) -> list[Case]:
    """The cases to run. InputError for a case of the full version where `full` is not given."""
    if not only:
        return [case for case in cases if full or not case.full_only]
    wanted = [case for case in cases if case.name in only or case.group == _NOT_LOADED]
    if long := [case.name for case in wanted if case.full_only and not full]:
        raise InputError(f"--only {long[0]}: takes long and is left to the full version; add --full")
    return wanted


def _load(path: Path) -> ModuleType:
    name = f"{cases.__name__}.{path.stem}"  # whose relative imports are those of the package
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up while it is made
    spec.loader.exec_module(module)
    return module


def _refuse_duplicates(before: Sequence[Case], more: Sequence[Case]) -> None:
    names = [case.name for case in (*before, *more)]
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise ValueError(f"case names given twice: {', '.join(repeated)}")


def _unloaded(path: Path, error: BaseException) -> Case:
    def fail(_: bool) -> Outcome:
        raise error

    return Case(
        name=path.stem,
        group=_NOT_LOADED,
        title=f"Module {path.name}",
        rationale="A case that cannot be loaded cannot be judged.",
        setup=f"{path}",
        expectation="The module loads and its cases run.",
        run=fail,
    )
