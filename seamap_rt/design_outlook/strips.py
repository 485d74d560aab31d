"""Strips of random sea, each long along a look and a few beams wide, with the statistics of the scene's waves.

A strip's surface is a sum over wavenumbers along and across its look. Of each wave system the variance between two
wavenumbers and two directions goes to the strip's nearest wavenumbers, so that lines along the look have the spectrum
that the sea has along it: what hides behind crests depends on nothing else. The draws are the same for every scene,
so that designs are compared on the same seas.

The horizon gives which of each strip's cells the lower antenna sees, a step of the surface at a time; their echo
over the noise by facets' slopes, a measured mean, and the link budget.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.fft
from numpy.typing import ArrayLike, NDArray

from ..compute.compiled import compiled
from ..conventions import POLARIZATIONS, from_db, unit_from_azimuth
from ..physics.shadowing import SEEN_DB
from ..radar import link
from ..radar.antenna import antenna
from ..radar.receiver import noise_power
from ..scattering import MEAN_MODELS, ShortWaves, mean_level, nrcs_composite
from ..scattering.calibration import fit_scale
from ..scattering.permittivity import permittivity_of
from ..sea.systems import spectral_system, travel_direction
from ..settings import RadarSettings, RandomWaves, ScatteringSettings, SeaSettings, SinusoidWaves
from ..tracing.visibility import profile_powers

Array = NDArray[np.float64]

LOOKS = 16
ROWS, ROW_M = 16, 0.75  # of a strip, across the look: 12 m, which repeat
_DIRECTIONS = 80  # of waves: a multiple of LOOKS, so that strips share their wavenumbers
_WAVENUMBERS = 240
_LONGEST = 1e-3  # rad/m
_SHORTEST_STEPS = 3.0  # of the strip in the shortest wave
_MOST_STEPS = 8192
_WAVES = 6.0  # of the mean length, that a strip is long at least: its wavenumbers are multiples of 2π over it
_STREAM = 20041124


class Waves(NamedTuple):
    """The sea's variance [m²] by wavenumber [rad/m] (k,) and azimuth of travel (direction,), (k, direction)."""

    wavenumber: Array
    variance: Array

    @property
    def elevation_variance(self) -> float:
        """m²."""
        return float(self.variance.sum())

    @property
    def mean_length(self) -> float:
        """Wavelength [m] at the mean wavenumber by variance; 0 without waves."""
        moment = float(np.sum(self.variance.sum(axis=1) * self.wavenumber))
        return 2.0 * np.pi * self.elevation_variance / moment if moment > 0.0 else 0.0

    @property
    def slope_variance(self) -> float:
        """Slope variance in one direction, the mean over all."""
        return 0.5 * float(np.sum(self.variance.sum(axis=1) * self.wavenumber**2))


