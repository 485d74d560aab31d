"""How boats and buoys move in waves: response amplitude operators of heave, roll and pitch.

A wave is η = Re(a e^{i(k·x − ωt)}) with x east, y north; the motion at the boat's reference point, amidships in the
waterline, is Re(R a e^{i(k·x − ωt)}). Heave is positive upwards, roll with the starboard side down, pitch with the bow
up. A boat that moves meets the wave at the encounter frequency ω − k·v. Where a force is not from a table, it is that
of the water's motion on the hull's stiffness, added mass and damping: the principle of relative motion (Korvin-
Kroukovsky 1955), whose two sides agree for a wave that is long against the hull.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Protocol

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy.special import j1

from ..conventions import GRAVITY, unit_from_azimuth
from ..errors import InputError
from ..physics.dispersion import angular_frequency, wavenumber

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating]

_PERIOD = 0.8  # s/√m: roll's period times √GM over the beam, of craft below 45 m (IMCO 1973, fishing vessels' code)
_FLAT, _NARROW, _SLENDER = 6.0, 3.0, 1.0  # beam over draught: where the fits of roll damping end and change
_SLOW = 1e-3  # rad/s: slower encounters count as this, since nothing holds a free boat in surge and sway
_FREE = ("Heave", "Roll", "Pitch")
_DOFS = ("influenced_dof", "radiating_dof")
_WIDEST = np.pi / 4  # rad, between directions of a table: between them forces are interpolated
_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Responses:
    """Complex motions per metre of wave amplitude, each of the waves' shape: heave [m/m], roll and pitch [rad/m]."""

    heave: Complex
    roll: Complex
    pitch: Complex


class Vessel(Protocol):
    """What floats on the waves."""

    def response(
        self, kx: ArrayLike, ky: ArrayLike, omega: ArrayLike, heading_deg: float, speed_m_s: float, depth_m: float = inf
    ) -> Responses:
        """Motions in waves of wavevectors (kx east, ky north) [rad/m] and frequencies omega over ground [rad/s], of
        their broadcast shape, on a heading [deg clockwise from north] at a speed over ground along it [m/s], in water
        of a depth [m]. Raises ValueError for a heading or speed that is not finite and for a depth ≤ 0."""
        ...


@dataclass(frozen=True)
class Follower:
    """A small raft without mass, which follows the surface: the limit of all vessels in long waves."""

    def response(
        self, kx: ArrayLike, ky: ArrayLike, omega: ArrayLike, heading_deg: float, speed_m_s: float, depth_m: float = inf
    ) -> Responses:
        """See `Vessel.response`."""
        met = _met(kx, ky, omega, heading_deg, speed_m_s, depth_m)
        return Responses(np.ones(met.k.shape, dtype=np.complex128), -1j * met.starboard, 1j * met.ahead)


@dataclass(frozen=True)
class Disc:
    """A small buoy in the shape of an upright disc.

    Heave is an oscillator of hydrostatic stiffness, with the added mass 4/3 ρ a³ of a disc of radius a at the surface
    (half of Lamb's 8/3 ρ a³, the limit of high frequencies; that of low ones is twice as much), and with the damping
    that Haskind's relation (Newman 1962) gives the undisturbed wave's force. The wave is averaged over the disc, its
    pressure taken at the bottom. Tilt is the mean slope under the disc, without dynamics of its own: a buoy with a
    deep keel or high weights sways otherwise. Viscous damping, mooring and shallow water's part in radiation are left
    out. Raises ValueError for sizes that are not positive and finite.
    """

    diameter_m: float
    draught_m: float

    def __post_init__(self) -> None:
        _check_sizes(diameter_m=self.diameter_m, draught_m=self.draught_m)

    @property
    def heave_period_s(self) -> float:
        """Natural period of heave [s]."""
        return float(_TURN * np.sqrt((self.draught_m + self._added_draught) / GRAVITY))

    @property
    def _added_draught(self) -> float:
        return 4.0 / (3.0 * np.pi) * (0.5 * self.diameter_m)  # m of water under the disc that weigh as the added mass

    def response(
        self, kx: ArrayLike, ky: ArrayLike, omega: ArrayLike, heading_deg: float, speed_m_s: float, depth_m: float = inf
    ) -> Responses:
        """See `Vessel.response`."""
        met = _met(kx, ky, omega, heading_deg, speed_m_s, depth_m)
        radius = 0.5 * self.diameter_m
        radiated = met.pull * radius
        # ω B / C with B = ω k |F|²/(2 ρ g²), of the force F = C e^{−kT} 2 J₁(ka)/(ka) of a wave of that frequency.
        damping = 0.5 * np.pi * (radiated * np.exp(-met.pull * self.draught_m) * _over_disc(radiated)) ** 2
        share = _over_disc(met.k * radius)
        heave = _relative(met, self.draught_m, self._added_draught, damping, depth_m) * share
        return Responses(heave, -1j * met.starboard * share, 1j * met.ahead * share)


