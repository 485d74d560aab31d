"""Files that wait, never end or declare more than they hold, and everything that opens one. Run as a program it reads
each of them once and tells what came of it: `python hostile_files.py FOLDER RESULTS`, a line of JSON a case."""

from __future__ import annotations

import json
import os
import signal
import struct
import sys
import time
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from seamap_rt.app.folders import find_runs
from seamap_rt.app.jobs import FOLDER, Queue, _lines
from seamap_rt.app.panels import read_shadowing
from seamap_rt.app.source import Results
from seamap_rt.app.trade_view import read_points
from seamap_rt.cli.retrieving import _opened_maps
from seamap_rt.compute.locks import holder_of
from seamap_rt.compute.machine import forget_peak_memory, peak_memory
from seamap_rt.errors import InputError
from seamap_rt.interferometry import open_echoes
from seamap_rt.io.meshfile import ENDINGS, load_mesh
from seamap_rt.io.motionfile import read_motion
from seamap_rt.io.patternfile import read_pattern
from seamap_rt.io.polar_images import read_polar_images
from seamap_rt.io.reading import read_whole_turns
from seamap_rt.io.recorded import read_recording
from seamap_rt.io.recorded_sea import recorded_sea
from seamap_rt.io.recording_header import read_header
from seamap_rt.io.results_folder import unfinished_files
from seamap_rt.io.scenefile import read_toml
from seamap_rt.io.spectrumfile import read_directional_spectrum
from seamap_rt.prediction import read_capytaine
from seamap_rt.products.recorded_sea import load_state, state_file
from seamap_rt.scene import load_scene
from seamap_rt.settings import ObjectSettings
from seamap_rt.studies.cluster import _address
from seamap_rt.studies.point import load_outcome as kept_point

HEADER = {
    "frequency_hz": 10e9, "pulse_width_s": 20e-9, "bandwidth_hz": 50e6, "height_m": 5.0, "baseline_m": 0.2,
    "azimuth_beamwidth_deg": 1.8, "elevation_beamwidth_deg": 18.0, "first_gate_m": 15.0, "gate_m": 1.5,
}  # fmt: skip
MUCH = 400_000_000  # bytes: more than the law allows to be taken
LONGEST_S, MOST_GROWTH = 2.0, 300e6
_HANGS_S = 30
_MOST_WAITS = 2


def _listed(path: Path) -> None:
    """A folder of a run as the page lists it, and then opens it."""
    entry = next(iter(find_runs(path.parent.parent)), None)
    if entry is None:
        raise InputError("no folder of results")
    if entry.headline.startswith("not read: "):
        raise InputError(entry.headline)
    try:
        Results(path.parent).layout()
    except OSError as error:
        raise InputError(str(error)) from None


def _nothing(found: Any) -> None:
    """What is passed over without a word: of the program's own, which is made anew."""
    if not found:
        raise InputError("nothing")


def _jobs(runs: Path) -> None:
    queue = Queue(runs)
    queue.close()
    _nothing(queue.jobs())


def _turns(path: Path) -> None:
    try:
        read_whole_turns(path.parent / "gauges.nc", lambda file: list(file))
    except OSError as error:
        raise InputError(str(error)) from None


def _shadowing(path: Path) -> None:
    try:
        read_shadowing(path.parent)
    except OSError as error:
        raise InputError(str(error)) from None


