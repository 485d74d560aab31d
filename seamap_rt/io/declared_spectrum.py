"""What a file's words say of a directional spectrum: its units, and which way its directions point.

All is converted here to Hz, degrees clockwise from north where waves come from, and m²/(Hz·degree). In the units of a
spectral density the second stands for 1/Hz: m2 s rad-1 is per Hz and radian, as WAVEWATCH III and ERA5 write it; per
rad/s it is where the unit has radians twice, or radians and degrees.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import GRAVITY, WATER_DENSITY
from ..errors import InputError
from .plain_json import plain_attribute
from .units import to_unit

Sense = Literal["from", "to"]

_TO = re.compile(
    r"to_direction|\b(going|propagat\w+|travel\w*|heading)\b|\btowards?\b|\bto which\b|oceanographic", re.I
)
_FROM = re.compile(r"from_direction|\b(coming )?from\b|nautical|meteorological", re.I)
_ORIGIN = re.compile(r"\bfrom (the |true |magnetic |geographic )*(north|east|x)\b", re.I)
_CARTESIAN = re.compile(r"counter-?\s?clockwise|anti-?clockwise|cartesian|mathematical|trigonometric|from east", re.I)
_DESCRIBING = ("standard_name", "long_name", "description", "comment", "convention", "direction_convention",
               "direction", "reference", "positive")  # fmt: skip
_ANGLES = {"rad": "rad", "radian": "rad", "radians": "rad", "deg": "deg", "degr": "deg", "degree": "deg",
           "degrees": "deg", "°": "deg"}  # fmt: skip
_FACTORS = {"m": ("m", 1.0), "meter": ("m", 1.0), "metre": ("m", 1.0), "cm": ("m", 1e-2), "mm": ("m", 1e-3),
            "j": ("j", 1.0), "joule": ("j", 1.0), "kj": ("j", 1e3), "hz": ("hz", 1.0), "hertz": ("hz", 1.0),
            "s": ("s", 1.0), "sec": ("s", 1.0), "second": ("s", 1.0)}  # fmt: skip
_FULL_CIRCLE = 2.0 * math.pi + 0.01


@dataclass(frozen=True)
class DensityUnit:
    """What a density is counted in: `factor` makes it m²/(Hz·degree), of an action density times 2πf [rad/s]."""

    factor: float
    action: bool = False


def density_unit(declared: str, called: str, omega: bool = False, action: bool = False) -> DensityUnit:
    """By the words of a unit. omega: the file counts frequencies in rad/s; action: the density is called one of action.

    Raises InputError for what is no directional density, and where per Hz and per rad/s cannot be told apart.
    """
    powers, factor = _parsed(declared)
    angles = {each: powers.pop(each, 0) for each in ("rad", "deg")}
    lengths, energy = powers.pop("m", 0), powers.pop("j", 0)
    seconds = powers.pop("s", 0) - powers.pop("hz", 0)
    action = action or seconds == 2
    if (energy, lengths) == (1, -2):
        factor /= WATER_DENSITY * GRAVITY
    elif (energy, lengths) != (0, 2):
        raise _no_density(declared, called)
    count = -sum(angles.values())
    wrong = max(angles.values()) > 0 or angles["deg"] < -1 or count not in (1, 2)
    if powers or seconds != 1 + action or wrong:
        raise _no_density(declared, called)
    direction, per_omega = ("deg" if angles["deg"] else "rad"), count == 2
    if omega and not per_omega and not re.search(r"h(z|ertz)", declared, re.I):
        raise InputError(
            f"{called}: is in '{declared}' over frequencies in rad/s: per Hz or per rad/s is not told; write m2/Hz/rad "
            "or m2/(rad/s)/rad, or give frequencies in Hz"
        )
    factor *= math.pi / 180.0 if direction == "rad" else 1.0
    return DensityUnit(factor * (2.0 * math.pi if per_omega else 1.0), action)


def _no_density(declared: str, called: str) -> InputError:
    return InputError(
        f"{called}: is in '{declared}': must be a variance per frequency and direction, such as m2/Hz/degree or "
        "m2 s rad-1; convert it"
    )


def _parsed(declared: str) -> tuple[dict[str, int], float]:
    """Powers of m, j, s, hz, rad, deg and of what is not known, and the factor that these units leave."""
    text = declared.lower().replace("**", "^").replace("²", "^2").translate(str.maketrans("{}·*.", "     "))
    powers, factor, sign, after = dict[str, int](), 1.0, 1, [1]
    for token in re.findall(r"[()/]|[a-zµ°]+\s*\^?\s*-?\d*", text):
        if token == "(":
            after.append(after[-1] * sign)
            sign = 1
        elif token == ")":
            after = after[:-1] or [1]
        elif token == "/":
            sign = -1
        else:
            name, power = re.fullmatch(r"([a-zµ°]+)\s*\^?\s*(-?\d*)", token).groups()  # type: ignore[union-attr]
            times = after[-1] * sign * int(power if power not in ("", "-") else 1)
            base, scale = (_ANGLES[name], 1.0) if name in _ANGLES else _FACTORS.get(name, (name, 1.0))
            powers[base] = powers.get(base, 0) + times
            factor *= scale**times
            sign = 1
    return {name: power for name, power in powers.items() if power}, factor


def words_of(attributes: Mapping[str, Any]) -> str:
    """What attributes say in words of which way directions point."""
    told = {str(name).lower(): plain_attribute(value) for name, value in attributes.items()}
    return "; ".join(str(told[name]) for name in _DESCRIBING if name in told)


def from_degrees(
    direction: NDArray[np.float64], attributes: Mapping[str, Any], called: str, otherwise: Sense = "from"
) -> NDArray[np.float64]:
    """Directions (d,) as degrees clockwise from north where waves come from, by their coordinate's attributes;
    otherwise: what a file of this kind means where it says nothing. Raises InputError for what cannot be told."""
    unit = plain_attribute(attributes.get("units"))
    if unit is None and direction.size > 2 and np.ptp(direction) > 4.0 and np.abs(direction).max() <= _FULL_CIRCLE:
        raise InputError(
            f"{called}: has no unit and ends at {direction.max():.3g}; declare degree or radian as its units"
        )
    degrees = to_unit(direction, None if unit is None else re.sub(r"[\s_]*(true|t)$", "", str(unit)), "degree", called)
    words = words_of(attributes)
    apart = _ORIGIN.sub("", _CARTESIAN.sub("", words))  # "clockwise from north" tells no sense
    to, coming = _TO.search(apart), _FROM.search(apart)
    name = str(plain_attribute(attributes.get("standard_name", "")))
    if to and coming and not re.search(r"(to|from)_direction", name):
        raise InputError(f"{called}: is described as '{words}', both where waves come from and go to; keep one of them")
    sense: Sense = otherwise
    if to or coming:
        sense = "to" if to and not name.endswith("from_direction") else "from"
    if _CARTESIAN.search(words):
        degrees = 90.0 - degrees
        sense = sense if to or coming else "to"
    return degrees + (180.0 if sense == "to" else 0.0)


def spectrum_as_declared(
    density: xr.DataArray, called: str, sense: Sense = "from", unit: str | None = None
) -> xr.DataArray:
    """A density (…, freq, dir) in Hz, degrees where waves come from, and m²/(Hz·degree), by its attributes and those of
    its coordinates. sense, unit: of a file of this kind that says nothing. Raises InputError."""
    if not {"freq", "dir"} <= set(density.dims):
        return density  # whoever asks for directions says that there are none
    frequency, direction = density["freq"], density["dir"]
    told = plain_attribute(frequency.attrs.get("units"))
    per_second = str(told).replace(" ", "").lower() in ("s-1", "1/s", "s^-1", "s**-1")  # CF's word for Hz
    hertz = to_unit(frequency.to_numpy(), "hz" if per_second else told, "hz", f"{called}: frequency")
    omega = told is not None and "rad" in str(told).lower()
    attributes = {**direction.attrs}
    for each in ("direction_convention", "convention"):
        attributes.setdefault(each, density.attrs.get(each, ""))
    degrees = from_degrees(direction.to_numpy().astype(np.float64), attributes, f"{called}: direction", sense)
    declared = plain_attribute(density.attrs.get("units", unit))
    if "significant_height" in str(plain_attribute(density.attrs.get("standard_name", ""))):
        declared = unit  # wavespectra 4.9 leaves the words of a height on spectra that it constructs
    factor, action = 1.0, "action" in words_of(density.attrs).lower()
    if declared is not None and str(declared).strip():
        found = density_unit(str(declared), f"{called}: density", omega, action)
        factor, action = found.factor, found.action
    elif omega or action:
        raise InputError(
            f"{called}: density: has no unit, with frequencies in '{told}'; declare one, such as m2/Hz/degree"
        )
    result = density.assign_coords(freq=hertz, dir=degrees) * factor
    if action:  # E = 2πf N
        result = result * (2.0 * np.pi * result["freq"])
    return result
