"""Mesh files that place parts in a scene: Collada, read here, and glTF (Khronos 2.0), which a library reads: what it
declares is held against what it holds before arrays are made of it.

A Collada file (.dae, Khronos 1.4 and 1.5) becomes faces in metres, x to the right, y ahead and z up. Its `unit` says
how many metres one of its own is, and its `up_axis` which of its axes is up; nodes of the scene place its meshes.
Materials, animation and what else it holds are not read.
"""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .opening import LONG, read_bytes, size

_MOST_ELEMENTS = 2_000_000  # of XML
_MOST_NODES = 10_000
_UP = {  # rows: right, ahead, up of the file's x, y, z
    "X_UP": np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]),
    "Y_UP": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "Z_UP": np.eye(3),
}
_FACES = ("triangles", "polylist", "polygons")

Part = tuple[NDArray[np.float64], list[NDArray[np.int64]]]  # vertices (n, 3), and polygons as rows of their places


def read_collada(content: bytes, most_corners: int) -> tuple[NDArray[np.float64], list[NDArray[np.int64]]]:
    """Vertices (n, 3) and polygons of all meshes, where the scene puts them.

    Raises InputError for more than `most_corners` and vertices of all instances, and for what is not read; ValueError,
    KeyError and the like for damage.
    """
    if content.count(b"<") > _MOST_ELEMENTS or b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise InputError("has entities, or too many elements of XML; export it anew, with fewer")
    root = ET.fromstring(content)
    for each in root.iter():
        each.tag = each.tag.rpartition("}")[2]  # names without their namespace
    held = {f"#{each.get('id')}": each for each in root.iter() if each.get("id")}
    up = (root.findtext("asset/up_axis") or "Y_UP").strip()
    unit = root.find("asset/unit")
    world = np.eye(4)
    world[:3, :3] = _UP[up] * float(unit.get("meter", 1.0) if unit is not None else 1.0)
    parts: dict[str, Part] = {}
    vertices: list[NDArray] = []
    faces: list[NDArray[np.int64]] = []
    shown = root.find("scene/instance_visual_scene")
    scene = held[shown.attrib["url"]] if shown is not None else ET.Element("none")
    first = corners = 0
    for place, url in _instances(scene, world, held):
        if url not in parts:
            parts[url] = _part(held[url], held)
        points, polygons = parts[url]
        corners += sum(map(len, polygons)) + len(points)
        if corners > most_corners:
            raise InputError(f"shows more than {most_corners} corners and vertices; decimate the mesh")
        vertices.append(points @ place[:3, :3].T + place[:3, 3])
        turned = slice(None, None, -1 if np.linalg.det(place[:3, :3]) < 0.0 else 1)  # mirrored: outside stays outside
        faces += [first + polygon[turned] for polygon in polygons]
        first += len(points)
    return np.concatenate(vertices) if vertices else np.empty((0, 3)), faces


def _instances(
    scene: ET.Element, world: NDArray[np.float64], held: dict[str, ET.Element]
) -> Iterator[tuple[NDArray[np.float64], str]]:
    """Where each mesh of a scene is put, and which it is."""
    left, seen = [(scene, world)], 0
    while left:
        (node, place), seen = left.pop(), seen + 1
        if seen > _MOST_NODES:
            raise InputError(f"has more than {_MOST_NODES} nodes, or some below themselves; join its parts")
        for each in node:
            if each.tag in ("matrix", "translate", "rotate", "scale"):
                place = place @ _transform(each)
            elif each.tag in ("lookat", "skew", "instance_controller"):
                raise InputError(f"has <{each.tag}>, which is not read; apply transforms and modifiers and export it")
            elif each.tag == "node":
                left.append((each, place))
            elif each.tag == "instance_node":
                left.append((held[each.attrib["url"]], place))
            elif each.tag == "instance_geometry":
                yield place, each.attrib["url"]


def _transform(element: ET.Element) -> NDArray[np.float64]:
    """(4, 4) of an element of a node."""
    values, made = _floats(element), np.eye(4)
    if element.tag == "matrix":
        return values.reshape(4, 4)
    if element.tag == "translate":
        made[:3, 3] = values
    elif element.tag == "scale":
        made[:3, :3] = np.diag(values)
    else:  # about an axis, degrees (Rodrigues)
        x, y, z = values[:3] / np.linalg.norm(values[:3])
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        angle = np.radians(values[3])
        made[:3, :3] += np.sin(angle) * across + (1.0 - np.cos(angle)) * across @ across
    return made


