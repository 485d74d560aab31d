"""The study's weakest sea: under which assumptions σ0 = −55 dB stands out of the noise at 100 m."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import db, from_db, radar_wavelength
from seamap_rt.products.link import CURVE_POINTS, FURTHEST_M, simulated_power
from seamap_rt.radar import link
from seamap_rt.radar.antenna import antenna
from seamap_rt.settings import RadarSettings


class MinimumNrcs(NamedTuple):
    """The weakest sea that stands out of the noise, under one set of assumptions."""

    assumption: str
    gain_dbi: float
    integration: str
    minimum_db: float  # σ0 at the claim's range
    met: bool
    reached_m: float  # range at which σ0 of the claim has a signal to noise ratio of 0 dB


def aperture_gain(radar: RadarSettings, efficiency: float = 1.0) -> float:
    """4π A η/λ² of the aperture's own area, the gain (a ratio) that textbooks start from."""
    area = radar.antenna.width_m * radar.antenna.height_m
    return 4.0 * np.pi * efficiency * area / radar_wavelength(radar.frequency_hz) ** 2


def claim_minimum_nrcs(
    radar: RadarSettings, decorrelation_time_s: float = 0.010, claim_db: float = -55.0, range_m: float = 100.0
) -> list[MinimumNrcs]:
    """Under which assumptions σ0 = −55 dB has 0 dB of signal to noise at 100 m, and at what range each has that.

    The textbook's echo with the gain of 100 % and 60 % of the aperture's area and with that of the scene's own pattern,
    and the simulator's echo; each for one pulse and for a dwell added without and with phase.
    """
    ranges = np.geomspace(1.001 * radar.height_m, FURTHEST_M, 2 * CURVE_POINTS)
    own = antenna(radar).gain
    echoes: list[tuple[str, float, Callable[[NDArray[np.float64]], NDArray[np.float64]]]] = [
        (words, gain, lambda r, gain=gain: link.textbook_power(radar, 1.0, r, gain))
        for words, gain in (
            ("textbook, 100 % of the aperture", aperture_gain(radar)),
            ("textbook, 60 % of the aperture", aperture_gain(radar, 0.6)),
            ("textbook, gain of the pattern", own),
        )
    ]
    echoes.append(("simulator, with its losses", own, lambda r: simulated_power(radar, r)))
    rows: list[MinimumNrcs] = []
    for words, gain, echo in echoes:
        there, everywhere = echo(np.array([range_m])), echo(ranges)
        for integration in link.integrations(radar, decorrelation_time_s):
            minimum = float(db(link.minimum_nrcs(radar, there, integration.gain))[0])
            reached = link.furthest(ranges, from_db(claim_db) / link.minimum_nrcs(radar, everywhere, integration.gain))
            rows.append(MinimumNrcs(words, float(db(gain)), integration.name, minimum, minimum <= claim_db, reached))
    return rows
