"""Light on the sea: how bright the sun makes each point, and what one sees who stands at the mast.

From the mast a column of the picture is a vertical plane: along it, the first point that rises over all nearer ones is
what is seen. Water mirrors the sky by Fresnel's law (Schlick 1994), and the sun about the direction in which it would
be seen in a mirror; the rest is the light that comes back from within, lit as Lambert's law has it.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Array = NDArray[np.float64]

SUN_ELEVATION_DEG = 25.0
_WIDE_DEG, _PIXELS, _LINES = 70.0, 960, 400
_SKY_SHARE = 0.2  # of the picture above the horizon
_STEPS = 700
_MIRROR = 0.02  # of light that falls straight down
_ROUGH = 0.15  # rms slope of waves that no map resolves
_FALLS, _LEFT = 5.0 * np.exp(-2.69 * _ROUGH), 1.0 + 22.7 * _ROUGH**1.5  # of a rough sea's mirror
_GLINT_DEG = 9.0  # half width of the sun's image: slopes of waves that no map resolves
_LOW_SKY, _HIGH_SKY = np.array([0.93, 0.91, 0.84]), np.array([0.42, 0.62, 0.83])
_WATER, _SUN, _UNKNOWN = np.array([0.04, 0.16, 0.25]), np.array([1.0, 0.93, 0.78]), np.array([0.62, 0.61, 0.58])
_GROUND_SHADE = 0.45  # of the light that comes from all the sky


def sun(azimuth_deg: float, elevation_deg: float = SUN_ELEVATION_DEG) -> Array:
    """Unit vector to the sun, east north up."""
    high, angle = np.radians(elevation_deg), np.radians(azimuth_deg)
    return np.array([np.cos(high) * np.sin(angle), np.cos(high) * np.cos(angle), np.sin(high)])


def lambert(height: Array, x: Array, y: Array, to_sun: Array, exaggerated: float = 1.0) -> Array:
    """Brightness (y, x) from 0 to 1 of a surface over x and y: the sky's share, and the sun's by the cosine of its
    angle to the normal. exaggerated: how many times too high it is drawn."""
    rise_y, rise_x = np.gradient(exaggerated * np.nan_to_num(height), y, x)
    cosine = (to_sun[2] - rise_x * to_sun[0] - rise_y * to_sun[1]) / np.sqrt(1.0 + rise_x**2 + rise_y**2)
    return _GROUND_SHADE + (1.0 - _GROUND_SHADE) * np.clip(cosine, 0.0, 1.0)


@dataclass(frozen=True)
class Seen:
    """What each point (line, pixel) of a picture from the mast shows: distance ahead [m], infinite where it is the flat
    sea beyond the map, NaN in the sky; its place east and north [m]."""

    ahead: Array
    east: Array
    north: Array


def seen_from_mast(height: Array, x: Array, y: Array, mast_m: float, look_deg: float) -> Seen:
    """height (y, x) [m]; what is not known counts as mean sea level. mast_m: of the eye. look_deg: of the picture's
    middle."""
    along, aside, rows = _rays(look_deg)
    first, last = 0.6 * mast_m / abs(rows[-1]), float(np.hypot(np.abs(x).max(), np.abs(y).max()))
    steps = np.geomspace(max(first, 0.5), max(last, 2.0 * first), _STEPS)
    east, north = (steps[:, None] * (along[i] + aside[i]) for i in (0, 1))
    rising = (_bilinear(np.nan_to_num(height), x, y, east, north) - mast_m) / steps[:, None]
    horizon = np.maximum.accumulate(rising, axis=0)
    below = rows < 0.0
    number = np.full((_LINES, _PIXELS), -1)
    for column in range(_PIXELS):
        number[below, column] = np.searchsorted(horizon[:, column], rows[below])
    known = (number >= 0) & (number < _STEPS)
    ahead = np.where(known, steps[np.clip(number, 0, _STEPS - 1)], np.where(number >= _STEPS, np.inf, np.nan))
    reach = np.where(np.isfinite(ahead), ahead, 0.0)
    return Seen(ahead, *(reach * (along[i] + aside[i]) for i in (0, 1)))


def mast_picture(height: Array, x: Array, y: Array, known: NDArray[np.bool_], mast_m: float, look_deg: float) -> bytes:
    """A JPEG. known (y, x): where there is a height; in the looked-at area the others are grey."""
    seen = seen_from_mast(height, x, y, mast_m, look_deg)
    along, aside, rows = _rays(look_deg)
    sun_high = sun(look_deg + 20.0)
    sight = np.stack([
        np.broadcast_to(along[0] + aside[0], seen.ahead.shape), np.broadcast_to(along[1] + aside[1], seen.ahead.shape),
        np.broadcast_to(rows[:, None], seen.ahead.shape),
    ], axis=-1)  # fmt: skip
    sight = sight / np.linalg.norm(sight, axis=-1, keepdims=True)
    rise_y, rise_x = np.gradient(np.nan_to_num(height), y, x)
    slopes = [_bilinear(each, x, y, seen.east, seen.north) for each in (rise_x, rise_y)]
    flat = ~np.isfinite(seen.ahead)
    slopes = [np.where(flat, 0.0, each) for each in slopes]
    colour = _water(sight, slopes[0], slopes[1], sun_high)
    colour = np.where(np.isnan(seen.ahead)[..., None], _sky(sight, sun_high), colour)
    gaps = (_bilinear(1.0 * known, x, y, seen.east, seen.north) < 0.5) & ~flat
    gaps &= (np.abs(seen.east) <= np.abs(x).max()) & (np.abs(seen.north) <= np.abs(y).max())
    colour = np.where(gaps[..., None], 0.5 * (_UNKNOWN + colour), colour)
    file = io.BytesIO()
    Image.fromarray(np.rint(255.0 * np.clip(colour, 0.0, 1.0)).astype(np.uint8)).save(file, "JPEG", quality=82)
    return file.getvalue()


def _rays(look_deg: float) -> tuple[Array, Array, Array]:
    """Ahead (2,), aside (2, pixel), east and north for each metre ahead; and how far lines rise (line,) for each."""
    angle, half = np.radians(look_deg), np.tan(np.radians(0.5 * _WIDE_DEG))
    across = np.linspace(-half, half, _PIXELS)
    pixel = across[1] - across[0]
    rows = pixel * (_SKY_SHARE * _LINES - np.arange(_LINES) - 0.5)
    aside = np.stack([across * np.cos(angle), -across * np.sin(angle)])
    return np.array([np.sin(angle), np.cos(angle)]), aside, rows


def _bilinear(values: Any, x: Array, y: Array, east: Array, north: Array) -> Array:
    """Of a field (y, x) on even cells; 0 outside."""
    column, row = (east - x[0]) / (x[1] - x[0]), (north - y[0]) / (y[1] - y[0])
    inside = (column >= 0.0) & (column <= x.size - 1) & (row >= 0.0) & (row <= y.size - 1)
    left, low = (np.clip(each.astype(np.intp), 0, size - 2) for each, size in ((column, x.size), (row, y.size)))
    part, up = column - left, row - low
    below = values[low, left] * (1.0 - part) + values[low, left + 1] * part
    above = values[low + 1, left] * (1.0 - part) + values[low + 1, left + 1] * part
    return np.where(inside, below * (1.0 - up) + above * up, 0.0)


def _water(sight: Array, rise_x: Array, rise_y: Array, to_sun: Array) -> Array:
    """Colour (line, pixel, 3) of water of some slopes."""
    normal = np.stack([-rise_x, -rise_y, np.ones_like(rise_x)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    facing = np.clip(-np.sum(normal * sight, axis=-1), 0.0, 1.0)[..., None]
    mirrored = sight + 2.0 * facing * normal
    mirrored[..., 2] = np.abs(mirrored[..., 2])  # once more off the water, if it goes down
    share = _MIRROR + (1.0 - _MIRROR) * (1.0 - facing) ** _FALLS / _LEFT
    lit = _GROUND_SHADE + (1.0 - _GROUND_SHADE) * np.clip(normal @ to_sun, 0.0, 1.0)[..., None]
    apart = np.degrees(np.arccos(np.clip(mirrored @ to_sun, -1.0, 1.0)))[..., None]
    glint = 1.1 * np.exp(-0.5 * (apart / _GLINT_DEG) ** 2)
    return share * _sky(mirrored, to_sun) + (1.0 - share) * _WATER * (1.6 * lit) + glint * share**0.5 * _SUN


def _sky(toward: Array, to_sun: Array) -> Array:
    """Colour of the sky in some directions (…, 3)."""
    high = np.clip(toward[..., 2:], 0.0, 1.0) ** 0.5
    about = np.clip(toward @ to_sun, 0.0, 1.0)[..., None] ** 24
    return _LOW_SKY + (_HIGH_SKY - _LOW_SKY) * high + 0.12 * about * _SUN
