"""What each option of the scattering costs in time per turn, and what it does to the map.

    python -m validation.scattering.scattering_speed [--scene choppy_sea] [--rounds 5] [--tracer horizon]

Warm turns (sea, mesh, light, echoes, truth; no retrieval) of the scene as it is, with one option changed at a time, in
turn, round after round, so that other load affects all alike; medians. Beside them the first calibration, and the rms
height error, 50–200 m, of a noise-free turn.
"""

from __future__ import annotations

import argparse

import numpy as np

import seamap_rt as sr
from seamap_rt.interferometry import retrieve
from seamap_rt.metrics import error_figures
from seamap_rt.simulation import Simulator

OPTIONS = {
    "all (default)": {},
    "nrcs = nrl": {"scattering.nrcs": "nrl"},
    "nrcs = constant": {"scattering.nrcs": "constant"},
    "breaking = false": {"scattering.breaking": False},
    "hydrodynamic_modulation = false": {"scattering.hydrodynamic_modulation": False},
    "doppler = orbital": {"scattering.doppler": "orbital"},
    "these three": {
        "scattering.breaking": False,
        "scattering.hydrodynamic_modulation": False,
        "scattering.doppler": "orbital",
    },
    "diffraction = knife_edge": {"tracing.diffraction": "knife_edge"},
    "polarization = HH": {"scattering.polarization": "HH"},
}
STEPS = ("sea", "mesh", "trace", "echoes", "truth")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="choppy_sea")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--tracer", default="horizon")
    arguments = parser.parse_args()
    times: dict[str, list[list[float]]] = {name: [] for name in OPTIONS}
    first: dict[str, float] = {}
    error: dict[str, float] = {}
    for number in range(arguments.rounds + 1):
        for name, keys in OPTIONS.items():
            scene = sr.load_scene(arguments.scene, {"tracing.tracer": arguments.tracer, "radar.noise": False, **keys})
            simulator = Simulator(scene)
            turn = simulator.turn(0)
            if number == 0:  # compiles, fills caches, and judges the map
                overall = error_figures(retrieve(turn.echoes, scene.retrieval), turn.truth)["overall"]
                error[name] = overall["height_rmse_m"]
                continue
            first[name] = min(first.get(name, np.inf), turn.timing["calibrate"])
            warm = simulator.turn(1).timing
            times[name].append([warm["total"], *(warm.get(step, 0.0) for step in STEPS)])
    print(f"{'':34}{'total':>8}" + "".join(f"{step:>8}" for step in STEPS) + f"{'extra':>8}{'once':>8}{'error m':>9}")
    whole = np.array(times["all (default)"])
    for name, rows in times.items():
        extra = float(np.median(np.array(rows)[:, 0] - whole[:, 0]))
        cells = "".join(f"{value:8.2f}" for value in np.median(rows, axis=0))
        print(f"{name:34}{cells}{extra:+8.2f}{first[name]:8.2f}{error[name]:9.3f}")


if __name__ == "__main__":
    main()
