"""Maps by a magnetron: heights as of a coherent transmitter, and nothing that rests on phases from pulse to pulse."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr

import seamap_rt as sr
from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.errors import SchemaError
from seamap_rt.io.recording_header import RecordingHeader
from seamap_rt.wavefield.sea_state import in_words

SMALL: dict[str, Any] = {
    "radar.range_m": [15.0, 98.0],
    "sea.extent_m": 256.0,
    "tracing.tracer": "horizon",
    "retrieval.estimator": "single_cell",
}
MAGNETRON: dict[str, Any] = {"radar.transmitter": "magnetron"}
MEASURED: dict[str, Any] = {**MAGNETRON, "radar.coherent_on_receive": True}


@cache
def _simulated(keys: tuple[tuple[str, Any], ...]) -> sr.Simulation:
    return sr.simulate(sr.load_scene("tiny", {**SMALL, **dict(keys)}))


def simulated(**keys: Any) -> Any:
    return _simulated(tuple({name.replace("__", "."): value for name, value in keys.items()}.items()))


def polar(echoes: xr.Dataset, **settings: Any) -> xr.Dataset:
    chosen = sr.load_scene("tiny", {**SMALL, **{f"retrieval.{name}": value for name, value in settings.items()}})
    return sr.retrieve(echoes, chosen.retrieval)["polar"].to_dataset().isel(turn=0)


def dotted(keys: dict[str, Any]) -> dict[str, Any]:
    return {name.replace(".", "__"): value for name, value in keys.items()}


# ------------------------------------------------------------------------------------------------------ heights


@pytest.mark.parametrize("transmit", ["single", "switched"])
def test_heights_of_single_pulses_are_those_of_a_coherent_transmitter(transmit: str) -> None:
    """The products of two receivers lose a pulse's phase: without noise the maps differ by float32's rounding."""
    plain, random = (
        polar(simulated(radar__transmit=transmit, radar__noise=False, **dotted(keys)).echoes, paths="one_way")
        for keys in ({}, MAGNETRON)
    )
    assert np.isfinite(plain["height"]).sum() > 1000
    np.testing.assert_allclose(random["height"], plain["height"], atol=1e-4)
    np.testing.assert_allclose(random["height_std"], plain["height_std"], rtol=1e-3, atol=1e-6)
    assert "radial_velocity" in plain
    assert not {"radial_velocity", "doppler_width"} & set(random)


def test_errors_with_noise_are_those_of_a_coherent_transmitter() -> None:
    """Noise turned by a phase is other noise as strong: medians of |error| over 1,500 cells that err alike in groups of
    about four, of two seeds: 1.25/√(2 × 1500/4) = 5 %; the same sea and speckle leave less of it."""
    medians = []
    for keys in ({}, MAGNETRON):
        errors = []
        for seed in (1, 2):
            made = simulated(radar__transmit="single", seed=seed, **dotted(keys))
            got, true = polar(made.echoes), made.truth["polar"].to_dataset().isel(turn=0)
            counted = (true["visible_fraction"].values > 0.5) & (got["quality"].values & 4 == 0)
            errors.append(np.abs(got["height"].values - true["height"].values)[counted])
        medians.append(np.nanmedian(np.concatenate(errors)))
    assert medians[0] > 0.02
    assert medians[1] / medians[0] == pytest.approx(1.0, abs=0.05)


def test_switched_magnetrons_are_compared_one_way_alone() -> None:
    """Each antenna on itself would be two pulses: there is no p = 2, which a measured phase gives back."""
    for keys, paths in (({}, 2), (MAGNETRON, 1), (MEASURED, 2)):
        assert polar(simulated(radar__transmit="switched", **dotted(keys)).echoes).attrs["paths"] == paths


def test_a_carrier_that_strays_lifts_and_lowers_whole_looks() -> None:
    """By h δ/f, δ of a look's mean: h σ/(f √N) rms over looks, whatever the range. 33 looks: ±12 %, and as much again
    for the share of a look's pulses that count for most."""
    keys = {"radar__transmit": "single", "radar__noise": False, **dotted(MAGNETRON)}
    steady, strayed = (
        polar(simulated(**keys, radar__frequency_jitter_hz=jitter).echoes)["height"].values.astype(float)
        for jitter in (0.0, 2.5e6)
    )
    off = np.nanmedian(strayed - steady, axis=1)
    law = 5.0 * 2.5e6 / 10e9 / np.sqrt(50.0)
    assert np.sqrt(np.mean(off**2)) == pytest.approx(law, rel=0.4)
    assert np.abs(off).max() < 4.0 * law
    halves = [np.nanmedian((strayed - steady)[:, part], axis=1) for part in (slice(5, 25), slice(25, None))]
    assert np.corrcoef(halves)[0, 1] > 0.5


