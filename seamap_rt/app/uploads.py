"""Files that a browser gives: bounded, named safely, read by the program's own readers, and kept below the runs; and
the place where recorded echoes are given, to be retrieved.

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
from typing import TYPE_CHECKING, Any

from nicegui import events, ui

from ..errors import InputError, one_line
from ..settings import ObjectSettings
from .safety import Roots, is_text, safe_name
from .widgets import choice, flat_button

if TYPE_CHECKING:
    from .page import Page


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
    """As `check`, in a process of its own."""
    arguments = [f"{array}={name}" for array, name in names.items()]
    run_apart("seamap_rt.app.uploads", kind, str(path), *arguments, longest_s=_LONGEST_S)


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
    """Uploads with a kind's endings, by name."""
    if not roots.uploads.is_dir():
        return []
    there = (each for each in roots.uploads.iterdir() if is_text(each.name))
    return sorted(each for each in there if each.suffix.lower() in KINDS[kind].endings)


def run_apart(module: str, *words: str, longest_s: float) -> bytes:
    """What `python -m MODULE WORDS` prints. InputError with its last line where it refuses, ends badly or takes too
    long."""
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-m", module, *words],
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


_MOST_MEMORY = 8 * 2**30  # bytes of addresses: what is read of an upload, and the libraries that read it
_MOST_CPU_S = 120
_ANY_RADAR = {  # beside which the arrays of a recording are read: its own header comes with the retrieval
    "frequency_hz": 10e9, "pulse_width_s": 20e-9, "bandwidth_hz": 50e6, "height_m": 5.0, "baseline_m": 0.2,
    "azimuth_beamwidth_deg": 1.8, "elevation_beamwidth_deg": 18.0, "first_gate_m": 15.0, "gate_m": 1.5,
}  # fmt: skip


_READERS: dict[str, tuple[str, str, Callable[[Any, Path, Any], Any]]] = {  # where it is, and how it is called
    "spectrum": ("io.spectrumfile", "read_directional_spectrum", lambda read, path, _: read(path)),
    "sea": ("io.recorded_sea", "recorded_sea", lambda read, path, _: read(str(path)).elevation(0)),
    "pattern": ("io.patternfile", "read_pattern", lambda read, path, _: read(path)),
    "motion": ("io.motionfile", "read_motion", lambda read, path, _: read(path)),
    "vessel": ("prediction", "read_capytaine", lambda read, path, _: read(path)),
    "mesh": ("io.meshfile", "load_mesh", lambda read, path, _: read(_object(path))),
    "header": ("io.recording_header", "read_header", lambda read, path, _: read(path)),
    "recording": ("io.recorded", "read_recording", lambda read, path, names: read(path, _ANY_RADAR, names)),
}


def _object(path: Path) -> ObjectSettings:
    return ObjectSettings(mesh=str(path), position_m=(0.0, 100.0, 0.0))


def check(kind: str, path: Path, names: Mapping[str, str] | None = None) -> None:
    """Read a file as what it is to be; InputError of one line where it is not. names: of a recording's arrays that it
    calls otherwise."""
    try:
        _read(kind, path, names)
    except (InputError, MemoryError):
        raise
    except Exception as error:  # libraries that read such files raise exceptions of many types
        raise InputError(f"{path}: cannot be read ({type(error).__name__}: {error}); save it anew") from None


def _read(kind: str, path: Path, names: Mapping[str, str] | None) -> None:
    if kind not in _READERS:
        raise InputError(f"{kind}: no kind of upload")
    module, name, read = _READERS[kind]
    reader = getattr(import_module(f"..{module}", __package__), name)  # none of the others is loaded
    read(reader, path, names)


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


