"""The page: choose waves and radar, see what that is likely to do, run it in a process of its own, look at the results.

`seamap-rt app` serves it, here: until Ctrl-C, on a socket of this machine, for who holds its token. It can start
processes and read files, so it answers only who knows the token of its address, only under the names that it listens on
(a foreign name that was made to point here is refused), and no page of another origin.

The page's process simulates nothing and loads no ray tracer: a run is the command line in a process of its own
(`jobs`), and what it wrote is read turn by turn from its files (`source`), also while it grows. `folders` says which
files may be touched; `draft` is the form without the page; `prospects` is what a design is likely to do. What a person
moves, plays or points at is a graph in the browser; any other figure is the report's own, as an image. Either is drawn
in processes of their own (`drawing`); an upload is first read in another (`uploads`). `page` holds the places of the
page, whose names end with `_view`, and what they are made of; panels are parts of See.
"""

from __future__ import annotations

import asyncio
import hmac
import os
import secrets
import socket
import threading
import webbrowser
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, quote

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, Response

from ..errors import InputError
from . import drawing
from .folders import is_text

INTERRUPTED = 130
_LONGEST_END_S = 20.0
_COOKIE = "seamap_rt"
_MOST_BYTES = 64 * 2**20  # of a request: the largest upload
_MOST_HEAD = 2**15  # bytes of its query and headers: others read cookies in a time that grows with their square
_HEADERS = {
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cache-control": "no-store",
}


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
    listening = _open_socket(host, port)
    number = listening.getsockname()[1]
    given = os.environ.get("SEAMAP_RT_APP_TOKEN")  # by tests, and by who opens the page himself
    token = given or secrets.token_urlsafe(24)
    gate = Gate(token, _host_names(host, number), f"{_COOKIE}_{number}")
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
    from .folders import give_files
    from .page import ServerState, show

    server = ServerState(runs)
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


def _open_socket(host: str, port: int) -> socket.socket:
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


def _host_names(host: str, port: int) -> frozenset[str]:
    """What a browser may call the page. Beyond loopback, also this machine's own names."""
    names = {"127.0.0.1", "localhost", "[::1]"}
    if host not in ("127.0.0.1", "localhost", "::1"):
        names |= {f"[{host}]" if ":" in host else host, socket.gethostname().lower(), socket.getfqdn().lower()}
    return frozenset(f"{name}:{port}" for name in names)


@dataclass(frozen=True)
class Gate:
    """What a request must be to pass; see `refusal`.

    token: of the address. hosts: values of `Host` under which the page is known, as "127.0.0.1:8322".
    """

    token: str
    hosts: frozenset[str]
    cookie: str = _COOKIE  # cookies know no ports: two pages on one machine need two names

    def refusal(self, headers: Iterable[tuple[bytes, bytes]], query: bytes) -> str | None:
        """Why a request is refused; None where it passes."""
        pairs = [(name.lower(), value.decode("latin-1")) for name, value in headers]
        given = dict(pairs)
        if len([name for name, _ in pairs if name == b"host"]) != 1 or given[b"host"].lower() not in self.hosts:
            return "unknown host: open the address that seamap-rt app printed"
        origin = given.get(b"origin")
        if origin is not None and origin.partition("://")[2].lower() != given[b"host"].lower():
            return "another origin: open the address that seamap-rt app printed"
        if not self._is_admitted(given.get(b"cookie", ""), query):
            return "no token: open the address that seamap-rt app printed, with its ?token="
        return None

    def _is_admitted(self, cookies: str, query: bytes) -> bool:
        pairs = (each.strip().partition("=") for each in cookies.split(";"))
        tokens = [
            *parse_qs(query.decode("latin-1")).get("token", []),
            *(v for name, _, v in pairs if name == self.cookie),
        ]
        return any(hmac.compare_digest(each.encode(), self.token.encode()) for each in tokens)


@dataclass
class Guard:
    """ASGI middleware: lets through what passes the gate, and bounds what it may send."""

    app: Any
    gate: Gate
    most_bytes: int = _MOST_BYTES

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        query: bytes = scope.get("query_string", b"")
        if len(query) + sum(len(name) + len(value) for name, value in scope["headers"]) > _MOST_HEAD:
            await _refuse(scope, receive, send, 431, f"more than {_MOST_HEAD / 2**10:.0f} kB before the request's body")
            return
        refusal = self.gate.refusal(scope["headers"], query)
        if refusal is not None:
            await _refuse(scope, receive, send, 403, refusal)
            return
        if not is_text(scope["path"]):
            await _refuse(scope, receive, send, 400, "the address has a character that does not print")
            return
        if scope["type"] == "websocket":
            await self.app(scope, receive, send)
            return
        length = Headers(raw=scope["headers"]).get("content-length", "")
        if length.isdecimal() and (len(length) > 19 or int(length) > self.most_bytes):
            await _refuse(scope, receive, send, 413, f"more than {self.most_bytes / 2**20:.0f} MB")
            return
        if b"token=" in query and scope["method"] == "GET":
            await self._welcome(scope["path"])(scope, receive, send)
            return
        request = _Request(receive, self.most_bytes)
        try:
            await self.app(scope, request.read, _add_headers(send))
        except Exception:
            if not request.gone:  # else a library's complaint that there was nobody left to answer
                raise

    def _welcome(self, path: str) -> Response:
        """The token goes from the address into a cookie, so that it is not in the history, nor passed on."""
        value = f"{self.gate.cookie}={self.gate.token}; Path=/; HttpOnly; SameSite=Strict"
        local = "/" + path.lstrip("/\\")  # "//elsewhere" would be another machine
        return Response(status_code=303, headers={"location": quote(local), "set-cookie": value, **_HEADERS})


class _Request:
    """What a request sends. A body that says nothing of its length is cut off where it becomes too long."""

    def __init__(self, receive: Any, most_bytes: int) -> None:
        self._receive, self._most_bytes, self._seen = receive, most_bytes, 0
        self.gone = False  # who asked

    async def read(self) -> Any:
        message = await self._receive()
        self._seen += len(message.get("body", b""))
        self.gone |= message["type"] == "http.disconnect"
        return {"type": "http.disconnect"} if self._seen > self._most_bytes else message


def _add_headers(send: Any) -> Any:
    async def send_with_headers(message: Any) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in _HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return send_with_headers


async def _refuse(scope: Any, receive: Any, send: Any, status: int, words: str) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": words[:120]})
    else:
        await PlainTextResponse(f"seamap-rt: {words}\n", status, _HEADERS)(scope, receive, send)
