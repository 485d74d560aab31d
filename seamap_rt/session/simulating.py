"""A scene's echoes and the truth beside them, in memory or on the disk, and the sinks of turns that keep them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import xarray as xr

from ..echoes.video import polar_image
from ..errors import must_be
from ..gauges import gauge_series
from ..interferometry import open_echoes
from ..io.growing_store import GrowingStore
from ..io.polar_images import write_polar_image
from ..io.process import Progress
from ..io.results_folder import OF_RUN, RUN, clear_folder, note_growing, results_folder
from ..io.text import TableMixin
from ..report.headline import run_facts
from ..scene import SceneLike, as_scene
from ..simulation import Simulator
from .driver import FinishedTurn, Sink, deliver, iterate


class FileSink(Sink):
    """Appends what `select` picks of each turn to a file, such as a GrowingStore or an AppendableNetCDF, which is
    closed at the end."""

    def __init__(self, file: Any, select: Callable[[FinishedTurn], Any], stage: str = "write") -> None:
        self.stage = stage
        self._file, self._select = file, select

    def turn(self, turn: FinishedTurn) -> None:
        self._file.append(self._select(turn))

    def __enter__(self) -> Self:
        self._file.__enter__()
        return self

    def __exit__(self, *raised: Any) -> bool | None:
        return self._file.__exit__(*raised)


def run_store(folder: Path, files: Sequence[str]) -> GrowingStore:
    """The store of what a run's folder grows by; these files are made of it at the end."""
    return GrowingStore(
        folder / RUN, ("turn", "pulse", "sample", "issue"), {OF_RUN[name]: folder / name for name in files}
    )


class GaugeSink(Sink):
    """What the scene's gauges read in the latest turn (schema `gauges`). The turns must hold maps."""

    stage = "truth"

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator
        self.latest: xr.Dataset | None = None

    def turn(self, turn: FinishedTurn) -> None:
        assert turn.maps is not None
        simulator, period = self._simulator, self._simulator.installation.period
        middle = simulator.installation.sensed.pose(np.array([(turn.number + 0.5) * period])).origin[0, :2]
        of_turn = {"turn_s": period, "antenna_m": middle}
        self.latest = gauge_series(turn.maps, simulator.sea, simulator.scene.gauges, turn.truth, **of_turn)


IMAGES = "polar_images"


class ImageSink(Sink):
    """Writes what a marine radar shows of each turn, `polar_images/turn-0001.pol` and on."""

    def __init__(self, folder: Path, simulator: Simulator) -> None:
        installation, scattering = simulator.installation, simulator.scene.scattering
        self._folder, self._radar = folder / IMAGES, installation.radar
        self._said = {
            "ship_speed_m_s": installation.platform.speed_m_s,
            "wind_speed_m_s": scattering.wind_speed_m_s,
            "wind_from_deg": scattering.wind_from_deg,
        }

    def turn(self, turn: FinishedTurn) -> None:
        self._folder.mkdir(exist_ok=True)
        path = self._folder / f"turn-{turn.number + 1:04d}.pol"
        write_polar_image(path, polar_image(turn.echoes, self._radar, self._said))


def image_sinks(folder: Path, simulator: Simulator) -> list[ImageSink]:
    """The pictures of a radar that shows any."""
    return [ImageSink(folder, simulator)] if simulator.installation.radar.receiver.chain == "video" else []


def concatenate_turns(turns: Sequence[xr.DataTree]) -> xr.DataTree:
    """One tree of several turns' trees, each with the groups `polar` and `ground`, as their file has them."""
    if len(turns) == 1:
        return turns[0]
    how: Any = {"data_vars": "minimal", "coords": "minimal", "compat": "override"}
    groups = {str(n): xr.concat([turn[n].to_dataset() for turn in turns], "turn", **how) for n in turns[0]}
    return xr.DataTree.from_dict(groups)


