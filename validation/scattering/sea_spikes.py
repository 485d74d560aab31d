"""Sea spikes beside breakers that are a share of each facet: texture, tails, life, speed, and what they do to maps.

    python -m validation.scattering.sea_spikes [--only texture,tails,life,speed,ratio,heights,seas] [--seeds 11:16]
        [--set KEY=VALUE]…

  texture  shape ν of the texture of single looks and gates, by range, beside the law of Watts & Wicks (1990)
  tails    how often the intensity with speckle exceeds 5, 10, 20 and 30 times its mean, beside the K-distribution of
           the law's ν and of the simulated ν
  life     correlation of the texture of the same cells after 0.02 to 2 s
  speed    echo-weighted speed of the scatterers over the water, up-wave, of all and of the brightest 1 % of the facets
  ratio    HH beside VV of the same cells (power without speckle) at 2.5 to 3.5° grazing, up-wave ±30°: the brightest
           hundredth in HH, and the cells where HH exceeds VV (Hwang et al. 2008: 10 to 15 dB over HH's mean, 1 to 2 dB
           over VV's, 1.4 to 5.5°)
  heights  choppy_sea with noise: errors, error bars and lost cells, with and without spikes
  seas     the same over the seas of `validation.retrieval.seas`

Seeds a:b are a … b − 1. The one number that was chosen, a crest of 0.1 wavelengths, was chosen on seeds 1 to 6 of
choppy_sea in HH.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln, kve

import seamap_rt as sr
from seamap_rt.conventions import SPEED_OF_LIGHT, wrap_degrees
from seamap_rt.echoes import expected_look_gates
from seamap_rt.echoes.spike_field import SpikeField
from seamap_rt.scattering.sea_spikes import sea_spikes
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator

from ..retrieval.seas import CASES, against_truth
from .texture import BANDS_M, SECTORS, empirical_shape

MIDDLE_M = np.sqrt(np.multiply(BANDS_M[:-1], BANDS_M[1:]))
POLARIZATIONS = ("HH", "VV")


def scene_of(seed: int, polarization: str, spikes: bool, changes: dict[str, str]) -> Scene:
    keys = {"seed": seed, "scattering.polarization": polarization, "scattering.sea_spikes": spikes}
    return sr.load_scene("choppy_sea", {"tracing.tracer": "horizon", **changes, **keys})


def levels(scene: Scene) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Expected power (look, gate) with the run's spikes and patches and as their mean, azimuths from the waves' [deg],
    ranges."""
    simulator = Simulator(scene)
    mesh = simulator.mesh(0)
    light, returns, _ = simulator.light(0, mesh=mesh)
    calm = replace(simulator.surface, spikes=None, texture=None)(light, mesh.strain)
    cell = scene.retrieval.cell_azimuth_deg
    lit, mean = (expected_look_gates(light, each.rcs, simulator.installation, cell) for each in (returns, calm))
    angle = wrap_degrees(lit.sweep + simulator.installation.radar.sector_deg[0] - 270.0)
    return lit.power[0, 0], mean.power[0, 0], angle, lit.range


def cells_by_sector(scene: Scene) -> dict[str, tuple[NDArray, NDArray, NDArray]]:
    """Power over the mean over looks of what it would be without spikes: with and without, and ranges (gate,)."""
    lit, mean, angle, ranges = levels(scene)
    found = {}
    for name, middles in SECTORS.items():
        looks = np.any([np.abs(wrap_degrees(angle - middle)) <= 30.0 for middle in middles], axis=0)
        trend = mean[looks].mean(axis=0)
        found[name] = lit[looks] / trend, mean[looks] / trend, ranges
    return found


def law(scene: Scene, sector: str) -> NDArray:
    radar = scene.radar
    grazing = np.degrees(np.arcsin(radar.height_m / MIDDLE_M))
    cell = np.radians(radar.antenna.azimuth_beamwidth_deg) * MIDDLE_M * 0.5 * SPEED_OF_LIGHT * radar.pulse_width_s
    return empirical_shape(grazing, cell, scene.scattering.polarization, sector)


def shape_of(cells: Sequence[NDArray]) -> float:
    """ν of the texture, by its first two moments."""
    values = np.concatenate([each.ravel() for each in cells])
    return float(1.0 / (np.mean(values**2) / np.mean(values) ** 2 - 1.0)) if values.size else np.nan


