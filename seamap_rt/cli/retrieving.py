"""The command `retrieve`: maps from echoes or a recording."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ..errors import InputError
from .shell import Names, Number, Settings, command, console, overrides_of, section_of

if TYPE_CHECKING:
    import xarray as xr  # loaded where it is used: it takes half a second

    from ..io.exports import Kind, Origin

_EXPORTS: dict[Kind, str] = {"netcdf": "ground.nc", "geotiff": "ground.tif", "csv": "ground.csv"}
_EXPORT = re.compile(r"ground(-\d+)?\.(nc|tif|csv)")


@command(
    "retrieve runs/choppy_sea-1/echoes.zarr --out again",
    "retrieve night.npz --header header.toml --to geotiff --at 54.32,-7.5",
)
def retrieve(
    echoes: Path,
    *,
    header: Path | None = None,
    name: Names | None = None,
    out: Path | None = None,
    follow: Number = 0.0,
    wind_from: Number | None = None,
    to: Annotated[list[str] | None, Parameter(negative=(), consume_multiple=False)] = None,
    at: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,  # the south is negative
    even_if_wrong: Annotated[bool, Parameter(negative=())] = False,
    overwrite: bool = False,
    set_: Settings | None = None,
) -> int:
    """Heights and slopes (maps.nc) from echoes that keep the schema, or a recording. Never opens a truth file.

    What the echoes say of themselves (sign of the phase, offsets, gaps, gain) is inspected first: what is surely wrong
    is refused, what is doubtful is said in the first lines and in retrieval.html.

    Parameters
    ----------
    echoes
        A Zarr store, or a recording as .npz, .mat, .h5, .hdf5 or .nc.
    header
        Of a recording: a TOML or JSON file that describes the radar, where the recording does not.
    name
        Of a recording: ARRAY=NAME, what it calls an array, as in lower=rx/1; as often as wanted.
    out
        Folder for maps.nc and retrieval.html; default beside the echoes.
    follow
        Go on while the echoes grow, until no new turn has come for so many seconds.
    wind_from
        Degrees clockwise from north from which the wind blows, to compare the echo's drift with.
    to
        geotiff, csv or netcdf, as often as wanted: the ground maps with latitude and longitude beside maps.nc.
    at
        LAT,LON of the antenna at time 0, degrees north and east, for --to.
    even_if_wrong
        Retrieve what is surely wrong as well.
    overwrite
        Replace an earlier maps.nc.
    set_
        retrieval.KEY=VALUE, as often as wanted.
    """
    from ..settings import RetrievalSettings

    settings = section_of(RetrievalSettings, "retrieval", "retrieve", set_)
    if not echoes.exists():
        wanted = {"": "an echoes.zarr or of a recording", ".zarr": "an echoes.zarr"}.get(echoes.suffix, "a recording")
        raise InputError(f"ECHOES = '{echoes}': no such file or folder; give the path of {wanted}")
    for option, value in (("--follow", follow), ("--wind-from", wind_from or 0.0)):
        if not math.isfinite(value) or (option == "--follow" and value < 0.0):
            must = "seconds, at least 0" if option == "--follow" else "degrees clockwise from north"
            raise InputError(f"{option} = {value:g}: must be {must}; correct it")
    kinds, origin = _exports(to, at)
    import xarray as xr  # these take two seconds: what was typed is checked before

    from ..io.exports import export, headings
    from ..io.results_folder import refuse_unfinished, results_folder, write_whole
    from ..report.retrieved_page import RETRIEVED, retrieved_page
    from ..session.retrieving import MAPS, retrieve_into
    from ..wavefield import sea_state
    from ..wavefield.sea_state import in_words

    folder = out or echoes.parent
    earlier = tuple(path.name for path in folder.glob("ground*") if _EXPORT.fullmatch(path.name))
    products = (MAPS, RETRIEVED, *earlier)
    refuse_unfinished(echoes.parent, "ECHOES")
    with results_folder(folder, overwrite, (MAPS,)):
        found = retrieve_into(
            folder,
            lambda: _opened(echoes, header, name),
            settings,
            products,
            wait_s=follow,
            wind_from_deg=wind_from,
            even_if_wrong=even_if_wrong,
            told=_told if follow else lambda _: None,
        )
        with xr.open_datatree(found.maps) as opened:
            maps = opened.load()
        said = [*_answered(maps), f"sea state: {in_words(sea_state(maps))}"]
        page = retrieved_page(maps, found.findings, said, found.echoes.attrs, echoes.name)
        write_whole(folder / RETRIEVED, page)
        heading = headings(found.echoes, maps["ground"].to_dataset()["turn"].values)
        written = [
            file for kind in kinds for file in export(maps, folder / _EXPORTS[kind], origin, kind, heading_deg=heading)
        ]
    grave = {"wrong": "surely wrong", "doubtful": "doubtful"}
    for finding in found.findings:
        if finding.verdict in grave:
            console.print(f"{grave[finding.verdict]}: {finding.line}")
    for line in (*said, str(found.maps), str(folder / RETRIEVED), *map(str, written)):
        console.print(line)
    return 0


def _exports(to: list[str] | None, at: str | None) -> tuple[list[Kind], Origin | str]:
    """Kinds of files that are wanted beside maps.nc, and where on Earth they are."""
    from ..io.exports import origin_of

    kinds = [kind.strip() for each in to or [] for kind in each.split(",")]
    for kind in kinds:
        if kind not in _EXPORTS:
            raise InputError(f"--to {kind}: must be {', '.join(_EXPORTS)}; give one of them, or several")
    if (at is None) != (not kinds):
        missing = "--to geotiff, csv or netcdf" if at else "--at LAT,LON of the antenna, as in --at 54.32,-7.5"
        raise InputError(f"{'--at' if at else '--to'}: needs {missing}; give both or neither")
    return list(dict.fromkeys(kinds)), origin_of(at, "--at") if at else ""  # type: ignore[arg-type]


def _told(maps: xr.DataTree) -> None:
    """A line for a turn that has just come."""
    from ..conventions import turn_name

    polar = maps["polar"].to_dataset()
    console.print(f"{turn_name(polar['turn'].values[-1])}: {_answered(maps)[0]}")


def _opened(echoes: Path, header: Path | None, name: list[str] | None) -> xr.Dataset:
    """Echoes from a store, or from a recording and its header."""
    from ..interferometry import open_echoes, open_recording
    from ..io.recorded import RECORDING_ENDINGS

    if echoes.suffix.lower() in RECORDING_ENDINGS:
        return open_recording(echoes, header, overrides_of(name, "--name"))
    if header is None:
        return open_echoes(echoes)
    raise InputError(f"--header {header}: goes with a recording ({', '.join(RECORDING_ENDINGS)}); leave it out")


def _answered(maps: xr.DataTree) -> list[str]:
    """How much of the maps holds heights, and what kept the rest from it, if that is all."""
    import numpy as np

    from ..conventions import written
    from ..dataset import QUALITY_FLAGS

    polar = maps["polar"].to_dataset()
    known = np.isfinite(polar["height"].values)
    if known.any():
        spread = float(np.median(polar["height_std"].values[known]))
        return [f"{known.mean():.0%} of the cells answered, median error bar {written(spread, 3)} m"]
    flags = polar["quality"].values
    shares = {name: float(np.mean((flags & bit) != 0)) for name, bit in QUALITY_FLAGS.items()}
    reasons = ", ".join(f"{name} {share:.0%}" for name, share in shares.items() if share > 0.0)
    return [f"flag: no cell answered ({reasons})"]
