"""Vessels from files of Capytaine: motions from what a boundary-element code computed."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..errors import InputError
from ..io.declared import to_unit
from ..io.opening import load, open_dataset
from ..physics.dispersion import wavenumber
from .vessel import Complex, EncounterWaves, Real, Responses, Values, Vessel, encounter_waves

_SLOW = 1e-3  # rad/s: slower encounters count as this, since nothing holds a free boat in surge and sway
_FREE = ("Heave", "Roll", "Pitch")
_DOFS = ("influenced_dof", "radiating_dof")
_WAVES = ("omega", "wave_direction")
_MIRRORED = {  # the sign of a force where port and starboard, and where bow and stern change places
    "Surge": (1.0, -1.0), "Sway": (-1.0, 1.0), "Heave": (1.0, 1.0), "Roll": (-1.0, 1.0), "Pitch": (1.0, -1.0),
    "Yaw": (-1.0, -1.0),
}  # fmt: skip
_ALIKE = 0.1  # share of a matrix by which a symmetric boat's may differ from its mirror image: panels are coarse
_FINE = np.pi / 36  # rad, between directions of a round boat: between them forces err by a thousandth
_FEWEST, _NAMED = 2, 4  # frequencies that must hold numbers; and that are named where they do not
_LONG = 0.25  # by which heave's force may differ from its limit in long waves, where frequencies are left out
_BESIDE_M = 0.01
_WIDEST = np.pi / 4  # rad, between directions of a table: between them forces are interpolated
_TURN = 2.0 * np.pi

Symmetry = Literal["sides", "sides_and_ends", "round"]


@dataclass(frozen=True, eq=False)
class _HullTable:
    """What a boundary-element code computed, in its own axes: x to the bow, y to port, z up."""

    dofs: tuple[str, ...]
    omega: Real  # rad/s, ascending
    direction: Real  # rad, towards which waves run, anticlockwise from the bow; a whole turn, first and last the same
    mass: Real  # (dof, dof)
    stiffness: Real
    added_mass: Real = field(repr=False)  # (omega, dof, dof)
    damping: Real = field(repr=False)
    force: Complex = field(repr=False)  # (omega, direction, dof), per metre
    notes: tuple[str, ...] = ()  # what was left out of the file, or is odd in it

    def response(
        self, kx: Values, ky: Values, omega: Values, heading_deg: float, speed_m_s: Values, depth_m: float = inf
    ) -> Responses:
        """See `Vessel.response`."""
        met = encounter_waves(kx, ky, omega, heading_deg, speed_m_s, depth_m)
        beat = np.where(np.abs(met.encounter) < _SLOW, _SLOW, met.encounter)[..., None, None]
        low, high, part = _bracket(self.omega, np.abs(met.encounter))
        added, damping = (
            each[low] + part[..., None, None] * (each[high] - each[low]) for each in (self.added_mass, self.damping)
        )
        impedance = self.stiffness - beat**2 * (self.mass + added) - 1j * beat * damping
        motions = np.linalg.solve(impedance, self._force(met, depth_m)[..., None])[..., 0]
        heave, roll, pitch = (motions[..., self.dofs.index(name)] for name in _FREE)
        return Responses(heave, roll, -pitch)  # with y to port, a positive turn about it puts the bow down

    def _force(self, met: EncounterWaves, depth_m: float) -> Complex:
        low, high, part = _bracket(self.omega, met.sigma)
        towards = np.arctan2(-met.starboard, met.ahead)
        left, right, turned = _bracket(self.direction, (towards - self.direction[0]) % _TURN + self.direction[0])
        part, turned = part[..., None], turned[..., None]
        below, above = ((1.0 - turned) * self.force[row, left] + turned * self.force[row, right] for row in (low, high))
        force = (1.0 - part) * below + part * above
        # In waves longer than all of the table the force of heave has reached its limit, all others go with the slope.
        longer = np.minimum(met.k / wavenumber(self.omega[0], depth_m, surface_tension=0.0), 1.0)[..., None]
        force = force * np.where(np.array(self.dofs) == "Heave", 1.0, longer)
        return np.where((met.sigma > self.omega[-1] * (1.0 + 1e-9))[..., None], 0.0, force)


def read_capytaine(path: str | Path, body: str | None = None, symmetry: Symmetry | None = None) -> Vessel:
    """The vessel of a NetCDF file of Capytaine (Ancellin & Dias 2019), with all its degrees of freedom moving.

    body: which of several, by the name before `__Heave`; the others are there, held fast. symmetry: what gives the
    directions that the file leaves out: `sides`, port is like starboard; `sides_and_ends`, bow like stern too; `round`,
    all directions are alike. Frequencies that hold no number, 0 and inf are left out, and `notes` says so.

    The boat's reference point must be the file's origin, its rotation centre above or below it; one of several bodies
    has it in its own rotation centre, wherever that is. The forces are those of the file's depth of water. A moving
    boat has the forces of the wavelength, with added mass and damping of the encounter frequency and no other effect of
    speed. Between frequencies and between directions all is linear; beyond the file's lowest frequency added mass and
    damping stay, heave's force stays and the other forces go with the slope; beyond its highest added mass and damping
    stay, and waves do not move the boat. Raises InputError for a file that is not there or not of this kind, and for
    one that lacks a variable, the body, a degree of freedom, finite numbers, or directions within 45° all round.
    """
    path = Path(path)
    try:
        with open_dataset(path, "a NetCDF file of Capytaine") as file:
            held = load(file, str(path), path)
    except InputError:
        raise
    except Exception as error:  # h5py, h5netcdf and xarray each have their own for a file of another make
        raise InputError(f"{path}: cannot be read as NetCDF ({error}); save the dataset in that form") from None
    held, dofs, several = _select_body(held, path, body)
    mass, stiffness = (_numbers(held, path, name, _DOFS) for name in ("inertia_matrix", "hydrostatic_stiffness"))
    if not np.isfinite([mass, stiffness]).all():
        name = "hydrostatic_stiffness" if np.isfinite(mass).all() else "inertia_matrix"
        raise InputError(f"{path}: {name} holds what is no number; set the body's mass and its centre")
    added_mass, damping = (
        _numbers(held, path, name, ("omega", *_DOFS)) for name in ("added_mass", "radiation_damping")
    )
    scattered, incident = (
        real + 1j * imaginary
        for name in ("diffraction_force", "Froude_Krylov_force")
        for real, imaginary in (_numbers(held, path, name, ("complex", *_WAVES, _DOFS[0])),)
    )
    omega, towards = (
        to_unit(_numbers(held, path, name, (name,)), held[name].attrs.get("units"), unit, f"{path}: {name}")
        for name, unit in zip(_WAVES, ("rad/s", "rad"), strict=True)
    )
    if (most := float(np.abs(towards).max())) > 2.0 * _TURN:
        raise InputError(f"{path}: wave_direction = {most:g}: must be in rad, or say its units; write them to the file")
    if [str(each) for each in np.atleast_1d(held["complex"])] != ["re", "im"]:
        raise InputError(f"{path}: complex is not re, im; save the file by Capytaine's separate_complex_values")
    if float(held.get("forward_speed", 0.0)) != 0.0:
        raise InputError(f"{path}: forward_speed is not 0; compute the boat at rest, its speed is given with the waves")
    order = np.argsort(omega)
    known, notes = _known_frequencies(path, omega, added_mass, damping, scattered, incident)
    order = order[known[order]]
    omega, added_mass, damping = omega[order], added_mass[order], damping[order]
    scattered, incident = scattered[order], incident[order]
    force, heave = scattered + incident, dofs.index("Heave")
    long = np.abs(force[0, 0, heave]) / max(stiffness[heave, heave], 1e-12)
    if notes and not abs(long - 1.0) < _LONG:
        raise InputError(
            f"{path}: the lowest frequency that holds numbers is {omega[0]:.3g} rad/s, where heave's force is "
            f"{long:.2g} of its stiffness, and in long waves it is 1; compute lower ones"
        )
    if several:
        depth = float(held.get("water_depth", inf))
        k = np.asarray(wavenumber(omega, depth, surface_tension=0.0))
        place = _place(k[0], towards, incident[0, :, heave], stiffness[heave], dofs)
        force = force * np.exp(-1j * k[:, None] * (np.stack((np.cos(towards), np.sin(towards)), 1) @ place))[..., None]
        if (away := float(np.hypot(*place))) > _BESIDE_M:
            notes.append(f"the body stands {away:.3g} m from the file's origin, and its motions count from there")
    matrices = {"inertia_matrix": mass, "hydrostatic_stiffness": stiffness, "added_mass": added_mass[omega.size // 2]}
    towards, force = _complete_directions(path, dofs, towards, force, symmetry, matrices)
    direction, columns = np.unique(np.round(towards % _TURN, 7) % np.round(_TURN, 7), return_index=True)
    direction = np.append(direction, direction[0] + _TURN)
    if (gap := float(np.diff(direction).max())) > _WIDEST + 1e-5:
        raise InputError(
            f"{path}: wave_direction leaves out {np.degrees(gap):.0f}°: must be at most 45° apart, all round; compute "
            "the directions between, or set prediction.vessel.symmetry, by which they follow: sides, sides_and_ends or "
            "round"
        )
    for name in ("Roll", "Pitch"):
        if (own := stiffness[dofs.index(name), dofs.index(name)]) <= 0.0:
            notes.append(f"{name} has the stiffness {own:.3g} N m, of a boat that capsizes; check its centre of mass")
    force = force[:, np.append(columns, columns[0])].astype(np.complex128)
    warnings = tuple(f"{path}: {note}" for note in notes)
    return _HullTable(dofs, omega, direction, mass, stiffness, added_mass, damping, force, warnings)


def _select_body(held: xr.Dataset, path: Path, body: str | None) -> tuple[xr.Dataset, tuple[str, ...], bool]:
    """One body's part of a file, the names of its degrees of freedom, and whether there are several bodies."""
    among = {name: [str(each) for each in np.atleast_1d(held[name])] if name in held else [] for name in _DOFS}
    every = [each for each in among[_DOFS[0]] if each in among[_DOFS[1]]]
    bodies = list(dict.fromkeys(each.rpartition("__")[0] for each in every))
    own = str(held["body_name"].values) if bodies == [""] and "body_name" in held else ""
    if len(bodies) > 1 and body not in bodies:
        given = f"is '{body}'" if body else "is missing"
        raise InputError(f"{path}: holds several bodies, prediction.vessel.body {given}: must be {' or '.join(bodies)}")
    if len(bodies) == 1 and body not in (None, own, *bodies):
        name = own or bodies[0]
        remedy = f"write {name}, or leave it out" if name else "leave it out"
        raise InputError(f"{path}: holds one body, prediction.vessel.body is '{body}'; {remedy}")
    mine = [each for each in every if len(bodies) == 1 or each.rpartition("__")[0] == body]
    dofs = tuple(each.rpartition("__")[2] for each in mine)
    if missing := [name for name in _FREE if name not in dofs]:
        raise InputError(
            f"{path}: lacks {', '.join(missing)} among its degrees of freedom ({', '.join(dofs) or 'none'}); compute "
            "a body with Heave, Roll and Pitch"
        )
    rows = [[among[name].index(each) for each in mine] for name in _DOFS]
    return held.isel(dict(zip(_DOFS, rows, strict=True))), dofs, len(bodies) > 1


