"""Echoes on a boat that rolls, pitches, yaws, heaves and runs: against exact paths, and against a direct sum."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from exact_echoes import MODES, ROCKING, SEED, direct_sum, mast_of, radar_of, relative_rms, sea_seen
from numpy.typing import NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT, wrap_degrees
from seamap_rt.echoes import from_scatterers, slow_time, turn_voltages
from seamap_rt.echoes.slow_time import widest
from seamap_rt.echoes.turn import choose_nodes
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import Pulses
from seamap_rt.scene import Scene
from seamap_rt.settings import PlatformSettings, RadarSettings

ROLL_OF = {"motion": "sinusoidal", "heading_deg": 22.0}  # the boat looks ahead: its roll leans the fan
ANYWHERE = [
    {"offset_m": (-0.3, 0.1, -0.12), "role": "both"},
    {"offset_m": (0.25, -0.2, 0.13), "role": "both"},
    {"offset_m": (0.1, 0.4, 0.6), "role": "rx"},
]
WIDE = {"pattern": "gaussian", "azimuth_beamwidth_deg": 20.0, "elevation_beamwidth_deg": 60.0}


def scene_of(platform: dict, **radar) -> Scene:
    default = {
        "noise": False,
        "sector_deg": (20.0, 24.0),
        "range_m": (15.0, 130.0),
        "antenna": WIDE,
        "height_m": 6.0,
        "tilt_deg": 4.0,
        "rotation_rpm": 30.0,
    }
    return Scene.model_validate({"name": "boat", "radar": {**default, **radar}, "platform": platform})


# --------------------------------------------------------------------------------------------- exact places and paths


class ExactBoat:
    """Where the antennas are and look, from the settings alone, in mpmath's working precision."""

    def __init__(self, radar: RadarSettings, platform: PlatformSettings, offsets: list[tuple]) -> None:
        self.radar, self.platform, self.offsets = radar, platform, offsets
        lever = platform.lever_arm_m or (0.0, 0.0, radar.height_m)
        self.lever = mpmath.matrix([mpmath.mpf(part) for part in lever])
        # The world's origin lies below the array when the boat lies still at time 0.
        self.rest = self._attitude(0, 0, platform.heading_deg) * self.lever

    def _attitude(self, roll, pitch, yaw):
        """Columns are the boat's starboard, forward and up in the world."""
        (cr, sr), (cp, sp), (cy, sy) = (
            (mpmath.cos(mpmath.radians(a)), mpmath.sin(mpmath.radians(a))) for a in (roll, pitch, yaw)
        )
        heading = mpmath.matrix([[cy, sy, 0], [-sy, cy, 0], [0, 0, 1]])  # the bow to the east of north
        lifted = mpmath.matrix([[1, 0, 0], [0, cp, -sp], [0, sp, cp]])  # the bow up
        heeled = mpmath.matrix([[cr, 0, sr], [0, 1, 0], [-sr, 0, cr]])  # starboard down
        return heading * lifted * heeled

    def at(self, time: float):
        """Antennas' places, boresight, and roll, pitch, yaw."""
        p, t = self.platform, mpmath.mpf(time)

        def swing(name: str, amplitude: float):
            phase = 2 * mpmath.pi * t / mpmath.mpf(getattr(p, f"{name}_period_s"))
            return amplitude * mpmath.sin(phase + mpmath.radians(mpmath.mpf(getattr(p, f"{name}_phase_deg"))))

        roll, pitch, yaw = (
            mpmath.mpf(rest) + swing(name, amplitude)
            for name, rest, amplitude in (
                ("roll", p.list_deg, p.roll_deg),
                ("pitch", p.trim_deg, p.pitch_deg),
                ("yaw", p.heading_deg, p.yaw_deg),
            )
        )
        boat = self._attitude(roll, pitch, yaw)
        course, run = mpmath.radians(mpmath.mpf(p.heading_deg)), mpmath.mpf(p.speed_m_s) * t
        moved = mpmath.matrix([run * mpmath.sin(course), run * mpmath.cos(course), swing("heave", p.heave_m)])
        up = mpmath.matrix([0, 0, self.radar.height_m])
        origin = moved + boat * self.lever - self.rest + up
        scan = mpmath.radians(self.radar.sector_deg[0] + 6 * mpmath.mpf(self.radar.rotation_rpm) * t - p.heading_deg)
        lean = mpmath.radians(self.radar.tilt_deg)
        cs, ss, cl, sl = mpmath.cos(scan), mpmath.sin(scan), mpmath.cos(lean), mpmath.sin(lean)
        axes = mpmath.matrix([[cs, ss * cl, ss * sl], [-ss, cs * cl, cs * sl], [0, -sl, cl]])  # columns
        places = [origin + boat * (axes * mpmath.matrix(offset)) for offset in self.offsets]
        return places, boat * axes[:, 1], (roll, pitch, yaw)


