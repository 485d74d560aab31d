"""What a scene's objects echo, what the sea hides of them, and both in the whole simulation, in every mode."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scenery_scenes import MODES, SPEED, Array, box, lit, places, scene, traced

from seamap_rt.compute import machine
from seamap_rt.conventions import SPEED_OF_LIGHT, from_db, unit_from_azimuth, wrap_degrees
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.echoes.scenery import Scenery
from seamap_rt.echoes.turn import turn_echoes
from seamap_rt.errors import InputError
from seamap_rt.interferometry import retrieve
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.radar.antenna import antenna
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.radar.waveform import RangeResponse, gates
from seamap_rt.scene import Scene, load_scene
from seamap_rt.session import simulate
from seamap_rt.simulation import Simulator
from seamap_rt.tracing.horizon import Skyline, trace_horizon
from validation.hard_cases.case import RadialSurface

# ------------------------------------------------------------------------------------------ what they echo


def loudness(made: Scene, turn: int = 0, draws: int = 1) -> tuple[Array, Array]:
    """Mean power (pulse, gate) of an object's own echo over pulses' receivers and the first seeds, and the pulses'
    azimuths."""
    mast = Installation(made.radar, made.platform)
    fired, grid = pulses(mast, turn), polar_grid(mast, made.tracing, turn)
    level = np.zeros((grid.sweep.size, grid.ground_range.size))
    mesh = surface_mesh(grid, level, np.zeros((*level.shape, 3), np.float32))
    power = np.zeros(1)
    for seed in range(draws):
        volts = Scenery(made.model_copy(update={"seed": seed}) if draws > 1 else made, mast).voltages(mesh, fired)
        assert volts is not None
        power = power + np.nanmean(np.abs(volts.astype(np.complex128)) ** 2, axis=1) / draws
    return power, fired.azimuth


def test_an_echo_by_the_radar_equation(tmp_path: Path) -> None:
    """Its place to a few centimetres, its mean power over draws, 15 m on, as a moving boat sees it."""
    size, east, north = 0.2, 10.0, 60.0
    # The turntable passes the start of its sector at the start of each turn.
    boat = 15.0 + 5.0 * 3.0 / 360.0
    level = np.hypot(east - boat, north)
    bearing = np.degrees(np.arctan2(east - boat, north)) % 360.0
    distance = np.hypot(level, 5.0 - 1.0)
    near = distance - 30.0  # so that a gate stands at its range
    keys: dict[str, Any] = {
        "thing": {"position_m": [east, north, 0.0], "rcs_dbsm": 10.0},
        "radar__sector_deg": [bearing - 3.0, bearing + 3.0],
        "radar__range_m": [near, near + 45.0],
        "turns": 4,
        **SPEED,
    }
    made = scene(box((size, size, size), (0.0, 0.0, 1.0)), tmp_path, **keys)
    power, azimuth = loudness(made, 3, draws=100)
    ranges = gates(made.radar)
    off = wrap_degrees(azimuth - bearing)
    total = power.sum()
    # The box's size and the pulses' spacing of 0.036°; half of 0.2 m at 60 m is 0.1°.
    assert (power.sum(axis=1) @ off) / total == pytest.approx(0.0, abs=0.1)
    assert (power.sum(axis=0) @ ranges) / total == pytest.approx(distance, abs=0.15)

    aerial, wavelength = antenna(made.radar), SPEED_OF_LIGHT / made.radar.frequency_hz
    pattern = float(aerial.elevation(np.array([-4.0 / distance]))[0]) ** 4
    response = float(RangeResponse.of(made.radar)(np.zeros(1))[0]) ** 2
    loss = from_db(made.radar.losses_db)
    expected = aerial.gain**2 * wavelength**2 * from_db(10.0) * pattern * response
    expected /= (4.0 * np.pi) ** 3 * distance**4 * loss
    gate = int(np.argmin(np.abs(ranges - distance)))
    pulse = int(np.argmin(np.abs(off)))
    # Power is exponential over the draws: 4 of 1/√100.
    assert power[pulse, gate] / expected == pytest.approx(1.0, abs=0.4)
    # It is heard where the beam looks, and nowhere else: two-way −3 dB at 0.65°.
    assert power[np.abs(off) > 2.2].max() < 1e-3 * power[pulse, gate]


def test_what_stands_under_water_echoes_nothing(tmp_path: Path) -> None:
    made = scene(box((2.0, 2.0, 2.0), (0.0, 40.0, -1.2)), tmp_path, thing={"rcs_dbsm": 30.0})
    power, _ = loudness(made)
    assert power.max() == 0.0
    before, after = traced(made)
    assert_array_equal(lit(before), lit(after))  # nor does it hide anything


def test_an_object_just_outside_the_sector_is_heard_through_the_beams_edge(tmp_path: Path) -> None:
    """Half a beam before the start and behind the end alike. It turns the same side to the antenna: the same draws."""
    loud = []
    for azimuth in (359.2, 20.8):
        east, north = (float(part) for part in unit_from_azimuth(azimuth))
        made = scene(
            box((0.1, 0.1, 0.1), (0.0, 0.0, 1.0)),
            tmp_path,
            thing={"position_m": [60.0 * east, 60.0 * north, 0.0], "rcs_dbsm": 10.0, "heading_deg": azimuth},
            radar__sector_deg=[0.0, 20.0],
        )
        loud.append(loudness(made, draws=20)[0].sum())
    # The first pulse lies on the sector's start, the last half a pulse before its end: at 10 % a pulse of the beam's
    # flank, 6 %. What the same draws leave (correlated by 0.986, in a mean of 20) is 3.5 %; four of that.
    assert loud[0] == pytest.approx(loud[1], rel=0.2)
    assert min(loud) > 0.0


@pytest.mark.parametrize(
    ("platform", "bearing", "sector"),
    [
        ({}, 0.0, [110.0, 130.0]),
        ({"platform__speed_m_s": 5.0}, 0.0, [110.0, 130.0]),
        ({"platform__pitch_deg": 10.0, "platform__roll_deg": 10.0}, 0.0, [110.0, 130.0]),
        ({"platform__pitch_deg": 10.0, "platform__roll_deg": 10.0}, -6.0, [0.0, 130.0]),  # begins abaft the beam
    ],
)
def test_the_boats_own_things_stay_at_their_range(
    platform: dict[str, Any], bearing: float, sector: list[float], tmp_path: Path
) -> None:
    """A point 20 m ahead on the bow's sprit: at its bearing and range off the bow, and the phase stands still."""
    swings = {"platform__motion": "sinusoidal"} if "platform__pitch_deg" in platform else {}
    right, ahead = unit_from_azimuth(bearing)
    made = scene(
        box((0.02, 0.02, 0.02), (0.0, 0.0, 2.0)),
        tmp_path,
        thing={"position_m": [20.0 * right, 20.0 * ahead, 0.0], "rcs_dbsm": 0.0, "fixed_to": "boat"},
        radar__sector_deg=sector,
        radar__transmit="single",
        platform__heading_deg=120.0,
        **platform,
        **swings,
    )
    simulator = Simulator(made)
    fired = pulses(simulator.installation, 0)
    volts = simulator.scenery.voltages(simulator.mesh(0), fired)
    assert volts is not None
    power = np.abs(volts[:, 0]) ** 2
    pulse, gate = np.unravel_index(power.argmax(), power.shape)
    # The swinging mast, its antennas 3 m over the point, may bear on it a little off the bow.
    off = wrap_degrees(fired.azimuth[pulse] - 120.0 - bearing)
    assert off == pytest.approx(0.0, abs=0.15 if not swings else 2.0)
    assert gates(made.radar)[gate] == pytest.approx(np.hypot(20.0, 3.0), abs=0.76)
    around = np.flatnonzero(power[:, gate] > 0.25 * power[pulse, gate])
    phase = np.unwrap(np.angle(volts[around, 0, gate]))
    # The beam's edge weighs the points of 20 mm differently: 0.08 rad, of a boat at rest too. Were it left behind by
    # one at 5 m/s, 5 ms would turn it by 2k·0.025 m = 10 rad. Its straight flight departs from the arc of a boat that
    # pitches at 12°/s by 20 m · (12°/s · 3 ms)²/2 = 4 µm.
    assert np.ptp(phase) < 0.2