@dataclass(frozen=True)
class Strips:
    """height (look, row, step) [m] at distances (step,) [m] from the mast; azimuth (look,) [deg]."""

    height: NDArray[np.float32]
    distance: Array
    azimuth: Array

    @property
    def step(self) -> float:
        return float(self.distance[1] - self.distance[0])

    def steps(self, edges: tuple[Array, Array]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """First and last (gate,) of the steps between distances [m], at least one apart."""
        first, last = (np.clip(np.rint(each / self.step), 0, self.distance.size - 1).astype(np.int64) for each in edges)
        return first, np.maximum(last, first + 1)


def azimuths() -> Array:
    """Azimuths of the looks, deg."""
    return (np.arange(LOOKS) + 0.5) * 360.0 / LOOKS


def directions() -> Array:
    """Azimuths [deg] that waves run to, (direction,)."""
    return (np.arange(_DIRECTIONS) + 0.5) * 360.0 / _DIRECTIONS


def waves_of(sea: SeaSettings, limit: float) -> Waves:
    """Of all systems, of waves below `limit` rad/m; regular waves of any length count as one direction and one k."""
    edges = np.geomspace(_LONGEST, limit, _WAVENUMBERS + 1)
    k, width = np.sqrt(edges[1:] * edges[:-1]), np.diff(edges)
    toward = directions()
    variance = np.zeros((k.size, toward.size))
    east, north = unit_from_azimuth(toward)
    for waves in sea.waves:
        if isinstance(waves, SinusoidWaves):
            way = travel_direction(waves)
            nearest = int(np.argmax(east * way[0] + north * way[1]))
            variance[np.abs(k - 2.0 * np.pi / waves.wavelength_m).argmin(), nearest] += 0.125 * waves.height_m**2
        elif isinstance(waves, RandomWaves):
            system = spectral_system(waves, sea.depth_m)
            radial = np.where(k < system.shortest, system.radial(k), 0.0) * width
            along = system.toward[0] * east + system.toward[1] * north
            if system.spreading is None:
                share = np.zeros((1, toward.size))
                share[0, int(np.argmax(along))] = 1.0
            else:
                across = system.toward[0] * north - system.toward[1] * east
                share = np.broadcast_to(system.spreading(k[:, None], along, across), variance.shape)
                share = share / np.maximum(share.sum(axis=1, keepdims=True), 1e-300)
            variance += radial[:, None] * share
    return Waves(k, variance)


@lru_cache(maxsize=4)
def _draws(half: int) -> NDArray[np.complex64]:
    """Waves of random phase and variance 2 (look, row, wave): all of the size expected, so that a few strips hold the
    sea's whole variance."""
    phase = np.random.default_rng(_STREAM).random((LOOKS, half, ROWS), dtype=np.float32)  # longer strips begin alike
    return np.ascontiguousarray((np.sqrt(2.0) * np.exp(2j * np.pi * phase)).transpose(0, 2, 1).astype(np.complex64))


def strips(waves: Waves, length: float, shortest: float) -> Strips:
    """Strips of that length [m] and of some wavelengths at least; the shortest wave [m] has three steps or more."""
    length = max(length, _WAVES * waves.mean_length)
    step = max(shortest / _SHORTEST_STEPS, length / _MOST_STEPS)
    wanted = int(np.ceil(length / step))
    count = int(scipy.fft.next_fast_len(wanted, real=True) or wanted)
    half = count // 2 + 1
    along, across = 2.0 * np.pi / (count * step), 2.0 * np.pi / (ROWS * ROW_M)
    look, toward = azimuths(), directions()
    turned = np.radians(toward - look[0])
    k = waves.wavenumber[:, None]
    forward, aside = k * np.cos(turned) / along, k * np.sin(turned) / across
    # A wave that runs towards the mast has the same surface as its mirror image's that runs away.
    back = forward < 0.0
    column = np.minimum(np.rint(np.abs(forward)).astype(np.int64), half - 1)
    row = np.rint(np.where(back, -aside, aside)).astype(np.int64) % ROWS
    place = (row * half + column).ravel()
    turn = _DIRECTIONS // LOOKS
    power = np.stack(
        [np.bincount(place, np.roll(waves.variance, -turn * n, axis=1).ravel(), ROWS * half) for n in range(LOOKS)]
    ).reshape(LOOKS, ROWS, half)
    power[..., 1:] *= 0.25 if half > 1 else 1.0  # a pair of opposite waves; in column 0 both are in the sum already
    wave = np.sqrt(power).astype(np.float32) * _draws(half)
    height: NDArray[np.float32] = np.asarray(
        scipy.fft.irfft2(wave, s=(ROWS, count), axes=(1, 2), norm="forward", workers=-1, overwrite_x=True), np.float32
    )
    return Strips(height, step * (np.arange(count, dtype=np.float64) + 0.5), look)


STARTS = 3  # places of the mast on a strip
_PROFILES = np.arange(0, ROWS, 8)  # rows on which the field over crests is found
TABLE = 512  # entries by the local grazing angle's tangent t, even in t/(1 + t)


class Sight(NamedTuple):
    """Means over a gate's length of single rows, (look, row, gate)."""

    visible: NDArray[np.float32]  # share of the ground
    height: NDArray[np.float32]  # m, of all of it
    lit_height: NDArray[np.float32]  # m times the share that is seen
    echo: NDArray[np.float32]  # σ0 before calibration, per ground


def table_grazing() -> Array:
    """Local grazing angles [rad] (TABLE,) of echo tables, from 0 to π/2."""
    even = np.linspace(0.0, 1.0, TABLE)
    return np.arctan2(even, 1.0 - even)


def sight(strips: Strips, eye_m: ArrayLike, edges: tuple[Array, Array], echo: Array, in_sight: Array) -> Sight:
    """What a mast sees that stands at several places of each strip, one after the other along the first axis.

    eye_m: height of the lower antenna over mean sea level, of all places or (place,). edges: ground ranges [m] at which
    gates begin and end, (gate,). echo: σ0 (look, TABLE) per ground, at the grazing angles of `table_grazing`; in_sight:
    likewise, the share of what the strips light that shorter waves leave in sight. Strips repeat.
    """
    first, last = strips.steps(edges)
    starts = np.arange(STARTS) * (strips.distance.size // STARTS)
    shape = (STARTS * LOOKS, ROWS, first.size)
    eyes = np.broadcast_to(np.asarray(eye_m, dtype=np.float64), STARTS).copy()
    made = Sight(*(np.empty(shape, np.float32) for _ in Sight._fields))
    tables = np.stack((echo, in_sight), axis=-1).astype(np.float32)
    _look(strips.height, strips.step, eyes, starts, first, last, tables, made)
    return made


def radar_sight(
    strips: Strips, eye_m: ArrayLike, edges: tuple[Array, Array], permittivity: complex, wavelength_m: float
) -> Array:
    """Share (polarization, place and look, gate) of the water that a radar sees in each of `POLARIZATIONS`: what
    returns `SEEN_DB` or more of its two-way power when lit. Arguments as of `sight`."""
    steps, (first, last) = strips.distance.size, strips.steps(edges)
    corner = np.arange(last[-1] + 1)
    heights = np.broadcast_to(np.asarray(eye_m, dtype=np.float64), STARTS)
    shape = len(POLARIZATIONS), STARTS, LOOKS, _PROFILES.size
    shares = np.empty((*shape, first.size))
    for place, eye in enumerate(heights):
        surface = strips.height[:, _PROFILES][..., (place * (steps // STARTS) + corner) % steps] - eye
        surface = surface.reshape(-1, corner.size).astype(np.float64)
        powers = profile_powers(strips.step * (corner + 0.5), surface, permittivity, wavelength_m)
        for number, power in enumerate(powers):
            seen = np.cumsum(np.pad(power >= from_db(SEEN_DB), ((0, 0), (1, 0))), axis=1)
            shares[number, place] = ((seen[:, last] - seen[:, first]) / (last - first)).reshape(*shape[2:], first.size)
    return shares.mean(axis=3).reshape(len(POLARIZATIONS), STARTS * LOOKS, first.size)


@compiled
def _look(height, step, eyes, starts, first, last, table, sight):
    visible, mean, lit_mean, echo = sight
    looks, rows, steps = height.shape
    entries = table.shape[1] - 1
    reach = last[-1]
    sums = np.zeros((4, reach + 1))
    for place in range(starts.size * looks):
        look, start, eye = place % looks, starts[place // looks], eyes[place // looks]
        for row in range(rows):
            z = height[look, row]
            horizon = -np.inf
            here = start
            for n in range(reach):
                near = step * (n + 0.5)
                there = here + 1 if here + 1 < steps else 0
                horizon = max(horizon, (z[here] - eye) / near)
                middle, rise = 0.5 * (z[here] + z[there]), (z[there] - z[here]) / step
                here = there
                view = (middle - eye) / (near + 0.5 * step)
                lit = 1.0 if view > horizon else 0.0
                strength = 0.0
                if lit > 0.0:
                    up = max(rise - view, 0.0)  # over 1 + rise · view, as tangents subtract
                    at = entries * up / (up + max(1.0 + rise * view, 1e-6))
                    entry = min(int(at), entries - 1)
                    part = at - entry
                    strength = table[look, entry, 0] * (1.0 - part) + table[look, entry + 1, 0] * part
                    lit = table[look, entry, 1] * (1.0 - part) + table[look, entry + 1, 1] * part
                sums[0, n + 1] = sums[0, n] + lit
                sums[1, n + 1] = sums[1, n] + middle
                sums[2, n + 1] = sums[2, n] + lit * middle
                sums[3, n + 1] = sums[3, n] + strength
            for gate in range(first.size):
                begin, end = first[gate], last[gate]
                share = 1.0 / (end - begin)
                visible[place, row, gate] = (sums[0, end] - sums[0, begin]) * share
                mean[place, row, gate] = (sums[1, end] - sums[1, begin]) * share
                lit_mean[place, row, gate] = (sums[2, end] - sums[2, begin]) * share
                echo[place, row, gate] = (sums[3, end] - sums[3, begin]) * share


_ACROSS = np.array([-1.5, -0.5, 0.5, 1.5])  # standard deviations of the slope across a look


def echo_by_grazing(
    settings: ScatteringSettings, frequency_hz: float, limit: float, slope_rms: float, look_deg: Array
) -> Array:
    """σ0 per ground (look, TABLE) of facets by the grazing angle at which they are met, before calibration.

    limit: rad/m, up to which waves are on the surface; slope_rms: of the surface in one direction.
    """
    if settings.nrcs != "two_scale":
        return np.ones((look_deg.size, TABLE))
    grazing = table_grazing()[None, :, None]
    wind = np.radians(look_deg - settings.wind_from_deg)[:, None, None]
    across = slope_rms * _ACROSS
    weight = np.exp(-0.5 * _ACROSS**2)
    terms = nrcs_composite(
        0.5 * np.pi - grazing,
        0.0,
        across,
        wind,
        frequency_hz=frequency_hz,
        permittivity=permittivity_of(settings, frequency_hz),
        polarization=settings.polarization,
        waves=ShortWaves.of(settings, limit),
        breaking=settings.breaking,
    )
    area = np.sqrt(1.0 + across**2)
    return np.sum((terms.bragg + terms.specular + terms.breaking) * area * weight, axis=-1) / weight.sum()


def calibrated(
    settings: ScatteringSettings, frequency_hz: float, raw: NDArray[np.float32], grazing: Array, look_deg: Array
) -> NDArray[np.float32]:
    """σ0 per ground (look, row, gate) with the measured model's mean; raw: before; grazing (gate,) [rad]."""
    if settings.nrcs == "constant":
        return raw * np.float32(from_db(settings.nrcs_db))
    if settings.mean_model is None:
        return raw
    wind, mean = np.radians(look_deg - settings.wind_from_deg)[:, None], raw.mean(axis=1)
    target = np.broadcast_to(mean_level(settings, np.degrees(grazing), frequency_hz, wind_angle=wind), mean.shape)
    known = wind if MEAN_MODELS[settings.mean_model].knows_wind_direction else None
    scale = fit_scale(mean, np.ones(mean.shape), target, grazing[None], known, degree=3)
    return raw * scale(grazing[None], wind)[:, None].astype(np.float32)


def snr_of_unity(radar: RadarSettings, ranges: Array, lean: Array | None = None) -> Array:
    """Signal to noise ratio (gate,) of one pulse of a sea of σ0 = 1; of antennas that lean up (n,) [rad]: (n, gate)."""
    losses = link.losses_to_textbook(radar, ranges)
    power = link.textbook_power(radar, 1.0, ranges)
    lost = from_db(losses.azimuth + (losses.elevation if lean is None else 0.0) + losses.response)
    level = power / lost * link.eclipsed_share(radar, ranges) / noise_power(radar)
    if lean is None:
        return level
    return level * antenna(radar).voltage(0.0, -link.grazing_angle(radar, ranges) - lean[:, None]) ** 4
