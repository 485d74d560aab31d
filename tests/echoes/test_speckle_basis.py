"""Modes of speckle as the beam hears them, against the covariance that it has by its law."""

from __future__ import annotations

import numpy as np
import pytest
from exact_echoes import ROCKING, SEED, radar_of, sea_seen
from numpy.typing import NDArray

from seamap_rt.echoes.response import truncation_share
from seamap_rt.echoes.speckle import (
    EVENLY,
    BeamWindow,
    Motion,
    MovingSpeckle,
    StillSpeckle,
    speckle_basis,
    speckle_truncation,
)
from seamap_rt.echoes.summation import ListedFacets
from seamap_rt.echoes.turn import ReceiveGeometry, peak_gate_voltage
from seamap_rt.radar.installation import Installation

NODES, SPACING_S, K = 21, 8e-4, 209.6
LAG = SPACING_S * (np.arange(NODES)[:, None] - np.arange(NODES))
BEAM = np.exp(-0.5 * (SPACING_S * (np.arange(NODES) - 10.0) / 2e-3) ** 2)  # 8 ms wide of 17


def astray(rows: NDArray, law: NDArray) -> float:
    """Share of the power that is heard which goes on otherwise than by the law's covariance (node, node)."""
    found = rows.T.astype(complex) @ rows.conj()
    np.testing.assert_allclose(np.real(np.diag(found)), 1.0, rtol=1e-6)  # of each node, however little it is heard
    wrong = np.linalg.eigvalsh(BEAM[:, None] * (found - law) * BEAM)
    return float(np.abs(wrong).sum() / np.sum(BEAM**2))


@pytest.mark.parametrize("left_out", [1e-2, 1e-3, 1e-4])
def test_what_is_heard_goes_on_by_its_law(left_out: float) -> None:
    """What is discarded is missing, and is given back node by node to modes that go on otherwise."""
    # Found: 0.3 to 5 times what is discarded; 10 times where Bragg waves all run one way, for modes are chosen of half
    # and half.
    heard, tau = BeamWindow(left_out=left_out).with_beam(BEAM), 0.01
    assert astray(speckle_basis(NODES, SPACING_S, tau, heard), np.exp(-((LAG / tau) ** 2))) < 6.0 * left_out
    for approaching in (0.0, 0.3, 1.0):
        motion = Motion(0.6, np.array([approaching]), np.ones((1, 1), np.float32), np.array([2.0]), 0.4)
        moving = MovingSpeckle.of(NODES, SPACING_S, K, tau, motion, SEED, window=heard)
        bragg, breakers = (kind[0] for kind in moving.modes(slice(0, 1), np.zeros(1)))
        turning = np.exp(2j * K * 0.6 * LAG)
        law = np.exp(-((LAG / tau) ** 2)) * (approaching * turning + (1.0 - approaching) * turning.conj())
        assert astray(bragg, law) < 12.0 * left_out
        law = np.exp(-((LAG / tau) ** 2) - 0.5 * (2.0 * K * 0.4 * LAG) ** 2 - 4j * K * LAG)
        assert astray(breakers, law) < 6.0 * left_out


def test_a_beam_needs_fewer_modes_than_an_even_ear() -> None:
    even, through = (len(speckle_basis(NODES, SPACING_S, 5e-3, each)) for each in (EVENLY, EVENLY.with_beam(BEAM)))
    assert through < 0.7 * even


@pytest.mark.parametrize("platform", [None, {**ROCKING, "roll_deg": 4.0}], ids=["upright", "rolling"])
def test_no_gate_hears_a_node_louder_than_its_modes_reckon(platform: dict | None) -> None:
    radar = radar_of(sector_deg=(20.0, 50.0))
    facets, _, fired = sea_seen(radar, platform)
    hearing = ReceiveGeometry.of(facets, Installation(radar), fired, SEED, 0.01, None, 1e-4)
    assert isinstance(hearing.speckle, StillSpeckle)
    reckoned = hearing.beam_window.node_voltages(hearing.window)
    assert reckoned.min() < 0.1  # there are nodes that are hardly heard
    nowhere = np.zeros(facets.grid.columns + 1, np.intp)
    none = ListedFacets(
        np.empty(0, np.intp), np.empty(0), np.empty((1, 0)), np.empty((1, 0)), np.empty((1, 0), np.complex64)
    )
    low, batch = hearing.batch(slice(0, facets.grid.columns), nowhere, none, np.empty((0, 1), np.float32))
    first, beam = low + batch.columns.first_node, batch.beam
    inside = (first >= 0) & (first + hearing.window <= hearing.nodes.count)
    assert inside.sum() > 10
    cosine = beam.level[:, None, None] * beam.along - beam.drop[:, None, None] * beam.up
    entry = np.clip((cosine * beam.entries_per_cosine + 0.5 * beam.table.shape[2]).astype(int), 0, None)
    voltage = np.abs(beam.table[0, 0, np.minimum(entry, beam.table.shape[2] - 1)]) / beam.table.max()
    turned = fired.installation.rate * (
        batch.columns.begin_s[:, None] + hearing.nodes.spacing_s * np.arange(hearing.window)
    )
    nearest = hearing.tabulated.samples.range[0]
    best = peak_gate_voltage(hearing.beams, turned, hearing.across, radar.height_m, nearest)
    assert np.all(voltage.max(axis=0)[inside] <= best[inside] + 5e-3)  # of a yaw's own turning, which is not reckoned
    assert platform is not None or np.all(voltage.max(axis=0)[inside] >= best[inside] - 0.05)


def test_the_share_follows_the_error_that_is_allowed() -> None:
    assert speckle_truncation(truncation_share(0.4, 2e-4)) == pytest.approx(0.1 * 2e-4 / 0.4)
    assert speckle_truncation(truncation_share(0.4, 0.02)) == 1e-3
    assert speckle_truncation(0.0) == 1e-4
