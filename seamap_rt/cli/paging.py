"""The command `app`: the page."""

from __future__ import annotations

from pathlib import Path

from ..errors import InputError
from .shell import Whole, command, console


@command("app", "app --port 0 --runs night", name="app")
def page(*, port: Whole = 8322, runs: Path = Path("runs"), host: str = "127.0.0.1", browser: bool = True) -> int:
    """Open the page: choose waves and radar, see what that is likely to do, run it, and look at what it gave.

    It answers this machine alone, and who has the address that is printed. Ctrl-C ends it, and its runs keep their
    whole turns.

    Parameters
    ----------
    port
        Of the page; 0 takes a free one.
    runs
        Folder in which runs are kept and looked for.
    host
        Address to listen on; another one than the default lets other machines in, unencrypted.
    browser
        Open the browser, where there is a screen.
    """
    if not 0 <= port <= 65535:
        raise InputError(f"--port = {port}: must be 0 to 65535; 0 takes a free one")
    from ..app import serve

    try:
        serve(runs, port=port, host=host, browser=browser, told=console.print)
    except KeyboardInterrupt:
        console.print("the page is closed")
    return 0
