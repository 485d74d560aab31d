"""The shape of an object from a mesh file, read by the library trimesh.

In STL, OBJ and PLY files, which say nothing of it, z is up and y ahead. glTF (GLB) has axes of its own, y up and z
ahead (Khronos glTF 2.0, section 3.4), and is turned. Whatever is wrong with a file becomes an InputError of one line.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from ..errors import InputError
from ..settings import ObjectSettings
from .quiet import quietly, without_log

ENDINGS = (".stl", ".glb", ".gltf", ".obj", ".ply")
MOST_TRIANGLES = 2_000_000
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
    vertices, faces = _read(settings.mesh, what)
    if len(faces) == 0:
        raise InputError(f"{what}: is damaged, or holds no triangles; give a surface, not points or lines")
    if len(faces) > MOST_TRIANGLES:
        raise InputError(f"{what}: holds {len(faces)} triangles: must be at most {MOST_TRIANGLES}; decimate the mesh")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(f"{what}: has triangles of vertices that are not there; export the mesh anew")
    with np.errstate(over="ignore", invalid="ignore"):
        vertices = vertices * settings.scale
        used = vertices[np.unique(faces)]  # vertices of no triangle do not count
        extent = float(np.max(np.ptp(used, axis=0)))
    if not np.isfinite(used).all():
        raise InputError(f"{what}: has vertices that are not finite; mend or export the mesh anew")
    if extent > MOST_EXTENT_M:
        raise InputError(
            f"{what}: is {extent:.3g} m long: must be at most {MOST_EXTENT_M:g} m; set objects.{number}.scale, "
            "0.001 for a file in millimetres"
        )
    if ending in (".glb", ".gltf"):
        vertices = vertices @ _FROM_GLTF.T
    mesh = trimesh.Trimesh(vertices=vertices, faces=faces, process=False, validate=False)
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    solid = mesh.area_faces > 1e-12 * extent**2
    if not solid.any():
        raise InputError(f"{what}: all its triangles are without area; give a surface")
    mesh.update_faces(solid)
    mesh.remove_unreferenced_vertices()
    return mesh


def _read(path: str, what: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices (n, 3) and triangles (m, 3) of all parts of a file, each where the file's own scene puts it."""
    try:
        with open(path, "rb"):
            pass
    except FileNotFoundError:
        raise InputError(f"{what}: no such file; give the path of a mesh") from None
    except IsADirectoryError:
        raise InputError(f"{what}: is a folder, not a file; give the mesh's file in it") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{what}: cannot be read ({error}); give a readable file") from None
    try:
        with quietly(), without_log("trimesh"):  # of materials and numbers: what matters is checked after
            mesh = _loaded(path).to_mesh()
        return np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)
    except MemoryError:
        raise InputError(f"{what}: is damaged: it promises more than it holds; export it anew") from None
    except Exception as error:  # the parsers raise exceptions of many types
        damage = f"{type(error).__name__}: {error}"[:120]
    raise InputError(f"{what}: is damaged, or not what its ending says ({damage}); export the mesh anew")


def _loaded(path: str) -> trimesh.Scene:
    """What a file holds. Text that is not UTF-8 is taken as Latin-1, which has a letter for each byte: only names and
    remarks hold such ones, and to guess the encoding, as trimesh does, could swallow a digit beside them."""
    ending = os.path.splitext(path)[1].lower()
    if ending in _TEXTS:
        content = Path(path).read_bytes()
        end = _TEXTS[ending](content)
        try:
            content[:end].decode("utf-8")
        except UnicodeDecodeError:
            content = content[:end].decode("latin-1").encode("utf-8") + content[end:]
            return trimesh.load_scene(io.BytesIO(content), ending[1:], process=False, skip_materials=True)
    return trimesh.load_scene(path, process=False, skip_materials=True)


def _text_of_stl(content: bytes) -> int:
    """Binary STL says in bytes 80 to 83 how many triangles of 50 bytes follow, and may begin with `solid` as well."""
    if len(content) == 84 + 50 * int.from_bytes(content[80:84], "little"):
        return 0
    if content.lstrip(b"\xef\xbb\xbf \t\r\n")[:5].lower() != b"solid":
        raise ValueError("neither text that begins with solid, nor as long as its triangles")
    return len(content)


def _text_of_ply(content: bytes) -> int:
    """The header; what follows may be text or numbers."""
    end = content.find(b"end_header")
    return end if end >= 0 and b"format ascii" not in content[:end] else len(content)


_TEXTS: dict[str, Callable[[bytes], int]] = {".obj": len, ".stl": _text_of_stl, ".ply": _text_of_ply}  # bytes of text