def _numbers(held: xr.Dataset, path: Path, name: str, dims: tuple[str, ...]) -> Real:
    if name not in held:
        raise InputError(f"{path}: has no {name}; save the whole dataset that Capytaine assembles, hydrostatics too")
    if set(held[name].dims) != set(dims):
        found = ", ".join(map(str, held[name].dims)) or "none"
        raise InputError(
            f"{path}: {name} has dims {found}: must be {', '.join(dims)}; compute one body, depth and speed"
        )
    return held[name].transpose(*dims).to_numpy().astype(np.float64)


def _known_frequencies(path: Path, omega: Real, *tables: NDArray[np.inexact]) -> tuple[NDArray[np.bool_], list[str]]:
    """Which frequencies, of tables (omega, …), hold numbers, and what to say of the others."""
    whole = np.logical_and.reduce([np.isfinite(each).reshape(omega.size, -1).all(axis=1) for each in tables])
    known = whole & np.isfinite(omega) & (omega > 0.0)
    if (omega < 0.0).any() or np.unique(omega[known]).size != known.sum():
        raise InputError(f"{path}: omega holds {omega.min():g} rad/s or one twice; compute frequencies above 0, once")
    if known.all():
        return known, []
    without = np.sort(omega[~known])
    left = ", ".join([*(f"{each:.3g}" for each in without[:_NAMED]), *(["…"] if without.size > _NAMED else [])])
    if known.sum() < _FEWEST:
        raise InputError(
            f"{path}: {known.sum()} of {omega.size} frequencies hold numbers (not {left} rad/s): must be at least "
            f"{_FEWEST}; compute more"
        )
    return known, [f"frequencies that hold no numbers, 0 or inf are left out: {left} rad/s"]


