"""Damage to a copy of a file: to its bytes, or to what lies in it."""

from __future__ import annotations

import io
import json
import random
import shutil
import tomllib
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from .damage import damaged_bytes, damaged_tree, toml_of

_VALUES = (0.0, -1.0, -999.0, 1e30, -1e30, 9.97e36, 3e38, 1e308, np.nan, np.inf, 1e-300, 1e9)
_TYPES = ("i1", "i8", "f4", "f8", "c8", "c16", "S3", "u2", "?", "M8[s]")


def damaged(original: Path, folder: Path, dice: random.Random) -> Path:
    """A damaged copy in a folder of its own, under the original's name, with what lay beside the original."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    copy = folder / original.name
    if original.is_dir():
        shutil.copytree(original, copy)
        _store(copy, dice)
        return copy
    for beside in original.parent.glob(f"{original.stem[:5]}*"):
        if beside.is_file() and beside != original and original.suffix in (".data_spec", ".txt"):
            shutil.copy(beside, folder)
    other = original.with_name("truth.nc" if original.name == "maps.nc" else "maps.nc")
    if original.name in ("maps.nc", "truth.nc"):
        shutil.copy(other, folder / "original.nc")
    content = original.read_bytes()
    if dice.random() < 0.5 or not _inside(copy, content, dice):
        copy.write_bytes(damaged_bytes(content, dice))
    return copy


def _inside(copy: Path, content: bytes, dice: random.Random) -> bool:
    """Damage of what a file means, where it can be opened; False for a kind that is bytes alone."""
    if content[:4] == b"\x89HDF":
        copy.write_bytes(content)
        with h5py.File(copy, "r+") as file:
            for _ in range(dice.choice((1, 1, 2))):
                _hdf5(file, dice)
    elif copy.suffix == ".npz":
        with np.load(io.BytesIO(content)) as held:
            arrays = dict(held)
        name = dice.choice(list(arrays))
        arrays[name] = _array(arrays[name], dice)
        if dice.random() < 0.2:
            del arrays[name]
        np.savez(copy, allow_pickle=True, **arrays)  # type: ignore[arg-type]
    elif copy.suffix == ".toml":
        copy.write_text(toml_of(damaged_tree(tomllib.loads(content.decode()), dice)), encoding="utf-8")
    elif copy.suffix == ".json":
        copy.write_text(json.dumps(damaged_tree(json.loads(content), dice)))
    else:
        return False
    return True


def _array(values: np.ndarray, dice: random.Random) -> np.ndarray:
    """Values of another kind, shape or size."""
    numbers = np.random.default_rng(dice.randrange(2**32))
    with np.errstate(all="ignore"):
        match dice.randrange(7):
            case 0 if values.ndim:
                return np.swapaxes(values, 0, -1)
            case 1 if values.size and values.dtype.kind in "fciu":
                changed = values.copy().astype(np.result_type(values.dtype, np.float64))
                share = dice.choice((0.001, 0.1, 1.0))
                changed[numbers.random(values.shape) < share] = dice.choice(_VALUES)
                return changed.astype(values.dtype)
            case 2 if values.dtype.kind in "fciu":
                return np.nan_to_num(np.real(values)).astype(dice.choice(_TYPES))
            case 3:
                return values[..., None]
            case 4 if values.ndim and len(values) > 1:
                return values[: dice.randrange(len(values))]
            case 5 if values.dtype.kind in "fci":
                return values * np.asarray(dice.choice((-1, 0, 1000, 1e30))).astype(values.dtype)
            case _ if values.ndim:
                return values[::-1]
    return np.zeros(3)


def _hdf5(file: h5py.File, dice: random.Random) -> None:
    names: list[str] = []
    file.visititems(lambda name, node: names.append(name) if isinstance(node, h5py.Dataset) else None)
    if not names:
        return
    name = dice.choice(names)
    node: Any = file[name]
    match dice.randrange(8):
        case 0:
            del file[name]
        case 1 | 2 | 3:
            values, attributes = _array(np.asarray(node[()]), dice), dict(node.attrs)
            del file[name]
            made = file.create_dataset(name, data=values if values.dtype.kind != "M" else values.astype("i8"))
            for key, value in attributes.items():
                if key not in ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "_Netcdf4Coordinates"):
                    made.attrs[key] = value
        case 4:
            holder = dice.choice((file, node, *(file[each] for each in list(file)[:3])))
            keys = list(holder.attrs) or ["units"]
            values = b"\xff\x1b[31m", "x" * 4000, 1e308, -1, np.nan, [1, 2, 3], np.zeros(0), "days since x"
            value = dice.choice(values)
            holder.attrs[dice.choice(keys)] = value
        case 5:
            shape, kind = node.shape, node.dtype
            del file[name]
            shape = tuple(max(1, size) * dice.choice((1, 1000, 10**7)) for size in shape) or (10**9,)
            file.create_dataset(name, shape, kind, chunks=True)  # nothing written
        case 6:
            del file[name]
            file[name] = dice.choice((h5py.SoftLink(f"/{name}"), h5py.SoftLink("/"), h5py.ExternalLink("no.h5", "/x")))
        case _:
            file.move(name, name + "_")


def _store(store: Path, dice: random.Random) -> None:
    """A Zarr store: a chunk lost, cut or damaged; a zarr.json damaged as text or as a tree."""
    files = sorted(path for path in store.rglob("*") if path.is_file())
    metadata = [path for path in files if path.name == "zarr.json"]
    chunks = [path for path in files if path.name != "zarr.json"]
    for _ in range(dice.choice((1, 1, 2))):
        match dice.randrange(6):
            case 0:
                dice.choice(chunks).unlink(missing_ok=True)
            case 1:
                path = dice.choice(chunks)
                if path.exists():
                    path.write_bytes(path.read_bytes()[: dice.randrange(1 + path.stat().st_size)])
            case 2:
                path = dice.choice(chunks)
                if path.exists():
                    kind = "f8" if path.stat().st_size % 8 == 0 else "u1"
                    values = np.frombuffer(bytearray(path.read_bytes()), dtype=kind)
                    path.write_bytes(_array(values, dice).tobytes())
            case 3:
                path = dice.choice(metadata)
                path.write_bytes(damaged_bytes(path.read_bytes(), dice))
            case 4 if chunks:
                shutil.rmtree(dice.choice(chunks).parent, ignore_errors=True)
            case _:
                path = dice.choice(metadata)
                try:
                    tree = json.loads(path.read_text())
                except (OSError, ValueError):
                    continue
                path.write_text(json.dumps(damaged_tree(tree, dice)))