READERS: dict[str, tuple[str, Callable[[Path], Any]]] = {  # the file's name, and what reads it
    "scene": ("a.toml", load_scene),
    "header": ("header.toml", lambda path: read_header(path)),
    "header of JSON": ("header.json", lambda path: read_header(path)),
    **{
        f"recording {ending}": (f"a{ending}", lambda path: read_recording(path, HEADER))
        for ending in (".npz", ".mat", ".h5", ".nc")
    },
    "header beside": ("b.toml", lambda path: read_recording(_good_recording(path.with_suffix(".npz")))),
    "spectrum": ("a.nc", read_directional_spectrum),
    "spectrum as text": ("a.spc", read_directional_spectrum),
    "spectrum, packed": ("a.spc.gz", read_directional_spectrum),
    "sea": ("a.nc", lambda path: recorded_sea(str(path)).elevation(0)),
    "sea as text": ("3d.dat", lambda path: recorded_sea(str(path)).elevation(0)),
    "sea of cameras": ("ZGrid_01.mat", lambda path: recorded_sea(str(path)).elevation(0)),
    "sea, a store": ("sea.zarr/zarr.json", lambda path: recorded_sea(str(path.parent)).elevation(0)),
    "pattern": ("a.csv", read_pattern),
    "pattern of a maker": ("a.msi", read_pattern),
    "motion": ("a.csv", read_motion),
    "vessel": ("a.nc", read_capytaine),
    **{
        f"mesh {ending}": (f"a{ending}", lambda path: load_mesh(ObjectSettings(mesh=str(path), position_m=(0, 9, 0))))
        for ending in ENDINGS
    },
    "polar image": ("a.pol", read_polar_images),
    "polar image, packed": ("a.pol.gz", read_polar_images),
    "maps": ("maps.nc", _opened_maps),
    "echoes": ("echoes.zarr/zarr.json", lambda path: open_echoes(path.parent)),
    "echoes of a run": ("run.zarr/echoes/zarr.json", lambda path: open_echoes(_named(path, "").parent.parent)),
    "run of the page": ("run/maps.nc", _listed),
    "scene of a run": ("run/scene.toml", lambda path: _listed(_named(path, "maps.nc"))),
    "metrics of a run": ("run/metrics.json", lambda path: _listed(_named(path, "maps.nc"))),
    "gauges of the page": ("run/gauges.nc", _turns),
    "shadowing of the page": ("run/shadowing.nc", _shadowing),
    "points of the page": ("points/0.json", lambda path: _nothing(read_points(path.parent.parent))),
    "jobs of the page": (f"{FOLDER}/0.json", lambda path: _jobs(path.parent.parent)),
    "progress of the page": ("a.txt", lambda path: _nothing(_lines(path))),
    "note of a run": (".unfinished.json", lambda path: _nothing(unfinished_files(_named(path, "").parent))),
    "lock of a run": (".lock", lambda path: _nothing(holder_of(path))),
    "point of a trade": ("0.json", lambda path: _nothing(kept_point(path))),
    "scheduler": ("scheduler.json", lambda path: _address(str(path))),
    "state of a nonlinear sea": (state_file(Path()).name, lambda path: load_state(path.parent, {})),
    "toml": ("b.toml", read_toml),
}


def _named(path: Path, name: str) -> Path:
    if name:
        (path.parent / name).touch()
    return path.with_name(name) if name else path


def _good_recording(path: Path) -> Path:
    np.savez(path, **dict.fromkeys(("lower", "upper", "time", "azimuth"), np.zeros(2)))
    return path


# --------------------------------------------------------------------------------------------------- what they are


def _sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(8_000_000_000)


ODD: dict[str, Callable[[Path], None]] = {
    "FIFO": os.mkfifo,
    "device": lambda path: path.symlink_to("/dev/zero"),
    "folder": lambda path: path.mkdir(),
    "hole": _sparse,
}


