"""What is said of a gauge's two records, and of their spectra, is true."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose

from seamap_rt.dataset import build
from seamap_rt.gauges import GaugeSpectra, NoSpectrum, judge, judge_one, sample_times, spectra

# ------------------------------------------------------------------------------------------------------ what is said


def record(wire: Any, turns: int = 120, period: float = 1.0, error: Any = None) -> xr.Dataset:
    """A gauge whose wire is wire(t), and whose radar errs by error (turn,)."""
    time = np.concatenate([sample_times(turn, period, 8.0) for turn in range(turns)])
    seen = period * (np.arange(turns) + 0.25)
    true = wire(seen)
    return build(
        "gauges",
        {
            "east": [1.0], "north": [2.0], "true_height": wire(time)[None], "seen_time": seen[None],
            "height": (true + (0.0 if error is None else error))[None], "height_std": np.full((1, turns), 0.1),
            "quality": np.zeros((1, turns)), "seen_true_height": true[None], "seen_cell_height": 0.9 * true[None],
        },
        {"turn": np.arange(turns), "time": time},
    ).assign_coords(gauge=["made"])  # fmt: skip


def test_figures_are_those_of_the_record() -> None:
    random = np.random.default_rng(3)
    error = random.normal(size=400)
    series = record(lambda t: np.sin(2.0 * np.pi * 0.13 * t), 400, error=0.0 * error)
    true = series["seen_true_height"].values[0]
    found = 0.8 * true + 0.05 + 0.1 * error
    series["height"].values[0] = found
    (entry,) = judge(series)
    assert entry["name"] == "made"
    difference = found - true
    assert_allclose(entry["rms_error_m"], np.sqrt(np.mean(difference**2)), rtol=1e-6)
    assert_allclose(entry["bias_m"], difference.mean(), rtol=1e-5)
    assert_allclose(entry["correlation"], np.corrcoef(true, found)[0, 1], rtol=1e-6)
    assert_allclose(entry["regression_slope"], np.polyfit(true, found, 1)[0], rtol=1e-6)
    assert abs(entry["regression_slope"] - 0.8) < 3.0 * 0.1 / np.sqrt(400 * 0.5)  # three standard errors
    assert_allclose(entry["averaging_rms_m"], 0.1 * np.sqrt(0.5), rtol=0.01)  # whole waves but for a hundredth
    assert_allclose(entry["hs_wire_m"], 4.0 * np.sqrt(0.5), rtol=0.01)
    assert entry["waves"] in (51, 52)  # 0.13 Hz for 400 s
    assert entry["answered"] == 1.0


def test_spectra_hold_the_variance() -> None:
    random = np.random.default_rng(5)
    noise = random.normal(size=4096)
    found = spectra(record(lambda t: np.interp(t, np.arange(4096.0), noise), 4096).isel(gauge=0))
    assert isinstance(found, GaugeSpectra)
    series = np.interp(np.arange(4096) + 0.25, np.arange(4096.0), noise)
    width = found.frequency[1] - found.frequency[0]
    # Two of 256 frequencies are left out; the windows weigh the record unevenly: some per cent.
    assert_allclose(found.radar.sum() * width, series.var(), rtol=0.05)
    assert_allclose(found.radar, found.wire_once_a_turn, rtol=1e-5)  # float32 heights


@pytest.mark.parametrize(("frequency", "seen", "share"), [(0.21, 0.21, 0.0), (0.71, 0.29, 1.0)])
def test_what_is_faster_than_half_the_turn_rate_folds_and_is_said_to(
    frequency: float, seen: float, share: float
) -> None:
    series = record(lambda t: np.sin(2.0 * np.pi * frequency * t))
    found = spectra(series.isel(gauge=0))
    assert isinstance(found, GaugeSpectra)
    assert found.frequency.max() < 0.5
    step = found.frequency[1]
    for density in (found.radar, found.wire_once_a_turn):
        assert abs(found.frequency[np.argmax(density)] - seen) <= step
    assert abs(found.wire_frequency[np.argmax(found.wire)] - frequency) <= step
    (entry,) = judge(series)
    assert_allclose(entry["nyquist_hz"], 0.5)
    assert_allclose(entry["beyond_nyquist_share"], share, atol=1e-3)  # Hann's sidelobes, 31 dB down and falling
    assert "above 0.5 Hz, half the turn rate" in entry["aliasing"]
    assert "; 100 % of the wire's variance" in entry["aliasing"] or share == 0.0


def test_a_slow_wire_shows_no_spectrum() -> None:
    """A wire read less often than four times a turn folds itself, and could not tell what folds down."""
    series = record(lambda t: np.sin(2.0 * np.pi * 0.8 * t))
    slow = series.isel(gauge=0).sel(sample=series["time"] % 0.5 < 1e-6)  # twice a turn
    found = spectra(slow)
    assert isinstance(found, NoSpectrum)
    assert "less than 4 times a turn" in found.reason


def test_the_bar_of_a_spectrum_holds() -> None:
    """Estimates of white noise scatter as χ² of the stated degrees of freedom: variance over mean² = 2/ν."""
    random = np.random.default_rng(11)
    estimates, freedom = [], 0.0
    for _ in range(60):
        noise = random.normal(size=128)
        found = spectra(record(lambda t, n=noise: np.interp(t, 0.25 + np.arange(128), n), 128).isel(gauge=0))
        assert isinstance(found, GaugeSpectra)
        estimates.append(found.radar[2:-1])  # away from the ends, whose bins the record's mean touches
        freedom = found.freedom
    spread = np.var(estimates) / np.mean(estimates) ** 2
    # 60 records of some 12 frequencies, neighbours tied by the window: the ratio is known to about 10 %.
    assert_allclose(spread, 2.0 / freedom, rtol=0.25)


def test_windows_that_overlap_are_worth_what_they_share() -> None:
    """Degrees of freedom of a mean of |X|², Gaussian X: 2 (Σ cᵢᵢ)²/Σ |cᵢⱼ|², c their covariance in white noise."""
    turns = 512
    found = spectra(record(np.sin, turns).isel(gauge=0))
    assert isinstance(found, GaugeSpectra)
    length = round(1.0 / (found.turn_s * found.frequency[0]))
    starts = np.arange(0, turns - length + 1, length // 2)
    windows = np.zeros((starts.size, turns), dtype=complex)
    for window, start in zip(windows, starts, strict=True):
        time = np.arange(length)
        window[start : start + length] = np.sin(np.pi * time / length) ** 2 * np.exp(0.5j * np.pi * time)
    shared = windows @ windows.conj().T
    assert starts.size > 10
    # A sixth of each neighbour is shared, and nothing of others: exact but for rounding.
    expected = 2.0 * np.trace(shared).real ** 2 / np.sum(np.abs(shared) ** 2)
    assert_allclose(found.freedom, expected, rtol=1e-9)


def test_short_records_are_told_apart_from_wrong_ones() -> None:
    (entry,) = judge(record(np.sin, turns=5))
    for name in ("correlation", "rms_error_m", "bias_m", "regression_slope", "hs_wire_m", "hs_true_m"):
        assert np.isnan(entry[name]), name
    assert "5 heights in 5 turns, and 8 are needed" in entry["reason"]
    assert "5 turns are too short a record" in entry["spectrum_reason"]
    assert entry["spectrum"] is None
    (longer,) = judge(record(np.sin, turns=20))
    assert longer["reason"] == ""
    assert_allclose(longer["correlation"], 1.0)
    assert "20 turns are too short" in longer["spectrum_reason"]


@pytest.mark.parametrize(("missing", "told"), [(12, False), (13, True)])
def test_few_holes_are_bridged_and_many_are_said(missing: int, told: bool) -> None:
    series = record(lambda t: np.sin(2.0 * np.pi * 0.1 * t))
    series["height"].values[0, 3 : 3 + 9 * missing : 9] = np.nan
    found = spectra(series.isel(gauge=0))
    assert isinstance(found, GaugeSpectra)
    assert np.isnan(found.radar).all() == told
    assert ("13 of 120 turns have no height" in found.reason) == told
    entry = judge_one(series.isel(gauge=0))
    assert np.isfinite(entry["beyond_nyquist_share"])  # of the wire, which has no holes
    assert np.isfinite(entry["correlation"])


def test_uneven_passes_give_no_spectrum() -> None:
    series = record(np.sin)
    series["seen_time"].values[0, 60:] += 0.3
    found = spectra(series.isel(gauge=0))
    assert isinstance(found, NoSpectrum)
    assert "even times" in found.reason


@pytest.mark.parametrize(("turns", "told"), [(31, False), (32, True)])
def test_a_spectrum_takes_32_turns(turns: int, told: bool) -> None:
    """Two segments of sixteen and one over their middle: some six degrees of freedom."""
    found = spectra(record(np.sin, turns).isel(gauge=0))
    assert isinstance(found, GaugeSpectra) == told


@pytest.mark.parametrize(("uneven", "told"), [(0.09, True), (0.11, False)])
def test_passes_are_even_to_a_tenth_of_a_turn(uneven: float, told: bool) -> None:
    """Steps that differ by a tenth leave times within a 40th of a turn of even ones, and phases at half the turn rate
    within 0.08 rad: 0.2 % of a wave is lost."""
    series = record(lambda t: np.cos(2.0 * np.pi * 0.43 * t), 256)
    jitter = np.random.default_rng(1).uniform(-0.5, 0.5, 256)
    jitter[100:102] = 0.5, -0.5  # the widest step and the narrowest
    jitter[102] = 0.5
    seen = series["seen_time"].values[0] + 0.5 * uneven * jitter
    series["seen_time"].values[0] = seen
    for name in ("height", "seen_true_height"):
        series[name].values[0] = np.cos(2.0 * np.pi * 0.43 * seen)
    found = spectra(series.isel(gauge=0))
    assert isinstance(found, GaugeSpectra) == told
    if isinstance(found, GaugeSpectra):
        near = np.abs(found.frequency - 0.43) < 3.0 * found.frequency[0]
        held = found.radar[near].sum() * found.frequency[0]
        assert held == pytest.approx(0.5, rel=0.02)
