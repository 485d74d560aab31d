"""Which mast a trade recommends if a cell counts by what light sees of it, and by what the radar sees.

    python -m validation.claims.trade_visible [--seeds 2] [--only HS]

The three seas of `validation.claims.trade_heights`, antennas 0.2 m apart, in VV and in HH. A cell counts that is more
than half visible: to light, as in `seamap_rt.measured`; or to a radar, of water that returns −6 dB or more of its
two-way power when lit. Printed for each: the lowest mast within 5 % of the best, its fully measured radius, and to how
far half of the sea is visible from there. Light by the horizon.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from seamap_rt.conventions import POLARIZATIONS, from_db
from seamap_rt.interferometry import retrieve_one
from seamap_rt.measured import CoverageProfile
from seamap_rt.physics.shadowing import SEEN_DB
from seamap_rt.scattering.permittivity import permittivity_of
from seamap_rt.scene import with_keys
from seamap_rt.simulation import Simulator
from seamap_rt.studies.paired import choose
from seamap_rt.tracing.visibility import water_powers
from seamap_rt.truth import polar_truth

from ..options import options
from .trade_heights import CHOICES, scene

MASTS = CHOICES["radar.height_m"]
SEAS_M = (0.7, 1.4, 2.8)


class Point(NamedTuple):
    """One run: fully measured radius [m] by cells that light sees and that the radar sees; half-visible ranges [m]."""

    by_light: float
    by_radar: float
    half_light: float
    half_radar: float


def point(wave_height: float, mast: float, polarization: str, seed: int) -> Point:
    keys = {"radar.height_m": mast, "scattering.polarization": polarization, "seed": seed, "turns": 1}
    simulator = Simulator(with_keys(scene(wave_height), keys))
    made, turn = simulator.scene, simulator.turn(0)
    maps = retrieve_one(turn.echoes, made.resolved_retrieval)["polar"].to_dataset()
    mesh = simulator.mesh(0)
    light, returns, _ = simulator.light(0, None, mesh)
    water = permittivity_of(made.scattering, made.radar.frequency_hz)
    powers = water_powers(mesh, water, made.wavelength_m)
    names: list[str] = list(POLARIZATIONS)
    seen = powers[names.index(polarization)] >= from_db(SEEN_DB)
    to_radar = replace(light, lit=np.broadcast_to(seen, light.lit.shape))
    truth = turn.truth["polar"].to_dataset()
    by_radar = polar_truth(to_radar, returns.rcs, simulator.installation, made.retrieval, 0)
    sigma = float(simulator.sea.resolved.elevation_std)
    radii = [
        CoverageProfile.of(maps, truth.assign(visible_fraction=each["visible_fraction"]), sigma).fully_measured_radius
        for each in (truth, by_radar)
    ]
    assert simulator.visible is not None
    figures = simulator.visible.figures
    halves = (figures["half_visible_m"], figures[f"half_visible_{polarization.lower()}_m"])
    return Point(*radii, *(np.nan if each is None else each for each in halves))


def main() -> None:
    arguments = options(__doc__, seeds=2, only=0.0)
    for wave_height in [arguments.only] if arguments.only else SEAS_M:
        for polarization in POLARIZATIONS:
            seeds = range(1, arguments.seeds + 1)
            made = np.array([[point(wave_height, mast, polarization, seed) for seed in seeds] for mast in MASTS])
            for name, radius in zip(("light", polarization), (made[..., 0], made[..., 1]), strict=True):
                table = xr.DataArray(radius, {"radar.height_m": MASTS, "seed": list(seeds)}, ("radar.height_m", "seed"))
                choice = choose(table, "radar.height_m")
                assert choice is not None
                half = made[MASTS.index(choice.value)].mean(axis=0)
                print(
                    f"Hs {wave_height:g} m, {polarization}, cells by {name}: mast {choice.value:g} m (best "
                    f"{choice.best:g} m), radius {half[0 if name == 'light' else 1]:.0f} m; half visible to light "
                    f"{half[2]:.0f} m, in {polarization} {half[3]:.0f} m; radii "
                    + " ".join(f"{each:.0f}" for each in radius.mean(axis=1)),
                    flush=True,
                )


if __name__ == "__main__":
    main()
