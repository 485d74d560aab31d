"""Mean sea clutter as measured: σ0 per unit HORIZONTAL area, shadowing included. One file a published model."""

from __future__ import annotations

from seamap_rt.scattering.gregers_hansen12 import nrcs_gregers_hansen12
from seamap_rt.scattering.horst78 import nrcs_horst78
from seamap_rt.scattering.reilly90 import nrcs_reilly90
from seamap_rt.scattering.sea_state import sea_state_from_wind, wind_from_sea_state
from seamap_rt.scattering.tsc90 import nrcs_tsc90

__all__ = [
    "nrcs_gregers_hansen12",
    "nrcs_horst78",
    "nrcs_reilly90",
    "nrcs_tsc90",
    "sea_state_from_wind",
    "wind_from_sea_state",
]
