"""What free waves get wrong of the sea that they know: a law in time, whose two figures later turns tell.

Waves of a real sea are changed by those around them: high groups run faster, waves trade energy, currents are not the
same everywhere. A wave whose frequency is wrong by δ is wrong in phase by δτ a time τ after it was seen, and what it
has wrong is 2 − 2 cos δτ of its variance, or 2 − 2 exp(−½ δ²τ²) where δ is normal. What does not grow with time, bound
waves say, is a share of its own.

How large δ is on a sea of waves is known before any turn has told. A group of complex envelope A and wavenumber k runs
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
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import nnls

from .spectrum import Spectrum

Field = NDArray[np.float64]

_STILL = 0.015  # of what is known, before any turn has told: as it was on seas of waves of Airy
_TRUSTED = 0.2  # turns that what is taken before any has told counts for
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
        """Of a sea of which no turn has told yet."""
        return cls(_STILL, scatter(spectrum))

    def share(self, time: Field, height: Field) -> Field:
        """At some times [s], of groups whose energy is `height` times that of all in the mean. More than 1 is wrong of
        high groups whose phases nobody knows any more."""
        turned = 0.5 * (self.drift * (time - self.since)) ** 2
        alone, own = -np.expm1(-turned), -np.expm1(-turned * height**2 / 6.0)
        return np.minimum(self.still, 1.0) + 2.0 / 3.0 * (alone + height * (alone + own))

    def kept(self, time: Field, height: Field) -> Field:
        """What is worth keeping of what is known, at most all: with a share w of it wrong it and the sea correlate by
        1 − w/2, and by so much a forecast errs least, by 1 − (1 − w/2)² of it."""
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
class Told:
    """What one turn told of an earlier field: the share of what that knew that it had wrong, and the share that it said
    was open; what it should have wrong for each (rad/s)² of drift [s²]; and how much that counts, in turns."""

    wrong: float
    open: float
    drifted: float
    weight: float = 1.0


def likely(told: Sequence[Told], spectrum: Spectrum, since: float) -> ModelError:
    """The model error of waves seen at `since` [s] by all that was told: least squares, in which shares err by as much
    as they are, also what is taken before any turn has told."""
    before = ModelError.expected(spectrum)
    first = np.array([before.still, before.drift**2])
    doubt = np.array([0.0, _SLOW**2])
    rows = np.array([(1.0, each.drifted) for each in told]).reshape(-1, 2)
    wrong, opened, weight = (np.array([getattr(each, name) for each in told]) for name in ("wrong", "open", "weight"))
    found = first
    for _ in range(_PASSES):
        loose = np.diag(np.sqrt(_TRUSTED) / (np.maximum(first, found) + doubt))
        sure = np.sqrt(weight) / np.maximum(opened + rows @ found, _LEAST)
        found, _ = nnls(np.vstack((sure[:, None] * rows, loose)), np.concatenate((sure * wrong, loose @ first)))
    return ModelError(float(found[0]), float(np.sqrt(found[1])), since)
