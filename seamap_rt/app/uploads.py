"""Files that a browser gives: bounded, named safely, read by the program's own readers, and kept below the runs.

A reader works in a process of its own (`checking`), and a button beside a field asks for a file.
"""

from __future__ import annotations

import asyncio
import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nicegui import events, ui

from ..errors import InputError, one_line
from .safety import Roots, is_text, safe_name

MB = 2**20
_LONGEST_S = 150.0
_MOST_NAMES = 1000  # of one file, each with another content


@dataclass(frozen=True)
class Kind:
    """What may be uploaded: in words, endings, and most bytes."""

    words: str
    endings: tuple[str, ...]
    most: int


_SPECTRA = (
    ".nc", ".txt", ".spec", ".spc", ".sp2", ".swn", ".data_spec", ".swdir", ".swdir2", ".swr1", ".swr2", ".gz", ".spt",
    ".csv", ".json", ".dirspec",
)  # fmt: skip
KINDS = {
    "spectrum": Kind("a wave spectrum", _SPECTRA, 32 * MB),
    "sea": Kind("a recorded sea", (".nc", ".dat"), 60 * MB),  # a larger one is put below the runs by hand
    "pattern": Kind("an antenna pattern", (".csv", ".msi", ".pln", ".ant", ".txt"), 4 * MB),
    "motion": Kind("a boat's motion", (".csv", ".txt"), 32 * MB),
    "vessel": Kind("a vessel of Capytaine", (".nc",), 32 * MB),
    "mesh": Kind("a mesh", (".stl", ".glb", ".obj", ".ply", ".dae"), 32 * MB),  # glTF as text may name any other file
    "recording": Kind("a recording", (".npz", ".mat", ".h5", ".hdf5", ".nc"), 60 * MB),
    "header": Kind("a recording's header", (".toml", ".json"), MB),
    "beside": Kind(  # which only who names it in a field reads
        "a file that another one needs beside it",
        (".nc", ".txt", ".data_spec", ".swdir", ".swdir2", ".swr1", ".swr2", ".csv", ".stl", ".glb", ".obj", ".ply"),
        32 * MB,
    ),
}
_OF_FIELDS = (  # which file a key of a scene names
    (r"sea\.file", "sea"),
    (r"sea\.waves\.\d+\.file", "spectrum"),
    (r"radar\.antenna\.file|radar\.antennas\.\d+\.file", "pattern"),
    (r"platform\.file", "motion"),
    (r"prediction\.vessel\.file", "vessel"),
    (r"objects\.\d+\.mesh", "mesh"),
)
Check = Callable[[str, Path, Mapping[str, str]], Any]


def kind_of_field(key: str) -> str | None:
    """The kind of file that a key of a scene names; None of a key that names none."""
    return next((kind for pattern, kind in _OF_FIELDS if re.fullmatch(pattern, key)), None)


def check_apart(kind: str, path: Path, names: Mapping[str, str]) -> None:
    """As `checking.check`, in a process of its own."""
    told = [f"{array}={name}" for array, name in names.items()]
    run_apart("seamap_rt.app.checking", kind, str(path), *told, longest_s=_LONGEST_S)


def save_upload(
    roots: Roots,
    kind: str,
    name: str,
    content: bytes,
    names: Mapping[str, str] | None = None,
    check: Check = check_apart,
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
    path, fresh = _place(roots.uploads, safe, content)
    try:
        if kind != "beside":
            check(kind, path, dict(names or {}))
    except InputError as refusal:
        if fresh:
            path.unlink(missing_ok=True)
        raise InputError(str(refusal).replace(f"{path}", safe)) from None
    return path


def _place(folder: Path, name: str, content: bytes) -> tuple[Path, bool]:
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
    """What of a kind's endings lies among the uploads, by name."""
    if not roots.uploads.is_dir():
        return []
    there = (each for each in roots.uploads.iterdir() if is_text(each.name))
    return sorted(each for each in there if each.suffix.lower() in KINDS[kind].endings)


def run_apart(module: str, *words: str, longest_s: float) -> bytes:
    """What `python -m MODULE WORDS` prints. InputError with its last line where it refuses, ends badly or takes too
    long."""
    try:
        done = subprocess.run(
            [sys.executable, "-m", module, *words],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=longest_s,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise InputError(f"takes longer than {longest_s:.0f} s; make it smaller") from None
    if done.returncode == 0:
        return done.stdout
    said = done.stderr.decode("utf-8", "replace").strip().splitlines()
    if done.returncode == 2 and said:
        raise InputError(one_line(said[-1]))
    why = f"by signal {-done.returncode}" if done.returncode < 0 else f"with exit code {done.returncode}"
    raise InputError(f"cannot be read: what reads it ended {why}; make it smaller, or save it anew")


def upload_button(
    roots: Roots,
    kind: str,
    said: Callable[[str], None],
    taken: Callable[[Path], None],
    label: str = "",
    names: Callable[[], dict[str, str]] = dict,
) -> Any:
    """A button that asks for a file of a kind of `uploads.KINDS`. said: is given what goes on, or why the file is
    refused; taken: where it lies. label: beside the icon. names: of a recording's arrays that it calls otherwise."""
    wanted = KINDS[kind]

    async def uploaded(event: events.UploadEventArguments) -> None:
        name = event.file.name
        upload.reset()
        said(f"{name}: is checked …")
        try:
            content = await event.file.read()
            path = await asyncio.to_thread(save_upload, roots, kind, name, content, names())
        except (InputError, OSError) as refusal:
            said(str(refusal))
            return
        said("")
        taken(path)

    upload = ui.upload(
        auto_upload=True,
        max_file_size=wanted.most,
        on_upload=uploaded,
        on_rejected=lambda: said(
            f"must be {wanted.words} ({', '.join(wanted.endings)}) of at most {wanted.most / MB:.0f} MB"
        ),
    )
    upload.classes("hidden").mark(f"upload-{kind}").props["accept"] = ",".join(wanted.endings)
    button = ui.button(label, icon="upload_file")
    button.props("flat dense no-caps").props["aria-label"] = f"Upload {wanted.words}"
    button.on("click", js_handler=f"() => getElement({upload.id}).$refs.qRef.pickFiles()")
    return button
