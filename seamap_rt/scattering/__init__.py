"""How the sea's surface returns the radar's power: Bragg waves, mirrors, breakers, measured means, calibration.

Settings (`[scattering]`):

    nrcs            two_scale (theory by facet, the default); nrl, git, tsc, hybrid: the mean of a measured model on all
                    that is seen; constant
    calibrated_to   the measured model that sets the mean of two_scale, or none
    breaking, hydrodynamic_modulation
                    breakers; short waves that the strain of the long ones gathers
    sea_spikes      breakers are bursts that run with their wave, grow and fade (`scattering.sea_spikes`)
    texture         breakers gather in patches that live for seconds (`scattering.texture`)
    doppler         full: Bragg waves of both directions and breakers move on the water at their own speeds;
                    orbital: they move with it
    permittivity    meissner_wentz12, meissner_wentz04, klein_swift77
    tracing.diffraction
                    knife_edge: the field over up to two crests, with its phase, at each facet and antenna; none:
                    geometric shadows (`seamap_rt.tracing`)

Theory, with no constant tuned here:

* First-order Bragg scattering by the ripples of Elfouhaily et al. (1997), tilted by the facet and averaged in closed
  tables over the Gaussian tilts of the waves that the mesh does not carry (Valenzuela 1978).
* Specular reflection near the vertical (Barrick 1968).
* Breakers by Kudryavtsev et al. (2003, 2005). They do not depend on polarization, and so raise HH.
* Relaxing hydrodynamic modulation (Alpers & Hasselmann 1978).

Mean models carry the names of their papers (`nrcs_gregers_hansen12`, `nrcs_horst78`, `nrcs_tsc90`, `nrcs_reilly90`) and
refuse winds and frequencies beyond the ranges of their papers unless `extrapolate` is set. The ranges of GIT, TSC and
Hybrid are taken from codes that quote the papers. A scene's mean in a wind beyond is the model's at the nearest wind of
its range, times theory's growth from there (`mean_level`); an account says so.

Calibration is one smooth scale by grazing angle, found once a run on samples of the whole circle, so that single turns
and narrow sectors keep their own random variation. NRL 2012 is a mean over all directions: the mean power around each
ring is its, and how that changes from up- to down-wind is theory's. The other models know it, and are met by a scale by
wind direction too.

Speckle is complex Gaussian for each facet. Its correlation is exp(−(τ/τc)²) times that of the scatterers' own motion.
The spread of power from cell to cell comes from the resolved waves, from sea spikes, and from patches of breakers where
they are asked for.

Evidence: validation/models/scattering.md.
"""

from seamap_rt.scattering.bragg import bragg_coefficients, nrcs_bragg, nrcs_two_scale
from seamap_rt.scattering.composite import FacetNrcs, nrcs_composite
from seamap_rt.scattering.empirical import (
    nrcs_gregers_hansen12,
    nrcs_horst78,
    nrcs_reilly90,
    nrcs_tsc90,
    sea_state_from_wind,
    wind_from_sea_state,
)
from seamap_rt.scattering.mean_models import MEAN_MODELS, MeanModel, mean_level, mean_nrcs
from seamap_rt.scattering.permittivity import (
    PERMITTIVITIES,
    fresnel,
    permittivity_klein_swift77,
    permittivity_meissner_wentz04,
    permittivity_meissner_wentz12,
)
from seamap_rt.scattering.sea_spikes import clutter_shape_watts_wicks90
from seamap_rt.scattering.short_waves import ShortWaves

__all__ = [
    "MEAN_MODELS",
    "PERMITTIVITIES",
    "FacetNrcs",
    "MeanModel",
    "ShortWaves",
    "bragg_coefficients",
    "clutter_shape_watts_wicks90",
    "fresnel",
    "mean_level",
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
