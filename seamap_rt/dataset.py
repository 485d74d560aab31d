"""Datasets of results: built from the table of `schema` and checked against it, so that a name means one thing
everywhere."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import SchemaError, must_be
from .schema import ECHO_ATTRIBUTES, FURTHER_ECHO_ATTRIBUTES, QUALITY_FLAGS, SCHEMA, WATER_ATTRIBUTES, Variable

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "ECHO_ATTRIBUTES", "FURTHER_ECHO_ATTRIBUTES", "QUALITY_FLAGS", "SCHEMA", "WATER_ATTRIBUTES", "Variable",
    "attributed", "build", "check", "group_of",
]  # fmt: skip


def build(
    product: str,
    values: Mapping[str, Any],
    coords: Mapping[str, Any],
    attrs: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """A dataset of `product` from plain arrays: types cast, dimensions and CF attributes from the schema.

    values, coords: name → array, with the schema's dimensions and units; attrs: attributes of the whole dataset. Raises
    SchemaError for a name that is not in the schema, a missing one, or a wrong number of dimensions.
    """
    import xarray as xr

    schema = SCHEMA[product]
    unknown = sorted((set(values) | set(coords)) - set(schema))
    if unknown:
        raise SchemaError(f"{product}: '{unknown[0]}' is not in the schema; it has {', '.join(schema)}")

    def checked(name: str, value: Any) -> tuple[tuple[str, ...], np.ndarray, dict[str, Any]]:
        variable = schema[name]
        array = np.asarray(value).astype(variable.dtype, copy=False)
        if array.ndim != len(variable.dims):
            raise SchemaError(f"{product}: '{name}' has {array.ndim} dimensions; the schema says {variable.dims}")
        attributes = variable.attributes()
        if name in ("quality", "flag"):
            attributes["flag_masks"] = np.array(list(QUALITY_FLAGS.values()), dtype=np.int16)
            attributes["flag_meanings"] = " ".join(QUALITY_FLAGS)
        return variable.dims, array, attributes

    dataset = xr.Dataset(
        {name: checked(name, value) for name, value in values.items()},
        {name: checked(name, value) for name, value in coords.items()},
        {"Conventions": "CF-1.11", **(attrs or {})},
    )
    check(product, dataset)
    return dataset


def attributed(product: str, name: str, value: Any) -> xr.DataArray:
    """One variable of `product` from a plain array: its type cast, dimensions and CF attributes from the schema."""
    import xarray as xr

    variable = SCHEMA[product][name]
    return xr.DataArray(np.asarray(value).astype(variable.dtype), dims=variable.dims, attrs=variable.attributes())


def check(product: str, dataset: xr.Dataset, needed: Collection[str] | None = None) -> None:
    """Raise SchemaError, in one line, unless `dataset` has the variables, types and attributes of `product`.

    Integers may stand where the schema has floats. needed: names of the variables that must be there, the schema's
    required ones if left out.
    """
    for name, variable in SCHEMA[product].items():
        if name not in dataset.variables:
            if variable.required if needed is None else name in needed:
                raise SchemaError(f"{product}: variable '{name}' is missing; add it, dims {variable.dims}")
            continue
        array = dataset[name]
        if array.dims != variable.dims:
            raise SchemaError(f"{product}: '{name}' has dims {array.dims}; the schema says {variable.dims}")
        kind = np.dtype(variable.dtype).kind
        if array.dtype.kind != kind and not (kind == "f" and array.dtype.kind in "iu"):
            raise SchemaError(f"{product}: '{name}' has type {array.dtype}; the schema says {variable.dtype}")
    if product == "echoes":
        for name, meaning in ECHO_ATTRIBUTES.items():
            if name not in dataset.attrs:
                raise SchemaError(f"echoes: attribute '{name}' is missing; add it ({meaning})")
        if dataset.sizes["receiver"] < 2 or dataset.sizes["antenna"] < 2 or dataset.sizes["xyz"] != 3:
            raise SchemaError("echoes: receiver and antenna must have size 2 or more, xyz size 3")


def group_of(tree: xr.DataTree, product: str, needed: Collection[str] | None = None) -> xr.Dataset:
    """The group of maps or truth that `product` names, as in maps/polar; SchemaError unless `check` passes, InputError
    for what is no tree."""
    import xarray as xr

    whole, name = product.split("/")
    source = "retrieve gives" if whole == "maps" else "simulate gives"
    must_be(whole, tree, xr.DataTree, f"a DataTree with the groups polar and ground, as {source}")
    if name not in tree.children:
        raise SchemaError(f"{whole}: the group '{name}' is missing; give the tree of a whole {whole}.nc")
    dataset = tree[name].to_dataset()
    check(product, dataset, needed)
    return dataset
