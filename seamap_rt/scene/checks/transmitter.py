"""The transmitter: that nothing is asked of phases from pulse to pulse which it does not keep."""

from __future__ import annotations

from ...radar.transmitter import comparing_pulses, pulse_coherence
from ...settings import RadarSettings, RetrievalSettings


def check_pulses_compare(radar: RadarSettings, retrieval: RetrievalSettings) -> None:
    """A magnetron whose phases are not measured serves what compares the receivers of one pulse alone."""
    asked = comparing_pulses(radar.interferogram, retrieval)
    if asked is None or pulse_coherence(radar) > 0.0:
        return
    key, why, instead = asked
    key = key if key.startswith("retrieval.") else f"radar.{key}"
    raise ValueError(
        f"{key}: cannot be with radar.transmitter = 'magnetron', which starts each pulse with a random phase ({why}); "
        f"{instead}, or set radar.coherent_on_receive = true, which takes that phase off"
    )
