"""Motions of a vessel on many courses through the sea ahead: expected, drawn, and by the sea state alone.

On a course of velocity U a wave η = Re(a e^{i(k·x − ωt)}) is met at the encounter frequency ωₑ = ω − k·U, in water of
any depth, and each motion is a sum over the waves of R a e^{−iωₑt}: one transform in time for a course (Barnett,
Magland & af Klinteberg 2019). R is the vessel's own (`vessel`, `capytaine`): in waves that are long against the boat
all of them lie on the surface as a raft does. Forward speed counts in ωₑ alone; lift, trim, planing, surf-riding and
the change of added mass and damping by speed are not modelled. Courses are straight and held from the first moment.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import finufft
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..compute.machine import pool
from ..conventions import GRAVITY, unit_from_azimuth
from ..errors import InputError
from .field import WaveField
from .knowledge import height_of
from .phasors import phasors
from .quantity import Course
from .spectrum import Field
from .vessel import Box, Disc, Vessel

Envelope = NDArray[np.complex128]

QUANTITIES = ("heave", "roll", "pitch", "acceleration", "bow")  # m, rad, rad, m/s², m (bow over the water there)
_HELD = 0.999  # of the expected sea's power, in the waves that sums are made of
_SPECTRAL, _ERRORS = 0.99, 0.97  # of the spectrum's variance; of that in the groups that errors are drawn from
_COARSE_S = 5.0  # between leads at which samples of what is open are taken
_TOGETHER = 2  # decimals [m, s] of places that are one
_EXACT = 1e-4  # of the transforms, relative
_OCHI = 0.093  # re-entry speed of a slam over √(g L) (Ochi 1964)


@dataclass(frozen=True)
class Hull:
    """Places on board and sizes of the bow, m from the boat's reference point.

    place_m: forward and starboard of it, where the vertical acceleration is wanted. bow_m: how far forward the bow is;
    draught_m there, freeboard_m there, slam_speed_m_s: of the re-entry that counts as a slam; None: not known.
    """

    place_m: tuple[float, float] = (0.0, 0.0)
    bow_m: float | None = None
    draught_m: float | None = None
    freeboard_m: float | None = None
    slam_speed_m_s: float | None = None

    def __post_init__(self) -> None:
        if not np.isfinite(self.place_m).all():
            raise InputError(f"hull.place_m = {self.place_m}: must be finite; give metres forward and starboard")
        for name in ("bow_m", "draught_m", "freeboard_m", "slam_speed_m_s"):
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value > 0.0):
                raise InputError(f"hull.{name} = {value:g}: must be finite and above 0; leave it out if unknown")

    @classmethod
    def of(cls, vessel: Vessel) -> Hull:
        """What a vessel's sizes give; slams by Ochi's (1964) threshold, 0.093 √(g L)."""
        if isinstance(vessel, Box):
            return cls(bow_m=0.5 * vessel.length_m, draught_m=vessel.draught_m).with_threshold()
        if isinstance(vessel, Disc):
            return cls(bow_m=0.5 * vessel.diameter_m, draught_m=vessel.draught_m).with_threshold()
        return cls()

    def with_threshold(self) -> Hull:
        """The same with Ochi's threshold of slams, where a bow is known and no threshold."""
        if self.bow_m is None or self.slam_speed_m_s is not None:
            return self
        return replace(self, slam_speed_m_s=_OCHI * float(np.sqrt(2.0 * GRAVITY * self.bow_m)))


@dataclass(frozen=True)
class Waves:
    """Plane waves (wave,): wavevectors east and north [rad/m], frequencies over ground [rad/s]."""

    kx: Field
    ky: Field
    omega: Field

    def encounter(self, way: Way) -> Field:
        """rad/s, (…, wave): ω − k·U."""
        heading, speed = way
        east, north = unit_from_azimuth(heading)
        return self.omega - np.asarray(speed) * (self.kx * east + self.ky * north)

    def phasors(self, course: Course, lead: Field) -> Envelope:
        """e^−jωₑt (moment, wave) at leads [s]."""
        x, y = (course.speed_m_s * part * lead for part in unit_from_azimuth(course.heading_deg))
        return phasors(self.kx, self.ky, self.omega, x, y, lead)


