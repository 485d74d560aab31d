"""The calibration finds a smooth factor, keeps the modulation, counts the dark, and survives the odd cases."""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest

from seamap_rt.conventions import db
from seamap_rt.scattering.calibration import fit_scale


def calibration_scale(raw_power, horizontal_area, target_nrcs, grazing, wind_angle):
    """The factor of `fit_scale` with the shape of all arguments together."""
    scale = fit_scale(raw_power, horizontal_area, target_nrcs, grazing, wind_angle)
    every = (raw_power, horizontal_area, target_nrcs, grazing, wind_angle)
    shape = np.broadcast_shapes(*(np.shape(each) for each in every if each is not None))
    return np.broadcast_to(scale(grazing, 0.0 if wind_angle is None else wind_angle), shape)


def polar_facets(ranges: int = 300, looks: int = 240, sector: float = 2.0 * np.pi) -> tuple[np.ndarray, ...]:
    """Grazing [rad], wind angle [rad] and horizontal area [m²] of a polar grid seen from 5 m."""
    distance = np.linspace(15.0, 400.0, ranges)[None, :]
    azimuth = np.linspace(0.0, sector, looks, endpoint=False)[:, None]
    area = distance * (sector / looks) * (385.0 / ranges) * np.ones_like(azimuth)
    grazing = np.arctan(5.0 / distance) * np.ones_like(azimuth)
    return grazing, azimuth * np.ones_like(distance), area


def chess_board(grazing: np.ndarray, wind: np.ndarray) -> np.ndarray:
    """Half of the facets, in fields of several bins each, so that every ring and every sector has both kinds."""
    ring = np.floor(4.0 * np.log(grazing / grazing.min())).astype(int)
    return (ring + np.floor(3.0 * np.cos(wind)).astype(int)) % 2 == 0


def model(grazing: np.ndarray) -> np.ndarray:
    return 1e-3 * np.sin(grazing) ** 1.5


@pytest.mark.parametrize("sector", [2.0 * np.pi, 2.0, 0.1])
def test_a_factor_within_the_family_is_found(sector: float) -> None:
    grazing, wind, area = polar_facets(sector=sector)
    x = np.log(grazing)
    wrong_by = np.exp(2.0 + 0.8 * x - 0.1 * x**2 + 0.3 * np.cos(wind) + 0.2 * np.cos(2.0 * wind))
    scale = calibration_scale(model(grazing) * area / wrong_by, area, model(grazing), grazing, wind)
    np.testing.assert_allclose(scale, wrong_by, rtol=0.05)  # the width of the bins: 15 % of the range each


def test_broad_patches_meet_the_target_and_the_modulation_stays() -> None:
    rng = np.random.default_rng(5)
    grazing, wind, area = polar_facets(600, 360)
    lit = rng.random(area.shape) < np.clip(6.0 * grazing, 0.05, 0.9)  # darker far out, as a sea is
    speckled = rng.exponential(1.0, area.shape)  # independent, so that a patch's own scatter is known
    raw = 37.0 * model(grazing) ** 1.3 * area * speckled * lit
    scale = calibration_scale(raw, area, model(grazing), grazing, wind)
    for patch in (np.s_[:90], np.s_[90:180], np.s_[:, :60], np.s_[:, 60:200], np.s_[:, 200:400], np.s_[:, 400:]):
        ratio = np.sum((raw * scale)[patch]) / np.sum((model(grazing) * area)[patch])
        # 0.25 dB: 5 % lit at the far end leaves some 3600 facets there, 2 % of scatter; the rest is the cubic's fit
        np.testing.assert_allclose(db(ratio), 0.0, atol=0.25)
    steps = np.abs(np.diff(np.log(scale), axis=1))
    assert np.max(steps) < 0.1  # smooth from facet to facet, whatever the facets do
    assert np.max(np.abs(np.diff(np.log(scale), axis=0))) < 0.02


@pytest.mark.parametrize("contrast", [-0.5, 0.0, 0.3, 1.0])  # of up- over down-wind, 2a: up to 8.7 dB
@pytest.mark.parametrize("axis", [0.0, 0.3])  # of up- and down- over cross-wind
def test_a_mean_over_directions_sets_each_ring_and_no_direction(contrast: float, axis: float) -> None:
    rng = np.random.default_rng(8)
    grazing, wind, area = polar_facets(300, 360)
    shape = np.exp(contrast * np.cos(wind) + axis * np.cos(2.0 * wind))
    raw = 21.0 * model(grazing) ** 1.2 * area * shape * rng.exponential(1.0, area.shape)
    scale = fit_scale(raw, area, model(grazing), grazing, None)(grazing, wind)
    np.testing.assert_array_equal(calibration_scale(raw, area, model(grazing), grazing, None), scale)
    np.testing.assert_array_equal(np.ptp(scale, axis=0), 0.0)
    for ring in (np.s_[:, :40], np.s_[:, 40:100], np.s_[:, 100:200], np.s_[:, 200:]):
        # 15,000 facets and more: 0.05 dB of scatter; the rest is the cubic's fit.
        np.testing.assert_allclose(
            db(np.sum((raw * scale)[ring]) / np.sum((model(grazing) * area)[ring])), 0.0, atol=0.2
        )


