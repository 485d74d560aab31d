"""Boats and buoys in waves: limits, symmetries, resonance, signs, and what a file of Capytaine is read as."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.conventions import GRAVITY, unit_from_azimuth
from seamap_rt.errors import InputError
from seamap_rt.physics.dispersion import angular_frequency, wavenumber
from seamap_rt.prediction.vessel import Box, Disc, Follower, Responses, Vessel, read_capytaine

BOAT = Box(8.0, 2.8, 0.5)
BUOY = Disc(0.9, 0.3)
SPAR = Disc(1.0, 4.0)  # deep enough to resonate sharply
VESSELS = pytest.mark.parametrize("vessel", [Follower(), BOAT, BUOY], ids=["follower", "box", "disc"])
K = np.geomspace(0.02, 8.0, 40)  # rad/m: waves of 300 m to 0.8 m


def toward(azimuth_deg: float, k: NDArray[np.float64] = K) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    east, north = unit_from_azimuth(azimuth_deg)
    return k * east, k * north


def sigma(k: NDArray[np.float64] | float, depth: float = np.inf) -> NDArray[np.float64]:
    return angular_frequency(k, depth, surface_tension=0.0)


def moved(
    vessel: Vessel,
    azimuth_deg: float,
    heading_deg: float = 0.0,
    speed: float = 0.0,
    k: NDArray[np.float64] = K,
    depth: float = np.inf,
) -> Responses:
    """Motions in waves that run towards an azimuth, on still water."""
    return vessel.response(*toward(azimuth_deg, k), sigma(k, depth), heading_deg, speed, depth)


def each(responses: Responses) -> NDArray[np.complexfloating]:
    return np.array([responses.heave, responses.roll, responses.pitch])


# ------------------------------------------------------------------------------------------------ limits and signs


@VESSELS
@pytest.mark.parametrize("heading", [0.0, 70.0, 215.0])
@pytest.mark.parametrize("wave", [0.0, 33.0, 90.0, 160.0, 250.0])
def test_a_boat_lies_on_a_long_wave_as_its_ends_and_sides_do(vessel: Vessel, heading: float, wave: float) -> None:
    # 2 km long: k T is 0.0016, roll's (ω/ω₀)² 0.004 and its share of damping 0.012.
    k = np.array([2.0 * np.pi / 2000.0])
    kx, ky = toward(wave, k)
    bow, starboard = unit_from_azimuth(heading), unit_from_azimuth(heading + 90.0)

    def elevation(place: tuple[NDArray[np.float64], NDArray[np.float64]], metres: float) -> NDArray[np.complex128]:
        return np.exp(1j * metres * (kx * place[0] + ky * place[1]))

    response = moved(vessel, wave, heading, k=k)
    bow_up = (elevation(bow, 1.0) - elevation(bow, -1.0)) / 2.0
    starboard_down = (elevation(starboard, -1.0) - elevation(starboard, 1.0)) / 2.0
    np.testing.assert_allclose(response.heave, 1.0, atol=0.002)
    np.testing.assert_allclose(response.pitch, bow_up, atol=0.02 * k[0])
    np.testing.assert_allclose(response.roll, starboard_down, atol=0.02 * k[0])


@pytest.mark.parametrize("vessel", [BOAT, BUOY, SPAR], ids=["box", "disc", "spar"])
def test_short_waves_do_not_move_it(vessel: Vessel) -> None:
    k = 2.0 * np.pi / np.array([0.08, 0.05])  # a tenth of the buoy and less
    for azimuth in (0.0, 45.0, 90.0):
        heave, roll, pitch = np.abs(each(moved(vessel, azimuth, k=k)))
        assert np.all(heave < 0.01)
        assert np.all(np.hypot(roll, pitch) < 0.02 * k)


@VESSELS
def test_ground_that_no_wave_feels_changes_nothing(vessel: Vessel) -> None:
    for depth in (400.0, 1e300):  # tanh(k h) is 1 to 1e-7 at the longest wave
        np.testing.assert_allclose(each(moved(vessel, 30.0, depth=depth)), each(moved(vessel, 30.0)), rtol=1e-6)


def test_the_pressure_falls_off_less_in_shallow_water() -> None:
    k, depth = np.array([0.1, 0.5, 1.0]), 2.0
    shallow = BOAT.response(k, 0.0, sigma(k), 0.0, 0.0, depth)
    deep = BOAT.response(k, 0.0, sigma(k), 0.0, 0.0)  # as often met, so that roll itself is the same
    keel = np.cosh(k * (depth - 0.5)) / np.cosh(k * depth)
    np.testing.assert_allclose(shallow.roll / deep.roll, keel * np.exp(k * 0.5), rtol=1e-12)
    aground = BOAT.response(k, 0.0, sigma(k), 0.0, 0.0, 0.3)
    np.testing.assert_allclose(aground.roll / deep.roll, np.exp(k * 0.5) / np.cosh(k * 0.3), rtol=1e-12)


# ------------------------------------------------------------------------------------------------------ symmetries


@VESSELS
@pytest.mark.parametrize("speed", [0.0, 6.0])
def test_port_and_starboard_differ_in_rolls_sign_alone(vessel: Vessel, speed: float) -> None:
    heading = 40.0
    one, other = (moved(vessel, heading + turn, heading, speed) for turn in (65.0, -65.0))
    np.testing.assert_allclose(each(other), each(one) * np.array([[1.0], [-1.0], [1.0]]), atol=1e-12)
    assert np.abs(one.roll).max() > 0.1


@VESSELS
def test_at_rest_a_sea_from_ahead_is_one_from_astern_with_pitch_the_other_way(vessel: Vessel) -> None:
    ahead, astern = moved(vessel, 180.0), moved(vessel, 0.0)
    np.testing.assert_allclose(each(ahead), each(astern) * np.array([[1.0], [1.0], [-1.0]]), atol=1e-12)
    assert np.abs(ahead.pitch).max() > 0.05


@VESSELS
def test_the_sea_abeam_does_not_pitch_and_the_sea_ahead_does_not_roll_it(vessel: Vessel) -> None:
    abeam, ahead = moved(vessel, 300.0, 30.0), moved(vessel, 210.0, 30.0)
    assert np.abs(abeam.pitch).max() < 1e-13 < 0.05 < np.abs(abeam.roll).max()
    assert np.abs(ahead.roll).max() < 1e-13 < 0.05 < np.abs(ahead.pitch).max()


def test_a_wave_as_long_as_the_box_along_it_neither_heaves_nor_rolls_it() -> None:
    ahead = 2.0 * np.pi / BOAT.length_m
    for starboard in (0.3, 0.8):
        k = np.hypot(ahead, starboard)
        response = BOAT.response(starboard, ahead, sigma(k), 0.0, 0.0)
        assert np.abs(response.heave) < 1e-12
        assert np.abs(response.roll) < 1e-12
        assert np.abs(response.pitch) > 0.02


@VESSELS
def test_waves_and_heading_turn_together(vessel: Vessel) -> None:
    one, other = moved(vessel, 20.0, 75.0, 4.0), moved(vessel, 20.0 + 123.0, 75.0 + 123.0, 4.0)
    np.testing.assert_allclose(each(other), each(one), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("small", "large"),
    [
        (Box(2.0, 0.7, 0.15), Box(32.0, 11.2, 2.4)),
        (Box(2.0, 0.7, 0.3, 0.6, metacentric_height_m=0.1), Box(32.0, 11.2, 4.8, 0.6, metacentric_height_m=1.6)),
        (Box(2.0, 0.7, 0.15, roll_period_s=1.5), Box(32.0, 11.2, 2.4, roll_period_s=6.0)),
        (Disc(0.5, 0.2), Disc(8.0, 3.2)),
    ],
)
def test_a_model_moves_as_the_boat_by_froudes_law(small: Vessel, large: Vessel) -> None:
    scale = 16.0
    model, boat = moved(small, 130.0, 10.0, 1.0, k=K), moved(large, 130.0, 10.0, 4.0, k=K / scale)
    np.testing.assert_allclose(model.heave, boat.heave, rtol=1e-9)
    np.testing.assert_allclose(model.roll, scale * boat.roll, rtol=1e-9)
    np.testing.assert_allclose(model.pitch, scale * boat.pitch, rtol=1e-9)


def test_the_shape_of_the_waves_is_kept() -> None:
    k = np.full((3, 1), 0.3)
    for vessel in (Follower(), BOAT, BUOY):
        response = vessel.response(k, np.zeros((1, 4)), 1.0, 0.0, 0.0)
        assert [part.shape for part in (response.heave, response.roll, response.pitch)] == 3 * [(3, 4)]
        assert np.iscomplexobj(response.heave)


# ------------------------------------------------------------------------------------------- resonance and encounter


def test_heave_resonates_at_the_discs_own_period() -> None:
    # Water under a column of draught T weighs with the added mass of 4/3 ρ a³ as much as T + 4a/3π of it.
    period = 2.0 * np.pi * np.sqrt((4.0 + 4.0 / (3.0 * np.pi) * 0.5) / GRAVITY)
    assert SPAR.heave_period_s == pytest.approx(period, rel=1e-12)
    omega = np.linspace(0.8, 1.2, 4001) * 2.0 * np.pi / period
    heave = moved(SPAR, 0.0, k=omega**2 / GRAVITY).heave
    top = int(np.argmax(np.abs(heave)))
    assert omega[top] * period / (2.0 * np.pi) == pytest.approx(1.0, abs=0.003)
    assert np.abs(heave[top]) > 10.0
    assert np.angle(heave[top]) == pytest.approx(np.pi / 2.0, abs=0.3)  # the motion lags by a quarter period


def test_at_resonance_heave_radiates_what_the_wave_brings() -> None:
    # Haskind and the balance of energy: |X| = |F|/(ω B) = 2 ρ g²/(ω² k |F|), F = ρ g π a² e^{−kT} 2J₁(ka)/(ka).
    omega = 2.0 * np.pi / SPAR.heave_period_s
    k = omega**2 / GRAVITY
    mean = 1.0 - (0.5 * k) ** 2 / 8.0  # to (ka)⁴/192
    force = GRAVITY * np.pi * 0.25 * np.exp(-4.0 * k) * mean
    added = 1.0 - k * 4.0 / (3.0 * np.pi) * 0.5  # the force on the added mass, by relative motion
    heave = moved(SPAR, 0.0, k=np.array([k])).heave[0]
    assert abs(heave) == pytest.approx(2.0 * GRAVITY**2 / (omega**2 * k * force) * added, rel=1e-3)


@pytest.mark.parametrize("azimuth", [180.0, 0.0])
def test_a_boat_under_way_resonates_at_the_frequency_it_meets(azimuth: float) -> None:
    speed = 1.0
    k = np.linspace(0.05, 0.45, 4001)
    met = sigma(k) - speed * k * np.cos(np.radians(azimuth))
    top = int(np.argmax(np.abs(moved(SPAR, azimuth, 0.0, speed, k).heave)))
    assert met[top] * SPAR.heave_period_s / (2.0 * np.pi) == pytest.approx(1.0, abs=0.01)


def test_roll_resonates_at_its_period_and_lags_the_wave_whichever_overtakes() -> None:
    boat = Box(8.0, 2.8, 0.5, roll_period_s=5.0, roll_damping=0.03)  # too slow to send out waves
    k = np.linspace(0.1, 0.3, 2001)
    amplification = moved(boat, 90.0, k=k).roll / (-1j * k)
    top = int(np.argmax(np.abs(amplification)))
    assert sigma(k)[top] * 5.0 / (2.0 * np.pi) == pytest.approx(1.0, abs=0.01)
    assert np.abs(amplification[top]) > 10.0
    quartering = K * np.cos(np.pi / 4.0)
    for speed in (0.0, 8.0, 15.0):
        met = sigma(K) - speed * quartering
        lag = np.imag(moved(boat, 45.0, 0.0, speed).roll / (-1j * quartering * np.sign(met)))
        longer_than_the_boat = 0.5 * 8.0 * quartering < np.pi  # in shorter waves the mean wave changes its sign
        assert np.all(lag[longer_than_the_boat] > 0.0)
    assert np.any(met < 0.0)


def test_heave_lags_waves_that_the_boat_overtakes_too() -> None:
    own = 2.0 * np.pi / SPAR.heave_period_s
    k = np.array([0.4])
    speed = float((sigma(k)[0] + own) / k[0])  # met at −own
    heave = moved(SPAR, 0.0, 0.0, speed, k).heave[0]
    assert abs(heave) > 5.0
    assert np.angle(heave) == pytest.approx(-np.pi / 2.0, abs=0.3)


@pytest.mark.parametrize("draught", [0.8, 0.5, 0.28, 0.2])
def test_no_wave_throws_a_boat_out_of_the_water(draught: float) -> None:
    # Beam over draught 3.5 to 14: the waves that it sends out damp each, the less the flatter it is.
    k = np.geomspace(0.02, 8.0, 300)
    for speed, most in ((0.0, 1.6), (3.0, 2.0), (12.0, 4.0)):
        for azimuth in np.arange(0.0, 181.0, 15.0):
            response = moved(Box(8.0, 2.8, draught, metacentric_height_m=1.0), azimuth, 0.0, speed, k)
            assert np.abs(response.heave).max() < most
            assert np.all(np.abs(response.pitch) < most * k)
            assert np.all(np.abs(response.roll) < 5.0 * k)  # 1/(2 · 0.1) at resonance


@VESSELS
def test_a_wave_that_keeps_up_with_the_boat_is_finite(vessel: Vessel) -> None:
    k = np.array([0.0, 0.5, 0.5 * (1.0 + 1e-12)])
    speed = float(sigma(0.5) / 0.5)
    assert np.isfinite(each(moved(vessel, 0.0, 0.0, speed, k))).all()
    assert moved(vessel, 0.0, k=k).heave[0] == pytest.approx(1.0)


# ------------------------------------------------------------------------------------------------------- the paper


@pytest.mark.parametrize("speed", [0.0, 3.0])
@pytest.mark.parametrize("angle", [180.0, 140.0, 60.0])
def test_heave_and_pitch_are_those_of_the_paper(speed: float, angle: float) -> None:
    # Jensen, Mansour & Olsen (2004) in their own symbols; angle 180° is a head sea.
    length, beam, draught, block = 8.0, 2.8, 0.5, 0.7
    k = np.geomspace(0.05, 1.2, 30)
    cosine = np.cos(np.radians(angle))
    alpha = 1.0 - speed / np.sqrt(GRAVITY * length) * np.sqrt(k * length) * cosine
    broad = beam * block
    sent = 2.0 * np.sin(k * broad * alpha**2 / 2.0) * np.exp(-k * draught * alpha**2)
    f = np.sqrt((1.0 - k * draught) ** 2 + (sent**2 / (k * broad * alpha**3)) ** 2)
    eta = 1.0 / np.sqrt((1.0 - 2.0 * k * draught * alpha**2) ** 2 + (sent**2 / (k * broad * alpha**2)) ** 2)
    s = np.abs(k * cosine) * length / 2.0
    smith = np.exp(-k * draught)
    heave = smith * f * np.sin(s) / s * eta
    pitch = smith * f * 6.0 / (length * s**2) * (np.sin(s) - s * np.cos(s)) * eta
    held = k * broad * alpha**2 < np.pi  # short of the sine's top
    assert np.count_nonzero(held) > 20
    response = moved(Box(length, beam, draught, block), angle, 0.0, speed, k)
    np.testing.assert_allclose(np.abs(response.heave)[held], np.abs(heave)[held], rtol=1e-9)
    np.testing.assert_allclose(np.abs(response.pitch)[held], np.abs(pitch)[held], rtol=1e-9)


@pytest.mark.parametrize(
    ("draught", "a", "b", "d"), [(0.7, 0.738, -2.99, -1.287), (1.4, 5.81, -6.13, -5.65), (0.2, 1.25, -3.21, -1.221)]
)
def test_roll_is_damped_as_in_the_paper(draught: float, a: float, b: float, d: float) -> None:
    # At resonance roll is moment over ω B₄₄; B/T = 4, 2 and 14, which counts as 6.
    beam, height, added = 2.8, 0.9, 0.05
    boat = Box(8.0, beam, draught, metacentric_height_m=height, roll_damping=added)
    omega = 2.0 * np.pi * np.sqrt(height) / (0.8 * beam)
    assert boat.natural_roll_s == pytest.approx(2.0 * np.pi / omega)
    k = omega**2 / GRAVITY
    x, beat = 0.5 * k * beam, omega * np.sqrt(beam / (2.0 * GRAVITY))
    tilting = k * np.exp(-k * draught) * 3.0 * (np.sin(x) - x * np.cos(x)) / x**3  # moment over stiffness
    inviscid = beam**2 * np.sqrt(2.0 * GRAVITY / beam) * a * np.exp(b * beat**-1.3) * beat**d / (GRAVITY * height)
    roll = moved(boat, 90.0, k=np.array([k])).roll[0]
    assert roll == pytest.approx(tilting / (omega * inviscid + 2.0 * added), rel=1e-9)


@pytest.mark.parametrize("ratio", [4.0, 5.0, 6.0])
def test_rolls_damping_and_moment_belong_to_one_hull(ratio: float) -> None:
    # Haskind in two dimensions, M² = ρ g² b₄₄/ω: by it the paper's fit gives the moment of a box of that stiffness, to
    # a factor of 1.8 in a hull that is not flat, whose sway, left out here, takes part. Rad/s in the fit give 2.6.
    beam, length = 2.8, 8.0
    height = beam * (ratio / 12.0 - 0.5 / ratio)
    for beat in (0.8, 1.0, 1.2):
        omega = beat * np.sqrt(2.0 * GRAVITY / beam)
        boat = Box(length, beam, beam / ratio, 1.0, 2.0 * np.pi / omega, height, 0.0)
        k = np.array([omega**2 / GRAVITY])
        roll = np.abs(moved(boat, 90.0, k=k).roll[0])
        lever = 0.5 * k[0] * beam
        tilting = k[0] * np.exp(-k[0] * beam / ratio) * 3.0 * (np.sin(lever) - lever * np.cos(lever)) / lever**3
        stiffness = GRAVITY * beam * beam / ratio * height  # of a metre of the box, over ρ
        damping = tilting * stiffness / (omega * roll)
        assert 0.9 < np.sqrt(GRAVITY**2 * damping / omega) / (stiffness * tilting) < 1.9


def test_stability_is_the_boxs_own_unless_given() -> None:
    assert BOAT.stability_m == pytest.approx(2.8**2 / (12.0 * 0.5) - 0.25)
    assert BOAT.natural_roll_s == pytest.approx(0.8 * 2.8 / np.sqrt(BOAT.stability_m))
    assert Box(8.0, 2.8, 0.5, roll_period_s=4.0).stability_m == pytest.approx((0.8 * 2.8 / 4.0) ** 2)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf])
@pytest.mark.parametrize("name", ["length_m", "beam_m", "draught_m", "roll_period_s", "metacentric_height_m", "block"])
def test_a_boxs_size_is_refused(name: str, bad: float) -> None:
    with pytest.raises(ValueError, match=rf"^{name} = {bad:g}: must be .*above 0.*; give") as refusal:
        Box(**{"length_m": 8.0, "beam_m": 2.8, "draught_m": 0.5, name: bad})
    assert str(refusal.value).isprintable()


def test_other_bad_input_is_refused() -> None:
    for name in ("diameter_m", "draught_m"):
        with pytest.raises(ValueError, match=rf"^{name} = -2: must be finite and above 0; give it in metres$"):
            Disc(**{"diameter_m": 1.0, "draught_m": 0.3, name: -2.0})
    with pytest.raises(ValueError, match=r"^block = 1.2: must be above 0 and at most 1"):
        Box(8.0, 2.8, 0.5, 1.2)
    with pytest.raises(ValueError, match=r"^roll_damping = -0.1: must be finite and at least 0"):
        Box(8.0, 2.8, 0.5, roll_damping=-0.1)
    with pytest.raises(ValueError, match=r"^draught_m = 3: a box of beam 2.8 m capsizes.*give metacentric_height_m"):
        Box(8.0, 2.8, 3.0)
    for vessel in (Follower(), BOAT, BUOY):
        with pytest.raises(ValueError, match=r"^heading_deg = nan: must be finite"):
            moved(vessel, 0.0, np.nan)
        with pytest.raises(ValueError, match=r"^speed_m_s = inf: must be finite"):
            moved(vessel, 0.0, 0.0, np.inf)
        with pytest.raises(ValueError, match=r"^depth: must be positive"):
            vessel.response(K, 0.0, sigma(K), 0.0, 0.0, 0.0)


# ------------------------------------------------------------------------------------------------ files of Capytaine

FREQUENCIES = np.array([0.4, 0.7, 1.1, 1.6, 2.3])
DIRECTIONS = np.radians(np.arange(0.0, 360.0, 30.0))
DOFS = ("Surge", "Heave", "Roll", "Pitch")
ROLL, PITCH = DOFS.index("Roll"), DOFS.index("Pitch")


def file(force: NDArray[np.generic], mass: NDArray, stiffness: NDArray, added: NDArray, damping: NDArray) -> xr.Dataset:
    """As Capytaine's separate_complex_values leaves it; arrays over (omega, direction, dof) and (omega, dof, dof)."""
    pair = ("influenced_dof", "radiating_dof")
    split = np.array([force.real, force.imag])
    dims = ("complex", "omega", "wave_direction", "influenced_dof")
    return xr.Dataset(
        {
            "added_mass": (("omega", *pair), added),
            "radiation_damping": (("omega", *pair), damping),
            "diffraction_force": (dims, 0.25 * split),
            "Froude_Krylov_force": (dims, 0.75 * split),
            "inertia_matrix": (pair, mass),
            "hydrostatic_stiffness": (pair, stiffness),
        },
        coords={
            "omega": FREQUENCIES,
            "wave_direction": DIRECTIONS,
            "influenced_dof": list(DOFS),
            "radiating_dof": list(DOFS),
            "complex": ["re", "im"],
            "water_depth": np.inf,
            "forward_speed": 0.0,
            "g": GRAVITY,
            "wavenumber": ("omega", FREQUENCIES**2 / GRAVITY),
        },
    )


