"""Where breakers are born: by the strain of the resolved waves, or by the speed of the water at their crests?

    python -m validation.scattering.breaking_places [--seeds 11:13] [--winds 5,8,12] [--area] [--set KEY=VALUE]…

Barthelemy et al. (2018): a wave breaks once the water at its crest runs faster than B = u/c = 0.85 of the crest's own
speed c. The simulator's breakers follow the strain of the resolved waves to a power (`breaking_share`). On
one linear wave both would be the same number, ka cos θ, if the short waves did not relax; those of X-band do within a
fraction of a second, so that their strain leads the crest.

Here c is found at each facet, down-wind, as the speed that fits slope and curvature best: η_t = −c η_x and
η_xt = −c η_xx, weighed by ℓ² = ⟨η_x²⟩/⟨η_xx²⟩, which at a crest is its −η_xt/η_xx. Printed for each wind and sea: the
share of the area with B > 0.85, that of its whitecaps (3.84e-6 U^3.41; Monahan & O'Muircheartaigh 1980) and of the
breakers' own zones; along the waves the correlations of B (to 1 at most) and of the strain with each other and with the
height; and the shape of HH over Watts & Wicks' (1990) law, mean of both looks, with spikes that are

    strain   as they are
    brighter all of them where B > 0.85, each so much brighter
    more     so many more where B > 0.85, none elsewhere, each as it is
    even     anywhere alike

all with the same breaking echo in all, and the processor's seconds that B takes of a turn. --area prints instead the
share of the area with B > 0.85, to 200 m, by where the resolved waves end.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.conventions import unit_from_azimuth, wrap_degrees
from seamap_rt.echoes import expected_look_gates
from seamap_rt.mesh import Facets
from seamap_rt.scattering.breaking import breakers
from seamap_rt.scene import Scene
from seamap_rt.sea import Sea
from seamap_rt.simulation import Simulator
from validation.scattering.sea_spikes import MIDDLE_M, law, shape_of
from validation.scattering.texture import BANDS_M, SECTORS

THRESHOLD = 0.85
SEAS = {5.0: (0.5, 3.6), 8.0: (1.4, 5.5), 12.0: (2.5, 7.5)}  # Hs, Tp by the wind, m/s
WAYS = ("strain", "brighter", "more", "even")
_APART = 0.1  # of the shortest resolved wave, between the points of a difference


def scene_of(seed: int, wind: float, changes: Mapping[str, Any]) -> Scene:
    height, period = SEAS[wind]
    keys = {
        "seed": seed,
        "scattering.polarization": "HH",
        "scattering.sea_spikes": True,
        "scattering.wind_speed_m_s": wind,
        "tracing.tracer": "horizon",
    }
    scene = sr.load_scene("choppy_sea", {**keys, **changes})
    waves = scene.sea.waves[0].model_copy(update={"significant_wave_height_m": height, "peak_period_s": period})
    sea = scene.sea.model_copy(update={"waves": (waves,), "model": "linear"})
    return scene.model_copy(update={"sea": sea})


def speed_ratio(sea: Sea, facets: Facets, toward_deg: float) -> NDArray[np.float64]:
    """B = u/c (column, facet), down-wind; 0 where the water runs against the waves."""
    pose = facets.grid.column_pose
    azimuth = facets.grid.column_azimuth[:, None] + np.degrees(facets.angle)
    east, north = unit_from_azimuth(azimuth)
    x, y = pose.origin[:, :1] + east * facets.distance, pose.origin[:, 1:2] + north * facets.distance
    t = np.broadcast_to(pose.time[:, None], x.shape)
    along = np.array(unit_from_azimuth(toward_deg))
    apart = 2.0 * _APART * sea.resolved.resolution_m
    slopes, rates, flow = [], [], np.zeros(0)
    for step in (-apart, 0.0, apart):
        _, slope, velocity = sea.everything(x + step * along[0], y + step * along[1], t)
        slopes.append(slope @ along)
        rates.append(velocity[..., 2])
        flow = velocity[..., :2] @ along if step == 0.0 else flow
    bend, rate_bend = ((each[2] - each[0]) / (2.0 * apart) for each in (slopes, rates))
    weight = np.mean(slopes[1] ** 2) / np.mean(bend**2)
    speed = -(rates[1] * slopes[1] + weight * rate_bend * bend) / (slopes[1] ** 2 + weight * bend**2)
    return np.where((flow > 0.0) & (speed > 0.0), flow / np.maximum(speed, 1e-6), 0.0)


@dataclass
class Turn:
    """Of one sea: shares of the area, and cells' power over its mean over looks by way and sector."""

    over: float
    strained: float  # share of the strain's breaking that lies on B > 0.85
    together: float  # correlations along the waves: B and strain
    high: float  # B and height
    led: float  # strain and height
    seconds: float
    cells: dict[tuple[str, str], NDArray]
    ranges: NDArray


