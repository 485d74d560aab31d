"""The four modes and the moving boat, from the sea to the map: the laws that validation.radar prints.

Their own functions are used, so that what they print is held here on small pieces of sea.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from seamap_rt.scene import load_scene
from seamap_rt.simulation import Simulator, Turn
from validation.radar import modes, riding

EDGES = (50.0, 75.0, 100.0)
SMALL: dict[str, Any] = {"radar.range_m": [15.0, 110.0], "sea.extent_m": 400.0}


# ------------------------------------------------------------------------------ what the scripts do for the simulator


@pytest.mark.parametrize("mode", modes.MODES, ids=str)
def test_noise_that_is_added_afterwards_is_the_simulation_s_own(mode: Any) -> None:
    keys = {
        "radar.sector_deg": [262.0, 268.0],
        "platform.list_deg": 10.0,
        "platform.speed_m_s": 3.0,
        **SMALL,
        **mode.keys,
    }
    made = load_scene("tiny", {**keys, "tracing.tracer": "horizon", "radar.noise": False})
    simulator = Simulator(made)
    added = modes.with_noise(simulator.turn(0), made.radar, made.seed, simulator.installation).echoes
    loud = Simulator(load_scene("tiny", {**keys, "tracing.tracer": "horizon"})).turn(0).echoes
    assert_array_equal(added["voltage"].values, loud["voltage"].values)
    assert added.attrs == loud.attrs


def test_sensors_held_against_the_same_echoes_say_what_the_simulation_s_own_do() -> None:
    sensors = {
        "roll_bias_deg": 0.3,
        "heading_bias_deg": 2.0,
        "latency_s": 0.05,
        "attitude_noise_deg": 0.1,
        "rate_hz": 20.0,
    }
    small = {**SMALL, "radar.sector_deg": [262.0, 268.0]}
    made = riding.boat_scene("tiny", 1, riding.SWINGING, **small)
    said = riding.as_sensed(Simulator(made).turn(0).echoes, made, sensors)
    faulty = {f"platform.sensors.{key}": value for key, value in sensors.items()}
    own = Simulator(riding.boat_scene("tiny", 1, riding.SWINGING, **small, **faulty)).turn(0).echoes
    for name in ("voltage", "position", "attitude", "azimuth"):
        assert_array_equal(said[name].values, own[name].values)


# ---------------------------------------------------------------------------------------------------- the modes


@pytest.mark.parametrize("look", [90.0, 270.0], ids=["recedes", "comes"])
@pytest.mark.parametrize("mode", [modes.PING_PONG, modes.ALTERNATING], ids=str)
def test_a_drifting_sea_biases_forward_and_backward_pairs_against_each_other(mode: Any, look: float) -> None:
    # Asked: 5 % of 2vτR/(pB), 2 % of it with both pairs. The map of both pairs, of the same speckle, is taken off: what
    # is left of a flat sea's scatter is its Doppler's, ±1 % over these cells.
    found = modes.doppler_bias("choppy_sea", look, mode, 1, EDGES, **SMALL)
    still = modes.doppler_bias("choppy_sea", look, modes.SWITCHED, 1, EDGES, **SMALL)["both"]
    for pairs in ("forward", "backward"):
        got, asked = (found[pairs] - found["both"]).T
        assert np.abs(asked).min() > 0.01
        assert (np.sign(asked) == np.sign(asked[0])).all()
        np.testing.assert_allclose(got, asked, rtol=0.05)
    recedes = 1.0 if look == 90.0 else -1.0
    assert np.sign(found["forward"][0, 1]) == -recedes
    assert np.abs(found["both"][:, 0] - still[:, 0]).max() < 0.02 * np.abs(found["forward"][:, 1]).max()


@pytest.mark.parametrize("mode", modes.MODES, ids=str)
def test_faults_of_the_radar_bias_each_mode_as_its_sensitivity_asks(mode: Any) -> None:
    # The phase of a channel shifts every cell alike; 1 % is room for cells whose height curves with the phase. The
    # longer baseline's rays differ by 1 mm over the shadows' edges too, which changes single cells.
    small = {**SMALL, "radar.sector_deg": [255.0, 275.0]}
    sound = modes.sector("tiny", mode, 1, **small)
    clean = modes.Cells.of(modes.simulated(sound), sound, mode)
    for fault, tolerance in zip(modes.FAULTS.values(), (0.01, 0.05), strict=True):
        faulty = modes.sector("tiny", mode, 1, **small, **fault)
        turn = modes.simulated(faulty)
        off, asked = modes.Cells.of(turn, faulty, mode), modes.fault_height(clean, sound.radar, fault)
        inside = clean.within(50.0, 100.0) & off.within(50.0, 100.0)
        got = (off.height - clean.height)[inside].mean()
        assert got == pytest.approx(asked[inside].mean(), rel=tolerance)
        if mode is modes.SWITCHED:
            # Reciprocal paths are the same to rounding; a pulse later speckle has turned by its Doppler, which the
            # other order turns back, and decorrelated by 1e-4.
            told = fault.get("radar.channel_phase_deg", 0.0)
            assert modes.measured_channel_phase(turn.echoes) == pytest.approx(told, abs=0.05)


@cache
def mode_maps() -> Any:
    keys = {"radar.sector_deg": [200.0, 340.0], "sea.extent_m": 512.0}
    return modes.four_modes("tiny", 1, **keys, **{"radar.range_m": [15.0, 130.0]})


@pytest.mark.slow
def test_noise_alone_errs_as_each_mode_asks() -> None:
    # Some 2300 cells, of which every fourth or so is independent: an rms to 3 %, their ratio to 4 %.
    loud = mode_maps()[modes.SINGLE, True][0]
    _, single, _ = modes.phase_errors(mode_maps(), modes.SINGLE, 50.0, 120.0)
    for mode in (modes.SWITCHED, modes.ALTERNATING, modes.PING_PONG):
        _, alone, _ = modes.phase_errors(mode_maps(), mode, 50.0, 120.0)
        asked = modes.noise_ratio(mode, loud.snr_db[loud.within(50.0, 120.0)])
        assert alone[0] / single[0] == pytest.approx(asked, rel=0.12)


@pytest.mark.slow
def test_speckle_moves_heights_alike_however_often_the_phase_counts() -> None:
    # The same sea, speckle and antennas: half the error per radian, twice the radians.
    for one, two in ((modes.SINGLE, modes.ALTERNATING), (modes.SWITCHED, modes.PING_PONG)):
        still = [modes.phase_errors(mode_maps(), mode, 50.0, 120.0)[0][0] / mode.paths for mode in (one, two)]
        assert still[1] == pytest.approx(still[0], rel=0.05)


# --------------------------------------------------------------------------------------------------- the boat


@cache
def swell_ride(name: str) -> Any:
    """Rides over 60° up-wave, abeam of a boat that heads north."""
    keys = {"radar.range_m": [15.0, 150.0], "radar.transmit": "single"}
    return riding.Ride.of(riding.boat_scene("tiny", 1, riding.MOTIONS[name], **keys))


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in riding.MOTIONS if name != "at rest"])
def test_heights_keep_level_whatever_the_boat_does(name: str) -> None:
    # A map that took the target in the upright plane of its bearing would err by sin² of the roll of 5 m: 15 cm at 10°.
    cells = swell_ride(name).clean
    inside = cells.within(50.0, 150.0)
    assert inside.sum() > 1000
    assert abs(cells.error[inside].mean()) < 0.02


@pytest.mark.slow
def test_a_boat_that_leans_towards_the_look_sees_as_well_as_one_at_rest() -> None:
    # Abeam the fan of the beam stays upright: less than a tenth more, and with noise as much more as the beam asks.
    leaning, rest = swell_ride("list 10°"), swell_ride("at rest")
    west = riding.near(rest.clean, 270.0, 15.0)
    assert riding.error(leaning.clean, west) < 1.10 * riding.error(rest.clean, west)


@pytest.mark.slow
def test_a_roll_sensor_s_error_tilts_the_map_abeam() -> None:
    made = riding.boat_scene(
        "tiny", 1, riding.REST, **{"radar.range_m": [15.0, 115.0], "radar.sector_deg": [255.0, 285.0]}
    )
    turn: Turn = Simulator(made).turn(0)
    for bias in (0.1, -0.1):
        for side, distance, got, asked in riding.roll_bias(turn, made, bias):
            if side == "port" and distance <= 100.0:
                assert np.sign(asked) == np.sign(bias)  # starboard said to be lower: port reads too high
                assert got == pytest.approx(asked, rel=0.05)
