"""From maps to a forecast: the phase-resolved sea around the boat, with its error, seconds ahead.

Free waves that obey the dispersion relation are fitted to what the last turns' maps, or other instruments, saw, with
the sea's own directional spectrum as what is expected of them. Reads maps and observations alone, never the truth.
"""

from .advice import advise
from .advice_motions import Hull
from .advice_windows import countdown, turn_windows
from .buoy_spectrum import spectrum_of_buoys
from .capytaine import read_capytaine
from .field import WaveField
from .forecast import forecast, highest_wave, quiet_windows
from .observations import Observations
from .reconstruction import Predictor, forecasts, issue, predictor_of, reconstruct, vessel_notes, vessel_of
from .spectrum import Spectrum
from .vessel import Box, Disc, Follower

__all__ = [
    "Box",
    "Disc",
    "Follower",
    "Hull",
    "Observations",
    "Predictor",
    "Spectrum",
    "WaveField",
    "advise",
    "countdown",
    "forecast",
    "forecasts",
    "highest_wave",
    "issue",
    "predictor_of",
    "quiet_windows",
    "read_capytaine",
    "reconstruct",
    "spectrum_of_buoys",
    "turn_windows",
    "vessel_notes",
    "vessel_of",
]