def saved(dataset: xr.Dataset, folder: Path) -> Vessel:
    path = folder / "boat.nc"
    dataset.to_netcdf(path, engine="h5netcdf")
    return read_capytaine(path)


def boat_file() -> xr.Dataset:
    """A boat whose degrees of freedom act on each other, with coefficients that change with frequency."""
    random = np.random.default_rng(7)
    size, count = len(DOFS), FREQUENCIES.size
    shape = (count, size, size)
    mass = np.diag([900.0, 900.0, 800.0, 3000.0])
    stiffness = np.diag([0.0, 4e4, 9e3, 5e4])
    stiffness[1, 3] = stiffness[3, 1] = -2e3
    coupling = random.normal(size=shape) * 60.0
    added = np.diag([100.0, 1500.0, 300.0, 4000.0]) * (1.0 + 0.3 * np.cos(FREQUENCIES))[:, None, None]
    damping = np.diag([50.0, 2500.0, 400.0, 5000.0]) * FREQUENCIES[:, None, None]
    added, damping = added + coupling, damping + 0.2 * coupling  # not symmetric, so that rows are no columns
    force = random.normal(size=(count, DIRECTIONS.size, size, 2)) @ np.array([1.0, 1j]) * 2e4
    return file(force, mass, stiffness, added, damping)


