"""Commands that take what is there: maps from echoes or a recording, forecasts from maps, and what a kill left."""

from __future__ import annotations

import math
import re
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ..errors import InputError
from ..io.text import number_list, parse_number
from .shell import (
    Names,
    Number,
    Settings,
    StreamFormat,
    StreamTo,
    about,
    command,
    console,
    overrides_of,
    section_of,
    streaming,
)

if TYPE_CHECKING:
    import numpy as np  # loaded where they are used: they take half a second
    import xarray as xr
    from numpy.typing import NDArray

    from ..io.exports import Kind, Origin
    from ..session.retrieving import Turn


_PRODUCT = "prediction.nc"
_LONGEST_S, _MOST_LEADS = 60.0, 10_000
_FARTHEST_M = 10_000.0


@command("predict runs/choppy_sea-1/maps.nc", "predict maps.nc --lead 0:20:0.5 --at -100,0 --at 0,50")
def predict(
    maps: Annotated[Path, about("A maps.nc, as run and retrieve write it.")],
    *,
    lead: Annotated[str, about("START:STOP:STEP, seconds after the last that was seen.")] = "0:30:1",
    at: Annotated[
        list[str] | None,
        Parameter(
            negative=(),
            allow_leading_hyphen=True,
            help="EAST,NORTH, a place in metres; as often as wanted, default where the antennas are.",
        ),
    ] = None,
    out: Annotated[Path | None, about("Folder for prediction.nc; default beside the maps.")] = None,
    overwrite: Annotated[bool, about("Replace an earlier prediction.nc.")] = False,
    set_: Annotated[Settings | None, about("prediction.KEY=VALUE, as often as wanted.")] = None,
) -> int:
    """Forecast the sea from maps (prediction.nc): one forecast for each turn, from what was seen up to then."""
    from ..settings import PredictionSettings

    leads, places = _leads(lead), [_place(each) for each in at] if at else None
    settings = section_of(PredictionSettings, "prediction", "predict", set_, lead_s=float(leads.max()))
    from ..io.opening import check_file

    check_file(maps, "a maps.nc", named=f"MAPS = '{maps}'")
    from ..io.appendable import AppendableNetCDF  # these take a second: what was typed is checked before
    from ..io.results_folder import clear_folder, note_growing, refuse_unfinished, results_folder
    from ..prediction import forecasts

    refuse_unfinished(maps.parent, "MAPS")
    folder = out or maps.parent
    with results_folder(folder, overwrite, (_PRODUCT,)):
        seen = _opened_maps(maps)
        made = forecasts(seen, places, leads, settings)
        first = next(made, None)  # what is refused is refused before earlier results go
        if first is None:
            raise InputError(f"MAPS = '{maps}': no turn shows a sea; nothing can be forecast from it")
        clear_folder(folder, (_PRODUCT,))
        issued, last = 0, first
        with note_growing(folder, (_PRODUCT,)), AppendableNetCDF(folder / _PRODUCT, ("issue",)) as file:
            for last in chain([first], made):
                file.append(last)
                issued += 1
    if notes := last.attrs.get("vessel_notes"):
        console.print(f"flag: {notes}")
    console.print(*_headlines(last, issued, seen["polar"].sizes["turn"]), folder / _PRODUCT, sep="\n")
    return 0


def _opened_maps(maps: Path) -> xr.DataTree:
    from ..io.opening import load, open_tree

    try:
        with open_tree(maps, "a maps.nc", named=f"MAPS = '{maps}'") as tree:
            return load(tree, f"MAPS = '{maps}'", maps, dense=False)
    except OSError as error:
        raise InputError(f"MAPS = '{maps}': cannot be read as NetCDF ({error}); give a maps.nc") from None


def _leads(text: str) -> NDArray[np.float64]:
    """Seconds from START:STOP:STEP, both ends included."""
    import numpy as np

    about, form = f"--lead {text}", "as in --lead 0:30:1"
    if ":" not in text:
        raise InputError(f"{about}: must be START:STOP:STEP in seconds, {form}")
    leads = np.array([float(each) for each in number_list(text, about, form, _MOST_LEADS)])
    if not (leads[0] >= 0.0 and leads[-1] <= _LONGEST_S):
        raise InputError(f"{about}: must run from 0 s or later up to {_LONGEST_S:g} s, {form}")
    return leads


