"""Do two runs hold the same bits? Echoes, maps, truth and gauges of two folders, and do the metrics keep their keys?

python -m validation.same_bits OLD NEW [--tolerance 0]

Made for changes that must change nothing: `seamap-rt run SCENE --out OLD` before, `--out NEW` after. The metrics may
gain keys. With a tolerance, arrays may differ by that share of their own rms. Exit 1 where anything differs.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

PRODUCTS = ("echoes.zarr", "maps.nc", "truth.nc")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--tolerance", type=float, default=0.0, help="of each array's own rms")
    arguments = parser.parse_args()
    wrong = list(differences(arguments.old, arguments.new, arguments.tolerance))
    for line in wrong:
        print(line)
    if wrong:
        sys.exit(1)
    print(f"{arguments.new}: the same as {arguments.old}")


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


def arrays(folder: Path, products: Sequence[str] = PRODUCTS) -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    """The arrays of these products in a folder of results, and of gauges, by file, group and name."""
    if "echoes.zarr" in products:
        with xr.open_zarr(folder / "echoes.zarr", consolidated=False) as echoes:
            yield from ((f"echoes {name}", echoes[name].values) for name in echoes.variables)
    for file in (name for name in products if name.endswith(".nc")):
        with xr.open_datatree(folder / file) as tree:
            for group in tree.groups:
                data = tree[group].to_dataset()
                yield from ((f"{file}{group} {name}", data[name].values) for name in data.variables)
    if (folder / "gauges.nc").exists():
        with xr.open_dataset(folder / "gauges.nc") as gauges:
            yield from ((f"gauges.nc {name}", gauges[name].values) for name in gauges.variables)


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
