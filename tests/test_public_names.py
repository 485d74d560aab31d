"""What a user meets first: public names that are listed and told, and scenes by their names."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import pytest

import seamap_rt as sr
from seamap_rt.scene import Scene, as_scene

FUNCTIONS = sorted(name for name in sr.__all__ if inspect.isfunction(getattr(sr, name)))


def test_dir_lists_the_public_names() -> None:
    assert sorted(dir(sr)) == sorted([*sr.__all__, "__version__"])
    assert all(getattr(sr, name) is not None for name in dir(sr))


def test_a_scene_is_taken_by_its_name_or_its_file(tmp_path: Path) -> None:
    scene = sr.load_scene("tiny")
    file = tmp_path / "mine.toml"
    file.write_text(scene.to_toml(), encoding="utf-8")
    assert as_scene(scene) is scene
    assert as_scene("tiny") == scene
    assert as_scene(file) == scene
    assert isinstance(as_scene(str(file)), Scene)
    with pytest.raises(sr.InputError, match="choppy_see"):
        sr.simulate("choppy_see")
    for begin in (sr.run, sr.expected, sr.studies.trade, sr.studies.shadowing):
        more = [{"radar.height_m": [3.0]}] if begin is sr.studies.trade else []
        with pytest.raises(sr.InputError, match="no_such_scene"):
            begin("no_such_scene", *more)  # type: ignore[operator]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_public_functions_say_what_they_take_and_what_they_refuse(name: str) -> None:
    """Each names most of its arguments in its docstring, and what it raises if it checks anything."""
    function = getattr(sr, name)
    words = inspect.getdoc(function) or ""
    assert len(words) > 60, name
    assert words.splitlines()[0].endswith((".", ":", ",")) or "\n" in words
    unsaid = [each for each in inspect.signature(function).parameters if each not in words and each != "scene"]
    assert not unsaid, f"{name} does not say what {', '.join(unsaid)} is"


def test_an_earlier_name_goes_on_with_a_warning() -> None:
    with pytest.warns(DeprecationWarning, match="NoBackendError"):
        assert sr.NoBackend is sr.NoBackendError
    with pytest.warns(DeprecationWarning, match="ResolvedSea"):
        assert sr.sea.Resolved is sr.sea.ResolvedSea


def test_errors_and_what_functions_return_have_public_names() -> None:
    """Of the package's own classes whatever a public function returns by its annotation, or says that it raises."""
    files = Path(sr.__file__).parent.rglob("*.py")
    own = {each for file in files for each in re.findall(r"^class ([A-Z]\w+)", file.read_text("utf-8"), re.MULTILINE)}
    told = [str(inspect.signature(getattr(sr, name)).return_annotation) for name in FUNCTIONS]
    told += re.findall(r"\w+Error", " ".join(inspect.getdoc(getattr(sr, name)) or "" for name in FUNCTIONS))
    named = own.intersection(re.findall(r"\w+", " ".join(told)))
    assert named <= set(dir(sr))
    assert {"RunResult", "FinishedTurn", "Finding", "WaveField", "SchemaError", "NoBackendError"} <= named
