"""The sea's surface as a run has it: its mean is the model's, its spread is the theory's, its motion the wind's."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.conventions import db, wrap_degrees
from seamap_rt.echoes.radar_cross_section import SeaSurface, two_way_power
from seamap_rt.mesh.grid import circle_grid, polar_grid
from seamap_rt.mesh.surface import sea_on_grid, surface_mesh
from seamap_rt.radar.installation import Installation
from seamap_rt.scattering import MEAN_MODELS, ShortWaves, mean_nrcs, nrcs_composite, permittivity_meissner_wentz12
from seamap_rt.scattering.composite import CompositeSea
from seamap_rt.scene import Scene, load_scene
from seamap_rt.simulation import Simulator
from seamap_rt.tracing import Illumination, tracer


def scene(**keys: Any) -> Scene:
    """choppy_sea by the horizon tracer, with other keys."""
    overrides = {"tracing.tracer": "horizon"} | {key.replace("__", "."): value for key, value in keys.items()}
    return load_scene("choppy_sea", overrides)


@cache
def simulated(diffraction: str) -> tuple[Illumination, NDArray[np.float32]]:
    """The traced facets of a whole turn of choppy_sea, and their strain."""
    made = scene(tracing__diffraction=diffraction)
    mesh = Simulator(made).mesh(0)
    assert mesh.strain is not None
    light = tracer("horizon", made.radar, made.scattering, diffraction=made.tracing.diffraction)
    return light(mesh.levelled), mesh.strain


def lit(diffraction: str = "none") -> Illumination:
    return simulated(diffraction)[0]


def strain(diffraction: str = "none") -> NDArray[np.float32]:
    return simulated(diffraction)[1]


def surface(found: Scene, facets: Illumination) -> SeaSurface:
    """As the simulator makes it, but of these facets for all directions."""
    limit = np.pi / found.sea.resolution_m if found.sea.resolution_m else 0.0
    return SeaSurface(found.scattering, found.radar, limit).calibrated(facets, strain())


@pytest.mark.parametrize(("model", "polarization"), [("nrl", "HH"), ("git", "VV"), ("tsc", "HH"), ("hybrid", "VV")])
def test_the_mean_is_the_models_by_range_and_by_wind(model: str, polarization: str) -> None:
    near = 29.0 if model == "git" else 15.0  # GIT ends at 10° of grazing
    made = scene(scattering__calibrated_to=model, scattering__polarization=polarization, radar__range_m=[near, 400.0])
    facets = lit()
    returns = surface(made, facets)(facets, strain())
    power = returns.rcs * two_way_power(facets)
    wind = np.radians(wrap_degrees(facets.grid.column_azimuth - 270.0))[:, None]
    grazing = np.degrees(np.arctan(5.0 / facets.distance))
    wanted = facets.horizontal_area * mean_nrcs(model, grazing[None, :], 8.0, 10e9, polarization, wind, clipped=True)
    wanted = np.broadcast_to(wanted, power.shape)
    looks = np.abs(wrap_degrees(facets.grid.column_azimuth)) <= 180.0  # not those that run on beyond the turn
    for near_m, far_m in ((30.0, 60.0), (60.0, 120.0), (120.0, 240.0), (240.0, 400.0)):
        ring = (facets.distance > near_m) & (facets.distance < far_m)
        # 0.3 dB is what is asked of the calibration.
        assert abs(float(db(power[looks][:, ring].sum() / wanted[looks][:, ring].sum()))) < 0.3
    if not MEAN_MODELS[model].knows_wind_direction:
        return
    for middle in (0.0, 90.0, 180.0, 270.0):
        sector = np.abs(wrap_degrees(np.degrees(wind[:, 0]) - middle)) <= 45.0
        far = facets.distance > 30.0
        assert abs(float(db(power[sector][:, far].sum() / wanted[sector][:, far].sum()))) < 0.3
        for near_m, far_m in ((20.0, 35.0), (35.0, 90.0), (90.0, 400.0)):
            ring = (facets.distance > max(near_m, near)) & (facets.distance < far_m)
            if model == "git" and near_m < near:
                continue
            # A quadrant of a ring holds a few crests: 0.3 dB of the fit and their own scatter.
            assert abs(float(db(power[sector][:, ring].sum() / wanted[sector][:, ring].sum()))) < 1.2


@pytest.mark.parametrize(
    ("model", "polarization"), [*zip(MEAN_MODELS, ("VV", "HH") * (len(MEAN_MODELS) // 2), strict=True)]
)
def test_the_echo_changes_with_direction_as_its_model_does_or_as_theory_does(model: str, polarization: str) -> None:
    facets, near = lit(), 30.0  # GIT ends at 10° of grazing
    keys: dict[str, Any] = {"scattering__polarization": polarization, "radar__range_m": [near, 400.0]}
    found, knows = (
        surface(scene(scattering__calibrated_to=model, **keys), facets),
        MEAN_MODELS[model].knows_wind_direction,
    )
    power, theory = found(facets, strain()).rcs, np.sum(found.terms(facets, strain()), axis=0)
    heard, far = two_way_power(facets), facets.distance > near
    if not knows:  # theory times one factor a ring, whatever the look, to float32's digits
        factor = np.where(theory > 0.0, power / np.where(theory > 0.0, theory, 1.0), np.nan)[:, far]
        one = np.nanmedian(factor, axis=0)
        np.testing.assert_allclose(
            np.where(np.isnan(factor), one, factor), np.broadcast_to(one, factor.shape), rtol=1e-5
        )
    angle = np.abs(np.degrees(found.wind(facets)[:, 0]))
    up, across, down = (np.abs(angle - middle) <= 45.0 for middle in (0.0, 90.0, 180.0))

    def contrasts_db(field: NDArray[np.floating]) -> NDArray[np.float64]:
        ahead, aside, behind = (
            field[sector][:, far].sum(dtype=np.float64) / sector.sum() for sector in (up, across, down)
        )
        return db(np.array([ahead / aside, ahead / behind]))

    mean = np.broadcast_to(found.mean(facets) * facets.horizontal_area, power.shape)
    wanted = contrasts_db(mean if knows else theory * heard)
    assert np.all(wanted > 1.0)
    # Of theory, rings count by other powers; of a fit by direction, each side is good to 0.3 dB.
    np.testing.assert_allclose(contrasts_db(power * heard), wanted, atol=0.6)


def test_the_scale_takes_out_no_wave() -> None:
    facets, made = lit(), scene()
    found = surface(made, facets)
    terms = found.terms(facets, strain())
    theory = terms.bragg + terms.specular + terms.breaking
    bright = theory > 0.0
    far = facets.distance > 15.0
    scale = np.where(bright, found(facets, strain()).rcs / np.where(bright, theory, 1.0), np.nan)[:, far]
    logarithm = np.log(np.nanmean(scale, axis=0))
    # Over a quarter of the peak's wavelength, 12 m, the scale changes less than a dB beyond 30 m; the waves change
    # what theory gives by 4 dB rms.
    step = np.abs(logarithm[48::48] - logarithm[:-48:48])[facets.distance[far][48::48] > 30.0]
    assert db(np.exp(step.max())) < 1.0
    swing = np.log(np.maximum(theory[:, far].astype(np.float64), 1e-9))[bright[:, far]].std()
    assert db(np.exp(swing)) > 3.0


def test_facets_that_lean_towards_the_radar_return_more() -> None:
    facets, made = lit(), scene()
    rcs = surface(made, facets)(facets, strain()).rcs / facets.horizontal_area
    seen = facets.visible_to_both & (facets.distance > 60.0) & (facets.distance < 150.0)
    leaning = facets.slope_look[seen]
    steep, flat = np.quantile(leaning, [0.8, 0.2])
    assert rcs[seen][leaning > steep].mean() > 3.0 * rcs[seen][leaning < flat].mean()


def test_strain_and_breakers_brighten_where_the_water_converges() -> None:
    facets = lit()
    seen = facets.visible_to_both & (facets.distance > 60.0)
    crowded, thin = (strain()[seen] > 0.03), (strain()[seen] < -0.03)
    with_strain, without = (surface(scene(scattering__hydrodynamic_modulation=on), facets) for on in (True, False))
    assert without.memory_rate is None
    terms = with_strain.terms(facets, strain())
    share = terms.breaking[seen] / (terms.bragg + terms.specular + terms.breaking)[seen]
    assert share[crowded].mean() > 2.0 * share[thin].mean()
    bare = SeaSurface(without.scattering, without.radar, without.resolved_below).terms(facets, None)
    ratio = terms.bragg[seen] / bare.bragg[seen]
    assert ratio[crowded].mean() > 1.1 > 0.9 > ratio[thin].mean()  # exp(4.5 · 0.03) = 1.14


def test_breakers_are_most_of_hh_and_little_of_vv() -> None:
    facets, shares = lit(), {}
    for polarization in ("HH", "VV"):
        found = surface(scene(scattering__polarization=polarization), facets)(facets, strain())
        assert found.motion is not None
        assert found.motion.breaking is not None
        shares[polarization] = float((found.rcs * found.motion.breaking).sum() / found.rcs.sum())
        still = surface(scene(scattering__polarization=polarization, scattering__breaking=False), facets)(
            facets, strain()
        )
        assert still.motion is not None
        assert still.motion.breaking is None
    # At 12° more than 90 % of a breaker's HH and some 60 % of its VV come from the crest; of the whole sea, less.
    assert shares["HH"] > 0.6
    assert shares["VV"] < 0.4


def test_scatterers_run_down_wind() -> None:
    facets = lit()
    motion = surface(scene(), facets)(facets, strain()).motion
    assert motion is not None
    wind = wrap_degrees(facets.grid.column_azimuth - 270.0)
    into, along, across = (np.abs(wrap_degrees(wind - middle)) < 10.0 for middle in (0.0, 180.0, 90.0))
    assert np.all(motion.approaching[into] > 0.99)  # cos⁴ 5° against sin⁴ 5°
    assert np.all(motion.approaching[along] < 0.01)
    np.testing.assert_allclose(motion.approaching[across].mean(), 0.5, atol=0.01)
    assert np.all(motion.breaker_speed[into] < 0.0)  # outward: they come
    assert np.all(motion.breaker_speed[along] > 0.0)
    fastest = np.abs(motion.breaker_speed).max()  # into the wind, to half a column
    np.testing.assert_allclose(motion.breaker_speed, -fastest * np.cos(np.radians(wind)), atol=1e-3 * fastest)
    # X band's Bragg waves, 1.5 cm long: √(g/k + T k/ρ)
    k = 4.0 * np.pi * 10e9 / 299_792_458.0
    np.testing.assert_allclose(motion.bragg_speed, np.sqrt(9.81 / k + 0.074 / 1025.0 * k), rtol=1e-9)
    assert surface(scene(scattering__doppler="orbital"), facets)(facets, strain()).motion is None


@pytest.mark.parametrize(
    ("nrcs", "wind_m_s", "share"),
    [("two_scale", 8.0, 0.03), ("two_scale", 12.0, 0.01), ("nrl", 12.0, 0.03), ("constant", 8.0, 0.0)],
)
def test_all_scatterers_drift_before_the_wind(nrcs: str, wind_m_s: float, share: float) -> None:
    made = scene(scattering__nrcs=nrcs, scattering__wind_drift=share, scattering__wind_speed_m_s=wind_m_s)
    facets = lit()
    running = surface(made, facets)(facets, strain()).running
    outward = np.zeros((1, 1)) if running is None else running
    wind = np.radians(facets.grid.column_azimuth - 270.0)[:, None]  # 0 looks into it: water comes
    np.testing.assert_allclose(outward + 0.0 * wind, -share * wind_m_s * np.cos(wind), atol=1e-6)
    orbital = scene(scattering__nrcs=nrcs, scattering__doppler="orbital")
    assert surface(orbital, facets)(facets, strain()).running is None


@pytest.mark.parametrize(("look", "towards"), [(270.0, 1.0), (0.0, 0.0), (90.0, -1.0)])
def test_the_mean_doppler_is_that_of_bragg_waves_and_drift(look: float, towards: float) -> None:
    """Of a level sea under 8 m/s in VV: up the wind Bragg waves (0.23 m/s) and 0.24 m/s of drift come, across the wind
    as much comes as goes. The mean velocity is the phase of the covariance of neighbouring pulses."""
    keys: dict[str, Any] = {
        "sea__waves": [], "scattering__breaking": False, "radar__sector_deg": [look - 4.0, look + 4.0],
        "radar__range_m": [50.0, 120.0], "radar__noise": False, "radar__transmit": "single",
        "radar__prf_hz": 2000.0, "radar__rotation_rpm": 4.0,
    }  # fmt: skip
    echoes = Simulator(scene(**keys)).turn(0).echoes
    voltage = echoes["voltage"].values[:, 0].astype(np.complex128)
    turned = np.angle(np.sum(voltage[1:] * voltage[:-1].conj()))
    wavelength = 299_792_458.0 / 10e9
    velocity = turned * 2000.0 * wavelength / (4.0 * np.pi)  # m/s, what comes is positive
    # 8° of the circle about the wind and 5° of grazing take 0.4 % off; speckle of some 1e4 looks strays by 0.01 m/s.
    assert velocity == pytest.approx(towards * (0.231 + 0.03 * 8.0), abs=0.03)


def test_a_sector_is_calibrated_as_the_circle_is() -> None:
    keys: dict[str, Any] = {"radar__range_m": [15.0, 100.0], "sea__extent_m": 300.0, "sea__resolution_m": 1.0}
    whole, sector = (
        Simulator(scene(**keys, radar__sector_deg=sector)).surface.scale for sector in ([0.0, 360.0], [250.0, 260.0])
    )
    assert whole is not None
    assert sector is not None
    np.testing.assert_array_equal(whole.coefficients, sector.coefficients)


def test_a_run_of_turns_keeps_one_scale() -> None:
    simulator = Simulator(scene(radar__range_m=[15.0, 60.0], radar__sector_deg=[250.0, 260.0], sea__extent_m=200.0))
    first = simulator.surface
    simulator.light(1)
    assert simulator.surface is first


def test_theory_alone_is_not_scaled_and_constant_is_constant() -> None:
    facets = lit()
    alone = surface(scene(scattering__calibrated_to="none"), facets)
    assert alone.scale is None
    terms = alone.terms(facets, strain())
    np.testing.assert_array_equal(alone(facets, strain()).rcs, terms.bragg + terms.specular + terms.breaking)
    level = scene(scattering__nrcs="constant", scattering__nrcs_db=-30.0)
    rcs = surface(level, facets)(facets, strain()).rcs
    seen = facets.lit.any(axis=0)
    np.testing.assert_allclose(rcs[seen], np.broadcast_to(1e-3 * facets.horizontal_area, rcs.shape)[seen], rtol=1e-6)
    assert not rcs[~seen].any()


@pytest.mark.parametrize("model", ["nrl", "tsc", "hybrid"])
def test_a_measured_mean_on_every_lit_facet(model: str) -> None:
    facets = lit()
    rcs = surface(scene(scattering__nrcs=model), facets)(facets, strain()).rcs
    np.testing.assert_array_equal(rcs > 0.0, facets.lit.any(axis=0))
    # What is lit makes up for what is dark: in one direction, at about one range, all that is lit is scaled alike.
    per_area = (rcs / facets.horizontal_area)[100:104]
    near = (facets.distance > 60.0) & (facets.distance < 63.0) & (per_area > 0.0)
    assert near.any()
    assert np.ptp(per_area[near]) < 0.3 * per_area[near].mean()  # 3 m of range are 0.7 dB of NRL


def test_two_way_power_without_diffraction_is_the_pairs_that_see() -> None:
    facets = lit()
    lower, upper = facets.lit.astype(np.float64)
    pairs = (lower * lower + 2.0 * lower * upper + upper * upper) / 4.0  # (0,0), (0,1), (1,0), (1,1)
    np.testing.assert_allclose(two_way_power(facets), pairs, atol=1e-7)


def test_diffraction_reaches_the_dark_and_keeps_the_mean() -> None:
    facets = lit("knife_edge")
    assert facets.field is not None
    made = scene(tracing__diffraction="knife_edge")
    rcs = surface(made, facets)(facets, strain()).rcs
    dark = ~facets.lit.any(axis=0)
    assert np.any(rcs[dark] > 0.0)
    assert not np.any(rcs[(facets.field == 0.0).all(axis=0)])
    power = rcs * two_way_power(facets)
    ring = (facets.distance > 120.0) & (facets.distance < 400.0)
    wanted = facets.horizontal_area * mean_nrcs(
        "nrl", np.degrees(np.arctan(5.0 / facets.distance)), 8.0, 10e9, "VV", clipped=True
    )
    assert abs(float(db(power[:, ring].sum() / (len(power) * wanted[ring].sum())))) < 0.3


def test_the_circle_samples_every_direction_within_bounded_memory() -> None:
    for far in (60.0, 400.0, 6000.0):
        made = scene()
        radar = made.radar.model_copy(update={"range_m": (15.0, far), "sector_deg": (100.0, 110.0)})
        grid, columns = circle_grid(radar, made.tracing)
        assert columns.shape == (grid.columns,)
        azimuth = np.sort(grid.column_azimuth[columns] % 360.0)
        gaps = np.diff(np.append(azimuth, azimuth[0] + 360.0))
        np.testing.assert_allclose(np.diff(grid.azimuth)[columns], grid.spacing_deg, rtol=1e-9)
        assert gaps.max() < 31.0  # at least twelve groups
        assert grid.columns * 2 * (grid.ground_range.size - 1) < 2e6


def test_the_sea_of_the_circle_is_that_of_the_turn() -> None:
    made = scene(radar__range_m=[15.0, 60.0], sea__extent_m=200.0, tracing__columns_per_beam=4)  # the circle's own
    simulator = Simulator(made)
    grid, columns = circle_grid(made.radar, made.meshing)
    circle = surface_mesh(grid, *sea_on_grid(simulator.sea, grid)).facets
    still = replace(
        polar_grid(Installation(made.radar), made.meshing, 0), time=np.zeros(simulator.mesh(0).grid.sweep.size)
    )
    turn = surface_mesh(still, *sea_on_grid(simulator.sea, still)).facets
    for number in np.flatnonzero(columns)[::7]:
        twin = int(np.argmin(np.abs(turn.grid.column_sweep - grid.column_sweep[number])))
        np.testing.assert_allclose(circle.height[number], turn.height[twin], atol=1e-9)
    assert tracer("horizon", made.radar, made.scattering)(simulator.mesh(0)).lit.any()


@pytest.mark.parametrize("diffraction", ["none", "knife_edge"])
def test_terms_are_the_facets_own_on_their_true_area(diffraction: str) -> None:
    facets, made = lit(diffraction), scene()
    found = SeaSurface(made.scattering, made.radar, 4.0)
    fall = (5.0 - facets.height) / facets.distance if facets.ray_slope is None else facets.ray_slope
    sigma = nrcs_composite(
        0.5 * np.pi - np.arctan(fall),  # of the ray that arrives: over an edge it falls more steeply
        facets.slope_look,
        facets.slope_cross,
        np.radians(facets.grid.column_azimuth - 270.0)[:, None],
        frequency_hz=10e9,
        permittivity=complex(permittivity_meissner_wentz12(10e9, 20.0, 35.0)),
        polarization="VV",
        waves=ShortWaves(8.0, 4.0),
        strain=strain(),
    )
    area = facets.horizontal_area * np.sqrt(1.0 + facets.slope_look**2 + facets.slope_cross**2)
    reached = facets.lit if facets.field is None else facets.field != 0.0
    for term, level in zip(found.terms(facets, strain()), sigma, strict=True):
        np.testing.assert_allclose(term, level * area * reached.any(axis=0), rtol=2e-3, atol=1e-12)  # float32 angles


@pytest.mark.parametrize("polarization", ["VV", "HH"])
@pytest.mark.parametrize("wind_speed", [3.0, 8.0, 20.0])
def test_single_precision_is_enough_in_every_attitude(wind_speed: float, polarization: str) -> None:
    # Leaning facets seen from grazing to the vertical, from before and from behind, in all winds. float32 knows cos θi
    # to 6e-8, and the exponent of mirrors is up to 200 times 1 − 1/cos² θi: 3e-5.
    rng, shape = np.random.default_rng(3), 12_000
    permittivity = complex(permittivity_meissner_wentz12(10e9, 20.0, 35.0))
    sea = CompositeSea.of(10e9, permittivity, polarization, ShortWaves(wind_speed, 4.0), 0.01)
    incidence = 0.5 * np.pi - np.arctan(np.exp(rng.uniform(np.log(1e-3), np.log(30.0), shape)))
    look, cross, strain = rng.normal(0.0, 0.2, (3, shape))
    wind = rng.uniform(-np.pi, np.pi, shape)
    given = np.sin(incidence), np.cos(incidence), look, cross, np.cos(wind), np.sin(wind), strain
    exact, single = np.stack(sea.nrcs(*given)), sea.nrcs(*(each.astype(np.float32) for each in given))
    assert {each.dtype for each in single} == {np.dtype(np.float32)}
    assert np.all(np.abs(np.stack(single) - exact) <= 5e-5 * exact.sum(axis=0) + 3e-8)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_slope_that_is_no_number_looks_up_nothing_beyond_a_table(value: float) -> None:
    permittivity = complex(permittivity_meissner_wentz12(10e9, 20.0, 35.0))
    sea = CompositeSea.of(10e9, permittivity, "VV", ShortWaves(8.0, 4.0), 0.01)
    sine, cosine, look, cross, strain = np.full((5, 64), 0.1, np.float32)
    axis = np.ones(64, np.float32), np.zeros(64, np.float32)
    whole = sea.nrcs(sine, cosine, look, cross, *axis, strain)
    look = np.where(np.arange(64) % 2 == 0, np.float32(value), look)
    with np.errstate(invalid="ignore"):
        made = sea.nrcs(sine, cosine, look, cross, *axis, strain)
    for found, wanted in zip(made, whole, strict=True):
        np.testing.assert_array_equal(found[1::2], wanted[1::2])  # its neighbours' are their own


def test_a_run_with_diffraction_is_calibrated_with_it() -> None:
    simulator = Simulator(scene(tracing__diffraction="knife_edge"))
    facets, returns, _ = simulator.light(0)
    ring = (facets.distance > 250.0) & (facets.distance < 400.0)
    power = (returns.rcs * two_way_power(facets))[:, ring].sum()
    grazing = np.degrees(np.arctan(5.0 / facets.distance[ring]))
    wanted = facets.horizontal_area[ring] * mean_nrcs("nrl", grazing, 8.0, 10e9, "VV")
    # Straight light would make it 3 to 4 dB too weak: diffraction takes that much of the power out there.
    assert abs(float(db(power / (facets.grid.columns * wanted.sum())))) < 0.5


@pytest.mark.parametrize(("look", "sign"), [(270.0, 1.0), (90.0, -1.0)])
def test_a_runs_echoes_turn_as_the_scatterers_move(look: float, sign: float) -> None:
    # A sea without waves of its own, so that only ripples and breakers move: HH, mostly breakers, at about 60 Hz.
    keys: dict[str, Any] = {
        "scattering__polarization": "HH",
        "sea__waves": [],
        "radar__noise": False,
        "radar__range_m": [15.0, 150.0],
        "radar__sector_deg": [look - 24.0, look + 24.0],
    }
    lag, turned = 10, {}
    for doppler in ("full", "orbital"):
        voltage = Simulator(scene(**keys, scattering__doppler=doppler)).turn(0).echoes["voltage"].values[:, 0]
        product = voltage[lag:] * voltage[:-lag].conj()
        turned[doppler] = float(np.angle(product.sum())) / (2.0 * np.pi * lag * 1e-4)
    # Some 2000 cells: over four seeds the mean frequency of the still ones scatters by 1.8 Hz (by 4.3 Hz over ±6°).
    assert 35.0 < sign * turned["full"] < 90.0
    assert abs(turned["orbital"]) < 8.0
