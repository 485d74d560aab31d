"""How well the waves at a place and a moment are known: what was seen along the way of each group of waves.

A group of waves of wavevector k moves with its group velocity, and what was seen of the sea wherever it went is seen of
it. Of a sea of density F(k) [m⁴] that was seen with the information Q (Σ w per square metre, of all turns) along a
group's way, the share 1/(1 + 2π² F Q) of its variance stays open: the diagonal of the fit's own covariance, for waves
that observations meet many times a wavelength. A wave and the one that runs against it look the same at a moment, and
part only as time goes: what is known of their sum alone stays open too. Waves that no lattice carries, and groups that
came from where nothing was seen, stay open altogether. Long waves, which shadows leave gaps of their own length in, are
left to samples of the fit (`ensemble`).

What free waves get wrong of the sea that they know is a law in time, whose two figures later turns tell.
Waves of a real sea are changed by those around them: high groups run faster, waves trade energy, currents are not the
same everywhere. A wave whose frequency is wrong by δ is wrong in phase by δτ a time τ after it was seen, and what it
has wrong is 2 − 2 cos δτ of its variance, or 2 − 2 exp(−½ δ²τ²) where δ is normal. What does not grow with time, bound
waves say, is a share of its own.

δ on a sea of waves is known before the first comparison. A group of complex envelope A and wavenumber k runs
by ½ k² |A|² ω faster than low waves do (Stokes 1847). On a Gaussian sea of variance m, of ⟨|A|²⟩ = 2m, that moves
waves as 2 k² m ω would in the mean over their energy, which amplitude dispersion is (`physics.amplitude_dispersion`).
What is left of it, ½ k² ω (|A|² − 4m) A, has the variance (½ k² ω)² times ⟨|A|⁶⟩ − 8m ⟨|A|⁴⟩ + 16m² ⟨|A|²⟩ = 16 m³
in place of that of A, 2m: frequencies scatter by √2 k² m ω, rms, while groups hold together.

Three things that waves may do tell where that is wrong. Waves that each drift for themselves, or trade energy, are
wrong everywhere alike; a group that is carried along by others is wrong as its own energy is; one that scatters by its
own height is wrong where groups are high: with u = |A|²/2m, for which a Gaussian sea has exp(−u), by 1, u and u³/6. How
much each has is not known: a third of the mean square is each one's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter, map_coordinates
from scipy.optimize import nnls

from .assimilation import Batch
from .observations import damped
from .spectrum import Field, Lattice, Spectrum

_RINGS, _WAYS = 4, 2  # of the spectrum's rings and directions that make a group
_DROPPED = 1e-3  # of the sea's variance, held by the weakest groups together
_SQUARES = 8.0  # a wavelength of the peak
_GROUP = 0.05  # of that wavelength: by which what was seen is spread out, so that no square is missed
_EXTENT = 0.6  # of its own wavelength, that a group reaches to every side
_AROUND = ((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))


@dataclass(frozen=True)
class Groups:
    """Groups of waves, arrays (group,)."""

    k: Field  # rad/m
    toward: Field  # rad
    omega: Field  # rad/s, over ground
    frequency: Field  # rad/s, intrinsic
    east: Field  # m/s, group velocity over ground
    north: Field
    variance: Field  # m²
    density: Field  # m⁴
    against: Field  # m⁴, of the waves that run the other way

    def __getitem__(self, chosen: NDArray[np.bool_]) -> Groups:
        """The groups of a mask."""
        return Groups(*(getattr(self, each.name)[chosen] for each in fields(self)))

    @classmethod
    def of(cls, spectrum: Spectrum) -> Groups:
        """The groups of a spectrum."""
        variance = _blocks(spectrum.variances)
        share = np.maximum(variance, 1e-300)
        area = _blocks(spectrum.areas)
        log_k = _blocks(spectrum.variances * np.log(spectrum.k)[:, None]) / share
        way = _blocks(np.ones_like(spectrum.table) * np.arange(spectrum.toward.size)) / (_RINGS * _WAYS)
        order = np.argsort(variance.ravel())
        kept = np.sort(order[np.cumsum(variance.ravel()[order]) > _DROPPED * variance.sum()])
        k = np.exp(log_k.ravel()[kept])
        toward = way.ravel()[kept] * (spectrum.toward[1] - spectrum.toward[0])
        water = spectrum.water
        speed, (drift_east, drift_north) = water.group_speed(k), water.current
        frequency = water.frequency(k)
        omega = spectrum.omega(k * np.sin(toward), k * np.cos(toward), k)
        return cls(
            k,
            toward,
            omega,
            frequency,
            speed * np.sin(toward) + drift_east,
            speed * np.cos(toward) + drift_north,
            variance.ravel()[kept] * variance.sum() / variance.ravel()[kept].sum(),
            (variance / area).ravel()[kept],
            np.roll(variance / area, variance.shape[1] // 2, axis=1).ravel()[kept],
        )


def _blocks(table: Field) -> Field:
    rings, ways = table.shape
    return table.reshape(rings // _RINGS, _RINGS, ways // _WAYS, _WAYS).sum(axis=(1, 3))


@dataclass(frozen=True)
class BatchCoverage:
    """Where one batch of observations saw the sea, on squares (east, north) of a grid: information 1/m⁴, and the mean
    variances (3, east, north) [m²] of the blur of what was seen."""

    time: float  # s
    information: NDArray[np.float32]
    blur: NDArray[np.float32]


@dataclass(frozen=True)
class Knowledge:
    """What all batches together tell of each group."""

    groups: Groups
    lattices: tuple[Lattice, ...]
    coverages: tuple[BatchCoverage, ...]
    corner: tuple[float, float]  # m, of the grid's first square's middle
    side: float  # m, of a square
    centre: tuple[float, float]  # m

    @classmethod
    def of(
        cls, spectrum: Spectrum, lattices: Sequence[Lattice], batches: Sequence[Batch], centre: tuple[float, float]
    ) -> Knowledge:
        """The knowledge that the batches of a fit give."""
        water = spectrum.water
        length = 2.0 * np.pi / float(water.wavenumber(2.0 * np.pi / spectrum.peak_period))
        side = length / _SQUARES
        x, y = (np.concatenate([getattr(batch.seen, name) for batch in batches]) for name in ("x", "y"))
        margin = 3.0 * _GROUP * length
        corner = (float(x.min()) - margin, float(y.min()) - margin)
        shape = (int((x.max() + margin - corner[0]) / side) + 2, int((y.max() + margin - corner[1]) / side) + 2)
        coverages = []
        for batch in batches:
            places = zip((batch.seen.x, batch.seen.y), corner, strict=True)
            i, j = (np.rint((each - first) / side).astype(int) for each, first in places)
            square = i * shape[1] + j
            weighed = batch.weight * np.vstack((np.ones(len(batch.seen)), batch.seen.blur.T))
            spread = np.stack(
                [
                    gaussian_filter(
                        np.bincount(square, each, shape[0] * shape[1]).reshape(shape),
                        _GROUP * _SQUARES,
                        mode="constant",
                    )
                    for each in weighed
                ]
            )
            coverages.append(
                BatchCoverage(
                    float(batch.seen.time.mean()),
                    (spread[0] / side**2).astype(np.float32),
                    (spread[1:] / np.maximum(spread[0], 1e-12)).astype(np.float32),
                )
            )
        return cls(Groups.of(spectrum), tuple(lattices), tuple(coverages), corner, side, centre)

    def open_share(self, x: Field, y: Field, time: Field, chosen: NDArray[np.bool_]) -> Field:
        """Share (point, group) of each chosen group's variance that is not known at points (point,)."""
        groups = self.groups[chosen]
        ends = [float(lattice.k[lattice.scale > 0.0].max(initial=0.0)) for lattice in self.lattices]
        short = groups.k > ends[0]
        carried = groups.k <= ends[-1]
        radius = min(lattice.radius for lattice in self.lattices)
        near = np.hypot(x - self.centre[0], y - self.centre[1]) < radius
        carried = carried & (near[:, None] | ~short)
        share = np.zeros((x.size, groups.k.size))
        if not groups.k.size:
            return share
        for east, north in _AROUND:
            offset = _EXTENT * 2.0 * np.pi / groups.k
            at = x[:, None] + east * offset, y[:, None] + north * offset
            known, both = self._information(groups, *at, time, short)
            mine, other = (2.0 * np.pi**2 * each * known for each in (groups.density, groups.against))
            alike = (both / np.maximum(known, 1e-100)) ** 2
            share += (1.0 + other) / ((1.0 + mine) * (1.0 + other) - mine * other * alike)
        return np.where(carried, share / len(_AROUND), 1.0)

    def _information(
        self, groups: Groups, x: Field, y: Field, time: Field, short: NDArray[np.bool_]
    ) -> tuple[Field, Field]:
        """What was seen along the ways of groups that pass places (point, group) at times (point,), 1/m⁴, and how much
        of it the waves that run against them share."""
        radius = min(lattice.radius for lattice in self.lattices)
        kx, ky = groups.k * np.sin(groups.toward), groups.k * np.cos(groups.toward)
        total, both = np.zeros(x.shape), np.zeros(x.shape, np.complex128)
        for coverage in self.coverages:
            lapse = (time - coverage.time)[:, None]
            at = x - groups.east * lapse, y - groups.north * lapse
            place = [(each - corner) / self.side for each, corner in zip(at, self.corner, strict=True)]
            seen = map_coordinates(coverage.information, place, order=1, cval=0.0)
            blur = np.stack([map_coordinates(each, place, order=1, cval=0.0) for each in coverage.blur], axis=-1)
            if np.isfinite(radius):
                seen = np.where(short & (np.hypot(at[0] - self.centre[0], at[1] - self.centre[1]) > radius), 0.0, seen)
            seen = seen * damped(blur, kx, ky) ** 2
            total += seen
            both += seen * np.exp(2j * groups.frequency * (coverage.time - self.coverages[0].time))
        return total, np.abs(both)


