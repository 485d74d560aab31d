"""Units as files spell them, and numbers in the unit that the program counts in.

An angle is a dimension here, so that rad/s is no Hz and a density per radian none per degree. The library pint has no
such dimension: of the 334 spellings of tests/io/test_units.py, with powers as in CF, pint 0.25 takes 77 for 2π times
what they are and refuses 80; it loads in 0.35 s.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError

_TURN = 2.0 * math.pi
_DEFINED: list[tuple[str, float, dict[str, int]]] = [
    ("m meter meters metre metres", 1.0, {"length": 1}),
    ("ft foot feet", 0.3048, {"length": 1}),
    ("nmi NM nautical_mile nautical_miles", 1852.0, {"length": 1}),
    ("s sec secs second seconds", 1.0, {"time": 1}),
    ("min mins minute minutes", 60.0, {"time": 1}),
    ("h hr hrs hour hours", 3600.0, {"time": 1}),
    ("d day days", 86400.0, {"time": 1}),
    ("rad radian radians", 1.0, {"angle": 1}),
    ("deg degr degree degrees ° º deg_true degree_true degrees_true", _TURN / 360.0, {"angle": 1}),
    ("cycle cycles", 1.0, {}),  # of a second: Hz
    ("Hz hz hertz", 1.0, {"time": -1}),
    ("g gram grams", 1e-3, {"mass": 1}),
    ("N newton newtons", 1.0, {"mass": 1, "length": 1, "time": -2}),
    ("J joule joules", 1.0, {"mass": 1, "length": 2, "time": -2}),
    ("Js", 1.0, {"mass": 1, "length": 2, "time": -1}),  # as SWAN writes J s
]
_PREFIXES = {"k": 1e3, "M": 1e6, "G": 1e9, "c": 1e-2, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "n": 1e-9}
_PREFIX_WORDS = {"kilo": 1e3, "mega": 1e6, "giga": 1e9, "centi": 1e-2, "milli": 1e-3, "micro": 1e-6, "nano": 1e-9}
_UNITS = {name: (size, powers) for names, size, powers in _DEFINED for name in names.split()}
_UNITS |= {
    prefix + name: (scale * _UNITS[name][0], _UNITS[name][1])
    for prefixes, names in (
        (_PREFIXES, "m s Hz g N J rad deg"),
        (_PREFIX_WORDS, "meter meters metre metres second seconds hertz gram grams radian radians"),
    )
    for prefix, scale in prefixes.items()
    for name in names.split()
} | {"msec": (1e-3, {"time": 1}), "usec": (1e-6, {"time": 1}), "MHZ": (1e6, {"time": -1}), "GHZ": (1e9, {"time": -1})}
for _two_meanings in ("nm", "Mm", "Ms"):  # a nautical mile, a millimetre, a millisecond of careless spelling
    del _UNITS[_two_meanings]

_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺{}−", "0123456789-+  -")
_TOKEN = re.compile(
    r"\s*(?:(?P<sign>[()/])|(?P<number>\d+(?:\.\d+)?(?:[eE][-+]?\d+)?)(?![\d.])"
    r"|(?P<name>[^\W\d]+|[°º])(?:\s*\^\s*(?P<raised>[-+]?\d{1,2})|(?P<power>[-+]?\d{1,2}))?)(?![\d.]\d)"
)


def to_unit(values: ArrayLike, declared: str | None, unit: str, what: str) -> NDArray[np.float64]:
    """Values in `unit`, converted from the unit that is declared of `what`; as they are where none is.

    Raises InputError, which names both, for a unit that is not understood or measures something else.
    """
    given: NDArray[np.float64] = np.asarray(values)
    if declared is None or not str(declared).strip():
        return given
    factor = conversion(str(declared), unit)
    if factor is None:
        raise InputError(f"{what}: is in '{declared}': must be in {unit}, or a unit of its kind; convert it")
    return given if factor == 1.0 else given * factor


def conversion(declared: str, unit: str) -> float | None:
    """What makes numbers of a declared unit those of another; None where nothing does.

    A frequency of 2π rad/s is one of 1 Hz, and a density per Hz is 2π times one per rad/s.
    """
    have, want = parsed(declared), parsed(unit)
    if have is None or want is None:
        return None
    (size, powers), (base, wanted) = have, want
    excess = {name: powers.get(name, 0) - wanted.get(name, 0) for name in {*powers, *wanted}}
    excess = {name: power for name, power in excess.items() if power}
    if not excess:
        return 1.0 if size == base else size / base
    if wanted == {"angle": 1, "time": -1} and excess == {"angle": -1}:  # a rate; 1/s is rad/s, as engineers write it
        return size / base * (_TURN if re.search(r"hz|hertz|cycle", declared, re.I) else 1.0)
    seconds = wanted.get("time", 0)
    if "angle" not in wanted or wanted["angle"] < 0:  # frequencies and densities, not rates of turning
        if seconds == -1 and excess == {"angle": 1}:
            return size / base / _TURN
        if seconds == 1 and excess == {"angle": -1} and wanted.get("length") == 2:
            return size / base * _TURN
    return None


def parsed(text: str) -> tuple[float, Mapping[str, int]] | None:
    """A unit's size in m, s, rad and kg, and its powers of length, time, angle and mass; None for what is no unit."""
    if len(text) > 80:
        return None
    text = re.sub(r"\b(rad|m)s(?=\^?-1\b)", r"\1 s", text.translate(_SUPERSCRIPTS).replace("**", "^").strip())
    text = re.sub(r"[*·⋅×]|(?<!\d)\.|\.(?!\d)", " ", re.sub(r"\bper\b", "/", text))
    size, powers, position = 1.0, Counter[str](), 0
    outer, sign = [1], 1  # of each open bracket; of the next factor
    while position < len(text.rstrip()):
        token = _TOKEN.match(text, position)
        if token is None:
            return None
        position = token.end()
        if token["sign"] == "/":
            if sign < 0:
                return None
            sign = -1
            continue
        if token["sign"] == "(":
            outer.append(outer[-1] * sign)
        elif token["sign"] == ")":
            if len(outer) == 1 or sign < 0:
                return None
            outer.pop()
        else:
            factor, dimensions = (float(token["number"]), {}) if token["number"] else _known(token["name"])
            if token["number"] and token.start() > 0:  # m 2 is careless spelling, a number comes first
                return None
            power = outer[-1] * sign * int(token["raised"] or token["power"] or 1)
            if not 0.0 < factor < math.inf:
                return None
            size *= factor**power
            for name, exponent in dimensions.items():
                powers[name] += exponent * power
        sign = 1
    if len(outer) > 1 or sign < 0 or not text or not 0.0 < size < math.inf:
        return None
    return size, {name: power for name, power in powers.items() if power}


def _known(name: str) -> tuple[float, Mapping[str, int]]:
    """A unit by its name, in capitals too; of size 0 if there is none."""
    plain = name.lower() if name.isupper() or (name.istitle() and len(name) > 2) or name == "Km" else name
    return _UNITS.get(name) or _UNITS.get(plain) or (0.0, {})
