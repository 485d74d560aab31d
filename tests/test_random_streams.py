"""What a seed means: the streams' numbers stay, and no branch shares its numbers with another."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from seamap_rt.random_streams import Stream, branch, key


@pytest.mark.parametrize(
    ("stream", "number"),
    [
        (Stream.SEA, 1),
        (Stream.SPECKLE, 2),
        (Stream.NOISE, 3),
        (Stream.SENSORS, 7),
        (Stream.OBJECTS, 8),
        (Stream.TRANSMITTER, 9),
        (Stream.SPIKES, 11),
        (Stream.TEXTURE, 12),
    ],
)
def test_a_stream_keeps_its_number(stream: Stream, number: int) -> None:
    """Another number would draw another sea from the seed of every run that was kept."""
    assert stream == number
    expected = np.random.SeedSequence(5, spawn_key=(number, 4)).generate_state(4)
    np.testing.assert_array_equal(branch(5, stream, 4).generate_state(4), expected)


def test_all_streams_are_listed() -> None:
    assert len(Stream) == 8


def test_branches_differ() -> None:
    """By seed, stream, member and depth: 64 bits of each, all different."""
    members = [(), (0,), (1,), (0, 0), (0, 1), (1, 0)]
    keys = [int(key(seed, stream, *member)) for seed, stream, member in product((0, 1, 2**63), Stream, members)]
    assert len(set(keys)) == len(keys)


def test_branches_are_independent() -> None:
    """The correlation of two streams' normal numbers is 0 within five of its standard deviations, 1/√n."""
    draws = np.stack([np.random.default_rng(branch(3, stream)).standard_normal(20_000) for stream in Stream])
    off = np.asarray(np.corrcoef(draws))[np.triu_indices(len(Stream), 1)]
    assert np.abs(off).max() < 5.0 / np.sqrt(20_000)
