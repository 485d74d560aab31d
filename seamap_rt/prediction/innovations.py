"""What later turns tell of a fit: how large the errors of its forecasts are, how waves run otherwise than assumed.

What a turn sees, less what an earlier field forecast for it, holds the forecast's error and the observation's own. The
observations of looks that do not overlap err independently, but a forecast's error is that of waves, and spans them: so
the covariance of such differences between looks a few metres apart is that of the forecast (Hollingsworth & Lönnberg
1986), whatever the observations' errors are. How it grows from sooner to later turns tells the law of `model_error`.

Of a fit whose observations are from about t₀, a current U that it does not have leaves −(t − t₀) U·∇η of what comes at
t, and so does amplitude dispersion with Δω in place of k·U for each wave (`physics.amplitude_dispersion`). Residuals of
each new turn are regressed on both together, for a current does to waves of one length what the other does, and the
lengths tell them apart; where a current alone is far off it is put right first. What is known of the current is where
the search begins.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from ..physics.dispersion import Water
from .assimilation import Batch
from .field import WaveField
from .fit import Fit
from .knowledge import ErrorSample, ModelError, fit_model_error, height_of
from .observations import Observations, damped
from .spectrum import Field

_APART = 2  # looks: beams of neighbouring ones overlap
_ABREAST = 0.75  # m, of distance from the antennas: the same gate, or nearly
_FARTHEST_M = 5.0  # that two looks of a pair are apart
_PAIRS = 40  # for which the stated covariance is worked out
_NEARBY_M = 80.0  # within which looks are compared: farther out they lie too far apart
_FEWEST_PAIRS = 200  # pairs of looks, for their covariance to stand out from its chance
_AGO = 15  # fields before a turn, of which it is compared with one: half as far ahead as forecasts are for
_SOONER = 3  # of that, each second turn: this separates what grows with time from what does not
_FORGOTTEN = 0.9  # of the weight of samples, from one turn to the next
_KEPT = 40  # samples: what is older counts for a hundredth


class Innovations:
    """Errors of earlier fields, as the last turns show them."""

    def __init__(self, seed: int = 0) -> None:
        self._before: deque[WaveField] = deque(maxlen=_AGO)
        self._samples: deque[ErrorSample] = deque(maxlen=_KEPT)
        self._stream = np.random.default_rng(seed)

    def remember(self, field: WaveField) -> None:
        """A field, for turns that come; without the squares of what was seen, which are large and not asked for."""
        self._before.append(replace(field, knowledge=replace(field.knowledge, coverages=())))

    def compare(self, fit: Fit, number: int) -> None:
        """Takes up what one turn tells of an earlier field that rests on not much less than the fit."""
        for n, each in enumerate(self._samples):
            self._samples[n] = replace(each, weight=_FORGOTTEN * each.weight)
        rows = enumerate(reversed(self._before), 1)
        ago = max((n for n, each in rows if 2 * each.turns >= fit.turns and fit.shares(each)), default=0)
        if number % 2:
            ago = -(-ago // _SOONER)
        if not ago:
            return
        earlier = self._before[-ago]
        for batch in fit.batches[number]:
            pairs = pairs_of_looks(batch.seen, fit.centre, min(fit.lattices[-1].radius, _NEARBY_M))
            if len(pairs) < _FEWEST_PAIRS or batch.seen.kind[0] != "elevation":
                continue
            waves = _waves(batch, earlier)
            difference = (fit.remove_setdown(batch) - waves.real).astype(np.float64)
            found, stated, known = compared(batch.seen, difference, earlier, pairs, self._stream)
            if known > 0.0:
                lapse = float(batch.seen.time.mean()) - earlier.model_error.since
                drifted = lapse**2 * weight_of_groups(waves, pairs, known)
                self._samples.append(ErrorSample((found - stated) / known, stated / known, drifted))

    def model_error(self, fit: Fit) -> ModelError:
        """The model error of a field by the present fit."""
        return fit_model_error(self._samples, fit.spectrum, fit.middle)


def _waves(batch: Batch, field: WaveField) -> NDArray[np.complex128]:
    """Complex sums (n,) of a field's waves at a batch's places, m."""
    now, later = (batch.sum.values([np.complex64(part) * a for a in field.amplitudes]) for part in (1.0, -1j))
    return now + 1j * later


def weight_of_groups(waves: NDArray[np.complexfloating], pairs: NDArray[np.intp], known: float) -> float:
    """What waves that drift have wrong in pairs' products, over known and drift², by how high groups are: 1 in the mean
    of Gaussian seas. waves: complex sums (n,); known: m², expected of the pairs' products."""
    one, other = waves[pairs[:, 0]], waves[pairs[:, 1]]
    both = np.real(one * np.conj(other))
    alike = float(np.mean(both) / np.mean(np.abs(one) ** 2))  # a pair is apart
    if not alike > 0.0:
        return 1.0
    height = height_of(one, known / alike)
    return float(np.mean(1.0 + 0.5 * both / known * (1.0 + height**2 / 6.0))) / 3.0


def pairs_of_looks(seen: Observations, centre: tuple[float, float], radius: float) -> NDArray[np.intp]:
    """Pairs (pair, 2) of one turn's observations abreast of each other, two looks apart, within a radius [m]."""
    away = np.hypot(seen.x - centre[0], seen.y - centre[1])
    near = np.flatnonzero(away < radius)
    moments = np.unique(seen.time[near])
    if near.size < 2 or moments.size < 2 * _APART:
        return np.zeros((0, 2), np.intp)
    tree = KDTree(np.stack((seen.x[near], seen.y[near]), axis=1))
    pairs = near[tree.query_pairs(_FARTHEST_M, output_type="ndarray")]
    look = np.rint(seen.time / np.median(np.diff(moments)))
    apart = np.abs(look[pairs[:, 0]] - look[pairs[:, 1]])
    return pairs[(apart == _APART) & (np.abs(away[pairs[:, 0]] - away[pairs[:, 1]]) < _ABREAST)]


