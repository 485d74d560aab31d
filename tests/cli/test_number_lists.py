"""Options that take several numbers read them alike, A,B,… or START:STOP:STEP, and refuse alike."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import pytest

from seamap_rt.cli.retrieving import _leads
from seamap_rt.cli.studying import _metres
from seamap_rt.errors import InputError
from seamap_rt.products.link import ranges_of
from seamap_rt.products.sampling import times_of
from seamap_rt.scene import load_scene
from seamap_rt.studies.vary import parse_vary

READERS: dict[str, Callable[[str], Iterable[float]]] = {
    "--vary": lambda text: parse_vary(f"radar.height_m={text}")[1],
    "--heights": _metres,
    "--ranges": lambda text: ranges_of(text, load_scene("tiny")),
    "--times": times_of,
    "--lead": _leads,
}


@pytest.mark.parametrize("option", READERS)
def test_steps_are_taken_in_decimals_and_meet_their_stop(option: str) -> None:
    """0.3 is 0.3, not three times 0.1."""
    assert list(READERS[option]("10.1:10.4:0.1")) == [10.1, 10.2, 10.3, 10.4]
    assert list(READERS[option]("10:30:8")) == [10.0, 18.0, 26.0]
    assert list(READERS[option]("10:10:1")) == [10.0]


@pytest.mark.parametrize("option", READERS)
@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1:2:x", "numbers"),
        ("1:2", "must be three numbers"),
        ("1:2:3:4", "must be three numbers"),
        ("1:inf:1", "must be finite"),
        ("1:1e999:1", "must be finite"),
        ("1:2_0:1", "numbers"),
        ("3:1:1", "STEP must be greater than 0 and STOP at least START"),
        ("1:2:0", "STEP must be greater than 0 and STOP at least START"),
        ("1:2:-1", "STEP must be greater than 0 and STOP at least START"),
        ("0:1e12:1", "are taken; widen STEP"),
    ],
)
def test_what_is_no_list_of_numbers_is_refused_with_what_to_write(option: str, text: str, words: str) -> None:
    with pytest.raises(InputError) as refusal:
        READERS[option](text)
    line = str(refusal.value)
    assert "\n" not in line
    assert line.startswith(option)
    assert text in line
    assert words in line
