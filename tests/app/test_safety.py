"""Who may ask the page, and which files it touches: anything else is refused."""

from __future__ import annotations

import asyncio
import os
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import example, given
from hypothesis import strategies as st

from seamap_rt.app import Gate, Guard
from seamap_rt.app.folders import PRODUCTS, Roots, products_of, safe_name
from seamap_rt.errors import InputError
from seamap_rt.io.growing_store import GrowingStore
from seamap_rt.io.reading import read_whole_turns

_GATE = Gate("the-token", frozenset({"127.0.0.1:8000", "localhost:8000"}))
_COOKIE = (b"cookie", b"other=1; seamap_rt=the-token")
_HOST = (b"host", b"127.0.0.1:8000")


def test_the_token_opens_as_a_cookie_or_in_the_address() -> None:
    assert _GATE.refusal([_HOST, _COOKIE], b"") is None
    assert _GATE.refusal([_HOST], b"token=the-token") is None


@pytest.mark.parametrize(
    ("headers", "query", "why"),
    [
        ([_HOST], b"", "no token"),
        ([_HOST], b"token=the-toke", "no token"),
        ([_HOST, (b"cookie", b"seamap_rt=the-token2")], b"", "no token"),
        ([_HOST, (b"cookie", b"seamap_rt_9=the-token")], b"", "no token"),
        ([(b"host", b"evil.example:8000"), _COOKIE], b"", "unknown host"),
        ([(b"host", b"127.0.0.1:8001"), _COOKIE], b"", "unknown host"),
        ([_COOKIE], b"", "unknown host"),
        ([_HOST, (b"host", b"evil.example"), _COOKIE], b"", "unknown host"),
        ([_HOST, _COOKIE, (b"origin", b"http://evil.example")], b"", "another origin"),
        ([_HOST, _COOKIE, (b"origin", b"null")], b"", "another origin"),
        ([_HOST, _COOKIE, (b"origin", b"http://127.0.0.1:8001")], b"", "another origin"),
    ],
)
def test_anything_else_is_refused(headers: list[tuple[bytes, bytes]], query: bytes, why: str) -> None:
    refusal = _GATE.refusal(headers, query)
    assert refusal is not None
    assert refusal.startswith(why)


_BYTES = st.binary(max_size=40)
_ORIGINS = (
    _BYTES | st.builds(b"http://".__add__, _BYTES) | st.sampled_from([b"http://[", b"http://[::1", b"//]", b"\xb2"])
)


@given(_BYTES | st.builds(b"seamap_rt=".__add__, _BYTES), _ORIGINS, _BYTES | st.builds(b"token=".__add__, _BYTES))
def test_no_bytes_open_the_gate_or_break_it(cookie: bytes, origin: bytes, query: bytes) -> None:
    headers = [_HOST, (b"cookie", cookie), (b"origin", origin)]
    assert _GATE.refusal(headers, query) is not None
    assert _GATE.refusal(headers[:2], query) is not None


