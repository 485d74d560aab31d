"""Waves that the mesh does not carry: what they hide of lit facets, against Smith's law and against exact horizons."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt import load_scene, sea
from seamap_rt.conventions import radar_wavenumber
from seamap_rt.echoes.radar_cross_section import SeaSurface
from seamap_rt.mesh import SurfaceMesh, mesh_turn
from seamap_rt.physics.shadowing import shadow_kept
from seamap_rt.scattering import ShortWaves
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator
from seamap_rt.tracing import Illumination, UnresolvedWaves
from seamap_rt.tracing.diffraction import diffract
from seamap_rt.tracing.horizon import trace_horizon
from seamap_rt.truth import polar_truth
from validation.analytic.diffraction import knife_edge
from validation.analytic.shadowing import shadowing_smith67

Array = NDArray[np.floating]
UNLIKE = UnresolvedWaves((0.006, 0.003), 230.0)  # slope variances along and across a wind from there
SMITH = {"tracing.tracer": "horizon", "tracing.unresolved_shadowing": "smith"}


def fan(**keys: object) -> tuple[Scene, SurfaceMesh]:
    """A sector of a random sea, or of another with the keys given."""
    base = {"radar.range_m": [15.0, 60.0], "sea.extent_m": 200.0, "radar.sector_deg": [200.0, 260.0]}
    scene = load_scene("tiny", overrides={**base, **keys})
    return scene, mesh_turn(sea.realize(scene.sea, 7), scene.radar, scene.tracing, 0)


@pytest.fixture(scope="module")
def lit() -> Illumination:
    return trace_horizon(fan()[1])


def test_a_level_sea_is_seen_by_smith_s_law_of_the_look_s_own_slopes() -> None:
    """2e-6: the table is linear between steps of 1/256 of σ, where S″ ≤ 1 per σ²; float32 rounds to 1e-7."""
    light = trace_horizon(fan(**{"sea.waves": []})[1])
    shaded = UNLIKE.shade(light)
    assert shaded.in_sight is not None
    away = np.radians(light.grid.column_azimuth - UNLIKE.wind_from_deg)
    slope = np.sqrt(0.006 * np.cos(away) ** 2 + 0.003 * np.sin(away) ** 2)[:, None]
    grazing = -light.rise / light.distance
    assert_allclose(shaded.in_sight, shadowing_smith67(grazing / (np.sqrt(2.0) * slope)), atol=4e-6)
    assert shaded.in_sight.min() < 0.8 < shaded.in_sight.max()  # there is something to judge


def test_each_facet_is_seen_under_its_own_grazing_angle(lit: Illumination) -> None:
    same = UnresolvedWaves((0.005, 0.005), 0.0)
    shaded = same.shade(lit)
    assert shaded.in_sight is not None
    assert shaded.facing_in_sight is not None
    reached = lit.lit.any(axis=0)
    grazing = (lit.slope_look - lit.rise / lit.distance)[reached]
    law = shadowing_smith67(np.maximum(grazing, 0.0) / np.sqrt(2.0 * 0.005))
    assert_allclose(shaded.in_sight[reached], law, atol=4e-6)
    assert np.ptp(law) > 0.3
    assert not shaded.in_sight[~reached].any()
    assert not shaded.facing_in_sight[~reached].any()
    # ½ (1 + erf v) of the water faces the ray: between a half, edge on, and all.
    share = shaded.in_sight[reached] / np.maximum(shaded.facing_in_sight[reached], 1e-12)
    assert np.all((share[grazing > 0.0] > 0.4999) & (share[grazing > 0.0] < 1.0001))


def test_bent_light_meets_the_small_waves_under_the_ray_that_arrives() -> None:
    scene, mesh = fan()
    bent = diffract(trace_horizon(mesh), mesh, scene.wavelength_m)
    assert bent.ray_slope is not None
    shaded = UnresolvedWaves((0.005, 0.005), 0.0).shade(bent)
    assert shaded.in_sight is not None
    dark = bent.reached.any(axis=0) & ~bent.lit.any(axis=0)
    law = shadowing_smith67(np.maximum((bent.slope_look + bent.ray_slope)[dark], 0.0) / np.sqrt(2.0 * 0.005))
    assert_allclose(shaded.in_sight[dark], law, atol=4e-6)
    assert dark.any()


def test_of_hidden_water_the_share_kept_answers(lit: Illumination) -> None:
    """A mean of light's shadows and of none, of all the water and of what faces the ray alike."""
    dark, half, bright = (replace(UNLIKE, kept=kept).shade(lit) for kept in (0.0, 0.3, 1.0))
    reached = lit.lit.any(axis=0)
    for name in ("in_sight", "facing_in_sight"):
        shares = [getattr(each, name)[reached] for each in (dark, half, bright)]
        assert_allclose(shares[1], 0.7 * shares[0] + 0.3, atol=1e-6)
        assert_allclose(shares[2], 1.0, rtol=1e-6)
    tangent = np.array([0.01, 0.1, 0.4])
    assert_allclose(replace(UNLIKE, kept=0.3).shares(tangent, 0.0), 0.7 * np.array(UNLIKE.shares(tangent, 0.0)) + 0.3)


