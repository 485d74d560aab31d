"""The water: spectra, spreading, dispersion, and the evolving surface that is drawn from them."""

from . import dispersion, spectra, spreading
from .components import Components, SurfaceState, direct_sum
from .surface import Resolved, Sea, realize

__all__ = [
    "Components",
    "Resolved",
    "Sea",
    "SurfaceState",
    "direct_sum",
    "dispersion",
    "realize",
    "spectra",
    "spreading",
]