def test_whole_bins_in_shadow_pull_their_weight() -> None:
    grazing, wind, area = polar_facets(600, 360)
    dark = chess_board(grazing, wind)
    raw = np.where(dark, 0.0, model(grazing) * area) / grazing
    scale = calibration_scale(raw, area, model(grazing), grazing, wind)
    weight = 1.0 / model(grazing)  # so that no ring outweighs the others
    total = np.sum(raw * scale * weight) / np.sum(area)
    # a fit of the lit bins alone would give 0.5; 10 %: the bins weigh by √area, the sum by area
    np.testing.assert_allclose(total, 1.0, atol=0.1)


def test_units_and_levels_do_not_matter() -> None:
    rng = np.random.default_rng(6)
    grazing, wind, area = polar_facets(120, 90)
    raw = model(grazing) * area * rng.exponential(1.0, area.shape)
    scale = calibration_scale(raw, area, model(grazing), grazing, wind)
    np.testing.assert_allclose(
        calibration_scale(1e-12 * raw, area, model(grazing), grazing, wind), 1e12 * scale, rtol=1e-6
    )
    np.testing.assert_allclose(
        calibration_scale(raw, area, 1e6 * model(grazing), grazing, wind), 1e6 * scale, rtol=1e-6
    )
    np.testing.assert_allclose(calibration_scale(raw, area, model(grazing), grazing, -wind), scale, rtol=1e-12)


def test_nothing_lit_or_nothing_at_all_is_quietly_one() -> None:
    grazing, wind, area = polar_facets(40, 30)
    for power, target in ((np.zeros_like(area), 1e-3), (area, 0.0)):
        scale = calibration_scale(power, area, target, grazing, wind)
        np.testing.assert_array_equal(scale, np.ones_like(area))
    lit = np.eye(2)  # what is lit is not wanted, and the other way round, in one ring and in one sector
    scale = calibration_scale(lit, 1.0, 1.0 - lit, np.array([[0.1], [0.3]]), np.array([0.0, 2.0]))
    np.testing.assert_array_equal(scale, np.ones((2, 2)))
    assert calibration_scale(*(np.zeros(0),) * 5).shape == (0,)


def test_few_lit_facets_give_a_bounded_factor() -> None:
    grazing, wind, area = polar_facets(60, 60)
    raw = np.zeros_like(area)
    raw[10, :5] = 1e-9
    scale = calibration_scale(raw, area, model(grazing), grazing, wind)
    assert np.all(np.isfinite(scale))
    assert np.all(scale > 0.0)
    one = calibration_scale(1e-3, 2.0, 1e-3, 0.1, 0.0)  # a single facet: target · area / power
    np.testing.assert_allclose(one, 2.0, rtol=1e-9)


def test_rays_from_below_the_horizon_and_float32_pass() -> None:
    grazing, wind, area = (each.astype(np.float32) for each in polar_facets(60, 60))
    grazing[:, -1] = -0.01
    scale = calibration_scale(area * np.float32(1e-4), area, np.float32(1e-4), grazing, wind)
    np.testing.assert_allclose(scale, 1.0, rtol=1e-4)


def test_what_is_not_a_power_is_refused() -> None:
    grazing, wind, area = polar_facets(10, 10)
    for bad in (-1.0, np.nan, np.inf):
        raw = area.copy()
        raw[3, 3] = bad
        with pytest.raises(ValueError, match="raw_power"):
            calibration_scale(raw, area, 1e-3, grazing, wind)


def test_a_turn_is_calibrated_in_no_time() -> None:
    grazing, wind, area = (each.astype(np.float32) for each in polar_facets(1500, 800))
    raw = area * np.float32(1e-4)
    target = model(grazing).astype(np.float32)
    times = []
    for _ in range(3):
        start = process_time()
        calibration_scale(raw, area, target, grazing, wind)
        times.append(process_time() - start)
    assert min(times) < 1.0  # 0.06 s alone on a core; of the process, however busy the machine is
