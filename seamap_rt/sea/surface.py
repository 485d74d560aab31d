"""The evolving sea surface: wave systems realised once, then evaluated at any place and time.

First-order waves, seen at fixed places (linear, Airy 1845) or carried by the water (choppy, see `choppy`), on a uniform
current. Heights in metres above mean sea level, x east, y north, t in seconds.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .choppy import ChoppySurface
from .facts import ResolvedSea, spectrum_dataset
from .wave_trains import Components, LinearSurface, Quantity, WaveTrain

if TYPE_CHECKING:
    import xarray as xr


class Memory:
    """Values by the points that they are of; the oldest go when they are more than `most_bytes` together."""

    def __init__(self, most_bytes: float) -> None:
        self._most = most_bytes
        self._values: OrderedDict[Hashable, NDArray[np.float64]] = OrderedDict()

    def recall(
        self, what: Hashable, points: tuple[NDArray[np.float64], ...], make: Callable[[], NDArray[np.float64]]
    ) -> NDArray[np.float64]:
        """The values of `what` at the points, made now unless they are known; the caller may write into them."""
        digest = hashlib.blake2b(digest_size=16)
        for each in points:
            digest.update(np.ascontiguousarray(each).data)
        key = what, points[0].size, digest.digest()
        values = self._values.pop(key, None)
        if values is None:
            values = make()
        self._values[key] = values
        while sum(each.nbytes for each in self._values.values()) > self._most and self._values:
            self._values.popitem(last=False)
        return values.copy()


class Patch(Protocol):
    """The patch of a recorded sea that ends: places, m, are known or not."""

    def holds(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]: ...


@dataclass(eq=False)
class Sea:
    """A realised sea. x, y, t broadcast; results carry the broadcast shape first. Asking changes nothing.

    `elevation_rate` is ∂η/∂t at a fixed place, `velocity` the water particle's, current included; the kinematic
    condition ties them: w = ∂η/∂t + U·∇η on linear waves that ride on a current U, w = ∂η/∂t + u·∇η on choppy ones.

    Made for many places at few times: each fraction of a second costs FFTs of the whole plane. For a long record at a
    few places of a linear sea `direct_sum(sea.components(), x, y, t)` is the quicker way.
    """

    trains: Sequence[WaveTrain]
    surface: LinearSurface | ChoppySurface
    resolved: ResolvedSea
    current: tuple[float, float] = (0.0, 0.0)  # m/s east, north. Waves ride on it: the whole surface is carried along
    ends_s: float = np.inf  # after which nothing is known of it
    patch: Patch | None = None  # beyond which it is continued, and not known; None: it is everywhere
    _memory: Memory | None = None

    def remember(self, most_bytes: float) -> None:
        """From here on keep the values that were asked for last, in so many bytes. They stay what they are."""
        self._memory = Memory(most_bytes)

    def elevation(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> NDArray[np.float64]:
        """Height above mean sea level, (…) m."""
        return self._sample(x, y, t, ("elevation",))[0]

    def is_known(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.bool_]:
        """Where (…) the surface is that of the sea, and may be judged by: not where a record was continued."""
        east, north = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
        return np.ones(east.shape, dtype=bool) if self.patch is None else self.patch.holds(east, north)

    @property
    def judge(self) -> KnownSea:
        """The sea as forecasts are judged by."""
        return KnownSea(self)

    def elevation_rate(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> NDArray[np.float64]:
        """∂η/∂t at a fixed place, (…) m/s."""
        east, north, time, shape = self._riding(x, y, t)
        return self.surface.elevation_rate(east, north, time, self.current).reshape(shape)

    def slopes(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> NDArray[np.float64]:
        """∂η/∂x and ∂η/∂y, (…, 2) east north."""
        return np.moveaxis(self._sample(x, y, t, ("slope_east", "slope_north")), 0, -1)

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> NDArray[np.float64]:
        """The water particle's velocity at the surface, (…, 3) m/s east north up."""
        return np.moveaxis(self._sample(x, y, t, ("flow_east", "flow_north", "rate")), 0, -1)

    def elevation_and_velocity(
        self, x: ArrayLike, y: ArrayLike, t: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
        """Elevation (…) m and water velocity (…, 3) m/s in one pass: what a mesh of the moving surface needs."""
        values = self._sample(x, y, t, ("elevation", "flow_east", "flow_north", "rate"))
        return values[0], _single(values[1:])

    def elevation_velocity_and_relaxed_shift(
        self, x: ArrayLike, y: ArrayLike, t: ArrayLike, rate: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float32], NDArray[np.float32]]:
        """Elevation (…) m, water velocity (…, 3) m/s and relaxed shift D (…, 2) m east north, in one pass.

        dD/dt + μ D = u of the water that passes, with u its horizontal velocity less the current: −∂D/∂l along a look l
        is the strain of short waves that run along it and relax at the rate μ [1/s] (Alpers & Hasselmann 1978); μ = 0
        makes D the water's displacement. Raises ValueError for a rate below 0 or not finite.
        """
        if not (0.0 <= rate < np.inf):
            raise ValueError(f"rate = {rate}: must be 0 or more and finite; give the relaxation rate in 1/s")
        quantities = ("elevation", "flow_east", "flow_north", "rate", "relaxed_east", "relaxed_north")
        values = self._sample(x, y, t, quantities, rate)
        return values[0], _single(values[1:4]), _single(values[4:])

    def elevation_and_slopes(
        self, x: ArrayLike, y: ArrayLike, t: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Elevation (…) m and slopes (…, 2) in one pass."""
        values = self._sample(x, y, t, ("elevation", "slope_east", "slope_north"))
        return values[0], np.moveaxis(values[1:], 0, -1)

    def elevation_slopes_and_velocity(
        self, x: ArrayLike, y: ArrayLike, t: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Elevation (…) m, slopes (…, 2) and velocity (…, 3) m/s in one pass."""
        values = self._sample(x, y, t, ("elevation", "slope_east", "slope_north", "flow_east", "flow_north", "rate"))
        return values[0], np.moveaxis(values[1:3], 0, -1), np.moveaxis(values[3:], 0, -1)

    def folded(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> NDArray[np.bool_]:
        """Where the surface stands more than once over a place, (…): choppy crests that break over. Linear: nowhere."""
        east, north, time, shape = self._riding(x, y, t)
        return self.surface.folded(east, north, time).reshape(shape)

    def components(self) -> Components:
        """Every wave of this realisation, for `direct_sum`: as they are without a current. Of a choppy sea the waves by
        which labels are displaced, enlarged by `ChoppyFacts.amplitude_scale`: their sum is not the surface."""
        return Components.joined([train.components() for train in self.trains])

    @cached_property
    def spectrum(self) -> xr.Dataset:
        """The directional spectrum, its expectation over realisations; see `facts.spectrum_dataset`."""
        return spectrum_dataset(self.trains, self.resolved)

    def _sample(
        self, x: ArrayLike, y: ArrayLike, t: ArrayLike, quantities: Sequence[Quantity], rate: float = 0.0
    ) -> NDArray[np.float64]:
        """Quantities (quantity, …) in the world's frame; rate: μ of the relaxed ones, 1/s."""
        east, north, time, shape = self._riding(x, y, t)

        def make() -> NDArray[np.float64]:
            return self.surface.sample(east, north, time, quantities, rate)

        memory, what = self._memory, (tuple(quantities), rate)
        values = make() if memory is None else memory.recall(what, (east, north, time), make)
        for name, speed in zip(("flow_east", "flow_north"), self.current, strict=True):
            if speed != 0.0 and name in quantities:
                values[quantities.index(name)] += speed
        return values.reshape(len(quantities), *shape)

    def _riding(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> tuple[NDArray, NDArray, NDArray, tuple[int, ...]]:
        """Places in the frame of the water at rest, times, each (n,), and the shape of the arguments."""
        points = np.broadcast_arrays(*(np.asarray(value, dtype=np.float64) for value in (x, y, t)))
        east, north, time = (point.ravel() for point in points)
        if not (np.isfinite(east).all() and np.isfinite(north).all() and np.isfinite(time).all()):
            raise ValueError("x, y, t: must be finite")
        if self.current != (0.0, 0.0):
            east, north = east - self.current[0] * time, north - self.current[1] * time
        return east, north, time, points[0].shape


@dataclass(frozen=True)
class KnownSea:
    """A sea whose elevation is NaN where it is not known."""

    sea: Sea

    def elevation(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> NDArray[np.float64]:
        """Height above mean sea level, (…) m."""
        height = self.sea.elevation(x, y, t)
        return height if self.sea.patch is None else np.where(self.sea.is_known(x, y), height, np.nan)


def _single(values: NDArray[np.float64]) -> NDArray[np.float32]:
    """(axis, …) as (…, axis) in single precision."""
    single = np.empty((*values.shape[1:], values.shape[0]), dtype=np.float32)
    for axis, value in enumerate(values):
        single[..., axis] = value
    return single
