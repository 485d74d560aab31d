"""Who may ask the server of the page, and which files it may touch: one address on loopback, one token.

The page can start processes and read files, so it answers only who knows the token of its address, only under the names
that it listens on (a foreign name that was made to point here is refused), and no page of another origin.
"""

from __future__ import annotations

import hmac
import os
import re
import secrets
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, quote

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, Response

from ..errors import InputError
from ..io.opening import check_file

COOKIE = "seamap_rt"
MOST_BYTES = 64 * 2**20  # of a request: the largest upload
_MOST_HEAD = 2**15  # bytes of its query and headers: others read cookies in a time that grows with their square
_NO_TEXT = re.compile(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]")  # controls, and bytes that are no UTF-8
_HEADERS = {
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cache-control": "no-store",
}


def new_token() -> str:
    """A secret that nobody guesses, for an address."""
    return secrets.token_urlsafe(24)


@dataclass(frozen=True)
class Gate:
    """What a request must be to pass; see `refusal`.

    token: of the address. hosts: values of `Host` under which the page is known, as "127.0.0.1:8322".
    """

    token: str
    hosts: frozenset[str]
    cookie: str = COOKIE  # cookies know no ports: two pages on one machine need two names

    def refusal(self, headers: Iterable[tuple[bytes, bytes]], query: bytes) -> str | None:
        """Why a request is refused; None where it passes."""
        pairs = [(name.lower(), value.decode("latin-1")) for name, value in headers]
        given = dict(pairs)
        if len([name for name, _ in pairs if name == b"host"]) != 1 or given[b"host"].lower() not in self.hosts:
            return "unknown host: open the address that seamap-rt app printed"
        origin = given.get(b"origin")
        if origin is not None and origin.partition("://")[2].lower() != given[b"host"].lower():
            return "another origin: open the address that seamap-rt app printed"
        if not self._knows(given.get(b"cookie", ""), query):
            return "no token: open the address that seamap-rt app printed, with its ?token="
        return None

    def _knows(self, cookies: str, query: bytes) -> bool:
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
    most_bytes: int = MOST_BYTES

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
            await self.app(scope, request.read, _with_headers(send))
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


def _with_headers(send: Any) -> Any:
    async def sent(message: Any) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in _HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return sent


async def _refuse(scope: Any, receive: Any, send: Any, status: int, words: str) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": words[:120]})
    else:
        await PlainTextResponse(f"seamap-rt: {words}\n", status, _HEADERS)(scope, receive, send)


# ------------------------------------------------------------------------------------------------------ files

_FILE_KEYS = ("file", "mesh")  # of scenes, at any depth
_PRODUCTS = (".nc", ".json", ".toml", ".part", ".npz", ".txt")


@dataclass(frozen=True)
class Roots:
    """The folders below which the page may touch files: the first is that of the runs, into which it writes."""

    runs: Path
    others: tuple[Path, ...] = ()

    @cached_property
    def _resolved(self) -> tuple[Path, ...]:
        return tuple(each.resolve() for each in (self.runs, *self.others))

    @property
    def uploads(self) -> Path:
        """Where what is dropped onto the page goes."""
        return self.runs / ".uploads"

    def holds(self, path: str | Path) -> bool:
        """Whether a path, links followed, lies below one of the folders."""
        try:
            real = Path(path).resolve()
        except (OSError, ValueError, RuntimeError):
            return False
        return any(real.is_relative_to(root) for root in self._resolved)

    def run(self, name: str) -> Path:
        """The folder of a run by its name, relative to the runs. InputError for one that is not there."""
        folder = self.runs / name
        try:
            found = folder.is_dir() and folder.resolve().is_relative_to(self._resolved[0])
        except (OSError, ValueError, RuntimeError):
            found = False
        if not found:
            raise InputError(f"run = '{name}': no such folder in {self.runs}; choose one from the list")
        if odd := unreadable_product(folder, self.holds):
            raise InputError(f"run = '{name}': {odd}")
        return folder

    def check_files(self, tree: Any, key: str = "") -> None:
        """InputError for a scene that names a file elsewhere. Paths in it are absolute."""
        if isinstance(tree, Mapping):
            for name, value in tree.items():
                below = f"{key}.{name}" if key else str(name)
                if name in _FILE_KEYS and isinstance(value, str) and value and not self.holds(value):
                    raise InputError(
                        f"{below} = {value}: lies outside of the folders that this page may read; upload the file, or "
                        f"copy it below {self.runs}"
                    )
                self.check_files(value, below)
        elif isinstance(tree, list | tuple):
            for index, entry in enumerate(tree):
                self.check_files(entry, f"{key}.{index}")


def is_text(name: str) -> bool:
    """False for a name with letters that do not print, or in bytes that are no text: no browser can be given it."""
    return not _NO_TEXT.search(name)


def unreadable_product(folder: Path, holds: Callable[[Path], bool]) -> str:
    """Which of a folder's products nobody may read, in words: it is no regular file, or a link to a place that `holds`
    denies. Empty where all are as they should be."""
    with os.scandir(folder) as found:
        entries = list(found)
    for entry in entries:
        if entry.name.endswith(".part") and entry.is_dir(follow_symlinks=False):  # the turns of one that grows
            if odd := unreadable_product(Path(entry.path), holds):
                return odd
            continue
        if entry.name.endswith(_PRODUCTS) and not entry.is_file(follow_symlinks=False):
            try:
                check_file(entry.path, "a result", named=entry.name)
            except InputError as refusal:
                return str(refusal)
            if not holds(Path(entry.path)):
                return f"{entry.name}: links to a place that this page may not read; copy the file"
    return ""


def safe_name(name: str, fallback: str = "upload") -> str:
    """The last part of a name that a browser gave, with letters that any file system takes."""
    last = name.replace("\\", "/").rsplit("/", 1)[-1]
    kept = "".join(letter if letter.isascii() and (letter.isalnum() or letter in "._+-") else "_" for letter in last)
    kept = kept.lstrip(".")[-100:]
    return kept or fallback
