"""The water: spectra, spreading, dispersion, and the evolving surface that is drawn from them."""

from ..physics import dispersion
from . import spectra, spreading
from .components import Components, SurfaceState, direct_sum
from .facts import Resolved
from .realisation import realize, resolution
from .surface import Sea
from .systems import WaveFacts, directional_density, spectral_system, wave_facts

__all__ = [
    "Components",
    "Resolved",
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
