"""Where the maps' origin lies on Earth: latitude and longitude of metres east and north of it.

The projection is azimuthal equidistant about the origin (Snyder 1987, USGS professional paper 1395, chapter 25, on the
WGS 84 ellipsoid): distance and azimuth from the radar, which is what a radar measures, are those of the geodesic.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from .text import parse_number

if TYPE_CHECKING:
    from pyproj import CRS

Array = NDArray[np.float64]

_NEAREST_POLE = 89.9  # deg of latitude: nearer to it east and north turn within a map
_FARTHEST_M = 1e6


@dataclass(frozen=True)
class Origin:
    """The point that maps count metres from: below the antenna at time 0. WGS 84, degrees north and east."""

    latitude: float
    longitude: float

    def __post_init__(self) -> None:
        for name, value, most in (("latitude", self.latitude, _NEAREST_POLE), ("longitude", self.longitude, 180.0)):
            if not abs(value) <= most:  # NaN too
                raise InputError(f"{name} = {value:g}: must be −{most:g} to {most:g}, in degrees; correct it")

    @property
    def crs(self) -> CRS:
        """The coordinate reference system of the maps' x and y."""
        from pyproj.crs import ProjectedCRS
        from pyproj.crs.coordinate_operation import AzimuthalEquidistantConversion

        about = AzimuthalEquidistantConversion(self.latitude, self.longitude)
        return ProjectedCRS(about, name="azimuthal equidistant about the radar")

    def cf(self) -> dict[str, Any]:
        """Attributes of a CF grid mapping."""
        return self.crs.to_cf()

    def places(self, x: ArrayLike, y: ArrayLike) -> tuple[Array, Array]:
        """Latitude and longitude [deg] of x metres east and y metres north; NaN where these are."""
        from pyproj import Transformer

        east, north = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
        if np.nanmax(np.hypot(east, north), initial=0.0) > _FARTHEST_M:
            raise InputError(f"x, y: must be within {_FARTHEST_M:g} m of the origin; correct the maps")
        known = np.isfinite(east) & np.isfinite(north)
        longitude, latitude = np.full(east.shape, np.nan), np.full(east.shape, np.nan)
        inverse = Transformer.from_crs(self.crs, "EPSG:4326", always_xy=True)
        longitude[known], latitude[known] = inverse.transform(east[known], north[known])
        return latitude, longitude


def origin_of(at: Origin | tuple[float, float] | str, name: str = "at") -> Origin:
    """From LAT,LON as a text, or a pair of degrees. Raises InputError."""
    if isinstance(at, Origin):
        return at
    parts = at.split(",") if isinstance(at, str) else at
    try:
        latitude, longitude = (parse_number(part) for part in parts)
    except (TypeError, ValueError):
        raise InputError(f"{name} = {at!r}: must be LAT,LON in degrees north and east, as 54.32,-7.5") from None
    try:
        return Origin(latitude, longitude)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
