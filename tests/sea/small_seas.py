"""Seas of one part each, small enough to be summed wave by wave."""

from __future__ import annotations

from typing import Any

from seamap_rt.settings import JonswapWaves, SeaSettings, SinusoidWaves


def jonswap(**changes: Any) -> JonswapWaves:
    return JonswapWaves(**{"spectrum": "jonswap", "significant_wave_height_m": 1.4, "peak_period_s": 5.5, **changes})


def sinusoid(**changes: Any) -> SinusoidWaves:
    return SinusoidWaves(**{"spectrum": "sinusoid", "height_m": 1.0, "wavelength_m": 20.0, **changes})


def sea_of(*waves: Any, **changes: Any) -> SeaSettings:
    return SeaSettings(**{"resolution_m": 1.0, "extent_m": 256.0, "waves": waves, **changes})


PARTS = {
    "regular": sea_of(sinusoid(wave_from_deg=250.0, phase_deg=40.0), depth_m=3.0),
    "plane": sea_of(jonswap()),
    "shallow plane": sea_of(jonswap(significant_wave_height_m=0.2, peak_period_s=4.0), depth_m=1.5),
    "line": sea_of(jonswap(spreading="long_crested", wave_from_deg=230.0)),
    "shallow line": sea_of(
        jonswap(significant_wave_height_m=0.2, spreading="long_crested", wave_from_deg=20.0), depth_m=2.0
    ),
}
