"""Power images and polar maps as CfRadial 2 (WMO FM 301), in and out; xradar opens what is written here.

Each turn is a sweep, a sector scan at elevation 0, and each radial or look a ray of it. Video is the field `video` in
counts, since no law of power is known of it; maps keep the names and units of our own schema, with slant range as
`range`. Attributes that the standard has no place for stand as JSON in the root's `comment`, so that what is read is
what was written.

What CfRadial leaves open: it has no field for a height of the sea, and of a moving platform readers may keep one place
a volume. xradar's own writer drops a ray's heading and place, so the files are written without it. Only files that were
written here are read. SOMaR is not written: we could not read its draft to check against it.
"""

from __future__ import annotations

import json
import os
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import xarray as xr

from ..dataset import SCHEMA, build, check
from ..errors import InputError, SchemaError, must_be
from .opening import check_file
from .results_folder import whole_file
from .text import to_builtin

_EPOCH = "2000-01-01T00:00:00"  # of a simulation's time 0
_SHIP = ("heading", "latitude", "longitude")
_MARK = "seamap_rt"


def write_radial_volume(
    path: str | os.PathLike[str], data: xr.Dataset, at: tuple[float, float] = (np.nan, np.nan)
) -> None:
    """Write data to a CfRadial 2 file at path: `polar_images`, as `read_polar_images` gives, or `maps/polar` of maps.

    at: latitude and longitude [deg] of the maps' origin; images have their own. Raises InputError for a path that
    cannot be written and for what is no dataset, SchemaError for a dataset of another kind.
    """
    must_be("path", path, (str, os.PathLike), "the path of a file to write")
    if Path(path).suffix != ".nc":
        raise InputError(f"path = '{path}': must end with .nc, for readers choose by it; add it")
    must_be("data", data, xr.Dataset, "a dataset `polar_images`, as read_polar_images gives, or `polar` of maps")
    images = "video" in data
    check("polar_images" if images else "maps/polar", data)
    turns = np.unique(data["turn"].values)
    start = _start(data.attrs.get("start", _EPOCH))
    sweeps = {f"sweep_{n}": _sweep(data, images, int(turn), n, start) for n, turn in enumerate(turns)}
    times = [each["time"].values for each in sweeps.values()]
    latitude, longitude = (float(data[name].values[0]) for name in _SHIP[1:]) if images else at
    facts = {"kind": "polar_images" if images else "maps/polar", "attrs": to_builtin(data.attrs)}
    root = xr.Dataset(
        {
            "volume_number": 0,
            "time_coverage_start": f"{times[0].min()}Z",
            "time_coverage_end": f"{times[-1].max()}Z",
            "latitude": ((), latitude, {"units": "degrees_north"}),
            "longitude": ((), longitude, {"units": "degrees_east"}),
            "altitude": ((), float(data.attrs.get("height_m", np.nan)), {"units": "meters"}),
            "sweep_group_name": ("sweep", np.array(list(sweeps))),
            "sweep_fixed_angle": ("sweep", np.zeros(len(sweeps))),
        },
        attrs={
            "Conventions": "Cf/Radial",
            "version": "2.0",
            "title": "marine radar's power images" if images else "sea surface heights by an interferometric radar",
            "instrument_name": str(data.attrs.get("radar", "")) or _MARK,
            "institution": "",
            "references": "",
            "source": _MARK,
            "history": _MARK,
            "comment": json.dumps({_MARK: facts}),
            "platform_is_mobile": "true",
        },
    )
    tree = xr.DataTree.from_dict({"/": root} | {f"/{name}": sweep for name, sweep in sweeps.items()})
    try:
        with whole_file(Path(path)) as part:
            tree.to_netcdf(os.fspath(part), engine="h5netcdf")
    except OSError as error:
        raise InputError(f"path = '{path}': cannot be written ({error.strerror or error}); choose another") from None


