"""Douglas sea states as real numbers, and the wind that raises them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

_UNIT_WIND = 3.16  # m/s, the wind of sea state 1


def sea_state_from_wind(wind_speed: ArrayLike) -> NDArray[np.float64]:
    """Douglas sea state (a real number) of a fully developed sea under a wind [m/s]: (U10/3.16)^1.25."""
    return np.asarray((np.asarray(wind_speed, dtype=np.float64) / _UNIT_WIND) ** 1.25)


def wind_from_sea_state(sea_state: ArrayLike) -> NDArray[np.float64]:
    """Wind U10 [m/s] that raises a Douglas sea state (a real number) when it has blown long enough."""
    return np.asarray(_UNIT_WIND * np.asarray(sea_state, dtype=np.float64) ** 0.8)
