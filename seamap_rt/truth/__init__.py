"""The true heights, slopes and visible fractions of the maps' cells: means of the simulated sea over each cell."""

from .ground import ground_truth, mask_unknown
from .polar import polar_truth

__all__ = ["ground_truth", "mask_unknown", "polar_truth"]