def added(one: tuple, other: tuple) -> tuple:
    return tuple(mpmath.mpf(a) + mpmath.mpf(b) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize(("transmit", "interferogram"), MODES)
@pytest.mark.parametrize("antennas", [None, ANYWHERE], ids=["stacked", "anywhere"])
def test_phases_are_those_of_the_exact_paths(transmit: str, interferogram: str, antennas: list[dict] | None) -> None:
    # complex64 keeps an angle to 6e-8 rad, float64 paths of 240 m to 1e-11 rad; asked: 1e-6 rad.
    if antennas is not None and interferogram == "alternating_pulse":
        antennas = antennas[:2]  # such a mode takes two
    error = (0.004, -0.003, 0.002)  # of the last antenna's place: its phases have it, what is told of it has not
    radar: dict = {"transmit": transmit, "interferogram": interferogram}
    if antennas is None:
        radar["baseline_error_m"] = 0.01
        known = [(0.0, 0.0, -0.1), (0.0, 0.0, 0.1)]
        true = [(0, 0, -mpmath.mpf("0.105")), (0, 0, mpmath.mpf("0.105"))]
    else:
        radar["antennas"] = [*antennas[:-1], {**antennas[-1], "offset_error_m": error}]
        radar["antennas"] = [{**WIDE, **each} for each in radar["antennas"]]
        known = [each["offset_m"] for each in antennas]
        true = [*known[:-1], added(known[-1], error)]
    scene = scene_of(ROCKING, **radar)
    velocity = np.array([-2.0, 1.5, 0.3])
    k = 2 * mpmath.pi * mpmath.mpf(10**10) / mpmath.mpf(SPEED_OF_LIGHT)
    for place in ([12.0, 25.0, 0.4], [45.0, 110.0, -1.0]):
        echoes = from_scatterers(scene, [place], [10.0], velocity[None])
        with mpmath.workdps(40):
            seen, told = (ExactBoat(scene.radar, scene.platform, offsets) for offsets in (true, known))
            for pulse in (0, 1, 2, 101, echoes.sizes["pulse"] - 1):
                one = echoes.isel(pulse=pulse)
                places, boresight, attitude = seen.at(pulse / mpmath.mpf(10_000))
                known_places, _, _ = told.at(pulse / mpmath.mpf(10_000))
                exact = np.array([[float(part) for part in centre] for centre in known_places])
                np.testing.assert_allclose(one["position"].values, exact, rtol=0, atol=1e-12)
                np.testing.assert_allclose(one["attitude"].values, [float(a) for a in attitude], rtol=0, atol=1e-12)
                bearing = float(mpmath.degrees(mpmath.atan2(boresight[0], boresight[1])))
                assert abs(wrap_degrees(float(one["azimuth"]) - bearing)) < 1e-10
                where = mpmath.matrix(place) + pulse / mpmath.mpf(10_000) * mpmath.matrix(velocity.tolist())
                paths = [mpmath.norm(where - centre) for centre in places]
                volts = one["voltage"].values
                heard = np.flatnonzero(~np.isnan(volts[:, 0]))
                gate = int(np.abs(volts[heard[0]]).argmax())
                for receiver in heard:
                    phase = -k * (paths[int(one["transmitter"])] + paths[receiver])
                    apart = mpmath.mpf(float(np.angle(volts[receiver, gate].astype(complex)))) - phase + mpmath.pi
                    assert abs(float(apart % (2 * mpmath.pi) - mpmath.pi)) < 1e-6


def test_perfect_sensors_tell_the_truth_and_others_their_own() -> None:
    place = [[12.0, 25.0, 0.4]]
    exact = from_scatterers(scene_of(ROCKING), place, [10.0])
    biased = from_scatterers(
        scene_of({**ROCKING, "sensors": {"roll_bias_deg": 1.0, "height_bias_m": 0.5}}), place, 10.0
    )
    np.testing.assert_array_equal(exact["voltage"], biased["voltage"])  # what is heard does not care
    np.testing.assert_allclose(biased["attitude"] - exact["attitude"], [[1.0, 0.0, 0.0]] * 223, atol=1e-12)
    truth = mast_of(scene_of(ROCKING).radar, ROCKING).pose(exact["time"].values)
    np.testing.assert_array_equal(exact["position"], truth.positions)
    np.testing.assert_array_equal(exact["azimuth"], truth.bearing)


# ------------------------------------------------------------------------------------- the sum over nodes and columns

# A boat at rest leaves 2.3e-3 over 20 … 60 m, 1.3e-3 beyond 35 m (test_turn tells of what): moving ones are held to it.
UPRIGHT = {
    "heaving": {"motion": "sinusoidal", "heave_m": 0.5},
    "yawing": {"motion": "sinusoidal", "yaw_deg": 5.0},
    "running": {"speed_m_s": 5.0, "heading_deg": 60.0},
    "running away": {"speed_m_s": 5.0, "heading_deg": 202.0, "lever_arm_m": (0.4, -1.0, 4.7)},
    "pitching": {**ROLL_OF, "pitch_deg": 5.0},
    "rolling through upright": {**ROLL_OF, "roll_deg": 10.0},  # 0.27°/ms, at 1.4 m/s
}


@pytest.mark.parametrize("platform", UPRIGHT.values(), ids=UPRIGHT.keys())
def test_upright_fans_against_a_direct_sum(platform: dict) -> None:
    radar = radar_of()
    facets, rcs, fired = sea_seen(radar, platform)
    assert choose_nodes(facets, radar, fired, np.inf).stride >= 4
    found = turn_voltages(facets, rcs, Installation(radar), fired, SEED, np.inf)
    exact = direct_sum(facets, rcs, radar, fired)
    # The antennas' own flight taken as a constant radial velocity adds v²t²/2R: 4e-6 m, 2e-3 rad, at 5 m/s, 20 m, 2.5
    # ms.
    assert relative_rms(found, exact) < 4e-3
    assert relative_rms(found[..., 10:], exact[..., 10:]) < 2.5e-3
    product, true = (v[:, 0] * v[:, 1].conj() for v in (found, exact))
    assert abs(np.angle(np.sum(product * true.conj()))) < 4e-4


def test_gates_and_spreading_that_walk() -> None:
    # What is taken as it is when the beam passes a column: at 5 m/s a facet walks by 1 cm in the beam's 2.5 ms.
    radar = radar_of()
    facets, rcs, fired = sea_seen(radar, UPRIGHT["running"])
    found = turn_voltages(facets, rcs, Installation(radar), fired, SEED, np.inf)
    assert relative_rms(found, direct_sum(facets, rcs, radar, fired, walking=True)) < 8e-3


def test_leaning_fans_against_a_direct_sum() -> None:
    # The beam is laid on the mean sea in the middle of each gate. A fan that leans by ρ hears a facet that is z above
    # that, or r nearer, sin ρ (z + H r/R)/R off that azimuth: on a flat sea, ρ = 10°, within a gate's ±1.5 m 0.09° at
    # 40 m and 0.02° at 67 m, where 0.01° of a two-way beam 1.3° wide are one per cent of its voltage on the flank. Of
    # waves 0.5 m to either side 0.12° at 40 m.
    listing = {"list_deg": 10.0, "heading_deg": 22.0}

    def error(platform: dict, height_m: float, **radar) -> float:
        settings = radar_of(**radar)
        facets, rcs, fired = sea_seen(settings, platform, height_m=height_m)
        assert np.abs(fired.pose.axes[:, 0, 2]).max() > 0.03
        found = turn_voltages(facets, rcs, Installation(settings), fired, SEED, np.inf)
        return relative_rms(found, direct_sum(facets, rcs, settings, fired))

    assert error(listing, 0.0, range_m=(60.0, 75.0)) < 0.015
    assert error(listing, 0.0) < 0.06
    assert error({**listing, "list_deg": 2.0}, 1.0) < 0.03  # a fifth of what 10° do
    assert error(ROCKING, 1.0) < 0.15


@pytest.mark.parametrize(("heading", "brighter"), [(-68.0, True), (112.0, False)], ids=["starboard", "port"])
def test_a_fan_abeam_stays_upright_and_nods(heading: float, brighter: bool) -> None:
    # Starboard down, the beam to starboard points 10° down to where the sea is seen at 20 m 14° below the horizon.
    radar = radar_of()
    facets, rcs, fired = sea_seen(radar, {"list_deg": 10.0, "heading_deg": heading})
    found = turn_voltages(facets, rcs, Installation(radar), fired, SEED, np.inf)
    # ±2° of the sector are ±2° off abeam, where the fan leans by 0.35°: 0.004° on the waves at 40 m.
    assert relative_rms(found, direct_sum(facets, rcs, radar, fired)) < 0.02
    facets, rcs, fired = sea_seen(radar)
    level = turn_voltages(facets, rcs, Installation(radar), fired, SEED, np.inf)
    assert (np.mean(np.abs(found) ** 2) > np.mean(np.abs(level) ** 2)) == brighter


# --------------------------------------------------------------------------------------------------- bits and seams


# Rolling through upright when a turn ends; running, and so with another Doppler band and other nodes in every turn.
SEAM = {
    **ROLL_OF,
    "roll_deg": 10.0,
    "roll_period_s": 4.0,
    "roll_phase_deg": 90.0,
    "pitch_deg": 6.0,
    "pitch_period_s": 7.0,
    "heave_m": 0.4,
    "yaw_deg": 3.0,
    "speed_m_s": 3.0,
}


def _about_the_seam(first: Pulses, second: Pulses, before: int, after: int) -> Pulses:
    """The last pulses of a turn and the first of the next, as if they were one turn's."""
    names = ("number", "time", "azimuth", "transmitter", "slot")
    joined = {name: np.concatenate((getattr(first, name)[-before:], getattr(second, name)[:after])) for name in names}
    return replace(first, **joined, sweep=np.concatenate((first.sweep[-before:], 360.0 + second.sweep[:after])))


def _turns(decorrelation_time_s: float) -> tuple[RadarSettings, list[tuple], list[NDArray]]:
    radar = radar_of(sector_deg=(22.0, 382.0), range_m=(30.0, 60.0))
    seen = [sea_seen(radar, SEAM, turn) for turn in (0, 1)]
    return radar, seen, [turn_voltages(f, r, Installation(radar), p, SEED, decorrelation_time_s) for f, r, p in seen]


def test_turns_meet() -> None:
    # The direct sum goes on over the end of turn 0 with that turn's own mesh, which reaches three beams beyond it.
    radar, seen, found = _turns(np.inf)
    (facets, rcs, first), (_, _, second) = seen
    assert choose_nodes(facets, radar, first, np.inf).stride >= 4
    count = 6  # pulses, 0.2°: what the mesh does not reach then lies 50 dB down, two-way
    exact = direct_sum(facets, rcs, radar, _about_the_seam(first, second, count, count))
    across = np.concatenate((found[0][-count:], found[1][:count]))
    assert relative_rms(across[:count], exact[:count]) < 4e-3
    assert relative_rms(across[count:], exact[count:]) < 4e-3


@pytest.mark.parametrize(("decorrelation_time_s", "most"), [(np.inf, 1e-4), (0.01, 0.05), (0.003, 0.15)])
def test_speckle_goes_on_from_turn_to_turn(
    decorrelation_time_s: float, most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Turn 0 goes on for some pulses that are turn 1's, and has the voltages that turn 1 has: turns draw a column's
    # speckle from the same numbers, in modes of the same window while their fans lean about as much.
    if np.isinf(decorrelation_time_s):  # to what is missed between nodes, which lie elsewhere in each turn: to 2e-4
        monkeypatch.setattr(slow_time, "widest", lambda law, interval, share, _: widest(law, interval, share, 1))
    radar, seen, found = _turns(decorrelation_time_s)
    (facets, rcs, first), (_, _, second) = seen
    count = 6
    longer = _about_the_seam(first, second, first.number.size, count)
    going_on = turn_voltages(facets, rcs, Installation(radar), longer, SEED, decorrelation_time_s)
    assert relative_rms(found[1][:count], going_on[-count:]) < most