Way = tuple[float, ArrayLike]  # a course, or a heading [deg] and speeds (…, 1) [m/s]
Shares = Callable[[Waves, Way], Envelope]  # (quantity, …, wave) per metre of amplitude


@dataclass(frozen=True)
class Transfers:
    """Motions per metre of wave amplitude (course, quantity, wave) of a sea's expected waves, groups and spectrum."""

    courses: Sequence[Course]
    waves: Envelope
    groups: Envelope
    spectrum: Envelope


Expectation = tuple[Field, Field]  # expected and variance that is open, (course, quantity, moment)


def shares_of(vessel: Vessel, hull: Hull, depth_m: float) -> Shares:
    """QUANTITIES per metre of wave amplitude; of the bow 0 where it is not known."""
    forward, starboard = hull.place_m

    def shares(waves: Waves, way: Way) -> Envelope:
        met = vessel.response(waves.kx, waves.ky, waves.omega, *way, depth_m)
        made = np.zeros((len(QUANTITIES), *met.heave.shape), np.complex128)
        made[0], made[1], made[2] = met.heave, met.roll, met.pitch
        made[3] = -(waves.encounter(way) ** 2) * (met.heave + forward * met.pitch - starboard * met.roll)
        if hull.bow_m is not None:
            east, north = unit_from_azimuth(way[0])
            ahead = waves.kx * east + waves.ky * north
            made[4] = met.heave + hull.bow_m * met.pitch - np.exp(1j * hull.bow_m * ahead)
        return made

    return shares


