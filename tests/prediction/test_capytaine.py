"""What a file of Capytaine is read as: limits, its own equations, interpolation, refusals."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
import xarray as xr
from met_waves import each, moved
from numpy.typing import NDArray

from seamap_rt.conventions import GRAVITY
from seamap_rt.errors import InputError
from seamap_rt.physics.dispersion import wavenumber
from seamap_rt.prediction import vessel_notes
from seamap_rt.prediction.capytaine import Symmetry, read_capytaine
from seamap_rt.prediction.vessel import Follower, Vessel

Engine = Literal["scipy", "h5netcdf"]
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


def saved(dataset: xr.Dataset, folder: Path, engine: Engine = "scipy", **choice: Any) -> Vessel:
    path = folder / "boat.nc"
    path.unlink(missing_ok=True)
    dataset.to_netcdf(path, engine=engine)
    return read_capytaine(path, **choice)


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


def without(data: xr.Dataset, omega: NDArray[np.float64]) -> xr.Dataset:
    """The same with NaN where the solver found nothing."""
    known = ~data["omega"].isin(omega)
    return data.assign({name: each.where(known) for name, each in data.items() if "omega" in each.dims})


def alike(one: Vessel, other: Vessel, columns: range | list[int] = range(12)) -> None:
    """The same motions in waves of the file's own frequencies and directions, and as it meets them under way."""
    for column, speed in ((column, speed) for column in columns for speed in (0.0, 1.5)):
        azimuth, k = -np.degrees(DIRECTIONS[column]), FREQUENCIES**2 / GRAVITY
        got, want = (each(moved(vessel, azimuth, 0.0, speed, k)) for vessel in (one, other))
        np.testing.assert_allclose(got, want, rtol=1e-6, atol=1e-7)  # directions are told apart by 1e-7


_SIDES = np.array([1.0, 1.0, -1.0, 1.0])  # of Surge, Heave, Roll, Pitch, where port and starboard change places
_ENDS = np.array([-1.0, 1.0, 1.0, -1.0])


def symmetric_file(symmetry: str) -> xr.Dataset:
    """A boat with a symmetry, and with forces of which it alone is known."""
    data = boat_file()
    if symmetry == "round":
        data = data.sel(influenced_dof=list(DOFS[1:]), radiating_dof=list(DOFS[1:]))  # heave and the turns
        toward = np.stack((np.ones(12), -np.sin(DIRECTIONS), np.cos(DIRECTIONS)), axis=1)
        scale = np.array([[3e4, 2e3 - 1e3j, 2e3 - 1e3j]]) * FREQUENCIES[:, None]
        force = toward[None] * scale[:, None]
        for name in ("diffraction_force", "Froude_Krylov_force"):
            data[name] = (data[name].dims, np.array([force.real, force.imag]))
        matrix = data["inertia_matrix"].dims, np.diag([900.0, 800.0, 800.0])
        stiff = data["inertia_matrix"].dims, np.diag([4e4, 9e3, 9e3])
        changing = (1.0 + 0.3 * np.cos(FREQUENCIES))[:, None, None] * np.diag([1500.0, 300.0, 300.0])
        dims = data["added_mass"].dims
        return data.assign(
            inertia_matrix=matrix, hydrostatic_stiffness=stiff, added_mass=(dims, changing),
            radiation_damping=(dims, changing),
        )  # fmt: skip
    mirrors = {"sides": [_SIDES], "sides_and_ends": [_SIDES, _ENDS]}[symmetry]
    for mirror in mirrors:
        to = -DIRECTIONS if mirror is _SIDES else np.pi - DIRECTIONS
        columns = np.rint(np.degrees(to) / 30.0).astype(int) % 12
        for name in ("diffraction_force", "Froude_Krylov_force"):
            data[name] = 0.5 * (data[name] + data[name].isel(wave_direction=columns).values * mirror)
        for name in ("inertia_matrix", "hydrostatic_stiffness", "added_mass", "radiation_damping"):
            data[name] = 0.5 * (data[name] + data[name] * np.outer(mirror, mirror))
    return data


@pytest.mark.parametrize("engine", ["scipy", "h5netcdf"])
def test_netcdf_of_either_version_is_read_alike(engine: Engine, tmp_path: Path) -> None:
    alike(saved(boat_file(), tmp_path, engine), saved(boat_file(), tmp_path))