# ------------------------------------------------------------------------------------------ measured phases


def test_velocities_come_back_with_measured_phases() -> None:
    """3° of error from pulse to pulse leave a lag of 15 pulses 3° √2/√35 at most: λ/(4π τ) of it is 1 cm/s."""
    plain, random, measured = (
        polar(simulated(radar__transmit="single", **dotted(keys)).echoes) for keys in ({}, MAGNETRON, MEASURED)
    )
    assert "radial_velocity" not in random
    strong = plain["snr_db"].values > 15.0
    off = (measured["radial_velocity"] - plain["radial_velocity"]).values[strong]
    assert np.nanstd(plain["radial_velocity"].values[strong]) > 0.3
    assert np.nanmedian(np.abs(off)) < 0.02


@pytest.mark.parametrize("transmit", ["single", "switched"])
def test_what_measured_phases_cost_alternating_pulses(transmit: str) -> None:
    """A look's phase is off as a whole by the mean error of its pulses, √(2/N) of one's; the map says so."""
    degrees = 10.0
    common = {"radar__interferogram": "alternating_pulse", "radar__transmit": transmit, "radar__noise": False}
    plain, echoes = (
        simulated(**common, **dotted(keys)).echoes
        for keys in ({}, {**MEASURED, "radar.transmit_phase_error_deg": degrees})
    )
    unstated = polar(echoes.assign_attrs({**echoes.attrs, "transmit_phase_error_deg": 0.0}))
    plain, measured = polar(plain), polar(echoes)
    turned = np.exp(1j * (measured["phase"].values - plain["phase"].values))
    strong = np.where(plain["coherence"].values > 0.9, turned, np.nan)
    looks = np.angle(np.nanmean(strong, axis=1))
    law = np.radians(degrees) * np.sqrt(2.0 / 25.0)
    # 33 looks: ±12 %; and the pulses of a cell count by their speckle, which leaves fewer of them.
    assert np.sqrt(np.mean(looks**2)) == pytest.approx(law, rel=0.4)
    within = np.nanmedian(np.abs(np.angle(strong * np.exp(-1j * looks)[:, None])))
    assert within < 0.5 * law
    added = np.sqrt(measured["height_std"].values ** 2 - unstated["height_std"].values ** 2)
    paths, ranges = 2 if transmit == "switched" else 1, plain["range"].values
    asked = law * (SPEED_OF_LIGHT / 10e9) * ranges / (2.0 * np.pi * paths * 0.2)
    ratio = np.nanmedian(added / asked, axis=0)[ranges > 50.0]
    np.testing.assert_allclose(ratio, 1.0, atol=0.03)  # λR/(2πpB) holds at grazing, to (h/R)² and the heights' share


# ------------------------------------------------------------------------------------------------ what is refused

ASKED = [
    ({"radar.interferogram": "alternating_pulse"}, "interferogram = 'alternating_pulse'", "single_pulse"),
    ({"retrieval.coherent_s": 0.002}, "retrieval.coherent_s = 0.002", "set it to 0"),
    ({"retrieval.channels": "from_cross_paths"}, "retrieval.channels = 'from_cross_paths'", "as_given"),
    ({"retrieval.map_time_s": 1.0}, "retrieval.map_time_s = 1", "leave it out"),
]


