"""Mesh files of every kind give back the object they were made from, or one line of error."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

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
    mesh.export(path)
    return path


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
    assert "kinds .stl, .glb" in refusal(tmp_path / "a.dae")
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
