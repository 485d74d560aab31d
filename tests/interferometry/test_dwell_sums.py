"""The one pass over the voltages against sums written out, and coherent integration against its law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import gamma

from seamap_rt.compute import machine
from seamap_rt.errors import SchemaError
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.dwell_sums import DwellSums, PulseComparison
from seamap_rt.interferometry.dwells import Dwells
from seamap_rt.interferometry.windows import without_noise
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.settings import RetrievalSettings

GATES, INTERVAL = 19, 1e-4
RADAR = RadarDescription(
    wavelength=0.03,
    noise_power=0.0,
    transmit="switched",
    sector=(0.0, 360.0),
    period=1.0,
    height=5.0,
    response=RangeResponse(20e-9, 50e6),
    ranges=np.linspace(15.0, 42.0, GATES),
)
ALTERNATING = replace(RADAR, interferogram="alternating_pulse")


def noise(rng: np.random.Generator, *shape: int) -> NDArray[np.complex64]:
    draws = np.sqrt(0.5) * (rng.normal(size=shape) + 1j * rng.normal(size=shape))
    return draws.astype(np.complex64)


def sums(
    voltage: NDArray[np.complex64],
    dwells: Dwells,
    radar: RadarDescription = RADAR,
    number: NDArray[np.intp] | None = None,
    levels: dict[int, NDArray[np.float64]] | None = None,
    **chosen: object,
) -> DwellSums:
    """Of pulses `number` (all, unless some are missing) of transmitters that alternate."""
    number = np.arange(len(voltage)) if number is None else number
    settings = RetrievalSettings.model_validate(chosen)
    transmitter = (number % 2 if radar.transmit == "switched" else 0 * number).astype(np.int8)
    time = np.asarray(number * INTERVAL, dtype=np.float64)
    paired = PulseComparison.of(voltage, transmitter, time, (0, 1), radar, settings)
    return DwellSums.of(voltage, transmitter, time, paired, dwells, (0, 1), radar, settings, levels)


def written_out(
    voltage: NDArray[np.complex64],
    dwells: Dwells,
    number: NDArray[np.intp],
    wanted: list[tuple[int, int, int, int | None]],
    level: NDArray[np.float64] | None = None,
) -> NDArray[np.complex128]:
    """⟨V(n, receiver) V(n + lag, other)*⟩ (look, gate), one product after another, over all of `wanted` (lag, receiver,
    other, transmitter of pulse n or None)."""
    where = {int(each): row for row, each in enumerate(number)}
    total, count = np.zeros((dwells.looks, GATES), dtype=complex), np.zeros((dwells.looks, GATES))
    looks = np.broadcast_to(dwells.look.reshape(len(number), -1), (len(number), GATES))
    for lag, receiver, other, transmitter in wanted:
        for row, each in enumerate(number):
            partner = where.get(int(each) + lag)
            if partner is None or transmitter not in (None, int(each) % 2):
                continue
            product = voltage[row, receiver].astype(complex) * voltage[partner, other].astype(complex).conj()
            if level is not None:
                product = product * np.exp(-0.5j * (level[row] + level[partner]))
            for gate in np.flatnonzero(np.isfinite(product) & (looks[row] >= 0)):
                total[looks[row, gate], gate] += product[gate]
                count[looks[row, gate], gate] += 1
    with np.errstate(invalid="ignore"):
        return np.asarray(total / np.where(count > 0, count, np.nan), dtype=np.complex128)


@pytest.mark.parametrize("leaning", [False, True])
@pytest.mark.parametrize("levelled", [False, True])
@pytest.mark.parametrize("gaps", [0.0, 1e-3, 0.1])
def test_every_sum_is_what_it_says_it_is(leaning: bool, levelled: bool, gaps: float) -> None:
    # Pulses missing, voltages NaN nowhere, here and there, and often, pulses of no look, a look without pulses, blocks
    # of 64 crossed.
    rng = np.random.default_rng(1)
    number = np.delete(np.arange(150), [3, 4, 50, 51, 52, 97])
    voltage = noise(rng, number.size, 2, GATES)
    voltage[rng.random(voltage.shape) < gaps] = np.nan
    look = np.minimum(number // 30, 4)[:, None] + (np.arange(GATES) > 3) * (number % 30 > 20)[:, None]
    look[:5] = -1
    look = np.where(look == 2, -1, look)
    dwells = Dwells(look if leaning else look[:, 0], 6)
    levels = {p: rng.uniform(-50.0, 50.0, (number.size, GATES)) for p in (1, 2)} if levelled else None
    found = sums(voltage, dwells, number=number, levels=levels)
    assert found.one is not None
    assert found.two is not None

    one, two = (levels or {}).get(1), (levels or {}).get(2)
    asked = written_out(voltage, dwells, number, [(0, 0, 1, None)], one)
    # Products of float32 are exact to 1e-7 each, and turns to 1e-7 of a turn of a radian or so; sums are float64.
    np.testing.assert_allclose(found.one.cross, asked, rtol=0.0, atol=1e-6)
    forward = written_out(voltage, dwells, number, [(1, 0, 1, 0)], two)
    backward = written_out(voltage, dwells, number, [(-1, 0, 1, 0)], two)
    np.testing.assert_allclose(found.two.cross, 0.5 * (forward + backward), rtol=0.0, atol=1e-6)
    for lag in found.lags:
        apart = round(lag.seconds / INTERVAL)
        asked = written_out(voltage, dwells, number, [(apart, r, r, None) for r in (0, 1)])
        np.testing.assert_allclose(lag.products.cross, asked.conj(), rtol=0.0, atol=1e-6)
        assert apart % 2 == 0  # the same transmitter's
    both = np.where(np.isfinite(voltage).all(axis=1, keepdims=True), voltage, np.nan)  # pulses that are in products
    for receiver, power in enumerate((found.one.lower, found.one.upper)):
        asked = written_out(both, dwells, number, [(0, receiver, receiver, None)]).real
        np.testing.assert_allclose(power, asked, rtol=1e-6)


def test_receivers_that_alternate_give_both_ways_alone() -> None:
    # The very same voltages, heard in turn: what was p = 2 of all pulses is now all there is, to the last bit.
    voltage = noise(np.random.default_rng(2), 200, 2, GATES)
    dwells = Dwells(np.arange(200) // 50, 4)
    whole = sums(voltage, dwells)
    voltage[0::2, 1] = voltage[1::2, 0] = np.nan
    half = sums(voltage, dwells, ALTERNATING)
    assert half.one is None
    assert half.two is not None
    assert whole.two is not None
    np.testing.assert_array_equal(half.two.cross, whole.two.cross)
    single = sums(voltage, dwells, replace(ALTERNATING, transmit="single"))
    assert single.two is None
    assert single.one is not None  # the same pulses, but one antenna sent them all
    np.testing.assert_array_equal(single.one.cross, whole.two.cross)
    assert sums(voltage, dwells, replace(RADAR, transmit="single")).two is None


def test_one_way_alone_on_request_and_pairs_of_one_direction() -> None:
    voltage = noise(np.random.default_rng(3), 200, 2, GATES)
    dwells, number = Dwells(np.arange(200) // 50, 4), np.arange(200)
    assert sums(voltage, dwells, paths="one_way").two is None
    for which, lag in (("forward", 1), ("backward", -1)):
        two = sums(voltage, dwells, pulse_pairs=which).two
        assert two is not None
        asked = written_out(voltage, dwells, number, [(lag, 0, 1, 0)])
        np.testing.assert_allclose(two.cross, asked, rtol=0.0, atol=1e-6)


def test_odd_echoes_have_sums() -> None:
    dwells = Dwells(np.zeros(1, dtype=np.intp), 2)
    single = sums(noise(np.random.default_rng(4), 1, 2, GATES), dwells)
    assert single.two is None
    assert single.lags == ()
    assert single.one is not None
    assert single.one.has_value[0].all()
    assert not single.one.has_value[1].any()
    dead = noise(np.random.default_rng(5), 20, 2, GATES)
    dead[:, 1] = np.nan
    quiet = sums(dead, Dwells(np.zeros(20, dtype=np.intp), 1))
    assert quiet.one is not None
    assert not quiet.one.has_value.any()
    with pytest.raises(SchemaError, match="both receivers hold"):
        sums(noise(np.random.default_rng(6), 20, 2, GATES), Dwells(np.zeros(20, dtype=np.intp), 1), ALTERNATING)


@pytest.mark.parametrize(("coherent", "pulses"), [(0.0, 1), (8e-4, 5), (1.6e-3, 9)])
def test_coherent_integration_leaves_its_share_of_the_noises_beat(coherent: float, pulses: int) -> None:
    # A steady echo that recedes, 6 dB below the noise of a pulse: the phase's variance is (2/S + 1/(M S²))/2N. Cells
    # number 6000, so that the variance found is good to √(2/6000) = 2 %; the formula leaves out the fourth order of
    # the noise (its phase, of N = 200 pulses, is small) and the dwell's ends, where M is less: 4 %. 4 σ of the first
    # and the latter make 12 %. Without the turn by the velocity the echo would be lost.
    rng, dwell, looks, snr = np.random.default_rng(7), 200, 6000 // GATES, 0.25
    count = dwell * looks
    velocity = 3.0 * np.sin(2.0 * np.pi * np.arange(count) / (60 * dwell))  # m/s, as of waves
    echo = np.sqrt(snr) * np.exp(-4j * np.pi / RADAR.wavelength * np.cumsum(velocity) * INTERVAL)
    voltage = (echo[:, None, None] + noise(rng, count, 2, GATES)).astype(np.complex64)
    found = sums(voltage, Dwells(np.arange(count) // dwell, looks), coherent_s=coherent, paths="one_way")
    assert found.one is not None
    assert found.noise_square[1] == pytest.approx(1.0 / pulses)
    variance = np.mean(np.angle(found.one.cross) ** 2)
    assert variance == pytest.approx((2.0 / snr + found.noise_square[1] / snr**2) / (2.0 * dwell), rel=0.12)


def test_coherent_integration_turns_no_phase() -> None:
    # An echo without noise, of both ways, receding at up to 3 m/s: however wrong the velocity, which is taken over
    # neighbours that have others, lags of both signs leave what lies between the receivers. float32 holds it to 1e-7.
    rng, count = np.random.default_rng(8), 400
    velocity = np.linspace(-3.0, 3.0, GATES) + rng.uniform(-0.2, 0.2, GATES)
    time = np.arange(count) * INTERVAL
    echo = np.exp(-1j * 4.0 * np.pi / RADAR.wavelength * velocity * time[:, None])
    voltage = np.stack((echo, echo * np.exp(-0.7j)), axis=1).astype(np.complex64)
    found = sums(voltage, Dwells(np.arange(count) // 50, 8), coherent_s=2e-3)
    assert found.one is not None
    assert found.two is not None
    for covariance in (found.one, found.two):
        np.testing.assert_allclose(np.angle(covariance.cross[1:-1]), 0.7, rtol=0.0, atol=1e-6)


def test_the_coherence_without_noise_is_the_echos() -> None:
    # 500 looks of an echo of coherence 0.7, 3 dB above the noise: of 2000 cells its mean is good to 0.03/√2000 = 7e-4,
    # its bias at so many looks (1 − γ²)²/(4Nγ) is 2e-4, that of powers in a denominator 1e-3.
    rng, pulses, cells, noise_power = np.random.default_rng(9), 500, 2000, 0.5
    common, own = noise(rng, pulses, 1, cells), noise(rng, pulses, 2, cells)
    voltage = np.sqrt(0.7) * common + np.sqrt(0.3) * own + np.sqrt(noise_power) * noise(rng, pulses, 2, cells)
    one = sums(voltage.astype(np.complex64), Dwells(np.zeros(pulses, dtype=np.intp), 1), paths="one_way").one
    assert one is not None
    assert without_noise(one, noise_power).coherence.mean() == pytest.approx(0.7, abs=4e-3)
    assert one.coherence.mean() == pytest.approx(0.7 / 1.5, abs=4e-3)
    assert np.isnan(without_noise(one, 10.0).coherence).all()  # nothing is heard


@pytest.mark.parametrize("pulses", [1, 4, 16])
def test_few_looks_seem_coherent(pulses: int) -> None:
    # Voltages that have nothing in common: 4000 cells know the mean to less than 0.5/√4000 = 0.8 %; 3 σ.
    voltage = noise(np.random.default_rng(10), pulses, 2, 4000)
    one = sums(voltage, Dwells(np.zeros(pulses, dtype=np.intp), 1), paths="one_way").one
    assert one is not None
    expected = 0.5 * np.sqrt(np.pi) * gamma(pulses) / gamma(pulses + 0.5)
    assert without_noise(one, 0.0).coherence.mean() == pytest.approx(expected, abs=0.024)


def test_threads_change_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    voltage = noise(np.random.default_rng(11), 300, 2, GATES)
    dwells, found = Dwells(np.arange(300) // 50, 6), []
    for threads in (1, 2, 3, 16):
        monkeypatch.setattr(machine, "threads", lambda number=threads: number)
        found.append(sums(voltage, dwells))
    for other in found[1:]:
        assert other.one is not None
        assert found[0].one is not None
        np.testing.assert_array_equal(other.one.cross, found[0].one.cross)
        np.testing.assert_array_equal(other.lags[0].products.cross, found[0].lags[0].products.cross)
