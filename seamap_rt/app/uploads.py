"""Files that a browser gives: bounded, named safely, read by the program's own readers, and kept below the runs.

`python -m seamap_rt.app.uploads KIND PATH [ARRAY=NAME]…` reads a file once in a process of its own, whose memory and
time are bounded: one that is made to swell or to crash its reader ends that process and not the page.
"""

from __future__ import annotations

import asyncio
import re
import resource
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from nicegui import events, ui

from ..errors import InputError, one_line
from ..settings import ObjectSettings
from .folders import Roots, is_text, safe_name

MB = 2**20
_LONGEST_S = 150.0
_MOST_NAMES = 1000  # of one file, each with another content


@dataclass(frozen=True)
class Kind:
    """What may be uploaded: in words, endings, most bytes, the module and the function that read it, and the keys of a
    scene that name one."""

    words: str
    endings: tuple[str, ...]
    most: int
    reader: tuple[str, str] = ("", "")
    keys: str = "$^"


_SPECTRA = (
    ".nc", ".txt", ".spec", ".spc", ".sp2", ".swn", ".data_spec", ".swdir", ".swdir2", ".swr1", ".swr2", ".gz", ".spt",
    ".csv", ".json", ".dirspec",
)  # fmt: skip
_PATTERNS, _PATTERN_KEYS = (".csv", ".msi", ".pln", ".ant", ".txt"), r"radar\.antenna\.file|radar\.antennas\.\d+\.file"
_MESHES = (".stl", ".glb", ".obj", ".ply", ".dae")  # glTF as text may name any other file
_RECORDINGS = (".npz", ".mat", ".h5", ".hdf5", ".nc")
_BESIDE = (
    ".nc", ".txt", ".data_spec", ".swdir", ".swdir2", ".swr1", ".swr2", ".csv", ".stl", ".glb", ".obj", ".ply",
)  # fmt: skip
_SPECTRUM_READER = ("io.spectrumfile", "read_directional_spectrum")
KINDS = {
    "spectrum": Kind("a wave spectrum", _SPECTRA, 32 * MB, _SPECTRUM_READER, r"sea\.waves\.\d+\.file"),
    # a larger one is put below the runs by hand
    "sea": Kind("a recorded sea", (".nc", ".dat"), 60 * MB, ("io.recorded_sea", "recorded_sea"), r"sea\.file"),
    "pattern": Kind("an antenna pattern", _PATTERNS, 4 * MB, ("io.patternfile", "read_pattern"), _PATTERN_KEYS),
    "motion": Kind("a boat's motion", (".csv", ".txt"), 32 * MB, ("io.motionfile", "read_motion"), r"platform\.file"),
    "vessel": Kind(
        "a vessel of Capytaine", (".nc",), 32 * MB, ("prediction", "read_capytaine"), r"prediction\.vessel\.file"
    ),
    "mesh": Kind("a mesh", _MESHES, 32 * MB, ("io.meshfile", "load_mesh"), r"objects\.\d+\.mesh"),
    "recording": Kind("a recording", _RECORDINGS, 60 * MB, ("io.recorded", "read_recording")),
    "header": Kind("a recording's header", (".toml", ".json"), MB, ("io.recording_header", "read_header")),
    # which only who names it in a field reads
    "beside": Kind("a file that another one needs beside it", _BESIDE, 32 * MB),
}
Check = Callable[[str, Path, Mapping[str, str]], Any]


def kind_of_field(key: str) -> str | None:
    """The kind of file that a key of a scene names; None of a key that names none."""
    return next((name for name, kind in KINDS.items() if re.fullmatch(kind.keys, key)), None)


def check_in_process(kind: str, path: Path, names: Mapping[str, str]) -> None:
    """Run `check` in a process of its own; InputError also where that ends badly or takes too long."""
    arguments = [kind, str(path), *(f"{array}={name}" for array, name in names.items())]
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-m", "seamap_rt.app.uploads", *arguments],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_LONGEST_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise InputError(f"takes longer than {_LONGEST_S:.0f} s; make it smaller") from None
    lines = done.stderr.decode("utf-8", "replace").strip().splitlines()
    if done.returncode == 2 and lines:
        raise InputError(one_line(lines[-1]))
    if done.returncode:
        why = f"by signal {-done.returncode}" if done.returncode < 0 else f"with exit code {done.returncode}"
        raise InputError(f"cannot be read: what reads it ended {why}; make it smaller, or save it anew")


