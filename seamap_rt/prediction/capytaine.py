"""Vessels from files of Capytaine: motions from what a boundary-element code computed."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..io.opening import load, open_dataset
from ..physics.dispersion import wavenumber
from .vessel import Complex, Met, Real, Responses, Vessel, meeting

_SLOW = 1e-3  # rad/s: slower encounters count as this, since nothing holds a free boat in surge and sway
_FREE = ("Heave", "Roll", "Pitch")
_DOFS = ("influenced_dof", "radiating_dof")
_WIDEST = np.pi / 4  # rad, between directions of a table: between them forces are interpolated
_TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class _Tabulated:
    """What a boundary-element code computed, in its own axes: x to the bow, y to port, z up."""

    dofs: tuple[str, ...]
    omega: Real  # rad/s, ascending
    direction: Real  # rad, towards which waves run, anticlockwise from the bow; a whole turn, first and last the same
    mass: Real  # (dof, dof)
    stiffness: Real
    added_mass: Real = field(repr=False)  # (omega, dof, dof)
    damping: Real = field(repr=False)
    force: Complex = field(repr=False)  # (omega, direction, dof), per metre

    def response(
        self, kx: ArrayLike, ky: ArrayLike, omega: ArrayLike, heading_deg: float, speed_m_s: float, depth_m: float = inf
    ) -> Responses:
        """See `Vessel.response`."""
        met = meeting(kx, ky, omega, heading_deg, speed_m_s, depth_m)
        beat = np.where(np.abs(met.encounter) < _SLOW, _SLOW, met.encounter)[..., None, None]
        low, high, part = _between(self.omega, np.abs(met.encounter))
        added, damping = (
            each[low] + part[..., None, None] * (each[high] - each[low]) for each in (self.added_mass, self.damping)
        )
        impedance = self.stiffness - beat**2 * (self.mass + added) - 1j * beat * damping
        motions = np.linalg.solve(impedance, self._force(met, depth_m)[..., None])[..., 0]
        heave, roll, pitch = (motions[..., self.dofs.index(name)] for name in _FREE)
        return Responses(heave, roll, -pitch)  # with y to port, a positive turn about it puts the bow down

    def _force(self, met: Met, depth_m: float) -> Complex:
        low, high, part = _between(self.omega, met.sigma)
        towards = np.arctan2(-met.starboard, met.ahead)
        left, right, turned = _between(self.direction, (towards - self.direction[0]) % _TURN + self.direction[0])
        part, turned = part[..., None], turned[..., None]
        below, above = ((1.0 - turned) * self.force[row, left] + turned * self.force[row, right] for row in (low, high))
        force = (1.0 - part) * below + part * above
        # In waves longer than all of the table the force of heave has reached its limit, all others go with the slope.
        longer = np.minimum(met.k / wavenumber(self.omega[0], depth_m, surface_tension=0.0), 1.0)[..., None]
        force = force * np.where(np.array(self.dofs) == "Heave", 1.0, longer)
        return np.where((met.sigma > self.omega[-1] * (1.0 + 1e-9))[..., None], 0.0, force)


def read_capytaine(path: str | Path) -> Vessel:
    """The vessel of a NetCDF-4 file of Capytaine (Ancellin & Dias 2019), with all degrees of freedom in it moving.

    The boat's reference point must be the file's origin, its rotation centre above or below it; the forces are those
    of the file's depth of water. A moving boat has the forces of the wavelength, with added mass and damping of the
    encounter frequency and no other effect of speed. Between frequencies and between directions all is linear; beyond
    the file's lowest frequency added mass and damping stay, heave's force stays and the other forces go with the slope;
    beyond its highest added mass and damping stay, and waves do not move the boat. Raises InputError for a file that is
    not there or not of this kind, and for one that lacks a variable, a degree of freedom, a finite number, or
    directions within 45° all round.
    """
    path = Path(path)
    try:
        with open_dataset(path, "a NetCDF file of Capytaine") as file:
            held = load(file, str(path), path)
    except InputError:
        raise
    except Exception as error:  # h5py, h5netcdf and xarray each have their own for a file of another make
        raise InputError(f"{path}: cannot be read as NetCDF ({error}); save the dataset in that form") from None
    among = {name: [str(each) for each in np.atleast_1d(held[name])] if name in held else [] for name in _DOFS}
    dofs = tuple(each for each in among[_DOFS[0]] if each in among[_DOFS[1]])
    if missing := [name for name in _FREE if name not in dofs]:
        raise InputError(
            f"{path}: lacks {', '.join(missing)} among its degrees of freedom ({', '.join(dofs) or 'none'}); compute "
            "one body with Heave, Roll and Pitch"
        )
    rows = [[among[name].index(each) for each in dofs] for name in _DOFS]
    held = held.isel(dict(zip(_DOFS, rows, strict=True)))
    mass, stiffness = (_numbers(held, path, name, _DOFS) for name in ("inertia_matrix", "hydrostatic_stiffness"))
    added_mass, damping = (
        _numbers(held, path, name, ("omega", *_DOFS)) for name in ("added_mass", "radiation_damping")
    )
    scattered, incident = (
        _numbers(held, path, name, ("complex", "omega", "wave_direction", _DOFS[0]))
        for name in ("diffraction_force", "Froude_Krylov_force")
    )
    omega, towards = (_numbers(held, path, name, (name,)) for name in ("omega", "wave_direction"))
    if not (omega.min() > 0.0 and np.unique(omega).size == omega.size):
        raise InputError(f"{path}: omega holds {omega.min():g} rad/s or one twice; compute frequencies above 0, once")
    if [str(each) for each in np.atleast_1d(held["complex"])] != ["re", "im"]:
        raise InputError(f"{path}: complex is not re, im; save the file by Capytaine's separate_complex_values")
    if float(held.get("forward_speed", 0.0)) != 0.0:
        raise InputError(f"{path}: forward_speed is not 0; compute the boat at rest, its speed is given with the waves")
    direction, columns = np.unique(np.round(towards % _TURN, 7) % np.round(_TURN, 7), return_index=True)
    direction = np.append(direction, direction[0] + _TURN)
    if (gap := float(np.diff(direction).max())) > _WIDEST + 1e-5:
        raise InputError(
            f"{path}: wave_direction leaves out {np.degrees(gap):.0f}°: must be at most 45° apart, all round; compute "
            "the directions between, a symmetric boat's other side too"
        )
    order = np.argsort(omega)
    real, imaginary = scattered + incident
    force = (real + 1j * imaginary)[order][:, np.append(columns, columns[0])]
    return _Tabulated(dofs, omega[order], direction, mass, stiffness, added_mass[order], damping[order], force)


def _numbers(held: xr.Dataset, path: Path, name: str, dims: tuple[str, ...]) -> Real:
    if name not in held:
        raise InputError(f"{path}: has no {name}; save the whole dataset that Capytaine assembles, hydrostatics too")
    if set(held[name].dims) != set(dims):
        found = ", ".join(map(str, held[name].dims)) or "none"
        raise InputError(
            f"{path}: {name} has dims {found}: must be {', '.join(dims)}; compute one body, depth and speed"
        )
    numbers = held[name].transpose(*dims).to_numpy().astype(np.float64)
    if not np.isfinite(numbers).all():
        raise InputError(f"{path}: {name} holds what is no number; leave out frequencies 0 and inf, set all inertia")
    return numbers


def _between(grid: Real, at: Real) -> tuple[NDArray[np.intp], NDArray[np.intp], Real]:
    """Neighbours on an ascending grid, and how far from the first to the second; the ends go on for ever."""
    low = np.clip(np.searchsorted(grid, at, side="right") - 1, 0, grid.size - 1)
    high = np.minimum(low + 1, grid.size - 1)
    span = np.where(high > low, grid[high] - grid[low], 1.0)
    return low, high, np.clip((at - grid[low]) / span, 0.0, 1.0)
