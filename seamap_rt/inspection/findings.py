"""What a finding is; and those on the heights themselves, on the scan (missing pulses, an uneven turn), and
on a turn's voltages (gaps, balance, saturation, what the receivers have in common, power by range)."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import db, wrap_degrees
from ..dataset import QUALITY_FLAGS

Verdict = Literal["good", "doubtful", "wrong", "unknown"]


class Finding(NamedTuple):
    """A finding on one thing. "wrong" is sure, "doubtful" probable; "unknown" cannot be found from this data."""

    what: str
    verdict: Verdict
    says: str  # with the figure that it rests on
    remedy: str = ""

    @property
    def line(self) -> str:
        return f"{self.what}: {self.says}{f'; {self.remedy}' if self.remedy else ''}"


def judged(what: str, doubtful: bool, says: str, remedy: str) -> Finding:
    """A finding that is good, or doubtful and has a remedy."""
    return Finding(what, "doubtful", says, remedy) if doubtful else Finding(what, "good", says)


def rings(distance: NDArray[np.float64], count: int) -> NDArray[np.intp]:
    """Number of the ring of each cell (n,), of so many rings of equally many cells by distance."""
    edges = np.quantile(distance, np.linspace(0.0, 1.0, count + 1))
    return np.clip(np.searchsorted(edges, distance, "right") - 1, 0, count - 1)


_FEWEST = 0.05  # of the cells
_STEEPEST = 0.5  # of the mast's height, by the waves' standard deviation: as high a sea washes over the antenna


def heights(polar: xr.Dataset, mast: float) -> list[Finding]:
    """Findings on the heights of polar maps. mast: height of the antennas, m."""
    height = polar["height"].values
    known = np.isfinite(height)
    share = float(known.mean())
    flags = polar["quality"].values
    why = {name: float(np.mean((flags & bit) != 0)) for name, bit in QUALITY_FLAGS.items()}
    worst = max(why, key=lambda name: why[name])
    answered = judged(
        "cells",
        share < _FEWEST,
        f"{100.0 * share:.2g} % hold a height"
        + (f", {100.0 * why[worst]:.0f} % are flagged {worst}" if share < 1.0 else ""),
        "look whether the echoes stand clear of the noise, and of what stands still",
    )
    if not known.any():
        return [answered]
    middle = np.median(height[known])
    spread = 1.4826 * float(np.median(np.abs(height[known] - middle)))
    return [
        answered,
        judged(
            "heights",
            spread > _STEEPEST * mast,
            f"they scatter by {spread:.2f} m (of a standard deviation) under a mast of {mast:.3g} m",
            "no such sea leaves it dry: check baseline_m, frequency_hz, gate_m, first_gate_m and phase_offset_deg",
        ),
    ]


_MOST_MISSING = 0.01
_UNEVEN = 0.25  # of the beam's width, rms: as much blurs the map by 3 %
_TURNS = 2.0, 150.0  # a minute
_LEAST_PRF = 100.0  # Hz
_JUMP = 1.0  # beam widths


def scan(echoes: xr.Dataset) -> list[Finding]:
    """Findings on the scan of all turns; time and azimuth are read, voltages are not."""
    time, azimuth = (np.asarray(echoes[name].values, dtype=np.float64) for name in ("time", "azimuth"))
    turn = np.asarray(echoes["turn"].values)
    missing = _missing(echoes, time, turn)
    if str(echoes.attrs.get("scan", "turning")) != "turning":
        return [missing]
    rpm, rate = (float(echoes.attrs[name]) for name in ("rotation_rpm", "prf_hz"))
    speed = judged(  # times in another unit than seconds make an antenna that no radar has
        "speed of the scan",
        not _TURNS[0] <= rpm <= _TURNS[1] or rate < _LEAST_PRF,
        f"{rpm:.3g} turns a minute, {rate:.4g} pulses a second",
        "check that time is in seconds and azimuth in degrees, and rotation_rpm",
    )
    return [missing, speed, _evenness(echoes, time, azimuth, turn)]


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


Array = NDArray[np.float64]

_MOST_GAPS = 0.01
_MOST_IMBALANCE_DB = 3.0
_MOST_SATURATED = 0.01
_STRONG_DB, _CLEAR_DB = 10.0, 5.0
_FEWEST_CELLS = 100
_LEAST_COHERENCE, _NO_COHERENCE = 0.5, 0.15  # of strong echoes, in the range where they have most
_RINGS = 8
# Power of range by which the echo of lit water falls: −3 of a cell as wide as the beam with an even σ0, which falls
# itself; steep waves that face the radar make it −2. Gain that follows the range and logarithms make it flatter.
_FLATTEST = -1.5
_LEAST_SPAN = 1.5  # ratio of the ranges that a power law is fitted to


def signal(turn: xr.Dataset, polar: xr.Dataset) -> list[Finding]:
    """Findings on one turn's echoes, voltages loaded, and its polar maps."""
    voltage = turn["voltage"].values
    finite = np.isfinite(voltage)
    power = np.real(voltage).astype(np.float64) ** 2 + np.imag(voltage).astype(np.float64) ** 2
    return [
        _gaps(finite, turn),
        _balance(power, finite, float(turn.attrs["noise_power_w"])),
        _saturation(turn, polar),
        _coherence(polar),
        _fall(polar),
    ]