@pytest.mark.parametrize(("keys", "named", "instead"), ASKED)
def test_a_scene_asks_nothing_of_phases_that_it_does_not_keep(keys: dict[str, Any], named: str, instead: str) -> None:
    sr.load_scene("tiny", {**keys, **MEASURED})
    with pytest.raises(sr.InputError) as caught:
        sr.load_scene("tiny", {**keys, **MAGNETRON})
    for words in (named, instead, "radar.transmitter = 'magnetron'", "radar.coherent_on_receive = true"):
        assert words in str(caught.value)


@pytest.mark.parametrize(("keys", "named", "instead"), ASKED)
def test_a_retrieval_asks_nothing_of_phases_that_are_random(keys: dict[str, Any], named: str, instead: str) -> None:
    echoes = simulated(radar__transmit="switched", **dotted(MAGNETRON)).echoes
    settings = {name.removeprefix("retrieval."): value for name, value in keys.items() if "retrieval." in name}
    if not settings:
        echoes = echoes.assign_attrs({**echoes.attrs, "interferogram": "alternating_pulse"})
    with pytest.raises(SchemaError, match=named) as caught:
        polar(echoes, **settings)
    assert instead in str(caught.value)


def test_a_magnetron_sends_no_chirp() -> None:
    with pytest.raises(sr.InputError, match=r"^radar.transmitter = 'magnetron': sends plain pulses"):
        sr.load_scene("tiny", {**MAGNETRON, "radar.waveform": "chirp"})


def test_attributes_of_a_transmitter_that_there_is_not_are_refused() -> None:
    echoes = simulated(radar__transmit="switched", **dotted(MAGNETRON)).echoes
    for name, value in (("transmitter", "klystron"), ("coherent_on_receive", 2), ("transmit_phase_error_deg", -1.0)):
        with pytest.raises(SchemaError, match=f"echoes: {name} = "):
            sr.retrieve(echoes.assign_attrs({**echoes.attrs, name: value}))


# ------------------------------------------------------------------------------------------- what reads the maps


def test_without_velocities_the_way_that_waves_run_is_right_or_left_open() -> None:
    """Waves from 270°: their axis by the heights; their way by what a turn's second shows, or both ways are said."""
    scene = {"radar__sector_deg": (0.0, 360.0), "radar__transmit": "single"}
    plain, random = (simulated(**scene, **dotted(keys)) for keys in ({}, MAGNETRON))
    known, open_way = (sr.sea_state(sr.retrieve(made.echoes)) for made in (plain, random))
    assert np.isfinite(known["mean_direction"]).all()
    assert float(open_way["mean_axis"][0]) == pytest.approx(90.0, abs=25.0)
    for name in ("significant_wave_height", "peak_period"):
        assert float(open_way[name][0]) == pytest.approx(float(known[name][0]), rel=0.1)
    axis, way = (float(open_way[name][0]) for name in ("mean_axis", "mean_direction"))
    if np.isfinite(way):
        assert way == pytest.approx(270.0, abs=25.0)
    else:
        assert in_words(open_way).endswith(f"from {axis:.0f}° or {axis + 180.0:.0f}°")


def test_a_recording_says_what_sent_it() -> None:
    simulation = simulated(radar__transmit="single", **dotted(MEASURED))
    echoes = simulation.echoes
    keys = {name: echoes.attrs[name] for name in RecordingHeader.model_fields if name in echoes.attrs}
    keys |= {"coherent_on_receive": True, "noise_power_w": float(echoes.attrs["noise_power_w"])}
    voltage = echoes["voltage"].values
    recorded = {}
    for measured in (True, False):
        recorded[measured] = sr.echoes_from_recording(
            voltage[:, 0],
            voltage[:, 1],
            {**keys, "coherent_on_receive": measured},
            time=echoes["time"].values,
            azimuth=echoes["azimuth"].values,
            ranges=echoes["range"].values,
        )
        for name in ("transmitter", "transmit_phase_error_deg"):
            assert recorded[measured].attrs[name] == echoes.attrs[name]
    assert "radial_velocity" in polar(recorded[True])
    assert "radial_velocity" not in polar(recorded[False])