# ------------------------------------------------------------------------------------------ what the sea hides of them


def waves(r: Array) -> Array:
    return 1.0 * np.cos(2.0 * np.pi * r / 35.0)


@pytest.mark.parametrize("sector", [[300.0, 420.0], [0.0, 360.0]])
def test_the_skyline_is_the_horizon_tracers(sector: list[float]) -> None:
    """Above the tangent over the crests before it a thing is seen, below it is not; and so are the facets' points."""
    made = load_scene("flat", {"radar.sector_deg": sector, "radar.range_m": [15.0, 250.0], "tracing.facet_m": 0.25})
    mesh = mesh_turn(RadialSurface(waves), made.radar, made.tracing, 0)
    skyline, facets = Skyline(mesh), trace_horizon(mesh)
    eye = np.array([0.0, 0.0, 4.9])
    fine = np.arange(1.0, 250.0, 0.01)

    def horizon(distance: float) -> float:
        nearer = fine[fine < distance]
        return 4.9 + distance * float(np.max((waves(nearer) - 4.9) / nearer))

    random = np.random.default_rng(3)
    for distance, azimuth in zip(
        random.uniform(30.0, 240.0, 60), random.uniform(sector[0], sector[1], 60), strict=True
    ):
        east, north = (float(part) for part in unit_from_azimuth(azimuth))
        tangent = horizon(distance)
        # The last rung before the thing may lie 0.25 m short of it, where the sea is 0.25 m · (0.18 + 5/30) lower.
        for above, seen in ((0.01, True), (-0.09, False)):
            place = np.array([[distance * east, distance * north, tangent + above]])
            assert skyline.sees(eye[None], place)[0] == seen, (distance, azimuth)

    column = facets.grid.columns // 2
    points = places(facets, np.zeros((facets.grid.columns, 3)))[column]
    margin = np.array([height - horizon(d) for d, height in zip(facets.distance, points[:, 2], strict=True)])
    sure = (margin < -0.09) | (lit(facets)[0, column] & (facets.slope_look[column] > -0.1))
    sure &= facets.distance > 2.0
    seen = skyline.sees(np.broadcast_to(eye, points.shape), points + np.array([0.0, 0.0, 0.01]))
    assert sure.mean() > 0.8
    assert_array_equal(seen[sure], lit(facets)[0, column][sure])


