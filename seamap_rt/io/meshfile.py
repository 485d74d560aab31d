"""The shape of an object from a mesh file, read by the library trimesh, or here where faces may be polygons.

In STL, OBJ and PLY files, which say nothing of it, z is up and y ahead. glTF (GLB) has axes of its own, y up and z
ahead (Khronos glTF 2.0, section 3.4), and is turned; Collada tells its axes and its unit, which are obeyed. Whatever is
wrong with a file becomes an InputError of one line.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.exchange.ply import load_ply

from ..compute.machine import free_memory
from ..errors import InputError, say_of
from ..settings import ObjectSettings
from .mesh_scenes import FileResolver, check_gltf, read_collada
from .opening import LONG, read_bytes
from .process import suppress_complaints, suppress_log

ENDINGS = (".stl", ".glb", ".gltf", ".obj", ".ply", ".dae")
Polygons = tuple[NDArray[np.float64], Any]  # vertices (n, 3), and rows of their places
MOST_TRIANGLES = 2_000_000
_MOST_TAKEN = 100  # times its own bytes, that a whole file takes of memory
MOST_EXTENT_M = 30_000.0  # a file in millimetres whose scale was forgotten
_FROM_GLTF = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])  # rows: right, ahead, up of its x, y, z


def load_mesh(settings: ObjectSettings, number: int = 0) -> trimesh.Trimesh:
    """The object in its own frame: x to the right, y ahead, z up [m], `scale` applied, where the file puts it.

    All parts of a file become one mesh; equal vertices are joined, so that a closed surface is known to be closed, and
    triangles without area are dropped. `number` is the object's, for the messages.

    Raises InputError for a file that is missing, of another kind or damaged, without triangles or with more than
    `MOST_TRIANGLES`, with vertices that are not finite, and for an object larger than `MOST_EXTENT_M`.
    """
    what = f"objects.{number}.mesh = '{settings.mesh}'"
    ending = os.path.splitext(settings.mesh)[1].lower()
    if ending not in ENDINGS:
        raise InputError(f"{what}: must be a file of the kinds {', '.join(ENDINGS)}; export the mesh as one of them")
    content = read_bytes(settings.mesh, "a mesh", named=what, most=LONG)
    with say_of(f"{what}: ", InputError):
        return _mesh(content, settings, ending, number)


def _mesh(content: bytes, settings: ObjectSettings, ending: str, number: int) -> trimesh.Trimesh:
    vertices, faces = _read(content, Path(settings.mesh), ending)
    if len(faces) == 0:
        raise InputError("is damaged, or holds no triangles; give a surface, not points or lines")
    if len(faces) > MOST_TRIANGLES:
        raise InputError(f"holds {len(faces)} triangles: must be at most {MOST_TRIANGLES}; decimate the mesh")
    with np.errstate(over="ignore", invalid="ignore"):
        used, places = np.unique(faces, return_inverse=True)  # vertices of no triangle do not count
        vertices, faces = vertices[used] * settings.scale, places.reshape(faces.shape)
        extent = float(np.max(np.ptp(vertices, axis=0)))
    if not np.isfinite(vertices).all():
        raise InputError("has vertices that are not finite; mend or export the mesh anew")
    if extent > MOST_EXTENT_M:
        raise InputError(
            f"is {extent:.3g} m long: must be at most {MOST_EXTENT_M:g} m; set objects.{number}.scale, "
            "0.001 for a file in millimetres"
        )
    if ending in (".glb", ".gltf"):
        vertices = vertices @ _FROM_GLTF.T
    mesh = trimesh.Trimesh(vertices=vertices, faces=faces, process=False, validate=False)
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    solid = mesh.area_faces > 1e-12 * extent**2
    if not solid.any():
        raise InputError("all its triangles are without area; give a surface")
    mesh.update_faces(solid)
    mesh.remove_unreferenced_vertices()
    return mesh


def _read(content: bytes, path: Path, ending: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices (n, 3) and triangles (m, 3) of all parts of a file, each where the file's own scene puts it."""
    try:
        with suppress_complaints(), suppress_log("trimesh"):  # of materials and numbers: what matters is checked after
            vertices, faces = _READERS[ending](content, path)
            vertices = np.asarray(vertices, dtype=np.float64)
            return vertices, triangles_of(vertices, faces)
    except InputError:
        raise
    except MemoryError:
        if free_memory() < _MOST_TAKEN * len(content):
            raise
        damage = "it promises more than it holds"
    except Exception as error:  # the parsers raise exceptions of many types
        damage = f"{type(error).__name__}: {error}"[:120]
    raise InputError(f"is damaged, or not what its ending says ({damage}); export the mesh anew")


