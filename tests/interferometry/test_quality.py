"""Echoes of one's own and flags: skirts are no echo, a calm spot is no shadow, and each flag has its cause."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.dwells import Dwells
from seamap_rt.interferometry.quality import (
    has_echo,
    least_coherence,
    lit_power,
    object_echo,
    own_echo,
    quality_flags,
)
from seamap_rt.interferometry.windows import Covariance
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.settings import RetrievalSettings

RESPONSE = RangeResponse(20e-9, 50e6)
SPACING, BEAM = (1.8, 1.5), 1.8
RANGES = 15.0 + 1.5 * np.arange(257, dtype=np.float64)
PULSES = 50


def radar(noise_power: float = 0.0) -> RadarDescription:
    return RadarDescription(0.03, noise_power, "switched", (0.0, 360.0), 1.0, 5.0, RESPONSE, RANGES)


def coherent(power: NDArray[np.float64], noise_power: float = 0.0) -> Covariance:
    both = power + noise_power
    return Covariance(power.astype(np.complex128), both, both)


@pytest.mark.parametrize(("looks", "tolerance"), [(200, 0.2), (3, 0.5), (1, 0.9)])
@pytest.mark.parametrize("hidden", [0.0, 0.5, 0.9])
def test_the_lit_cells_power_knows_no_shadow(looks: int, tolerance: float, hidden: float) -> None:
    rng = np.random.default_rng(1)
    power = rng.exponential(size=(looks, RANGES.size)) * RANGES**-3.5
    power[rng.random(power.shape) < hidden] *= 1e-4
    lit = lit_power(power, RANGES)[0]
    away = slice(20, -20)  # at the ends fewer gates are pooled
    # Nine hidden cells with a hundredth of the amplitude of a lit one shift the median of amplitudes by an eighth.
    # 21 gates of one look, a tenth of them lit, are two cells: then the level is one of theirs, to a factor or two.
    factor = 10.0 if looks < 3 and hidden > 0.8 else (3.0 if looks == 3 and hidden > 0.8 else 1.0 + tolerance)
    ratio = lit[away] / (1.18 * RANGES[away] ** -3.5)
    assert np.exp(np.abs(np.log(ratio)).mean()) < factor


def test_a_ship_is_no_sea() -> None:
    rng = np.random.default_rng(2)
    power = rng.exponential(size=(200, RANGES.size)) * RANGES**-3.5
    without = lit_power(power, RANGES)
    power[100:103, 120:124] *= 1e4
    # 12 cells of 4200 with 100 times the amplitude hold a quarter of it all: half of what is left above the median
    # lies where 0.64 did, 1.4 times as high in Γ(3/2).
    np.testing.assert_allclose(lit_power(power, RANGES), without, rtol=0.5)


@pytest.mark.parametrize("decibel", [30.0, 40.0, 60.0])
@pytest.mark.parametrize("cells", [1, 40, 200])
def test_a_pier_is_no_sea(decibel: float, cells: int) -> None:
    # 200 of the 4200 cells of a level: by amplitude a pier of 40 dB would outweigh the sea five to one.
    power = np.random.default_rng(2).exponential(size=(200, RANGES.size)) * RANGES**-3.5
    without = lit_power(power, RANGES)
    power[:cells, 120] *= 10.0 ** (decibel / 10.0)
    # At 30 dB 75 of 200 cells fade so far that they count, with 15 times the amplitude: half of 1100 above the median,
    # where the sea has 1300 a unit of power, shift it by 0.4 of 1.18.
    np.testing.assert_allclose(lit_power(power, RANGES), without, rtol=0.5)


@pytest.mark.parametrize("shape", [np.inf, 2.0, 0.5])
def test_a_sea_is_no_object(shape: float) -> None:
    # Speckle of a K-distributed sea, down to the spikiest: there one cell in a million has a hundred times the mean;
    # of 51,400 none, or rarely one with its skirts.
    rng = np.random.default_rng(9)
    texture = 1.0 if np.isinf(shape) else rng.gamma(shape, 1.0 / shape, (200, RANGES.size))
    power = texture * rng.exponential(size=(200, RANGES.size)) * RANGES**-3.5
    assert object_echo(power, lit_power(power, RANGES), RESPONSE, SPACING, BEAM).sum() <= 9


@pytest.mark.parametrize("width", [SPACING[0], 0.45])  # looks as wide as the beam, and a quarter of it
@pytest.mark.parametrize("decibel", [25.0, 40.0, 55.0])
def test_what_an_object_disturbs_is_not_the_seas(decibel: float, width: float) -> None:
    strength, shape = 10.0 ** (decibel / 10.0), skirts(10, 15, width)
    sea = np.random.default_rng(10).gamma(4.0, 0.25, size=(21, 31))
    found = object_echo(sea + strength * shape, np.full((1, 31), 1.18), RESPONSE, (width, SPACING[1]), BEAM)
    disturbed = strength * shape > 0.011 * (sea + strength * shape)
    held = shape >= 1.1e-4 * shape.max()  # fainter skirts are not told
    assert found[disturbed & held].all()
    # Beyond the beam's and the pulse's reach from all that is strong nothing is.
    assert not found[width * np.abs(np.arange(21) - 10) > 4.0 * BEAM].any()
    assert not found[:, np.abs(np.arange(31) - 15) > 7].any()


def test_silence_has_no_level() -> None:
    for power in (np.zeros((4, RANGES.size)), np.full((4, RANGES.size), np.nan), -np.ones((4, RANGES.size))):
        np.testing.assert_array_equal(lit_power(power, RANGES), 0.0)


def skirts(look: int, gate: int, width: float = SPACING[0]) -> NDArray[np.float64]:
    """Power (look, gate) of a reflector in the middle of one cell of 21 × 31, through the beam and the pulse."""
    aside = width * (np.arange(21)[:, None] - look + np.linspace(-0.5, 0.5, 41))
    beam = np.exp(-8.0 * np.log(2.0) * (aside / BEAM) ** 2).mean(axis=1)
    return beam[:, None] * RESPONSE(SPACING[1] * (np.arange(31) - gate)) ** 2


def test_skirts_are_no_echo() -> None:
    own = own_echo(skirts(10, 15), RESPONSE, SPACING, BEAM)
    # What a reflector leaves beyond its own cell, which holds a gate to either side, equals what is predicted.
    expected = np.zeros(own.shape, dtype=bool)
    expected[10, 14:17] = True
    np.testing.assert_array_equal(own & (skirts(10, 15) > 1e-9), expected)


def test_a_deep_shadow_beside_a_bright_crest_is_no_echo() -> None:
    power = np.ones((21, 40))
    power[:, 20:23] = 1e-4
    assert not own_echo(power, RESPONSE, SPACING, BEAM)[:, 21].any()
    power = np.ones((21, 40))
    power[10, 15:25] = 1e-4
    assert not own_echo(power, RESPONSE, SPACING, BEAM)[10, 17:23].any()


def test_speckle_keeps_its_echoes() -> None:
    power = np.random.default_rng(3).exponential(size=(200, 257))
    # A look's skirt is 0.1 of it: of two independent exponentials one is below 0.1 of the greater of two others in
    # 1 − 2/1.1 + 1/1.2 … = 0.15 at worst; the pulse's own skirts, 0.002, add nothing.
    assert own_echo(power, RESPONSE, SPACING, BEAM).mean() > 0.8
    blurred = 0.25 * (power[:-2] + 2.0 * power[1:-1] + power[2:])  # as the beam itself mixes neighbouring looks
    assert own_echo(blurred, RESPONSE, SPACING, BEAM).mean() > 0.97


def test_moved_looks_give_moved_echoes() -> None:
    power = np.random.default_rng(4).exponential(size=(60, 80)) ** 3
    own, moved = (own_echo(each, RESPONSE, SPACING, BEAM) for each in (power, power[7:]))
    np.testing.assert_array_equal(own[12:], moved[5:])


def test_noise_alone_is_no_echo() -> None:
    # The mean of 50 powers of noise strays by 1/√50 = 0.14 of it; 0 dB lies 7 standard deviations up.
    noise = 1e-12
    rng = np.random.default_rng(5)
    power = noise * rng.gamma(PULSES, 1.0 / PULSES, size=(200, 257))
    cells = Covariance(power.astype(np.complex128), power, power)
    assert not has_echo(cells, power - noise, noise, RetrievalSettings()).any()


def test_a_calm_spot_is_an_echo_where_no_noise_is() -> None:
    power = np.random.default_rng(6).gamma(2.0, 0.5, size=(200, 257)) * RANGES**-3.5
    power[50:60, 100:120] *= 10.0**-1.6  # 16 dB calmer; speckle of two samples fades by 14 dB in one cell of 500
    heard = has_echo(coherent(power), power, radar().noise_power, RetrievalSettings())
    assert heard[52:58, 103:117].mean() > 0.99


def test_a_shadowed_far_gate_leans_on_its_neighbours() -> None:
    # Nine cells of ten are hidden: the median over the looks is a hidden cell's.
    rng = np.random.default_rng(7)
    hidden = rng.random((200, 257)) < 0.9
    power = np.where(hidden, 1e-5, 1.0) * rng.gamma(4.0, 0.25, size=hidden.shape) * RANGES**-3.5
    np.testing.assert_array_equal(has_echo(coherent(power), power, radar().noise_power, RetrievalSettings()), ~hidden)


def test_a_dead_receiver_hears_nothing() -> None:
    power = np.ones((4, 257))
    cells = Covariance(np.zeros(power.shape, dtype=np.complex128), power, np.zeros(power.shape))
    assert not has_echo(cells, 0.5 * power, radar().noise_power, RetrievalSettings()).any()


@pytest.mark.parametrize("samples", [2, 5, 20])
def test_least_coherence_is_rarely_reached_by_chance(samples: int) -> None:
    rng = np.random.default_rng(8)
    cells = 200_000
    lower, upper = (rng.normal(size=(2, cells, samples)).view() for _ in range(2))
    a, b = lower[0] + 1j * lower[1], upper[0] + 1j * upper[1]
    sums = [np.sum(x * y.conj(), axis=1) for x, y in ((a, b), (a, a), (b, b))]
    found = np.abs(sums[0]) / np.sqrt(sums[1].real * sums[2].real)
    # 200 of 200,000 expected, ± 14.
    assert abs(np.count_nonzero(found > least_coherence(samples)) - 200) < 70


def test_one_sample_says_nothing() -> None:
    np.testing.assert_array_equal(least_coherence(np.array([0.0, 1.0])), 0.0)
    assert np.all(np.diff(least_coherence(np.arange(2.0, 500.0))) < 0.0)


def test_each_flag_has_its_cause() -> None:
    looks, gates = 4, RANGES.size
    dwells = Dwells(np.repeat(np.arange(looks), PULSES), looks)
    power = np.ones((looks, gates))
    cells = coherent(power)
    cells.cross[1, 10] = 0.01
    heard = np.ones(power.shape, dtype=bool)
    heard[0, 5] = False
    saturated, flag = np.zeros((dwells.look.size, gates), dtype=np.int8), np.zeros(dwells.look.size, dtype=np.int16)
    saturated[2 * PULSES : 2 * PULSES + 2, 30] = 1
    flag[3 * PULSES] = QUALITY_FLAGS["submerged"]
    echoes = xr.Dataset({"saturated": (("pulse", "range"), saturated), "flag": ("pulse", flag)})
    ambiguous, share = np.zeros(power.shape, dtype=bool), np.ones(power.shape)
    ambiguous[1, 40], ambiguous[0, 5], share[1, 50], share[2, 50] = True, True, 0.4, np.nan
    quality = quality_flags(
        echoes, dwells, cells, heard, np.ones(power.shape), np.zeros(power.shape), radar(), ambiguous, share
    )
    expected = np.zeros(power.shape, dtype=np.int16)
    for cell, name in (((0, 5), "no_echo"), ((1, 10), "low_coherence"), ((1, 40), "ambiguous")):
        expected[cell] = QUALITY_FLAGS[name]
    expected[1, 50], expected[2, 30] = QUALITY_FLAGS["partly_shadowed"], QUALITY_FLAGS["saturated"]
    expected[3] = QUALITY_FLAGS["submerged"]
    expected[:, radar().blind] |= QUALITY_FLAGS["blind"]
    np.testing.assert_array_equal(quality, expected)


def test_a_sea_beyond_half_an_ambiguity_is_ambiguous() -> None:
    dwells = Dwells(np.repeat(np.arange(4), PULSES), 4)
    power = np.ones((4, RANGES.size))
    height = np.random.default_rng(9).normal(scale=0.35, size=power.shape)
    given = xr.Dataset(), dwells, coherent(power), np.ones(power.shape, dtype=bool)
    near, far = (quality_flags(*given, np.full(power.shape, g), height, radar()) for g in (0.1, 1.0))
    assert (near & QUALITY_FLAGS["ambiguous"] > 0).all()
    assert not (far & QUALITY_FLAGS["ambiguous"]).any()
