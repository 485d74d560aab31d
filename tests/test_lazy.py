"""Packages whose names are loaded when asked for have all of them, and no others."""

from __future__ import annotations

import importlib
import subprocess
import sys

import pytest

LAZY = ["seamap_rt", *(f"seamap_rt.{name}" for name in ("interferometry", "mesh", "report", "sea", "session"))]


@pytest.mark.parametrize("package", LAZY)
def test_every_public_name_is_there(package: str) -> None:
    """Each in a process that has loaded nothing else."""
    program = f"import {package} as p\nfor name in p.__all__: assert getattr(p, name) is getattr(p, name), name"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("package", LAZY)
def test_there_are_no_other_names(package: str) -> None:
    module = importlib.import_module(package)
    with pytest.raises(AttributeError, match=rf"module '{package}' has no attribute 'nosuch'"):
        _ = module.nosuch
