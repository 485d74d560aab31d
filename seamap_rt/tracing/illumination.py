"""The facets of a turn with the light that reaches them: what every tracer gives; and a trimesh as Mitsuba holds it."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..compute.backend import prepare
from ..mesh import Facets

if TYPE_CHECKING:
    from trimesh import Trimesh


def mitsuba() -> Any:
    """Mitsuba on the backend. Late, and untyped: what it holds depends on the backend's variant."""
    backend, mi = prepare(), importlib.import_module("mitsuba")
    if mi.variant() is None:
        mi.set_variant(backend.variant)
    return mi


def mitsuba_mesh(name: str, surface: Trimesh, normals: NDArray[Any] | None = None) -> Any:
    """The surface as a Mitsuba mesh: float32 vertices, uint32 faces, and flat ones unless its vertices have normals.

    Mitsuba 3.10 takes tensors (n, 3) at once, earlier ones flat arrays into a mesh of so many vertices and faces.
    """
    mi = mitsuba()
    if hasattr(mi.Mesh, "from_fields"):  # 3.10
        shading = {"face_normals": True} if normals is None else {"normals": _rows(mi.TensorXf, mi.Float, normals)}
        positions = _rows(mi.TensorXf, mi.Float, surface.vertices)
        return mi.Mesh(name, faces=_rows(mi.TensorXu, mi.UInt32, surface.faces), positions=positions, **shading)
    shape = mi.Mesh(name, len(surface.vertices), len(surface.faces), has_vertex_normals=normals is not None)
    parameters = mi.traverse(shape)
    set_triangles(parameters, "", surface)
    parameters.update()
    if normals is not None:  # later: 3.7 makes its own of positions that are new
        parameters["vertex_normals"] = flat(mi.Float, normals)
        parameters.update()
    return shape


def set_triangles(parameters: Any, prefix: str, surface: Trimesh) -> None:
    """Write the surface into Mitsuba's parameters under a prefix. The caller calls `parameters.update()`."""
    mi = mitsuba()
    if f"{prefix}positions" in parameters:  # 3.10
        parameters[f"{prefix}positions"] = _rows(mi.TensorXf, mi.Float, surface.vertices)
        parameters[f"{prefix}faces"] = _rows(mi.TensorXu, mi.UInt32, surface.faces)
    else:
        parameters[f"{prefix}vertex_positions"] = flat(mi.Float, surface.vertices)
        parameters[f"{prefix}faces"] = flat(mi.UInt32, surface.faces, np.uint32)


def _rows(tensor: Any, kind: Any, values: NDArray[Any]) -> Any:
    """Values (n, 3) as a Dr.Jit tensor of that shape."""
    dtype = np.uint32 if values.dtype.kind in "iu" else np.float32
    return tensor(flat(kind, values, dtype), values.shape)


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


_LIGHT = ("lit", "field", "ray_slope", "in_sight", "facing_in_sight")


@dataclass(frozen=True)
class Illumination(Facets):
    """Facets, and which of them each antenna lights. Plain arrays, free of Mitsuba's.

    Light is geometric, or bends over the edges of shadows: then `field` and `ray_slope` are there, `lit` stays
    geometric, and what reaches a facet is the field alone. Where waves that the mesh does not carry cast shadows
    (`unresolved_waves`), a facet that is reached is in sight in part.
    """

    lit: NDArray[np.bool_]  # (antenna, column, facet)
    rays: int = 0  # that were traced to find it
    field: NDArray[np.complex64] | None = None  # (antenna, column, facet) over that of free space, one way
    ray_slope: NDArray[np.float32] | None = None  # (column, facet) tan of the angle by which the arriving ray falls
    in_sight: NDArray[np.float32] | None = None  # (column, facet) share of its water; None: all of it
    facing_in_sight: NDArray[np.float32] | None = None  # (column, facet) of those parts of it that face the ray

    @classmethod
    def of(cls, facets: Facets, lit: NDArray[np.bool_], rays: int = 0) -> Illumination:
        """Facets with geometric light (antenna, column, facet)."""
        return cls(**{each.name: getattr(facets, each.name) for each in fields(Facets)}, lit=lit, rays=rays)

    @property
    def light(self) -> dict[str, NDArray[Any] | None]:
        """Its own arrays, (antenna, column, facet) or (column, facet), beside those of the facets."""
        return {name: getattr(self, name) for name in _LIGHT}

    def part(self, columns: slice) -> Illumination:
        """Neighbouring columns alone. The rays that were traced for all count with the first."""
        if columns == slice(0, self.grid.columns):
            return self
        own = {name: None if each is None else each[..., columns, :] for name, each in self.light.items()}
        return replace(super().part(columns), **own, rays=0 if columns.start else self.rays)

    def with_facets(self, facets: Facets) -> Illumination:
        """The same light on facets of the same mesh with other heights and slopes."""
        return replace(self, **{each.name: getattr(facets, each.name) for each in fields(Facets)})

    @property
    def visible_to_both(self) -> NDArray[np.bool_]:
        """(column, facet): lit for both antennas, and for all if there are more."""
        return np.asarray(self.lit.all(axis=0))

    @property
    def reached(self) -> NDArray[np.bool_]:
        """(antenna, column, facet): a ray arrives, straight or over an edge."""
        return self.lit if self.field is None else self.field != 0.0

    def without(self, dark: NDArray[np.bool_]) -> Illumination:
        """The same without light where `dark`, which broadcasts to (antenna, column, facet)."""
        field = None if self.field is None else np.where(dark, np.complex64(0.0), self.field)
        return replace(self, lit=self.lit & ~dark, field=field)
