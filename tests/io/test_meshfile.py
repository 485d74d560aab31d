"""Mesh files of every kind give back the object they were made from, or one line of error."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from seamap_rt.errors import InputError, one_line
from seamap_rt.io import meshfile
from seamap_rt.io.meshfile import load_mesh
from seamap_rt.settings import ObjectSettings

FLOAT32 = 1e-6  # STL and GLB keep metres in single precision
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def settings(path: Path | str, **keys: Any) -> ObjectSettings:
    return ObjectSettings(mesh=str(path), position_m=(0.0, 0.0, 0.0), **keys)


def wedge() -> trimesh.Trimesh:
    """2 m wide (x), 5 m long (y), 1 m high: low ahead, and none of its sides like another."""
    corners = [(x, y, z) for x in (-0.5, 1.5) for y, z in ((-2.0, 0.0), (3.0, 0.0), (-2.0, 1.0))]
    return trimesh.convex.convex_hull(np.array(corners))


def in_gltf_axes(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """As a modeller writes it: y up, z ahead, and so x to the left."""
    x, y, z = mesh.vertices.T
    return trimesh.Trimesh(np.stack((-x, z, y), axis=1), mesh.faces, process=False)


def write(path: Path, mesh: trimesh.Trimesh) -> Path:
    if path.suffix == ".gltf":
        parts = trimesh.Scene(mesh).export(file_type="gltf")
        assert isinstance(parts, dict)
        for name, data in parts.items():
            path.with_name("model.gltf" if name.endswith(".gltf") else name).write_bytes(data)
        return path.with_name("model.gltf")
    if path.suffix == ".dae":
        return polygons_as(path, mesh.vertices, mesh.faces.tolist())
    mesh.export(path)
    return path


def collada(
    vertices: Any, faces: list[list[int]], up: str = "Z_UP", metre: float = 1.0, node: str = "", more: str = ""
) -> str:
    """A text of Collada: one mesh of polygons with normals beside them, once in the scene."""
    points = " ".join(f"{value:.17g}" for value in np.ravel(vertices))
    corners = " ".join(f"{each} 0" for face in faces for each in face)
    counts = " ".join(str(len(face)) for face in faces)
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="own" meter="{metre}"/><up_axis>{up}</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="{np.size(vertices)}">{points}</float_array>
<technique_common><accessor source="#pa" count="{len(vertices)}" stride="3"/></technique_common></source>
<source id="n"><float_array id="na" count="3">0 0 1</float_array>
<technique_common><accessor source="#na" count="1" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="{len(faces)}"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="NORMAL" source="#n" offset="1"/><vcount>{counts}</vcount><p>{corners}</p></polylist>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node>{node}<instance_geometry url="#g"/></node>{more}</visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def polygons_as(path: Path, vertices: Any, faces: list[list[int]]) -> Path:
    """A file of polygons, as its ending and its name say: OBJ by absolute or relative numbers, PLY as text or not."""
    vertices = np.asarray(vertices, dtype=float)
    if path.suffix == ".dae":
        path.write_text(collada(vertices, faces))
    elif path.suffix == ".obj":
        less = len(vertices) if "relative" in path.name else -1
        lines = ["v {:.17g} {:.17g} {:.17g}".format(*each) for each in vertices]
        path.write_text("\n".join((*lines, *("f " + " ".join(str(i - less) for i in face) for face in faces))))
    else:
        kind = "binary_big_endian" if "binary" in path.name else "ascii"
        head = (
            f"ply\nformat {kind} 1.0\nelement vertex {len(vertices)}\nproperty double x\nproperty double y\n"
            f"property double z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        )
        if kind == "ascii":
            rows = [*map(list, vertices), *([len(face), *face] for face in faces)]
            path.write_text(head + "\n".join(" ".join(map(str, row)) for row in rows) + "\n")
        else:
            packed = b"".join(struct.pack(f">B{len(face)}i", len(face), *face) for face in faces)
            path.write_bytes(head.encode() + vertices.astype(">f8").tobytes() + packed)
    return path


def prism(outline: Sequence[tuple[float, float]]) -> tuple[NDArray[np.float64], list[list[int]]]:
    """1 m high, of an outline that turns anticlockwise: bottom and top as one polygon each, sides of four corners."""
    count = len(outline)
    points = np.array([(x, y, z) for z in (0.0, 1.0) for x, y in outline])
    sides = [[i, (i + 1) % count, (i + 1) % count + count, i + count] for i in range(count)]
    return points, [list(range(count))[::-1], list(range(count, 2 * count)), *sides]


OUTLINES = {  # with their areas
    "L": ([(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)], 7.0),
    "arrow": ([(0, 0), (2, -2), (0, 3), (-2, -2)], 6.0),
    "comb": ([(0, 0), (5, 0), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)], 11.0),
    "square": ([(0, 0), (2, 0), (2, 2), (0, 2)], 4.0),
    "corner on a side": ([(0, 0), (1, 0), (2, 0), (2, 2), (1, 1), (0, 2)], 3.0),
}
KINDS = ("absolute.obj", "relative.obj", "text.ply", "binary.ply", "polylist.dae")


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("outline", OUTLINES)
def test_polygons_have_their_own_area(tmp_path: Path, outline: str, kind: str, turned: bool) -> None:
    """Whatever the polygon and however it lies in space, a prism of it is closed, with its area and its volume."""
    points, area = OUTLINES[outline]
    vertices, faces = prism(points)
    if turned:
        vertices = vertices @ trimesh.transformations.rotation_matrix(1.0, (1.0, 2.0, 3.0))[:3, :3].T
    path = polygons_as(tmp_path / kind, vertices, faces)
    if kind == "binary.ply" and len(points) != 4:  # a row of it has one length for trimesh
        assert "save it as text" in refusal(path)
        return
    mesh = load_mesh(settings(path))
    around = sum(np.hypot(x - points[i - 1][0], y - points[i - 1][1]) for i, (x, y) in enumerate(points))
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(area, rel=1e-9)
    assert mesh.area == pytest.approx(2.0 * area + around, rel=1e-9)


def test_relative_numbers_count_from_where_they_stand(tmp_path: Path) -> None:
    """Two boxes, each followed by its faces: both are there, as with absolute numbers."""
    box, far = prism(OUTLINES["square"][0]), prism(OUTLINES["L"][0])
    text = ""
    for vertices, faces in (box, far):
        text += "".join(f"v {x + 10 * (vertices is far[0])} {y} {z}\n" for x, y, z in vertices)
        text += "".join("f " + " ".join(f"{i - len(vertices)}//1" for i in face) + "\n" for face in faces)
    (tmp_path / "a.obj").write_text(text)
    mesh = load_mesh(settings(tmp_path / "a.obj"))
    assert mesh.volume == pytest.approx(11.0)
    assert_allclose(mesh.bounds, [[0.0, 0.0, 0.0], [14.0, 4.0, 1.0]])


@pytest.mark.parametrize("metre", [1.0, 0.0254, 0.01])
@pytest.mark.parametrize("up", ["X_UP", "Y_UP", "Z_UP"])
def test_collada_tells_its_axes_and_its_unit(tmp_path: Path, up: str, metre: float) -> None:
    vertices, faces = prism([(0.0, 0.0), (3.0, 0.0), (3.0, 5.0), (0.0, 5.0)])
    right, ahead, above = vertices.T  # and in Collada's words right, up and towards the viewer
    own = {"X_UP": (above, -right, -ahead), "Y_UP": (right, above, -ahead), "Z_UP": (right, ahead, above)}[up]
    (tmp_path / "a.dae").write_text(collada(np.stack(own, axis=1) / metre, faces, up, metre))
    mesh = load_mesh(settings(tmp_path / "a.dae"))
    assert_allclose(mesh.bounds, [[0.0, 0.0, 0.0], [3.0, 5.0, 1.0]], atol=1e-12)
    assert mesh.volume == pytest.approx(15.0)


def test_collada_places_its_parts_as_its_scene_says(tmp_path: Path) -> None:
    vertices, faces = prism([(0.0, 0.0), (3.0, 0.0), (3.0, 5.0), (0.0, 5.0)])
    moved = "<translate>0 0 2</translate><rotate>0 0 1 90</rotate><scale>2 1 1</scale>"
    mirror = "<node><matrix>-1 0 0 -10  0 1 0 0  0 0 1 0  0 0 0 1</matrix><instance_geometry url='#g'/></node>"
    (tmp_path / "a.dae").write_text(collada(vertices, faces, node=moved, more=mirror))
    mesh = load_mesh(settings(tmp_path / "a.dae"))
    assert_allclose(mesh.bounds, [[-13.0, 0.0, 0.0], [0.0, 6.0, 3.0]], atol=1e-12)
    assert mesh.volume == pytest.approx(30.0 + 15.0)  # positive: the mirrored one, too, turns outward


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<COLLADA><asset/></COLLADA>", "no triangles"),
        ("<COLLADA", "damaged"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><COLLADA>&b;</COLLADA>', "entities"),
        (collada(*prism(OUTLINES["L"][0])).replace('url="#s"', 'url="#none"'), "damaged"),
        (collada(*prism(OUTLINES["L"][0]), node="<skew>1 0 0 0 1 0 0</skew>"), "skew"),
        (collada(*prism(OUTLINES["L"][0]), node='<node id="k"><instance_node url="#k"/></node>'), "below themselves"),
    ],
)
def test_collada_that_is_not_read_is_refused(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "a.dae").write_text(text)
    assert words in refusal(tmp_path / "a.dae")


def refusal(path: Path | str, **keys: Any) -> str:
    with pytest.raises(InputError) as caught:
        load_mesh(settings(path, **keys), 3)
    line = str(caught.value)
    assert line.startswith(one_line(f"objects.3.mesh = '{path}':"))
    assert line.isprintable()
    assert "\n" not in line
    assert ";" in line  # what to do about it
    return line


@pytest.mark.parametrize("ending", meshfile.ENDINGS)
def test_every_kind_gives_the_same_object(tmp_path: Path, ending: str) -> None:
    made = wedge()
    path = write(tmp_path / f"a{ending}", in_gltf_axes(made) if ending in (".glb", ".gltf") else made)
    mesh = load_mesh(settings(path))
    assert_allclose(mesh.bounds, made.bounds, atol=FLOAT32)
    assert_allclose(mesh.center_mass, made.center_mass, atol=FLOAT32)
    assert mesh.volume == pytest.approx(5.0, rel=1e-6)  # positive: normals still point outward
    assert mesh.is_watertight  # STL's loose corners are joined


def test_the_ending_may_be_in_capitals(tmp_path: Path) -> None:
    path = write(tmp_path / "a.stl", wedge()).rename(tmp_path / "A.STL")
    assert load_mesh(settings(path)).is_watertight


def test_scale_is_metres_per_unit(tmp_path: Path) -> None:
    path = write(tmp_path / "a.ply", wedge())
    assert_allclose(load_mesh(settings(path, scale=0.01)).bounds, 0.01 * wedge().bounds, rtol=FLOAT32)


def test_parts_of_a_scene_are_joined_where_it_puts_them(tmp_path: Path) -> None:
    """One box 10 m ahead (glTF's z), another mirrored: still turned inside in."""
    scene = trimesh.Scene()
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    scene.add_geometry(box, transform=trimesh.transformations.translation_matrix([0.0, 0.0, 10.0]))
    scene.add_geometry(box, transform=np.diag([-1.0, 1.0, 1.0, 1.0]))
    scene.export(tmp_path / "two.glb")
    mesh = load_mesh(settings(tmp_path / "two.glb"))
    assert_allclose(mesh.bounds, [[-0.5, -1.5, -1.0], [0.5, 11.5, 1.0]], atol=FLOAT32)
    assert mesh.volume == pytest.approx(12.0, rel=1e-6)


def test_triangles_without_area_are_dropped(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text(TRIANGLE + "v 0.5 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 2\n")
    assert len(load_mesh(settings(path)).faces) == 1


def test_a_stray_vertex_harms_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text(TRIANGLE + "v nan 1e9 0\nf 1 2 3\n")
    mesh = load_mesh(settings(path))
    assert_allclose(mesh.bounds, [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]])


def test_what_cannot_be_read_is_refused(tmp_path: Path) -> None:
    assert "no such file" in refusal(tmp_path / "none.stl")
    (tmp_path / "folder.ply").mkdir()
    assert "is a folder" in refusal(tmp_path / "folder.ply")
    assert "kinds .stl, .glb" in refusal(tmp_path / "a.fbx")
    assert "is not a path" in refusal("a\0.stl")
    (tmp_path / "a.gltf").write_text('{"asset": {"version": "2.0"}, "buffers": [{"uri": "none.bin", "byteLength": 4}]}')
    assert "'none.bin': no such file" in refusal(tmp_path / "a.gltf")


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.glb", b"glTF\0\0\0\0"),
        ("b.glb", bytes(range(250))),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 3\n"),
        ("a.stl", bytes(range(250))),
        ("a.obj", b"v 1 2\nf 1 2 9\n"),
        ("a.gltf", b'{"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}]}'),
    ],
)
def test_damage_is_refused(tmp_path: Path, name: str, data: bytes) -> None:
    (tmp_path / name).write_bytes(data)
    assert "damaged" in refusal(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.obj", "# Bo\u00efe\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        (
            "a.stl",
            "solid Bo\u00efe\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
            "endfacet\nendsolid\n",
        ),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_names_may_be_written_in_any_alphabet(tmp_path: Path, name: str, text: str, encoding: str) -> None:
    (tmp_path / name).write_bytes(text.encode(encoding))
    assert load_mesh(settings(tmp_path / name)).faces.shape == (1, 3)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no triangles"),
        ("v 0 0 0\nv 1 1 1\n", "no triangles"),
        (TRIANGLE + "v nan 0 0\nf 1 2 3\nf 1 2 4\n", "not finite"),
        (TRIANGLE + "v 0 inf 0\nf 1 2 4\n", "not finite"),
        (TRIANGLE + "v 0 1e308 0\nv 0 -1e308 0\nf 1 4 5\n", "inf m long"),
        (TRIANGLE + "v 0.5 0 0\nf 1 2 4\n", "without area"),
        ("v 0 0 0\nv 1e6 0 0\nv 0 1 0\nf 1 2 3\n", "1e+06 m long"),
    ],
)
def test_a_surface_is_asked_for(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "a.obj"
    path.write_text(text)
    assert words in refusal(path)


def test_triangles_must_have_their_vertices(tmp_path: Path) -> None:
    header = "ply\nformat ascii 1.0\nelement vertex 3\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz")
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    for last in (7, -1):
        (tmp_path / "a.ply").write_text(f"{header}0 0 0\n1 0 0\n0 1 0\n3 0 1 {last}\n")
        assert "not there" in refusal(tmp_path / "a.ply")


def test_too_many_triangles_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path / "a.stl", wedge())
    count = len(wedge().faces)
    monkeypatch.setattr(meshfile, "MOST_TRIANGLES", count)
    load_mesh(settings(path))
    monkeypatch.setattr(meshfile, "MOST_TRIANGLES", count - 1)
    assert f"{count} triangles: must be at most {count - 1}; decimate" in refusal(path)
