"""A refusal is one line that a terminal can print, whatever the user's file brought into it."""

from __future__ import annotations

import pytest

from seamap_rt.errors import InputError, SchemaError, one_line


@pytest.mark.parametrize("kind", [InputError, SchemaError])
def test_refusals_are_one_printable_line(kind: type[Exception]) -> None:
    line = str(kind("a\x1b[2Jname\x00 of\n  two\tlines \udc80"))
    assert line == "a\\x1b[2Jname\\x00 of two lines \\udc80"
    assert line.isprintable()


def test_several_problems_are_as_many_lines() -> None:
    """No more lines than problems, whatever the words hold, and none twice."""
    error = InputError("a: is\nwrong", "b: too", "a: is wrong")
    assert error.problems == ("a: is wrong", "b: too")
    assert str(error) == "a: is wrong\nb: too"
    assert InputError("one").problems == ("one",)


def test_long_words_keep_their_ends() -> None:
    path = "/" + "x" * 5000 + "/end.toml"
    line = one_line(f"'{path}': no such file")
    assert len(line) < 240
    assert len(one_line("word " * 1000)) == 1000
    assert line.startswith("'/xxx")
    assert line.endswith("/end.toml': no such file")
    assert one_line("y" * 200) == "y" * 200
