"""Checks from numbers: a measured value beside its limits, as text for the page."""

from __future__ import annotations

import math

from .case import Check


def within(what: str, measured: float, expected: float, tolerance: float, unit: str = "") -> Check:
    """`measured` must lie within `tolerance` of `expected`; nan never does."""
    passed = abs(measured - expected) <= tolerance
    return Check(what, _number(measured, tolerance, unit), _band(expected, tolerance, unit), bool(passed))


def relative(what: str, measured: float, expected: float, tolerance: float, unit: str = "") -> Check:
    """`measured` must agree with `expected` to `tolerance` of it."""
    passed = abs(measured - expected) <= tolerance * abs(expected)
    least = tolerance * abs(expected)
    words = f"{_number(expected, least, unit)} to {100.0 * tolerance:.2g} %"
    return Check(what, _number(measured, least, unit), words, bool(passed))


def at_most(what: str, measured: float, limit: float, unit: str = "") -> Check:
    """`measured` must not exceed `limit`."""
    return Check(what, _rounded(measured, unit), f"at most {_rounded(limit, unit)}", bool(measured <= limit))


def at_least(what: str, measured: float, limit: float, unit: str = "") -> Check:
    """`measured` must reach `limit`."""
    return Check(what, _rounded(measured, unit), f"at least {_rounded(limit, unit)}", bool(measured >= limit))


def between(what: str, measured: float, low: float, high: float, unit: str = "") -> Check:
    """`measured` must lie within `low` to `high`."""
    words = f"{_rounded(low, '')} to {_rounded(high, unit)}"
    return Check(what, _rounded(measured, unit), words, bool(low <= measured <= high))


def recorded(what: str, measured: str) -> Check:
    """A figure that is only recorded: nothing is required of it."""
    return Check(what, measured, "—", None)


def _band(expected: float, tolerance: float, unit: str) -> str:
    spread = f"{tolerance:.2g}"
    return f"{_number(expected, tolerance, '')} ± {spread}{_spaced(unit)}"


def _number(value: float, tolerance: float, unit: str) -> str:
    """With as many digits as show a tenth of the tolerance."""
    if not (math.isfinite(value) and tolerance > 0.0):
        return _rounded(value, unit)
    decimals = 1 - math.floor(math.log10(tolerance))
    large = abs(value) >= 1e6 or (value != 0.0 and abs(value) < 1e-3 and decimals > 5)
    if large:
        digits = max(3, min(12, math.floor(math.log10(abs(value))) + decimals))
        return f"{value:.{digits}g}{_spaced(unit)}"
    return f"{value:.{max(0, min(decimals, 12))}f}{_spaced(unit)}"


def _rounded(value: float, unit: str) -> str:
    return f"{value:.3g}{_spaced(unit)}"


def _spaced(unit: str) -> str:
    return unit if unit in ("", "°") else f" {unit}"
