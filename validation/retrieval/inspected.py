"""What the inspection says of all shipped scenes: as they are, no alarm; with receivers exchanged, the right one.

    python -m validation.retrieval.inspected [--turns 2] [--seed 11]

A column a verdict: of a scene as it is nothing may be wrong or doubtful; of exchanged receivers and of conjugated
voltages the sign of the phase must be wrong. The ratio is that of the mean level's strays with either sign: the
inspection calls a sign wrong from 4 on.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

import seamap_rt as sr
from seamap_rt.inspection import Level, inspect
from seamap_rt.io.scenefile import list_shipped

from ..options import options


def strays(echoes: xr.Dataset) -> float:
    level = Level.of(sr.retrieve(echoes)["polar"].to_dataset())
    return np.nan if level is None else level.rms


def main() -> None:
    given = options(__doc__, turns=2, seed=11)
    print(f"{'scene':20} {'strays (m)':>10} {'conjugated':>10} {'ratio':>6}  as it is; exchanged; conjugated")
    for name in list_shipped():
        scene = sr.load_scene(name, overrides={"turns": given.turns, "seed": given.seed, "tracing.tracer": "horizon"})
        good = sr.simulate(scene).echoes
        voltage = good["voltage"]
        others = {
            "exchanged": good.assign(voltage=voltage.copy(data=np.ascontiguousarray(voltage.values[:, ::-1]))),
            "conjugated": good.assign(voltage=np.conj(voltage)),
        }
        said = [f"{each.what} ({each.verdict})" for each in inspect(good) if each.verdict in ("wrong", "doubtful")]
        alarms = [
            "wrong"
            if any(each.what == "sign of the phase" and each.verdict == "wrong" for each in inspect(bad))
            else "MISSED"
            for bad in others.values()
        ]
        right, turned = strays(good), strays(others["conjugated"])
        words = "; ".join([", ".join(said) or "nothing", *alarms])
        print(f"{name:20} {right:10.3f} {turned:10.2f} {turned / right:6.0f}  {words}", flush=True)


if __name__ == "__main__":
    main()
