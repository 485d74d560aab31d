"""The time left is what has been measured so far: nothing at first, a bound after one part, then their mean."""

from __future__ import annotations

import pytest

from seamap_rt.io.process import ProgressEstimate, duration


class Hand:
    """A clock that is moved by hand."""

    def __init__(self) -> None:
        self.time = 100.0

    def __call__(self) -> float:
        return self.time


def test_equal_turns_are_told_exactly() -> None:
    """Turns of 8 s after a first one of 20 s: at the begin of turn n of 5, 8 (5 − n + 1) s are left."""
    said: list[str] = []
    hand = Hand()
    pace = ProgressEstimate("turn", 5, said.append, hand)
    for lasts in (20.0, 8.0, 8.0, 8.0, 8.0):
        pace.begin()
        pace.stage("mesh")
        hand.time += 0.5 * lasts
        pace.stage("trace")
        hand.time += 0.5 * lasts
    assert said == [
        "turn 1 of 5: mesh, … left",
        "turn 1 of 5: trace, … left",
        "turn 2 of 5: mesh, at most 80 s left",
        "turn 2 of 5: trace, at most 76 s left",
        "turn 3 of 5: mesh, about 24 s left",
        "turn 3 of 5: trace, about 20 s left",
        "turn 4 of 5: mesh, about 16 s left",
        "turn 4 of 5: trace, about 12 s left",
        "turn 5 of 5: mesh, about 8 s left",
        "turn 5 of 5: trace, about 4 s left",
    ]


def test_a_turn_that_takes_longer_has_nothing_less_than_nothing_left() -> None:
    hand = Hand()
    pace = ProgressEstimate("turn", 3, print, hand)
    for lasts in (1.0, 1.0, 500.0):
        pace.begin()
        hand.time += lasts
    assert pace.time_left() == "about 0 s"


def test_a_stage_is_told_once_by_its_own_name() -> None:
    said: list[str] = []
    pace = ProgressEstimate("turn", 1, said.append)
    pace.begin()
    steps = ("calibrate", "mesh", "sea", "mesh", "mesh", "trace", "scattering", "sea", "echoes", "truth", "sea")
    for step in (*steps, "retrieve"):
        pace.stage(step)
    told = [line.split(": ")[1].split(",")[0] for line in said]
    assert told == ["calibrate", "mesh", "sea", "mesh", "trace", "echoes", "truth", "retrieve"]


@pytest.mark.parametrize(("seconds", "words"), [(0.4, "0 s"), (89.4, "89 s"), (90.0, "2 min"), (3600.0, "60 min")])
def test_long_times_are_minutes(seconds: float, words: str) -> None:
    assert duration(seconds) == words
