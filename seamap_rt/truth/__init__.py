"""The true heights, slopes and visible fractions of the maps' cells: means of the simulated sea over each cell."""

from .ground import ground_truth, where_known
from .polar import polar_truth

__all__ = ["ground_truth", "polar_truth", "where_known"]
