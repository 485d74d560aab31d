"""The heights themselves, whether there are any, and whether a sea can have them; and what a finding is."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import xarray as xr

from ..dataset import QUALITY_FLAGS

Verdict = Literal["good", "doubtful", "wrong", "unknown"]


class Finding(NamedTuple):
    """Of one thing. "wrong" is sure, "doubtful" probable; "unknown" cannot be told from this data."""

    what: str
    verdict: Verdict
    says: str  # with the figure that it rests on
    remedy: str = ""

    @property
    def line(self) -> str:
        return f"{self.what}: {self.says}{f'; {self.remedy}' if self.remedy else ''}"


def judged(what: str, doubtful: bool, says: str, remedy: str) -> Finding:
    """A finding that is good, or doubtful and has a remedy."""
    return Finding(what, "doubtful", says, remedy) if doubtful else Finding(what, "good", says)


_FEWEST = 0.05  # of the cells
_STEEPEST = 0.5  # of the mast's height, by the waves' standard deviation: as high a sea washes over the antenna


def heights(polar: xr.Dataset, mast: float) -> list[Finding]:
    """Of polar maps; mast: height of the antennas, m."""
    height = polar["height"].values
    known = np.isfinite(height)
    share = float(known.mean())
    flags = polar["quality"].values
    why = {name: float(np.mean((flags & bit) != 0)) for name, bit in QUALITY_FLAGS.items()}
    worst = max(why, key=lambda name: why[name])
    answered = judged(
        "cells",
        share < _FEWEST,
        f"{100.0 * share:.2g} % hold a height"
        + (f", {100.0 * why[worst]:.0f} % are flagged {worst}" if share < 1.0 else ""),
        "look whether the echoes stand clear of the noise, and of what stands still",
    )
    if not known.any():
        return [answered]
    middle = np.median(height[known])
    spread = 1.4826 * float(np.median(np.abs(height[known] - middle)))
    return [
        answered,
        judged(
            "heights",
            spread > _STEEPEST * mast,
            f"they scatter by {spread:.2f} m (of a standard deviation) under a mast of {mast:.3g} m",
            "no such sea leaves it dry: check baseline_m, frequency_hz, gate_m, first_gate_m and phase_offset_deg",
        ),
    ]
