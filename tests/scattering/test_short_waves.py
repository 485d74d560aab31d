"""Where the mesh's waves end the scattering's begin: no gap, and no wave that counts twice."""

import numpy as np
import pytest

from seamap_rt import simulation
from seamap_rt.echoes.radar_cross_section import SeaSurface
from seamap_rt.report.headline import run_facts
from seamap_rt.scattering import ShortWaves, nrcs_two_scale, permittivity_meissner_wentz12
from seamap_rt.scattering.breaking import approaching_share
from seamap_rt.scene import load_scene
from seamap_rt.sea import realize, spectral_system
from seamap_rt.sea.spectra import elfouhaily97
from seamap_rt.settings import ElfouhailyWaves, JonswapWaves, SeaSettings

EPS = complex(permittivity_meissner_wentz12(10e9, 20.0, 35.0))


def wind_sea(wind=10.0, **changes):
    waves = ElfouhailyWaves(spectrum="elfouhaily", wind_speed_m_s=wind, wave_from_deg=250.0)
    return SeaSettings(**{"waves": (waves,), "extent_m": 512.0, "resolution_m": 1.0, **changes})


@pytest.mark.parametrize("resolution", [0.5, 1.0, 4.0])
@pytest.mark.parametrize(("wind", "height", "slope"), [(5.0, 0.648, 0.03167), (10.0, 2.634, 0.06047)])
def test_resolved_and_short_waves_make_up_the_whole_sea(resolution, wind, height, slope):
    resolved = realize(wind_sea(wind, resolution_m=resolution), seed=1).resolved
    short = ShortWaves(wind, resolved.wavenumber_limit)
    # Height and mean square slope of the spectrum, as computed from the paper's formulas (PM-developed, Ωc = 0.84).
    np.testing.assert_allclose(4.0 * np.sqrt(resolved.variance + short.variance), height, rtol=1e-3)
    # 3e-3 of the resolved slope: the lattice's ragged rim.
    np.testing.assert_allclose(resolved.mean_square_slope + short.mean_square_slope, slope, rtol=2e-3)
    share = resolved.mean_square_slope / (resolved.mean_square_slope + short.mean_square_slope)
    np.testing.assert_allclose(resolved.mean_square_slope_share, share, rtol=3e-3)


def test_the_hand_over_is_at_one_wavenumber_for_both():
    resolved = realize(wind_sea(), seed=1).resolved
    short = ShortWaves(10.0, resolved.wavenumber_limit)
    k = resolved.wavenumber_limit * np.array([0.5, 0.999, 1.001, 3.0])
    waves = ElfouhailyWaves(spectrum="elfouhaily", wind_speed_m_s=10.0)
    system = spectral_system(waves, np.inf)
    on_mesh = np.where(k < resolved.wavenumber_limit, system.radial(k), 0.0)
    np.testing.assert_allclose(on_mesh + short.spectrum(k), elfouhaily97(k, 10.0), rtol=1e-12)
    assert abs(short.level_step_db(system.radial)) < 1e-9


def test_the_step_between_unlike_seas_is_told():
    swell = JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.4, peak_period_s=5.5)
    system = spectral_system(swell, np.inf)
    short = ShortWaves(8.0, np.pi / 0.8)
    expected = 10.0 * np.log10(elfouhaily97(np.pi / 0.8, 8.0) / system.radial(np.array([np.pi / 0.8]))[0])
    np.testing.assert_allclose(short.level_step_db(system.radial), expected, rtol=1e-12)
    assert np.isnan(short.level_step_db(lambda k: np.zeros(k.size)))


def test_slopes_split_along_and_across_the_wind_as_the_plane_spectrum_does():
    short = ShortWaves(10.0, 2.0)
    along, across = short.slope_variances
    k, angle = np.geomspace(2.0, 1e5, 4001)[:, None], np.arange(360) * np.pi / 180.0
    plane = elfouhaily97(k, 10.0) / (2.0 * np.pi) * (1.0 + short.contrast(k) * np.cos(2.0 * angle)) * np.pi / 180.0
    for found, part in ((along, np.cos(angle)), (across, np.sin(angle))):
        expected = np.trapezoid(np.sum(plane * (k * part) ** 2, axis=1) * k[:, 0], np.log(k[:, 0]))
        np.testing.assert_allclose(found, expected, rtol=1e-4)
    np.testing.assert_allclose(ShortWaves(10.0).slope_variances[0], 0.03560, rtol=1e-3)  # of the whole sea, as printed


def test_cox_and_munk_hold_the_whole_sea_in_their_band():
    # Cox & Munk 1954, clean sea: 0.003 + 0.00512 U ± 0.004 from photographs; the 1997 spectrum was not fitted to them.
    for wind in (4.0, 7.0, 10.0, 13.0):
        assert abs(ShortWaves(wind).mean_square_slope / (0.003 + 0.00512 * wind) - 1.0) < 0.25


def test_a_facet_seen_squarely_is_as_rough_as_its_own_waves_make_it():
    def sigma(below):
        return float(
            nrcs_two_scale(
                0.0, 0.0, 0.0, 0.0, frequency_hz=10e9, wind_speed=10.0, permittivity=EPS, polarization="VV",
                resolved_below=below,
            )
        )  # fmt: skip

    # At the normal σ0 is |R(0)|²/mss, mss that of the waves on the facet (Bragg's own σ0 is far above it: 1 % left).
    expected = ShortWaves(10.0).mean_square_slope / ShortWaves(10.0, 4.0).mean_square_slope
    np.testing.assert_allclose(sigma(4.0) / sigma(0.0), expected, rtol=0.02)
    assert expected > 1.2


