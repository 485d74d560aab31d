"""The command `recover`: what a killed run has left, or one that met a full disk, becomes readable."""

from __future__ import annotations

from pathlib import Path

from .shell import command, console


@command("recover runs/choppy_sea-1", "recover night")
def recover(folder: Path, /) -> int:
    """Put what a kill or a full disk has left of a run under its own names: every turn that is whole in all its files.

    Parameters
    ----------
    folder
        Of the run.
    """
    from ..io.results_folder import recover as recover_folder

    found = recover_folder(folder)
    if found is None:
        console.print(f"{folder}: nothing to recover, no process was stopped while it wrote here")
        return 0
    if found.complete == 0:
        console.print(f"{folder}: no whole one of the {found.unit} was left, and what there was is removed")
        return 0
    whole = f"all {found.unit}" if found.complete is None else f"{found.complete} whole {found.unit}"
    missing = [name for name in ("metrics.json", "report.html") if not (folder / name).exists()]
    rest = f"; {' and '.join(missing)} are missing" if "maps.nc" in found.files and "echoes.zarr" in found.files else ""
    console.print(f"{folder}: {whole} in {', '.join(found.files)}{rest if missing else ''}")
    return 0
