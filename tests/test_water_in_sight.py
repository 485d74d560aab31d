"""The visible share of a run's first turn: light's is the truth's, and a radar's falls with the level asked for."""

from __future__ import annotations

import numpy as np
import pytest

import seamap_rt as sr
from seamap_rt.conventions import POLARIZATIONS
from seamap_rt.physics.shadowing import LEVELS_DB, SEEN_DB
from seamap_rt.report.reduce import half_visible_in_words
from seamap_rt.simulation import Simulator
from seamap_rt.visible_share import VisibleShare

KEYS = {"radar.range_m": [15.0, 200.0], "radar.sector_deg": [250.0, 290.0], "tracing.tracer": "horizon", "turns": 1}


@pytest.fixture(scope="module")
def simulated() -> tuple[VisibleShare, np.ndarray, np.ndarray]:
    """Of a sector that looks up-wave; and the truth's slant ranges and visible share by range."""
    simulator = Simulator(sr.load_scene("choppy_sea", KEYS))
    truth = simulator.turn(0).truth["polar"].to_dataset()
    assert simulator.visible is not None
    share = truth["visible_fraction"].values.mean(axis=(0, 1))
    return simulator.visible, truth["range"].values, share


def test_light_sees_what_the_truth_says(simulated: tuple[VisibleShare, np.ndarray, np.ndarray]) -> None:
    """To 1 % of the sea at 50–200 m: the truth's cells are 3 m, the bins 5 m, and both end where they end."""
    visible, slant, share = simulated
    inside = (slant >= 50.0) & (slant <= 195.0)
    ground = np.sqrt(slant[inside] ** 2 - 5.0**2)
    assert np.interp(ground, visible.range_m, visible.light).mean() == pytest.approx(share[inside].mean(), abs=0.01)


def test_a_radar_sees_less_the_more_power_it_asks_for(simulated: tuple[VisibleShare, np.ndarray, np.ndarray]) -> None:
    visible, _, _ = simulated
    assert visible.radar.shape == (len(POLARIZATIONS), len(LEVELS_DB), visible.range_m.size)
    assert np.all(np.diff(visible.radar, axis=1) >= 0.0)  # −3, −6, −10 dB
    found = visible.figures
    half = found["half_visible_m"]
    assert half is not None
    for name in ("vv", "hh"):  # light overstates it by 7 to 30 %, by wave optics (validation.light.half_visible)
        radar = found[f"half_visible_{name}_m"]
        assert radar is not None
        assert 0.7 * half < radar < 0.95 * half


def test_nothing_is_hidden_on_level_water() -> None:
    simulator = Simulator(sr.load_scene("flat", {"radar.sector_deg": [0.0, 10.0], "tracing.tracer": "horizon"}))
    simulator.turn(0)
    assert simulator.visible is not None
    assert np.abs(simulator.visible.light - 1.0).max() < 1e-12
    assert np.abs(simulator.visible.radar - 1.0).max() < 1e-12
    assert simulator.visible.figures["half_visible_m"] is None


def test_the_words_name_the_radar_first() -> None:
    curves = [
        {"sees": "light", "level_db": 0.0, "half_visible_m": 120.4},
        {"sees": "VV", "level_db": SEEN_DB, "half_visible_m": 101.2},
        {"sees": "HH", "level_db": SEEN_DB, "half_visible_m": None},
    ]
    metrics = {"visible": {"polarization": "VV", "seen_db": SEEN_DB, "range_m": [], "curves": curves}}
    assert half_visible_in_words(metrics) == "101 m (VV), 120 m (light)"
    metrics["visible"]["polarization"] = "HH"
    assert half_visible_in_words(metrics) == "— (HH), 120 m (light)"
    assert half_visible_in_words({}) == "— (light)"  # of a run by an earlier version
