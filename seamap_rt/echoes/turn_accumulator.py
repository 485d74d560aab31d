"""The light and the returns of a turn, gathered from its parts into arrays that are made once.

Arrays that each part brings, kept to be joined after the last, would lie among those that are made and dropped for
every part. The holes between them are too small for what a whole turn needs next, and count as memory that is held:
0.1 to 0.2 GB of a turn of ten million facets.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mesh import Facets
from ..tracing import Illumination
from .radar_cross_section import Returns


@dataclass
class TurnAccumulator:
    """What parts of a turn of so many columns have given so far. A turn in one part is handed through."""

    columns: int
    _arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    _last: tuple[Illumination, Returns] | None = None
    _rays: int = 0

    def add(self, columns: slice, light: Illumination, returns: Returns) -> None:
        """Take in neighbouring columns, the next ones."""
        self._last, self._rays = (light, returns), self._rays + light.rays
        if columns == slice(0, self.columns):
            return
        motion = returns.motion
        by_facet = {**light.light, "rcs": returns.rcs, "running": returns.running}
        by_column = {}
        if motion is not None:
            by_facet["breaking"] = motion.breaking
            by_column = {"approaching": motion.approaching, "breaker_speed": motion.breaker_speed}
        for name, values in by_facet.items():
            if values is not None:
                self._whole(name, values, -2)[..., columns, :] = values
        for name, values in by_column.items():
            self._whole(name, values, -1)[columns] = values

    def _whole(self, name: str, part: NDArray[Any], axis: int) -> NDArray[Any]:
        if name not in self._arrays:
            shape = list(part.shape)
            shape[axis] = self.columns
            self._arrays[name] = np.empty(shape, part.dtype)
        return self._arrays[name]

    def on(self, facets: Facets) -> tuple[Illumination, Returns]:
        """The light of the turn on its facets, and what they return. RuntimeError where nothing was gathered."""
        if self._last is None:
            raise RuntimeError("no part of the turn was added")
        (light, returns), of = self._last, self._arrays.get
        if not self._arrays:
            return light.on(facets), returns
        found = {name: of(name) for name in light.light}
        motion = returns.motion
        if motion is not None:
            same = {name: of(name) for name in ("approaching", "breaking", "breaker_speed")}
            motion = replace(motion, **same)
        return replace(light.on(facets), **found, rays=self._rays), Returns(self._arrays["rcs"], motion, of("running"))
