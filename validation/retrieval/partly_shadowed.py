"""Whether the retrieval's visible share and its flag follow what echoes, or what light sees.

    python -m validation.retrieval.partly_shadowed [--scene choppy_sea]

One turn, cells with an echo at 50–200 m, with geometric shadows and with the field over edges. The retrieval has the
echo alone. Its `visible_share` is held against the cells' share of the water that light sees, and that returns −6 dB or
more of its two-way power when lit, in the scene's polarization. Light by the horizon.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

import seamap_rt as sr
from seamap_rt.conventions import POLARIZATIONS, from_db
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.interferometry import retrieve_one
from seamap_rt.metrics import HALF_VISIBLE, headline_gates
from seamap_rt.physics.shadowing import SEEN_DB
from seamap_rt.scattering.permittivity import permittivity_of
from seamap_rt.simulation import Simulator
from seamap_rt.tracing.visibility import water_powers
from seamap_rt.truth import polar_truth

from ..options import options


class Held(NamedTuple):
    """The retrieval's visible share beside one that is true: their means and correlation; flagged, of the cells that
    are less than half visible and of the others."""

    stated: float
    true: float
    correlation: float
    of_hidden: float
    of_visible: float


def held(scene: sr.Scene) -> dict[str, Held]:
    """Against light, and against the radar in the scene's polarization."""
    simulator, flags = Simulator(scene), QUALITY_FLAGS
    found = retrieve_one(simulator.turn(0).echoes, scene.resolved_retrieval)["polar"].to_dataset().isel(turn=0)
    mesh = simulator.mesh(0)
    light, returns, _ = simulator.light(0, None, mesh)
    water = permittivity_of(scene.scattering, scene.radar.frequency_hz)
    powers = dict(
        zip((str(each) for each in POLARIZATIONS), water_powers(mesh, water, scene.wavelength_m), strict=True)
    )
    own = scene.scattering.polarization
    made = {}
    for name, seen in {"light": light.visible_to_both, own: powers[own] >= from_db(SEEN_DB)}.items():
        lit = replace(light, lit=np.broadcast_to(seen, light.lit.shape))
        truth = polar_truth(lit, returns.rcs, simulator.installation, scene.retrieval, 0)
        true, stated, quality = truth["visible_fraction"].values[0], found["visible_share"].values, found["quality"]
        cells = headline_gates(found["range"].values) & ((quality.values & flags["no_echo"]) == 0)
        cells &= np.isfinite(true) & np.isfinite(stated)
        true, stated = true[cells], stated[cells]
        flagged, hidden = (quality.values[cells] & flags["partly_shadowed"]) > 0, true < HALF_VISIBLE
        ratio = float(np.corrcoef(true, stated)[0, 1])
        shares = flagged[hidden].mean(), flagged[~hidden].mean()
        made[name] = Held(float(stated.mean()), float(true.mean()), ratio, *map(float, shares))
    return made


def main() -> None:
    asked = options(__doc__, scene="choppy_sea")
    for diffraction in ("none", "knife_edge"):
        keys = {"tracing.tracer": "horizon", "tracing.diffraction": diffraction}
        for name, each in held(sr.load_scene(asked.scene, keys)).items():
            print(
                f"diffraction {diffraction}, beside {name}: stated share {each.stated:.3f}, true {each.true:.3f}, "
                f"correlation {each.correlation:.3f}; flagged {each.of_hidden:.0%} of cells less than half visible, "
                f"{each.of_visible:.0%} of the others",
                flush=True,
            )


if __name__ == "__main__":
    main()
