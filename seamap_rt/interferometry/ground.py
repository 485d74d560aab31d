"""The map on the ground: each look's cells are laid where their own heights put them, then sampled on a square grid.

From a boat at rest a look's cells lie on a straight line. Those of a boat that moves or rolls do not: they are laid by
their azimuth and distance from one centre, first along each look and then across the looks.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..radar.grid import LookFan

_FINER = 3  # looks for one; coarser ones would blur waves across the looks


def resample_looks(
    ground_range: NDArray[np.float64],
    fields: dict[str, NDArray[np.float64]],
    distance: NDArray[np.float64],
    widest_gap: float,
) -> dict[str, NDArray[np.float64]]:
    """Fields (look, gate) at equal ground ranges (look, distance): linear between valid cells, NaN across gaps.

    Cells are sorted by ground range first: on a steep face a nearer gate can lie further out.
    """
    out = {name: np.full((ground_range.shape[0], distance.size), np.nan) for name in fields}
    for look, places in enumerate(ground_range):
        valid = np.isfinite(places)
        if np.count_nonzero(valid) < 2:
            continue
        order = np.flatnonzero(valid)[np.argsort(places[valid], kind="stable")]
        known = places[order]
        after = np.clip(np.searchsorted(known, distance), 1, known.size - 1)
        inside = (distance >= known[0]) & (distance <= known[-1])
        inside &= known[after] - known[after - 1] <= widest_gap
        for name, field in fields.items():
            out[name][look, inside] = np.interp(distance[inside], known, field[look, order])
    return out


def centred_looks(
    fan: LookFan,
    azimuth_sweep: NDArray[np.float64],
    ground_range: NDArray[np.float64],
    fields: dict[str, NDArray[np.float64]],
    distance: NDArray[np.float64],
    widest_gap: float,
) -> tuple[LookFan, dict[str, NDArray[np.float64]]]:
    """Fields (look, gate) of cells that lie anywhere, on a finer fan from a common centre, (look, distance).

    azimuth_sweep [deg from the sector's start, not wrapped] and ground_range [m] are the cells' own, from that centre.
    Looks more than one and a half apart have a gap between them.
    """
    laid = resample_looks(ground_range, {**fields, "_sweep": azimuth_sweep}, distance, widest_gap)
    sweep, half = laid.pop("_sweep"), 0.5 * fan.spacing
    # The first and the last look serve as far as half a look beyond.
    sweep = np.concatenate((sweep[:1] - half, sweep, sweep[-1:] + half))
    looks = _FINER * fan.sweep.size
    fine = fan.sweep[0] - half + (np.arange(looks) + 0.5) * fan.spacing / _FINER
    across = resample_looks(
        sweep.T, {name: np.concatenate((f[:1], f, f[-1:])).T for name, f in laid.items()}, fine, 1.5 * fan.spacing
    )
    return replace(fan, sweep=fine), {name: field.T for name, field in across.items()}


def sample_fan(
    fan: LookFan,
    resampled: dict[str, NDArray[np.float64]],
    distance: NDArray[np.float64],
    sweep: NDArray[np.float64],
    ground_range: NDArray[np.float64],
) -> dict[str, NDArray[np.float64]]:
    """Fields at places (sweep angle, ground range), bilinear in both; NaN unless all that is used is known.

    Before the first look and after the last the nearest of them serves, as far as half a look; all the way in a full
    circle, whose ends lie a turn apart in time and are not blended.
    """
    looks = fan.sweep.size
    number = fan.look_number(sweep)
    outside = np.zeros(np.shape(number), dtype=bool)
    if not fan.closed:
        outside = (number < -0.5) | (number > looks - 0.5)
    number = np.clip(number, 0.0, looks - 1.0)
    step = distance[1] - distance[0]
    reach = (ground_range - distance[0]) / step
    outside |= (reach < 0.0) | (reach > distance.size - 1.0)
    low = np.clip(number.astype(int), 0, max(looks - 2, 0))
    near = np.clip(reach.astype(int), 0, distance.size - 2)
    high = np.minimum(low + 1, looks - 1)
    across, along = number - low, reach - near
    out = {}
    for name, field in resampled.items():
        first = field[low, near] * (1.0 - along) + field[low, near + 1] * along
        second = field[high, near] * (1.0 - along) + field[high, near + 1] * along
        blended = np.where(
            across <= 0.0, first, np.where(across >= 1.0, second, first * (1.0 - across) + second * across)
        )
        out[name] = np.where(outside, np.nan, blended)
    return out
