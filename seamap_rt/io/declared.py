"""What a variable's attributes say of its numbers: their packing, what is missing, their time and unit (CF's rules)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..errors import InputError
from .units import to_unit

_PACKING = ("scale_factor", "add_offset", "_Unsigned")
_FILLS = ("_FillValue", "missing_value")
_LIMITS = ("valid_min", "valid_max", "valid_range")


def plain_attribute(value: Any) -> Any:
    """A value as it was meant: arrays and lists of one entry, which HDF5 and JSON make of it, and bytes."""
    while isinstance(value, np.ndarray | list | tuple) and np.size(value) == 1 and np.ndim(value) > 0:
        value = value[0]
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist() if value.dtype.kind != "V" else value
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def plain_attributes(values: xr.Dataset) -> xr.Dataset:
    """A dataset whose attributes, and those of its variables, are plain."""
    for each in (values, *values.variables.values()):
        each.attrs = {name: plain_attribute(value) for name, value in each.attrs.items()}
    return values


def decoded(values: NDArray, attributes: Mapping[str, Any], name: str) -> NDArray:
    """Numbers of an array by its attributes: packing is undone, dates are dates, what is missing is NaN, and of
    whole numbers that are not packed masked. Without such attributes the array itself. Raises InputError for what
    cannot be obeyed."""
    told = {key: plain_attribute(attributes[key]) for key in (*_PACKING, *_FILLS, *_LIMITS) if key in attributes}
    for key, value in told.items():
        sizes = (2,) if key == "valid_range" else (1,)
        right = np.size(value) in sizes and (key == "_Unsigned" or np.asarray(value).dtype.kind in "iufb")
        if not right:
            raise InputError(f"{name}: {key} = {value!r}: must be a number; correct the attribute")
    unit = plain_attribute(attributes.get("units"))
    dates = isinstance(unit, str) and " since " in unit
    if not told and not dates:
        return values
    if values.dtype.kind == "c" and not dates:
        real, imaginary = (decoded(part, attributes, name) for part in (values.real, values.imag))
        return real + 1j * imaginary
    if values.dtype.names and not dates:
        parts = {key: np.ma.asarray(decoded(values[key], attributes, name), np.float64) for key in values.dtype.names}
        pair = np.empty(values.shape, [(key, np.float64) for key in parts])
        for key, part in parts.items():
            pair[key] = part.filled(np.nan)
        return pair
    if values.dtype.kind not in "iuf":
        raise InputError(f"{name}: has {', '.join(told) or unit} and no plain numbers; save it as numbers")
    missing = outside(values, *valid_limits(told))
    if not dates and not any(key in told for key in _PACKING) and values.dtype.kind in "iu":
        for key in _FILLS:
            if key in told:
                missing |= values == told[key]
        return np.ma.masked_array(values, missing) if missing.any() else values
    given = {key: value for key, value in told.items() if key not in _LIMITS}
    if dates:
        given |= {"units": unit, "calendar": plain_attribute(attributes.get("calendar", "standard"))}
    dims = tuple(f"axis_{n}" for n in range(values.ndim))
    try:
        result = xr.conventions.decode_cf_variable(name, xr.Variable(dims, values, given)).to_numpy()
    except (ValueError, TypeError, OverflowError) as error:
        raise InputError(f"{name}: its attributes cannot be obeyed ({error}); correct them") from None
    if dates and result.dtype.kind != "M":
        raise InputError(f"{name}: is in '{unit}' of a calendar without real dates; give dates of the standard one")
    if missing.any():
        result[missing] = np.datetime64("NaT") if dates else np.nan
    return result


def valid_limits(attributes: Mapping[str, Any]) -> tuple[Any, Any]:
    """The least and the most that is valid of numbers as they are stored; None where there is none."""
    low, high = attributes.get("valid_range", (attributes.get("valid_min"), attributes.get("valid_max")))
    return low, high


def outside(values: NDArray, low: Any, high: Any) -> NDArray[np.bool_]:
    """Which numbers are not valid."""
    beyond = np.zeros(values.shape, dtype=bool)
    if low is not None:
        beyond |= values < low
    return beyond if high is None else beyond | (values > high)


def in_unit(values: NDArray, attributes: Mapping[str, Any], unit: str, name: str) -> NDArray:
    """Decoded numbers in a unit, converted from the one that their attributes tell; dates stay dates."""
    declared = plain_attribute(attributes.get("units"))
    if values.dtype.kind in "mM" or declared is None:
        return values
    return to_unit(values, declared, unit, name)
