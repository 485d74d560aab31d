"""An outlook as lines of text."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..conventions import written
from ..measured import FULLY_MEASURED
from .model import Likely

_STEPS = (25.0, 50.0, 100.0, 250.0, 500.0)  # m, of which the finest that gives at most _LINES is taken
_LINES = 12
_NOTHING = 0.05  # per cent: a chance that is less is none


def outlook_rows(found: Likely) -> Iterator[str]:
    """The two radii first, then a table by range."""
    radius, reach = found.figures["fully_measured_radius_m"], found.figures["reach_m"]
    if radius is None:
        yield "no waves: nothing is there to measure"
    else:
        end = "at least " if found.figures["reach_to_the_end"] else ""
        yield f"fully measured radius about {radius:.0f} m, reach {end}{reach:.0f} m (a model, not a simulation)"
    seen, answered = (_mean(found.profile[name]) for name in ("seen_fraction", "answered_fraction"))
    if reach == 0.0 and seen > 0.5 > answered:
        yield (
            "the echo lacks, not the light: raise radar.transmit_power_w or the antennas' gain, or point the beam at "
            "the sea by radar.tilt_deg"
        )
    if radius is not None and found.motion:
        cost = written(max(found.figures["radius_at_rest_m"] - radius, 0.0), 0)
        yield f"the boat's motion costs {cost} m of that radius: {found.motion}"
    if found.left_out:
        yield f"it does not know: {found.left_out}"
    yield FULLY_MEASURED
    yield (
        "visible: share of the sea's area that both antennas see; cells seen: those more than half visible; answered: "
        "with a sure height; height error: rms of these; SNR: of one pulse; score: 1 for a perfect height, 0 for none"
    )
    yield "range (m)  visible  cells seen  of these answered  height error (m)  SNR (dB)  score"
    ranges = found.range
    step = next((each for each in _STEPS if np.ptp(ranges) / each <= _LINES), _STEPS[-1])
    for middle in np.arange(np.ceil(ranges[0] / step) * step, ranges[-1] + 0.5 * step, step):
        inside = np.abs(ranges - middle) <= 0.25 * step
        here = {name: _mean(values[inside]) for name, values in found.profile.items()}
        shares = [_share(here[f"{name}_fraction"]) for name in ("visible", "seen", "answered")]
        error, snr, score = (here[name] for name in ("height_error", "snr_db", "quality"))
        error = error if 100.0 * here["answered_fraction"] > _NOTHING else np.nan
        yield (
            f"{middle:9.0f}  {shares[0]:>7}  {shares[1]:>10}  {shares[2]:>17}  {_at_least(error, 1e-3):>16}  "
            f"{written(snr, 0):>8}  {_at_least(score, 5e-4):>5}"
        )


def _mean(values: NDArray[np.float64]) -> float:
    """Of those that are numbers; NaN where there are none."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else np.nan


def _share(value: float) -> str:
    share = 100.0 * value
    return written(share if share > _NOTHING else 0.0 * share, 0) + (" %" if np.isfinite(share) else "")


def _at_least(value: float, least: float) -> str:
    """With two digits; what is less than the least that counts is none."""
    return f"<{least:g}" if value < least else written(value, 2)
