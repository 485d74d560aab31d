"""Echoes that no radar should give: the right answer, NaN with a flag, or a refusal in one line; never a warning."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest
import xarray as xr
from rolling_echoes import Boat, ideal_sea
from scipy.special import gammaincc

from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.errors import SchemaError
from seamap_rt.interferometry import retrieve
from seamap_rt.settings import RetrievalSettings

ESTIMATORS = ("adaptive", "single_cell")
MODES = (("switched", "single_pulse"), ("switched", "alternating_pulse"), ("single", "alternating_pulse"))
PULSES = 200  # of the sector of 36°, 10 a look

# Voltages are complex64, whose phases are good to 6e-8 rad; the least height per phase is 0.5 m/rad, and a mean over
# other pulses rounds otherwise.
ROUNDING = 1e-6  # m
# The window of the adaptive estimator is what the echoes themselves make it: other pulses, a slightly other window.
RESAMPLED = {"adaptive": 1e-4, "single_cell": ROUNDING}  # m

each_estimator = pytest.mark.parametrize("estimator", ESTIMATORS)
each_mode = pytest.mark.parametrize("mode", MODES, ids="-".join)


@cache
def calm(mode: tuple[str, str] = MODES[0]) -> xr.Dataset:
    return Boat(mode=mode).echoes(ideal_sea)


def maps(echoes: xr.Dataset, estimator: str, **settings: Any) -> xr.Dataset:
    """The polar map of the first turn, held to what every map must keep."""
    given = RetrievalSettings.model_validate({"estimator": estimator, "ground_m": 20.0, **settings})
    found = retrieve(echoes, given)["polar"].to_dataset().isel(turn=0)
    unknown = ~np.isfinite(found["height"].values)
    assert (found["quality"].values[unknown] != 0).all()
    assert np.isfinite(found["height_std"].values[~unknown]).all()
    assert not any(np.isinf(field.values).any() for field in found.data_vars.values())
    assert np.isfinite(found["time"].values).all()
    return found


@cache
def unchanged(estimator: str, mode: tuple[str, str] = MODES[0]) -> xr.Dataset:
    return maps(calm(mode), estimator)


def with_voltage(change: Callable[[np.ndarray], object], mode: tuple[str, str] = MODES[0], **attrs: Any) -> xr.Dataset:
    echoes = calm(mode).copy(deep=True)
    change(echoes["voltage"].values)
    return echoes.assign_attrs(attrs)


def with_values(name: str, rows: Any, value: Any) -> xr.Dataset:
    echoes = calm()
    values = echoes[name].values.copy()
    values[rows] = value
    variable = (echoes[name].dims, values)
    return echoes.assign_coords({name: variable}) if name in echoes.coords else echoes.assign({name: variable})


def refusal(echoes: xr.Dataset) -> str:
    with pytest.raises(SchemaError) as caught:
        retrieve(echoes)
    line = str(caught.value)
    assert "\n" not in line
    return line


def assert_alike(found: xr.Dataset, reference: xr.Dataset, tolerance: float = ROUNDING) -> None:
    np.testing.assert_allclose(found["height"].values, reference["height"].values, rtol=0.0, atol=tolerance)


def assert_nothing_known(found: xr.Dataset, flag: str) -> None:
    assert np.isnan(found["height"].values).all()
    assert (found["quality"].values & QUALITY_FLAGS[flag] != 0).all()


def setting(rows: Any, value: Any) -> Callable[[np.ndarray], object]:
    return lambda voltage: voltage.__setitem__(rows, value)


# ------------------------------------------------------------------------------------------------ nothing to be known


@each_estimator
def test_without_a_baseline_every_height_is_ambiguous(estimator: str) -> None:
    echoes = Boat(offsets=((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))).echoes(ideal_sea)
    assert_nothing_known(maps(echoes, estimator, paths="one_way"), "ambiguous")


DEAD = {"lower": slice(0, 1), "upper": slice(1, 2), "both": slice(0, 2)}


@each_estimator
@pytest.mark.parametrize(
    ("receivers", "value", "mode"),
    [(*dead, mode) for dead, mode in zip(product(DEAD, (0.0, np.nan)), 2 * MODES, strict=True)],
)
def test_a_dead_receiver_leaves_no_echo(estimator: str, receivers: str, value: float, mode: tuple[str, str]) -> None:
    for noise_power in (0.0, 0.01):
        change = setting((slice(None), DEAD[receivers]), value)
        echoes = with_voltage(change, mode, noise_power_w=noise_power)
        if mode[1] == "alternating_pulse":  # what is not sampled stays so
            echoes["voltage"] = echoes["voltage"].where(np.isfinite(calm(mode)["voltage"]))
        assert_nothing_known(maps(echoes, estimator), "no_echo")


@pytest.mark.parametrize("least_db", [-2.0, 0.0, 1.0])
def test_noise_alone_is_taken_for_an_echo_as_often_as_its_power_allows(least_db: float) -> None:
    """The mean power of n pulses of two receivers is a gamma variable of shape 2n; min_snr_db asks for 1 + SNR."""
    pulses, gates = 4, 70
    echoes = noise(noise_power=1.0)
    settings = {"cell_range_m": 1.5, "cell_azimuth_deg": 0.18 * pulses, "min_snr_db": least_db}
    found = maps(echoes, "single_cell", **settings)
    cells = PULSES // pulses * gates
    expected = gammaincc(2 * pulses, 2 * pulses * (1.0 + 10.0 ** (0.1 * least_db)))
    share = np.isfinite(found["height"].values).mean()
    # Cells are independent: three and a half standard deviations of their number.
    assert abs(share - expected) < 3.5 * np.sqrt(expected * (1.0 - expected) / cells)


@each_estimator
def test_noise_alone_is_hardly_ever_believed(estimator: str) -> None:
    found = maps(noise(noise_power=1.0), estimator)
    # Of a cell of 10 pulses: 2e-4 at 0 dB, and both windows are wider than the gate that this counts.
    assert np.isfinite(found["height"].values).mean() <= 2e-3
    # Nobody said that it is noise: what is left are coherences that are not low by chance, |γ| > 0.3 of 10 pulses and
    # 2.7 gates' worth, exp(−27·0.09) = 9 %, and heights all over the ambiguity, which say that they may be folded.
    unsaid = maps(noise(noise_power=0.0), estimator)
    assert (unsaid["quality"].values == 0).mean() < 0.05


@cache
def noise(noise_power: float) -> xr.Dataset:
    generator = np.random.default_rng(5)

    def fill(voltage: np.ndarray) -> None:
        voltage.real, voltage.imag = np.sqrt(0.5) * generator.standard_normal((2, *voltage.shape))

    return with_voltage(fill, noise_power_w=noise_power)


@each_estimator
@pytest.mark.parametrize(("which", "mode"), [("all", MODES[0]), ("some", MODES[1]), ("one", MODES[0])])
def test_voltages_of_no_physics_give_a_map_without_a_warning(estimator: str, which: str, mode: tuple[str, str]) -> None:
    """At the ends of float32, whose squares are nothing or infinite: all pulses, some, or one gate of one receiver."""
    changed = np.isfinite(calm(mode)["voltage"].values)
    if which == "some":
        changed &= (np.arange(PULSES) % 7 < 3)[:, None, None]
    if which == "one":
        changed[np.arange(PULSES) != 5] = False
        changed[:, 1:] = False
        changed[:, :, np.arange(changed.shape[2]) != 30] = False
    for value in (1e-45, 1e-38, 1e-20, 1e10, 1e19, 1e20, 3.4e38, -3.4e38j):
        maps(with_voltage(setting(changed, value), mode, noise_power_w=1.0), estimator)


# ------------------------------------------------------------------------------------------------- what is missing


@each_estimator
@pytest.mark.parametrize(
    ("value", "mode"),
    [(np.nan, MODES[0]), (np.inf, MODES[1]), (complex(0.0, -np.inf), MODES[2]), (complex(np.nan, 1.0), MODES[0])],
)
def test_pulses_that_are_not_finite_are_left_out(estimator: str, value: complex, mode: tuple[str, str]) -> None:
    heard = np.isfinite(calm(mode)["voltage"].values)
    rows = (np.arange(PULSES) % 7 == 0)[:, None, None]
    echoes = with_voltage(lambda voltage: np.copyto(voltage, np.complex64(value), where=rows & heard), mode)
    assert_alike(maps(echoes, estimator), unchanged(estimator, mode), RESAMPLED[estimator])


@each_estimator
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_gates_that_are_not_finite_have_no_echo_and_leave_their_neighbours_be(estimator: str, value: float) -> None:
    found = maps(with_voltage(setting((slice(None), slice(None), slice(20, 23)), value)), estimator)
    assert_nothing_known(found.isel(range=slice(20, 23)), "no_echo")
    others = np.r_[0:17, 26:70]  # beside the gap windows are shorter
    assert_alike(found.isel(range=others), unchanged(estimator).isel(range=others))


@each_estimator
@each_mode
def test_missing_pulses_change_nothing(estimator: str, mode: tuple[str, str]) -> None:
    kept = np.flatnonzero(np.random.default_rng(2).random(PULSES) > 0.1)
    found = maps(calm(mode).isel(pulse=kept), estimator)
    assert_alike(found, unchanged(estimator, mode), RESAMPLED[estimator])


@each_estimator
@each_mode
def test_a_missing_sector_has_no_echo_and_the_rest_stays(estimator: str, mode: tuple[str, str]) -> None:
    found = maps(calm(mode).isel(pulse=np.r_[0:60, 120:PULSES]), estimator)
    assert_nothing_known(found.isel(azimuth=slice(6, 12)), "no_echo")
    others = np.r_[0:5, 13:20]  # the looks beside it have shorter windows
    assert_alike(found.isel(azimuth=others), unchanged(estimator, mode).isel(azimuth=others), RESAMPLED[estimator])


@each_estimator
@pytest.mark.parametrize(
    ("name", "value"), [("time", np.nan), ("azimuth", np.inf), ("attitude", np.nan), ("position", np.inf)]
)
def test_pulses_of_unknown_time_direction_or_place_are_left_out(estimator: str, name: str, value: float) -> None:
    reference = unchanged(estimator)
    assert_alike(maps(with_values(name, slice(0, None, 7), value), estimator), reference)
    dropout = maps(with_values(name, slice(60, 120), value), estimator)
    assert_nothing_known(dropout.isel(azimuth=slice(6, 12)), "no_echo")
    others = np.r_[0:5, 13:20]
    assert_alike(dropout.isel(azimuth=others), reference.isel(azimuth=others))


@each_estimator
def test_a_single_pulse_is_a_single_look(estimator: str) -> None:
    found = maps(calm().isel(pulse=slice(5, 6)), estimator)
    height = found["height"].values
    assert_nothing_known(found.isel(azimuth=slice(1, None)), "no_echo")
    # One antenna sends, so that gates lie up to B/4 · H/R off the mean of both: centimetres in height near by.
    assert np.abs(height[0]).max() < 0.03


@each_estimator
def test_one_look_and_one_gate(estimator: str) -> None:
    look = maps(Boat(sector=(0.0, 1.8)).echoes(ideal_sea), estimator)
    assert look["height"].shape == (1, 70)
    # Of one look no sea is interpolated: the sliding plane's tangent is off by H s²/R² in its window, cm at 15 m.
    other = {"adaptive": "sliding_plane"}.get(estimator, estimator)
    assert_alike(look.isel(azimuth=0), unchanged(other).isel(azimuth=0), 2e-2 if estimator == "adaptive" else ROUNDING)
    gate = maps(calm().isel(range=slice(5, 6)), estimator)
    assert gate["height"].shape == (20, 1)
    assert np.abs(gate["height"].values).max() < ROUNDING


# ---------------------------------------------------------------------------------------------- order, turns, times


@each_estimator
@each_mode
def test_the_order_of_pulses_does_not_matter(estimator: str, mode: tuple[str, str]) -> None:
    mixed = calm(mode).isel(pulse=np.random.default_rng(4).permutation(PULSES))
    assert_alike(maps(mixed, estimator), unchanged(estimator, mode))


@each_estimator
def test_azimuths_that_run_backwards_are_looks_all_the_same(estimator: str) -> None:
    back = calm().assign_coords(azimuth=("pulse", calm()["azimuth"].values[::-1]))
    assert_alike(maps(back, estimator), unchanged(estimator).isel(azimuth=slice(None, None, -1)), RESAMPLED[estimator])


@each_estimator
def test_equal_times_do_no_harm(estimator: str) -> None:
    twice = np.repeat(calm()["time"].values[::2], 2)
    assert_alike(maps(calm().assign_coords(time=("pulse", twice)), estimator), unchanged(estimator))


@each_estimator
def test_only_whole_turns_are_mapped(estimator: str) -> None:
    first, second = calm(), calm().assign_coords(time=calm()["time"] + 1.0, turn=calm()["turn"] + 1)
    second = second.assign(voltage=1j * second["voltage"]).isel(pulse=slice(0, 50))
    both = xr.concat([first, second], "pulse", data_vars="minimal")
    for echoes in (both, both.isel(pulse=np.random.default_rng(4).permutation(both.sizes["pulse"]))):
        tree = retrieve(echoes, RetrievalSettings(estimator=estimator, ground_m=20.0))  # type: ignore[arg-type]
        assert tree["polar"].sizes["turn"] == 1
        assert_alike(tree["polar"].to_dataset().isel(turn=0), maps(first, estimator))
    assert_alike(maps(first.assign_attrs(complete_turns=3), estimator), maps(first, estimator))


# ------------------------------------------------------------------------------------------------ geometry and scale


@each_estimator
def test_gates_nearer_than_the_sea_know_nothing_and_those_beyond_are_right(estimator: str) -> None:
    boat = Boat(height=10.0, ranges=np.arange(3.0, 60.0, 1.5))
    settings = {"cell_range_m": 1.5, "window_range_m": 1.5}
    found = maps(boat.echoes(ideal_sea), estimator, **settings)
    above, beyond = boat.ranges < 9.9, boat.ranges > 15.0
    assert_nothing_known(found.isel(range=above), "ambiguous")
    # A window of one gate averages nothing but looks, which are alike; the adaptive one may be longer.
    tolerance = ROUNDING if estimator == "single_cell" else 0.05
    assert np.abs(found["height"].values[:, beyond]).max() < tolerance


@each_estimator
def test_a_phase_beyond_the_triangle_is_ambiguous(estimator: str) -> None:
    """λ/3 apart antennas differ by at most 2π/3 of phase: the echo's own plus 3 is none."""
    echoes = Boat(offsets=((0.0, 0.0, -0.005), (0.0, 0.0, 0.005)), ranges=np.arange(50.0, 120.0, 1.5)).echoes(ideal_sea)
    echoes["voltage"].values[:, 1] *= np.complex64(np.exp(3j))
    assert_nothing_known(maps(echoes, estimator, paths="one_way"), "ambiguous")


