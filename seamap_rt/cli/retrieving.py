"""The command `retrieve`: maps from echoes or a recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from ..dataset import QUALITY_FLAGS
from ..errors import InputError
from .shell import Names, Settings, app, console, overrides_of, section_of


@app.command
def retrieve(
    echoes: Path,
    *,
    header: Path | None = None,
    name: Names | None = None,
    out: Path | None = None,
    overwrite: bool = False,
    set_: Settings | None = None,
) -> int:
    """Heights and slopes (maps.nc) from echoes that keep the schema, or a recording. Never opens a truth file.

    Parameters
    ----------
    echoes
        A Zarr store, or a recording as .npz, .h5, .hdf5 or .nc.
    header
        Of a recording: a TOML or JSON file that describes the radar, where the recording does not.
    name
        Of a recording: ARRAY=NAME, what it calls an array, as in lower=rx/1; as often as wanted.
    out
        Folder for maps.nc; default beside the echoes.
    overwrite
        Replace an earlier maps.nc.
    set_
        retrieval.KEY=VALUE, as often as wanted.
    """
    from ..interferometry import retrieve as retrieve_echoes
    from ..io.appendable import AppendableNetCDF
    from ..io.results_folder import clear_folder, growing, refuse_unfinished, results_folder
    from ..settings import RetrievalSettings
    from ..wavefield import sea_state
    from ..wavefield.sea_state import in_words

    settings = section_of(RetrievalSettings, "retrieval", "retrieve", set_)
    if not echoes.exists():
        raise InputError(f"ECHOES = '{echoes}': no such file or folder; give the path of an echoes.zarr")
    folder = out or echoes.parent
    refuse_unfinished(echoes.parent, "ECHOES")
    with results_folder(folder, overwrite, ("maps.nc",)):
        recorded = _opened(echoes, header, name)
        maps = retrieve_echoes(recorded, settings)
        clear_folder(folder, ("maps.nc",))
        with growing(folder, ("maps.nc",)), AppendableNetCDF(folder / "maps.nc") as file:
            for turn in range(maps["polar"].sizes["turn"]):
                file.append(maps.isel(turn=slice(turn, turn + 1)))
    for line in _answered(maps):
        console.print(line)
    console.print(f"sea state: {in_words(sea_state(maps))}")
    console.print(str(folder / "maps.nc"))
    return 0


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
    polar = maps["polar"].to_dataset()
    known = np.isfinite(polar["height"].values)
    if known.any():
        spread = float(np.median(polar["height_std"].values[known]))
        return [f"{known.mean():.0%} of the cells answered, median error bar {spread:.3f} m"]
    flags = polar["quality"].values
    shares = {name: float(np.mean((flags & bit) != 0)) for name, bit in QUALITY_FLAGS.items()}
    reasons = ", ".join(f"{name} {share:.0%}" for name, share in shares.items() if share > 0.0)
    return [f"flag: no cell answered ({reasons})"]
