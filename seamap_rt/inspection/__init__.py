"""What echoes and the maps made of them say of themselves: whether the radar was as its description has it.

Nothing here knows the sea. What is surely wrong (the sign of the phase, receivers that have nothing in common, waves
that run backwards) is kept apart from what probably is, and from what this data cannot tell.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..dataset import check, group_of
from ..interferometry import open_echoes, retrieve
from ..interferometry.checks import settings_of
from ..settings import RetrievalSettings
from .findings import Finding, heights, scan, signal
from .level import Level, offsets, sign
from .motion import motion
from .receivers import receivers, transmitter

_ORDER = ("wrong", "doubtful", "good", "unknown")


def inspect(
    echoes: xr.Dataset | str | Path,
    maps: xr.DataTree | None = None,
    settings: RetrievalSettings | Mapping[str, Any] | None = None,
    wind_from_deg: float | None = None,
) -> list[Finding]:
    """Findings on echoes and their maps, the gravest first.

    echoes: that keep the schema, or the path of a store. maps: as `retrieve` makes them of these echoes by the same
    settings; made here if left out. settings: as of `retrieve`. wind_from_deg: deg clockwise from north, where it is
    known. Voltages are judged by the first turn, all else by all turns. Raises SchemaError for echoes that cannot be
    retrieved.
    """
    if not isinstance(echoes, xr.Dataset):
        echoes = open_echoes(echoes)
    check("echoes", echoes)
    settings = settings_of(echoes, settings)
    maps = retrieve(echoes, settings) if maps is None else maps
    polar = group_of(maps, "maps/polar")
    rows = np.flatnonzero(np.asarray(echoes["turn"].values) == int(polar["turn"].values[0]))
    first = echoes.isel(pulse=slice(int(rows[0]), int(rows[-1]) + 1)).load()
    level = Level.of(polar.isel(turn=[0]))
    paths = int(polar.attrs.get("paths", 1))
    phase = sign(first, settings, level)
    level_says = offsets(echoes, Level.of(polar), paths) if phase.verdict != "wrong" else []
    if phase.verdict == "doubtful" and any(each.verdict == "doubtful" for each in level_says):
        phase = phase._replace(verdict="unknown", remedy="mend what is doubtful first")
    findings = [  # of the wrong sign there is no level that could tell more
        receivers(first),
        *level_says,
        phase,
        *heights(polar, float(echoes.attrs["height_m"])),
        *signal(first, polar.isel(turn=[0])),
        transmitter(first),
        *scan(echoes),
        *motion(maps, wind_from_deg),
    ]
    return sorted(findings, key=lambda finding: _ORDER.index(finding.verdict))


__all__ = ["Finding", "Level", "inspect"]
