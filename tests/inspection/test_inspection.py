"""What is planted into echoes is found, and named; echoes as they should be are not called doubtful."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.inspection import Finding, Level, inspect
from seamap_rt.inspection.findings import heights, scan
from seamap_rt.inspection.motion import motion
from seamap_rt.inspection.receivers import receivers, transmitter

Voltage = NDArray[np.complex64]
MAST = 5.0
SCENE = {
    "turns": 2,
    "radar.range_m": [15.0, 200.0],
    "radar.sector_deg": [200.0, 340.0],
    "radar.height_m": MAST,
    "sea.extent_m": 480.0,
    "sea.resolution_m": 1.6,
    "tracing.tracer": "horizon",
}


@cache
def echoes(transmit: str = "switched") -> xr.Dataset:
    scene = sr.load_scene("choppy_sea", overrides={**SCENE, "radar.transmit": transmit})
    return sr.simulate(scene).echoes


def planted(change: Callable[[Voltage], Any], transmit: str = "switched") -> xr.Dataset:
    good = echoes(transmit)
    voltage = good["voltage"].values.copy()
    changed = change(voltage)
    return good.assign(voltage=(good["voltage"].dims, np.ascontiguousarray(voltage if changed is None else changed)))


def upper(change: Callable[[Voltage], Voltage]) -> xr.Dataset:
    def of_both(voltage: Voltage) -> None:
        voltage[:, 1] = change(voltage[:, 1])

    return planted(of_both)


def grave(found: list[Finding]) -> dict[str, Finding]:
    return {finding.what: finding for finding in found if finding.verdict in ("wrong", "doubtful")}


@pytest.mark.parametrize("transmit", ["switched", "single"])
def test_echoes_as_they_should_be_are_not_doubtful(transmit: str) -> None:
    found = inspect(echoes(transmit), wind_from_deg=270.0)
    assert not grave(found)
    known = {finding.what for finding in found if finding.verdict == "good"}
    assert known >= {"sign of the phase", "mast height", "Doppler", "waves from turn to turn", "power by range"}
    assert "phase from pulse to pulse" in known


@pytest.mark.parametrize(
    ("transmit", "change", "remedy"),
    [
        ("switched", np.conj, "conjugate"),
        ("switched", lambda voltage: voltage[:, ::-1], "exchange lower and upper"),
        ("switched", lambda voltage: np.conj(voltage[:, ::-1]), "do both"),
        ("single", np.conj, "conjugate"),
        ("single", lambda voltage: voltage[:, ::-1], "exchange lower and upper"),
    ],
)
@pytest.mark.slow
def test_a_wrong_sign_is_surely_wrong_and_its_remedy_is_said(transmit: str, change: Any, remedy: str) -> None:
    first, *_ = inspect(planted(change, transmit))
    assert (first.what, first.verdict) == ("sign of the phase", "wrong")
    assert remedy in first.remedy


def test_velocities_of_the_wrong_sign_are_found_by_the_next_turn() -> None:
    """One antenna sends: receivers exchanged and conjugated leave the heights as they are, and turn the Doppler."""
    turned = planted(lambda voltage: np.conj(voltage[:, ::-1]), "single")
    found = grave(inspect(turned, wind_from_deg=270.0))
    assert "sign of the phase" not in found
    assert found["waves from turn to turn"].verdict == "wrong"
    assert found["Doppler"].verdict == "doubtful"


@pytest.mark.parametrize("degrees", [25.0, -20.0])
def test_a_phase_offset_is_found_and_told_in_degrees(degrees: float) -> None:
    """The level of a sea that is half hidden rises with range by itself: 7° of phase, up the waves of this one."""
    finding = grave(inspect(upper(lambda voltage: voltage * np.exp(-1j * np.radians(degrees)))))[
        "phase offset of the receivers"
    ]
    said = float(finding.remedy.split("phase of ")[1].split(" ")[0])
    assert said == pytest.approx(degrees - 7.0, abs=3.0)


def test_a_wrong_mast_height_is_found_and_told() -> None:
    """A mast said to be a metre too high lifts all that is seen by a metre: R δ/B does not change, h does."""
    lifted = echoes().assign(position=echoes()["position"] + np.array([0.0, 0.0, 1.0]))
    lifted.attrs = {**lifted.attrs, "height_m": MAST + 1.0}
    finding = grave(inspect(lifted))["mast height"]
    said = float(finding.remedy.split("height_m = ")[1].split(" ")[0])
    assert said == pytest.approx(MAST, abs=0.15)


GENERATOR = np.random.default_rng(4)


@pytest.mark.parametrize(
    ("what", "change"),
    [
        ("receivers' balance", lambda: upper(lambda voltage: 0.5 * voltage)),
        ("coherence of the receivers", lambda: upper(lambda voltage: np.roll(voltage, 4, axis=1))),
        ("power by range", lambda: planted(lambda v: v * (echoes()["range"].values / 100.0).astype(np.float32) ** 1.5)),
        (
            "voltages",
            lambda: planted(lambda v: np.where(GENERATOR.random((v.shape[0], 1, 1)) < 0.05, np.nan, v).astype(v.dtype)),
        ),
        (
            "missing pulses",
            lambda: echoes().isel(pulse=np.flatnonzero(GENERATOR.random(echoes().sizes["pulse"]) > 0.05)),
        ),
        (
            "evenness of the scan",
            lambda: echoes().assign_coords(
                azimuth=echoes()["azimuth"] + 2.0 * np.sin(np.radians(3.0 * echoes()["azimuth"]))
            ),
        ),
    ],
)
def test_what_is_planted_is_named(what: str, change: Callable[[], xr.Dataset]) -> None:
    found = grave(inspect(change()))
    assert found[what].verdict == "doubtful"
    assert found[what].remedy


def test_receivers_that_have_nothing_in_common_are_surely_wrong() -> None:
    def noise(voltage: Voltage) -> Voltage:
        return voltage[GENERATOR.permutation(voltage.shape[0])]

    assert grave(inspect(upper(noise)))["coherence of the receivers"].verdict == "wrong"


def first(made: xr.Dataset, **attributes: Any) -> xr.Dataset:
    """The first turn, loaded, described otherwise."""
    return made.assign_attrs({**made.attrs, **attributes}).isel(pulse=slice(0, 10_000)).load()


@pytest.mark.parametrize("transmit", ["switched", "single"])
def test_pulses_that_are_said_to_be_coherent_and_are_not(transmit: str) -> None:
    """Phases that are drawn anew for each pulse and both receivers: their own coherence is what it was."""
    turned = np.exp(2j * np.pi * GENERATOR.random(echoes(transmit).sizes["pulse"])).astype(np.complex64)
    made = first(planted(lambda voltage: voltage * turned[:, None, None], transmit))
    finding = transmitter(made)
    assert finding.verdict == "wrong"
    assert "transmitter = 'magnetron'" in finding.remedy
    assert transmitter(first(made, transmitter="magnetron")).verdict == "good"
    claimed = transmitter(first(made, transmitter="magnetron", coherent_on_receive=1))
    assert claimed.verdict == "wrong"
    assert "mend how each pulse's phase is measured" in claimed.remedy


@pytest.mark.parametrize(("stated", "verdict"), [(0.0, "doubtful"), (30.0, "good")])
def test_errors_of_measured_phases_are_told_in_degrees(stated: float, verdict: str) -> None:
    error = np.radians(30.0) * GENERATOR.standard_normal(echoes().sizes["pulse"])
    made = planted(lambda voltage: voltage * np.exp(1j * error).astype(np.complex64)[:, None, None])
    found = transmitter(first(made, transmitter="magnetron", coherent_on_receive=1, transmit_phase_error_deg=stated))
    assert found.verdict == verdict
    if verdict == "doubtful":
        assert float(found.says.split("errors of ")[1].split("°")[0]) == pytest.approx(30.0, abs=2.0)


def test_a_magnetron_that_is_coherent_is_no_fault() -> None:
    """Of echoes that could give velocities a header that says less is not doubtful, but said."""
    found = transmitter(first(echoes(), transmitter="magnetron"))
    assert found.verdict == "unknown"
    assert "could be used" in found.says


def test_the_next_turn_tells_the_way_where_no_velocity_does() -> None:
    """Waves from 270°, whose axis is 90°: of the two ways along it the one is said that the second turn shows."""
    maps = sr.retrieve(echoes().assign_attrs({**echoes().attrs, "transmitter": "magnetron"}))
    drift, run = motion(maps)
    assert (drift.verdict, run.verdict) == ("unknown", "good")
    assert float(run.says.split("come from ")[1].rstrip("°")) == pytest.approx(270.0, abs=20.0)


@pytest.mark.parametrize(
    ("change", "verdict", "words"),
    [
        (lambda v: np.stack((v[:, 0], v[:, 0]), axis=1), "wrong", "both hold the same signal"),
        (lambda v: np.stack((v[:, 0], 0 * v[:, 0]), axis=1), "wrong", "the upper receiver holds nothing"),
        (lambda v: 0 * v, "wrong", "both are zero"),
        (lambda v: np.stack((v[:, 0], v[:, 1].conj()), axis=1), "wrong", "one is conjugated"),
        (lambda v: v + np.complex64(3.0 * np.abs(v).mean()), "doubtful", "is a constant"),
        (lambda v: v.real.astype(np.complex64), "doubtful", "no quadratures"),
        (lambda v: np.stack((v[:, 0], np.roll(v[:, 1], 1, axis=1)), axis=1), "doubtful", "1 behind"),
        (lambda v: np.stack((np.roll(v[:, 0], 2, axis=1), v[:, 1]), axis=1), "doubtful", "2 before"),
    ],
)
@pytest.mark.parametrize("transmit", ["switched", "single"])
def test_samples_that_are_no_two_voltages_of_one_echo(transmit: str, change: Any, verdict: str, words: str) -> None:
    finding = receivers(planted(change, transmit).isel(pulse=echoes(transmit)["turn"].values == 0))
    assert finding.verdict == verdict
    assert words in finding.says
    assert finding.remedy
    assert receivers(echoes(transmit).isel(pulse=slice(0, 10_000))).verdict == "good"


def test_times_in_another_unit_make_an_antenna_that_no_radar_has() -> None:
    """Of milliseconds read as seconds."""
    slow = echoes().assign_coords(time=1e3 * echoes()["time"])
    slow.attrs = {**slow.attrs, "rotation_rpm": 0.06, "prf_hz": 10.0}
    said = {finding.what: finding for finding in scan(slow)}
    assert said["speed of the scan"].verdict == "doubtful"
    assert "seconds" in said["speed of the scan"].remedy


def test_a_phase_half_a_turn_off_is_not_called_good() -> None:
    """No offset of the level shows it where heights fold; that it is nowhere the sea's does."""
    found = inspect(upper(np.negative))
    assert {"sign of the phase", "mast height", "phase offset of the receivers", "heights"} & set(grave(found))
    assert next(each for each in found if each.what == "sign of the phase").verdict != "good"


