"""A retrieval by itself: turns of echoes that stand or still grow, inspected before anything is written."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..errors import InputError, SchemaError
from ..inspection import Finding, inspect
from ..interferometry.retrieval import Changes, joined, retrieve_turns
from ..io.appendable import AppendableNetCDF
from ..io.results_folder import clear_folder, note_growing

MAPS = "maps.nc"
_JUDGED = 2  # turns: by the second the waves have moved on
_POLL_S = 1.0


class RetrievalResult(NamedTuple):
    """What a retrieval found; the maps are in their file."""

    maps: Path
    findings: list[Finding]
    echoes: xr.Dataset  # as they were when they were opened last


class Turn(NamedTuple):
    """Maps of one turn, and the echoes among which it was."""

    echoes: xr.Dataset
    maps: xr.DataTree


def retrieve_into(
    folder: Path,
    opened: Callable[[], xr.Dataset],
    settings: Changes,
    products: tuple[str, ...],
    *,
    wait_s: float = 0.0,
    wind_from_deg: float | None = None,
    even_if_wrong: bool = False,
    on_turn: Callable[[Turn], None] = lambda _: None,
) -> RetrievalResult:
    """Write maps.nc into a folder turn by turn.

    opened: opens the echoes; again for as long as they grow. settings: as of `retrieve`. products: files of an earlier
    retrieval that are removed first. wait_s: how long to wait for a further turn. on_turn: is given each turn. The
    first two turns are inspected before anything is written: InputError for what is surely wrong, unless even_if_wrong.
    """
    turns = iter(follow_turns(opened, settings, wait_s))
    first = list(islice(turns, _JUDGED))
    if not first:
        raise SchemaError("the echoes hold no complete turn; simulate or record at least one")
    findings = inspect(first[-1].echoes, joined([turn.maps for turn in first]), settings, wind_from_deg)
    wrong = [finding for finding in findings if finding.verdict == "wrong"]
    if wrong and not even_if_wrong:
        raise InputError(f"{wrong[0].line}; --even-if-wrong retrieves them as they are")
    clear_folder(folder, products)
    echoes, count = first[-1].echoes, 0
    with note_growing(folder, (MAPS,)), AppendableNetCDF(folder / MAPS) as file:
        for turn in (*first, *turns):
            file.append(turn.maps)
            on_turn(turn)
            echoes, count = turn.echoes, count + 1
    if count > len(first):
        with xr.open_datatree(folder / MAPS) as maps:
            findings = inspect(echoes, maps.load(), settings, wind_from_deg)
    return RetrievalResult(folder / MAPS, findings, echoes)


def follow_turns(
    opened: Callable[[], xr.Dataset],
    settings: Changes,
    wait_s: float = 0.0,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> Iterator[Turn]:
    """Each complete turn once, in order; ends after wait_s without a new one. A file that is just being written may be
    unreadable for a moment: while it is waited for, that is no error."""
    last, since = -1, clock()
    while True:
        echoes = None
        if wait_s:
            with suppress(InputError, SchemaError, OSError):
                echoes = opened()
            if echoes is None and clock() - since >= wait_s:
                echoes = opened()  # now it is one
        else:
            echoes = opened()
        if echoes is not None:
            for maps in retrieve_turns(echoes, settings, last):
                last = int(np.asarray(maps["polar"].to_dataset()["turn"].values)[-1])
                yield Turn(echoes, maps)
                since = clock()
        if clock() - since >= wait_s:
            return
        sleep(min(_POLL_S, wait_s))
