"""Hard cases of scenes at the limits of the settings: crests, storms, walls, next to no sea, too many facets."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

import seamap_rt as sr
from seamap_rt.errors import InputError
from seamap_rt.mesh.sizing import MOST_TRIANGLES
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.resolved_scene import run_sea
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator

from .case import TRACERS, Effort, Finding, RadialSurface, light, scene


def on_the_crest(above: float, **keys: Any) -> Scene:
    """Antennas so far above the crest of a steep wave, looking down its back."""
    return scene(
        "sinusoid",
        **{
            "sea__waves__0__height_m": 3.0,
            "sea__waves__0__wavelength_m": 22.0,
            "radar__height_m": 1.505 + above,
            "radar__baseline_m": 0.01,
            "radar__sector_deg": [88.0, 92.0],
            "radar__range_m": [4.0, 11.5],
            "scattering__nrcs": "constant",
            "tracing__facet_m": 0.25,
            **keys,
        },
    )


def crest(_: Effort) -> list[Finding]:
    """1 cm above a crest nothing of its back is seen; just below it is refused."""
    rows = []
    for name in TRACERS:
        made = on_the_crest(0.01, radar__noise=False, tracing__tracer=name, tracing__diffraction="none")
        turn = Simulator(made).turn(0)
        heard = bool(turn.echoes["voltage"].values.any())
        polar = sr.retrieve(turn.echoes, made.retrieval)["polar"].to_dataset()
        known = int(np.isfinite(polar["height"].values).sum())
        flagged = bool((polar["quality"].values & 1).all())
        rows.append(
            Finding(
                f"no facet lit: antenna 1 cm above a crest, {name}",
                "by straight rays no echo at all without noise, every cell NaN and flagged no_echo",
                f"{'an' if heard else 'no'} echo, {known} heights, {'all' if flagged else 'not all'} flagged",
                not heard and known == 0 and flagged,
            )
        )
    for above, right in ((0.001, "taken"), (0.0, "refused"), (-0.01, "refused")):
        try:
            Simulator(on_the_crest(above))
            obtained = "taken"
        except InputError as error:
            obtained = f"refused: {error}"
        rows.append(
            Finding(
                f"antenna {1e3 * above:+.0f} mm from a crest",
                right,
                obtained,
                obtained.startswith(right) and "\n" not in obtained,
            )
        )
    return rows


def storm(_: Effort) -> list[Finding]:
    """Hs 15 m under a 5 m mast, 20 s each of three seas that come up over it."""
    keys = {
        "sea__resolution_m": 4.0,
        "sea__waves__0__significant_wave_height_m": 15.0,
        "sea__waves__0__peak_period_s": 17.0,
        "sea__extent_m": 1024.0,
        "radar__sector_deg": [262.0, 267.4],
        "scattering__nrcs": "constant",
        "tracing__facet_m": 1.0,
        "turns": 20,
    }
    drowned, bad = [], 0
    for seed in range(1, 100):
        made = scene("tiny", **keys, seed=seed)
        waves = run_sea(made).components()
        level = sr.sea.direct_sum(waves, 0.0, 0.0, np.arange(20.0)).elevation
        if level[0] > 4.0 or np.count_nonzero(level > 5.0) < 4:
            continue
        simulation = sr.simulate(made)
        volts = simulation.echoes["voltage"].values
        silent = np.all(np.isnan(volts), axis=(1, 2))
        polar = sr.retrieve(simulation.echoes, made.retrieval)["polar"].to_dataset()
        unknown = np.isnan(polar["height"].values)
        bad += int(np.count_nonzero(~np.isfinite(volts[~silent])))
        bad += int(np.count_nonzero(silent != (simulation.echoes["flag"].values == 64)))
        bad += int(np.count_nonzero(polar["quality"].values[unknown] == 0))
        drowned.append(float(silent.mean()))
        if len(drowned) == 3:
            break
    return [
        Finding(
            "Hs 15 m under a 5 m mast",
            "whole pulses NaN and flagged while under water, all else finite, no cell without a height or a reason",
            f"drowned {', '.join(f'{share:.0%}' for share in drowned)} of the pulses; {bad} bad values",
            len(drowned) == 3 and min(drowned) > 0.0 and bad == 0,
        )
    ]


def choppy_wall(_: Effort) -> list[Finding]:
    """Choppy waves near the folding limit, and a step of 30 m within 2 cm."""
    made = scene(
        "tiny",
        sea__model="choppy",
        sea__waves__0__significant_wave_height_m=2.87,  # the highest that a scene may have
        sea__waves__0__peak_period_s=3.6,
        sea__resolution_m=0.5,
        sea__extent_m=360.0,
        scattering__nrcs="constant",
        tracing__facet_m=0.25,
    )
    water = sr.sea.realize(made.sea, 2)
    facts = water.resolved.choppy
    mesh = mesh_turn(water, made.radar, made.meshing, 0)
    rays, horizon = (light(name, mesh, made) for name in TRACERS)
    steepest, share = np.abs(mesh.facets.slope_look).max(), float(np.mean(rays != horizon))
    rows = [
        Finding(
            f"a wall of water: choppy, {facts.folded_share if facts else 0.0:.1%} folded",
            "rays and horizon differ on less than 0.02 % of the facets",
            f"{share:.4%} of {rays.size}; steepest slope {steepest:.1f}",
            share < 2e-4,
        )
    ]
    made = scene("flat", radar__sector_deg=[90.0, 91.8], radar__range_m=[15.0, 60.0], tracing__facet_m=0.02)
    for top in (4.0, 30.0):
        surface = RadialSurface(lambda r, top=top: np.where(np.abs(r - 20.0) < 0.011, top, 0.0))
        mesh = mesh_turn(surface, made.radar, made.meshing, 0)
        distance, wrong = mesh.facets.distance, 0
        for name in TRACERS:
            for antenna, (lit, mast) in enumerate(zip(light(name, mesh, made), (4.9, 5.1), strict=True)):
                lands = 20.0 * mast / (mast - top) if top < mast else np.inf
                expected = (distance < 20.0) | (distance > lands)
                sure = (np.abs(distance - 20.0) > 1e-6) & ~(np.abs(distance - lands) < 0.04)
                wrong += int(np.count_nonzero(lit[:, sure] != expected[sure])) * (antenna >= 0)
        rows.append(
            Finding(
                f"a step of {top:g} m within 2 cm", "dark from it to where the ray lands", f"{wrong} wrong", wrong == 0
            )
        )
    return rows


def level(_: Effort) -> list[Finding]:
    """Hs of 1 µm: all lit, and heights as of a flat sea."""
    # Speckle that changes within a dwell: else some cell fades and has no echo, on the flat sea too.
    keys = {"radar__noise": False, "scattering__decorrelation_time_s": 1e-3}
    maps, lit = [], 1.0
    for height in (1e-6, 0.0):
        made = scene("tiny", sea__waves__0__significant_wave_height_m=height, **keys)
        turn = Simulator(made).turn(0)
        lit = min(lit, float(turn.truth["polar"].to_dataset()["visible_fraction"].values.min()))
        maps.append(sr.retrieve(turn.echoes, made.retrieval)["polar"].to_dataset()["height"].values)
    error = np.abs(maps[0] - maps[1])
    return [
        Finding(
            "a sea of 1 µm",
            "nothing shadowed, no NaN, heights of a flat sea with the same speckle to 1 µm",
            f"visible {lit:.0%}, {np.isnan(maps[0]).sum()} NaN, heights differ by {1e6 * np.nanmax(error):.2f} µm",
            bool(lit == 1.0 and np.isfinite(maps[0]).all() and np.nanmax(error) < 1e-6),
        )
    ]


def ten_million(effort: Effort) -> list[Finding]:
    """A scene that is too large is refused with what it needs; with --full, 10⁷ facets are traced."""
    keys = {
        "radar__range_m": [15.0, 3000.0],
        "radar__prf_hz": 2000.0,
        "retrieval__ground_m": 10.0,
        "scattering__extrapolate": True,
        "tracing__columns_per_beam": 4,
        "sea__extent_m": 6200.0,
        "sea__resolution_m": 3.0,
    }
    columns = 4.0 * (360.0 + 6.0 * 1.8) / 1.8
    least = 2.0 * columns * 3005.0 / MOST_TRIANGLES
    try:
        scene("flat", **keys, tracing__facet_m=0.98 * least)
        obtained = "taken"
    except InputError as error:
        obtained = str(error)
    right = "GB" in obtained and "raise tracing.facet_m" in obtained and "\n" not in obtained
    rows = [Finding("2 % more facets than may be", "refused in one line, with the memory they need", obtained, right)]
    if not effort.full:
        return rows
    made = scene("flat", **keys, tracing__facet_m=2.0 * columns * 3005.0 / 1e7)
    mesh = mesh_turn(RadialSurface(lambda r: 0.3 * np.cos(r / 5.0)), made.radar, made.meshing, 0)
    seconds, lit = [], []
    for name in TRACERS:
        start = time.perf_counter()
        lit.append(light(name, mesh, made))
        seconds.append(time.perf_counter() - start)
    share = float(np.mean(lit[0] != lit[1]))
    obtained = f"{lit[0][0].size:.3g} facets, {seconds[0]:.0f} s and {seconds[1]:.0f} s, differ on {share:.4%}"
    return [
        *rows,
        Finding("10⁷ facets, rays and horizon", "traced; differ on less than 0.02 %", obtained, share < 2e-4),
    ]
