"""What a forecast expects of waves before their phases are known, from one turn's map."""

from __future__ import annotations

import numpy as np
import pytest
from plane_waves import Waves, maps, random_sea

from seamap_rt.conventions import wrap_degrees
from seamap_rt.physics.dispersion import DEEP_WATER
from seamap_rt.prediction.spectrum import Spectrum, spectrum_of_turns
from seamap_rt.wavefield.sea_state import TurnSpectrum

CELLS = {"cell_range_m": 3.0, "cell_azimuth_deg": 1.8, "pulse_m": 2.3, "azimuth_beamwidth_deg": 1.8}


def expected(sea: Waves, noise: float = 0.08, cells: dict[str, float] | None = None) -> Spectrum:
    """Of a map with noise. cells: what it says that its values are the mean over."""
    rng, height, velocity = np.random.default_rng(7), sea.heights(), sea.velocity()
    height, velocity = (each + std * rng.normal(size=each.shape) for each, std in ((height, noise), (velocity, 0.5)))
    polar = maps(height, velocity, noise, "single_cell")["polar"].to_dataset().isel(turn=0)
    shown = TurnSpectrum.of(polar.assign_attrs(cells or {}), DEEP_WATER)
    assert shown is not None
    made = spectrum_of_turns([shown], DEEP_WATER)
    assert made is not None
    return made


def part(made: Spectrum, longest: float, shortest: float) -> tuple[float, float]:
    """Significant height [m] and mean azimuth [deg] that waves of a band of periods [s] come from."""
    period = 2.0 * np.pi / made.water.frequency(made.k)
    held = made.variances[(period < longest) & (period > shortest)]
    way = np.angle(np.sum(held * np.exp(1j * made.toward)))
    return 4.0 * float(np.sqrt(held.sum())), float(np.degrees(way)) + 180.0


@pytest.mark.parametrize("seed", [1, 2])
def test_a_wind_sea_across_a_swell_keeps_its_own_way_and_size(seed: int) -> None:
    # 1.5 m of 8 s from the south under 1 m of 4.5 s from the west. A map of 150 m holds few waves of either, and what
    # gaps and the other system scatter blurs both: 25° and a third.
    swell, wind = random_sea(seed, 1.5, 8.0, 180.0, 30.0), random_sea(seed + 10, 1.0, 4.5, 270.0)
    made = expected(swell + wind)
    for (longest, shortest), true in (((12.0, 6.3), (1.5, 180.0)), ((5.2, 2.5), (1.0, 270.0))):
        height, way = part(made, longest, shortest)
        assert height == pytest.approx(true[0], rel=0.35)
        assert abs(wrap_degrees(way - true[1])) < 25.0


@pytest.mark.parametrize("seed", [1, 2])
def test_waves_too_short_to_be_seen_run_with_the_wind_sea(seed: int) -> None:
    made = expected(random_sea(seed, 1.4, 5.5, 250.0))
    _, way = part(made, 2.5, 1.0)
    assert abs(wrap_degrees(way - 250.0)) < 20.0
    # What no map of 1.5 m cells tells has the tail that Phillips (1958) gives: F ∝ k⁻⁴, a step of log k then ∝ k⁻².
    short = made.k > 0.9
    level = made.variances.sum(axis=1)[short] * made.k[short] ** 2
    np.testing.assert_allclose(level, level[0], rtol=1e-6)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_noise_in_cells_too_wide_to_tell_is_no_waves(seed: int) -> None:
    # Cells hold some 60 % of waves of 12 m and less of shorter ones, and what puts that back raises the noise as well.
    # The sea ends at 20 m: shorter waves are those of the tail, however much noise there is.
    sea = random_sea(seed, 1.4, 8.0, 250.0)
    little, much = (expected(sea, noise, CELLS) for noise in (0.1, 0.3))
    short = (little.k > 2.0 * np.pi / 11.0) & (little.k < 2.0 * np.pi / 5.0)
    held = [float(each.variances[short].sum()) for each in (little, much)]
    assert held[1] == pytest.approx(held[0], rel=0.1)
    assert held[0] < 0.02 * little.variance


@pytest.mark.parametrize("length", [20.0, 40.0])
def test_a_single_wave_keeps_its_length(length: float) -> None:
    """The mean of its rings, to half of a ring's step: rings stand a factor 1200^(1/95) apart."""
    number = 2.0 * np.pi / length
    made = expected(Waves(np.array([number]), np.array([2.0]), np.array([0.5 + 0.0j])), 0.02)
    near = np.abs(np.log(made.k / number)) < 0.4
    held = made.variances.sum(axis=1)[near]
    assert held.sum() > 0.9 * made.variance
    assert np.average(np.log(made.k[near] / number), weights=held) == pytest.approx(
        0.0, abs=0.5 * np.log(1200.0) / 95.0
    )
