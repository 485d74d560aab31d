"""The polar grid of one turn: radial lines, each at the moment when the beam passes it, and rungs at ground ranges;
and samples of the sea all around the mast (`circle_grid`), over which a mean echo is taken."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..radar.installation import ArrayPose, Installation, column_frame
from ..radar.scan import BEAMS_BEYOND, sector_width
from ..settings import RadarSettings, TracingSettings
from .sizing import radar_detail

MOST_FACETS = 2_000_000  # of a turn that is worked on whole
PART_FACETS = 500_000  # of a larger one, at a time
INNERMOST_M = 1.0  # ground range of the first rung


@dataclass(frozen=True)
class PolarGrid:
    """Lines and rungs of one turn. Lines are numbered from `first`; line 0 starts the sector."""

    turn: int
    spacing_deg: float  # between neighbouring lines
    first: int  # number of the first line (negative: it lies before the sector)
    per_circle: int  # columns of a full circle: makes column numbers unique over turns
    sweep: NDArray[np.float64]  # (line,) deg from the start of the sector
    azimuth: NDArray[np.float64]  # (line,) deg, not wrapped
    time: NDArray[np.float64]  # (line,) s, when the boresight passes the line
    ground_range: NDArray[np.float64]  # (rung,) m
    pose: ArrayPose  # (line,) of the antennas at those times
    column_pose: ArrayPose  # (column,)
    drift: NDArray[np.float64]  # (column, antenna, 3) m/s of the antennas along the column, across it, up
    reach_deg: float  # to either side of the boresight, within which the beam hears something

    @property
    def columns(self) -> int:
        return self.sweep.size - 1

    @cached_property
    def parts(self) -> list[slice]:
        """Columns whose facets are worked on at a time, where a whole turn's would take much memory: parts, or all."""
        facets = 2 * (self.ground_range.size - 1)
        count = -(-self.columns * facets // PART_FACETS) if self.columns * facets > MOST_FACETS else 1
        edges = [self.columns * n // count for n in range(count + 1)]
        return [slice(begin, end) for begin, end in pairwise(edges) if end > begin]

    def part(self, columns: slice) -> PolarGrid:
        """Neighbouring columns alone, with their lines."""
        lines = slice(columns.start, columns.stop + 1)
        return replace(
            self,
            first=self.first + columns.start,
            sweep=self.sweep[lines],
            azimuth=self.azimuth[lines],
            time=self.time[lines],
            pose=self.pose[lines],
            column_pose=self.column_pose[columns],
            drift=self.drift[columns],
        )

    @cached_property
    def column_sweep(self) -> NDArray[np.float64]:
        """Sweep of the columns' middles (deg)."""
        return 0.5 * (self.sweep[1:] + self.sweep[:-1])

    @cached_property
    def column_time(self) -> NDArray[np.float64]:
        return 0.5 * (self.time[1:] + self.time[:-1])

    @cached_property
    def column_azimuth(self) -> NDArray[np.float64]:
        return 0.5 * (self.azimuth[1:] + self.azimuth[:-1])

    @cached_property
    def column_height(self) -> NDArray[np.float64]:
        """(column, 1) m, of the frame's origin above mean sea level."""
        return self.column_pose.origin[:, 2:]

    @cached_property
    def antenna_positions(self) -> NDArray[np.float64]:
        """(column, antenna, 3) m, of the antennas in the column's frame: along the column, across it, up."""
        return self._to_column_axes(self.column_pose.offsets)

    @cached_property
    def array_up(self) -> NDArray[np.float64]:
        """(column, 3) unit vector up the array: along the column, across it, up."""
        return self._to_column_axes(self.column_pose.axes[:, 2:])[:, 0]

    def _to_column_axes(self, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """Vectors (column, n, 3) east north up as along, across, up."""
        return np.einsum("cij,cnj->cni", column_frame(self.column_azimuth), vectors)

    @cached_property
    def circle_azimuth(self) -> NDArray[np.float64]:
        """(line,) deg, the azimuth within one circle: lines over the same ground have the same bits in every turn."""
        line = np.rint(self.sweep / self.spacing_deg).astype(np.int64)
        return (self.azimuth[0] - self.sweep[0]) + self.spacing_deg * (line % self.per_circle)

    @property
    def column_number(self) -> NDArray[np.int64]:
        """A number for each column that stays the same where the end of a turn is the start of the next."""
        return (self.turn + 1) * self.per_circle + self.first + np.arange(self.columns, dtype=np.int64)


def polar_grid(installation: Installation, tracing: TracingSettings, turn: int) -> PolarGrid:
    """The grid of a turn: columns a fraction of the beam wide, rungs equally far apart over the range window."""
    radar, array = installation.radar, installation.array
    detail = radar_detail(radar, tracing)
    per_circle = int(np.ceil(360.0 / (array.narrowest_beam_deg / detail.columns_per_beam)))
    spacing = 360.0 / per_circle
    sector = np.linspace(0.0, sector_width(radar) / 360.0, 721)
    scanned = (turn + sector) * installation.period
    installation.check_that_it_sweeps(scanned)
    # The fan of a heeled mast hears the near range well off its bearing.
    lean = installation.lean_deg(scanned, float(np.arcsin(min(1.0, radar.height_m / radar.range_m[0]))))
    # In whole degrees: a column that two turns hear keeps its speckle while both ask for it equally long.
    reach = BEAMS_BEYOND * array.beam_deg + np.ceil(lean - 1e-9)
    # Rounding of a long run's angles is no swing.
    beyond = int(np.ceil((reach + np.abs(installation.swing(scanned)).max()) / spacing - 1e-6))
    # From the foot of the mast on, though the gates may start further out: what is near can shadow what is far.
    far = radar.range_m[1] + installation.response.support_m
    rungs = int(np.ceil((far - INNERMOST_M) / detail.facet_m)) + 1
    if radar.scan == "staring":
        middle = round(0.5 * sector_width(radar) / spacing)
        line = np.arange(middle - beyond, middle + beyond + 1)
        time = column_time = (turn + 0.5) * installation.period  # the sea as it is half-way
        time, column_time = np.full(line.size, time), np.full(line.size - 1, column_time)
    else:
        inside = int(np.ceil(sector_width(radar) / spacing - 1e-9))
        line = np.arange(-beyond, inside + beyond + 1)
        nominal = (
            (turn * per_circle + line) / per_circle * installation.period
        )  # the same bits where a turn meets the next
        time = installation.passing(spacing * line.astype(np.float64), nominal)
        column_time = 0.5 * (time[1:] + time[:-1])
    sweep = spacing * line.astype(np.float64)
    middles = installation.pose(column_time)
    azimuth = radar.sector_deg[0] + sweep
    frame = column_frame(0.5 * (azimuth[1:] + azimuth[:-1]))
    return PolarGrid(
        turn=turn,
        spacing_deg=spacing,
        first=int(line[0]),
        per_circle=per_circle,
        sweep=sweep,
        azimuth=azimuth,
        time=time,
        ground_range=INNERMOST_M + detail.facet_m * np.arange(rungs, dtype=np.float64),
        pose=installation.pose(time),
        column_pose=middles,
        drift=np.einsum("cij,caj->cai", frame, installation.velocity(column_time)),
        reach_deg=reach,
    )


_GROUP = 4  # columns
_MOST_FACETS = 1_000_000
_LEAST_GROUPS = 12


def circle_grid(radar: RadarSettings, tracing: TracingSettings) -> tuple[PolarGrid, NDArray[np.bool_]]:
    """Lines of groups of columns around the circle, all at time 0, and which columns (column,) lie in a group.

    Groups of neighbouring columns stand evenly around the circle, so that every direction to the wind and every
    distance is there, whatever sector the radar scans. Neighbouring columns see the same crests, so that half of them
    give nearly as much as all. Where they stand, and how wide they are, follows from the radar alone: meshes of other
    spacings are then calibrated on the same crests, or the random sample would set their scales apart by 0.1 dB. Rungs
    are the mesh's own, so that its own mean is right.
    """
    around = {"sector_deg": (0.0, 360.0), "scan": "turning"}
    plain = radar_detail(radar, TracingSettings())
    columns = {"columns_per_beam": plain.columns_per_beam}
    whole = polar_grid(Installation(radar.model_copy(update=around)), tracing.model_copy(update=columns), 0)
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
