"""The judge of changes that must change no bit sees one that does."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from validation.same import PRODUCTS, differences


def results(folder: Path, height: float, **metrics: Any) -> Path:
    """Files of results that hold a row of three numbers each, the maps with a NaN and this height."""
    folder.mkdir()
    for name in PRODUCTS:
        last = height if name == "maps.nc" else 2.0
        data = xr.Dataset({"height": ("x", np.array([1.0, np.nan, last]))})
        if name.endswith(".zarr"):
            data.to_zarr(folder / name, group="echoes", consolidated=False)
        else:
            xr.DataTree.from_dict({"/polar": data}).to_netcdf(folder / name, engine="h5netcdf")
    (folder / "metrics.json").write_text(json.dumps(metrics))
    return folder


def test_a_changed_bit_and_a_lost_key_are_told(tmp_path: Path) -> None:
    old = results(tmp_path / "old", 2.0, rms=1.0)
    assert list(differences(old, results(tmp_path / "same", 2.0, rms=3.0, more=0.0))) == []
    other = results(tmp_path / "other", np.nextafter(2.0, 3.0))
    bit, key = differences(old, other)
    assert bit.startswith("maps.nc/polar height: differs")
    assert key.startswith("metrics.json .rms: only in")
    assert list(differences(old, other, tolerance=1e-5)) == [key]
