"""Theory for the sea that was meshed: its slopes along every look, and one regular wave crest by crest."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..conventions import unit_from_azimuth
from ..mesh import PolarGrid
from ..physics.dispersion import angular_frequency
from ..physics.shadowing import regular_wave_visible_share, shadowing_smith67, shadowing_wagner67
from ..scene import Scene
from ..sea import Sea
from ..sea.systems import travel_direction
from ..settings import SinusoidWaves

FUNCTIONS = {"smith": shadowing_smith67, "wagner": shadowing_wagner67}
Array = NDArray[np.float64]

_FAR_AND_NEAR = np.geomspace(1e6, 0.1, 5000)  # m, where half ranges are looked for
_LONG = 1e5  # wavelengths: a wave met so nearly abeam is flat along the look


def shadowing_share(name: str, height_m: float, slope_rms: Array, weight: Array, range_m: Array) -> Array:
    """Visible share (group, range) by one of `FUNCTIONS`, for groups of sectors with slopes (sector,) along the look.

    weight (group, sector): of the sectors in each group, each row adding up to 1. A flat sea is all seen.
    """
    with np.errstate(divide="ignore"):
        v = height_m / (np.sqrt(2.0) * slope_rms[:, None] * range_m)
    unknown = np.isnan(v)  # nothing was seen, or nothing was looked at
    return weight @ np.where(unknown, np.nan, FUNCTIONS[name](np.where(unknown, 0.0, v)))


def shadowing_half(name: str, height_m: float, slope_rms: Array, weight: Array) -> Array:
    """Ground range [m] (group,) at which `shadowing_share` is one half; infinite over a flat sea, else to 1e-5."""
    share = shadowing_share(name, height_m, slope_rms, weight, _FAR_AND_NEAR)
    half = [np.exp(np.interp(0.5, each, np.log(_FAR_AND_NEAR), left=np.nan)) for each in share]
    return np.where(share[:, 0] > 0.5, np.inf, half)


def resolved_slope(sea: Sea, azimuth_deg: ArrayLike) -> Array:
    """rms slope (n,) along azimuths (n,) of the resolved waves: the expectation, of no single realisation or mesh."""
    spectrum = sea.spectrum
    tensor = np.zeros((2, 2))
    density = spectrum["variance_density"].values
    if density.size:
        east, north = spectrum["kx"].values, spectrum["ky"].values
        variance = density * abs(east[1] - east[0]) * abs(north[1] - north[0])
        mixed = float(north @ variance @ east)
        tensor += [[float((variance @ east**2).sum()), mixed], [mixed, float(north**2 @ variance.sum(axis=1))]]
    k = spectrum["k"].values
    for line, toward in zip(spectrum["line_density"].values, spectrum["line_toward"].values, strict=True):
        tensor += float(line @ k**2) * abs(k[1] - k[0]) * _along(toward)
    sinusoids = (spectrum[f"sinusoid_{name}"].values for name in ("amplitude", "wavenumber", "toward"))
    for amplitude, wavenumber, toward in zip(*sinusoids, strict=True):
        tensor += 0.5 * (amplitude * wavenumber) ** 2 * _along(toward)
    look = np.stack(unit_from_azimuth(azimuth_deg))
    return np.sqrt(np.einsum("in,ij,jn->n", look, tensor, look))


def _along(azimuth_deg: float) -> Array:
    unit = np.array(unit_from_azimuth(azimuth_deg))
    return np.outer(unit, unit)


def exact_wave(scene: Scene) -> SinusoidWaves | None:
    """The scene's only wave, if it is a regular one whose light has a closed form; else None."""
    if scene.sea.model != "linear" or len(scene.sea.waves) != 1 or scene.platform.motion != "fixed":
        return None
    (wave,) = scene.sea.waves
    return wave if isinstance(wave, SinusoidWaves) and wave.height_m > 0.0 else None


def exact_share(scene: Scene, wave: SinusoidWaves, grid: PolarGrid, height_m: float, edges: Array) -> Array:
    """Visible share of horizontal area (column, bin), crest by crest, each column at its own time and place."""
    east, north = travel_direction(wave)
    k = 2.0 * np.pi / wave.wavelength_m
    look_east, look_north = unit_from_azimuth(grid.column_azimuth)
    along = look_east * east + look_north * north
    current_east, current_north = unit_from_azimuth(scene.sea.current_toward_deg)
    drift = k * scene.sea.current_m_s * float(current_east * east + current_north * north)
    origin = grid.column_pose.origin[:, :2] @ (east, north)
    turning = float(angular_frequency(k, scene.sea.depth_m)) + drift
    phase = np.radians(wave.phase_deg) + k * origin - turning * grid.column_time
    below = 0.5 * wave.height_m * np.cos(phase)  # the water at the foot of the mast
    share = np.where((below < height_m)[:, None], 1.0, np.zeros(edges.size - 1))
    for column, cosine in enumerate(along):
        if abs(cosine) * _LONG < 1.0 or below[column] >= height_m:
            continue
        met = wave.wavelength_m / abs(cosine)
        ahead = phase[column] if cosine > 0.0 else -phase[column]
        share[column] = regular_wave_visible_share(wave.height_m, met, height_m, ahead, edges)
    return share
