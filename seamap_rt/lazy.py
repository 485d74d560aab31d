"""Names of a package that are loaded when first asked for: who needs one of its modules does without the rest."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

_INSTALLED = Path(__file__).parent / "_judges"  # what a wheel calls the package `validation`


def lazy_attributes(
    package: str, homes: Mapping[str, str], renamed: Mapping[str, str] | None = None
) -> Callable[[str], Any]:
    """The `__getattr__` of a package.

    homes: names by the module that holds them, relative to the package, as {"surface": "Sea Patch"}. A home that ends
    in a dot is a package, of which the names are modules: "." is this one. renamed: today's names by old ones, which
    warn.
    """
    home_of = {name: home for home, names in homes.items() for name in names.split()}

    def get(name: str) -> Any:
        if new := (renamed or {}).get(name):
            warnings.warn(f"{package}.{name} is now called {new}", DeprecationWarning, stacklevel=3)
            name = new
        if name not in home_of:
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        home = home_of[name] if home_of[name].startswith(".") else f".{home_of[name]}"
        if home.endswith("."):
            return import_module(f"{home}{name}", package)
        return getattr(import_module(home, package), name)

    return get


def judge(name: str) -> Any:
    """A module of the package `validation`, which lies beside this one in a checkout. Raises InputError without it."""
    home = f"{__package__}._judges" if _INSTALLED.is_dir() else "validation"
    try:
        return import_module(f"{home}.{name}")
    except ModuleNotFoundError as error:
        if not str(error.name).startswith(home):  # a library that a judge needs
            raise
        from .errors import InputError  # only here: the package itself loads nothing

        raise InputError(
            f"validation.{name}: Python finds another package of that name before this program's, or none ({error}); "
            "run from another folder, or take that one off PYTHONPATH"
        ) from None