def raft_file() -> xr.Dataset:
    """A raft without mass in Capytaine's axes, x to the bow, y to port: its force is stiffness times the surface."""
    k = (FREQUENCIES**2 / GRAVITY)[:, None]
    stiffness = np.diag([0.0, 4e4, 9e3, 5e4])
    force = np.zeros((FREQUENCIES.size, DIRECTIONS.size, len(DOFS)), dtype=np.complex128)
    force[..., 1] = stiffness[1, 1]
    force[..., 2] = stiffness[2, 2] * 1j * k * np.sin(DIRECTIONS)  # a turn about x: the port side up
    force[..., 3] = -stiffness[3, 3] * 1j * k * np.cos(DIRECTIONS)  # a turn about y, to port: the bow down
    nothing = np.zeros((FREQUENCIES.size, len(DOFS), len(DOFS)))
    return file(force, np.diag([1e3, 0.0, 0.0, 0.0]), stiffness, nothing, nothing)


def direct(data: xr.Dataset, row: int, column: int) -> NDArray[np.complex128]:
    """Heave, roll and pitch of the file's own frequency and direction, in the axes of this project."""
    omega = FREQUENCIES[row]
    force = data["diffraction_force"] + data["Froude_Krylov_force"]
    force = force.isel(omega=row, wave_direction=column).to_numpy()
    mass = data["inertia_matrix"].to_numpy() + data["added_mass"].to_numpy()[row]
    matrix = data["hydrostatic_stiffness"].to_numpy() - omega**2 * mass
    motions = np.linalg.solve(matrix - 1j * omega * data["radiation_damping"].to_numpy()[row], force[0] + 1j * force[1])
    return motions[1:] * np.array([1.0, 1.0, -1.0])


