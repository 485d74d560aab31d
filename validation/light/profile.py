"""The triangulated surface of a mesh along planes through the antenna's axis: what judges of light march over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seamap_rt.mesh.facets import Plane
from seamap_rt.mesh.grid import PolarGrid


@dataclass(frozen=True)
class Profile:
    """The triangulated surface along one plane of every column: rungs and diagonals, alternating outward."""

    rung_distance: NDArray[np.float64]  # (rung,)
    diagonal_distance: NDArray[np.float64]  # (rung − 1,)
    rung_height: NDArray[np.float64]  # (column, rung)
    diagonal_height: NDArray[np.float64]  # (column, rung − 1)


def profile(elevation: NDArray[np.float64], grid: PolarGrid, fraction: float) -> Profile:
    """The profile at `fraction` of each column's width, from the lines' elevations (line, rung). Exact."""
    plane = Plane.of(grid, fraction)
    first, second = elevation[:-1], elevation[1:]
    return Profile(
        rung_distance=plane.rung_distance,
        diagonal_distance=plane.diagonal_distance,
        rung_height=(1.0 - fraction) * first + fraction * second,
        diagonal_height=(1.0 - plane.share) * first[:, :-1] + plane.share * second[:, 1:],
    )
