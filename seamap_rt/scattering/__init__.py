"""How the sea's surface returns the radar's power: Bragg waves, mirrors, breakers, measured means, calibration."""

from seamap_rt.scattering.bragg import bragg_coefficients, nrcs_bragg, nrcs_two_scale
from seamap_rt.scattering.calibration import calibration_scale
from seamap_rt.scattering.composite import FacetNrcs, nrcs_composite
from seamap_rt.scattering.empirical import (
    nrcs_gregers_hansen12,
    nrcs_horst78,
    nrcs_reilly90,
    nrcs_tsc90,
    sea_state_from_wind,
    wind_from_sea_state,
)
from seamap_rt.scattering.mean_models import MEAN_MODELS, MeanModel, mean_nrcs
from seamap_rt.scattering.permittivity import (
    PERMITTIVITIES,
    fresnel,
    permittivity_klein_swift77,
    permittivity_meissner_wentz04,
    permittivity_meissner_wentz12,
)
from seamap_rt.scattering.short_waves import ShortWaves

__all__ = [
    "MEAN_MODELS",
    "PERMITTIVITIES",
    "FacetNrcs",
    "MeanModel",
    "ShortWaves",
    "bragg_coefficients",
    "calibration_scale",
    "fresnel",
    "mean_nrcs",
    "nrcs_bragg",
    "nrcs_composite",
    "nrcs_gregers_hansen12",
    "nrcs_horst78",
    "nrcs_reilly90",
    "nrcs_tsc90",
    "nrcs_two_scale",
    "permittivity_klein_swift77",
    "permittivity_meissner_wentz04",
    "permittivity_meissner_wentz12",
    "sea_state_from_wind",
    "wind_from_sea_state",
]