def _part(geometry: ET.Element, held: dict[str, ET.Element]) -> Part:
    """A mesh as it is: the vertices of all of its sources, one after the other, and its faces."""
    sources, faces = dict[str, tuple[int, NDArray[np.float64]]](), list[NDArray[np.int64]]()
    for group in geometry.iterfind("mesh/*"):
        if group.tag in ("tristrips", "trifans"):
            raise InputError(f"has faces as <{group.tag}>, which are not read; export it with triangles or polygons")
        if group.tag not in _FACES:
            continue
        inputs = {each.attrib["semantic"]: each for each in group.iterfind("input")}
        stride = 1 + max(int(each.attrib["offset"]) for each in group.iterfind("input"))
        within = int(inputs["VERTEX"].attrib["offset"])
        source = inputs["VERTEX"].attrib["source"]
        if source not in sources:
            sources[source] = sum(len(points) for _, points in sources.values()), _points(held[source], held)
        first, points = sources[source]
        if group.find("ph") is not None:
            raise InputError("has faces with holes, which are not read; triangulate the mesh and export it anew")
        for each in group.iterfind("p"):
            corners = np.array((each.text or "").split(), dtype=np.int64).reshape(-1, stride)[:, within]
            if corners.size and not 0 <= corners.min() <= corners.max() < len(points):
                raise ValueError("a face has a corner that is not there")
            lengths = (
                np.full(len(corners) // 3, 3) if group.tag == "triangles" else
                np.array((group.findtext("vcount") or "").split(), dtype=np.int64) if group.tag == "polylist" else
                np.array([len(corners)])
            )  # fmt: skip
            faces += np.split(first + corners, np.cumsum(lengths))[: len(lengths)]
    return np.concatenate([np.empty((0, 3)), *(points for _, points in sources.values())]), faces


def _points(vertices: ET.Element, held: dict[str, ET.Element]) -> NDArray[np.float64]:
    """Positions (n, 3) of a <vertices>."""
    source = next(each.attrib["source"] for each in vertices.iterfind("input") if each.get("semantic") == "POSITION")
    accessor = held[source].find("technique_common/accessor")
    assert accessor is not None
    stride, start = int(accessor.get("stride", 3)), int(accessor.get("offset", 0))
    return _floats(held[accessor.attrib["source"]])[start:].reshape(-1, stride)[:, :3]


def _floats(element: ET.Element) -> NDArray[np.float64]:
    return np.array((element.text or "").split(), dtype=np.float64)


_DEEPEST = 100
_MOST_WORDS = 1_000_000  # commas of its JSON
_MOST_CORNERS = 6_000_000  # of all instances: three a triangle
_OFTEN = 8  # that its bytes may be named by accessors and views
_WIDTHS = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


class FileResolver:
    """The files in a folder, as trimesh asks for those that a glTF file names."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __getitem__(self, name: str) -> bytes:
        path = self._folder / unquote(name)
        return read_bytes(path, "what the mesh needs beside it", named=f"'{name}'", most=LONG, below=self._folder)

    get = __getitem__


def check_gltf(content: bytes, beside: FileResolver) -> None:
    """Raise InputError for a file, GLB or text, whose nodes are too many or no tree, or whose accessors and instances
    are more than it holds. Raises ValueError, KeyError and the like for damage."""
    text = content
    if content[:4] == b"glTF":
        text = content[20 : 20 + int.from_bytes(content[12:16], "little")]
    if text.count(b",") > _MOST_WORDS:
        raise InputError(f"describes itself in more than {_MOST_WORDS} words; join its parts")
    document = json.loads(text)
    nodes, buffers = document.get("nodes", []), document.get("buffers", [])
    if len(nodes) > _MOST_NODES:
        raise InputError(f"has {len(nodes)} nodes: must have at most {_MOST_NODES}; join its parts")
    _check_tree(nodes)
    outside = [each["uri"] for each in buffers if not each.get("uri", "data:").startswith("data:")]
    held = len(content) + sum(len(beside[uri]) for uri in set(outside))
    accessors = document.get("accessors", [])
    named = [sum(each["byteLength"] for each in document.get("bufferViews", [])), sum(map(_declared_bytes, accessors))]
    if max(named) > _OFTEN * held:
        raise InputError(f"declares {size(max(named))} of numbers and holds {size(held)}; export it anew")
    for each in accessors:
        if "bufferView" in each and _declared_bytes(each) > document["bufferViews"][each["bufferView"]]["byteLength"]:
            raise InputError(f"has an accessor of {size(_declared_bytes(each))} on fewer bytes; export it anew")
    corners = [sum(_corners(part, accessors) for part in mesh["primitives"]) for mesh in document.get("meshes", [])]
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


def _declared_bytes(accessor: dict[str, Any]) -> int:
    return abs(int(accessor["count"])) * _COLUMNS[accessor["type"]] * _WIDTHS[accessor["componentType"]]


def _corners(part: dict[str, Any], accessors: list[dict[str, Any]]) -> int:
    """The larger of its vertices and its indices."""
    used = (part.get("indices"), part.get("attributes", {}).get("POSITION"))
    return max((int(accessors[each]["count"]) for each in used if each is not None), default=0)
