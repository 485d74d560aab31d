"""The outlook held against the simulation: it is used for instant answers, and must not be sold as one."""

from __future__ import annotations

import numpy as np

from ..claims.outlook import compared, draw
from ..report import Case, Check, Outcome
from ..report.checks import at_most, recorded

FIRST = 1  # of the random designs; the model was looked at with others
DESIGNS, SEEDS = {False: 6, True: 40}, {False: 1, True: 3}  # by full
RMS, MOST = 6.0, 20.0  # per cent


def beside_simulations(full: bool) -> Outcome:
    found = compared(FIRST, DESIGNS[full], SEEDS[full])
    checks: list[Check] = []
    for name, label in (("radius", "fully measured radius"), ("reach", "reach")):
        off = found.off(name)
        checks.append(at_most(f"{label}, rms over {off.size} designs", float(np.sqrt(np.mean(off**2))), RMS, "%"))
        checks.append(at_most("the same, most", float(abs(off).max()), MOST, "%"))
    seconds = float(np.median(found.seconds))
    checks.append(recorded("an outlook", f"{1e3 * seconds:.0f} ms in the median"))
    caption = "Each dot a design: the outlook against the mean of its simulations. Shaded: 5 %."
    return Outcome(tuple(checks), draw(found), caption)


CASES: list[Case] = [
    Case(
        name="outlook",
        group="speed",
        title="What a design is likely to see, at once",
        rationale="A designer wants an answer while a value is being changed; a model may give it if it is known how "
        "far it is off.",
        setup=f"{DESIGNS[False]} random designs of sea, mast, baseline, power, polarization and mode, a whole turn "
        f"each (with --full {DESIGNS[True]}, {SEEDS[True]} seeds), by the horizon tracer; radars that see less than "
        "30 m left out",
        expectation=f"{RMS:g} % rms, so that masts of a trade, which differ by more, keep their order; {MOST:g} % at "
        "most. A turn's own scatter is 1 m.",
        run=beside_simulations,
    ),
]
