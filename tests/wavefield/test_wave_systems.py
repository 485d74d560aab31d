"""What stands beside the likeliest wave systems: seas of one system more, waves that run the other way, what hides."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plane_waves import Waves, random_sea

from seamap_rt.physics.dispersion import DEEP_WATER
from seamap_rt.wavefield.periodogram import mean_periodogram
from seamap_rt.wavefield.sea_state import TurnSpectrum
from seamap_rt.wavefield.system_likelihood import find_systems
from seamap_rt.wavefield.wave_systems import SYSTEM_WORTH, WaveSystem, WaveSystems

SAMPLES = 40.0


def systems(*each: tuple[float, float, float], reversal: float = 0.0) -> WaveSystems:
    """Of heights [m], periods [s] and directions that waves run to [deg], known to a tenth each."""
    made = tuple(WaveSystem((height / 4.0) ** 2, 1.0 / period, np.radians(to)) for height, period, to in each)
    return WaveSystems(made, 0.01 * np.eye(5 * len(made)), 0.0, 1.0, 0.01, reversal, DEEP_WATER, 9.0 / 150.0)


def test_alternatives_count_by_their_chance() -> None:
    """Mean squares about what was found, of a period and a direction that an alternative has otherwise."""
    found, other = systems((1.0, 5.0, 90.0)), systems((1.0, 5.0, 90.0), (1.0, 10.0, 150.0))
    alone = found.figures(SAMPLES)
    both = replace(found, alternatives=((0.2, other),)).figures(SAMPLES)
    assert both["peak_period"] == alone["peak_period"] == pytest.approx(5.0)
    apart = both["peak_period_std"] ** 2 - alone["peak_period_std"] ** 2
    assert apart == pytest.approx(0.2 * (10.0 - 5.0) ** 2)  # of two systems alike the longer has the higher peak
    turned = both["mean_direction_std"] ** 2 - alone["mean_direction_std"] ** 2
    assert turned == pytest.approx(0.2 * 30.0**2)  # of two systems alike the mean runs between them


@pytest.mark.parametrize("chance", [0.0, 1e-3, 0.1, 0.4])
def test_waves_that_may_run_the_other_way_have_no_sure_direction(chance: float) -> None:
    figures = systems((1.0, 5.0, 90.0), reversal=chance).figures(SAMPLES)
    if chance > 0.2:
        assert "mean_direction" not in figures
        assert figures["mean_axis"] == pytest.approx(90.0)
        return
    sure = systems((1.0, 5.0, 90.0)).figures(SAMPLES)
    apart = figures["mean_direction_std"] ** 2 - sure["mean_direction_std"] ** 2
    assert apart == pytest.approx(chance * 180.0**2, abs=1e-9)


def found_in(sea: Waves, start: WaveSystems | None = None, seen: float = 1.0) -> WaveSystems:
    polar = sea.turns(1)["polar"].to_dataset().isel(turn=0)
    turn = TurnSpectrum.of(polar, DEEP_WATER)
    assert turn is not None
    found = find_systems([turn.heights], mean_periodogram([turn.periodogram]), turn.direction, DEEP_WATER, start, seen)
    assert found is not None
    return found


@pytest.mark.parametrize("seed", [31, 32])
def test_the_search_finds_what_a_climb_from_the_truth_does(seed: int) -> None:
    """Short of a system that is not worth it: a swell under a wind sea and another one, of which one system in the
    middle is a maximum too."""
    sea = (
        random_sea(seed, 1.4, 14.0, 40.0)
        + random_sea(seed + 10, 1.2, 8.0, 90.0)
        + random_sea(seed + 20, 0.8, 4.0, 200.0)
    )
    truth = systems((1.4, 14.0, 220.0), (1.2, 8.0, 270.0), (0.8, 4.0, 20.0))
    assert found_in(sea).likelihood > found_in(sea, truth).likelihood - SYSTEM_WORTH


def test_errors_of_a_sea_of_which_half_is_hidden_are_twice_as_large() -> None:
    """Of waves that the circle holds many of; the share in sight widens all of them alike."""
    sea = random_sea(7, 1.0, 4.0, 200.0)
    whole, half = (found_in(sea, seen=share).covariance for share in (1.0, 0.5))
    np.testing.assert_allclose(half, 4.0 * whole, rtol=1e-6)
