"""What is taken from the voltages of a turn, in one pass: interferograms of one way and of two, and lag products."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...settings import RetrievalSettings
from ..input.description import RadarDescription
from .channels import Channel, crossing, ratio_of
from .coherent import Extended, extended, integrated
from .dwells import Dwells
from .pairs import PulsePairs, both_ways_of, neighbouring_pulses, same_pulses, sampled
from .products import Products, dwell_means, half_turns
from .velocity import NO_LAGS, Lag, pulse_pair_lags
from .windows import Covariance


@dataclass(frozen=True)
class Paired:
    """Which pulses of two receivers are compared, by how many of its ways p an echo's phase differs between them.

    one: the same pulse at both receivers, or, of receivers that alternate, neighbours of one transmitter; two: each
    antenna hears its own. What the echoes do not hold is None.
    """

    heard: NDArray[np.bool_]  # (pulse, 2) lower, upper receiver
    one: PulsePairs | None
    two: PulsePairs | None

    @classmethod
    def of(
        cls,
        voltage: NDArray[np.complex64],
        transmitter: NDArray[np.integer],
        time: NDArray[np.float64],
        antennas: tuple[int, int],
        radar: RadarDescription,
        settings: RetrievalSettings,
    ) -> Paired:
        """voltage (pulse, receiver, gate) of all receivers; antennas: of settings.receivers. Raises SchemaError where
        receivers are said to alternate and do not."""
        heard = sampled(voltage)[:, list(settings.receivers)]
        if radar.alternating:
            pairs = neighbouring_pulses(heard, time, radar.interval, settings.pulse_pairs)
            return cls(heard, *((None, pairs) if radar.paths == 2 else (pairs, None)))
        two = None
        if settings.paths == "best" and radar.coherent:
            two = both_ways_of(heard, transmitter, antennas, time, radar.interval, settings.pulse_pairs)
        return cls(heard, same_pulses(heard), two)


@dataclass(frozen=True)
class DwellSums:
    """Means over each cell's dwell; cells are (look, gate), powers have their noise, `noise_power` [W]."""

    one: Covariance | None  # of one way, p = 1
    two: Covariance | None  # of both ways, p = 2
    lags: tuple[Lag, ...]  # ⟨V(t + τ) V*(t)⟩ of one transmitter and receiver, shortest τ first
    noise_square: Mapping[int, float]  # p → what is left of the noise's beat with itself, see PulsePairs
    channel: Channel
    noise_power: float

    @classmethod
    def of(
        cls,
        voltage: NDArray[np.complex64],
        transmitter: NDArray[np.integer],
        time: NDArray[np.float64],
        paired: Paired,
        dwells: Dwells,
        antennas: tuple[int, int],
        radar: RadarDescription,
        settings: RetrievalSettings,
        levels: Mapping[int, NDArray[np.float64]] | None = None,
    ) -> DwellSums:
        """voltage (pulse, receiver, gate). levels: of p, phase (pulse, gate) of mean sea level on each pulse, which
        products are freed of where the antennas move (`turned` gives it back).

        Raises SchemaError where the channels are to be found from cross paths, and there are none.
        """
        receivers, transmitter = settings.receivers, np.asarray(transmitter)
        lags = NO_LAGS
        if radar.coherent:
            lags = pulse_pair_lags(transmitter, paired.heard, time, radar.interval, dwells.usual, receivers)
        by_paths: dict[int, Extended] = {}
        for paths, pairs in ((1, paired.one), (2, paired.two)):
            if pairs is not None:
                by_paths[paths] = extended(
                    pairs, transmitter, paired.heard, time, radar.interval, settings.coherent_s, lags.cycle
                )
        cross = []
        if settings.channels == "from_cross_paths":
            cross = crossing(paired.heard, transmitter, antennas, time, radar.interval, receivers)
        kinds: list[list[Products]] = []
        for paths, each in by_paths.items():
            level = half_turns(levels[paths]) if levels else None
            kinds += [[Products((n, receivers[0]), (m, receivers[1]), owner, level)] for n, m, owner in each.members]
        means = iter(dwell_means(voltage, dwells, [*kinds, *cross, *lags.kinds]))
        covariances = {paths: [next(means) for _ in each.members] for paths, each in by_paths.items()}
        channel = Channel.given(settings.channel_gain_db, settings.channel_phase_deg)
        if cross:
            channel = ratio_of([next(means) for _ in cross])
        measured = lags.lags(means)
        sums = {
            paths: channel.corrected(integrated(covariances[paths], each, measured)) for paths, each in by_paths.items()
        }
        return cls(
            sums.get(1),
            sums.get(2),
            measured,
            {paths: 1.0 / len(each.members) for paths, each in by_paths.items()},
            channel,
            channel.noise_power(radar.noise_power),
        )