@each_estimator
@pytest.mark.parametrize("scale", [1e-18, 1e-10, 1e10, 1e18])
def test_the_unit_of_voltages_does_not_matter(estimator: str, scale: float) -> None:
    echoes = with_voltage(lambda voltage: np.multiply(voltage, np.float32(scale), out=voltage))
    # At 1e-18 powers are near the least normal float32, 1.2e-38; phases still have 20 bits.
    assert_alike(maps(echoes, estimator), unchanged(estimator), 10.0 * ROUNDING)


@each_estimator
@pytest.mark.parametrize("scale", [1e-30, 5e18, 1e25])
def test_powers_beyond_all_numbers_are_no_echo(estimator: str, scale: float) -> None:
    """Squares of 1e-30 and 1e25 are no float32, and of 5e18 the sum over a look is none: either is known, or none."""
    found = maps(with_voltage(lambda voltage: np.multiply(voltage, np.float32(scale), out=voltage)), estimator)
    if np.isfinite(found["height"].values).any():
        assert_alike(found, unchanged(estimator))
    else:
        assert_nothing_known(found, "no_echo")


@each_estimator
def test_a_sector_in_which_no_pulse_lies_is_empty(estimator: str) -> None:
    assert_nothing_known(maps(calm().assign_attrs(sector_deg=[180.0, 216.0]), estimator), "no_echo")


