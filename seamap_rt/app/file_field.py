"""The button beside a field that names a file: it takes the file from the browser, checked and kept below the runs."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nicegui import events, ui

from ..errors import InputError
from .safety import Roots
from .uploads import KINDS, MB, keep


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
            path = await asyncio.to_thread(keep, roots, kind, name, content, names())
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
