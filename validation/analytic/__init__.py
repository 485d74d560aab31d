"""Closed-form answers that the simulator is held against. Nothing here uses the simulator's own formulas."""

from .clutter import flat_sea_gate_height, flat_sea_power, flat_sea_power_textbook
from .echoes import echoes
from .geometry import (
    ground_position_from_range_difference,
    height_from_range_difference,
    range_difference,
)
from .phase import cramer_rao_phase_std, phase_pdf_lee94, phase_std_lee94
from .point_sea import PointSea
from .seas import FlatSea, SinusoidSea, TiltedSea
from .shadowing import (
    shadowing_smith67,
    shadowing_wagner67,
    sinusoid_shadowed_fraction,
    sinusoid_visible_intervals,
    visible_share,
)

__all__ = [
    "FlatSea",
    "PointSea",
    "SinusoidSea",
    "TiltedSea",
    "cramer_rao_phase_std",
    "echoes",
    "flat_sea_gate_height",
    "flat_sea_power",
    "flat_sea_power_textbook",
    "ground_position_from_range_difference",
    "height_from_range_difference",
    "phase_pdf_lee94",
    "phase_std_lee94",
    "range_difference",
    "shadowing_smith67",
    "shadowing_wagner67",
    "sinusoid_shadowed_fraction",
    "sinusoid_visible_intervals",
    "visible_share",
]