@each_estimator
def test_more_noise_than_power_leaves_no_echo(estimator: str) -> None:
    assert_nothing_known(maps(calm().assign_attrs(noise_power_w=1e6), estimator), "no_echo")


# ------------------------------------------------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("frequency_hz", 0.0),
        ("frequency_hz", np.nan),
        ("frequency_hz", "ten"),
        ("pulse_width_s", 0.0),
        ("bandwidth_hz", -1.0),
        ("prf_hz", 0.0),
        ("prf_hz", 123.0),  # pulses are 0.5 ms apart
        ("rotation_rpm", 0.0),
        ("noise_power_w", -1.0),
        ("noise_power_w", np.nan),
        ("tilt_deg", 90.0),
        ("transmit", "both"),
        ("interferogram", "double"),
        ("complete_turns", np.nan),
        ("sector_deg", [36.0, 0.0]),
        ("sector_deg", [0.0, 18.0, 36.0]),
        ("sector_deg", [np.nan, 36.0]),
        ("sector_deg", [0.0, 720.0]),
    ],
)
def test_attributes_that_no_radar_has_are_refused_by_name(name: str, value: Any) -> None:
    assert name in refusal(calm().assign_attrs({name: value}))


@each_mode
def test_a_pulse_rate_that_is_not_the_times_is_refused(mode: tuple[str, str]) -> None:
    assert "prf_hz = 123" in refusal(calm(mode).assign_attrs(prf_hz=123.0))


