"""Which cells hold an echo of their own, and what is to be said of them: masks and CF flags from the echo alone."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import db
from ..dataset import QUALITY_FLAGS
from ..settings import RetrievalSettings
from .covariance import Covariance
from .description import RadarDescription
from .dwells import Dwells

_SHADOW_DB = 20.0  # a cell this far below its gate's median has no echo of its own, only its neighbours' skirts
_LOW_COHERENCE = 0.3
_PARTLY_SHADOWED_DB = 8.0
_SATURATED_SHARE = 0.01  # of a dwell's pulses


def gate_median(power: NDArray[np.float64], known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Median over the looks of each gate's known cells (1, gate); 0 where none is known."""
    median = np.zeros((1, power.shape[1]))
    some = known.any(axis=0)
    if some.any():
        median[0, some] = np.nanmedian(np.where(known, power, np.nan)[:, some], axis=0)
    return median


def has_echo(
    cells: Covariance, echo_power: NDArray[np.float64], radar: RadarDescription, settings: RetrievalSettings
) -> NDArray[np.bool_]:
    """Cells with an echo of their own: above the noise, and not merely the skirts of lit neighbours."""
    with np.errstate(invalid="ignore"):
        # A dead receiver leaves no cross term, whose angle would read as a flat sea.
        heard = np.isfinite(cells.cross) & (echo_power > 0.0) & (cells.lower > 0.0) & (cells.upper > 0.0)
        if radar.noise_power:
            heard &= db(np.maximum(echo_power, 0.0) / radar.noise_power) >= settings.min_snr_db
        typical = gate_median(echo_power, heard)
        return heard & (echo_power > typical * 10.0 ** (-_SHADOW_DB / 10.0))


def quality_flags(
    echoes: xr.Dataset,
    dwells: Dwells,
    cells: Covariance,
    heard: NDArray[np.bool_],
    echo_power: NDArray[np.float64],
    gain: NDArray[np.float64],
    height: NDArray[np.float64],
    radar: RadarDescription,
) -> NDArray[np.int16]:
    """CF flags of each cell, from the echo alone."""
    quality = np.zeros(heard.shape, dtype=np.int16)
    quality[~heard] |= QUALITY_FLAGS["no_echo"]
    with np.errstate(invalid="ignore"):
        quality[heard & (cells.coherence < _LOW_COHERENCE)] |= QUALITY_FLAGS["low_coherence"]
        # Half an ambiguity is π·gain. The sea's own size, as far as it shows, says where heights may lie beyond it.
        known = height[np.isfinite(height)]
        size = 1.4826 * np.median(np.abs(known - np.median(known))) if known.size else 0.0
        quality[heard & ((np.pi * gain < 3.0 * size) | ~np.isfinite(height))] |= QUALITY_FLAGS["ambiguous"]
        typical = gate_median(echo_power, heard)
        weak = echo_power < typical * 10.0 ** (-_PARTLY_SHADOWED_DB / 10.0)
        quality[heard & weak] |= QUALITY_FLAGS["partly_shadowed"]
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
    """What the radar itself says of its pulses, to all cells that they are part of."""
    flagged = np.flatnonzero(flags)
    look = dwells.look[flagged]
    look = look if dwells.leaning else look[:, None]
    gates = np.arange(quality.shape[1])
    for flag in np.unique(flags[flagged]):
        rows = look[flags[flagged] == flag]
        looks, gate = np.broadcast_arrays(rows, gates)
        inside = looks >= 0
        quality[looks[inside], gate[inside]] |= flag
