"""The page's address: a port that is taken is refused before anything is loaded, and loopback is the default."""

from __future__ import annotations

import inspect
import socket
from pathlib import Path

import pytest

from seamap_rt.app.serving import _listening, _names, serve
from seamap_rt.cli.paging import page
from seamap_rt.errors import InputError


def test_a_taken_port_is_refused_in_a_line() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=rf"--port = {port}: cannot be listened on"):
            _listening("127.0.0.1", port)


def test_a_host_that_is_none_is_refused_in_a_line() -> None:
    with pytest.raises(InputError, match=r"cannot be listened on at no\.such\.host"):
        _listening("no.such.host.invalid", 0)


def test_it_listens_on_loopback_unless_told_otherwise() -> None:
    assert inspect.signature(page).parameters["host"].default == "127.0.0.1"
    with _listening("127.0.0.1", 0) as listening:
        assert listening.getsockname()[0] == "127.0.0.1"
    assert _names("127.0.0.1", 80) == {"127.0.0.1:80", "localhost:80", "[::1]:80"}


def test_a_folder_that_cannot_be_is_refused_by_its_option(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"--runs = .*file/runs: cannot be a folder"):
        serve(tmp_path / "file" / "runs", port=0, host="127.0.0.1", browser=False, told=print)