def _zeros(start: bytes, wbits: int = 15) -> bytes:
    """`start` and then MUCH of nothing, packed."""
    pack = zlib.compressobj(1, wbits=wbits)
    piece = bytes(4_000_000)
    return b"".join((pack.compress(start), *(pack.compress(piece) for _ in range(MUCH // len(piece))), pack.flush()))


def _npz(path: Path) -> None:
    """An archive of one array, written as zip does, so that no one has to hold it."""
    header: Any = {"descr": "<c8", "fortran_order": False, "shape": (MUCH // 800, 100)}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file, file.open("lower.npy", "w") as it:
        np.lib.format.write_array_header_1_0(it, header)
        for _ in range(MUCH // 4_000_000):
            it.write(bytes(4_000_000))


def _mat(path: Path) -> None:
    def element(kind: int, data: bytes) -> bytes:
        return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)

    name = b"zgrid" if path.name.startswith("Z") else b"lower"
    shape = (100, 100, MUCH // 80_000)
    head = element(6, struct.pack("<II", 6, 0)) + element(5, struct.pack("<III", *shape)) + element(1, name)
    inner = head + struct.pack("<II", 9, MUCH)
    packed = _zeros(struct.pack("<II", 14, len(inner) + MUCH) + inner)
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + struct.pack("<II", 15, len(packed)) + packed)
    if path.name.startswith("Z"):
        import scipy.io

        places = np.meshgrid(np.arange(100.0), np.arange(100.0))
        scipy.io.savemat(path.with_name("XYGrid_01.mat"), dict(zip(("xgrid", "ygrid"), places, strict=True)))


def _hdf5(path: Path) -> None:
    """A vector in one chunk, as packed as nothing is."""
    with h5py.File(path, "w") as file:
        count = MUCH // 8
        array = file.create_dataset("lower", (count,), "<f8", chunks=(count,), compression="gzip")
        array.id.write_direct_chunk((0,), _zeros(b""))


def _netcdf(dims: dict[str, int], name: str) -> Callable[[Path], None]:
    """An array of which nothing was written: it is read as zeros."""

    def make(path: Path) -> None:
        with h5py.File(path, "w") as file:
            for axis, size in dims.items():
                file.create_dataset(axis, (size,), "<f8", chunks=(min(64, size),)).make_scale(axis)
            made = file.create_dataset(name, tuple(dims.values()), "<f8", chunks=(1, *[2] * (len(dims) - 1)))
            for place, axis in enumerate(dims):
                made.dims[place].attach_scale(file[axis])

    return make


def _packed_text(start: bytes) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        path.write_bytes(_zeros(start, wbits=31))

    return make


def _swan(path: Path) -> None:
    path.write_text("SWAN   1\n$ a\nLOCATIONS\n     300000000\n   0.0 0.0\nAFREQ\n 2\n 0.1\n 0.2\nNDIR\n 4\n")


def _glb(count: int, **tree: Any) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        told = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(count))}],
            "nodes": [{"mesh": 0}] * count, "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"componentType": 5126, "type": "VEC3", "count": 3, "bufferView": 0}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36}],
        } | tree  # fmt: skip
        text = json.dumps(told).encode()
        text += b" " * (-len(text) % 4)
        body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", 36, b"BIN\0") + bytes(36)
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)

    return make


def _store(name: str, shape: list[int], chunk: list[int]) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        path.write_text(json.dumps({"zarr_format": 3, "node_type": "group", "attributes": {}}))
        (path.parent / name).mkdir()
        (path.parent / name / "zarr.json").write_text(json.dumps({
            "zarr_format": 3, "node_type": "array", "shape": shape, "data_type": "float64", "fill_value": 0.0,
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunk}}, "attributes": {},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            "codecs": [{"name": "bytes", "configuration": {"endian": "little"}}],
            "dimension_names": ["pulse", "range", "receiver"][: len(shape)] if name != "x" else ["x"],
        }))  # fmt: skip

    return make


