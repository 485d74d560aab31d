"""How boats and buoys move in waves: response amplitude operators of heave, roll and pitch.

A wave is η = Re(a e^{i(k·x − ωt)}) with x east, y north; the motion at the boat's reference point, amidships in the
waterline, is Re(R a e^{i(k·x − ωt)}). Heave is positive upwards, roll with the starboard side down, pitch with the bow
up. A boat that moves meets the wave at the encounter frequency ω − k·v. A force is that
of the water's motion on the hull's stiffness, added mass and damping: the principle of relative motion (Korvin-
Kroukovsky 1955), whose two sides agree for a wave that is long against the hull.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import j1

from ..conventions import GRAVITY, unit_from_azimuth
from ..physics.dispersion import angular_frequency

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating]
Values = ArrayLike

_PERIOD = 0.8  # s/√m: roll's period times √GM over the beam, of craft below 45 m (IMCO 1973, fishing vessels' code)
_FLAT, _NARROW, _SLENDER = 6.0, 3.0, 1.0  # beam over draught: where the fits of roll damping end and change
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
        self, kx: Values, ky: Values, omega: Values, heading_deg: float, speed_m_s: Values, depth_m: float = inf
    ) -> Responses:
        """Motions in waves of wavevectors (kx east, ky north) [rad/m] and frequencies omega over ground [rad/s], on a
        heading [deg clockwise from north] at speeds over ground along it [m/s], of the broadcast shape of waves and
        speeds, in water of a depth [m]. Raises ValueError for a heading or speed that is not finite and for a depth
        ≤ 0."""
        ...


@dataclass(frozen=True)
class Follower:
    """A small raft without mass, which follows the surface: the limit of all vessels in long waves."""

    def response(
        self, kx: Values, ky: Values, omega: Values, heading_deg: float, speed_m_s: Values, depth_m: float = inf
    ) -> Responses:
        """See `Vessel.response`."""
        met = encounter_waves(kx, ky, omega, heading_deg, speed_m_s, depth_m)
        return met.responses(np.ones(met.k.shape), -1j * met.starboard, 1j * met.ahead)


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
        self, kx: Values, ky: Values, omega: Values, heading_deg: float, speed_m_s: Values, depth_m: float = inf
    ) -> Responses:
        """See `Vessel.response`."""
        met = encounter_waves(kx, ky, omega, heading_deg, speed_m_s, depth_m)
        radius = 0.5 * self.diameter_m
        radiated = met.pull * radius
        # ω B / C with B = ω k |F|²/(2 ρ g²), of the force F = C e^{−kT} 2 J₁(ka)/(ka) of a wave of that frequency.
        damping = 0.5 * np.pi * (radiated * np.exp(-met.pull * self.draught_m) * _disc_mean(radiated)) ** 2
        share = _disc_mean(met.k * radius)
        heave = _relative(met, self.draught_m, self._added_draught, damping, depth_m) * share
        return met.responses(heave, -1j * met.starboard * share, 1j * met.ahead * share)


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
        self, kx: Values, ky: Values, omega: Values, heading_deg: float, speed_m_s: Values, depth_m: float = inf
    ) -> Responses:
        """See `Vessel.response`."""
        met = encounter_waves(kx, ky, omega, heading_deg, speed_m_s, depth_m)
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

    def _roll_damping(self, met: EncounterWaves) -> Real:
        """Roll damping over the stiffness [s]: the paper's fit of a section's damping, and what the user adds."""
        ratio = np.clip(self.beam_m / self.draught_m, _SLENDER, _FLAT)
        if ratio >= _NARROW:
            a, b, d = 0.256 * ratio - 0.286, -0.11 * ratio - 2.55, 0.033 * ratio - 1.419
        else:
            a, b, d = -3.94 * ratio + 13.69, -2.12 * ratio - 1.89, 1.16 * ratio - 7.97
        tempo = np.sqrt(2.0 * GRAVITY / self.beam_m)
        beat = np.log(np.maximum(np.abs(met.encounter) / tempo, 0.01))  # slower, the fit is 0 to the last digit
        fit = a * np.exp(b * np.exp(-1.3 * beat) + d * beat)
        inviscid = self.beam_m**2 * tempo * fit / (GRAVITY * self.stability_m)
        return inviscid + self.roll_damping * self.natural_roll_s / np.pi


@dataclass(frozen=True)
class EncounterWaves:
    """Waves as a boat meets them; encounters by speed too."""

    k: Real  # rad/m
    ahead: Real  # rad/m, of the wavevector towards the bow
    starboard: Real
    sigma: Real  # rad/s, intrinsic: with it the water moves
    encounter: Real  # rad/s; negative of waves that the boat overtakes

    @property
    def pull(self) -> Real:
        """ωₑ²/g [rad/m]: the wavenumber of waves that the boat sends out, in deep water."""
        return self.encounter**2 / GRAVITY

    def responses(self, *motions: NDArray[np.inexact]) -> Responses:
        """Motions of which some are alike at all speeds."""
        return Responses(*(np.broadcast_to(each, self.encounter.shape).astype(np.complex128) for each in motions))


def encounter_waves(
    kx: Values, ky: Values, omega: Values, heading_deg: float, speed_m_s: Values, depth_m: float = inf
) -> EncounterWaves:
    """How a boat meets waves: see `Vessel.response`."""
    for name, value in (("heading_deg", heading_deg), ("speed_m_s", speed_m_s)):
        if not np.isfinite(value).all():
            raise ValueError(f"{name} = {np.asarray(value)}: must be finite; give the boat's way over ground")
    east, north, omega = np.broadcast_arrays(*(np.asarray(each, dtype=np.float64) for each in (kx, ky, omega)))
    bow_east, bow_north = unit_from_azimuth(heading_deg)
    k, ahead = np.hypot(east, north), east * bow_east + north * bow_north
    sigma = angular_frequency(k, depth_m, surface_tension=0.0)
    return EncounterWaves(k, ahead, east * bow_north - north * bow_east, sigma, omega - np.asarray(speed_m_s) * ahead)


def _relative(met: EncounterWaves, draught_m: float, added_m: float, damping: Real, depth_m: float) -> Complex:
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


def _disc_mean(across: Real) -> Real:
    """Mean of a wave over a disc, 2 J₁(ka)/(ka)."""
    x = np.maximum(across, 1e-9)
    return 2.0 * j1(x) / x


def _check_sizes(**sizes: float) -> None:
    for name, size in sizes.items():
        if not (np.isfinite(size) and size > 0.0):
            unit = "seconds" if name.endswith("_s") else "metres"
            raise ValueError(f"{name} = {size:g}: must be finite and above 0; give it in {unit}")


__all__ = ["Box", "Disc", "EncounterWaves", "Follower", "Responses", "Vessel", "encounter_waves"]