def _gaps(finite: NDArray[np.bool_], turn: xr.Dataset) -> Finding:
    """Voltages that are no numbers, of pulses and receivers that were to be sampled."""
    sampled = finite.any(axis=2)
    alternating = turn.attrs["interferogram"] == "alternating_pulse"
    wanted = 0.5 * sampled.size if alternating else float(sampled.size)
    missing = max(0.0, 1.0 - finite.sum() / max(1.0, wanted * finite.shape[2]))
    return judged(
        "voltages",
        missing > _MOST_GAPS,
        f"{_percent(missing)} are no numbers" if missing else "all are numbers",
        "look what the recorder wrote; cells without pulses stay empty",
    )


def _balance(power: Array, finite: NDArray[np.bool_], noise: float) -> Finding:
    totals = [np.where(finite[:, each], power[:, each], 0.0).sum() for each in (0, 1)]
    counts = [max(1, np.count_nonzero(finite[:, each])) for each in (0, 1)]
    echo = [max(total / count - noise, 0.0) for total, count in zip(totals, counts, strict=True)]
    if min(echo) <= 0.05 * noise or min(echo) <= 0.0:
        return Finding("receivers' balance", "unknown", "there is too little echo over the noise")
    ratio = float(db(echo[1] / echo[0]))
    return judged(
        "receivers' balance",
        abs(ratio) > _MOST_IMBALANCE_DB,
        f"the upper receiver holds {ratio:+.1f} dB of the lower one's power",
        "check cables and gains; a deaf receiver makes the phase noisier, not wrong",
    )


def _saturation(turn: xr.Dataset, polar: xr.Dataset) -> Finding:
    if "saturated" not in turn:
        return Finding("saturation", "good", "no converter is said to be at its limit")
    share = float(np.mean((polar["quality"].values & QUALITY_FLAGS["saturated"]) != 0))
    return judged(
        "saturation",
        share > _MOST_SATURATED,
        f"{_percent(share)} of the cells hold saturated samples",
        "lower the gain; their heights are biased",
    )


def _coherence(polar: xr.Dataset) -> Finding:
    """Coherence of strong echoes, which noise does not decorrelate, in the best ring: near by a long baseline does."""
    what = "coherence of the receivers"
    coherence, snr, distance = (polar[name].values for name in ("coherence", "snr_db", "ground_range"))
    strong = np.isfinite(coherence) & np.isfinite(distance) & (np.isnan(snr) | (snr > _STRONG_DB))
    if np.count_nonzero(strong) < _FEWEST_CELLS:
        return Finding(what, "unknown", f"too few cells echo by {_STRONG_DB:.0f} dB over the noise")
    parts = np.array_split(coherence[strong][np.argsort(distance[strong])], _RINGS)
    best = max(float(np.median(part)) for part in parts if part.size)
    says = f"{best:.2f} where strong echoes have most of it"
    if best < _NO_COHERENCE:
        remedy = "give two receivers that sample the same pulses of the same antennas' echo, as lower and upper"
        return Finding(what, "wrong", f"{says}: they have nothing in common", remedy)
    return judged(what, best < _LEAST_COHERENCE, says, "check that both sample at one instant and from one oscillator")


def _fall(polar: xr.Dataset) -> Finding:
    """How the echoes fall with range, near enough to stand clear of the noise."""
    what = "power by range"
    snr, distance = (polar[name].values.astype(np.float64) for name in ("snr_db", "ground_range"))
    known = np.isfinite(snr) & (distance > 0.0)
    if np.count_nonzero(known) < _FEWEST_CELLS:
        return Finding(what, "unknown", "too few cells echo over a known noise")
    level, out = snr[known], np.log10(distance[known])
    ring = rings(out, _RINGS)
    parts = [ring == each for each in range(_RINGS // 4, _RINGS)]
    parts = [part for part in parts if np.count_nonzero(part) >= _FEWEST_CELLS // _RINGS]
    middles = [(np.median(out[part]), np.median(level[part])) for part in parts]
    clear = np.array([each for each in middles if each[1] > _CLEAR_DB])  # near the noise it lifts what is detected
    if len(clear) < 3 or 10.0 ** float(np.ptp(clear[:, 0])) < _LEAST_SPAN:
        return Finding(what, "unknown", "the echoes span too little range")
    exponent = float(np.polyfit(clear[:, 0], clear[:, 1] / 10.0, 1)[0])
    return judged(
        what,
        exponent > _FLATTEST,
        f"the echoes fall with the power {exponent:.1f} of range".replace("-", "−"),
        "check that gain does not follow the range and that the receiver is linear; snr_db and error bars rest on it",
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"
