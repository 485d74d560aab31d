"""Datasets → the few numbers that are drawn. Missing values are left out; NaN where none is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..conventions import db, wrap_degrees
from ..metrics import headline_band, headline_gates
from ..scene import Scene
from ..sea import WaveFacts, wave_facts
from ..settings import SinusoidWaves, WaveSystem

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

SECTOR_HALF_WIDTH_DEG = 22.5
MAD_TO_STD = 1.4826  # of a normal distribution


# ------------------------------------------------------------------------------------------------ plain numbers


def number(value: Any) -> float:
    """A float; NaN for what is missing or not a number."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return float("nan")


def series(values: Any, size: int | None = None) -> Array:
    """A list with nulls as an array with NaN; all NaN when it is missing or not `size` long."""
    array = np.array([number(value) for value in values] if isinstance(values, Sequence | np.ndarray) else [])
    if size is not None and array.size != size:
        return np.full(size, np.nan)
    return array.astype(np.float64)


def mean(values: NDArray[Any], axis: int | tuple[int, ...] | None = None) -> Array:
    """Mean of the finite values; NaN where there are none."""
    return np.ma.filled(np.ma.masked_invalid(values).mean(axis=axis, dtype=np.float64), np.nan)


def quantile(values: NDArray[Any], share: float) -> float:
    """Quantile of the finite values; NaN if there are none."""
    finite = values[np.isfinite(values)]
    return float(np.quantile(finite, share)) if finite.size else float("nan")


# ------------------------------------------------------------------------------------------------------ geometry


def edges(centres: ArrayLike, only: float = 1.0) -> Array:
    """Edges halfway between rising centres; one centre gets a cell of width `only`."""
    centres = np.asarray(centres, dtype=np.float64)
    if centres.size == 1:
        return np.array([centres[0] - 0.5 * only, centres[0] + 0.5 * only])
    middle = 0.5 * (centres[1:] + centres[:-1])
    return np.concatenate(([2.0 * centres[0] - middle[0]], middle, [2.0 * centres[-1] - middle[-1]]))


def look_edges(azimuth_deg: ArrayLike, only: float) -> tuple[NDArray[np.int64], Array]:
    """Order of the looks as they follow each other clockwise, and their edges in that order, never wrapped [deg].

    The start is behind the widest gap, so that a sector across north stays one piece.
    """
    azimuth = np.asarray(azimuth_deg, dtype=np.float64) % 360.0
    order = np.argsort(azimuth)
    gap = np.diff(azimuth[order], append=azimuth[order[0]] + 360.0)
    if azimuth.size > 1 and np.ptp(gap) > 0.5 * np.median(gap):
        order = np.roll(order, -int(np.argmax(gap)) - 1)
    onward = np.diff(azimuth[order]) % 360.0
    return order, edges(azimuth[order[0]] + np.concatenate(([0.0], np.cumsum(onward))), only)


def near_azimuth(azimuth_deg: ArrayLike, centre_deg: float) -> NDArray[np.bool_]:
    """Which looks lie within ±22.5° of an azimuth."""
    return np.abs(wrap_degrees(np.asarray(azimuth_deg) - centre_deg)) <= SECTOR_HALF_WIDTH_DEG


def main_waves(scene: Scene) -> WaveFacts | None:
    """The highest of the wave systems; None without waves."""
    systems = [wave_facts(waves, scene.sea.depth_m) for waves in scene.sea.waves]
    return max((waves for waves in systems if waves is not None), key=lambda waves: waves.height, default=None)


def describe_waves(waves: WaveSystem, depth: float) -> str:
    """A wave system in a few words."""
    facts = wave_facts(waves, depth)
    if facts is None:
        return "no waves"
    if isinstance(waves, SinusoidWaves):
        size = f"{waves.height_m:.3g} m high, {waves.wavelength_m:.3g} m long"
    else:
        size = f"Hs {facts.height:.3g} m, Tp {facts.peak_period:.3g} s"
    return f"waves from {facts.from_deg:.4g}°, {size}"


# ---------------------------------------------------------------------------------------------------- the datasets


def polar(tree: xr.DataTree, name: str) -> Array:
    """A polar variable as an array (turn, azimuth, range)."""
    return np.asarray(tree["polar"].dataset[name].values, dtype=np.float64)


def coordinate(tree: xr.DataTree, group: str, name: str) -> Array:
    return np.asarray(tree[group].dataset[name].values, dtype=np.float64)


def judged_gates(tree: xr.DataTree) -> NDArray[np.bool_]:
    """Gates between 50 and 200 m."""
    return headline_gates(coordinate(tree, "polar", "range"))


def judged_band(tree: xr.DataTree) -> str:
    """The share of 50 to 200 m that the maps hold, in words."""
    band = headline_band(coordinate(tree, "polar", "range"))
    return f"{band[0]:.0f}–{band[1]:.0f} m" if band else "50–200 m, where the maps hold nothing"


def visible(metrics: Mapping[str, Any]) -> tuple[Array, list[Mapping[str, Any]]]:
    """Ground ranges [m] and curves of `visible` in the metrics, light first; none where they do not say."""
    entry = metrics.get("visible")
    return (series(entry.get("range_m")), list(entry["curves"])) if isinstance(entry, Mapping) else (np.array([]), [])


def half_visible_in_words(metrics: Mapping[str, Any]) -> str:
    """The range to which half of the sea is visible to the radar in its own polarization, and to light."""
    entry, (_, curves) = metrics.get("visible"), visible(metrics)
    if not isinstance(entry, Mapping):
        return "— (light)"
    own = {each["sees"]: each["half_visible_m"] for each in curves if each["level_db"] in (0.0, entry["seen_db"])}
    far = [(name, own.get(name)) for name in (entry["polarization"], "light")]
    return ", ".join(f"{'—' if half is None else f'{half:.0f} m'} ({name})" for name, half in far)


def mean_power(echoes: xr.Dataset, azimuth_deg: ArrayLike, turn: int, only: float) -> tuple[Array, Array]:
    """Mean of |V|² [W] per look and gate of one turn, over its pulses and receivers; with the looks' edges [deg].

    The looks are in the order of `look_edges`; one look alone is `only` degrees wide.
    """
    order, borders = look_edges(azimuth_deg, only)
    power = np.full((order.size, echoes.sizes["range"]), np.nan)
    pulse = np.flatnonzero(echoes["turn"].values == turn)
    if pulse.size == 0:
        return power, borders
    span = slice(int(pulse[0]), int(pulse[-1]) + 1)
    voltage: NDArray[np.complex64] = echoes["voltage"].isel(pulse=span).values[pulse - pulse[0]]
    sweep = (echoes["azimuth"].values[pulse] - borders[0] + 1e-9) % 360.0  # a pulse on an edge opens its look
    look = np.searchsorted(borders - borders[0], sweep, side="right") - 1
    sampled = np.isfinite(voltage[:, :, 0])  # a receiver samples a whole pulse or none of it
    for index in range(order.size):
        of_look = voltage[look == index][sampled[look == index]]
        if of_look.size:
            power[index] = mean(of_look.real**2 + of_look.imag**2, axis=0)
    return power, borders


def power_db(power: Array, noise_power_w: float) -> Array:
    """Power in dB over the noise, or over 1 W where no noise was added; NaN where there is none."""
    level = db(np.where(power > 0.0, power, np.nan) / (noise_power_w if noise_power_w > 0.0 else 1.0))
    return np.where(np.isfinite(level), level, np.nan)