@pytest.mark.parametrize("heading", [0.0, 200.0])
def test_a_raft_from_a_file_follows_the_surface(tmp_path: Path, heading: float) -> None:
    # Straight at the file's directions and frequencies, so that nothing lies between.
    raft = saved(raft_file(), tmp_path)
    for column in range(DIRECTIONS.size):
        azimuth = heading - np.degrees(DIRECTIONS[column])  # anticlockwise from the bow
        k = FREQUENCIES**2 / GRAVITY
        got, want = (each(moved(vessel, azimuth, heading, k=k)) for vessel in (raft, Follower()))
        np.testing.assert_allclose(got, want, atol=1e-6)


def test_long_waves_go_on_below_the_file_and_short_ones_end_with_it(tmp_path: Path) -> None:
    raft = saved(raft_file(), tmp_path)
    for depth in (np.inf, 20.0):
        below = wavenumber(FREQUENCIES[0], depth, surface_tension=0.0) * np.array([0.0, 1e-6, 0.3, 0.99])
        got = each(moved(raft, 60.0, 0.0, k=below, depth=depth))
        scale = np.maximum(below, 1e-12) * FREQUENCIES[0] ** 2 / GRAVITY
        scale /= wavenumber(FREQUENCIES[0], depth, surface_tension=0.0)
        slope = 1j * scale * np.array([-np.sin(np.radians(60.0)), np.cos(np.radians(60.0))])[:, None]
        np.testing.assert_allclose(got[0], 1.0, rtol=1e-6)
        np.testing.assert_allclose(got[1:], slope, atol=1e-6)
    above = np.array([1.0001, 3.0]) * FREQUENCIES[-1] ** 2 / GRAVITY
    assert np.all(each(moved(raft, 60.0, k=above)) == 0.0)


