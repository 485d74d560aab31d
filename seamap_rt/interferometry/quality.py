"""Which cells hold an echo of their own, and their flags: masks and CF flags from the echo alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..conventions import db
from ..dataset import QUALITY_FLAGS
from ..radar.waveform import RangeResponse
from ..settings import RetrievalSettings
from .description import RadarDescription
from .dwells import Dwells
from .windows import Covariance

if TYPE_CHECKING:
    import xarray as xr


_SIDELOBES_DB = 40.0  # below a gate's strongest echo: what lies deeper may come in by the antenna's two-way sidelobes
_MORE = 1.05  # than a skirt, whose beam is not quite Gaussian
_SKIRT_LEAST = 1e-4  # of a neighbour's power: fainter skirts than the sidelobes are not tested
_OBJECT_RATIO = 100.0  # of an object's echo to the sea's
_OBJECT_CELLS = 0.06  # share of the cells of a level that objects may hold
_DISTURBED = 0.01  # share of a cell's power, from which on an object's skirt disturbs it
_TREND_GATES = 10  # to either side, pooled: enough cells for a level even in a single look
_TREND_STEP = 8  # gates from one level to the next; between them it is interpolated
_FALSE_ALARM = 1e-3  # of two receivers without a common signal
_PARTLY_SHADOWED = 0.5  # of the cell's area in sight
_SATURATED_SHARE = 0.01  # of a dwell's pulses


def gate_median(power: NDArray[np.float64], known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Median over the looks of each gate's known cells (1, gate); 0 where none is known."""
    in_order = np.sort(np.where(known, power, np.inf).T, axis=1)
    count = np.count_nonzero(known, axis=0)
    middle = np.take_along_axis(in_order, np.stack((np.maximum(count - 1, 0) // 2, count // 2), axis=1), axis=1)
    return np.where(count > 0, middle.mean(axis=1), 0.0)[None]


def lit_power(power: NDArray[np.float64], ranges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Echo power (1, gate) [W] that a lit cell of each gate has, however many of its cells lie in shadow.

    power (look, gate): without noise, of any sign, NaN where unknown. The median weighted by amplitude, in which dark
    cells do not count, of 21 gates' cells of all looks, each brought to the middle gate's range by R⁻³. Objects, a
    hundred times as strong as the sea and a twentieth of the cells at most, are left out. 0 where no cell has an echo.
    Of speckle of mean power T it is 1.18 T.
    """
    gates = ranges.size
    middles = np.unique(np.append(np.arange(0, gates, _TREND_STEP), gates - 1))
    spreading = np.where(np.isfinite(power) & (power > 0.0), power, 0.0) * ranges**3
    levels = np.zeros(middles.size)
    for n, middle in enumerate(middles):
        reach = min(_TREND_GATES, max(middle, 4), max(gates - 1 - middle, 4))  # as far on both sides
        pooled = np.sort(spreading[:, max(middle - reach, 0) : middle + reach + 1], axis=None)
        count = _OBJECT_CELLS * pooled.size
        ordinary = pooled.size - 1 - int(max(0.0, count - np.sqrt(count)))  # of few cells more may be lit
        pooled = pooled[: np.searchsorted(pooled, _OBJECT_RATIO * pooled[ordinary], "right")] if pooled.size else pooled
        amount = np.cumsum(np.sqrt(pooled))
        levels[n] = pooled[min(np.searchsorted(amount, 0.5 * amount[-1]), pooled.size - 1)] if amount.size else 0.0
    heard = levels > 0.0
    if not heard.any():
        return np.zeros((1, gates))
    return np.exp(np.interp(np.log(ranges), np.log(ranges[middles[heard]]), np.log(levels[heard])))[None] / ranges**3


def own_echo(
    power: NDArray[np.float64], response: RangeResponse, spacing: tuple[float, float], beamwidth_deg: float
) -> NDArray[np.bool_]:
    """Cells with more power than the skirts of any neighbour's echo bring there: the others have no echo of their own.

    power (look, gate): of a dwell, without noise, not averaged over gates. spacing: of looks [deg] and of gates [m];
    beamwidth_deg: one-way, −3 dB. The two gates beside a cell belong to it, as do all that the pulse does not
    separate from it: 3 m cells overlap.
    """
    bright = np.where(np.isfinite(power) & (power > 0.0), power, 0.0)
    return bright > _MORE * _skirts(bright, response, spacing, beamwidth_deg)


def object_echo(power: NDArray[np.float64], level: NDArray[np.float64], *beam: Any) -> NDArray[np.bool_]:
    """Cells with an object's echo: a hundred times the level (1, gate) [W] of the sea and the noise, or a hundredth of
    whose power may be the skirt of such a cell. beam: what else `own_echo` asks for.

    Of a sea as spiky as any (K distribution of shape ½: P(x) = exp(−√(2x)) of x times the mean) one cell in a million
    is as strong.
    """
    bright = np.where(np.isfinite(power) & (power > 0.0), power, 0.0)
    strong = bright > _OBJECT_RATIO * level
    if not strong.any():
        return strong
    return strong | (_skirts(np.where(strong, bright, 0.0), *beam, same=True) > _DISTURBED * bright)


def _skirts(
    bright: NDArray[np.float64], response: RangeResponse, spacing: tuple[float, float], beam: float, same: bool = False
) -> NDArray[np.float64]:
    """Most power [W] (look, gate) that a neighbour's echo brings to a cell; same: gates that share its cell count."""
    skirts = np.zeros_like(bright)
    looks, gates = bright.shape
    along, across = _range_skirts(response, spacing[1], gates), _beam_skirts(spacing[0], beam, looks)
    for look, aside in enumerate(across):
        for gate, pulse in enumerate(along):
            level = aside * pulse
            if (look == 0 and not same and (gate < 2 or level > 0.5)) or level < _SKIRT_LEAST:
                continue
            for far, near in (((0, look), (look, 0)), ((look, 0), (0, look))):
                for there, here in (((0, gate), (gate, 0)), ((gate, 0), (0, gate))):
                    source = bright[far[0] : looks - far[1], there[0] : gates - there[1]]
                    target = skirts[near[0] : looks - near[1], here[0] : gates - here[1]]
                    np.maximum(target, level * source, out=target)
    return skirts


def _range_skirts(response: RangeResponse, spacing: float, gates: int) -> NDArray[np.float64]:
    """Power that a reflector in the middle of a gate leaves 0, 1, 2 … gates on, over that in its own."""
    count = min(gates, int(response.reach_m / spacing) + 1)
    skirts = (response(spacing * np.arange(count)) / response(0.0)) ** 2
    return skirts[: 1 + int(np.flatnonzero(skirts >= _SKIRT_LEAST)[-1])]


def _beam_skirts(spacing_deg: float, beamwidth_deg: float, looks: int) -> NDArray[np.float64]:
    """Power that a reflector in the middle of a look leaves 0, 1, 2 … looks on: a dwell's mean of a Gaussian beam."""
    count = min(looks, 2 + int(2.0 * beamwidth_deg / spacing_deg))
    aside = spacing_deg * (np.arange(count)[:, None] + np.linspace(-0.5, 0.5, 41))
    skirts = np.exp(-8.0 * np.log(2.0) * (aside / beamwidth_deg) ** 2).mean(axis=1)
    return skirts / skirts[0]


def has_echo(
    cells: Covariance, echo_power: NDArray[np.float64], noise_power: float, settings: RetrievalSettings
) -> NDArray[np.bool_]:
    """Cells in which both receivers hear an echo above the noise and the antenna's sidelobes."""
    with np.errstate(invalid="ignore"):
        # A receiver without signal leaves no cross term, whose angle would read as a flat sea.
        heard = np.isfinite(cells.cross) & (echo_power > 0.0) & (cells.lower > 0.0) & (cells.upper > 0.0)
        if noise_power:
            heard &= db(np.maximum(echo_power, 0.0) / noise_power) >= settings.min_snr_db
        strongest = np.max(echo_power, axis=0, where=heard, initial=0.0)
        return heard & (echo_power > strongest * 10.0 ** (-_SIDELOBES_DB / 10.0))


def least_coherence(samples: ArrayLike) -> NDArray[np.float64]:
    """Sample coherence that two receivers which hear nothing in common exceed once in a thousand cells.

    samples: independent ones in a cell. Of none in common P(|γ| > t) = (1 − t²)^(n − 1) (Touzi et al., IEEE Trans.
    Geosci. Remote Sens. 37(1), 135–149, 1999). 0 below two samples: one is always coherent.
    """
    number = np.asarray(samples, dtype=np.float64)
    return np.where(number < 2.0, 0.0, np.sqrt(1.0 - _FALSE_ALARM ** (1.0 / (np.maximum(number, 2.0) - 1.0))))


def quality_flags(
    echoes: xr.Dataset,
    dwells: Dwells,
    cells: Covariance,
    heard: NDArray[np.bool_],
    gain: NDArray[np.float64],
    height: NDArray[np.float64],
    radar: RadarDescription,
    ambiguous: NDArray[np.bool_] | None = None,
    visible_share: NDArray[np.float64] | None = None,
    samples: float | None = None,
) -> NDArray[np.int16]:
    """CF flags of each cell, from the echo alone.

    ambiguous: cells of which unwrapping did not find the cycle; where it was not run, those in which the sea's own
    size exceeds half an ambiguity. visible_share: as `shadow` gives it. samples: independent ones of noise in a
    cell, by default its pulses. An antenna under water (`submerged`) is known to the radar, which flags it pulse by
    pulse in the echoes' `flag`.
    """
    quality = np.zeros(heard.shape, dtype=np.int16)
    quality[~heard] |= QUALITY_FLAGS["no_echo"]
    with np.errstate(invalid="ignore"):
        least = least_coherence(dwells.pulses if samples is None else samples)
        quality[heard & (cells.coherence < least)] |= QUALITY_FLAGS["low_coherence"]
        if ambiguous is None:
            # Half an ambiguity is π·gain. The sea's own size, as far as it shows, says where heights may lie beyond it.
            known = height[np.isfinite(height)]
            size = 1.4826 * np.median(np.abs(known - np.median(known))) if known.size else 0.0
            ambiguous = np.pi * gain < 3.0 * size
        quality[heard & (ambiguous | ~np.isfinite(height))] |= QUALITY_FLAGS["ambiguous"]
        if visible_share is not None:
            quality[heard & (visible_share < _PARTLY_SHADOWED)] |= QUALITY_FLAGS["partly_shadowed"]
    quality[:, radar.blind] |= QUALITY_FLAGS["blind"]
    if "saturated" in echoes:
        clipped = np.asarray(echoes["saturated"].values) > 0
        with np.errstate(invalid="ignore", divide="ignore"):
            share = dwells.sums(clipped.astype(np.float64)) / dwells.pulses
        quality[share > _SATURATED_SHARE] |= QUALITY_FLAGS["saturated"]
    if "flag" in echoes:
        _add_pulse_flags(quality, np.asarray(echoes["flag"].values), dwells)
    return quality


def _add_pulse_flags(quality: NDArray[np.int16], flags: NDArray[np.int16], dwells: Dwells) -> None:
    """Flags that the radar gives its pulses, for all cells that they are part of."""
    flagged = np.flatnonzero(flags)
    look = dwells.look[flagged]
    look = look if dwells.leaning else look[:, None]
    gates = np.arange(quality.shape[1])
    for flag in np.unique(flags[flagged]):
        rows = look[flags[flagged] == flag]
        looks, gate = np.broadcast_arrays(rows, gates)
        inside = looks >= 0
        quality[looks[inside], gate[inside]] |= flag
