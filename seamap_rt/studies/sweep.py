"""A sweep's folder: what it is of, what of it is there already, and its table.

trade.json    what is swept: scene, keys and values, seeds, version of the package
points/*.json what came of each point
trade.csv, trade.nc, trade.png, trade.html
"""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import __version__
from ..errors import InputError
from ..io.opening import open_file, read_json
from ..io.process import uninterrupted
from ..io.results_folder import clear_folder, remove_hidden, results_folder, write_whole
from ..scene import Scene
from .choices import outlook_columns
from .point import MANIFEST, POINTS, Outcome, Task, ended, keep, load_point
from .trade_table import Criterion, rows, trade_page, trade_table
from .vary import Grid, Point, seeds_of

if TYPE_CHECKING:
    import xarray as xr

_POINT_FILES = "[0-9][0-9][0-9][0-9][0-9]_*.json"  # what a user keeps there has other names
PRODUCTS = ("trade.html", MANIFEST, "trade.csv", "trade.nc", "trade.png")


@dataclass(frozen=True)
class Sweep(Grid):
    """A grid of points and the folder that they are kept in. Raises InputError where no point can be run."""

    folder: Path
    notes: list[str] = field(default_factory=list, compare=False)  # which files of points were not believed

    def with_seeds(self, seeds: int) -> Sweep:
        """The same with so many seeds; the manifest, where there is one, says so."""
        result = Sweep(self.scene, self.vary, seeds_of(self.scene, seeds), self.folder, self.notes)
        write_whole(self.folder / MANIFEST, json.dumps(result.manifest, indent=1))
        return result

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """What the results depend on."""
        return {
            "version": __version__,
            "scene": self.scene.to_toml(),
            "vary": [[key, values] for key, values in self.vary.items()],
            "seeds": self.seeds,
            "files": self._files(),
        }

    def _files(self) -> dict[str, str]:
        """Fingerprints of the files that the scenes name: spectra, patterns, motions, objects."""
        trees = [tomllib.loads(scene.to_toml()) for scene in self.scenes if isinstance(scene, Scene)]
        paths = sorted({path for tree in trees for path in _named_files(tree)})
        return {path: _hash(path) for path in paths if Path(path).is_file()}

    # ----------------------------------------------------------------------------------------------- the folder

    @contextmanager
    def prepared(self, resume: bool, overwrite: bool) -> Iterator[None]:
        """The folder, held by this process and ready for the missing points.

        Raises InputError for a folder that holds something else, or which another process holds.
        """
        if resume and overwrite:
            raise InputError("--resume and --overwrite: one goes on with what is there, the other removes it; give one")
        file = self.folder / MANIFEST
        if resume:
            self._refuse_another(file)
        elif file.exists() and not overwrite:
            raise InputError(
                f"--out = '{self.folder}': holds a sweep already; give --resume to go on with it or --overwrite to "
                "begin anew, or choose another folder"
            )
        with results_folder(self.folder, resume or overwrite, PRODUCTS):
            if resume:
                remove_hidden(self.folder, PRODUCTS)
            else:
                clear_folder(self.folder, PRODUCTS)
            points = self.folder / POINTS
            points.mkdir(exist_ok=True)
            for left in (*points.glob(".*.part"), *(() if resume else points.glob(_POINT_FILES))):
                left.unlink()
            write_whole(file, json.dumps(self.manifest, indent=1))
            yield

    def _refuse_another(self, file: Path) -> None:
        try:
            stored = dict(read_json(file))
        except (OSError, ValueError, TypeError, RecursionError):
            raise InputError(
                f"--resume: '{file.parent}' holds no sweep; leave --resume out, or name its folder"
            ) from None
        words = {
            "version": f"version of seamap_rt ({stored.get('version')}, this is {__version__})",
            "scene": "scene",
            "vary": "grid of --vary",
            "files": "content of the files that the scene names",
        }
        for key, what in words.items():
            if stored.get(key) != self.manifest[key]:
                raise InputError(f"--resume: '{file.parent}' holds a sweep of another {what}; choose another folder")

    # ----------------------------------------------------------------------------------------------- the points

    def task(self, point: Point, scene: Scene | InputError) -> Task:
        """What a worker computes at a point."""
        text, sea = "", ""
        if isinstance(scene, Scene):
            text = scene.to_toml()
            sea = hashlib.sha256(f"{scene.seed} {scene.sea.model_dump_json()}".encode()).hexdigest()
        return Task(point.name, text, point.keys, point.seed, str(self.folder), sea)

    def missing(self) -> list[Task]:
        """Points to compute: those without a result, and those that failed. What the scene refuses is noted at once."""
        wanted: list[Task] = []
        for point, scene in zip(self.points, self.scenes, strict=True):
            task = self.task(point, scene)
            outcome, why_not = load_point(task)
            if why_not:
                self.notes.append(f"{POINTS}/{task.file.name}: {why_not}; the point is run again")
            if outcome is not None and outcome["status"] in ("done", "refused"):
                continue
            task.file.unlink(missing_ok=True)
            if isinstance(scene, InputError):
                keep(task, ended(task, "refused", "; ".join(scene.problems)))
            else:
                wanted.append(task)
        return wanted

    def outcomes(self) -> dict[tuple[int, ...], Outcome]:
        """What is there, by the point's place in the grid."""
        every = zip(self.points, self.scenes, strict=True)
        found = {point.index: load_point(self.task(point, scene))[0] for point, scene in every}
        return {index: outcome for index, outcome in found.items() if outcome is not None}

    def table(self, criterion: Criterion) -> xr.Dataset:
        """The results so far over the varied keys and seeds."""
        about = {"title": f"{self.scene.name}: {' × '.join(self.vary)}", "scene": self.scene.to_toml()}
        about["polarization"] = self.scene.scattering.polarization
        table = trade_table(self.vary, self.seeds, self.outcomes(), criterion, about)
        return table.merge(outlook_columns(self.vary, self.designs, table["range"].values), join="left")

    def write(self, table: xr.Dataset) -> None:
        """The table and its figure, as files."""
        # Matplotlib takes its time to load, and workers draw nothing.
        from ..report import style
        from .trade_figures import draw_trade, trade_images

        with uninterrupted():
            write_whole(self.folder / "trade.csv", rows(table))
            # By way of memory: HDF5 itself may crash on a full disk.
            write_whole(self.folder / "trade.nc", bytes(table.to_netcdf(engine="h5netcdf")))
        figure = style.png(draw_trade(table))
        write_whole(self.folder / "trade.png", figure)
        write_whole(self.folder / "trade.html", trade_page(table, trade_images(table, figure)))


def _named_files(tree: Any) -> Iterator[str]:
    """What stands under the keys `file` and `mesh`, anywhere in a scene."""
    if isinstance(tree, Mapping):
        yield from (tree[key] for key in ("file", "mesh") if isinstance(tree.get(key), str))
    if isinstance(tree, Mapping | list):
        for each in tree.values() if isinstance(tree, Mapping) else tree:
            yield from _named_files(each)


def _hash(path: str) -> str:
    with open_file(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
