"""A scheduler that is not one is refused in a line, soon: silent, rude, of another kind, or without workers."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from threading import Thread

import pytest
from dask import config
from distributed import LocalCluster

from seamap_rt.errors import InputError
from seamap_rt.studies import cluster


@contextmanager
def port_that(greets: bytes | None) -> Iterator[str]:
    """The address of something that greets whoever connects and waits; None hangs up."""
    server, guests = socket.create_server(("127.0.0.1", 0)), []

    def serve() -> None:
        while True:
            try:
                guest, _ = server.accept()
            except OSError:
                return
            if greets is None:
                guest.close()
            else:
                guest.sendall(greets)
                guests.append(guest)

    thread = Thread(target=serve)
    thread.start()
    with closing(server):
        yield f"tcp://127.0.0.1:{server.getsockname()[1]}"
        server.shutdown(socket.SHUT_RDWR)
    thread.join()
    for guest in guests:
        guest.close()


def refused(scheduler: str, match: str) -> None:
    start = time.monotonic()
    with pytest.raises(InputError, match=match), cluster.existing_client(scheduler, 1.0):
        raise AssertionError("not refused")
    assert time.monotonic() - start < 15.0  # a client of its own accord waits for ever


GREETINGS = {
    "hangs up": None,
    "silent": b"",
    "ssh": b"SSH-2.0-OpenSSH_9.2\r\n",
    "three letters": b"hi\n",
    "a length alone": (100).to_bytes(8, "little"),
}


@pytest.mark.parametrize("greets", GREETINGS.values(), ids=GREETINGS)
def test_what_is_no_scheduler_is_refused(greets: bytes | None) -> None:
    with port_that(greets) as address:
        refused(address, f"--scheduler = '{address}': no scheduler answers at {address}")


def test_a_closed_port_is_refused() -> None:
    with port_that(None) as address:
        pass
    refused(address, "no scheduler answers")


def test_tls_without_certificates_is_refused() -> None:
    refused(
        "tls://127.0.0.1:1", "needs certificates, and dask's configuration has no distributed.comm.tls.ca-file; set"
    )
    with config.set({"distributed.comm.tls.ca-file": "ca.pem"}):
        refused("tls://127.0.0.1:1", r"tls\.client\.cert; set it, or DASK_DISTRIBUTED__COMM__TLS__CLIENT__CERT,")


def test_plain_connections_are_flagged() -> None:
    assert cluster.network_notes(None) == ()
    assert cluster.network_notes("tls://host:8786") == ()
    (note,) = cluster.network_notes("tcp://host:8786")
    assert "--scheduler = 'tcp://host:8786' trusts its network" in note


def test_a_scheduler_without_workers_is_refused() -> None:
    """One that runs, but to which no worker has come, says how one is started."""
    empty = LocalCluster(
        n_workers=0,
        processes=True,
        host="127.0.0.1",
        dashboard_address=None,  # pyright: ignore[reportArgumentType]
    )
    with closing(empty):
        refused(empty.scheduler_address, "has no workers; start some, as by dask worker tcp://")
