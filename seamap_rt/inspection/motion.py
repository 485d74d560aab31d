"""Which way things move: by the Doppler, by the waves from turn to turn, and by the wind.

A height map does not tell a wave from the same wave run backwards; the water's velocity does, and so does the next
turn. Between turns T apart a wave of wavenumber k gains the phase −ωT: of what both maps hold, the sum of
Re(H₂ H₁* e^{±iωT}) is larger with the sign of the way that the waves run. Bragg waves and breakers drift with the wind.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import unit_from_azimuth, wrap_degrees
from ..dataset import group_of
from ..wavefield.sea_state import TurnSpectrum, sea_state, water_of
from ..wavefield.wave_direction import wavevectors
from .findings import Finding

Array = NDArray[np.float64]

_FEWEST_CELLS = 100
_LEAST_SPAN = 120.0  # deg of looks, to tell a drift's direction
_LEAST_DRIFT = 0.1  # m/s
_APART_DEG = 120.0
_SURE = 0.2  # of what both maps hold: less says nothing


def motion(maps: xr.DataTree, wind_from_deg: float | None = None) -> list[Finding]:
    """Findings on how the waves drift and run, by maps of one turn or several. wind_from_deg: where it is known."""
    polar = group_of(maps, "maps/polar")
    axis = _mean(sea_state(maps)["mean_axis"].values, 2)
    turns = (TurnSpectrum.of(polar.isel(turn=turn), water_of(polar.attrs)) for turn in range(polar.sizes["turn"]))
    # By the water's velocity alone: heights that run the other way from turn to turn show its sign to be wrong.
    waves = _mean(np.array([np.nan if turn is None else turn.direction.wave_from_deg for turn in turns]), 1)
    return [_drift(polar, waves, wind_from_deg), _run(maps, waves, axis)]


def _mean(degrees: Array, folds: int) -> float | None:
    """Mean of directions, or of axes (folds = 2), in deg; None of none."""
    known = np.exp(1j * folds * np.radians(degrees[np.isfinite(degrees)]))
    return float(np.degrees(np.angle(np.mean(known))) / folds % (360.0 / folds)) if known.size else None


def _drift(polar: xr.Dataset, waves: float | None, wind: float | None) -> Finding:
    """Where the echo's mean velocity comes from, beside wind or waves."""
    what = "Doppler"
    if "radial_velocity" not in polar:
        return Finding(what, "unknown", "these maps hold no velocities")
    velocity = polar["radial_velocity"].values.astype(np.float64)
    azimuth = polar["azimuth"].values
    looks = np.array([np.broadcast_to(each[:, None], velocity.shape) for each in unit_from_azimuth(azimuth)])
    seen = np.isfinite(velocity)
    width = abs(wrap_degrees(azimuth[1] - azimuth[0])) if azimuth.size > 1 else 0.0
    if np.count_nonzero(seen) < _FEWEST_CELLS or width * azimuth.size < _LEAST_SPAN:
        return Finding(what, "unknown", "too few velocities, or too narrow a sector, to tell which way the echo drifts")
    east, north = np.linalg.lstsq(looks[:, seen].T, velocity[seen], rcond=None)[0]
    speed, comes_from = float(np.hypot(east, north)), float(np.degrees(np.arctan2(-east, -north)) % 360.0)
    says = f"the echo drifts at {speed:.2f} m/s from {comes_from:.0f}°"
    other, name = (wind, "the wind") if wind is not None else (waves, "the waves")
    if other is None or speed < _LEAST_DRIFT:
        return Finding(what, "unknown", f"{says}; no wind or waves to compare it with" if other is None else says)
    apart = abs(float(wrap_degrees(comes_from - other)))
    if apart <= _APART_DEG:
        return Finding(what, "good", f"{says}, {name} from {other:.0f}°")
    if wind is None:  # objects and crossing systems do this too, and a wrong sign turns both round
        return Finding(what, "unknown", f"{says}, against {name} from {other:.0f}°; give the wind to judge it")
    remedy = (
        "a strong current or swell against the wind does this; so does the wrong sign of the phase from pulse to pulse"
    )
    return Finding(what, "doubtful", f"{says}, against {name} from {other:.0f}°", remedy)


def _run(maps: xr.DataTree, given: float | None, axis: float | None) -> Finding:
    """Whether the waves run from turn to turn the way that the Doppler says; without it, which way along their axis."""
    what = "waves from turn to turn"
    ground = group_of(maps, "maps/ground")
    waves = axis if given is None else given
    if waves is None:
        return Finding(what, "unknown", "which way the waves run is not known")
    if ground.sizes["turn"] < 2:
        return Finding(what, "unknown", "one turn does not show it")
    height, time = (ground[name].values.astype(np.float64) for name in ("height", "time"))
    side = float(abs(ground["x"].values[1] - ground["x"].values[0]))
    kx, ky = wavevectors(side, height.shape[1:])
    water = water_of(group_of(maps, "maps/polar").attrs)
    k = np.hypot(kx, ky)
    frequency = water.frequency(k)
    to_east, to_north = (-float(each[0]) for each in unit_from_azimuth([waves]))
    forth = np.sign(kx * to_east + ky * to_north)
    least = 2.0 * np.pi / (0.5 * side * min(height.shape[1:]))  # longer ones are no waves of this map
    totals = np.zeros(3)
    for first in range(height.shape[0] - 1):
        pair, when = height[first : first + 2], time[first : first + 2]
        both = np.isfinite(pair).all(axis=0) & np.isfinite(when).all(axis=0)
        if np.count_nonzero(both) < _FEWEST_CELLS:
            continue
        lapse = float(np.median(np.diff(when, axis=0)[0][both]))
        one, two = (np.fft.rfft2(np.where(both, each - each[both].mean(), 0.0)) for each in pair)
        cross = np.where((k > least) & (forth != 0.0), two * one.conj(), 0.0)
        shift = water.doppler_shift(kx, ky)
        phase = [np.exp(1j * (forth * frequency * way + shift) * lapse) for way in (1.0, -1.0)]
        totals += [*(float(np.real(cross * each).sum()) for each in phase), float(np.abs(cross).sum())]
    if totals[2] <= 0.0 or abs(totals[0] - totals[1]) < _SURE * totals[2]:
        return Finding(what, "unknown", "the turns have too little in common to say which way the waves run")
    says = f"{100.0 * totals[0] / totals[2]:.0f} % fits waves from {waves:.0f}°, {100.0 * totals[1] / totals[2]:.0f} % "
    says += "waves that run the other way"
    if given is None:
        comes_from = waves if totals[0] > totals[1] else (waves + 180.0) % 360.0
        return Finding(what, "good", f"without velocities: {says}: they come from {comes_from:.0f}°")
    if totals[0] > totals[1]:
        return Finding(what, "good", says)
    remedy = "set conjugate in the header and exchange lower and upper: heights stay, velocities turn round"
    return Finding(what, "wrong", f"{says}: the velocities have the wrong sign", remedy)
