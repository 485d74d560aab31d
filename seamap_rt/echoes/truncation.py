"""How much of the beam's sides and of the pulse's flanks a sum over facets may leave out, by the errors allowed.

What is left out, a share p of the power, comes from other water, which stands σ higher or lower. It turns the
interferometric phase of a sample as √p σ of height does, and of N samples as √(p/N) σ. So far aside, or in range, that
√p σ is a tenth of the error that the mesh may make, a facet need not be summed.
"""

from __future__ import annotations

from collections.abc import Hashable
from functools import lru_cache
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..radar.antenna import pattern_stamps
from ..radar.array import antenna_array
from ..radar.scan import BEAMS_BEYOND
from ..settings import RadarSettings
from .beams import two_way_beams
from .gating import tabulated
from .speckle import LEFT_OUT

_WITHIN = 0.1  # of the height error allowed, for a single sample: cells have tens
_MOST = 1e-4  # of the power, however flat the sea: in deep shadow nothing else may be heard
_MOST_SPECKLE = 1e-3  # of the power: covariances of pulses err by no more
_BEAMS = np.arange(20, round(20 * BEAMS_BEYOND) + 1) / 20.0


def truncation_share(elevation_std_m: float, height_error_m: float) -> float:
    """The share p of the power that may be left out, of a sea that stands σ = elevation_std_m high, rms."""
    return float(min(_MOST, (_WITHIN * height_error_m / max(elevation_std_m, 1e-9)) ** 2))


def beam_truncation(radar: RadarSettings, share: float) -> float:
    """Beam widths to either side of the boresight, 1 to 3, beyond which no more than that share of the power lies."""
    return _beam_truncation(cast(Hashable, radar), pattern_stamps(radar), share)  # frozen, and so hashable


@lru_cache(maxsize=8)
def _beam_truncation(settings: Hashable, _: Hashable, share: float) -> float:
    enough = np.flatnonzero(share_aside(cast(RadarSettings, settings), _BEAMS) <= share)
    return float(_BEAMS[enough[0]]) if share > 0.0 and enough.size else BEAMS_BEYOND


def share_aside(radar: RadarSettings, beams: ArrayLike) -> NDArray[np.float64]:
    """Share of the two-way power from more than so many beam widths to either side, of the path that has most."""
    aside = np.radians(np.minimum(np.asarray(beams) * antenna_array(radar).beam_deg, 90.0))
    return np.maximum(two_way_beams(radar).share_beyond(np.sin(aside)), 0.0)


def speckle_truncation(share: float) -> float:
    """The share p of a facet's power that may go on in slow time otherwise than by its law, where that share of all
    power may be left out. It is of the same water: no phase turns by √p, but what errs by chance errs by p of itself
    more or less. So p σ is that tenth here, and p at most 1e-3; where nothing may be left out, 1e-4."""
    return min(_MOST_SPECKLE, float(np.sqrt(share))) if share > 0.0 else LEFT_OUT


def truncation_error_m(radar: RadarSettings, elevation_std_m: float, share: float) -> float:
    """√p σ [m] of what is left out aside and in range; a staring antenna hears all that is aside."""
    aside = 0.0 if radar.scan == "staring" else float(share_aside(radar, [beam_truncation(radar, share)])[0])
    return float(np.sqrt(aside + tabulated(radar, share).left_out)) * elevation_std_m
