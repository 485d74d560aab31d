"""What is taken from the voltages of a turn, in one pass: interferograms of one way and of two, and lag products.

The upper receiver's channel over the lower's, as it is given or as measured on the echoes by reciprocity.

From the lower antenna to the upper one an echo takes the very path that it takes from the upper to the lower. With T
and R what transmitter and receiver put to it, V₀₁ = T₀ R₁ s and V₁₀ = T₁ R₀ s: their ratio is R₁/R₀ · T₀/T₁. One
transmitter that is switched between the antennas leaves the receivers' ratio; what lies between the switch and an
antenna's phase centre is in T and R alike, cancels, and stays unknown. Noise is taken to be amplified as the echo is.

Coherent integration: pulses are added before they are multiplied, for echoes below a single pulse's noise.

The sum of the pulses that lie within half of `coherent_s` of a pulse, times that pulse of the other receiver, is a sum
of products of pulses that lie apart. Each is freed of the Doppler phase that the velocity about the cell gives it, and
they are averaged: K products for each pulse instead of one leave 1/K of the noise's beat with itself. Lags of both
signs are treated alike, so that an error of the velocity costs some power and changes no phase.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..conventions import from_db
from ..errors import SchemaError
from ..settings import RetrievalSettings
from .description import RadarDescription
from .dwells import Dwells
from .products import (
    Products,
    PulsePairs,
    Rows,
    dwell_means,
    half_turns,
    neighbouring_pulses,
    rows_apart,
    same_pulses,
    sampled,
    two_way_pairs,
)
from .velocity import NO_LAGS, Lag, phase_rate, pulse_pair_lags
from .windows import Covariance


@dataclass(frozen=True)
class Channel:
    """Complex gain of the upper receiver's channel over the lower's."""

    ratio: complex = 1.0 + 0.0j

    @classmethod
    def from_gain(cls, gain_db: float, phase_deg: float) -> Channel:
        """The upper receiver's voltage gain over the lower's, from a power gain [dB] and a phase [deg]."""
        return cls(complex(np.sqrt(from_db(gain_db)) * np.exp(1j * np.radians(phase_deg))))

    def corrected(self, covariance: Covariance) -> Covariance:
        """As it would be had the upper receiver been the lower's like."""
        if self.ratio == 1.0:
            return covariance
        cross, upper = covariance.cross / np.conj(self.ratio), covariance.upper / abs(self.ratio) ** 2
        return replace(covariance, cross=cross, upper=upper)

    def noise_power(self, recorded: float) -> float:
        """Noise [W] of either receiver once corrected, of the mean of both as it was recorded."""
        return 2.0 * recorded / (1.0 + abs(self.ratio) ** 2)


def cross_path_products(
    heard: NDArray[np.bool_],
    transmitter: NDArray[np.integer],
    antennas: tuple[int, int],
    time: NDArray[np.float64],
    interval: float,
    receivers: tuple[int, int],
) -> list[list[Products]]:
    """Products of what goes from the lower antenna to the upper with what goes back, on neighbouring pulses: those
    that follow and those that go before, whose Doppler phases cancel.

    heard (pulse, 2) lower, upper receiver. Raises SchemaError where there are none.
    """
    up, down = heard[:, 1] & (transmitter == antennas[0]), heard[:, 0] & (transmitter == antennas[1])
    following = np.abs(np.diff(time) - interval) < 0.5 * interval
    after, before = np.flatnonzero(following & up[:-1] & down[1:]), np.flatnonzero(following & down[:-1] & up[1:])
    if not (after.size and before.size):
        raise SchemaError(
            "echoes: retrieval.channels = 'from_cross_paths': must hold, on neighbouring pulses, the lower antenna's "
            "pulse at the upper receiver and the upper one's at the lower; record both receivers while the "
            "transmitters alternate, or give the channel by retrieval.channel_gain_db and channel_phase_deg"
        )
    return [
        [Products((after, receivers[1]), (after + 1, receivers[0]), after)],
        [Products((before + 1, receivers[1]), (before, receivers[0]), before + 1)],
    ]


def ratio_of(crossings: Sequence[Covariance]) -> Channel:
    """The channel that the products of both directions give, over all cells together.

    Raises SchemaError where a receiver has no echo on its cross path.
    """
    known = np.logical_and.reduce([each.has_value for each in crossings])
    product = sum(complex(each.cross[known].sum()) for each in crossings)
    up, down = (sum(float(getattr(c, name)[known].sum()) for c in crossings) for name in ("lower", "upper"))
    if not (up > 0.0 and down > 0.0):
        raise SchemaError(
            "echoes: retrieval.channels = 'from_cross_paths': must hold echoes on both cross paths; one of the "
            "receivers heard nothing"
        )
    return Channel(complex(np.sqrt(up / down) * np.exp(1j * np.angle(product))))


