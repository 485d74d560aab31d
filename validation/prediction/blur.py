"""How much of a wave's height the height of a dwell holds: regular waves along and across the look.

    python -m validation.prediction.blur [--seeds 4]

Regular waves of steepness 1/40, by the horizon tracer without noise: the slope of retrieved on true heights of dwells,
over ranges, in looks within 15° of the waves' way (along) or of their crests (across). `blur` is the standard deviation
[m] of the Gaussian mean that would hold as much, `expected` that of the pulse along the look (filled, see
prediction.observations), and of beam and dwell across it.
"""

from __future__ import annotations

import numpy as np

import seamap_rt as sr
from seamap_rt.prediction.observations import turn_observations
from seamap_rt.simulation import Simulator

from ..options import options

RANGES = ((20.0, 40.0), (40.0, 70.0), (70.0, 110.0))
NEAR_DEG = 15.0


def observed(length: float, seed: int) -> tuple[np.ndarray, ...]:
    """Distance, angle to the waves' way [deg], observed and true height, and expected blur, of one turn."""
    wave = {"spectrum": "sinusoid", "height_m": length / 40.0, "wavelength_m": length, "wave_from_deg": 270.0}
    changes = {"seed": seed, "sea.waves": [wave], "tracing.tracer": "horizon", "radar.noise": False}
    scene = sr.load_scene("choppy_sea", changes)
    simulator = Simulator(scene)
    turn = simulator.turn(0)
    seen = turn_observations(sr.retrieve(turn.echoes, scene.resolved_retrieval)["polar"].to_dataset().isel(turn=0))
    truth = np.empty(len(seen))
    for moment in np.unique(seen.time):
        now = seen.time == moment
        truth[now] = simulator.sea.elevation(seen.x[now], seen.y[now], seen.time[now])
    off = np.degrees(np.arctan2(np.abs(seen.y), np.abs(seen.x)))
    blur = np.sqrt(seen.blur[:, 0])  # of waves that run along x
    return np.hypot(seen.x, seen.y), off, seen.value, truth, blur, seen.std


def main() -> None:
    given = options(__doc__, seeds=4)
    print("wave      look     range   slope   blur  expected")
    for length in (10.0, 15.0, 25.0):
        parts = [observed(length, 900 + seed) for seed in range(given.seeds)]
        away, off, value, truth, blur, std = (np.concatenate(each) for each in zip(*parts, strict=True))
        for name, chosen in (("along", off < NEAR_DEG), ("across", off > 90.0 - NEAR_DEG)):
            for near, far in RANGES:
                inside = chosen & (away > near) & (away < far)
                weight = 1.0 / std[inside] ** 2
                mine, theirs = value[inside], truth[inside]
                mine, theirs = mine - np.average(mine, weights=weight), theirs - np.average(theirs, weights=weight)
                slope = float(np.sum(weight * mine * theirs) / np.sum(weight * theirs**2))
                found = np.sqrt(-2.0 * np.log(min(slope, 1.0))) * length / (2.0 * np.pi)
                expected = float(np.sqrt(np.mean(blur[inside] ** 2)))
                print(
                    f"{length:4.0f} m  {name:7}{near:4.0f}–{far:3.0f} m{slope:7.3f}{found:7.2f}{expected:7.2f}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
