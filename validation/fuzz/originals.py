"""One whole file, or more, of every kind that the program reads: small, so that thousands are read in minutes."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import trimesh
import xarray as xr
import zstandard

import seamap_rt as sr
from seamap_rt.io.appendable import AppendableNetCDF

POLAR = Path(__file__).parents[1] / "reference" / "wamos_revelle.pol.zst"
SPECTRA = Path(__file__).parents[2] / "tests" / "io" / "spectra"
BINS = (
    "answered",
    "height_bias_m",
    "height_rmse_m",
    "known_share",
    "quality",
    "range_m",
    "slope_rmse",
    "visible_fraction",
)
SMALL: dict[str, Any] = {
    "radar.sector_deg": [260.0, 275.0],
    "radar.range_m": [15.0, 45.0],
    "radar.prf_hz": 1000.0,
    "sea.extent_m": 160.0,
    "sea.resolution_m": 2.0,
    "tracing.tracer": "horizon",
}
HEADER: dict[str, Any] = {
    "frequency_hz": 10e9,
    "pulse_width_s": 20e-9,
    "bandwidth_hz": 50e6,
    "height_m": 5.0,
    "baseline_m": 0.2,
    "azimuth_beamwidth_deg": 1.8,
    "elevation_beamwidth_deg": 18.0,
    "first_gate_m": 30.0,
    "gate_m": 1.5,
    "sector_deg": [0.0, 40.0],
    "rotation_rpm": 60.0,
}


def make(folder: Path) -> dict[str, list[Path]]:
    """The files by kind; a kind is named as `readers.READERS` names it."""
    folder.mkdir(parents=True, exist_ok=True)
    simulation = sr.simulate(sr.load_scene("tiny", overrides=SMALL), out=folder / "run")
    maps = sr.retrieve(simulation.echoes)
    with AppendableNetCDF(folder / "run" / "maps.nc") as file:
        file.append(maps)
    simulation.truth.close()
    shutil.rmtree(folder / "run" / "run.zarr" / "truth")  # damage is to meet the echoes
    return {
        "scene": sorted(set(map(Path, sr_scenes()))),
        "spectrum": _spectra(folder),
        "pattern": _patterns(folder),
        "motion": [_motion(folder)],
        "mesh": _meshes(folder),
        "recording": _recordings(folder),
        "polar images": _images(folder),
        "header": _headers(folder),
        "echo store": [folder / "run" / "run.zarr"],
        "maps and truth": [folder / "run" / "maps.nc", folder / "run" / "truth.nc"],
        "sweep": _sweep(folder),
    }


def sr_scenes() -> list[Path]:
    from seamap_rt.io.scenefile import list_shipped

    return list(list_shipped().values())


def _spectra(folder: Path) -> list[Path]:
    """wavespectra's own layout as NetCDF-4, and those of buoys and models that the tests hold."""
    frequency, direction = np.arange(0.05, 0.5, 0.02), np.arange(0.0, 360.0, 15.0)
    energy = 2 * np.pi * sr.sea.spectra.jonswap(2 * np.pi * frequency, hs=1.2, tp=6.0, gamma=2.0)
    spread = np.cos(np.radians(direction - 300.0) / 2.0) ** 16
    table = energy[:, None] * spread / (15.0 * spread.sum())
    own = folder / "own.nc"
    xr.Dataset({"efth": (("freq", "dir"), table)}, {"freq": frequency, "dir": direction}).to_netcdf(
        own, engine="h5netcdf"
    )
    names = ("swan.spc", "swan_stationary.spc", "ww3.nc", "ndbc.nc", "46042.data_spec", "46042w2024.txt")
    here = folder / "spectra"
    if SPECTRA.is_dir():
        shutil.copytree(SPECTRA, here, dirs_exist_ok=True)
    return [own, *(here / name for name in names if (here / name).exists())]


def _patterns(folder: Path) -> list[Path]:
    angles = np.arange(-90.0, 90.1, 3.0)
    cuts = {"azimuth": -12.0 * (angles / 12.0) ** 2, "elevation": -12.0 * (angles / 24.0) ** 2}
    csv, msi = folder / "pattern.csv", folder / "pattern.msi"
    rows = [
        f"{name},{angle:g},{max(-60.0, level):g}"
        for name, cut in cuts.items()
        for angle, level in zip(angles, cut, strict=True)
    ]
    csv.write_text("\n".join(["cut,angle_deg,gain_db", *rows]))
    text = "NAME fuzz\nFREQUENCY 10 GHz\nGAIN 30 dBi\n"
    for key, cut in (("HORIZONTAL", cuts["azimuth"]), ("VERTICAL", cuts["elevation"])):
        text += f"{key} {angles.size}\n" + "".join(
            f"{a:g} {min(60.0, -v):g}\n" for a, v in zip(angles, cut, strict=True)
        )
    msi.write_text(text)
    return [csv, msi]