# Gates and looks over which the velocity is averaged: a single cell's, where it is needed, is mostly noise.
_VELOCITY_WINDOW = (np.ones(5), np.ones(3))


@dataclass(frozen=True)
class CoherentProducts:
    """Rows of the lower and the upper receiver that are multiplied, and the pulses whose dwells they count to; how
    much longer [s] each lag, lower less upper, is than that of the pair it extends."""

    members: tuple[tuple[Rows, Rows, Rows], ...]
    beyond: tuple[float, ...]


def extended(
    pairs: PulsePairs,
    transmitter: NDArray[np.integer],
    heard: NDArray[np.bool_],
    time: NDArray[np.float64],
    interval: float,
    coherent_s: float,
    cycle: int,
) -> CoherentProducts:
    """The pairs themselves, and those with the lower pulses of the same transmitter up to half of coherent_s away,
    `cycle` pulses apart; heard (pulse, 2)."""
    members, beyonds = [], []
    for lower, upper in pairs.pairs:
        lag = int(np.sign(np.median(lower - upper))) if lower.size else 0
        members.append((lower, upper, lower))
        partner = np.full(time.size, -1)
        partner[lower] = upper
        beyonds.append(0.0)
        for step in range(1, int(0.5 * coherent_s / (cycle * interval) + 1e-9) + 1):
            for beyond in (away := step * cycle * interval, -away) if lag == 0 else (lag * step * cycle * interval,):
                owner, other = rows_apart(time, beyond, interval)
                good = (partner[owner] >= 0) & heard[other, 0] & (transmitter[other] == transmitter[owner])
                if good.any():
                    members.append((other[good], partner[owner[good]], owner[good]))
                    beyonds.append(beyond)
    return CoherentProducts(tuple(members), tuple(beyonds))


def integrated(means: Sequence[Covariance], extended: CoherentProducts, lags: Sequence[Lag]) -> Covariance:
    """Their mean, each freed of the Doppler phase that it has beyond that of the pair it extends; powers are those of
    single pulses, noise and all."""
    base = [each for each, beyond in zip(means, extended.beyond, strict=True) if beyond == 0.0]
    cross: NDArray[np.complex128] = np.sum([each.cross for each in base], axis=0)
    count = np.full(np.shape(cross), float(len(base)))
    if len(base) < len(means):
        rate = np.nan_to_num(
            phase_rate([Lag(each.seconds, each.products.windowed(*_VELOCITY_WINDOW), each.share) for each in lags])
        )
        for each, beyond in zip(means, extended.beyond, strict=True):
            if beyond:
                # The first and the last looks have no pulses before and after them.
                cross = cross + np.where(each.has_value, each.cross * np.exp(-1j * rate * beyond), 0.0)
                count = count + each.has_value
    return Covariance(
        np.asarray(cross / count, dtype=np.complex128),
        np.asarray(sum(each.lower for each in base) / len(base)),
        np.asarray(sum(each.upper for each in base) / len(base)),
    )


@dataclass(frozen=True)
class PulseComparison:
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
    ) -> PulseComparison:
        """voltage (pulse, receiver, gate) of all receivers; antennas: of settings.receivers. Raises SchemaError where
        receivers are said to alternate and do not."""
        heard = sampled(voltage)[:, list(settings.receivers)]
        if radar.alternating:
            pairs = neighbouring_pulses(heard, time, radar.interval, settings.pulse_pairs)
            return cls(heard, *((None, pairs) if radar.paths == 2 else (pairs, None)))
        two = None
        if settings.paths == "best" and radar.coherent:
            two = two_way_pairs(heard, transmitter, antennas, time, radar.interval, settings.pulse_pairs)
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
        paired: PulseComparison,
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
            lags = pulse_pair_lags(transmitter, paired.heard, time, radar.interval, dwells.median_pulses, receivers)
        by_paths: dict[int, CoherentProducts] = {}
        for paths, pairs in ((1, paired.one), (2, paired.two)):
            if pairs is not None:
                by_paths[paths] = extended(
                    pairs, transmitter, paired.heard, time, radar.interval, settings.coherent_s, lags.cycle
                )
        cross = []
        if settings.channels == "from_cross_paths":
            cross = cross_path_products(paired.heard, transmitter, antennas, time, radar.interval, receivers)
        kinds: list[list[Products]] = []
        for paths, each in by_paths.items():
            level = half_turns(levels[paths]) if levels else None
            kinds += [[Products((n, receivers[0]), (m, receivers[1]), owner, level)] for n, m, owner in each.members]
        means = iter(dwell_means(voltage, dwells, [*kinds, *cross, *lags.kinds]))
        covariances = {paths: [next(means) for _ in each.members] for paths, each in by_paths.items()}
        channel = Channel.from_gain(settings.channel_gain_db, settings.channel_phase_deg)
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
