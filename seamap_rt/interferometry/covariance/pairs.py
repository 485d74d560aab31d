"""Which pulses the interferogram compares: the same one of both receivers, or neighbours where the receivers alternate.

Between neighbours τ apart an echo that recedes at v turns its phase by 2k v τ: pairs with the pulse after (forward)
see that turn one way, those with the pulse before the other way, and the mean of both products has none of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import SchemaError

Rows = NDArray[np.intp]


@dataclass(frozen=True)
class PulsePairs:
    """Rows of the echoes: where each receiver is sampled, and the (lower, upper) rows that are multiplied."""

    lower: Rows
    upper: Rows
    pairs: tuple[tuple[Rows, Rows], ...]  # forward, backward, or both

    @property
    def members(self) -> tuple[Rows, Rows]:
        """Rows of all pulses in the products, each as often as it is in one, and the lower pulse of that product: how
        the array stood for a dwell is their mean, not that of all pulses, from which it is half a pulse off."""
        rows = np.concatenate([row for pair in self.pairs for row in pair])
        return rows, np.concatenate([n for n, _ in self.pairs for _ in range(2)])

    @property
    def noise_square(self) -> float:
        """How much of the noise's own beat is left per lower pulse.

        In the mean of forward and backward products each lower pulse meets two upper ones, so that the products of
        noise with noise are twice as many; those of noise with echo are no more than the pulses themselves.
        """
        return 1.0 / len(self.pairs)


def sampled(voltage: NDArray[np.complex64]) -> NDArray[np.bool_]:
    """Whether each receiver was sampled on each pulse, (pulse, receiver), of voltage (pulse, receiver, gate)."""
    known = np.asarray(np.isfinite(voltage[:, :, voltage.shape[2] // 2].real))  # one gate decides for most pulses
    rest = np.nonzero(~known)
    known[rest] = np.isfinite(voltage[rest].real).any(axis=1)
    return known


def neighbouring_pulses(heard: NDArray[np.bool_], time: NDArray[np.float64], interval: float, which: str) -> PulsePairs:
    """Pairs of alternating pulses. heard (pulse, 2) lower, upper; time (pulse,) and interval [s]; which: forward,
    backward or both. Only neighbours one interval apart are pairs: none is made across pulses that are missing.

    Raises SchemaError where receivers do not alternate, or are never neighbours in the order that is requested.
    """
    if heard.all(axis=1).any():
        raise SchemaError(
            "echoes: interferogram = 'alternating_pulse', yet both receivers hold voltages on the same pulse; "
            "set those that were not sampled to NaN"
        )
    following = np.abs(np.diff(time) - interval) < 0.5 * interval
    before, after = heard[:-1], heard[1:]
    forward = np.flatnonzero(following & before[:, 0] & after[:, 1])
    backward = np.flatnonzero(following & before[:, 1] & after[:, 0])
    made = {"forward": (forward, forward + 1), "backward": (backward + 1, backward)}
    chosen = tuple(made) if which == "both" else (which,)
    if heard.any(axis=0).all() and not all(made[each][0].size for each in chosen):
        raise SchemaError(
            f"echoes: no two neighbouring pulses make a {' and a '.join(chosen)} pair of the receivers; choose others "
            "by retrieval.receivers, or one direction by retrieval.pulse_pairs"
        )
    lower, upper = (np.flatnonzero(heard[:, receiver]) for receiver in (0, 1))
    return PulsePairs(lower, upper, tuple(made[each] for each in chosen))


def same_pulses(heard: NDArray[np.bool_]) -> PulsePairs:
    """Each pulse that both receivers heard, with itself. heard (pulse, 2)."""
    rows = np.flatnonzero(heard.all(axis=1))
    return PulsePairs(rows, rows, ((rows, rows),))


def both_ways_of(
    heard: NDArray[np.bool_],
    transmitter: NDArray[np.integer],
    antennas: tuple[int, int],
    time: NDArray[np.float64],
    interval: float,
    which: str,
) -> PulsePairs | None:
    """Pairs of neighbouring pulses of which each antenna hears its own: an interferogram of both ways, p = 2.

    It exists beside that of one way where the transmitters alternate and both receivers hear all; None where it does
    not. heard (pulse, receiver), transmitter (pulse,), time (pulse,) and interval [s]; which: of PulsePairs.
    """
    own = heard & (np.asarray(transmitter)[:, None] == np.asarray(antennas))
    following = np.abs(np.diff(time) - interval) < 0.5 * interval
    forward, backward = ((own[:-1, n] & own[1:, 1 - n] & following).any() for n in (0, 1))
    there = {"forward": forward, "backward": backward, "both": forward and backward}[which]
    return neighbouring_pulses(own, time, interval, which) if there else None


def rows_apart(time: NDArray[np.float64], lag: float, interval: float) -> tuple[Rows, Rows]:
    """Rows of pulses of which the second comes `lag` [s] after the first, before it if negative, within half the
    interval [s] between pulses; times (pulse,) rise. Where one is missing there is no pair."""
    count, least, most = round(lag / interval), lag - 0.5 * interval, lag + 0.5 * interval
    if 0 < count < time.size:  # of pulses that never miss the answer is at hand
        beyond, within = time[count:] - time[:-count], time[count - 1 :] - time[: time.size - count + 1]
        if beyond.min() > least and beyond.max() < most and within.max() < least:
            there = np.arange(time.size - count)
            return there, there + count
    later = np.searchsorted(time, time + lag - 0.5 * interval)
    there = np.flatnonzero(later < time.size)
    there = there[np.abs(time[later[there]] - time[there] - lag) < 0.5 * interval]
    return there, later[there]