def test_what_bends_into_small_shadows_goes_from_all_to_none_with_their_fresnel_number() -> None:
    """By the judge's knife edge; all of waves much smaller than the radar's, nothing in light's limit: (√2/πv)⁴ of
    v → ∞. HH is the square."""
    for height, slope, wavelength in ((0.012, 0.077, 0.03), (0.05, 0.1, 0.03), (0.012, 0.077, 0.1)):
        v = np.sqrt(2.0 * height * slope / wavelength)
        assert shadow_kept(height, slope, wavelength, "VV") == pytest.approx((2.0 * abs(knife_edge(v))) ** 4)
        assert shadow_kept(height, slope, wavelength, "HH") == pytest.approx((2.0 * abs(knife_edge(v))) ** 8)
    assert shadow_kept(1e-8, 0.01, 0.03, "VV") == pytest.approx(1.0, abs=1e-3)
    assert shadow_kept(0.0, 0.0, 0.03, "HH") == 1.0
    v = np.sqrt(2.0 * 0.02 * 0.1 / 5e-7)
    assert shadow_kept(0.02, 0.1, 5e-7, "VV") == pytest.approx((np.sqrt(2.0) / (np.pi * v)) ** 4, rel=1e-3)
    for wrong in ((-0.1, 0.1, 0.03), (0.1, -0.1, 0.03), (0.1, 0.1, 0.0)):
        with pytest.raises(ValueError, match="0 or more"):
            shadow_kept(*wrong, "VV")


def test_a_radar_s_shadows_lie_between_none_and_light_s() -> None:
    vv, hh, light = (
        UnresolvedWaves.of(
            load_scene("tiny", {"tracing.unresolved_shadowing": name, "scattering.polarization": polarization}), 4.0
        )
        for name, polarization in (("fresnel", "VV"), ("fresnel", "HH"), ("smith", "VV"))
    )
    assert vv is not None
    assert hh is not None
    assert light is not None
    assert 1.0 > vv.kept > hh.kept > light.kept == 0.0
    assert hh.kept == pytest.approx(vv.kept**2)
    assert vv.slope_variances == light.slope_variances


@pytest.mark.parametrize("wind", [5.0, 9.0])
@pytest.mark.parametrize("polarization", ["VV", "HH"])
def test_a_scene_s_hidden_water_keeps_what_its_own_small_waves_leave(wind: float, polarization: str) -> None:
    """The judge's knife edge of the waves' height, ∫ S dk, and of their slope in one direction, half of ∫ k² S dk, of
    what the roughness leaves of the spectrum beyond the mesh: sums over a fine grid of the spectrum itself."""
    keys = {"tracing.unresolved_shadowing": "fresnel", "scattering.polarization": polarization}
    scene = load_scene("tiny", {**keys, "scattering.wind_speed_m_s": wind})
    found = UnresolvedWaves.of(scene, 4.0)
    assert found is not None
    short = ShortWaves.of(scene.scattering, 4.0)
    k = np.geomspace(4.0, 4000.0, 200_001)
    waves = short.spectrum(k) - short.roughness(k, short.divide(radar_wavenumber(scene.radar.frequency_hz)))
    height, slope = (np.sqrt(share * np.trapezoid(waves * k**power, k)) for share, power in ((1.0, 0), (0.5, 2)))
    edge = 2.0 * abs(knife_edge(np.sqrt(2.0 * height * slope / scene.wavelength_m)))
    assert found.kept == pytest.approx(edge ** (4 if polarization == "VV" else 8), rel=2e-3)
    assert sum(found.slope_variances) == pytest.approx(2.0 * slope**2, rel=2e-3)