def _place(k: float, towards: Real, heave: NDArray[np.inexact], stiffness: Real, dofs: tuple[str, ...]) -> Real:
    """Where a body's rotation centre is, x and y [m]: of long waves of wavenumber k the force of heave has the phase of
    the waterplane's centre, and the stiffness between heave and the turns says how far that is from it."""
    toward = np.stack((np.cos(towards), np.sin(towards)), axis=1)
    centre = np.asarray(np.linalg.lstsq(toward, np.angle(heave) / k, rcond=None)[0], dtype=np.float64)
    stiff = {name: stiffness[dofs.index(name)] / stiffness[dofs.index("Heave")] for name in ("Roll", "Pitch")}
    return centre + np.array([stiff["Pitch"], -stiff["Roll"]])


def _complete_directions(
    path: Path,
    dofs: tuple[str, ...],
    towards: Real,
    force: NDArray[np.inexact],
    symmetry: Symmetry | None,
    matrices: dict[str, Real],
) -> tuple[Real, NDArray[np.inexact]]:
    """Directions (direction,) rad and forces (omega, direction, dof) with those that a symmetry gives."""
    if symmetry is None:
        return towards, force
    if strange := [name for name in dofs if name not in _MIRRORED]:
        raise InputError(
            f"{path}: has the degree of freedom {strange[0]}, and a symmetry is known of {', '.join(_MIRRORED)} alone; "
            "compute without it, or leave prediction.vessel.symmetry out"
        )
    sides, ends = (np.diag([_MIRRORED[name][mirror] for name in dofs]) for mirror in (0, 1))
    known = {"sides": [sides], "sides_and_ends": [sides, ends], "round": [sides, _rotation(dofs, np.pi / 2)]}
    if (images := known.get(symmetry)) is None:
        raise InputError(
            f"symmetry = '{symmetry}': must be one of {', '.join(known)}; leave it out where there is none"
        )
    turns = np.array([name in ("Roll", "Pitch", "Yaw") for name in dofs])
    for image, (name, matrix) in ((image, each) for image in images for each in matrices.items()):
        like = image @ matrix @ image.T
        own = np.abs(np.diag(matrix))
        size = np.sqrt(np.where(turns, own[turns].max(), own[~turns].max()))
        if (np.abs(like - matrix) > _ALIKE * np.outer(size, size)).any():
            raise InputError(
                f"{path}: {name} is not that of a boat with prediction.vessel.symmetry = '{symmetry}'; compute "
                "directions all round"
            )
    if symmetry == "round":
        angles = np.arange(0.0, _TURN, _FINE)
        return towards[0] + angles, np.stack([force[:, 0] @ _rotation(dofs, angle).T for angle in angles], axis=1)
    towards, force = np.append(towards, -towards), np.concatenate((force, force @ sides), axis=1)
    if symmetry == "sides_and_ends":
        towards, force = np.append(towards, np.pi - towards), np.concatenate((force, force @ ends), axis=1)
    return towards, force


def _rotation(dofs: tuple[str, ...], angle: float) -> Real:
    """(dof, dof) what a turn about the vertical makes of forces and moments."""
    turned = np.eye(len(dofs))
    for first, second in (("Surge", "Sway"), ("Roll", "Pitch")):
        if first in dofs and second in dofs:
            pair = [dofs.index(first), dofs.index(second)]
            turned[np.ix_(pair, pair)] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return turned


def _bracket(grid: Real, at: Real) -> tuple[NDArray[np.intp], NDArray[np.intp], Real]:
    """Neighbours on an ascending grid, and how far from the first to the second; the ends go on for ever."""
    low = np.clip(np.searchsorted(grid, at, side="right") - 1, 0, grid.size - 1)
    high = np.minimum(low + 1, grid.size - 1)
    span = np.where(high > low, grid[high] - grid[low], 1.0)
    return low, high, np.clip((at - grid[low]) / span, 0.0, 1.0)