def test_a_file_of_one_degree_alone_gives_the_oscillators_response(tmp_path: Path) -> None:
    m, a, b, c, f = 1200.0, 700.0, 900.0, 3000.0, 2500.0 - 400.0j
    size, count = len(DOFS), FREQUENCIES.size
    diagonal = np.broadcast_to(np.eye(size), (count, size, size))
    force = np.full((count, DIRECTIONS.size, size), f)
    data = file(force, m * np.eye(size), c * np.eye(size), a * diagonal, b * diagonal)
    got = moved(saved(data, tmp_path), 0.0, k=FREQUENCIES**2 / GRAVITY)
    want = f / (c - FREQUENCIES**2 * (m + a) - 1j * FREQUENCIES * b)
    np.testing.assert_allclose(each(got), want * np.array([[1.0], [1.0], [-1.0]]), rtol=1e-6)


@pytest.mark.parametrize("shuffled", [False, True])
def test_coupled_motions_of_a_file_solve_its_equations(tmp_path: Path, shuffled: bool) -> None:
    data = boat_file()
    vessel = saved(
        data.isel(
            omega=[3, 1, 0, 4, 2],
            wave_direction=np.roll(np.arange(12), 5),
            influenced_dof=[2, 0, 3, 1],
            radiating_dof=[1, 3, 2, 0],
        ).transpose("wave_direction", "radiating_dof", "omega", "influenced_dof", "complex")
        if shuffled
        else data,
        tmp_path,
    )
    heading = 25.0
    for row, column in ((0, 0), (2, 5), (4, 11), (1, 7)):
        azimuth = heading - np.degrees(DIRECTIONS[column])
        k = FREQUENCIES[row : row + 1] ** 2 / GRAVITY
        got = each(moved(vessel, azimuth, heading, k=k))[:, 0]
        np.testing.assert_allclose(got, direct(data, row, column), rtol=1e-6)


