"""Speckle of a set coherence and number of looks: phases spread as in Lee et al. (1994), coherences as in Touzi et al.
(1999).

Cells of one gate and one look are independent in analytic echoes, so that sampling errors are those of plain counts.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray
from scipy.special import gammaln

from seamap_rt.conventions import wrap_phase
from seamap_rt.interferometry import retrieve
from seamap_rt.radar.waveform import gates
from seamap_rt.settings import RadarSettings, RetrievalSettings
from validation import analytic

Array = NDArray[np.float64]
COHERENCES = (0.5, 0.8, 0.95, 0.99)
LOOKS = (1, 2, 5, 10, 50)  # of 50 pulses a dwell
RADAR = RadarSettings(sector_deg=(0.0, 36.0), range_m=(20.0, 219.5), range_sampling_m=0.5)
# One way: of both ways pulses are compared whose speckle may be another.
ALONE = RetrievalSettings(estimator="single_cell", cell_range_m=0.5, paths="one_way", ground_m=500.0)
SEA = analytic.TiltedSea(0.002, -0.001)
GROUPS = np.array_split(np.arange(gates(RADAR).size), 4)


def per_group(values: tuple[float, ...]) -> Array:
    return np.repeat(values, [group.size for group in GROUPS])


def polar(echoes: xr.Dataset) -> xr.Dataset:
    return retrieve(echoes, ALONE)["polar"].to_dataset().isel(turn=0)


@cache
def true_phase() -> Array:
    return polar(analytic.echoes(SEA, RADAR))["phase"].values.astype(np.float64)


@cache
def speckled(looks: int) -> list[tuple[Array, Array]]:
    """Of each coherence the phase errors [rad] and sample coherences of 20 looks by 100 gates."""
    maps = polar(analytic.echoes(SEA, RADAR, coherence=per_group(COHERENCES), looks=looks, seed=looks))
    error, sample = wrap_phase(maps["phase"].values - true_phase()), maps["coherence"].values
    return [(error[:, group].ravel(), sample[:, group].ravel().astype(np.float64)) for group in GROUPS]


def coherence_touzi99(coherence: float, looks: float) -> float:
    """Mean sample coherence of N looks: Γ(N) Γ(3/2)/Γ(N + ½) ₃F₂(3/2, N, N; N + ½, 1; γ²) (1 − γ²)^N."""
    k = np.arange(20_000)  # beyond, at γ = 0.99 and N = 50, terms are below 1e-80

    def log_rising(a: float) -> Array:
        return gammaln(a + k) - gammaln(a)

    terms = log_rising(1.5) + 2.0 * log_rising(looks) - log_rising(looks + 0.5) - 2.0 * gammaln(k + 1.0)
    scale = gammaln(looks) + gammaln(1.5) - gammaln(looks + 0.5) + looks * np.log1p(-(coherence**2))
    return float(np.sum(np.exp(terms + scale) * coherence ** (2.0 * k)))


@pytest.mark.parametrize("looks", LOOKS)
@pytest.mark.parametrize("group", range(4))
def test_phases_spread_as_lee94(looks: int, group: int) -> None:
    error, _ = speckled(looks)[group]
    coherence, count = COHERENCES[group], error.size
    variance = np.mean(error**2)
    # Four standard errors of a mean square, by the sample's own fourth moment.
    tolerance = 4.0 * np.sqrt((np.mean(error**4) - variance**2) / count)
    assert abs(variance - analytic.phase_std_lee94(coherence, looks) ** 2) < tolerance
    assert abs(error.mean()) < 4.0 * np.sqrt(variance / count)
    # Kolmogorov: D √n passes 1.95 once in a thousand; of these 20 draws the greatest is 1.23.
    phase = np.linspace(-np.pi, np.pi, 20_001)
    density = analytic.phase_pdf_lee94(phase, coherence, looks)
    cumulative = np.concatenate(([0.0], np.cumsum(0.5 * (density[1:] + density[:-1])) * (phase[1] - phase[0])))
    assert cumulative[-1] == pytest.approx(1.0, abs=1e-6)
    assert distance_of(error, phase, cumulative) < 1.95


def distance_of(sample: Array, grid: Array, cumulative: Array) -> float:
    """√n times the largest distance of a sample's distribution from a cumulative one."""
    expected, count = np.interp(np.sort(sample), grid, cumulative), sample.size
    step = np.arange(count + 1) / count
    return float(np.sqrt(count) * max(np.max(step[1:] - expected), np.max(expected - step[:-1])))


