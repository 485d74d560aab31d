"""How far a waveguide's beam stands from the normal of its aperture: squint.

Slots at half a guide wavelength of the design frequency, to either side of the wall's middle by turns, are in phase at
that frequency alone. A guide that is fed in the middle is two halves that squint against each other, and looks ahead;
one that is fed at its end swings its beam away from the feed as the frequency rises (Elliott 2003).
"""

from __future__ import annotations

import numpy as np

from ..conventions import SPEED_OF_LIGHT
from ..settings import AntennaSettings


def squint_deg(settings: AntennaSettings, frequency_hz: float) -> float:
    """Degrees from the aperture's normal to the beam at a frequency [Hz]; positive away from the feed, clockwise.

    sin θ = λ/λg(f) − λ/λg(f₀) = √(1 − (fc/f)²) − (f₀/f) √(1 − (fc/f₀)²), with fc = c/(2 guide width) the cut-off of the
    guide's TE₁₀ mode. About the design frequency f₀ it grows by λg(f₀)/λ per relative change of frequency: 0.76° per
    percent in WR-90 at 10 GHz. ValueError at and below cut-off, and where no beam is left ahead.
    """
    if settings.feed == "centre":
        return 0.0
    design = frequency_hz if settings.design_frequency_hz is None else settings.design_frequency_hz
    cut_off = SPEED_OF_LIGHT / (2.0 * settings.guide_width_m)
    for name, value in (("radar.frequency_hz", frequency_hz), ("radar.antenna.design_frequency_hz", design)):
        if value <= cut_off:
            raise ValueError(
                f"{name} = {value:g}: must be above the waveguide's cut-off, {cut_off:.4g} Hz; "
                f"raise it, or widen radar.antenna.guide_width_m = {settings.guide_width_m:g}"
            )
    sine = np.sqrt(1.0 - (cut_off / frequency_hz) ** 2) - np.sqrt(design**2 - cut_off**2) / frequency_hz
    if sine <= -1.0:
        raise ValueError(
            f"radar.antenna.design_frequency_hz = {design:g}: must be nearer to the frequency, {frequency_hz:g} "
            "Hz, at which such slots have no beam ahead; lower it"
        )
    return float(np.degrees(np.arcsin(sine)))
