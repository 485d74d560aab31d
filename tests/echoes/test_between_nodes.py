"""What pulses between slow-time nodes miss, against sums of every pulse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_echo_kernel import SEED, at_nodes, radar_of, seen_by

from seamap_rt.echoes import turn as summing
from seamap_rt.echoes.response import tabulated
from seamap_rt.echoes.slow_time import choose_nodes, correlation_of, interpolation_weights, widest
from seamap_rt.echoes.turn import turn_echoes
from seamap_rt.radar.installation import Installation
from seamap_rt.settings import RadarSettings

PULSE_S = 1e-4
SHARES = (1e-3, 1e-4, 1e-5)


@pytest.mark.parametrize("share", SHARES)
def test_a_turn_misses_between_its_nodes_what_the_law_says(share: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Forty facets, speckle that never changes, speeds spread evenly; every pulse by the law in float64. Sides and
    flanks are left in, so that only the nodes differ."""
    seen = seen_by(radar_of(transmit="single", sector_deg=(20.0, 45.0)), velocity=(0.0, 0.0, 0.0))
    rng, speed = np.random.default_rng(5), 3.0
    rcs, velocity = np.zeros_like(seen.rcs), np.zeros_like(seen.facets.velocity_look)
    sweep = seen.facets.grid.column_sweep
    whole = np.flatnonzero((sweep > 6.0) & (sweep < 19.0))  # what the sector's pulses hear from end to end
    column = whole[np.linspace(0, whole.size - 1, 40).astype(int)]
    facet = np.searchsorted(seen.facets.distance, rng.uniform(160.0, 190.0, 40))
    rcs[column, facet] = 1.0
    velocity[column, facet] = rng.permutation(np.linspace(-speed, speed, 40))
    facets = replace(seen.facets, velocity_look=velocity)
    seen = replace(seen, rcs=rcs, facets=facets)
    monkeypatch.setattr(summing, "beam_truncation", lambda *_: summing.BEAMS_BEYOND)
    monkeypatch.setattr(summing, "tabulated", lambda radar, _: tabulated(radar))
    exact = at_nodes(seen, np.inf)[1]
    nodes = choose_nodes(facets, seen.radar, seen.fired, np.inf, neglected=share)
    found = turn_echoes(facets, rcs, Installation(seen.radar), seen.fired, SEED, np.inf, neglected=share).voltage
    missed = np.nanmean(np.abs(found - exact) ** 2) / np.nanmean(np.abs(exact) ** 2)
    assert missed == pytest.approx(nodes.missed, rel=0.3)  # forty facets' mean; found 0.9 to 0.95 of it
    assert nodes.missed <= share


def test_a_tighter_share_asks_for_closer_nodes() -> None:
    """And no wider ones would do, nor fewer of them around a pulse."""
    correlation = correlation_of(RadarSettings(), 360.0, 180.0, 5e-3)
    chosen = [widest(correlation, PULSE_S, share, 64) for share in (1e-2, *SHARES, 1e-6)]
    strides = [each.stride for each in chosen]
    assert strides == sorted(strides, reverse=True)
    assert strides[0] > 1.3 * strides[-1]
    assert chosen[-1].stride == widest(correlation, PULSE_S, 0.0, 64).stride  # as if it were nothing: 1e-6
    for each, share in zip(chosen, (1e-2, *SHARES, 1e-6), strict=True):
        taps = each.weights.shape[1]
        assert each.missed <= share < interpolation_weights(correlation, PULSE_S, each.stride + 1, 12).missed
        assert taps == 2 or interpolation_weights(correlation, PULSE_S, each.stride, taps - 2).missed > share


def test_what_does_not_change_needs_few_nodes() -> None:
    still = widest(correlation_of(RadarSettings(), 0.0, 0.0, np.inf), PULSE_S, 1e-4, 64)
    assert still.stride == 64
    fast = widest(correlation_of(RadarSettings(), 0.0, 0.49 / PULSE_S, np.inf), PULSE_S, 1e-4, 64)
    assert fast.stride == 1


def test_what_is_new_at_each_pulse_has_a_node_there_and_is_that_node() -> None:
    made = widest(lambda lag: np.where(lag == 0.0, 1.0, 0.0), PULSE_S, 1e-4, 64)
    assert made.stride == 1
    np.testing.assert_array_equal(made.weights, [[1.0]])
    assert made.missed == 0.0


def test_speeds_spread_evenly_are_missed_as_the_law_says() -> None:
    """A Gaussian beam that passes scatterers of speeds up to 400 Hz, pulse by pulse, at 360°/s."""
    gaussian = {"azimuth_beamwidth_deg": 1.8, "pattern": "gaussian"}
    radar = RadarSettings.model_validate({"antenna": gaussian})
    made = interpolation_weights(correlation_of(radar, 360.0, 400.0, np.inf), PULSE_S, 8, 8)
    width = 1.8 / np.sqrt(8.0 * np.log(2.0)) / 360.0  # s, σ of the two-way voltage: that of the one-way power
    seconds, tones = PULSE_S * np.arange(-400, 400), 5.0 * (np.arange(160)[:, None] - 79.5)
    heard = np.exp(-0.5 * (seconds / width) ** 2) * np.exp(2j * np.pi * tones * seconds)
    stride, taps = made.weights.shape
    missed = []
    for phase in range(stride):
        offsets = stride * (np.arange(taps) - taps // 2 + 1) - phase
        guess = sum(w * np.roll(heard, -n, axis=1) for w, n in zip(made.weights[phase], offsets, strict=True))
        missed.append(np.sum(np.abs(guess - heard) ** 2) / np.sum(np.abs(heard) ** 2))
    assert np.mean(missed) == pytest.approx(made.missed, rel=0.05)