def compared(
    seen: Observations, difference: Field, field: WaveField, pairs: NDArray[np.intp], stream: np.random.Generator
) -> Field:
    """Mean product of differences (n,) [m] over the pairs, what the field that forecast them states for it, and what
    the waves that it knows have of it [m²]."""
    found = float(np.mean(difference[pairs[:, 0]] * difference[pairs[:, 1]]))
    one, other = stream.choice(pairs, min(_PAIRS, len(pairs)), replace=False).T
    groups = field.knowledge.groups
    kx, ky = groups.k * np.sin(groups.toward), groups.k * np.cos(groups.toward)
    lag = np.multiply.outer(seen.x[one] - seen.x[other], kx) + np.multiply.outer(seen.y[one] - seen.y[other], ky)
    lag -= np.multiply.outer(seen.time[one] - seen.time[other], groups.omega)
    blurred = damped(seen.blur[one][:, None], kx, ky) ** 2
    waves = float(np.mean(np.sum(groups.variance * blurred * np.cos(lag), axis=1)))
    lattice = field.members[0].lattice
    blur = damped(seen.blur[one].mean(axis=0), lattice.kx, lattice.ky).astype(np.complex128)
    missed = [field.samples([blur], seen.x[each], seen.y[each], seen.time[each])[0] for each in (one, other)]
    stated = 0.5 * float(np.mean(np.real(missed[0] * np.conj(missed[1]))))
    return np.array([found, stated, waves - stated])


_TELLING = 0.03  # m/s: of less a forecast half a minute ahead hardly knows
_SURE = 6.0  # standard errors of residuals that err independently; neighbouring ones, and turns, err alike
_RIDGE = 0.02  # of the evidence along the waves: few of them show the current across
_FEWEST_TURNS = 6  # turns that a fit rests on, before which it knows too little of waves between the places it saw
_FASTEST = 3.0  # m/s, that currents are looked for
_FAR = 0.2  # m/s: waves that lay so far off were fitted badly, short ones worst: what they said is of no use any more
_MOST = 1.5  # of amplitude dispersion: a spectrum that is given a third too low is put right too
_STEP = 0.1  # of it, that is worth a new fit: on a sea of Hs/λ 1/20 0.04 rad in half a minute
_UNKNOWN = 0.5  # of it, before the first comparison: on gentle seas and shallow water none ever does
_DOUBT = 0.01  # of its evidence: a current explains nearly the same, and is what is believed where either would do


class Drift:
    """What is known of a current beside the one that was given, m/s east and north, and of the share of amplitude
    dispersion that waves run by. amplitude_dispersion: that share, where it is known."""

    def __init__(self, amplitude_dispersion: float | None = None) -> None:
        self._known = amplitude_dispersion is not None
        self._ways = np.array([0.0, 0.0, amplitude_dispersion or 0.0])
        self._matrix, self._vector = np.zeros((3, 3)), np.zeros(3)

    @property
    def current(self) -> NDArray[np.float64]:
        """m/s (2,), beside the one that was given."""
        return self._ways[:2]

    @property
    def amplitude_dispersion(self) -> float:
        """The share that waves run by."""
        return float(self._ways[2])

    def water(self, assumed: Water) -> Water:
        """The water as it runs."""
        east, north = (float(a + b) for a, b in zip(assumed.current, self.current, strict=True))
        return replace(assumed, current=(east, north))

    def learn(self, fit: Fit, number: int) -> bool:
        """Takes up what a turn that the fit does not rest on yet says; whether the waves run otherwise now."""
        if fit.turns <= _FEWEST_TURNS:  # the new one too
            return False
        matrix, vector = fit.drift_evidence(number, amplitudes=not self._known)
        self._matrix = _FORGOTTEN * self._matrix + matrix
        self._vector = _FORGOTTEN * self._vector + vector + matrix @ self._ways
        ridge = _RIDGE * float(np.trace(self._matrix[:2, :2]))
        if not ridge > 0.0:
            return False
        loose = np.diag([ridge, ridge, _DOUBT * float(self._matrix[2, 2]) + _UNKNOWN**-2])
        alone = self._likely_current(float(self._ways[2]), loose)
        if self._known:
            return self._accept_innovations(alone)
        if float(np.hypot(*(alone - self._ways)[:2])) > _FAR and self._accept_innovations(alone):
            self._matrix, self._vector = np.zeros((3, 3)), np.zeros(3)
            return True
        # Drawn to the current of now, not to none: what that holds of it back would be taken for amplitude dispersion.
        likely = self._vector + loose @ np.append(self._ways[:2], 0.0)
        share = float(np.clip(np.linalg.solve(self._matrix + loose, likely)[2], 0.0, _MOST))
        return self._accept_innovations(self._likely_current(share, loose))

    def _likely_current(self, share: float, loose: NDArray[np.float64]) -> NDArray[np.float64]:
        """The current that is likely beside a share of amplitude dispersion, and that share, (3,)."""
        rest = self._vector[:2] - self._matrix[:2, 2] * share
        current = np.linalg.solve((self._matrix + loose)[:2, :2], rest)
        return np.append(np.clip(current, -_FASTEST, _FASTEST), share)

    def _accept_innovations(self, found: NDArray[np.float64]) -> bool:
        """Takes it up where it is worth a new fit and sure enough; whether it did."""
        change = found - self._ways
        small = float(np.hypot(*change[:2])) < _TELLING and abs(change[2]) < _STEP
        if small or float(change @ self._matrix @ change) < _SURE**2:
            return False
        self._ways = found
        return True
