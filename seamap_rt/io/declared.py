"""What a variable's attributes say of its numbers: their packing, what is missing, their time and unit (CF's rules)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.conventions import decode_cf_variable

from ..errors import InputError
from .plain_json import plain_attribute
from .units import to_unit

_PACKING = ("scale_factor", "add_offset", "_Unsigned")
_FILLS = ("_FillValue", "missing_value")


def plain_attributes(values: xr.Dataset) -> xr.Dataset:
    """A dataset whose attributes, and those of its variables, are plain."""
    for each in (values, *values.variables.values()):
        each.attrs = {name: plain_attribute(value) for name, value in each.attrs.items()}
    return values


def decoded(values: NDArray, attributes: Mapping[str, Any], name: str) -> NDArray:
    """Numbers of an array by its attributes: packing is undone, dates are dates, what is missing is NaN, and of
    whole numbers that are not packed masked. Without such attributes the array itself. Raises InputError for what
    cannot be obeyed."""
    told = {key: plain_attribute(attributes[key]) for key in (*_PACKING, *_FILLS) if key in attributes}
    for key, value in told.items():
        if np.size(value) != 1 or (key != "_Unsigned" and np.asarray(value).dtype.kind not in "iufb"):
            raise InputError(f"{name}: {key} = {value!r}: must be a number; correct the attribute")
    unit = plain_attribute(attributes.get("units"))
    dates = isinstance(unit, str) and " since " in unit
    if not told and not dates:
        return values
    if values.dtype.kind == "c" and not dates:
        real, imaginary = (decoded(part, attributes, name) for part in (np.real(values), np.imag(values)))
        return real + 1j * imaginary
    if values.dtype.names and not dates:
        parts = {key: np.ma.asarray(decoded(values[key], attributes, name), np.float64) for key in values.dtype.names}
        pair = np.empty(values.shape, [(key, np.float64) for key in parts])
        for key, part in parts.items():
            pair[key] = part.filled(np.nan)
        return pair
    if values.dtype.kind not in "iuf":
        raise InputError(f"{name}: has {', '.join(told) or unit} and no plain numbers; save it as numbers")
    if not dates and not any(key in told for key in _PACKING) and values.dtype.kind in "iu":
        missing = np.isin(values, [told[key] for key in _FILLS if key in told])
        return np.ma.masked_array(values, missing) if missing.any() else values
    if dates:
        told |= {"units": unit, "calendar": plain_attribute(attributes.get("calendar", "standard"))}
    dims = tuple(f"axis_{n}" for n in range(values.ndim))
    try:
        result = decode_cf_variable(name, xr.Variable(dims, values, told)).to_numpy()
    except (ValueError, TypeError, OverflowError) as error:
        raise InputError(f"{name}: its attributes cannot be obeyed ({error}); correct them") from None
    if dates and result.dtype.kind != "M":
        raise InputError(f"{name}: is in '{unit}' of a calendar without real dates; give dates of the standard one")
    return result


def in_unit(values: NDArray, attributes: Mapping[str, Any], unit: str, name: str) -> NDArray:
    """Decoded numbers in a unit, converted from the one that their attributes tell; dates stay dates."""
    declared = plain_attribute(attributes.get("units"))
    if values.dtype.kind in "mM" or declared is None:
        return values
    return to_unit(values, declared, unit, name)


def within_valid_range(values: NDArray, attributes: Mapping[str, Any], packing: Mapping[str, Any]) -> NDArray:
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
