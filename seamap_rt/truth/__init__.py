"""The true heights, slopes and visible fractions of the maps' cells: means of the simulated sea over each cell."""

from .ground import ground_truth
from .known import where_known
from .polar import polar_truth, polar_truth_on_device

__all__ = ["ground_truth", "polar_truth", "polar_truth_on_device", "where_known"]
