"""Samples of the sea all around the mast, lit by the horizon method: what a mean echo is taken over.

Groups of neighbouring columns stand evenly around the circle, so that every direction to the wind and every distance is
there, whatever sector the radar scans. Neighbouring columns see the same crests, so that half of them give nearly as
much as all. Where they stand, and how wide they are, follows from the radar alone: meshes of other spacings are then
calibrated on the same crests, or the random sample would set their scales apart by 0.1 dB. Rungs are the mesh's
own, so that its own mean is right.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..mesh.grid import PolarGrid, polar_grid
from ..mesh.sizing import radar_detail
from ..settings import RadarSettings, TracingSettings

_GROUP = 4  # columns
_MOST_FACETS = 1_000_000
_LEAST_GROUPS = 12


def circle_grid(radar: RadarSettings, tracing: TracingSettings) -> tuple[PolarGrid, NDArray[np.bool_]]:
    """Lines of groups of columns around the circle, all at time 0, and which columns (column,) lie in a group."""
    around = {"sector_deg": (0.0, 360.0), "scan": "turning"}
    plain = radar_detail(radar, TracingSettings())
    columns = {"columns_per_beam": plain.columns_per_beam}
    whole = polar_grid(radar.model_copy(update=around), tracing.model_copy(update=columns), 0)
    facets = 2.0 * whole.ground_range[-1] / plain.facet_m
    most = min(int(_MOST_FACETS / ((_GROUP + 1) * facets)), whole.per_circle // (2 * _GROUP))
    # A mesh of tiny facets takes fewer groups, to limit memory.
    most = min(most, int(4 * _MOST_FACETS / ((_GROUP + 1) * 2 * whole.ground_range.size)))
    groups = min(max(most, _LEAST_GROUPS), whole.per_circle // (_GROUP + 1))
    start = np.arange(groups) * whole.per_circle // groups - whole.first
    lines = (start[:, None] + np.arange(_GROUP + 1)).ravel()
    grid = replace(
        whole,
        sweep=whole.sweep[lines],
        azimuth=whole.azimuth[lines],
        time=np.zeros(lines.size),
        pose=whole.pose[lines],
        column_pose=whole.column_pose[lines[:-1]],  # a column follows its first line
        drift=whole.drift[lines[:-1]],
    )
    return grid, np.arange(grid.columns) % (_GROUP + 1) < _GROUP