_STILL = 0.015  # of what is known, before the first comparison: as it was on seas of waves of Airy
_TRUSTED = 0.2  # turns that the value of before the first comparison counts for
_SLOW = 0.004  # rad/s, within which no first guess of the drift is sure: a tenth of a radian in half a minute
_LEAST = 1e-4  # of what is known, that no turn tells
_PASSES = 8  # of the weights, which follow what is found


@dataclass(frozen=True)
class ModelError:
    """Share of what is known that is wrong nevertheless: `still`, and more as waves drift out of phase, by `drift`
    [rad/s, rms] from when they were seen, at `since` [s], on."""

    still: float = 0.0
    drift: float = 0.0
    since: float = 0.0

    @classmethod
    def expected(cls, spectrum: Spectrum) -> ModelError:
        """The model error expected before the first comparison."""
        return cls(_STILL, scatter(spectrum))

    def share(self, time: Field, height: Field) -> Field:
        """The share at some times [s], of groups whose energy is `height` times that of all in the mean. More than 1 is
        wrong of high groups whose phases nobody knows any more."""
        turned = 0.5 * (self.drift * (time - self.since)) ** 2
        alone, own = -np.expm1(-turned), -np.expm1(-turned * height**2 / 6.0)
        return np.minimum(self.still, 1.0) + 2.0 / 3.0 * (alone + height * (alone + own))

    def kept_share(self, time: Field, height: Field) -> Field:
        """Share of the known waves that a forecast keeps, at most 1: where a share w of them is wrong, they and the sea
        correlate by 1 − w/2, and with that factor a forecast errs least, by 1 − (1 − w/2)² of their variance."""
        return np.clip(1.0 - 0.5 * self.share(time, height), 0.0, 1.0)


