"""The scan: pulses that are missing, and an antenna that does not turn evenly."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..conventions import wrap_degrees
from .heights import Finding, judged

_MOST_MISSING = 0.01
_UNEVEN = 0.25  # of the beam's width, rms: as much blurs the map by 3 %
_TURNS = 2.0, 150.0  # a minute
_LEAST_PRF = 100.0  # Hz
_JUMP = 1.0  # beam widths


def scan(echoes: xr.Dataset) -> list[Finding]:
    """Of all turns; time and azimuth are read, voltages are not."""
    time, azimuth = (np.asarray(echoes[name].values, dtype=np.float64) for name in ("time", "azimuth"))
    turn = np.asarray(echoes["turn"].values)
    found = [_missing(echoes, time, turn)]
    if str(echoes.attrs.get("scan", "turning")) == "turning":
        found += [_speed(echoes), _evenness(echoes, time, azimuth, turn)]
    return found


def _speed(echoes: xr.Dataset) -> Finding:
    """Times in another unit than seconds make an antenna that no radar has."""
    rpm, rate = (float(echoes.attrs[name]) for name in ("rotation_rpm", "prf_hz"))
    least, most = _TURNS
    return judged(
        "speed of the scan",
        not least <= rpm <= most or rate < _LEAST_PRF,
        f"{rpm:.3g} turns a minute, {rate:.4g} pulses a second",
        "check that time is in seconds and azimuth in degrees, and rotation_rpm",
    )


def _missing(echoes: xr.Dataset, time: np.ndarray, turn: np.ndarray) -> Finding:
    """Against the pulses that the repetition frequency has room for, turn by turn."""
    wanted = held = 0.0
    longest = 0.0
    for number in np.unique(turn):
        here = np.sort(time[turn == number])
        if here.size > 1:
            wanted += (here[-1] - here[0]) * float(echoes.attrs["prf_hz"]) + 1.0
            held += here.size
            longest = max(longest, float(np.diff(here).max()))
    share = max(0.0, 1.0 - held / wanted) if wanted else 0.0
    share = share if share * wanted > 1.5 else 0.0  # the end of an interval is no pulse
    return judged(
        "missing pulses",
        share > _MOST_MISSING,
        f"{100.0 * share:.2g} % are missing, the longest gap is {1e3 * longest:.3g} ms" if share else "none",
        "pulses without a time, an azimuth or an attitude are left out; mend what reads them",
    )


def _evenness(echoes: xr.Dataset, time: np.ndarray, azimuth: np.ndarray, turn: np.ndarray) -> Finding:
    """Azimuths beside the straight line through each turn."""
    beam = float(echoes.attrs["azimuth_beamwidth_deg"])
    rate = 6.0 * float(echoes.attrs["rotation_rpm"])
    left, largest = [], 0.0
    for number in np.unique(turn):
        rows = np.flatnonzero(turn == number)
        if rows.size < 3:
            continue
        since = time[rows] - time[rows[0]]
        way = np.cumsum(np.concatenate(([0.0], wrap_degrees(np.diff(azimuth[rows]) - rate * np.diff(since)))))
        line = np.polynomial.Polynomial.fit(since, way, 1)
        left.append(way - line(since))
        largest = max(largest, float(np.abs(left[-1]).max()))
    if not left:
        return Finding("evenness of the scan", "unknown", "the turns hold too few pulses")
    rms = float(np.sqrt(np.mean(np.concatenate(left) ** 2)))
    return judged(
        "evenness of the scan",
        rms > _UNEVEN * beam or largest > _JUMP * beam,
        f"azimuths stray by {rms:.2g}° rms and {largest:.2g}° at most from even turns of {rate / 6.0:.4g} rpm",
        "maps follow the azimuths as given: if the antenna did turn evenly, mend the encoder's readings",
    )