def _read_by_trimesh(content: bytes, ending: str, resolver: Any = None) -> Polygons:
    loaded = trimesh.load_scene(io.BytesIO(content), ending, resolver=resolver, process=False, skip_materials=True)
    mesh = loaded.to_mesh()
    return mesh.vertices, mesh.faces


def _read_obj(content: bytes, _: Path) -> Polygons:
    """Vertices and faces alone. Relative numbers count back from the last vertex before the face."""
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    triangles = 0
    for line in content.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").splitlines():
        match line.partition(b"#")[0].split():
            case [b"v" | b"f", *words] if any(b"_" in each for each in words):
                raise ValueError(f"a line has what is no number: {line[:40]!r}")
            case [b"v", x, y, z, *_]:
                vertices.append([float(x), float(y), float(z)])
            case [b"f", _, _, _, *_] as words:
                numbers = [int(each.partition(b"/")[0]) for each in words[1:]]
                faces.append([each - 1 if each > 0 else each + len(vertices) if each else -1 for each in numbers])
                triangles += len(numbers) - 2
            case [b"v" | b"f", *_]:
                raise ValueError(f"a line has fewer than three numbers: {line[:40]!r}")
        if max(triangles, len(vertices) // 3) > MOST_TRIANGLES:
            raise InputError(f"holds more than {MOST_TRIANGLES} triangles; decimate the mesh")
    return np.array(vertices).reshape(-1, 3), faces


def _read_ply(content: bytes, _: Path) -> Polygons:
    """Faces as the file has them, whatever their corners. What is not UTF-8 in its text is a name or a remark."""
    end = content.find(b"end_header")
    end = end if end >= 0 and b"format ascii" not in content[:end] else len(content)
    try:
        loaded = load_ply(io.BytesIO(_recode_to_utf8(content, end)), fix_texture=False, skip_materials=True)
    except ValueError as error:
        if "unexpected length" not in str(error):
            raise
        raise InputError(
            "is damaged, or its faces, in binary, have unlike numbers of corners; save it as text, or triangles alone"
        ) from None
    raw = loaded["metadata"]["_ply_raw"]
    vertices = np.stack([np.ravel(raw["vertex"]["data"][axis]) for axis in "xyz"], axis=-1)
    held: Any = raw["face"]["data"] if raw.get("face", {}).get("length") else np.empty((0, 3), dtype=np.int64)
    if isinstance(held, np.ndarray) and held.dtype.names is None:
        return vertices, held
    names = list(held) if isinstance(held, dict) else list(held.dtype.names)
    faces = held[next((name for name in names if name in ("vertex_index", "vertex_indices")), names[0])]
    return vertices, faces["f1"] if getattr(faces, "dtype", np.dtype(float)).names else faces


def _read_stl(content: bytes, _: Path) -> Polygons:
    """Binary STL says in bytes 80 to 83 how many triangles of 50 bytes follow, and may begin with `solid` as well."""
    binary = len(content) == 84 + 50 * int.from_bytes(content[80:84], "little")
    if not binary and content.lstrip(b"\xef\xbb\xbf \t\r\n")[:5].lower() != b"solid":
        raise ValueError("neither text that begins with solid, nor as long as its triangles")
    return _read_by_trimesh(content if binary else _recode_to_utf8(content, len(content)), "stl")


def _recode_to_utf8(content: bytes, end: int) -> bytes:
    """Text up to `end` that is not UTF-8 is taken as Latin-1, which has a letter for each byte: only names and remarks
    hold such ones, and to guess the encoding, as trimesh does, could swallow a digit beside them."""
    try:
        content[:end].decode("utf-8")
    except UnicodeDecodeError:
        return content[:end].decode("latin-1").encode("utf-8") + content[end:]
    return content


def _read_gltf(content: bytes, path: Path) -> Polygons:
    beside = FileResolver(path.parent)
    check_gltf(content, beside)
    return _read_by_trimesh(content, path.suffix[1:].lower(), beside)


_READERS: dict[str, Callable[[bytes, Path], Polygons]] = {
    ".stl": _read_stl, ".glb": _read_gltf, ".gltf": _read_gltf, ".obj": _read_obj, ".ply": _read_ply,
    ".dae": lambda content, _: read_collada(content, 6 * MOST_TRIANGLES),
}  # fmt: skip


_MOST_WORK = 1_000_000  # squares of the corners, of polygons that are not convex: some seconds


def triangles_of(vertices: NDArray[np.float64], polygons: Any) -> NDArray[np.int64]:
    """Corners (m, 3) of the triangles that polygons have, in their order. vertices: (n, 3).

    polygons: rows of places in `vertices`, three or more each. A polygon may lie anyhow in space and turn either way;
    its triangles turn the same way. Raises ValueError for a corner that is not there, and for too many
    polygons that are not convex.
    """
    lengths = np.array([len(each) for each in polygons], dtype=np.int64)
    ends = np.cumsum(np.maximum(lengths - 2, 0))
    found = np.empty((int(ends[-1]) if ends.size else 0, 3), dtype=np.int64)
    work = 0
    for count in np.unique(lengths[lengths > 2]):
        which = np.flatnonzero(lengths == count)
        corners = np.array([polygons[each] for each in which], dtype=np.int64)
        if corners.min() < 0 or corners.max() >= len(vertices):
            raise ValueError("a face has a corner that is not there")
        fan = np.stack([np.zeros(count - 2, dtype=np.int64), np.arange(1, count - 1), np.arange(2, count)], axis=-1)
        made = corners[:, fan]
        if count > 3:
            plane, convex = _project_to_planes(vertices[corners])
            work += count**2 * np.count_nonzero(~convex)
            if work > _MOST_WORK:
                raise ValueError("too many corners of faces that are not convex; triangulate them")
            for each in np.flatnonzero(~convex):
                made[each] = corners[each][_clip_ears(plane[each])]
        found[(ends[which] - (count - 2))[:, None] + np.arange(count - 2)] = made
    return found


def _project_to_planes(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Polygons (n, k, 3) seen from where they turn anticlockwise, (n, k, 2), and which are convex."""
    with np.errstate(over="ignore", invalid="ignore"):
        about = corners - corners.mean(axis=1, keepdims=True)
        normal = np.cross(about, np.roll(about, -1, axis=1)).sum(axis=1)  # twice the area (Newell)
        flat = np.argmax(np.abs(normal), axis=1)
        axes = np.stack(((flat + 1) % 3, (flat + 2) % 3), axis=-1)
        plane = np.take_along_axis(about, axes[:, None, :], axis=2)
        mirrored = np.take_along_axis(normal, flat[:, None], axis=1)[:, 0] < 0.0
        plane[mirrored] = plane[mirrored][..., ::-1]
        sides = np.roll(plane, -1, axis=1) - plane
        after = np.roll(sides, -1, axis=1)
        turn = sides[..., 0] * after[..., 1] - sides[..., 1] * after[..., 0]
        return plane, ~(turn < -1e-9 * np.abs(turn).max(axis=1, keepdims=True)).any(axis=1)


def _clip_ears(place: NDArray[np.float64]) -> NDArray[np.int64]:
    """Triangles (k − 2, 3) of a polygon (k, 2) that turns anticlockwise. One that crosses itself has as many."""
    left, found, at, tried = list(range(len(place))), [], 0, 0
    least = 1e-12 * float(np.ptp(place, axis=0).max()) ** 2  # corners on one line, but for rounding, are no ear
    while len(left) > 2:
        a, b, c = (left[(at + step) % len(left)] for step in range(3))
        one, two = place[b] - place[a], place[c] - place[b]
        ear = _cross(one, two) > least and not np.any(
            (_cross(one, (others := place[left]) - place[a]) > 0.0)
            & (_cross(two, others - place[b]) > 0.0)
            & (_cross(one + two, others - place[a]) < 0.0)
        )
        if ear or tried >= len(left):  # none is left: of a line, or of a polygon that crosses itself
            found.append((a, b, c))
            del left[(at + 1) % len(left)]
            tried = 0
        else:
            at, tried = at + 1, tried + 1
    return np.array(found, dtype=np.int64)


def _cross(one: Any, two: Any) -> Any:
    """Of vectors (…, 2). Of one with itself it is exactly 0: a corner does not lie in a triangle of it."""
    return one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]