def read_radial_volume(path: str | os.PathLike[str]) -> xr.Dataset:
    """The file at path that `write_radial_volume` wrote, as the dataset that was. Raises InputError for another one."""
    must_be("path", path, (str, os.PathLike), "the path of a CfRadial 2 file")
    check_file(Path(path), "a CfRadial 2 file", named=f"'{path}'")
    try:
        with xr.open_datatree(os.fspath(path), engine="h5netcdf") as tree:
            tree.load()
            sweeps = [
                tree[name].to_dataset() for name in sorted(tree.children, key=lambda name: int(name.rpartition("_")[2]))
            ]
            facts = json.loads(tree.attrs["comment"])[_MARK]
    except (OSError, KeyError, ValueError, TypeError):
        raise InputError(f"{path}: is no CfRadial 2 file of seamap_rt; give one that was written here") from None
    start = np.datetime64(_start(facts["attrs"].get("start", _EPOCH)), "ns")
    kind = facts["kind"]
    attrs = {name: np.array(value) if isinstance(value, list) else value for name, value in facts["attrs"].items()}
    turns = np.array([int(each["turn_number"]) for each in sweeps])
    seconds = [(each["time"].values - start) / np.timedelta64(1, "s") for each in sweeps]
    names = [name for name in SCHEMA[kind] if name in sweeps[0] and name not in ("time", "azimuth", "range", "turn")]
    if not names:
        raise SchemaError(f"{path}: holds no field of {kind}")
    ranges = sweeps[0]["range"].values.astype(np.float64)
    if kind == "polar_images":
        joined = {name: np.concatenate([each[name].values for each in sweeps]) for name in names if name != "pulse"}
        counts = [each.sizes["time"] for each in sweeps]
        coords = {
            "pulse": np.concatenate([each["pulse"].values for each in sweeps]),
            "range": ranges,
            "time": np.concatenate(seconds),
            "azimuth": np.concatenate([each["azimuth"].values for each in sweeps]),
            "turn": np.repeat(turns, counts),
        }
        return build(kind, joined, coords, attrs)
    order = [np.argsort(each["look"].values) for each in sweeps]
    fields = {n: np.stack([s[n].values[o] for s, o in zip(sweeps, order, strict=True)]) for n in names}
    fields["time"] = np.stack([s[o] for s, o in zip(seconds, order, strict=True)])
    azimuth = sweeps[0]["azimuth"].values[order[0]]
    return build(kind, fields, {"turn": turns, "azimuth": azimuth, "range": ranges}, attrs)


def _sweep(data: xr.Dataset, images: bool, turn: int, number: int, start: datetime) -> xr.Dataset:
    """One turn's rays, in the order of their times."""
    if images:
        rays = data.isel(pulse=np.flatnonzero(data["turn"].values == turn))
        ray, look = "pulse", {"pulse": rays["pulse"].values, **{name: rays[name].values for name in _SHIP}}
        fields = {"video": rays["video"]}
    else:
        rays = data.sel(turn=turn)
        ray, look = "azimuth", {"look": np.arange(rays.sizes["azimuth"])}
        look |= {name: rays[name].values for name in ("antenna_x", "antenna_y") if name in rays}
        fields = {str(name): each for name, each in rays.data_vars.items() if each.dims == ("azimuth", "range")}
    offsets = np.round(1e9 * rays["time"].values.astype(np.float64)).astype("timedelta64[ns]")
    made = xr.Dataset(
        {name: (("time", "range"), each.values, each.attrs) for name, each in fields.items()}
        | {name: ("time", values) for name, values in look.items()}
        | {
            "elevation": ("time", np.zeros(rays.sizes[ray]), {"units": "degrees"}),
            "azimuth": ("time", rays["azimuth"].values, {"units": "degrees"}),
            "sweep_number": number,
            "sweep_mode": "sector",
            "follow_mode": "none",
            "prt_mode": "fixed",
            "sweep_fixed_angle": 0.0,
            "turn_number": turn,
        },
        {
            "time": ("time", np.datetime64(start, "ns") + offsets, {"standard_name": "time"}),
            "range": (
                "range",
                rays["range"].values,
                {"units": "meters", "standard_name": "projection_range_coordinate"},
            ),
        },
    )
    return made.sortby("time")


def _start(text: str) -> datetime:
    """A start time without its zone, in UTC."""
    moment = datetime.fromisoformat(text)
    return moment if moment.tzinfo is None else moment.astimezone(UTC).replace(tzinfo=None)
