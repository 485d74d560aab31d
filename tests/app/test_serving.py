"""The page's address: a port that is taken is refused before anything is loaded, and loopback is the default."""

from __future__ import annotations

import contextlib
import inspect
import signal
import socket
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from browsing import serve as served

from seamap_rt.app import _host_names, _open_socket, serve
from seamap_rt.cli.beginning import page
from seamap_rt.errors import InputError


def test_a_taken_port_is_refused_in_a_line() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=rf"--port = {port}: cannot be listened on"):
            _open_socket("127.0.0.1", port)


def test_a_host_that_is_none_is_refused_in_a_line() -> None:
    with pytest.raises(InputError, match=r"cannot be listened on at no\.such\.host"):
        _open_socket("no.such.host.invalid", 0)


def test_it_listens_on_loopback_unless_told_otherwise() -> None:
    assert inspect.signature(page).parameters["host"].default == "127.0.0.1"
    with _open_socket("127.0.0.1", 0) as listening:
        assert listening.getsockname()[0] == "127.0.0.1"
    assert _host_names("127.0.0.1", 80) == {"127.0.0.1:80", "localhost:80", "[::1]:80"}


def test_a_folder_that_cannot_be_is_refused_by_its_option(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"--runs = .*file/runs: cannot be a folder"):
        serve(tmp_path / "file" / "runs", port=0, host="127.0.0.1", browser=False, announce=print)


_STATIC = b"/_nicegui/3/static/"
_PATHS = [
    b"/%0d%0aX:1", b"/%00", b"/%ff%fe", b"/\xff", b"/%ed%a0%80", b"/%7f%80", b"/" + b"a" * 20_000, b"//evil",
    b"/%", b"*",
    b"/files/%00/maps.nc", b"/files/one%0d%0a/maps.nc", b"/files/%ff/maps.nc", b"/files/" + b"a/" * 3000 + b"maps.nc",
    b"/files/" + b"a" * 3000 + b"/maps.nc", b"/files/one/maps.nc%00", b"/files/../../etc/passwd/maps.nc",
    _STATIC + b"%00", _STATIC + b"%0d%0a", _STATIC + b"a" * 3000, _STATIC + b"../../x",
    b"/_nicegui_ws/socket.io/?EIO=4&transport=polling&sid=%00", b"/_nicegui_ws/socket.io/?EIO=x&transport=%ff",
]  # fmt: skip
_HEADERS = [
    b"Origin: http://[bad", b"Origin: \xff", b"Cookie: \xff=\x01", b'Cookie: a="' + b"\\" * 20_000 + b'"',
    b"Content-Length: -1", b"Content-Length: " + b"9" * 5000, b"Content-Length: \xb2", b"Transfer-Encoding: chunked",
    b"Range: bytes=\xff", b"Range: bytes=" + b"0-1," * 3000 + b"2-3", b"If-Range: \xff", b"Content-Type: \xff",
    b"X: \0", b"X: " + b"a" * 100_000, b"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: x",
    b"X-Forwarded-Prefix: \xff", b"Host: elsewhere",
]  # fmt: skip


def _asked(address: tuple[str, int], path: bytes, header: bytes, with_token: bytes) -> bytes:
    lines = [b"GET " + path + b" HTTP/1.1", b"Host: %s:%d" % (address[0].encode(), address[1]), b"Connection: close"]
    waits = header.startswith((b"Transfer-Encoding", b"Upgrade"))  # it waits for more, and we go
    with socket.create_connection(address, 0.3 if waits else 20.0) as line:
        line.sendall(b"\r\n".join([*lines, with_token, *([header] if header else []), b"", b""]))
        with contextlib.suppress(TimeoutError, ConnectionError):
            return line.recv(65536)
        return b""


def test_no_bytes_on_the_line_leave_a_traceback(tmp_path: Path) -> None:
    """Paths and headers as no browser sends them, with the token and without: an answer of 2xx to 4xx, or none."""
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "maps.nc").write_bytes(b"x" * 10)
    server = served(tmp_path)
    place = urlsplit(server.address)
    address, token = (str(place.hostname), int(place.port or 0)), place.query.encode()
    cookie = b"Cookie: seamap_rt_%d=%s" % (address[1], token.partition(b"=")[2])
    for path in _PATHS:
        asked_with_token = path + (b"&" if b"?" in path else b"?") + token
        answers = [_asked(address, path, b"", each) for each in (cookie, b"A: b")]
        answers.append(_asked(address, asked_with_token, b"", b"A: b"))
        assert {each[9:10] for each in answers} <= {b"2", b"3", b"4", b""}, (path, answers)
    for header in _HEADERS:
        for path in (b"/", b"/files/one/maps.nc", b"/_nicegui_ws/socket.io/?EIO=4&transport=polling"):
            answers = [_asked(address, path, header, each) for each in (cookie, b"A: b")]
            assert {each[9:10] for each in answers} <= {b"2", b"3", b"4", b""}, (path, header, answers)
    assert _asked(address, b"/files/one/maps.nc", b"", cookie).startswith(b"HTTP/1.1 200")  # it lives
    server.process.send_signal(signal.SIGINT)
    said, _ = server.process.communicate(timeout=30.0)
    assert "Traceback" not in said