@dataclass(frozen=True)
class SeaPrediction:
    """What is known of the sea about a boat from one moment on.

    waves, amplitudes (set, wave) [m]: expected, with phases of the boat's place at lead 0; expect: from envelopes
    (set, course, quantity, moment), leads and transfers to the expected motion and the variance that is open. groups,
    variances (group,) [m²]: of what may err, drawn_groups: of them those that errors are drawn from. spectrum, spectral
    (wave,) [m²]: the sea state.
    """

    waves: Waves
    amplitudes: Envelope
    expect: Callable[[Envelope, Field, Transfers], Expectation]
    groups: Waves
    variances: Field
    drawn_groups: NDArray[np.intp]
    spectrum: Waves
    spectral: Field

    @classmethod
    def of(cls, field: WaveField) -> SeaPrediction:
        """A wave field's, at its antennas and issue."""
        east, north = field.centre
        parts = []
        for lattice, amplitudes in zip(field.lattices, field.amplitudes, strict=True):
            turns = lattice.kx * east + lattice.ky * north - lattice.omega * field.issued
            parts.append((lattice.kx, lattice.ky, lattice.omega, amplitudes * np.exp(1j * turns)))
        kx, ky, omega, here = (np.concatenate([each[n].ravel() for each in parts]) for n in range(4))
        of = np.repeat(np.arange(len(parts)), [each[0].size for each in parts])
        kept = _strongest(np.abs(here) ** 2, _HELD)
        sets = np.where(
            of[kept] == np.arange(len(parts))[:, None], here[kept], 0.0
        )  # short waves are left out far away
        groups, spectrum = field.knowledge.groups, field.spectrum
        k, toward = (each.ravel() for each in np.meshgrid(spectrum.k, spectrum.toward, indexing="ij"))
        variances = spectrum.variances.ravel()
        strong = _strongest(variances, _SPECTRAL)
        x, y = k[strong] * np.sin(toward[strong]), k[strong] * np.cos(toward[strong])
        return cls(
            Waves(kx[kept], ky[kept], omega[kept]),
            sets,
            _OpenShares(field).expect,
            Waves(groups.k * np.sin(groups.toward), groups.k * np.cos(groups.toward), groups.omega),
            groups.variance,
            _strongest(groups.variance, _ERRORS),
            Waves(x, y, spectrum.omega(x, y, k[strong])),
            variances[strong] * spectrum.variance / variances[strong].sum(),
        )

    def transfers(self, courses: Sequence[Course], shares: Shares) -> Transfers:
        """Transfers for some courses; all waves and speeds of a heading at once."""
        sets = self.waves, self.groups, self.spectrum
        whole = Waves(*(np.concatenate([getattr(each, name) for each in sets]) for name in ("kx", "ky", "omega")))
        made = np.empty((len(courses), len(QUANTITIES), whole.kx.size), np.complex128)

        def fill_heading(heading: float) -> None:
            chosen = [number for number, course in enumerate(courses) if course.heading_deg == heading]
            speeds = np.array([[courses[number].speed_m_s] for number in chosen])
            made[chosen] = np.moveaxis(shares(whole, (heading, speeds)), 1, 0)

        with pool() as workers:
            list(workers.map(fill_heading, {course.heading_deg for course in courses}))
        ends = np.cumsum([each.kx.size for each in sets])
        return Transfers(courses, *np.split(made, ends[:-1], axis=-1))

    def envelopes(self, lead: Field, transfers: Transfers) -> Envelope:
        """Sums of the expected waves (set, course, quantity, moment) at evenly spaced leads [s] from 0 on."""
        step, count = float(lead[1] - lead[0]), lead.size
        made = np.zeros((self.amplitudes.shape[0], *transfers.waves.shape[:2], count), np.complex128)
        own = {part: np.flatnonzero(each) for part, each in enumerate(self.amplitudes) if each.any()}

        def transform_waves(number: int, course: Course, share: Envelope) -> None:
            # Moments are a transform's modes, counted from its middle.
            angle = (self.waves.encounter(course) * step + np.pi) % (2.0 * np.pi) - np.pi
            middle = self.amplitudes * self.waves.phasors(course, lead[count // 2 : count // 2 + 1])
            for part, waves in own.items():
                strengths = middle[part, waves] * share.take(waves, axis=1)
                sums: Any = finufft.nufft1d1(angle[waves], strengths, count, eps=_EXACT, isign=-1, nthreads=1)
                made[part, number] = sums

        with pool() as workers:
            list(workers.map(transform_waves, range(made.shape[1]), transfers.courses, transfers.waves))
        return made

    def expected(self, lead: Field, transfers: Transfers) -> Expectation:
        """Motions and their open variance (course, quantity, moment) at evenly spaced leads [s] from 0 on."""
        return self.expect(self.envelopes(lead, transfers), lead, transfers)

    def draw_motions(self, lead: Field, transfers: Transfers, draws: int, seed: int) -> NDArray[np.float32]:
        """Motions that may come (course, quantity, draw, moment): the expected, and errors of one sea for all courses
        of a draw, of the sea's own spectrum, as large as what is open."""
        mean, variance = self.expected(lead, transfers)
        chosen = self.drawn_groups
        stream, scale = np.random.default_rng(seed), np.sqrt(self.variances[chosen])
        normal = stream.standard_normal((draws, 2 * chosen.size), np.float32)
        made = np.empty((*mean.shape[:2], draws, lead.size), np.float32)
        groups = Waves(*(each[chosen] for each in (self.groups.kx, self.groups.ky, self.groups.omega)))

        def draw_course(number: int, course: Course) -> None:
            share = transfers.groups[number][:, chosen] * scale
            power = np.maximum(np.sum(np.abs(share) ** 2, axis=1), 1e-300)
            size = np.sqrt(variance[number] / power[:, None])
            swing = groups.phasors(course, lead).astype(np.complex64).T
            errors = share.astype(np.complex64)[:, :, None] * swing * size.astype(np.float32)[:, None]
            made[number] = normal @ np.concatenate((errors.real, -errors.imag), axis=1)
            made[number] += mean[number, :, None]

        with pool() as workers:
            list(workers.map(draw_course, range(made.shape[0]), transfers.courses))
        return made

    def moments(self, transfers: Transfers) -> tuple[Field, Field]:
        """Standard deviations (course, quantity) by the sea state, and of their rates [1/s]."""
        power = self.spectral * np.abs(transfers.spectrum) ** 2
        met = np.stack([self.spectrum.encounter(course) for course in transfers.courses])
        return np.sqrt(power.sum(axis=-1)), np.sqrt(np.einsum("cqw,cw->cq", power, met**2))


class _OpenShares:
    """The part of a wave field's sums worth keeping, and what stays open: the shares that `WaveField.predict` has
    for the elevation, at leads some seconds apart, and for short waves at the boat's first place."""

    def __init__(self, field: WaveField) -> None:
        self._field = field

    def expect(self, envelopes: Envelope, lead: Field, transfers: Transfers) -> Expectation:
        """See `SeaPrediction`."""
        field = self._field
        variances = field.knowledge.groups.variance
        powers = variances * np.abs(transfers.groups) ** 2
        whole = powers.sum(axis=-1)[..., None]
        coarse = np.linspace(lead[0], lead[-1], max(2, int(np.ceil(np.ptp(lead) / _COARSE_S)) + 1))
        kept, open_variance = self._samples(coarse, transfers.courses)
        here = np.full(coarse.size, field.centre[0]), np.full(coarse.size, field.centre[1]), field.issued + coarse
        short = np.einsum("lg,cqg->cql", field.short_share(here), powers) / np.maximum(whole, 1e-300)
        share = np.minimum(open_variance[:, None] / variances.sum() + short, 1.0)
        kept, share = _interpolate(coarse, kept, lead)[:, None], _interpolate(coarse, share, lead)
        met = field.is_within_period(*(each.ravel() for each in _ways(field, transfers.courses, lead)))
        met = met.reshape(len(transfers.courses), 1, lead.size)
        still_open = np.where(met, share, 1.0) * whole
        known = whole - still_open
        out = np.multiply.outer([course.speed_m_s for course in transfers.courses], lead)[:, None]
        near = np.stack([out < lattice.radius for lattice in field.lattices])
        waves = np.sum(envelopes * near, axis=0)
        right = field.model_error.kept_share(field.issued + lead, height_of(waves, known))
        mean = np.where(met, right * kept * waves.real, 0.0)
        return mean, still_open + known * (1.0 - right**2)

    def _samples(self, lead: Field, courses: Sequence[Course]) -> tuple[Field, Field]:
        """Share of the elevation worth keeping, and its variance left open [m²], (course, lead), by samples."""
        field = self._field
        places, number = np.unique(
            np.stack([each.ravel() for each in _ways(field, courses, lead)]).round(_TOGETHER),
            axis=1,
            return_inverse=True,
        )
        kept, missed = field.residual_elevation(*places)
        open_variance = 0.5 * np.mean(np.abs(missed) ** 2, axis=0)
        shape = len(courses), lead.size
        return kept[number].reshape(shape), open_variance[number].reshape(shape)


def _ways(field: WaveField, courses: Sequence[Course], lead: Field) -> tuple[Field, Field, Field]:
    """Places [m] and times [s] (course, moment) along courses from the antennas on."""
    toward = np.array([unit_from_azimuth(course.heading_deg) for course in courses])
    out = np.multiply.outer([course.speed_m_s for course in courses], lead)
    x, y = (first + part[:, None] * out for first, part in zip(field.centre, toward.T, strict=True))
    return x, y, np.broadcast_to(field.issued + lead, out.shape)


def _interpolate(coarse: Field, values: Field, lead: Field) -> Field:
    """Values (…, coarse) at leads between, along lines."""
    low = np.clip(np.searchsorted(coarse, lead, side="right") - 1, 0, coarse.size - 2)
    part = (lead - coarse[low]) / (coarse[low + 1] - coarse[low])
    return (1.0 - part) * values[..., low] + part * values[..., low + 1]


def _strongest(power: Field, share: float) -> NDArray[np.intp]:
    """Numbers of the strongest entries that hold a share of the power."""
    order = np.argsort(power)[::-1]
    return order[: int(np.searchsorted(np.cumsum(power[order]), share * power.sum())) + 1]


__all__ = ["QUANTITIES", "Hull", "SeaPrediction", "Transfers", "Waves", "shares_of"]