def turn_of(scene: Scene) -> Turn:
    simulator = Simulator(scene)
    mesh = simulator.mesh(0)
    light, returns, _ = simulator.light(0, mesh=mesh)
    surface, strain = simulator.surface, mesh.strain
    assert surface.spikes is not None
    assert strain is not None
    start = time.process_time()
    ratio = speed_ratio(simulator.sea, light, scene.scattering.wind_from_deg + 180.0)
    seconds = time.process_time() - start
    terms, even = surface.terms(light, strain), surface.terms(light, None).breaking
    factor, rest = surface.spikes.on(light).factor, terms.bragg + terms.specular
    breaks = (ratio > THRESHOLD).astype(np.float32)
    area = np.broadcast_to(light.horizontal_area, ratio.shape)
    share = max(float(np.average(breaks, weights=area)), 1e-4)
    denser = replace(surface.spikes, spikes=replace(surface.spikes.spikes, share=surface.spikes.spikes.share / share))
    more = denser.on(light).factor * share + (surface.spikes.spikes.left - denser.spikes.left * share)
    breaking = {
        "strain": (terms.breaking, factor),
        "brighter": (even * breaks, factor),
        "more": (even * breaks, more),
        "even": (even, factor),
    }
    looks = np.abs(wrap_degrees(light.grid.column_azimuth - scene.scattering.wind_from_deg)) < 20.0
    seen = [each[looks].ravel() for each in (np.minimum(ratio, 1.0), strain, light.height)]
    correlation = np.corrcoef(seen)
    was = rest + terms.breaking * factor
    turn = Turn(
        over=float(np.average(breaks, weights=area)),
        strained=float(np.sum(terms.breaking * breaks) / np.sum(terms.breaking)),
        together=float(correlation[0, 1]),
        high=float(correlation[0, 2]),
        led=float(correlation[1, 2]),
        seconds=seconds,
        cells={},
        ranges=np.zeros(0),
    )
    for way, (power, spikes) in breaking.items():
        level = np.sum(terms.breaking) / max(float(np.sum(power)), 1e-30)  # as much breaking in all
        rcs = returns.rcs * np.divide(rest + level * power * spikes, was, out=np.zeros_like(was), where=was > 0.0)
        calm = returns.rcs * np.divide(rest + level * power, was, out=np.zeros_like(was), where=was > 0.0)
        cell = scene.retrieval.cell_azimuth_deg
        lit, mean = (expected_look_gates(light, each, simulator.installation, cell) for each in (rcs, calm))
        angle = wrap_degrees(lit.sweep + simulator.installation.radar.sector_deg[0] - 270.0)
        for name, middles in SECTORS.items():
            looks = np.any([np.abs(wrap_degrees(angle - middle)) <= 30.0 for middle in middles], axis=0)
            turn.cells[way, name] = lit.power[0, 0][looks] / mean.power[0, 0][looks].mean(axis=0)
        turn.ranges = lit.range
    return turn


def print_area(seeds: range, wind: float, changes: dict[str, str]) -> None:
    for resolution in (1.6, 0.8, 0.4):
        keys = {"sea.resolution_m": resolution, "sea.extent_m": 512.0, "radar.range_m": [15.0, 200.0]}
        found = []
        for seed in seeds:
            scene = scene_of(seed, wind, {**changes, **keys})
            simulator = Simulator(scene)
            facets = simulator.mesh(0).facets
            ratio = speed_ratio(simulator.sea, facets, scene.scattering.wind_from_deg + 180.0)
            area = np.broadcast_to(facets.horizontal_area, ratio.shape)
            found.append(np.average(ratio > THRESHOLD, weights=area))
        print(f"{wind:g} m/s, waves of {2.0 * resolution:g} m and more: B > 0.85 on {np.mean(found):.1e} of the area")


def over_the_law(turns: list[Turn], scene: Scene, way: str) -> NDArray[np.float64]:
    """ν of a way over the law's by range, geometric mean of both looks."""
    total = np.zeros(MIDDLE_M.size)
    for name in SECTORS:
        shapes = [
            shape_of([each.cells[way, name][:, (each.ranges >= near) & (each.ranges < far)] for each in turns])
            for near, far in pairwise(BANDS_M)
        ]
        total += 0.5 * np.log(np.array(shapes) / law(scene, name))
    return np.exp(total)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="11:13", help="a:b are a … b − 1")
    parser.add_argument("--winds", default="5,8,12", help=f"of {', '.join(f'{each:g}' for each in SEAS)}")
    parser.add_argument("--area", action="store_true", help="the share of the area with B > 0.85 alone")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    arguments = parser.parse_args()
    seeds = range(*(int(each) for each in arguments.seeds.split(":")))
    changes = dict(each.split("=", 1) for each in arguments.set)
    for wind in (float(each) for each in arguments.winds.split(",")):
        if arguments.area:
            print_area(seeds, wind, changes)
            continue
        scene = scene_of(seeds[0], wind, changes)
        turns = [turn_of(scene_of(seed, wind, changes)) for seed in seeds]
        over, strained, together, high, led, seconds = (
            float(np.mean([getattr(each, name) for each in turns]))
            for name in ("over", "strained", "together", "high", "led", "seconds")
        )
        zones = breakers(wind, scene.scattering.inverse_wave_age, scene.radar.frequency_hz).fraction
        caps = 3.84e-6 * wind**3.41
        print(f"{wind:g} m/s: B > 0.85 on {over:.1e} of the area, whitecaps {caps:.1e}, zones {zones:.1e}")
        print(f"  {strained:.1%} of strain's breaking lies there; B takes {seconds:.2f} s")
        print(f"  correlations: B and strain {together:.2f}, B and height {high:.2f}, strain and height {led:.2f}")
        print("  HH over the law" + "".join(f"{value:8.0f}" for value in MIDDLE_M) + "   m")
        for way in WAYS:
            print(f"  {way:15}" + "".join(f"{value:8.2f}" for value in over_the_law(turns, scene, way)), flush=True)


if __name__ == "__main__":
    main()