def test_beside_the_mesh_nothing_is_seen() -> None:
    made = load_scene("flat", {"radar.sector_deg": [0.0, 20.0], "radar.range_m": [15.0, 100.0]})
    mesh = mesh_turn(RadialSurface(np.zeros_like), made.radar, made.tracing, 0)
    azimuth = np.array([-8.0, -5.0, -0.3, 0.0, 10.0, 20.0, 25.0, 28.0, 180.0])
    east, north = unit_from_azimuth(azimuth)
    points = np.stack((50.0 * east, 50.0 * north, np.ones_like(east)), axis=1)
    seen = Skyline(mesh).sees(np.broadcast_to([0.0, 0.0, 5.0], points.shape), points)
    # The mesh runs on by three beams of 1.8° to either side, 5.4° and a column.
    assert_array_equal(seen, (azimuth > -6.0) & (azimuth < 26.0))


def test_a_crest_hides_a_buoy(tmp_path: Path) -> None:
    """A box 0.05 to 0.25 m over mean sea level, 130 m off. Over a crest of 0.67 m at 120 m the tangent passes it at
    0.3 m; with a trough there and the crest at 100 m, at −0.6 m."""
    echo = {}
    for phase in (0.0, 180.0):
        made = scene(
            box((0.5, 0.5, 0.2), (0.0, 0.0, 0.15)),
            tmp_path,
            name="sinusoid",
            thing={"position_m": [-130.0, 0.0, 0.0], "rcs_dbsm": 10.0},
            sea__waves__0__phase_deg=phase,
            radar__sector_deg=[265.0, 275.0],
            radar__range_m=[15.0, 150.0],
        )
        simulator = Simulator(made)
        crest = float(simulator.sea.elevation(np.array([-120.0]), np.zeros(1), np.zeros(1))[0])
        assert crest == pytest.approx(0.667 if phase == 0.0 else -0.667, abs=0.01)
        volts = simulator.scenery.voltages(simulator.mesh(0), pulses(Installation(made.radar), 0))
        assert volts is not None
        echo[phase] = np.abs(volts).max()
    assert echo[0.0] == 0.0
    assert echo[180.0] > 0.0