def height_of(waves: NDArray[np.complexfloating], known: ArrayLike) -> Field:
    """u of groups that complex sums of waves are of, by the variance that they have in the mean."""
    return 0.5 * np.abs(waves) ** 2 / np.maximum(known, 1e-12)


def scatter(spectrum: Spectrum) -> float:
    """rad/s, rms, of the frequencies of a sea's waves as its groups are high or low: on deep water, and by order of
    magnitude elsewhere."""
    omega = 2.0 * np.pi / spectrum.peak_period
    k = float(spectrum.water.wavenumber(omega))
    return np.sqrt(2.0) * k**2 * spectrum.variance * omega


@dataclass(frozen=True)
class ErrorSample:
    """What one turn showed of an earlier field: the share of its knowledge that was wrong, and the share that it held
    open; what it should have wrong for each (rad/s)² of drift [s²]; and how much that counts, in turns."""

    wrong: float
    open: float
    drifted: float
    weight: float = 1.0


def fit_model_error(samples: Sequence[ErrorSample], spectrum: Spectrum, since: float) -> ModelError:
    """The model error of waves seen at `since` [s] by all samples: least squares, in which shares err by as much as
    they are, also what is taken before the first sample."""
    before = ModelError.expected(spectrum)
    first = np.array([before.still, before.drift**2])
    doubt = np.array([0.0, _SLOW**2])
    rows = np.array([(1.0, each.drifted) for each in samples]).reshape(-1, 2)
    wrong, opened, weight = (
        np.array([getattr(each, name) for each in samples]) for name in ("wrong", "open", "weight")
    )
    found = first
    for _ in range(_PASSES):
        loose = np.diag(np.sqrt(_TRUSTED) / (np.maximum(first, found) + doubt))
        sure = np.sqrt(weight) / np.maximum(opened + rows @ found, _LEAST)
        found, _ = nnls(np.vstack((sure[:, None] * rows, loose)), np.concatenate((sure * wrong, loose @ first)))
    return ModelError(float(found[0]), float(np.sqrt(found[1])), since)