def save_upload(
    roots: Roots,
    kind: str,
    name: str,
    content: bytes,
    names: Mapping[str, str] | None = None,
    check: Check = check_in_process,
) -> Path:
    """Keep what a browser gave under a name, if it is what it is to be: its path.

    A file of the same name with another content stays as it is, since a run may read it; this one gets a number. names:
    of a recording's arrays that it calls otherwise. Raises InputError of one line, and keeps nothing, for what is too
    large, has another ending, or is refused by its reader.
    """
    wanted, safe = KINDS[kind], safe_name(name)
    if Path(safe).suffix.lower() not in wanted.endings:
        raise InputError(
            f"{safe}: is not {wanted.words}: must end in {', '.join(wanted.endings)}; save it as one of them"
        )
    if len(content) > wanted.most:
        size, most = f"{len(content) / MB:.1f} MB", f"{wanted.most / MB:.0f}"
        raise InputError(
            f"{safe}: has {size}: must have at most {most}; make it smaller, or copy it below {roots.runs} and name it "
            "there"
        )
    roots.uploads.mkdir(exist_ok=True)
    path, fresh = _store_content(roots.uploads, safe, content)
    try:
        if any(wanted.reader):
            check(kind, path, dict(names or {}))
    except InputError as refusal:
        if fresh:
            path.unlink(missing_ok=True)
        raise InputError(str(refusal).replace(f"{path}", safe)) from None
    return path


def _store_content(folder: Path, name: str, content: bytes) -> tuple[Path, bool]:
    """Where a content lies now, and whether it was put there just now."""
    stem, ending = Path(name).stem, Path(name).suffix
    for number in range(1, _MOST_NAMES):
        path = folder / (name if number == 1 else f"{stem}-{number}{ending}")
        try:
            with path.open("xb") as file:
                file.write(content)
            return path, True
        except FileExistsError:
            if path.is_file() and path.stat().st_size == len(content) and path.read_bytes() == content:
                return path, False
    raise InputError(f"{name}: has too many other files of its name in {folder}; take some away")


def list_uploads(roots: Roots, kind: str) -> list[Path]:
    """Uploads with a kind's endings, by name."""
    there = (each for each in roots.uploads.glob("*") if is_text(each.name))
    return sorted(each for each in there if each.suffix.lower() in KINDS[kind].endings)


def upload_button(
    roots: Roots,
    kind: str,
    say: Callable[[str], Any],
    taken: Callable[[Path], None],
    names: Callable[[], dict[str, str]] = dict,
) -> Any:
    """A button that asks for a file of a kind of `uploads.KINDS`. say: is given what goes on, or why the file is
    refused; taken: where it lies. names: of a recording's arrays that it calls otherwise."""
    wanted = KINDS[kind]

    async def take_upload(event: events.UploadEventArguments) -> None:
        name = event.file.name
        upload.reset()
        say(f"{name}: is checked …")
        try:
            content = await event.file.read()
            path = await asyncio.to_thread(save_upload, roots, kind, name, content, names())
        except (InputError, OSError) as refusal:
            say(str(refusal))
            return
        say("")
        taken(path)

    upload = ui.upload(
        auto_upload=True,
        max_file_size=wanted.most,
        on_upload=take_upload,
        on_rejected=lambda: say(
            f"must be {wanted.words} ({', '.join(wanted.endings)}) of at most {wanted.most / MB:.0f} MB"
        ),
    )
    upload.classes("hidden").mark(f"upload-{kind}").props["accept"] = ",".join(wanted.endings)
    button = ui.button(icon="upload_file")
    button.props("flat dense no-caps").props["aria-label"] = f"Upload {wanted.words}"
    button.on("click", js_handler=f"() => getElement({upload.id}).$refs.qRef.pickFiles()")
    return button


_MOST_MEMORY = 8 * 2**30  # bytes of addresses: what is read of an upload, and the libraries that read it
_MOST_CPU_S = 120
_ANY_RADAR = {  # beside which the arrays of a recording are read: its own header comes with the retrieval
    "frequency_hz": 10e9, "pulse_width_s": 20e-9, "bandwidth_hz": 50e6, "height_m": 5.0, "baseline_m": 0.2,
    "azimuth_beamwidth_deg": 1.8, "elevation_beamwidth_deg": 18.0, "first_gate_m": 15.0, "gate_m": 1.5,
}  # fmt: skip


def check(kind: str, path: Path, names: Mapping[str, str] | None = None) -> None:
    """Read a file as what it is to be; InputError of one line where it is not. names: of a recording's arrays that it
    calls otherwise."""
    module, name = KINDS[kind].reader
    read: Callable[..., Any] = getattr(import_module(f"..{module}", __package__), name)  # no other reader is loaded
    try:
        if kind == "sea":
            read(str(path)).elevation(0)
        elif kind == "mesh":
            read(ObjectSettings(mesh=str(path), position_m=(0.0, 100.0, 0.0)))
        elif kind == "recording":
            read(path, _ANY_RADAR, names)
        else:
            read(path)
    except (InputError, MemoryError):
        raise
    except Exception as error:  # libraries that read such files raise exceptions of many types
        raise InputError(f"{path}: cannot be read ({type(error).__name__}: {error}); save it anew") from None


def main() -> int:
    """Check the file that is named."""
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_MEMORY, _MOST_MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (_MOST_CPU_S, _MOST_CPU_S))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    kind, path, *names = sys.argv[1:]
    try:
        check(kind, Path(path), dict(each.split("=", 1) for each in names))
    except InputError as refusal:
        first, *more = refusal.problems
        print(first + (f" (and {len(more)} more)" if more else ""), file=sys.stderr)
        return 2
    except MemoryError:
        print(f"{path}: takes more memory than an upload may; make it smaller", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
