"""[radar.receiver]: from the mixer to complex gates."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le

from .section import Meaning, Section


class ReceiverSettings(Section):
    """From the mixer to complex range gates. The keys of the digital chain are ignored by `chain = "baseband"`."""

    chain: Literal["baseband", "digital"] = "baseband"
    """`baseband`: ideal complex gates; `digital`: the intermediate frequency undersampled, quantised and saturating,
    mixed down, filtered and decimated."""
    if_hz: Annotated[float, Gt(0.0), Le(1e10), Meaning("Hz", "intermediate frequency")] = 160e6
    """Intermediate frequency."""
    adc_rate_hz: Annotated[float, Ge(1e6), Le(1e10), Meaning("Hz", "samples per second")] = 200e6
    """Sampling rate of the analogue-to-digital converter."""
    adc_bits: Annotated[int, Ge(1), Le(24), Meaning("1", "a converter has bits; beyond 24 it would be none")] = 12
    """Bits of the converter."""
    full_scale_dbm: Annotated[float, Ge(-120.0), Le(30.0), Meaning("dBm", "of a sine at the antenna's port")] = -30.0
    """Full scale of the converter, as the power of a sine at the antenna's port."""
    gain: Literal["fixed", "agc"] = "fixed"
    """`agc`: automatic gain, which sets the full scale from the echoes of the dwell before."""
    agc_headroom_db: Annotated[float, Ge(0.0), Le(60.0), Meaning("dB", "of the full scale over the strongest echo")] = (
        6.0
    )
    """Headroom that automatic gain keeps between the strongest echo and full scale."""
    stc_exponent: Annotated[float, Ge(0.0), Le(8.0), Meaning("1", "0 is none; clutter falls as 3 to 7")] = 0.0
    """Sensitivity-time control: what comes from nearer than stc_range_m is weakened by (range/stc_range_m) to this, in
    power, and given back after the converter."""
    stc_range_m: Annotated[float, Ge(1e-3), Le(20_000.0), Meaning("m", "from which on nothing is weakened")] = 100.0
    """Range at which the sensitivity-time control ends."""
