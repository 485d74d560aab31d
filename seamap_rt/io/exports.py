"""Ground maps for other programs: CF NetCDF, GeoTIFF and CSV, with latitude, longitude, and the antenna's position.

`maps.nc` counts metres from the antenna; these say where that was on Earth.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from io import StringIO
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..dataset import attributed, group_of
from ..errors import InputError
from .geography import Origin, origin_of
from .geotiff import geotiff
from .results_folder import write_whole

Kind = Literal["netcdf", "geotiff", "csv"]
KINDS: tuple[Kind, ...] = get_args(Kind)
_ENDINGS: dict[str, Kind] = {".nc": "netcdf", ".tif": "geotiff", ".tiff": "geotiff", ".csv": "csv"}
FIELDS = ("height", "height_std", "slope_x", "slope_y", "slope_x_std", "slope_y_std")
_POSITION, _HEADING = ("antenna_latitude", "antenna_longitude"), "heading"
# Column → format; a nanodegree is 0.1 mm.
_COLUMNS = {
    "turn": "%d",
    "time_s": "%.4f",
    "x_m": "%.3f",
    "y_m": "%.3f",
    "latitude_deg": "%.9f",
    "longitude_deg": "%.9f",
    "height_m": "%.4f",
    "height_std_m": "%.4f",
    "slope_x": "%.5f",
    "slope_y": "%.5f",
    "slope_x_std": "%.5f",
    "slope_y_std": "%.5f",
    "antenna_latitude_deg": "%.9f",
    "antenna_longitude_deg": "%.9f",
    "heading_deg": "%.2f",
}


def export(
    maps: xr.DataTree,
    path: str | os.PathLike[str],
    at: Origin | tuple[float, float] | str,
    kind: Kind | None = None,
    turns: Sequence[int] | None = None,
    heading_deg: ArrayLike | None = None,
) -> list[Path]:
    """Write the ground maps with their place on Earth; the files that were written.

    maps: as `retrieve` makes them. path: of the file; a GeoTIFF holds one turn, and of several each gets its number
    behind the name. at: latitude and longitude [deg, WGS 84] of the maps' origin, below the antenna at time 0. kind:
    "netcdf", "geotiff" or "csv"; by the ending of path (.nc, .tif, .csv) if left out. turns: numbers of turns, all if
    left out. heading_deg: of the boat, deg clockwise from north, one or one a turn that is written, where it is known.

    The maps' x is east and y north of the origin; latitude and longitude are exact by the geodesic from there. Raises
    InputError for a place, kind, turn or heading that is none, SchemaError for maps that are none.
    """
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"path = {path!r:.60}: must be the path of a file; give one that ends with .nc, .tif or .csv")
    path = Path(path)
    chosen = kind or _ENDINGS.get(path.suffix.lower())
    if chosen not in KINDS:
        raise InputError(f"kind = '{chosen or path.suffix}': must be {', '.join(KINDS)}; give one of them")
    placed = placed_maps(maps, origin_of(at), turns, heading_deg)
    if not path.parent.is_dir():
        raise InputError(f"path = '{path}': its folder does not exist; make it first")
    files = {path: placed}
    if chosen == "geotiff" and placed.sizes["turn"] > 1:
        files = {
            path.with_name(f"{path.stem}-{number}{path.suffix}"): placed.isel(turn=[place])
            for place, number in enumerate(placed["turn"].values)
        }
    write = {"netcdf": _netcdf, "geotiff": _tiff, "csv": _csv}[chosen]
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
        crs=((), np.int32(0), origin.cf()),
    )
    for name in (*FIELDS, "time"):
        placed[name].attrs["grid_mapping"] = "crs"
    where = origin.places(*(_by_turn(polar, name) for name in ("antenna_x", "antenna_y")))
    units = ("degrees_north", "degrees_east")
    for name, value, unit in zip(_POSITION, where, units, strict=True):
        placed[name] = ("turn", value, {"long_name": name.replace("_", " "), "units": unit})
    heading = _headings(heading_deg, len(wanted))
    if heading is not None:
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


def _by_turn(polar: xr.Dataset, name: str) -> NDArray[np.float64]:
    """(turn,) m; maps that do not say where the antenna was are of one that stands at the origin."""
    if name not in polar:
        return np.zeros(polar.sizes["turn"])
    return np.nan_to_num(polar[name].mean("azimuth", skipna=True).values)


def _headings(given: ArrayLike | None, turns: int) -> NDArray[np.float64] | None:
    if given is None:
        return None
    heading = np.asarray(given, dtype=np.float64)
    if heading.shape not in ((), (1,), (turns,)) or not np.isfinite(heading).all():
        raise InputError(f"heading_deg: must be a finite number, or one for each of {turns} turns; correct it")
    return np.broadcast_to(heading % 360.0, turns)


def _netcdf(path: Path, placed: xr.Dataset) -> None:
    kept = {name: {"zlib": True, "complevel": 4, "_FillValue": np.nan} for name in (*FIELDS, "time")}
    plain = {str(name): {"_FillValue": None} for name in (*placed.coords, *placed.data_vars) if name not in kept}
    part = path.with_name(f".{path.name}.part")
    try:
        placed.to_netcdf(part, engine="h5netcdf", encoding=kept | plain)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def _tiff(path: Path, placed: xr.Dataset) -> None:
    one = placed.isel(turn=0)
    time = one["time"].values
    facts: dict[str, Any] = {"turn": int(one["turn"])}
    if np.isfinite(time).any():
        facts["time_s"] = f"{np.nanmin(time):.4f} to {np.nanmax(time):.4f}"
    facts |= {f"{name}_deg": float(one[name]) for name in (*_POSITION, _HEADING) if name in one}
    at = (float(one["crs"].attrs[f"{name}_of_projection_origin"]) for name in ("latitude", "longitude"))
    bands = {name: one[name].values for name in FIELDS}
    write_whole(path, geotiff(bands, one["x"].values, one["y"].values, Origin(*at), facts))


def _csv(path: Path, placed: xr.Dataset) -> None:
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
