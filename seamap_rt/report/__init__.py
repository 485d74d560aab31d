"""Metrics and figures → one page that says what was measured, how well, and what was left out."""

from .curves import error_against_range, height_scatter, timing, visible_share
from .maps import echo_power, height_maps, slope_maps
from .page import write_report
from .sea_words import fold_warning, ground_warning

__all__ = [
    "echo_power",
    "error_against_range",
    "fold_warning",
    "ground_warning",
    "height_maps",
    "height_scatter",
    "slope_maps",
    "timing",
    "visible_share",
    "write_report",
]
