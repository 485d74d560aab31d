"""How the sea's surface returns the radar's power: permittivity, Bragg, measured means, calibration."""

from seamap_rt.scattering.bragg import bragg_coefficients, nrcs_bragg, nrcs_two_scale
from seamap_rt.scattering.calibration import calibration_scale
from seamap_rt.scattering.empirical import nrcs_gregers_hansen12, sea_state_from_wind
from seamap_rt.scattering.permittivity import fresnel, permittivity_meissner_wentz12
from seamap_rt.scattering.short_waves import ShortWaves

__all__ = [
    "ShortWaves",
    "bragg_coefficients",
    "calibration_scale",
    "fresnel",
    "nrcs_bragg",
    "nrcs_gregers_hansen12",
    "nrcs_two_scale",
    "permittivity_meissner_wentz12",
    "sea_state_from_wind",
]
