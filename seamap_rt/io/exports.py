"""Ground maps for other programs: CF NetCDF, GeoTIFF and CSV, with latitude, longitude, and the antenna's position.

`maps.nc` counts metres from the antenna; these say where that was on Earth. The projection is azimuthal equidistant
about the origin (Snyder 1987, USGS professional paper 1395, chapter 25, on the WGS 84 ellipsoid): distance and azimuth
from the radar, which is what a radar measures, are those of the geodesic. A GeoTIFF holds one turn, a band a field, row
0 in the north, no data NaN; its keys are those of OGC 19-008r4 (GeoTIFF 1.1).
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from io import BytesIO, StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args
from xml.sax.saxutils import escape

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..dataset import attributed, group_of
from ..errors import InputError, say_of
from .radial_volume import write_radial_volume
from .results_folder import whole_file, write_whole
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
    """The origin from a text LAT,LON, or from a pair of degrees. Raises InputError."""
    if isinstance(at, Origin):
        return at
    parts = at.split(",") if isinstance(at, str) else at
    try:
        latitude, longitude = (parse_number(part) for part in parts)
    except (TypeError, ValueError):
        raise InputError(f"{name} = {at!r}: must be LAT,LON in degrees north and east, as 54.32,-7.5") from None
    with say_of(f"{name}: ", InputError):
        return Origin(latitude, longitude)


_PIXEL_SCALE, _TIE_POINT, _GEO_KEYS, _GEO_DOUBLES, _GEO_TEXTS = 33550, 33922, 34735, 34736, 34737
_GDAL_METADATA, _GDAL_NO_DATA = 42112, 42113  # GDAL's own: names of the bands, and what stands for no data
_DOUBLE, _SHORT, _TEXT = 12, 3, 2  # types of TIFF 6.0
_PROJECTED, _PIXEL_IS_AREA, _USER_DEFINED, _WGS84, _EQUIDISTANT, _METRE, _DEGREE = 1, 1, 32767, 4326, 12, 9001, 9102


def geotiff(bands: Mapping[str, NDArray], x: NDArray, y: NDArray, origin: Origin, facts: Mapping[str, object]) -> bytes:
    """The file. bands: name → (y, x). x, y: metres east and north of the cells' middles, both ascending and evenly
    spaced. facts: what else the file is to say, name → value."""
    from tifffile import imwrite

    dx, dy = ((float(axis[-1] - axis[0]) / (axis.size - 1)) for axis in (x, y))
    image = np.stack([np.asarray(band, dtype=np.float32)[::-1] for band in bands.values()])
    names = [
        f'<Item name="DESCRIPTION" sample="{number}" role="description">{escape(name)}</Item>'
        for number, name in enumerate(bands)
    ]
    items = [f'<Item name="{escape(name)}">{escape(str(value))}</Item>' for name, value in facts.items()]
    tags = [
        (_PIXEL_SCALE, _DOUBLE, 3, (dx, dy, 0.0)),
        (_TIE_POINT, _DOUBLE, 6, (0.0, 0.0, 0.0, float(x[0]) - 0.5 * dx, float(y[-1]) + 0.5 * dy, 0.0)),
        *_geo_keys(origin),
        (_GDAL_METADATA, _TEXT, 0, f"<GDALMetadata>{''.join([*items, *names])}</GDALMetadata>"),
        (_GDAL_NO_DATA, _TEXT, 0, "nan"),
    ]
    file = BytesIO()
    imwrite(
        file,
        image,
        photometric="minisblack",
        planarconfig="separate",
        compression="zlib",
        metadata=None,
        software="seamap_rt",
        extratags=[(code, kind, count, value, True) for code, kind, count, value in tags],
    )
    return file.getvalue()


def _geo_keys(origin: Origin) -> list[tuple[int, int, int, object]]:
    doubles = (origin.longitude, origin.latitude, 0.0, 0.0)
    text = "azimuthal equidistant about the radar|"
    keys = [  # key, where its value is (0: here), how many, value or its place
        (1024, 0, 1, _PROJECTED),  # model
        (1025, 0, 1, _PIXEL_IS_AREA),
        (2048, 0, 1, _WGS84),  # geodetic system
        (2054, 0, 1, _DEGREE),
        (3072, 0, 1, _USER_DEFINED),  # projected system
        (3073, _GEO_TEXTS, len(text), 0),
        (3074, 0, 1, _USER_DEFINED),  # projection
        (3075, 0, 1, _EQUIDISTANT),
        (3076, 0, 1, _METRE),
        (3082, _GEO_DOUBLES, 1, 2),  # false easting
        (3083, _GEO_DOUBLES, 1, 3),  # false northing
        (3088, _GEO_DOUBLES, 1, 0),  # longitude of the centre
        (3089, _GEO_DOUBLES, 1, 1),  # latitude of the centre
    ]
    directory = (1, 1, 1, len(keys), *(number for key in keys for number in key))
    return [
        (_GEO_KEYS, _SHORT, len(directory), directory),
        (_GEO_DOUBLES, _DOUBLE, len(doubles), doubles),
        (_GEO_TEXTS, _TEXT, 0, text),
    ]


Kind = Literal["netcdf", "geotiff", "csv", "cfradial"]
KINDS: tuple[Kind, ...] = get_args(Kind)
_ENDINGS: dict[str, Kind] = {".nc": "netcdf", ".tif": "geotiff", ".tiff": "geotiff", ".csv": "csv"}
FIELDS = ("height", "height_std", "slope_x", "slope_y", "slope_x_std", "slope_y_std")
_POSITION, _HEADING = ("antenna_latitude", "antenna_longitude"), "heading"
# Column → format; a nanodegree is 0.1 mm.
_COLUMNS = (
    {"turn": "%d", "time_s": "%.4f", "x_m": "%.3f", "y_m": "%.3f", "latitude_deg": "%.9f", "longitude_deg": "%.9f"}
    | {"height_m": "%.4f", "height_std_m": "%.4f"}
    | dict.fromkeys(("slope_x", "slope_y", "slope_x_std", "slope_y_std"), "%.5f")
    | {"antenna_latitude_deg": "%.9f", "antenna_longitude_deg": "%.9f", "heading_deg": "%.2f"}
)


def export(
    maps: xr.DataTree,
    path: str | os.PathLike[str],
    at: Origin | tuple[float, float] | str,
    kind: Kind | None = None,
    turns: Sequence[int] | None = None,
    heading_deg: ArrayLike | None = None,
) -> list[Path]:
    """Write maps with their place on Earth; the files that were written.

    maps: as `retrieve` makes them. path: of the file; a GeoTIFF holds one turn, and of several each gets its number
    behind the name. at: latitude and longitude [deg, WGS 84] of the maps' origin, below the antenna at time 0. kind:
    "netcdf", "geotiff" or "csv" of the ground maps, or "cfradial" of the polar ones (CfRadial 2, which xradar opens);
    by the ending of path (.nc, .tif, .csv) if left out. turns: numbers of turns, all if left out. heading_deg: of the
    boat, deg clockwise from north, one or one a turn that is written, where it is known.

    The maps' x is east and y north of the origin; latitude and longitude are exact by the geodesic from there. Raises
    InputError for a place, kind, turn or heading that is none, SchemaError for maps that are none.
    """
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"path = {path!r:.60}: must be the path of a file; give one that ends with .nc, .tif or .csv")
    path = Path(path)
    chosen = kind or _ENDINGS.get(path.suffix.lower())
    if chosen not in KINDS:
        raise InputError(f"kind = '{chosen or path.suffix}': must be {', '.join(KINDS)}; give one of them")
    origin = origin_of(at)
    placed = placed_maps(maps, origin, turns, heading_deg)
    if not path.parent.is_dir():
        raise InputError(f"path = '{path}': its folder does not exist; make it first")
    files = {path: placed}
    if chosen == "geotiff" and placed.sizes["turn"] > 1:
        files = {
            path.with_name(f"{path.stem}-{number}{path.suffix}"): placed.isel(turn=[place])
            for place, number in enumerate(placed["turn"].values)
        }
    write = {
        "netcdf": _write_netcdf,
        "geotiff": _write_tiff,
        "csv": _write_csv,
        "cfradial": partial(_write_radial, maps, origin),
    }[chosen]
    for name, held in files.items():
        try:
            write(name, held)
        except OSError as error:
            raise InputError(
                f"path = '{name}': cannot be written ({error.strerror or error}); choose another"
            ) from None
    return list(files)


def placed_maps(
    maps: xr.DataTree, origin: Origin, turns: Sequence[int] | None = None, heading_deg: ArrayLike | None = None
) -> xr.Dataset:
    """Ground maps as a CF dataset with `lat`, `lon` (y, x), the antenna's place (turn,) and the grid mapping `crs`."""
    ground, polar = (group_of(maps, f"maps/{name}") for name in ("ground", "polar"))
    held = [int(number) for number in ground["turn"].values]
    wanted = held if turns is None else [int(number) for number in turns]
    missing = [number for number in wanted if number not in held]
    if missing or not wanted:
        raise InputError(f"turns = {wanted}: the maps' `turn` is {held[0]} to {held[-1]}; choose among them")
    ground, polar = (each.isel(turn=[held.index(number) for number in wanted]) for each in (ground, polar))
    for name in FIELDS:
        if name not in ground:  # of maps that were made without it
            ground[name] = attributed("maps/ground", name, np.full(ground["height"].shape, np.nan))
    grid = np.meshgrid(ground["x"].values, ground["y"].values)
    latitude, longitude = origin.places(*grid)
    placed = ground[[*FIELDS, "time"]].assign_coords(
        lat=(("y", "x"), latitude, _attributes("latitude", "degrees_north", "latitude of the cell's middle")),
        lon=(("y", "x"), longitude, _attributes("longitude", "degrees_east", "longitude of the cell's middle")),
        crs=((), np.int32(0), origin.crs.to_cf()),
    )
    for name in (*FIELDS, "time"):
        placed[name].attrs["grid_mapping"] = "crs"
    where = origin.places(*(_mean_of_turns(polar, name) for name in ("antenna_x", "antenna_y")))
    units = ("degrees_north", "degrees_east")
    for name, value, unit in zip(_POSITION, where, units, strict=True):
        placed[name] = ("turn", value, {"long_name": name.replace("_", " "), "units": unit})
    if heading_deg is not None:
        heading = np.asarray(heading_deg, dtype=np.float64)
        if heading.shape not in ((), (1,), (len(wanted),)) or not np.isfinite(heading).all():
            raise InputError(
                f"heading_deg: must be a finite number, or one for each of {len(wanted)} turns; correct it"
            )
        heading = np.broadcast_to(heading % 360.0, len(wanted))
        placed[_HEADING] = ("turn", heading, _attributes("platform_orientation", "degree", "heading, from north"))
    placed.attrs |= {"Conventions": "CF-1.11", "title": "heights and slopes of the sea, retrieved from radar echoes"}
    return placed


