"""[radar.receiver]: from the mixer to complex gates."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le

from .limits import Meaning
from .section import Section


class ReceiverSettings(Section):
    """From the mixer to complex range gates. The keys of the digital chain are ignored by `chain = "baseband"`."""

    chain: Annotated[
        Literal["baseband", "digital"],
        Meaning(
            "`baseband`: ideal complex gates; `digital`: the intermediate frequency undersampled, quantised and "
            "saturating, mixed down, filtered and decimated."
        ),
    ] = "baseband"
    if_hz: Annotated[
        float, Gt(0.0), Le(1e10), Meaning("Intermediate frequency.", unit="Hz", reason="intermediate frequency")
    ] = 160e6
    adc_rate_hz: Annotated[
        float,
        Ge(1e6),
        Le(1e10),
        Meaning("Sampling rate of the analogue-to-digital converter.", unit="Hz", reason="samples per second"),
    ] = 200e6
    adc_bits: Annotated[
        int,
        Ge(1),
        Le(24),
        Meaning("Bits of the converter.", unit="1", reason="a converter has bits; beyond 24 it would be none"),
    ] = 12
    full_scale_dbm: Annotated[
        float,
        Ge(-120.0),
        Le(30.0),
        Meaning(
            "Full scale of the converter, as the power of a sine at the antenna's port.",
            unit="dBm",
            reason="of a sine at the antenna's port",
        ),
    ] = -30.0
    gain: Annotated[
        Literal["fixed", "agc"],
        Meaning("`agc`: automatic gain, which sets the full scale from the echoes of the dwell before."),
    ] = "fixed"
    agc_headroom_db: Annotated[
        float,
        Ge(0.0),
        Le(60.0),
        Meaning(
            "Headroom that automatic gain keeps between the strongest echo and full scale.",
            unit="dB",
            reason="of the full scale over the strongest echo",
        ),
    ] = 6.0
    stc_exponent: Annotated[
        float,
        Ge(0.0),
        Le(8.0),
        Meaning(
            "Sensitivity-time control: what comes from nearer than stc_range_m is weakened by (range/stc_range_m) to "
            "this, in power, and given back after the converter.",
            unit="1",
            reason="0 is none; clutter falls as 3 to 7",
        ),
    ] = 0.0
    stc_range_m: Annotated[
        float,
        Ge(1e-3),
        Le(20_000.0),
        Meaning(
            "Range at which the sensitivity-time control ends.", unit="m", reason="from which on nothing is weakened"
        ),
    ] = 100.0
