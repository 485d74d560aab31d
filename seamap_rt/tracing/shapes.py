"""Mitsuba on the chosen backend, and a trimesh as Mitsuba holds it."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from numpy.typing import NDArray
from trimesh import Trimesh

from ..compute.backend import prepare


def mitsuba() -> Any:
    """Mitsuba on the backend. Late, and untyped: what it holds depends on the backend's variant."""
    backend, mi = prepare(), importlib.import_module("mitsuba")
    if mi.variant() is None:
        mi.set_variant(backend.variant)
    return mi


def mitsuba_mesh(name: str, surface: Trimesh) -> Any:
    """The surface as a Mitsuba mesh: float32 vertices, uint32 faces, no normals of its own."""
    mi = mitsuba()
    count = len(surface.vertices), len(surface.faces)
    shape = mi.Mesh(name, *count, has_vertex_normals=False, has_vertex_texcoords=False)
    parameters = mi.traverse(shape)
    set_triangles(parameters, "", surface)
    parameters.update()
    return shape


def set_triangles(parameters: Any, prefix: str, surface: Trimesh) -> None:
    """Write the surface into Mitsuba's parameters under a prefix. The caller calls `parameters.update()`."""
    mi = mitsuba()
    parameters[f"{prefix}vertex_positions"] = flat(mi.Float, surface.vertices, np.float32)
    parameters[f"{prefix}faces"] = flat(mi.UInt32, surface.faces, np.uint32)


def flat(kind: Any, values: NDArray[Any], dtype: Any = np.float32) -> Any:
    """Values (any shape) as one flat Dr.Jit array of a type."""
    return copied(kind, np.ascontiguousarray(values, dtype=dtype).ravel())


def copied(kind: Any, values: NDArray[Any]) -> Any:
    """Values (n,) as an array of a type of Dr.Jit's, in memory of its own.

    On LLVM it would share NumPy's memory otherwise: be changed with it, or freed while a kernel still runs, and be read
    beyond its end, for kernels take whole packets of lanes, which Dr.Jit's own memory has room for.
    """
    dr = importlib.import_module("drjit")
    if dr.backend_v(kind) != dr.JitBackend.LLVM or not values.size:
        return kind(values)
    made = dr.empty(kind, values.size)
    np.array(made, copy=False)[...] = values
    return made