@dataclass(frozen=True)
class Box:
    """A box-shaped boat, by the closed forms of Jensen, Mansour & Olsen (2004), Ocean Engineering 31, 61–85.

    Sizes in metres; `block` is the block coefficient, by which the beam counts in heave and pitch. roll_period_s and
    metacentric_height_m (transverse): of one that is not given, T = 0.8 B/√GM; of neither, GM is the box's with its
    weight centred in the waterline. roll_damping: what viscosity and keels add, as a share of the critical.

    As in the paper, heave and pitch are uncoupled, bow and stern alike, a section's added mass is its own mass, its
    damping that of waves of amplitude 2 sin(ωₑ²B/2g) e^{−ωₑ²T/g} that it sends out, and the wave is averaged over the
    length alone: in waves from abeam shorter than about two beams heave is too large. Otherwise than there, the force
    keeps its phase; the wave's pressure falls off with its own wavenumber on all headings; and the sine stays at 1
    beyond its top, since its zero would leave a box of beam 12.6 times its draught undamped. Roll has the paper's
    inviscid damping, of one prism, at ωₑ √(B/2g), which makes that fit dimensionless; B/T counts as 1 to 6 there, its
    range. The paper's moment of roll follows from the fit and dies out in long waves; here it is the stiffness times
    the slope that the box averages, which in long waves is exact.

    Raises ValueError for sizes that are not positive and finite, a block beyond (0, 1], a damping that is negative or
    not finite, and a box that would float upside down.
    """

    length_m: float
    beam_m: float
    draught_m: float
    block: float = 1.0
    roll_period_s: float | None = None
    metacentric_height_m: float | None = None
    roll_damping: float = 0.1

    def __post_init__(self) -> None:
        _check_sizes(length_m=self.length_m, beam_m=self.beam_m, draught_m=self.draught_m)
        given = {"roll_period_s": self.roll_period_s, "metacentric_height_m": self.metacentric_height_m}
        _check_sizes(**{name: value for name, value in given.items() if value is not None})
        if not 0.0 < self.block <= 1.0:
            raise ValueError(f"block = {self.block:g}: must be above 0 and at most 1; give displacement / (L B T)")
        if not 0.0 <= self.roll_damping < inf:
            raise ValueError(
                f"roll_damping = {self.roll_damping:g}: must be finite and at least 0; give a share of the critical"
            )
        if not self.stability_m > 0.0:
            raise ValueError(
                f"draught_m = {self.draught_m:g}: a box of beam {self.beam_m:g} m capsizes with its weight in the "
                "waterline; give metacentric_height_m or roll_period_s"
            )

    @property
    def stability_m(self) -> float:
        """Transverse metacentric height [m]."""
        if self.metacentric_height_m is not None:
            return self.metacentric_height_m
        if self.roll_period_s is not None:
            return (_PERIOD * self.beam_m / self.roll_period_s) ** 2
        return self.beam_m**2 / (12.0 * self.block * self.draught_m) - 0.5 * self.draught_m

    @property
    def natural_roll_s(self) -> float:
        """Natural period of roll [s]."""
        return self.roll_period_s or float(_PERIOD * self.beam_m / np.sqrt(self.stability_m))

    def response(
        self, kx: ArrayLike, ky: ArrayLike, omega: ArrayLike, heading_deg: float, speed_m_s: float, depth_m: float = inf
    ) -> Responses:
        """See `Vessel.response`."""
        met = _met(kx, ky, omega, heading_deg, speed_m_s, depth_m)
        half = 0.5 * met.pull * self.beam_m * self.block
        sent = 2.0 * np.sin(np.minimum(half, 0.5 * np.pi)) * np.exp(-met.pull * self.draught_m)
        damping = sent**2 / np.maximum(2.0 * half, 1e-12)
        vertical = _relative(met, self.draught_m, self.draught_m, damping, depth_m)
        along = 0.5 * met.ahead * self.length_m
        mean = np.sinc(along / np.pi)
        slope = _smith(met.k, self.draught_m, depth_m) * mean * _lever(0.5 * met.starboard * self.beam_m)
        rolling = (
            1.0 - (met.encounter * self.natural_roll_s / _TURN) ** 2 - 1j * met.encounter * self._roll_damping(met)
        )
        return Responses(
            vertical * mean, -1j * met.starboard * slope / rolling, 1j * met.ahead * _lever(along) * vertical
        )

    def _roll_damping(self, met: _Met) -> Real:
        """Over the stiffness [s]: the paper's fit of a section's damping, and what the user adds."""
        ratio = np.clip(self.beam_m / self.draught_m, _SLENDER, _FLAT)
        if ratio >= _NARROW:
            a, b, d = 0.256 * ratio - 0.286, -0.11 * ratio - 2.55, 0.033 * ratio - 1.419
        else:
            a, b, d = -3.94 * ratio + 13.69, -2.12 * ratio - 1.89, 1.16 * ratio - 7.97
        tempo = np.sqrt(2.0 * GRAVITY / self.beam_m)
        beat = np.maximum(np.abs(met.encounter) / tempo, 0.01)  # slower, the fit is 0 to the last digit
        inviscid = self.beam_m**2 * tempo * a * np.exp(b * beat**-1.3) * beat**d / (GRAVITY * self.stability_m)
        return inviscid + self.roll_damping * self.natural_roll_s / np.pi


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
        met = _met(kx, ky, omega, heading_deg, speed_m_s, depth_m)
        beat = np.where(np.abs(met.encounter) < _SLOW, _SLOW, met.encounter)[..., None, None]
        low, high, part = _between(self.omega, np.abs(met.encounter))
        added, damping = (
            each[low] + part[..., None, None] * (each[high] - each[low]) for each in (self.added_mass, self.damping)
        )
        impedance = self.stiffness - beat**2 * (self.mass + added) - 1j * beat * damping
        motions = np.linalg.solve(impedance, self._force(met, depth_m)[..., None])[..., 0]
        heave, roll, pitch = (motions[..., self.dofs.index(name)] for name in _FREE)
        return Responses(heave, roll, -pitch)  # with y to port, a positive turn about it puts the bow down

    def _force(self, met: _Met, depth_m: float) -> Complex:
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
        with xr.open_dataset(path, engine="h5netcdf") as file:
            held = file.load()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; give the path of a NetCDF file of Capytaine") from None
    except Exception as error:  # h5py, h5netcdf and xarray each have their own for a file of another make
        raise InputError(f"{path}: cannot be read as NetCDF-4 ({error}); save the dataset in that form") from None
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