@pytest.mark.parametrize(
    ("symmetry", "kept"), [("sides", range(7)), ("sides_and_ends", range(4)), ("round", [0]), ("round", [4])]
)
def test_directions_left_out_follow_by_the_boats_symmetry(
    symmetry: Symmetry, kept: range | list[int], tmp_path: Path
) -> None:
    whole = symmetric_file(symmetry)
    part = whole.isel(wave_direction=list(kept))
    alike(saved(part, tmp_path, symmetry=symmetry), saved(whole, tmp_path))
    with pytest.raises(InputError, match=r"set prediction\.vessel\.symmetry, by which they follow"):
        saved(part, tmp_path)


@pytest.mark.parametrize("name", ["inertia_matrix", "hydrostatic_stiffness", "added_mass"])
@pytest.mark.parametrize(
    ("symmetry", "wrong"), [("sides", "Heave Roll"), ("sides_and_ends", "Heave Pitch"), ("round", "Roll Roll")]
)
def test_a_symmetry_that_a_boat_has_not_is_refused(name: str, symmetry: Symmetry, wrong: str, tmp_path: Path) -> None:
    data, (row, column) = symmetric_file(symmetry), wrong.split()
    own = [data[name].sel(influenced_dof=each, radiating_dof=each).to_numpy() for each in (row, column)]
    data[name].loc[{"influenced_dof": row, "radiating_dof": column}] = 0.7 * np.sqrt(own[0] * own[1])
    wanted = rf"{name} is not that of a boat with prediction\.vessel\.symmetry = '{symmetry}'"
    with pytest.raises(InputError, match=wanted):
        saved(data, tmp_path, symmetry=symmetry)


@pytest.mark.parametrize("place", [(0.0, 0.0), (30.0, -12.0)])
def test_each_of_two_bodies_moves_as_it_would_alone(place: tuple[float, float], tmp_path: Path) -> None:
    """Neither feels the other, which lies at a place of its own: there its waves are late, and its motions too."""
    alone = raft_file()
    k = FREQUENCIES[:, None] ** 2 / GRAVITY
    late = np.exp(1j * k * (np.cos(DIRECTIONS) * place[0] + np.sin(DIRECTIONS) * place[1]))[..., None]
    pair = ("influenced_dof", "radiating_dof")
    both = xr.Dataset(coords={name: each for name, each in alone.coords.items() if name not in pair})
    both = both.assign_coords({key: [f"{body}__{dof}" for body in ("hull", "raft") for dof in DOFS] for key in pair})
    for name in ("diffraction_force", "Froude_Krylov_force"):
        real, imaginary = alone[name].to_numpy()
        there = (real + 1j * imaginary) * late
        forces = [alone[name].to_numpy(), np.array([there.real, there.imag])]
        both[name] = (alone[name].dims, np.concatenate(forces, axis=-1))
    for name in ("inertia_matrix", "hydrostatic_stiffness", "added_mass", "radiation_damping"):
        one = alone[name].to_numpy()
        both[name] = (alone[name].dims, np.block([[3.0 * one, 0.0 * one], [0.0 * one, one]]))
    got = saved(both, tmp_path, body="raft")
    alike(got, saved(alone, tmp_path))
    assert len(vessel_notes(got)) == (1 if any(place) else 0)
    with pytest.raises(InputError, match=r"holds several bodies, prediction\.vessel\.body is missing: .* hull or raft"):
        saved(both, tmp_path)
    with pytest.raises(InputError, match=r"several bodies, prediction\.vessel\.body is 'barge': must be hull or raft"):
        saved(both, tmp_path, body="barge")


def test_a_symmetry_of_no_boat_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"symmetry = 'none': must be one of sides, sides_and_ends, round; leave it out"
    ):
        saved(boat_file(), tmp_path, symmetry="none")


def test_one_body_has_the_name_of_its_file(tmp_path: Path) -> None:
    named = raft_file().assign_coords(body_name="raft")
    alike(saved(named, tmp_path, body="raft"), saved(named, tmp_path))
    with pytest.raises(
        InputError, match=r"holds one body, prediction\.vessel\.body is 'hull'; write raft, or leave it out"
    ):
        saved(named, tmp_path, body="hull")


