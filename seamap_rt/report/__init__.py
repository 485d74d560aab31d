"""Metrics and figures → one page that says what was measured, how well, and what was left out.

Names are loaded when first used, so that `report.limits`, which the command line imports, loads no matplotlib.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .curves import error_against_range, height_scatter, timing, visible_share
    from .maps import echo_power, height_maps, slope_maps
    from .page import write_report
    from .sea_words import fold_warning, ground_warning, warnings

_HOMES = {
    "echo_power": "maps",
    "error_against_range": "curves",
    "fold_warning": "sea_words",
    "ground_warning": "sea_words",
    "height_maps": "maps",
    "height_scatter": "curves",
    "slope_maps": "maps",
    "timing": "curves",
    "visible_share": "curves",
    "warnings": "sea_words",
    "write_report": "page",
}

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


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
