"""Facets, scattering and radar → complex range gates, and their expectation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazily

if TYPE_CHECKING:
    from .expected import expected_look_gates
    from .scatterers import from_scatterers
    from .turn import turn_voltages

__all__ = ["expected_look_gates", "from_scatterers", "turn_voltages"]

__getattr__ = lazily(
    __name__, {"expected": "expected_look_gates", "scatterers": "from_scatterers", "turn": "turn_voltages"}
)
