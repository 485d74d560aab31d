"""What a file's words say of a directional spectrum: its units, and which way its directions point.

All is converted here to Hz, degrees clockwise from north where waves come from, and m²/(Hz·degree). In the units of a
spectral density the second stands for 1/Hz: m2 s rad-1 is per Hz and radian, as WAVEWATCH III and ERA5 write it; per
rad/s it is where the unit has radians twice, or radians and degrees.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import GRAVITY, WATER_DENSITY
from ..errors import InputError
from .declared import within_valid_range
from .plain_json import plain_attribute
from .units import parsed, to_unit

Sense = Literal["from", "to"]

_TO = re.compile(
    r"to_direction|\b(going|propagat\w+|travel\w*|heading)\b|\btowards?\b|\bto which\b|oceanographic", re.I
)
_FROM = re.compile(r"from_direction|\b(coming )?from\b|nautical|meteorological", re.I)
_ORIGIN = re.compile(r"\bfrom (the |true |geographic )*(north|east|x)\b", re.I)
_CARTESIAN = re.compile(r"counter-?\s?clockwise|anti-?clockwise|cartesian|mathematical|trigonometric", re.I)
_EAST, _NORTH = (re.compile(rf"\bfrom (the |true |geographic )*({each})\b", re.I) for each in ("east|x", "north"))
_DESCRIBING = ("standard_name", "long_name", "description", "comment", "convention", "direction_convention",
               "direction", "reference", "positive")  # fmt: skip
_OF_DIRECTIONS = re.compile(r"[^.;,]*\b(directions?|going to|coming from|oceanographic|nautical)\b[^.;,]*", re.I)
_NO_FREQUENCY = re.compile(r"angular|circular|\brad\b|radian|omega|sigma|period", re.I)
_ANGLE_AND_WORDS = re.compile(r"((?:deg(?:r|rees?)?|rad(?:ians?)?|[°º])(?:_true)?)(?:T$|[\s_,(]+(.+?)\)?$)", re.I)
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
    size, powers = parsed(declared) or (0.0, {})
    length, seconds, mass, angles = (powers.get(each, 0) for each in ("length", "time", "mass", "angle"))
    if (mass, length) == (1, 0):  # an energy, kg/s² = J/m²
        size, seconds, length = size / (WATER_DENSITY * GRAVITY), seconds + 2, 2
        mass = 0
    action = action or seconds == 2
    twice = re.search(r"deg\w*\s*\^?\s*\{?-2", declared.replace("**", "^"), re.I)  # no frequency is in degrees
    if not size or mass or length != 2 or seconds != 1 + action or angles not in (-1, -2) or twice:
        raise InputError(
            f"{called}: is in '{declared}': must be a variance per frequency and direction, such as m2/Hz/degree or "
            "m2 s rad-1; convert it"
        )
    per_omega = angles == -2
    if omega and not per_omega and not re.search(r"h(z|ertz)", declared, re.I):
        raise InputError(
            f"{called}: is in '{declared}' over frequencies in rad/s: per Hz or per rad/s is not told; write m2/Hz/rad "
            "or m2/(rad/s)/rad, or give frequencies in Hz"
        )
    return DensityUnit(size * math.pi / 180.0 * (2.0 * math.pi if per_omega else 1.0), action)


def words_of(attributes: Mapping[str, Any]) -> str:
    """What attributes say in words of which way directions point."""
    told = {str(name).lower(): plain_attribute(value) for name, value in attributes.items()}
    return "; ".join(str(told[name]) for name in _DESCRIBING if name in told)


def wave_from_degrees(
    direction: NDArray[np.float64],
    attributes: Mapping[str, Any],
    called: str,
    otherwise: Sense = "from",
    more: str = "",
) -> NDArray[np.float64]:
    """Directions (d,) as degrees clockwise from north where waves come from, by their coordinate's attributes;
    more: what else the file says of directions, where these say nothing; otherwise: what a file of this kind means
    where nothing does. Raises InputError for what cannot be told."""
    unit = plain_attribute(attributes.get("units"))
    if unit is None and direction.size > 2 and np.ptp(direction) > 4.0 and np.abs(direction).max() <= _FULL_CIRCLE:
        raise InputError(
            f"{called}: has no unit and ends at {direction.max():.3g}; declare degree or radian as its units"
        )
    words, written = words_of(attributes), _ANGLE_AND_WORDS.fullmatch(str(unit).strip())
    if written and written[2] and written[0].lower() not in ("degrees_north", "degrees_east"):
        unit, words = written[1], "; ".join(filter(None, (words, written[2].replace("_", " "))))
    elif written:
        unit = written[1] if written[0].endswith("T") else unit
    degrees = to_unit(direction, unit, "degree", called)
    sense = _sense(words, str(plain_attribute(attributes.get("standard_name", ""))), called)
    words = words if _turned(words) or sense else "; ".join(filter(None, (words, more)))
    if "magnetic" in words.lower():
        raise InputError(f"{called}: is described as '{words}': must count from true north; turn it by the variation")
    turned, east = _turned(words), bool(_EAST.search(words))
    if turned or east:
        degrees = (90.0 if east or not _NORTH.search(words) else 0.0) + (-degrees if turned else degrees)
    sense = sense or _sense(words, "", called) or ("to" if turned else otherwise)
    return degrees + (180.0 if sense == "to" else 0.0)


def _turned(words: str) -> bool:
    return bool(_CARTESIAN.search(words))


def _sense(words: str, name: str, called: str) -> Sense | None:
    apart = _ORIGIN.sub("", words)  # "clockwise from north" tells no sense
    to, coming = _TO.search(apart), _FROM.search(apart)
    if to and coming and not re.search(r"(to|from)_direction", name):
        raise InputError(f"{called}: is described as '{words}', both where waves come from and go to; keep one of them")
    if not (to or coming):
        return None
    return "to" if to and not name.endswith("from_direction") else "from"


def convert_spectrum(
    density: xr.DataArray,
    called: str,
    sense: Sense = "from",
    unit: str | None = None,
    said: Iterable[str] = (),
) -> xr.DataArray:
    """A density (…, freq, dir) in Hz, degrees where waves come from, and m²/(Hz·degree), by its attributes, those of
    its coordinates. What lies beyond its valid range is missing. sense, unit: of a file of this kind that says nothing;
    said: what the file says beside it. Raises InputError."""
    density = density.copy(data=within_valid_range(density.to_numpy(), density.attrs, density.encoding))
    if not {"freq", "dir"} <= set(density.dims):
        return density  # whoever asks for directions says that there are none
    hertz, told = frequencies_hz(density["freq"], called)
    omega = "rad" in told.lower()
    direction = density["dir"]
    more = "; ".join(
        chunk[0]
        for text in (*said, words_of(density.attrs))
        for chunk in _OF_DIRECTIONS.finditer(text)
        if not re.search("wind|current", chunk[0])
    )
    degrees = wave_from_degrees(
        direction.to_numpy().astype(np.float64), direction.attrs, f"{called}: direction", sense, more
    )
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


def frequencies_hz(frequency: xr.DataArray, called: str) -> tuple[NDArray[np.float64], str]:
    """Frequencies (f,) in Hz, and the unit that the file declares. Raises InputError."""
    told, words = plain_attribute(frequency.attrs.get("units")), words_of(frequency.attrs)
    if told is None and _NO_FREQUENCY.search(words):
        raise InputError(f"{called}: frequency: is described as '{words}' and has no unit; declare Hz or rad/s")
    return to_unit(frequency.to_numpy(), told, "Hz", f"{called}: frequency"), str(told)
