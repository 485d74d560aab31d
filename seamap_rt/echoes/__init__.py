"""Facets, scattering and radar → complex range gates, and their expectation."""

from .expected import expected_look_gates
from .scatterers import from_scatterers
from .turn import turn_voltages

__all__ = ["expected_look_gates", "from_scatterers", "turn_voltages"]
