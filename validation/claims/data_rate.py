"""The study's data rate: which samples, of how many bits, of how many receivers, make the figure that it prints."""

from __future__ import annotations

from typing import NamedTuple

from seamap_rt.radar.receiver import bytes_of_a_pulse
from seamap_rt.radar.waveform import sample_spacing_m

CLAIM = 32e6  # B/s, printed by the design study of 2004 for 10 kHz over 400 m
TOLERANCE = 0.03  # one gate or sample more or less, and a rounded figure
WINDOW_M, PRF_HZ = 400.0, 10e3


class Reading(NamedTuple):
    """One way to read the study's figure."""

    receivers: int
    sampling: str
    bits: int  # of one sample, I and Q together
    bytes_per_second: float

    @property
    def fits(self) -> bool:
        """Whether it gives what the study printed, within 3 %."""
        return abs(self.bytes_per_second / CLAIM - 1.0) <= TOLERANCE


def claim_data_rate() -> list[Reading]:
    """The readings of the study's 32 MB/s: which samples, of how many bits, of one receiver or both, 0 to 400 m.

    Among them is the converter's full rate as complex samples, which holds nothing that real ones do not.
    """
    kinds = [("real 200 MS/s", 200e6, bits) for bits in (12, 16)]
    kinds += [(f"complex {rate} MS/s", 1e6 * rate, 2 * bits) for rate in (50, 100, 200) for bits in (12, 16, 24, 32)]
    return [
        Reading(
            receivers, sampling, bits, receivers * PRF_HZ * bytes_of_a_pulse(WINDOW_M, sample_spacing_m(rate), bits)
        )
        for receivers in (1, 2)
        for sampling, rate, bits in kinds
    ]
