"""Whole turns of scenes that nobody would choose: simulated and retrieved twice, from settings drawn from lists.

    python -m validation.fuzz.turns [--seconds 300] [--seed 1] [--case NUMBER]

Laws: a scene is refused by InputError or SchemaError, or its turn comes through without a warning; voltages are finite
or NaN; heights have an error bar and lie below three heights of the mast and the sea, or at most four bars above that;
and a second simulator in the same process gives the same bits (what is read before it is written, or from beyond an
array, seldom is the same twice).
Prints each case that breaks one, with its number, and how many were refused; exit 1 where any did.
"""

from __future__ import annotations

import random
import sys
import time
import traceback
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.errors import InputError, SchemaError
from seamap_rt.interferometry import retrieve_one
from seamap_rt.simulation import Simulator

from ..options import options

BASE: Mapping[str, Any] = {
    "tracing.tracer": "horizon",
    "radar.sector_deg": [260, 275],
    "radar.range_m": [15, 60],
    "sea.extent_m": 180,
    "turns": 1,
}
MOST_KEYS = 6


def _jonswap(**keys: Any) -> dict[str, Any]:
    wave = {"spectrum": "jonswap", "significant_wave_height_m": 1.0, "peak_period_s": 5.0, "wave_from_deg": 270.0}
    return wave | keys


CHOICES: Mapping[str, list[Any]] = {
    "sea.model": ["linear", "choppy"],
    "sea.waves": [
        [],
        [{"spectrum": "flat"}],
        [_jonswap(peak_period_s=1.2, significant_wave_height_m=0.05)],
        [_jonswap(peak_period_s=1.2, significant_wave_height_m=0.5)],
        [_jonswap(), _jonswap(peak_period_s=14.0, wave_from_deg=10.0)],
        [_jonswap(spreading="long_crested")],
        [_jonswap(significant_wave_height_m=6.0, peak_period_s=12.0)],
        [_jonswap(significant_wave_height_m=1e-6)],
        [{"spectrum": "sinusoid", "height_m": 1.0, "wavelength_m": 20.0, "wave_from_deg": 33.0}],
        [{"spectrum": "sinusoid", "height_m": 0.3, "wavelength_m": 1.0}],
        [{"spectrum": "pierson_moskowitz", "wind_speed_m_s": 15.0}],
        [{"spectrum": "elfouhaily", "wind_speed_m_s": 9.0}],
    ],
    "sea.depth_m": [0.01, 0.3, 2.0, 9.0, 50.0, float("inf")],
    "sea.resolution_m": [0.25, 0.5, 2.0, 4.0, 7.0, 13.0, 40.0],
    "sea.extent_m": [130, 180, 200, 333, 511, 800],
    "sea.current_m_s": [0.0, 0.5, 3.0],
    "sea.current_toward_deg": [0.0, 123.0],
    "scattering.nrcs": ["two_scale", "nrl", "git", "constant"],
    "scattering.polarization": ["VV", "HH"],
    "scattering.sea_spikes": [False],
    "scattering.texture": [True],
    "scattering.wind_drift": [0.0, 0.1],
    "scattering.wind_speed_m_s": [1.0, 3.0, 7.0, 12.0, 20.0],
    "scattering.breaking": [False],
    "scattering.doppler": ["orbital"],
    "scattering.decorrelation_time_s": [1e-4, 1e-3, 1.0, float("inf")],
    "scattering.calibrated_to": ["none", "nrl", "tsc"],
    "scattering.extrapolate": [True],
    "radar.height_m": [0.5, 1.5, 3.0, 12.0, 40.0],
    "radar.baseline_m": [0.0, 0.01, 0.5, 2.0],
    "radar.rotation_rpm": [5.0, 20.0, 120.0, 300.0],
    "radar.sector_deg": [[0, 10], [80, 100], [350, 355], [175, 185]],
    "radar.range_m": [[15, 60], [5, 20], [30, 90], [2, 40]],
    "radar.pulse_width_s": [5e-9, 50e-9, 200e-9],
    "radar.bandwidth_hz": [5e6, 200e6],
    "radar.prf_hz": [500.0, 2e3, 2e4],
    "radar.transmit_power_w": [1e-9, 1e-3, 1e4],
    "radar.noise": [False],
    "radar.scan": ["staring"],
    "radar.receiver.chain": ["video"],
    "radar.transmit": ["single", "switched"],
    "radar.interferogram": ["alternating_pulse", "single_pulse"],
    "radar.transmitter": ["magnetron"],
    "radar.waveform": ["chirp"],
    "radar.tilt_deg": [-20.0, 5.0, 20.0],
    "radar.frequency_hz": [9.3e9, 9.6e9, 12e9],
    "platform.motion": ["wave_following"],
    "platform.speed_m_s": [5.0, 20.0],
    "platform.list_deg": [10.0],
    "platform.heading_deg": [77.0],
    "tracing.height_error_m": [0.001, 0.2, 5.0],
    "tracing.unresolved_shadowing": ["smith"],
    "tracing.diffraction": ["none"],
    "tracing.facet_m": [0.1, 3.0, 20.0],
    "tracing.columns_per_beam": [3, 9],
    "retrieval.estimator": ["single_cell", "sliding_plane", "adaptive"],
    "retrieval.cell_range_m": [0.5, 8.0, 50.0],
    "retrieval.cell_azimuth_deg": [0.3, 7.0, 40.0],
    "retrieval.paths": ["one", "best"],
    "retrieval.map_time_s": [0.0, 0.5],
    "retrieval.ambiguity": ["fold", "resolve"],
    "retrieval.crest_bias": ["remove", "state"],
    "retrieval.receivers": [[1, 0]],
}