_LINE = {"time": 20, "y": 20, "x": MUCH // 8}
BOMBS: dict[tuple[str, str], Callable[[Path], None]] = {  # by reader, and what it declares
    ("recording .npz", "zeros"): _npz,
    ("recording .mat", "zeros"): _mat,
    ("recording .h5", "zeros"): _hdf5,
    ("recording .nc", "zeros"): _hdf5,
    ("spectrum", "zeros"): _netcdf({"freq": 1000, "dir": MUCH // 8000}, "efth"),
    ("spectrum, packed", "zeros"): _packed_text(b"SWAN   1\n"),
    ("spectrum as text", "places"): _swan,
    ("sea", "long axis"): _netcdf(_LINE, "elevation"),
    ("sea", "wide frames"): _netcdf({"time": 20, "y": 7000, "x": 7000}, "elevation"),
    ("sea of cameras", "zeros"): _mat,
    ("sea, a store", "long axis"): _store("x", [MUCH], [MUCH]),
    ("sea, a store", "chunks"): _store("x", [MUCH], [1]),
    ("vessel", "zeros"): _netcdf({"omega": 1000, "wave_direction": MUCH // 8000}, "added_mass"),
    ("mesh .glb", "accessor"): _glb(1, accessors=[{"componentType": 5126, "type": "VEC3", "count": 10**8}]),
    ("mesh .glb", "nodes"): _glb(300_000),
    ("mesh .glb", "loop"): _glb(2, nodes=[{"mesh": 0, "children": [1]}, {"children": [0]}]),
    ("mesh .glb", "depth"): _glb(2000, nodes=[{"mesh": 0, "children": [n + 1]} for n in range(1999)] + [{"mesh": 0}]),
    ("polar image, packed", "zeros"): _packed_text(b""),
    ("maps", "long axis"): _netcdf(_LINE, "height"),
    ("echoes", "long axis"): _store("time", [10**12], [10**12]),
    ("run of the page", "wide turn"): _netcdf({"turn": 2, "y": 7000, "x": 7000}, "height"),
    ("shadowing of the page", "long axis"): _netcdf(_LINE, "visible_fraction"),
}  # fmt: skip


def _elsewhere(how: str) -> Callable[[Path], None]:
    """A file of HDF5, of which one array lies in another file that anybody may read."""

    def make(path: Path) -> None:
        other = path.with_name("other.h5")
        with h5py.File(other, "w") as file:
            file["x"] = np.arange(10.0)
        with h5py.File(path, "w") as file:
            if how == "link":
                file["group/lower"] = h5py.ExternalLink(str(other), "/x")
            elif how == "storage":
                file.create_dataset("lower", (10,), "<f8", external=[(str(other), 0, 80)])
            else:
                layout = h5py.VirtualLayout((10,), "<f8")
                layout[:] = h5py.VirtualSource(str(other), "x", (10,))
                file.create_virtual_dataset("lower", layout)

    return make


ELSEWHERE = {how: _elsewhere(how) for how in ("link", "storage", "virtual")}
OF_HDF5 = [name for name, (file, _) in READERS.items() if file.endswith((".nc", ".h5")) and "advice" not in name]
OF_HDF5 += ["recording .mat"]  # advice is silent whatever is wrong
CASES: dict[tuple[str, str], Callable[[Path], None]] = {
    **{(reader, kind): make for reader in READERS for kind, make in ODD.items()},
    **BOMBS,
    **{(reader, f"others' {how}"): make for reader in OF_HDF5 for how, make in ELSEWHERE.items()},
}


class _Waits(BaseException):
    """No reader takes it for a fault of the file."""


def main() -> None:
    """Read each file once; a line each: reader, kind, what was raised, its message, seconds and bytes that it took."""
    import trimesh  # noqa: F401
    import wavespectra  # noqa: F401
    import zstandard  # noqa: F401

    folder, results = map(Path, sys.argv[1:])

    def hangs(*_: Any) -> None:
        raise _Waits("waits")

    signal.signal(signal.SIGALRM, hangs)
    waited = 0
    with results.open("w") as told:
        for number, ((reader, kind), make) in enumerate(CASES.items()):
            name, read = READERS[reader]
            path = folder / str(number) / name
            path.parent.mkdir(parents=True)
            make(path)
            forget_peak_memory()
            before, clock = peak_memory(), time.process_time()
            signal.alarm(_HANGS_S)
            try:
                read(path)
                raised, message = "", ""
            except BaseException as error:
                raised, message = type(error).__name__, str(error)
            signal.alarm(0)
            waited += raised == "_Waits"
            took = time.process_time() - clock
            if waited > _MOST_WAITS:  # the others' are not told, and so not held
                return
            print(json.dumps([reader, kind, raised, message, took, peak_memory() - before]), file=told, flush=True)
            if not path.is_dir():
                path.unlink()


if __name__ == "__main__":
    main()