# ------------------------------------------------------------------------------------------ the whole simulation


@pytest.mark.parametrize(("transmit", "interferogram"), MODES)
def test_the_map_holds_no_echo_in_the_shadow(transmit: str, interferogram: str, tmp_path: Path) -> None:
    """A silent wall 6 m high, 15° wide: no sea behind it in the truth, and no height in the map, in any mode."""
    made = scene(
        box((10.0, 1.0, 12.0), (0.0, 0.0, 0.0)),
        tmp_path,
        thing={"position_m": [0.0, 38.0, 0.0]},
        radar__noise=True,
        radar__sector_deg=[335.0, 385.0],
        radar__range_m=[15.0, 80.0],
        radar__transmit=transmit,
        radar__interferogram=interferogram,
        scattering__nrcs_db=-25.0,
    )
    made_of = simulate(made)
    polar = made_of.truth["polar"].to_dataset()
    heights = retrieve(made_of.echoes, made.retrieval)["polar"].to_dataset()
    azimuth, ranges = wrap_degrees(polar["azimuth"].values), polar["range"].values
    # Cells of 1.8° and 3 m, and a beam that hears ±1° more and a pulse ±3 m.
    behind = (np.abs(azimuth)[:, None] < 3.0) & (ranges > 46.0)
    clear = (np.abs(azimuth)[:, None] > 10.0) | (ranges < 30.0)
    visible, quality = polar["visible_fraction"].values[0], heights["quality"].values[0]
    assert_array_equal(visible[behind], 0.0)
    assert_array_equal(visible[clear], 1.0)
    assert (quality[behind] & QUALITY_FLAGS["no_echo"] > 0).mean() > 0.95
    assert np.isnan(heights["height"].values[0][behind & (quality & QUALITY_FLAGS["no_echo"] > 0)]).all()
    assert not (quality[clear] & QUALITY_FLAGS["no_echo"]).any()
    assert np.isnan(polar["nrcs_db"].values[0][behind]).all()


@pytest.mark.parametrize(("transmit", "interferogram"), MODES)
def test_an_object_is_sampled_as_the_mode_samples(transmit: str, interferogram: str, tmp_path: Path) -> None:
    """Silent receivers are NaN, the others alike but for where the antennas are: every mode hears the same power."""
    made = scene(
        box((0.02, 0.02, 0.02), (0.0, 0.0, 1.0)),
        tmp_path,
        thing={"position_m": [0.0, 60.0, 0.0], "rcs_dbsm": 10.0},
        radar__sector_deg=[355.0, 365.0],
        radar__transmit=transmit,
        radar__interferogram=interferogram,
    )
    simulator = Simulator(made)
    fired = pulses(Installation(made.radar), 0)
    volts = simulator.scenery.voltages(simulator.mesh(0), fired)
    assert volts is not None
    sampled = np.isfinite(volts[:, :, 0])
    cycle = fired.number % 2
    for receiver in (0, 1):
        whole = interferogram == "single_pulse"
        assert_array_equal(sampled[:, receiver], np.ones_like(cycle, bool) if whole else cycle == receiver)
    power = np.nanmax(np.abs(volts), axis=(0, 2)) ** 2
    assert power[0] == pytest.approx(power[1], rel=0.05)
    # The path that a pulse takes: 60 m from the middle, ±0.1 m of height over 4 m of drop, 6.6 mm longer or shorter.
    peak = np.unravel_index(np.nanargmax(np.abs(volts[:, 0])), volts[:, 0].shape)
    pulse, gate = int(peak[0]), int(peak[1])
    even = pulse - pulse % 2
    other = even if interferogram == "single_pulse" else even + 1
    phase = np.angle(volts[even, 0, gate] * np.conj(volts[other, 1, gate]))
    k, out = 2.0 * np.pi / 0.0299792458, np.hypot(60.0, 4.1) - np.hypot(60.0, 3.9)
    ways = 2.0 if (transmit, interferogram) == ("switched", "alternating_pulse") else 1.0
    # V ~ exp(−jkR): the upper antenna is the farther one, by the box's own size of 20 mm in 60 m.
    assert np.angle(np.exp(1j * (phase - ways * k * out))) == pytest.approx(0.0, abs=0.01)


