"""Our spectra, spreading and tables against those of the library wavespectra, which was written by others.

Both are given the same thing: where a definition differs, the comment says how, and the comparison is made where it
does not.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.constants import g as STANDARD_GRAVITY  # 9.80665, wavespectra's

from seamap_rt.conventions import GRAVITY
from seamap_rt.io.spectrumfile import read_directional_spectrum
from seamap_rt.sea import spectra
from seamap_rt.sea.spreading import cos2s
from seamap_rt.sea.tabulated import TabulatedSpectrum

FREQUENCY = np.arange(0.02, 4.0, 0.0005)  # Hz, far and fine enough that both integrate to the same height
OMEGA = 2.0 * np.pi * FREQUENCY
TP = 8.0


def library():
    with warnings.catch_warnings():  # of readers that want packages which are not here
        warnings.filterwarnings("ignore", message="Cannot import function")
        return pytest.importorskip("wavespectra.construct")


def per_hertz(spectrum: NDArray[np.float64]) -> NDArray[np.float64]:
    return 2.0 * np.pi * spectrum  # S(ω) dω = E(f) df


@pytest.mark.parametrize("gamma", [1.0, 3.3, 7.0])
def test_jonswap_of_a_height_and_period(gamma: float) -> None:
    theirs = library().frequency.jonswap(FREQUENCY, fp=1.0 / TP, gamma=gamma, hs=2.0).to_numpy()
    ours = per_hertz(spectra.jonswap(OMEGA, 2.0, TP, gamma))
    seen = ours > 1e-12
    # The shapes are the same to rounding. The heights: theirs counts its own frequencies, a sum of rectangles and a
    # tail of f^−5, ours all of them; on this grid that is a difference of 3e-10.
    ratio = theirs[seen] / ours[seen]
    np.testing.assert_allclose(ratio / ratio[0], 1.0, rtol=1e-11)
    np.testing.assert_allclose(ratio[0], 1.0, rtol=1e-9)


def test_jonswap_of_wind_and_fetch() -> None:
    wind, fetch = 12.0, 80e3
    relative = GRAVITY * fetch / wind**2
    level, peak = 0.076 * relative**-0.22, 3.5 * relative**-0.33 * GRAVITY / wind
    theirs = library().frequency.jonswap(FREQUENCY, fp=peak, alpha=level).to_numpy()
    ours = per_hertz(spectra.jonswap_fetch(OMEGA, wind, fetch))
    # The same α g² ω⁻⁵, with another g.
    np.testing.assert_allclose(theirs * (GRAVITY / STANDARD_GRAVITY) ** 2, ours, rtol=1e-11, atol=1e-200)


def test_pierson_moskowitz_of_a_wind() -> None:
    wind = 10.0
    peak = (0.8 * 0.74) ** 0.25 * GRAVITY / (1.026 * wind) / (2.0 * np.pi)  # exp(−β x⁴) peaks where 1.25 (fp/f)⁴ = β x⁴
    theirs = library().frequency.pierson_moskowitz(FREQUENCY, fp=peak, alpha=8.1e-3).to_numpy()
    ours = per_hertz(spectra.pierson_moskowitz(OMEGA, wind_speed=wind))
    np.testing.assert_allclose(theirs * (GRAVITY / STANDARD_GRAVITY) ** 2, ours, rtol=1e-11, atol=1e-200)


def test_pierson_moskowitz_of_a_height_and_period() -> None:
    theirs = library().frequency.pierson_moskowitz(FREQUENCY, fp=1.0 / TP, hs=2.0).to_numpy()
    np.testing.assert_allclose(theirs, per_hertz(spectra.pierson_moskowitz_scaled(OMEGA, 2.0, TP)), rtol=1e-9)


@pytest.mark.parametrize("depth", [8.0, 20.0, 60.0])
def test_tma(depth: float) -> None:
    waves = FREQUENCY > 0.3 / TP  # below, nothing is left to divide by
    deep = library().frequency.jonswap(FREQUENCY, fp=1.0 / TP).to_numpy()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "overflow encountered in sinh", RuntimeWarning)  # where Φ is 1
        theirs = library().frequency.tma(FREQUENCY, fp=1.0 / TP, dep=depth).to_numpy()
        scaled = library().frequency.tma(FREQUENCY, fp=1.0 / TP, dep=depth, hs=2.0).to_numpy()
    # Their k is a rational approximation, right to 0.1 %; Φ follows it less than that.
    np.testing.assert_allclose((theirs[waves] / deep[waves]), spectra.tma_depth_factor(OMEGA[waves], depth), rtol=1e-3)
    # The height that is asked for they give to the product, and we to its parent in deep water: so ask for the parent
    # whose product has it.
    product = float(np.trapezoid(spectra.tma(OMEGA, 1.0, TP, 3.3, depth), OMEGA))
    parent = 2.0 / (4.0 * np.sqrt(product))
    ours = per_hertz(spectra.tma(OMEGA, parent, TP, 3.3, depth))
    np.testing.assert_allclose(scaled, ours, rtol=1e-3, atol=1e-200)


@pytest.mark.parametrize("spread_deg", [12.0, 25.0, 60.0])
def test_cartwright_is_cos2s(spread_deg: float) -> None:
    direction = np.arange(0.0, 360.0, 1.0)
    theirs = library().direction.cartwright(direction, dm=300.0, dspr=spread_deg).to_numpy()  # 1/degree
    # Their s follows from the spread by σ² = 2/(s + 1), and their norm is a sum over the directions, which for 360 of
    # them is the integral to rounding, but for the kink at 180° that a power of 0.8 has: 6e-8.
    exponent = 2.0 / np.radians(spread_deg) ** 2 - 1.0
    ours = cos2s(np.radians(direction - 300.0), exponent) * np.pi / 180.0
    np.testing.assert_allclose(theirs, ours, rtol=2e-7, atol=1e-15)


def test_a_sea_of_theirs_through_a_file(tmp_path: Path) -> None:
    frequency, direction = np.arange(0.03, 0.6, 0.005), np.arange(0.0, 360.0, 5.0)
    partition = library().construct_partition(
        freq_kwargs={"freq": frequency, "fp": 1.0 / TP, "hs": 2.5},
        dir_kwargs={"dir": direction, "dm": 285.0, "dspr": 25.0},
    )
    theirs = partition.to_dataset(name="efth")
    theirs.to_netcdf(tmp_path / "theirs.nc", engine="h5netcdf")
    table = read_directional_spectrum(tmp_path / "theirs.nc")
    ours = TabulatedSpectrum(table.frequency_hz, table.from_deg, table.density)
    # They too go on as f^−5. Their rectangles and our trapezoids differ by half of the last one, 1e-5 of the variance.
    np.testing.assert_allclose(ours.hs, float(theirs.spec.hs()), rtol=2e-4)
    np.testing.assert_allclose(ours.peak_frequency_hz, float(theirs.spec.fp(smooth=False)), rtol=1e-12)
    k = np.array(0.06)
    circle = np.radians(np.arange(0.0, 360.0, 0.1))
    going = np.sum(ours.spreading(k, np.cos(circle), np.sin(circle)) * np.exp(1j * circle))
    coming_from = (270.0 - np.degrees(np.angle(going))) % 360.0
    np.testing.assert_allclose(coming_from, float(theirs.spec.dm()), atol=1e-3)
    np.testing.assert_allclose(coming_from, 285.0, atol=1e-3)