def test_a_cookie_is_read_in_a_time_that_grows_with_its_length() -> None:
    """Python's own reader takes 10 s for 60 kB of backslashes, from anybody: no token is asked before."""
    begin = time.process_time()
    for filled in (b"\\", b"\\1", b"a=b;", b" ", b'"'):
        cookie = b'a="' + filled * (2**15 // len(filled)) + b'"'
        assert _GATE.refusal([_HOST, (b"cookie", cookie)], b"") is not None
    assert time.process_time() - begin < 1.0


@given(
    st.text(st.characters(exclude_categories=[]), max_size=30),
    st.sampled_from([b"", b"token=the-token", b"a=%00&token=the-token"]) | _BYTES,
    st.lists(st.tuples(st.sampled_from([b"cookie", b"origin", b"content-length", b"range", b"x"]), _BYTES), max_size=3),
    st.sampled_from(["http", "websocket"]),
)
@example("/\r\nset-cookie: a=b", b"token=the-token", [], "http")
@example("/a\0b", b"", [], "http")
@example("/\udcff", b"token=the-token", [], "http")
@example("/ž?#", b"token=the-token", [], "http")
@example("/", b"", [(b"content-length", b"9" * 5000)], "http")
@example("/", b"", [(b"x", b"a" * 2**15)], "http")
def test_whatever_bytes_come_the_answer_is_one_that_can_be_sent(
    path: str, query: bytes, headers: list[tuple[bytes, bytes]], kind: str
) -> None:
    """By one who has the token: no fault of ours, and nothing of the address that would begin a header of its own."""
    scope = {"type": kind, "method": "GET", "path": f"/{path}", "query_string": query}
    sent, _ = _asked({**scope, "headers": [_HOST, _COOKIE, *headers]}, [b""])
    if kind == "websocket":
        assert sent[0]["type"] in ("websocket.close", "http.response.start")
        return
    assert sent[0]["status"] in (200, 303, 400, 403, 413, 431)
    for name, value in sent[0]["headers"]:
        assert not set(name + value) & set(b"\r\n\0")
        assert (name + value).isascii()
    if not path.isprintable() and sent[0]["status"] in (200, 303):
        assert all(letter.isspace() or ord(letter) > 0xA0 for letter in path if not letter.isprintable())


def _asked(scope: dict[str, Any], body: list[bytes], most: int = 10) -> tuple[list[dict[str, Any]], list[bytes]]:
    """What a guarded application of one line answers, and what it was given to read."""
    sent: list[dict[str, Any]] = []
    read: list[bytes] = []
    parts = iter(body)

    async def receive() -> dict[str, Any]:
        part = next(parts, None)
        return (
            {"type": "http.disconnect"} if part is None else {"type": "http.request", "body": part, "more_body": True}
        )

    async def send(message: dict[str, Any]) -> None:
        sent.append(message)

    async def application(_: Any, receive: Any, send: Any) -> None:
        while (message := await receive())["type"] == "http.request":
            read.append(message["body"])
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"in"})

    whole = {"type": "http", "method": "POST", "path": "/", "query_string": b"", "headers": [_HOST, _COOKIE], **scope}
    # In a thread of its own: a browser that was driven in this process keeps a loop running.
    with ThreadPoolExecutor(1) as pool:
        pool.submit(lambda: asyncio.run(Guard(application, _GATE, most)(whole, receive, send))).result()
    return sent, read


def test_a_body_is_bounded_by_what_it_says_and_by_what_it_sends() -> None:
    sent, read = _asked({"headers": [_HOST, _COOKIE, (b"content-length", b"11")]}, [b"x" * 11])
    assert (sent[0]["status"], read) == (413, [])
    sent, read = _asked({}, [b"1234", b"5678", b"9abc", b"more"])
    assert read == [b"1234", b"5678"]  # the third would make twelve of at most ten


def test_a_head_is_bounded_whoever_asks() -> None:
    for long in ({"headers": [_HOST, _COOKIE, (b"x", b"a" * 2**15)]}, {"query_string": b"a" * 2**15}):
        sent, read = _asked(long, [b"x"])
        assert (sent[0]["status"], read) == (431, [])
    sent, _ = _asked({"headers": [_HOST, _COOKIE, (b"x", b"a" * 2**14)]}, [b"x"])
    assert sent[0]["status"] == 200


def test_who_has_gone_is_not_complained_of_and_a_fault_of_ours_is() -> None:
    async def fails(_: Any, receive: Any, send: Any) -> None:
        if await receive():
            raise RuntimeError("No response returned.")

    def asked(message: dict[str, Any]) -> None:
        async def receive() -> dict[str, Any]:
            return message

        async def send(_: dict[str, Any]) -> None: ...

        scope = {"type": "http", "method": "GET", "path": "/", "query_string": b"", "headers": [_HOST, _COOKIE]}
        with ThreadPoolExecutor(1) as pool:
            pool.submit(lambda: asyncio.run(Guard(fails, _GATE)(scope, receive, send))).result()

    asked({"type": "http.disconnect"})
    with pytest.raises(RuntimeError):
        asked({"type": "http.request", "body": b""})


def test_the_application_is_not_reached_without_a_token() -> None:
    sent, read = _asked({"headers": [_HOST]}, [b"x"])
    assert (sent[0]["status"], read) == (403, [])


def test_a_websocket_is_closed_without_a_token() -> None:
    sent, _ = _asked({"type": "websocket", "headers": [_HOST]}, [b""])
    assert [each["type"] for each in sent] == ["websocket.close"]