def test_between_the_files_frequencies_and_directions_all_is_linear(tmp_path: Path) -> None:
    data = boat_file()
    vessel = saved(data, tmp_path)
    part, turn = 0.3, 0.8
    omega = (1.0 - part) * FREQUENCIES[1] + part * FREQUENCIES[2]
    between = data.isel(omega=[1, 2]).interp(omega=[omega])
    last = between.isel(wave_direction=11) * (1.0 - turn) + between.isel(wave_direction=0) * turn  # over the bow
    force = (last["diffraction_force"] + last["Froude_Krylov_force"]).isel(omega=0).to_numpy()
    mass = between["inertia_matrix"].to_numpy() + between["added_mass"].to_numpy()[0]
    damping = between["radiation_damping"].to_numpy()[0]
    matrix = between["hydrostatic_stiffness"].to_numpy() - omega**2 * mass - 1j * omega * damping
    want = np.linalg.solve(matrix, force[0] + 1j * force[1])[1:] * np.array([1.0, 1.0, -1.0])
    got = each(moved(vessel, -(330.0 + 30.0 * turn), k=np.array([omega**2 / GRAVITY])))[:, 0]
    np.testing.assert_allclose(got, want, rtol=1e-6)


def test_a_boat_of_a_file_under_way_has_the_waves_force_at_the_frequency_it_meets(tmp_path: Path) -> None:
    data = boat_file()
    vessel = saved(data, tmp_path)
    k = FREQUENCIES[1] ** 2 / GRAVITY
    for met, row in ((FREQUENCIES[2], 2), (-FREQUENCIES[0], 0)):  # the second overtakes the waves
        speed = (FREQUENCIES[1] - met) / k  # straight along
        force = (data["diffraction_force"] + data["Froude_Krylov_force"]).isel(omega=1, wave_direction=0).to_numpy()
        mass = data["inertia_matrix"].to_numpy() + data["added_mass"].to_numpy()[row]
        matrix = data["hydrostatic_stiffness"].to_numpy() - met**2 * mass
        matrix = matrix - 1j * met * data["radiation_damping"].to_numpy()[row]
        want = np.linalg.solve(matrix, force[0] + 1j * force[1])[1:] * np.array([1.0, 1.0, -1.0])
        got = each(moved(vessel, 0.0, 0.0, speed, np.array([k])))[:, 0]
        np.testing.assert_allclose(got, want, rtol=1e-6)
    still = moved(vessel, 0.0, 0.0, FREQUENCIES[1] / k, np.array([k]))  # the wave keeps up with the boat
    assert np.isfinite(each(still)).all()


