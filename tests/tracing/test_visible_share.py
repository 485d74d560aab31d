"""How much of the sea is seen: the default mesh against one of four times the rungs and columns, sign included."""

from __future__ import annotations

import numpy as np

from validation.light.share import EDGES_M, shares


def test_the_default_mesh_sees_neither_too_much_nor_too_little() -> None:
    """To 2 %, and 3 % in single rings of a sixth of a turn; with vertices on the water itself 8 % too much was seen."""
    found = shares("0.7 m 4 s, 3 m mast", sector=(240.0, 300.0))
    beyond = found.off[EDGES_M[:-1] >= 100.0]
    assert np.abs(beyond).max() < 0.03
    assert abs(beyond.mean()) < 0.02
    assert found.finer[-1] < 0.2  # there is shadow enough to judge
