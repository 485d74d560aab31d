"""The linear surface: all trains of the sea, added up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .wave_trains import Points, Quantity, WaveTrain


class Surface(Protocol):
    """A surface at fixed places, still water otherwise: x, y [m], t [s] are (n,)."""

    def sample(
        self, x: Points, y: Points, t: Points, quantities: Sequence[Quantity], rate: float = 0.0
    ) -> NDArray[np.float64]:
        """Quantities (quantity, n); "rate" is the rise of the water particle, w; rate: μ of the relaxed ones, 1/s."""
        ...

    def elevation_rate(self, x: Points, y: Points, t: Points, current: tuple[float, float]) -> NDArray[np.float64]:
        """∂η/∂t (n,) m/s at places that are fixed while the water is carried along by the current [m/s] east, north."""
        ...

    def folded(self, x: Points, y: Points, t: Points) -> NDArray[np.bool_]:
        """(n,): the surface stands there more than once."""
        ...


@dataclass(frozen=True)
class LinearSurface:
    """First-order (Airy 1845) waves."""

    trains: tuple[WaveTrain, ...]

    def sample(
        self, x: Points, y: Points, t: Points, quantities: Sequence[Quantity], rate: float = 0.0
    ) -> NDArray[np.float64]:
        """Quantities (quantity, n); "rate" is ∂η/∂t, and to first order the rise of the water particle."""
        if not self.trains or x.size == 0:
            return np.zeros((len(quantities), x.size))
        total = self.trains[0].sample(x, y, t, quantities, rate)
        for train in self.trains[1:]:
            total += train.sample(x, y, t, quantities, rate)
        return total

    def elevation_rate(self, x: Points, y: Points, t: Points, current: tuple[float, float]) -> NDArray[np.float64]:
        """∂η/∂t (n,) m/s, w − U·∇η."""
        if current == (0.0, 0.0):
            return self.sample(x, y, t, ("rate",))[0]
        rise, slope_east, slope_north = self.sample(x, y, t, ("rate", "slope_east", "slope_north"))
        return rise - current[0] * slope_east - current[1] * slope_north

    def folded(self, x: Points, y: Points, t: Points) -> NDArray[np.bool_]:
        """(n,): never."""
        return np.zeros(x.size, dtype=bool)