def test_without_small_waves_all_that_is_lit_is_seen(lit: Illumination) -> None:
    shaded = UnresolvedWaves((0.0, 0.0), 0.0).shade(lit)
    assert shaded.in_sight is not None
    faces = lit.lit.any(axis=0) & (lit.slope_look - lit.rise / lit.distance > 1e-5)
    assert_array_equal(shaded.in_sight[faces], 1.0)


def test_every_tracer_s_light_is_shaded_alike(lit: Illumination) -> None:
    """It is no part of a tracer: light that is the same is shaded to the same bits, and `lit` stays what it was."""
    simulators = [Simulator(load_scene("tiny", {**SMITH, "tracing.tracer": name})) for name in ("horizon", "facets")]
    shades = [each.shaded(lit) for each in simulators]
    assert_array_equal(shades[0].in_sight, shades[1].in_sight)
    assert_array_equal(shades[0].lit, lit.lit)
    assert Simulator(load_scene("tiny", {"tracing.tracer": "horizon"})).shaded(lit) is lit


# --------------------------------------------------------------------- profiles on which the small waves are drawn


def drawn(random: np.random.Generator, step: float, points: int, k: Array, variance: Array) -> Array:
    """A Gaussian profile with the variance given at each wavenumber, all of which the profile holds a whole number of
    times."""
    spectrum = np.zeros(points // 2 + 1, dtype=complex)
    place = np.rint(k * step * points / (2.0 * np.pi)).astype(int)
    spectrum[place] = 0.5 * points * np.sqrt(variance) * (random.standard_normal((2, k.size)).T @ [1.0, 1.0j])
    return np.fft.irfft(spectrum, points)


def profiles(number: int) -> tuple[Array, list[tuple[Array, Array]], float]:
    """Distances, pairs of a long-waved profile and of small waves on it with S ∝ k⁻³, and the small waves' slope."""
    step, points = 0.03, 8192
    k = 2.0 * np.pi * np.arange(1, points // 2) / (step * points)
    long, small = (k > 0.13) & (k < 4.0), (k >= 4.0) & (k < 50.0)
    level = 0.004 * k**-3.0 * (k[1] - k[0])
    random = np.random.default_rng(5)
    made = [
        (drawn(random, step, points, k[long], level[long]), drawn(random, step, points, k[small], level[small]))
        for _ in range(number)
    ]
    return step * np.arange(points), made, float(np.sqrt(np.sum(level[small] * k[small] ** 2)))


def visible(x: Array, height: Array, eye: float) -> NDArray[np.bool_]:
    rise = np.full(x.size, -np.inf)
    rise[x > 1.0] = (height[x > 1.0] - eye) / x[x > 1.0]
    return rise >= np.maximum.accumulate(rise)


def test_what_smith_s_law_hides_of_lit_points_is_what_small_waves_hide() -> None:
    """Of 25–240 m within 1.5 % of the window, where they hide 7 % or so: what the law leaves out cancels. Sixty
    profiles scatter by 0.3 %."""
    x, made, slope = profiles(60)
    within = x > 25.0
    lit, seen, law = 0.0, 0.0, 0.0
    for long, small in made:
        before = visible(x, long, 5.0)
        grazing = np.gradient(long, x) + (5.0 - long) / np.maximum(x, 1.0)
        share = before * shadowing_smith67(np.maximum(grazing, 0.0) / (np.sqrt(2.0) * slope))
        lit, seen, law = (
            lit + before[within].mean(),
            seen + visible(x, long + small, 5.0)[within].mean(),
            (law + share[within].mean()),
        )
    lit, seen, law = (each / len(made) for each in (lit, seen, law))
    assert lit - seen > 0.05
    assert abs(law - seen) < 0.015


def test_the_upper_antenna_sees_what_the_lower_sees_and_little_more() -> None:
    """One above the other; the bound √(π/2) B/(R σ) is the law's steepest change with the grazing angle."""
    x, made, slope = profiles(20)
    surplus, bound = [], np.sqrt(0.5 * np.pi) * 0.2 / (100.0 * slope)
    around = np.abs(x - 100.0) < 20.0
    for long, small in made:
        lower, upper = (visible(x, long + small, eye) for eye in (4.9, 5.1))
        assert not (lower & ~upper).any()
        surplus.append(np.mean(upper[around] & ~lower[around] & visible(x, long, 4.9)[around]))
    assert 0.0 < np.mean(surplus) < bound


# -------------------------------------------------------------------------------------------------------- a run


@pytest.mark.parametrize(("nrcs", "share"), [("two_scale", "facing_in_sight"), ("nrl", "in_sight")])
def test_theory_echoes_from_what_faces_the_ray_and_a_mean_model_from_all(
    lit: Illumination, nrcs: str, share: str
) -> None:
    """Theory's σ0 is a mean over tilts of which those that turn away count 0: they must not be taken off twice."""
    scene = load_scene("tiny", {"scattering.nrcs": nrcs})
    surface, shaded = SeaSurface(scene.scattering, scene.radar, 4.0), UNLIKE.shade(lit)
    assert_allclose(surface(shaded, None).rcs, surface(lit, None).rcs * getattr(shaded, share), rtol=1e-5)


@pytest.fixture(scope="module")
def sector() -> dict[str, object]:
    return {"radar.sector_deg": [240.0, 300.0], "tracing.tracer": "horizon"}


def test_a_scene_s_small_waves_hide_what_truth_says_they_do(sector: dict[str, object]) -> None:
    """The cells' visible share is that of the facets' water. 3 %: cells' edges cut facets, and no cell is wider than
    another; a share of 1 gives the bits of light that is not shaded."""
    simulator = Simulator(load_scene("tiny", {**sector, **SMITH}))
    light, returns, _ = simulator.light(0)
    assert light.in_sight is not None

    def mean(light: Illumination) -> float:
        truth = polar_truth(light, returns.rcs, simulator.installation, simulator.scene.retrieval, 0)
        return float(truth["visible_fraction"].mean())

    bare = mean(replace(light, in_sight=None))
    heard = np.hypot(light.distance, simulator.installation.radar.height_m) > simulator.installation.radar.range_m[0]
    hidden = np.mean((light.visible_to_both * (1.0 - light.in_sight))[:, heard])
    assert bare - mean(light) == pytest.approx(hidden, rel=0.03)
    assert hidden > 0.02
    assert bare == mean(replace(light, in_sight=np.ones_like(light.in_sight)))


def test_the_mean_echo_stays_where_small_waves_hide() -> None:
    """Of all directions together, of which the calibration takes the mean of the same light, to 0.05 dB, a tenth of
    what it is known by; up the wind more is lost and across it less, 0.3 dB. Without these shadows it loses 1.0 dB."""
    keys = {
        "tracing.tracer": "horizon",
        "scattering.nrcs": "nrl",
        "radar.range_m": [15.0, 150.0],
        "sea.extent_m": 400.0,
        "tracing.diffraction": "none",
    }
    power = []
    for shadows in ({}, SMITH):
        light, returns, _ = Simulator(load_scene("choppy_sea", {**keys, **shadows})).light(0)
        power.append((returns.rcs * light.visible_to_both)[:, light.distance > 50.0].sum(dtype=np.float64))
    assert abs(10.0 * np.log10(power[1] / power[0])) < 0.05