def headings(echoes: xr.Dataset, turns: ArrayLike) -> NDArray[np.float64]:
    """(turn,) deg clockwise from north: the boat's mean heading in each of these turns, as its sensors have it."""
    turn, yaw = echoes["turn"].values, np.radians(echoes["attitude"].values[:, 2])
    turned = np.where(np.isfinite(yaw), np.exp(1j * yaw), 0.0)
    return np.degrees(np.angle([turned[turn == number].sum() for number in np.asarray(turns)])) % 360.0


def _attributes(standard: str, units: str, words: str) -> dict[str, str]:
    return {"standard_name": standard, "units": units, "long_name": words}


def _mean_of_turns(polar: xr.Dataset, name: str) -> NDArray[np.float64]:
    """(turn,) m; maps that do not say where the antenna was are of one that stands at the origin."""
    if name not in polar:
        return np.zeros(polar.sizes["turn"])
    return np.nan_to_num(polar[name].mean("azimuth", skipna=True).values)


def _write_netcdf(path: Path, placed: xr.Dataset) -> None:
    packed = {name: {"zlib": True, "complevel": 4, "_FillValue": np.nan} for name in (*FIELDS, "time")}
    plain = {str(name): {"_FillValue": None} for name in (*placed.coords, *placed.data_vars) if name not in packed}
    with whole_file(path) as part:
        placed.to_netcdf(part, engine="h5netcdf", encoding=packed | plain)


