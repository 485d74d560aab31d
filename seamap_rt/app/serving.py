"""The server of the page: until Ctrl-C, on a socket of this machine, for who holds its token (`safety`)."""

from __future__ import annotations

import asyncio
import os
import socket
import threading
import webbrowser
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from ..errors import InputError
from . import drawing
from .safety import COOKIE, Gate, Guard, new_token

INTERRUPTED = 130
_LONGEST_END_S = 20.0


def serve(runs: Path, *, port: int, host: str, browser: bool, announce: Callable[[str], None]) -> None:
    """Serve the page until Ctrl-C or SIGTERM.

    runs: folder of the runs, made if it is not there. port: 0 takes a free one. announce: is given the address.
    Raises InputError for a port or a host that cannot be listened on, and for a folder that cannot be made.
    """
    try:
        runs.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"--runs = {runs}: cannot be a folder ({error.strerror or error}); choose another one"
        ) from None
    listening = _listening(host, port)
    number = listening.getsockname()[1]
    token = os.environ.get("SEAMAP_RT_APP_TOKEN") or new_token()  # given by tests, and by who opens it himself
    gate = Gate(token, _names(host, number), f"{COOKIE}_{number}")
    name = "127.0.0.1" if host in ("0.0.0.0", "::", "") else host
    address = f"http://{f'[{name}]' if ':' in name else name}:{number}/?token={token}"
    server = _server(runs, gate)
    announce(f"the page: {address}")
    announce(f"runs are kept in {runs}; Ctrl-C ends the page, and its runs keep their whole turns")
    if browser and (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        webbrowser.open(address)
    server.run(sockets=[listening])


def _server(runs: Path, gate: Gate) -> Any:
    import uvicorn
    from fastapi import FastAPI
    from nicegui import app as page_app
    from nicegui import ui

    from . import design_view  # noqa: F401  what is seen first: it is ready when the browser comes
    from .draft import scene_schema
    from .page import ServerState, show
    from .runs import give_files

    server = ServerState.of(runs)
    outer = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    give_files(outer, server)

    async def root() -> None:
        await show(server)

    ui.run_with(
        outer, root=root, title="seamap_rt", favicon="🌊", dark=None, show_welcome_message=False, reconnect_timeout=60.0
    )
    page_app.on_startup(lambda: asyncio.to_thread(scene_schema))  # of the form, while the browser loads the page
    page_app.on_shutdown(partial(_close, server))
    config = uvicorn.Config(
        Guard(outer, gate),
        log_level="warning",
        access_log=False,
        server_header=False,
        ws_per_message_deflate=False,  # pictures do not compress, and the road within a machine is wide
        timeout_graceful_shutdown=2,
    )
    return uvicorn.Server(config)


def _close(server: Any) -> None:
    """End what runs; and the process, whatever a library still waits for by then."""
    last = threading.Timer(_LONGEST_END_S, os._exit, (INTERRUPTED,))
    last.daemon = True
    last.start()
    drawing.close()
    server.queue.close()


def _listening(host: str, port: int) -> socket.socket:
    """The socket, so that a port that is taken is refused before anything is loaded."""
    try:
        family, kind, protocol, _, place = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        listening = socket.socket(family, kind, protocol)
        try:
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listening.bind(place)
            listening.listen(128)  # who comes before the server is ready waits
        except OSError:
            listening.close()
            raise
    except OSError as error:
        raise InputError(
            f"--port = {port}: cannot be listened on at {host} ({error.strerror or error}); choose another one, or 0 "
            "for a free one"
        ) from None
    return listening


def _names(host: str, port: int) -> frozenset[str]:
    """What a browser may call the page. Beyond loopback, also this machine's own names."""
    names = {"127.0.0.1", "localhost", "[::1]"}
    if host not in ("127.0.0.1", "localhost", "::1"):
        names |= {f"[{host}]" if ":" in host else host, socket.gethostname().lower(), socket.getfqdn().lower()}
    return frozenset(f"{name}:{port}" for name in names)
