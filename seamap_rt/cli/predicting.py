"""The command `predict`: forecasts from maps."""

from __future__ import annotations

from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ..errors import InputError
from ..io.text import parse_number
from .shell import Settings, command, console, section_of

if TYPE_CHECKING:
    import numpy as np  # loaded where they are used: they take half a second
    import xarray as xr
    from numpy.typing import NDArray

_PRODUCT = "prediction.nc"
_LONGEST_S, _MOST_LEADS = 60.0, 10_000
_FARTHEST_M = 10_000.0


@command("predict runs/choppy_sea-1/maps.nc", "predict maps.nc --lead 0:20:0.5 --at -100,0 --at 0,50")
def predict(
    maps: Path,
    *,
    lead: str = "0:30:1",
    at: Annotated[list[str] | None, Parameter(negative=(), allow_leading_hyphen=True)] = None,
    out: Path | None = None,
    overwrite: bool = False,
    set_: Settings | None = None,
) -> int:
    """Forecast the sea from maps (prediction.nc): one forecast for each turn, from what was seen up to then.

    Parameters
    ----------
    maps
        A maps.nc, as run and retrieve write it.
    lead
        START:STOP:STEP, seconds after the last that was seen.
    at
        EAST,NORTH, a place in metres; as often as wanted, default where the antennas are.
    out
        Folder for prediction.nc; default beside the maps.
    overwrite
        Replace an earlier prediction.nc.
    set_
        prediction.KEY=VALUE, as often as wanted.
    """
    from ..settings import PredictionSettings

    leads, places = _leads(lead), [_place(each) for each in at] if at else None
    settings = section_of(PredictionSettings, "prediction", "predict", set_, lead_s=float(leads.max()))
    from ..io.opening import check_file

    check_file(maps, "a maps.nc", named=f"MAPS = '{maps}'")
    from ..io.appendable import AppendableNetCDF  # these take a second: what was typed is checked before
    from ..io.results_folder import clear_folder, growing, refuse_unfinished, results_folder
    from ..prediction import forecasts

    refuse_unfinished(maps.parent, "MAPS")
    folder = out or maps.parent
    with results_folder(folder, overwrite, (_PRODUCT,)):
        seen = _opened(maps)
        made = forecasts(seen, places, leads, settings)
        first = next(made, None)  # what is refused is refused before earlier results go
        if first is None:
            raise InputError(f"MAPS = '{maps}': no turn shows a sea; nothing can be forecast from it")
        clear_folder(folder, (_PRODUCT,))
        issued, last = 0, first
        with growing(folder, (_PRODUCT,)), AppendableNetCDF(folder / _PRODUCT, ("issue",)) as file:
            for last in chain([first], made):
                file.append(last)
                issued += 1
    if told := last.attrs.get("vessel_notes"):
        console.print(f"flag: {told}")
    for line in _headlines(last, issued, seen["polar"].sizes["turn"]):
        console.print(line)
    console.print(str(folder / _PRODUCT))
    return 0


def _opened(maps: Path) -> xr.DataTree:
    from ..io.opening import load, open_tree

    try:
        with open_tree(maps, "a maps.nc", named=f"MAPS = '{maps}'") as tree:
            return load(tree, f"MAPS = '{maps}'", maps, dense=False)
    except OSError as error:
        raise InputError(f"MAPS = '{maps}': cannot be read as NetCDF ({error}); give a maps.nc") from None


def _leads(text: str) -> NDArray[np.float64]:
    """Seconds from START:STOP:STEP, both ends included."""
    import numpy as np

    try:
        start, stop, step = (parse_number(part) for part in text.split(":"))
    except ValueError:
        raise InputError(f"--lead {text}: must be START:STOP:STEP in seconds, as in --lead 0:30:1") from None
    if not (0.0 <= start <= stop <= _LONGEST_S and step > 0.0):
        raise InputError(f"--lead {text}: must run from 0 s or later up to {_LONGEST_S:g} s by a step above 0")
    if (stop - start) / step > _MOST_LEADS:
        raise InputError(f"--lead {text}: asks for more than {_MOST_LEADS:,} leads; take a longer step")
    return start + step * np.arange(int((stop - start) / step + 1e-9) + 1, dtype=np.float64)


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