def _write_tiff(path: Path, placed: xr.Dataset) -> None:
    one = placed.isel(turn=0)
    time = one["time"].values
    facts: dict[str, Any] = {"turn": int(one["turn"])}
    if np.isfinite(time).any():
        facts["time_s"] = f"{np.nanmin(time):.4f} to {np.nanmax(time):.4f}"
    facts |= {f"{name}_deg": float(one[name]) for name in (*_POSITION, _HEADING) if name in one}
    at = (float(one["crs"].attrs[f"{name}_of_projection_origin"]) for name in ("latitude", "longitude"))
    bands = {name: one[name].values for name in FIELDS}
    write_whole(path, geotiff(bands, one["x"].values, one["y"].values, Origin(*at), facts))


def _write_radial(maps: xr.DataTree, origin: Origin, path: Path, placed: xr.Dataset) -> None:
    """The polar maps of the turns that are placed."""
    polar = group_of(maps, "maps/polar").sel(turn=placed["turn"].values)
    write_radial_volume(path, polar, (origin.latitude, origin.longitude))


def _write_csv(path: Path, placed: xr.Dataset) -> None:
    """A line a cell whose height is known."""
    turn, row, column = np.nonzero(np.isfinite(placed["height"].values))
    heading = placed[_HEADING].values if _HEADING in placed else np.full(placed.sizes["turn"], np.nan)
    columns = [
        placed["turn"].values[turn],
        placed["time"].values[turn, row, column],
        placed["x"].values[column],
        placed["y"].values[row],
        *(placed[name].values[row, column] for name in ("lat", "lon")),
        *(placed[name].values[turn, row, column] for name in FIELDS),
        *(placed[name].values[turn] for name in _POSITION),
        heading[turn],
    ]
    text = StringIO()
    formats = list(_COLUMNS.values())
    np.savetxt(text, np.column_stack(columns), formats, delimiter=",", header=",".join(_COLUMNS), comments="")
    write_whole(path, text.getvalue())
