"""From maps to a forecast: the phase-resolved sea around the boat, with its error, seconds ahead.

Free waves that obey the dispersion relation are fitted to what the last turns' maps, or other instruments, saw, with
the sea's own directional spectrum as what is expected of them. Reads maps and observations alone, never the truth.
"""

from .field import WaveField
from .forecast import forecast, quiet_windows
from .observations import Observations
from .predictor import Predictor
from .reconstruction import forecasts, reconstruct
from .spectrum import Spectrum
from .vessel import Box, Disc, Follower, read_capytaine

__all__ = [
    "Box",
    "Disc",
    "Follower",
    "Observations",
    "Predictor",
    "Spectrum",
    "WaveField",
    "forecast",
    "forecasts",
    "quiet_windows",
    "read_capytaine",
    "reconstruct",
]
