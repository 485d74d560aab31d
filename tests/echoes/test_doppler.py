"""Scatterers that move relative to the water: covariance of the speckle, and Doppler of the voltages."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from exact_echoes import series_of
from numpy.typing import NDArray

from seamap_rt import sea as sea_package
from seamap_rt.compute import machine
from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.echoes import turn, turn_voltages
from seamap_rt.echoes.speckle import (
    Motion,
    MovingSpeckle,
    SpeedBounds,
    StillSpeckle,
    fastest_echo,
    speckle_basis,
    two_way_basis,
)
from seamap_rt.echoes.summation.gaussian import draw_all, key_of
from seamap_rt.echoes.turn import choose_nodes
from seamap_rt.mesh import mesh_turn, polar_grid, surface_mesh
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.radar.waveform import gates
from seamap_rt.settings import RadarSettings, SeaSettings, SinusoidWaves, TracingSettings
from seamap_rt.tracing import Illumination
from seamap_rt.tracing.horizon import trace_horizon

SEED = 4
K = 2.0 * np.pi * 10e9 / SPEED_OF_LIGHT
WAVELENGTH = SPEED_OF_LIGHT / 10e9


def radar_of(**others) -> RadarSettings:
    base = {"noise": False, "sector_deg": (20.0, 30.0), "range_m": (15.0, 80.0), "transmit": "single"}
    return RadarSettings.model_validate({**base, **others})


def flat_sea(radar: RadarSettings) -> tuple[Illumination, NDArray[np.float32]]:
    """A flat sea at rest."""
    grid = polar_grid(Installation(radar), TracingSettings(), 0)
    shape = (grid.sweep.size, grid.ground_range.size)
    facets = trace_horizon(surface_mesh(grid, np.zeros(shape), np.zeros((*shape, 3), np.float32)))
    return facets, np.broadcast_to(1e-3 * facets.horizontal_area, facets.height.shape).astype(np.float32)


def motion_of(
    facets: Illumination | None = None,
    *,
    bragg: float = 0.24,
    approaching: float = 0.5,
    breaking: float | NDArray[np.float32] | None = None,
    speed: float = 0.0,
    spread: float = 0.0,
) -> Motion:
    """The same motion in each column; without facets, in one column."""
    columns = 1 if facets is None else facets.height.shape[0]
    if facets is not None and isinstance(breaking, float):
        breaking = np.full(facets.height.shape, breaking, dtype=np.float32)
    assert not isinstance(breaking, float | int)
    return Motion(bragg, np.full(columns, approaching), breaking, np.full(columns, speed), spread)


def bragg_law(lag: NDArray[np.float64], tau: float, speed: float, approaching: float) -> NDArray[np.complex128]:
    phase = 2.0 * K * speed * lag
    return np.exp(-((lag / tau) ** 2)) * (np.cos(phase) + 1j * (2.0 * approaching - 1.0) * np.sin(phase))


def breaker_law(lag: NDArray[np.float64], tau: float, speed: float, spread: float) -> NDArray[np.complex128]:
    return np.exp(-((lag / tau) ** 2) - 0.5 * (2.0 * K * spread * lag) ** 2 - 2j * K * speed * lag)


# ------------------------------------------------------------------------------------------------- speckle


@pytest.mark.parametrize("tau", [3e-3, 10e-3, np.inf])
@pytest.mark.parametrize("approaching", [0.0, 0.1, 0.5, 1.0])
def test_one_basis_serves_every_share(tau: float, approaching: float) -> None:
    # Both directions at 0.24 and, far apart, at 2 m/s. 1e-4 of half and half's variance is left out, at most twice
    # that of any other share's: an entry, by Cauchy and Schwarz, errs by less than what its two nodes lack, and the
    # first and the last node lack most, up to 30 × 2e-4.
    nodes, spacing = 30, 0.7e-3
    time = spacing * np.arange(nodes)
    for speed in (0.24, 2.0):
        basis, contrast = two_way_basis(nodes, spacing, tau, 2.0 * K * speed)
        covariance = np.einsum("mt,m,mu->tu", basis, 1.0 + (2.0 * approaching - 1.0) * contrast, basis.conj())
        law = bragg_law(time[:, None] - time, tau, speed, approaching)
        np.testing.assert_allclose(covariance, law, rtol=0, atol=6e-3)
        if approaching == 0.5:
            np.testing.assert_allclose(covariance.imag, 0.0, atol=1e-12)


@pytest.mark.parametrize("approaching", [0.0, 0.3, 0.5, 1.0])
@pytest.mark.parametrize(("tau", "spread"), [(10e-3, 0.0), (5e-3, 0.4), (np.inf, 0.4), (np.inf, 0.0)])
def test_covariance_of_the_draws(tau: float, spread: float, approaching: float) -> None:
    # Facets of three kinds in one column. A covariance from n complex draws errs by 1/√n; 5.5 of it covers three times
    # 900 entries. The truncation leaves out up to 6e-3, see above.
    nodes, spacing, each = 30, 0.7e-3, 30_000
    breaking = np.repeat(np.array([0.0, 0.3, 1.0], dtype=np.float32), each)[None]
    motion = motion_of(approaching=approaching, breaking=breaking, speed=3.0, spread=spread)
    series = series_of(MovingSpeckle.of(nodes, spacing, K, tau, motion, SEED), 0, 17, 3 * each)
    time = spacing * np.arange(nodes)
    lag = time[:, None] - time
    for kind, share in enumerate((0.0, 0.3, 1.0)):
        drawn = series[:, kind * each : (kind + 1) * each]
        law = (1.0 - share) * bragg_law(lag, tau, 0.24, approaching) + share * breaker_law(lag, tau, 3.0, spread)
        tolerance = 5.5 / np.sqrt(each) + 6e-3
        np.testing.assert_allclose(drawn @ drawn.conj().T / each, law, rtol=0, atol=tolerance)
        # Circular: no covariance without conjugation.
        np.testing.assert_allclose(drawn @ drawn.T / each, 0.0, atol=5.5 * np.sqrt(2.0 / each))


def test_every_facet_has_unit_power_at_every_node() -> None:
    breaking = np.array([[0.0, 0.25, 1.0]], dtype=np.float32)
    for approaching in (0.0, 0.5, 0.9):
        motion = motion_of(approaching=approaching, breaking=breaking, speed=-2.0, spread=0.3)
        speckle = MovingSpeckle.of(40, 0.8e-3, K, 10e-3, motion, SEED)
        for rows in speckle.modes(slice(0, 1), np.zeros(1)):
            np.testing.assert_allclose(np.sum(np.abs(rows[0]) ** 2, axis=0), 1.0, atol=1e-6)  # float32


def test_a_column_keeps_its_numbers() -> None:
    # Where the end of a turn is the start of the next, a column has another place but the same number: the same bits.
    rng = np.random.default_rng(1)
    approaching, speed = rng.uniform(size=9), rng.normal(size=9)
    breaking = rng.uniform(size=(9, 50)).astype(np.float32)
    whole = Motion(0.24, approaching, breaking, speed, 0.4)
    part = Motion(0.24, approaching[6:], breaking[6:], speed[6:], 0.4)
    there = series_of(MovingSpeckle.of(20, 1e-3, K, 0.01, whole, SEED), 7, 123, 50)
    here = series_of(MovingSpeckle.of(20, 1e-3, K, 0.01, part, SEED), 1, 123, 50)
    np.testing.assert_array_equal(there, here)
    other = series_of(MovingSpeckle.of(20, 1e-3, K, 0.01, part, SEED), 1, 124, 50)
    assert abs(np.vdot(here, other)) / (20 * 50) < 0.5  # some 5 × 50 samples in common by chance: 0.06


def test_bragg_waves_and_breakers_share_no_number() -> None:
    # A facet of breakers alone and one of Bragg waves alone in the same place of the same column.
    kinds = []
    for share in (0.0, 1.0):
        motion = motion_of(bragg=0.0, breaking=np.full((1, 20_000), share, dtype=np.float32))
        kinds.append(series_of(MovingSpeckle.of(12, 1e-3, K, 0.01, motion, SEED), 0, 3, 20_000))
    assert np.max(np.abs(kinds[0] @ kinds[1].conj().T)) / 20_000 < 5.0 / np.sqrt(20_000)


def test_speckle_without_motion_has_its_numbers() -> None:
    # A turn without motion keeps the bits it has: the key of the draws, by SplitMix64 as published (its first number
    # after the state 0 is 0xE220A8397B1DCDAF), and their order: column, facet, mode.
    assert int(key_of(np.uint64(0), 0)) == 0xE220A8397B1DCDAF
    basis = speckle_basis(20, 1e-3, 0.01)
    found = series_of(StillSpeckle(basis, 7), 5, 321, 11)
    key = np.random.SeedSequence(7, spawn_key=(2,)).generate_state(1, np.uint64)[0]
    column = np.uint64(key_of(key, 321))
    draws = np.stack([draw_all(np.uint64(column), 11, len(basis))[:, facet] for facet in range(11)], axis=1)
    np.testing.assert_array_equal(found, basis.T @ draws)


# ------------------------------------------------------------------------------------------------- voltages


def test_doppler_in_the_voltages() -> None:
    # Slow rotation (6 rpm): the ratio of the gates' autocorrelation to that of unchanging speckle is the law itself.
    # 1500 pulses hold some 300 ms/4 ms independent samples for each of the 40 cells in range, 0.02 of a correlation;
    # and interpolation between nodes, at a prf of 4 kHz, must not fold what breakers at 4 m/s echo at 267 Hz.
    radar = radar_of(rotation_rpm=6.0, sector_deg=(20.0, 50.0), prf_hz=4e3)
    facets, rcs = flat_sea(radar)
    fired, lags = pulses(Installation(radar), 0), np.array([1, 3, 6, 10, 16])

    def correlation(tau: float, motion: Motion | None) -> NDArray[np.complex128]:
        v = turn_voltages(facets, rcs, Installation(radar), fired, SEED, tau, motion=motion)[:, 0].astype(np.complex128)
        power = np.sum(np.abs(v) ** 2)
        return np.array([np.sum(v[lag:] * v[: v.shape[0] - lag].conj()) / power for lag in lags])

    lag = lags / radar.prf_hz
    still = correlation(np.inf, None)
    for tau, approaching, share, speed in (
        (4e-3, 1.0, None, 0.0),
        (4e-3, 0.0, None, 0.0),
        (4e-3, 0.5, None, 0.0),
        (6e-3, 0.8, 0.5, -4.0),
        (6e-3, 0.2, 1.0, 4.0),
    ):
        motion = motion_of(facets, bragg=0.6, approaching=approaching, breaking=share, speed=speed, spread=0.2)
        if share is not None:
            assert choose_nodes(facets, radar, fired, tau, motion).stride > 1
        law = (1.0 - (share or 0.0)) * bragg_law(lag, tau, 0.6, approaching)
        law += (share or 0.0) * breaker_law(lag, tau, speed, 0.2)
        found = correlation(tau, motion) / still
        np.testing.assert_allclose(found, law, rtol=0, atol=0.03)
        if share is None and approaching != 0.5:  # what approaches has a positive frequency
            assert np.sign(np.angle(found[1])) == (1.0 if approaching == 1.0 else -1.0)


@pytest.mark.parametrize("tau", [2e-3, np.inf])
def test_motion_leaves_the_power(tau: float) -> None:
    # 30° hold 23 beams (two ways, 1.3°), 65 m of range 22 pulses (3 m): 500 independent powers even where speckle
    # never changes, 4.5 % of their mean, in both turns: 6.4 %, of which 0.2 is more than three. Each gate is divided by
    # its own mean, or the nearest would outweigh all others.
    radar = radar_of(sector_deg=(20.0, 50.0), rotation_rpm=12.0, prf_hz=2e3)
    facets, rcs = flat_sea(radar)
    fired = pulses(Installation(radar), 0)
    motion = motion_of(facets, approaching=0.7, breaking=0.4, speed=2.0, spread=0.3)
    still, moving = (
        np.mean(
            np.abs(turn_voltages(facets, rcs, Installation(radar), fired, SEED, tau, motion=each)) ** 2, axis=(0, 1)
        )
        for each in (None, motion)
    )
    assert np.mean(moving / still) == pytest.approx(1.0, abs=0.2)


def test_doppler_follows_the_swell() -> None:
    # A swell 60 m long comes from where the radar looks, at 1.5 rpm over 1.8° (0.2 s, in which it moves by 2 m): each
    # gate's pulse-pair frequency against the orbital velocity of deep water, ωη against the look and ∂η/∂t up. It is
    # lit everywhere. The mean is over columns ±5.4° off the swell and over the beam's 0.2 s.
    radar = radar_of(rotation_rpm=1.5, sector_deg=(24.0, 26.0), prf_hz=1e3, height_m=10.0, range_m=(20.0, 120.0))
    wave = SinusoidWaves(spectrum="sinusoid", height_m=1.2, wavelength_m=60.0, phase_deg=40.0, wave_from_deg=25.0)
    sea = sea_package.realize(SeaSettings(waves=(wave,)), 1)
    facets = trace_horizon(mesh_turn(sea, radar, TracingSettings(columns_per_beam=3), 0))
    assert facets.lit.all()
    rcs = np.broadcast_to(1e-3 * facets.horizontal_area, facets.height.shape).astype(np.float32)
    fired = pulses(Installation(radar), 0)
    wavenumber, middle = 2.0 * np.pi / 60.0, float(fired.time.mean())
    omega, slant = np.sqrt(9.81 * wavenumber), gates(radar)
    out = np.sqrt(slant**2 - 10.0**2)
    phase = -wavenumber * out - omega * middle + np.radians(40.0)  # it runs inward
    inward, up = 0.6 * omega * np.cos(phase), 0.6 * omega * np.sin(phase)
    closing = inward * out / slant + up * 10.0 / slant
    for approaching, share, speed in ((1.0, None, 0.0), (0.0, None, 0.0), (0.5, 1.0, -2.0)):
        motion = motion_of(facets, approaching=approaching, breaking=share, speed=speed)
        v = turn_voltages(facets, rcs, Installation(radar), fired, SEED, 0.01, motion=motion)[:, 0].astype(
            np.complex128
        )
        found = np.angle(np.sum(v[1:] * v[:-1].conj(), axis=0)) * radar.prf_hz / (2.0 * np.pi)
        own = (2.0 * approaching - 1.0) * 0.24 if share is None else -speed
        difference = found - 2.0 * (closing + own) / WAVELENGTH
        # A pulse pair's frequency errs by the spectrum's width, 28 Hz with Bragg's two lines in it, over the root of
        # the 0.33 s / 13 ms independent samples: 5.5 Hz in a gate, 1 Hz in the mean of 67, of which 33 are independent.
        # The swell's Doppler has 29 Hz rms: its factor errs by 1/29 a standard deviation. Bragg's own is 16 Hz.
        assert np.sqrt(np.mean(difference**2)) < 8.0
        assert abs(np.mean(difference)) < 4.0
        assert np.polyfit(2.0 * closing / WAVELENGTH, found, 1)[0] == pytest.approx(1.0, abs=0.15)


def test_motion_leaves_the_interferometric_phase() -> None:
    # A single facet: what both receivers share drops out, whatever its scatterers do. Phases in float32, 1e-4 rad.
    radar = radar_of()
    facets, whole = flat_sea(radar)
    rcs = np.zeros_like(whole)
    column, facet = rcs.shape[0] // 2, rcs.shape[1] // 2
    rcs[column, facet] = whole[column, facet]
    fired, products = pulses(Installation(radar), 0), []
    for motion in (None, motion_of(facets, approaching=1.0, breaking=0.5, speed=3.0, spread=0.3)):
        v = turn_voltages(facets, rcs, Installation(radar), fired, SEED, 0.01, motion=motion).astype(np.complex128)
        product = v[:, 0] * v[:, 1].conj()
        bright = np.abs(product) > 1e-2 * np.abs(product).max()
        assert bright.sum() > 50
        products.append(np.angle(product[bright]))
        assert np.ptp(products[-1]) < 3e-4
    assert abs(products[0].mean() - products[1].mean()) < 1e-4


def test_threads_and_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    radar = radar_of(transmit="switched")
    facets, rcs = flat_sea(radar)
    fired = pulses(Installation(radar), 0)
    breaking = np.random.default_rng(2).uniform(size=rcs.shape).astype(np.float32)
    breaking[::3] = 0.0  # columns without breakers
    motion = motion_of(facets, approaching=0.7, breaking=breaking, speed=-3.0, spread=0.3)
    heard = []
    for count in (1, 2, 2):
        monkeypatch.setattr(machine, "threads", lambda count=count: count)
        heard.append(turn_voltages(facets, rcs, Installation(radar), fired, SEED, 0.01, motion=motion))
    one, two, again = heard
    np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(two, again)
    monkeypatch.setattr(turn, "BATCH_COLUMNS", 7)  # only the order of the sum changes: float32
    other = turn_voltages(facets, rcs, Installation(radar), fired, SEED, 0.01, motion=motion)
    np.testing.assert_allclose(other, one, rtol=0, atol=1e-5 * np.abs(one).max())


# ------------------------------------------------------------------------------------------------- nodes, refusals


def test_nodes_have_room_for_the_fastest() -> None:
    facets, _ = flat_sea(radar_of())

    def doppler(motion: Motion | None, moving: Illumination = facets) -> float:
        return fastest_echo(SpeedBounds.of(moving, motion), K, np.inf, motion)[0]

    assert doppler(None) == 0.0
    assert doppler(motion_of(facets, bragg=0.24)) == pytest.approx(2.0 * 0.24 / WAVELENGTH)
    assert doppler(motion_of(facets, breaking=0.1, speed=-3.0)) == pytest.approx(2.0 * 3.0 / WAVELENGTH)
    assert doppler(motion_of(facets, breaking=0.0, speed=-3.0)) == pytest.approx(2.0 * 0.24 / WAVELENGTH)
    # A spread of speeds is a shorter time: Gaussian Doppler of σ = 2 · 0.5/λ decorrelates as exp(−½ (2πστ)²).
    wide = motion_of(facets, breaking=0.1, speed=3.0, spread=0.5)
    time_constant = fastest_echo(SpeedBounds.of(facets, wide), K, np.inf, wide)[1]
    assert time_constant == pytest.approx(np.sqrt(0.5) / (np.pi * 2.0 * 0.5 / WAVELENGTH))
    # Breakers on water that runs with them are faster than either.
    running = replace(facets, velocity_look=facets.velocity_look - np.float32(1.0))
    assert doppler(motion_of(facets, breaking=0.1, speed=-3.0), running) == pytest.approx(2.0 * 4.0 / WAVELENGTH)


@pytest.mark.parametrize(
    ("others", "words"),
    [
        ({"bragg_speed": np.nan}, "bragg_speed = nan: must be finite"),
        ({"breaker_spread": -1.0}, "breaker_spread = -1: must be finite and at least 0"),
        ({"approaching": np.array([0.5, 1.1])}, "approaching = 0.5 … 1.1: must lie within 0 to 1"),
        ({"breaking": np.array([[0.5], [np.nan]], dtype=np.float32)}, "must lie within 0 to 1"),
        ({"breaker_speed": np.array([0.0, np.inf])}, "breaker_speed: must be finite"),
        ({"breaker_speed": np.zeros(3)}, r"breaker_speed \(3,\): must be \(2,\)"),
    ],
)
def test_motion_is_refused(others: dict, words: str) -> None:
    good = Motion(0.24, np.array([0.5, 1.0]), None, np.zeros(2), 0.3)
    with pytest.raises(ValueError, match=words):
        replace(good, **others)


def test_motion_of_other_facets_is_refused() -> None:
    radar = radar_of()
    facets, rcs = flat_sea(radar)
    fired = pulses(Installation(radar), 0)
    with pytest.raises(ValueError, match="make it from the grid of the same turn"):
        turn_voltages(facets, rcs, Installation(radar), fired, SEED, 0.01, motion=motion_of())
    breaking = np.zeros((rcs.shape[0], 3), dtype=np.float32)
    with pytest.raises(ValueError, match="one share for each facet"):
        turn_voltages(facets, rcs, Installation(radar), fired, SEED, 0.01, motion=motion_of(facets, breaking=breaking))
