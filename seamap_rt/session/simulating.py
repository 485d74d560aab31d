"""A scene's echoes and the truth beside them, in memory or on the disk."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from ..errors import must_be
from ..interferometry import open_echoes
from ..io.appendable import AppendableNetCDF
from ..io.echo_store import EchoStore
from ..io.results_folder import clear_folder, growing, results_folder
from ..report.headline import run_facts
from ..scene import SceneLike, as_scene
from ..simulation import Simulator
from .driver import Progress, deliver, iterate
from .sinks import FileSink, Memory

PRODUCTS = ("echoes.zarr", "truth.nc")


@dataclass(frozen=True)
class Simulation:
    """Echoes and truth of a whole run, and what is known of how it was made.

    echoes: schema `echoes`. truth: groups `polar` and `ground` (schemas `truth/…`). timing: seconds by stage, turn by
    turn. facts: what was modelled, what was left out, and the parts of metrics.json that describe mesh and sea.
    """

    echoes: xr.Dataset
    truth: xr.DataTree
    timing: list[dict[str, float]]
    facts: dict[str, Any]


def simulate(
    scene: SceneLike, out: str | Path | None = None, *, overwrite: bool = False, progress: Progress | None = None
) -> Simulation:
    """Simulate all turns of a scene, or of that which a file or a shipped scene's name stands for.

    out: a folder into which `echoes.zarr` and `truth.nc` are streamed turn by turn, so that memory holds one turn; the
    datasets of the result are then read from there. Without it everything stays in memory. Earlier echoes or truth in
    that folder are replaced only with `overwrite`. progress: called with a line on each stage as it begins.
    Raises InputError for a scene that cannot be simulated, NoBackend if rays are requested and cannot be traced.
    """
    scene = as_scene(scene)
    if out is not None:
        must_be("out", out, (str, os.PathLike), "the path of a folder")
    simulator = Simulator(scene)
    turns = iterate(scene, simulator=simulator, retrieved=False, progress=progress)
    if out is None:
        memory = Memory()
        figures = deliver(turns, [memory])
        echoes, truth = memory.echoes, memory.truth
    else:
        folder = Path(out)
        with results_folder(folder, overwrite, PRODUCTS):
            clear_folder(folder, PRODUCTS)
            store, file = EchoStore(folder / "echoes.zarr"), AppendableNetCDF(folder / "truth.nc")
            with growing(folder, PRODUCTS):
                figures = deliver(turns, [FileSink(file, lambda t: t.truth), FileSink(store, lambda t: t.echoes)])
        echoes, truth = open_echoes(store.path), xr.open_datatree(file.path)
    facts = run_facts(scene, simulator.sea, simulator.surface)
    return Simulation(echoes, truth, [turn.timing for turn in figures], facts)
