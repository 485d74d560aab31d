"""Turns of a recorded antenna, found from its azimuths: where each begins, and which are whole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..conventions import wrap_degrees
from ..errors import InputError
from ..io.recording_header import RecordingHeader

Array = NDArray[np.float64]

_SWING = 0.8  # of the antenna's rate, by which a boat may swing the boresight on or back
_ROUGH_DEG = 2.0  # what reading and noise of an azimuth may add to that
_RATE_ERROR = 0.2
_LONG_GAP = 3.0  # median steps of time; over longer ones it is not known how far the antenna turned
_ROUNDING = 1e-6  # deg
_DEGREES = "give degrees, if these are radians"


@dataclass(frozen=True)
class Turns:
    """The pulses that are kept, in their turns."""

    kept: NDArray[np.intp]  # rows (pulse,)
    number: NDArray[np.int32]  # (pulse,) of the turn, from 0
    rate: float  # deg/s
    sector: tuple[float, float]  # deg
    start: float  # s, when turn 0 begins


def turns_of(azimuth: Array, time: Array, head: RecordingHeader, turn: Array | None = None) -> Turns:
    """Turns of azimuths (pulse,) [deg clockwise from north] at times (pulse,) [s, increasing].

    turn (pulse,): their numbers, if they are known. A first and a last turn that do not cover the sector to within a
    beam's width are left out, unless partial_turns = 'keep'; one in the middle with pulses missing counts as whole.
    Raises InputError for azimuths that jump or do not turn clockwise, and where no turn is whole.
    """
    if azimuth.size == 0:
        raise InputError("azimuth: no pulse has one: must be known of some pulses that transmit; correct it")
    rate = _rate(azimuth, time, head)
    steps = np.diff(azimuth)
    steps = steps + 360.0 * np.round((rate * np.diff(time) - steps) / 360.0)
    _refuse_jumps(steps, rate * np.diff(time), azimuth, head)
    travelled = np.concatenate(([0.0], np.cumsum(steps)))
    sector = head.sector_deg
    if sector is None:
        if travelled[-1] < 360.0 - 2.0 * head.azimuth_beamwidth_deg:
            remedy = _DEGREES if _is_in_radians(azimuth) else "add it"
            raise InputError(
                f"sector_deg: is missing: the azimuths cover {travelled[-1]:.4g}°: must cover a full circle, or the "
                f"header say which sector is looked at; {remedy}"
            )
        sector = (float(azimuth[0]), float(azimuth[0]) + 360.0)
    width = sector[1] - sector[0]
    beside = 0.5 * (360.0 - width)  # what is received beyond the sector belongs to the turn that is nearer
    first = (azimuth[0] - sector[0] + beside + _ROUNDING) % 360.0 - beside - _ROUNDING
    sweep = first + travelled
    number = np.floor((sweep + beside + _ROUNDING) / 360.0) if turn is None else _check_turns(turn)
    number = np.maximum.accumulate(number).astype(np.int32)
    sweep = sweep - 360.0 * np.floor((sweep + beside + _ROUNDING) / 360.0)
    kept = np.arange(azimuth.size)
    if head.partial_turns == "drop":
        step = rate * float(np.median(np.diff(time))) if time.size > 1 else 0.0
        kept = _whole(number, sweep, width, max(head.azimuth_beamwidth_deg, 2.0 * step))
    start = float(time[kept[0]] - sweep[kept[0]] / rate)
    return Turns(kept, number[kept] - number[kept[0]], rate, sector, start)


def _rate(azimuth: Array, time: Array, head: RecordingHeader) -> float:
    """deg/s, the header's, which must agree with the azimuths, else theirs."""
    stated = None if head.rotation_rpm is None else 6.0 * head.rotation_rpm
    if azimuth.size < 2:
        if stated is None:
            raise InputError("rotation_rpm: is missing: must be given with a single pulse; add it to the header")
        return stated
    step = np.diff(time)
    near = step <= _LONG_GAP * np.median(step)
    # An encoder's counts are coarse and many pulses share one: only the sum of their steps tells the rate.
    rate = float(wrap_degrees(np.diff(azimuth))[near].sum() / step[near].sum())
    if rate <= 0.0:
        raise InputError(
            f"azimuth: turns at {rate:.4g} deg/s: must turn clockwise; set encoder_clockwise = false if the encoder "
            "counts the other way"
        )
    if stated is not None and abs(rate / stated - 1.0) > _RATE_ERROR and rate * step.sum() > 10.0 * _ROUGH_DEG:
        raise InputError(
            f"rotation_rpm = {head.rotation_rpm:g}: must agree with the azimuths, which turn at {rate / 6.0:.4g} rpm; "
            "correct either, or encoder_counts"
        )
    return rate if stated is None else stated


def _is_in_radians(azimuth: Array) -> bool:
    return float(np.ptp(azimuth)) <= 2.0 * np.pi


def _refuse_jumps(steps: Array, expected: Array, azimuth: Array, head: RecordingHeader) -> None:
    count = 0.0 if head.encoder_counts is None else 720.0 / head.encoder_counts
    bad = np.flatnonzero(np.abs(steps - expected) > _SWING * expected + _ROUGH_DEG + count)
    if bad.size:
        here = int(bad[0])
        remedy = _DEGREES if _is_in_radians(azimuth) else "sort the pulses by time, or mend the encoder's readings"
        raise InputError(
            f"azimuth: jumps by {steps[here]:.4g}° from one pulse's {azimuth[here]:.6g}° to the next one's "
            f"{azimuth[here + 1]:.6g}°: must go on by about {expected[here]:.4g}°; {remedy}"
        )


def _check_turns(turn: Array) -> Array:
    if not np.isfinite(turn).all() or (np.diff(turn) < 0.0).any():
        raise InputError("turn: must be whole numbers that never decrease; sort the pulses by time, or leave turn out")
    return turn


def _whole(number: NDArray[np.int32], sweep: Array, width: float, slack: float) -> NDArray[np.intp]:
    """Rows of the pulses without a first and a last turn that are not whole."""
    kept = np.ones(number.size, dtype=bool)
    for turn in dict.fromkeys((int(number[0]), int(number[-1]))):
        members = number == turn
        kept[members] = sweep[members].min() <= slack and sweep[members].max() >= width - slack
    if not kept.any():
        raise InputError(
            f"azimuth: no turn covers the sector's {width:g}°: must hold one whole turn; record longer, or set "
            "partial_turns = 'keep'"
        )
    return np.flatnonzero(kept)