def test_maps_that_hold_nothing_or_what_no_sea_can_are_doubtful() -> None:
    polar = sr.retrieve(echoes())["polar"].to_dataset()
    assert {each.verdict for each in heights(polar, MAST)} == {"good"}
    empty = polar.assign(height=polar["height"].where(polar["range"] < 16.0))
    assert heights(empty, MAST)[0].verdict == "doubtful"
    assert heights(polar.assign(height=20.0 * polar["height"]), MAST)[1].verdict == "doubtful"


def test_a_flat_calm_is_not_called_wrong() -> None:
    """No wave says where the level is, but the level itself does."""
    scene = sr.load_scene(
        "flat", overrides={"tracing.tracer": "horizon", "radar.range_m": [15.0, 120.0], "radar.sector_deg": [0.0, 90.0]}
    )
    calm = sr.simulate(scene).echoes
    assert not grave(inspect(calm))
    turned = calm.assign(voltage=np.conj(calm["voltage"]))
    assert grave(inspect(turned))["sign of the phase"].verdict == "wrong"


def test_maps_of_too_few_heights_leave_the_level_open() -> None:
    polar = sr.retrieve(echoes())["polar"].to_dataset()
    assert Level.of(polar) is not None
    assert Level.of(polar.assign(height=polar["height"].where(polar["range"] < 15.5))) is None
