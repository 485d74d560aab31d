"""Checks: nan never passes, limits belong to what is allowed, and words show enough digits."""

from __future__ import annotations

import math

import pytest

from validation.report.checks import at_least, at_most, between, recorded, relative, within


@pytest.mark.parametrize(
    "check",
    [
        within("x", math.nan, 1.0, 0.1),
        relative("x", math.nan, 1.0, 0.1),
        at_most("x", math.nan, 1.0),
        at_least("x", math.nan, 1.0),
        between("x", math.nan, 0.0, 1.0),
        within("x", 1.0, 1.0, math.nan),
        relative("x", 1.0, 1.0, math.nan),
    ],
)
def test_nan_is_red(check) -> None:
    assert check.passed is False


@pytest.mark.parametrize(("found", "passed"), [(0.49, False), (0.5, True), (1.5, True), (1.51, False)])
def test_limits_are_within(found: float, passed: bool) -> None:
    assert within("x", found, 1.0, 0.5).passed is passed
    assert relative("x", 2.0 * found, 2.0, 0.5).passed is passed
    assert relative("x", -2.0 * found, -2.0, 0.5).passed is passed
    assert between("x", found, 0.5, 1.5).passed is passed
    assert at_least("x", found, 0.5).passed is (found >= 0.5)
    assert at_most("x", found, 1.5).passed is (found <= 1.5)


def test_words() -> None:
    check = within("k", 0.10193679923, 0.1019368, 5e-8, "rad/m")
    assert (check.found, check.expected) == ("0.101936799 rad/m", "0.101936800 ± 5e-08 rad/m")
    check = relative("σ0", 2.155515e-4, 2.15550e-4, 1e-5)
    assert (check.found, check.expected) == ("0.000215552", "0.00021555 to 0.001 %")
    assert at_most("x", 0.0012345, 1.0, "mm").found == "0.00123 mm"
    assert recorded("x", "3 s").passed is None
