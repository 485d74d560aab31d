"""How waves run otherwise than was told, by what it does to forecasts: a turn later they lie elsewhere.

Of a fit whose observations are from about t₀, a current U that it does not have leaves −(t − t₀) U·∇η of what comes at
t, and so does amplitude dispersion with Δω in place of k·U for each wave (`physics.amplitude_dispersion`). Residuals of
each new turn are regressed on both together, for a current does to waves of one length what the other does, and the
lengths tell them apart; where a current alone is far off it is put right first. What is told of the current is where
the search begins.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..physics.dispersion import Water
from .fit import Fit

_FORGOTTEN = 0.9  # of the evidence, from turn to turn
_TELLING = 0.03  # m/s: of less a forecast half a minute ahead hardly knows
_SURE = 6.0  # standard errors of residuals that err independently; neighbouring ones, and turns, err alike
_RIDGE = 0.02  # of the evidence along the waves: the current across them is told by few of them
_FEWEST = 6  # turns that a fit rests on, before which it knows too little of waves between the places it saw
_FASTEST = 3.0  # m/s, that currents are looked for
_FAR = 0.2  # m/s: waves that lay so far off were fitted badly, short ones worst: what they said is of no use any more
_MOST = 1.5  # of amplitude dispersion: a spectrum that is told a third too low is put right too
_STEP = 0.1  # of it, that is worth a new fit: on a sea of Hs/λ 1/20 0.04 rad in half a minute
_UNKNOWN = 0.5  # of it, before any turn has told: on gentle seas and shallow water none ever does
_DOUBT = 0.01  # of its evidence: a current explains nearly the same, and is what is believed where either would do


class Drift:
    """What is known of a current beside the one that was told, m/s east and north, and of the share of amplitude
    dispersion that waves run by. amplitude_dispersion: that share, where it is known."""

    def __init__(self, amplitude_dispersion: float | None = None) -> None:
        self._known = amplitude_dispersion is not None
        self._ways = np.array([0.0, 0.0, amplitude_dispersion or 0.0])
        self._matrix, self._vector = np.zeros((3, 3)), np.zeros(3)

    @property
    def current(self) -> NDArray[np.float64]:
        """m/s (2,), beside the one that was told."""
        return self._ways[:2]

    @property
    def amplitude_dispersion(self) -> float:
        """The share that waves run by."""
        return float(self._ways[2])

    def water(self, told: Water) -> Water:
        """The water as it runs."""
        east, north = (float(a + b) for a, b in zip(told.current, self.current, strict=True))
        return replace(told, current=(east, north))

    def learn(self, fit: Fit, number: int) -> bool:
        """Takes up what a turn that the fit does not rest on yet says; whether the waves run otherwise now."""
        if fit.turns <= _FEWEST:  # the new one too
            return False
        matrix, vector = fit.drift_evidence(number, amplitudes=not self._known)
        self._matrix = _FORGOTTEN * self._matrix + matrix
        self._vector = _FORGOTTEN * self._vector + vector + matrix @ self._ways
        ridge = _RIDGE * float(np.trace(self._matrix[:2, :2]))
        if not ridge > 0.0:
            return False
        loose = np.diag([ridge, ridge, _DOUBT * float(self._matrix[2, 2]) + _UNKNOWN**-2])
        alone = self._beside(float(self._ways[2]), loose)
        if self._known:
            return self._believed(alone)
        if float(np.hypot(*(alone - self._ways)[:2])) > _FAR and self._believed(alone):
            self._matrix, self._vector = np.zeros((3, 3)), np.zeros(3)
            return True
        # Drawn to the current of now, not to none: what that holds of it back would be taken for amplitude dispersion.
        likely = self._vector + loose @ np.append(self._ways[:2], 0.0)
        share = float(np.clip(np.linalg.solve(self._matrix + loose, likely)[2], 0.0, _MOST))
        return self._believed(self._beside(share, loose))

    def _beside(self, share: float, loose: NDArray[np.float64]) -> NDArray[np.float64]:
        """The current that is likely beside a share of amplitude dispersion, and that share, (3,)."""
        rest = self._vector[:2] - self._matrix[:2, 2] * share
        current = np.linalg.solve((self._matrix + loose)[:2, :2], rest)
        return np.append(np.clip(current, -_FASTEST, _FASTEST), share)

    def _believed(self, found: NDArray[np.float64]) -> bool:
        """Takes it up where it is worth a new fit and sure enough; whether it did."""
        change = found - self._ways
        small = float(np.hypot(*change[:2])) < _TELLING and abs(change[2]) < _STEP
        if small or float(change @ self._matrix @ change) < _SURE**2:
            return False
        self._ways = found
        return True