def test_threads_do_not_change_the_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = scene(
        box((1.0, 1.0, 4.0), (0.0, 0.0, 0.0)),
        tmp_path,
        thing={"position_m": [0.0, 40.0, 0.0], "rcs_dbsm": 20.0},
        radar__noise=True,
        radar__sector_deg=[355.0, 365.0],
        radar__range_m=[15.0, 60.0],
        **SPEED,
    )
    bits = []
    for count in (1, 2, 3):
        monkeypatch.setattr(machine, "threads", lambda count=count: count)
        simulator = Simulator(made)
        fired, mesh = pulses(simulator.installation, 0), simulator.mesh(0)
        facets, returns, _ = simulator.light(0, mesh=mesh)
        objects = simulator.scenery.voltages(mesh, fired)
        received = turn_echoes(facets, returns.rcs, Installation(made.radar), fired, 1, 0.01, returns.motion, objects)
        bits.append(received.voltage.tobytes())
    assert bits[0] == bits[1] == bits[2]


def test_an_object_and_the_sea_add_up(tmp_path: Path) -> None:
    """What the object echoes comes on top of what the sea does with the object in the way."""
    keys: dict[str, Any] = {"radar__sector_deg": [355.0, 365.0], "radar__range_m": [15.0, 60.0]}
    mesh, here = box((1.0, 1.0, 4.0), (0.0, 0.0, 0.0)), [0.0, 40.0, 0.0]
    loud = scene(mesh, tmp_path, thing={"position_m": here, "rcs_dbsm": 20.0}, **keys)
    silent = scene(mesh, tmp_path, thing={"position_m": here}, **keys)
    both, sea = (simulate(each).echoes["voltage"].values for each in (loud, silent))
    simulator = Simulator(loud)
    own = simulator.scenery.voltages(simulator.mesh(0), pulses(Installation(loud.radar), 0))
    assert own is not None
    assert_allclose(both, sea + own, atol=1e-6 * np.abs(both).max())
    assert np.abs(own).max() > 10.0 * np.abs(sea[:, :, -5:]).max()


# ------------------------------------------------------------------------------------------ refusals


@pytest.mark.parametrize(
    ("thing", "keys"),
    [
        ({"position_m": [0.0, 0.0, 0.0]}, {}),
        ({"position_m": [0.0, 0.0, 0.0], "fixed_to": "boat"}, {"platform__heading_deg": 77.0}),
        ({"position_m": [7.0, 0.0, 0.0]}, {**SPEED, "turns": 2}),  # it will be there after 1.4 s
    ],
    ids=["the world's", "the boat's", "in the boat's way"],
)
def test_an_object_about_the_antenna_is_refused(thing: dict[str, Any], keys: dict[str, Any], tmp_path: Path) -> None:
    made = scene(box((1.0, 1.0, 12.0), (0.0, 0.0, 0.0)), tmp_path, thing=thing, **keys)
    with pytest.raises(InputError, match=r"^objects\.0: encloses the antenna at .*; move it by objects\.0\.pos") as e:
        Simulator(made)
    assert "\n" not in str(e.value)


def test_a_broken_mesh_is_refused_in_one_line(tmp_path: Path) -> None:
    made = scene(box((1.0, 1.0, 1.0), (0.0, 40.0, 0.0)), tmp_path)
    (tmp_path / "thing.ply").write_text("no mesh at all")
    with pytest.raises(InputError, match=r"^objects\.0\.mesh = .*: is damaged") as e:
        Simulator(made)
    assert "\n" not in str(e.value)