class RecordingsPanel:
    """Two files, and what is wanted of them."""

    def __init__(self, page: Page) -> None:
        self.page = page
        roots = page.server.roots
        with ui.column().classes("w-full gap-2 pb-2"):
            most = f"{KINDS['recording'].most / MB:.0f} MB"
            ui.label(
                "Two complex arrays, lower and upper (pulse, gate), with time and azimuth, and a header that says what "
                f"radar it was. Files of more than {most}: copy them into {roots.uploads}, and open this place again."
            ).classes("text-sm break-words")
            with ui.element("div").classes("w-full grid gap-2 grid-cols-1 md:grid-cols-2"):
                self._recording = self._choice("recording", "Recording")
                self._header = self._choice("header", "Header, where the recording has none")
            self._names = ui.input("Arrays under other names", placeholder="lower=rx/1, upper=rx/2")
            self._names.props("dense outlined stack-label").classes("w-full")
            self._names.tooltip(
                "Arrays are lower, upper, time, azimuth, and others that the program's own README names"
            )
            with ui.row().classes("w-full items-center gap-2"):
                ui.button("Retrieve", icon="travel_explore", on_click=self._retrieve).props(
                    'no-caps aria-label="Retrieve the recording"'
                ).mark("retrieve")
                self._wrong = ui.checkbox("even if the inspection finds it surely wrong").props("dense")
                flat_button("Download a header to fill in", icon="download", on_click=_give_header)
            self._said = ui.label().classes("text-sm").props("role=status").mark("recording-said")
        self.fill()

    def _choice(self, kind: str, label: str) -> Any:
        """A list of what is there, and a button for more."""
        with ui.row().classes("w-full items-center no-wrap gap-1"):
            made = choice(label, f"choose-{kind}", width="all", clearable=kind == "header")

            def taken(path: Path) -> None:
                self.fill()
                made.value = str(path)

            names = self._other_names if kind == "recording" else dict
            upload_button(self.page.server.roots, kind, self._tell, taken, names=names)
        return made

    def _tell(self, line: str) -> None:
        self._said.set_text(line)

    def fill(self) -> None:
        """What is there to be chosen."""
        for kind, made in (("recording", self._recording), ("header", self._header)):
            there = {str(each): each.name for each in list_uploads(self.page.server.roots, kind)}
            made.set_options(there, value=made.value if made.value in there else None)

    def _other_names(self) -> dict[str, str]:
        """InputError for what is no name of an array."""
        from ..io.recorded import ARRAYS

        chosen: dict[str, str] = {}
        for each in filter(None, (part.strip() for part in (self._names.value or "").split(","))):
            array, equals, name = (part.strip() for part in each.partition("="))
            if array not in ARRAYS or not equals or not name:
                raise InputError(f"{each}: must be ARRAY=NAME, where ARRAY is one of {', '.join(ARRAYS)}")
            chosen[array] = name
        return chosen

    def _retrieve(self) -> None:
        """Queue it, and go where it is seen."""
        server, recording = self.page.server, self._recording.value
        if not recording:
            self._said.set_text("Choose a recording, or upload one.")
            return
        try:
            names = self._other_names()
        except InputError as refusal:
            self._said.set_text(str(refusal))
            return
        words = ["retrieve", str(recording)]
        words += ["--header", str(self._header.value)] if self._header.value else []
        words += [word for array, name in names.items() for word in ("--name", f"{array}={name}")]
        words += ["--even-if-wrong"] if self._wrong.value else []
        folder = server.free_folder(safe_name(Path(recording).stem, "recording"))
        server.queue.add(f"maps from {Path(recording).name}", folder, "", [*words, "--out", "{out}"])
        self.page.see(folder)


def _give_header() -> None:
    ui.download.content(header_to_fill_in(), "header.toml")


def header_to_fill_in() -> str:
    """The keys that a header must have, each with its meaning, and those that it may have, as remarks."""
    from ..io.recording_header import RecordingHeader

    schema = RecordingHeader.model_json_schema()
    needed = schema["required"]
    lines = ["# What a recording's arrays do not say. Fill in what is needed; the other keys may stay remarks.", ""]
    for name in (*needed, *(each for each in schema["properties"] if each not in needed)):
        key = schema["properties"][name]
        unit, left = key.get("unit") or "", key.get("left_out")
        if "description" in key:
            comment = f"{key['description']}{f' [{unit}]' if unit not in ('', '1') else ''}"
            lines.append(f"# {comment}{f' Left out: {left}.' if left else ''}")
        lines.append(f"{'' if name in needed else '# '}{name} = ")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main())
