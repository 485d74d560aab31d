"""What a glTF file declares, held against what it holds, before a library makes arrays of it (Khronos glTF 2.0)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from ..errors import InputError
from .opening import LONG, read_bytes, size

_MOST_NODES, _DEEPEST = 10_000, 100
_MOST_WORDS = 1_000_000  # commas of its JSON
_MOST_CORNERS = 6_000_000  # of all instances: three a triangle
_OFTEN = 8  # that its bytes may be named by accessors and views
_WIDTHS = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


class FilesBeside:
    """The files in a folder, as trimesh asks for those that a glTF file names."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __getitem__(self, name: str) -> bytes:
        path = self._folder / unquote(name)
        return read_bytes(path, "what the mesh needs beside it", named=f"'{name}'", most=LONG, below=self._folder)

    get = __getitem__


def check_gltf(content: bytes, beside: FilesBeside) -> None:
    """Raise InputError for a file, GLB or text, whose nodes are too many or no tree, or whose accessors and instances
    are more than it holds. Raises ValueError, KeyError and the like for damage."""
    text = content
    if content[:4] == b"glTF":
        text = content[20 : 20 + int.from_bytes(content[12:16], "little")]
    if text.count(b",") > _MOST_WORDS:
        raise InputError(f"describes itself in more than {_MOST_WORDS} words; join its parts")
    told = json.loads(text)
    nodes, buffers = told.get("nodes", []), told.get("buffers", [])
    if len(nodes) > _MOST_NODES:
        raise InputError(f"has {len(nodes)} nodes: must have at most {_MOST_NODES}; join its parts")
    _check_tree(nodes)
    outside = [each["uri"] for each in buffers if not each.get("uri", "data:").startswith("data:")]
    held = len(content) + sum(len(beside[uri]) for uri in set(outside))
    accessors = told.get("accessors", [])
    named = [sum(each["byteLength"] for each in told.get("bufferViews", [])), sum(map(_bytes_of, accessors))]
    if max(named) > _OFTEN * held:
        raise InputError(f"declares {size(max(named))} of numbers and holds {size(held)}; export it anew")
    for each in accessors:
        if "bufferView" in each and _bytes_of(each) > told["bufferViews"][each["bufferView"]]["byteLength"]:
            raise InputError(f"has an accessor of {size(_bytes_of(each))} on fewer bytes; export it anew")
    corners = [sum(_corners(part, accessors) for part in mesh["primitives"]) for mesh in told.get("meshes", [])]
    instances = sum(corners[node["mesh"]] for node in nodes if "mesh" in node)
    if instances > _MOST_CORNERS:
        raise InputError(f"shows {instances // 3} triangles: must be at most {_MOST_CORNERS // 3}; decimate the mesh")


def _check_tree(nodes: list[dict[str, Any]]) -> None:
    above: dict[int, int] = {}
    for parent, node in enumerate(nodes):
        for child in node.get("children", ()):
            if above.setdefault(child, parent) != parent:
                raise InputError("has a node below two others, so that its nodes are no tree; export it anew")
    for node in range(len(nodes)):
        depth, at = 0, node
        while at in above:
            depth, at = depth + 1, above[at]
            if depth > _DEEPEST:
                raise InputError(f"has nodes more than {_DEEPEST} deep, or below themselves; join its parts")


def _bytes_of(accessor: dict[str, Any]) -> int:
    return abs(int(accessor["count"])) * _COLUMNS[accessor["type"]] * _WIDTHS[accessor["componentType"]]


def _corners(part: dict[str, Any], accessors: list[dict[str, Any]]) -> int:
    """The larger of its vertices and its indices."""
    used = (part.get("indices"), part.get("attributes", {}).get("POSITION"))
    return max((int(accessors[each]["count"]) for each in used if each is not None), default=0)
