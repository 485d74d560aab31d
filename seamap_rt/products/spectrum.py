"""The spectrum that a scene's wave systems are expected to have, over frequency and direction."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..dataset import build
from ..physics import dispersion
from ..scene import Scene
from ..sea import Sea, directional_density, spectral_system, wave_facts
from ..settings import RandomWaves

SHORT_CRESTED, LONG_CRESTED, REGULAR = 0, 1, 2  # kinds of wave systems
_DIRECTIONS, _FREQUENCIES = 180, 240


def directional_spectrum(scene: Scene, sea: Sea) -> xr.Dataset:
    """The schema's `sea/spectrum`: what is expected of the scene's wave systems, those too that are not resolved."""
    depth = scene.sea.depth_m
    known = [(number, waves, wave_facts(waves, depth)) for number, waves in enumerate(scene.sea.waves)]
    known = [(number, waves, facts) for number, waves, facts in known if facts is not None]
    limit = _frequency(sea.resolved.wavenumber_limit, depth)
    peaks = [1.0 / facts.peak_period for _, _, facts in known]
    lowest, highest = 0.3 * min([*peaks, limit]), max([1.5 * limit, *(6.0 * peak for peak in peaks)])
    frequency = np.geomspace(lowest, highest, _FREQUENCIES)
    direction = 360.0 / _DIRECTIONS * np.arange(_DIRECTIONS)
    k = dispersion.wavenumber(2.0 * np.pi * frequency, depth)
    plane = np.zeros((frequency.size, direction.size))
    lines, kinds = np.zeros((len(known), frequency.size)), []
    for row, (_, waves, _) in enumerate(known):
        kinds.append(REGULAR)
        if isinstance(waves, RandomWaves):
            system = spectral_system(waves, depth)
            lines[row] = system.radial(k) * 2.0 * np.pi / dispersion.group_speed(k, depth)
            kinds[-1] = LONG_CRESTED if system.spreading is None else SHORT_CRESTED
            if system.spreading is not None:
                plane += directional_density(system, frequency, direction, depth)
    dataset = build(
        "sea/spectrum",
        {
            "directional_spectrum": plane,
            "frequency_spectrum": lines.sum(axis=0),
            "system_spectrum": lines,
            "system_kind": kinds,
            "system_height": [facts.height for _, _, facts in known],
            "system_period": [facts.peak_period for _, _, facts in known],
            "system_direction": [facts.from_deg for _, _, facts in known],
        },
        {"frequency": frequency, "direction": direction, "system": [number for number, _, _ in known]},
        {"resolved_up_to_hz": limit, **{f"sea_{name}": v for name, v in sea.spectrum.attrs.items()}},
    )
    dataset["system_kind"].attrs["flag_values"] = np.array([SHORT_CRESTED, LONG_CRESTED, REGULAR], dtype=np.int8)
    dataset["system_kind"].attrs["flag_meanings"] = "short_crested long_crested regular"
    return dataset


def _frequency(k: float, depth: float) -> float:
    """Hz of a wavenumber [rad/m]."""
    return float(dispersion.angular_frequency(k, depth)) / (2.0 * np.pi)
