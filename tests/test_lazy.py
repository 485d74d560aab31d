"""Packages whose names are loaded when asked for have all of them, and no others."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from validation import ROOT

LAZY = ["seamap_rt", *(f"seamap_rt.{name}" for name in ("interferometry", "mesh", "sea", "session"))]


_EACH_ALONE = """
import importlib, os, sys
import numba, xarray
for package in sys.argv[1:]:
    child = os.fork()
    if child == 0:
        module = importlib.import_module(package)
        for name in module.__all__:
            assert getattr(module, name) is getattr(module, name), (package, name)
        os._exit(0)
    if os.waitpid(child, 0)[1]:
        print(package)
"""


def test_every_public_name_is_there() -> None:
    """Each package in a process that has loaded nothing else of ours; what it takes from elsewhere is loaded once."""
    done = subprocess.run([sys.executable, "-c", _EACH_ALONE, *LAZY], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.split()) == (0, []), done.stderr


@pytest.mark.parametrize("package", LAZY)
def test_there_are_no_other_names(package: str) -> None:
    module = importlib.import_module(package)
    with pytest.raises(AttributeError, match=rf"module '{package}' has no attribute 'nosuch'"):
        _ = module.nosuch


def test_a_wheel_has_one_package_of_its_own_name_and_the_judges_in_it(tmp_path: Path) -> None:
    """Laid out as pyproject.toml lays out a wheel, of links; another's `validation` stands before it."""
    build = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["hatch"]["build"]
    wheel = build["targets"]["wheel"]
    places = {name: wheel["sources"].get(name, name) for name in wheel["packages"]}
    assert {place.split("/")[0] for place in places.values()} == {"seamap_rt"}
    site = tmp_path / "site"
    for name, place in places.items():
        (site / place).mkdir(parents=True)
        for each in (ROOT / name).iterdir():
            (site / place / each.name).symlink_to(each)
    (tmp_path / "others" / "validation").mkdir(parents=True)
    (tmp_path / "others" / "validation" / "__init__.py").touch()
    program = "import seamap_rt as sr; print(sr.__file__, sr.analytic.__file__)"
    paths = os.pathsep.join(str(each) for each in (tmp_path / "others", site))
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd="/", env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.split() == [
        str(site / "seamap_rt" / "__init__.py"),
        str(site / places["validation"] / "analytic" / "__init__.py"),
    ]