def main() -> None:
    arguments = options(__doc__, seconds=300.0, seed=1, case=int)
    warnings.simplefilter("error")
    ends, number, refused, broken = time.monotonic() + arguments.seconds, arguments.case or 0, 0, 0
    while arguments.case is not None or time.monotonic() < ends:
        keys = drawn(arguments.seed, number)
        says = judged(keys)
        refused += says == "refused"
        if says not in ("", "refused"):
            broken += 1
            print(f"{number}: {says}\n    {dict(keys)}", flush=True)
        number += 1
        if arguments.case is not None:
            break
    print(f"{number} scenes, {refused} refused, {broken} broke a law")
    sys.exit(1 if broken else 0)


def drawn(seed: int, number: int) -> Mapping[str, Any]:
    """The keys of a case."""
    draw = random.Random(f"{seed}/{number}")
    keys = draw.sample(sorted(CHOICES), draw.randint(1, MOST_KEYS))
    return {**BASE, **{key: draw.choice(CHOICES[key]) for key in keys}, "seed": draw.randint(1, 999)}


def judged(keys: Mapping[str, Any]) -> str:
    """Which law a scene breaks, and how; "refused", or nothing."""
    try:
        scene = sr.load_scene("tiny", keys)
        made = [_turn(scene) for _ in range(2)]
    except (InputError, SchemaError):
        return "refused"
    except Exception as error:
        at = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__}: {error} at {at.filename}:{at.lineno}"
    return next((says for says in (*_wrong(scene, *made[0]), _unlike(*made)) if says), "")


def _turn(scene: sr.Scene) -> tuple[xr.Dataset, xr.Dataset]:
    """Echoes and polar maps."""
    echoes = Simulator(scene).turn(0).echoes
    return echoes, retrieve_one(echoes, scene.resolved_retrieval)["polar"].to_dataset()


def _wrong(scene: sr.Scene, echoes: xr.Dataset, maps: xr.Dataset) -> list[str]:
    height, std = (maps[name].values for name in ("height", "height_std"))
    named = ("significant_wave_height_m", "height_m")  # neither of a wind's spectrum
    waves = sum(next((m for name in named if (m := getattr(each, name, None))), 5.0) for each in scene.sea.waves)
    known = np.isfinite(height) & np.isfinite(std)
    beyond = np.abs(height[known]) - 3.0 * (scene.radar.height_m + waves) - 4.0 * std[known]
    return [
        "voltages that are infinite" if np.isinf(echoes["voltage"].values).any() else "",
        "heights without an error bar" if (np.isfinite(height) & ~np.isfinite(std)).any() else "",
        f"heights of {np.nanmax(np.abs(height)):.3g} m" if (beyond > 0.0).any() else "",
    ]


def _unlike(one: tuple[xr.Dataset, xr.Dataset], other: tuple[xr.Dataset, xr.Dataset]) -> str:
    for first, second in zip(one, other, strict=True):
        for name in first.variables:
            if not _same(first[name].values, second[name].values):
                return f"{name} is another when done again"
    return ""


def _same(one: NDArray, other: NDArray) -> bool:
    return one.dtype == other.dtype and one.tobytes() == other.tobytes()


if __name__ == "__main__":
    main()
