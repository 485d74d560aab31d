"""Recorded echoes: a recording and its header are uploaded, and a retrieval of them is queued and opened."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from nicegui import ui

from ..errors import InputError
from ..io.recorded import ARRAYS
from ..io.recording_header import RecordingHeader
from .safety import safe_name
from .uploads import KINDS, MB, list_uploads, upload_button
from .widgets import choice, flat_button

if TYPE_CHECKING:
    from .page import Page


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
        told: dict[str, str] = {}
        for each in filter(None, (part.strip() for part in (self._names.value or "").split(","))):
            array, equals, name = (part.strip() for part in each.partition("="))
            if array not in ARRAYS or not equals or not name:
                raise InputError(f"{each}: must be ARRAY=NAME, where ARRAY is one of {', '.join(ARRAYS)}")
            told[array] = name
        return told

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
    schema = RecordingHeader.model_json_schema()
    needed = schema["required"]
    lines = ["# What a recording's arrays do not say. Fill in what is needed; the other keys may stay remarks.", ""]
    for name in (*needed, *(each for each in schema["properties"] if each not in needed)):
        key = schema["properties"][name]
        unit, left = key.get("unit") or "", key.get("left_out")
        if "description" in key:
            told = f"{key['description']}{f' [{unit}]' if unit not in ('', '1') else ''}"
            lines.append(f"# {told}{f' Left out: {left}.' if left else ''}")
        lines.append(f"{'' if name in needed else '# '}{name} = ")
    return "\n".join(lines) + "\n"
