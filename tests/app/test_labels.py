"""What the page's buttons say is what they do."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import seamap_rt.app

_FILES = sorted(Path(seamap_rt.app.__file__).parent.glob("*.py"))
_SAYS = {"download": "Download", "delete": "Delete"}


def _buttons(source: str) -> Iterator[tuple[str, str]]:
    """Of each button that has an icon: the icon, and what the source says of it, its properties included."""
    for each in ast.walk(ast.parse(source)):
        if isinstance(each, ast.Call) and ast.unparse(each.func) in ("ui.button", "flat_button", "round_button"):
            icon = next((k.value for k in each.keywords if k.arg == "icon"), None)
            lines = source.splitlines()[each.lineno - 1 : (each.end_lineno or each.lineno) + 2]
            yield str(getattr(icon, "value", "")), "\n".join(lines)


@pytest.mark.parametrize("file", _FILES, ids=lambda path: path.stem)
def test_what_deletes_and_what_downloads_say_so(file: Path) -> None:
    source = file.read_text(encoding="utf-8")
    for icon, said in _buttons(source):
        if icon in _SAYS:
            assert _SAYS[icon] in said
    assert not re.search(r"\bTake (out|away|off)\b", source)