def test_a_file_is_refused_in_one_line_that_says_what_it_lacks(tmp_path: Path) -> None:
    good = boat_file()
    without_roll = good.sel(influenced_dof=["Surge", "Heave", "Pitch"], radiating_dof=["Surge", "Heave", "Pitch"])
    half = good.sel(wave_direction=slice(0.0, np.pi + 0.01))
    blank = good.copy(deep=True)
    blank["inertia_matrix"][0, 0] = np.nan
    at_zero = good.assign_coords(omega=[0.0, *FREQUENCIES[1:]])
    cases = {
        r"lacks Roll among its degrees of freedom \(Surge, Heave, Pitch\); compute": without_roll,
        r"lacks Heave, Roll, Pitch among its degrees of freedom \(none\)": good.drop_vars("radiating_dof")[["omega"]],
        r"has no inertia_matrix; save the whole dataset": good.drop_vars("inertia_matrix"),
        r"has no diffraction_force; save": good.drop_vars("diffraction_force"),
        r"added_mass has dims period, .*: must be omega,": good.rename(omega="period"),
        r"added_mass has dims water_depth, .*: must be": good.assign(
            added_mass=good["added_mass"].expand_dims("water_depth")
        ),
        r"Froude_Krylov_force has dims .*: must be complex,": good.assign(
            Froude_Krylov_force=good["Froude_Krylov_force"].sel(complex="re", drop=True)
        ),
        r"inertia_matrix holds what is no number; leave": blank,
        r"omega holds 0 rad/s or one twice; compute": at_zero,
        r"wave_direction leaves out 180°: must be at most 45° apart, all round; compute": half,
        r"complex is not re, im; save": good.assign_coords(complex=["im", "re"]),
        r"forward_speed is not 0; compute": good.assign_coords(forward_speed=2.0),
    }
    for words, dataset in cases.items():
        with pytest.raises(InputError, match=rf"boat\.nc: {words}") as refusal:
            saved(dataset, tmp_path)
        assert str(refusal.value).isprintable()
    with pytest.raises(InputError, match=r"none\.nc: no such file; give the path"):
        read_capytaine(tmp_path / "none.nc")
    (tmp_path / "text.nc").write_text("not a dataset")
    with pytest.raises(InputError, match=r"text\.nc: cannot be read as NetCDF-4 \(.*\); save the dataset in that form"):
        read_capytaine(str(tmp_path / "text.nc"))