@pytest.mark.parametrize("looks", LOOKS)
@pytest.mark.parametrize("group", range(4))
def test_sample_coherences_are_those_of_touzi99(looks: int, group: int) -> None:
    _, sample = speckled(looks)[group]
    expected = coherence_touzi99(COHERENCES[group], looks) if looks > 1 else 1.0  # a single look always agrees
    # Four standard errors of a mean, and the rounding of complex64 and float32.
    assert abs(sample.mean() - expected) < 4.0 * sample.std() / np.sqrt(sample.size) + 1e-6


def test_noise_lowers_the_coherence() -> None:
    """By 1/(1 + 1/SNR), when speckle is as new in each pulse as noise is: 50 looks again."""
    snr_db = (-5.0, 0.0, 5.0, 15.0)
    maps = polar(analytic.echoes(SEA, RADAR, coherence=0.9, looks=50, snr_db=per_group(snr_db)))
    for group, level in zip(GROUPS, snr_db, strict=True):
        ratio = 10.0 ** (level / 10.0)
        error = wrap_phase(maps["phase"].values - true_phase())[:, group].ravel()
        sample = maps["coherence"].values[:, group].ravel().astype(np.float64)
        left = 0.9 / (1.0 + 1.0 / ratio)
        assert abs(sample.mean() - coherence_touzi99(left, 50)) < 4.0 * sample.std() / np.sqrt(sample.size)
        variance = np.mean(error**2)
        tolerance = 4.0 * np.sqrt((np.mean(error**4) - variance**2) / error.size)
        assert abs(variance - analytic.phase_std_lee94(left, 50) ** 2) < tolerance
        if level >= 0.0:  # below, some cells have less power than noise, and no ratio
            # Each pulse scatters by all its power, 1/√50 of that in a cell.
            heard = 10.0 ** (maps["snr_db"].values[:, group].astype(np.float64) / 10.0)
            assert abs(heard.mean() - ratio) < 4.0 * (1.0 + ratio) / np.sqrt(50 * heard.size)


def test_noise_alone_has_any_phase() -> None:
    maps = polar(analytic.echoes(SEA, RADAR, snr_db=-200.0))
    phase = maps["phase"].values.astype(np.float64)
    circle = np.linspace(-np.pi, np.pi, 3)
    assert distance_of(phase.ravel(), circle, np.array([0.0, 0.5, 1.0])) < 1.95
    sample = maps["coherence"].values.astype(np.float64)
    assert abs(sample.mean() - coherence_touzi99(0.0, 50)) < 4.0 * sample.std() / np.sqrt(sample.size)
    # Noise passes for an echo of 0 dB where its mean over 50 pulses and 2 receivers is twice itself: 10 sigma.
    assert np.isnan(maps["height"].values).all()


@pytest.mark.parametrize(
    "mode", [("switched", "single_pulse"), ("single", "alternating_pulse"), ("switched", "alternating_pulse")]
)
def test_every_mode_spreads_alike(mode: tuple[str, str]) -> None:
    """One look that lasts all a dwell, heard by either receiver; of 25 pairs to either side one alone reaches into
    the dwell before, where speckle is another: a fiftieth of the power, which spreads as noise of 17 dB would."""
    radar = RADAR.model_copy(update={"transmit": mode[0], "interferogram": mode[1]})
    exact, drawn = (polar(analytic.echoes(SEA, radar, coherence=c, looks=1)) for c in (None, 0.9))
    inner = slice(1, -1)
    error = wrap_phase(drawn["phase"].values - exact["phase"].values.astype(np.float64))[inner].ravel()
    low = 0.0 if mode[1] == "single_pulse" else 0.02
    variance = np.mean(error**2)
    tolerance = 4.0 * np.sqrt((np.mean(error**4) - variance**2) / error.size)
    asked = [float(analytic.phase_std_lee94(0.9 * (1.0 - share), 1)) ** 2 for share in (0.0, low)]
    assert asked[0] - tolerance < variance < asked[1] + tolerance
