"""A current that nobody told, by what it does to forecasts: a turn later the waves lie where it has carried them.

Of a fit whose observations are from about t₀, a current U that it does not have leaves −(t − t₀) U·∇η of what comes at
t. Residuals of each new turn are regressed on that. What is told of the current is where the search begins.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..physics.dispersion import Water
from .fit import Fit

_FORGOTTEN = 0.9  # of the evidence, from turn to turn
_TELLING = 0.03  # m/s: of less a forecast half a minute ahead hardly knows
_SURE = 6.0  # standard errors of residuals that err independently; neighbouring ones, and turns, err alike
_RIDGE = 0.02  # of the evidence along the waves: the current across them is told by few of them
_FEWEST = 6  # turns that a fit rests on, before which it knows too little of waves between the places it saw
_FASTEST = 3.0  # m/s, that currents are looked for


class Drift:
    """What is known of a current beside the one that was told, m/s east and north."""

    def __init__(self) -> None:
        self.current = np.zeros(2)
        self._matrix, self._vector = np.zeros((2, 2)), np.zeros(2)

    def water(self, told: Water) -> Water:
        """The water as it runs."""
        east, north = (float(a + b) for a, b in zip(told.current, self.current, strict=True))
        return replace(told, current=(east, north))

    def learn(self, fit: Fit, number: int) -> bool:
        """Takes up what a turn that the fit does not rest on yet says; whether the current is another now."""
        if fit.turns <= _FEWEST:  # the new one too
            return False
        matrix, vector = fit.drift_evidence(number)
        self._matrix = _FORGOTTEN * self._matrix + matrix
        self._vector = _FORGOTTEN * self._vector + vector + matrix @ self.current
        ridge = _RIDGE * float(np.trace(self._matrix))
        if not ridge > 0.0:
            return False
        found = np.linalg.solve(self._matrix + ridge * np.eye(2), self._vector)
        found = np.clip(found, -_FASTEST, _FASTEST)
        change = found - self.current
        if float(np.hypot(*change)) < _TELLING or float(change @ self._matrix @ change) < _SURE**2:
            return False
        self.current = found
        return True
