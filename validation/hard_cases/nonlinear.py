"""Hard cases of nonlinear seas that go on: steep ones, shallow water, waves at the edge of breaking, a restart."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from typing import Any

import numpy as np

from seamap_rt.sea import realize
from seamap_rt.sea.high_order import Plan, State
from seamap_rt.settings import SeaSettings

from .case import Effort, Finding

MINUTES = 10.0, 2.0  # with all rays, and with a few
ALL = 10_000_000
PEAK_M = 47.2  # of waves of 5.5 s on deep water
UNCOUNTED = 3e-3  # of the energy that breaking is not counted to have taken: the time step's
SEAS: dict[str, tuple[float, dict[str, Any]]] = {
    "Hs/λ 1/15 on deep water": (np.inf, {"spectrum": "jonswap", "significant_wave_height_m": PEAK_M / 15.0}),
    "Hs 0.8 m in 5 m of water": (5.0, {"spectrum": "tma", "significant_wave_height_m": 0.8}),
    "Hs 2 m in 5 m, at the edge of breaking": (5.0, {"spectrum": "tma", "significant_wave_height_m": 2.0}),
}


def nonlinear_seas(effort: Effort) -> list[Finding]:
    """Short-crested seas of 5.5 s on 95 m for ten minutes (two, with few rays), and again from the middle."""
    rows, minutes = [], MINUTES[0] if effort.rays >= ALL else MINUTES[1]
    for name, (depth, waves) in SEAS.items():
        settings = SeaSettings.model_validate(
            {"extent_m": 95.0, "depth_m": depth, "waves": [{**waves, "peak_period_s": 5.5, "wave_from_deg": 270.0}]}
        )
        plan = Plan(settings, realize(settings, seed=1))
        rows += list(_is_alive(name, minutes, plan))
    return rows


def _is_alive(name: str, minutes: float, plan: Plan) -> Iterator[Finding]:
    evolution = plan.evolution(0.0, 0.5)
    begin = evolution.advanced(plan.beginning(evolution), plan.steps_before(evolution.step))
    half = round(30.0 * minutes / evolution.step)
    middle = evolution.advanced(begin, half)
    kept = pickle.dumps(middle)
    end = evolution.advanced(middle, half)
    before, after = evolution.energy(begin), evolution.energy(end)
    broken = (end.broken - begin.broken) / before
    uncounted = 1.0 - after / before - broken
    heights = begin.significant_height, end.significant_height
    yield Finding(
        f"nonlinear sea, {name}: {minutes:g} min, {2 * plan.band.most_x} points a side",
        f"lives; what it loses and breaking is not counted to have taken, at most {UNCOUNTED:.1%} of the energy",
        f"Hs {heights[0]:.2f} → {heights[1]:.2f} m, {broken:.1%} broken, {uncounted:+.2%} neither",
        abs(uncounted) < UNCOUNTED and 0.0 < heights[1] < heights[0],
    )
    again: State = plan.evolution(0.0, 0.5).advanced(pickle.loads(kept), half)  # made anew: nothing else is kept
    same = all(np.array_equal(a, b) for a, b in ((end.elevation, again.elevation), (end.potential, again.potential)))
    same = same and (end.time, end.broken) == (again.time, again.broken)
    yield Finding(
        f"nonlinear sea, {name}: gone on with from the middle",
        "the same bits at the end",
        "the same bits" if same else f"{np.abs(end.elevation - again.elevation).max():.1e} m apart",
        same,
    )