class Memory(Sink):
    """Keeps the echoes and the truth of all turns in memory."""

    def __init__(self) -> None:
        self._echoes: list[xr.Dataset] = []
        self._truth: list[xr.DataTree] = []

    def turn(self, turn: FinishedTurn) -> None:
        self._echoes.append(turn.echoes)
        self._truth.append(turn.truth)

    @property
    def echoes(self) -> xr.Dataset:
        """The echoes of all turns (schema `echoes`)."""
        joined = xr.concat(self._echoes, "pulse", data_vars="minimal", coords="minimal", compat="override")
        joined.attrs = self._echoes[-1].attrs
        return joined

    @property
    def truth(self) -> xr.DataTree:
        """The truth of all turns: groups `polar` and `ground`."""
        return concatenate_turns(self._truth)


PRODUCTS = (RUN, "echoes.zarr", "truth.nc", IMAGES)  # the second of earlier versions


@dataclass(frozen=True, repr=False)
class Simulation(TableMixin):
    """Echoes and truth of a whole run, and what is known of how it was made.

    echoes: schema `echoes`. truth: groups `polar` and `ground` (schemas `truth/…`). timing: seconds by stage, turn by
    turn. facts: what was modelled, what was left out, and the parts of metrics.json that describe mesh and sea.
    """

    echoes: xr.Dataset
    truth: xr.DataTree
    timing: list[dict[str, float]]
    facts: dict[str, Any]

    def rows(self) -> list[tuple[str, str]]:
        """What it holds, and what it took."""
        sizes, attrs = self.echoes.sizes, self.echoes.attrs
        gates, seconds = self.echoes["range"].values, [turn["total"] for turn in self.timing]
        polar, sea = self.truth["polar"].sizes, self.facts["sea"]
        return [
            ("radar", f"{1e-9 * attrs['frequency_hz']:.4g} GHz, {attrs['height_m']:.3g} m high, {attrs['transmit']}"),
            ("echoes", f"{sizes['pulse']} pulses of {sizes['receiver']} receivers in {attrs['complete_turns']} turns"),
            ("range", f"{gates[0]:.4g}–{gates[-1]:.4g} m in {gates.size} gates"),
            ("truth", f"{polar['azimuth']} looks of {polar['range']} cells"),
            ("sea", f"significant wave height {4.0 * sea['elevation_std']:.3g} m, as resolved"),
            ("time", f"{sum(seconds):.3g} s, {min(seconds):.3g} s the fastest turn"),
            ("left out", f"{len(self.facts['left_out'])} effects, each with its error: .facts['left_out']"),
        ]


def simulate(
    scene: SceneLike, out: str | Path | None = None, *, overwrite: bool = False, progress: Progress | None = None
) -> Simulation:
    """Simulate all turns of a scene, or of that which a file or a shipped scene's name stands for.

    out: a folder into whose `run.zarr` echoes and truth are streamed turn by turn, so that memory holds one turn, with
    `truth.nc` made at the end; the datasets of the result are then read from there, and `radar.receiver.chain =
    "video"` leaves the picture of each turn in `polar_images`, for `read_polar_images`. Without it everything stays in
    memory. Earlier echoes or truth in that folder are replaced only with `overwrite`. progress: called with a line on
    each stage as it begins.
    Raises InputError for a scene that cannot be simulated, NoBackendError if rays are requested and cannot be traced.
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
            store = FileSink(run_store(folder, ["truth.nc"]), lambda t: {"echoes": t.echoes, "truth": t.truth})
            with note_growing(folder, (RUN, "truth.nc")):
                figures = deliver(turns, [store, *image_sinks(folder, simulator)])
        echoes, truth = open_echoes(folder / RUN), xr.open_datatree(folder / "truth.nc")
    facts = run_facts(scene, simulator.sea, simulator.surface)
    return Simulation(echoes, truth, [turn.timing for turn in figures], facts)
