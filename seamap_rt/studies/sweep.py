"""A sweep's folder: what it is of, what of it is there already, and its table.

trade.json    what is swept: scene, keys and values, seeds, version of the package
points/*.json what came of each point
trade.csv, trade.nc, trade.png, trade.html
"""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import __version__
from ..errors import InputError, must_be
from ..io.opening import open_file, read_json
from ..io.process import uninterrupted
from ..io.results_folder import clear_folder, remove_hidden, results_folder, write_whole
from ..io.scenefile import apply_overrides
from ..scene import Scene
from .choices import outlook_columns
from .point import MANIFEST, POINTS, Outcome, Task, ended, keep, load_point
from .trade_table import Criterion, rows, trade_table
from .vary import Point, Vary, grid, scenes_of, seeds_of

if TYPE_CHECKING:
    import xarray as xr

_POINT_FILES = "[0-9][0-9][0-9][0-9][0-9]_*.json"  # what a user keeps there has other names
PRODUCTS = ("trade.html", MANIFEST, "trade.csv", "trade.nc", "trade.png")


@dataclass(frozen=True)
class Sweep:
    """A grid of points and the folder that they are kept in. Raises InputError where no point can be run."""

    scene: Scene
    vary: Vary
    seeds: list[int]
    folder: Path
    notes: list[str] = field(default_factory=list, compare=False)  # which files of points were not believed

    @classmethod
    def of(cls, scene: Scene, vary: Mapping[str, Sequence[Any]], seeds: int, folder: Path) -> Sweep:
        """vary: values by scene key; seeds: how many. Raises InputError for fewer than one seed."""
        wanted = "a dict of lists, such as {'radar.height_m': [3, 5, 10]}"
        must_be("vary", vary, Mapping, wanted)
        for key, each in vary.items():
            must_be(f"vary: {key}", each, Iterable, wanted)
        plain = {key: apply_overrides({}, {"values": list(each)})["values"] for key, each in vary.items()}
        values = json.loads(json.dumps(plain, default=str))  # dates, too, are what was written
        return cls(scene, values, seeds_of(scene, seeds), folder)

    def with_seeds(self, seeds: int) -> Sweep:
        """The same with so many seeds; the manifest, where there is one, says so."""
        result = Sweep(self.scene, self.vary, seeds_of(self.scene, seeds), self.folder, self.notes)
        write_whole(self.folder / MANIFEST, json.dumps(result.manifest, indent=1))
        return result

    @cached_property
    def points(self) -> list[Point]:
        """The grid's points, the seeds varying fastest."""
        return grid(self.scene, self.vary, self.seeds)

    @cached_property
    def scenes(self) -> list[Scene | InputError]:
        """The scene of each point, or why it has none."""
        return scenes_of(self.scene, self.points)

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
        table = trade_table(self.vary, self.seeds, self.outcomes(), criterion, about)
        return table.merge(outlook_columns(self.vary, self._one_seed, table["range"].values), join="left")

    @cached_property
    def _one_seed(self) -> dict[tuple[int, ...], Scene | InputError]:
        """The scene of each design, by its place in the grid without the seeds."""
        return {
            point.index[:-1]: scene
            for point, scene in zip(self.points, self.scenes, strict=True)
            if point.index[-1] == 0
        }

    def write(self, table: xr.Dataset) -> None:
        """The table and its figure, as files."""
        # Matplotlib takes its time to load, and workers draw nothing.
        from ..report import style
        from .trade_figures import draw_trade, trade_page

        with uninterrupted():
            write_whole(self.folder / "trade.csv", rows(table))
            # By way of memory: HDF5 itself may crash on a full disk.
            write_whole(self.folder / "trade.nc", bytes(table.to_netcdf(engine="h5netcdf")))
        figure = style.png(draw_trade(table))
        write_whole(self.folder / "trade.png", figure)
        write_whole(self.folder / "trade.html", trade_page(table, figure))


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
