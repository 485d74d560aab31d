"""The voltages of a turn: gaps, balance of the receivers, saturation, what they have in common, power by range."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import db
from ..dataset import QUALITY_FLAGS
from .heights import Finding, judged

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
    """Of one turn's echoes, voltages loaded, and the polar maps of it."""
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
    """Of strong echoes, which noise does not decorrelate, in the best ring: near by a long baseline does."""
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
    edges = np.quantile(out, np.linspace(0.0, 1.0, _RINGS + 1))
    ring = np.clip(np.searchsorted(edges, out, "right") - 1, 0, _RINGS - 1)
    far = [each for each in range(_RINGS // 4, _RINGS) if np.count_nonzero(ring == each) >= _FEWEST_CELLS // _RINGS]
    middle = {each: float(np.median(level[ring == each])) for each in far}
    far = [each for each in far if middle[each] > _CLEAR_DB]  # near the noise what is detected is what it lifts
    where = np.array([np.median(out[ring == each]) for each in far])
    if where.size < 3 or 10.0 ** float(np.ptp(where)) < _LEAST_SPAN:
        return Finding(what, "unknown", "the echoes span too little range")
    exponent = float(np.polyfit(where, np.array([middle[each] for each in far]) / 10.0, 1)[0])
    return judged(
        what,
        exponent > _FLATTEST,
        f"the echoes fall with the power {exponent:.1f} of range".replace("-", "−"),
        "check that gain does not follow the range and that the receiver is linear; snr_db and error bars rest on it",
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"
