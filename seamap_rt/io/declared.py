"""What a variable's attributes say of its numbers (CF's rules): packing, what is missing, time, unit as files spell it.

An angle is a dimension here, so that rad/s is no Hz and a density per radian none per degree. The library pint has no
such dimension: of the 334 spellings of tests/io/test_units.py, with powers as in CF, pint 0.25 takes 77 for 2π times
what they are and refuses 80; it loads in 0.35 s.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from xarray.conventions import decode_cf_variable

from ..errors import InputError, Refusal
from .text import plain_attribute

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
    factor = conversion_factor(str(declared), unit)
    if factor is None:
        raise Refusal(f"{what}: is in '{declared}': must be in {unit}, or a unit of its kind; convert it")
    return given if factor == 1.0 else given * factor


def conversion_factor(declared: str, unit: str) -> float | None:
    """What makes numbers of a declared unit those of another; None where nothing does.

    A frequency of 2π rad/s is one of 1 Hz, and a density per Hz is 2π times one per rad/s.
    """
    have, want = parse_unit(declared), parse_unit(unit)
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


def parse_unit(text: str) -> tuple[float, Mapping[str, int]] | None:
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
            factor, dimensions = (float(token["number"]), {}) if token["number"] else _look_up_unit(token["name"])
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


def _look_up_unit(name: str) -> tuple[float, Mapping[str, int]]:
    """A unit by its name, in capitals too; of size 0 if there is none."""
    plain = name.lower() if name.isupper() or (name.istitle() and len(name) > 2) or name == "Km" else name
    return _UNITS.get(name) or _UNITS.get(plain) or (0.0, {})


_PACKING = ("scale_factor", "add_offset", "_Unsigned")
_FILLS = ("_FillValue", "missing_value")


def plain_attributes(values: xr.Dataset) -> xr.Dataset:
    """A dataset whose attributes, and those of its variables, are plain."""
    for each in (values, *values.variables.values()):
        each.attrs = {name: plain_attribute(value) for name, value in each.attrs.items()}
    return values


def decode(values: NDArray, attributes: Mapping[str, Any], name: str) -> NDArray:
    """Numbers of an array by its attributes: packing is undone, dates are dates, what is missing is NaN, and of
    whole numbers that are not packed masked. Without such attributes the array itself. Raises InputError for what
    cannot be obeyed."""
    declared = {key: plain_attribute(attributes[key]) for key in (*_PACKING, *_FILLS) if key in attributes}
    for key, value in declared.items():
        if np.size(value) != 1 or (key != "_Unsigned" and np.asarray(value).dtype.kind not in "iufb"):
            raise InputError(f"{name}: {key} = {value!r}: must be a number; correct the attribute")
    unit = plain_attribute(attributes.get("units"))
    dates = isinstance(unit, str) and " since " in unit
    if not declared and not dates:
        return values
    if values.dtype.kind == "c" and not dates:
        real, imaginary = (decode(part, attributes, name) for part in (np.real(values), np.imag(values)))
        return real + 1j * imaginary
    if values.dtype.names and not dates:
        parts = {key: np.ma.asarray(decode(values[key], attributes, name), np.float64) for key in values.dtype.names}
        pair = np.empty(values.shape, [(key, np.float64) for key in parts])
        for key, part in parts.items():
            pair[key] = part.filled(np.nan)
        return pair
    if values.dtype.kind not in "iuf":
        raise InputError(f"{name}: has {', '.join(declared) or unit} and no plain numbers; save it as numbers")
    if not dates and not any(key in declared for key in _PACKING) and values.dtype.kind in "iu":
        missing = np.isin(values, [declared[key] for key in _FILLS if key in declared])
        return np.ma.masked_array(values, missing) if missing.any() else values
    if dates:
        declared |= {"units": unit, "calendar": plain_attribute(attributes.get("calendar", "standard"))}
    dims = tuple(f"axis_{n}" for n in range(values.ndim))
    try:
        result = decode_cf_variable(name, xr.Variable(dims, values, declared)).to_numpy()
    except (ValueError, TypeError, OverflowError) as error:
        raise InputError(f"{name}: its attributes cannot be obeyed ({error}); correct them") from None
    if dates and result.dtype.kind != "M":
        raise InputError(f"{name}: is in '{unit}' of a calendar without real dates; give dates of the standard one")
    return result


def convert_by_attributes(values: NDArray, attributes: Mapping[str, Any], unit: str, name: str) -> NDArray:
    """Decoded numbers in a unit, converted from the one that their attributes tell; dates stay dates."""
    declared = plain_attribute(attributes.get("units"))
    if values.dtype.kind in "mM" or declared is None:
        return values
    return to_unit(values, declared, unit, name)


def mask_out_of_range(values: NDArray, attributes: Mapping[str, Any], packing: Mapping[str, Any]) -> NDArray:
    """Decoded numbers, NaN where they lie beyond valid_range, valid_min or valid_max. These are of the packed numbers
    where they have whole ones' type, and of the unpacked ones otherwise. packing: scale_factor, add_offset."""
    limits = {key: attributes[key] for key in ("valid_range", "valid_min", "valid_max") if key in attributes}
    if not limits or values.dtype.kind not in "iuf":
        return values
    low, high = limits.get("valid_range", (-np.inf, np.inf))
    ends = np.array([plain_attribute(limits.get("valid_min", low)), plain_attribute(limits.get("valid_max", high))])
    scale, offset = (
        float(plain_attribute(packing.get(key, usual))) for key, usual in (("scale_factor", 1.0), ("add_offset", 0.0))
    )
    if ends.dtype.kind in "iu":
        ends = np.sort(ends * scale + offset)
    slack = 1e-6 * np.abs(ends)  # of numbers scaled in float32
    return np.where((values < ends[0] - slack[0]) | (values > ends[1] + slack[1]), np.nan, values)
