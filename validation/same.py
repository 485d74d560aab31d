"""Do two versions compute the same? Echoes, maps, truth, gauges, forecasts and expectations, array by array.

python -m validation.same OLD NEW [--tolerance 0] [--only SCENE]

OLD and NEW are folders of results, or two of the program: checkouts, or wheels that were unpacked (`pip wheel`,
`python -m zipfile -e`). Each of these computes a turn of six scenes by rays and by the horizon, in VV and in HH. The
metrics may gain keys. With a tolerance arrays may differ by that share of their own rms. Exit 1 where anything differs.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

PRODUCTS = ("run.zarr", "maps.nc", "truth.nc")
FURTHER = ("gauges.nc", "prediction.nc", "expected.nc")  # where they are
SCENES = ("choppy_sea", "harbour", "rough_ride", "pier", "magnetron_pair", "wind_and_swell")
_TURN = """
import sys
import seamap_rt as sr
from seamap_rt.report import page
page.pictures = lambda *_: ()
name, tracer, polarization, out = sys.argv[1:]
scene = sr.load_scene(name, {"turns": 1, "tracing.tracer": tracer, "scattering.polarization": polarization})
sr.run(scene, out, predict=True)
expected = sr.expected(scene)
parts = {f"{name}_{part}": getattr(expected[name], part) for name in expected.data_vars for part in ("real", "imag")}
coordinates = expected.drop_vars(list(expected.data_vars))
coordinates.assign(parts).drop_attrs().to_netcdf(out + "/expected.nc", engine="h5netcdf")
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--tolerance", type=float, default=0.0, help="of each array's own rms")
    parser.add_argument("--only", action="append", choices=SCENES, help="of the scenes, as often as wanted")
    arguments = parser.parse_args()
    for folder in (arguments.old, arguments.new):
        if not ((folder / "seamap_rt").is_dir() or _stores(folder)):
            parser.error(f"{folder}: holds neither a program (seamap_rt) nor results (run.zarr); give one that does")
    programs = [folder for folder in (arguments.old, arguments.new) if (folder / "seamap_rt").is_dir()]
    if len(programs) == 1:
        parser.error(f"{programs[0]}: is a program, and the other folder is none; give two of a kind")
    of_both = arguments.old, arguments.new, arguments.tolerance
    wrong = 0
    for line in versions(*of_both, arguments.only or SCENES) if programs else differences(*of_both):
        print(line, flush=True)
        wrong += not line.startswith("the same: ")
    if wrong:
        sys.exit(1)
    print(f"{arguments.new}: the same as {arguments.old}")


def versions(old: Path, new: Path, tolerance: float, scenes: Sequence[str]) -> Iterator[str]:
    """Lines on what two versions of the program compute otherwise, and one on each scene in which they do not."""
    for name, tracer, polarization in product(scenes, ("facets", "horizon"), ("VV", "HH")):
        label = f"{name}, {tracer}, {polarization}"
        with tempfile.TemporaryDirectory() as home:
            folders = []
            for program, which in ((old, "old"), (new, "new")):
                folders.append(Path(home) / which)
                words = (name, tracer, polarization, str(folders[-1]))
                subprocess.run(
                    [sys.executable, "-P", "-c", _TURN, *words],
                    env=os.environ | {"PYTHONPATH": str(program.resolve())}, cwd=home, check=True,
                )  # fmt: skip
            wrong = list(differences(folders[0], folders[1], tolerance))
        yield from (f"{label}: {line}" for line in wrong)
        if not wrong:
            yield f"the same: {label}"


def differences(old: Path, new: Path, tolerance: float = 0.0) -> Iterator[str]:
    """A line for each thing that is not the same in two folders of results."""
    first, second = dict(arrays(old)), dict(arrays(new))
    for name in sorted({*first, *second}):
        if name not in first or name not in second:
            yield f"{name}: only in {old if name in first else new}"
        elif (far := _distance(first[name], second[name])) > tolerance:
            yield f"{name}: differs, by {far:.3g} of its rms"
    keys = [set(_keys(json.loads((folder / "metrics.json").read_text(encoding="utf-8")))) for folder in (old, new)]
    for key in sorted(keys[0] - keys[1]):
        yield f"metrics.json {key}: only in {old}"


def arrays(folder: Path, products: Sequence[str] = (*PRODUCTS, *FURTHER)) -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    """The arrays of these products in a folder of results, by file, group and name."""
    for store, group in _stores(folder) if "run.zarr" in products else ():
        with xr.open_zarr(store, group=group, consolidated=False) as echoes:
            yield from ((f"echoes {name}", echoes[name].values) for name in echoes.variables)
    for file in (name for name in products if name.endswith(".nc")):
        if file in FURTHER and not (folder / file).exists():
            continue
        with xr.open_datatree(folder / file) as tree:
            for group in tree.groups:
                data = tree[group].to_dataset()
                yield from ((f"{file}{group} {name}", data[name].values) for name in data.variables)


def _stores(folder: Path) -> list[tuple[Path, str | None]]:
    """Where the echoes of a folder are, and their group; an earlier version has them in a store of their own."""
    stores = (folder / "run.zarr", "echoes"), (folder / "echoes.zarr", None)
    return [(store, group) for store, group in stores if store.is_dir()]


def _distance(old: np.ndarray[Any, Any], new: np.ndarray[Any, Any]) -> float:
    """0 for the same bits (NaN beside NaN counts); else the rms difference over the rms, infinite where that fails."""
    if old.shape != new.shape or old.dtype != new.dtype:
        return float("inf")
    if old.dtype.kind not in "fc":
        return 0.0 if np.array_equal(old, new) else float("inf")
    if np.array_equal(old, new, equal_nan=True):
        return 0.0
    known = ~np.isnan(old)
    if not np.array_equal(known, ~np.isnan(new)):
        return float("inf")
    scale = float(np.sqrt(np.mean(np.abs(old[known]) ** 2)))
    return float(np.sqrt(np.mean(np.abs(new[known] - old[known]) ** 2))) / scale if scale > 0.0 else float("inf")


def _keys(value: Any, above: str = "") -> Iterator[str]:
    """Paths of keys; the entries of a list are one another's like."""
    if isinstance(value, dict):
        for key, entry in value.items():
            yield f"{above}.{key}"
            yield from _keys(entry, f"{above}.{key}")
    elif isinstance(value, list):
        for entry in value:
            yield from _keys(entry, f"{above}[]")


if __name__ == "__main__":
    main()