def texture(seeds: range, changes: dict[str, str]) -> None:
    print(f"{'ν':27}" + "".join(f"{value:8.0f}" for value in MIDDLE_M) + "   m")
    for polarization in POLARIZATIONS:
        turns = [cells_by_sector(scene_of(seed, polarization, True, changes)) for seed in seeds]
        scene = scene_of(seeds[0], polarization, True, changes)
        over = np.zeros(MIDDLE_M.size)
        for name in SECTORS:
            rows = []
            for which in (0, 1):
                rows.append(
                    [
                        shape_of([t[name][which][:, (t[name][2] >= near) & (t[name][2] < far)] for t in turns])
                        for near, far in pairwise(BANDS_M)
                    ]
                )
            wanted = law(scene, name)
            over += 0.5 * np.log(np.array(rows[0]) / wanted)
            for label, row in (("spikes", rows[0]), ("without", rows[1]), ("Watts & Wicks 1990", wanted)):
                print(f"{polarization} {name:7}{label:>17}" + "".join(f"{value:8.2f}" for value in row))
        print(f"{polarization} over the law, both{'':8}" + "".join(f"{value:8.2f}" for value in np.exp(over)))


def k_exceedance(times: NDArray, shape: float) -> NDArray:
    """P(intensity > times the mean) of a K-distribution: 2/Γ(ν) (νx)^(ν/2) K_ν(2√(νx)) (Ward 1981)."""
    root = 2.0 * np.sqrt(shape * times)
    return 2.0 * np.exp(0.5 * shape * np.log(shape * times) - gammaln(shape) - root) * kve(shape, root)


def tails(seeds: range, changes: dict[str, str]) -> None:
    times, (near, far) = np.array([3.0, 5.0, 10.0, 20.0, 30.0]), (100.0, 200.0)
    print(f"share of cells, {near:g}-{far:g} m, over" + "".join(f"{value:10g}" for value in times) + "   × the mean")
    for polarization in POLARIZATIONS:
        turns = [cells_by_sector(scene_of(seed, polarization, True, changes)) for seed in seeds]
        for name in SECTORS:
            for which, label in ((0, "spikes"), (1, "without")):
                cells = [t[name][which][:, (t[name][2] >= near) & (t[name][2] < far)].ravel() for t in turns]
                power, shape = np.concatenate(cells), shape_of(cells)
                # Speckle over the texture: its exceedance is known.
                found = [np.mean(np.exp(-value * power.mean() / np.maximum(power, 1e-12))) for value in times]
                gamma = k_exceedance(times, shape)
                for row, what in ((found, label), (gamma, f"K, its ν = {shape:.2f}")):
                    print(f"{polarization} {name:7}{what:>20}" + "".join(f"{value:10.1e}" for value in row))
            wanted = float(
                np.exp(np.interp(np.sqrt(near * far), MIDDLE_M, np.log(law(turns_scene(changes, polarization), name))))
            )
            row = k_exceedance(times, wanted)
            print(
                f"{polarization} {name:7}{f'K, law ν = {wanted:.2f}':>20}" + "".join(f"{value:10.1e}" for value in row)
            )


def turns_scene(changes: dict[str, str], polarization: str) -> Scene:
    return scene_of(1, polarization, True, changes)


