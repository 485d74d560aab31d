"""The water: spectra, spreading, dispersion, and the evolving surface that is drawn from them.

Wave systems. Any number of systems (wind sea, swells) add up. Each `[[sea.waves]]` has a spectrum, a direction and a
spreading of its own; `scenes/wind_and_swell.toml` shows the keys, those of a measured spectrum too.

    spectrum     pierson_moskowitz, jonswap, tma (by wind and fetch, or by Hs and Tp), elfouhaily (peak to ripples),
                 file (NDBC, SWAN, WAVEWATCH III, or wavespectra's own), sinusoid, flat
    spreading    cos2s, mitsuyasu, hasselmann, donelan_banner, elfouhaily, long_crested
    sea.model    linear; choppy: first-order Lagrangian waves, whose crests are sharper; or recorded, see below
    sea.depth_m, sea.current_m_s
                 full dispersion with depth and surface tension; a uniform current carries the waves
    sea.resolution_m or sea.energy_fraction
                 the shortest wave on the surface, or the share of the variance that is to be on it

Resolved waves. Which waves the surface carries decides the shadowing, so each run states it (`Sea.resolved`, metrics,
report). Shorter waves belong to `seamap_rt.scattering`: its spectrum (Elfouhaily et al. 1997, of the scene's wind)
begins at the wavenumber where that of the mesh ends, so that no wave is missing and none counts twice. This holds as
long as the mesh is finer than the waves; it is, unless `tracing.facet_m` is set above `sea.resolution_m`, and then a
run says so. Where the two spectra do not meet, the step in level is stated in dB.

Choppy waves are evaluated at fixed places on the ground, by finding the water that stands there. Significant height
and mean level stay those that were set, by closed forms. Crests that fold over are counted and flagged, and a scene is
refused if more than 2 % of its water is folded at time 0. The elevation has no skewness at this order; the report puts
3kσ, that of a second-order sea, beside it.

Recorded seas. `sea.model = "recorded"` takes the surface of `sea.file`, frame by frame, however large: a nonlinear
simulation's, or a measured patch (NetCDF, Zarr, HOS-ocean's 3d.dat, WASS's grids, Schwendeman & Thomson's Matlab files;
`seamap_rt.io.recorded_sea` has the names, axes and units that it knows). Spacing, depth and the directional spectrum,
by linear dispersion, come from the file where the scene leaves them out. What is made up between frames, and across
gaps that cameras leave, has an error that is stated among the resolved facts; more than a tenth of the waves is
refused, as is a record that ends too early. A patch that ends within the range circle is refused, or goes on as
`sea.beyond` says, level or mirrored; its reach is reported beforehand, and nothing beyond is judged
(`Sea.is_known`), nor in a rim of 5 % of its side. The water's flow is that of the file's surface potential or
velocities, and of linear waves where it has none: both to first order, as is the sum of `components`.

    sea = realize(scene.sea, seed=1)
    sea.elevation(x, y, t), sea.slopes(x, y, t), sea.velocity(x, y, t)    # arrays that broadcast; m, m/s

Evidence: validation/models/sea.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_attributes

if TYPE_CHECKING:
    from ..physics import dispersion
    from . import spectra, spreading
    from .facts import ResolvedSea, ResolvedWaves
    from .realisation import realize, resolution
    from .surface import Sea
    from .systems import WaveFacts, directional_density, spectral_system, wave_facts
    from .wave_trains import Components, SurfaceState, direct_sum

__all__ = [
    "Components",
    "ResolvedSea",
    "ResolvedWaves",
    "Sea",
    "SurfaceState",
    "WaveFacts",
    "direct_sum",
    "directional_density",
    "dispersion",
    "realize",
    "resolution",
    "spectra",
    "spectral_system",
    "spreading",
    "wave_facts",
]

__getattr__ = lazy_attributes(
    __name__,
    {
        ".": "spectra spreading",
        "..physics.": "dispersion",
        "facts": "ResolvedSea ResolvedWaves",
        "realisation": "realize resolution",
        "surface": "Sea",
        "systems": "WaveFacts directional_density spectral_system wave_facts",
        "wave_trains": "Components SurfaceState direct_sum",
    },
    {"Resolved": "ResolvedSea"},
)
