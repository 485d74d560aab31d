"""What was seen of the sea, of any instrument in one type: place, time, value, standard error and kind."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..conventions import unit_from_azimuth
from ..dataset import QUALITY_FLAGS
from ..errors import InputError

Array = NDArray[np.float64]

KINDS = ("elevation", "slope_x", "slope_y", "velocity_x", "velocity_y", "velocity_z")

_BARRED = ~QUALITY_FLAGS["partly_shadowed"]  # cells left out by their flags; half hidden ones help
_STEEPEST = 4.0  # antenna heights: nearer by, points above one another share a gate, and errors are larger than said
_PULSE_SIGMA = 1.0 / np.sqrt(8.0 * np.log(2.0))  # of a pulse by its −3 dB width
_BEAM_SIGMA = 1.0 / np.sqrt(16.0 * np.log(2.0))  # of a two-way Gaussian beam by its one-way −3 dB width
# A wave's dim back is filled with the echo of the bright face before it: along the look, heights hold as much of
# regular waves of 10 to 25 m as if the pulse's variance were twice as large (python -m validation.prediction.blur).
_FILLED = 2.0
_WIDEST_ERROR = 2.0  # standard deviations of the sea: a value in more doubt tells nothing


@dataclass(frozen=True)
class Observations:
    """Values of the sea's surface; all arrays (n,).

    x, y: where, m east and north; time: s; value and its standard error std: m, 1 (slopes) or m/s; kind: of KINDS, or
    one for all. Velocities are those of the water at the surface. blur_along, blur_across: standard deviations [m]
    along and across the look [deg clockwise from north] of the area that a value is the mean over. Raises InputError
    for arrays of unlike lengths, values that are not finite, errors that are not positive and kinds that are not known.
    """

    x: Array
    y: Array
    time: Array
    value: Array
    std: Array
    kind: NDArray[np.str_]
    blur_along: Array = field(default_factory=lambda: np.zeros(1))
    blur_across: Array = field(default_factory=lambda: np.zeros(1))
    look: Array = field(default_factory=lambda: np.zeros(1))

    def __post_init__(self) -> None:
        size = np.size(self.value)
        for name in (each.name for each in fields(self)):
            array = np.asarray(getattr(self, name), dtype=np.str_ if name == "kind" else np.float64)
            if array.size not in (1, size) or array.ndim > 1:
                raise InputError(f"observations: {name} has shape {array.shape}; it must be ({size},), as value is")
            object.__setattr__(self, name, np.broadcast_to(array.reshape(-1), size))
        for name in ("x", "y", "time", "value", "std", "blur_along", "blur_across", "look"):
            if not np.isfinite(getattr(self, name)).all():
                raise InputError(f"observations: {name} holds values that are not finite; leave those out")
        if size and not self.std.min() > 0.0:
            raise InputError(f"observations: std = {self.std.min():g}: must be positive; give each value's error")
        unknown = sorted(set(np.unique(self.kind)) - set(KINDS))
        if unknown:
            raise InputError(f"observations: kind '{unknown[0]}' is not known; it must be one of {', '.join(KINDS)}")

    def __len__(self) -> int:
        return self.value.size

    def __getitem__(self, chosen: ArrayLike) -> Observations:
        """The observations of a mask, an index array or a slice."""
        return Observations(*(getattr(self, each.name)[chosen] for each in fields(self)))

    @property
    def blur(self) -> Array:
        """Variances [m²] of the areas, (n, 3): east, east with north, north."""
        east, north = unit_from_azimuth(self.look)
        along, across = self.blur_along**2, self.blur_across**2
        return np.stack(
            (
                along * east**2 + across * north**2,
                (along - across) * east * north,
                along * north**2 + across * east**2,
            ),
            axis=-1,
        )

    def __add__(self, other: Observations) -> Observations:
        """Both together."""
        return Observations(
            *(np.concatenate((getattr(self, each.name), getattr(other, each.name))) for each in fields(self))
        )


def turn_observations(polar: xr.Dataset, sea_std: float = np.inf) -> Observations:
    """What the polar map of one turn says of the sea's elevation, each cell at its own time and place.

    Heights of single dwells are taken where the map has them: their errors hardly depend on each other, and no
    neighbour is in them. sea_std: of the sea [m]; what is in much more doubt is left out.
    """
    single = "dwell_height" in polar
    names = ("dwell_height", "dwell_height_std") if single else ("height", "height_std")
    value, std, distance = (polar[name].values.astype(np.float64) for name in (*names, "ground_range"))
    ranges = polar["range"].values
    height = np.sqrt(np.maximum(ranges**2 - distance**2, 0.0))
    seen = np.isfinite(value) & np.isfinite(distance) & (std > 0.0) & (std < _WIDEST_ERROR * sea_std)
    seen &= ((polar["quality"].values & _BARRED) == 0) & (distance > _STEEPEST * height)
    look, gate = np.nonzero(seen)
    east, north = unit_from_azimuth(polar["azimuth"].values[look])
    out = distance[look, gate]
    at = [polar[name].values[look] if name in polar else 0.0 for name in ("antenna_x", "antenna_y")]
    return Observations(
        at[0] + out * east,
        at[1] + out * north,
        polar["time"].values[look],
        value[look, gate],
        std[look, gate],
        np.array(["elevation"]),
        *_blur(polar, out, single),
        polar["azimuth"].values[look].astype(np.float64),
    )


def damped(blur: Array, kx: Array, ky: Array) -> Array:
    """What is left of waves of kx, ky [rad/m] in means over areas of variances (..., 3) [m²], of their broadcast."""
    return np.exp(-0.5 * (blur[..., 0] * kx**2 + 2.0 * blur[..., 1] * kx * ky + blur[..., 2] * ky**2))


def _blur(polar: xr.Dataset, distance: Array, single: bool) -> tuple[Array, Array]:
    """Standard deviations [m] along and across the look of the areas that heights are the mean over, of a pulse, a beam
    and the dwell."""
    azimuth = polar["azimuth"].values
    turned = abs((azimuth[1] - azimuth[0] + 180.0) % 360.0 - 180.0) if azimuth.size > 1 else 0.0
    along = _PULSE_SIGMA * float(polar.attrs.get("pulse_m", 2.3))
    beam = np.radians(
        np.hypot(_BEAM_SIGMA * float(polar.attrs.get("azimuth_beamwidth_deg", 1.8)), turned / np.sqrt(12))
    )
    if not single:
        along = np.hypot(along, float(polar.attrs.get("cell_range_m", 3.0)) / np.sqrt(12.0))
    return np.full(distance.shape, np.sqrt(_FILLED) * along), beam * distance