@pytest.fixture(scope="module")
def raft(tmp_path_factory: pytest.TempPathFactory) -> Vessel:
    return saved(raft_file(), tmp_path_factory.mktemp("raft"))


@pytest.fixture(scope="module")
def boat(tmp_path_factory: pytest.TempPathFactory) -> Vessel:
    return saved(boat_file(), tmp_path_factory.mktemp("boat"))


@pytest.mark.parametrize(
    ("what", "where"),
    [
        *((what, where) for what in ("added_mass", "omega") for where in ([0.05], [9.0], [0.05, 1.3])),
        *((what, [0.05, 1.3]) for what in ("radiation_damping", "diffraction_force", "Froude_Krylov_force")),
    ],
)
def test_frequencies_without_numbers_are_left_out_and_named(
    what: str, where: list[float], raft: Vessel, tmp_path: Path
) -> None:
    """As if they were not in the file, be it one variable or the frequency itself, 0 and infinite, that is none."""
    more = raft_file().reindex(omega=np.sort([*FREQUENCIES, *where]), method="nearest")
    if what == "omega":
        at = np.where(np.isin(more["omega"], where), np.where(more["omega"] > 5.0, np.inf, 0.0), more["omega"])
        at = at[np.unique(at, return_index=True)[1]] if 1.3 not in where else np.where(more["omega"] == 1.3, np.inf, at)
        more = more.assign_coords(omega=at)
    else:
        more[what] = more[what].where(~more["omega"].isin(where))
    got = saved(more, tmp_path)
    alike(got, raft)
    (note,) = vessel_notes(got)
    assert re.search(r"frequencies that hold no numbers, 0 or inf are left out: .* rad/s", note)


@pytest.mark.parametrize(
    ("turn", "rate"),
    [
        *((turn, "rad/s") for turn in ("deg", "degrees", "rad", "radians", None)),
        *(("deg", rate) for rate in ("rad s-1", "Hz", None)),
    ],
)
def test_frequencies_and_directions_are_in_the_units_that_the_file_says(
    turn: str | None, rate: str | None, boat: Vessel, tmp_path: Path
) -> None:
    data = boat_file()
    direction, omega = DIRECTIONS, FREQUENCIES
    direction = np.degrees(direction) if turn and turn.startswith("deg") else direction
    omega = omega / (2.0 * np.pi) if rate == "Hz" else omega
    told = data.assign_coords(
        wave_direction=("wave_direction", direction, {"units": turn} if turn else {}),
        omega=("omega", omega, {"units": rate} if rate else {}),
    )
    alike(saved(told, tmp_path), boat)


def test_a_file_is_refused_in_one_line_that_says_what_it_lacks(tmp_path: Path) -> None:
    good = boat_file()
    without_roll = good.sel(influenced_dof=["Surge", "Heave", "Pitch"], radiating_dof=["Surge", "Heave", "Pitch"])
    half = good.sel(wave_direction=slice(0.0, np.pi + 0.01))
    blank = good.copy(deep=True)
    blank["inertia_matrix"][0, 0] = np.nan
    twice = good.assign_coords(omega=[0.4, *FREQUENCIES[[0, 2, 3, 4]]])
    short = without(raft_file(), FREQUENCIES[:3])
    for name in ("diffraction_force", "Froude_Krylov_force"):
        short[name] = short[name] * 0.04
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
        r"inertia_matrix holds what is no number; set the body's mass": blank,
        r"omega holds 0\.4 rad/s or one twice; compute": twice,
        r"omega holds -1 rad/s or one twice; compute": good.assign_coords(omega=[-1.0, *FREQUENCIES[1:]]),
        r"1 of 5 frequencies hold numbers \(not 0\.7, 1\.1, 1\.6, 2\.3 rad/s\): must be at least 2": without(
            good, FREQUENCIES[1:]
        ),
        r"the lowest frequency that holds numbers is 1\.6 rad/s, where heave's force is 0\.04 of .* lower": short,
        r"wave_direction leaves out 180°: must be at most 45° apart, all round; compute": half,
        r"wave_direction = 330: must be in rad, or say its units; write": good.assign_coords(
            wave_direction=np.degrees(DIRECTIONS)
        ),
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
    with pytest.raises(InputError, match=r"text\.nc: cannot be read as NetCDF \(.*\); save the dataset in that form"):
        read_capytaine(str(tmp_path / "text.nc"))
