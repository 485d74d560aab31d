"""What forecasts lose where the sea is not as the inversion has it: another dispersion, a current, a wrong heading.

    python -m validation.prediction.physics [--seeds 2]

The inversion and the simulator share linear dispersion, and so flatter each other. `choppy_sea`, 24 turns, by the
horizon tracer: the same sea whose waves run by ω (1 + (k a)²/2) with a = √2 σ for every wave, which overstates it for
short ones; a current that nobody told, with the waves and across them; a heading that is told wrong. Correlation and
rms over σ at the boat, 10 s ahead and 20 s ahead, and the stated error there.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.physics.dispersion import angular_frequency
from validation.prediction.designers import errors, figures, scene_of

HEIGHT_M = 1.4
LEADS_S = (10.0, 20.0)
WITH = {"sea.current_m_s": 0.3, "sea.current_toward_deg": 90.0}
UNTOLD = {"retrieval.current_m_s": 0.0, "retrieval.current_toward_deg": 0.0}


def amplitude_dispersion(k: ArrayLike, depth: float) -> NDArray[np.float64]:
    """Angular frequency [rad/s] of waves on a sea of HEIGHT_M, by Stokes' second-order correction."""
    steepness = np.asarray(k) * np.sqrt(2.0) * HEIGHT_M / 4.0
    return angular_frequency(k, depth) * (1.0 + 0.5 * steepness**2)


@contextmanager
def steep_waves() -> Iterator[None]:
    """The simulator's waves, alone, run by their amplitude too."""
    with mock.patch("seamap_rt.sea.lattice.angular_frequency", amplitude_dispersion):
        yield


CASES: dict[str, tuple[dict[str, Any], Callable[[], Any]]] = {
    "as the inversion has it": ({}, nullcontext),
    "dispersion by amplitude, untold": ({}, steep_waves),
    "current 0.1 m/s with the waves, untold": (WITH | {"sea.current_m_s": 0.1} | UNTOLD, nullcontext),
    "current 0.3 m/s with the waves, untold": (WITH | UNTOLD, nullcontext),
    "current 0.3 m/s across, untold": (WITH | {"sea.current_toward_deg": 0.0} | UNTOLD, nullcontext),
    "current 0.3 m/s with the waves, told": (WITH, nullcontext),
    "heading 3° wrong": ({"platform.sensors.heading_bias_deg": 3.0}, nullcontext),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--first", type=int, default=651)
    given = parser.parse_args()
    for name, (changed, world) in CASES.items():
        with world():
            parts = [errors(scene_of(given.first + n, **changed))[10] for n in range(given.seeds)]
        for lead in LEADS_S:
            found = figures(parts, (lead - 1.0, lead + 1.0))
            told = ", ".join(f"{key} {number:.3f}" for key, number in found.items())
            print(f"{name}, {lead:g} s: {told}", flush=True)


if __name__ == "__main__":
    main()
