"""Metrics and figures → one page that says what was measured, how well, and what was left out.

Names are loaded when first used, so that `report.limits`, which the command line imports, loads no matplotlib.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_attributes

if TYPE_CHECKING:
    from .curves import error_against_range, height_scatter, timing, visible_share
    from .maps import echo_power, height_maps, slope_maps
    from .page import write_report
    from .sea_statistics import fold_warning, ground_warning, warnings

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
    "warnings",
    "write_report",
]

__getattr__ = lazy_attributes(
    __name__,
    {
        "curves": "error_against_range height_scatter timing visible_share",
        "maps": "echo_power height_maps slope_maps",
        "page": "write_report",
        "sea_statistics": "fold_warning ground_warning warnings",
    },
)