def life(seeds: range, changes: dict[str, str]) -> None:
    """Of the factor on patches that stay where they are, of 3 m by 1.8° at 100–200 m."""
    lags = np.array([0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0])
    scene = scene_of(seeds[0], "HH", True, changes)
    settings = scene.scattering
    spikes = sea_spikes(settings.wind_speed_m_s, settings.inverse_wave_age, scene.radar.frequency_hz)
    facets = Simulator(scene).mesh(0).facets
    assert spikes is not None
    gates = np.flatnonzero((facets.distance > 100.0) & (facets.distance < 200.0))
    deep = max(1, round(3.0 / np.diff(facets.distance[gates][::2]).mean())) * 2
    wide = max(1, round(1.8 / facets.grid.spacing_deg))
    gates = gates[: gates.size // deep * deep]

    def patches(field: SpikeField, later: float) -> NDArray:
        pose = facets.grid.column_pose
        moved = replace(facets, grid=replace(facets.grid, column_pose=replace(pose, time=pose.time + later)))
        factor = field.evaluate(moved).factor[: facets.grid.columns // wide * wide, gates]
        return factor.reshape(-1, wide, gates.size // deep, deep).mean(axis=(1, 3)).ravel()

    products = np.zeros((lags.size, 2))
    for seed in seeds:
        field = SpikeField(spikes, seed, settings.wind_from_deg)
        first = patches(field, 0.0) - 1.0
        for number, lag in enumerate(lags):
            products[number] += np.mean(first * (patches(field, lag) - 1.0)), np.mean(first**2)
    print("lag s      " + "".join(f"{value:8.2f}" for value in lags))
    print("correlation" + "".join(f"{a / b:8.2f}" for a, b in products))


def speed(seeds: range, changes: dict[str, str]) -> None:
    print(
        "m/s towards the radar over the water, up-wave ±30°, 50–200 m: mean by echo, of the brightest 1 % of the facets"
    )
    for polarization in POLARIZATIONS:
        for spikes in (False, True):
            sums = np.zeros(4)
            for seed in seeds:
                simulator = Simulator(scene_of(seed, polarization, spikes, changes))
                light, returns, _ = simulator.light(0)
                motion = returns.motion
                assert motion is not None
                assert motion.breaking is not None
                bragg = (2.0 * motion.approaching - 1.0) * motion.bragg_speed
                own = (1.0 - motion.breaking) * bragg[:, None] - motion.breaking * motion.breaker_speed[:, None]
                own = own if returns.running is None else own - returns.running
                looks = np.abs(wrap_degrees(light.grid.column_azimuth - 270.0)) < 30.0
                ring = (light.distance > 50.0) & (light.distance < 200.0)
                echo = (returns.rcs * light.lit.any(axis=0))[looks][:, ring]
                own = own[looks][:, ring]
                bright = echo > np.quantile(echo[echo > 0.0], 0.99)
                sums += np.sum(echo * own), np.sum(echo), np.sum((echo * own)[bright]), np.sum(echo[bright])
            label = "spikes" if spikes else "without"
            print(f"{polarization} {label:8} {sums[0] / sums[1]:6.2f} {sums[2] / sums[3]:6.2f}")


def ratio(seeds: range, changes: dict[str, str]) -> None:
    print("**HH beside VV of the same cells**\n")
    print("|  | HH over VV, dB | brightest hundredth, dB | cells with HH > VV | HH there over its mean, dB | VV, dB |")
    print("|---|---|---|---|---|---|")
    for spikes in (True, False):
        pairs = []
        for seed in seeds:
            scene = scene_of(seed, "HH", spikes, changes)
            (horizontal, _, angle, ranges), vertical = levels(scene), levels(scene_of(seed, "VV", spikes, changes))[0]
            grazing = np.degrees(np.arcsin(scene.radar.height_m / ranges))
            cells = (np.abs(angle) <= 30.0)[:, None] & ((grazing > 2.5) & (grazing < 3.5))
            fall = np.broadcast_to(vertical[np.abs(angle) <= 30.0].mean(axis=0), cells.shape)
            pairs.append(np.stack((horizontal[cells], vertical[cells])) / fall[cells])
        hh, vv = np.concatenate(pairs, axis=1)
        bright, over = hh >= np.quantile(hh, 0.99), hh > vv
        levels_db = (
            *(10.0 * np.log10(hh[those].mean() / vv[those].mean()) for those in (slice(None), bright)),
            *(10.0 * np.log10(each[over].mean() / each.mean()) if over.any() else np.nan for each in (hh, vv)),
        )
        share = f"{100.0 * over.mean():.1f} %"
        cells = [f"{each:+.1f}" for each in levels_db]
        print(f"| {'spikes' if spikes else 'without'} | {cells[0]} | {cells[1]} | {share} | {cells[2]} | {cells[3]} |")


def _table(name: str, scenes: Callable[[int, bool], Scene], seeds: range) -> None:
    for spikes in (False, True):
        rows = []
        for seed in seeds:
            scene = scenes(seed, spikes)
            turn = Simulator(scene).turn(0)
            rows.append(against_truth(sr.retrieve(turn.echoes), turn.truth)[0])
        mean = {key: float(np.mean([row[key] for row in rows])) for key in rows[0]}
        label = "spikes" if spikes else "without"
        print(
            f"{name:48} {label:8} {mean['ratio']:5.2f} {100 * mean['within']:6.1f} % {mean['rms']:6.3f} "
            f"{mean['correlation']:6.3f} {mean['slope']:5.2f} {100 * mean['lost']:5.1f} %",
            flush=True,
        )


_HEAD = f"{'':57} ratio   within    rms   corr slope   lost"


def heights(seeds: range, changes: dict[str, str]) -> None:
    print(_HEAD)
    for polarization in POLARIZATIONS:
        _table(f"choppy_sea {polarization}", lambda seed, on, p=polarization: scene_of(seed, p, on, changes), seeds)


def seas(seeds: range, changes: dict[str, str]) -> None:
    print(_HEAD)
    for case in CASES:
        _table(
            f"{case.name}, {case.polarization} {case.mast:g} m",
            lambda seed, on, c=case: c.scene(seed, **{"scattering.sea_spikes": on}, **changes),
            seeds,
        )


SECTIONS = {each.__name__: each for each in (texture, tails, life, speed, ratio, heights, seas)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default=",".join(SECTIONS), help="sections, with commas between them")
    parser.add_argument("--seeds", default="11:16")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    arguments = parser.parse_args()
    first, last = (int(each) for each in arguments.seeds.split(":"))
    changes = dict(each.split("=", 1) for each in arguments.set)
    for name in arguments.only.split(","):
        SECTIONS[name](range(first, last), changes)


if __name__ == "__main__":
    main()