def _motion(folder: Path) -> Path:
    path, time = folder / "motion.csv", np.arange(-3.0, 8.0, 0.25)
    swings = np.stack([time, 5 * np.sin(time), 2 * np.cos(time), 359.0 + time, 0.3 * np.sin(time)], axis=1)
    rows = [",".join(f"{each:.4g}" for each in row) for row in swings]
    path.write_text("\n".join(["time_s,roll_deg,pitch_deg,heading_deg,heave_m", *rows]))
    return path


def _meshes(folder: Path) -> list[Path]:
    box = trimesh.creation.box((2.0, 5.0, 1.0))
    paths = [folder / f"box.{ending}" for ending in ("obj", "stl", "ply", "glb")]
    for path in paths:
        box.export(path)
    for name, text in (("text.stl", "stl_ascii"), ("text.ply", "ply")):
        extra = {"encoding": "ascii"} if text == "ply" else {}
        content = box.export(file_type=text, **extra)
        paths.append(folder / name)
        paths[-1].write_bytes(content if isinstance(content, bytes) else str(content).encode())
    return paths


def _recordings(folder: Path) -> list[Path]:
    generator, pulses, gates = np.random.default_rng(1), 120, 12
    time = np.arange(pulses) / 1000.0
    look = generator.standard_normal((2, pulses, gates, 2))
    slow = np.linspace(-0.1, 0.2, 7)
    arrays = {
        "lower": (look[0, ..., 0] + 1j * look[0, ..., 1]).astype(np.complex64),
        "upper": (1e3 * look[1]).astype(np.int16),
        "time": time,
        "azimuth": 360.0 * time,
        "attitude": np.zeros((7, 3)),
        "attitude_time": slow,
        "transmitter": np.zeros(pulses, dtype=np.int8),
        "quality": np.zeros(pulses, dtype=np.int16),
        "ranges": 30.0 + 1.5 * np.arange(gates),
    }
    head = {key: value for key, value in HEADER.items() if key not in ("first_gate_m", "gate_m")}
    np.savez(folder / "night.npz", header=json.dumps(head), allow_pickle=False, **arrays)  # type: ignore[arg-type]
    for name, options in (("night.h5", {}), ("packed.nc", {"chunks": True, "compression": "gzip"})):
        with h5py.File(folder / name, "w") as file:
            for key, values in arrays.items():
                file.create_dataset(key, data=values, **options)
            file.create_group("header").attrs.update(head)
    return [folder / "night.npz", folder / "night.h5", folder / "packed.nc"]


def _images(folder: Path) -> list[Path]:
    """Of a real ship, packed and plain."""
    packed = folder / POLAR.name
    shutil.copy(POLAR, packed)
    plain = packed.with_suffix("")
    with zstandard.open(packed, "rb") as file:
        plain.write_bytes(file.read())
    return [packed, plain]


def _headers(folder: Path) -> list[Path]:
    from .damage import toml_of

    (folder / "header.toml").write_text(toml_of(HEADER))
    (folder / "header.json").write_text(json.dumps(HEADER))
    return [folder / "header.toml", folder / "header.json"]


def _sweep(folder: Path) -> list[Path]:
    """What a trade keeps of a point, what it says of itself, and where a scheduler says that it is."""
    numbers = [0.1, None, 0.3]
    point = {
        "keys": {"radar.height_m": 5.0},
        "seed": 1,
        "status": "done",
        "reason": "",
        "metrics": {"height_rmse_m": 0.1, "hs_true_m": 1.3},
        "by_range": {name: [12.5, 37.5, 62.5] if name == "range_m" else numbers for name in sorted(BINS)},
        "facts": {"significant_height_m": 1.4, "range_m": [15.0, 75.0], "facets": 1000, "folded_share": 0.0},
        "cost": {"seconds": {"total": 1.0}, "peak_memory_bytes": 1000, "worker": "a:1"},
    }
    manifest = {"version": sr.__version__, "scene": "", "vary": [["radar.height_m", [5.0]]], "seeds": [1], "files": {}}
    contents = {"point.json": point, "trade.json": manifest, "scheduler.json": {"address": "tcp://127.0.0.1:1"}}
    for name, content in contents.items():
        (folder / name).write_text(json.dumps(content))
    return [folder / name for name in contents]
