"""How many seeds a band of a few metres asks for."""

from __future__ import annotations

import numpy as np
from scipy.special import stdtrit

ASKED_M = 10.0  # half width of a band that tells masts a few metres apart
_MOST = 10_000


def seeds_for(have: int, half_m: float) -> str:
    """How many seeds narrow a band of `have` seeds, which is `half_m` to either side, to ASKED_M."""
    scatter = half_m * np.sqrt(have) / stdtrit(have - 1, 0.975)
    many = np.arange(2, _MOST)
    enough = many[stdtrit(many - 1, 0.975) * scatter / np.sqrt(many) <= ASKED_M]
    number = f"about {enough[0]}" if enough.size else f"more than {_MOST}"
    return f"Bands of ± {ASKED_M:.0f} m ask for {number} seeds"