@pytest.mark.parametrize("path", ["/", "//evil.example/x", "/\\evil.example", "/a b/č?x#y%0d"])
def test_the_token_leaves_the_address_for_a_cookie_of_this_machine_alone(path: str) -> None:
    sent, _ = _asked({"method": "GET", "path": path, "query_string": b"token=the-token"}, [])
    headers = dict(sent[0]["headers"])
    assert sent[0]["status"] == 303
    assert headers[b"location"].startswith(b"/")
    assert headers[b"location"][1:2] not in (b"/", b"\\")
    assert b"HttpOnly" in headers[b"set-cookie"]
    assert b"SameSite=Strict" in headers[b"set-cookie"]


# ------------------------------------------------------------------------------------------------------- files


@pytest.fixture
def roots(tmp_path: Path) -> Roots:
    (tmp_path / "runs" / "one").mkdir(parents=True)
    (tmp_path / "runs2").mkdir()
    (tmp_path / "secret.nc").write_text("secret")
    (tmp_path / "runs" / "link").symlink_to(tmp_path)
    return Roots(tmp_path / "runs")


def test_only_what_lies_below_the_folders_is_held(roots: Roots, tmp_path: Path) -> None:
    assert roots.holds(tmp_path / "runs" / "one" / "maps.nc")
    assert not roots.holds(tmp_path / "runs2")  # begins with the same letters
    assert not roots.holds(tmp_path / "runs" / ".." / "secret.nc")
    assert not roots.holds(tmp_path / "runs" / "link" / "secret.nc")
    assert not roots.holds("/etc/passwd")
    assert not roots.holds("a\0b")


@pytest.mark.parametrize("name", ["..", "../runs2", "/etc", "link", "nowhere", "one\0", "one/../.."])
def test_a_run_by_any_other_name_is_refused(roots: Roots, name: str) -> None:
    assert roots.run("one").name == "one"
    with pytest.raises(InputError, match="no such folder"):
        roots.run(name)


@pytest.mark.parametrize("kind", ["file", "link", "FIFO", "linked folder"])
def test_turns_of_a_run_that_grows_are_its_own_files(roots: Roots, tmp_path: Path, kind: str) -> None:
    store = GrowingStore(roots.runs / "one" / "run.zarr")
    store.append({"truth": xr.Dataset({"height": (("turn", "x"), np.ones((1, 9000)))}, {"turn": [0]})})
    chunk = store.path / "truth" / "height" / "c" / "0" / "0"
    if kind == "linked folder":
        store.path.rename(tmp_path / "moved")
        store.path.symlink_to(tmp_path / "moved")
        with pytest.raises(InputError, match=r"run\.zarr: links to a place"):
            roots.run("one")
        return
    if kind != "file":
        chunk.rename(tmp_path / "secret.chunk")
        chunk.symlink_to(tmp_path / "secret.chunk") if kind == "link" else os.mkfifo(chunk)
    path = roots.run("one") / "truth.nc"
    if kind == "file":
        assert read_whole_turns(path, lambda file: file["height"].shape) == (1, 9000)
    else:
        with pytest.raises(OSError, match="lies outside" if kind == "link" else "regular file"):
            read_whole_turns(path, lambda file: file["height"][0])


def test_a_scene_that_names_a_file_elsewhere_is_refused_by_its_key(roots: Roots, tmp_path: Path) -> None:
    inside = str(tmp_path / "runs" / "waves.nc")
    roots.check_files({"sea": {"waves": [{"file": inside}]}, "objects": [{"mesh": inside}], "platform": {"file": ""}})
    with pytest.raises(InputError, match=r"sea\.waves\.0\.file = /etc/passwd: lies outside"):
        roots.check_files({"sea": {"waves": [{"file": "/etc/passwd"}]}})
    with pytest.raises(InputError, match=r"prediction\.vessel\.file"):
        roots.check_files({"prediction": {"vessel": {"file": "../../x"}}})


@given(st.text(max_size=200))
def test_a_name_from_a_browser_becomes_one_that_stays_in_its_folder(name: str) -> None:
    safe = safe_name(name)
    assert safe
    assert (Path("/folder") / safe).resolve().parent == Path("/folder")
    assert not safe.startswith(".")


def test_products_are_named_files_alone(tmp_path: Path) -> None:
    for name in ("maps.nc", "private.txt", "report.html"):
        (tmp_path / name).write_text("x")
    assert products_of(tmp_path) == ["report.html", "maps.nc"]
    assert all("/" not in name for name in PRODUCTS)