def _place(text: str) -> tuple[float, float]:
    try:
        east, north = (parse_number(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--at {text}: must be EAST,NORTH in metres, as in --at -100,0") from None
    if not (abs(east) <= _FARTHEST_M and abs(north) <= _FARTHEST_M):
        raise InputError(f"--at {text}: must be within {_FARTHEST_M:g} m of the origin")
    return east, north


def _headlines(last: xr.Dataset, issued: int, turns: int) -> list[str]:
    """What the last forecast says of the first place."""
    from ..conventions import written

    here = last.isel(issue=0, place=0)
    sea = float(here["significant_wave_height"]) / 4.0
    lines = [f"{issued} forecasts from {turns} turns" + ("" if issued == turns else ": other turns show no sea")]
    for lead in (10.0, 30.0):
        at = here.sel(lead=lead, method="nearest")
        mean, std = float(at["elevation"]), float(at["elevation_std"])
        if abs(float(at["lead"]) - lead) < 1.0:
            lines.append(
                f"{lead:g} s after the last look: {mean:+.2f} ± {written(std, 2)} m ({std / sea:.2f} of the sea's own)"
            )
    longest = float(here["maximum_prediction_time"])
    lines.append(f"maximum prediction time {longest:.1f} s: until then the stated error is below half of the sea's own")
    return lines


@command("recover runs/choppy_sea-1", "recover night")
def recover(folder: Annotated[Path, about("Of the run.")], /) -> int:
    """Put what a kill or a full disk has left of a run under its own names: every turn that is whole in all its
    files."""
    from ..io.recovery import recover as recover_folder
    from ..io.results_folder import RUN

    found = recover_folder(folder)
    if found is None:
        console.print(f"{folder}: nothing to recover, no process was stopped while it wrote here")
        return 0
    if found.complete == 0:
        console.print(f"{folder}: no whole one of the {found.unit} was left, and what there was is removed")
        return 0
    whole = f"all {found.unit}" if found.complete is None else f"{found.complete} whole {found.unit}"
    missing = [name for name in ("metrics.json", "report.html") if not (folder / name).exists()]
    rest = f"; {' and '.join(missing)} are missing" if RUN in found.files and "maps.nc" in found.files else ""
    console.print(f"{folder}: {whole} in {', '.join(found.files)}{rest if missing else ''}")
    return 0


_EXPORTS: dict[Kind, str] = {
    "netcdf": "ground.nc",
    "geotiff": "ground.tif",
    "csv": "ground.csv",
    "cfradial": "polar_cfradial.nc",
}
_EXPORT = re.compile(r"ground(-\d+)?\.(nc|tif|csv)|polar_cfradial\.nc")


@command(
    "retrieve runs/choppy_sea-1 --out again",
    "retrieve night.npz --header header.toml --to geotiff --at 54.32,-7.5",
)
def retrieve(
    echoes: Annotated[Path, about("Folder of a run, a Zarr store, or a recording as .npz, .mat, .h5, .hdf5 or .nc.")],
    *,
    header: Path | None = None,
    name: Names | None = None,
    out: Annotated[Path | None, about("Folder for maps.nc and retrieval.html; default beside the echoes.")] = None,
    follow: Number = 0.0,
    stream: StreamTo = None,
    stream_format: StreamFormat = None,
    wind_from: Number | None = None,
    to: Annotated[list[str] | None, Parameter(negative=(), consume_multiple=False)] = None,
    at: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,  # the south is negative
    even_if_wrong: Annotated[bool, Parameter(negative=())] = False,
    overwrite: Annotated[bool, about("Replace an earlier maps.nc.")] = False,
    set_: Annotated[Settings | None, about("retrieval.KEY=VALUE, in place of what the echoes carry.")] = None,
) -> int:
    """Heights and slopes (maps.nc) from echoes that keep the schema, or a recording. Never opens a truth.

    What the echoes say of themselves (sign of the phase, offsets, gaps, gain) is inspected first: what is surely wrong
    is refused, what is doubtful is said in the first lines and in retrieval.html.

    Parameters
    ----------
    header
        Of a recording: a TOML or JSON file that describes the radar, where the recording does not.
    name
        Of a recording: ARRAY=NAME, what it calls an array, as in lower=rx/1; as often as wanted.
    follow
        Go on while the echoes grow, until no new turn has come for so many seconds.
    wind_from
        Degrees clockwise from north from which the wind blows, to compare the echo's drift with.
    to
        geotiff, csv, netcdf or cfradial, as often as wanted: beside maps.nc the ground maps with latitude and
        longitude, or the polar maps as CfRadial 2.
    at
        LAT,LON of the antenna at time 0, degrees north and east, for --to.
    even_if_wrong
        Retrieve what is surely wrong as well.
    """
    from ..settings import RetrievalSettings

    settings = section_of(RetrievalSettings, "retrieval", "retrieve", set_).model_dump(exclude_unset=True)
    if not echoes.exists():
        wanted = {"": "a run's folder or of a recording", ".zarr": "a run.zarr"}.get(echoes.suffix, "a recording")
        raise InputError(f"ECHOES = '{echoes}': no such file or folder; give the path of {wanted}")
    for option, value in (("--follow", follow), ("--wind-from", wind_from or 0.0)):
        if not math.isfinite(value) or (option == "--follow" and value < 0.0):
            must = "seconds, at least 0" if option == "--follow" else "degrees clockwise from north"
            raise InputError(f"{option} = {value:g}: must be {must}; correct it")
    kinds, origin = _exports(to, at)
    import xarray as xr  # these take two seconds: what was typed is checked before

    from ..conventions import turn_name
    from ..interferometry.checks import store_of_echoes
    from ..io.exports import export, headings
    from ..io.results_folder import refuse_unfinished, results_folder, write_whole
    from ..report.retrieved_page import RETRIEVED, retrieved_page
    from ..session.retrieving import MAPS, retrieve_into
    from ..wavefield import sea_state
    from ..wavefield.sea_state import in_words

    def print_turn(turn: Turn) -> None:
        polar = turn.maps["polar"].to_dataset()
        console.print(f"{turn_name(polar['turn'].values[-1])}: {_answered_share(turn.maps)[0]}")

    home = store_of_echoes(echoes)[0].parent
    folder = out or home
    earlier = tuple(path.name for path in folder.glob("*.*") if _EXPORT.fullmatch(path.name))
    products = (MAPS, RETRIEVED, *earlier)
    refuse_unfinished(home, "ECHOES")
    with streaming(stream, stream_format) as broadcast, results_folder(folder, overwrite, (MAPS,)):
        tell = [print_turn] if follow else []
        if broadcast is not None:
            from ..session.streaming import RetrievalStream

            tell.append(RetrievalStream(broadcast, stream_format or "json").turn)

        def tell_all(turn: Turn) -> None:
            for each in tell:
                each(turn)

        found = retrieve_into(
            folder,
            lambda: _opened(echoes, header, name),
            settings,
            products,
            wait_s=follow,
            wind_from_deg=wind_from,
            even_if_wrong=even_if_wrong,
            on_turn=tell_all,
        )
        with xr.open_datatree(found.maps) as opened:
            maps = opened.load()
        summary = [*_answered_share(maps), f"sea state: {in_words(sea_state(maps))}"]
        page = retrieved_page(maps, found.findings, summary, found.echoes.attrs, echoes.name)
        write_whole(folder / RETRIEVED, page)
        heading = headings(found.echoes, maps["ground"].to_dataset()["turn"].values)
        written = [
            file for kind in kinds for file in export(maps, folder / _EXPORTS[kind], origin, kind, heading_deg=heading)
        ]
    grave = {"wrong": "surely wrong", "doubtful": "doubtful"}
    for finding in found.findings:
        if finding.verdict in grave:
            console.print(f"{grave[finding.verdict]}: {finding.line}")
    console.print(*summary, found.maps, folder / RETRIEVED, *written, sep="\n")
    return 0


def _exports(to: list[str] | None, at: str | None) -> tuple[list[Kind], Origin | str]:
    """Kinds of files that are wanted beside maps.nc, and where on Earth they are."""
    from ..io.exports import origin_of

    kinds = [kind.strip() for each in to or [] for kind in each.split(",")]
    for kind in kinds:
        if kind not in _EXPORTS:
            raise InputError(f"--to {kind}: must be {', '.join(_EXPORTS)}; give one of them, or several")
    if (at is None) != (not kinds):
        missing = f"--to {', '.join(_EXPORTS)}" if at else "--at LAT,LON of the antenna, as in --at 54.32,-7.5"
        raise InputError(f"{'--at' if at else '--to'}: needs {missing}; give both or neither")
    return list(dict.fromkeys(kinds)), origin_of(at, "--at") if at else ""  # type: ignore[arg-type]


def _opened(echoes: Path, header: Path | None, name: list[str] | None) -> xr.Dataset:
    """Echoes from a store, or from a recording and its header."""
    from ..interferometry import open_echoes, open_recording
    from ..io.recorded import RECORDING_ENDINGS

    if echoes.suffix.lower() in RECORDING_ENDINGS:
        return open_recording(echoes, header, overrides_of(name, "--name"))
    if header is None:
        return open_echoes(echoes)
    raise InputError(f"--header {header}: goes with a recording ({', '.join(RECORDING_ENDINGS)}); leave it out")


def _answered_share(maps: xr.DataTree) -> list[str]:
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
