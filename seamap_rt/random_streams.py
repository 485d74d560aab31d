"""The random numbers of a run: one seed, a branch for each use, all branches in one table.

A branch is `numpy.random.SeedSequence(seed, spawn_key=(stream, …))`. Branches share no number, so that one use may draw
more or fewer without changing another: the same seed gives the same sea with and without noise, and the same bits for
any number of threads and workers. Numbers once given to a stream stay: they are part of what a seed means.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class Stream(IntEnum):
    """What a branch of the random source is used for."""

    SEA = 1  # phases and amplitudes of the waves of a run
    SPECKLE = 2  # of each facet, by column and facet
    NOISE = 3  # of each pulse and receiver
    SENSORS = 7  # errors of the boat's motion sensors
    OBJECTS = 8  # where the scattering points of an object lie, by object
    TRANSMITTER = 9  # of a magnetron's pulses: starting phase, carrier, and the error of the measured phase
    SPIKES = 11  # of breakers, by class of their waves
    TEXTURE = 12  # of patches of breakers, by their size


def branch(seed: int, stream: Stream, *member: int) -> np.random.SeedSequence:
    """The branch of a scene's seed for one use; member: of what there are several, such as objects or pulses."""
    return np.random.SeedSequence(seed, spawn_key=(int(stream), *member))


def key(seed: int, stream: Stream, *member: int) -> np.uint64:
    """64 bits that stand for the branch, from which generators by counting start."""
    return branch(seed, stream, *member).generate_state(1, np.uint64)[0]
