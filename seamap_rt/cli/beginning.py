"""Commands with which one begins: new, keys, scenes and app."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from rich.table import Table
from rich.text import Text

from ..compute.machine import A_TABLE
from ..errors import InputError
from .shell import Whole, about, app, command, console

Shell = Literal["bash", "zsh", "fish"]
_WIDEST = 36  # characters of a column in a pipe; what is longer moves its line's rest


@command("new mine.toml", "new night.toml --like solid_state_chirp", need=A_TABLE)
def new(file: Path = Path("my_scene.toml"), /, *, like: str = "choppy_sea", overwrite: bool = False) -> int:
    """Write a scene file to begin with, its keys explained. It runs as it stands.

    Parameters
    ----------
    file
        The scene file, whose name is the scene's.
    like
        The pattern, a shipped scene's name (see scenes) or a scene file. choppy_sea has the radar of the study (1 W,
        20 ns, 60 turns a minute), solid_state_chirp one of 25 W that compresses its pulses.
    overwrite
        Replace the file.
    """
    from ..scene.starting import write_scene

    path = write_scene(file, like, overwrite=overwrite)
    console.print(f"{path}: like {like}; change it, and run it by seamap-rt run {path}")
    return 0


@command("keys radar.height_m", "keys height", need=A_TABLE)
def keys(what: str = "", /) -> int:
    """Tell of the keys of a scene file: unit, default, limits and meaning. In a pipe, a line each.

    Parameters
    ----------
    what
        A key, as radar.height_m; a section, as radar or sea.waves; or a word of names and meanings, as height.
        Default all.
    """
    from ..scene.keys import KeySection, key_sections, keys_about

    found: Sequence[KeySection] = keys_about(what) if what.strip() else key_sections()
    if console.is_terminal:
        for each in found:
            _print_table(each)
        return 0
    rows = [("key", "unit", "default", "limit", "meaning"), *(row for each in found for row in _rows(each))]
    widths = [min(_WIDEST, max(len(row[column]) for row in rows)) for column in range(3)]
    for row in rows:
        padded = [f"{cell:<{width}}" for cell, width in zip(row, widths, strict=False)]
        console.print("  ".join([*padded, " | ".join(filter(None, row[3:]))]).rstrip())
    return 0


def _rows(section) -> list[tuple[str, ...]]:
    """A section's keys in plain text, with the section before the name."""
    above = f"{section.path}." if section.path else ""
    rows: list[tuple[str, ...]] = []
    if section.tag:
        choices = ", ".join(kind.name for kind in section.kinds)
        rows.append((above + section.tag, "", "needed", choices, section.meaning))
    for row in section.rows:
        of = f" Of {', '.join(row.kinds)}." if row.kinds else ""
        cells = (above + row.name, row.unit, row.default, row.limit, row.meaning + of)
        rows.append(tuple(" ".join(cell.replace("`", "").split()) for cell in cells))
    return rows


def _print_table(section) -> None:
    if not (rows := _rows(section)):
        return
    table = Table(title=Text(section.heading), title_justify="left", title_style="bold", show_lines=False, expand=False)
    table.add_column("key", no_wrap=True)
    table.add_column("unit")
    table.add_column("default", overflow="fold", max_width=24)
    table.add_column("limit", overflow="fold", max_width=32)
    table.add_column("meaning")
    for name, *cells in rows:
        table.add_row(name.rsplit(".", 1)[-1], *cells)
    console.print(table, soft_wrap=False)


@command("scenes", "new mine.toml --like pier", need=A_TABLE)
def scenes() -> int:
    """List the shipped scenes, a line each."""
    from ..io.scenefile import list_shipped, read_toml

    for name, path in list_shipped().items():
        console.print(f"{name:20} {read_toml(path).get('title', '')}")
    return 0


@command("--install-completion", "--install-completion --shell zsh", name="--install-completion", need=A_TABLE)
def install_completion(
    *, shell: Annotated[Shell | None, about("Default the one from which this is called.")] = None
) -> int:
    """Let bash, zsh or fish complete commands and options by Tab."""
    from cyclopts.completion.detect import ShellDetectionError

    try:
        path = app.install_completion(shell=shell)
    except ShellDetectionError:
        raise InputError("--shell: is missing, and cannot be found from here; give bash, zsh or fish") from None
    console.print(f"{path}: completes seamap-rt in every shell that is started from now on")
    return 0


@command("app", "app --port 0 --runs night", name="app")
def page(
    *,
    port: Annotated[Whole, about("Of the page; 0 takes a free one.")] = 8322,
    runs: Annotated[Path, about("Folder in which runs are kept and looked for.")] = Path("runs"),
    host: Annotated[
        str, about("Address to listen on; another one than the default lets other machines in, unencrypted.")
    ] = "127.0.0.1",
    browser: Annotated[bool, about("Open the browser, where there is a screen.")] = True,
) -> int:
    """Open the page: choose waves and radar, see what that is likely to do, run it, and look at what it gave.

    It answers this machine alone, and who has the address that is printed. Ctrl-C ends it, and its runs keep their
    whole turns.
    """
    if not 0 <= port <= 65535:
        raise InputError(f"--port = {port}: must be 0 to 65535; 0 takes a free one")
    from ..app import serve

    try:
        serve(runs, port=port, host=host, browser=browser, announce=console.print)
    except KeyboardInterrupt:
        console.print("the page is closed")
    return 0
