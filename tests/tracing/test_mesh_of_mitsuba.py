"""A surface as Mitsuba's mesh, by the interface of 3.9 (the real one) and of 3.10 (a stand-in by its release notes)."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from seamap_rt.mesh.surface import as_trimesh
from seamap_rt.tracing import illumination

VERTICES = np.array([[0.0, 0.0, 0.1], [1.0, 0.0, 0.2], [0.0, 1.0, 0.3], [1.0, 1.0, 0.7]])
FACES = np.array([[0, 1, 2], [1, 3, 2]])
NORMALS = np.tile([0.0, 0.6, 0.8], (4, 1))


class NewMesh:
    """What `mi.Mesh` of 3.10 takes: (n, 3) tensors at once, by keyword; it makes normals of its own if not told to
    leave the faces flat."""

    from_fields = None

    def __init__(
        self, name: str, *, faces: Any, positions: Any, normals: Any = None, face_normals: bool = False
    ) -> None:
        self.name, self.faces, self.positions, self.normals, self.flat = name, faces, positions, normals, face_normals


@pytest.fixture
def new(monkeypatch: pytest.MonkeyPatch) -> None:
    mi = illumination.mitsuba()
    types = {name: getattr(mi, name) for name in ("Float", "UInt32", "TensorXf", "TensorXu")}
    monkeypatch.setattr(illumination, "mitsuba", lambda: SimpleNamespace(Mesh=NewMesh, **types))


def test_todays_mesh_holds_vertices_faces_and_the_normals_that_it_is_given() -> None:
    mi = illumination.mitsuba()
    mesh = illumination.mitsuba_mesh("sea", as_trimesh(VERTICES, FACES))
    smooth = illumination.mitsuba_mesh("sea", as_trimesh(VERTICES, FACES), NORMALS)
    if hasattr(mi.Mesh, "from_fields"):
        assert (mesh.has_normals(), smooth.has_normals()) == (False, True)
    else:
        assert (mesh.has_vertex_normals(), smooth.has_vertex_normals()) == (False, True)
        held = np.array(mi.traverse(smooth)["vertex_normals"]).reshape(-1, 3)
        assert_array_equal(held, NORMALS.astype(np.float32))


@pytest.mark.usefixtures("new")
def test_mesh_of_mitsuba_3_10_is_given_tensors_and_flat_faces_unless_there_are_normals() -> None:
    """Smooth normals of Mitsuba's own would bend what `paths` reflects: 3.10 makes them where none are given."""
    mesh = illumination.mitsuba_mesh("sea", as_trimesh(VERTICES, FACES))
    assert_array_equal(np.array(mesh.positions), VERTICES.astype(np.float32))
    assert_array_equal(np.array(mesh.faces), FACES)
    assert np.array(mesh.faces).dtype == np.uint32
    assert mesh.flat
    assert mesh.normals is None
    smooth = illumination.mitsuba_mesh("sea", as_trimesh(VERTICES, FACES), NORMALS)
    assert_array_equal(np.array(smooth.normals), NORMALS.astype(np.float32))
    assert not smooth.flat


@pytest.mark.usefixtures("new")
def test_parameters_of_mitsuba_3_10_are_written_by_their_new_names_alone() -> None:
    held: dict[str, Any] = {"sea.positions": None, "sea.faces": None, "sea.normals": "untouched"}
    illumination.set_triangles(held, "sea.", as_trimesh(VERTICES, FACES))
    assert set(held) == {"sea.positions", "sea.faces", "sea.normals"}
    assert_array_equal(np.array(held["sea.positions"]), VERTICES.astype(np.float32))
    assert_array_equal(np.array(held["sea.faces"]), FACES)
    assert held["sea.normals"] == "untouched"
