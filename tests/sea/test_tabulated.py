"""A table of E(f, θ) as a sea: its energy, its directions and its tail are those of the table."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.physics.dispersion import group_speed, wavenumber
from seamap_rt.sea.tabulated import TabulatedSpectrum

FREQUENCY: NDArray[np.float64] = 0.04 * 1.1 ** np.arange(28.0)  # log-spaced, as wave models have it
FROM = np.arange(0.0, 360.0, 10.0)
CIRCLE = 2.0 * np.pi * np.arange(36_000) / 36_000.0


def sea(from_deg: float = 300.0, exponent: float = 10.0) -> NDArray[np.float64]:
    """m²/(Hz·degree) of a narrow sea."""
    energy = np.exp(-(((FREQUENCY - 0.1) / 0.03) ** 2))[:, None]
    return energy * np.cos(np.radians(FROM - from_deg) / 2.0) ** (2.0 * exponent) / 90.0


def over_k(table: TabulatedSpectrum, power: float = 0.0) -> float:
    """∫ ω^power S dk, on nodes of its own in f that hold all of the table's kinks."""
    base = np.concatenate(([0.0], table.frequency_hz, table.frequency_hz[-1] * np.geomspace(1.0, 1e4, 2001)[1:]))
    first = 2.0 * table.frequency_hz[0] - table.frequency_hz[1]
    base = np.sort(np.append(base, max(first, 1e-9)))
    nodes, weights = np.polynomial.legendre.leggauss(8)
    half = 0.5 * np.diff(base)[:, None]
    omega = 2.0 * np.pi * (base[:-1, None] + half * (1.0 + nodes))
    k = wavenumber(omega, table.depth)
    step = 2.0 * np.pi * half * weights / group_speed(k, table.depth)  # dk
    return float(np.sum(omega**power * table.radial(k) * step))