@pytest.mark.parametrize(
    ("rows", "value"),
    [
        (slice(None), np.arange(118.5, 14.0, -1.5)),  # backwards
        (5, 24.0),
        (5, np.nan),
        (slice(None), np.arange(0.0, 105.0, 1.5)),  # from the antenna itself
        (slice(None), np.arange(-30.0, 75.0, 1.5)),
        (slice(None), 15.0 + 1.5 * np.arange(70.0) ** 1.01),
    ],
)
def test_gates_that_are_not_evenly_spaced_beyond_the_antenna_are_refused(rows: Any, value: Any) -> None:
    assert "range" in refusal(with_values("range", rows, value))


@pytest.mark.parametrize("sender", [-1, 2, 7])
def test_an_antenna_that_is_not_there_is_refused(sender: int) -> None:
    assert f"transmitter = {sender}" in refusal(with_values("transmitter", 7, sender))


@pytest.mark.parametrize("name", ["time", "azimuth", "attitude", "position"])
def test_nothing_known_of_any_pulse_is_refused(name: str) -> None:
    assert name in refusal(with_values(name, slice(None), np.nan))


def test_turns_that_go_back_in_time_are_refused() -> None:
    assert "turn" in refusal(with_values("turn", slice(0, 100), 1).assign_attrs(complete_turns=2))


def test_nothing_at_all_is_refused() -> None:
    assert "no complete turn" in refusal(calm().assign_attrs(complete_turns=0))
    assert "no complete turn" in refusal(calm().isel(pulse=slice(0, 0)))
    assert "range" in refusal(calm().isel(range=slice(0, 0)))


@pytest.mark.parametrize("times", [1e3, 1e30])
def test_ranges_beyond_every_horizon_are_refused(times: float) -> None:
    echoes = calm()
    far = echoes.assign_coords(range=echoes["range"] * times)
    with pytest.raises(SchemaError, match=r"range\[\d+\] = .*: must be at most 20000 m"):
        retrieve(far)


def test_a_ground_map_that_fits_no_memory_is_refused() -> None:
    # In the words of the scene's own limit, whoever brings the ranges.
    with pytest.raises(SchemaError, match=r"retrieval\.ground_m = 0\.01: must be at least .* raise"):
        retrieve(calm(), RetrievalSettings(ground_m=0.01))