def facts_of(simulator):
    return run_facts(simulator.scene, simulator.sea, simulator.surface)


def test_a_simulation_hands_over_where_its_sea_ends(monkeypatch):
    asked = []

    def recorded(scattering, radar, resolved_below, **others):
        asked.append(resolved_below)
        return SeaSurface(scattering, radar, resolved_below, **others)

    monkeypatch.setattr(simulation, "SeaSurface", recorded)
    changes = {"tracing.tracer": "horizon", "sea.resolution_m": 1.3, "radar.sector_deg": [0.0, 10.0]}
    simulator = simulation.Simulator(load_scene("tiny", changes))
    assert asked == [np.pi / 1.3]
    facts = facts_of(simulator)["short_waves"]
    np.testing.assert_allclose(facts["wavenumber_from"], np.pi / 1.3)
    np.testing.assert_allclose(facts["mean_square_slope"], ShortWaves(8.0, np.pi / 1.3).mean_square_slope)


def test_no_resolved_wave_scatters_as_roughness():
    """Bragg waves longer than the limit are the mesh's: they count as the longest that the facet carries."""

    def sigma(theta, below):
        return float(
            nrcs_two_scale(
                theta, 0.0, 0.0, 0.0, frequency_hz=10e9, wind_speed=10.0, permittivity=EPS, polarization="VV",
                resolved_below=below,
            )
        )  # fmt: skip

    k = 2.0 * np.pi * 10e9 / 299_792_458.0
    theta = np.radians(30.0)
    bragg = 2.0 * k * np.sin(theta)
    # Away from the normal (here the ceiling takes some per cent) the limit does not matter as long as it is below k_B…
    np.testing.assert_allclose(sigma(theta, 0.5 * bragg), sigma(theta, 0.1 * bragg), rtol=0.1)
    # … and above it the waves at the limit scatter, weaker than those of k_B would: S/k falls as k⁻⁴.
    assert sigma(theta, 3.0 * bragg) < 0.05 * sigma(theta, 0.5 * bragg)


def test_a_mesh_coarser_than_the_waves_is_told():
    changes = {"tracing.tracer": "horizon", "tracing.facet_m": 1.0, "sea.resolution_m": 0.8}
    simulator = simulation.Simulator(load_scene("tiny", changes))
    assert any("shorter than 2 m along the look" in row["what"] for row in facts_of(simulator)["left_out"])
    fine = simulation.Simulator(load_scene("tiny", {**changes, "tracing.facet_m": 0.5}))
    assert not any("along the look" in row["what"] for row in facts_of(fine)["left_out"])


@pytest.mark.parametrize("above", [0.0, 3.9, 40.0])
@pytest.mark.parametrize("wind", [0.5, 5.0, 20.0])
def test_each_wave_is_resolved_or_tilts_or_is_rough(above, wind):
    short = ShortWaves(wind, above)
    divide = short.divide(209.6)
    k = np.geomspace(1e-3, 1e5, 200_001)
    slope = k**3 * elfouhaily97(k, wind)
    resolved = np.trapezoid(np.where(k < above, slope, 0.0), np.log(k))
    rough = np.trapezoid(k**3 * short.roughness(k, divide), np.log(k))
    # 1e-3: the two grids' cells at the limit
    whole = ShortWaves(wind).mean_square_slope
    np.testing.assert_allclose(resolved + sum(short.tilt_variances(divide)) + rough, whole, rtol=1e-3)
    assert short.tilt_variances(divide)[0] >= short.tilt_variances(divide)[1] > 0.0
    np.testing.assert_allclose(short.roughness(divide, divide), 0.5 * short.spectrum(divide), rtol=1e-12)


def test_the_divide_is_a_quarter_of_the_radars_wavenumber_and_clear_of_the_mesh():
    assert ShortWaves(10.0, 3.9).divide(200.0) == 50.0
    assert ShortWaves(10.0, 30.0).divide(200.0) == 120.0
    k = np.geomspace(0.1, 2e3, 400)
    short = ShortWaves(10.0)
    share = short.roughness(k, 50.0) / short.spectrum(k)
    assert np.all(np.diff(share) >= -1e-12)  # rounding
    # What first-order scattering has of it towards the vertical, ∝ k⁻⁴ T, stays finite: at most e^(8 · 0.35²)
    assert np.max(share * (50.0 / k) ** 4) < np.exp(8.0 * 0.35**2)
    assert share[0] < 1e-60


def test_waves_approach_where_the_radar_looks_into_the_wind():
    angle = np.radians([0.0, 90.0, 180.0, -90.0, 360.0])
    np.testing.assert_allclose(approaching_share(angle), [1.0, 0.5, 0.0, 0.5, 1.0], atol=1e-15)
    look = np.linspace(-np.pi, np.pi, 73)
    np.testing.assert_allclose(approaching_share(look) + approaching_share(look + np.pi), 1.0, rtol=1e-12)
    # its two senses together are a spreading of 1/3, near Elfouhaily's at X-band Bragg waves
    sum_of_both = np.cos(look / 2.0) ** 4 + np.sin(look / 2.0) ** 4
    np.testing.assert_allclose(approaching_share(look) * sum_of_both, np.cos(look / 2.0) ** 4, atol=1e-12)
    np.testing.assert_allclose(sum_of_both / 0.75, 1.0 + np.cos(2.0 * look) / 3.0, rtol=1e-12)
    for wind in (5.0, 8.0, 12.0):
        assert abs(float(ShortWaves(wind).contrast(419.0)) - 1.0 / 3.0) < 0.1
