"""Hard cases of forecasts: no sea, no sight, hours of time, next to no depth, a boat that runs away."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

import seamap_rt as sr
from seamap_rt.forecast_errors import true_elevation
from seamap_rt.prediction import Predictor, WaveField
from seamap_rt.simulation import Simulator

from .case import Effort, Finding, scene

_SHOWN = ("height", "height_std", "dwell_height", "dwell_height_std")
_TURNS = 8


def _maps(made: Any, first: int = 0, turns: int = _TURNS) -> tuple[Simulator, list[xr.Dataset]]:
    simulator = Simulator(made)
    return simulator, [
        sr.retrieve(simulator.turn(number).echoes, made.resolved_retrieval)["polar"].to_dataset().isel(turn=0)
        for number in range(first, first + turns)
    ]


def _last(maps: list[xr.Dataset]) -> WaveField | None:
    predictor, field = Predictor(), None
    for polar in maps:
        field = predictor.turn(polar)
    return field


def _score(simulator: Simulator, field: WaveField | None, **course: float) -> tuple[float, float]:
    """Rms error and stated error of forecasts of up to ten seconds among the cells that are seen, over the sea's σ."""
    if field is None:
        return np.nan, np.nan
    out = np.linspace(20.0, 90.0, 8)
    at = [(field.centre[0] + 0.7 * r, field.centre[1] + 0.7 * r) for r in out]
    made = sr.forecast(field, at, np.arange(0.0, 11.0), draws=0, **course)  # type: ignore[arg-type]
    error = made["elevation"].values - true_elevation(simulator.sea, made)
    both = np.sqrt([np.mean(error**2), np.mean(made["elevation_std"].values ** 2)]) / field.sea_std
    return float(both[0]), float(both[1])


def _tiny(**keys: Any) -> Any:
    return scene("tiny", tracing__tracer="horizon", turns=1, **{"radar__sector_deg": [0.0, 90.0], **keys})


def forecasts(_: Effort) -> list[Finding]:
    """A calm, the dark, hours, a film of water and a boat at speed: right, a wide error, or none; never garbage."""
    rows = []
    calm = _maps(scene("flat", tracing__tracer="horizon", radar__range_m=[20.0, 60.0]), turns=2)[1]
    field = _last(calm)
    mean, std = field.elevation(0.0, 0.0, field.issued + np.arange(31.0)) if field else (np.zeros(1), np.zeros(1))
    right = bool(np.all(np.abs(mean) < 0.05) and np.all(std < 0.05))
    obtained = f"at most {np.abs(mean).max():.3f} ± {std.max():.3f} m" if field else "none"
    rows.append(Finding("forecast of a calm", "none, or less than 5 cm of sea", obtained, right))

    simulator, seen = _maps(_tiny())
    near = _score(simulator, _last(seen))
    rows.append(_finding("a sea seen for eight turns, up to 10 s ahead", near, 1.6))
    dark = [each.assign({name: xr.full_like(each[name], np.nan) for name in _SHOWN}) for each in seen]
    blind = _score(simulator, _last([*seen[:3], *dark[3:]]))
    rows.append(_finding("the same, the last five turns in the dark", blind, 1.6))
    rows.append(
        Finding(
            "what the dark costs",
            "a wider stated error than with sight",
            f"{blind[1]:.2f} σ in place of {near[1]:.2f} σ",
            blind[1] > near[1],
        )
    )
    late, maps = _maps(_tiny(), first=36_000)
    rows.append(_finding("ten hours after the start", _score(late, _last(maps)), 1.6))
    shallow, maps = _maps(_tiny(sea__depth_m=0.5, sea__waves__0__significant_wave_height_m=0.15))
    rows.append(_finding("half a metre of water", _score(shallow, _last(maps)), 1.6))
    course = {"heading_deg": 45.0, "speed_m_s": 15.0}
    fast, maps = _maps(_tiny(platform__heading_deg=45.0, platform__speed_m_s=15.0))
    rows.append(_finding("a boat at 15 m/s", _score(fast, _last(maps), **course), 1.6))
    return rows


def _finding(case: str, score: tuple[float, float], most: float) -> Finding:
    """Right where a forecast is finite, its error at most so many stated ones, and the stated one at most σ."""
    right = bool(np.isfinite(score).all() and score[0] < most * score[1] and score[1] < 1.05)
    obtained = "none" if not np.isfinite(score).all() else f"{score[0]:.2f} σ, stated {score[1]:.2f} σ"
    return Finding(case, f"an error of at most {most:g} stated ones, which are no more than σ", obtained, right)