def density_at(table: TabulatedSpectrum, frequency: float, from_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """E(f, θ) [m²/(Hz·degree)] as the two functions have it."""
    k = wavenumber(2.0 * np.pi * frequency, table.depth)
    east, north = unit_from_azimuth(from_deg + 180.0)
    per_radian = table.radial(k) * 2.0 * np.pi / group_speed(k, table.depth) * table.spreading(k, east, north)
    return per_radian * np.pi / 180.0


# ----------------------------------------------------------------------------------------------------------- energy


@pytest.mark.parametrize("depth", [5.0, np.inf])
@pytest.mark.parametrize("tail", [None, 0.0, 4.0, 5.0])
def test_the_variance_is_the_tables(depth: float, tail: float | None) -> None:
    table = TabulatedSpectrum(FREQUENCY, FROM, sea(), depth, tail)
    energy = sea().sum(axis=1) * 10.0
    # Linear between the nodes, so the trapezoid is exact; below the first a triangle, one step wide.
    inside = np.trapezoid(energy, FREQUENCY) + 0.5 * energy[0] * (FREQUENCY[1] - FREQUENCY[0])
    beyond = energy[-1] * FREQUENCY[-1] / (tail - 1.0) if tail else 0.0
    np.testing.assert_allclose(table.hs, 4.0 * np.sqrt(inside + beyond), rtol=1e-13)
    np.testing.assert_allclose(over_k(table), inside + beyond, rtol=1e-12)
    assert table.peak_frequency_hz == FREQUENCY[np.argmax(energy)]


def test_the_tail_goes_on_as_a_power() -> None:
    flat = np.full((2, 36), 0.01)  # 3.6 m²/Hz
    table = TabulatedSpectrum(np.array([0.1, 0.2]), FROM, flat)
    # 0.36 between the two, 0.18 in the triangle below, 3.6 · 0.2/4 = 0.18 above.
    np.testing.assert_allclose(table.hs, 4.0 * np.sqrt(0.72), rtol=1e-13)
    np.testing.assert_allclose(density_at(table, 0.4, FROM), 0.01 / 32.0, rtol=1e-12)
    np.testing.assert_allclose(density_at(table, 0.05, FROM), 0.005, rtol=1e-12)
    ended = TabulatedSpectrum(np.array([0.1, 0.2]), FROM, flat, tail_exponent=None)
    np.testing.assert_array_equal(ended.radial(wavenumber(2.0 * np.pi * np.array([0.2001, 1.0, 1e4]), np.inf)), 0.0)
    assert ended.radial(wavenumber(2.0 * np.pi * 0.1999, np.inf)) > 0.0


def test_moments_follow_the_dispersion() -> None:
    for depth in (3.0, np.inf):
        table = TabulatedSpectrum(FREQUENCY, FROM, sea(), depth, None)
        energy = np.concatenate(([0.0], sea().sum(axis=1) * 10.0))
        frequency = np.concatenate(([2.0 * FREQUENCY[0] - FREQUENCY[1]], FREQUENCY))
        # ∫ f² E df of a broken line: Simpson's rule is exact for the cubic in each step.
        middle = 0.5 * (frequency[1:] + frequency[:-1])
        product = frequency**2 * energy
        inner = middle**2 * 0.5 * (energy[1:] + energy[:-1])
        exact = np.sum(np.diff(frequency) * (product[1:] + product[:-1] + 4.0 * inner) / 6.0)
        np.testing.assert_allclose(over_k(table, 2.0), (2.0 * np.pi) ** 2 * exact, rtol=1e-12)


# -------------------------------------------------------------------------------------------------------- directions


@given(st.floats(0.001, 1.0), st.integers(0, 10_000))
def test_spreading_is_a_density_at_every_wavenumber(where: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    direction = (np.arange(0.0, 360.0, 15.0) + 0.5 * random.integers(-10, 11, 24)) % 360.0
    values = random.uniform(0.0, 1.0, (28, 24)) * (random.uniform(size=(28, 24)) > 0.5)
    table = TabulatedSpectrum(FREQUENCY, direction, values)
    k = wavenumber(2.0 * np.pi * 0.8 * where, np.inf)
    spread = table.spreading(k, np.cos(CIRCLE), np.sin(CIRCLE))
    assert np.all(spread >= 0.0)
    # A broken line whose kinks lie on the steps of the sum, multiples of ½° on such of 0.01°: exact.
    np.testing.assert_allclose(spread.sum() * 2.0 * np.pi / CIRCLE.size, 1.0, rtol=1e-12)


def test_interpolation_is_linear_in_frequency_and_direction() -> None:
    random = np.random.default_rng(3)
    values = random.uniform(0.0, 1.0, (28, 36))
    table = TabulatedSpectrum(FREQUENCY, FROM, values, depth=12.0)
    for row in (0, 9, 27):
        np.testing.assert_allclose(density_at(table, FREQUENCY[row], FROM), values[row], rtol=1e-9)
    between = 0.25 * FREQUENCY[9] + 0.75 * FREQUENCY[10]
    expected = 0.25 * values[9] + 0.75 * values[10]
    np.testing.assert_allclose(density_at(table, between, FROM), expected, rtol=1e-9)
    # Across north too: 354° lies 0.4 of the way from 350° to 0°.
    aside = 0.6 * expected + 0.4 * np.roll(expected, -1)
    np.testing.assert_allclose(density_at(table, between, FROM + 4.0), aside, rtol=1e-9)


@pytest.mark.parametrize("from_deg", [0.0, 90.0, 300.0, 359.0])
def test_waves_go_where_they_do_not_come_from(from_deg: float) -> None:
    table = TabulatedSpectrum(FREQUENCY, FROM, sea(from_deg, 20.0))
    spread = table.spreading(wavenumber(2.0 * np.pi * 0.1, np.inf), np.cos(CIRCLE), np.sin(CIRCLE))
    east, north = np.sum(spread * np.cos(CIRCLE)), np.sum(spread * np.sin(CIRCLE))
    away = np.degrees(np.angle((east + 1j * north) / complex(*unit_from_azimuth(from_deg + 180.0))))
    # 36 directions hold the first moment of a cos^40(θ/2) to rounding, and a broken line between them keeps it.
    np.testing.assert_allclose(away, 0.0, atol=1e-10)


def test_turning_the_table_turns_the_sea() -> None:
    values = np.random.default_rng(5).uniform(0.0, 1.0, (28, 36))
    k = wavenumber(2.0 * np.pi * 0.13, np.inf)
    still = TabulatedSpectrum(FREQUENCY, FROM, values)
    for turn in (7.3, 90.0, 200.0):
        turned = TabulatedSpectrum(FREQUENCY, (FROM + turn) % 360.0, values)
        angle = CIRCLE - np.radians(turn)  # clockwise from north is backwards from east
        np.testing.assert_allclose(
            turned.spreading(k, np.cos(angle), np.sin(angle)),
            still.spreading(k, np.cos(CIRCLE), np.sin(CIRCLE)),
            rtol=0.0,
            atol=1e-11,  # 1e-15 rad of 2π, times slopes of 0.3/rad a degree
        )
        np.testing.assert_allclose(turned.hs, still.hs, rtol=1e-14)


def test_one_bin_of_directions_is_a_triangle() -> None:
    values = np.zeros((28, 36))
    values[:, 30] = np.exp(-(((FREQUENCY - 0.1) / 0.03) ** 2))
    table = TabulatedSpectrum(FREQUENCY, FROM, values)
    k = wavenumber(2.0 * np.pi * 0.1, np.inf)
    azimuth = np.array([285.0, 290.0, 295.0, 300.0, 302.5, 310.0, 120.0])
    east, north = unit_from_azimuth(azimuth + 180.0)
    expected = np.array([0.0, 0.0, 0.5, 1.0, 0.75, 0.0, 0.0]) / np.radians(10.0)
    np.testing.assert_allclose(table.spreading(k, east, north), expected, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(over_k(table), (table.hs / 4.0) ** 2, rtol=1e-12)


def test_a_sector_of_directions_ends_at_its_sides() -> None:
    sector = np.array([340.0, 350.0, 0.0, 10.0, 20.0])
    table = TabulatedSpectrum(FREQUENCY, sector, np.ones((28, 5)))
    azimuth = np.array([325.0, 330.0, 335.0, 345.0, 0.0, 25.0, 30.0, 180.0])
    np.testing.assert_allclose(density_at(table, 0.1, azimuth), [0, 0, 0.5, 1, 1, 0.5, 0, 0], atol=1e-12)
    # As the sum over bins has it: five of 10°.
    np.testing.assert_allclose(
        table.radial(wavenumber(0.2 * np.pi, np.inf)) * 2.0 * np.pi,
        50.0 * group_speed(wavenumber(0.2 * np.pi, np.inf)),
        rtol=1e-12,
    )


def test_an_even_circle_where_there_are_no_waves() -> None:
    table = TabulatedSpectrum(FREQUENCY, FROM, sea(), tail_exponent=None)
    np.testing.assert_array_equal(table.spreading(np.array([0.0, 1e-6]), np.array(0.6), np.array(0.8)), 0.5 / np.pi)
    np.testing.assert_array_equal(table.radial(np.array([0.0, 1e-6, 1e9])), 0.0)
    calm = TabulatedSpectrum(FREQUENCY, FROM, np.zeros((28, 36)))
    assert calm.hs == 0.0
    np.testing.assert_array_equal(
        calm.spreading(np.array(0.1), np.array([1.0, 0.0]), np.array([0.0, 1.0])), 0.5 / np.pi
    )


# ------------------------------------------------------------------------------------------------------------ errors


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"frequency_hz": FREQUENCY[::-1]}, "frequency_hz"),
        ({"frequency_hz": FREQUENCY - FREQUENCY[0]}, "frequency_hz"),
        ({"frequency_hz": np.where(FREQUENCY > 0.5, np.inf, FREQUENCY)}, "frequency_hz"),
        ({"from_deg": FROM[:2]}, "from_deg"),
        ({"from_deg": np.append(FROM[:-1], 360.0)}, "from_deg"),
        ({"from_deg": np.where(FROM == 0.0, np.nan, FROM)}, "from_deg"),
        ({"density": sea().T}, "transpose"),
        ({"density": -sea()}, "density"),
        ({"density": np.where(sea() > 0.001, np.nan, sea())}, "density"),
        ({"depth": 0.0}, "depth"),
        ({"tail_exponent": 1.0}, "tail_exponent"),
        ({"tail_exponent": -5.0}, "tail_exponent"),
    ],
)
def test_what_is_no_table_raises(change: dict, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        TabulatedSpectrum(**{"frequency_hz": FREQUENCY, "from_deg": FROM, "density": sea(), **change})