@dataclass(frozen=True)
class _Met:
    """Waves as a boat meets them."""

    k: Real  # rad/m
    ahead: Real  # rad/m, of the wavevector towards the bow
    starboard: Real
    sigma: Real  # rad/s, intrinsic: with it the water moves
    encounter: Real  # rad/s; negative of waves that the boat overtakes

    @property
    def pull(self) -> Real:
        """ωₑ²/g [rad/m]: the wavenumber of waves that the boat sends out, in deep water."""
        return self.encounter**2 / GRAVITY


def _met(kx: ArrayLike, ky: ArrayLike, omega: ArrayLike, heading_deg: float, speed_m_s: float, depth_m: float) -> _Met:
    for name, value in (("heading_deg", heading_deg), ("speed_m_s", speed_m_s)):
        if not np.isfinite(value):
            raise ValueError(f"{name} = {value:g}: must be finite; give the boat's way over ground")
    east, north, omega = np.broadcast_arrays(*(np.asarray(each, dtype=np.float64) for each in (kx, ky, omega)))
    bow_east, bow_north = unit_from_azimuth(heading_deg)
    k, ahead = np.hypot(east, north), east * bow_east + north * bow_north
    sigma = angular_frequency(k, depth_m, surface_tension=0.0)
    return _Met(k, ahead, east * bow_north - north * bow_east, sigma, omega - speed_m_s * ahead)


def _relative(met: _Met, draught_m: float, added_m: float, damping: Real, depth_m: float) -> Complex:
    """Heave over the mean wave: the water moves stiffness, added mass and damping, the boat these and its own mass.

    added_m: m of water that weigh as the added mass. damping: times frequency, over the stiffness, at the encounter.
    """
    moved = 1.0 - met.pull * (draught_m + added_m) - 1j * np.sign(met.encounter) * damping
    driven = damping * met.sigma / np.maximum(np.abs(met.encounter), 1e-12)
    force = 1.0 - met.sigma**2 / GRAVITY * added_m - 1j * driven
    return _smith(met.k, draught_m, depth_m) * force / moved


def _smith(k: Real, draught_m: float, depth_m: float) -> Real:
    """A wave's pressure at the keel over that at the surface (Smith 1883); a keel on the ground feels the ground's."""
    if np.isinf(depth_m):
        return np.exp(-k * draught_m)
    keel, clear = min(draught_m, depth_m), max(depth_m - draught_m, 0.0)
    return np.exp(-k * keel) * (1.0 + np.exp(-2.0 * k * clear)) / (1.0 + np.exp(-2.0 * k * depth_m))


def _lever(half: Real) -> Real:
    """Share of a wave's slope that tilts a box, 3 (sin s − s cos s)/s³ of s = k L/2."""
    s = np.maximum(np.abs(half), 1e-2)  # below, 1 − s²/10 is exact to 1e-11
    return np.where(np.abs(half) < 1e-2, 1.0 - half**2 / 10.0, 3.0 * (np.sin(s) - s * np.cos(s)) / s**3)


def _over_disc(across: Real) -> Real:
    """Mean of a wave over a disc, 2 J₁(ka)/(ka)."""
    x = np.maximum(across, 1e-9)
    return 2.0 * j1(x) / x


def _check_sizes(**sizes: float) -> None:
    for name, size in sizes.items():
        if not (np.isfinite(size) and size > 0.0):
            unit = "seconds" if name.endswith("_s") else "metres"
            raise ValueError(f"{name} = {size:g}: must be finite and above 0; give it in {unit}")


__all__ = ["Box", "Disc", "Follower", "Responses", "Vessel", "read_capytaine"]
